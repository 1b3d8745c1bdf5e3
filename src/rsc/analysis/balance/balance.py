"""Whirl with its unbalance exactly: harmonic balance in the frame turning with the whirl (docs/maintainers/analysis.md).

A whirl with unbalance has two base frequencies, Psi and Omega. In the frame turning with Psi it is periodic with the
beat Omega - Psi, and its lines are w_k = Psi + k (Omega - Psi): the whirl (k = 0), the unbalance (1), the mirror line
(-1) and so on. Only the contact is nonlinear, so that the unknowns are Psi and the force lines F_k alone:

    d_k = u_k - H(w_k) F_k,    F_k = line k of the contact law along d,    u_1 = E, all other u_k = 0.
"""

import contextlib
from dataclasses import dataclass

import numpy as np

from rsc.analysis.balance.balance_force import beat_force, extremes, hankel, lines_of, toeplitz
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import receptance_rotor, receptance_stator, receptance_with_slope
from rsc.analysis.paper.synchronous import synchronous_response, unbalance_response
from rsc.analysis.paper.whirls import steady_whirls
from rsc.system.blas import one_thread

TWO_PI = 2.0 * np.pi
HARMONICS = 8
# samples of the beat per harmonic: the damper's kink needs more than the smooth force
SAMPLES_PER_HARMONIC = 64
# change of the unknowns over the largest force and over Psi at which Newton's method, quadratic there, has converged
_CONVERGED = 1e-9
# and above which the next step is one from afar
_FAR = 1e-3
_DIVERGED = 1e3
# more steps than this mean a far start, from which the method may end on another motion, next to a fold for example
_MOST_STEPS = 7
_FEW_STEPS = 5
# smallest step of the unbalance, as a share of it
_LEAST_STEP = 1e-4


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


class NotBalanced(ArithmeticError):
    """No steady motion was found.

    reached : float, share of the unbalance up to which the whirl could be followed, NaN where that was not tried. The
        whirl with unbalance usually ends there in a fold with an unstable one, whatever the number of harmonics.
    """

    def __init__(self, problem, reached=np.nan):
        super().__init__(problem)
        self.reached = reached


@one_thread
def balance(system, frequency, speed, harmonics=HARMONICS):
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
    problem = _Problem(system, TWO_PI * float(speed), harmonics)
    forces, Psi = problem.analytic_start(frequency)
    try:
        return problem.result(*problem.solve(forces, Psi, problem.E))
    except NotBalanced:  # the first order is too far away: raise the unbalance step by step
        return problem.result(*problem.raised(lambda share: problem.analytic_start(frequency, share)))


@one_thread
def balance_rolling(system, roll, speed, harmonics=HARMONICS):
    """Find a whirl that rolls with its unbalance at one rotor speed: its surfaces may slip during a part of the beat.

    Parameters
    ----------
    system : System
        With a contact diameter.
    roll : rsc.analysis.paper.rolling.Roll
    speed : float, Hz
    harmonics : int

    Returns
    -------
    Balance

    Raises
    ------
    NotBalanced
    """
    problem = _Problem(system, TWO_PI * float(speed), harmonics)
    forces = np.zeros(2 * harmonics + 1, complex)
    # the free phase is that of a force with full friction, `_Problem.jacobian`
    forces[harmonics] = np.hypot(1.0, roll.traction) * roll.normal_force * problem.turn / abs(problem.turn)
    return problem.result(*problem.raised(lambda share: (forces, roll.Psi)))


def beat_of(system, balance):
    """Contact force and its derivatives over the beat of a `Balance`, as `rsc.analysis.balance.balance_force.BeatForce`."""
    problem = _Problem(system, TWO_PI * balance.speed, (len(balance.forces) - 1) // 2)
    return problem.residual(balance.forces, TWO_PI * balance.frequency, problem.E)[3]


class _Problem:
    """The balance of one system at one speed."""

    def __init__(self, system, Omega, harmonics):
        self.system, self.Omega, self.harmonics = system, Omega, harmonics
        self.bodies = system.joined()
        self.k = np.arange(-harmonics, harmonics + 1)
        self.n_time = SAMPLES_PER_HARMONIC * max(harmonics, 4)
        self.rotor_free, E = unbalance_response(system, Omega)
        self.E = complex(E)
        self.turn = law_of(system).turn
        self.size, self.unit = 1.0, 1.0  # a typical force and frequency, set at the start of each solution

    def analytic_start(self, frequency, share=1.0):
        """Forces (2 K + 1,) and Psi of the analytic whirl with the lines of first order."""
        system = self.system
        Psi, F_N = steady_whirls(system, self.Omega)
        if len(Psi) == 0:
            raise NotBalanced(f"no whirl at {self.Omega / TWO_PI:g} Hz")
        i = np.argmin(np.abs(Psi - TWO_PI * frequency))
        part, _ = synchronous_response(system, Psi[i : i + 1], F_N[i : i + 1], self.Omega)
        forces = np.zeros(len(self.k), complex)
        middle = self.harmonics
        forces[middle] = self.turn * F_N[i]
        forces[middle + 1], forces[middle - 1] = share * part.force[0], share * part.mirror_force[0]
        return forces, float(Psi[i])

    def receptances(self, Psi):
        """H and dH/dw at the lines w_k, without the rotating friction factor."""
        return receptance_with_slope(self.bodies, self.Omega, Psi + self.k * (self.Omega - Psi))

    def beats(self, *lines):
        """Samples over one beat of each of several lines k = -K .. K."""
        spectra = np.zeros((len(lines), self.n_time), complex)
        spectra[:, self.k] = lines
        return np.fft.ifft(spectra) * self.n_time

    def residual(self, forces, Psi, E, far=False):
        """Residual (2 K + 1,) of the balance, the distances d_k, dd_k/dPsi parts and the force of the beat.

        far : bool, whether the derivatives are for a step from afar.
        """
        H, slope = self.receptances(Psi)
        d = -H * forces
        d[self.harmonics + 1] += E
        rate = 1j * self.k * (self.Omega - Psi)
        *beat, held = self.beats(d, rate * d, forces)
        force = beat_force(self.system, *beat, Psi, self.Omega, held if far else None)
        lines = np.fft.fft(force.force)[self.k] / self.n_time
        return forces - lines, d, (H, slope), force

    def solve(self, forces, Psi, E):
        """Newton's method; returns (forces, Psi, steps).

        Full steps: the contact is so stiff that every step along it first raises the force residual. Steps from afar are made
        with the force that they start from, `beat_force`; where the contact is lost during the beat they may lead nowhere.
        """
        self.size, self.unit = float(np.abs(forces).max()), abs(Psi)
        with contextlib.suppress(NotBalanced):
            return self.newton(forces, Psi, E, _FAR)
        return self.newton(forces, Psi, E, np.inf)

    def newton(self, forces, Psi, E, far):
        """As `solve`; a step is one from afar while the one before was longer than `far`."""
        length = 1.0
        for step in range(1, _MOST_STEPS + 1):
            state = self.residual(forces, Psi, E, far=length > far)
            change = _solved(self.jacobian(forces, Psi, state), self.right_hand_side(forces, state))
            forces, Psi = self.moved(forces, Psi, change)
            length = np.abs(change).max()
            if not length < _DIVERGED or Psi >= 0.0 or (forces[self.harmonics] / self.turn).real <= 0.0:
                break
            if length <= _CONVERGED:
                return forces, Psi, step
        raise NotBalanced("Newton's method does not converge")

    def raised(self, start_at):
        """The solution reached from a small unbalance by secant steps; returns as `solve`.

        start_at(share) gives forces and Psi near the motion with a small share of the unbalance.
        """
        reached, step, newton_steps = 0.0, 0.1, 0
        forces, Psi = start_at(0.0)
        before = None
        while reached < 1.0:
            share = min(1.0, reached + step)
            if before is None:
                start = start_at(share)
            else:
                ahead = (share - reached) / (reached - before[2])
                start = forces + ahead * (forces - before[0]), Psi + ahead * (Psi - before[1])
            try:
                new = self.solve(*start, share * self.E)
            except NotBalanced:
                step *= 0.5
                if step < _LEAST_STEP:
                    text = f"no steady whirl with more than {100.0 * reached:.1f} % of the unbalance"
                    raise NotBalanced(text, reached) from None
                continue
            before = forces, Psi, reached
            forces, Psi, reached, newton_steps = new[0], new[1], share, newton_steps + new[2]
            step *= 1.5 if new[2] <= _FEW_STEPS else 0.75
        return forces, Psi, newton_steps

    def right_hand_side(self, forces, state):
        residual = -state[0]
        phase = -(forces[self.harmonics] / self.turn).imag
        return np.concatenate([residual.real, residual.imag, [phase]]) / self.size

    def moved(self, forces, Psi, change):
        """Forces and Psi after a step in the unknowns: Re F_k, Im F_k over a typical force, then Psi over itself."""
        n = len(self.k)
        return forces + self.size * (change[:n] + 1j * change[n : 2 * n]), Psi + self.unit * change[-1]

    def jacobian(self, forces, Psi, state):
        """Derivative of the residual; the phase of the whirl is held by Im(F_0 / (1 + i mu)) = 0."""
        _, d, (H, slope), force = state
        n, k = len(self.k), self.k
        rate = 1j * k * (self.Omega - Psi)
        lines = lines_of(force.by_d, force.by_v, force.by_d_conj, force.by_v_conj, force.by_Psi)
        by_v, by_v_conj = toeplitz(lines[1], k), hankel(lines[3], k)
        direct = toeplitz(lines[0], k) + by_v * rate
        mirrored = hankel(lines[2], k) + by_v_conj * rate.conj()
        # change of the lines of the law through d: dd_k = -H_k dF_k - (1 - k) H'_k F_k dPsi
        by_F, by_F_conj = np.eye(n) + direct * H, mirrored * H.conj()
        moved = -(1 - k) * slope * forces
        v_moved = -1j * k * d  # the beat itself gets slower
        by_Psi = direct @ moved + mirrored @ moved.conj() + by_v @ v_moved + by_v_conj @ v_moved.conj()
        by_Psi += lines[4, k]
        matrix = np.zeros((2 * n + 1, 2 * n + 1))
        plus, minus = by_F + by_F_conj, by_F - by_F_conj
        matrix[:n, :n], matrix[:n, n : 2 * n] = plus.real, -minus.imag
        matrix[n : 2 * n, :n], matrix[n : 2 * n, n : 2 * n] = plus.imag, minus.real
        matrix[: 2 * n, -1] = -np.concatenate([by_Psi.real, by_Psi.imag]) * self.unit / self.size
        phase = 1.0 / self.turn
        matrix[-1, self.harmonics], matrix[-1, n + self.harmonics] = phase.imag, phase.real
        return matrix

    def result(self, forces, Psi, steps):
        """The `Balance` of a solution."""
        system, lines = self.system, Psi + self.k * (self.Omega - Psi)
        rotor = -receptance_rotor(system, lines, self.Omega) * forces
        rotor[self.harmonics + 1] += self.rotor_free @ system.rotor.contact
        stator = receptance_stator(system, lines) * forces
        _, _, _, force = self.residual(forces, Psi, self.E)
        sizes = np.abs(rotor) / abs(rotor[self.harmonics])
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


def _solved(matrix, right):
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        raise NotBalanced("singular Jacobian") from None
