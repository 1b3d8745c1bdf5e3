"""Modes times samples, compiled: the motion of a run in the scene's coordinates."""

from functools import cache

import numpy as np

from rsc.compiled.paths import cached

_ROWS = 64  # samples at a time: their numbers stay in the nearest cache


def times(shape, rows):
    """shape (n, m) times every row of complex numbers (k, m), (k, n), summed in one order: a matrix product's bits would depend
    on how many rows there are."""
    if not shape.size:
        return np.zeros((rows.shape[0], shape.shape[0]), dtype=complex)
    if len(shape) == 1 and shape[0, 0] == 1.0:  # normalised to its coordinate
        return rows
    result = np.empty((len(rows), len(shape)), dtype=complex)
    _compiled()(np.ascontiguousarray(shape), rows, result)
    return result


@cache
def _compiled():
    return cached(_multiply, __file__)


def _multiply(shape, rows, result):
    n, m = shape.shape
    y, z = np.empty((m, _ROWS)), np.empty((m, _ROWS))
    sum_y, sum_z = np.empty(_ROWS), np.empty(_ROWS)
    for first in range(0, len(rows), _ROWS):
        count = min(_ROWS, len(rows) - first)
        for k in range(count):
            for j in range(m):
                y[j, k], z[j, k] = rows[first + k, j].real, rows[first + k, j].imag
        for i in range(n):
            for k in range(_ROWS):
                # times a complex number whose imaginary part is zero: what is zero keeps its sign
                sum_y[k], sum_z[k] = y[0, k] * shape[i, 0] - z[0, k] * 0.0, z[0, k] * shape[i, 0] + y[0, k] * 0.0
            for j in range(1, m):
                s = shape[i, j]
                for k in range(_ROWS):
                    sum_y[k] += y[j, k] * s - z[j, k] * 0.0
                    sum_z[k] += z[j, k] * s + y[j, k] * 0.0
            for k in range(count):
                result[first + k, i] = complex(sum_y[k], sum_z[k])
