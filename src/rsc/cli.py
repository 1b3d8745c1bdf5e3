"""The command line: arguments in, calls, tables out, exit codes. A command imports what it needs: `rsc --help` is quick."""

import argparse
import contextlib
import json
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from rsc.errors import DataError, RscError, SceneError, WriteError
from rsc.scene.templates import MODELS, template

if TYPE_CHECKING:
    from rsc.results.summary import Summary
    from rsc.scene.scene import Scene

OK, BAD_INPUT, NUMERICS, DISK, INTERRUPTED = 0, 2, 3, 4, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code: 0 done, 2 bad input, 3 numerics stopped, 4 file or disk, 130 interrupted."""
    options = _parser().parse_args(arguments)
    try:
        with _sigterm_as_ctrl_c(), _warnings_in_one_line():
            return _run_in_one_thread(options)
    except WriteError as error:
        _refused(error, DISK)
        _leave(DISK)
    except DataError as error:
        return _refused(error, DISK)
    except RscError as error:
        return _refused(error, BAD_INPUT)
    except KeyboardInterrupt as stop:
        if not hasattr(stop, "result"):
            return _refused("interrupted", INTERRUPTED)
        _print_summary(stop.result.summary, options)
        return _code(stop.result.summary)
    except BrokenPipeError:
        sys.stderr.close()
        return OK


def _run_in_one_thread(options: argparse.Namespace) -> int:
    from rsc.system.blas import one_thread

    with one_thread:
        return options.run(options)


@contextlib.contextmanager
def _warnings_in_one_line() -> Iterator[None]:
    """Python would add the place and its source to a warning."""
    before = warnings.formatwarning
    warnings.formatwarning = lambda message, *_, **__: f"rsc: {message}\n"
    try:
        yield
    finally:
        warnings.formatwarning = before


@contextlib.contextmanager
def _sigterm_as_ctrl_c() -> Iterator[None]:
    """A job scheduler's signal ends a command as Ctrl-C does: the run so far is saved and reported, exit code 130."""
    before = signal.getsignal(signal.SIGTERM)
    replaced = before is signal.SIG_DFL and threading.current_thread() is threading.main_thread()
    if replaced:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        if replaced:
            signal.signal(signal.SIGTERM, before)


def _leave(code: int) -> NoReturn:
    """End the process without the clean-up in which HDF5 would crash on a file that it could not write."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _refused(error: object, code: int) -> int:
    print(f"error: {error}", file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="rsc", description="Rotor-stator contact: backward whirl simulated and predicted.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, run: Callable[[argparse.Namespace], int], text: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=text, description=text)
        sub.set_defaults(run=run)
        return sub

    check = command("check", _check, "simulate, predict and compare; write result, pictures and verdict table")
    check.add_argument("scene", metavar="SCENE")
    check.add_argument("-o", "--output", metavar="DIR", help="folder for result and pictures (default out/SCENE)")
    simulate = command("run", _run, "simulate only")
    simulate.add_argument("scene", metavar="SCENE")
    simulate.add_argument("-o", "--output", metavar="FILE", help="result file (default SCENE.h5)")
    simulate.add_argument("--resume", action="store_true", help="continue an interrupted or killed run bit for bit")
    text = "resume also with other versions or on another processor: other bits from there on, and the result says so"
    simulate.add_argument("--not-bitwise", action="store_true", help=text)
    predict = command("predict", _predict, "analytic only: branches over the run's speeds, or the whirls at given speeds")
    predict.add_argument("scene", metavar="SCENE")
    predict.add_argument("--speed", metavar="HZ", type=_speed, nargs="+", help="a table of the whirls at these rotor speeds")
    predict.add_argument("-o", "--output", metavar="FILE", help="draw the map of the branches into this picture")
    plot = command("plot", _plot, "pictures of results; runs of one scene share the amplitude picture")
    plot.add_argument("results", metavar="RESULT", nargs="+")
    plot.add_argument("-o", "--output", metavar="DIR", default=".", help="folder for the pictures")
    info = command("info", _info, "what a result holds and how its run ended")
    info.add_argument("result", metavar="RESULT")
    verify = command("verify", _verify, "run a slice of a result again from its checkpoint and compare the bits")
    verify.add_argument("result", metavar="RESULT")
    verify.add_argument("--block", type=int, default=-1, metavar="N", help="which block of samples (default: the last)")
    new = command("new", _new, "print a commented scene to start from")
    new.add_argument("model", choices=MODELS, metavar="MODEL", help=", ".join(MODELS))
    _import_parser(command("import", _import, "a finite-element model into a scene: the rotor of ROSS, or matrices"))
    for sub in (check, simulate, predict, info):
        sub.add_argument("--json", action="store_true", help="print JSON instead of a table")
    return parser


def _import_parser(parser: argparse.ArgumentParser) -> None:
    """Options of `rsc import ross` and `rsc import fe`."""
    kinds = parser.add_subparsers(required=True, metavar="KIND", dest="kind")
    ross = kinds.add_parser("ross", help="the file of ROSS's rotor.save_mat")
    ross.add_argument("model", metavar="MODEL.mat")
    fe = kinds.add_parser("fe", help="matrix files of any finite-element program")
    text = "file, or FILE:NAME for one of several matrices in it"
    for name, needed in (("mass", True), ("stiffness", True), ("damping", False), ("gyroscopic", False)):
        fe.add_argument(f"--{name}", metavar="FILE", required=needed, help=text)
    fe.add_argument("--coordinates", metavar="TABLE.csv", help="node and direction (x, y, rx, ry, other) of every row")
    fe.add_argument("--units", choices=("m", "mm"), help="mm: mm, N, t, s (default: SI, refused where it looks like the latter)")
    fe.add_argument("--axis", choices=("x", "y", "z"), default="z", help="axis of the rotor in files that carry directions")
    fe.add_argument("--stator", action="store_true", help="the body is a stator; the output is an .npz")
    for sub in (ross, fe):
        sub.add_argument("-o", "--output", metavar="FILE", required=True, help="scene to begin with (.toml), or the model (.npz)")
        sub.add_argument("--contact", metavar="NODE", required=True, help="node at the contact, or NODE,NODE,SHARE between two")
        sub.add_argument("--unbalance", metavar="NODE", help="node of the unbalance (default: that of the contact)")
        sub.add_argument("--speed", metavar="HZ", type=_speed, help="rotor speed at which bearing coefficients were taken")


def _speed(text: str) -> float:
    """A rotor speed in Hz from "50" or "3000 rpm"."""
    from rsc.scene.units import QuantityError, quantity

    try:
        return float(text)  # whether a rotor can have it is for the command to say
    except ValueError as no_number:
        try:
            return quantity(text, "frequency")
        except QuantityError as error:
            raise argparse.ArgumentTypeError(f"{text!r} {error}") from no_number


def _import(options: argparse.Namespace) -> int:
    from rsc.machine.importing import import_fe
    from rsc.machine.ross import read_ross
    from rsc.study.import_model import import_model

    parts = options.contact.split(",")
    contact = options.contact if len(parts) != 3 else (parts[0], parts[1], float(parts[2]))
    if options.kind == "ross":
        model = read_ross(options.model, options.speed)
    else:
        roles = ("mass", "stiffness", "damping", "gyroscopic")
        matrices: dict[str, Any] = {name: _matrix(getattr(options, name)) for name in roles}
        more = {"units": options.units, "axis": options.axis} | ({} if options.speed is None else {"speed": options.speed})
        node = contact if isinstance(contact, str) else contact[0]
        model = import_fe(**matrices, coordinates=options.coordinates, contact=node, stator=options.stator, **more)
    print(import_model(model, options.output, contact, options.unbalance))
    return OK


def _matrix(text: str | None) -> str | tuple[str, str] | None:
    """A file, or (file, name) of FILE:NAME."""
    if text is None or ":" not in text or Path(text).exists():
        return text
    file, _, name = text.rpartition(":")
    return file, name


def _check(options: argparse.Namespace) -> int:
    from rsc.show.report_pictures import draw
    from rsc.show.text import report_plain, report_text
    from rsc.study.check import check

    scene = _load(options.scene)
    folder = _folder(options.output or Path("out") / Path(options.scene).stem)
    report = check(scene, progress=_wants_progress(), path=folder / "result.h5", note=_note)
    pictures = draw(report, folder)
    (folder / "report.json").write_text(json.dumps(report_plain(report), indent=1))
    if options.json:
        print(json.dumps(report_plain(report)))
    else:
        print(report_text(report))
        print("\nwritten: " + ", ".join(str(path) for path in (folder / "result.h5", folder / "report.json", *pictures)))
    return _code(report.result.summary)


def _run(options: argparse.Namespace) -> int:
    from rsc.study.simulate import simulate

    scene = _load(options.scene)
    path = Path(options.output or f"{Path(options.scene).stem}.h5")
    if path.resolve() == Path(options.scene).resolve():
        raise SceneError(options.scene, "--output", str(path), "another file than the scene")
    resuming = {"resume": options.resume, "bitwise": not options.not_bitwise}
    result = simulate(scene, progress=_wants_progress(), path=path, note=_note, **resuming)
    _print_summary(result.summary, options, f"\nwritten: {path}")
    return _code(result.summary)


def _predict(options: argparse.Namespace) -> int:
    from rsc.show.text import survey_plain, survey_text, whirls_plain, whirls_text

    scene = _load(options.scene)
    if options.speed:
        from rsc.analysis.force_ratio import ratios_of
        from rsc.analysis.predict import predict
        from rsc.analysis.remarks import rolling_remarks, scene_remarks, whirl_remarks
        from rsc.study.reductions import reduction_remarks
        from rsc.system.assemble import assemble

        lists, system = predict(scene, speed=options.speed), assemble(scene)
        remarks = [
            scene_remarks(system, whirls)
            + whirl_remarks(system, whirls)
            + rolling_remarks(system, speed)
            + reduction_remarks(scene, (whirl for whirl in whirls if whirl.stable))
            for speed, whirls in zip(options.speed, lists, strict=True)
        ]
        ratios = [ratios_of(system, whirls) for whirls in lists]
        texts = [whirls_text(whirls, scene.contact.gap, *more) for whirls, *more in zip(lists, remarks, ratios, strict=True)]
        plains = [whirls_plain(*pair) for pair in zip(lists, ratios, strict=True)]
        print(json.dumps(plains) if options.json else "\n\n".join(texts))
        return OK
    from rsc.analysis.survey import survey
    from rsc.study.reductions import reduction_remarks

    prediction = survey(scene)
    prediction.remarks.extend(reduction_remarks(scene, (b.whirls[0] for b in prediction.branches if b.stable.any())))
    print(json.dumps(survey_plain(prediction)) if options.json else survey_text(prediction))
    if options.output:
        from rsc.show import plots
        from rsc.show.report_pictures import branch_map

        plots.save(branch_map(prediction), options.output)
        print(f"written: {options.output}", file=sys.stderr)
    return OK


def _plot(options: argparse.Namespace) -> int:
    from rsc.results.trajectory import load
    from rsc.show import plots
    from rsc.show.report_pictures import amplitude, draw
    from rsc.study.check import report

    folder = _folder(options.output)
    reports = [report(load(path)) for path in options.results]
    written = []
    for path, run_report in zip(options.results, reports, strict=True):
        subfolder = folder if len(reports) == 1 else _folder(folder / f"{Path(path).parent.name}_{Path(path).stem}")
        written += draw(run_report, subfolder)
    if len(reports) > 1:
        written.append(folder / "amplitude.png")
        plots.save(amplitude(reports, reports[0].result.scene.title), written[-1])
    print("written: " + ", ".join(str(path) for path in written))
    return OK


def _info(options: argparse.Namespace) -> int:
    from rsc.results.trajectory import load
    from rsc.show.text import plain, run_text

    result = load(options.result)
    if options.json:
        print(json.dumps({"scene": result.scene.to_dict(), "summary": plain(result.summary)}))
        return OK
    print(f"{result.scene.title}\n{run_text(result.summary)}")
    print(f"{len(result.time)} samples; made with {result.summary.versions}")
    if result.summary.advice:
        print(f"advice: {result.summary.advice}")
    return OK


def _verify(options: argparse.Namespace) -> int:
    from rsc.results.result_file import read_summary
    from rsc.show.text import run_text
    from rsc.simulation.run import versions
    from rsc.study.verify import verify

    verification = verify(options.result, options.block)
    print(run_text(read_summary(options.result)))
    print(f"scene sha256 {verification.scene_hash}; made with {verification.versions}")
    answer = "the same bits" if verification.same else f"other bits in {', '.join(verification.differing)}"
    if verification.versions != versions():
        answer += f"; this is {versions()}"
    print(f"rows {verification.first} to {verification.last - 1} run again: {answer}")
    return OK if verification.same else NUMERICS


def _new(options: argparse.Namespace) -> int:
    print(template(options.model), end="")
    return OK


def _print_summary(summary: "Summary", options: argparse.Namespace, more: str = "") -> None:
    from rsc.show.text import plain, run_text

    print(json.dumps(plain(summary)) if options.json else run_text(summary) + more)


def _load(path: str) -> "Scene":
    from rsc.scene.scene import load_scene

    return load_scene(path)


def _folder(path: str | os.PathLike[str]) -> Path:
    """The folder, made when missing and proved writable before anything is computed."""
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / ".rsc-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise DataError(path, f"cannot be written ({error.strerror})") from None
    return path


def _wants_progress() -> bool:
    return sys.stderr.isatty()


def _note(text: str) -> None:
    print(f"rsc: {text}", file=sys.stderr, flush=True)


def _code(summary: "Summary") -> int:
    if summary.advice:
        print(f"rsc: {summary.advice}", file=sys.stderr)
    return {"finished": OK, "interrupted": INTERRUPTED}.get(str(summary.status), NUMERICS)
