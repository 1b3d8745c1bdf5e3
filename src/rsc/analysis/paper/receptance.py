"""Receptances at the contact point (25), (26) and natural frequencies of a System; frequencies are rad/s.

Dynamic stiffness: A(Psi) = K + i S - Psi^2 M + i Psi (B + i Q + Omega G_1) = K + i S - Psi^2 M + Psi D, D = Omega G - Q + i B,
because G_1 = -i G with the real symmetric G = `Body.gyroscopic`. S and Q, skew stiffness and damping, are None in most
systems, which then pay nothing for them. What makes directions differ is left out: `rsc.analysis.paper.anisotropy`.
"""

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.algebra.eigenvalues import eigenvalues
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.states import feedback
from rsc.system.system import FloatOrArray, System

_FREE = 1e-12  # share of the largest omega^2 up to which a mode counts as free: the rounding of its stiffness


def entrywise(x):
    """A number, or numbers, each to be multiplied with a whole matrix."""
    return np.asarray(x)[..., None, None]


def transposed(matrices):
    """Every matrix of a stack transposed."""
    return np.swapaxes(matrices, -1, -2)


def in_both_directions(own, conjugate):
    """Real matrix of [y, z] where `own` acts on r = y + i z and `conjugate` (None: nothing) on conj(r)."""
    conjugate = np.zeros_like(own) if conjugate is None else conjugate
    plus, minus = own + conjugate, own - conjugate
    return np.block([[plus.real, -minus.imag], [plus.imag, minus.real]])


def along(shapes, contact):
    """Displacements at the contact, l^T r: of shapes (..., n) and the vector l (n,) of one system, or those of a stack."""
    return (shapes * contact).sum(axis=-1)


def receptance_rotor(system: System, Psi: FloatOrArray, Omega: FloatOrArray):
    """Contact-point receptance of the rotor, H_R(Psi) = l_R^T A_R(Psi)^-1 l_R (25).

    Parameters
    ----------
    system : System
    Psi : array_like of float or complex, rad/s
        Frequencies, any shape.
    Omega : float, rad/s, or array of the shape of Psi

    Returns
    -------
    ndarray of complex, shape of Psi, m/N
        Infinite at a pole.
    """
    return _at_contact(rotor_stiffness(system, Psi, Omega), system.rotor.contact)


def receptance_stator(system: System, Psi: FloatOrArray):
    """Contact-point receptance of the stator, H_S(Psi) (26), in m/N; 0 for a rigid stator. Shapes as in (25)."""
    return _at_contact(stator_stiffness(system, Psi), system.stator.contact)


def receptance(system: System, Psi: FloatOrArray, Omega: FloatOrArray):
    """Receptance of the contact, H(Psi) = H_R(Psi) + H_S(Psi), in m/N; arguments as `receptance_rotor`."""
    return receptance_rotor(system, Psi, Omega) + receptance_stator(system, Psi)


def pushed(system: System, w, Omega: FloatOrArray, force):
    """Displacements of all coordinates by contact forces at frequencies w: (-A_R^-1 l_R F, A_S^-1 l_S F).

    Parameters
    ----------
    system : System
    w : array_like of float, rad/s
    Omega : float, rad/s, or array of the shape of w
    force : array_like of complex, shape of w, N

    Returns
    -------
    rotor, stator : ndarray of complex, shape of w followed by (N,) and (M,), m (tilts: rad)
        Infinite at a pole.
    """
    force = np.asarray(force)[..., None]
    rotor = -solve_at(rotor_stiffness(system, w, Omega), system.rotor.contact) * force
    return rotor, solve_at(stator_stiffness(system, w), system.stator.contact) * force


def rotor_stiffness(system: System, Psi: FloatOrArray, Omega: FloatOrArray):
    """Dynamic stiffness A_R(Psi) in N/m; shape of Psi followed by (N, N). Of a stack of systems Psi has one number each."""
    return _stiffness(system.rotor, Psi, Omega)


def stator_stiffness(system: System, Psi: FloatOrArray):
    """Dynamic stiffness A_S(Psi) in N/m; shape of Psi followed by (M, M)."""
    return _stiffness(system.stator, Psi, 0.0)


def _stiffness(body, Psi: FloatOrArray, Omega: FloatOrArray):
    body = body.at_speed(Omega)
    own = body.without_states()
    matrices = dynamic_stiffness(own.mass, own.by_frequency(Omega), own.static, Psi)
    return matrices - feedback(body, Psi) if body.n_states else matrices


def dynamic_stiffness(mass, damping, stiffness, Psi: FloatOrArray):
    """K + i S - Psi^2 M + Psi D, for every Psi: stiffness K + i S and damping D, complex. Made in place: of large matrices this
    takes as long as solving them."""
    Psi = entrywise(Psi)
    matrices = Psi * damping
    matrices += stiffness
    matrices -= (Psi * Psi) * mass
    return matrices


def _at_contact(matrices, contact):
    x = solve_at(matrices, contact)
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(x).all(axis=-1), along(x, contact), np.inf)


def solve_at(matrices, vector):
    """Solve each of a stack of (n, n) matrices for one vector (n,), or one each; infinite where a matrix is exactly singular."""
    try:
        return np.linalg.solve(matrices, vector[..., None])[..., 0]
    except np.linalg.LinAlgError:
        flat = matrices.reshape(-1, *matrices.shape[-2:])
        vectors = np.broadcast_to(vector, matrices.shape[:-1]).reshape(flat.shape[:-1])
        return _solve_or_inf(flat, vectors + 0j).reshape(matrices.shape[:-1])


def _solve_or_inf(matrices, vectors):
    """Solutions (k, n) of (k, n, n) and (k, n); the singular ones, infinite, are found by halving, for there are few."""
    try:
        return np.linalg.solve(matrices, vectors[..., None])[..., 0]
    except np.linalg.LinAlgError:
        half = len(matrices) // 2
        if not half:
            return np.full(vectors.shape, np.inf + 0j)
        return np.concatenate([_solve_or_inf(matrices[part], vectors[part]) for part in (slice(half), slice(half, None))])


def contact_receptance(system: System, Omega: FloatOrArray, Psi: NDArray[np.float64]):
    """cH and its first two derivatives with respect to Psi; Psi (n,) and Omega (one, or each) in rad/s give three (n,) arrays.
    The system may be a stack of n.

    With x = A^-1 l, y = A^-T l and A' = dA/dPsi: H' = -y^T A' x, H'' = 2 y^T A' A^-1 A' x - y^T A'' x, A'' = -2 M. But for
    first-order states A is symmetric, and y = x.
    """
    bodies = system.at_speed(Omega).joined().with_states()
    c = law_of(system).turn
    with np.errstate(invalid="ignore", over="ignore"):
        matrices, x, moved = _solved_with_slope(bodies, Omega, Psi)
        y, moved_left = (x, moved) if bodies.symmetric else _solved_with_slope(bodies, Omega, Psi, left=True)[1:]
        try:
            spread = np.linalg.solve(matrices, moved[..., None])[..., 0]
        except np.linalg.LinAlgError:
            spread = np.full_like(moved, np.nan)
        first = -(y * moved).sum(-1)
        massive = (x[:, None, :] @ bodies.mass)[:, 0, :]
        second = 2.0 * (moved_left * spread).sum(-1) + 2.0 * (y * massive).sum(-1)
        return c * along(x, bodies.contact), c * first, c * second


def receptance_with_slope(bodies, Omega: FloatOrArray, Psi: NDArray[np.float64]):
    """H and dH/dPsi of rotor and stator as one Body (`System.joined`), without the friction factor, as `contact_receptance`."""
    whole = bodies.with_states()
    with np.errstate(invalid="ignore", over="ignore"):
        _, x, moved = _solved_with_slope(whole, Omega, Psi)
        y = x if whole is bodies else _solved_with_slope(whole, Omega, Psi, left=True)[1]
        return x @ whole.contact, -(y * moved).sum(-1)


def _solved_with_slope(bodies, Omega: FloatOrArray, Psi: NDArray[np.float64], left=False):
    """A (n, N, N), x = A^-1 l and A' x (n, N); with `left` those of the transposed A."""
    damping = bodies.by_frequency(Omega)
    matrices = dynamic_stiffness(bodies.mass, damping, bodies.static, Psi)
    matrices, damping = (transposed(matrices), transposed(damping)) if left else (matrices, damping)
    x = solve_at(matrices, bodies.contact)
    return matrices, x, np.einsum("nij,nj->ni", damping - 2.0 * Psi[:, None, None] * bodies.mass, x)


def phase_slopes(system: System, Omega: FloatOrArray, Psi: NDArray[np.float64]):
    """First and second derivative of the phase of cH with respect to Psi, (n,) in s and s^2."""
    value, first, second = contact_receptance(system, Omega, Psi)
    with np.errstate(divide="ignore", invalid="ignore"):
        return (first / value).imag, (second / value - (first / value) ** 2).imag


def uncoupled_frequencies(system: System, Omega: FloatOrArray):
    """Signed undamped natural frequencies of the rotor alone, at one or several Omega.

    Returns
    -------
    ndarray of float, shape of Omega followed by (2 N,), rad/s
        Rising; negative ones are backward.
    """
    if len(system.knot_speed):
        return _at_each(uncoupled_frequencies, system, Omega)
    return natural_frequencies(system.rotor.mass, system.rotor.stiffness, system.rotor.gyroscopic, Omega)


def coupled_frequencies(system: System, Omega: FloatOrArray):
    """Signed undamped natural frequencies with rotor and stator joined at their n contacts, at one or several Omega.

    At one contact they are the zeros of H_R + H_S.

    Returns
    -------
    ndarray of float, shape of Omega followed by (2 (N + M - n),), rad/s
        Rising; negative ones are backward.
    """
    if len(system.knot_speed):
        return _at_each(coupled_frequencies, system, Omega)
    bodies = system.joined()
    rows = np.array([np.concatenate([contact.rotor, -contact.stator]) for contact in system.contacts])
    free = scipy.linalg.null_space(rows)  # every motion with l_R r_R = l_S r_S
    mass, stiffness, gyroscopic = (free.T @ matrix @ free for matrix in (bodies.mass, bodies.stiffness, bodies.gyroscopic))
    return natural_frequencies(mass, stiffness, gyroscopic, Omega)


def _at_each(frequencies, system: System, Omega: FloatOrArray):
    """Frequencies of a system whose stiffness follows the speed, at each of one or several Omega."""
    rows = [frequencies(system.at_speed(speed), speed) for speed in np.ravel(Omega)]
    return np.reshape(rows, (*np.shape(Omega), -1))


def natural_frequencies(mass, stiffness, gyroscopic, Omega: FloatOrArray):
    """Signed natural frequencies in rad/s of undamped bodies by their matrices (n, n), rising, at one or several Omega."""
    n = len(mass)
    if n == 0:
        return np.zeros((*np.shape(Omega), 0))
    square, modes = scipy.linalg.eigh(stiffness, mass)
    scale = mode_scale(square)
    pencil = np.zeros((*np.shape(Omega), 2 * n, 2 * n))
    pencil[..., :n, n:] = np.diag(scale)
    pencil[..., n:, :n] = np.diag(square / scale)
    pencil[..., n:, n:] = entrywise(Omega) * (modes.T @ gyroscopic @ modes)
    return np.sort(eigenvalues(pencil).real)


def free_motions(system: System):
    """Number of motions of the rotor that its stiffness does not oppose; where directions differ each direction counts."""
    if system.rotor.n_states:  # whether a controller holds it shows in its free vibrations
        return 0
    stiffness, mass = system.rotor.stiffness, system.rotor.mass
    if system.rotor.anisotropic_stiffness is not None:
        stiffness, mass = in_both_directions(stiffness, system.rotor.anisotropic_stiffness), in_both_directions(mass, None)
    square = scipy.linalg.eigvalsh(stiffness, mass)
    return int(np.sum(square <= _FREE * square.max(initial=0.0)))


def mode_scale(square):
    """Frequencies sqrt|omega^2| with a free mode's zero replaced by a typical one (they only scale unknowns)."""
    scale = np.sqrt(np.abs(square))
    largest = scale.max(axis=-1, keepdims=True)
    largest = np.where(largest > 0.0, largest, 1.0)
    return np.where(scale > 1e-6 * largest, scale, largest)
