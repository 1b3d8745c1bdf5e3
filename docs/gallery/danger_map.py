"""Danger map: at which friction and speed does an impact leave this pump in a backward whirl?

Friction is the number that nobody knows. A sweep asks the same of a grid of cases: what is predicted, and where a run ends that
starts with an impact of 3 N s. Yellow is no safe colour: a whirl exists there, and a harder impact may start it.
"""

from pathlib import Path

from rsc.cli import main

Path("pump.toml").write_text("""\
title = "Pump rotor, after an impact of 3 N s"
rotor = {model = "laval", mass = "12 kg", frequency = "2600 rpm", damping_ratio = 0.02, eccentricity = "0.02 mm"}
stator = {model = "laval", mass = "3 kg", frequency = "160 Hz", damping_ratio = 0.1}
contact = {gap = "0.25 mm", friction = 0.2, stiffness = "50 kN/mm", damping_ratio = 0.05, diameter = "80 mm"}
drive = {speed = "50 Hz", duration = "2 s"}
start = {running = true, impulse = ["3 N s", 0]}
""")

varied = ["--vary", "contact.friction=0.05:0.4:15", "--vary", "drive.speed=20:60:17"]
main(["sweep", "pump.toml", *varied, "--compute", "predict,run", "-o", "danger_map"])
main(["report", "danger_map/sweep.nc", "-o", "danger_map"])
