"""Where whirls of a pressed set can lie, and candidates for Newton's method on (W).

With the secant stiffness kappa_j = N_j/(s_j + N_j/k_j), which lies between 0 and k_j, Psi is a real eigenvalue of

    A(Psi) + sum_j c_j kappa_j l_j l_j^T,

so that a backward whirl of passive bodies lies between the lowest backward frequency of the free system and the highest of the
one with all contacts bonded by k_j, both undamped. First-order states are not passive: with them whirls of both senses are looked
for up to twice the highest of these eigenvalues that were seen for any kappa.
"""

import itertools
from dataclasses import replace

import numpy as np

from rsc.analysis.paper.receptance import natural_frequencies
from rsc.analysis.several.condition import Whirling, newton

_FREE_OF_ROUNDING = 1e-9  # by which the range is made wider
# secant stiffnesses over k of a pressed contact that candidates start from
_SHARES = (1e-4, 1e-3, 1e-2, 0.1, 0.3, 0.6, 0.85, 0.97, 0.999)
_MOST = 120  # combinations of them
_GROWING = 0.3  # |Im Psi|/|Re Psi| up to which an eigenvalue starts Newton's method
_GAP_STEPS = 16
_WITH_STATES = 2.0  # times the highest eigenvalue that is seen, where nothing bounds the frequencies of whirls


def ranges(own, driven):
    """[(low, high)] in rad/s of Psi where whirls of a pressed set and of its subsets can lie: backward, and where something
    beside friction can feed a whirl also forward."""
    if own.states:
        values = secant_eigenvalues(own, _grid(own.n) * own.stiffness)[0]
        high = _WITH_STATES * np.abs(values.real[np.abs(values.imag) < np.abs(values.real)]).max(initial=0.0)
        return [(-high, 0.0), (0.0, high)]
    bodies, parts = own.bodies, []
    bonded = bodies.stiffness + (own.rows.T * own.stiffness) @ own.rows
    turning = bodies.turning(own.Omega)
    free, held = (natural_frequencies(bodies.mass, stiffness, turning, 1.0) for stiffness in (bodies.stiffness, bonded))
    for sense in (-1.0, 1.0) if driven else (-1.0,):
        own_sense = sense * free > 0.0
        # of a free motion, whose pair of frequencies is 0, rounding may leave none of a sense
        low = np.abs(free[own_sense]).min() if own_sense.sum() == bodies.n_coordinates else 0.0
        high = (sense * held).max()
        ends = sense * low * (1.0 - _FREE_OF_ROUNDING), sense * high * (1.0 + _FREE_OF_ROUNDING)
        parts.append((min(ends), max(ends)))
    return parts


def secant_eigenvalues(own, kappa):
    """Eigenvalues Psi (m, 2 (N + M) + p) and their shapes (m, 2 (N + M) + p, N + M + p) of secant stiffnesses kappa (m, n) in
    N/m."""
    bodies, p = own.bodies, own.states
    n = bodies.n_coordinates - p
    inverse, turning = np.linalg.inv(bodies.mass[:n, :n]), bodies.by_frequency(own.Omega)
    tied = bodies.static + np.einsum("jp,mj,jq->mpq", own.rows, kappa * own.turn, own.rows)
    # Psi^2 x = M^-1 (tied + Psi D) x; states z, without mass, have 0 = tied [x, z] + Psi D x + i Psi z
    x, v, z = slice(n), slice(n, 2 * n), slice(2 * n, 2 * n + p)
    matrices = np.zeros((len(kappa), 2 * n + p, 2 * n + p), complex)
    matrices[:, x, v] = np.eye(n)
    matrices[:, v, x], matrices[:, v, z] = inverse @ tied[:, :n, :n], inverse @ tied[:, :n, n:]
    matrices[:, v, v] = inverse @ turning[:n, :n]
    matrices[:, z, x], matrices[:, z, z] = 1j * tied[:, n:, :n], 1j * tied[:, n:, n:]
    matrices[:, z, v] = 1j * turning[n:, :n]
    size = np.sqrt(np.abs(matrices[:, v, x]).max())
    matrices[:, x, v] *= size
    matrices[:, v, x] /= size
    matrices[:, v, z] /= size
    matrices[:, z, v] *= size
    values, vectors = np.linalg.eig(matrices)
    shapes = np.swapaxes(vectors, 1, 2)
    return values, np.concatenate([shapes[:, :, x], shapes[:, :, z]], axis=2) if p else shapes[:, :, x]


def secant_candidates(own, bounds):
    """Candidates from a grid of secant stiffnesses: of each the eigenvalues that neither grow nor decay fast."""
    kappa = _grid(own.n) * own.stiffness
    values, shapes = secant_eigenvalues(own, kappa)
    low, high = min(part[0] for part in bounds), max(part[1] for part in bounds)
    lasting = np.abs(values.imag) < _GROWING * np.abs(values.real)
    i, mode = np.nonzero(lasting & (values.real > low) & (values.real < high))
    d = shapes[i, mode] @ own.rows.T
    N = kappa[i] * own.gap / (1.0 - kappa[i] / own.stiffness)
    moves = np.abs(d).min(axis=1) > 0.0  # else a node of the mode lies in a contact
    return Whirling(values.real[i, mode][moves], N[moves], np.angle(d[moves] / d[moves, :1]))


def _grid(n):
    """(m, n) shares of the stiffness: all combinations, of more contacts every so manieth of them."""
    shares = _SHARES if n <= 2 else _SHARES[1::2]
    combinations = np.array(list(itertools.product(shares, repeat=n)))
    every = -(-len(combinations) // _MOST)
    return combinations[:: every | 1]  # an odd step, so that the last contact has every share


def grazing_candidates(own, j, fewer):
    """Candidates from whirls of the pressed set without its contact j: with a gap of |d_j| there they graze it, N_j = 0, and from
    that the gap is led to its own value.

    fewer : Whirling of `own.without(j)`
    """
    others = own.without(j)
    d = others.shapes(fewer) @ own.rows[j]
    phi = np.insert(fewer.phi, j, np.angle(d), axis=1)
    whirls = Whirling(fewer.Psi, np.insert(fewer.N, j, 0.0, axis=1), phi - phi[:, :1])
    start = np.abs(d)
    for share in np.linspace(0.0, 1.0, _GAP_STEPS)[1:]:
        gaps = np.tile(own.gap, (len(start), 1))
        gaps[:, j] = start * (own.gap[j] / start) ** share
        after, met = newton(replace(own, gap=gaps), whirls)
        whirls, start = after.at(met), start[met]
    return whirls
