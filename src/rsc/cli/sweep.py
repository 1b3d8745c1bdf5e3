"""`rsc sweep`: parameter sweeps; plan, parts, status and collection for batch systems."""

import argparse
import contextlib
import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rsc.cli.common import FORCE, INTERRUPTED, JSON, OK, SOME_FAILED, Commands, load
from rsc.cli.progress import note, signs_of_life, wants_progress
from rsc.errors import SolverError
from rsc.files.mark import HDF5
from rsc.files.output import target

if TYPE_CHECKING:
    from rsc.results.labelled import Labelled
    from rsc.results.sweep_store import Plan, SweepStore

ACTIONS = ("plan", "run", "status", "collect", "scene")
DATASET = "sweep.nc"


def add(commands: Commands) -> None:
    parser = commands("sweep", sweep_command, "run or predict many cases with varied parameters; can be interrupted and resumed")
    parser.add_argument(
        "words", metavar="SCENE", nargs="+",
        help="a scene; or `plan SCENE`, then `run STORE --part N` on any machine, `status STORE`, `collect STORE`; "
        "`scene STORE N` prints the scene of case N",
    )  # fmt: skip
    text = "values of a key: FROM:TO:NUMBER, log:FROM:TO:NUMBER, A,B,C, normal:MEAN:DEVIATION, uniform:FROM:TO; with units"
    parser.add_argument("--vary", metavar="KEY=VALUES", action="append", default=[], help=text)
    parser.add_argument("--zip", action="store_true", help="combine lists and ranges one by one instead of as a grid")
    parser.add_argument("--random", metavar="N", type=int, default=0, help="number of random samples (normal, uniform)")
    parser.add_argument("--sobol", metavar="N", type=int, default=0, help="number of samples of a Sobol sequence")
    parser.add_argument("--seed", metavar="S", type=int, default=0, help="seed of the samples (default: 0)")
    parser.add_argument("--table", metavar="FILE", help="read cases from a CSV file whose header names the keys")
    text = "one or several of predict (default), mu_min, jump, run, motions, check, separated by commas"
    parser.add_argument("--compute", metavar="WHAT", default="predict", help=text)
    parser.add_argument("-o", "--output", metavar="STORE", help="folder of the store (default: out/SCENE-sweep)")
    parser.add_argument("--resume", action="store_true", help="compute only the parts missing in the store")
    parser.add_argument("--threads", metavar="N", type=int, help="number of threads (default: all processors)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="address or file of a dask scheduler whose workers compute")
    parser.add_argument("--part", metavar="N", help="with `run`: part N or parts A-B to compute")
    parser.add_argument("--force", action="store_true", help=FORCE)
    parser.add_argument("--json", action="store_true", help=JSON)
    parser.add_argument("--yes", action="store_true", help="allow more than 10 million cases")


def sweep_command(options: argparse.Namespace) -> int:
    words = options.words
    if words[0] in ACTIONS and len(words) > 1:
        return {"plan": _plan, "run": _run, "status": _status, "collect": _collect, "scene": _scene}[words[0]](options)
    if len(words) > 1:
        raise SolverError(f"sweep {' '.join(words)}: must be one scene, or one of {', '.join(ACTIONS)} and its argument")
    return _sweep(options)


def _sweep(options: argparse.Namespace) -> int:
    from rsc.results.sweep_store import SweepStore
    from rsc.study.sweep.engines import dask_client
    from rsc.study.sweep.sweep import computed

    store = SweepStore(options.output or Path("out") / f"{Path(options.words[0]).stem}-sweep")
    _refuse_dataset(store, options)
    plan = _planned(options)
    try:
        with dask_client(options.scheduler) if options.scheduler else contextlib.nullcontext() as client:
            how = {"executor": client, "threads": options.threads, "progress": wants_progress(), "note": note}
            data = computed(plan, store, options.resume, **how)
    except KeyboardInterrupt:
        # the threads are left at their parts: what is whole is in the store
        print(f"error: interrupted; rsc sweep ... -o {store.folder} --resume continues it", file=sys.stderr, flush=True)
        os._exit(INTERRUPTED)
    return _told(data, store, options)


def _refuse_dataset(store: "SweepStore", options: argparse.Namespace) -> None:
    """DataError for a sweep.nc that cannot be replaced, before anything is computed."""
    if store.exists:  # else the folder must be empty, which is seen to elsewhere
        target(store.folder / DATASET, HDF5, options.force)


def _planned(options: argparse.Namespace) -> "Plan":
    """The plan that the options ask for."""
    from rsc.study.sweep.plan import make_plan
    from rsc.study.sweep.vary import MOST_CASES, cases

    scene, vary = load(options.words[-1]), {}
    for item in options.vary:
        name, equals, values = (part.strip() for part in item.partition("="))
        if not equals:
            raise SolverError(f"--vary {item}: must be KEY=VALUES")
        if name in vary:
            raise SolverError(f"--vary {name}: must be given once")
        vary[name] = values
    how = {name: getattr(options, name) for name in ("random", "sobol", "seed", "table")}
    most = sys.maxsize if options.yes else MOST_CASES
    with signs_of_life("reading the cases"):
        return make_plan(scene, cases(scene, vary, zipped=options.zip, most=most, **how), options.compute)


def _plan(options: argparse.Namespace) -> int:
    """Write the plan of a sweep whose parts are computed elsewhere."""
    from rsc.results.sweep_store import SweepStore
    from rsc.study.sweep.sweep import planned

    store = SweepStore(options.output or Path("out") / f"{Path(options.words[1]).stem}-sweep")
    count, folder = planned(_planned(options), store, options.resume, note), store.folder
    if options.json:
        print(json.dumps({"store": str(folder), "parts": count}))
        return OK
    print(f"{count} parts: rsc sweep run {folder} --part N, with N from 0 to {count - 1}; then rsc sweep collect {folder}")
    return OK


def _run(options: argparse.Namespace) -> int:
    """Compute some parts of a plan that are not there."""
    from rsc.study.sweep.plan import labels, stored_plan
    from rsc.study.sweep.sweep import compute_parts

    store = _store(options)
    compute_parts(store, _numbers(options.part, len(labels(stored_plan(store)))), note)
    return OK


def _numbers(text: str | None, count: int) -> range:
    """The numbers that "7" or "3-10" name."""
    first, _, last = (text or "").partition("-")
    try:
        numbers = range(int(first), int(last or first) + 1)
    except ValueError:
        numbers = range(0)
    if not numbers or not 0 <= numbers[0] <= numbers[-1] < count:
        raise SolverError(f"--part {text or '(missing)'}: must be a number from 0 to {count - 1}, or A-B")
    return numbers


def _status(options: argparse.Namespace) -> int:
    """How much of a store is there."""
    from rsc.study.sweep.plan import held_labels, labels, stored_plan

    store = _store(options)
    plan = stored_plan(store)
    every, held = labels(plan), held_labels(plan, store)
    missing = _gaps([every.index(label) for label in held], len(every))
    if options.json:
        about = {"cases": len(plan.cases), "dims": plan.cases.dims, "computed": plan.kinds, "versions": plan.versions}
        print(json.dumps({"store": str(store.folder), **about, "parts": len(every), "there": len(held), "missing": missing}))
        return OK
    dims = " x ".join(f"{size} {name}" for name, size in plan.cases.dims.items())
    print(f"{len(plan.cases)} cases ({dims}), {', '.join(plan.kinds)}; made with {plan.versions}")
    print(f"{len(held)} of {len(every)} parts are there" + (f"; missing: {missing}" if missing else ""))
    return OK


def _gaps(numbers: list[int], count: int) -> str:
    """The numbers below a count that are missing among rising ones, as a list of ranges that a batch system understands."""
    pieces: list[str] = []
    after = 0
    for number in [*numbers, count]:
        if number > after:
            pieces.append(str(after) if number == after + 1 else f"{after}-{number - 1}")
        after = number + 1
    return ",".join(pieces)


def _collect(options: argparse.Namespace) -> int:
    """Write the dataset of what a store holds."""
    from rsc.study.sweep.sweep import collected

    store = _store(options)
    _refuse_dataset(store, options)
    return _told(collected(store, note), store, options)


def _scene(options: argparse.Namespace) -> int:
    """Print the scene of one case."""
    from rsc.study.sweep.plan import stored_plan
    from rsc.study.sweep.sweep import scene_of_case

    store = _store(options, 3)
    (number,) = _numbers(options.words[2], len(stored_plan(store).cases))[:1]
    scene = scene_of_case(store, number)
    print(json.dumps(scene.to_dict()) if options.json else scene.to_toml().removesuffix("\n"))
    return OK


def _store(options: argparse.Namespace, count: int = 2) -> "SweepStore":
    from rsc.results.sweep_store import SweepStore

    if len(options.words) != count:
        raise SolverError(f"sweep {' '.join(options.words)}: must be {options.words[0]} STORE{' N' if count == 3 else ''}")
    return SweepStore(options.words[1])


def _told(data: "Labelled", store: "SweepStore", options: argparse.Namespace) -> int:
    """Write the dataset and tell how the cases ended; returns the exit code."""
    from rsc.show.sweeps import words as sweep_words

    path = store.folder / DATASET
    data.save(path, options.force)
    ended = OK if (data["status"] == "finished").all() else SOME_FAILED
    if options.json:
        print(json.dumps({"store": str(store.folder), "dataset": str(path), **sweep_words.plain(data)}))
        return ended
    print(sweep_words.ends(data))
    for line in sweep_words.reasons(data):
        print(line, file=sys.stderr)
    if (data["status"] == "missing").any():
        print("missing cases are computed by --resume, or by `rsc sweep run` of their parts", file=sys.stderr)
    if danger := sweep_words.dangers(data):
        print(danger)
    if severity := sweep_words.severities(data):
        print(severity)
    print(f"written: {path}")
    return ended
