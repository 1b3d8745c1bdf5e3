"""Units as files state them: "(ms)", "um", "Time [s]"; what rsc knows of them, and what is left to tell."""

import re
from functools import lru_cache

from rsc.units import QuantityError, quantity

_DIMENSIONS = ("length", "voltage", "time", "frequency", "velocity", "acceleration", "force", "angle")
_SPELLED = {"volt": "V", "volts": "V"}  # as oscilloscopes write it
_LONGEST = 30  # letters of a unit
_BRACKETS = re.compile(r"(?P<name>.*?)[\s_]*[(\[{](?P<unit>[^()\[\]{}]*)[)\]}]\s*")
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
    for spelled in dict.fromkeys((text, _SPELLED.get(text.lower(), text), text.lower())):
        for dimension in _DIMENSIONS:
            try:
                return dimension, quantity(f"1 {spelled}", dimension)
            except QuantityError:
                continue
    return None


def bare(unit: str) -> str:
    """A unit without the brackets and blanks about it."""
    return unit.strip().strip("()[]{}").strip()


def parted(name: str) -> tuple[str, str]:
    """(name, unit) of a head such as "Time (ms)", "X [um]", "X / um"; the whole head and "" where no unit stands in it.

    In brackets stands a unit; behind a stroke or comma only what rsc knows as one.
    """
    match = _BRACKETS.fullmatch(name)
    if match and match["name"].strip() and not match["unit"].strip().isdigit():
        return match["name"].strip(), match["unit"].strip()
    match = _PARTED.fullmatch(name)
    if match and meaning(match["unit"]):
        return match["name"].strip(), match["unit"]
    return name, ""
