"""Reading of TOML files with a size limit; errors name the position in one line."""

import codecs
import re
import tomllib
from pathlib import Path
from typing import Any

from rsc.errors import DataError, SceneError, one_line
from rsc.files.content import content_of

MAX_FILE_BYTES = 1_000_000
MAX_DOTS = 100
_UTF_16 = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE  # what `>` of a Windows shell writes
_KEY_DOT = re.compile(r"""[\w"'-][ \t]*\.(?=[ \t]*[\w"'-])""")


def text_of(path: Path, what: str, hint: str) -> str:
    """The text of a file that should contain `what` ("a scene"); `hint` says how to get one. SceneError if unreadable or
    empty."""
    file = one_line(path)
    try:
        content = content_of(path, MAX_FILE_BYTES)
    except DataError as error:
        problem = "put large matrices into a .npz file" if error.problem.startswith("the file has") else error.problem
        raise SceneError(file, "file", path.name, f"{what}: a readable file of at most 1 MB", problem) from None
    try:
        text = content.decode("utf-16" if content.startswith(_UTF_16) else "utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(file, "file", f"byte {error.start}", "UTF-8 text", "save it as UTF-8") from None
    if not text.strip():
        raise SceneError(file, "file", "", f"{what} in TOML", f"the file is empty; {hint}")
    return text


def tables_of(text: str, file: str) -> dict[str, Any]:
    """Parse TOML text to nested dicts; SceneError names file and line."""
    for piece in re.split("[=,{\n]", text):
        # tomllib needs quadratic time for long dotted keys: a megabyte of dots would hang
        if piece.count(".") > MAX_DOTS and len(_KEY_DOT.findall(piece)) > MAX_DOTS:
            wanted = f"keys of at most {MAX_DOTS} parts"
            raise SceneError(file, "file", piece.strip(), wanted, "nested too deep")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise SceneError(file, "file", "a very deep value", "a table in TOML", "nested too deep") from None
    except tomllib.TOMLDecodeError as error:
        message, _, place = str(error).rpartition(" (at ")
        place = place.rstrip(")")
        if message.startswith(("Cannot overwrite", "Cannot declare", "Duplicate")):
            message = f"{message}: is a key or table given twice?"
        line, hint = _line_at(text, place), ""
        if "\\" in message or "hex" in message:
            hint = "write paths with / or in single quotes: a backslash in double quotes starts an escape"
        raise SceneError(file, place or "file", line, "valid TOML", hint or " ".join(message.split())) from None
    except ValueError as error:  # an integer with thousands of digits
        hint = str(error).partition(":")[0]
        raise SceneError(file, "file", "a number", "a number of sensible length", hint) from None


def _line_at(text: str, place: str) -> str:
    """The source line at a position such as "line 3, column 5"."""
    words = place.replace(",", " ").split()
    lines = text.splitlines()
    if len(words) == 4 and words[1].isdigit() and 0 < int(words[1]) <= len(lines):
        return lines[int(words[1]) - 1].strip()
    return lines[-1].strip() if lines else ""
