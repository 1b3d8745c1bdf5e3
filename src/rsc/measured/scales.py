"""Scale of a column, from the table and the file; refusals if they contradict each other."""

import math

from rsc.errors import DataError, SceneError, one_line
from rsc.measured.channel import Channel
from rsc.measured.keys import Channels, Probe
from rsc.measured.stated import bare, meaning
from rsc.units import DIMENSIONS

_ALIKE = 1e-6  # relative, of two units that are the same
_OTHERS = ("velocity", "acceleration", "force", "time", "frequency", "angle")  # of which no displacement is made


def metres(probe: Probe, number: int, channel: Channel, full_scale: float, source: str) -> tuple[float, list[str]]:
    """m for a one in the column of the probe of a number (from 0), and what to tell.

    Parameters
    ----------
    full_scale : V for a one in the numbers of a file that has no units, as WAV; 1 of others
    """
    name, unit = one_line(probe.column)[:40], channel.unit
    known = meaning(unit)
    kind, size = known or ("", 1.0)
    if channel.quantity in _OTHERS or kind in _OTHERS:
        what = f"{channel.quantity or kind}" + (f" in {one_line(unit)}" if unit else "")
        raise DataError(source, f"{name} is {_with_article(what)}, says the file: give a channel of displacement")
    if probe.sensitivity is not None:
        if kind == "length":
            wanted = f"left out: the file states {one_line(unit)} for {name}"
            raise _refusal(source, f"measured.probe[{number}].sensitivity", probe.sensitivity, wanted)
        return full_scale * size / probe.sensitivity, _unused(name, unit, known)
    if probe.unit is not None:
        if kind == "length" and abs(probe.unit / size - 1.0) > _ALIKE:
            wanted = f"left out, or the {size:g} m that the file states for {name} ({one_line(unit)})"
            raise _refusal(source, f"measured.probe[{number}].unit", probe.unit, wanted)
        if kind == "voltage":
            taken = f"one of these is taken as {probe.unit:g} m, as the table says"
            return full_scale * probe.unit, [f"the file states {one_line(bare(unit))} for {name}: {taken}"]
        return full_scale * probe.unit, _unused(name, unit, known)
    if kind == "length":
        return size, []
    stated = f"states {one_line(unit)} for {name}" if unit else f"states no unit for {name}"
    hint = f"the file {stated}"
    raise _refusal(source, f"measured.probe[{number}].sensitivity", None, "given, or instead of it unit", hint)


def seconds(table: Channels, channel: Channel, source: str) -> tuple[float, list[str]]:
    """s per unit of a time column, and remarks."""
    size, told = _size(channel, "time", table.time_unit, "measured.time_unit", source)
    return 1.0 if size is None else size, told


def turns_a_second(table: Channels, channel: Channel, source: str) -> tuple[float, list[str]]:
    """Hz per unit of the speed column, and remarks."""
    size, told = _size(channel, "frequency", table.speed_unit, "measured.speed_unit", source)
    return 1.0 if size is None else size, told


def rate_of(table: Channels, channel: Channel, source: str) -> float | None:
    """Samples a second of a channel, None where neither the file nor the table says them."""
    if channel.interval is None:
        return table.rate
    stated = 1.0 / channel.interval if math.isfinite(1.0 / channel.interval) else 0.0
    if table.rate is not None and not abs(table.rate - stated) <= 1e-4 * table.rate:
        wanted = f"left out, or the {stated:.9g} Hz that the file states"
        raise _refusal(source, "measured.rate", table.rate, wanted)
    return stated


def _size(channel: Channel, wanted: str, by_table: float | None, key: str, source: str) -> tuple[float | None, list[str]]:
    """SI value of one unit, from the table or else from the file, and remarks."""
    known, name = meaning(channel.unit), one_line(channel.names[0] if channel.names else "the column")[:40]
    if known is None:
        return by_table, _unused(name, channel.unit, known)
    kind, size = known
    if wanted == "frequency" and kind == "angular velocity":
        kind = wanted
    if kind == "voltage" and wanted == "frequency":  # of a converter from frequency to voltage, whose factor the table has
        return by_table, [] if by_table is not None else _unused(name, channel.unit, None)
    if kind != wanted:
        raise DataError(source, f"{name} is in {one_line(channel.unit)}, says the file: no {wanted}")
    if by_table is not None and abs(by_table / size - 1.0) > _ALIKE:
        stated = f"left out, or the {size:g} {DIMENSIONS[wanted][0]} that the file states for {name} ({one_line(channel.unit)})"
        raise _refusal(source, key, by_table, stated)
    return size, []


def _unused(name: str, unit: str, known: tuple[str, float] | None) -> list[str]:
    if not unit or known:
        return []
    return [f"the unit of {name} in the file, {one_line(bare(unit))[:30]}, is unknown to rsc: not used"]


def _refusal(source: str, key: str, value: float | None, wanted: str, hint: str = "") -> SceneError:
    return SceneError(source, key, value, wanted, hint)


def _with_article(words: str) -> str:
    return ("an " if words[0] in "aeiou" else "a ") + words
