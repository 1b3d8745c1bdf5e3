"""One body, rotor or stator without contact: the one place where its equation of motion stands as data.

    M r'' + (B + i Q - i Omega G) r' + C conj(r') + (K + i S) r + E conj(r) + D_i (r' - i Omega r) = forces

K, S, E, B, Q and C may follow the rotor speed Omega (knots.py).

A harmonic motion r = x e^{i Psi t} gives A(Psi, Omega) x = input with the complex symmetric dynamic stiffness

    A = K - Psi^2 M + i Psi B + Psi Omega G + i S - Psi Q + i (Psi - Omega) D_i,

what acts on the conjugates, C and E, left out: they join the lines at Psi and -Psi. Rotating damping D_i makes damping and skew
stiffness of a body follow the rotor speed, B + D_i and S - Omega D_i, knots all of them: whoever asks for them goes through
`Body.at_speed` first.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import ArrayLike, NDArray

from rsc.system import knots as knot_tables
from rsc.system.knots import ANISOTROPIC, SKEW, Knots

Matrix = Any  # a square ndarray or a matrix of scipy.sparse

# what acts on r, in the order in which A is added up
TERMS = ("stiffness", "mass", "damping", "gyroscopic", "skew_stiffness", "skew_damping", "rotating_damping")


def factors(Psi: ArrayLike, Omega: ArrayLike) -> dict[str, Any]:
    """What each matrix is multiplied with in A(Psi, Omega)."""
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
    """What each matrix is multiplied with in dA/dPsi."""
    Psi, Omega = np.asarray(Psi), np.asarray(Omega)
    one = np.ones(np.broadcast(Psi, Omega).shape)
    turning = {"gyroscopic": Omega * one, "skew_damping": -one}
    return {"mass": -2.0 * Psi * one, "damping": 1j * one, **turning, "rotating_damping": 1j * one}


@dataclass(frozen=True, eq=False)
class Body:
    """Matrices of one body in SI units, n complex coordinates; what it does not have is None.

    The matrices are symmetric, those on r real and those on conj(r) complex: ndarrays, or matrices of scipy.sparse before a
    reduction. Of a stack of bodies every array has one more axis, the first.
    """

    mass: Matrix  # (n, n) M, kg (kg m^2 on tilts), positive definite
    damping: Matrix  # (n, n) B, N s/m
    stiffness: Matrix  # (n, n) K, N/m
    # (n,) l: the displacement at the contact is l . r; not a number where there are several contacts (`Contact` has their rows);
    # of a body before its reduction also (c, n), a row for each of c places that touch
    contact: NDArray[np.float64]
    gyroscopic: Matrix | None = None  # (n, n) G, kg m^2; the paper's G_1 = -i G
    skew_stiffness: Matrix | None = None  # (n, n) S, N/m: k_yz = -k_zy = -S
    skew_damping: Matrix | None = None  # (n, n) Q, N s/m
    anisotropic_stiffness: Matrix | None = None  # (n, n) E, N/m
    anisotropic_damping: Matrix | None = None  # (n, n) C, N s/m
    rotating_damping: Matrix | None = None  # (n, n) D_i, N s/m, of what turns with the rotor: acts on r' - i Omega r
    knots: Knots | None = None  # what the matrices above have besides at some rotor speeds
    # (n,) kg m, times Omega^2 e^{i Omega t}; of a body before its reduction (n, m), one column an unbalance
    unbalance: NDArray[np.complex128] = field(default_factory=lambda: np.zeros((0, 0), complex))
    unbalance_euler: NDArray[np.complex128] = field(default_factory=lambda: np.zeros(0, complex))  # (n,) kg m, of the run-up term
    load: NDArray[np.complex128] = field(default_factory=lambda: np.zeros(0, complex))  # (n,) N, constant
    observers: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))  # (q, n) rows of displacements to be known

    @property
    def n_coordinates(self) -> int:
        """Number of complex coordinates n."""
        return int(self.mass.shape[-1])

    @property
    def terms(self) -> dict[str, Matrix]:
        """The matrices on r that the body has, by the name of their field."""
        return {name: getattr(self, name) for name in TERMS if getattr(self, name) is not None}

    @property
    def inputs(self) -> NDArray[np.complex128]:
        """(n, c + m + 1): the contact rows (mostly one), the unbalances and the load as columns."""
        return np.column_stack([self.contact.T, self.unbalance, self.load])

    @property
    def outputs(self) -> NDArray[np.float64]:
        """(c + q, n): the contact rows and the observers."""
        return np.vstack([self.contact, self.observers])

    @property
    def turns(self) -> bool:
        """Whether the dynamic stiffness depends on the rotor speed."""
        return self.follows or self.gyroscopic is not None

    @property
    def follows(self) -> bool:
        """Whether stiffness and damping follow the rotor speed, so that `at_speed` is another body."""
        return self.rotating_damping is not None or self.knots is not None

    @property
    def mirrored(self) -> bool:
        """Whether backward and forward are alike, A(-Psi) = conj A(Psi)."""
        return not self.follows and self.gyroscopic is self.skew_stiffness is self.skew_damping is None

    @property
    def skew(self) -> bool:
        """Whether there is cross-coupled stiffness or damping, at some rotor speed at least."""
        return self.rotating_damping is not None or self._has(SKEW)

    @property
    def directed(self) -> bool:
        """Whether a matrix of its own is cross-coupled or tells directions apart."""
        return self._has(SKEW) or not self.isotropic

    @property
    def isotropic(self) -> bool:
        """Whether all directions are alike."""
        return not self._has(ANISOTROPIC)

    def _has(self, names):
        """Whether there is one of some matrices, at some rotor speed at least."""
        return any(getattr(self, name) is not None for name in names) or (self.knots is not None and self.knots.has(names))

    def dynamic_stiffness(self, Psi: ArrayLike, Omega: ArrayLike) -> Matrix:
        """A(Psi, Omega) in N/m for frequencies and speeds in rad/s; of ndarrays one matrix for each place of Psi and Omega."""
        self.refuse_knots()
        return _sum(factors(Psi, Omega), self.terms)

    def slope(self, Psi: ArrayLike, Omega: ArrayLike) -> Matrix:
        """dA/dPsi at constant Omega, N s/m."""
        factor = slope_factors(Psi, Omega)
        return _sum(factor, {name: matrix for name, matrix in self.terms.items() if name in factor})

    @property
    def static(self) -> Matrix:
        """K + i S, what of A does not depend on Psi; real where nothing is skew. Of a body at a speed, as all that follows."""
        self._refuse_following()
        return self.stiffness if self.skew_stiffness is None else self.stiffness + 1j * self.skew_stiffness

    def turning(self, Omega: ArrayLike) -> Matrix:
        """Omega G - Q, of one body or a stack: what depends on the sense of rotation beside i B."""
        self._refuse_following()
        turning = np.asarray(Omega)[..., None, None] * self.gyroscopic
        return turning if self.skew_damping is None else turning - self.skew_damping

    def by_frequency(self, Omega: ArrayLike) -> Matrix:
        """D = Omega G - Q + i B, the factor of Psi in A."""
        return self.turning(Omega) + 1j * self.damping

    def at_speed(self, Omega: ArrayLike) -> "Body":
        """The body as it is at rotor speeds in rad/s: the one door to coefficients that follow the speed.

        Everything that asks for stiffness or damping at a speed (receptance, stability, free vibrations) asks this body; a body
        whose coefficients are constant is returned as it is, for any Omega. Rotating damping D_i becomes damping B + D_i and skew
        stiffness S - Omega D_i. Gyroscopics stay what they are: their factor is Omega itself.

        Parameters
        ----------
        Omega : float, or array: of a single body a stack of that shape is made, of a stack each has its own or all have one

        Returns
        -------
        Body
            `follows` is false.
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
        """The body with the coefficients that its knots give it at rotor speeds in rad/s; rotating damping stays."""
        if self.knots is None:
            return self
        body, followed = replace(self, knots=None), self.knots.at(Omega)
        if body.mass.ndim == 2:
            body = body.repeated(np.shape(Omega))
        own = {name: getattr(body, name) for name in followed}
        return replace(body, **{name: part if own[name] is None else own[name] + part for name, part in followed.items()})

    def repeated(self, shape: tuple[int, ...]) -> "Body":
        """A stack of this body, so many times; () leaves it as it is."""

        def many(part):
            return part.repeated(shape) if isinstance(part, Knots) else np.broadcast_to(part, shape + part.shape)

        parts = ((item.name, getattr(self, item.name)) for item in fields(self)) if shape else ()
        return replace(self, **{name: many(part) for name, part in parts if part is not None})

    def refuse_knots(self) -> None:
        """Raise ValueError where matrices follow the speed from knot to knot: they are not known before `at_speed`."""
        if self.knots is not None:
            raise ValueError("coefficients of this body follow the rotor speed from knot to knot: at_speed comes first")

    def _refuse_following(self):
        if self.follows:
            raise ValueError("stiffness and damping of this body follow the rotor speed: at_speed comes first")

    def mirror(self) -> "Body":
        """The body in the mirror image z -> -z: what is skew changes its sign, what is complex becomes its conjugate."""
        conjugated = {name: getattr(self, name) for name in ("unbalance", "unbalance_euler", "load", *ANISOTROPIC)}
        signed = {name: getattr(self, name) for name in SKEW}
        return replace(
            self,
            **{name: np.conj(value) for name, value in conjugated.items() if value is not None},
            **{name: -value for name, value in signed.items() if value is not None},
            knots=None if self.knots is None else self.knots.mirror(),
        )

    def at(self, i: ArrayLike) -> "Body":
        """The bodies at the places i (an array) of a stack, be it of one; what is no stack stands for every place."""
        if self.mass.ndim == 2:
            return self
        parts = ((item.name, getattr(self, item.name)) for item in fields(self) if item.name != "knots")
        knots = None if self.knots is None else self.knots.chosen(i)
        return replace(self, **{name: part[i] for name, part in parts if part is not None and len(part)}, knots=knots)


def _sum(factor, terms):
    if scipy.sparse.issparse(terms["mass"]):
        return sum(factor[name] * matrix for name, matrix in terms.items())
    return sum(factor[name][..., None, None] * matrix for name, matrix in terms.items())


def stacked(bodies: Sequence[Body]) -> Body:
    """Stack of bodies with equal numbers of coordinates; a matrix that one lacks and others have is zero there."""
    made: dict[str, Any] = {}
    for item in fields(Body):
        parts = [getattr(body, item.name) for body in bodies]
        if item.name == "knots" and any(part is not None for part in parts):
            made["knots"] = knot_tables.stacked(parts, bodies[0].n_coordinates)
        elif any(part is not None for part in parts):
            made[item.name] = np.array([np.zeros_like(bodies[0].mass) if part is None else part for part in parts])
    return Body(**made)


def joined(first: Body, second: Body) -> Body:
    """Two bodies, or stacks, as one of all their coordinates, without what acts on it: block-diagonal matrices, [l, l]."""
    for body in (first, second):
        body.refuse_knots()
    blocks = {name: _blocks(first, second, name) for name in TERMS}
    return Body(**blocks, contact=np.concatenate([first.contact, second.contact], axis=-1))


def _blocks(first, second, name):
    parts = [getattr(body, name) for body in (first, second)]
    if parts[0] is parts[1] is None:
        return None
    n, m = first.n_coordinates, second.n_coordinates
    block = np.zeros((*first.mass.shape[:-2], n + m, n + m))
    for part, place in zip(parts, (np.s_[..., :n, :n], np.s_[..., n:, n:]), strict=True):
        if part is not None:
            block[place] = part
    return block
