"""Whirl with its unbalance exactly: harmonic balance in the frame turning with the whirl (docs/maintainers/analysis.md).

A whirl with unbalance has two base frequencies, Psi and Omega. In the frame turning with Psi it is periodic with the
beat Omega - Psi, and its lines are w_k = Psi + k (Omega - Psi): the whirl (k = 0), the unbalance (1), the mirror line
(-1) and so on. Of the `Problem` only the unbalance is special: u_1 = E, all other u_k = 0.
"""

from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np

from rsc.analysis.balance.balance_force import extremes
from rsc.analysis.balance.problem import Problem
from rsc.analysis.paper.receptance import receptance_rotor, receptance_stator, receptance_with_slope
from rsc.analysis.paper.synchronous import synchronous_response, unbalance_response
from rsc.system.blas import one_thread
from rsc.system.system import System

HARMONICS = 8


@dataclass(frozen=True, eq=False)
class Balance:
    """A whirl with unbalance at one rotor speed, steady and in the frame turning with it periodic.

    speed, frequency : float Hz, rotor speed and whirl frequency Psi
    forces : (2 K + 1,) complex N, lines k = -K .. K of the contact force
    lines : (2 K + 1,) float Hz, their frequencies
    rotor, stator : (2 K + 1,) complex m, lines of the motion at the contact coordinates
    envelope : (float, float) m, smallest and largest |r_R| at the contact coordinate over the beat
    normal_force : (float, float) N, smallest and largest over the beat
    contact_share : float, share of the beat with pressed contact; below 1 the contact is lost during the beat
    tail : float, size of the last lines over that of the whirl, a measure of the truncation
    steps : int, Newton steps taken
    """

    speed: float
    frequency: float
    forces: np.ndarray
    lines: np.ndarray
    rotor: np.ndarray
    stator: np.ndarray
    envelope: tuple
    normal_force: tuple
    contact_share: float
    tail: float
    steps: int


@one_thread
def balance(system: System, frequency, speed, harmonics=HARMONICS):
    """Find a whirl with its unbalance at one rotor speed.

    Parameters
    ----------
    system : System
        With finite contact stiffness. A constant load is not part of the motion and is left out.
    frequency : float, Hz
        The analytic whirl next to it is the start.
    speed : float, Hz
    harmonics : int
        K: lines -K .. K.

    Returns
    -------
    Balance

    Raises
    ------
    NotBalanced
        No whirl there, or none with so much unbalance: see its `reached`.
    """
    problem = _Unbalanced(system, TWO_PI * float(speed), harmonics, frequency)
    return problem.result(*problem.found())


@one_thread
def balance_rolling(system: System, roll, speed):
    """Find a whirl that rolls with its unbalance at one rotor speed: its surfaces may slip during a part of the beat.

    Parameters
    ----------
    system : System
        With a contact diameter.
    roll : rsc.analysis.paper.rolling.Roll
    speed : float, Hz

    Returns
    -------
    Balance

    Raises
    ------
    NotBalanced
    """
    problem = _Rolling(system, TWO_PI * float(speed), HARMONICS, roll)
    return problem.result(*problem.raised())


def beat_of(system: System, balance):
    """Contact force and its derivatives over the beat of a `Balance`, as `rsc.analysis.balance.balance_force.BeatForce`."""
    problem = _Unbalanced(system, TWO_PI * balance.speed, (len(balance.forces) - 1) // 2)
    return problem.residual(balance.forces, TWO_PI * balance.frequency)[3]


class _Unbalanced(Problem):
    """The balance of a whirl with its unbalance, whose share is raised.

    frequency : float, Hz, of the analytic whirl to start from; None if `start` does not need it
    """

    beat_slope = -1.0
    limit = "no steady whirl with {} of the unbalance"

    def __init__(self, system: System, Omega: float, harmonics, frequency=None):
        super().__init__(system, Omega, np.arange(-harmonics, harmonics + 1))
        self.bodies, self.frequency = self.system.joined(), frequency
        self.rotor_free, E = unbalance_response(system, Omega)
        self.E = complex(E)

    def beat(self, Psi: float):
        return self.Omega - Psi

    def linear(self, Psi: float, share):
        u = np.zeros(len(self.k), complex)
        u[self.whirl + 1] = share * self.E
        H, slope = receptance_with_slope(self.bodies, self.Omega, self.lines_at(Psi))
        return u, (H, (1 - self.k) * slope), None

    def start(self, share):
        """The analytic whirl with the lines of first order."""
        Psi, F_N, forces = self.analytic_whirl(self.frequency)
        part, _ = synchronous_response(self.system, Psi, F_N, self.Omega)
        forces[self.whirl + 1], forces[self.whirl - 1] = share * part.force[0], share * part.mirror_force[0]
        return forces, float(Psi[0])

    def result(self, forces, Psi: float, steps):
        """The `Balance` of a solution."""
        system, lines = self.system, self.lines_at(Psi)
        rotor = -receptance_rotor(system, lines, self.Omega) * forces
        rotor[self.whirl + 1] += self.rotor_free @ system.rotor.contact
        stator = receptance_stator(system, lines) * forces
        _, _, _, force = self.residual(forces, Psi)
        sizes = np.abs(rotor) / abs(rotor[self.whirl])
        return Balance(
            speed=self.Omega / TWO_PI,
            frequency=Psi / TWO_PI,
            forces=forces,
            lines=lines / TWO_PI,
            rotor=rotor,
            stator=stator,
            envelope=extremes(rotor, self.k),
            normal_force=(float(force.normal.min()), float(force.normal.max())),
            contact_share=float((force.normal > 0.0).mean()),
            tail=float(max(sizes[0], sizes[-1])),
            steps=steps,
        )


class _Rolling(_Unbalanced):
    """As `_Unbalanced`, from a whirl that rolls."""

    def __init__(self, system: System, Omega: float, harmonics, roll):
        super().__init__(system, Omega, harmonics)
        self.roll = roll

    def start(self, share):
        """The whirl that rolls without unbalance, with the free phase of a force with full friction (`Problem.jacobian`)."""
        forces = np.zeros(len(self.k), complex)
        forces[self.whirl] = np.hypot(1.0, self.roll.traction) * self.roll.normal_force * self.turn / abs(self.turn)
        return forces, self.roll.Psi
