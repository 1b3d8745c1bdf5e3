"""Kinds of arguments of the public functions: what is of another kind is refused like a wrong scene, in one line.

`@takes(scene=SCENE, speed=optional(NUMBER))` checks the arguments of these names before the function is entered. A number may be
of any library that registers its types with `numbers`, as NumPy does; true and false are no numbers.
"""

import functools
import inspect
import math
import numbers
import os
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar, cast

from rsc.errors import SceneError, shown
from rsc.units import QuantityError, quantity
from rsc.units.together import refuse_mixed

_Function = TypeVar("_Function", bound=Callable[..., Any])


class ArgumentKind(NamedTuple):
    """What an argument may be, to be read after "must be", whether a value is, and what the function gets in its place."""

    wanted: str
    fits: Callable[[Any], bool]
    read: Callable[[Any], Any] = lambda value: value


def _has(*names: str) -> Callable[[Any], bool]:
    """Whether a value has attributes of these names; they are not read, which could read a file."""

    def fits(value: Any) -> bool:
        own = getattr(value, "__dict__", ())
        return not isinstance(value, type) and all(hasattr(type(value), name) or name in own for name in names)

    return fits


def _is_real(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return False
    try:
        float(value)
    except OverflowError:  # an integer beyond all floats
        return False
    return True


def _dtype(value: Any) -> str:
    """NumPy's letter for the kind of an array, "O" for what is none."""
    import numpy as np

    if isinstance(value, (str, bytes, Mapping)) or value is None:
        return "O"
    try:
        return str(np.asarray(value).dtype.kind)
    except (ValueError, TypeError, OverflowError):  # rows of different lengths, for example
        return "O"


def _axes(value: Any) -> int:
    import numpy as np

    return np.ndim(value)


def _in_hertz(value: Any, deep: int = 2) -> Any:
    """A rotor speed, or a list of them or of such lists, with texts such as "3000 rpm" as numbers in Hz; QuantityError for other
    texts."""
    if isinstance(value, str):
        return quantity(value, "frequency")
    if not deep or not isinstance(value, (list, tuple)):
        return value
    read = [_in_hertz(item, deep - 1) for item in value]
    refuse_mixed((item for item in value if isinstance(item, str) or _is_real(item)), "frequency")
    return read


def _is_path(value: Any) -> bool:
    return isinstance(value, (str, os.PathLike)) and isinstance(os.fspath(value), str)


SCENE = ArgumentKind("an rsc.Scene", _has("rotor", "stator", "contacts", "drive"))
RUN = ArgumentKind("an rsc.Trajectory", _has("time", "speed", "contact_rotor"))
RESULT = ArgumentKind("an rsc.Trajectory", _has("scene", "summary", "time", "speed", "contact_rotor"))
FALL = ArgumentKind("a Waterfall", _has("frequency", "amplitude", "window"))
# where nan and infinity are refused with the range by the function itself
REAL = ArgumentKind("a number", _is_real)
REALS = ArgumentKind("an array of numbers", lambda value: _dtype(value) in "iuf")
LINE = ArgumentKind("a number, or a list of them", lambda value: _dtype(value) in "iuf" and _axes(value) <= 1)
SPEED = ArgumentKind("a number in Hz, or a text such as \"3000 rpm\"", _is_real, _in_hertz)
# what is no speed at all the function refuses with its range
ROTOR_SPEEDS = ArgumentKind("numbers in Hz, or texts such as \"3000 rpm\"", lambda value: True, _in_hertz)
LINE_OF_SPEEDS = ArgumentKind(f"{SPEED.wanted}, or a list of them", LINE.fits, _in_hertz)
SIGNAL = ArgumentKind("an array of numbers, real or complex", lambda value: _dtype(value) in "iufc")
POSITIVE = ArgumentKind("a finite number above 0", lambda value: _is_real(value) and 0 < value < math.inf)
WHOLE = ArgumentKind(
    "a whole number of 64 bits", lambda value: isinstance(value, numbers.Integral) and _is_real(value) and abs(int(value)) < 2**63
)
NAMED = ArgumentKind(
    "a mapping of names to values", lambda value: isinstance(value, Mapping) and all(isinstance(key, str) for key in value)
)
FLAG = ArgumentKind("true or false", lambda value: isinstance(value, bool) or type(value).__name__ == "bool")  # NumPy's
PATH = ArgumentKind("the name of a file", _is_path)
TEXT = ArgumentKind("a text", lambda value: isinstance(value, str))
TEXTS = ArgumentKind(
    "a text, or a list of them",
    lambda value: isinstance(value, str) or (isinstance(value, (list, tuple)) and all(isinstance(text, str) for text in value)),
)
FUNCTION = ArgumentKind("a function", callable)


def optional(kind: ArgumentKind) -> ArgumentKind:
    """The kind, or None."""
    return ArgumentKind(f"{kind.wanted}, or None", lambda value: value is None or kind.fits(value), kind.read)


def scenes_in(function: str, scenes: Any) -> list[Any]:
    """The scenes of an iterable as a list; SceneError, with the function in the place of the file, for anything else."""
    try:
        listed = list(scenes) if not isinstance(scenes, (str, bytes, Mapping, type)) else [None]
    except TypeError:
        listed = [None]
    for scene in listed:
        if not SCENE.fits(scene):
            raise SceneError(function, "scenes", _visible(scenes), "a sequence of rsc.Scene")
    return listed


def takes(**kinds: ArgumentKind) -> Callable[[_Function], _Function]:
    """Decorator: SceneError, with the function in the place of the file, for an argument that is of another kind."""

    def decorate(function: _Function) -> _Function:
        signature = inspect.signature(function)

        @functools.wraps(function)
        def checked(*positional: Any, **named: Any) -> Any:
            try:
                bound = signature.bind(*positional, **named)
            except TypeError:  # too few, too many or of unknown names: Python's own message names the function
                return function(*positional, **named)
            for name, value in bound.arguments.items():
                if name in kinds:
                    bound.arguments[name] = _read(function.__name__, name, value, kinds[name])
            return function(*bound.args, **bound.kwargs)

        return cast(_Function, checked)

    return decorate


def _read(function: str, name: str, value: Any, kind: ArgumentKind) -> Any:
    """What a function gets for an argument; SceneError, with the function in the place of the file, for another kind."""
    try:
        read = kind.read(value)
    except QuantityError as error:
        raise SceneError(function, name, _visible(value), error.wanted, error.hint) from None
    if not kind.fits(read):
        raise SceneError(function, name, _visible(value), kind.wanted)
    return read


def _visible(value: Any) -> Any:
    """None as such: in a scene it stands for a missing key."""
    return _Nothing() if value is None else shown(value)


class _Nothing:
    def __repr__(self) -> str:
        return "None"
