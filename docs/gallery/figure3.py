"""Figure 3 (right) of the paper: one rotor, two backward whirls, and the jump from one to the other.

The prediction is a closed form, the simulation integrates the equations of motion; they share no code. The scene is a
reconstruction: the paper's parameters are not published.
"""

from pathlib import Path

import rsc

REFERENCE = Path(__file__).parents[2] / "data" / "reference"

scene = rsc.load_scene(REFERENCE / "gyroscopic_figure3_right.toml")
report = rsc.check(scene)
for branch in report.branches:
    stable = branch.speed[branch.stable]
    if stable.size:
        print(f"whirl {branch.label}: stable from {stable.min():.0f} to {stable.max():.0f} Hz")
for change in report.transitions:
    print(f"whirl {change.before} to {change.after} at {change.taken_over:.1f} Hz of rotor speed: {change.verdict}")
print(report.agreement)
report.save_html("figure3.html")
report.plot("campbell").figure.savefig("figure3.png")
