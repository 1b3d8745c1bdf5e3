"""The labelled dataset of a sweep, from the rows of its parts; what is derived from several of them."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.measure import final
from rsc.results.labelled import Labelled, Variable
from rsc.results.sweep_store import Cases, Plan
from rsc.scene.scene import Scene
from rsc.study.sweep.plan import Label, span
from rsc.study.sweep.rows import FINISHED, MISSING, STATUS, WHIRL, Rows, all_columns

UNKNOWN, NONE, EXISTS, STABLE, REACHED = range(-1, 4)
DANGER = ("no whirl", "a whirl exists", "a whirl is stable", "a whirl is reached")


def dataset(plan: Plan, labels: Iterable[Label], rows_of: Callable[[Label], Rows | None]) -> Labelled:
    """The dataset of a sweep.

    Parameters
    ----------
    plan : Plan
    labels : of all its parts; rows_of : callable, rows of a part, or None where it is missing

    Returns
    -------
    Labelled
        Every quantity of `rsc.study.sweep.rows.COLUMNS` that was computed, over the dimensions of the cases (and "whirl");
        `status` and `reason` of the first computation of a case that did not finish; `danger` and the largest backward whirl
        where whirls were predicted, -1 in a case of which they could not be.
    """
    count = len(plan.cases)
    status, reason = np.full(count, FINISHED, dtype="U16"), np.full(count, "", dtype=object)
    hashes = np.full(count, "", dtype="U64")
    flat: dict[str, NDArray[Any]] = {}
    by_kind: dict[str, list[tuple[int, int, Rows]]] = {kind: [] for kind in plan.kinds}
    predicted = np.zeros(count, dtype=bool)
    for label in labels:
        first, last = span(plan, label)
        rows = rows_of(label)
        if rows is None:
            status[first:last] = np.where(status[first:last] == FINISHED, MISSING, status[first:last])
            continue
        by_kind[label[0]].append((first, last, rows))
        own, why = (np.char.decode(rows[name], "utf-8", "replace") for name in ("status", "reason"))
        if label[0] == "predict":
            predicted[first:last] = own == FINISHED
        before = status[first:last]
        first_told = (before == FINISHED) & ((own != FINISHED) | (reason[first:last] == ""))
        reason[first:last][first_told], before[first_told] = why[first_told], own[first_told]
        hashes[first:last] = np.char.decode(rows["scene_hash"])
    for kind, pieces in by_kind.items():
        flat |= _columns(kind, count, pieces)
    flat |= _derived(flat, predicted)
    shape, dims = tuple(plan.cases.dims.values()), tuple(plan.cases.dims)
    variables: dict[str, Variable] = {}
    described = {name: column for kind in plan.kinds for name, column in all_columns(kind).items()}
    for name, values in {"status": status, "reason": reason.astype(str), "scene_hash": hashes, **flat}.items():
        own_dims = (*dims, WHIRL) if values.ndim == 2 else dims
        own_shape = (*shape, values.shape[1]) if values.ndim == 2 else shape
        unit, text = (described[name].unit, described[name].meaning) if name in described else _DERIVED[name]
        described_by = {"long_name": text} | ({"units": unit} if unit else {})
        if name == "danger":
            described_by["flags"] = "; ".join(f"{i} {word}" for i, word in enumerate(DANGER))
        variables[name] = (own_dims, values.reshape(own_shape), described_by)
    every_dim = dict(plan.cases.dims)
    for values in flat.values():
        if values.ndim == 2:
            every_dim[WHIRL] = values.shape[1]
    head = {"title": Scene.from_toml(plan.scene).title, "computed": ",".join(plan.kinds)}
    head |= {name: getattr(plan, name) for name in ("source", "scene", "versions")}
    return Labelled(every_dim, _coordinates(plan.cases), variables, head)


def _columns(kind: str, count: int, pieces: list[tuple[int, int, Rows]]) -> dict[str, NDArray[Any]]:
    """The columns of one kind over all cases; texts as str, flags as bool."""
    arrays: dict[str, NDArray[Any]] = {}
    for name, column in all_columns(kind).items():
        if name in STATUS:
            continue
        width = max((rows[name].shape[1] for _, _, rows in pieces), default=0) if column.per_whirl else 0
        if column.kind == "S":
            longest = max((rows[name].itemsize for _, _, rows in pieces), default=1)
            whole: NDArray[Any] = np.full(count, "", dtype=f"U{longest}")
        else:
            whole = np.full((count, width) if column.per_whirl else count, column.fill, dtype=column.dtype)
        for first, last, rows in pieces:
            values = np.char.decode(rows[name], "utf-8", "replace") if column.kind == "S" else rows[name]
            if column.per_whirl:
                whole[first:last, : values.shape[1]] = values
            else:
                whole[first:last] = values
        arrays[name] = whole.astype(bool) if column.kind == "b" else whole
    return arrays


_DERIVED = {
    "danger": ("", "the worst that backward whirls do here; -1: not predicted, as status tells"),
    "whirl_frequency": ("Hz", "frequency of the largest backward whirl that is as dangerous as any here"),
    "whirl_amplitude": ("m", "its amplitude at the contact"),
    "whirl_force": ("N", "its normal force"),
    "whirl_growth_rate": ("1/s", "its growth rate"),
}


def _derived(flat: dict[str, NDArray[Any]], predicted: NDArray[np.bool_]) -> dict[str, NDArray[Any]]:
    """How dangerous backward whirls are, and the largest of the most dangerous ones, in the cases where whirls were predicted."""
    if "frequency" not in flat:
        return {}
    exists = flat["admissible"] & (flat["frequency"] < 0.0)
    stable = exists & flat["stable"]
    worst = np.where(stable.any(axis=1), STABLE, np.where(exists.any(axis=1), EXISTS, NONE))
    danger = np.where(predicted, worst, UNKNOWN).astype("i1")
    chosen = np.where(stable.any(axis=1, keepdims=True), stable, exists)
    derived = {}
    place = np.argmax(np.where(chosen, flat["rotor_amplitude"], -1.0), axis=1) if chosen.shape[1] else None
    names = ("frequency", "rotor_amplitude", "normal_force", "growth_rate")
    for name, source in zip(list(_DERIVED)[1:], names, strict=True):
        values = np.full(len(danger), np.nan)
        if place is not None:
            values = np.where(chosen.any(axis=1), flat[source][np.arange(len(danger)), place], np.nan)
        derived[name] = values
    if "motion" in flat:
        danger[np.isin(flat["motion"], (final.WHIRL, final.ROLLS, final.RUNS_AWAY))] = REACHED
    return {"danger": danger, **derived}


def _coordinates(cases: Cases) -> dict[str, Variable]:
    coordinates: dict[str, Variable] = {}
    for axis in cases.axes:
        own = {"long_name": axis.meaning} | ({"units": axis.unit} if axis.unit else {})
        coordinates[axis.key] = ((axis.dim,), np.array(axis.values), own)
    return coordinates
