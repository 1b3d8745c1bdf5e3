"""Standard output and error of a command: control characters are escaped, and a failing stream does not end a run."""

import contextlib
import errno
import io
import os
import sys
import unicodedata
from collections.abc import Callable, Iterator
from typing import TextIO

_STEERING = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}  # Unicode categories: controls, directions of writing, line ends, none


class Plain(io.TextIOBase):
    """A stream that escapes control characters and what cannot be encoded, and goes silent if writing fails.

    stream : TextIO or None (closed when the program began)
    steering : str, allowed control characters
    failure : OSError or None, why it went silent; a broken pipe does not count
    """

    def __init__(self, stream: TextIO | None, steering: str) -> None:
        self._stream, self._steering = stream, steering
        self.failure: OSError | None = None

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Of the stream."""
        return getattr(self._stream, "encoding", None) or "utf-8"

    def isatty(self) -> bool:
        """Whether it is a terminal."""
        return self._stream is not None and self._stream.isatty()

    def fileno(self) -> int:
        """Of the stream; OSError without one."""
        if self._stream is None:
            raise OSError(errno.EBADF, "closed")
        return self._stream.fileno()

    def write(self, text: str) -> int:
        """Write a text; returns its length, written or not."""
        if self._stream is not None:
            clean = "".join(c if self._may_pass(c) else c.encode("unicode_escape").decode() for c in text)
            clean = clean.encode(self.encoding, "backslashreplace").decode(self.encoding, "replace")
            self._try(lambda stream: stream.write(clean))
        return len(text)

    def flush(self) -> None:
        """Flush the stream."""
        self._try(lambda stream: stream.flush())

    def _may_pass(self, c: str) -> bool:
        return c in self._steering or unicodedata.category(c) not in _STEERING

    def _try(self, act: Callable[[TextIO], object]) -> None:
        stream = self._stream
        if stream is None:
            return
        try:
            act(stream)
        except (OSError, ValueError) as error:  # ValueError: it was closed
            self._stream = None
            if isinstance(error, OSError) and not isinstance(error, BrokenPipeError):
                self.failure = error
            # else Python itself would try again to write the rest when it ends
            with contextlib.suppress(OSError, ValueError):
                nowhere = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nowhere, stream.fileno())
                os.close(nowhere)


@contextlib.contextmanager
def plain_streams() -> Iterator[Plain]:
    """Standard output and error as `Plain`; yields standard output."""
    before = sys.stdout, sys.stderr
    out = Plain(sys.stdout, "\n\t")
    sys.stdout, sys.stderr = out, Plain(sys.stderr, "\n\t\r")  # a progress bar begins its line anew
    try:
        yield out
    finally:
        sys.stdout, sys.stderr = before


def open_standard_files() -> None:
    """Open closed descriptors 0 to 2 on the null device: otherwise the next opened file would receive the messages."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
