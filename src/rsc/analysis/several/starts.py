"""Where whirls of a pressed set can lie, and candidates for Newton's method on (W).

With the secant stiffness kappa_j = N_j/(s_j + N_j/k_j), which lies between 0 and k_j, Psi is a real eigenvalue of

    A(Psi) + sum_j c_j kappa_j l_j l_j^T,

so that a backward whirl of passive bodies lies between the lowest backward frequency of the free system and the highest of the
one with all contacts bonded by k_j, both undamped.
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


def ranges(own, driven):
    """[(low, high)] in rad/s of Psi where whirls of a pressed set and of its subsets can lie: backward, and where something
    beside friction can feed a whirl also forward."""
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
    """Eigenvalues Psi (m, 2 (N + M)) and their shapes (m, 2 (N + M), N + M) of secant stiffnesses kappa (m, n) in N/m."""
    bodies = own.bodies
    n, inverse = bodies.n_coordinates, np.linalg.inv(bodies.mass)
    tied = bodies.static + np.einsum("jp,mj,jq->mpq", own.rows, kappa * own.turn, own.rows)
    # Psi^2 x = M^-1 (tied + Psi D) x
    matrices = np.zeros((len(kappa), 2 * n, 2 * n), complex)
    matrices[:, :n, n:] = np.eye(n)
    matrices[:, n:, :n] = inverse @ tied
    matrices[:, n:, n:] = inverse @ bodies.by_frequency(own.Omega)
    size = np.sqrt(np.abs(matrices[:, n:, :n]).max())
    matrices[:, :n, n:] *= size
    matrices[:, n:, :n] /= size
    values, vectors = np.linalg.eig(matrices)
    return values, np.swapaxes(vectors, 1, 2)[:, :, :n]


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
