"""How whirls change with the values of a scene, as text."""

import numpy as np

from rsc.show.words.table import table
from rsc.show.words.wording import frequency_text

MOST_VALUES = 16  # rows a whirl, those that change it most
ROUNDING = 1e-9  # of the largest change of a quantity, below which one is rounding: it would be another on every processor


def sensitivity_text(sensitivity):
    """A table for each stable backward whirl, or for all where none is; a `rsc.study.prediction.sensitivity.Sensitivity`."""
    shown = np.flatnonzero(sensitivity.stable) if sensitivity.stable.any() else range(len(sensitivity.whirl))
    return "\n\n".join(_of_whirl(sensitivity, int(k)) for k in shown) or "no backward whirl to differentiate"


def _of_whirl(sensitivity, k):
    """The values that change a whirl most, and by how much per percent of each."""
    names = "frequency", "rotor_amplitude", "normal_force", "growth_rate"
    *changes, growth = (_rounded(getattr(sensitivity, name)[:, k] / 100.0) for name in names)
    weight = np.max([np.abs(np.nan_to_num(change)) / _largest(change) for change in changes], axis=0)
    rows = []
    for i in np.argsort(-weight, kind="stable")[:MOST_VALUES]:
        if not weight[i]:
            break
        numbers = [change[i] for change in changes] + [growth[i]]
        note = "" if sensitivity.good[i, k] else "not resolved: the whirl ends close by"
        cells = [f"{number:+.4g}" for number in numbers]
        rows.append((sensitivity.name[i], f"{sensitivity.value[i]:.5g}", sensitivity.unit[i], *cells, note))
    header = ("by 1 % of", "now", "in", "whirl Hz", "|r| m", "F_N N", "growth 1/s", "")
    pressed = f" of {' and '.join(sensitivity.pressed[k])}" if sensitivity.pressed[k] else ""
    whirl = f"whirl {frequency_text(sensitivity.whirl[k], '.4f')}{pressed} at {frequency_text(sensitivity.speed, 'g')}"
    return f"{whirl} changes\n{table(header, rows)}"


def _largest(change):
    return np.max(np.abs(np.nan_to_num(change)), initial=1e-300)


def _rounded(change):
    """Changes of a quantity, 0 where they are rounding."""
    return np.where(np.abs(change) < ROUNDING * _largest(change), 0.0, change)
