"""Units in which numbers are read easily."""

import math

import numpy as np


def unit_for(largest, base):
    """Factor from SI and name of the unit in which `largest` reads between 1 and 1000."""
    prefixes = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M"}
    power = 0
    if largest > 0 and math.isfinite(largest):
        power = int(np.clip(3 * math.floor(math.log10(largest * (1 + 1e-9)) / 3), -9, 0 if base.startswith("m") else 6))
    return 10.0**-power, prefixes[power] + base


def largest_finite(values):
    """Largest finite value, 0 where there is none."""
    values = np.asarray(values, float)
    values = values[np.isfinite(values)]
    return float(values.max()) if values.size else 0.0
