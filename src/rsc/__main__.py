"""`python -m rsc` and `rsc` are the command line: whatever happens, from its first import on, ends in one line."""

import _thread
import contextlib
import os
import signal
import sys
import threading
import traceback
from types import TracebackType
from typing import Any

FAULT, INTERRUPTED = 1, 130


def entry() -> int:
    """Run the command line from its first import on; returns the exit code, 1 for an error that nobody foresaw."""
    sys.unraisablehook, sys.excepthook = _again, _hook
    code = _ended()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the command has ended as it has: only Python's own end is left
    if code == INTERRUPTED:  # Python would end by the signal where the interrupt came through compiled code
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(AttributeError, OSError, ValueError):  # closed, full
                stream.flush()
        os._exit(code)
    return code


def _ended() -> int:
    try:
        from rsc.cli import main

        return main()
    except BaseException as error:
        if _interrupted(error):
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            return _last_line("interrupted", INTERRUPTED)
        if not isinstance(error, Exception):
            raise
        return _last_line(_unforeseen(error), FAULT)


def _last_line(text: str, code: int) -> int:
    if sys.stderr is not None:
        with contextlib.suppress(OSError, ValueError):
            print(f"error: {text}", file=sys.stderr)
    return code


def _unforeseen(error: Exception) -> str:
    """What was raised, and the last place in rsc on the way there: all that is needed to find a fault of ours."""
    places = [(frame.filename, frame.lineno) for frame in traceback.extract_tb(error.__traceback__)]
    own = os.path.dirname(os.path.abspath(__file__))
    file, line = next((place for place in reversed(places) if place[0].startswith(own)), places[-1])
    text = "".join(c if c.isprintable() else " " for c in f"{type(error).__name__}: {error}"[:500])
    return f"unforeseen {text} ({os.path.relpath(file, own)}, line {line}): a fault of rsc, or a library or setting it cannot use"


def _interrupted(error: BaseException | None) -> bool:
    """Whether an interrupt is behind an error: compiled code turns one into an error of its own."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _again(unraisable: Any) -> None:
    """An interrupt that falls where Python cannot raise it, inside a callback, comes again a moment later."""
    if isinstance(unraisable.exc_value, KeyboardInterrupt):
        later = threading.Timer(0.02, _thread.interrupt_main)  # here it would be lost once more
        later.daemon = True
        later.start()
    elif not _of_a_lost_file(unraisable.exc_value):
        sys.__unraisablehook__(unraisable)


def _hook(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """For what libraries print by themselves: everything else is caught above."""
    if not _of_a_lost_file(error):
        sys.__excepthook__(kind, error, trace)


def _of_a_lost_file(error: BaseException | None) -> bool:
    """Whether HDF5, cleaning up, tells once more that a file could not be written, which has its own line."""
    return isinstance(error, RuntimeError) and "Can't decrement id ref count" in str(error)


if __name__ == "__main__":
    sys.exit(entry())
