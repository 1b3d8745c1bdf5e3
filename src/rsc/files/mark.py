"""The mark in a file written by rsc: a SHA-256 of the rest of the file.

It shows that rsc wrote the file and nobody has changed it since; only then it may be replaced. Each format has the mark where its
readers skip it. A CSV table has no such place: its mark is a small hidden file next to it.
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
_PIECE = 2**20  # bytes read at a time
_BESIDE = re.compile(rb"[^\n]{1,200}: written by rsc, sha256 ([0-9a-f]{64})\n")


@dataclass(frozen=True)
class Format:
    """Where files of a format contain the mark.

    piece : function of the digest that returns the bytes of the mark; None for a mark in a separate file
    behind : int, bytes of the format after the mark
    ready : function that prepares the content without mark for one
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
        """Whether an open file of this size contains the mark of its content."""
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
    """SHA-256 of the next `count` bytes of a file."""
    digest = hashlib.sha256()
    while count > 0 and (part := file.read(min(count, _PIECE))):
        digest.update(part)
        count -= len(part)
    return digest


def name_beside(name: str) -> str:
    """Name of the separate file with the mark of a file."""
    return f".{name}.rsc"


def text_beside(name: str, content: bytes) -> bytes:
    """Content of the separate file with the mark of another one."""
    shown = "".join(c if c.isprintable() else "?" for c in name)[:50]
    return f"{shown}: written by rsc, sha256 {hashlib.sha256(content).hexdigest()}\n".encode("utf-8", "replace")


def digest_beside(text: bytes) -> str | None:
    """The digest in a separate mark file; None for any other file."""
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
    """An archive whose end record has the length of the comment that will follow."""
    return archive[:-2] + struct.pack("<H", len(ZIP.piece(_NO_DIGEST)))  # type: ignore[misc]


PNG = Format(_chunk, behind=12)  # the last chunk
GIF = Format(_extension, behind=1)  # its last byte
PDF = Format(_line("% {}\n"))
SVG = HTML = Format(_line("<!-- {} -->\n"))
TOML = Format(_line("# {}\n"))
JSON = Format(_line(', "mark": "{}"'), behind=1)  # of an object that is not empty
HDF5 = Format(_line("\n{}\n"))  # after the end of the HDF5 data
ZIP = Format(_line("{}"), ready=_with_room_for_a_comment)  # the comment of the archive
CSV = Format(None)
PICTURES = {".png": PNG, ".pdf": PDF, ".svg": SVG}
