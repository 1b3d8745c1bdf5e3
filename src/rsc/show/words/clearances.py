"""Monitored clearances in words: closest approach of a run and its predictions, and touches."""

import math

from rsc.show.words.reasons import percent
from rsc.show.words.vibration import left_text
from rsc.show.words.wording import vibration


def touching(names):
    """What stands in the place of "stable" for a motion that touches clearances."""
    return f"touches {' and '.join(names)}"


def watched(scene, stretches):
    """The clearances of a run in the order of its scene, plain: name, gap m, largest deflection m and over the gap, its extents
    peak to peak in m, time in s at which the gap was first passed (None: never); [] of a measured run, which has no stretches."""
    rows = []
    vibrations = stretches.whole().clearances_peak_to_peak if stretches is not None and len(stretches) else ()
    for i, place in enumerate(scene.clearances if stretches is not None else ()):
        largest = float(stretches.deflections[:, i].max(initial=0.0))
        passed = float(stretches.passed[:, i].min(initial=math.inf))
        values = {"name": place.name, "gap": place.gap, "largest": largest, "over_gap": largest / place.gap}
        values["peak_to_peak"] = vibrations[i] if vibrations else 0.0
        rows.append(values | {"passed": passed if math.isfinite(passed) else None})
    return rows


def watched_text(scene, stretches):
    """The clearances of a run in a sentence, "" without any; the one that is passed first leads, then the nearest to its gap."""

    def urgency(row):
        return math.inf if row["passed"] is None else row["passed"], -row["over_gap"]

    texts, rows = [], watched(scene, stretches)
    for i, row in enumerate(sorted(rows, key=urgency)):
        if row["passed"] is None:
            text = f"{left_text(row['largest'], row['gap'])} left"
        else:
            text = f"touched {'first ' if i == 0 and len(rows) > 1 else ''}at {row['passed']:.4g} s"
            text += f", deflection up to {percent(row['over_gap'])} of the clearance"
        texts.append(f"{row['name']} {text}, {vibration(row['peak_to_peak'])}")
    return "; ".join(texts)
