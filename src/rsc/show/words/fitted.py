"""A fit as text and as JSON."""

import math

from rsc.errors import one_line
from rsc.show.words.plain import plain
from rsc.show.words.table import table
from rsc.show.words.wording import frequencies_text

NOT_TOLD = "not told"


def fit_text(fit):
    """Fitted values with their intervals, and undetermined values; `fit` is an `rsc.Fit`."""
    lines = [*([one_line(fit.scene.title)] if fit.scene.title else []), *(f"warning: {line}" for line in fit.warnings)]
    if not fit.converged:
        lines.append("not converged: the values are the best so far, their intervals are meaningless")
    kinds = [(int((fit.use == use).sum()), use) for use in ("fitted", "held back", "left out")]
    windows = ", ".join(f"{number} {use}" for number, use in kinds if number)
    lines += [
        f"{len(fit.use)} windows ({windows}) from "
        f"{frequencies_text(fit.speed.min(), fit.speed.max(), '.4g')}; {fit.runs} runs; "
        f"misfit {fit.misfit:.3g} (about 1: as large as the noise explains)",
        "",
        table(("value", "scene", "fitted", "68 % interval", ""), [_row(value) for value in fit.values]),
        "",
        "combinations determined by the run, the best first, as products of powers of the values:",
        *(_direction(direction) for direction in fit.directions),
    ]
    return "\n".join(lines)


def _row(value):
    digits = max(3, *(_digits(value.value, value.value - end) for end in (value.low, value.high)))
    fitted, low, high = (f"{number:.{digits}g}" for number in (value.value, value.low, value.high))
    unit = "" if value.unit == "1" else f" {value.unit}"
    return value.name, f"{value.guess:.4g}", fitted, f"{low} to {high}{unit}", "" if value.told else NOT_TOLD


def _digits(value, side):
    """Digits of a value: down to the second digit of its interval."""
    return 2 + math.ceil(math.log10(abs(value / side))) if value and side else 0


def _direction(direction):
    told = f"to {100.0 * direction.deviation:.2g} %" if direction.told else NOT_TOLD
    return f"  {direction.words}: {told}"


def fit_plain(fit):
    """A Fit as JSON can hold it: the scene as its tables, the names of the windows as text."""
    return {
        "converged": fit.converged,
        "values": plain(fit.values),
        "directions": [{"words": direction.words, **plain(direction)} for direction in fit.directions],
        "misfit": fit.misfit,
        "runs": fit.runs,
        "warnings": list(fit.warnings),
        "windows": {name: plain(getattr(fit, name)) for name in ("speed", "time", "use", "residual", "missed")},
        "scene": fit.scene.to_dict(),
    }
