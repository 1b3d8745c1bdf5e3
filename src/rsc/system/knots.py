"""Stiffness and damping that follow the rotor speed: matrices at some speeds, the knots, linear between them.

Beyond the first and the last knot they stay as they are there. The force of the moment is -K(Omega) r - B(Omega) r': a film or a
seal answers to the state of the moment, so no derivative of K or B by time takes part.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

SKEW = ("skew_stiffness", "skew_damping")
ANISOTROPIC = ("anisotropic_stiffness", "anisotropic_damping")
FOLLOWING = ("stiffness", "damping", *SKEW, *ANISOTROPIC)


@dataclass(frozen=True, eq=False)
class Knots:
    """What is added to the matrices of a body at some rotor speeds.

    speed : (k,) rad/s, strictly increasing, k >= 2
    parts : by the name of the `Body`'s matrix, `FOLLOWING`: (k, n, n), real or (on the conjugate) complex symmetric, or k
        matrices of scipy.sparse; of a stack (m, k, n, n)
    """

    speed: NDArray[np.float64]
    parts: dict[str, Any]

    def at(self, Omega: ArrayLike) -> dict[str, Any]:
        """The parts at rotor speeds in rad/s: of one knot table for every speed, of a stack each with its own or all with one."""
        Omega = np.asarray(Omega, dtype=float)
        below = np.clip(np.searchsorted(self.speed, Omega, side="right") - 1, 0, len(self.speed) - 2)
        low, high = self.speed[below], self.speed[below + 1]
        # both alike, so that the mirror image has the same bits
        shares = [np.clip(part / (high - low), 0.0, 1.0) for part in (high - Omega, Omega - low)]
        return {name: _between(part, below, shares) for name, part in self.parts.items()}

    def shares(self, Omega: ArrayLike) -> NDArray[np.float64]:
        """(..., k) how much of every knot there is at rotor speeds in rad/s."""
        Omega = np.asarray(Omega, dtype=float)
        return np.stack([np.interp(Omega, self.speed, own) for own in np.eye(len(self.speed))], axis=-1)

    def at_all(self, speed: NDArray[np.float64]) -> "Knots":
        """The same with knots at more speeds, of which `speed` has all."""
        if np.array_equal(speed, self.speed):
            return self
        each = [self.at(Omega) for Omega in speed]
        return Knots(speed, {name: np.stack([own[name] for own in each], axis=-3) for name in self.parts})

    def chosen(self, i: ArrayLike) -> "Knots":
        """Those at the places i of a stack."""
        return Knots(self.speed, {name: part[i] for name, part in self.parts.items()})

    def repeated(self, shape: tuple[int, ...]) -> "Knots":
        """A stack of these, so many times."""
        return Knots(self.speed, {name: np.broadcast_to(part, shape + part.shape) for name, part in self.parts.items()})

    def mirror(self) -> "Knots":
        """Those of the mirror image z -> -z, in which the rotor turns the other way."""
        parts = {name: part[..., ::-1, :, :] for name, part in self.parts.items()}
        signed = {name: -part if name in SKEW else np.conj(part) for name, part in parts.items()}
        return Knots(-self.speed[::-1], signed)

    def without(self, names: Iterable[str]) -> "Knots":
        """Those without the parts of these names."""
        return Knots(self.speed, {name: part for name, part in self.parts.items() if name not in names})

    def has(self, names: Iterable[str]) -> bool:
        """Whether there are parts of one of these names."""
        return any(name in self.parts for name in names)


def _between(part, below, shares):
    """The matrices of knots `below` and the next by their shares; exactly those of a knot at its speed."""
    if isinstance(part, (list, tuple)):  # sparse
        return part[below] * shares[0] + part[below + 1] * shares[1]
    first, second = (share[..., None, None] for share in shares)
    if part.ndim == 3:
        return first * part[below] + second * part[below + 1]
    row = np.arange(len(part))
    return first * part[row, below] + second * part[row, below + 1]


def union(tables: Sequence[Knots | None]) -> NDArray[np.float64]:
    """All speeds of several tables, rising."""
    return np.unique(np.concatenate([table.speed for table in tables if table is not None]))


def stacked(tables: Sequence[Knots | None], n: int) -> Knots:
    """Stack of the tables of bodies of n coordinates; zero where a body has none."""
    speed = union(tables)
    each = [None if table is None else table.at_all(speed) for table in tables]
    names = [name for name in FOLLOWING if any(table is not None and name in table.parts for table in each)]

    def part(table, name):
        zero = np.zeros((len(speed), n, n), complex if name in ANISOTROPIC else float)
        return zero if table is None else table.parts.get(name, zero)

    return Knots(speed, {name: np.array([part(table, name) for table in each]) for name in names})
