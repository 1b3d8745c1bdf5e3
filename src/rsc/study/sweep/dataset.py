"""The labelled dataset of a sweep from the rows of its parts, derived quantities, and its file."""

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, SolverError
from rsc.files.gate import F8, I1, I8, TEXT, Array
from rsc.measure.catalogue import WHIRLING
from rsc.measure.severity import Severity
from rsc.operating_system import free_memory
from rsc.results.budget import LARGEST_SHARE, size_text
from rsc.results.labelled import Labelled, Variable, load_labelled
from rsc.results.sweep_store import Cases, Plan, axis_of
from rsc.scene.scene import Scene
from rsc.study.sweep.compute import KINDS, LONGEST_REASON
from rsc.study.sweep.plan import Label, most_whirls, span
from rsc.study.sweep.rows import ADDED, FINISHED, MISSING, SETS, WHIRL, Column, Rows, all_columns

UNKNOWN, NONE, PREDICTED, LASTS, REACHED = range(-1, 4)
DANGER = (
    "no whirl predicted or found", "a whirl is predicted only", "a whirl lasts once it is started", "the run ends in a whirl",
)  # fmt: skip
# variable of classes -> their words
FLAGS = {"danger": DANGER, **dict.fromkeys(("severity", "end_severity", "lasting_severity"), tuple(map(str, Severity)))}
# of the results: as arrays, as the file that is written of them, and what is in use beside them; measured: 2.11 with all whirls
# and letters that are reckoned with
COPIES = 2.2
LETTERS = {"reason": LONGEST_REASON, "scene_hash": 64}  # of a text; of others:
FEWEST_LETTERS = 32


def refuse_too_large(plan: Plan) -> float:
    """Bytes that the dataset of a plan and its file take; SolverError when they are more than 80 % of the free memory."""
    whirls = most_whirls(plan.scene, plan.source) // 2  # more were never seen
    widths = {"f": 8, "i": 8, "b": 1, "c": 1, "S": FEWEST_LETTERS}
    each = sum(
        LETTERS.get(name, widths[column.kind] * (whirls if column.per_whirl else 1))
        for name, column in _columns(plan.kinds).items()
    )
    needed, free = COPIES * float(each * len(plan.cases)), free_memory()
    if free is not None and needed > LARGEST_SHARE * free:
        told = f"the results of {len(plan.cases)} cases need {size_text(needed)} of memory"
        raise SolverError(f"{told} and {size_text(free)} are free: must be fewer cases")
    return needed


def _columns(kinds: Iterable[str]) -> dict[str, Column]:
    """Every variable of a dataset in which these were computed."""
    columns = {name: column for kind in kinds for name, column in all_columns(kind).items()}
    severity = {"severity": _SEVERITY} if {"end_severity", "lasting_severity"} & set(columns) else {}
    return columns | (_DERIVED if "frequency" in columns else {}) | severity


def dataset(plan: Plan, pieces: Iterable[tuple[Label, Rows]]) -> Labelled:
    """The dataset of a sweep.

    Parameters
    ----------
    plan : Plan
    pieces : the rows of its parts, each with its label; cases of those that do not come have the status "missing"

    Returns
    -------
    Labelled
        Every quantity of `rsc.study.sweep.rows.COLUMNS` that was computed, over the dimensions of the cases (and "whirl");
        `status` and `reason` of the first computation of a case that did not finish; `danger` and the largest backward whirl
        where whirls were predicted, -1 in a case of which they could not be.
    """
    count, columns = len(plan.cases), {name: column for kind in plan.kinds for name, column in all_columns(kind).items()}
    flat = {name: _nothing(count, column) for name, column in columns.items()}
    flat["status"][:] = FINISHED.encode()
    computed, predicted = np.zeros(count, dtype="i1"), np.zeros(count, dtype=bool)
    for (kind, i), rows in pieces:
        cases = slice(*span(plan, (kind, i)))
        finished = rows["status"] == FINISHED.encode()
        if kind == "predict":
            predicted[cases] = finished
        first_told = (flat["status"][cases] == FINISHED.encode()) & (~finished | (flat["reason"][cases] == b""))
        computed[cases] += 1
        for name, column in all_columns(kind).items():
            flat[name] = _wide_enough(flat[name], rows[name], column)
            place = (cases, slice(rows[name].shape[1])) if column.per_whirl else cases
            told_before = name in ("status", "reason")
            flat[name][place] = np.where(first_told, rows[name], flat[name][place]) if told_before else rows[name]
    flat["status"][(computed < len(plan.kinds)) & (flat["status"] == FINISHED.encode())] = MISSING.encode()
    for name, column in columns.items():
        flat[name] = flat[name].astype(bool) if column.kind == "b" else flat[name]
    flat |= _derived(flat, predicted)
    flat |= _severity(flat, computed)
    scene = Scene.from_stored(plan.scene, plan.source)
    dims = plan.cases.dims | ({WHIRL: flat["frequency"].shape[1]} if "frequency" in flat else {})
    variables: dict[str, Variable] = {}
    for name, column in _columns(plan.kinds).items():
        own = _dims(plan.cases, column)
        variables[name] = (own, flat[name].reshape([dims[dim] for dim in own]), _about(name, column, scene))
    head = _head(plan.cases, plan.kinds, plan.scene, plan.source, plan.versions)
    return Labelled(dims, _coordinates(plan.cases), variables, head)


def _nothing(count: int, column: Column) -> NDArray[Any]:
    """A column over all cases, without a whirl and without text."""
    if column.kind == "S":
        return np.zeros(count, f"S{FEWEST_LETTERS}")
    return np.full((count, 0) if column.per_whirl else count, column.fill, column.dtype)


def _wide_enough(whole: NDArray[Any], values: NDArray[Any], column: Column) -> NDArray[Any]:
    """An array over all cases with room for as many whirls or letters as some rows have."""
    if column.kind == "S" and values.itemsize > whole.itemsize:
        return whole.astype(values.dtype)
    if column.per_whirl and values.shape[1] > whole.shape[1]:
        more = np.full((len(whole), values.shape[1] - whole.shape[1]), column.fill, column.dtype)
        return np.concatenate([whole, more], axis=1)
    return whole


def _dims(cases: Cases, column: Column) -> tuple[str, ...]:
    return (*cases.dims, WHIRL) if column.per_whirl else tuple(cases.dims)


def _about(name: str, column: Column, scene: Scene) -> dict[str, str]:
    """What a variable is, in the words of netCDF."""
    flags = list(enumerate(FLAGS.get(name, ())))
    if len(scene.contacts) > 1 and (name in SETS or name == "largest_contact"):
        flags = [(1 << i if name in SETS else i, contact.name or "") for i, contact in enumerate(scene.contacts)]
    own = {"long_name": column.meaning} | ({"units": column.unit} if column.unit else {})
    return own | ({"flags": "; ".join(f"{i} {word}" for i, word in flags)} if flags else {})


def _head(cases: Cases, kinds: Iterable[str], scene: str, source: str, versions: str) -> dict[str, str]:
    head = {"title": Scene.from_stored(scene, source).title, "computed": ",".join(kinds), "source": source, "scene": scene}
    return head | {"versions": versions, "axes": " ".join(f"{axis.key}:{axis.dim}" for axis in cases.axes)}


def load_dataset(path: str | os.PathLike[str]) -> Labelled:
    """Read the dataset of a sweep; what its quantities are, their units and dimensions is not believed but known. One of an older
    format lacks what was added since.

    Raises
    ------
    DataError
        The file is missing, damaged, of another version, or no sweep writes it.
    SceneError
        Its scene, or a value that was varied in it, cannot be.
    """
    def table(head: Mapping[str, str]) -> dict[str, Array]:
        kinds, axes = head["computed"].split(","), dict(pair.split(":") for pair in head["axes"].split(" "))
        if not set(kinds) <= set(KINDS) or not axes:
            raise ValueError("its head is not that of a sweep")
        dims = dict.fromkeys(axes.values())
        numbers = {dim: Array(I8, (dim,)) for dim in dims if dim not in axes}
        columns = {name: column for name, column in _columns(kinds).items() if name not in ADDED.get(head["format"], ())}
        if any(column.per_whirl for column in columns.values()):
            numbers[WHIRL] = Array(I8, (WHIRL,))
        coordinates = {key: Array(f"{F8} {I8} {I1} {TEXT}", (dim,)) for key, dim in axes.items()}
        variables = {
            name: Array(column.passes, (*dims, WHIRL) if column.per_whirl else tuple(dims)) for name, column in columns.items()
        }
        return numbers | coordinates | variables

    head, lengths, arrays = load_labelled(path, table)
    scene, kinds = Scene.from_stored(head["scene"], head["source"]), head["computed"].split(",")
    axes = dict(pair.split(":") for pair in head["axes"].split(" "))
    try:
        cases = Cases(tuple(axis_of(scene, key, dim, arrays[key]) for key, dim in axes.items()))
    except ValueError as error:
        raise DataError(path, f"is no result of a sweep ({error})") from None
    variables: dict[str, Variable] = {}
    for name, column in _columns(kinds).items():
        if name in arrays:
            values = arrays[name].astype(bool) if column.kind == "b" else arrays[name]
            variables[name] = (_dims(cases, column), values, _about(name, column, scene))
    dims = cases.dims | ({WHIRL: lengths[WHIRL]} if WHIRL in lengths else {})
    return Labelled(dims, _coordinates(cases), variables, _head(cases, kinds, head["scene"], head["source"], head["versions"]))


_SEVERITY = Column("c", "", "severity (docs/users/motions.md) by all that was computed of the case")
# what holds of a whirl that may roll because it cannot slide
_BESIDE_SLIDING = ("psi_real", "normal_force_positive", "asynchronous_force_dominates", "contact_stiff_enough")
_DERIVED = {
    "danger": Column("c", "", "class of danger by backward whirl; -1: not predicted, see status"),
    "whirl_frequency": Column("f", "Hz", "frequency of the largest predicted backward whirl, a stable one where there is one"),
    "whirl_amplitude": Column("f", "m", "its amplitude at the contact"),
    "whirl_force": Column("f", "N", "its normal force"),
    "whirl_growth_rate": Column("f", "1/s", "its growth rate"),
    "whirl_pressed": Column("i", "1", "contacts that it presses, coded as `pressed`"),
}


def _derived(flat: dict[str, NDArray[Any]], predicted: NDArray[np.bool_]) -> dict[str, NDArray[Any]]:
    """How dangerous backward whirls are, and the largest of the predicted ones, of those that are stable where some are.

    One that only an oscillation makes unstable is no smaller danger than a stable one: round it a bouncing whirl may last. Nor is
    one that cannot slide so fast: it may roll.
    """
    if "frequency" not in flat:
        return {}
    rolls = ~flat["holds_sliding"] & np.logical_and.reduce([flat[f"holds_{name}"] for name in _BESIDE_SLIDING])
    exists = (flat["frequency"] < 0.0) & (flat["admissible"] | rolls)
    stable = exists & flat["stable"] & flat["admissible"]
    danger = np.where(predicted, np.where(exists.any(axis=1), PREDICTED, NONE), UNKNOWN).astype("i1")
    if "lasting_whirl" in flat:
        danger[flat["lasting_whirl"] != b""] = LASTS
    chosen = np.where(stable.any(axis=1, keepdims=True), stable, exists)
    derived = {}
    place = np.argmax(np.where(chosen, flat["rotor_amplitude"], -1.0), axis=1) if chosen.shape[1] else None
    names = ("frequency", "rotor_amplitude", "normal_force", "growth_rate", "pressed")
    for (name, column), source in zip(list(_DERIVED.items())[1:], names, strict=True):
        values = np.full(len(danger), column.fill, column.dtype)
        if place is not None:
            values = np.where(chosen.any(axis=1), flat[source][np.arange(len(danger)), place], values)
        derived[name] = values
    if "motion" in flat:
        danger[np.isin(flat["motion"], [str(kind).encode() for kind in WHIRLING])] = REACHED
    return {"danger": danger, **derived}


def _severity(flat: dict[str, NDArray[Any]], computed: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """The severity of every case: that of the end of its run, and of what lasts; without a list of motions at risk where a whirl
    is predicted to be stable and unknown otherwise."""
    told = [flat[name] for name in ("end_severity", "lasting_severity") if name in flat]
    if not told:
        return {}
    listed = flat["lasting_severity"] if "lasting_severity" in flat else np.full(len(computed), -1)
    known = np.full(len(computed), Severity.UNKNOWN.level)
    if "frequency" in flat:
        stable = (flat["frequency"] < 0.0) & flat["stable"] & flat["admissible"]
        known[stable.any(axis=1)] = Severity.AT_RISK.level
    worst = np.maximum(np.where(listed < 0, known, listed), told[0])
    return {"severity": np.where(np.max(told, axis=0) < 0, -1, worst).astype("i1")}


def _coordinates(cases: Cases) -> dict[str, Variable]:
    coordinates: dict[str, Variable] = {}
    for axis in cases.axes:
        own = {"long_name": axis.meaning} | ({"units": axis.unit} if axis.unit else {})
        coordinates[axis.key] = ((axis.dim,), np.array(axis.values), own)
    return coordinates
