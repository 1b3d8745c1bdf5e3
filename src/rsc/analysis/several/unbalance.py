"""What adds lines to whirls at several contacts, to first order: the unbalance at Omega, with a mirror line at 2 Psi - Omega, and
supports whose directions differ at -Psi, with one at 3 Psi.

As for one contact (section 3.4 of docs/users/physics.md, the consistent form): in the frame turning with Psi the force of a
pressed contact (growth.py) answers a motion Y e^{iwt} + Z e^{-iwt}, w = Omega - Psi or -2 Psi, with

    c/2 [(K + t) Y + (K - t) u^2 conj(Z)] at w   and   c/2 [(conj K + t) Z + (conj K - t) u^2 conj(Y)] at -w,

K = k_C + i w b*, t = F_N/|d|.
"""

import numpy as np

from rsc.analysis.paper.anisotropy import anisotropic_part
from rsc.analysis.paper.synchronous import envelope_of
from rsc.system.system import FloatOrArray, System


def unbalance_lines(system: System, own, whirls):
    """Lines of the unbalance on m whirls in the turning frame; only the sizes count, for its phase against the whirl is free.

    Parameters
    ----------
    system : System
    own : Pressed
        With rings of the contacts' rotors.
    whirls : Whirling

    Returns
    -------
    line, mirror_line : (m, N + M + p) complex m (tilts: rad), the last of p first-order states
    force, mirror_force : (m, n) complex N, at the pressed contacts
    """
    drive = np.concatenate([system.rotor.unbalance * own.Omega**2, np.zeros(system.n_stator + own.states)])
    parts = [_lines(own, (own.Omega, drive, own.ring), *whirl) for whirl in zip(*whirls, strict=True)]
    return tuple(np.array(each) for each in zip(*parts, strict=True))


def direction_lines(system: System, own, whirls):
    """Lines at -Psi and 3 Psi that supports whose directions differ add to m whirls of the mean of the directions, to first order
    in what differs: E and C act on the conjugate of the whirl, -(E - i Psi C) conj(x) e^{-i Psi t}.

    Returns
    -------
    line, third : (m, N + M) complex m (tilts: rad), in the turning frame
    """
    E, C = (anisotropic_part(system.at_speed(own.Omega), kind) for kind in ("stiffness", "damping"))
    parts = []
    for Psi, N, phi, shape in zip(*whirls, own.shapes(whirls), strict=True):
        drive = -(E - 1j * Psi * C) @ shape.conj()
        parts.append(_lines(own, (-Psi, drive, np.zeros(own.n)), Psi, N, phi)[:2])
    return tuple(np.array(each) for each in zip(*parts, strict=True))


def _lines(own, driven, Psi: FloatOrArray, N, phi):
    """The lines of a force on the bodies at a frequency in rad/s, and of rings that turn with it; driven: all three."""
    at, drive, ring = driven
    w, u = at - Psi, np.exp(1j * phi)
    K = np.array([law.dynamic_stiffness(w) for law in own.laws])
    t = N / own.distances(N)
    direct, across = 0.5 * own.turn * (K + t), 0.5 * own.turn * (K - t) * u**2
    # conj(Z) is the second unknown
    back_direct, back_across = 0.5 * own.turn.conj() * (K + t), 0.5 * own.turn.conj() * (K - t) * u.conj() ** 2
    A, A_mirror = own.dynamic_stiffness(np.array([at, 2.0 * Psi - at]))
    L, n = own.rows, len(drive)
    matrix = np.block(
        [[A + (L.T * direct) @ L, (L.T * across) @ L], [(L.T * back_across) @ L, A_mirror.conj() + (L.T * back_direct) @ L]]
    )
    right = np.concatenate([drive - L.T @ (direct * ring), -L.T @ (back_across * ring)])
    x = np.linalg.lstsq(matrix, right, rcond=None)[0]  # a free motion at rest is no line: the least one
    Y, Z = L @ x[:n] + ring, L @ x[n:]
    return x[:n], x[n:].conj(), direct * Y + across * Z, (back_across * Y + back_direct * Z).conj()


def largest(whirl, line, mirror_line):
    """(smallest, largest) size of a displacement over the beat; without the lines where they have none, at a pole."""
    with np.errstate(invalid="ignore"):
        low, high = envelope_of(whirl, line, mirror_line)
    return np.where(np.isfinite(low), low, np.abs(whirl)), np.where(np.isfinite(high), high, np.abs(whirl))
