"""`rsc run`, `rsc info` and `rsc verify`: one run and its result file."""

import argparse
import json
import os
from pathlib import Path

from rsc.cli.common import JSON, OK, Commands, code, load, note, print_summary, wants_progress
from rsc.errors import DataError, SceneError, one_line


def add(commands: Commands) -> None:
    run = commands("run", run_command, "simulate only")
    run.add_argument("scene", metavar="SCENE")
    run.add_argument("-o", "--output", metavar="FILE", help="result file (default SCENE.h5)")
    run.add_argument("--resume", action="store_true", help="continue an interrupted or killed run bit for bit")
    text = "resume also with other versions or on another processor: other bits from there on, and the result says so"
    run.add_argument("--not-bitwise", action="store_true", help=text)
    run.add_argument("--json", action="store_true", help=JSON)
    info = commands("info", info_command, "what a result holds and how its run ended")
    info.add_argument("result", metavar="RESULT")
    info.add_argument("--json", action="store_true", help=JSON)
    verify = commands("verify", verify_command, "make the run of a result again and compare the bits")
    verify.add_argument("result", metavar="RESULT")
    text = "only this block of samples, from its checkpoint, counted from 0, or from the end when negative (default: everything)"
    verify.add_argument("--block", type=int, metavar="N", help=text)


def run_command(options: argparse.Namespace) -> int:
    from rsc.study.simulate import simulate

    scene = load(options.scene)
    path = Path(f"{Path(options.scene).stem}.h5" if options.output is None else options.output)
    if os.path.exists(path) and path.samefile(options.scene):
        raise SceneError(one_line(options.scene), "--output", str(path), "another file than the scene")
    resuming = {"resume": options.resume, "bitwise": not options.not_bitwise}
    result = simulate(scene, progress=wants_progress(), path=path, note=note, **resuming)
    print_summary(result.summary, options, f"\nwritten: {path}")
    return code(result.summary)


def info_command(options: argparse.Namespace) -> int:
    from rsc.results.trajectory import load
    from rsc.show.text import plain, run_text

    result = load(options.result)
    if options.json:
        print(json.dumps({"scene": result.scene.to_dict(), "summary": plain(result.summary)}))
        return OK
    print(f"{one_line(result.scene.title)}\n{run_text(result.summary)}")
    print(f"{result.n_time} samples; made with {result.summary.versions}")
    if result.summary.advice:
        print(f"advice: {result.summary.advice}")
    return OK


def verify_command(options: argparse.Namespace) -> int:
    from rsc.results.result_file import read_summary
    from rsc.show.text import run_text
    from rsc.simulation.run import versions
    from rsc.study.verify import verify

    verification = verify(options.result, options.block, wants_progress())
    print(run_text(read_summary(options.result)))
    print(f"scene sha256 {verification.scene_hash}; made with {verification.versions}")
    rows = f"rows {verification.first} to {verification.last - 1}" if verification.last > verification.first else "no row"
    elsewhere = f"; this is {versions()}" if verification.versions != versions() else ""
    if not verification.same:
        raise DataError(options.result, f"{rows} run again: other bits in {', '.join(verification.differing)}{elsewhere}")
    scope = "checkpoints, counters and energies as well" if verification.whole else "the rest of the result was not looked at"
    print(f"{rows} run again: the same bits; {scope}{elsewhere}")
    return OK
