"""Notes and progress of a command on standard error.

A note is a line that stays. Progress is a single line with stage, share and time left, which is rewritten on a terminal and
removed at the end; into a pipe or a file it is not written. `--quiet` suppresses both.
"""

import contextlib
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar

EVERY = 0.5  # s between two states of the line while nothing is told

_QUIET: ContextVar[bool] = ContextVar("quiet", default=False)


@contextlib.contextmanager
def told(quiet: bool) -> Iterator[None]:
    """Suppress notes and progress within the block if quiet."""
    before = _QUIET.set(quiet)
    try:
        yield
    finally:
        _QUIET.reset(before)


def wants_progress() -> bool:
    """Whether standard error is a terminal and progress is not suppressed."""
    return sys.stderr.isatty() and not _QUIET.get()


def note(text: str) -> None:
    """Print a note: a line that stays."""
    if not _QUIET.get():
        if wants_progress():
            _clear()
        _write(f"rsc: {text}\n")


class ProgressLine:
    """The line of one stage.

    stage : name of the stage
    """

    def __init__(self, stage: str) -> None:
        self._stage, self._began, self._text, self._share = stage, time.monotonic(), "", 0.0

    def say(self, text: str) -> None:
        """Show the current step of the stage."""
        self._text = text
        self.show()

    def count(self, ended: int, of: int, unit: str) -> None:
        """Show how many of a number of items are done."""
        self._share = ended / of if of else 0.0
        self.say(f"{ended} of {of} {unit}")

    def show(self) -> None:
        """Rewrite the line."""
        took = time.monotonic() - self._began
        left = f", {_span(took * (1.0 - self._share) / self._share)} left" if self._share > 0.0 else ""
        share = f" {100.0 * self._share:.0f} %" if self._share > 0.0 else ""
        text = f"rsc: {self._stage}{share} ({_span(took)}{left})" + (f": {self._text}" if self._text else "")
        width = _width()
        _write("\r" + text[:width].ljust(width))


@contextlib.contextmanager
def line(stage: str) -> Iterator[ProgressLine | None]:
    """Yield the line of a stage, rewritten every half second; None without a terminal."""
    if not wants_progress():
        yield None
        return
    shown, ended = ProgressLine(stage), threading.Event()

    def beat() -> None:
        while not ended.wait(EVERY):
            shown.show()

    pulse = threading.Thread(target=beat, daemon=True)
    pulse.start()
    try:
        yield shown
    finally:
        ended.set()
        pulse.join()
        _clear()


@contextlib.contextmanager
def signs_of_life(stage: str = "analysis") -> Iterator[Callable[[str], None]]:
    """Yield a function that shows the current step of a stage."""
    with line(stage) as shown:
        yield (lambda text: None) if shown is None else shown.say


@contextlib.contextmanager
def shown_runs(unit: str = "runs") -> Iterator[Callable[[int, int], object]]:
    """Yield a function of (done, total) that shows the progress of short runs or other units."""
    with line("simulation") as shown:
        yield lambda ended, of: None if shown is None else shown.count(ended, of, unit)


def _span(seconds: float) -> str:
    """A duration in words."""
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.0f} h"


def _width() -> int:
    """Columns that a line may take without being wrapped."""
    return shutil.get_terminal_size().columns - 1


def _clear() -> None:
    _write("\r" + " " * _width() + "\r")


def _write(text: str) -> None:
    print(text, end="", file=sys.stderr, flush=True)  # at once: an analysis has a second thread that tells
