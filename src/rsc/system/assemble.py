"""Assembly of a scene's matrices: `assemble(scene) -> System`, in SI units and rad/s."""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rsc.errors import SceneError
from rsc.system import knots as knot_tables
from rsc.system.body import Body
from rsc.system.knots import FOLLOWING, Knots
from rsc.system.system import ContactLaw, SwitchedOff, System, SystemClearance, SystemContact, SystemDrive

Reals = NDArray[np.float64]
Complexes = NDArray[np.complex128]


class SceneLike(Protocol):
    """The attributes of `rsc.Scene` that matrices and predictions need."""

    @property
    def rotor(self) -> Any: ...

    @property
    def stator(self) -> Any: ...

    @property
    def contacts(self) -> Any: ...

    @property
    def drive(self) -> Any: ...


def assemble(scene: SceneLike) -> System:
    """Return the matrices and constants of a scene (physics.md section 2).

    Parameters
    ----------
    scene : rsc.Scene
        A validated scene.

    Returns
    -------
    System
        Read-only, C-contiguous float64 and complex128 arrays; see its fields.
    """
    contacts = tuple(_contact(contact, scene.rotor, scene.stator) for contact in scene.contacts)
    # a body stores the contact row only if there is a single contact
    alone = contacts[0] if len(contacts) == 1 else None
    system = System(
        rotor=_body(scene.rotor, None if alone is None else alone.rotor, _imposed),
        stator=_body(scene.stator, None if alone is None else alone.stator),
        contacts=contacts,
        schedule_time=_frozen(np.array(scene.drive.time)),
        schedule_speed=_frozen(2.0 * np.pi * np.array(scene.drive.speed)),
        clearances=tuple(_clearance(place, scene.rotor, scene.stator) for place in getattr(scene, "clearances", ())),
        drive=None if getattr(scene.drive, "inertia", None) is None else _drive(scene.drive),
        switched=_switched(scene.rotor),
    )
    if system.drive is None:
        return system
    _refuse_light(scene, system.drive.inertia, system.unbalance_inertia)
    return replace(system, drive=replace(system.drive, weight=_weight(scene.rotor, system.rotor.unbalance_euler)))


def _switched(rotor: Any) -> tuple[SwitchedOff, ...]:
    """The bearings of a rotor that are switched off during a run."""
    times, made = rotor.switched_at, []
    matrices = {name: part for name in FOLLOWING if (part := getattr(rotor, f"{name}_until", None)) is not None}
    for i, time in enumerate(times):
        known = rotor.off_times or ()
        own = {name: _symmetric(part[known.index(time)]) for name, part in matrices.items() if time in known}
        parts = {name: _frozen(part) for name, part in own.items() if part.any()}
        states = {name: _frozen(part) for name, part in _states(rotor, time).items()}
        made.append(SwitchedOff(time, parts, states, _frozen(rotor.state_numbers((*times[i + 1 :], np.inf)[0]))))
    return tuple(made)


def _drive(table: Any) -> SystemDrive:
    """The SystemDrive of a scene's torque-limited [drive]."""
    torques = tuple(_frozen(np.array(curve) * (2.0 * np.pi, 1.0)) for curve in table.curves)
    ends = (table.duration,) if table.trip is None else (table.trip, table.duration)
    return SystemDrive(table.inertia, torques, ends, 2.0 * np.pi * table.fastest)


def _weight(rotor: Any, unbalance: Complexes) -> complex:
    """Torque amplitude w = U^H g in N m of the weight about the shaft: gravity acts at the centre of mass, with the unbalance
    as lever arm; a given constant load acts on the shaft axis and has none."""
    moving = np.ones(rotor.n_coordinates)
    moving[list(rotor.tilts)] = 0.0
    return complex(unbalance.conj() @ moving) * -1j * rotor.gravity if rotor.load is None else 0j


def _refuse_light(scene: SceneLike, inertia: float, least: float) -> None:
    """SceneError if the inertia of the drive is not larger than that of the unbalance alone."""
    if not inertia > least:
        wanted, hint = f"> {least:.6g} kg m^2", "it includes the inertia of the unbalance about the shaft axis, u^H M^-1 u"
        raise SceneError(getattr(scene, "source", ""), "drive.inertia", inertia, wanted, hint)


def _contact(contact: Any, rotor: Any, stator: Any) -> SystemContact:
    """The SystemContact of one [contact] table between two bodies of the scene."""
    return SystemContact(
        law=ContactLaw(**{item.name: getattr(contact, item.name) for item in fields(ContactLaw)}),
        gap=contact.gap,
        rotor=_frozen(contact.of_rotor(np.eye(rotor.n_coordinates))),
        stator=_frozen(_unit_vector(stator.n_coordinates, contact.stator_coordinate) * (not contact.in_rotor)),
        ring=complex(contact.ring_eccentricity),
        offset=complex(contact.offset),
        name=contact.name or "",
        in_rotor=contact.in_rotor or rotor.model == "reduced",  # of a reduced rotor it is unknown
        yield_force=contact.yield_force,
    )


def _clearance(place: Any, rotor: Any, stator: Any) -> SystemClearance:
    """The SystemClearance of a scene's [[clearance]], with the rows of both bodies."""
    rows = _row(rotor, place.rotor_coordinate, place.rotor_node), _row(stator, place.stator_coordinate, place.stator_node)
    return SystemClearance(place.name, place.gap, *map(_frozen, rows))


def _row(body: Any, coordinate: int | None, node: Any) -> Reals:
    """(n,) row that selects a coordinate, or an observed node of a reduced body; zeros if neither is given."""
    if node is not None:
        return np.array(body.observer_rows[body.observers.index(node)], dtype=float)
    return np.zeros(body.n_coordinates) if coordinate is None else _unit_vector(body.n_coordinates, coordinate)


def _body(body: Any, contact: Reals | None, imposed: Callable[..., dict[str, Any]] | None = None) -> Body:
    """The system's Body from one body of a scene.

    contact : (n,) row of the only contact, None with several; imposed : function that returns unbalance and load
    """
    mass, stiffness = _symmetric(body.mass_matrix()), _symmetric(body.stiffness_matrix())
    explicit, turning = body.gyroscopic_matrix(), body.rotating_damping_matrix()
    gyroscopic = np.zeros_like(mass) if explicit is None else _symmetric(explicit)
    states = _states(body, np.inf)
    magnetic = states.get("state_stiffness", 0.0)
    arrays = {
        "mass": mass,
        "damping": _damping(body, mass, stiffness) + _supported(body, "damping", _mean),
        "stiffness": stiffness + _supported(body, "stiffness", _mean) + magnetic,
        "contact": np.full(body.n_coordinates, np.nan) if contact is None else contact,
        "gyroscopic": gyroscopic,
        **_directed(body),
        **states,
        **({} if turning is None else {"rotating_damping": _symmetric(turning)}),
        **(imposed(body, mass, gyroscopic) if imposed else {}),
    }
    return Body(**{name: _frozen(array) for name, array in arrays.items()}, knots=_knots(body))


def _states(body: Any, until: float) -> dict[str, Any]:
    """First-order states of a body, without those of bearings that are switched off before a time in s, by field name of `Body`;
    empty without any."""
    own = body.first_order(until)
    return {} if own is None else {f"state_{name}": getattr(own, name) for name in own._fields}


def _knots(body: Any) -> Knots | None:
    """Speed-dependent coefficients of a body, from its supports and its matrices; None if all are constant."""
    n, tables = body.n_coordinates, []
    for place, knots in body.supports_by_speed or ():
        speed, stiffness, damping = (np.array(column) for column in zip(*knots, strict=True))
        of = {
            f"{word}{kind}": part(*four.T)
            for kind, four in (("stiffness", stiffness), ("damping", damping))
            for word, part in (("", _mean), ("skew_", _skew), ("anisotropic_", _anisotropic))
        }
        unit = _unit_vector(n, place)
        parts = {name: part[:, None, None] * np.outer(unit, unit) for name, part in of.items() if part.any()}
        tables.append(Knots(2.0 * np.pi * speed, parts))
    explicit = body.knots()
    if explicit is not None:
        speed, parts = explicit
        matrices = {name: np.array([_symmetric(matrix) for matrix in part]) for name, part in parts.items()}
        tables.append(Knots(2.0 * np.pi * np.array(speed), matrices))
    if not tables:
        return None
    speed = knot_tables.union(tables)
    resampled = [table.at_all(speed).parts for table in tables]
    names = [name for name in FOLLOWING if any(name in parts for parts in resampled)]
    return Knots(_frozen(speed), {name: _frozen(sum(parts[name] for parts in resampled if name in parts)) for name in names})


def elastic_stiffness(body: Any) -> Reals:
    """(2 n, 2 n) real symmetric stiffness of a body and its supports on [y, z]; cross-coupled (skew) stiffness, which stores no
    energy, is left out."""
    mean = _symmetric(body.stiffness_matrix()) + _supported(body, "stiffness", _mean)
    anisotropic = _supported(body, "stiffness", _anisotropic) + np.zeros_like(mean)
    return np.block([[mean + anisotropic.real, anisotropic.imag], [anisotropic.imag, mean - anisotropic.real]])


def _frozen(array: Any) -> Any:
    array = np.ascontiguousarray(array)
    array.flags.writeable = False
    return array


def _symmetric(rows: Any) -> Reals:
    matrix = np.array(rows)
    return 0.5 * (matrix + matrix.T)


def _damping(body: Any, mass: Reals, stiffness: Reals) -> Reals:
    """Damping matrix B of a body, from whichever form of damping the scene uses."""
    if body.damping_ratio is not None:
        return modal_damping(mass, stiffness, body.damping_ratio)
    if body.rayleigh is not None:
        alpha, beta = body.rayleigh
        return alpha * mass + beta * stiffness
    return _symmetric(body.damping_matrix())


def modal_damping(mass: Reals, stiffness: Reals, ratio: float) -> Reals:
    """Return the damping matrix that gives every mode of the undamped, non-rotating body the same damping ratio.

    B = M Phi diag(2 ratio omega) Phi^T M with mass-normalised modes Phi; rigid-body modes stay undamped.

    Parameters
    ----------
    mass, stiffness : ndarray, (n, n)
        Symmetric, positive definite and positive semidefinite.
    ratio : float
        Damping ratio, fraction of critical damping.

    Returns
    -------
    ndarray, (n, n), symmetric
    """
    if len(mass) == 1:
        return np.array([[2.0 * ratio * np.sqrt(stiffness[0, 0] * mass[0, 0])]])
    # M = L L^T; modes of L^-1 K L^-T are orthonormal, Phi = L^-T Q, so M Phi = L Q
    lower = np.linalg.cholesky(mass)
    scaled = np.linalg.solve(lower, np.linalg.solve(lower, stiffness).T)
    squares, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
    momenta = lower @ vectors
    damping = (momenta * (2.0 * ratio * np.sqrt(np.clip(squares, 0.0, None)))) @ momenta.T
    return 0.5 * (damping + damping.T)


def _imposed(rotor: Any, mass: Reals, gyroscopic: Reals) -> dict[str, Any]:
    """Unbalance, unbalance of the run-up (Euler) term and constant load of a rotor, by field name of `Body`."""
    unbalance, unbalance_euler = _unbalance(rotor, mass, gyroscopic)
    return {"unbalance": unbalance, "unbalance_euler": unbalance_euler, "load": _load(rotor, mass)}


def _unbalance(rotor: Any, mass: Reals, gyroscopic: Reals) -> tuple[Complexes, Complexes]:
    """Unbalances in kg m per coordinate that multiply phi'^2 and phi'' (the Euler term).

    Either as given by the scene, or from the eccentricities eps: M eps, but (M - G) eps of an inclined disk for phi'^2, whose
    polar inertia counteracts.
    """
    if rotor.unbalance is not None:
        return (np.array(rotor.unbalance, dtype=complex),) * 2
    eccentricity = rotor.eccentricities()
    inclined = np.zeros_like(eccentricity)
    inclined[list(rotor.tilts)] = eccentricity[list(rotor.tilts)]
    return mass @ eccentricity - gyroscopic @ inclined, mass @ eccentricity


def _directed(body: Any) -> dict[str, Any]:
    """Nonzero skew and anisotropic stiffness and damping matrices of a body, by field name of `Body`."""
    made = {}
    for kind in ("stiffness", "damping"):
        for word, part in (("skew", _skew), ("anisotropic", _anisotropic)):
            explicit = getattr(body, f"{word}_{kind}")
            matrix = _supported(body, kind, part) + (0.0 if explicit is None else _symmetric(explicit))
            if np.any(matrix):
                made[f"{word}_{kind}"] = matrix
    return made


def _supported(body: Any, kind: str, part: Callable[..., Any]) -> Any:
    """Diagonal matrix of one part of the support coefficients [yy, yz, zy, zz]; without supports 0.0, which keeps the bits."""
    if not body.supports:
        return 0.0
    matrix = np.zeros((body.n_coordinates,) * 2, dtype=complex if part is _anisotropic else float)
    for place, stiffness, damping in body.supports:
        matrix[place, place] += part(*(stiffness if kind == "stiffness" else damping))
    return matrix


# with r = y + i z the force -(k_yy y + k_yz z), -(k_zy y + k_zz z) is -(mean + i skew) r - anisotropic conj(r)
def _mean(yy: Any, yz: Any, zy: Any, zz: Any) -> Any:
    return 0.5 * (yy + zz)


def _skew(yy: Any, yz: Any, zy: Any, zz: Any) -> Any:
    return 0.5 * (zy - yz)


def _anisotropic(yy: Any, yz: Any, zy: Any, zz: Any) -> Any:
    return 0.5 * (yy - zz + 1j * (yz + zy))


def _load(rotor: Any, mass: Reals) -> Complexes:
    """Constant load f_0 in N (N m on a tilt): as given, or the weight -i g M e with e = 1 on displacements and 0 on tilts.

    Where M couples tilts and displacements (centre of mass off the coordinate, consistent mass of a beam) the weight also has
    a moment on the tilt.
    """
    if rotor.load is not None:
        return np.array(rotor.load, dtype=complex)
    moving = np.ones(rotor.n_coordinates)
    moving[list(rotor.tilts)] = 0.0
    load = np.zeros(rotor.n_coordinates, dtype=complex)
    load.imag -= rotor.gravity * (mass @ moving)
    return load


def _unit_vector(size: int, i: int) -> Reals:
    vector = np.zeros(size)
    vector[i : i + 1] = 1.0
    return vector
