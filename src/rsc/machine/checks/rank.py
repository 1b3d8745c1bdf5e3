"""Which motions of a body have a stiffness, as far as the digits of its file tell.

A file of ten digits, or of single precision, knows an entry to a part u of it, and v^T K v of a motion v to u |v|^T |K| |v|. Of a
free body v^T K v is that rounding alone, of either sign: 10^-9 of the stiffness of an element looks like a support of some Hz.
So the lowest motions are computed, and one whose stiffness is below that bound has none.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse

from rsc.errors import DataError
from rsc.machine.checks.checks import inertia, largest_of_rows
from rsc.machine.model.model import DOUBLE

SINGLE = 2.0**-24  # rounding of an entry over itself in single precision
_SHIFT = 64.0  # roundings of each coordinate's own stiffness: what keeps a free body's stiffness positive
_MOTIONS, _ITERATIONS = 8, 12  # lowest motions that are looked at, and inverse iterations for them
# entries whose digits are counted; decimal digits of what is taken for exact, and the most that a program rounds to
_SAMPLE, _EXACT, _MOST_DIGITS = 2000, 4, 13
_SHORT = 12  # bits of a number that is exact in any precision, as small whole numbers


class Lowest(NamedTuple):
    """The lowest motions of a body.

    free : int, how many of them have no stiffness
    frequency : float, Hz, natural frequency of the lowest that has one; infinite where all are free
    """

    free: int
    frequency: float


def rounding_of(matrix) -> float:
    """Largest rounding of an entry over itself, as its digits tell: those of decimal numbers of some digits, of single precision
    (also printed with more digits than it has), or of double precision."""
    entries = matrix.data if scipy.sparse.issparse(matrix) else np.asarray(matrix)[np.nonzero(matrix)]
    entries = entries[np.isfinite(entries) & (entries != 0.0)]
    sample = entries[:: max(1, len(entries) // _SAMPLE)]
    bits = np.frexp(sample)[0] * 2.0**_SHORT
    if not len(sample) or np.mean(bits != np.floor(bits)) < 0.1:
        return DOUBLE
    with np.errstate(over="ignore", under="ignore"):
        numbers, single = sample.tolist(), sample.astype(np.float32).astype(float)
    digits = next((digits for digits in range(_EXACT, _MOST_DIGITS + 1) if _have_digits(numbers, digits)), 17)
    if digits == _EXACT:
        return DOUBLE
    # short decimal numbers may be exact in single precision too: that they are short is no chance
    in_single = np.array_equal(single, sample) if digits > 7 else False
    if in_single or (8 < digits < 17 and _printed(single.tolist(), digits) == _printed(numbers, digits)):
        return SINGLE
    return DOUBLE if digits == 17 else 0.5 * 10.0 ** (1 - digits)


def _printed(numbers, digits):
    return [f"{number:.{digits - 1}e}" for number in numbers]


def _have_digits(numbers, digits):
    """Whether none of the numbers has more decimal digits."""
    return all(float(f"{number:.{digits - 1}e}") == number for number in numbers)


def held(mass, stiffness, source, advice, rounding=DOUBLE):
    """Refuse a stiffness that is indefinite or lets the body move freely.

    Parameters
    ----------
    mass, stiffness : (n, n), dense or sparse
    source, advice : str, for messages
    rounding : float
        Of an entry of the stiffness over itself (`rounding_of`).

    Returns
    -------
    frequency : float, Hz
        Lowest natural frequency.
    solve : function (n, k) -> (n, k)
        Displacements under forces.

    Raises
    ------
    DataError
        Also where a coordinate has neither mass nor stiffness.
    """
    negative, solve = inertia(stiffness - _SHIFT * 2.0**-53 * _own(mass, stiffness, source, advice))
    if negative:
        free = max(lowest_motions(mass, stiffness, source, rounding).free, 1)
    else:
        free, frequency = _lowest(mass, stiffness, solve, source, rounding)
    if free:
        digits = "" if rounding == DOUBLE else f" at the {digits_of(rounding)} digits of its numbers"
        soft = digits and ", or too soft for so few digits"
        raise DataError(source, f"{advice}{soft}: {free} rigid-body or other motions have no stiffness{digits}")
    return frequency, solve


def lowest_motions(mass, stiffness, source, rounding=DOUBLE) -> Lowest:
    """The lowest motions of a body that may be free.

    Raises
    ------
    DataError
        The stiffness is indefinite beyond rounding.
    """
    own = _own(mass, stiffness, source, "nothing of it can be reduced")
    negative, solve = inertia(stiffness + _SHIFT * rounding * own)
    if negative:
        raise DataError(source, "the stiffness is indefinite: it has negative eigenvalues")
    return _lowest(mass, stiffness, solve, source, rounding)


def digits_of(rounding):
    """Decimal digits of numbers with this rounding."""
    return int(np.floor(1.0 - np.log10(2.0 * rounding) + 1e-9))


def _own(mass, stiffness, source, advice):
    """Each coordinate's own stiffness, as a diagonal matrix: rounding is measured against it, since tilts of a fine mesh are
    10^15 times stiffer, over their inertia, than the shaft on its bearings. Refused are bodies without mass or stiffness."""
    empty = np.flatnonzero((largest_of_rows(mass) == 0.0) & (largest_of_rows(stiffness) == 0.0))
    if empty.size:
        raise DataError(source, f"{empty.size} coordinates have neither mass nor stiffness, the first is number {empty[0] + 1}")
    heavy, own = mass.diagonal() > 0.0, np.array(stiffness.diagonal(), dtype=float)
    if not heavy.any():
        raise DataError(source, "the mass matrix is zero")
    if own.max() <= 0.0:
        raise DataError(source, f"nothing has a stiffness; {advice}")
    bare = own <= 0.0  # a mass that nothing holds
    own[bare] = mass.diagonal()[bare] * np.max(own[heavy] / mass.diagonal()[heavy], initial=0.0)
    return scipy.sparse.diags_array(own) if scipy.sparse.issparse(stiffness) else np.diag(own)


def _lowest(mass, stiffness, solve, source, rounding):
    """`Lowest` by subspace iteration with the shifted stiffness; natural frequencies come out from above."""
    count = min(_MOTIONS, int(np.count_nonzero(mass.diagonal() > 0.0)))
    motions = np.random.default_rng(1).normal(size=(mass.shape[0], count))
    for _ in range(_ITERATIONS):
        motions = np.linalg.qr(np.column_stack([solve(column) for column in (mass @ motions).T]))[0]
    moved = stiffness @ motions
    stiff, massive = motions.T @ moved, motions.T @ (mass @ motions)
    # against the sum of both, which is positive whatever has no mass: the same motions, in the same order
    scale = max(np.trace(stiff) / max(np.trace(massive), 1e-300), 1e-300)
    try:
        turn = scipy.linalg.eigh(0.5 * (stiff + stiff.T), 0.5 * (stiff + stiff.T) + scale * massive)[1]
    except (np.linalg.LinAlgError, ValueError):  # also what is not finite
        raise DataError(source, "its mass or stiffness is indefinite, or too near to it to be solved") from None
    shapes = motions @ turn
    energy = np.einsum("ij,ij->j", shapes, stiffness @ shapes)
    bound = np.einsum("ij,ij->j", abs(shapes), abs(stiffness) @ abs(shapes))
    with np.errstate(divide="ignore", invalid="ignore"):  # what has no mass
        square = energy / np.einsum("ij,ij->j", shapes, mass @ shapes)
    free = energy <= rounding * bound
    frequencies = np.sqrt(square[~free].clip(min=0.0)) / (2.0 * np.pi)
    return Lowest(int(free.sum()), float(frequencies.min(initial=np.inf)))
