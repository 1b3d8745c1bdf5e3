"""The mark in a file that rsc wrote: a SHA-256 of all the rest of the file.

By it rsc knows later that it wrote the file and that nobody has changed it since; only then it may be replaced. Each format has
the mark where its readers pass over it. A table as CSV has no such place: its mark is a small hidden file next to it.
"""

import hashlib
import re
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import BinaryIO

_TOLD = "Written by rsc, which replaces this file only if nothing else in it was changed: sha256"
_NO_DIGEST = "0" * 64
_PIECE = 2**20  # bytes that are read at once
_BESIDE = re.compile(rb"[^\n]{1,200}: written by rsc, sha256 ([0-9a-f]{64})\n")


@dataclass(frozen=True)
class Format:
    """Where the files of a format carry the mark.

    piece : function of the digest, the bytes of the mark; None for a mark in a file of its own
    behind : int, bytes of the format that stand behind the mark
    ready : function of the content without mark, which makes room for one
    """

    piece: Callable[[str], bytes] | None
    behind: int = 0
    ready: Callable[[bytes], bytes] = bytes

    def marked(self, content: bytes) -> bytes:
        """The content of a file with the mark."""
        if self.piece is None:
            return content
        content = self.ready(content)
        place = len(content) - self.behind
        return content[:place] + self.piece(hashlib.sha256(content).hexdigest()) + content[place:]

    def is_marked(self, file: BinaryIO, size: int) -> bool:
        """Whether an open file of this size carries the mark of its content."""
        if self.piece is None:
            return False
        before = size - self.behind - len(self.piece(_NO_DIGEST))
        if before < 0:
            return False
        digest = _digest_of(file, before)
        mark, behind = file.read(size - self.behind - before), file.read(self.behind)
        digest.update(behind)
        return mark == self.piece(digest.hexdigest())


def _digest_of(file: BinaryIO, count: int) -> "hashlib._Hash":
    """SHA-256 of the next so many bytes of a file."""
    digest = hashlib.sha256()
    while count > 0 and (part := file.read(min(count, _PIECE))):
        digest.update(part)
        count -= len(part)
    return digest


def name_beside(name: str) -> str:
    """Name of the file with the mark of a file that has no place for it."""
    return f".{name}.rsc"


def text_beside(name: str, content: bytes) -> bytes:
    """What the file with the mark of another one holds."""
    shown = "".join(c if c.isprintable() else "?" for c in name)[:50]
    return f"{shown}: written by rsc, sha256 {hashlib.sha256(content).hexdigest()}\n".encode("utf-8", "replace")


def digest_beside(text: bytes) -> str | None:
    """The digest that a file with the mark of another one holds; None of any other file."""
    whole = _BESIDE.fullmatch(text)
    return whole[1].decode() if whole else None


def is_of(digest: str, file: BinaryIO, size: int) -> bool:
    """Whether an open file has this digest."""
    return _digest_of(file, size).hexdigest() == digest


def _line(comment: str) -> Callable[[str], bytes]:
    return lambda digest: comment.format(f"{_TOLD} {digest}").encode()


def _chunk(digest: str) -> bytes:
    """A text chunk of a PNG."""
    content = b"tEXt" + b"Comment\0" + f"{_TOLD} {digest}".encode()
    return struct.pack(">I", len(content) - 4) + content + struct.pack(">I", zlib.crc32(content))


def _extension(digest: str) -> bytes:
    """A comment of a GIF."""
    text = f"{_TOLD} {digest}".encode()
    return b"\x21\xfe" + bytes([len(text)]) + text + b"\0"


def _with_room_for_a_comment(archive: bytes) -> bytes:
    """An archive whose end foretells the length of the comment that will follow."""
    return archive[:-2] + struct.pack("<H", len(ZIP.piece(_NO_DIGEST)))  # type: ignore[misc]


PNG = Format(_chunk, behind=12)  # the last chunk
GIF = Format(_extension, behind=1)  # its last byte
PDF = Format(_line("% {}\n"))
SVG = HTML = Format(_line("<!-- {} -->\n"))
TOML = Format(_line("# {}\n"))
JSON = Format(_line(', "mark": "{}"'), behind=1)  # of an object that is not empty
HDF5 = Format(_line("\n{}\n"))  # behind what HDF5 counts as the file
ZIP = Format(_line("{}"), ready=_with_room_for_a_comment)  # the comment of the archive
CSV = Format(None)
PICTURES = {".png": PNG, ".pdf": PDF, ".svg": SVG}
