"""The mirror image of a scene, y -> -y: the same machine seen from the other end of its shaft, turning the other way.

The weight acts along -z in both. A vector y + i z becomes -y + i z, as the readers of pairs and polar amounts imply; speeds and
frequencies change sign, and so does what is cross-coupled, as stated where these keys are declared (`mirror`).
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from rsc.scene.keys.readers import Later, PairReader, PolarReader, Sequence


def mirrored_table(section: type, table: Mapping[str, Any]) -> dict[str, Any]:
    """A table of the mirrored scene, as plain content like that of `Scene.to_dict`; section: the class that declares its keys."""
    declared = {item.name: item.metadata for item in fields(section) if "reader" in item.metadata}
    return {key: _mirrored(declared[key], value) if key in declared else value for key, value in table.items()}


def _mirrored(metadata: Mapping[str, Any], value: Any) -> Any:
    if metadata["mirror"] is not None:
        return metadata["mirror"](value)
    return _as_read(metadata["reader"], value)


def _as_read(reader: Any, value: Any) -> Any:
    """A plain value; minus its conjugate if its reader is for vectors.

    A negative amount keeps every digit, as 180 degrees less the angle would not.
    """
    if isinstance(reader, Later):  # resolved scenes have the last, most complete form
        return _as_read(reader.forms[-1], value)
    if isinstance(reader, Sequence):
        return [_as_read(reader.item, item) for item in value]
    if isinstance(reader, PairReader):
        return [0.0 - value[0], value[1]]
    if isinstance(reader, PolarReader):
        return [0.0 - value[0], 0.0 - value[1]] if isinstance(value, list) else 0.0 - value
    return value


def negative(value: Any) -> Any:
    """Negate the numbers in nested lists; words are unchanged."""
    if isinstance(value, list):
        return [negative(item) for item in value]
    return value if isinstance(value, str) else 0.0 - value


def turned(span: list[float]) -> list[float]:
    """Mirror [lowest, highest] of speeds or frequencies."""
    return negative(span[::-1])


def reversed_order(items: list[Any]) -> list[Any]:
    """Mirror a list with one entry per rotor speed, whose sign changes."""
    return items[::-1]


def conjugates(matrix: list[Any]) -> list[Any]:
    """Mirror a matrix of pairs [real, imaginary], which acts on the conjugate of a vector."""
    return [[[real, 0.0 - imag] for real, imag in row] for row in matrix]


def each_conjugates(items: list[Any]) -> list[Any]:
    """Mirror a list of such matrices."""
    return [conjugates(matrix) for matrix in items]


def reversed_conjugates(items: list[Any]) -> list[Any]:
    """Mirror a list of matrices of pairs [real, imaginary], one per rotor speed, whose sign changes."""
    return each_conjugates(items[::-1])


def schedule(corners: list[list[float]]) -> list[list[float]]:
    """Mirror the corners [time, speed] of a schedule."""
    return [[time, 0.0 - speed] for time, speed in corners]


def by_speed(items: list[Any]) -> list[Any]:
    """Mirror [coordinate, [[speed, [yy, yz, zy, zz], ...], ...]] of every speed-dependent support."""
    return [[place, [[0.0 - speed, *supports([[0, *parts]])[0][1:]] for speed, *parts in knots[::-1]]] for place, knots in items]


def supports(items: list[Any]) -> list[Any]:
    """Mirror [coordinate, [yy, yz, zy, zz], ...] of every support."""
    return [[place, *([yy, 0.0 - yz, 0.0 - zy, zz] for yy, yz, zy, zz in parts)] for place, *parts in items]
