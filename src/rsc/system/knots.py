"""Speed-dependent stiffness and damping: matrices at given rotor speeds (knots), linear in between, constant beyond.

The force is -K(Omega) r - B(Omega) r' with the present Omega: a film or seal responds to its present state, so no time derivative
of K or B occurs.
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
    """Parts that are added to the matrices of a body, given at some rotor speeds.

    speed : (k,) rad/s, strictly increasing, k >= 2
    parts : by the name of the `Body`'s matrix, `FOLLOWING`: (k, n, n), real or (on the conjugate) complex symmetric, or k
        matrices of scipy.sparse; of a stack (m, k, n, n)
    """

    speed: NDArray[np.float64]
    parts: dict[str, Any]

    def at(self, Omega: ArrayLike) -> dict[str, Any]:
        """The parts interpolated at rotor speeds in rad/s: a scalar or array; for a stack a scalar or one speed per body."""
        Omega = np.asarray(Omega, dtype=float)
        below = np.clip(np.searchsorted(self.speed, Omega, side="right") - 1, 0, len(self.speed) - 2)
        low, high = self.speed[below], self.speed[below + 1]
        # both by the same operations, so that the mirror image has the same bits
        shares = [np.clip(part / (high - low), 0.0, 1.0) for part in (high - Omega, Omega - low)]
        return {name: _between(part, below, shares) for name, part in self.parts.items()}

    def shares(self, Omega: ArrayLike) -> NDArray[np.float64]:
        """(..., k) interpolation weights of the knots at rotor speeds in rad/s."""
        Omega = np.asarray(Omega, dtype=float)
        return np.stack([np.interp(Omega, self.speed, unit) for unit in np.eye(len(self.speed))], axis=-1)

    def at_all(self, speed: NDArray[np.float64]) -> "Knots":
        """The same function of speed with more knots; `speed` contains all present ones."""
        if np.array_equal(speed, self.speed):
            return self
        resampled = [self.at(Omega) for Omega in speed]
        return Knots(speed, {name: np.stack([parts[name] for parts in resampled], axis=-3) for name in self.parts})

    def chosen(self, i: ArrayLike) -> "Knots":
        """The knots at indices i of a stack."""
        return Knots(self.speed, {name: part[i] for name, part in self.parts.items()})

    def repeated(self, shape: tuple[int, ...]) -> "Knots":
        """A stack of copies with the given leading shape."""
        return Knots(self.speed, {name: np.broadcast_to(part, shape + part.shape) for name, part in self.parts.items()})

    def mirror(self) -> "Knots":
        """The knots of the mirror image y -> -y, in which the rotor turns the other way."""
        parts = {name: part[..., ::-1, :, :] for name, part in self.parts.items()}
        signed = {name: -part if name in SKEW else np.conj(part) for name, part in parts.items()}
        return Knots(-self.speed[::-1], signed)

    def without(self, names: Iterable[str]) -> "Knots":
        """The knots without the parts of these names."""
        return Knots(self.speed, {name: part for name, part in self.parts.items() if name not in names})

    def has(self, names: Iterable[str]) -> bool:
        """Whether any of these parts is present."""
        return any(name in self.parts for name in names)


def _between(part: Any, below: NDArray[np.intp], shares: Sequence[NDArray[np.float64]]) -> Any:
    """Weighted sum of the matrices of knots `below` and `below + 1`; exact at a knot."""
    if isinstance(part, (list, tuple)):  # sparse
        return part[below] * shares[0] + part[below + 1] * shares[1]
    first, second = (share[..., None, None] for share in shares)
    if part.ndim == 3:
        return first * part[below] + second * part[below + 1]
    row = np.arange(len(part))
    return first * part[row, below] + second * part[row, below + 1]


def union(tables: Sequence[Knots | None]) -> NDArray[np.float64]:
    """Speeds of all tables, sorted, without duplicates."""
    return np.unique(np.concatenate([table.speed for table in tables if table is not None]))


def stacked(tables: Sequence[Knots | None], n: int) -> Knots:
    """Stack of the tables of bodies with n coordinates; zero for a body without one."""
    speed = union(tables)
    resampled = [None if table is None else table.at_all(speed) for table in tables]
    names = [name for name in FOLLOWING if any(table is not None and name in table.parts for table in resampled)]

    def part(table: Knots | None, name: str) -> Any:
        zero = np.zeros((len(speed), n, n), complex if name in ANISOTROPIC else float)
        return zero if table is None else table.parts.get(name, zero)

    return Knots(speed, {name: np.array([part(table, name) for table in resampled]) for name in names})
