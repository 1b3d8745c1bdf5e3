"""Contact springs: force F(p) of the penetration p, for each kind of spring one set (`Room`) of functions.

A kind is a named tuple of constants; the first is k, N/m, the stiffness at p = 0, and k is 0 in contact states without force.
Kernel and packing call the functions below, which select the kind's functions by type, in Python as in compiled code.
"""

from collections.abc import Callable
from typing import NamedTuple

from rsc.kernel.simd import vec
from rsc.kernel.simd.emit import product
from rsc.kernel.simd.jit import overloaded


class Room(NamedTuple):
    """Functions that a kind of spring must provide. They are plain functions, compiled where they are used.

    To add a spring: a named tuple of its constants, these functions and an entry in `ROOMS`; all else supports or refuses it.
    """

    of: Callable  # (law of a System, gap) -> the constants
    times: Callable  # (spring, factor) -> the spring with its force multiplied by factor
    share: Callable  # (spring, place, gap) -> F/|d|, N/m, for the right-hand side; of the Place, 1/|d| is known first
    switch: Callable  # (spring, p) -> F, N, used to detect switches of the contact state
    slope: Callable  # (spring, p) -> dF/dp, N/m
    power: Callable  # (spring, p_0, p_1) -> energy released from p_0 to p_1, J, for the ledger
    limit: Callable  # (spring) -> stiffness that limits stable steps, N/m: the largest; if unbounded e.g. that at p = gap
    coefficient: Callable | None = None  # (spring, place, gap, h) -> a series like `LinearSeries`; None: not with taylor8


class Linear(NamedTuple):
    """F = k p."""

    k: float  # N/m


class LinearSeries:
    """Coefficients of h F/|d| = h k (1 - gap/|d|) from those of q = g'/(2 g), g = |d|^2, in ascending order (series.py)."""

    def __init__(self, spring, place, gap, h):
        stiff = h * spring.k
        self.first = stiff * place.penetration * place.inverse
        self.rest = [stiff * gap * place.inverse * -1.0]  # the others are those of a multiple of w = |d_0|/|d|, w' = -q w

    def at(self, k, q):
        """Coefficient k, given all lower ones."""
        if k == 0:
            return self.first
        self.rest.append(product(q, self.rest, k - 1) * (-1.0 / k))
        return self.rest[k]


def _share(spring, place, gap):
    # a single fused multiply-add once 1/|d| is known
    return vec.fma(-(spring.k * gap), place.inverse, spring.k)


def _power(spring, p_0, p_1):
    return 0.5 * spring.k * (p_0 * p_0 - p_1 * p_1)


ROOMS = {
    Linear: Room(
        of=lambda law, gap: Linear(float(law.stiffness)),
        times=lambda spring, factor: Linear(factor * spring.k),
        share=_share,
        switch=lambda spring, p: spring.k * p,
        slope=lambda spring, p: spring.k,
        power=_power,
        limit=lambda spring: spring.k,
        coefficient=LinearSeries,
    )
}


def _asked(name):
    def asked(spring, *args):
        return getattr(ROOMS[type(spring)], name)(spring, *args)

    overloaded(asked)(lambda spring, *args: getattr(ROOMS[spring.instance_class], name))
    return asked


times, share, switch, slope, power, limit = map(_asked, ("times", "share", "switch", "slope", "power", "limit"))
