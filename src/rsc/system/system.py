"""The scene's matrices: the one thing that the simulator and the analytic module share."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rsc.errors import SolverError
from rsc.system import body as bodies
from rsc.system.body import Body

ROUNDING = 1e-9  # of the largest damping of a body, below zero


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """Force of a contact on the penetration p, its rate and the slip (physics.md section 2); numbers, or (n,) of a stack."""

    stiffness: float  # N/m, k_C
    damping: float  # N s/m, b_C, acts only while the surfaces separate
    friction: float  # mu
    diameter: float | None = None  # m, d_R; None: one-sided friction, sigma = `System.sense`
    slip_velocity: float | None = None  # m/s, below which Coulomb friction falls linearly to 0; None with diameter None
    # of a stator whose surface turns about its centre, J omega' = mu sigma F_N d_R/2 - drag omega
    race_inertia: float | None = None  # kg m^2, J
    race_drag: float | None = None  # N m s


@dataclass(frozen=True, eq=False)
class SystemContact:
    """One place where rotor and stator may touch: d = l_R . r_R - l_S . r_S + ring e^{i phi} - offset."""

    law: ContactLaw
    gap: float  # m, nominal radial gap s
    rotor: NDArray[np.float64]  # (N,) l_R
    stator: NDArray[np.float64]  # (M,) l_S
    ring: complex = 0j  # m, eccentricity eps_A of the rotor's contact ring
    offset: complex = 0j  # m, where the stator's centre is at rest
    name: str = ""  # "" where there is one contact that has none
    in_rotor: bool = False  # whether two places of the rotor touch, or may: of a reduced one nobody knows


def only_one(contacts: Sequence[Any]) -> Any:
    """The contact of a scene or system, for whoever treats one only.

    Raises
    ------
    SolverError
        There are several.
    """
    if len(contacts) != 1:
        names = ", ".join(contact.name for contact in contacts)
        raise SolverError(f"the scene has {len(contacts)} contacts ({names}) and this is for one only; rsc run simulates several")
    return contacts[0]


@dataclass(frozen=True, eq=False)
class SystemClearance:
    """A place that is only watched: |rotor . r_R - stator . r_S| may reach the gap, and no force follows. Of a stack of systems
    gap and rows have one more axis, the first."""

    name: str
    gap: float  # m, radial
    rotor: NDArray[np.float64]  # (N,)
    stator: NDArray[np.float64]  # (M,), zeros against the ground


@dataclass(frozen=True, eq=False)
class SystemDrive:
    """A drive that gives way, J phi'' = T(phi') less what brakes the rotor (physics.md); T linear between knots (k, 2) of phi' in
    rad/s and N m, constant beyond."""

    inertia: float  # kg m^2, J, that of the unbalance included
    torques: tuple[NDArray[np.float64], ...]  # the knots of each part of the run
    ends: tuple[float, ...]  # s, of these parts
    fastest: float  # rad/s, a speed that the run hardly passes
    # N m, w = U^H g of the unbalance U and of gravity, the acceleration g: the weight turns the shaft with Im(w e^{-i phi})
    weight: complex = 0j

    def torque(self, Omega: ArrayLike, part: int = 0) -> NDArray[np.float64]:
        """T in N m at speeds in rad/s, in a part of the run."""
        knots, torque = self.torques[part].T
        return np.asarray(np.interp(np.asarray(Omega, dtype=float), knots, torque))


@dataclass(frozen=True, eq=False)
class System:
    """Bodies, contacts and drive of one scene in SI units and rad/s (physics.md section 2).

    With complex displacements r = y + i z, rotor (2) and stator (3) are, each with the matrices of its `Body`,

        M_R r_R'' + (B_R - i phi' G_R) r_R' + K_R r_R
            = (unbalance phi'^2 - i unbalance_euler phi'') e^{i phi} + load - l_R F_C
        M_S r_S'' + B_S r_S' + K_S r_S = l_S F_C

    All arrays are read-only float64 or complex128; a rigid stator has M = 0 coordinates.
    """

    rotor: Body  # N coordinates
    stator: Body  # M coordinates, no gyroscopics and nothing that acts on it but the contact
    contacts: tuple[SystemContact, ...]
    schedule_time: NDArray[np.float64]  # (n,) s, corners of the speed schedule, strictly increasing
    schedule_speed: NDArray[np.float64]  # (n,) rad/s at the corners, linear between them
    clearances: tuple[SystemClearance, ...] = ()
    drive: SystemDrive | None = None  # of a speed that is integrated; the schedule is then a constant first speed

    @property
    def contact(self) -> SystemContact:
        """The contact, for whoever can treat one only, around the bearing centre; raises SolverError of others."""
        only: SystemContact = only_one(self.contacts)
        if np.any(only.offset):
            raise SolverError("contact.offset: only a stator around the bearing centre can be computed yet")
        return only

    def at_contact(self, name: str) -> "System":
        """The system without its other contacts, and without a race, which whoever treats one contact does not know."""
        own = next(contact for contact in self.contacts if contact.name == name)
        own = replace(own, law=replace(own.law, race_inertia=None, race_drag=None))
        rotor, stator = replace(self.rotor, contact=own.rotor), replace(self.stator, contact=own.stator)
        return replace(self, rotor=rotor, stator=stator, contacts=(own,))

    @property
    def law(self) -> ContactLaw:
        """The law of the contact."""
        return self.contact.law

    @property
    def bodies(self) -> tuple[Body, Body]:
        """Rotor and stator."""
        return self.rotor, self.stator

    @property
    def n_rotor(self) -> int:
        """float of rotor coordinates N."""
        return self.rotor.n_coordinates

    @property
    def n_stator(self) -> int:
        """float of stator coordinates M (0 for a rigid stator)."""
        return self.stator.n_coordinates

    @property
    def relative(self) -> NDArray[np.float64]:
        """(N + M,) [l_R, -l_S] of the only contact, as the bodies have its rows."""
        only_one(self.contacts)
        return np.concatenate([self.rotor.contact, -self.stator.contact], axis=-1)

    @property
    def unbalance_inertia(self) -> float:
        """u^H M^-1 u of the unbalance, kg m^2: what it adds to the inertia about the shaft."""
        u = self.rotor.unbalance_euler
        return float((u.conj() @ np.linalg.solve(self.rotor.mass, u)).real)

    @property
    def fastest(self) -> float:
        """Largest magnitude of the rotor speed, rad/s."""
        return float(np.abs(self.schedule_speed).max()) if self.drive is None else self.drive.fastest

    @property
    def isotropic(self) -> bool:
        """Whether all directions are alike."""
        return all(body.isotropic for body in self.bodies)

    @property
    def skew(self) -> bool:
        """Whether there is cross-coupled stiffness or damping."""
        return any(body.skew for body in self.bodies)

    @property
    def driven(self) -> bool:
        """Whether something beside friction can feed a whirl: cross-coupling, rotating damping, or damping that is negative."""
        bodies = [self.at_speed(Omega).rotor for Omega in self.knot_speed] if len(self.knot_speed) else [self.rotor]
        rates = [np.linalg.eigvalsh(body.damping) for body in (*bodies, self.stator) if body.damping.size]
        return self.skew or any(own.min() < -ROUNDING * np.abs(own).max() for own in rates)

    @property
    def follows(self) -> bool:
        """Whether stiffness or damping follow the rotor speed."""
        return any(body.follows for body in self.bodies)

    @property
    def knot_speed(self) -> NDArray[np.float64]:
        """(k,) rad/s, rotor speeds where coefficients that follow the speed have their knots; none where none do so."""
        return np.zeros(0) if self.rotor.knots is None else self.rotor.knots.speed

    @property
    def turns(self) -> bool:
        """Whether whirls without unbalance depend on the rotor speed at all."""
        return self.follows or bool(np.any(self.rotor.gyroscopic))

    @property
    def sense(self) -> float:
        """Which way the rotor first turns, 1 forward (also where it never turns) or -1 backwards."""
        turning = self.schedule_speed[self.schedule_speed != 0.0]
        return -1.0 if len(turning) and turning[0] < 0.0 else 1.0

    def at_speed(self, Omega: ArrayLike) -> "System":
        """The system as it is at a rotor speed in rad/s (`Body.at_speed`), of several speeds a stack; as it stands where no
        coefficients follow the speed."""
        if not self.follows:
            return self
        shape = np.shape(Omega) if self.rotor.mass.ndim == 2 else ()
        system = self.repeated(shape) if shape else self
        return replace(system, rotor=system.rotor.at_speed(Omega))

    @property
    def at_first_speed(self) -> "System":
        """The system as it is where its run begins."""
        return self.at_speed(self.schedule_speed[0]) if self.follows else self

    def repeated(self, shape: tuple[int, ...]) -> "System":
        """A stack of this system, so many times."""
        contacts = tuple(_each(lambda value: _repeated(_numbers(value)[0], shape), contact) for contact in self.contacts)
        clearances = tuple(_each(lambda value: _repeated(value, shape), place) for place in self.clearances)
        rotor, stator = self.rotor.repeated(shape), self.stator.repeated(shape)
        return replace(self, rotor=rotor, stator=stator, contacts=contacts, clearances=clearances)

    def joined(self) -> Body:
        """Rotor and stator, or stacks of them, as one Body of N + M coordinates, contact row [l_R, l_S]."""
        return bodies.joined(*self.bodies)

    def speed_at(self, time: float | NDArray[np.float64]) -> np.float64 | NDArray[np.float64]:
        """Rotor speed phi' in rad/s at the given times in s (array or number)."""
        return np.interp(time, self.schedule_time, self.schedule_speed)

    def with_friction(self, friction: float) -> "System":
        """The system with another coefficient of friction."""
        contact = self.contact
        return replace(self, contacts=(replace(contact, law=replace(contact.law, friction=friction)),))

    def mirrored(self) -> "System":
        """The system in the mirror image z -> -z, where the rotor turns the other way."""
        contacts = tuple(
            replace(contact, ring=np.conj(contact.ring), offset=np.conj(contact.offset)) for contact in self.contacts
        )
        rotor, stator = (body.mirror() for body in self.bodies)
        return System(rotor, stator, contacts, self.schedule_time, -self.schedule_speed, self.clearances)

    def at(self, i: ArrayLike) -> "System":
        """The systems at the places i (an array) of a stack, be it of one; what is no stack stands for every place."""
        if self.rotor.mass.ndim == 2:
            return self
        contacts = tuple(_each(lambda part: part[i], contact) for contact in self.contacts)
        clearances = tuple(_each(lambda part: part[i], place) for place in self.clearances)
        return replace(self, rotor=self.rotor.at(i), stator=self.stator.at(i), contacts=contacts, clearances=clearances)


def _each(change: Any, *contacts: Any) -> Any:
    """A SystemContact of numbers, each made by `change` from those of some contacts; it has the name of the first."""
    made = {}
    for item in fields(contacts[0]):
        own = [getattr(contact, item.name) for contact in contacts]
        if isinstance(own[0], str):
            made[item.name] = own[0]
        else:
            made[item.name] = _each(change, *own) if isinstance(own[0], ContactLaw) else change(*own)
    return type(contacts[0])(**made)


def _repeated(value: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    return np.broadcast_to(value, shape + np.shape(value))


def stacked(systems: Sequence[System]) -> System:
    """Stack of systems with equal numbers of coordinates, contacts and clearances.

    Returns
    -------
    System
        Every matrix, vector and constant has one more axis, the first; `diameter` and `slip_velocity` are NaN where a system has
        none, a skew or anisotropic matrix is zero where it has none and others have. A stack has no speed schedule (empty
        arrays): `speed_at` refuses.

    Raises
    ------
    SolverError
        Contact laws of different classes, whose constants are not the same.
    """
    laws = sorted({type(contact.law).__name__ for system in systems for contact in system.contacts})
    if len(laws) > 1:
        raise SolverError(f"contact laws of different kinds ({', '.join(laws)}) cannot stand in one stack: one by one they can")
    contacts = zip(*(system.contacts for system in systems), strict=True)
    return System(
        rotor=bodies.stacked([system.rotor for system in systems]),
        stator=bodies.stacked([system.stator for system in systems]),
        contacts=tuple(_each(_numbers, *own) for own in contacts),
        schedule_time=np.zeros(0),
        schedule_speed=np.zeros(0),
        clearances=tuple(_each(_numbers, *own) for own in zip(*(system.clearances for system in systems), strict=True)),
    )


def _numbers(*values: Any) -> NDArray[Any]:
    return np.array([np.nan if value is None else value for value in values])


def together(systems: Sequence[System]) -> System:
    """The one System that all are, which stands for every place, or else their stack."""
    return systems[0] if all(system is systems[0] for system in systems) else stacked(systems)
