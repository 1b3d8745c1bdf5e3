"""Many runs and predictions of one scene with some values varied: `sweep(scene, vary, compute) -> xarray.Dataset`."""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING, Any

from rsc.arguments import FLAG, PATH, SCENE, TEXTS, WHOLE, optional, takes
from rsc.errors import DataError, SolverError
from rsc.operating_system import processors
from rsc.results.budget import peak_memory, size_text
from rsc.results.labelled import Labelled, refuse_without_xarray
from rsc.results.sweep_store import Cases, Plan, SweepStore
from rsc.scene.scene import Scene
from rsc.scene.values import with_entries
from rsc.study.sweep.compute import Part, compute_part
from rsc.study.sweep.dataset import dataset, refuse_too_large
from rsc.study.sweep.engines import IN_FLIGHT, Executor, own_threads, run_parts
from rsc.study.sweep.plan import (
    SIMULATING,
    Label,
    bytes_of_a_run,
    held_labels,
    is_whole,
    labels,
    make_plan,
    missing,
    name_of,
    part_of,
    read_rows,
    refuse_store,
    span,
    stored_plan,
    write_plan,
    write_rows,
)
from rsc.study.sweep.rows import Rows
from rsc.study.sweep.vary import cases

if TYPE_CHECKING:
    import xarray

Note = Callable[[str], object]


@takes(scene=SCENE, compute=TEXTS, path=optional(PATH), resume=FLAG, threads=optional(WHOLE), progress=FLAG)
def sweep(
    scene: Scene,
    vary: Mapping[str, Any] | Cases,
    compute: str | Sequence[str] = "predict",
    *,
    path: str | os.PathLike[str] | None = None,
    resume: bool = False,
    executor: Executor | None = None,
    threads: int | None = None,
    progress: bool = False,
) -> "xarray.Dataset":
    """Predict, simulate or check many variants of a scene.

    Parameters
    ----------
    scene : Scene
    vary : mapping or Cases
        Name of a value, such as "contact.friction" or "start.rotor[0][1]", to its values; several span a grid. `rsc.cases` makes
        other sets: side by side, scattered, from a table.
    compute : str or sequence of str
        One or more of "predict" (whirls at the first speed of every case), "mu_min" (least friction with which a whirl exists),
        "jump" (where a run-up leaves its whirl), "run" (the motion in which a run ends), "motions" (the most dangerous one that
        lasts), "check" (verdict of run and prediction); "mu_min" and "jump" of a scene with one contact only.
    path : str or Path, optional
        Folder that keeps every part as it is computed; whatever happens, nothing of it is lost.
    resume : bool
        Compute only the parts that `path` does not hold.
    executor : object with `submit`, optional
        Computes the parts, of up to 128 cases: a dask.distributed Client, an executor of concurrent.futures, and so on; its
        workers need the same rsc. Default: threads of this process.
    threads : int, optional
        Of this process; by default the processors that it may use.
    progress : bool
        Show cases done, rate and time left on standard error.

    Returns
    -------
    xarray.Dataset
        Over the varied values (and "whirl"), with units; the same bits whoever computed it and in which order. Every case has its
        `status`: "finished", or that of its run, "impossible", "failed" or "lost", with the `reason`.

    Raises
    ------
    SceneError
        A value that does not exist or that no scene may have.
    SolverError
        No case, too many, something that is of one contact only, results that would not fit into memory, or workers with other
        versions.
    DataError
        `path` cannot be used.

    Examples
    --------
    >>> scene = rsc.load_scene("laval.toml")
    >>> found = rsc.sweep(scene, {"contact.friction": "0.1:0.3:3"}, "predict")
    >>> found.whirl_frequency.round(2).values  # of the most dangerous whirl
    array([-52.16, -60.66, -63.85])
    """
    refuse_without_xarray()
    chosen = vary if isinstance(vary, Cases) else cases(scene, vary)
    plan = make_plan(scene, chosen, compute)
    store = None if path is None else SweepStore(path)
    return computed(plan, store, resume, executor=executor, threads=threads, progress=progress).to_xarray()


def computed(
    plan: Plan,
    store: SweepStore | None,
    resume: bool = False,
    *,
    executor: Executor | None = None,
    threads: int | None = None,
    progress: bool = False,
    note: Note = lambda text: None,
) -> Labelled:
    """The dataset of a plan, computed into a store or into memory; arguments and errors as `sweep`."""
    threads = threads if threads is not None else processors()
    if not 1 <= threads <= 1024:
        raise SolverError(f"threads = {threads!r}: must be a whole number from 1 to 1024")
    if store is not None:
        refuse_store(store, plan, resume)
    note(foresee(plan, threads, executor is None))
    with store.locked() if store is not None else nullcontext():
        rows = _MemoryRows(plan) if store is None else _StoredRows(plan, store, note)
        with nullcontext(executor) if executor is not None else own_threads(threads) as engine:
            in_flight = IN_FLIGHT if executor is not None else 2 * threads
            with _bar(plan, rows.cases_there, progress) as show:
                for label, part_rows, known in run_parts(rows.parts(), engine, in_flight):
                    rows.keep(label, part_rows, known)
                    show(label)
        pieces = ((label, rows.of(label)) for label in labels(plan))
        return dataset(plan, ((label, part_rows) for label, part_rows in pieces if part_rows is not None))


def planned(plan: Plan, store: SweepStore, resume: bool = False, note: Note = lambda text: None) -> int:
    """Write a plan whose parts are computed elsewhere (`compute_parts`, on any machine); returns the number of its parts.

    Errors as `sweep`.
    """
    refuse_store(store, plan, resume)
    note(foresee(plan, 1, own=False))
    with store.locked():
        write_plan(store, plan, note)
    return len(labels(plan))


def compute_parts(store: SweepStore, numbers: Iterable[int], note: Note = lambda text: None) -> None:
    """Compute the parts of these numbers, from 0, of the plan of a store; those that are there are left and noted."""
    plan = stored_plan(store)
    every = labels(plan)
    for number in numbers:
        part, i = part_of(plan, every[number]), every[number][1]
        if store.has(name_of(part, i)) and is_whole(store, part, i, note):
            note(f"part {number} is there")
        else:
            write_rows(store, part, i, compute_part(part))


def scene_of_case(store: SweepStore, number: int) -> Scene:
    """The scene of a case, counted from 0, of the plan of a store."""
    plan = stored_plan(store)
    values = dict(zip(plan.cases.keys, plan.cases.values(number, number + 1)[0], strict=True))
    return with_entries(Scene.from_stored(plan.scene, plan.source), values)


def collected(store: SweepStore, note: Note = lambda text: None) -> Labelled:
    """The dataset of a store; cases of missing parts have the status "missing".

    Raises DataError when there is none of them, or one that is damaged or not what its name says.
    """
    plan = stored_plan(store)
    needed, held = refuse_too_large(plan), held_labels(plan, store)
    if not held:
        raise DataError(store.folder, "holds no part of its plan yet")
    note(f"{len(plan.cases)} cases; {size_text(peak_memory(needed))} of memory at most, for the results and this process")
    return dataset(plan, ((label, read_rows(store, part_of(plan, label), label[1])) for label in held))


class _MemoryRows:
    """The rows of a sweep without a store."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._rows: dict[Label, Rows] = {}
        self.cases_there = 0

    def parts(self) -> Iterator[tuple[Label, Part]]:
        return ((label, part_of(self._plan, label)) for label in labels(self._plan))

    def keep(self, label: Label, rows: Rows, known: bool) -> None:
        self._rows[label] = rows

    def of(self, label: Label) -> Rows | None:
        return self._rows.get(label)


class _StoredRows:
    """The rows of a sweep in its store; those without an answer of the executor are only in memory."""

    def __init__(self, plan: Plan, store: SweepStore, note: Note) -> None:
        write_plan(store, plan, note)
        self._plan, self._store = plan, store
        self._missing = missing(plan, store, note)
        self._lost: dict[Label, Rows] = {}
        sizes = {label: span(plan, label) for label in self._missing}
        self.cases_there = len(plan.cases) * len(plan.kinds) - sum(last - first for first, last in sizes.values())

    def parts(self) -> Iterator[tuple[Label, Part]]:
        return ((label, part_of(self._plan, label)) for label in self._missing)

    def keep(self, label: Label, rows: Rows, known: bool) -> None:
        if known:
            write_rows(self._store, part_of(self._plan, label), label[1], rows)
        else:
            self._lost[label] = rows

    def of(self, label: Label) -> Rows | None:
        if label in self._lost:
            return self._lost[label]
        part = part_of(self._plan, label)
        return read_rows(self._store, part, label[1]) if self._store.has(name_of(part, label[1])) else None


def foresee(plan: Plan, threads: int, own: bool) -> str:
    """One line for people on the parts of a sweep and the memory that it takes.

    Raises
    ------
    SolverError
        Its results would not fit into memory.
    """
    dataset_bytes = refuse_too_large(plan)
    text = f"{len(plan.cases)} cases in {len(labels(plan))} parts; {size_text(dataset_bytes)} of memory for the results"
    simulated = [size for kind, size in zip(plan.kinds, plan.part_sizes, strict=True) if kind in SIMULATING]
    if simulated:
        each = max(simulated) * bytes_of_a_run(Scene.from_stored(plan.scene, plan.source), plan.cases)
        text += f" and {size_text(each)} for the runs of a part"
        text += f", in each of {threads} threads" if own else ", in each worker"
    return text


@contextmanager
def _bar(plan: Plan, n_stored: int, progress: bool) -> Iterator[Callable[[Label], None]]:
    """Yield a function that counts the cases of a part."""
    if not progress:
        yield lambda label: None
        return
    from tqdm import tqdm

    total = len(plan.cases) * len(plan.kinds)
    form = "rsc: sweep {percentage:.0f} % ({elapsed}, {remaining} left): {n} of {total} cases"
    with tqdm(total=total, initial=n_stored, bar_format=form, mininterval=0.2, leave=False) as bar:

        def show(label: Label) -> None:
            bar.update(len(part_of(plan, label).values))

        yield show
