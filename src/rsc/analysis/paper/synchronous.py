"""The unbalance in contact: synchronous part of a whirl (21), (28) and the forward rub.

All motions are first order in the unbalance around the whirl, or exact for the forward rub. Frequencies are rad/s.
"""

from dataclasses import dataclass

import numpy as np

from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import (
    along,
    pushed,
    receptance_rotor,
    receptance_stator,
    rotor_stiffness,
    solve_at,
    stator_stiffness,
)
from rsc.analysis.paper.whirls import whirl_shapes
from rsc.system.system import FloatOrArray, System

_PHASES = np.exp(2j * np.pi * np.arange(64) / 64)


@dataclass(frozen=True, eq=False)
class SynchronousPart:
    """Lines that the unbalance adds to a whirl; arrays of the shape of Psi.

    The whirl is r = a_Psi e^{i Psi t} + a_Omega e^{i Omega t} + a_m e^{i m t}, m = 2 Psi - Omega, at the contact
    coordinate of the rotor; the phase of the unbalance against the whirl is free.

    force, mirror_force : complex N, F_Omega and F_m
    line, mirror_line : float m, |a_Omega| and |a_m|
    low, high : float m, smallest and largest |r| over the beat
    """

    force: np.ndarray
    mirror_force: np.ndarray
    line: np.ndarray
    mirror_line: np.ndarray
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True, eq=False)
class ForwardRub:
    """Synchronous motion in permanent contact; complex values in the frame turning with Omega.

    force : float N, |F_C|; normal_force : float N
    distance : float m, |d| = s + F_N / k_C; contact_angle : float rad, of d against the unbalance's angle 0
    amplitude : float m, |r_R| at the contact coordinate
    rotor_shape (N,), stator_shape (M,) : complex m (tilts: rad)
    """

    force: float
    normal_force: float
    distance: float
    contact_angle: float
    amplitude: float
    rotor_shape: np.ndarray
    stator_shape: np.ndarray


def free_motion(system: System, Omega: FloatOrArray):
    """Deflection of the rotor by its unbalance without contact, A_R(Omega)^-1 unbalance Omega^2.

    Parameters
    ----------
    system : System
    Omega : array_like of float, rad/s

    Returns
    -------
    ndarray of complex, shape of Omega followed by (N,), m (tilts: rad)
    """
    Omega = np.asarray(Omega, dtype=float)
    matrices = rotor_stiffness(system, Omega, Omega)
    # at rest there is no unbalance force, also where nothing holds the rotor (free motions: a pole at 0)
    return np.where(Omega[..., None] == 0.0, 0.0, solve_at(matrices, system.rotor.unbalance)) * Omega[..., None] ** 2


def unbalance_response(system: System, Omega: FloatOrArray):
    """`free_motion`, and with it the deflection E = l_R^T rotor + eps_A of the contact ring, shape of Omega, complex m."""
    rotor = free_motion(system, Omega)
    return rotor, along(rotor, system.rotor.contact) + system.contact.ring


def synchronous_response(system: System, Psi: FloatOrArray, F_N: FloatOrArray, Omega: FloatOrArray):
    """Synchronous part of a whirl to first order in the unbalance.

    The contact force F = (1 + i mu)(k_C (|d| - s) + b* |d|') d/|d| is linearised about d_0 = s + F_N/k_C in the frame
    turning with Psi. With c = 1 + i mu, m = 2 Psi - Omega, G = conj(F_m) and

        q = d_0 / (2 F_N),   p = 1 / (2 (k_C + i (Omega - Psi) b*)),

    the two lines obey

        (H(Omega) + (q + p)/c) F_Omega - (q - p)/conj(c) G = E,
        -(q - p)/c F_Omega + (conj H(m) + (q + p)/conj(c)) G = 0.

    For a rigid contact p = 0, d_0 = s (physics.md section 3). b* is b_C/2, the mean of the one-sided damper.

    The paper's (21), (28) is inconsistent to first order: (H(Omega) + s/(c F_N)) F_Omega = E for a rigid contact, without a
    mirror line. What is called printed here takes d_0 for s, (H(Omega) + 2 q/c) F_Omega = E with 2 q = s/F_N + 1/k_C: it
    contains 1/k_C, which the paper does not print, so that both forms belong to the same whirl. It has no b*.

    Parameters
    ----------
    system : System
        Or a stack with one system for each root.
    Psi, F_N : array_like of float, one shape, rad/s and N
        Whirl roots and their normal forces.
    Omega : float, rad/s, or one each

    Returns
    -------
    consistent, printed : SynchronousPart
    """
    Psi, F_N = np.asarray(Psi, dtype=float), np.asarray(F_N, dtype=float)
    lines = _lines(system, Psi, F_N, Omega)
    whirl = along(whirl_shapes(system, Psi, F_N, Omega)[0], system.rotor.contact)
    low, high = envelope_of(whirl, *lines[2:])
    forms = zip(*lines[:2], *np.abs(lines[2:]), low, high, strict=True)
    return tuple(SynchronousPart(*form) for form in forms)


def synchronous_lines(system: System, Psi: FloatOrArray, F_N: FloatOrArray, Omega: FloatOrArray):
    """F_Omega, F_m in N and a_Omega in m of the consistent form, complex, against the mark of the shaft; arguments as
    `synchronous_response`."""
    F_Omega, F_m, line, _ = _lines(system, np.asarray(Psi, dtype=float), np.asarray(F_N, dtype=float), Omega)
    return F_Omega[0], F_m[0], line[0]


def _lines(system: System, Psi: FloatOrArray, F_N: FloatOrArray, Omega: FloatOrArray):
    """F_Omega, F_m in N, a_Omega, a_m in m, complex; of each the consistent and the printed form, (2, shape of Psi)."""
    law, m = law_of(system), 2.0 * Psi - Omega
    unbalanced, E = unbalance_response(system, Omega)
    H_r, H_r_mirror = receptance_rotor(system, Omega, Omega), receptance_rotor(system, m, Omega)
    H, H_mirror = H_r + receptance_stator(system, Omega), H_r_mirror + receptance_stator(system, m)
    forces = coupled_lines(system, (Psi, F_N), (Omega, H, H_mirror), E)
    with np.errstate(divide="ignore", invalid="ignore"):
        q = law.distance(F_N) / (2.0 * F_N)
        F_Omega = np.stack([forces[0], E / (H + 2.0 * q / law.turn)])
        F_m = np.stack([forces[1], np.zeros(np.shape(Psi))])
        line = along(unbalanced, system.rotor.contact) - H_r * F_Omega
    pole = ~np.isfinite(H)  # at rest, free motions: the rotor follows its contact ring without force
    F_Omega, F_m, line = np.where(pole, 0.0, F_Omega), np.where(pole, 0.0, F_m), np.where(pole, -system.contact.ring, line)
    return F_Omega, F_m, line, -H_r_mirror * F_m


def coupled_lines(system: System, whirl, lines, E):
    """Forces F_w and F_m of a line driven at w and of its mirror line at m = 2 Psi - w, which the contact of a whirl joins.

    Parameters
    ----------
    system : System
    whirl : (Psi, F_N), rad/s and N
    lines : (w, H(w), H(m)), rad/s and m/N
    E : complex m, motion of the contact at w without contact force

    Returns
    -------
    F_w, F_m : complex N, of the equations of `synchronous_response`
    """
    (Psi, F_N), (w, H, H_mirror) = whirl, lines
    law = law_of(system)
    c = law.turn
    with np.errstate(divide="ignore", invalid="ignore"):
        q = law.distance(F_N) / (2.0 * F_N)
        p = 0.5 / law.dynamic_stiffness(w - Psi)
        direct, mirror = H + (q + p) / c, H_mirror.conj() + (q + p) / c.conjugate()
        determinant = direct * mirror - (q - p) ** 2 / np.abs(c) ** 2
        return mirror * E / determinant, ((q - p) / c * E / determinant).conj()


def envelope_of(whirl, line, mirror_line):
    """Smallest and largest |whirl + line z + mirror_line / z| on the unit circle |z| = 1.

    The square is a trigonometric polynomial of second order: sampled, then its extremum found by Newton's method.
    """
    first = (whirl.conj() * line + whirl * mirror_line.conj())[..., None]
    second = (line * mirror_line.conj())[..., None]
    mean = np.abs(whirl) ** 2 + np.abs(line) ** 2 + np.abs(mirror_line) ** 2
    ends = []
    for sign in (-1.0, 1.0):
        sampled = sign * 2.0 * (first * _PHASES + second * _PHASES**2).real
        z = _PHASES[np.argmax(sampled, axis=-1)][..., None]
        best = sampled.max(axis=-1)
        for _ in range(3):
            slope = -2.0 * (first * z + 2.0 * second * z**2).imag
            bend = -2.0 * (first * z + 4.0 * second * z**2).real
            with np.errstate(divide="ignore", invalid="ignore"):
                step = np.where(bend != 0.0, slope / bend, 0.0)
            z = z * np.exp(-1j * np.clip(step, -0.1, 0.1))
        refined = sign * 2.0 * (first * z + second * z**2).real[..., 0]
        ends.append(np.sqrt(np.maximum(mean + sign * np.maximum(best, refined), 0.0)))
    return ends


def forward_rub(system: System, Omega: float):
    """Find the synchronous motions in permanent contact (forward rub).

    With c = (1 - i mu)/sqrt(1 + mu^2), H' = H(Omega) + c/(k_C sqrt(1 + mu^2)) and E the unbalance response of the
    contact ring, |H' F + c s| = |E|, a quadratic in F = |F_C| (physics.md section 3). Stability is not judged. On a race there is
    none: friction turns it until nothing slides any more.

    Parameters
    ----------
    system : System
    Omega : float, rad/s

    Returns
    -------
    list of ForwardRub
        None, one or two motions, by rising force.
    """
    law, (rotor, E) = law_of(system), unbalance_response(system, Omega)
    if law.surface_turns:
        return []
    c, H, forces = _rub_forces(system, np.asarray(float(Omega)), E)
    motions = []
    for F in np.sort(forces[forces > 0.0]):
        direction = E / (H * F + c * law.gap)  # of the force; d lags or leads it by the friction angle
        force = F * direction
        moved, stator_shape = pushed(system, Omega, Omega, force)
        rotor_shape, F_N = rotor + moved, F / law.oblique
        motions.append(
            ForwardRub(
                force=float(F),
                normal_force=float(F_N),
                distance=float(law.distance(F_N)),
                contact_angle=float(np.angle(direction * c)),
                amplitude=float(abs(rotor_shape @ system.rotor.contact)),
                rotor_shape=rotor_shape,
                stator_shape=stator_shape,
            )
        )
    return motions


def _rub_forces(system: System, Omega: FloatOrArray, E):
    """c, H'(Omega) and both solutions F (last axis; not a number: no motion) of the quadratic of the forward rub."""
    law = law_of(system)
    with np.errstate(invalid="ignore", divide="ignore"):  # a free motion has a pole at rest
        c, H = map(np.asarray, law.against_force(_receptance_at_own_speed(system, Omega)))
        half = law.gap * (H * np.conj(c)).real
        square = np.abs(H) ** 2
        spread = np.sqrt(half**2 - square * (law.gap**2 - np.abs(E) ** 2))
        return c, H, np.stack([(-half - spread) / square, (-half + spread) / square], axis=-1)


def _receptance_at_own_speed(system: System, Omega: FloatOrArray):
    """H(Omega) at the rotor speed Omega itself, for an array of speeds."""
    rotor = solve_at(rotor_stiffness(system, Omega, Omega), system.rotor.contact)
    rotor = np.where(np.isfinite(rotor), rotor, np.nan)
    stator = solve_at(stator_stiffness(system, Omega), system.stator.contact)
    return rotor @ system.rotor.contact + stator @ system.stator.contact


def synchronous_resonance(system: System, Omega_range):
    """Rotor speed at which the forward rub is largest.

    Parameters
    ----------
    system : System
    Omega_range : tuple of float, rad/s
        Lowest and highest speed.

    Returns
    -------
    float, rad/s
        Speed of the largest |r_R| at the contact coordinate, of two rubs at a speed of that which presses more; not a number
        where no speed has such a motion, and on a race that turns, as `forward_rub`.
    """
    if law_of(system).surface_turns:
        return np.nan
    low, high = Omega_range
    best = np.nan
    for n_speeds in (2001, 201, 201, 201):
        Omega = np.linspace(low, high, n_speeds)
        amplitude = _rub_amplitude(system, Omega)
        if np.all(np.isnan(amplitude)):
            return best
        i = int(np.nanargmax(amplitude))
        best = float(Omega[i])
        low, high = Omega[max(i - 1, 0)], Omega[min(i + 1, n_speeds - 1)]
    return best


def _rub_amplitude(system: System, Omega: FloatOrArray):
    """|r_R| of the forward rub that presses more at each speed (not a number: no contact); the other one is a saddle."""
    rotor, E = unbalance_response(system, Omega)
    c, H, forces = _rub_forces(system, Omega, E)
    force = np.where(forces[:, 1] > 0.0, forces[:, 1], np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        direction = E / (H * force + c * law_of(system).gap)
        H_r = solve_at(rotor_stiffness(system, Omega, Omega), system.rotor.contact) @ system.rotor.contact
    return np.abs(rotor @ system.rotor.contact - H_r * force * direction)
