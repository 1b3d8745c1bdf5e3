"""Whirl in supports whose directions differ, exactly: harmonic balance in the frame turning with the whirl.

Anisotropic terms join the line at w with the one at -w, the contact joins it with the one at 2 Psi - w: a whirl without unbalance
has the lines w_k = (1 - 2 k) Psi, the whirl (k = 0), its mirror line at -Psi (1), and so on. In the frame turning with Psi it is
periodic with the beat -2 Psi. As in `rsc.analysis.balance.balance` the unknowns are Psi and the force lines F_k,

    d_k = -H(w_k) F_k - H_c(w_k) conj(F_{1-k}),    F_k = line k of the contact law along d,

with the receptances H and H_c of the doubled dynamic stiffness (docs/maintainers/analysis.md).
"""

from dataclasses import dataclass, replace

import numpy as np

from rsc.analysis.balance.balance import NotBalanced
from rsc.analysis.balance.balance_force import beat_force, extremes, hankel, lines_of, toeplitz
from rsc.analysis.paper.anisotropy import contact_motion, mirror_line
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import along
from rsc.analysis.paper.whirls import steady_whirls
from rsc.system.blas import one_thread
from rsc.system.body import ANISOTROPIC

TWO_PI = 2.0 * np.pi
PAIRS = 6  # pairs of lines k, 1 - k
_SAMPLES = 384  # of the beat
_CONVERGED = 1e-9
_MOST_STEPS = 10
_FEW_STEPS = 4
# first and smallest step of the anisotropy, as a share of it
_FIRST_STEP, _LEAST_STEP = 0.25, 1e-3
LEAST_TOLD = 5e-4  # share of the anisotropy that one decimal of a percentage shows
_OFFSET = 1e-6  # of Psi, for the derivative of the receptances


@dataclass(frozen=True, eq=False)
class EllipticWhirl:
    """A whirl without unbalance, steady and in the frame turning with it periodic.

    speed, frequency : float Hz, rotor speed and whirl frequency Psi
    lines : (2 K,) float Hz, (1 - 2 k) Psi for k = 1 - K .. K
    motion : (2 K, N + M) complex m (tilts: rad), lines of all coordinates, rotor and stator
    rotor : (2 K,) complex m, lines of the rotor at the contact coordinate
    amplitude, mirror_amplitude : float m, of the lines at Psi and at -Psi
    envelope : (float, float) m, smallest and largest |r_R| at the contact coordinate
    normal_force : (float, float) N, smallest and largest; from 0 where contact is lost
    """

    speed: float
    frequency: float
    lines: np.ndarray
    motion: np.ndarray
    rotor: np.ndarray
    amplitude: float
    mirror_amplitude: float
    envelope: tuple
    normal_force: tuple


@one_thread
def elliptic_whirl(system, frequency, speed, pairs=PAIRS):
    """Find a whirl of a system whose directions differ at one rotor speed, from that of its isotropic mean.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    frequency : float, Hz
        The whirl of the isotropic mean that is next to it.
    speed : float, Hz
    pairs : int
        Pairs of lines.

    Returns
    -------
    EllipticWhirl

    Raises
    ------
    ValueError
        Rigid contact.
    NotBalanced
        No such whirl: see its `reached`, the share of the anisotropy up to which there is one.
    """
    Omega = TWO_PI * float(speed)
    Psi, F_N = steady_whirls(system, Omega)
    if len(Psi) == 0:
        raise NotBalanced(f"no whirl at {speed:g} Hz")
    i = np.argmin(np.abs(Psi - TWO_PI * frequency))
    return _result(system, Omega, *_raised(system, Omega, Psi[i : i + 1], F_N[i : i + 1], pairs))


def _raised(system, Omega, mean, F_N, pairs):
    """Forces and Psi of the whole anisotropy, followed from the whirl of the isotropic mean in secant steps."""
    forces, Psi = np.zeros(2 * pairs, complex), float(mean[0])
    forces[pairs - 1] = law_of(system).turn * F_N[0]
    reached, step, before = 0.0, _FIRST_STEP, None
    while reached < 1.0:
        share = min(1.0, reached + step)
        if before is None:
            lines, first = mirror_line(_weakened(system, share), mean, F_N, Omega), forces.copy()
            first[pairs], first[pairs - 2] = lines.force[0], lines.third_force[0]
            start = first, Psi
        else:
            ahead = (share - reached) / (reached - before[2])
            start = forces + ahead * (forces - before[0]), Psi + ahead * (Psi - before[1])
        try:
            solved = _solved(_weakened(system, share), Omega, *start)
        except NotBalanced:
            step *= 0.5
            if step < _LEAST_STEP:
                part = f"more than {100.0 * reached:.1f} %" if reached >= LEAST_TOLD else "any part"
                text = f"no whirl was found with {part} of what makes the directions differ"
                raise NotBalanced(text, reached) from None
            continue
        before = forces, Psi, reached
        (forces, Psi), reached = solved[:2], share
        step *= 1.5 if solved[2] <= _FEW_STEPS else 0.75
    return forces, Psi


def _weakened(system, share):
    return replace(system, rotor=_weaker(system.rotor, share), stator=_weaker(system.stator, share))


def _weaker(body, share):
    parts = {name: getattr(body, name) for name in ANISOTROPIC}
    return replace(body, **{name: None if part is None else share * part for name, part in parts.items()})


def _solved(system, Omega, forces, Psi):
    """Newton's method with full steps; returns (forces, Psi, steps)."""
    size, turn, n = np.abs(forces).max(), law_of(system).turn, len(forces)
    sign, whirl = np.sign(Psi), n // 2 - 1
    for step in range(1, _MOST_STEPS + 1):
        residual, force, receptances = _residual(system, Omega, forces, Psi)
        ends = [_residual(system, Omega, forces, Psi * (1.0 + offset))[0] for offset in (-_OFFSET, _OFFSET)]
        by_Psi = (ends[1] - ends[0]) / (2.0 * _OFFSET * size)  # a change of Psi over itself
        matrix = _jacobian(force, receptances, Psi)
        matrix = np.block([[matrix, np.concatenate([by_Psi.real, by_Psi.imag])[:, None]], [np.zeros((1, 2 * n + 1))]])
        matrix[-1, whirl], matrix[-1, n + whirl] = (1.0 / turn).imag, (1.0 / turn).real
        phase = (forces[whirl] / turn).imag
        try:
            change = np.linalg.solve(matrix, -np.concatenate([residual.real, residual.imag, [phase]]) / size)
        except np.linalg.LinAlgError:
            break
        forces, Psi = forces + size * (change[:n] + 1j * change[n : 2 * n]), Psi * (1.0 + change[-1])
        length = np.abs(change).max()
        if not length < 1.0 or np.sign(Psi) != sign or (forces[whirl] / turn).real <= 0.0:
            break
        if length <= _CONVERGED:
            return forces, Psi, step
    raise NotBalanced("Newton's method does not converge")


def _residual(system, Omega, forces, Psi):
    """Residual (2 K,), the `BeatForce` and the receptances H, H_c (2, 2 K)."""
    k = _numbers(forces)
    receptances = along(_motions(system, Omega, Psi, k), system.relative)
    d = -receptances[0] * forces - receptances[1] * forces[::-1].conj()
    force = beat_force(system, _beat(d, k), _beat(-2j * k * Psi * d, k), Psi, Omega)
    return forces - np.fft.fft(force.force)[k] / _SAMPLES, force, receptances


def _motions(system, Omega, Psi, k):
    """X_0 and X_1 of all lines, (2, 2 K, N + M): motions by the contact force of the line and by that of the opposite one."""
    first = k[: len(k) // 2]
    motions = contact_motion(system, (1 - 2 * first) * Psi, Omega)
    return np.concatenate([motions[:2], motions[2:, ::-1]], axis=1)


def _numbers(forces):
    """k of the lines; those of k and 1 - k lie at w and -w, and stand opposite to each other."""
    pairs = len(forces) // 2
    return np.arange(1 - pairs, pairs + 1)


def _beat(lines, k):
    spectrum = np.zeros(_SAMPLES, complex)
    spectrum[k] = lines
    return np.fft.ifft(spectrum) * _SAMPLES


def _jacobian(force, receptances, Psi):
    """Derivative of the real residual [Re, Im] by the real forces [Re, Im], both over a typical force."""
    H, H_c = receptances
    n = len(H)
    k = np.arange(1 - n // 2, n // 2 + 1)
    rate = -2j * k * Psi
    by_d, by_v, by_d_conj, by_v_conj = lines_of(force.by_d, force.by_v, force.by_d_conj, force.by_v_conj)
    direct = toeplitz(by_d, k) + toeplitz(by_v, k) * rate
    mirrored = hankel(by_d_conj, k) + hankel(by_v_conj, k) * rate.conj()
    # dd_k = -H_k dF_k - H_c,k conj(dF_{1-k}): reversing the columns takes line k to 1 - k
    by_F = np.eye(n) + direct * H + (mirrored * H_c.conj())[:, ::-1]
    by_F_conj = mirrored * H.conj() + (direct * H_c)[:, ::-1]
    plus, minus = by_F + by_F_conj, by_F - by_F_conj
    return np.block([[plus.real, -minus.imag], [plus.imag, minus.real]])


def _result(system, Omega, forces, Psi):
    k = _numbers(forces)
    own, opposite = _motions(system, Omega, Psi, k)
    motion = -own * forces[:, None] - opposite * forces[::-1].conj()[:, None]
    rotor = motion[:, : system.n_rotor] @ system.rotor.contact
    normal = _residual(system, Omega, forces, Psi)[1].normal
    whirl = len(k) // 2 - 1
    return EllipticWhirl(
        speed=Omega / TWO_PI,
        frequency=Psi / TWO_PI,
        lines=(1 - 2 * k) * Psi / TWO_PI,
        motion=motion,
        rotor=rotor,
        amplitude=float(abs(rotor[whirl])),
        mirror_amplitude=float(abs(rotor[whirl + 1])),
        envelope=extremes(rotor, k),
        normal_force=(float(normal.min()), float(normal.max())),
    )
