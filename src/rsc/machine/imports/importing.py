"""Models from files: what `rsc import` does before anything is reduced or written."""

import os
from pathlib import Path

import numpy as np
import scipy.sparse

from rsc.errors import DataError, one_line
from rsc.machine.formats import read_matrices
from rsc.machine.imports.build import WORDS, rotor_model, stator_model
from rsc.machine.imports.coordinates import from_labels, read_table
from rsc.machine.imports.supports import read_supports, with_supports
from rsc.machine.model.model import FiniteElementModel

MatrixSource = str | os.PathLike[str] | tuple[str | os.PathLike[str], str]
# names that programs give the matrices, where a file has several
_NAMES = {
    "mass": {"m", "mass", "maa", "maax", "mgg", "mxx", "m2gg"},
    "damping": {"c", "b", "d", "damping", "baa", "baax", "bgg", "caa", "caax"},
    "gyroscopic": {"g", "gyroscopic", "gaa", "gaax", "ggg", "gyro"},
    "rotating_damping": {"rotating_damping", "di", "crot", "c_rot"},
    "stiffness": {"k", "stiffness", "kaa", "kaax", "kgg", "kxx", "k2gg"},
}


def import_fe(
    mass: MatrixSource,
    stiffness: MatrixSource,
    damping: MatrixSource | None = None,
    gyroscopic: MatrixSource | None = None,
    coordinates: str | os.PathLike[str] | None = None,
    rotating_damping: MatrixSource | None = None,
    *,
    contact: int | str | None = None,
    stator: bool = False,
    **options,
) -> FiniteElementModel:
    """Read a finite-element model from its matrix files and its coordinate table.

    Parameters
    ----------
    mass, stiffness, damping, gyroscopic, rotating_damping : path, or (path, name)
        Files as `read_matrices` takes them; the name picks one of several matrices of a file, which is needed where none of them
        has a customary name (K, stiffness, KAA, model.K, ...). Rotor: M q'' + (C + Omega G) q' + K q = f;
        rotating damping D acts in the coordinates that turn with the rotor.
    coordinates : path, optional
        The table (`read_table`); not needed where the files carry node and direction of their rows (DMIG, Abaqus, CalculiX).
    contact : int or str, optional
        Node of the contact; needed for a stator.
    stator : bool
        Whether the body is a stator, a rotor otherwise.
    **options
        axis: "x", "y" or "z" (default), the axis of the rotor in files that carry directions. units: "m" or "mm" (mm, N, t, s).
        speed: Hz, at which coefficients of bearings were taken (rotor). free: whether a rotor may move freely, because its scene
        adds bearings. supports: table of those whose coefficients follow the speed (`read_supports`). band: Hz, up to which a
        stator is looked at (500).

    Raises
    ------
    DataError
        A file that cannot be read, or matrices that cannot be right: see `rotor_model` and `stator_model`.
    """
    sources = {"mass": mass, "damping": damping, "gyroscopic": gyroscopic, "stiffness": stiffness}
    sources["rotating_damping"] = rotating_damping
    unknown = set(options) - {"axis", "units", "speed", "band", "free", "supports"}
    if unknown:
        raise TypeError(f"unknown option {min(unknown)}")
    matrices, labels = {}, {}
    for role, wanted in sources.items():
        if wanted is not None:
            matrices[role], labels[role] = picked(wanted, role)
    name = one_line(stiffness[0] if isinstance(stiffness, tuple) else stiffness)
    if all(label is not None for label in labels.values()):
        matrices, rows = aligned(matrices, labels)
        table = from_labels(rows, options.get("axis", "z"), name)
        if coordinates is not None:
            table = _named(table, read_table(coordinates), coordinates)
    elif coordinates is None:
        raise DataError(name, "its rows carry no nodes and directions: a coordinate table is needed")
    else:
        table = read_table(coordinates)
    if stator:
        if contact is None:
            raise DataError(name, "a stator needs the node of its contact")
        return stator_model(matrices, table, name, contact, options.get("band", 500.0), options.get("units"))
    supports = options.get("supports")
    free = options.get("free", False) or supports is not None
    model = rotor_model(matrices, table, name, options.get("units"), options.get("speed"), free)
    if supports is not None:
        model = with_supports(model, read_supports(supports))
    if contact is not None:
        model.row_at(contact)
    return model


def picked(wanted: MatrixSource, role: str):
    """(matrix, labels or None) of one file: the named one, the only square one, or the one with a customary name.

    Raises
    ------
    DataError
        No such matrix, or several that could be meant.
    """
    path, name = wanted if isinstance(wanted, tuple) else (wanted, None)
    content = read_matrices(path)
    square = [key for key, matrix in content.matrices.items() if matrix.ndim == 2 and matrix.shape[0] == matrix.shape[1] > 1]
    if name is not None:
        chosen = [key for key in content.matrices if key == name]
    elif len(square) == 1:
        chosen = square
    else:
        chosen = [key for key in square if key.rpartition(".")[2].lower() in _NAMES[role]]
    if len(chosen) != 1:
        known = ", ".join(one_line(key) for key in sorted(square)[:10]) or "no square ones"
        raise DataError(one_line(Path(path)), f"which matrix is {WORDS[role]}? It has {known}; name one")
    return content.matrices[chosen[0]], content.labels.get(chosen[0])


def aligned(matrices, labels):
    """(matrices, labels) with one common order of rows: those of all labels, sorted. Rows that a file does not have are empty."""
    rows = np.unique(np.concatenate(list(labels.values())), axis=0)
    order = {tuple(row): i for i, row in enumerate(rows.tolist())}
    moved = {}
    for role, matrix in matrices.items():
        place = np.array([order[tuple(row)] for row in labels[role].tolist()])
        entries = scipy.sparse.coo_array(matrix)
        i, j = place[entries.row], place[entries.col]
        moved[role] = scipy.sparse.coo_array((entries.data, (i, j)), shape=(len(rows),) * 2).tocsc()
    return moved, rows


def _named(table, own, path):
    """The table of the labels with the names and positions of the user's table, which must have the same nodes in its rows."""
    if len(table) != len(own) or not np.array_equal(table.node, own.node):
        raise DataError(one_line(path), "its nodes are not those of the files' rows, sorted by node and direction")
    return own
