"""A scene's matrices: `assemble(scene) -> System`, in SI and rad/s."""

from dataclasses import fields, replace
from typing import Any, Protocol

import numpy as np

from rsc.errors import SceneError
from rsc.system import knots as knot_tables
from rsc.system.body import Body
from rsc.system.knots import FOLLOWING, Knots
from rsc.system.system import ContactLaw, System, SystemClearance, SystemContact, SystemDrive


class SceneLike(Protocol):
    """The parts of a `rsc.Scene` that its matrices and its predictions are made of."""

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
    # of several contacts none stands for all: a body has the row of the only one
    alone = contacts[0] if len(contacts) == 1 else None
    system = System(
        rotor=_body(scene.rotor, None if alone is None else alone.rotor, _imposed),
        stator=_body(scene.stator, None if alone is None else alone.stator),
        contacts=contacts,
        schedule_time=_frozen(np.array(scene.drive.time)),
        schedule_speed=_frozen(2.0 * np.pi * np.array(scene.drive.speed)),
        clearances=tuple(_clearance(own, scene.rotor, scene.stator) for own in getattr(scene, "clearances", ())),
        drive=None if getattr(scene.drive, "inertia", None) is None else _drive(scene.drive),
    )
    if system.drive is None:
        return system
    _refuse_light(scene, system)
    return replace(system, drive=replace(system.drive, weight=_weight(scene.rotor, system.rotor.unbalance_euler)))


def _drive(own):
    """The SystemDrive of a scene's [drive] with a torque."""
    tables = (own.torque,) if own.trip is None else (own.torque, own.coast)
    torques = tuple(_frozen(np.array(table) * (2.0 * np.pi, 1.0)) for table in tables)
    ends = (own.duration,) if own.trip is None else (own.trip, own.duration)
    return SystemDrive(own.inertia, torques, ends, 2.0 * np.pi * own.fastest)


def _weight(rotor, unbalance):
    """w = U^H g in N m: the weight acts at the centre of mass, whose lever is the unbalance, a constant load at the shaft's."""
    moving = np.ones(rotor.n_coordinates)
    moving[list(rotor.tilts)] = 0.0
    return complex(unbalance.conj() @ moving) * -1j * rotor.gravity if rotor.load is None else 0j


def _refuse_light(scene, system):
    """SceneError of an inertia that is less than that of the unbalance alone."""
    least = system.unbalance_inertia
    if not system.drive.inertia > least:
        wanted, hint = f"> {least:.6g} kg m^2", "it holds that of the unbalance about the shaft, u^H M^-1 u"
        raise SceneError(getattr(scene, "source", ""), "drive.inertia", system.drive.inertia, wanted, hint)


def _contact(contact, rotor, stator):
    """The SystemContact of one a scene's [contact] and of the bodies that touch."""
    return SystemContact(
        law=ContactLaw(**{item.name: getattr(contact, item.name) for item in fields(ContactLaw)}),
        gap=contact.gap,
        rotor=_frozen(contact.of_rotor(np.eye(rotor.n_coordinates))),
        stator=_frozen(_unit_vector(stator.n_coordinates, contact.stator_coordinate) * (not contact.in_rotor)),
        ring=complex(contact.ring_eccentricity),
        offset=complex(contact.offset),
        name=contact.name or "",
        in_rotor=contact.in_rotor or rotor.model == "reduced",  # whose coordinates do not tell
    )


def _clearance(own, rotor, stator):
    """The SystemClearance of a scene's [[clearance]], with the rows of both bodies."""
    rows = _row(rotor, own.rotor_coordinate, own.rotor_node), _row(stator, own.stator_coordinate, own.stator_node)
    return SystemClearance(own.name, own.gap, *map(_frozen, rows))


def _row(body, coordinate, node):
    """The row of a coordinate, or of an observed node of a reduced body; zeros for neither."""
    if node is not None:
        return np.array(body.observer_rows[body.observers.index(node)], dtype=float)
    return np.zeros(body.n_coordinates) if coordinate is None else _unit_vector(body.n_coordinates, coordinate)


def _body(body, contact, imposed=None):
    """The Body of one of a scene's bodies; contact: its row of the only contact, None with several; imposed: what makes the
    forces on it."""
    mass, stiffness = _symmetric(body.mass_matrix()), _symmetric(body.stiffness_matrix())
    own, turning = body.gyroscopic_matrix(), body.rotating_damping_matrix()
    gyroscopic = np.zeros_like(mass) if own is None else _symmetric(own)
    arrays = {
        "mass": mass,
        "damping": _damping(body, mass, stiffness) + _supported(body, "damping", _mean),
        "stiffness": stiffness + _supported(body, "stiffness", _mean),
        "contact": np.full(body.n_coordinates, np.nan) if contact is None else contact,
        "gyroscopic": gyroscopic,
        **_directed(body),
        **({} if turning is None else {"rotating_damping": _symmetric(turning)}),
        **(imposed(body, mass, gyroscopic) if imposed else {}),
    }
    return Body(**{name: _frozen(array) for name, array in arrays.items()}, knots=_knots(body))


def _knots(body):
    """Knots of a body whose coefficients follow the speed, from its supports and its own matrices; None where none do."""
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
    own = body.knots()
    if own is not None:
        speed, parts = own
        matrices = {name: np.array([_symmetric(matrix) for matrix in part]) for name, part in parts.items()}
        tables.append(Knots(2.0 * np.pi * np.array(speed), matrices))
    if not tables:
        return None
    speed = knot_tables.union(tables)
    each = [table.at_all(speed).parts for table in tables]
    names = [name for name in FOLLOWING if any(name in parts for parts in each)]
    return Knots(_frozen(speed), {name: _frozen(sum(parts[name] for parts in each if name in parts)) for name in names})


def elastic_stiffness(body):
    """Matrix of the elastic forces of a body with its supports on [y, z] of its coordinates, real and symmetric, (2 n, 2 n); what
    is cross-coupled stores no energy and is left out."""
    mean = _symmetric(body.stiffness_matrix()) + _supported(body, "stiffness", _mean)
    beside = _supported(body, "stiffness", _anisotropic) + np.zeros_like(mean)
    return np.block([[mean + beside.real, beside.imag], [beside.imag, mean - beside.real]])


def _frozen(array):
    array = np.ascontiguousarray(array)
    array.flags.writeable = False
    return array


def _symmetric(rows):
    matrix = np.array(rows)
    return 0.5 * (matrix + matrix.T)


def _damping(body, mass, stiffness):
    """B of one body from whichever form of damping the scene gives."""
    if body.damping_ratio is not None:
        return modal_damping(mass, stiffness, body.damping_ratio)
    if body.rayleigh is not None:
        alpha, beta = body.rayleigh
        return alpha * mass + beta * stiffness
    return _symmetric(body.damping_matrix())


def modal_damping(mass, stiffness, ratio):
    """Return the damping matrix with the same ratio in every mode of the undamped, non-rotating body.

    B = M Phi diag(2 ratio omega) Phi^T M with mass-normalised modes Phi; a free-body mode stays undamped.

    Parameters
    ----------
    mass, stiffness : ndarray, (n, n)
        Symmetric, positive definite and positive semidefinite.
    ratio : float
        Share of critical damping.

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


def _imposed(rotor, mass, gyroscopic):
    """Unbalance, that of the Euler term and the constant load of a rotor, by the name of their field."""
    unbalance, unbalance_euler = _unbalance(rotor, mass, gyroscopic)
    return {"unbalance": unbalance, "unbalance_euler": unbalance_euler, "load": _load(rotor, mass)}


def _unbalance(rotor, mass, gyroscopic):
    """Unbalance and that of the Euler term, kg m per coordinate: given, or M eps of the eccentricities, which multiplies also
    phi'^2 where they are displacements; a disk whose axis is inclined resists with its polar inertia as well, (M - G) eps.
    """
    if rotor.unbalance is not None:
        return (np.array(rotor.unbalance, dtype=complex),) * 2
    eccentricity = rotor.eccentricities()
    inclined = np.zeros_like(eccentricity)
    inclined[list(rotor.tilts)] = eccentricity[list(rotor.tilts)]
    return mass @ eccentricity - gyroscopic @ inclined, mass @ eccentricity


def _directed(body):
    """Skew and anisotropic stiffness and damping where a body has them, by the name of their field."""
    made = {}
    for kind in ("stiffness", "damping"):
        for word, part in (("skew", _skew), ("anisotropic", _anisotropic)):
            own = getattr(body, f"{word}_{kind}")
            matrix = _supported(body, kind, part) + (0.0 if own is None else _symmetric(own))
            if np.any(matrix):
                made[f"{word}_{kind}"] = matrix
    return made


def _supported(body, kind, part):
    """Diagonal matrix of one part of the coefficients [xx, xy, yx, yy] of all supports; 0.0 for none, so that bits stay."""
    if not body.supports:
        return 0.0
    matrix = np.zeros((body.n_coordinates,) * 2, dtype=complex if part is _anisotropic else float)
    for place, stiffness, damping in body.supports:
        matrix[place, place] += part(*(stiffness if kind == "stiffness" else damping))
    return matrix


# a force -(k_xx x + k_xy y), -(k_yx x + k_yy y) is -(mean + i skew) u - anisotropic conj(u) of u = x + i y
def _mean(xx, xy, yx, yy):
    return 0.5 * (xx + yy)


def _skew(xx, xy, yx, yy):
    return 0.5 * (yx - xy)


def _anisotropic(xx, xy, yx, yy):
    return 0.5 * (xx - yy + 1j * (xy + yx))


def _load(rotor, mass):
    """Constant load f_0 in N (N m on a tilt): given, or the weight -i g M e, e = 1 on displacements and 0 on tilts.

    -i g e is the acceleration of a body in free fall. Where M couples tilts to displacements (a centre of mass beside its
    coordinate, the consistent mass of a beam) a tilt gets the moment of the weight that M puts there, else nothing.
    """
    if rotor.load is not None:
        return np.array(rotor.load, dtype=complex)
    moving = np.ones(rotor.n_coordinates)
    moving[list(rotor.tilts)] = 0.0
    load = np.zeros(rotor.n_coordinates, dtype=complex)
    load.imag -= rotor.gravity * (mass @ moving)
    return load


def _unit_vector(size, i):
    vector = np.zeros(size)
    vector[i : i + 1] = 1.0
    return vector
