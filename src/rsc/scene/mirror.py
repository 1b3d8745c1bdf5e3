"""The mirror image of a scene, z -> -z: the same machine seen from the other end of its shaft, turning the other way.

Every complex quantity becomes its conjugate, every speed and frequency its negative; what is cross-coupled changes its sign.
"""

from typing import Any

_POLAR = ("eccentricity", "angular_eccentricity", "ring_eccentricity")
_PER_COORDINATE = ("chain", "matrices")  # models with a list of eccentricities
_PAIRS = ("load", "unbalance", "rotor", "rotor_velocity", "stator", "stator_velocity", "knock")
_MATRICES_OF_PAIRS = ("anisotropic_stiffness", "anisotropic_damping")
_SIGNED = ("skew_stiffness", "skew_damping")
_RANGES = ("band", "speeds")
_FREQUENCIES = ("coefficients_at", "whirl", "speed")


def mirrored_content(content: dict[str, Any]) -> dict[str, Any]:
    """The content of the mirrored scene, of nested mappings as `Scene.to_dict` gives them: resolved, plain numbers."""
    return {name: _table(table) if isinstance(table, dict) else table for name, table in content.items()}


def _table(table: dict[str, Any]) -> dict[str, Any]:
    mirrored = {key: _mirrored(key, value) for key, value in table.items()}
    if table.get("model") in _PER_COORDINATE and isinstance(table.get("eccentricity"), list):
        mirrored["eccentricity"] = [_polar(item) for item in table["eccentricity"]]
    return mirrored


def _mirrored(key: str, value: Any) -> Any:
    if value is None or isinstance(value, str):
        return value
    if key in _POLAR:
        return _polar(value)
    if key in _PAIRS or key in _MATRICES_OF_PAIRS:
        return _conjugate(value)
    if key in _SIGNED or key in _FREQUENCIES:
        return _negative(value)
    if key in _RANGES:
        return [0.0 - end for end in value[::-1]]
    if key == "schedule":
        return [[time, 0.0 - speed] for time, speed in value]
    if key == "supports":
        return [[place, *([xx, 0.0 - xy, 0.0 - yx, yy] for xx, xy, yx, yy in parts)] for place, *parts in value]
    return value


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float))


def _polar(value: Any) -> Any:
    return [value[0], 0.0 - value[1]] if isinstance(value, list) else value


def _conjugate(value: Any) -> Any:
    """Pairs [y, z] in nested lists, conjugated."""
    if len(value) == 2 and all(map(_is_number, value)):
        return [value[0], 0.0 - value[1]]
    return [_conjugate(item) for item in value]


def _negative(value: Any) -> Any:
    return 0.0 - value if _is_number(value) else [_negative(item) for item in value]
