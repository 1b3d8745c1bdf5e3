"""What long searches say on the way: a line every two seconds, no more."""

import time
from collections.abc import Callable

EVERY = 2.0  # s

Note = Callable[[str], object]


def silent(text: str) -> None:
    """The note of who wants to hear nothing."""


class Patience:
    """Passes progress texts on to a note: at most one every two seconds, none in the first two.

    note : callable of a line of text
    """

    def __init__(self, note: Note) -> None:
        self._note, self._last = note, time.monotonic()

    def say(self, text: str) -> None:
        """Where the search is."""
        moment = time.monotonic()
        if moment - self._last >= EVERY:
            self._note(text)
            self._last = moment
