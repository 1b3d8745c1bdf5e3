"""Which motions of a body have a stiffness, within the number of digits in its file.

With ten digits, or single precision, an entry is known up to a relative error u, and v^T K v of a motion v up to u |v|^T |K|
|v|. For a rigid-body motion v^T K v is merely this rounding, of either sign: 10^-9 of the stiffness of an element looks like a
support with a frequency of some Hz. So the lowest motions are computed, and one whose stiffness is below that bound counts as
free.
"""

from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse

from rsc.errors import DataError
from rsc.machine.checks.checks import inertia, largest_of_rows
from rsc.machine.model.model import DOUBLE

SINGLE = 2.0**-24  # relative rounding of an entry in single precision
_SHIFT = 64.0  # times the rounding of each diagonal stiffness: keeps the stiffness of a free body positive definite
_MOTIONS, _ITERATIONS = 8, 12  # number of lowest motions computed, and inverse iterations for them
# entries whose digits are counted; decimal digits up to which numbers count as exact, and the most that programs round to
_SAMPLE, _EXACT, _MOST_DIGITS = 2000, 4, 13
_SHORT = 12  # bits of numbers that are exact in any precision, such as small integers


class Lowest(NamedTuple):
    """The lowest motions of a body.

    free : int, number of motions without stiffness
    frequency : float, Hz, lowest natural frequency of the others; infinite if all are free
    """

    free: int
    frequency: float


def rounding_of(matrix: Any) -> float:
    """Relative rounding of the entries, judged from their digits: decimal numbers with few digits, single precision (even if
    printed with more digits), or double precision."""
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
    # short decimal numbers may be exact in single precision too, but being short cannot be a coincidence
    in_single = np.array_equal(single, sample) if digits > 7 else False
    if in_single or (8 < digits < 17 and _printed(single.tolist(), digits) == _printed(numbers, digits)):
        return SINGLE
    return DOUBLE if digits == 17 else 0.5 * 10.0 ** (1 - digits)


def _printed(numbers: list[float], digits: int) -> list[str]:
    return [f"{number:.{digits - 1}e}" for number in numbers]


def _have_digits(numbers: list[float], digits: int) -> bool:
    """Whether no number has more decimal digits than this."""
    return all(float(f"{number:.{digits - 1}e}") == number for number in numbers)


def held(mass: Any, stiffness: Any, source: str, advice: str, rounding: float = DOUBLE) -> tuple[float, Any]:
    """DataError for a stiffness that is indefinite or leaves rigid-body motions.

    Parameters
    ----------
    mass, stiffness : (n, n), dense or sparse
    source, advice : str, for messages
    rounding : float
        Relative rounding of stiffness entries (`rounding_of`).

    Returns
    -------
    frequency : float, Hz
        Lowest natural frequency.
    solve : function (n, k) -> (n, k)
        Displacements due to forces.

    Raises
    ------
    DataError
        Also if a coordinate has neither mass nor stiffness.
    """
    negative, solve = inertia(stiffness - _SHIFT * 2.0**-53 * _own(mass, stiffness, source, advice))
    if negative:
        free = max(lowest_motions(mass, stiffness, source, rounding).free, 1)
    else:
        free, frequency = _lowest(mass, stiffness, solve, source, rounding)
    if free:
        digits = "" if rounding == DOUBLE else f" at the {digits_of(rounding)} digits of its numbers"
        soft = digits and ", or it is too soft for so few digits"
        raise DataError(source, f"{advice}{soft}: {free} rigid-body or other motions have no stiffness{digits}")
    return frequency, solve


def lowest_motions(mass: Any, stiffness: Any, source: str, rounding: float = DOUBLE) -> Lowest:
    """The lowest motions of a body, which may include rigid-body motions.

    Raises
    ------
    DataError
        The stiffness is indefinite beyond rounding.
    """
    scale = _own(mass, stiffness, source, "it cannot be reduced")
    negative, solve = inertia(stiffness + _SHIFT * rounding * scale)
    if negative:
        raise DataError(source, "the stiffness is indefinite: it has negative eigenvalues")
    return _lowest(mass, stiffness, solve, source, rounding)


def digits_of(rounding: float) -> int:
    """Number of decimal digits that corresponds to a relative rounding."""
    return int(np.floor(1.0 - np.log10(2.0 * rounding) + 1e-9))


def _own(mass: Any, stiffness: Any, source: str, advice: str) -> Any:
    """Diagonal matrix of the stiffness of each coordinate, as the scale of rounding: tilts of a fine mesh are, relative to their
    inertia, 10^15 times stiffer than the shaft on its bearings. DataError for a body without mass or stiffness."""
    empty = np.flatnonzero((largest_of_rows(mass) == 0.0) & (largest_of_rows(stiffness) == 0.0))
    if empty.size:
        raise DataError(source, f"{empty.size} coordinates have neither mass nor stiffness, the first is number {empty[0] + 1}")
    heavy, own = mass.diagonal() > 0.0, np.array(stiffness.diagonal(), dtype=float)
    if not heavy.any():
        raise DataError(source, "the mass matrix is zero")
    if own.max() <= 0.0:
        raise DataError(source, f"there is no stiffness; {advice}")
    bare = own <= 0.0  # a mass without stiffness
    own[bare] = mass.diagonal()[bare] * np.max(own[heavy] / mass.diagonal()[heavy], initial=0.0)
    return scipy.sparse.diags_array(own) if scipy.sparse.issparse(stiffness) else np.diag(own)


def _lowest(mass: Any, stiffness: Any, solve: Any, source: str, rounding: float) -> Lowest:
    """`Lowest` by subspace iteration with the shifted stiffness; natural frequencies are upper bounds."""
    count = min(_MOTIONS, int(np.count_nonzero(mass.diagonal() > 0.0)))
    motions = np.random.default_rng(1).normal(size=(mass.shape[0], count))
    for _ in range(_ITERATIONS):
        motions = np.linalg.qr(np.column_stack([solve(column) for column in (mass @ motions).T]))[0]
    moved = stiffness @ motions
    stiff, massive = motions.T @ moved, motions.T @ (mass @ motions)
    # relative to the sum of both, which is positive definite even without mass: same motions, same order
    scale = max(np.trace(stiff) / max(np.trace(massive), 1e-300), 1e-300)
    try:
        turn = scipy.linalg.eigh(0.5 * (stiff + stiff.T), 0.5 * (stiff + stiff.T) + scale * massive)[1]
    except (np.linalg.LinAlgError, ValueError):  # ValueError: non-finite numbers
        raise DataError(source, "its mass or stiffness is indefinite or nearly so") from None
    shapes = motions @ turn
    energy = np.einsum("ij,ij->j", shapes, stiffness @ shapes)
    bound = np.einsum("ij,ij->j", abs(shapes), abs(stiffness) @ abs(shapes))
    with np.errstate(divide="ignore", invalid="ignore"):  # motions without mass
        square = energy / np.einsum("ij,ij->j", shapes, mass @ shapes)
    free = energy <= rounding * bound
    frequencies = np.sqrt(square[~free].clip(min=0.0)) / (2.0 * np.pi)
    return Lowest(int(free.sum()), float(frequencies.min(initial=np.inf)))
