"""Where run-ups of gyroscopic_transition leave whirl A: predicted (rsc.analysis.lines.delayed_jump) and simulated.

    python bench/delay_table.py            prints the table: first seen / takes over, Hz
    python bench/delay_table.py --write    keeps it in bench/results
"""

import sys
from pathlib import Path

import rsc
from rsc.analysis.survey.survey import survey

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tools"))

from pages import RESULTS, write_page  # noqa: E402

SCENE = ROOT / "data" / "reference" / "gyroscopic_transition.toml"
DURATIONS = (120.0, 270.0, 480.0)
TOLERANCES = (1e-6, 1e-8)


def table():
    """The table as Markdown."""
    lines = ["| run-up | disturbance from | predicted | " + " | ".join(f"simulated, rtol {rtol:g}" for rtol in TOLERANCES) + " |"]
    lines.append("|---|---|---|" + "---|" * len(TOLERANCES))
    for duration in DURATIONS:
        scene = rsc.load_scene(SCENE).with_values({"drive.duration": duration})
        delay = survey(scene).delays["A"]
        cells = [f"{delay.first_seen:.1f} / {delay.jump:.1f}"]
        for rtol in TOLERANCES:
            change = rsc.check(scene.with_values({"solver.rtol": rtol})).transitions[0]
            cells.append(f"{change.first_seen:.1f} / {change.taken_over:.1f}")
        lines.append(f"| {duration:g} s | {delay.source} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main():
    """Print the table, or keep it."""
    text = table()
    if "--write" in sys.argv[1:]:
        title = "Delayed jumps, predicted and simulated"
        write_page(RESULTS / "delay_table.md", title, "python bench/delay_table.py --write", text)
    else:
        print(text)


if __name__ == "__main__":
    main()
