"""The mirror image of a scene, z -> -z: the same machine seen from the other end of its shaft, turning the other way.

Every complex quantity becomes its conjugate, which its reader tells; every speed and frequency its negative, and what is
cross-coupled changes its sign, which their keys say where they are declared (`mirror`).
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from rsc.scene.keys.keys import Later, PairReader, PolarReader, Sequence


def mirrored_table(section: type, table: Mapping[str, Any]) -> dict[str, Any]:
    """A table of the mirrored scene, of plain content as `Scene.to_dict` gives it; section: the class that declares its keys."""
    declared = {item.name: item.metadata for item in fields(section) if "reader" in item.metadata}
    return {key: _mirrored(declared[key], value) if key in declared else value for key, value in table.items()}


def _mirrored(metadata: Mapping[str, Any], value: Any) -> Any:
    if metadata["mirror"] is not None:
        return metadata["mirror"](value)
    return _as_read(metadata["reader"], value)


def _as_read(reader: Any, value: Any) -> Any:
    """What a reader reads, conjugated where it is complex."""
    if isinstance(reader, Later):  # in a resolved scene the last and fullest form
        return _as_read(reader.forms[-1], value)
    if isinstance(reader, Sequence):
        return [_as_read(reader.item, item) for item in value]
    if isinstance(reader, PairReader) or (isinstance(reader, PolarReader) and isinstance(value, list)):
        return [value[0], 0.0 - value[1]]
    return value


def negative(value: Any) -> Any:
    """Numbers in nested lists with the other sign; a word stays."""
    if isinstance(value, list):
        return [negative(item) for item in value]
    return value if isinstance(value, str) else 0.0 - value


def turned(span: list[float]) -> list[float]:
    """[lowest, highest] of speeds or frequencies."""
    return negative(span[::-1])


def reversed_order(items: list[Any]) -> list[Any]:
    """One entry for each rotor speed, which is the negative."""
    return items[::-1]


def reversed_conjugates(items: list[Any]) -> list[Any]:
    """A matrix of pairs [real, imaginary] for each rotor speed, which is the negative."""
    return [[[[real, 0.0 - imag] for real, imag in row] for row in matrix] for matrix in items[::-1]]


def schedule(corners: list[list[float]]) -> list[list[float]]:
    """[time, speed] of every corner."""
    return [[time, 0.0 - speed] for time, speed in corners]


def by_speed(items: list[Any]) -> list[Any]:
    """[coordinate, [[speed, [xx, xy, yx, yy], ...], ...]] of every support that follows the speed."""
    return [[place, [[0.0 - speed, *supports([[0, *parts]])[0][1:]] for speed, *parts in knots[::-1]]] for place, knots in items]


def supports(items: list[Any]) -> list[Any]:
    """[coordinate, [xx, xy, yx, yy], ...] of every support."""
    return [[place, *([xx, 0.0 - xy, 0.0 - yx, yy] for xx, xy, yx, yy in parts)] for place, *parts in items]
