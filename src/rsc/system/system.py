"""The scene's matrices: the one thing that the simulator and the analytic module share."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

# the fields that systems in a stack have each for themselves: all but the speed schedules, whose numbers of corners may differ
_OF_EACH = (
    "mass_r", "damping_r", "stiffness_r", "gyroscopic_r", "mass_s", "damping_s", "stiffness_s", "contact_r", "contact_s",
    "unbalance", "unbalance_euler", "load", "gap", "friction", "contact_stiffness", "contact_damping", "ring_ecc",
    "diameter", "slip_velocity",
)  # fmt: skip


# the fields that a System has or not
SKEW = ("skew_stiffness_r", "skew_damping_r", "skew_stiffness_s", "skew_damping_s")
ANISOTROPIC = ("anisotropic_stiffness_r", "anisotropic_damping_r", "anisotropic_stiffness_s", "anisotropic_damping_s")


@dataclass(frozen=True)
class System:
    """Matrices and constants of one scene in SI units and rad/s (physics.md section 2).

    With complex displacements r = y + i z, rotor (2) and stator (3) are

        M_R r_R'' + (B_R - i phi' G_R) r_R' + K_R r_R
            = (unbalance phi'^2 - i unbalance_euler phi'') e^{i phi} + load - l_R F_C
        M_S r_S'' + B_S r_S' + K_S r_S = l_S F_C

    and on the left side of each body, where it has them,

        + i Q r' + i S r + C conj(r') + E conj(r),

    skew (cross-coupled) damping Q and stiffness S, alike in all directions, and what makes directions differ, anisotropic
    damping C and stiffness E.

    All arrays are read-only float64 or complex128; a rigid stator has M = 0 coordinates.
    """

    mass_r: NDArray[np.float64]  # (N, N) kg (kg m^2 on tilt rows), symmetric positive definite
    damping_r: NDArray[np.float64]  # (N, N) N s/m, symmetric
    stiffness_r: NDArray[np.float64]  # (N, N) N/m, symmetric
    gyroscopic_r: NDArray[np.float64]  # (N, N) kg m^2, real symmetric; the paper's G_1 = -i gyroscopic_r
    mass_s: NDArray[np.float64]  # (M, M) kg
    damping_s: NDArray[np.float64]  # (M, M) N s/m
    stiffness_s: NDArray[np.float64]  # (M, M) N/m
    contact_r: NDArray[np.float64]  # (N,) l_R: 1 at the contacting coordinate
    contact_s: NDArray[np.float64]  # (M,) l_S
    unbalance: NDArray[np.complex128]  # (N,) complex kg m: M_R eps_M, on tilts (M_R - gyroscopic_r) eps_M, times phi'^2 e^{i phi}
    unbalance_euler: NDArray[np.complex128]  # (N,) complex kg m: M_R eps_M, multiplies -i phi'' e^{i phi}
    load: NDArray[np.complex128]  # (N,) complex N: constant load f_0
    gap: float  # m, nominal radial gap s
    friction: float  # mu
    contact_stiffness: float  # N/m, k_C
    contact_damping: float  # N s/m, b_C
    ring_ecc: complex  # m, eps_A of the rotor's contact ring
    diameter: float | None  # m, d_R; None: one-sided friction, sigma = +1
    slip_velocity: float | None  # m/s, below which Coulomb friction falls linearly to 0; None with diameter None
    schedule_time: NDArray[np.float64]  # (n,) s, corners of the speed schedule, strictly increasing
    schedule_speed: NDArray[np.float64]  # (n,) rad/s at the corners, linear between them
    # of seals, journal bearings and supports, real or complex symmetric; None: none
    skew_stiffness_r: NDArray[np.float64] | None = None  # (N, N) N/m, S
    skew_damping_r: NDArray[np.float64] | None = None  # (N, N) N s/m, Q
    skew_stiffness_s: NDArray[np.float64] | None = None  # (M, M)
    skew_damping_s: NDArray[np.float64] | None = None  # (M, M)
    anisotropic_stiffness_r: NDArray[np.complex128] | None = None  # (N, N) N/m, E
    anisotropic_damping_r: NDArray[np.complex128] | None = None  # (N, N) N s/m, C
    anisotropic_stiffness_s: NDArray[np.complex128] | None = None  # (M, M)
    anisotropic_damping_s: NDArray[np.complex128] | None = None  # (M, M)

    @property
    def n_rotor(self) -> int:
        """Number of rotor coordinates N."""
        return self.mass_r.shape[-1]

    @property
    def n_stator(self) -> int:
        """Number of stator coordinates M (0 for a rigid stator)."""
        return self.mass_s.shape[-1]

    @property
    def gyroscopic(self) -> bool:
        """Whether whirls without unbalance depend on the rotor speed at all."""
        return bool(self.gyroscopic_r.any())

    @property
    def isotropic(self) -> bool:
        """Whether all directions are alike."""
        return all(getattr(self, name) is None for name in ANISOTROPIC)

    @property
    def skew(self) -> bool:
        """Whether there is cross-coupled stiffness or damping."""
        return any(getattr(self, name) is not None for name in SKEW)

    def speed_at(self, time: float | NDArray[np.float64]) -> np.float64 | NDArray[np.float64]:
        """Rotor speed phi' in rad/s at the given times in s (array or number)."""
        return np.interp(time, self.schedule_time, self.schedule_speed)

    def mirrored(self) -> "System":
        """The system in the mirror image z -> -z, where the rotor turns the other way: r, loads and unbalance become their
        conjugates, speeds and what is cross-coupled change their sign, and what is anisotropic becomes its conjugate."""
        conjugated = {name: getattr(self, name) for name in ("unbalance", "unbalance_euler", "load", "ring_ecc", *ANISOTROPIC)}
        signed = {name: getattr(self, name) for name in ("schedule_speed", *SKEW)}
        return replace(
            self,
            **{name: np.conj(value) for name, value in conjugated.items() if value is not None},
            **{name: -value for name, value in signed.items() if value is not None},
        )

    def at(self, i: ArrayLike) -> "System":
        """The systems at the places i (an array) of a stack, be it of one; what is no stack stands for every place."""
        if self.mass_r.ndim == 2:
            return self
        own = [name for name in SKEW + ANISOTROPIC if getattr(self, name) is not None]
        return replace(self, **{name: getattr(self, name)[i] for name in (*_OF_EACH, *own)})


def stacked(systems: Sequence[System]) -> System:
    """Stack of systems with equal numbers of coordinates.

    Returns
    -------
    System
        Every matrix, vector and constant has one more axis, the first; `diameter` and `slip_velocity` are NaN where a system has
        none, a skew or anisotropic matrix is zero where it has none and others have. A stack has no speed schedule (empty
        arrays): `speed_at` refuses.
    """
    fields: dict[str, Any] = {name: np.array([getattr(system, name) for system in systems]) for name in _OF_EACH}
    fields |= {name: fields[name].astype(float) for name in ("diameter", "slip_velocity")}  # None becomes NaN
    for name in SKEW + ANISOTROPIC:
        own = [getattr(system, name) for system in systems]
        if any(matrix is not None for matrix in own):
            none = np.zeros((systems[0].n_rotor if name.endswith("_r") else systems[0].n_stator,) * 2)
            fields[name] = np.array([none if matrix is None else matrix for matrix in own])
    return replace(systems[0], **fields, schedule_time=np.zeros(0), schedule_speed=np.zeros(0))


def together(systems: Sequence[System]) -> System:
    """The one System that all are, which stands for every place, or else their stack."""
    return systems[0] if all(system is systems[0] for system in systems) else stacked(systems)
