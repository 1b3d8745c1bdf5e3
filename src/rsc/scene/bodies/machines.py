"""A body of model "machine" becomes one of model "reduced" while its scene is read."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import tau as TWO_PI
from typing import Any

import numpy as np

from rsc.errors import DataError, ReductionError, one_line, shown
from rsc.scene.bodies.reduced import AMOUNT, BEARINGS, MachineRotor, MachineStator, Reduction
from rsc.scene.keys.keys import Number, PairReader, Table, as_list, per_coordinate, read_table
from rsc.system.knots import ANISOTROPIC, FOLLOWING
from rsc.units import DIMENSIONS

# of the highest speed, backward and forward, and the least in Hz: impacts of the contact move the rotor faster than a whirl
BAND, LEAST_BAND = (-12.0, 6.0), (-500.0, 250.0)

REAL = tuple(name for name in FOLLOWING if name not in ANISOTROPIC)


def is_machine(table: Table) -> bool:
    """Whether a table is of model "machine"."""
    return table.values.get("model") == "machine"


def read_reduction(table: Table, elsewhere: Any, fastest: float) -> tuple[float, tuple[float, float]]:
    """Tolerance and band (Hz) of [reduction], for a rotor of a fastest speed in Hz."""
    values = read_table(Reduction, table, elsewhere)
    if values["band"] is None:
        band = min(BAND[0] * fastest, LEAST_BAND[0]), max(BAND[1] * fastest, LEAST_BAND[1])
        return values["tolerance"], band
    parts = as_list(values["band"])
    if parts is None or len(parts) != 2:
        table.refuse("band", values["band"], "[lowest, highest] frequency in Hz")
    low, high = (Number("frequency").read(table, f"band[{i}]", part) for i, part in enumerate(parts))
    if not low < high:
        table.refuse("band", values["band"], "[lowest, highest]")
    return values["tolerance"], (low, high)


def places_of(body: Table, contacts: Sequence[Table]) -> list[Any]:
    """The places of a machine that touch, each once, as they stand in the file: the `rotor_node` of every contact, or the one
    `contact` of the body. The displacements there become its first coordinates.

    Raises
    ------
    SceneError
        Both, neither, or nodes for some contacts only.
    """
    key, coordinate = f"{body.name}_node", f"{body.name}_coordinate"
    own, named = body.values.get("contact"), [table for table in contacts if key in table.values]
    if not named:
        if own is None:
            body.refuse("contact", None, "given: a node", f"of several contacts each [[contact]] names its {key} instead")
        return [own]
    for table in contacts:
        if coordinate in table.values:
            table.refuse(coordinate, table.values[coordinate], f"left out: {key} names a node")
        if key not in table.values:
            table.refuse(key, None, "given: a node", f"{named[0].name} has one")
    if own is not None:
        body.refuse("contact", own, "left out", f"{named[0].name} has {key}")
    return list({one_line(table.values[key]): table.values[key] for table in named}.values())


def with_coordinates(contacts: Sequence[Table], name: str, places: Sequence[Any]) -> list[Table]:
    """The tables of contacts with coordinates of the reduced body "rotor" or "stator" in the place of nodes."""
    key, known = f"{name}_node", [one_line(place) for place in places]
    made = []
    for table in contacts:
        values = {other: value for other, value in table.values.items() if other != key}
        if key in table.values:
            values[f"{name}_coordinate"] = known.index(one_line(table.values[key]))
        made.append(Table(table.file, table.name, values, table.folder))
    return made


def reduced(
    table: Table,
    elsewhere: Any,
    reduction: tuple[float, tuple[float, float], tuple[float, float]],
    touching: Sequence[Any],
    nodes: Sequence[Any] = (),
) -> tuple[Table, Any]:
    """The table of the reduced body, and the `rsc.machine.reduction.reduction.Reduced`.

    touching: places of its contacts; nodes: of clearances, observed as well.

    Raises
    ------
    SceneError
        A file, place or unbalance that cannot be, or a body that cannot be reduced.
    """
    from rsc.machine.imports.store import load_model
    from rsc.machine.model.contact import body_of
    from rsc.machine.reduction.directions import Unequal, reduce_unequal
    from rsc.machine.reduction.reduction import reduce

    rotor = table.name == "rotor"
    values = read_table(MachineRotor if rotor else MachineStator, table, elsewhere)
    tolerance, band, speeds = reduction
    fastest = max(map(abs, speeds))
    if table.folder is None:
        table.refuse("file", values["file"], "no file", "the scene of a result holds the reduced body")
    try:
        model, digest = load_model(table.folder / values["file"])
    except DataError as error:
        table.refuse("file", values["file"], "a file written by `rsc import`", error.problem)
    if values["sha256"] is not None and values["sha256"] != digest:
        table.refuse("file", values["file"], f"the file whose SHA-256 is {values['sha256'][:16]}...", f"it has {digest[:16]}...")
    if model.anisotropic_mass is not None:
        table.refuse("file", values["file"], "a model whose masses move alike in x and y")
    if rotor:
        model = _with_bearings(table, model, values["bearings"])
    at_nodes = _at_nodes(table, values) if rotor else {}
    observers = _observers(table, values["observers"], nodes)
    try:
        body = body_of(model, [_place(table, place) for place in touching], observers=observers, speed=fastest, **at_nodes)
    except DataError as error:
        table.refuse("contact", only_or_all(touching), "a place of the model", error.problem)
    except ValueError as error:
        table.refuse("unbalance", values.get("unbalance"), str(error))
    (low, high), (slowest, fastest) = band, speeds
    try:
        ranges = (TWO_PI * low, TWO_PI * high), (TWO_PI * slowest, TWO_PI * fastest)
        if model.isotropic:
            result = reduce(body, *ranges, tolerance)
        else:
            parts = model.anisotropic_stiffness, model.anisotropic_damping
            knots = None if model.knots is None else model.knots.without(REAL)
            stiffness, damping = (0.0 * body.stiffness if part is None else part for part in parts)
            unequal = Unequal(stiffness, damping, knots)
            result = reduce_unequal(body, unequal, *ranges, tolerance)
    except ReductionError as error:
        table.refuse("file", values["file"], "a body that can be reduced", str(error))
    origin = f"{model.source} ({values['file']}, sha256 {digest[:16]}), contact at {shown(only_or_all(touching))}"
    content = _content(result, rotor) | _anisotropic(model, result) | {
        "observers": [one_line(place) for place in observers],
        "origin": one_line(origin)[:400],
        "tolerance": tolerance,
        "band": list(band),
        "speeds": list(speeds),
    }
    if model.speed is not None:
        content["coefficients_at"] = model.speed
    return Table(table.file, table.name, content, table.folder), replace(result, model=model)


def only_or_all(places: Sequence[Any]) -> Any:
    """The only place, or a list of them, for messages."""
    return list(places) if len(places) > 1 else places[0]


def _observers(table: Table, raw: object, nodes: Sequence[Any]) -> list[Any]:
    """The observed nodes of a body, with those of clearances behind them."""
    observers = as_list(raw)
    if observers is None:
        table.refuse("observers", raw, "a list of nodes")
    for node in nodes:
        if one_line(node) not in map(one_line, observers):
            observers.append(_place(table, node, "observers"))
    return observers


def _place(table: Table, raw: object, key: str = "contact") -> Any:
    if isinstance(raw, Mapping) and key == "contact" and table.name == "rotor":
        if set(raw) != {"node", "against"}:
            table.refuse(key, dict(raw), "{node = ..., against = ...}, two nodes that touch each other")
        from rsc.machine.model.contact import Against

        return Against(*(_place(table, raw[end], f"contact.{end}") for end in ("node", "against")))
    if isinstance(raw, (int, str)) and not isinstance(raw, bool):
        return raw
    parts = as_list(raw)
    if parts is None or len(parts) != 3:
        table.refuse(key, raw, "a node (number or name), or [node, node, share of the way]")
    return parts


def _with_bearings(table: Table, model: Any, raw: object) -> Any:
    """The model with the bearings of the scene."""
    from rsc.machine.imports.bearings import Bearing, with_bearings

    bearings, items = [], as_list(raw)
    if items is None:
        table.refuse("bearings", raw, BEARINGS.wanted)
    for i, item in enumerate(items):
        parts, key = as_list(item), f"bearings[{i}]"
        if parts is None or len(parts) not in (2, 3):
            table.refuse(key, item, BEARINGS.wanted)
        units = zip(("stiffness", "damping"), parts[1:], strict=False)
        coefficients = [_coefficients(table, f"{key}[{k}]", part, unit) for k, (unit, part) in enumerate(units, 1)]
        bearings.append(Bearing(_node(table, f"{key}[0]", parts[0]), *coefficients))
    try:
        return with_bearings(model, bearings)
    except DataError as error:
        table.refuse("bearings", raw, "bearings at nodes of the model that hold it", error.problem)


def _coefficients(table: Table, key: str, raw: Any, unit: str) -> Any:
    """[xx, xy, yx, yy] of one number, the same in every direction, or of four."""
    if as_list(raw) is None:
        value = Number(unit).read(table, key, raw)
        return value, 0.0, 0.0, value
    if len(raw) != 4:
        table.refuse(key, raw, f"a number in {DIMENSIONS[unit][0]}, or [xx, xy, yx, yy]")
    return per_coordinate(table, key, raw, [Number(unit)] * 4)


def _node(table: Table, key: str, raw: Any) -> Any:
    if isinstance(raw, bool) or not isinstance(raw, (int, str)):
        table.refuse(key, raw, "a node, number or name")
    return raw


def _at_nodes(table: Table, values: Mapping[str, Any]) -> dict[str, Any]:
    """Unbalances, loads and gravity of a rotor."""
    from rsc.machine.model.contact import Unbalance

    unbalances, loads = [], []
    for i, raw in enumerate(as_list(values["unbalance"]) or []):
        parts, key = as_list(raw), f"unbalance[{i}]"
        if parts is None or len(parts) not in (2, 3):
            table.refuse(key, raw, "[node, amount] or [node, amount, angle in degrees]")
        angle = Number("angle in degrees").read(table, f"{key}[2]", parts[2]) if len(parts) == 3 else 0.0
        unbalances.append(Unbalance(parts[0], _amount(table, f"{key}[1]", parts[1]), angle))
    for i, raw in enumerate(as_list(values["load"]) or []):
        parts = as_list(raw)
        if parts is None or len(parts) != 2:
            table.refuse(f"load[{i}]", raw, "[node, [f_y, f_z] in N]")
        loads.append((parts[0], PairReader("force").read(table, f"load[{i}][1]", parts[1])))
    return {"unbalances": unbalances, "loads": loads, "gravity": values["gravity"] or 0.0}


def _amount(table: Table, key: str, raw: object) -> float | str:
    """kg m, or the text of a balance grade."""
    if isinstance(raw, str) and raw.strip().startswith("G"):
        return raw
    return AMOUNT.read(table, key, raw)


def _anisotropic(model: Any, result: Any) -> dict[str, Any]:
    """What makes directions differ, in the reduced coordinates, V^T E V, and the error reached with it."""
    from rsc.machine.reduction.directions import BOTH_LINES, congruent

    content: dict[str, Any] = {}
    for check in result.checks:
        if check.response == BOTH_LINES:
            content["directions_error"] = check.error
    for name in ("anisotropic_stiffness", "anisotropic_damping"):
        matrix = getattr(model, name)
        if matrix is not None:
            content[name] = _pairs(congruent(matrix, result.basis))
    for name, part in ({} if model.knots is None else model.knots.without(REAL).parts).items():
        content[f"{name}_knots"] = [_pairs(congruent(matrix, result.basis)) for matrix in part]
    return content


def _pairs(matrix: Any) -> list[Any]:
    """A complex matrix as nested lists of [real, imaginary]."""
    return [[[float(item.real), float(item.imag)] for item in row] for row in matrix]


def _error_at(result: Any, i: int) -> float:
    """Largest error of a reduction at one of its observers."""
    return max((float(check.error) for check in result.checks if check.place == f"observer {i}"), default=0.0)


def _content(result: Any, rotor: bool) -> dict[str, Any]:
    """Keys of a reduced body that its matrices give."""
    from rsc.machine.reduction.body import n_contacts

    body = result.body
    content: dict[str, Any] = {
        "model": "reduced",
        "mass": float(body.mass[0, 0]),
        "stiffness": body.stiffness.tolist(),
        "damping": body.damping.tolist(),
        "observer_rows": body.observers.tolist(),
        "observer_errors": [_error_at(result, i) for i in range(len(body.observers))],
        "coordinates_before": result.full.n_coordinates,
        "error": result.error,
        "highest_before": result.highest_before / TWO_PI,
        "highest_after": result.highest_after / TWO_PI,
    }
    if n_contacts(body) > 1:
        content["contact_masses"] = body.mass[: n_contacts(body), : n_contacts(body)].tolist()
    for name in ("skew_stiffness", "skew_damping", *(["gyroscopic", "rotating_damping"] if rotor else [])):
        matrix = getattr(body, name)
        if matrix is not None:
            content[name] = matrix.tolist()
    if body.knots is not None:
        content["knot_speeds"] = (body.knots.speed / TWO_PI).tolist()
        content |= {f"{name}_knots": part.tolist() for name, part in body.knots.parts.items()}
    if rotor:
        unbalance = body.unbalance.sum(axis=1) if body.unbalance.size else np.zeros(body.n_coordinates)
        for name, vector in (("unbalance", unbalance), ("load", body.load)):
            content[name] = [[float(np.real(item)), float(np.imag(item))] for item in vector]
    return content
