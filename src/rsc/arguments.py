"""Validation of the arguments of public functions: a wrong type raises SceneError with a one-line message.

`@takes(scene=SCENE, speed=optional(SPEED))` checks the named arguments before the function body runs. Any number type registered
with `numbers` is accepted, NumPy's included; bool is not a number.
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
    """A kind of argument: its description (read after "must be"), its test, and the conversion applied before the test."""

    wanted: str
    fits: Callable[[Any], bool]
    read: Callable[[Any], Any] = lambda value: value


def _has(*names: str) -> Callable[[Any], bool]:
    """A test for attributes of these names; it does not evaluate them, since a property might read a file."""

    def fits(value: Any) -> bool:
        attributes = getattr(value, "__dict__", ())
        return not isinstance(value, type) and all(hasattr(type(value), name) or name in attributes for name in names)

    return fits


def _is_real(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return False
    try:
        float(value)
    except OverflowError:  # an integer too large for a float
        return False
    return True


def _dtype(value: Any) -> str:
    """NumPy's one-letter kind of the array made from a value; "O" if it is not an array of numbers."""
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
    """Convert texts such as "3000 rpm" to Hz, also in lists nested up to `deep` levels; QuantityError for other texts."""
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
# the function itself checks the range, NaN and infinity included
REAL = ArgumentKind("a number", _is_real)
REALS = ArgumentKind("an array of numbers", lambda value: _dtype(value) in "iuf")
LINE = ArgumentKind("a number, or a list of them", lambda value: _dtype(value) in "iuf" and _axes(value) <= 1)
SPEED = ArgumentKind("a number in Hz, or a text such as \"3000 rpm\"", _is_real, _in_hertz)
IMPULSE = ArgumentKind(
    "a number in N s, or a text such as \"10 N s\"",
    _is_real,
    lambda value: quantity(value, "impulse") if isinstance(value, str) else value,
)
# the function itself refuses what is not a speed, and states the range
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
AXES = ArgumentKind("axes of matplotlib", _has("set_xlabel", "get_legend_handles_labels"))
DATASET = ArgumentKind(
    "an xarray.Dataset of rsc.sweep", lambda value: _has("coords", "data_vars", "sizes")(value) and "computed" in value.attrs
)


def optional(kind: ArgumentKind) -> ArgumentKind:
    """The kind, or None."""
    return ArgumentKind(f"{kind.wanted}, or None", lambda value: value is None or kind.fits(value), kind.read)


def scenes_in(function: str, scenes: Any) -> list[Any]:
    """The scenes of an iterable as a list; SceneError, which names the function instead of a file, for anything else."""
    try:
        listed = list(scenes) if not isinstance(scenes, (str, bytes, Mapping, type)) else [None]
    except TypeError:
        listed = [None]
    for scene in listed:
        if not SCENE.fits(scene):
            raise SceneError(function, "scenes", _visible(scenes), "a sequence of rsc.Scene")
    return listed


def takes(**kinds: ArgumentKind) -> Callable[[_Function], _Function]:
    """Decorator that checks arguments; SceneError, which names the function instead of a file, for one of the wrong kind."""

    def decorate(function: _Function) -> _Function:
        signature = inspect.signature(function)

        @functools.wraps(function)
        def checked(*positional: Any, **named: Any) -> Any:
            try:
                bound = signature.bind(*positional, **named)
            except TypeError:  # wrong number or names of arguments: calling the function raises Python's own message
                return function(*positional, **named)
            for name, value in bound.arguments.items():
                if name in kinds:
                    bound.arguments[name] = _read(function.__name__, name, value, kinds[name])
            return function(*bound.args, **bound.kwargs)

        return cast(_Function, checked)

    return decorate


def _read(function: str, name: str, value: Any, kind: ArgumentKind) -> Any:
    """The converted argument; SceneError, which names the function instead of a file, if it is of the wrong kind."""
    try:
        read = kind.read(value)
    except QuantityError as error:
        raise SceneError(function, name, _visible(value), error.wanted, error.hint) from None
    if not kind.fits(read):
        raise SceneError(function, name, _visible(value), kind.wanted)
    return read


def _visible(value: Any) -> Any:
    """A displayable form of a value; None is shown as "None", since SceneError takes None for a missing key."""
    return _Nothing() if value is None else shown(value)


class _Nothing:
    def __repr__(self) -> str:
        return "None"
