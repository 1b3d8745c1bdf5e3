"""The decorators of the kernel: compiled without the GIL, never with fastmath, cached under a hash of all kernel sources."""

from pathlib import Path

import numba
from numba.extending import overload

from rsc.compiled.paths import cached, entry_options, helper_options

_KERNEL = Path(__file__).parents[1]
_INLINED = helper_options(forceinline=True)


def inlined(function):
    """Compile a helper that is inlined into its caller; it has no separate cache entry."""
    return numba.njit(**_INLINED)(function)


def unrolled(choose):
    """A helper whose code depends on its arguments' types: `choose` receives the types and returns the function to inline."""

    def helper(*args):
        raise NotImplementedError("only compiled code calls this")

    overloaded(helper)(choose)
    return helper


def constant(value_of):
    """A number, or a tuple of numbers, that follows from the types of the arguments: `value_of` receives the types, once."""

    def choose(*kinds):
        value = value_of(*kinds)
        return lambda *args: value

    return unrolled(choose)


def overloaded(function):
    """numba.extending.overload whose code is inlined into its caller."""
    return overload(function, jit_options=_INLINED, strict=False)


def anywhere(function):
    """A helper like `inlined` that can also be called from Python, as the plain function."""
    overloaded(function)(lambda *args: function)
    return function


def compiled(function):
    """Compile a helper that remains a separate function within its caller's cached code; only compiled code calls it."""
    return numba.njit(**helper_options())(function)


def entry(function):
    """Compile a function that Python calls: cached on disk in the folder named after the kernel's content."""
    return cached(function, _KERNEL, **entry_options())
