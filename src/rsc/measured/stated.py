"""Units as stated in files: "(ms)", "um", "Time [s]"."""

import re
from functools import lru_cache

from rsc.units import QuantityError, quantity

_DIMENSIONS = ("length", "voltage", "time", "frequency", "velocity", "acceleration", "force", "angle")
_LONGEST = 30  # letters of a unit
_BRACKETS = re.compile(r"(?P<name>.*?)[\s_]*[(\[{](?P<unit>[^()\[\]{}]*)[)\]}]\s*")
_TAILS = re.compile(r"(?P<name>.*[^\W_])_(?P<unit>ms|us|µs|ns|sec|um|µm|mm|nm|mils?|mV|uV|rpm|RPM|k?Hz)")  # no "in", "s", "m"
_PARTED = re.compile(r"(?P<name>.*\S)\s*(?:/|,|\bin\b)\s*(?P<unit>\S+)\s*")


@lru_cache(maxsize=512)
def meaning(unit: str) -> tuple[str, float] | None:
    """(kind of quantity, size of the unit in SI or Hz) of a unit as a file writes it; None of what is no unit that rsc knows.

    "g" is the acceleration of free fall, which no measurement of a shaft takes for a gram.
    """
    text = bare(unit)
    if not text or len(text) > _LONGEST or text.isdigit():
        return None
    if text in ("g", "G", "gn"):
        return "acceleration", 9.80665
    for spelled in dict.fromkeys((text, text.lower())):
        for dimension in _DIMENSIONS:
            try:
                return dimension, quantity(f"1 {spelled}", dimension)
            except QuantityError:
                continue
    return None


def bare(unit: str) -> str:
    """A unit without the brackets and blanks about it, and without the moment that times are counted from ("s since ...")."""
    return unit.partition(" since ")[0].strip().strip("()[]{}").strip()


def seconds_of(unit: str) -> float | None:
    """s of a unit of time, 1 where nothing is said or where the unit is unknown; None of a unit of something else."""
    known = meaning(unit)
    return 1.0 if known is None else known[1] if known[0] == "time" else None


def parted(name: str) -> tuple[str, str]:
    """(name, unit) of a head such as "Time (ms)", "X [um]", "X / um", "time_ms"; the whole head and "" where it has no unit.

    In brackets stands a unit; behind a stroke or comma only what rsc knows as one, behind a low line only what is nothing else.
    """
    match = _BRACKETS.fullmatch(name)
    if match and match["name"].strip() and not match["unit"].strip().isdigit():
        return match["name"].strip(), match["unit"].strip()
    match = _TAILS.fullmatch(name) or _PARTED.fullmatch(name)
    if match and meaning(match["unit"]):
        return match["name"].strip(), match["unit"]
    return name, ""
