"""`supports_by_speed`: bearings and seals of a rotor with speed-dependent coefficients, linear between knots."""

from typing import Any

from rsc.scene.keys.keys import RawTable
from rsc.scene.keys.readers import MAX_COORDINATES, Integer, Later, Listed, Number, Sequence, as_list, per_coordinate

SPEED = Number("frequency", low=-1e6, high=1e6)
_FOUR = Sequence(Number("stiffness")), Sequence(Number("damping"))
_KNOTS = tuple(Sequence(Listed(form)) for form in ((SPEED, _FOUR[0]), (SPEED, *_FOUR)))
SUPPORTS_BY_SPEED = Later(
    "a list of [coordinate, knots], each knot [speed in Hz, [k_yy, k_yz, k_zy, k_zz] in N/m, [c_yy, c_yz, c_zy, c_zz] in N s/m]",
    tuple(Sequence(Listed((Integer(0, MAX_COORDINATES), knots))) for knots in _KNOTS),
)
MEANING = "Bearings and seals with speed-dependent coefficients: linear between knots, constant beyond."
_LEAST = "a list of at least two knots [speed, stiffness, damping]"


def read_by_speed(table: RawTable, raw: object, body: Any) -> tuple[Any, ...]:
    """((coordinate, ((speed, four stiffnesses, four dampings), ...)), ...) of `supports_by_speed`, speeds in Hz.

    Raises
    ------
    SceneError
        Wrong shape, fewer than two knots, knots not in order of speed, or a coordinate that is not a displacement.
    """
    items = as_list(raw)
    if items is None:
        table.refuse("supports_by_speed", raw, SUPPORTS_BY_SPEED.wanted)
    return tuple(_read_support(table, f"supports_by_speed[{i}]", item, body) for i, item in enumerate(items))


def _read_support(table: RawTable, key: str, item: Any, body: Any) -> tuple[Any, ...]:
    parts = as_list(item)
    if parts is None or len(parts) != 2:
        table.refuse(key, item, "[coordinate, knots]")
    place = read_place(table, f"{key}[0]", parts[0], body)
    knots = as_list(parts[1])
    if knots is None or len(knots) < 2:
        table.refuse(f"{key}[1]", parts[1], _LEAST, "use `supports` for constant coefficients")
    made = tuple(_read_knot(table, f"{key}[1][{i}]", knot) for i, knot in enumerate(knots))
    for i in range(1, len(made)):
        if not made[i][0] > made[i - 1][0]:
            table.refuse(f"{key}[1][{i}][0]", made[i][0], f"more than {made[i - 1][0]:g} Hz", "knots must be in order")
    return place, made


def read_place(table: RawTable, key: str, raw: Any, body: Any) -> int:
    """Number of a coordinate; SceneError unless it is a displacement."""
    place = Integer(0, body.n_coordinates - 1).read(table, key, raw)
    if place in body.tilts:
        table.refuse(key, place, "a displacement", f"coordinate {place} is a tilt")
    return place


def _read_knot(table: RawTable, key: str, raw: Any) -> tuple[Any, ...]:
    parts = as_list(raw)
    if parts is None or len(parts) not in (2, 3):
        table.refuse(key, raw, "[speed, [k_yy, k_yz, k_zy, k_zz], [c_yy, c_yz, c_zy, c_zz]]")
    speed = SPEED.read(table, f"{key}[0]", parts[0])
    readers = [Number("stiffness")] * 4, [Number("damping")] * 4
    coefficients = [per_coordinate(table, f"{key}[{k}]", part, readers[k - 1]) for k, part in enumerate(parts) if k]
    return speed, *coefficients, *(((0.0,) * 4,) if len(parts) == 2 else ())
