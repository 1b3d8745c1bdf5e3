"""The errors a caller of rsc can meet; nothing here depends on the rest of the package."""


class RscError(Exception):
    """Base of every error that rsc raises on purpose."""


class SceneError(RscError):
    """A scene that cannot be right: file, key, value, what is allowed and a hint, in one line.

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

    def __init__(self, file, key, value, wanted, hint=""):
        self.file, self.key, self.value, self.wanted, self.hint = file, key, value, wanted, hint
        shown = "(missing)" if value is None else _short(value)
        tail = f" ({hint})" if hint else ""
        super().__init__(f"{file}: {key} = {shown}: must be {wanted}{tail}")


class SolverError(RscError):
    """The solver was asked for something it cannot do (not a run that failed: that is a status)."""


class DataError(RscError):
    """A result or matrix file that cannot be read or written.

    Parameters
    ----------
    file : str
        Name of the file.
    problem : str
        What is wrong, in one line.
    """

    def __init__(self, file, problem):
        self.file, self.problem = str(file), problem
        super().__init__(f"{file}: {problem}")


class WriteError(DataError):
    """A result file could not be written to its end, a full disk for example; what was written before stays readable.

    The HDF5 library cannot close such a file and may crash when the process ends: a program should leave at once.
    """


def _short(value, limit=80):
    """One printable line for a value of any kind and size."""
    text = repr(value)
    text = " ".join(text.split())
    return text if len(text) <= limit else text[: limit - 3] + "..."
