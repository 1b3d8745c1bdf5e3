"""Where run-ups of gyroscopic_transition leave whirl B: predicted (rsc.analysis.delayed_jump) and simulated.

    python bench/delay_table.py
"""

from pathlib import Path

import rsc
from rsc.analysis.survey import survey

SCENE = Path(__file__).parent.parent / "data" / "reference" / "gyroscopic_transition.toml"
DURATIONS = (120.0, 270.0, 480.0)
TOLERANCES = (1e-6, 1e-8)


def main():
    """Print the table: first seen / takes over, Hz."""
    print("| run-up | disturbance from | predicted | " + " | ".join(f"simulated, rtol {rtol:g}" for rtol in TOLERANCES) + " |")
    print("|---|---|---|" + "---|" * len(TOLERANCES))
    for duration in DURATIONS:
        scene = rsc.load_scene(SCENE).with_values({"drive.duration": duration})
        delay = survey(scene).delays["B"]
        cells = [f"{delay.first_seen:.1f} / {delay.jump:.1f}"]
        for rtol in TOLERANCES:
            change = rsc.check(scene.with_values({"solver.rtol": rtol})).transitions[0]
            cells.append(f"{change.first_seen:.1f} / {change.taken_over:.1f}")
        print(f"| {duration:g} s | {delay.source} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
