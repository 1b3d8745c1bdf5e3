"""The contact force of one beat in the frame turning with a whirl, and its derivatives (alternating frequency and time).

Everything is dimensionless in time: tau = (Omega - Psi) t runs over one beat, v is the rate of d in that frame in 1/s.
"""

from dataclasses import dataclass

import numpy as np

from rsc.analysis.paper.law import law_of
from rsc.system.system import System

# samples of the beat in which extremes are looked for, before they are refined by a parabola
_ENVELOPE_SAMPLES = 2048


@dataclass(frozen=True, eq=False)
class BeatForce:
    """Contact force over one beat; arrays (n_time,), complex unless said otherwise.

    Small changes obey  dF = by_d dd + by_d_conj conj(dd) + by_v dv + by_v_conj conj(dv), and by_Psi per rad/s through
    the slip velocity.

    force : N
    normal : float, N
    """

    force: np.ndarray
    normal: np.ndarray
    by_d: np.ndarray
    by_d_conj: np.ndarray
    by_v: np.ndarray
    by_v_conj: np.ndarray
    by_Psi: np.ndarray


def beat_force(system: System, d, v, Psi: float, Omega: float, held=None):
    """Contact force (7), (10), (11) with Coulomb's sign where the scene has a contact diameter.

    With d = rho e, |e| = 1, v / e = rho' + i t (t: tangential rate in the turning frame):
    F = N (1 + i mu sigma) e, N = max(0, k_C (rho - s) + b_C min(rho', 0)) in contact, sigma of
    v_rel = Omega d_R/2 + Psi rho + t. The derivatives are those of the piece that each instant is in.

    A stiff contact makes of distances that are a little off a normal force that is far off, and with it the derivative of the
    force's direction. Newton's method from afar does better with a force that is nearly right: `held` stands for N there, and
    tells which instants are in contact.

    Parameters
    ----------
    system : System
    d, v : (n_time,) complex, m and m/s, in the frame turning with Psi
    Psi, Omega : float, rad/s
    held : (n_time,) complex N, optional
        An estimate of the force, for a step from afar. Without it all is as the law says.

    Returns
    -------
    BeatForce
    """
    rho = np.abs(d)
    e = d / np.where(rho > 0.0, rho, 1.0)
    local = v * e.conj()
    rho_dot, tangential = local.real, local.imag
    law = law_of(system)
    normal, *slopes = law.normal(rho, rho_dot)
    sigma, slope = (1.0, 0.0) if law.diameter is None else law.sign(law.slip(Psi, Omega, rho) + tangential)
    turn = law.turned(sigma)
    pressing = normal if held is None else (held * (turn * e).conj()).real / np.abs(turn) ** 2
    pressed = (pressing > 0.0) & ((rho > law.gap) | (held is not None))
    normal, pressing = np.where(pressed, normal, 0.0), np.where(pressed, pressing, 0.0)
    k, b = (np.where(pressed, slope, 0.0) for slope in slopes)
    fed = 1j * law.friction * slope * pressing  # dF / dv_rel, along e
    # in the local frame dd = (x + i y) e, dv = (p + i q) e:
    #   d rho = x,  d rho' = p + t y / rho,  dt = q - rho' y / rho,  de = i e y / rho
    safe = np.where(rho > 0.0, rho, 1.0)
    by_x = k * turn + fed * Psi
    by_y = (b * tangential * turn - fed * rho_dot + 1j * pressing * turn) / safe
    by_p, by_q = b * turn, fed
    square = e * e
    return BeatForce(
        force=normal * turn * e,
        normal=normal,
        by_d=0.5 * (by_x - 1j * by_y),
        by_d_conj=0.5 * (by_x + 1j * by_y) * square,
        by_v=0.5 * (by_p - 1j * by_q),
        by_v_conj=0.5 * (by_p + 1j * by_q) * square,
        by_Psi=fed * rho * e,
    )


def lines_of(*samples):
    """Lines of each of several samples over the beat, (n_time,) each; negative ones at the end."""
    return np.fft.fft(samples) / len(samples[0])


def toeplitz(lines, k):
    """Lines k - j of all lines over the beat, as the matrix (k, j) of a product with lines j."""
    return lines[k[:, None] - k]


def hankel(lines, k):
    """Lines k + j of all lines over the beat, as the matrix (k, j) of a product with the conjugates of lines j."""
    return lines[k[:, None] + k]


def extremes(lines, k):
    """Smallest and largest |sum_k lines e^{i k tau}|, refined by a parabola through the samples next to each."""
    spectrum = np.zeros(_ENVELOPE_SAMPLES, complex)
    spectrum[k] = lines
    size = np.abs(np.fft.ifft(spectrum)) * _ENVELOPE_SAMPLES
    ends = []
    for i in (int(np.argmin(size)), int(np.argmax(size))):
        left, mid, right = size[i - 1], size[i], size[(i + 1) % _ENVELOPE_SAMPLES]
        bend = left - 2.0 * mid + right
        ends.append(float(mid - (right - left) ** 2 / (8.0 * bend)) if bend else float(mid))
    return tuple(ends)
