"""Figures of the verification ladder: asserted where they are measured, and written down for the table of the ladder when asked.

`tools/ladder_table.py` sets RSC_FIGURES to a file and runs the ladder; every `met` then leaves one line of JSON there.
"""

import json
import os


def met(rung, what, measured, limit):
    """Assert measured <= limit (a NaN fails) and note the figure for the table of the ladder."""
    path = os.environ.get("RSC_FIGURES")
    if path:
        with open(path, "a", encoding="utf-8") as file:
            file.write(json.dumps([rung, what, float(measured), float(limit)]) + "\n")
    assert measured <= limit, f"{rung} {what}: {measured:.3g} > {limit:.3g}"


def slope(x, y):
    """Exponent p of y ~ x^p by least squares."""
    import numpy as np

    return float(np.polyfit(np.log(x), np.log(y), 1)[0])
