"""Exceptions raised by rsc and helpers for their messages; this module imports nothing else of the package."""

import difflib
import os
import reprlib
from collections.abc import Sequence
from typing import Any

_repr = reprlib.Repr()
_repr.maxstring = _repr.maxother = 60
_repr.maxlevel, _repr.maxlist, _repr.maxdict, _repr.maxtuple = 3, 4, 4, 4


class RscError(Exception):
    """Base class of all errors that rsc raises deliberately.

    Subclasses list in `_made_of` the attributes that their constructor takes, so that copying and pickling (also between
    processes) keep them.
    """

    _made_of: tuple[str, ...] = ()

    def __reduce__(self) -> tuple[Any, ...]:
        made_of = tuple(getattr(self, name) for name in self._made_of) or self.args
        return type(self), made_of, {**self.__dict__}


class SceneError(RscError):
    """An invalid scene; the message names file, key, value, allowed range and a hint in one line.

    Parameters
    ----------
    file : str
        Name of the scene file, or ``"<scene>"`` for one made in memory.
    key : str
        Dotted key, for example ``"contact.gap"``.
    value : object
        The value found in the scene (None if the key is missing).
    wanted : str
        The allowed range, to be read after "must be".
    hint : str
        One short piece of advice; may be empty.
    place : str
        The key as people read it, where `key` counts from 0 in a list: "rotor.disks, disk 2 (impeller), mass"; "" for the key.
    """

    _made_of = ("file", "key", "value", "wanted", "hint", "place")

    def __init__(self, file: str, key: str, value: object, wanted: str, hint: str = "", place: str = "") -> None:
        self.file, self.key, self.value, self.wanted, self.hint, self.place = file, key, shown(value), wanted, hint, place
        text = "(missing)" if value is None else _short(self.value)
        tail = f" ({hint})" if hint else ""
        super().__init__(f"{file}: {place or key} = {text}: must be {wanted}{tail}")


class SolverError(RscError):
    """The request is outside what the solver can do. A run that fails raises nothing: it ends with a status."""


class ReductionError(RscError):
    """A body of a machine that cannot be reduced as requested; the message gives the reason in one line."""


class DataError(RscError):
    """A result or matrix file that cannot be read or written.

    Parameters
    ----------
    file : str
        Name of the file as shown in the message, on one line.
    problem : str
        The problem, on one line.
    """

    _made_of = ("file", "problem")

    def __init__(self, file: str | os.PathLike[str], problem: str) -> None:
        self.file, self.problem = one_line(file), problem
        super().__init__(f"{self.file}: {problem}")


class WriteError(DataError):
    """A result file that could not be written completely, for example because the disk is full.

    Samples written before stay readable. The HDF5 library cannot close such a file and may crash at interpreter exit, so the
    program should end at once.
    """


def _short(value: object, limit: int = 80) -> str:
    """`repr` of a value on one line, shortened to `limit` characters."""
    text = repr(value)
    text = " ".join(text.split())
    return text if len(text) <= limit else text[: limit - 3] + "..."


class _Shown:
    """Placeholder for a value whose repr could be endless, huge or fail."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def shown(value: object) -> object:
    """Return the value itself, or a placeholder with a short repr if it is huge or deeply nested."""
    if isinstance(value, int) and not isinstance(value, bool) and value.bit_length() > 128:
        return _Shown(f"an integer of {value.bit_length()} bits")
    if isinstance(value, (str, bool, int, float, _Shown)) or value is None:
        return value
    return _Shown(_repr.repr(value))


def one_line(name: object) -> str:
    """A key or file name as printable text on one line, at most 500 characters."""
    text = str(name)
    text = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text[:501])
    return text if len(text) <= 500 else text[:497] + "..."


MEANT = "did you mean"  # start of a hint that suggests a name


def nearest(name: object, names: Sequence[str]) -> str:
    """Hint for a mistyped name: the closest allowed name, else the list of allowed names if that is short."""
    close = difflib.get_close_matches(str(name)[:100], names, n=1, cutoff=0.6)
    listed = "allowed: " + ", ".join(names)
    return f"{MEANT} \"{close[0]}\"?" if close else listed if len(listed) < 250 else ""
