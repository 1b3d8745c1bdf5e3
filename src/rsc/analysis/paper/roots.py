"""Real whirl frequencies at which the whirl condition (24) holds: all, by eigenvalues, then polished by Newton's method."""

import numpy as np
import scipy

from rsc.analysis.algebra.eigenvalues import eigenvalues
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import dynamic_stiffness, entrywise, mode_scale, solve_at, transposed
from rsc.analysis.paper.states import amplitudes, free_matrix, typical
from rsc.system.blas import threads_for
from rsc.system.system import FloatOrArray, System

ROOT_RESIDUAL = 1e-10  # |Im cH| / |cH| at which a root counts as met
MET = 1e3 * ROOT_RESIDUAL  # the same for what Newton's method did not settle
_SAME_ROOT = 1e-9
_FAR = 1e4  # times the highest frequency of a mode: a doubtful candidate beyond is an eigenvalue at infinity
_NEWTON_STEPS = 8
_SURE = 1e-13  # share of Psi up to which a step needs no look at where it leads: its error is the square of that
# unknowns are eliminated while that makes entries at most this much larger: it costs three digits
_ELIMINATED = 1e3
_CLOSE = 1e-3  # |Im cH| / |cH| beside a sign change that may be a root
_TOGETHER = 200_000  # entries of matrices that are solved together, so that they stay in the cache of the processor
# relative offsets at which a doubtful candidate is searched for sign changes
_OFFSETS = np.concatenate([-np.logspace(-5, -15, 31), [0.0], np.logspace(-15, -5, 31)])


def whirl_roots(system: System, Omega: float):
    """Find every finite real Psi with Im[(1 + i mu) H(Psi)] = 0 (24), whatever the sign of F_N.

    No start values: the roots are real eigenvalues. With A = A_re + i A_im and x = p + i q = A^-1 l the condition is

        A_re p - A_im q = l f,   A_im p + A_re q = 0,   mu l^T p + l^T q = 0,

    A_re = K + Psi (Omega G - Q) - Psi^2 M and A_im = S + Psi B, quadratic in Psi, real, of size 2 (N + M) + 1. Each eigenvalue is
    then polished on the condition itself.

    Parameters
    ----------
    system : System
    Omega : float, rad/s

    Returns
    -------
    ndarray of float, rad/s
        Rising, without duplicates, |Im cH| / |cH| < 1e-10 at each. A root that coincides with a real pole or zero of H
        (undamped bodies: the uncoupled and the coupled frequencies) is given as the place of the sign change.
        Psi = 0 (a standing deflection) is none. Without friction there is no root, unless a mode is undamped; without
        friction and damping every Psi fulfils the condition and none is returned.
    """
    return roots_by_place(system, Omega)[1]


def roots_by_place(system: System, Omega: FloatOrArray, only_met=False):
    """(places, roots) of a stack of systems and their speeds, by place and rising; of a single system all places are 0.

    only_met : without places where the condition changes its sign and is not met, poles and zeros of undamped bodies: at a pole H
    is rounding, and so is a whirl there, of 1e-10 N.
    """
    with threads_for(system.n_rotor + system.n_stator):
        return _roots_of(system.at_speed(Omega).joined(), law_of(system).friction, Omega, only_met)


def _roots_of(bodies, mu, Omega: FloatOrArray, only_met):
    """(places, roots) of `System.joined` bodies (one or a stack) with friction mu at the speeds Omega, by place and rising."""
    whole = bodies.with_states()
    whirling = np.asarray(mu != 0.0) | whole.damping.any(axis=(-2, -1))
    if bodies.skew_stiffness is not None:
        whirling |= bodies.skew_stiffness.any(axis=(-2, -1))
    whirling = np.flatnonzero(np.broadcast_arrays(whirling, Omega)[0])
    if not len(whirling):
        return whirling, np.zeros(0)
    bodies, mu, Omega = bodies.at(whirling), entry_at(mu, whirling), entry_at(Omega, whirling)
    candidates, scale = (_candidates_with_states if bodies.n_states else _candidates)(bodies, mu, Omega)
    bodies = whole.at(whirling)
    # of a real pencil the real eigenvalues are exactly real; a standing deflection is no whirl
    size = np.abs(candidates.real)
    is_whirl = (candidates.imag == 0.0) & (size > _SAME_ROOT * scale.min(axis=-1, keepdims=True))
    place, start = np.nonzero(np.atleast_2d(is_whirl))[0], candidates.real[is_whirl]
    roots, met = _newton(bodies.at(place), entry_at(mu, place), entry_at(Omega, place), start)
    near = (size < _FAR * scale.max(axis=-1, keepdims=True))[is_whirl]
    doubtful, places, parts = np.flatnonzero(~met & near), [place[met]], [roots[met]]
    many = max(1, _TOGETHER // (len(_OFFSETS) * bodies.mass.shape[-1] ** 2))
    for i in range(0, len(doubtful), many):
        some = doubtful[i : i + many]
        at = bodies.at(place[some]), entry_at(mu, place[some]), entry_at(Omega, place[some])
        of, local = _local_roots(*at, start[some], only_met)
        places.append(place[some][of])
        parts.append(local)
    place, roots = _merged(np.concatenate(places), np.concatenate(parts))
    return whirling[place], roots


def entry_at(value, i):
    """A number of each of a stack of systems at the places i; a single system's stands for every place."""
    return value if np.size(value) == 1 else value[i]


def _modes(bodies):
    """(omega^2, mass-normalised modes)."""
    per_root = np.linalg.inv(np.linalg.cholesky(bodies.mass))
    square, vectors = np.linalg.eigh(per_root @ bodies.stiffness @ transposed(per_root))
    return square, transposed(per_root) @ vectors


def _candidates(bodies, mu, Omega: FloatOrArray):
    """Finite eigenvalues of the whirl pencil, complex, and typical frequencies of the modes, (n,), both in rad/s; not a number
    where an eigenvalue is infinite. Of a stack of systems each has one more axis, the first.

    Unknowns in mass-normalised modes: scale * p, scale * q, Psi p, Psi q, each of one size, and f:

        (A - Psi) z + b f = 0,   c z = 0,   b c = 0.

    z is orthogonal to c and the equation is needed orthogonally to b, so with w orthogonal to both and z = w + b h

        (A_ww - Psi) w + A_wb h = 0,   A_cw w + A_cb h = 0,   A_cb proportional to mu.

    Without h a plain eigenvalue problem of size 4 (N + M) - 2 is left; where mu is so small that this is inaccurate (roots
    towards infinity) h stays, in a pencil that costs twice as much.
    """
    n = bodies.mass.shape[-1]
    square, modes = _modes(bodies)
    scale = mode_scale(square)
    unit = np.exp(np.log(scale).sum(axis=-1, keepdims=True) / n)
    rows = transposed(modes)
    contact = (rows @ bodies.contact[..., None])[..., 0]
    damping, gyroscopic = (rows @ matrix @ modes / unit[..., None] for matrix in (bodies.damping, bodies.gyroscopic))
    gyroscopic *= entrywise(Omega)
    if bodies.skew_damping is not None:
        gyroscopic -= rows @ bodies.skew_damping @ modes / unit[..., None]
    p_dot, q_dot = slice(2 * n, 3 * n), slice(3 * n, 4 * n)
    matrix, axes = np.zeros((*square.shape[:-1], 4 * n, 4 * n)), np.arange(2 * n)
    matrix[..., axes, axes + 2 * n] = np.concatenate([scale / unit] * 2, axis=-1)
    matrix[..., axes + 2 * n, axes] = np.concatenate([square / (scale * unit)] * 2, axis=-1)
    matrix[..., p_dot, p_dot] = matrix[..., q_dot, q_dot] = gyroscopic
    matrix[..., p_dot, q_dot] = -damping
    matrix[..., q_dot, p_dot] = damping
    if bodies.skew_stiffness is not None:
        skew = rows @ bodies.skew_stiffness @ modes / (scale * unit)[..., None, :]
        matrix[..., p_dot, n : 2 * n], matrix[..., q_dot, :n] = -skew, skew
    row = contact / scale
    _first_axis(matrix[..., : 2 * n], matrix[..., : 2 * n, :], np.concatenate([np.asarray(mu)[..., None] * row, row], axis=-1))
    _first_axis(matrix[..., p_dot], matrix[..., p_dot, :], contact)
    # now c is the first axis and b that of the first p_dot
    out = [0, 2 * n]
    equations = np.delete(matrix, out, axis=-2)
    inner, by_h, of_w = np.delete(equations, out, axis=-1), equations[..., 2 * n], np.delete(matrix[..., 0, :], out, axis=-1)
    return unit * _finite_eigenvalues(inner, by_h, of_w, matrix[..., 0, 2 * n]), scale


def _candidates_with_states(bodies, mu, Omega: FloatOrArray):
    """`_candidates` of bodies with first-order states, of w = [x, x', z] = p + i q, i Psi w = F w + b f with a real f:

    Psi [p, q] = [[F_im, F_re], [-F_re, F_im]] [p, q] - [0, b] f,   mu l^T p + l^T q = 0.
    """
    stacked = bodies.mass.ndim > 2
    values, sizes = [], []
    for i in range(len(bodies.mass) if stacked else 1):
        own = bodies.at(i) if stacked else bodies
        speed, friction = (float(np.ravel(entry_at(value, i))[0]) for value in (Omega, mu))
        plain, n = own.without_states(), own.n_coordinates
        F = free_matrix(own, speed)
        motions = np.linalg.eigvals(F)
        omega = typical(plain)
        scale = np.concatenate([np.ones(n), np.full(n, omega), amplitudes(own, omega)])
        F, b = F * scale / scale[:, None] + 0j, np.zeros(len(scale))
        b[n : 2 * n] = np.linalg.solve(plain.mass, plain.contact) / omega
        b /= np.linalg.norm(b)
        row = np.concatenate([plain.contact, np.zeros(len(scale) - n)])
        inner, by_f = np.block([[F.imag, F.real], [-F.real, F.imag]]), -np.concatenate([np.zeros(len(b)), b * omega])
        of_w = np.concatenate([friction * row, row])
        values.append(_finite_eigenvalues(inner[None], by_f[None], of_w[None], np.zeros(1))[0])
        sizes.append(np.abs(motions))
    return (np.array(values), np.array(sizes)) if stacked else (values[0], sizes[0])


def _finite_eigenvalues(inner, by_h, of_w, corner):
    """Psi where (inner - Psi) w + by_h h = 0, of_w w + corner h = 0 is solved; not a number where it is infinite."""
    n = inner.shape[-1]
    size = np.abs(inner).max(axis=(-2, -1))
    plain = (_length(by_h) * _length(of_w))[..., 0] < _ELIMINATED * size * np.abs(corner)
    values = np.full((*corner.shape, n + 1), np.nan, dtype=complex)
    reduced = inner[plain]
    reduced -= (by_h[plain] / corner[plain][..., None])[..., None] * of_w[plain][..., None, :]
    values[plain, :n] = eigenvalues(reduced)
    for i in np.argwhere(~plain):
        i = tuple(i)
        left = np.block([[inner[i], by_h[i][:, None]], [of_w[i], corner[i]]])
        right = np.eye(n + 1)
        right[-1, -1] = 0.0
        numerator, denominator = scipy.linalg.eigvals(left, right, homogeneous_eigvals=True)
        finite = np.abs(numerator) < 1e12 * np.abs(denominator)
        values[i][finite] = numerator[finite] / denominator[finite]
    return values


def _length(vectors):
    """Length of every vector, with an axis of one for its entries."""
    return np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))


def _first_axis(columns, rows, vector):
    """Turn the axes of a part of a matrix, given by its columns and its rows, so that `vector` is the first: in place."""
    normal = vector / _length(vector)
    normal[..., 0] += np.where(normal[..., 0] >= 0.0, 1.0, -1.0)
    normal *= np.sqrt(2.0) / _length(normal)
    columns -= (columns @ normal[..., None]) * normal[..., None, :]
    rows -= normal[..., None] * (normal[..., None, :] @ rows)


def whirl_condition(bodies, mu, Omega: FloatOrArray, Psi: FloatOrArray):
    """Im cH / |cH| and (Im cH)' / |cH| in s, both of the shape of Psi; bodies with their states as coordinates.

    The first, the sine of the phase of cH, has the zeros of Im cH but is bounded: no pole of H fakes a sign change
    in it. The second is the slope of that phase at a root.
    """
    damping = bodies.by_frequency(Omega)
    matrices = dynamic_stiffness(bodies.mass, damping, bodies.static, Psi)
    x = solve_at(matrices, bodies.contact)
    y = x if bodies.symmetric else solve_at(transposed(matrices), bodies.contact)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        damped, massive = ((y[..., None, :] @ matrix)[..., 0, :] for matrix in (damping, bodies.mass))
        slope = damped - 2.0 * np.asarray(Psi)[..., None] * massive  # y^T A'; H' = -y^T A' x
        value = (1.0 + 1j * mu) * (x * bodies.contact).sum(axis=-1)
        derivative = -(1.0 + 1j * mu) * np.sum(slope * x, axis=-1)
        return value.imag / np.abs(value), derivative.imag / np.abs(value)


def _newton(bodies, mu, Omega: FloatOrArray, start):
    """Newton's method on Im cH from good starts: the best iterates and whether each meets the condition."""
    best, residual, moved = start.copy(), np.full(start.shape, np.inf), np.full(start.shape, np.inf)
    Psi, active = start, np.arange(len(start))
    for _ in range(_NEWTON_STEPS):
        sine, slope = whirl_condition(bodies.at(active), entry_at(mu, active), entry_at(Omega, active), Psi)
        with np.errstate(invalid="ignore", divide="ignore"):
            step = sine / slope
        size, length, before = np.abs(sine), np.abs(step), residual[active]
        better, sure = size < before, length <= _SURE * np.abs(Psi)
        improved = active[better]
        best[improved] = np.where(sure, Psi - step, Psi)[better]
        residual[improved], moved[improved] = size[better], length[better]
        # on with those that still gain: at rounding they do not
        on = (size < 0.5 * before) & ~sure & np.isfinite(step)
        if not on.any():
            break
        Psi, active = (Psi - step)[on], active[on]
    # without friction the condition fades towards infinity: there the residual is small but the step is not
    return best, (residual < ROOT_RESIDUAL) & (moved <= 1e-6 * np.abs(best))


def _local_roots(bodies, mu, Omega: FloatOrArray, centres, only_met):
    """Sign changes next to candidates that Newton did not settle: at a pole or zero of H, or roots too close to one another.

    Returns
    -------
    of : (m,) int, the candidate of each
    roots : (m,) float, rad/s, to the last bit
    """
    of, Psi = np.arange(len(centres)), centres[:, None] * (1.0 + _OFFSETS)
    many = np.repeat(of, len(_OFFSETS))
    sine = whirl_condition(bodies.at(many), entry_at(mu, many), entry_at(Omega, many), Psi.ravel())[0].reshape(Psi.shape)
    brackets = []
    for i in of:
        finite = np.isfinite(sine[i])  # a sample may hit a pole to the last bit
        place, value = Psi[i][finite], sine[i][finite]
        changes = np.flatnonzero(value[:-1] * value[1:] < 0.0)
        if only_met:  # at a pole the condition is far from met on both sides
            changes = changes[np.minimum(abs(value[changes]), abs(value[changes + 1])) < _CLOSE]
        brackets += [(i, place[k], place[k + 1], value[k]) for k in changes]
    if not brackets:
        return np.zeros(0, int), np.zeros(0)
    of, low, high, sign_low = (np.array(part) for part in zip(*brackets, strict=True))
    at = bodies.at(of), entry_at(mu, of), entry_at(Omega, of)
    while True:
        middle = 0.5 * (low + high)
        open_ones = (middle != low) & (middle != high)
        if not open_ones.any():
            break
        value = whirl_condition(*at, middle)[0]
        with np.errstate(invalid="ignore"):
            above = value * sign_low > 0.0
        low = np.where(open_ones & (above | (value == 0.0)), middle, low)
        high = np.where(open_ones & ~above, middle, high)
    kept = np.abs(whirl_condition(*at, middle)[0]) < MET if only_met else np.full(len(of), True)
    return of[kept], middle[kept]


def _merged(places, roots):
    """(places, roots) by place and rising, without duplicates."""
    order = np.lexsort((roots, places))
    places, roots = places[order], roots[order]
    apart = (np.diff(places) > 0) | (np.abs(np.diff(roots)) > _SAME_ROOT * np.abs(roots[1:]))
    first = np.concatenate([np.ones(min(1, len(roots)), bool), apart])
    return places[first], roots[first]
