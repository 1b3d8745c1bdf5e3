"""The errors a caller of rsc can meet, and the words of their messages; nothing here depends on the rest of the package."""

import difflib
import os
import reprlib
from collections.abc import Sequence
from typing import Any

_repr = reprlib.Repr()
_repr.maxstring = _repr.maxother = 60
_repr.maxlevel, _repr.maxlist, _repr.maxdict, _repr.maxtuple = 3, 4, 4, 4


class RscError(Exception):
    """Base of every error that rsc raises on purpose.

    Copies and pickles, also through processes, keep its attributes: `_made_of` are those that it is made of.
    """

    _made_of: tuple[str, ...] = ()

    def __reduce__(self) -> tuple[Any, ...]:
        made_of = tuple(getattr(self, name) for name in self._made_of) or self.args
        return type(self), made_of, {**self.__dict__}


class SceneError(RscError):
    """A scene that cannot be right: file, key, value, allowed range and a hint, in one line.

    Parameters
    ----------
    file : str
        Name of the scene file, or ``"<scene>"`` for one made in memory.
    key : str
        Dotted key, for example ``"contact.gap"``.
    value : object
        What the scene says (None when the key is missing).
    wanted : str
        The allowed range, to be read after "must be".
    hint : str
        One short piece of advice; may be empty.
    """

    _made_of = ("file", "key", "value", "wanted", "hint")

    def __init__(self, file: str, key: str, value: object, wanted: str, hint: str = "") -> None:
        self.file, self.key, self.value, self.wanted, self.hint = file, key, shown(value), wanted, hint
        text = "(missing)" if value is None else _short(self.value)
        tail = f" ({hint})" if hint else ""
        super().__init__(f"{file}: {key} = {text}: must be {wanted}{tail}")


class SolverError(RscError):
    """The solver was asked for something it cannot do (not a run that failed: that is a status)."""


class ReductionError(RscError):
    """A body of a machine that cannot be reduced as asked: what stands against it, in one line."""


class DataError(RscError):
    """A result or matrix file that cannot be read or written.

    Parameters
    ----------
    file : str
        Name of the file, as in the message: in one line.
    problem : str
        What is wrong, in one line.
    """

    _made_of = ("file", "problem")

    def __init__(self, file: str | os.PathLike[str], problem: str) -> None:
        self.file, self.problem = one_line(file), problem
        super().__init__(f"{self.file}: {problem}")


class WriteError(DataError):
    """A result file could not be written to its end, a full disk for example; samples written before stay readable.

    The HDF5 library cannot close such a file and may crash when the process ends: a program should leave at once.
    """


def _short(value: object, limit: int = 80) -> str:
    """One printable line for a value of any kind and size."""
    text = repr(value)
    text = " ".join(text.split())
    return text if len(text) <= limit else text[: limit - 3] + "..."


class _Shown:
    """Stands for a value whose own repr could be endless, huge or impossible."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def shown(value: object) -> object:
    """Return the value, or a short stand-in for one that is huge or deeply nested."""
    if isinstance(value, int) and not isinstance(value, bool) and value.bit_length() > 128:
        return _Shown(f"an integer of {value.bit_length()} bits")
    if isinstance(value, (str, bool, int, float, _Shown)) or value is None:
        return value
    return _Shown(_repr.repr(value))


def one_line(name: object) -> str:
    """A key or file name that cannot break the line of a message."""
    text = str(name)
    text = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text[:501])
    return text if len(text) <= 500 else text[:497] + "..."


MEANT = "did you mean"  # begins a hint that has found a name


def nearest(name: object, names: Sequence[str]) -> str:
    """The hint for a mistyped name: the nearest allowed one, or a list of them if it is short."""
    close = difflib.get_close_matches(str(name)[:100], names, n=1, cutoff=0.6)
    listed = "allowed: " + ", ".join(names)
    return f"{MEANT} \"{close[0]}\"?" if close else listed if len(listed) < 250 else ""
