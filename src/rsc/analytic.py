"""Backward whirl in closed form: whirl roots, forces, deflection shapes, side conditions (14)-(28).

A steady whirl turns at Psi with the contact angle held at 0 in its own frame, so that d = l_R r_R - l_S r_S is
real and positive. The constant load of a scene is not part of this theory. Omega and Psi are rad/s throughout.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from rsc.receptance import (
    coupled_frequencies,
    dynamic_stiffness,
    joined,
    mode_scale,
    receptance,
    receptance_rotor,
    receptance_stator,
    rotor_stiffness,
    solve_at,
    stator_frequencies,
    stator_stiffness,
    uncoupled_frequencies,
)

__all__ = [
    "Condition",
    "contact_distance",
    "coupled_frequencies",
    "normal_force",
    "receptance",
    "receptance_rotor",
    "receptance_stator",
    "side_conditions",
    "stator_frequencies",
    "uncoupled_frequencies",
    "whirl_roots",
    "whirl_shapes",
]

ROOT_RESIDUAL = 1e-10  # |Im cH| / |cH| at which a root counts as met
DOMINANCE = 3.0  # |F_Psi| / |F_Omega| from which the asynchronous force dominates
_SAME_ROOT = 1e-9
_FAR = 1e4  # times the highest frequency of a mode: a doubtful candidate beyond is an eigenvalue at infinity
_NEWTON_STEPS = 8
# unknowns are eliminated while that makes entries at most this much larger: it costs three digits
_ELIMINATED = 1e3
# relative offsets at which a doubtful candidate is searched for sign changes
_OFFSETS = np.concatenate([-np.logspace(-5, -15, 31), [0.0], np.logspace(-15, -5, 31)])


@dataclass(frozen=True, eq=False)
class Condition:
    """One side condition at each root: its margin (larger is safer, see `side_conditions`) and whether it holds."""

    margin: np.ndarray
    holds: np.ndarray


def whirl_roots(system, Omega):
    """Find every finite real Psi with Im[(1 + i mu) H(Psi)] = 0 (24), whatever the sign of F_N.

    No start values: the roots are real eigenvalues. With A = A_re + i A_im and x = p + i q = A^-1 l the condition is

        A_re p - A_im q = l f,   A_im p + A_re q = 0,   mu l^T p + l^T q = 0,

    quadratic in Psi, real, of size 2 (N + M) + 1. Each eigenvalue is then polished on the condition itself.

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
    both = joined(system)
    if system.friction == 0.0 and not both.damping.any():
        return np.zeros(0)
    candidates, scale = _candidates(both, system.friction, Omega)
    # of a real pencil the real eigenvalues are exactly real
    start = candidates.real[candidates.imag == 0.0]
    start = start[np.abs(start) > _SAME_ROOT * scale.min()]  # a standing deflection is no whirl
    roots, met = _newton(both, system.friction, Omega, start)
    found = [roots[met]]
    for doubtful in start[~met & (np.abs(start) < _FAR * scale.max())]:
        found.append(_local_roots(both, system.friction, Omega, doubtful))
    return _merged(np.concatenate(found))


def _candidates(both, mu, Omega):
    """Finite eigenvalues of the whirl pencil, complex, and typical frequencies of the modes, (n,), both in rad/s.

    Unknowns in mass-normalised modes: scale * p, scale * q, Psi p, Psi q, each of one size, and f:

        (A - Psi) z + b f = 0,   c z = 0,   b c = 0.

    z is orthogonal to c and the equation is needed orthogonally to b, so with w orthogonal to both and z = w + b h

        (A_ww - Psi) w + A_wb h = 0,   A_cw w + A_cb h = 0,   A_cb proportional to mu.

    Without h a plain eigenvalue problem of size 4 (N + M) - 2 is left; where mu is so small that this is inaccurate (roots
    towards infinity) h stays, in a pencil that costs twice as much.
    """
    n = len(both.mass)
    square, modes = scipy.linalg.eigh(both.stiffness, both.mass)
    scale = mode_scale(square)
    unit = np.exp(np.mean(np.log(scale)))
    contact = modes.T @ both.contact
    damping, gyroscopic = (modes.T @ matrix @ modes / unit for matrix in (both.damping, Omega * both.gyroscopic))
    p, q, p_dot, q_dot = (slice(i * n, (i + 1) * n) for i in range(4))
    matrix = np.zeros((4 * n, 4 * n))
    matrix[p, p_dot] = matrix[q, q_dot] = np.diag(scale / unit)
    matrix[p_dot, p] = matrix[q_dot, q] = np.diag(square / (scale * unit))
    matrix[p_dot, p_dot] = matrix[q_dot, q_dot] = gyroscopic
    matrix[p_dot, q_dot] = -damping
    matrix[q_dot, p_dot] = damping
    _first_axis(matrix[:, : 2 * n], matrix[: 2 * n], np.concatenate([mu * contact / scale, contact / scale]))
    _first_axis(matrix[:, p_dot], matrix[p_dot], contact)
    # now c is the first axis and b that of the first p_dot
    keep = np.delete(np.arange(4 * n), [0, 2 * n])
    inner, by_h, of_w, corner = matrix[np.ix_(keep, keep)], matrix[keep, 2 * n], matrix[0, keep], matrix[0, 2 * n]
    size = np.abs(inner).max()
    if np.linalg.norm(by_h) * np.linalg.norm(of_w) < _ELIMINATED * size * abs(corner):
        return unit * np.linalg.eigvals(inner - np.outer(by_h / corner, of_w)), scale
    left = np.block([[inner, by_h[:, None]], [of_w, corner]])
    right = np.eye(len(left))
    right[-1, -1] = 0.0
    numerator, denominator = scipy.linalg.eigvals(left, right, homogeneous_eigvals=True)
    finite = np.abs(numerator) < 1e12 * np.abs(denominator)
    return unit * numerator[finite] / denominator[finite], scale


def _first_axis(columns, rows, vector):
    """Turn the axes of a part of a matrix, given by its columns and its rows, so that `vector` is the first: in place."""
    normal = vector / np.linalg.norm(vector)
    normal[0] += 1.0 if normal[0] >= 0.0 else -1.0
    normal *= np.sqrt(2.0) / np.linalg.norm(normal)
    columns -= np.outer(columns @ normal, normal)
    rows -= np.outer(normal, normal @ rows)


def _condition(both, mu, Omega, Psi):
    """Im cH / |cH| and (Im cH)' / |cH| in s, both of the shape of Psi.

    The first, the sine of the phase of cH, has the zeros of Im cH but is bounded: no pole of H fakes a sign change
    in it. The second is the slope of that phase at a root.
    """
    damping = Omega * both.gyroscopic + 1j * both.damping
    x = solve_at(dynamic_stiffness(both.mass, damping, both.stiffness, Psi), both.contact)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        slope = x @ damping - 2.0 * Psi[..., None] * (x @ both.mass)  # of A at x; A is symmetric, so H' = -x^T A' x
        value = (1.0 + 1j * mu) * (x @ both.contact)
        derivative = -(1.0 + 1j * mu) * np.sum(slope * x, axis=-1)
        return value.imag / np.abs(value), derivative.imag / np.abs(value)


def _newton(both, mu, Omega, start):
    """Newton's method on Im cH from good starts: the best iterates and whether each meets the condition."""
    best, residual, moved = start.copy(), np.full(start.shape, np.inf), np.full(start.shape, np.inf)
    Psi, active = start, np.arange(len(start))
    for _ in range(_NEWTON_STEPS):
        sine, slope = _condition(both, mu, Omega, Psi)
        with np.errstate(invalid="ignore", divide="ignore"):
            step = sine / slope
        size, before = np.abs(sine), residual[active]
        better = size < before
        found = active[better]
        best[found], residual[found], moved[found] = Psi[better], size[better], np.abs(step[better])
        # on with those that still gain: at rounding they do not
        on = (size < 0.5 * before) & (size > 0.0) & np.isfinite(step)
        if not on.any():
            break
        Psi, active = (Psi - step)[on], active[on]
    # without friction the condition fades towards infinity: there the residual is small but the step is not
    return best, (residual < ROOT_RESIDUAL) & (moved <= 1e-6 * np.abs(best))


def _local_roots(both, mu, Omega, centre):
    """Roots next to a candidate that Newton did not settle: those at a pole or zero of H, or too close to one."""
    Psi = centre * (1.0 + _OFFSETS)
    sine = _condition(both, mu, Omega, Psi)[0]
    Psi, sine = Psi[np.isfinite(sine)], sine[np.isfinite(sine)]  # a sample may hit a pole to the last bit
    changes = np.flatnonzero(sine[:-1] * sine[1:] < 0.0)
    return np.array([_bisect(both, mu, Omega, Psi[i], Psi[i + 1]) for i in changes])


def _bisect(both, mu, Omega, low, high):
    """The sign change of the condition between low and high, to the last bit."""
    sign_low = _condition(both, mu, Omega, np.array([low]))[0][0]
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            return middle
        value = _condition(both, mu, Omega, np.array([middle]))[0][0]
        if value == 0.0:
            return middle
        if value * sign_low > 0.0:
            low = middle
        else:
            high = middle


def _merged(roots):
    roots = np.sort(roots)
    apart = np.abs(np.diff(roots)) > _SAME_ROOT * np.abs(roots[1:])
    return roots[np.concatenate([np.ones(min(1, len(roots)), bool), apart])]


def normal_force(system, Psi, Omega, rigid=False):
    """Normal force of a whirl, F_N = -s / (Re[(1 + i mu) H(Psi)] + 1/k_C) (27).

    Parameters
    ----------
    system : System
    Psi : array_like of float, rad/s
        Roots of the whirl condition.
    Omega : float, rad/s
    rigid : bool
        True for the paper's rigid contact, k_C = infinity.

    Returns
    -------
    ndarray of float, shape of Psi, N
        Not positive: no steady whirl at this root.
    """
    real = ((1.0 + 1j * system.friction) * receptance(system, Psi, Omega)).real
    with np.errstate(divide="ignore"):
        return -system.gap / (real if rigid else real + 1.0 / system.contact_stiffness)


def steady_whirls(system, Omega):
    """Psi (rad/s) and F_N (N) of every whirl at a rotor speed in rad/s: the roots with positive normal force, rising."""
    Psi = whirl_roots(system, Omega)
    F_N = normal_force(system, Psi, Omega)
    return Psi[F_N > 0.0], F_N[F_N > 0.0]


def contact_distance(system, F_N):
    """|d| = s + F_N / k_C in m of a whirl with the normal force F_N in N."""
    return system.gap + np.asarray(F_N) / system.contact_stiffness


def whirl_shapes(system, Psi, F_N, Omega):
    """Deflections of a whirl in the frame turning with Psi, contact angle 0 (19), (20).

    r_R = -A_R^-1 l_R (1 + i mu) F_N,  r_S = A_S^-1 l_S (1 + i mu) F_N,  l_R^T r_R - l_S^T r_S = s + F_N / k_C.

    Parameters
    ----------
    system : System
    Psi, F_N : array_like of float, one shape, rad/s and N
        A root and its normal force.
    Omega : float, rad/s

    Returns
    -------
    rotor, stator : ndarray of complex, shape of Psi followed by (N,) and (M,), m (tilts: rad)
    """
    force = (1.0 + 1j * system.friction) * np.asarray(F_N)[..., None]
    rotor = -solve_at(rotor_stiffness(system, Psi, Omega), system.contact_r) * force
    return rotor, solve_at(stator_stiffness(system, Psi), system.contact_s) * force


def side_conditions(system, Psi, F_N, Omega, F_Omega):
    """Judge whirl roots by the paper's side conditions.

    Parameters
    ----------
    system : System
    Psi, F_N : array_like of float, one shape, rad/s and N
        Roots and their normal forces.
    Omega : float, rad/s
    F_Omega : array_like of complex, shape of Psi, N
        Synchronous contact force (`rsc.synchronous.synchronous_response`).

    Returns
    -------
    dict of str to Condition, with the margins

        psi_real                      |Psi d arg(cH)/dPsi|: 0 at the fold where the root stops being real
        normal_force_positive         F_N in N, holds above 0
        asynchronous_force_dominates  |F_Psi| / |F_Omega|, holds above 3
        rotor_amplitude_exceeds_gap   |r_R| / s - 1 at the contact coordinate, holds above 0
        sliding                       (Omega d_R/2 + Psi |d| - slip velocity) / |Omega d_R/2|, holds above 0;
                                      infinite without a contact diameter
        contact_stiff_enough          k_C s / F_N(rigid) - 1, holds above 0
    """
    Psi, F_N = np.asarray(Psi, dtype=float), np.asarray(F_N, dtype=float)
    sine, slope = _condition(joined(system), system.friction, Omega, Psi)
    rotor, _ = whirl_shapes(system, Psi, F_N, Omega)
    F_rigid = normal_force(system, Psi, Omega, rigid=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        stiff = np.where(F_rigid > 0.0, system.contact_stiffness * system.gap / F_rigid - 1.0, -np.inf)
        dominance = np.hypot(1.0, system.friction) * np.abs(F_N) / np.abs(F_Omega)
    amplitude = np.abs(rotor @ system.contact_r) / system.gap - 1.0
    sliding = _sliding_margin(system, Psi, contact_distance(system, F_N), Omega)
    return {
        "psi_real": Condition(np.abs(Psi * slope), np.abs(sine) < 1e3 * ROOT_RESIDUAL),
        "normal_force_positive": Condition(F_N, F_N > 0.0),
        "asynchronous_force_dominates": Condition(dominance, dominance > DOMINANCE),
        "rotor_amplitude_exceeds_gap": Condition(amplitude, amplitude > 0.0),
        "sliding": Condition(sliding, sliding > 0.0),
        "contact_stiff_enough": Condition(stiff, stiff > 0.0),
    }


def _sliding_margin(system, Psi, distance, Omega):
    if system.diameter is None:
        return np.full(np.shape(Psi), np.inf)
    surface = 0.5 * Omega * system.diameter
    slip = surface + Psi * distance - (system.slip_velocity or 0.0)
    return slip / abs(surface) if surface else np.copysign(np.inf, slip)
