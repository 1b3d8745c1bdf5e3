"""Pump with two seals: the whirl predicted with one seal touches the other; the whirl that lasts closes both contacts.

A model with the impeller's seal alone predicts a stable backward whirl with 16 kN. On its way there the shaft meets the bush of
the balance drum, so that this whirl does not exist. The whirl at both seals has a third of the force; a blow starts it.
"""

import rsc
from rsc.measure.words import FREQUENCY

PUMP = rsc.Scene.from_toml("""
title = "Pump with two seals"

[rotor]                      # coupling, impeller, balance drum
model = "chain"
masses = ["4 kg", "30 kg", "8 kg"]
stiffnesses = ["6 kN/mm", "5 kN/mm", "5 kN/mm", "6 kN/mm"]
damping_ratio = 0.02
eccentricity = ["10 um", "25 um", "15 um"]

[stator]                     # the casing at both seals
model = "chain"
masses = ["15 kg", "10 kg"]
stiffnesses = ["15 kN/mm", "5 kN/mm", "10 kN/mm"]
damping_ratio = 0.1

[[contact]]
name = "seal"                # of the impeller
rotor_coordinate = 1
stator_coordinate = 0
gap = "0.3 mm"
friction = 0.2
stiffness = "10 kN/mm"
damping_ratio = 0.05
diameter = "180 mm"

[[contact]]
name = "bush"                # of the balance drum
rotor_coordinate = 2
stator_coordinate = 1
gap = "0.15 mm"
friction = 0.2
stiffness = "10 kN/mm"
damping_ratio = 0.05
diameter = "90 mm"

[drive]
speed = "50 Hz"
duration = "1 s"

[start]
rotor_velocity = [[0, 0], ["1.2 m/s", 0], [0, 0]]    # a blow on the impeller
""")

for whirl in rsc.predict(PUMP):
    if whirl.growth_rate < 0.0:
        forces = ", ".join(f"{whirl.contacts[name].normal_force / 1e3:.1f} kN at {name}" for name in whirl.pressed)
        print(f"predicted: {whirl.frequency:.1f} Hz, {forces}{', touches ' if whirl.touches else ''}{', '.join(whirl.touches)}")
report = rsc.check(PUMP)
for name, course in report.contacts.items():
    print(f"{name}: {course.kind[-1]}, {course.over_gap[-1]:.2f} gaps, {course.force[-1] / 1e3:.1f} kN in the end")
last = [row for row in report.rows if row.quantity == FREQUENCY][-1]
print(f"whirl in the end: {last.simulated:.2f} Hz, predicted {last.predicted:.2f} Hz: {last.verdict}")
report.save_html("two_seals.html")
report.plot("force").figure.savefig("two_seals.png")
