"""All whirls of two pressed contacts, by a scan over Psi.

With a_j = c_j H_jj + 1/k_j, b_12 = c_2 H_12, b_21 = c_1 H_21, theta = phi_2 - phi_1 and z = e^{i theta}, (W) reads

    a_1 N_1 + b_12 z N_2 = -s_1,   b_21 N_1 / z + a_2 N_2 = -s_2.

The imaginary parts are homogeneous in the forces. They have a solution where Im a_1 Im a_2 = Im(b_12 z) Im(b_21/z), that is

    cos(2 theta + arg(b_12 conj b_21)) = [2 Im a_1 Im a_2 + Re(b_12 b_21)]/|b_12 b_21|,

at most four theta at each Psi, each with a ratio N_2/N_1 = -Im a_1/Im(b_12 z). The real parts, r_1 and r_2 for forces in that
ratio, must be in the ratio of the gaps: g(Psi) = r_2 s_1 - r_1 s_2 = 0. Each theta is a branch over Psi, which ends where two of
them meet or where a force becomes zero.
"""

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.several.condition import Whirling
from rsc.analysis.several.starts import secant_eigenvalues
from rsc.analysis.several.zeros import beside as near
from rsc.analysis.several.zeros import zeros
from rsc.system.system import FloatOrArray

_BASE = 400  # frequencies over a range, half of them evenly and half by their logarithm
_BESIDE, _WIDTHS = 61, 7.0  # beside an eigenvalue: their number, and asinh of how many widths they reach
_NARROWEST = 1e-7  # of an eigenvalue: its least width
_STIFF = 1e4  # times k_j stands for a rigid contact, whose eigenvalues are zeros of H_jj
_LOWEST = 1e-6  # of the upper end of a range, where it begins at 0
_BEYOND = 1e-9  # by which a cosine may pass 1: rounding where two branches are one


def pair_candidates(own, bounds):
    """Candidates for Newton's method: every zero of g, minimum of |g| and end of a branch within ranges of Psi.

    Parameters
    ----------
    own : Pressed
        Of two contacts.
    bounds : list of (low, high), rad/s

    Returns
    -------
    Whirling
    """
    parts = []
    for Psi, edges in _grids(own, bounds):
        g = _branches(own, Psi, middle := _phase(own, Psi))[0]
        crossed = zeros(lambda x, known=(Psi, middle): _branches(own, x, _phase(own, x, known))[0], Psi)
        at = np.concatenate([crossed, edges, Psi[_told(g)]])
        parts += _candidates(at, *_branches(own, at, _phase(own, at, (Psi, middle)))[1:])
    return Whirling(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _grids(own, bounds):
    """Frequencies (m,) of each range, rising, dense near the eigenvalues of the free system and of bonded ones, and those (k,)
    where branches may end: of contacts that are alike a branch may be no longer than that."""
    shares = np.array([(i, k) for i in (0.0, 1.0, _STIFF) for k in (0.0, 1.0, _STIFF)])
    eigenvalues = secant_eigenvalues(own, shares * own.stiffness)[0].ravel()
    width = np.maximum(np.abs(eigenvalues.imag), _NARROWEST * np.abs(eigenvalues.real))
    beside = (eigenvalues.real[:, None] + width[:, None] * np.sinh(np.linspace(-_WIDTHS, _WIDTHS, _BESIDE))).ravel()
    for low, high in bounds:
        smallest, largest = sorted((abs(low), abs(high)))
        sense = np.sign(low + high)
        spread = sense * np.geomspace(max(smallest, _LOWEST * largest), largest, _BASE // 2)
        inside = beside[(beside > low) & (beside < high)]
        Psi = np.unique(np.concatenate([np.linspace(low, high, _BASE // 2), spread, inside]))
        Psi = Psi[np.abs(Psi) >= _LOWEST * largest]
        edges = zeros(lambda x: _edges(own, x), Psi)
        yield np.unique(np.concatenate([Psi, near(edges, Psi)])), edges


def _coefficients(own, Psi: FloatOrArray):
    """[a_1, a_2] and [b_12, b_21] at Psi (m,), (m, 2) each."""
    H, _ = own.receptances(Psi)
    b = np.stack([own.turn[1] * H[:, 0, 1], own.turn[0] * H[:, 1, 0]], axis=1)
    return own.turn * np.diagonal(H, axis1=1, axis2=2) + 1.0 / own.stiffness, b


def _edges(own, Psi: FloatOrArray):
    """What is zero where branches end, (4, m): where two theta meet, cosine 1 and -1, and where a force vanishes."""
    a, b = _coefficients(own, Psi)
    product = b.prod(axis=1)
    size, known = np.abs(product), 2.0 * a.imag.prod(axis=1) + product.real
    return np.stack([size - known, size + known, a[:, 0].imag, a[:, 1].imag])


def _phase(own, Psi: FloatOrArray, known=None):
    """arg(b_12 conj b_21), continuous over Psi (m,): by itself, or as it is known (at frequencies, of them)."""
    b = _coefficients(own, Psi)[1]
    angle = np.angle(b[:, 0] * b[:, 1].conj())
    if known is None:
        return np.unwrap(angle)
    near = np.interp(Psi, *known)
    return angle + 2.0 * np.pi * np.round((near - angle) / (2.0 * np.pi))


def _branches(own, Psi: FloatOrArray, middle):
    """g, forces and theta of the four branches over Psi (m,), given their `_phase`.

    Returns
    -------
    g : (4, m), scaled, not a number where there is no theta or the forces have different signs
    N : (4, m, 2) N, which fulfil the real parts
    theta : (4, m)
    """
    a, b = _coefficients(own, Psi)
    product = b.prod(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = (2.0 * a.imag.prod(axis=1) + product.real) / np.abs(product)
        cosine = np.where(np.abs(cosine) < 1.0 + _BEYOND, np.clip(cosine, -1.0, 1.0), np.nan)
    half = 0.5 * np.arccos(cosine)
    theta = np.stack([half, half + np.pi, -half, -half + np.pi]) - 0.5 * middle
    z = np.exp(1j * theta)
    first, second = b[:, 0] * z, b[:, 1] * z.conj()
    # of the two homogeneous equations in the forces that which says more
    one, other = _rows(a[:, 0].imag, first.imag), _rows(second.imag, a[:, 1].imag)
    sizes = np.linalg.norm(one, axis=-1, keepdims=True), np.linalg.norm(other, axis=-1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        v = np.where(sizes[0] >= sizes[1], one, other)[..., ::-1] / np.maximum(*sizes) * np.array([-1.0, 1.0])
        v = np.where(v.prod(axis=-1, keepdims=True) > 0.0, np.abs(v), np.nan)
    one, other = _rows(a[:, 0].real, first.real), _rows(second.real, a[:, 1].real)
    r = [(row * v).sum(axis=-1) for row in (one, other)]
    size = np.abs(a).max(axis=1) + np.abs(b).max(axis=1)
    g = (r[1] / own.gap[1] - r[0] / own.gap[0]) / size * own.gap.max()
    with np.errstate(divide="ignore", invalid="ignore"):
        N = _rows(one[..., 1] * own.gap[1] - other[..., 1] * own.gap[0], other[..., 0] * own.gap[0] - one[..., 0] * own.gap[1])
        N /= (one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])[..., None]
    return g, N, theta


def _rows(first, second):
    return np.stack(np.broadcast_arrays(first, second), axis=-1)


def _told(g):
    """(m,) bool, the samples where |g| of a branch is least among its neighbours, or where the branch ends."""
    sound = np.isfinite(g)
    size = np.where(sound, np.abs(g), np.inf)
    beyond = np.pad(size, ((0, 0), (1, 1)), constant_values=np.inf)
    least = (size <= beyond[:, :-2]) & (size <= beyond[:, 2:])
    ends = ~(np.isfinite(beyond[:, :-2]) & np.isfinite(beyond[:, 2:]))
    return (sound & (least | ends)).any(axis=0)


def _candidates(Psi: NDArray[np.float64], *branches):
    """The candidates of all branches, given as their N and theta, at frequencies (m,): a Whirling each."""
    for N, theta in zip(*branches, strict=True):
        good = np.isfinite(N).all(axis=1) & (N > 0.0).all(axis=1)
        yield Whirling(Psi[good], N[good], np.stack([np.zeros(good.sum()), theta[good]], axis=1))
