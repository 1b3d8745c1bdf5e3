"""Changes of a file that are held back until all are known: a kill then leaves the file as it was, or as it shall be.

A library that changes a few bytes in many calls leaves a torn file where it is killed between them.
"""

import io
import os
from pathlib import Path
from typing import Any


class HeldBack(io.RawIOBase):
    """A file as a library sees it that reads, changes and lengthens it; on the disk nothing changes before `apply`."""

    def __init__(self, path: Path) -> None:
        self._file = open(path, "r+b", buffering=0)  # noqa: SIM115, closed with this one
        self._before = self._size = os.fstat(self._file.fileno()).st_size
        self._at, self._changes = 0, []  # type: int, list[tuple[int, bytes]]

    def readable(self) -> bool:
        return True

    writable = seekable = readable

    def seek(self, place: int, whence: int = os.SEEK_SET) -> int:
        self._at = place + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._size}[whence]
        return self._at

    def tell(self) -> int:
        return self._at

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        view = view[: max(min(len(view), self._size - self._at), 0)]
        view[:] = self._read(self._at, len(view))
        self._at += len(view)
        return len(view)

    def _read(self, place: int, count: int) -> bytes:
        """So many bytes as they shall be; 0 where nothing was written."""
        self._file.seek(place)
        content = bytearray((self._file.read(count) or b"").ljust(count, b"\0"))
        for start, change in self._changes:
            low, high = max(start, place), min(start + len(change), place + count)
            if low < high:
                content[low - place : high - place] = change[low - start : high - start]
        return bytes(content)

    def write(self, content: Any) -> int:
        change = bytes(content)
        self._changes.append((self._at, change))
        self._at += len(change)
        self._size = max(self._size, self._at)
        return len(change)

    def truncate(self, size: int | None = None) -> int:
        self._size = self._at if size is None else size
        return self._size

    def apply(self) -> None:
        """Make the changes: first what is behind the end, to which nothing refers yet, then all the rest in one call.

        Raises OSError.
        """
        behind = self._read(self._before, self._size - self._before)
        ends = [min(start + len(change), self._before) for start, change in self._changes if start < self._before]
        for place, content in ((self._before, behind), (0, self._read(0, max(ends, default=0)))):
            if content:
                self._file.seek(place)
                self._write(content)
                os.fsync(self._file.fileno())

    def _write(self, content: bytes) -> None:
        """All of it, in one call where the system takes it in one."""
        while content:
            content = content[self._file.write(content) :]

    def close(self) -> None:
        self._file.close()
        super().close()
