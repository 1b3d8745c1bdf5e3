"""Francis' double-shift QR iteration on a real Hessenberg matrix, for its eigenvalues alone, compiled.

Each sweep turns three rows and then three columns at a time. Rows lie one after another, so a turn of rows is a vector
operation; LAPACK's routine (dlahqr) does both number by number.
"""

from functools import cache
from math import copysign, sqrt

import numba
import numpy as np

from rsc.compiled.paths import cached

_EPS, _TINY = np.finfo(float).eps, np.finfo(float).tiny / np.finfo(float).eps
_SWEEPS = 60  # without an eigenvalue: given up
_STALLED = 10  # after every so many of them the shifts are others, in case the usual ones lead round a circle

_part = numba.njit(error_model="numpy", fastmath={"contract"})


def hessenberg_eigenvalues(matrix):
    """Eigenvalues of a real upper Hessenberg matrix (n, n), which is overwritten: (n,) complex, or None without convergence."""
    real, imaginary = np.empty(len(matrix)), np.empty(len(matrix))
    return real + 1j * imaginary if _compiled()(matrix, real, imaginary) else None


@cache
def _compiled():
    return cached(_iterate, __file__, fastmath={"contract"})


def _iterate(h, real, imaginary):
    """Fill in real and imaginary parts; whether all were found."""
    last, sweeps = len(h) - 1, 0
    while last >= 0:
        first = _first_of_block(h, last)
        if first > 0:
            h[first, first - 1] = 0.0
        if first == last:
            real[last], imaginary[last] = h[last, last], 0.0
        elif first == last - 1:
            real[first], imaginary[first], real[last], imaginary[last] = _of_two(
                h[first, first], h[first, last], h[last, first], h[last, last]
            )
        else:
            sweeps += 1
            if sweeps > _SWEEPS:
                return False
            _sweep(h, first, last, _shifts(h, first, last, sweeps))
            continue
        last, sweeps = first - 1, 0
    return True


@_part
def _first_of_block(h, last):
    """First row of the block that ends at row `last`: below the diagonal it is connected, up to rounding."""
    for k in range(last, 0, -1):
        below, size = abs(h[k, k - 1]), abs(h[k - 1, k - 1]) + abs(h[k, k])
        if below <= _TINY:
            return k
        if below <= _EPS * size:
            # Ahues and Tisseur's criterion: also small against what the eigenvalues of these two rows differ by
            above, gap, diagonal = abs(h[k - 1, k]), abs(h[k - 1, k - 1] - h[k, k]), abs(h[k, k])
            large, wide = max(below, above), max(diagonal, gap)
            total = wide + large
            if min(below, above) * (large / total) <= max(_TINY, _EPS * (min(diagonal, gap) * (wide / total))):
                return k
    return 0


@_part
def _of_two(a, b, c, d):
    """Eigenvalues of [[a, b], [c, d]]: real and imaginary part of each."""
    half = 0.5 * (a - d)
    size = max(abs(half), abs(b), abs(c))  # c is never 0 here
    square = (half / size) * (half / size) + (b / size) * (c / size)
    if square < 0.0:
        imaginary = sqrt(-square) * size
        return d + half, imaginary, d + half, -imaginary
    far = half + copysign(sqrt(square) * size, half)
    return d + far, 0.0, d - (b / far) * c if far != 0.0 else d, 0.0


@_part
def _shifts(h, first, last, sweeps):
    """The eigenvalues of the last two rows; of two real ones twice the one nearer to the last entry."""
    a, b, c, d = h[last - 1, last - 1], h[last - 1, last], h[last, last - 1], h[last, last]
    if sweeps % _STALLED == 0:
        size = abs(c) + abs(h[last - 1, last - 2])
        a = d = d + 0.75 * size
        b, c = -0.4375 * size, size
    real, imaginary, other, opposite = _of_two(a, b, c, d)
    if imaginary == 0.0:
        real = other = real if abs(real - d) <= abs(other - d) else other
    return real, imaginary, other, opposite


@_part
def _first_column(h, k, shifts):
    """The three entries of (h - shift)(h - other shift) below and at the diagonal in column k, scaled."""
    real, imaginary, other, opposite = shifts
    size = abs(h[k, k] - other) + abs(opposite) + abs(h[k + 1, k])
    below = h[k + 1, k] / size
    x = below * h[k, k + 1] + (h[k, k] - real) * ((h[k, k] - other) / size) - imaginary * (opposite / size)
    y = below * (h[k, k] + h[k + 1, k + 1] - real - other)
    z = below * h[k + 2, k + 1]
    size = abs(x) + abs(y) + abs(z)
    return x / size, y / size, z / size


@_part
def _start(h, first, last, shifts):
    """(k, x, y, z): a sweep starts as far down as two successive small entries below the diagonal allow."""
    k = last - 2
    while True:
        x, y, z = _first_column(h, k, shifts)
        if k == first:
            return k, x, y, z
        around = abs(h[k - 1, k - 1]) + abs(h[k, k]) + abs(h[k + 1, k + 1])
        if abs(h[k, k - 1]) * (abs(y) + abs(z)) <= _EPS * abs(x) * around:
            return k, x, y, z
        k -= 1


@_part
def _sweep(h, first, last, shifts):
    """One step of the iteration on rows and columns first to last."""
    start, x, y, z = _start(h, first, last, shifts)
    for k in range(start, last):
        below = k + 2 <= last
        if k > start:
            x, y, z = h[k, k - 1], h[k + 1, k - 1], h[k + 2, k - 1] if below else 0.0
        length = sqrt(x * x + y * y + z * z)
        if length == 0.0:
            continue
        # 1 - t v v^T with v = (1, v_y, v_z) leaves of the vector (x, y, z) only its first entry
        left = -copysign(length, x)
        t, v_y, v_z = (left - x) / left, y / (x - left), z / (x - left)
        if k > start:
            h[k, k - 1], h[k + 1, k - 1] = left, 0.0
            if below:
                h[k + 2, k - 1] = 0.0
        elif k > first:
            h[k, k - 1] *= 1.0 - t  # the small entries beside it stay below rounding
        if below:
            _turn_rows(h, k, last + 1, t, v_y, v_z)
            _turn_columns(h, first, min(k + 3, last) + 1, k, t, v_y, v_z)
        else:
            _turn_two(h, first, last, t, v_y)


# unsigned numbers of rows and columns: Numba asks signed ones for their sign, and the loops are no vector operations any more


@_part
def _turn_rows(h, k, end, t, v_y, v_z):
    """Rows k to k + 2, columns k to end - 1."""
    k, t_y, t_z = np.uint64(k), t * v_y, t * v_z
    y, z = k + np.uint64(1), k + np.uint64(2)
    for j in range(k, np.uint64(end)):
        total = h[k, j] + v_y * h[y, j] + v_z * h[z, j]
        h[k, j] -= total * t
        h[y, j] -= total * t_y
        h[z, j] -= total * t_z


@_part
def _turn_columns(h, first, end, k, t, v_y, v_z):
    """Columns k to k + 2, rows first to end - 1."""
    k, t_y, t_z = np.uint64(k), t * v_y, t * v_z
    y, z = k + np.uint64(1), k + np.uint64(2)
    for i in range(np.uint64(first), np.uint64(end)):
        total = h[i, k] + v_y * h[i, y] + v_z * h[i, z]
        h[i, k] -= total * t
        h[i, y] -= total * t_y
        h[i, z] -= total * t_z


@_part
def _turn_two(h, first, last, t, v_y):
    """The last two rows and columns, which end the sweep."""
    k, t_y = last - 1, t * v_y
    for j in range(k, last + 1):
        total = h[k, j] + v_y * h[last, j]
        h[k, j] -= total * t
        h[last, j] -= total * t_y
    for i in range(first, last + 1):
        total = h[i, k] + v_y * h[i, last]
        h[i, k] -= total * t
        h[i, last] -= total * t_y
