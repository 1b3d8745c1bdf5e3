"""Reduction of a body with model "machine" to one with model "reduced" while its scene is read."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from math import tau as TWO_PI
from typing import Any

import numpy as np

from rsc.errors import DataError, ReductionError, one_line, shown
from rsc.scene.bodies.controls import control_content
from rsc.scene.bodies.drawn import drawn_content
from rsc.scene.bodies.machine_file import Machine, place_of
from rsc.scene.bodies.part_list import part_list
from rsc.scene.bodies.reduced import Reduction
from rsc.scene.keys.keys import RawTable, read_table
from rsc.scene.keys.readers import Number, as_list
from rsc.system.knots import ANISOTROPIC, FOLLOWING

# relative to the highest speed, backward and forward, and at least in Hz: impacts excite higher frequencies than whirl
BAND, LEAST_BAND = (-12.0, 6.0), (-500.0, 250.0)

REAL = tuple(name for name in FOLLOWING if name not in ANISOTROPIC)


def is_machine(table: RawTable) -> bool:
    """Whether a table has model "machine" or "shaft", which is converted to a machine."""
    return table.values.get("model") in ("machine", "shaft")


def read_reduction(table: RawTable, elsewhere: Any, fastest: float) -> tuple[float, tuple[float, float]]:
    """Tolerance and band (Hz) of [reduction], for a rotor with a highest speed in Hz."""
    values = read_table(Reduction, table, elsewhere)
    tolerance, wanted = values["tolerance"], values["band"]
    values.refuse_untaken()
    if wanted is None:
        return tolerance, (min(BAND[0] * fastest, LEAST_BAND[0]), max(BAND[1] * fastest, LEAST_BAND[1]))
    parts = as_list(wanted)
    if parts is None or len(parts) != 2:
        table.refuse("band", wanted, "[lowest, highest] frequency in Hz")
    low, high = (Number("frequency").read(table, f"band[{i}]", part) for i, part in enumerate(parts))
    if not low < high:
        table.refuse("band", wanted, "[lowest, highest]")
    return tolerance, (low, high)


def places_of(body: RawTable, contacts: Sequence[RawTable]) -> list[Any]:
    """The contact locations of a machine, without duplicates, as written in the file: the `rotor_node` of every contact, or the
    `contact` of the body. The displacements there become its first coordinates.

    Raises
    ------
    SceneError
        Both, neither, or nodes for some contacts only.
    """
    key, coordinate = f"{body.name}_node", f"{body.name}_coordinate"
    single, named = body.values.get("contact"), [table for table in contacts if key in table.values]
    if not named:
        if body.values.get("model") == "shaft":
            where = "at" if body.name == "rotor" else "stator_at"
            contacts[0].refuse(where, None, "given: the position along the shaft, such as \"330 mm\"")
        if single is None:
            body.refuse("contact", None, "given: a node", f"with several contacts give {key} in each [[contact]] instead")
        return [single]
    for table in contacts:
        if coordinate in table.values:
            table.refuse(coordinate, table.values[coordinate], f"left out: {key} names a node")
        if key not in table.values:
            table.refuse(key, None, "given: a node", f"{named[0].name} has one")
    if single is not None:
        body.refuse("contact", single, "left out", f"{named[0].name} has {key}")
    return list({one_line(table.values[key]): table.values[key] for table in named}.values())


def with_coordinates(contacts: Sequence[RawTable], name: str, places: Sequence[Any]) -> list[RawTable]:
    """The tables of contacts with nodes of "rotor" or "stator" replaced by coordinates of the reduced body."""
    key, known = f"{name}_node", [one_line(place) for place in places]
    made = []
    for table in contacts:
        values = {other: value for other, value in table.values.items() if other != key}
        if key in table.values:
            values[f"{name}_coordinate"] = known.index(one_line(table.values[key]))
        made.append(RawTable(table.file, table.name, values, table.folder))
    return made


def reduced(
    table: RawTable,
    machine: Machine,
    reduction: tuple[float, tuple[float, float], tuple[float, float]],
    touching: Sequence[Any],
) -> tuple[RawTable, Any]:
    """(table of the reduced body, its `rsc.machine.reduction.reduction.Reduced`).

    touching: contact locations.

    Raises
    ------
    SceneError
        An invalid location or unbalance, or a body that cannot be reduced.
    """
    from rsc.machine.model.contact import body_of

    rotor, model, observers, stages = table.name == "rotor", machine.model, machine.observers, machine.stages
    if model.free:
        _refuse_loose(table, machine, touching)
    tolerance, (low, high), (slowest, fastest) = reduction
    top = max(abs(slowest), abs(fastest))
    places, results = [place_of(table, place) for place in touching], list[Any]()
    try:
        parts = [body_of(each, places, observers=observers, speed=top, **machine.at_nodes) for each, _ in stages]
    except DataError as error:
        table.refuse("contact", only_or_all(touching), "a place of the model", error.problem)
    except ValueError as error:
        table.refuse("unbalance", table.values.get("unbalance"), str(error))
    try:
        ranges = (TWO_PI * low, TWO_PI * high), (TWO_PI * slowest, TWO_PI * fastest)
        for (each, states), body in zip(stages, parts, strict=True):  # with all bearings first, without those switched off last
            begin = results[-1].basis if results else None
            results.append(_reduced_model(each, _in_loop(body, states), ranges, tolerance, begin))
    except ReductionError as error:
        table.refuse(machine.key, machine.value, "a body that can be reduced", str(error))
    result = replace(results[-1], error=max(one.error for one in results))
    origin = f"{machine.origin}, contact at {shown(only_or_all(touching))}"
    content = _content(result, rotor) | _anisotropic(model, result) | _until(machine, result) | {
        **control_content(machine.controls, model, result.basis),
        "observers": [one_line(place) for place in observers],
        "origin": one_line(origin)[:400],
        "tolerance": tolerance,
        "band": [low, high],
        "speeds": [slowest, fastest],
    }
    if model.speed is not None:
        content["coefficients_at"] = model.speed
    if rotor:
        content |= drawn_content(stages[0][0], result.basis, touching, machine.controls)
        content |= part_list(stages[0][0].shaft) if stages[0][0].shaft is not None else {}
    result = replace(result, model=stages[0][0], states=stages[0][1])
    return RawTable(table.file, table.name, content, table.folder), result


def _in_loop(body: Any, states: Any) -> Any:
    """A body to be reduced with its first-order states, if there are any."""
    return body if states is None else replace(body, **{f"state_{name}": getattr(states, name) for name in states._fields})


def _reduced_model(model: Any, body: Any, ranges: tuple[Any, Any], tolerance: float, begin: Any) -> Any:
    """The `Reduced` of a model whose isotropic mean is a body; begin: motions that it contains in any case."""
    from rsc.machine.reduction.directions import Unequal, reduce_unequal
    from rsc.machine.reduction.reduction import reduce

    if model.isotropic:
        return reduce(body, *ranges, tolerance, begin)
    parts = model.anisotropic_stiffness, model.anisotropic_damping
    knots = None if model.knots is None else model.knots.without(REAL)
    stiffness, damping = (0.0 * body.stiffness if part is None else part for part in parts)
    return reduce_unequal(body, Unequal(stiffness, damping, knots), *ranges, tolerance, begin)


def _until(machine: Machine, result: Any) -> dict[str, Any]:
    """Matrices of the bearings that are switched off at each time, in the reduced coordinates."""
    from rsc.machine.reduction.directions import congruent

    if not machine.switched:
        return {}
    content: dict[str, Any] = {"off_times": [time for time, _ in machine.switched]}
    models = [*machine.earlier, machine.model]
    for name in FOLLOWING:
        matrices = [getattr(model, name) for model in models]
        if all(matrix is None for matrix in matrices):
            continue
        zero = 0.0 * machine.model.stiffness
        whole = [zero if matrix is None else matrix for matrix in matrices]
        parts = [congruent(before - after, result.basis) for before, after in itertools.pairwise(whole)]
        if any(part.any() for part in parts):
            content[f"{name}_until"] = [_pairs(part) if name in ANISOTROPIC else part.tolist() for part in parts]
    return content


def _refuse_loose(table: RawTable, machine: Machine, touching: Sequence[Any]) -> None:
    """SceneError for a free body, unless it is a rotor that its magnetic bearings and its contacts catch in every motion."""
    from rsc.machine.imports.bearings import refuse_loose
    from rsc.machine.model.contact import row_at

    rotor = table.name == "rotor"
    holding = [row for one in machine.controls if one.off is None for row in one.rows(machine.model)[0]]
    try:
        caught = [row_at(machine.model, place_of(table, place)) for place in touching] if rotor else []
        refuse_loose(machine.model, [*caught, *holding])
    except DataError as error:
        table.refuse("bearings", table.values.get("bearings"), f"bearings that support the {table.name}", error.problem)


def only_or_all(places: Sequence[Any]) -> Any:
    """The only place, or a list of them, for messages."""
    return list(places) if len(places) > 1 else places[0]


def _anisotropic(model: Any, result: Any) -> dict[str, Any]:
    """Anisotropic matrices in the reduced coordinates, V^T E V, and the error achieved with them."""
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
    """Keys of a reduced body that follow from its matrices."""
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
