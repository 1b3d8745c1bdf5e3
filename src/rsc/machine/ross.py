"""Rotors of ROSS (petrobras/ross, versions 2.3 and 3): the live object, and the .mat file of `rotor.save_mat`.

Every node has six coordinates, x, y, z, alpha, beta and theta, in this order; behind those of the shaft's nodes come x, y and z
of each point mass (a support). alpha and beta are the rotations about x and y. M, K and C are asked at a frequency, at which the
coefficients of bearings and seals are taken; G is multiplied by the speed. ROSS itself is not imported.
"""

import inspect
import os

import numpy as np

from rsc.errors import DataError, one_line
from rsc.machine.build import rotor_model
from rsc.machine.coordinates import Coordinates
from rsc.machine.formats import read_matrices
from rsc.machine.model import Model

_NODE = ("x", "y", "other", "rx", "ry", "other")
_SUPPORT = ("x", "y", "other")
_ROLES = {"mass": "M", "stiffness": "K", "damping": "C", "gyroscopic": "G"}


def from_ross(rotor, speed: float = 0.0) -> Model:
    """Model of a ROSS rotor.

    Parameters
    ----------
    rotor : ross.Rotor
        Or anything with its M, K, C, G, nodes, nodes_pos and shaft_elements.
    speed : float
        Rotor speed at which the coefficients of bearings and seals are taken, Hz (ROSS takes rad/s).

    Returns
    -------
    Model
        Nodes have ROSS's numbers, point masses those behind them; tags of discs and bearings are names of their nodes; diameters
        are the outer ones of the elements.

    Raises
    ------
    DataError
        No such object, or matrices that cannot be right (`rotor_model`).
    """
    source, omega = "ROSS rotor", 2.0 * np.pi * speed
    try:
        matrices = {role: np.asarray(_asked(getattr(rotor, name), omega)) for role, name in _ROLES.items()}
        position = [float(place) for place in rotor.nodes_pos]
        elements = [(int(el.n), float(el.odl), float(el.odr)) for el in rotor.shaft_elements]
        named = [(str(el.tag), int(el.n)) for el in [*rotor.disk_elements, *rotor.bearing_elements]]
        tables = {str(el.tag): _frequencies(el) for el in rotor.bearing_elements}
    except (AttributeError, TypeError, ValueError) as error:
        raise DataError(source, f"no rotor of ROSS 2.3 or 3: {one_line(error)}") from None
    _refuse_complex(matrices, source)
    _refuse_beyond(tables, omega, source)
    model = _model({role: matrix.real for role, matrix in matrices.items()}, position, source, speed)
    diameter: dict[int, float] = {}
    for node, left, right in elements:
        diameter[node] = max(diameter.get(node, 0.0), left)
        diameter[node + 1] = max(diameter.get(node + 1, 0.0), right)
    names: dict[str, int] = {}
    for tag, node in named:
        names.setdefault(tag, node)
    return Model(**{**vars(model), "diameter": diameter, "names": names})


def read_ross(path: str | os.PathLike[str], speed: float | None = None, free: bool = False) -> Model:
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
        return _model(matrices, position, source, speed, free)
    except DataError as error:
        if "no stiffness" not in error.problem:
            raise
        hint = "bearings whose coefficients depend on the speed may have none at 0 Hz: rotor.save_mat(file, speed)"
        raise DataError(source, f"{error.problem}; {hint}") from None


def _asked(matrix, omega):
    """The matrix at a speed and a frequency of rad/s, by the names of its arguments."""
    takes = inspect.signature(matrix).parameters
    return matrix(**{name: omega for name in ("frequency", "speed") if name in takes})


def _refuse_complex(matrices, source):
    for role, matrix in matrices.items():
        if not np.all(np.isfinite(matrix)) or np.any(matrix.imag):
            raise DataError(source, f"its {role} matrix is not real and finite")


def _frequencies(bearing):
    """Frequencies of a bearing's coefficients, rad/s; none where they do not depend on them."""
    frequencies = getattr(bearing, "frequency", None)
    return np.zeros(0) if frequencies is None else np.ravel(frequencies).astype(float)


def _refuse_beyond(tables, omega, source):
    """Coefficients of a bearing are known from its lowest to its highest frequency (rad/s), if it has a table of them."""
    for tag, frequencies in tables.items():
        if len(frequencies) > 1 and not frequencies.min() <= omega <= frequencies.max():
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
