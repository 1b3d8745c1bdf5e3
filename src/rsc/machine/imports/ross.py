"""Rotors of ROSS (petrobras/ross, versions 2.3 and 3): the object itself, and the .mat file of `rotor.save_mat`.

Every node has six coordinates, x, y, z, alpha, beta and theta, in this order, followed, after all shaft nodes, by x, y and z of
each point mass (a support). alpha and beta are the rotations about x and y. M, K and C are evaluated at a frequency, at which
coefficients of bearings and seals are taken; G is multiplied by the speed. Tables of bearings and seals are over the rotor speed,
whatever ROSS calls it; only those of magnetic bearings are over the vibration frequency, to which their controller responds. ROSS
itself is not imported.
"""

import inspect
import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rsc.errors import DataError, one_line
from rsc.machine.formats import read_matrices
from rsc.machine.imports.build import rotor_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.model.following import over_speed
from rsc.machine.model.model import FiniteElementModel

_NODE = ("x", "y", "other", "rx", "ry", "other")
_SUPPORT = ("x", "y", "other")
_BELOW = 1.0 - 1e-9  # tolerance at the ends of a table: 4000 rpm / 60 is rounded
_ROLES = {"mass": "M", "stiffness": "K", "damping": "C", "gyroscopic": "G"}


def from_ross(
    rotor: Any, speed: float = 0.0, frequency: float | None = None, *, speeds: Sequence[float] | None = None
) -> FiniteElementModel:
    """Model of a ROSS rotor.

    Parameters
    ----------
    rotor : ross.Rotor
        Or any object with its M, K, C, G, nodes, nodes_pos and shaft_elements.
    speed : float
        Rotor speed at which coefficients of bearings and seals are evaluated, Hz (rad/s in ROSS).
    frequency : float, optional
        Vibration frequency in Hz at which frequency-dependent coefficients are evaluated: those of magnetic bearings, and any
        that a later ROSS evaluates at a speed and a frequency. For backward whirl its magnitude. By default the speed, as in
        ROSS. The notes of the model state the choice.
    speeds : sequence of float, optional
        Two or more increasing rotor speeds in Hz, for speed-dependent coefficients, linear in between.

    Returns
    -------
    Model
        Nodes have ROSS's numbers, point masses follow them; tags of disks and bearings are names of their nodes; diameters are
        the outer ones of the elements.

    Raises
    ------
    DataError
        Not such an object, or invalid matrices (`rotor_model`); magnetic bearings with several speeds but no frequency, whose
        coefficients would then vary with the speed.
    """
    if speeds is not None:
        return _over_speeds(rotor, frequency, list(speeds))
    source, omega = "ROSS rotor", 2.0 * np.pi * speed
    vibration = omega if frequency is None else 2.0 * np.pi * abs(frequency)
    try:
        magnetic = [el for el in rotor.bearing_elements if _is_magnetic(el)]
        matrices = {role: _asked(getattr(rotor, name), omega, vibration) for role, name in _ROLES.items()}
        for role in ("stiffness", "damping"):
            _exchanged(matrices[role], magnetic, _ROLES[role], (omega, vibration), len(rotor.nodes_pos))
        position = [float(place) for place in rotor.nodes_pos]
        elements = [(int(el.n), float(el.odl), float(el.odr)) for el in rotor.shaft_elements]
        named = [(str(el.tag), int(el.n)) for el in [*rotor.disk_elements, *rotor.bearing_elements]]
        tables = {str(el.tag): (_frequencies(el), vibration if _is_magnetic(el) else omega) for el in rotor.bearing_elements}
    except (AttributeError, TypeError, ValueError) as error:
        raise DataError(source, f"not a rotor of ROSS 2.3 or 3: {one_line(error)}") from None
    _refuse_complex(matrices, source)
    _refuse_beyond(tables, source)
    model = _model({role: matrix.real for role, matrix in matrices.items()}, position, source, speed)
    diameter: dict[int, float] = {}
    for node, left, right in elements:
        diameter[node] = max(diameter.get(node, 0.0), left)
        diameter[node + 1] = max(diameter.get(node + 1, 0.0), right)
    names: dict[str, int] = {}
    for tag, node in named:
        names.setdefault(tag, node)
    notes = (*model.notes, *_taken(magnetic, speed, frequency))
    return replace(model, diameter=diameter, names=names, notes=notes)


def _over_speeds(rotor: Any, frequency: float | None, speeds: list[float]) -> FiniteElementModel:
    if frequency is None and any(map(_is_magnetic, getattr(rotor, "bearing_elements", ()))):
        problem = "coefficients of a magnetic bearing depend on the vibration frequency, not the rotor speed; give a frequency"
        raise DataError("ROSS rotor", problem)
    return over_speed([from_ross(rotor, speed, frequency) for speed in speeds])


def _is_magnetic(bearing: Any) -> bool:
    return any(kind.__name__ == "MagneticBearingElement" for kind in type(bearing).__mro__)


def _exchanged(matrix: Any, bearings: Any, name: str, asked: tuple[float, float], n_nodes: int) -> None:
    """Replace the coefficients of some bearings in a matrix; asked = (frequency of the matrix, new frequency), rad/s."""
    if asked[0] == asked[1]:
        return
    for bearing in bearings:
        before, after = (np.asarray(getattr(bearing, name)(one)) for one in asked)
        first = [6 * int(bearing.n) + k for k in range(3)]
        link = [] if bearing.n_link is None else [6 * n_nodes + 3 * (int(bearing.n_link) - n_nodes) + k for k in range(3)]
        matrix[np.ix_(first + link, first + link)] += after - before


def _taken(magnetic: Any, speed: float, frequency: float | None) -> tuple[str, ...]:
    """Notes on the speed and frequency at which coefficients were evaluated."""
    if not magnetic and frequency is None:
        return ()
    whole = f"coefficients of bearings and seals are for a rotor speed of {speed:g} Hz"
    if frequency is not None:
        whole += f", those that depend on the vibration frequency for {abs(frequency):g} Hz, forward or backward"
    if not magnetic:
        return (f"{whole}.",)
    names = ", ".join(one_line(el.tag) for el in magnetic)
    at = f"{abs(speed if frequency is None else frequency):g} Hz"
    advice = "" if frequency is not None else "; for whirl at another frequency use from_ross(rotor, speed, frequency)"
    return (f"{whole}.", f"magnetic bearings ({names}) have their coefficients for a vibration at {at}{advice}.")


def read_ross_over_speed(
    paths: Sequence[str | os.PathLike[str]], speeds: Sequence[float], free: bool = False
) -> FiniteElementModel:
    """Model with speed-dependent coefficients, from files of `rotor.save_mat` at increasing rotor speeds in Hz.

    Raises
    ------
    DataError
        As `read_ross`; unequal numbers of speeds and files, speeds that do not increase, files of different rotors.
    """
    if len(speeds) != len(paths):
        problem = f"{len(paths)} ROSS files need as many rotor speeds, those they were saved at (--speed), not {len(speeds)}"
        raise DataError(one_line(paths[0]), problem)
    return over_speed([read_ross(path, speed, free) for path, speed in zip(paths, speeds, strict=True)])


def read_ross(path: str | os.PathLike[str], speed: float | None = None, free: bool = False) -> FiniteElementModel:
    """Model from the file of ROSS's `rotor.save_mat(file, speed)`.

    Parameters
    ----------
    path : str or path
    speed : float, optional
        Speed in Hz at which it was saved, which the file does not contain.
    free : bool
        Whether rigid-body motions are allowed, because its scene adds bearings.

    Raises
    ------
    DataError
        Not such a file (M, K, C, G and nodes), or invalid matrices (`rotor_model`).
    """
    content = read_matrices(path).matrices
    source = one_line(path)
    missing = {*_ROLES.values(), "nodes"} - set(content)
    if missing:
        raise DataError(source, f"not a file of ROSS's save_mat: it has no {', '.join(sorted(missing))}")
    matrices, position = {role: content[name] for role, name in _ROLES.items()}, np.ravel(content["nodes"]).tolist()
    try:
        model = _model(matrices, position, source, speed, free)
        return replace(model, notes=(*model.notes, _saved_at(speed)))
    except DataError as error:
        if "no stiffness" not in error.problem:
            raise
        hint = "bearings whose coefficients depend on the speed may have none at 0 Hz: rotor.save_mat(file, speed)"
        raise DataError(source, f"{error.problem}; {hint}") from None


def _saved_at(speed: float | None) -> str:
    """Note on what a file of save_mat does not contain about its bearings."""
    at = "the rotor speed at which the file was saved" if speed is None else f"{speed:g} Hz, at which the file was saved"
    magnetic = "a magnetic bearing, whose controller answers to the frequency of a vibration, has those of that one frequency"
    return f"coefficients of bearings and seals are those at {at}; {magnetic}, and a whirl of another frequency meets others."


def _asked(matrix: Any, omega: float, vibration: float) -> Any:
    """Evaluate a matrix method at a rotor speed and a vibration frequency in rad/s, by its argument names: a lone "frequency" is
    the rotor speed."""
    takes = inspect.signature(matrix).parameters
    asked = {"frequency": vibration if "speed" in takes else omega, "speed": omega}
    return np.array(matrix(**{name: value for name, value in asked.items() if name in takes}))


def _refuse_complex(matrices: Any, source: str) -> None:
    for role, matrix in matrices.items():
        if not np.all(np.isfinite(matrix)) or np.any(matrix.imag):
            raise DataError(source, f"its {role} matrix is not real and finite")


def _frequencies(bearing: Any) -> Any:
    """Frequencies of the table of a bearing's coefficients, rad/s; empty if constant."""
    frequencies = getattr(bearing, "frequency", None)
    return np.zeros(0) if frequencies is None else np.ravel(frequencies).astype(float)


def _refuse_beyond(tables: Any, source: str) -> None:
    """DataError if a bearing's table of coefficients does not cover the requested frequency (rad/s)."""
    for tag, (frequencies, omega) in tables.items():
        if len(frequencies) > 1 and not _BELOW * frequencies.min() <= omega <= frequencies.max() / _BELOW:
            low, high = frequencies.min() / (2.0 * np.pi), frequencies.max() / (2.0 * np.pi)
            words = f"{one_line(tag)} has coefficients from {low:.4g} to {high:.4g} Hz, but not at {omega / (2.0 * np.pi):.4g} Hz"
            raise DataError(source, f"bearing {words}; give a speed")


def _model(matrices: Any, position: list[float], source: str, speed: float | None, free: bool = False) -> FiniteElementModel:
    size, n_nodes = matrices["mass"].shape[0], len(position)
    n_supports, left = divmod(size - 6 * n_nodes, 3)
    if left or n_supports < 0:
        raise DataError(source, f"its {size} rows are not six for each of {n_nodes} nodes and three for each point mass")
    node = np.concatenate([np.repeat(np.arange(n_nodes), 6), n_nodes + np.repeat(np.arange(n_supports), 3)])
    direction = np.array([*_NODE * n_nodes, *_SUPPORT * n_supports])
    table = Coordinates(node.astype(np.int64), direction, {}, dict(enumerate(position)))
    return rotor_model(matrices, table, source, units="m", speed=speed, free=free)
