"""Two-disc rig with a snubber ring: run-up and run-down differ (hysteresis).

A snubber limits the passage of the resonance. Once in contact the ring's stiffness holds the rotor there: running up, it rubs to
a higher speed than the one at which it touches first when it runs down.
"""

import rsc

RIG = rsc.Scene.from_toml("""
title = "Two-disc rig with a snubber, run-up"

[rotor]
model = "chain"
masses = ["2.6 kg", "2.6 kg"]
stiffnesses = ["60 kN/m", "90 kN/m", "60 kN/m"]
damping_ratio = 0.01
eccentricity = ["40 um", "40 um"]

[stator]                     # the snubber ring on its springs
model = "laval"
mass = "0.4 kg"
frequency = "60 Hz"
damping_ratio = 0.1

[contact]
rotor_coordinate = 0
gap = "0.4 mm"
friction = 0.05
stiffness = "2 kN/mm"
damping_ratio = 0.1
diameter = "30 mm"

[drive]
speed = ["15 Hz", "40 Hz"]
duration = "50 s"
""")

print("free modes:", ", ".join(f"{mode.frequency:.1f} Hz" for mode in rsc.modes(RIG, 30.0).rotor))
up = rsc.check(RIG)
down = rsc.check(RIG.with_values({"title": "run-down", "drive.speed": [40.0, 15.0]}))
for name, report in (("up", up), ("down", down)):
    touching = [speed for speed, kind in zip(report.fall.speed, report.features.kind, strict=True) if kind != "no contact"]
    force = report.stretches.whole().force_max
    print(f"{name}: in contact from {min(touching):.1f} to {max(touching):.1f} Hz, up to {force:.0f} N")
up.save_html("two_disc_snubber.html", others=[down])
up.plot("amplitude", others=[down]).figure.savefig("two_disc_snubber.png")
