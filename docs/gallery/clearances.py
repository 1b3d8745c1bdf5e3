"""Monitored clearances: the modelled contact is not always the place that touches first.

The contact of this pump is that of its wear ring. The balance drum and the bush of the shaft seal get no force, only their gaps:
the run and every prediction tell what is touched there. A whirl that touches is not called stable, whatever its growth rate.
"""

import rsc
from rsc.show.words.answer import answer

PUMP = rsc.Scene.from_toml("""
title = "Multistage pump, drum and seal bush watched"

[rotor]                      # shaft seal, impellers, balance drum on one shaft
model = "chain"
masses = ["4 kg", "30 kg", "8 kg"]
stiffnesses = ["6 kN/mm", "5 kN/mm", "5 kN/mm", "6 kN/mm"]
damping_ratio = 0.02
eccentricity = ["10 um", "25 um", "15 um"]

[stator]                     # the wear ring in its casing
model = "laval"
mass = "15 kg"
frequency = "160 Hz"
damping_ratio = 0.1

[contact]
rotor_coordinate = 1
gap = "0.3 mm"
friction = 0.2
stiffness = "10 kN/mm"
damping_ratio = 0.05
diameter = "180 mm"

[[clearance]]
name = "seal_bush"
rotor_coordinate = 0
gap = "0.3 mm"

[[clearance]]
name = "drum"
rotor_coordinate = 2
gap = "0.15 mm"

[drive]
speed = ["1500 rpm", "6000 rpm"]
duration = "15 s"
""")

print("free modes at 100 Hz:", ", ".join(f"{mode.frequency:.1f} Hz" for mode in rsc.modes(PUMP, 100.0).rotor))
for whirl in rsc.predict(PUMP, 100.0):
    if whirl.rotor_amplitude > PUMP.contact.gap:
        told = f"{whirl.frequency:.1f} Hz, {whirl.normal_force:.0f} N, growth {whirl.growth_rate:+.1f} 1/s"
        print(f"predicted: {told}, stable: {whirl.stable}, touches {', '.join(whirl.touches)}")

report = rsc.check(PUMP)
told = dict(answer(report))
print(f"run-up: {told['whirl']}")
begin = report.result.time[report.result.normal_force > 0.0][0]
print(f"run-up: {told['clearances']}; the wear ring rubs from {begin:.2f} s on")
report.save_html("clearances.html")
report.plot("campbell").figure.savefig("clearances.png")
