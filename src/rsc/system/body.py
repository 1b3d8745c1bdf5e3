"""One body (rotor or stator) without contact: the matrices of its equation of motion.

    M r'' + (B + i Q - i Omega G) r' + C conj(r') + (K + i S) r + E conj(r) + D_i (r' - i Omega r) = Lz z + forces
    z' = Az z + Bz r + Bv r'

K, S, E, B, Q and C may follow the rotor speed Omega (knots.py). z are first-order states, of magnetic bearings or viscoelastic
supports, alike in both directions.

A harmonic motion r = x e^{i Psi t} gives A(Psi, Omega) x = input with the complex symmetric dynamic stiffness

    A = K - Psi^2 M + i Psi B + Psi Omega G + i S - Psi Q + i (Psi - Omega) D_i - Lz (i Psi - Az)^-1 (Bz + i Psi Bv),

without the terms on the conjugates, C and E, which couple the lines at Psi and -Psi. The term of the states is not
symmetric where they act elsewhere than they sense. Rotating damping D_i makes damping and skew stiffness depend on the rotor
speed, B + D_i and S - Omega D_i, and so do knots: call `Body.at_speed` first.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import ArrayLike, NDArray

from rsc.errors import SolverError
from rsc.system import knots as knot_tables
from rsc.system.knots import ANISOTROPIC, SKEW, Knots

Matrix = Any  # a square ndarray or a matrix of scipy.sparse

# matrices that act on r, in the order of summation of A
TERMS = ("stiffness", "mass", "damping", "gyroscopic", "skew_stiffness", "skew_damping", "rotating_damping")

# arrays of first-order states, with their shapes in numbers of coordinates n and states p
STATES = {
    "state_matrix": "pp",
    "state_displacement": "pn",
    "state_velocity": "pn",
    "state_force": "np",
    "state_stiffness": "nn",
}


def factors(Psi: ArrayLike, Omega: ArrayLike) -> dict[str, Any]:
    """Factor of each matrix in A(Psi, Omega)."""
    Psi, Omega = np.asarray(Psi), np.asarray(Omega)
    one = np.ones(np.broadcast(Psi, Omega).shape)
    return {
        "stiffness": one,
        "mass": -(Psi**2) * one,
        "damping": 1j * Psi * one,
        "gyroscopic": Psi * Omega,
        "skew_stiffness": 1j * one,
        "skew_damping": -Psi * one,
        "rotating_damping": 1j * (Psi - Omega) * one,
    }


def slope_factors(Psi: ArrayLike, Omega: ArrayLike) -> dict[str, Any]:
    """Factor of each matrix in dA/dPsi."""
    Psi, Omega = np.asarray(Psi), np.asarray(Omega)
    one = np.ones(np.broadcast(Psi, Omega).shape)
    turning = {"gyroscopic": Omega * one, "skew_damping": -one}
    return {"mass": -2.0 * Psi * one, "damping": 1j * one, **turning, "rotating_damping": 1j * one}


@dataclass(frozen=True, eq=False)
class Body:
    """Matrices of one body in SI units, n complex coordinates; absent ones are None.

    All matrices are symmetric, real if they act on r and complex if on conj(r): ndarrays, or scipy.sparse matrices before a
    reduction. A stack of bodies has a leading axis in every array.
    """

    mass: Matrix  # (n, n) M, kg (kg m^2 on tilts), positive definite
    damping: Matrix  # (n, n) B, N s/m
    stiffness: Matrix  # (n, n) K, N/m
    # (n,) l: the displacement at the contact is l . r; NaN with several contacts (`Contact` has their rows); before a
    # reduction also (c, n), one row for each of c contact locations
    contact: NDArray[np.float64]
    gyroscopic: Matrix | None = None  # (n, n) G, kg m^2; the paper's G_1 = -i G
    skew_stiffness: Matrix | None = None  # (n, n) S, N/m: k_yz = -k_zy = -S
    skew_damping: Matrix | None = None  # (n, n) Q, N s/m
    anisotropic_stiffness: Matrix | None = None  # (n, n) E, N/m
    anisotropic_damping: Matrix | None = None  # (n, n) C, N s/m
    rotating_damping: Matrix | None = None  # (n, n) D_i, N s/m, rotating damping: acts on r' - i Omega r
    knots: Knots | None = None  # speed-dependent parts that are added to the matrices above
    # first-order states: Az (p, p), Bz and Bv (p, n), Lz (n, p), and (n, n) the part of the stiffness that belongs to them, N/m
    state_matrix: NDArray[np.float64] | None = None
    state_displacement: NDArray[np.float64] | None = None
    state_velocity: NDArray[np.float64] | None = None
    state_force: NDArray[np.float64] | None = None
    state_stiffness: NDArray[np.float64] | None = None
    # (n,) kg m, times Omega^2 e^{i Omega t}; before a reduction (n, m), one column per unbalance
    unbalance: NDArray[np.complex128] = field(default_factory=lambda: np.zeros((0, 0), complex))
    unbalance_euler: NDArray[np.complex128] = field(default_factory=lambda: np.zeros(0, complex))  # (n,) kg m, Euler term
    load: NDArray[np.complex128] = field(default_factory=lambda: np.zeros(0, complex))  # (n,) N, constant
    observers: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))  # (q, n) rows of observed displacements

    @property
    def n_coordinates(self) -> int:
        """Number of complex coordinates n."""
        return int(self.mass.shape[-1])

    @property
    def n_states(self) -> int:
        """Number of complex first-order states p."""
        return 0 if self.state_matrix is None else int(self.state_matrix.shape[-1])

    @property
    def symmetric(self) -> bool:
        """Whether A is symmetric: without first-order states, also as coordinates (`with_states`), which have no mass."""
        return not self.n_states and bool(np.all(self.mass[..., -1, -1] != 0.0))

    @property
    def terms(self) -> dict[str, Matrix]:
        """Matrices that act on r and are present, by field name."""
        return {name: getattr(self, name) for name in TERMS if getattr(self, name) is not None}

    @property
    def inputs(self) -> NDArray[np.complex128]:
        """(n, c + m + 1): contact rows (usually one), unbalances and load as columns."""
        return np.column_stack([self.contact.T, self.unbalance, self.load])

    @property
    def outputs(self) -> NDArray[np.float64]:
        """(c + q, n): contact rows and observers."""
        return np.vstack([self.contact, self.observers])

    @property
    def turns(self) -> bool:
        """Whether the dynamic stiffness depends on the rotor speed."""
        return self.follows or self.gyroscopic is not None

    @property
    def follows(self) -> bool:
        """Whether stiffness or damping depend on the rotor speed, so that `at_speed` returns a different body."""
        return self.rotating_damping is not None or self.knots is not None

    @property
    def mirrored(self) -> bool:
        """Whether forward and backward whirl are equivalent, A(-Psi) = conj A(Psi)."""
        return not self.follows and self.gyroscopic is self.skew_stiffness is self.skew_damping is None

    @property
    def skew(self) -> bool:
        """Whether there is cross-coupled stiffness or damping at any rotor speed."""
        return self.rotating_damping is not None or self._has(SKEW)

    @property
    def directed(self) -> bool:
        """Whether there is a cross-coupled or anisotropic matrix."""
        return self._has(SKEW) or not self.isotropic

    @property
    def isotropic(self) -> bool:
        """Whether no matrix distinguishes directions."""
        return not self._has(ANISOTROPIC)

    def _has(self, names: Sequence[str]) -> bool:
        """Whether one of these matrices is present at any rotor speed."""
        return any(getattr(self, name) is not None for name in names) or (self.knots is not None and self.knots.has(names))

    def dynamic_stiffness(self, Psi: ArrayLike, Omega: ArrayLike) -> Matrix:
        """A(Psi, Omega) in N/m for frequencies and speeds in rad/s, which broadcast: (..., n, n) if the matrices are ndarrays."""
        self.refuse_knots()
        return _sum(factors(Psi, Omega), self.terms)

    def slope(self, Psi: ArrayLike, Omega: ArrayLike) -> Matrix:
        """dA/dPsi at constant Omega, N s/m."""
        factor = slope_factors(Psi, Omega)
        return _sum(factor, {name: matrix for name, matrix in self.terms.items() if name in factor})

    @property
    def static(self) -> Matrix:
        """K + i S, the part of A independent of Psi; real without skew stiffness. ValueError if `follows`, as for those below."""
        self._refuse_following()
        self.refuse_states()
        return self.stiffness if self.skew_stiffness is None else self.stiffness + 1j * self.skew_stiffness

    def turning(self, Omega: ArrayLike) -> Matrix:
        """Omega G - Q of one body or a stack: the part of the factor of Psi that depends on the sense of rotation."""
        self._refuse_following()
        self.refuse_states()
        turning = np.asarray(Omega)[..., None, None] * self.gyroscopic
        return turning if self.skew_damping is None else turning - self.skew_damping

    def by_frequency(self, Omega: ArrayLike) -> Matrix:
        """D = Omega G - Q + i B, the factor of Psi in A."""
        return self.turning(Omega) + 1j * self.damping

    def at_speed(self, Omega: ArrayLike) -> "Body":
        """The body at rotor speeds in rad/s, with constant coefficients: speed-dependent ones are available this way only.

        A body with constant coefficients is returned unchanged, for any Omega. Rotating damping D_i becomes damping B + D_i and
        skew stiffness S - Omega D_i. Gyroscopic matrices stay, since their factor is Omega itself.

        Parameters
        ----------
        Omega : float or array
            A single body becomes a stack of this shape; for a stack a scalar, or one speed for each of its bodies.

        Returns
        -------
        Body
            Its `follows` is False.
        """
        if not self.follows:
            return self
        body, Omega = self.at_knots(Omega), np.asarray(Omega, dtype=float)
        if body.rotating_damping is None:
            return body
        body = body.repeated(Omega.shape) if body.mass.ndim == 2 else body
        turned = Omega[..., None, None] * body.rotating_damping
        skew = -turned if body.skew_stiffness is None else body.skew_stiffness - turned
        return replace(body, damping=body.damping + body.rotating_damping, skew_stiffness=skew, rotating_damping=None)

    def at_knots(self, Omega: ArrayLike) -> "Body":
        """The body with the coefficients of its knots interpolated at rotor speeds in rad/s; rotating damping is kept."""
        if self.knots is None:
            return self
        body, followed = replace(self, knots=None), self.knots.at(Omega)
        if body.mass.ndim == 2:
            body = body.repeated(np.shape(Omega))
        constant = {name: getattr(body, name) for name in followed}
        sums = {name: part if constant[name] is None else constant[name] + part for name, part in followed.items()}
        return replace(body, **sums)

    def repeated(self, shape: tuple[int, ...]) -> "Body":
        """A stack of copies of this body with the given leading shape; () returns it unchanged."""

        def many(part: Any) -> Any:
            return part.repeated(shape) if isinstance(part, Knots) else np.broadcast_to(part, shape + part.shape)

        parts = ((item.name, getattr(self, item.name)) for item in fields(self)) if shape else ()
        return replace(self, **{name: many(part) for name, part in parts if part is not None})

    def refuse_knots(self) -> None:
        """Raise ValueError if matrices are interpolated between knots, and thus unknown before `at_speed`."""
        if self.knots is not None:
            raise ValueError("coefficients of this body are interpolated over the rotor speed: call at_speed first")

    def without_states(self) -> "Body":
        """The body without its first-order states; the stiffness that belongs to them stays."""
        without: dict[str, Any] = dict.fromkeys(STATES)
        return replace(self, **without) if self.n_states else self

    def with_other_states(self, states: dict[str, Any]) -> "Body":
        """The body with other first-order states, given by the names of `STATES`, and the stiffness that belongs to them."""
        before = 0.0 if self.state_stiffness is None else self.state_stiffness
        return replace(self, **states, stiffness=self.stiffness - before + states["state_stiffness"])

    def with_states(self) -> "Body":
        """The body with its first-order states as coordinates without mass behind its own, in the matrices of A and in `contact`:
        the equation of z is -Bz r - Bv r' + z' - Az z = 0. A body without states is returned unchanged."""
        if not self.n_states:
            return self
        states: Any = self
        self.refuse_knots()
        n, p = self.n_coordinates, self.n_states
        wide: dict[str, Any] = {name: np.zeros((*self.mass.shape[:-2], n + p, n + p)) for name in self.terms}
        for name, matrix in wide.items():
            matrix[..., :n, :n] = self.terms[name]
        wide["damping"][..., n:, :n], wide["damping"][..., n:, n:] = -states.state_velocity, np.eye(p)
        wide["stiffness"][..., :n, n:], wide["stiffness"][..., n:, n:] = -states.state_force, -states.state_matrix
        wide["stiffness"][..., n:, :n] = -states.state_displacement
        contact = np.concatenate([self.contact, np.zeros((*self.contact.shape[:-1], p))], axis=-1)
        return replace(self.without_states(), **wide, contact=contact)

    def refuse_states(self) -> None:
        """SolverError for a body with first-order states, where they are not supported."""
        if self.n_states:
            what = "first-order states (states, magnetic_bearings) are not predicted yet"
            raise SolverError(f"{what} where directions differ; `rsc run` simulates them")

    def _refuse_following(self) -> None:
        if self.follows:
            raise ValueError("stiffness and damping of this body depend on the rotor speed: call at_speed first")

    def mirror(self) -> "Body":
        """The body in the mirror image y -> -y: skew matrices change sign, complex matrices become their conjugates, complex
        vectors minus their conjugates."""
        vectors = {name: getattr(self, name) for name in ("unbalance", "unbalance_euler", "load")}
        conjugated = {name: getattr(self, name) for name in ANISOTROPIC}
        signed = {name: getattr(self, name) for name in SKEW}
        return replace(
            self,
            **{name: -np.conj(value) for name, value in vectors.items()},
            **{name: np.conj(value) for name, value in conjugated.items() if value is not None},
            **{name: -value for name, value in signed.items() if value is not None},
            knots=None if self.knots is None else self.knots.mirror(),
        )

    def at(self, i: ArrayLike) -> "Body":
        """The bodies at indices i (an array) of a stack; a single body is returned unchanged."""
        if self.mass.ndim == 2:
            return self
        parts = ((item.name, getattr(self, item.name)) for item in fields(self) if item.name != "knots")
        knots = None if self.knots is None else self.knots.chosen(i)
        return replace(self, **{name: part[i] for name, part in parts if part is not None and len(part)}, knots=knots)


def _sum(factor: dict[str, Any], terms: dict[str, Matrix]) -> Matrix:
    if scipy.sparse.issparse(terms["mass"]):
        return sum(factor[name] * matrix for name, matrix in terms.items())
    return sum(factor[name][..., None, None] * matrix for name, matrix in terms.items())


def stacked(bodies: Sequence[Body]) -> Body:
    """Stack of bodies with equal numbers of coordinates; a matrix that only some have is zero for the others."""
    made: dict[str, Any] = {}
    for item in fields(Body):
        parts = [getattr(body, item.name) for body in bodies]
        if item.name == "knots" and any(part is not None for part in parts):
            made["knots"] = knot_tables.stacked(parts, bodies[0].n_coordinates)
        elif any(part is not None for part in parts):
            made[item.name] = np.array([np.zeros_like(bodies[0].mass) if part is None else part for part in parts])
    return Body(**made)


def joined(first: Body, second: Body) -> Body:
    """Two bodies (or stacks) as one uncoupled body: block-diagonal matrices, contact row [l, l], no unbalance and load."""
    for body in (first, second):
        body.refuse_knots()
    blocks: dict[str, Any] = {name: _blocks(first, second, name) for name in TERMS}
    blocks |= {name: _state_blocks(first, second, name) for name in STATES}
    return Body(**blocks, contact=np.concatenate([first.contact, second.contact], axis=-1))


def _state_blocks(first: Body, second: Body, name: str) -> Matrix | None:
    """Block-diagonal matrix of the first-order states of two bodies; None without any."""
    if first.n_states + second.n_states == 0:
        return None
    sizes = {"p": (first.n_states, second.n_states), "n": (first.n_coordinates, second.n_coordinates)}
    (rows, more_rows), (columns, more_columns) = (sizes[kind] for kind in STATES[name])
    block = np.zeros((*first.mass.shape[:-2], rows + more_rows, columns + more_columns))
    for body, place in ((first, np.s_[..., :rows, :columns]), (second, np.s_[..., rows:, columns:])):
        if body.n_states:
            block[place] = getattr(body, name)
    return block


def _blocks(first: Body, second: Body, name: str) -> Matrix | None:
    parts = [getattr(body, name) for body in (first, second)]
    if parts[0] is parts[1] is None:
        return None
    n, m = first.n_coordinates, second.n_coordinates
    block = np.zeros((*first.mass.shape[:-2], n + m, n + m))
    for part, place in zip(parts, (np.s_[..., :n, :n], np.s_[..., n:, n:]), strict=True):
        if part is not None:
            block[place] = part
    return block
