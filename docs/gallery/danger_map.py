"""Danger map: at which friction and speed does an impact leave this pump in a backward whirl?

Friction is the number that nobody knows. A sweep asks the same of a grid of cases: what is predicted, and where a run ends that
starts with an impact of 3 N s. Yellow is no safe colour: a whirl exists there, and a harder impact may start it.
"""

import rsc

PUMP = rsc.Scene.from_toml("""
title = "Pump rotor, after an impact of 3 N s"
rotor = {model = "laval", mass = "12 kg", frequency = "2600 rpm", damping_ratio = 0.02, eccentricity = "0.02 mm"}
stator = {model = "laval", mass = "3 kg", frequency = "160 Hz", damping_ratio = 0.1}
contact = {gap = "0.25 mm", friction = 0.2, stiffness = "50 kN/mm", damping_ratio = 0.05, diameter = "80 mm"}
drive = {speed = "50 Hz", duration = "2 s"}
start = {running = true, impulse = ["3 N s", 0]}
""")

varied = {"contact.friction": "0.05:0.4:15", "drive.speed": "20:60:17"}
data = rsc.sweep(PUMP, varied, ["predict", "run"], path="danger_map")
finished, impossible = ((data.status == word).sum() for word in ("finished", "impossible"))
print(f"{data.status.size} cases: {finished:d} finished, {impossible:d} impossible")
for code, words in (flag.split(" ", 1) for flag in data.danger.attrs["flags"].split("; ")):
    if count := int((data.danger == int(code)).sum()):
        print(f"{words}: {count} cases")
rsc.plot_sweep(data, "danger").figure.savefig("danger_map.png")
