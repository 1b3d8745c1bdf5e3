"""Vertical pump with a seal ring: the leakage through the ring prevents backward whirl.

The leakage is a spring, a damper and, since the water turns with half of the shaft's speed, a cross-coupled spring, which drives
forward and holds against backward whirl. A pump that starts dry has none of the three.
The shaft is vertical: no weight acts sideways.
"""

from math import pi

import rsc

DRY = rsc.Scene.from_toml("""
title = "Vertical pump, dry seal ring"

[rotor]                      # impeller on its line shaft
model = "laval"
mass = "60 kg"
frequency = "18 Hz"
damping_ratio = 0.02
eccentricity = "20 um"

[stator]                     # seal ring and what carries it
model = "laval"
mass = "8 kg"
frequency = "90 Hz"
damping_ratio = 0.1

[contact]
gap = "0.25 mm"
friction = 0.2
stiffness = "40 kN/mm"
damping_ratio = 0.05
diameter = "150 mm"

[drive]
speed = "1480 rpm"
duration = "8 s"

[start]
running = true
impulse = ["10 N s", 0]
""")

speed = DRY.drive.speed[0]  # Hz
k, c = 1.2e6, 6000.0  # N/m and N s/m, of a ring of this size at some 4 bar
cross = c * pi * speed  # c Omega / 2
WET = DRY.with_values({"rotor.supports": [[0, [k, cross, -cross, k], [c, 0.0, 0.0, c]]]})

reports = {"dry": rsc.check(DRY), "wet": rsc.check(WET)}
for name, report in reports.items():
    stable = [f"{w.frequency:.1f} Hz, {w.normal_force:.0f} N" for w in rsc.predict(report.result.scene, speed) if w.stable]
    print(f"{name}: predicted to be stable: {', '.join(stable) or 'no whirl'}; the impact ends in {report.features.kind[-1]}")
reports["dry"].save_html("pump_seal.html")
reports["dry"].plot("campbell").figure.savefig("pump_seal.png")
