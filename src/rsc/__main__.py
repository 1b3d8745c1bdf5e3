"""`python -m rsc` and `rsc` are the command line; an interrupt while its parts are loaded is one as well."""

import _thread
import signal
import sys
import threading
from typing import Any

INTERRUPTED = 130


def entry() -> int:
    """Run the command line from its first import on; returns the exit code."""
    sys.unraisablehook = _again
    try:
        from rsc.cli import main

        return main()
    except BaseException as error:
        if not _interrupted(error):
            raise
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        if sys.stderr is not None:
            print("error: interrupted", file=sys.stderr)
        return INTERRUPTED


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
    else:
        sys.__unraisablehook__(unraisable)


if __name__ == "__main__":
    sys.exit(entry())
