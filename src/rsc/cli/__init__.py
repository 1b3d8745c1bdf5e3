"""The command line: arguments in, calls, tables out, exit codes.

Each command has a module with `add`, its options, and a function of them that returns the exit code. A command imports what it
needs when it runs: `rsc --help` is quick.
"""

import argparse
import contextlib
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import NoReturn

from rsc.cli import (
    check,
    compare,
    completion,
    explore,
    fit,
    impact,
    import_model,
    limits,
    modes,
    motions,
    new,
    plot,
    predict,
    remedy,
    report,
    run,
    sweep,
)
from rsc.cli.common import BAD_INPUT, DISK, INTERRUPTED, code, print_summary
from rsc.cli.parser import MainParser, Parser
from rsc.cli.progress import told
from rsc.cli.streams import open_standard_files, plain_streams
from rsc.errors import DataError, RscError, SolverError, WriteError
from rsc.operating_system import SENT_TWICE, STOPS, address_space

COMMANDS = (
    check, compare, fit, run, predict, modes, limits, motions, remedy, report, sweep, impact, plot, new, import_model, completion,
    explore,
)  # fmt: skip
LEAST_ADDRESS_SPACE = 1e9  # bytes; compiling the kernel takes most of it


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code: 0 done, 2 bad input, 3 numerics stopped, 4 file or disk, 5 some cases of a sweep
    failed, 130 interrupted.

    If the reader of the output goes away (broken pipe), the command continues and writes its files.
    """
    open_standard_files()
    with plain_streams() as out:
        try:
            ended = _ended(_parser().parse_args(arguments))
        finally:
            out.flush()
            if out.failure is not None:
                _refused(f"standard output: {str(out.failure.strerror).lower()}", DISK)
                raise SystemExit(DISK)
        return ended


def _ended(options: argparse.Namespace) -> int:
    """Run the command of the options; returns the exit code."""
    try:
        _refuse_little_address_space()
        with _stops_as_ctrl_c(), _warnings_in_one_line():
            return _run_in_one_thread(options)
    except WriteError as error:
        _refused(error, DISK)
        _leave(DISK)
    except DataError as error:
        return _refused(error, DISK)
    except RscError as error:
        return _refused(error, BAD_INPUT)
    except MemoryError:
        return _refused("not enough memory", BAD_INPUT)
    except KeyboardInterrupt as stop:
        if not hasattr(stop, "result"):
            return _refused("interrupted", INTERRUPTED)
        print_summary(stop.result, options)
        return code(stop.result.summary)


def _run_in_one_thread(options: argparse.Namespace) -> int:
    if "numpy" not in sys.modules:
        # read by NumPy and by SciPy when they are loaded; one that is loaded already could only be told by loading the other, too
        os.environ["OPENBLAS_NUM_THREADS"] = "1"
        return _run(options)
    from rsc.system.blas import one_thread

    with one_thread:
        return _run(options)


def _run(options: argparse.Namespace) -> int:
    """Run the command, in the units that it is to show."""
    with told(options.quiet):
        return _run_in_units(options)


def _run_in_units(options: argparse.Namespace) -> int:
    if not hasattr(options, "units"):
        return options.run(options)
    from rsc.show.words.units import shown_in

    with shown_in(options.units):
        return options.run(options)


def _refuse_little_address_space() -> None:
    """Libraries of compiled code end the process, or never end, where they cannot get their memory."""
    allowed = address_space()
    if allowed is not None and allowed < LEAST_ADDRESS_SPACE:
        sizes = f"{LEAST_ADDRESS_SPACE / 1e6:.0f} MB of address space and {allowed / 1e6:.0f} MB are allowed"
        raise SolverError(f"a command needs {sizes} (ulimit -v)")


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
def _stops_as_ctrl_c() -> Iterator[None]:
    """A signal of a job scheduler, or of a terminal that is closed, ends a command as Ctrl-C does: what was found so far is saved
    and told, exit code 130."""
    in_main = threading.current_thread() is threading.main_thread()
    replaced = [number for number in STOPS if in_main and signal.getsignal(number) is signal.SIG_DFL]
    for number in replaced:
        signal.signal(number, _stop_once if number in SENT_TWICE else signal.default_int_handler)
    try:
        yield
    finally:
        for number in replaced:
            signal.signal(number, signal.SIG_DFL)


def _stop_once(number: int, frame: object) -> None:
    """A handler as that of Ctrl-C, but for a signal that comes twice."""
    signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt


def _leave(code: int) -> NoReturn:
    """End the process without the clean-up in which HDF5 would crash on a file that it could not write."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _refused(error: object, code: int) -> int:
    print(f"error: {error}", file=sys.stderr)
    return code


class _Version(argparse.Action):
    """What `result.summary.versions` would say of a run made now; asked for only here, because it imports the kernel."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from rsc.simulation.run import versions

        print(versions())
        parser.exit()


def _parser() -> MainParser:
    parser = MainParser(prog="rsc", description="Rotor-stator contact: backward whirl simulated and predicted.")
    text = "print the versions of rsc, Python and libraries, and the processor: all that the bits of a run depend on"
    parser.add_argument("--version", action=_Version, nargs=0, help=text)
    parser.commands = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=Parser)

    def commands(name: str, run: Callable[[argparse.Namespace], int], text: str) -> argparse.ArgumentParser:
        sub = parser.commands.add_parser(name, help=text, description=text)
        sub.add_argument("-q", "--quiet", action="store_true", help="no progress and no notes: only the answer and errors")
        sub.set_defaults(run=run, parser=sub)
        return sub

    for module in COMMANDS:
        module.add(commands)
    return parser
