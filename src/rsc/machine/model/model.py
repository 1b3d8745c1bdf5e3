"""A finite-element model of a rotor or a stator in complex coordinates, before any reduction."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from rsc.errors import DataError, nearest, one_line
from rsc.machine.formats import Matrix
from rsc.system.knots import ANISOTROPIC, Knots

DOUBLE = 8.0 * 2.0**-53  # rounding of an entry over itself in double precision, after some arithmetic
DISPLACEMENT, TILT, OTHER = "displacement", "tilt", "other"


@dataclass(frozen=True)
class FiniteElementModel:
    """Matrices of one body in SI units, as finite elements give them.

    With complex coordinates z (u = x + i y, and phi = ry - i rx = u' where a node tilts) and the speed Omega in rad/s

        M z'' + (C + i C_s - i Omega G) z' + (K + i S) z + C_i (z' - i Omega z)
            + M_c conj(z'') + C_c conj(z') + K_c conj(z) = f

    M, C, G, K, C_s, S and C_i are real and symmetric. C, K, C_s, S, C_c and K_c may follow the speed, linear between knots.
    Forward motion has positive frequency. Matrices are all sparse (csc_array) or all dense.

    A casing whose axial motion is coupled has no complex coordinates of its own: its model takes every real coordinate once, for
    x and as i times the same for y, which is right for the contact as far as `notes` says (machine/imports/casing.py).
    """

    source: str  # where it comes from, for messages
    node: NDArray[np.int64]  # (n,) node of each coordinate
    kind: NDArray[np.str_]  # (n,) "displacement" (m), "tilt" (rad) or "other"
    mass: Matrix  # (n, n) M, kg (kg m, kg m^2 where tilts take part), positive semidefinite
    damping: Matrix  # (n, n) C, N s/m
    gyroscopic: Matrix  # (n, n) G, kg m^2
    stiffness: Matrix  # (n, n) K, N/m
    skew_damping: Matrix | None = None  # (n, n) C_s, N s/m: cross-coupled damping
    skew_stiffness: Matrix | None = None  # (n, n) S, N/m: cross-coupled stiffness of seals, journal bearings, rotating damping
    anisotropic_mass: Matrix | None = None  # (n, n) complex symmetric M_c, and so on; None where both directions are alike
    anisotropic_damping: Matrix | None = None
    anisotropic_stiffness: Matrix | None = None
    rotating_damping: Matrix | None = None  # (n, n) C_i, N s/m, of what turns with the rotor
    knots: Knots | None = None  # what the matrices above have besides at some rotor speeds, by the names of their fields
    speed: float | None = None  # Hz, the rotor speed at which coefficients of bearings and seals were taken
    rounding: float = DOUBLE  # of an entry of the stiffness over itself, as far as the digits of its file tell
    free: bool = False  # whether some motions have no stiffness, so that bearings must be added
    names: dict[str, int] = field(default_factory=dict)  # nodes by name
    position: dict[int, float] = field(default_factory=dict)  # m along the axis, by node
    diameter: dict[int, float] = field(default_factory=dict)  # m, outer diameter by node
    notes: tuple[str, ...] = ()  # what was left out or assumed, whole sentences
    shaft: Any = None  # rsc.machine.shaft.parts.Shaft that it was made of, for pictures

    @property
    def n(self) -> int:
        """Number of complex coordinates."""
        return len(self.node)

    @property
    def is_sparse(self) -> bool:
        """Whether the matrices are sparse."""
        return scipy.sparse.issparse(self.mass)

    @property
    def isotropic(self) -> bool:
        """Whether nothing acts on the conjugate, at any speed."""
        own = self.anisotropic_mass is None and self.anisotropic_damping is None and self.anisotropic_stiffness is None
        return own and (self.knots is None or not self.knots.has(ANISOTROPIC))

    @property
    def slowest_speed(self) -> float:
        """The first rotor speed in Hz that its coefficients are known at; 0 where they belong to none."""
        return float(self.knots.speed[0]) / (2.0 * np.pi) if self.knots is not None else self.speed or 0.0

    def at_speed(self, speed: float) -> "FiniteElementModel":
        """The model as it is at a rotor speed in Hz; rotating damping becomes damping and skew stiffness."""
        Omega, model = 2.0 * np.pi * speed, self
        if self.knots is not None:
            model = replace(model, knots=None)
            for name, part in self.knots.at(Omega).items():
                own = getattr(model, name)
                model = replace(model, **{name: part if own is None else own + part})
        if model.rotating_damping is None:
            return model
        turned = -Omega * model.rotating_damping
        skew = turned if model.skew_stiffness is None else model.skew_stiffness + turned
        return replace(model, damping=model.damping + model.rotating_damping, skew_stiffness=skew, rotating_damping=None)

    def node_of(self, place: int | str) -> int:
        """Number of a node given by number or name.

        Raises
        ------
        DataError
            No such node.
        """
        if isinstance(place, str) and place in self.names:
            return self.names[place]
        if isinstance(place, str) and not place.lstrip("-").isdigit():
            known = ", ".join(sorted(self.names)[:20])
            hint = nearest(place, tuple(self.names)) if self.names else "its nodes have no names"
            raise DataError(self.source, f"no node has the name {one_line(place)[:40]!r} ({hint or known})")
        if int(place) not in self.node:
            raise DataError(self.source, f"no node {int(place)} (nodes {self.node.min()} to {self.node.max()})")
        return int(place)

    def row_at(self, place: int | str) -> NDArray[np.float64]:
        """Row l of the displacement at a node, (n,): the displacement is l z, and a force F there is l F.

        Raises
        ------
        DataError
            No such node, or no displacement there.
        """
        return self._unit(self.node_of(place), DISPLACEMENT)

    def row_between(self, first: int | str, second: int | str, share: float) -> NDArray[np.float64]:
        """Row of the displacement between two nodes, (n,).

        Where both nodes tilt and have positions: the cubic of a beam without shear (Hermite); otherwise linear.

        Parameters
        ----------
        first, second : int or str
            Nodes by number or name; the second one further along the axis.
        share : float
            Part of the way from the first node to the second, 0 to 1.

        Raises
        ------
        DataError
            No such node, no displacement there, share outside 0 to 1, or positions that do not increase.
        """
        if not 0.0 <= share <= 1.0:
            raise DataError(self.source, f"share {share:g}: must be from 0 to 1")
        a, b = self.node_of(first), self.node_of(second)
        tilts = set(self.node[self.kind == TILT].tolist())
        if not ({a, b} <= tilts and {a, b} <= set(self.position)):
            return (1.0 - share) * self._unit(a, DISPLACEMENT) + share * self._unit(b, DISPLACEMENT)
        length, s = self.position[b] - self.position[a], share
        if length <= 0.0:
            raise DataError(self.source, f"node {b} must lie further along the axis than node {a}")
        at_a = (1.0 - 3.0 * s**2 + 2.0 * s**3) * self._unit(a, DISPLACEMENT) + length * s * (1.0 - s) ** 2 * self._unit(a, TILT)
        at_b = (3.0 * s**2 - 2.0 * s**3) * self._unit(b, DISPLACEMENT) - length * s**2 * (1.0 - s) * self._unit(b, TILT)
        return at_a + at_b

    def diameter_at(self, place: int | str) -> float | None:
        """Outer diameter at a node in m, for the contact there; None where it is not known."""
        return self.diameter.get(self.node_of(place))

    def _unit(self, node: int, kind: str) -> NDArray[np.float64]:
        row = ((self.node == node) & (self.kind == kind)).astype(np.float64)
        if not row.any():
            raise DataError(self.source, f"node {node} has no {kind}")
        return row

    def with_conjugate(self, speed: float) -> tuple[Matrix, Matrix, Matrix]:
        """Mass, damping and stiffness (2n, 2n), complex, of z and conj(z) as independent coordinates.

        Their eigenvalues are those of the real matrices: the roots of the n complex coordinates and, mirrored, of the conjugate.

        Parameters
        ----------
        speed : float
            Rotor speed, Hz.
        """
        return self.at_speed(speed)._with_conjugate(speed)

    def _with_conjugate(self, speed: float) -> tuple[Matrix, Matrix, Matrix]:
        turning = self.damping - 2j * np.pi * speed * self.gyroscopic
        if self.skew_damping is not None:
            turning = turning + 1j * self.skew_damping
        stiffness = self.stiffness if self.skew_stiffness is None else self.stiffness + 1j * self.skew_stiffness
        stack = scipy.sparse.block_array if self.is_sparse else np.block
        return tuple(
            stack([[own, other], [other.conj(), own.conj()]])
            for own, other in (
                (self.mass, _or_zero(self.anisotropic_mass, self.mass)),
                (turning, _or_zero(self.anisotropic_damping, self.mass)),
                (stiffness, _or_zero(self.anisotropic_stiffness, self.mass)),
            )
        )  # type: ignore[return-value]


def _or_zero(matrix: Matrix | None, other: Matrix) -> Matrix:
    return 0.0 * other if matrix is None else matrix
