"""`rsc run`, `rsc info` and `rsc verify`: one run and its result file."""

import argparse
import json
from pathlib import Path

from rsc.cli.common import FORCE, JSON, OK, Commands, add_units, clearances_plain, code, load, print_summary, refuse_shared
from rsc.cli.progress import note, wants_progress
from rsc.errors import DataError, SceneError, one_line


def add(commands: Commands) -> None:
    run = commands("run", run_command, "simulate without prediction")
    run.add_argument("scene", metavar="SCENE")
    run.add_argument("-o", "--output", metavar="FILE", help="result file (default: SCENE.h5)")
    run.add_argument("--resume", action="store_true", help="continue an interrupted or killed run bit for bit")
    text = "allow resuming with other versions or on another processor: not bit-identical, and marked in the result"
    run.add_argument("--not-bitwise", action="store_true", help=text)
    text = "also write the run as measured by two probes and a Keyphasor, for `rsc.read_measured`: FILE.toml and FILE.csv"
    run.add_argument("--as-measured", metavar="FILE.toml", help=text)
    run.add_argument("--noise", metavar="LENGTH", default="0 um", help="with --as-measured: noise of each probe, e.g. \"2 um\"")
    run.add_argument("--runout", metavar="LENGTH", default="0 um", help="with --as-measured: runout of the shaft, e.g. \"10 um\"")
    run.add_argument("--force", action="store_true", help=FORCE)
    add_units(run)
    run.add_argument("--json", action="store_true", help=JSON)
    info = commands("info", info_command, "print status, counters and energy balance of a result")
    info.add_argument("result", metavar="RESULT")
    add_units(info)
    info.add_argument("--json", action="store_true", help=JSON)
    verify = commands("verify", verify_command, "repeat the run of a result and compare the bits")
    verify.add_argument("result", metavar="RESULT")
    text = "only this block of samples, starting from its checkpoint; 0 is the first, -1 the last (default: everything)"
    verify.add_argument("--block", type=int, metavar="N", help=text)


def run_command(options: argparse.Namespace) -> int:
    from rsc.study.run.simulate import simulate

    scene = load(options.scene)
    path = Path(f"{Path(options.scene).stem}.h5" if options.output is None else options.output)
    measured = () if options.as_measured is None else {Path(options.as_measured), Path(options.as_measured).with_suffix(".csv")}
    refuse_shared("run", [options.scene], [path, *measured])
    probes = _probes(options)
    resuming = {"resume": options.resume, "bitwise": not options.not_bitwise}
    result = simulate(scene, progress=wants_progress(), path=path, note=note, overwrite=options.force, **resuming)
    more = f"\nwritten: {path}"
    if options.as_measured is not None:
        from rsc.measured.virtual import write_measured

        noise, runout = probes["noise"], probes["runout"]
        table = write_measured(result, options.as_measured, noise=noise, runout=runout, overwrite=options.force)
        more += f", {table}, {table.with_suffix('.csv')}"
    print_summary(result, options, more)
    return code(result.summary)


def _probes(options: argparse.Namespace) -> dict[str, float]:
    """Noise and runout in m, checked before anything is computed."""
    from rsc.measured.virtual import targets
    from rsc.units import QuantityError, quantity

    lengths = {}
    for name in ("noise", "runout"):
        try:
            lengths[name] = quantity(getattr(options, name), "length")
        except QuantityError as error:
            raise SceneError("run", f"--{name}", getattr(options, name), error.wanted, error.hint) from None
        if not 0.0 <= lengths[name] <= 1.0:
            raise SceneError("run", f"--{name}", getattr(options, name), "a length from 0 to 1 m")
    if options.as_measured is None and any(lengths.values()):
        raise SceneError("run", "--as-measured", None, "given with --noise and --runout")
    if options.as_measured is not None:
        targets(options.as_measured, options.force)
    return lengths


def info_command(options: argparse.Namespace) -> int:
    from rsc.results.trajectory import load
    from rsc.show.words.plain import plain
    from rsc.show.words.text import result_text
    from rsc.show.words.units import prefer

    result = load(options.result)
    prefer(result.scene)
    if options.json:
        own = {"scene": result.scene.to_dict(), "summary": plain(result.summary)}
        print(json.dumps(own | clearances_plain(result)))
        return OK
    print(f"{one_line(result.scene.title)}\n{result_text(result)}")
    print(f"{result.n_time} samples; made with {result.summary.versions}")
    if result.summary.advice:
        print(f"advice: {result.summary.advice}")
    return OK


def verify_command(options: argparse.Namespace) -> int:
    from rsc.results.result_file import read_summary
    from rsc.show.words.text import run_text
    from rsc.simulation.run import versions
    from rsc.study.run.verify import verify

    verification = verify(options.result, options.block, wants_progress())
    print(run_text(read_summary(options.result)))
    print(f"scene sha256 {verification.scene_hash}; made with {verification.versions}")
    rows = f"rows {verification.first} to {verification.last - 1}" if verification.last > verification.first else "no row"
    elsewhere = f"; this is {versions()}" if verification.versions != versions() else ""
    if not verification.same:
        raise DataError(options.result, f"{rows} repeated: different bits in {', '.join(verification.differing)}{elsewhere}")
    scope = "checkpoints, counters and energies as well" if verification.whole else "the rest of the result was not checked"
    print(f"{rows} repeated: identical bits; {scope}{elsewhere}")
    return OK
