"""Layout of the kernel's arrays: matrices start on cache lines, and the numbers of coordinates come in classes.

The number of coordinates left by a reduction changes with every tolerance, band and speed, and the kernel is compiled anew for
each number. Padding with inert coordinates, to fill the last register, costs little (bench/results/classes.md): registers hold
two complex coordinates if vectors are short, four if they are long (`VecType`).
"""

import numpy as np

from rsc.kernel.model import CONTACT_VECTORS, MODEL_VECTORS, Model
from rsc.kernel.simd.registers import FEW

_LINE = 8  # doubles in a cache line
# sizes: any up to EACH coordinates, multiples of 2 up to EVEN, multiples of 4 beyond
EACH, EVEN = 4, FEW // 2
_SCALES, _MATRICES = ("scale_x", "scale_v"), ("damping_columns", "gyroscopic_columns", "stiffness_columns", "rotating_columns")
_FOLLOWING = ("following_stiffness", "following_damping")


def on_lines(matrix):
    """A copy (n, m) that starts on a cache line; otherwise loaded registers may straddle two lines."""
    room = np.empty(matrix.size + _LINE)
    first = -room.ctypes.data % (8 * _LINE) // 8
    aligned = room[first : first + matrix.size].reshape(matrix.shape)
    aligned[...] = matrix
    return aligned


def size_of_class(n):
    """Number of coordinates in the kernel for n coordinates of a scene with a reduced body."""
    step = 1 if n <= EACH else 2 if n <= EVEN else 4
    return -(-n // step) * step


def filled(model: Model) -> Model:
    """The model padded with inert coordinates to the size of its class."""
    n = model.stiffness.size // 2
    return widened(model, size_of_class(n))


def widened(model: Model, size: int) -> Model:
    """The model padded with inert coordinates to `size` coordinates."""
    n = model.stiffness.size // 2
    if size == n:
        return model
    vectors = {name: longer(getattr(model, name), 2 * size) for name in MODEL_VECTORS}
    for name in _SCALES:
        vectors[name][2 * n :] = vectors[name][0]  # divisor of their error, which is zero
    contacts = tuple(_longer_contact(contact, 2 * size) for contact in model.contacts)
    matrices = {name: _larger(getattr(model, name), n, size) for name in _MATRICES}
    watched = np.array([longer(row, 2 * size) for row in model.watched_rows]) if len(model.watched_rows) else ()
    for name in _FOLLOWING:
        columns = getattr(model, name)
        shape = (*np.shape(columns)[:2], 2 * size, 2 * size)
        matrices[name] = _larger(columns, n, size).reshape(shape) if len(columns) else ()
    matrices |= {"weight": longer(model.weight, 2 * size), "states": _more_states(model.states, n, size)}
    return model._replace(**vectors, watched_rows=watched, contacts=contacts, **matrices)


def _more_states(states, n, size):
    """First-order states padded from n to `size` coordinates; () without."""
    if not states:
        return states
    columns = _larger(states.columns, n, size).reshape(*states.columns.shape[:2], size, 2 * size)
    mark, weight = (longer(vector, 2 * size) for vector in (states.mark, states.weight))
    return states._replace(columns=columns, mark=mark, weight=weight)


def _longer_contact(contact, size):
    """A contact's data with rows padded to `size` numbers."""
    rows = {name: longer(getattr(contact, name), size) for name in CONTACT_VECTORS}
    race = contact.race._replace(row=longer(contact.race.row, size)) if contact.race else ()
    return contact._replace(**rows, race=race)


def longer(vector, size):
    """A vector padded with zeros to `size` numbers."""
    return np.concatenate([vector, np.zeros(size - vector.size)])


def _larger(columns, n, size):
    """Columns (n, 2n) of a matrix, or several stacked, padded for `size` coordinates; () if absent."""
    if not len(columns):
        return columns
    blocks = columns.reshape(-1, n, 2 * n)
    room = np.zeros((len(blocks), size, 2 * size))
    room[:, :n, : 2 * n] = blocks
    return on_lines(room.reshape(-1, 2 * size))
