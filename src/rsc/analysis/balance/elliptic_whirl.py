"""Whirl in supports whose directions differ, exactly: harmonic balance in the frame turning with the whirl.

Anisotropic terms join the line at w with the one at -w, the contact joins it with the one at 2 Psi - w: a whirl without unbalance
has the lines w_k = (1 - 2 k) Psi, the whirl (k = 0), its mirror line at -Psi (1), and so on. In the frame turning with Psi it is
periodic with the beat -2 Psi, and the line opposite to k is 1 - k. Of the `Problem` the receptances are special: H and H_c are
those of the doubled dynamic stiffness (docs/maintainers/analysis.md), and nothing else drives, u_k = 0.
"""

from dataclasses import dataclass, replace
from math import tau as TWO_PI

import numpy as np

from rsc.analysis.balance.balance_force import extremes
from rsc.analysis.balance.problem import Problem
from rsc.analysis.paper.anisotropy import contact_motion, mirror_line
from rsc.analysis.paper.receptance import along
from rsc.system.blas import one_thread
from rsc.system.body import ANISOTROPIC
from rsc.system.system import System

PAIRS = 6  # pairs of lines k, 1 - k
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
def elliptic_whirl(system: System, frequency, speed, pairs=PAIRS):
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
    problem = _Elliptic(system, TWO_PI * float(speed), pairs, frequency)
    return problem.result(*problem.found()[:2])


class _Elliptic(Problem):
    """The balance of a whirl whose supports differ in their directions; the share of that is raised."""

    beat_slope = -2.0
    from_afar = False  # from the whirl of the mean such steps may lead to another whirl
    limit = "no whirl was found with {} of what makes the directions differ"

    def __init__(self, system: System, Omega: float, pairs, frequency):
        super().__init__(system, Omega, np.arange(1 - pairs, pairs + 1))
        self.frequency, self.relative = frequency, system.relative

    def beat(self, Psi: float):
        return -2.0 * Psi

    def linear(self, Psi: float, share):
        at = [along(self.motions(Psi * (1.0 + offset), share), self.relative) for offset in (0.0, -_OFFSET, _OFFSET)]
        slope = (at[2] - at[1]) / (2.0 * _OFFSET * Psi)
        return 0.0, *zip(at[0], slope, strict=True)

    def motions(self, Psi: float, share=1.0):
        """X_0 and X_1 of all lines, (2, 2 K, N + M): the responses to a unit contact force at the same frequency, and at the
        opposite one."""
        first = self.lines_at(Psi)[: len(self.k) // 2]
        motions = contact_motion(self.weakened(share), first, self.Omega)
        return np.concatenate([motions[:2], motions[2:, ::-1]], axis=1)

    def weakened(self, share):
        """The system with a share of what makes its directions differ."""
        return replace(self.system, rotor=_weaker(self.system.rotor, share), stator=_weaker(self.system.stator, share))

    def start(self, share):
        """The whirl of the isotropic mean with the mirror line of first order."""
        Psi, F_N, forces = self.analytic_whirl(self.frequency)
        if share > 0.0:
            lines = mirror_line(self.weakened(share), Psi, F_N, self.Omega)
            forces[self.whirl + 1], forces[self.whirl - 1] = lines.force[0], lines.third_force[0]
        return forces, float(Psi[0])

    def result(self, forces, Psi: float):
        """The `EllipticWhirl` of a solution."""
        own, opposite = self.motions(Psi)
        motion = -own * forces[:, None] - opposite * forces[::-1].conj()[:, None]
        rotor = motion[:, : self.system.n_rotor] @ self.system.rotor.contact
        normal = self.residual(forces, Psi)[3].normal
        return EllipticWhirl(
            speed=self.Omega / TWO_PI,
            frequency=Psi / TWO_PI,
            lines=self.lines_at(Psi) / TWO_PI,
            motion=motion,
            rotor=rotor,
            amplitude=float(abs(rotor[self.whirl])),
            mirror_amplitude=float(abs(rotor[self.whirl + 1])),
            envelope=extremes(rotor, self.k),
            normal_force=(float(normal.min()), float(normal.max())),
        )


def _weaker(body, share):
    parts = {name: getattr(body, name) for name in ANISOTROPIC}
    return replace(body, **{name: None if part is None else share * part for name, part in parts.items()})
