"""Units in which numbers are shown: the one table of them, and the system that is chosen.

Everything inside rsc, JSON and every file is in SI and Hz. A number becomes another one only here, when it is shown.
"""

import contextlib
import math
from collections.abc import Iterator
from contextvars import ContextVar
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

INCH, POUND = 0.0254, 0.45359237  # m, kg
FORCE = POUND * 9.80665  # N of a pound
SI, VIBRATION = "si", "vibration"  # the latter stands for a length peak to peak
# system -> unit of SI -> units that take its place: (least size in SI from which, factor from SI, name), rising; one that is not
# here has a prefix with which it reads between 1 and 1000
SYSTEMS: dict[str, dict[str, tuple[tuple[float, float, str], ...]]] = {
    SI: {VIBRATION: ((0.0, 1e6, "um"),)},
    "metric": {
        VIBRATION: ((0.0, 1e6, "um"),),
        "Hz": ((0.0, 60.0, "rpm"),),
        "m": ((0.0, 1e6, "um"), (1e-3, 1e3, "mm")),
    },
    "us": {
        VIBRATION: ((0.0, 1e3 / INCH, "mil"),),
        "Hz": ((0.0, 60.0, "rpm"),),
        "m": ((0.0, 1e3 / INCH, "mil"), (INCH, 1.0 / INCH, "in")),
        "mm": ((0.0, 1e-3 / INCH, "in"),),
        "m/s": ((0.0, 1.0 / INCH, "in/s"),),
        "kg": ((0.0, 1.0 / POUND, "lb"),),
        "N": ((0.0, 1.0 / FORCE, "lbf"),),
        "N s": ((0.0, 1.0 / FORCE, "lbf s"),),
        "N m": ((0.0, 1.0 / (FORCE * INCH), "lbf in"),),
        "N/m": ((0.0, INCH / FORCE, "lbf/in"),),
        "N s/m": ((0.0, INCH / FORCE, "lbf s/in"),),
        "kg m^2": ((0.0, 1.0 / (POUND * INCH**2), "lb in^2"),),
        "J": ((0.0, 1.0 / (FORCE * 12.0 * INCH), "ft lbf"),),
        "W": ((0.0, 1.0 / (550.0 * FORCE * 12.0 * INCH), "hp"),),
    },
}
_chosen: ContextVar[str | None] = ContextVar("units", default=None)


def system() -> str:
    """The system that is chosen, "si" where none is."""
    return _chosen.get() or SI


@contextlib.contextmanager
def shown_in(name: str | None) -> Iterator[None]:
    """Show numbers in a system as long as it lasts; None: as a scene asks for, see `prefer`."""
    before = _chosen.set(name)
    try:
        yield
    finally:
        _chosen.reset(before)


def prefer(scene: Any) -> None:
    """Show numbers as a scene asks for, where nobody has chosen a system."""
    chosen = getattr(scene, "report", None)  # a measured run has no such table
    if _chosen.get() is None and chosen is not None:
        _chosen.set(chosen.units)


@contextlib.contextmanager
def shown_as_in(scene: Any) -> Iterator[None]:
    """The same as long as it lasts."""
    with shown_in(_chosen.get()):
        prefer(scene)
        yield


def column(base: str) -> tuple[float, str]:
    """Factor from SI and name of the unit in which a column of a table shows a unit of SI, or `VIBRATION`."""
    known = SYSTEMS[system()].get(base)
    return known[0][1:] if known else (1.0, base)


def unit_for(largest: float, base: str) -> tuple[float, str]:
    """Factor from SI and name of the unit in which `largest` reads well."""
    known = SYSTEMS[system()].get(base)
    if known:
        size = abs(largest) if math.isfinite(largest) else 0.0
        return next((factor, name) for least, factor, name in reversed(known) if size >= least)
    prefixes = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M"}
    power = 0
    if largest > 0 and math.isfinite(largest):
        power = int(np.clip(3 * math.floor(math.log10(largest * (1 + 1e-9)) / 3), -9, 0 if base.startswith("m") else 6))
    return 10.0**-power, prefixes[power] + base


def largest_finite(values: ArrayLike) -> float:
    """Largest finite value, 0 where there is none."""
    numbers = np.asarray(values, float)
    numbers = numbers[np.isfinite(numbers)]
    return float(numbers.max()) if numbers.size else 0.0
