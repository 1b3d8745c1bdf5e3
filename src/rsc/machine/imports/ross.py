"""Rotors of ROSS (petrobras/ross, versions 2.3 and 3): the live object, and the .mat file of `rotor.save_mat`.

Every node has six coordinates, x, y, z, alpha, beta and theta, in this order; behind those of the shaft's nodes come x, y and z
of each point mass (a support). alpha and beta are the rotations about x and y. M, K and C are asked at a frequency, at which the
coefficients of bearings and seals are taken; G is multiplied by the speed. Tables of bearings and seals are over the rotor speed,
whatever ROSS calls it; only those of a magnetic bearing are over the frequency of a vibration, whose controller answers to that.
ROSS itself is not imported.
"""

import inspect
import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rsc.errors import DataError, one_line
from rsc.machine.formats import read_matrices
from rsc.machine.imports.build import rotor_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.model.following import over_speed
from rsc.machine.model.model import FiniteElementModel

_NODE = ("x", "y", "other", "rx", "ry", "other")
_SUPPORT = ("x", "y", "other")
_BELOW = 1.0 - 1e-9  # of the end of a table: 4000 rpm / 60 is rounded
_ROLES = {"mass": "M", "stiffness": "K", "damping": "C", "gyroscopic": "G"}


def from_ross(
    rotor, speed: float = 0.0, frequency: float | None = None, *, speeds: Sequence[float] | None = None
) -> FiniteElementModel:
    """Model of a ROSS rotor.

    Parameters
    ----------
    rotor : ross.Rotor
        Or anything with its M, K, C, G, nodes, nodes_pos and shaft_elements.
    speed : float
        Rotor speed at which the coefficients of bearings and seals are taken, Hz (ROSS takes rad/s).
    frequency : float, optional
        Frequency in Hz of the vibration at which coefficients that depend on it are taken: those of magnetic bearings, and
        whatever a later ROSS asks for at a speed and a frequency. Of a backward whirl, which is negative, its size. By default
        the speed, as ROSS does. The notes of the model say what was taken.
    speeds : sequence of float, optional
        Two or more rotor speeds in Hz, rising: the coefficients follow the speed, linear between these.

    Returns
    -------
    FiniteElementModel
        Nodes have ROSS's numbers, point masses those behind them; tags of discs and bearings are names of their nodes; diameters
        are the outer ones of the elements.

    Raises
    ------
    DataError
        No such object, or matrices that cannot be right (`rotor_model`); magnetic bearings over several speeds without a
        frequency, which would then follow the speed.
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
        raise DataError(source, f"no rotor of ROSS 2.3 or 3: {one_line(error)}") from None
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


def _over_speeds(rotor, frequency, speeds):
    if frequency is None and any(map(_is_magnetic, getattr(rotor, "bearing_elements", ()))):
        problem = "coefficients of a magnetic bearing follow the frequency of a vibration, not the rotor speed; name a frequency"
        raise DataError("ROSS rotor", problem)
    return over_speed([from_ross(rotor, speed, frequency) for speed in speeds])


def _is_magnetic(bearing):
    return any(kind.__name__ == "MagneticBearingElement" for kind in type(bearing).__mro__)


def _exchanged(matrix, bearings, name, asked, n_nodes):
    """In the rows of some bearings their coefficients at another frequency: asked = (that of the matrix, the other), rad/s."""
    if asked[0] == asked[1]:
        return
    for bearing in bearings:
        before, after = (np.asarray(getattr(bearing, name)(one)) for one in asked)
        first = [6 * int(bearing.n) + k for k in range(3)]
        link = [] if bearing.n_link is None else [6 * n_nodes + 3 * (int(bearing.n_link) - n_nodes) + k for k in range(3)]
        matrix[np.ix_(first + link, first + link)] += after - before


def _taken(magnetic, speed, frequency):
    """What was taken of bearings that depend on the frequency of a vibration, in words."""
    if not magnetic and frequency is None:
        return ()
    whole = f"coefficients of bearings and seals are those at a rotor speed of {speed:g} Hz"
    if frequency is not None:
        whole += f", what depends on the frequency of a vibration that at {abs(frequency):g} Hz, forward or backward"
    if not magnetic:
        return (f"{whole}.",)
    names = ", ".join(one_line(el.tag) for el in magnetic)
    at = f"{abs(speed if frequency is None else frequency):g} Hz"
    advice = "" if frequency is not None else "; a whirl of another frequency meets others: from_ross(rotor, speed, frequency)"
    return (f"{whole}.", f"magnetic bearings ({names}) have the coefficients of a vibration at {at}{advice}.")


def read_ross_over_speed(
    paths: Sequence[str | os.PathLike[str]], speeds: Sequence[float], free: bool = False
) -> FiniteElementModel:
    """Model whose coefficients follow the speed, from files of `rotor.save_mat` at rotor speeds in Hz, in order.

    Raises
    ------
    DataError
        As `read_ross`; another number of speeds than files, speeds that do not rise, files of different rotors.
    """
    if len(speeds) != len(paths):
        problem = f"{len(paths)} files of ROSS need as many rotor speeds, at which they were saved (--speed), not {len(speeds)}"
        raise DataError(one_line(paths[0]), problem)
    return over_speed([read_ross(path, speed, free) for path, speed in zip(paths, speeds, strict=True)])


def read_ross(path: str | os.PathLike[str], speed: float | None = None, free: bool = False) -> FiniteElementModel:
    """Model from the file of ROSS's `rotor.save_mat(file, speed)`.

    Parameters
    ----------
    path : str or path
    speed : float, optional
        The speed it was saved at, Hz, which the file does not tell.
    free : bool
        Whether it may move freely, because its scene adds bearings.

    Raises
    ------
    DataError
        Not such a file (M, K, C, G and nodes), or matrices that cannot be right (`rotor_model`).
    """
    content = read_matrices(path).matrices
    source = one_line(path)
    missing = {*_ROLES.values(), "nodes"} - set(content)
    if missing:
        raise DataError(source, f"no file of ROSS's save_mat: it has no {', '.join(sorted(missing))}")
    matrices, position = {role: content[name] for role, name in _ROLES.items()}, np.ravel(content["nodes"]).tolist()
    try:
        model = _model(matrices, position, source, speed, free)
        return replace(model, notes=(*model.notes, _saved_at(speed)))
    except DataError as error:
        if "no stiffness" not in error.problem:
            raise
        hint = "bearings whose coefficients depend on the speed may have none at 0 Hz: rotor.save_mat(file, speed)"
        raise DataError(source, f"{error.problem}; {hint}") from None


def _saved_at(speed):
    """What a file of save_mat does not tell of its bearings, in words."""
    at = "the rotor speed at which the file was saved" if speed is None else f"{speed:g} Hz, at which the file was saved"
    magnetic = "a magnetic bearing, whose controller answers to the frequency of a vibration, has those of that one frequency"
    return f"coefficients of bearings and seals are those at {at}; {magnetic}, and a whirl of another frequency meets others."


def _asked(matrix, omega, vibration):
    """The matrix at a rotor speed and a frequency of a vibration in rad/s, by the names of its arguments: "frequency" alone is
    the rotor speed."""
    takes = inspect.signature(matrix).parameters
    asked = {"frequency": vibration if "speed" in takes else omega, "speed": omega}
    return np.array(matrix(**{name: value for name, value in asked.items() if name in takes}))


def _refuse_complex(matrices, source):
    for role, matrix in matrices.items():
        if not np.all(np.isfinite(matrix)) or np.any(matrix.imag):
            raise DataError(source, f"its {role} matrix is not real and finite")


def _frequencies(bearing):
    """Frequencies of a bearing's coefficients, rad/s; none where they do not depend on them."""
    frequencies = getattr(bearing, "frequency", None)
    return np.zeros(0) if frequencies is None else np.ravel(frequencies).astype(float)


def _refuse_beyond(tables, source):
    """Coefficients of a bearing are known from its lowest to its highest frequency (rad/s), if it has a table of them."""
    for tag, (frequencies, omega) in tables.items():
        if len(frequencies) > 1 and not _BELOW * frequencies.min() <= omega <= frequencies.max() / _BELOW:
            low, high = frequencies.min() / (2.0 * np.pi), frequencies.max() / (2.0 * np.pi)
            words = f"{one_line(tag)} has coefficients from {low:.4g} to {high:.4g} Hz, none at {omega / (2.0 * np.pi):.4g} Hz"
            raise DataError(source, f"bearing {words}; name a speed")


def _model(matrices, position, source, speed, free=False):
    size, n_nodes = matrices["mass"].shape[0], len(position)
    n_supports, left = divmod(size - 6 * n_nodes, 3)
    if left or n_supports < 0:
        raise DataError(source, f"its {size} rows are not six for each of {n_nodes} nodes and three for each point mass")
    node = np.concatenate([np.repeat(np.arange(n_nodes), 6), n_nodes + np.repeat(np.arange(n_supports), 3)])
    direction = np.array([*_NODE * n_nodes, *_SUPPORT * n_supports])
    table = Coordinates(node.astype(np.int64), direction, {}, dict(enumerate(position)))
    return rotor_model(matrices, table, source, units="m", speed=speed, free=free)
