"""From real matrices and their coordinate table to a `FiniteElementModel`, with every refusal that the matrices can earn."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy.sparse

from rsc.errors import DataError
from rsc.machine.checks.checks import plausible, proportional, semidefinite, symmetric
from rsc.machine.checks.rank import held, lowest_motions, rounding_of
from rsc.machine.formats import Matrix
from rsc.machine.imports.casing import one_direction
from rsc.machine.imports.complex_form import DECOUPLED, Pairs, coupling, fold, pairs
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.model.model import TILT, FiniteElementModel

_MOST_DENSE = 3000  # coordinates; larger matrices become sparse
_FIXED = 1e30  # N/m: what Abaqus puts on the diagonal of a coordinate that is held
_UNITS, _FEET = ("m", "mm"), "fix its feet"
_BEARINGS = "bearings are missing (rsc import --bearings adds them)"
WORDS = {
    "mass": "the mass matrix",
    "damping": "the damping",
    "gyroscopic": "the gyroscopic matrix",
    "rotating_damping": "the rotating damping",
    "stiffness": "the stiffness",
}


def rotor_model(
    matrices: Mapping[str, Matrix],
    coordinates: Coordinates,
    source: str,
    units: str | None = None,
    speed: float | None = None,
    free: bool = False,
) -> FiniteElementModel:
    """Model of a rotor with its bearings.

    Parameters
    ----------
    matrices : mapping
        "mass", "stiffness" and, where there are any, "damping" and "gyroscopic": (n, n), of M q'' + (C + Omega G) q' + K q = f;
        "rotating_damping", of what turns with the rotor.
    coordinates : Coordinates
        One for each row.
    source : str
        Name for messages.
    units : str, optional
        "m" for SI, "mm" for mm, N, t and s; None: SI, and refused where it looks like the latter.
    speed : float, optional
        Rotor speed at which coefficients of bearings and seals were taken, Hz.
    free : bool
        Whether it may move freely, because the scene adds bearings.

    Raises
    ------
    DataError
        Sizes that do not fit, a direction without its partner, other directions that are coupled, parts that are not symmetric or
        indefinite, cross-coupling in the mass, gyroscopics that depend on the direction or turn against x to y, a free motion,
        units that cannot be.
    """
    rounding = rounding_of(matrices["stiffness"]) if "stiffness" in matrices else 0.0
    matrices, coordinates, notes = prepared(matrices, coordinates, source, units)
    places = pairs(coordinates, source)
    _refuse_coupled(matrices, places, source)
    model = _folded(matrices, places, coordinates, source)
    notes += _left_out(places)
    if not model.gyroscopic.diagonal().any():
        notes += ("there is no gyroscopic matrix.",)
    model = replace(model, speed=speed, notes=notes, rounding=rounding)
    semidefinite(model.mass, WORDS["mass"], source)
    if model.rotating_damping is not None:
        semidefinite(model.rotating_damping, WORDS["rotating_damping"], source)
    if free:
        n_free, frequency = lowest_motions(model.mass, model.stiffness, source, rounding)
        model = replace(model, free=n_free > 0)
    else:
        frequency, _ = held(model.mass, model.stiffness, source, _BEARINGS, rounding)
    if units is None:
        plausible(model, frequency)
    return model


def stator_model(
    matrices: Mapping[str, Matrix],
    coordinates: Coordinates,
    source: str,
    contact: int | str,
    band: float,
    units: str | None = None,
) -> FiniteElementModel:
    """Model of a stator: complex coordinates where x and y are coupled to nothing else, otherwise one direction (casing.py).

    Parameters
    ----------
    matrices, coordinates, source, units
        As of `rotor_model`, without gyroscopics.
    contact : int or str
        Node of the contact, by number or name.
    band : float
        Highest frequency in Hz at which the contact may move; up to it both directions are compared.

    Raises
    ------
    DataError
        As of `rotor_model`; cross-coupling; a casing whose directions differ at the contact.
    """
    for name, word in (("gyroscopic", "gyroscopic matrix"), ("rotating_damping", "rotating damping")):
        if name in matrices:
            raise DataError(source, f"a stator has no {word}")
    rounding = rounding_of(matrices["stiffness"]) if "stiffness" in matrices else 0.0
    matrices, coordinates, notes = prepared(matrices, coordinates, source, units)
    matrices = {name: symmetric(matrix, WORDS[name], source) for name, matrix in matrices.items()}
    try:
        places = pairs(coordinates, source)
    except DataError:
        places = None
    if places is not None and not _coupled(matrices, places):
        model = replace(_folded(matrices, places, coordinates, source), notes=notes + _left_out(places))
        if model.skew_stiffness is not None or model.skew_damping is not None:
            raise DataError(source, "cross-coupling between x and y, which no body at rest has in its stiffness or damping")
        frequency, _ = held(model.mass, model.stiffness, source, _FEET, rounding)
    else:
        frequency, solve = held(matrices["mass"], matrices["stiffness"], source, _FEET, rounding)
        model = one_direction(matrices, coordinates, source, (contact, band), solve)
        del solve  # the factors are what takes memory
        model = replace(model, notes=notes + model.notes)
    semidefinite(model.mass, WORDS["mass"], source)
    if abs(model.damping).max() > 0.0 and not proportional(model.damping, model.mass, model.stiffness):
        semidefinite(model.damping, WORDS["damping"], source)
    if units is None:
        plausible(model, frequency)
    model.row_at(contact)
    return model


def prepared(matrices, coordinates, source, units):
    """(matrices, coordinates, notes) of one kind (sparse or dense), in SI units, without rows that are held or empty."""
    missing = {"mass", "stiffness"} - set(matrices)
    if missing:
        raise DataError(source, f"{WORDS[min(missing)]} is missing")
    if units is not None and units not in _UNITS:
        raise DataError(source, f"units {units!r}: must be m or mm")
    size = len(coordinates)
    for name, matrix in matrices.items():
        if matrix.ndim != 2 or matrix.shape != (size, size):
            raise DataError(source, f"{WORDS[name]} has the size {'x'.join(map(str, matrix.shape))} and the table {size} rows")
    sparse = size > _MOST_DENSE or any(scipy.sparse.issparse(matrix) for matrix in matrices.values())
    matrices = {name: scipy.sparse.csc_array(matrix) if sparse else np.asarray(matrix) for name, matrix in matrices.items()}
    if units == "mm":
        scale = scipy.sparse.diags_array(np.where(np.isin(coordinates.direction, ("rx", "ry")), 1.0, 1e3))
        matrices = {name: 1e-3 * (scale @ matrix @ scale) for name, matrix in matrices.items()}
    matrices, coordinates, notes = _without_held(matrices, coordinates)
    for name, matrix in matrices.items():
        largest = abs(matrix).max() if min(matrix.shape) else 0.0
        if largest >= _FIXED:  # its squares would leave the range of numbers
            raise DataError(source, f"{WORDS[name]} has an entry of {largest:.3g}, which no machine has")
    return matrices, coordinates, notes


def _without_held(matrices, coordinates):
    """Rows that are held (1e30 on the diagonal of the stiffness) or empty in every matrix are taken out."""
    held_rows = np.abs(matrices["stiffness"].diagonal()) >= _FIXED
    used = np.zeros(len(coordinates), bool)
    for matrix in matrices.values():
        used |= np.asarray((abs(matrix) > 0.0).sum(axis=1)).ravel() > 0
    rows = np.flatnonzero(used & ~held_rows)
    if rows.size == len(coordinates):
        return matrices, coordinates, ()
    note = f"{len(coordinates) - rows.size} coordinates are left out: they are held, or have neither mass nor stiffness."
    return {name: matrix[rows][:, rows] for name, matrix in matrices.items()}, coordinates.taken(rows), (note,)


def _coupled(matrices, places: Pairs):
    """Name of the first matrix that couples x, y, rx, ry with other directions; None where none does."""
    return next((name for name, matrix in matrices.items() if coupling(matrix, places) > DECOUPLED), None)


def _refuse_coupled(matrices, places, source):
    name = _coupled(matrices, places)
    if name is None:
        return
    if TILT in places.kind:
        advice = "torsion or axial motion, as by gears, is not modelled: import each shaft alone, with the mesh as a bearing"
    else:
        advice = "no node tilts, as in solid elements: model the rotor by beam elements, or a casing with --stator"
    raise DataError(source, f"{WORDS[name]} couples x, y, rx or ry with other directions; a rotor's must not ({advice})")


def _left_out(places):
    if places.others.size == 0:
        return ()
    return (f"{places.others.size} coordinates of other directions are left out: nothing couples them.",)


def _folded(matrices, places, coordinates, source):
    """The matrices in complex coordinates, their parts checked."""
    parts = {name: fold(matrix, places) for name, matrix in matrices.items()}
    zero = 0.0 * parts["mass"].real
    mass, stiffness = parts["mass"], parts["stiffness"]
    if abs(mass.imaginary).max() > 0.0:
        raise DataError(source, "the mass matrix couples x and y crosswise, which no mass does")
    real = {name: symmetric(part.real, WORDS[name], source) for name, part in parts.items() if name != "gyroscopic"}
    crosswise = {
        name: symmetric(parts[name].imaginary, f"the cross-coupling in {WORDS[name]}", source)
        for name in ("damping", "stiffness")
        if name in parts and abs(parts[name].imaginary).max() > 0.0
    }
    return FiniteElementModel(
        source=source,
        node=places.node,
        kind=places.kind,
        mass=real["mass"],
        damping=real.get("damping", zero),
        gyroscopic=_gyroscopic(parts["gyroscopic"], source) if "gyroscopic" in parts else zero,
        stiffness=real["stiffness"],
        skew_damping=crosswise.get("damping"),
        skew_stiffness=crosswise.get("stiffness"),
        rotating_damping=_turning(parts["rotating_damping"], real, source) if "rotating_damping" in parts else None,
        anisotropic_mass=_some(mass.anisotropic),
        anisotropic_damping=_some(parts["damping"].anisotropic) if "damping" in parts else None,
        anisotropic_stiffness=_some(stiffness.anisotropic),
        names=coordinates.names,
        position=coordinates.position,
    )


def _turning(parts, real, source):
    """D_i, the same in every direction; None where it is zero."""
    if abs(parts.imaginary).max() > 0.0 or abs(parts.anisotropic).max() > 0.0:
        raise DataError(source, "the rotating damping depends on the direction, and turns with the rotor")
    return _some(real["rotating_damping"])


def _some(part):
    """The part, or None where it is zero."""
    return part if abs(part).max() > 0.0 else None


def _gyroscopic(parts, source):
    """G of -i Omega G."""
    if abs(parts.real).max() > 0.0:
        raise DataError(source, "the gyroscopic matrix is not skew-symmetric")
    if abs(parts.anisotropic).max() > 0.0:
        raise DataError(source, "the gyroscopic matrix depends on the direction: the transverse inertias are unequal")
    matrix = symmetric(-parts.imaginary, "the gyroscopic matrix in complex coordinates", source)
    if matrix.diagonal().sum() < 0.0:
        raise DataError(source, "the gyroscopic matrix turns from y to x: change its sign, or the order of the axes")
    return matrix
