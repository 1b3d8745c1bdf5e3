"""Supports whose directions differ: the lines that they add to a circular motion (docs/maintainers/analysis.md).

Anisotropic stiffness E and damping C act on the conjugate of the displacement, so that a line at w pulls one at -w along:

    A(w) z + (E + i w C) conj(z') = f,   z at w, z' at -w.

Both together are a system twice as large, solved exactly where nothing is nonlinear (`unbalance_ellipse`, and for free vibrations
`rsc.analysis.alone.free_vibration`). A whirl in contact is that of the isotropic mean with a mirror line at -Psi, to first order
in that line (`mirror_line`); exactly it is found by `rsc.analysis.balance.elliptic_whirl`.
"""

from dataclasses import dataclass

import numpy as np

from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import along, dynamic_stiffness, entrywise, rotor_stiffness, solve_at
from rsc.analysis.paper.synchronous import coupled_lines, envelope_of, unbalance_response
from rsc.analysis.paper.whirls import whirl_shapes
from rsc.system.system import FloatOrArray, System


@dataclass(frozen=True, eq=False)
class MirrorLine:
    """What supports whose directions differ add to a circular whirl; arrays (n,).

    The whirl is r = a e^{i Psi t} + a_- e^{-i Psi t} + a_3 e^{3 i Psi t} at the contact coordinate of the rotor: the anisotropic
    terms drive the line at -Psi, whose own mirror line about Psi lies at 3 Psi.

    share : float, |a_-|/|a|
    line, third : float m, |a_-| and |a_3|
    force, third_force : complex N, contact force of both lines
    low, high : float m, smallest and largest |r|
    """

    share: np.ndarray
    line: np.ndarray
    third: np.ndarray
    force: np.ndarray
    third_force: np.ndarray
    low: np.ndarray
    high: np.ndarray


def mirror_line(system: System, Psi: FloatOrArray, F_N: FloatOrArray, Omega: FloatOrArray):
    """Mirror line of a circular whirl at -Psi, to first order in that line.

    The contact force c F_N e^{i Psi t} of the whirl alone moves the contact at -Psi by E_- = -H_c(-Psi) conj(c) F_N, exactly. The
    contact joins the lines at -Psi and 3 Psi as it joins those at Omega and 2 Psi - Omega of an unbalance
    (`rsc.analysis.paper.synchronous.synchronous_response`).

    Parameters
    ----------
    system : System
        Or a stack with one system for each root.
    Psi, F_N : (n,) float, rad/s and N
        Whirl roots and their normal forces.
    Omega : float, rad/s, or one each

    Returns
    -------
    MirrorLine
    """
    whirl = along(whirl_shapes(system, Psi, F_N, Omega)[0], system.rotor.contact)
    return _mirrored(system, (Psi, F_N), Omega, whirl, 0.0)


def rub_mirror_share(system: System, rub, Omega: float):
    """Mirror line of a forward rub at -Omega over the rub, by `mirror_line`'s equations, driven by the unbalance as well; 0 where
    directions are alike.

    Parameters
    ----------
    system : System
    rub : rsc.analysis.paper.synchronous.ForwardRub
    Omega : float, rad/s

    Returns
    -------
    float
    """
    if system.isotropic:
        return 0.0
    # a shift of time that puts the contact at angle 0 turns what runs backward by the contact angle
    free = unbalance_ellipse(system, Omega)[1] @ system.rotor.contact * np.exp(1j * rub.contact_angle)
    motion = np.array([Omega]), np.array([rub.normal_force])
    return float(_mirrored(system, motion, Omega, np.array([rub.amplitude]), free).share[0])


def _mirrored(system: System, motion, Omega: FloatOrArray, whirl, free):
    """`MirrorLine` of a motion (Psi, F_N), given its amplitude and the motion of the rotor at -Psi without contact force."""
    (Psi, F_N), contact, n = motion, system.relative, system.n_rotor
    at_mirror, at_third = (contact_motion(system, w, Omega) for w in (-Psi, 3.0 * Psi))
    F_back = law_of(system).turn.conjugate() * F_N
    with np.errstate(invalid="ignore"):  # at a pole nothing of this is a number
        (H, H_c), (H_third, _) = (along(moved[:2], contact) for moved in (at_mirror, at_third))
        F_mirror, F_third = coupled_lines(system, motion, (-Psi, H, H_third), free - H_c * F_back)
        (H_r, H_rc), (H_r_third, _) = (along(moved[:2, ..., :n], system.rotor.contact) for moved in (at_mirror, at_third))
        line, third = free - H_r * F_mirror - H_rc * F_back, -H_r_third * F_third
        low, high = envelope_of(whirl, line, third)
    return MirrorLine(np.abs(line / whirl), np.abs(line), np.abs(third), F_mirror, F_third, low, high)


def contact_motion(system: System, w, Omega: FloatOrArray):
    """Motions of all coordinates, rotor and stator, by contact forces F at w and F' at -w, which anisotropic terms join:

        z = -(X_0 F + X_1 conj(F')) at w,   z' = -(X_2 F' + X_3 conj(F)) at -w.

    Parameters
    ----------
    system : System
        Or a stack with one system for each frequency.
    w : (n_w,) float, rad/s
    Omega : float, rad/s, or one each

    Returns
    -------
    X : (4, n_w, N + M) complex, m/N; infinite at a pole
    """
    contact = system.relative
    n = contact.shape[-1]
    pushes = np.zeros((*contact.shape[:-1], 2 * n, 2))
    pushes[..., :n, 0] = pushes[..., n:, 1] = contact
    matrices = doubled_stiffness(system, w, Omega)
    try:
        solved = np.linalg.solve(matrices, pushes)
    except np.linalg.LinAlgError:  # a pole of an undamped body
        solved = np.stack([solve_at(matrices, pushes[..., i]) for i in (0, 1)], axis=-1)
    own, beside = solved[..., :n, :], solved[..., n:, :].conj()
    return np.stack([own[..., 0], own[..., 1], beside[..., 1], beside[..., 0]])


def doubled_stiffness(system: System, w, Omega: FloatOrArray):
    """Dynamic stiffness at w of [z, conj(z')], z the lines at w and z' those at -w, of n = N + M coordinates: (n_w, 2 n, 2 n)."""
    system = system.at_speed(Omega)
    bodies, w = system.joined(), np.asarray(w, dtype=float)
    n = bodies.mass.shape[-1]
    direct, beside = (dynamic_stiffness(bodies.mass, bodies.by_frequency(Omega), bodies.static, one) for one in (w, -w))
    stiffness, damping = (anisotropic_part(system, kind) for kind in ("stiffness", "damping"))
    turning = 1j * entrywise(w)
    matrices = np.empty((*w.shape, 2 * n, 2 * n), complex)
    matrices[..., :n, :n], matrices[..., n:, n:] = direct, beside.conj()
    matrices[..., :n, n:], matrices[..., n:, :n] = stiffness + turning * damping, stiffness.conj() + turning * damping.conj()
    return matrices


def anisotropic_part(system: System, kind):
    """E or C of rotor and stator as one, (n, n) complex; of a stack with one more axis."""
    n = system.n_rotor
    both = np.zeros((*system.rotor.mass.shape[:-2], n + system.n_stator, n + system.n_stator), complex)
    for body, part in zip(system.bodies, (np.s_[..., :n, :n], np.s_[..., n:, n:]), strict=True):
        matrix = getattr(body, f"anisotropic_{kind}")
        if matrix is not None:
            both[part] = matrix
    return both


def unbalance_ellipse(system: System, Omega: FloatOrArray):
    """Deflection of the rotor by its unbalance without contact, exactly: forward and backward circle of each coordinate.

    Parameters
    ----------
    system : System
    Omega : float, rad/s

    Returns
    -------
    forward, backward : ndarray of complex, (N,), m (tilts: rad)
        Lines at Omega and -Omega: r = forward e^{i Omega t} + backward e^{-i Omega t}.
    """
    n, size = system.n_rotor, system.n_rotor + system.n_stator
    if Omega == 0.0:  # no force, also where nothing holds the rotor (free motions: a pole at 0)
        return np.zeros(n, complex), np.zeros(n, complex)
    if system.n_states and system.isotropic:
        force = system.rotor.unbalance * Omega**2
        return solve_at(rotor_stiffness(system, Omega, Omega), force), np.zeros(n, complex)
    force = np.zeros(2 * size, complex)
    force[:n] = system.rotor.unbalance * Omega**2
    answer = solve_at(doubled_stiffness(system, Omega, Omega), force)
    return answer[:n], answer[size : size + n].conj()


def largest_without_contact(system: System, Omega: FloatOrArray):
    """Largest |r_R| at the contact coordinate and largest |d| of the motion without contact, m, a circle or an ellipse."""
    rotor, E = unbalance_response(system, Omega)
    if system.isotropic:
        return float(abs(rotor @ system.rotor.contact)), float(abs(E))
    forward, backward = (line @ system.rotor.contact for line in unbalance_ellipse(system, Omega))
    return float(abs(forward) + abs(backward)), float(abs(forward + system.contact.ring) + abs(backward))
