"""Comparison of a measured run with a scene: two probes and a Keyphasor show which value of the model is wrong.

The "measurement" is a simulated run, seen by two probes at 45 and 135 degrees with noise and runout, so that the truth is known.
The scene it is compared with has half of the friction; the comparison finds that out.
"""

import rsc

PUMP = rsc.Scene.from_toml("""
title = "Pump rotor in its casing ring, measured"
rotor = {model = "laval", mass = "12 kg", frequency = "2600 rpm", damping_ratio = 0.02, eccentricity = "0.02 mm"}
stator = {model = "laval", mass = "3 kg", frequency = "160 Hz", damping_ratio = 0.1}
contact = {gap = "0.25 mm", friction = 0.2, stiffness = "50 kN/mm", damping_ratio = 0.05, diameter = "80 mm"}
drive = {speed = ["40 Hz", "60 Hz"], duration = "10 s"}
start = {whirl = "backward"}
output = {rate = 5000.0}
""")

table = rsc.write_measured(rsc.simulate(PUMP), "bench.toml", noise=2e-6, runout=10e-6)  # as `rsc run --as-measured`
measured = rsc.read_measured(table)
print(f"measured: {measured.speed[0]:.1f} to {measured.speed[-1]:.1f} Hz; warnings: {measured.warnings or 'none'}")

doubtful = rsc.compare(PUMP.with_values({"contact.friction": 0.1}), measured)
for root in doubtful.nearest:
    if root.brings:
        print(f"with a friction of 0.1: measured {root.measured:.1f} Hz, next root {root.frequency:.0f} Hz")
        print(f"{root.brings[0].name} = {root.brings[0].needed:.2f} would make it the model's")

report = rsc.compare(PUMP, measured)
print(f"with a friction of 0.2: {report.agreement}")
report.save_html("measured.html")
report.plot("campbell").figure.savefig("measured.png")
