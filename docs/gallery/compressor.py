"""Compressor imported from ROSS: whirls at its labyrinth, and which of the estimated parameters matter.

The model is ROSS's own example of a compressor, with the coefficients of bearings and seals at 9,000 rpm, as its `save_mat`
wrote it; ROSS is not needed. The casing ring, its friction and the contact's stiffness are guesses, as they are in every machine.
"""

from pathlib import Path

import rsc
from rsc.machine.imports.ross import read_ross
from rsc.study.import_model import import_model

FILE = Path(__file__).parents[2] / "data" / "reference" / "machines" / "ross_compressor_9000rpm.mat"
SPEED = 150.0  # Hz

import_model(read_ross(FILE, SPEED), "compressor.toml", contact=27, overwrite=True)  # it is edited below
text = Path("compressor.toml").read_text()
Path("compressor.toml").write_text(text.replace("tolerance = 1e-4", 'tolerance = 1e-3\nband = ["-500 Hz", "250 Hz"]'))
imported = rsc.load_scene("compressor.toml")
scene = imported.with_values({
    "title": "Compressor of ROSS, labyrinth ring at node 27",
    "stator.mass": 40.0, "stator.frequency": 60.0,
    "contact.gap": 3e-4, "contact.friction": 0.3, "contact.stiffness": 5e7, "contact.diameter": 0.25,
    "drive.speed": SPEED, "drive.duration": 2.0, "start.whirl": "backward",
})  # fmt: skip

reduction = imported.reductions[0]
before, after = len(reduction.full.contact), len(reduction.body.contact)
print(f"reduced from {before} to {after} coordinates, error at the contact {reduction.error:.0e}")
modes = rsc.modes(scene, SPEED).rotor[:2]
print("first modes:", ", ".join(f"{mode.frequency:.1f} Hz (decrement {mode.decrement:.2f})" for mode in modes))
for friction in (0.15, 0.3):
    whirls = [whirl for whirl in rsc.predict(scene.with_values({"contact.friction": friction}), SPEED) if whirl.stable]
    told = [f"{whirl.frequency:.1f} Hz, {whirl.normal_force / 1e3:.1f} kN" for whirl in whirls]
    print(f"friction {friction}: {', '.join(told) or 'no stable whirl'}")

guessed = [f"stator.{key}" for key in ("mass", "frequency", "damping_ratio")]
guessed += [f"contact.{key}" for key in ("friction", "stiffness", "gap")]
listed = rsc.sensitivity(scene, SPEED, guessed)
i = int(listed.stable.argmax())
(force,) = (whirl.normal_force for whirl in rsc.predict(scene, SPEED) if whirl.stable)
for j in sorted(range(len(guessed)), key=lambda j: -abs(listed.normal_force[j, i])):
    print(f"1 % of {guessed[j]} changes its force by {listed.normal_force[j, i] / force:+.2f} %")

report = rsc.check(scene)
report.save_html("compressor.html")
report.plot("campbell").figure.savefig("compressor.png")
