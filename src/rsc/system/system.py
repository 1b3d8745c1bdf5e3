"""The matrices of a scene, the only data shared by simulator and analytic module."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rsc.errors import SolverError
from rsc.system import body as bodies
from rsc.system.body import Body
from rsc.system.knots import SKEW

FloatOrArray = float | NDArray[np.float64]  # a number, or one for each speed or whirl
ROUNDING = 1e-9  # relative to the largest damping of a body: negative damping smaller than this is rounding


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """Contact force law in penetration p, its rate and the slip velocity (physics.md section 2); scalars, or (n,) in a stack."""

    stiffness: float  # N/m, k_C
    damping: float  # N s/m, b_C, acts only while the surfaces separate
    friction: float  # mu
    diameter: float | None = None  # m, d_R; None: one-sided friction, sigma = `System.sense`
    slip_velocity: float | None = None  # m/s, below it Coulomb friction falls linearly to 0; None without diameter
    # of a stator surface (race) free to rotate, J omega' = mu sigma F_N d_R/2 - drag omega
    race_inertia: float | None = None  # kg m^2, J
    race_drag: float | None = None  # N m s

    def depth(self, force: float) -> float:
        """Penetration in m at a normal force in N, without the damper; NaN, not known, of a law that does not say it."""
        return force / self.stiffness if type(self) is ContactLaw else math.nan


@dataclass(frozen=True, eq=False)
class SystemContact:
    """One place where rotor and stator may touch: d = l_R . r_R - l_S . r_S + ring e^{i phi} - offset."""

    law: ContactLaw
    gap: float  # m, nominal radial gap s
    rotor: NDArray[np.float64]  # (N,) l_R
    stator: NDArray[np.float64]  # (M,) l_S
    ring: complex = 0j  # m, eccentricity eps_A of the rotor's contact ring
    offset: complex = 0j  # m, rest position of the stator's centre
    name: str = ""  # "" for a single unnamed contact
    in_rotor: bool = False  # whether both surfaces belong, or in a reduced rotor may belong, to the rotor
    yield_force: float | None = None  # N, normal force at which it deforms for good; no equation knows it


def only_one(contacts: Sequence[Any]) -> Any:
    """The single contact of a scene or system, for code that handles only one.

    Raises
    ------
    SolverError
        There are several.
    """
    if len(contacts) != 1:
        names = ", ".join(contact.name for contact in contacts)
        raise SolverError(f"the scene has {len(contacts)} contacts ({names}) but this takes one; rsc run simulates several")
    return contacts[0]


@dataclass(frozen=True, eq=False)
class SystemClearance:
    """A monitored location: |rotor . r_R - stator . r_S| is compared with the gap but causes no force. In a stack gap and rows
    have a leading axis."""

    name: str
    gap: float  # m, radial
    rotor: NDArray[np.float64]  # (N,)
    stator: NDArray[np.float64]  # (M,), zeros against the ground


@dataclass(frozen=True, eq=False)
class SwitchedOff:
    """Bearings of the rotor that are switched off at a time in s: what their matrices add to those of the rotor until then, and
    first-order states."""

    time: float
    parts: dict[str, NDArray[Any]]  # by the name of the Body's matrix
    states: dict[str, NDArray[np.float64]]  # `STATES` of the rotor until then, all of them; empty without any
    left: NDArray[np.intp]  # numbers, among the states at the start, of those that still act on the rotor afterwards

    def added_to(self, rotor: Body) -> Body:
        """The rotor with these bearings."""
        sums: dict[str, Any] = {}
        for name, part in self.parts.items():
            constant = getattr(rotor, name)
            sums[name] = part if constant is None else constant + part
        with_parts = replace(rotor, **sums)
        return with_parts.with_other_states(self.states) if self.states else with_parts

    def mirrored(self) -> "SwitchedOff":
        """The same in the mirror image y -> -y."""
        parts = {name: -part if name in SKEW else np.conj(part) for name, part in self.parts.items()}
        return replace(self, parts=parts)


@dataclass(frozen=True, eq=False)
class SystemDrive:
    """Torque-limited drive, J phi'' = T(phi') less the torques that brake the rotor (physics.md); T is linear between its knots,
    (k, 2) of phi' in rad/s and N m, and constant beyond."""

    inertia: float  # kg m^2, J, that of the unbalance included
    torques: tuple[NDArray[np.float64], ...]  # T of each part of the run: powered, then coast-down
    ends: tuple[float, ...]  # s, end times of these parts
    fastest: float  # rad/s, estimate of the highest speed reached
    # N m, w = U^H g of unbalance U and gravity g: the weight exerts the torque Im(w e^{-i phi}) on the shaft
    weight: complex = 0j

    def torque(self, Omega: ArrayLike, part: int = 0) -> NDArray[np.float64]:
        """T in N m at speeds in rad/s (array or number), in a part of the run."""
        knots, torque = self.torques[part].T
        return np.asarray(np.interp(np.asarray(Omega, dtype=float), knots, torque))


@dataclass(frozen=True, eq=False)
class System:
    """Bodies, contacts and drive of one scene in SI units and rad/s (physics.md section 2).

    With complex displacements r = y + i z, rotor (2) and stator (3) with the matrices of their `Body` are

        M_R r_R'' + (B_R - i phi' G_R) r_R' + K_R r_R
            = (unbalance phi'^2 - i unbalance_euler phi'') e^{i phi} + load - l_R F_C
        M_S r_S'' + B_S r_S' + K_S r_S = l_S F_C

    All arrays are read-only float64 or complex128; a rigid stator has M = 0 coordinates. Bearings that are switched off during
    the run are not part of the rotor: predictions are those for the machine without them.
    """

    rotor: Body  # N coordinates
    stator: Body  # M coordinates, no gyroscopics, loaded by the contact alone
    contacts: tuple[SystemContact, ...]
    schedule_time: NDArray[np.float64]  # (n,) s, corners of the speed schedule, strictly increasing
    schedule_speed: NDArray[np.float64]  # (n,) rad/s at the corners, linear between them
    clearances: tuple[SystemClearance, ...] = ()
    drive: SystemDrive | None = None  # torque-limited: the speed is integrated and the schedule its constant start
    switched: tuple[SwitchedOff, ...] = ()  # by time

    @property
    def contact(self) -> SystemContact:
        """The only contact, centred on the bearing; SolverError if there are several or it has an offset."""
        only: SystemContact = only_one(self.contacts)
        if np.any(only.offset):
            raise SolverError("contact.offset: this is implemented only for a stator centred on the bearing")
        return only

    def at_contact(self, name: str) -> "System":
        """The system with only this contact, and without its race, which code for one contact does not support."""
        contact = next(contact for contact in self.contacts if contact.name == name)
        contact = replace(contact, law=replace(contact.law, race_inertia=None, race_drag=None))
        rotor, stator = replace(self.rotor, contact=contact.rotor), replace(self.stator, contact=contact.stator)
        return replace(self, rotor=rotor, stator=stator, contacts=(contact,))

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
        """Number of rotor coordinates N."""
        return self.rotor.n_coordinates

    @property
    def n_stator(self) -> int:
        """Number of stator coordinates M (0 for a rigid stator)."""
        return self.stator.n_coordinates

    @property
    def n_states(self) -> int:
        """Number of first-order states of rotor and stator."""
        return self.rotor.n_states + self.stator.n_states

    @property
    def relative(self) -> NDArray[np.float64]:
        """(N + M,) [l_R, -l_S] of the only contact."""
        only_one(self.contacts)
        return np.concatenate([self.rotor.contact, -self.stator.contact], axis=-1)

    @property
    def unbalance_inertia(self) -> float:
        """u^H M^-1 u in kg m^2, the contribution of the unbalance to the inertia about the shaft axis."""
        u = self.rotor.unbalance_euler
        return float((u.conj() @ np.linalg.solve(self.rotor.mass, u)).real)

    @property
    def fastest(self) -> float:
        """Largest |rotor speed| of the run, rad/s."""
        return float(np.abs(self.schedule_speed).max()) if self.drive is None else self.drive.fastest

    @property
    def isotropic(self) -> bool:
        """Whether no matrix distinguishes directions."""
        return all(body.isotropic for body in self.bodies)

    @property
    def skew(self) -> bool:
        """Whether there is cross-coupled stiffness or damping."""
        return any(body.skew for body in self.bodies)

    @property
    def driven(self) -> bool:
        """Whether cross-coupling, rotating or negative damping, or a controller can feed energy into a whirl besides friction."""
        bodies = [self.at_speed(Omega).rotor for Omega in self.knot_speed] if len(self.knot_speed) else [self.rotor]
        rates = [np.linalg.eigvalsh(body.damping) for body in (*bodies, self.stator) if body.damping.size]
        return self.skew or self.n_states > 0 or any(rate.min() < -ROUNDING * np.abs(rate).max() for rate in rates)

    @property
    def follows(self) -> bool:
        """Whether stiffness or damping depend on the rotor speed."""
        return any(body.follows for body in self.bodies)

    @property
    def knot_speed(self) -> NDArray[np.float64]:
        """(k,) rad/s, knots of the speed-dependent coefficients; empty if all are constant."""
        return np.zeros(0) if self.rotor.knots is None else self.rotor.knots.speed

    def at_time(self, time: float) -> "System":
        """The system with the bearings that are switched off later than a time in s, which then stay."""
        rotor = self.rotor
        for one in reversed(self.switched):  # each has all states until its time
            rotor = one.added_to(rotor) if one.time > time else rotor
        return replace(self, rotor=rotor, switched=()) if self.switched else self

    @property
    def at_start(self) -> "System":
        """The system as the run starts, with all bearings."""
        return self.at_time(-np.inf)

    @property
    def turns(self) -> bool:
        """Whether whirls without unbalance depend on the rotor speed."""
        return self.follows or bool(np.any(self.rotor.gyroscopic))

    @property
    def sense(self) -> float:
        """Initial sense of rotation: 1 forward (also if it never turns) or -1 backward."""
        turning = self.schedule_speed[self.schedule_speed != 0.0]
        return -1.0 if len(turning) and turning[0] < 0.0 else 1.0

    def at_speed(self, Omega: ArrayLike) -> "System":
        """The system at a rotor speed in rad/s (`Body.at_speed`), a stack for an array of speeds; unchanged if all coefficients
        are constant."""
        if not self.follows:
            return self
        shape = np.shape(Omega) if self.rotor.mass.ndim == 2 else ()
        system = self.repeated(shape) if shape else self
        return replace(system, rotor=system.rotor.at_speed(Omega))

    @property
    def at_first_speed(self) -> "System":
        """The system at the initial rotor speed of the run."""
        return self.at_speed(self.schedule_speed[0]) if self.follows else self

    def repeated(self, shape: tuple[int, ...]) -> "System":
        """A stack of copies of this system with the given leading shape."""
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
        """The system in the mirror image y -> -y, where the rotor turns the other way."""
        contacts = tuple(
            replace(contact, ring=-np.conj(contact.ring), offset=-np.conj(contact.offset)) for contact in self.contacts
        )
        rotor, stator = (body.mirror() for body in self.bodies)
        switched = tuple(one.mirrored() for one in self.switched)
        return System(rotor, stator, contacts, self.schedule_time, -self.schedule_speed, self.clearances, switched=switched)

    def at(self, i: ArrayLike) -> "System":
        """The systems at indices i (an array) of a stack; a single system is returned unchanged."""
        if self.rotor.mass.ndim == 2:
            return self
        contacts = tuple(_each(lambda part: part[i], contact) for contact in self.contacts)
        clearances = tuple(_each(lambda part: part[i], place) for place in self.clearances)
        return replace(self, rotor=self.rotor.at(i), stator=self.stator.at(i), contacts=contacts, clearances=clearances)


def _each(change: Any, *contacts: Any) -> Any:
    """A SystemContact (or SystemClearance) whose fields are made by `change` from those of the given ones; it has the name of
    the first."""
    made = {}
    for item in fields(contacts[0]):
        values = [getattr(contact, item.name) for contact in contacts]
        if isinstance(values[0], str):
            made[item.name] = values[0]
        else:
            made[item.name] = _each(change, *values) if isinstance(values[0], ContactLaw) else change(*values)
    return type(contacts[0])(**made)


def _repeated(value: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    return np.broadcast_to(value, shape + np.shape(value))


def stacked(systems: Sequence[System]) -> System:
    """Stack of systems with equal numbers of coordinates, contacts and clearances.

    Returns
    -------
    System
        Every matrix, vector and constant has a leading axis; `diameter` and `slip_velocity` are NaN for a system without them,
        a skew or anisotropic matrix that only some systems have is zero for the others. A stack has no speed schedule (empty
        arrays), so `speed_at` raises.

    Raises
    ------
    SolverError
        SystemContact laws of different classes, which have different constants.
    """
    laws = sorted({type(contact.law).__name__ for system in systems for contact in system.contacts})
    if len(laws) > 1:
        raise SolverError(f"contact laws of different kinds ({', '.join(laws)}) cannot share a stack: compute them one by one")
    contacts = zip(*(system.contacts for system in systems), strict=True)
    return System(
        rotor=bodies.stacked([system.rotor for system in systems]),
        stator=bodies.stacked([system.stator for system in systems]),
        contacts=tuple(_each(_numbers, *same) for same in contacts),
        schedule_time=np.zeros(0),
        schedule_speed=np.zeros(0),
        clearances=tuple(_each(_numbers, *same) for same in zip(*(system.clearances for system in systems), strict=True)),
    )


def _numbers(*values: Any) -> NDArray[Any]:
    return np.array([np.nan if value is None else value for value in values])


def together(systems: Sequence[System]) -> System:
    """The system itself if all are the same object, else their stack."""
    return systems[0] if all(system is systems[0] for system in systems) else stacked(systems)
