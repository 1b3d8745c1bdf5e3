"""One harmonic balance for every whirl whose lines act on each other (docs/maintainers/analysis.md).

In the frame turning with Psi such a whirl is periodic with a beat, and its lines are w_k = Psi + k beat, k = 0 the whirl itself.
Rotor and stator are linear and only the contact is not, so that the unknowns are Psi and the lines F_k of its force alone:

    d_k = u_k - H(w_k) F_k - H_c(w_k) conj(F_k'),    F_k = line k of the contact law along d,    Im(F_0/(1 + i mu)) = 0,

with the motion u_k that something else drives and, where supports differ in their directions, the receptance H_c of the opposite
line k', at w_k' = -w_k. The last equation holds the free phase of the whirl.
"""

import contextlib
from math import tau as TWO_PI

import numpy as np

from rsc.analysis.balance.balance_force import beat_force, hankel, lines_of, toeplitz
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.whirls import steady_whirls
from rsc.system.system import System

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
# first and smallest step of what is raised, as a share of it
_FIRST_STEP, _LEAST_STEP = 0.1, 1e-4
LEAST_TOLD = 5e-4  # share that one decimal of a percentage shows


class NotBalanced(ArithmeticError):
    """No steady motion was found.

    reached : float, share of the unbalance, or of what makes the directions differ, up to which the whirl could be followed, NaN
        where that was not tried. The whirl usually ends there in a fold with an unstable one, whatever the number of harmonics.
    """

    def __init__(self, problem, reached=np.nan):
        super().__init__(problem)
        self.reached = reached


class Problem:
    """The balance of one system at one speed. A kind of whirl says which lines it has, what drives them and where to start.

    Parameters
    ----------
    system : System
    Omega : float, rad/s
    k : (n,) int, rising, numbers of the lines
    """

    beat_slope: float  # d beat/dPsi
    limit: str  # what is raised, as a failure names it, with a place for how much of it
    from_afar = True  # whether steps from afar are tried first

    def __init__(self, system: System, Omega: float, k):
        self.system, self.Omega, self.k = system.at_speed(Omega), Omega, k
        self.whirl = int(np.flatnonzero(k == 0)[0])
        self.n_time = SAMPLES_PER_HARMONIC * max(k[-1], 4)
        self.turn = law_of(system).turn
        self.size, self.unit = 1.0, 1.0  # a typical force and frequency, set at the start of each solution

    def beat(self, Psi: float):
        """Frequency of the beat, rad/s."""
        raise NotImplementedError

    def linear(self, Psi: float, share):
        """(u, H and dH/dPsi, H_c and dH_c/dPsi or None) of all lines, given the share of what is raised."""
        raise NotImplementedError

    def start(self, share):
        """Forces (n,) and Psi near the motion with a share of what is raised."""
        raise NotImplementedError

    def lines_at(self, Psi: float):
        """w_k, rad/s."""
        return Psi + self.k * self.beat(Psi)

    def analytic_whirl(self, frequency):
        """Psi (1,), F_N (1,) and forces (n,) of the analytic whirl next to a frequency in Hz, alone."""
        Psi, F_N = steady_whirls(self.system, self.Omega)
        if len(Psi) == 0:
            raise NotBalanced(f"no whirl at {self.Omega / TWO_PI:g} Hz")
        i = np.argmin(np.abs(Psi - TWO_PI * frequency))
        forces = np.zeros(len(self.k), complex)
        forces[self.whirl] = self.turn * F_N[i]
        return Psi[i : i + 1], F_N[i : i + 1], forces

    def found(self):
        """Forces, Psi and the Newton steps taken; where the first order is too far away by raising what drives step by step."""
        try:
            return self.solve(*self.start(1.0))
        except NotBalanced:
            return self.raised()

    def residual(self, forces, Psi: float, share=1.0, far=False):
        """Residual (n,) of the balance, the deflections d_k, the slopes from `linear`, and the contact force over a beat.

        far : bool, whether the solution is still far away: the derivatives then take `forces` for those of the law
        """
        u, own, opposite = self.linear(Psi, share)
        d = u - own[0] * forces
        if opposite is not None:
            d -= opposite[0] * forces[::-1].conj()
        rate = 1j * self.k * self.beat(Psi)
        distance, velocity, held = self._beats(d, rate * d, forces)
        force = beat_force(self.system, distance, velocity, Psi, self.Omega, held if far else None)
        lines = np.fft.fft(force.force)[self.k] / self.n_time
        return forces - lines, d, (own, opposite), force

    def _beats(self, *lines):
        """Samples over one beat of each of several sets of lines."""
        spectra = np.zeros((len(lines), self.n_time), complex)
        spectra[:, self.k] = lines
        return np.fft.ifft(spectra) * self.n_time

    def solve(self, forces, Psi: float, share=1.0):
        """Newton's method; returns (forces, Psi, steps).

        Full steps: the contact is so stiff that every step along it first raises the force residual. Steps from afar are made
        with the force that they start from, `beat_force`; where the contact is lost during the beat they may lead nowhere.
        """
        self.size, self.unit = float(np.abs(forces).max()), abs(Psi)
        if self.from_afar:
            with contextlib.suppress(NotBalanced):
                return self.newton(forces, Psi, share, _FAR)
        return self.newton(forces, Psi, share, np.inf)

    def newton(self, forces, Psi: float, share, far):
        """As `solve`; a step is one from afar while the one before was longer than `far`."""
        length, sense = 1.0, np.sign(Psi)
        for step in range(1, _MOST_STEPS + 1):
            state = self.residual(forces, Psi, share, far=length > far)
            try:
                change = np.linalg.solve(self.jacobian(forces, Psi, state), self.right_hand_side(forces, state))
            except np.linalg.LinAlgError:
                raise NotBalanced("singular Jacobian") from None
            forces, Psi = self.moved(forces, Psi, change)
            length = np.abs(change).max()
            if not length < _DIVERGED or np.sign(Psi) != sense or (forces[self.whirl] / self.turn).real <= 0.0:
                break
            if length <= _CONVERGED:
                return forces, Psi, step
        raise NotBalanced("Newton's method does not converge")

    def raised(self):
        """The solution reached from a small share by secant steps; returns as `solve`."""
        reached, step, newton_steps = 0.0, _FIRST_STEP, 0
        forces, Psi = self.start(0.0)
        before = None
        while reached < 1.0:
            share = min(1.0, reached + step)
            if before is None:
                start = self.start(share)
            else:
                ahead = (share - reached) / (reached - before[2])
                start = forces + ahead * (forces - before[0]), Psi + ahead * (Psi - before[1])
            try:
                new = self.solve(*start, share)
            except NotBalanced:
                step *= 0.5
                if step < _LEAST_STEP:
                    part = f"more than {100.0 * reached:.1f} %" if reached >= LEAST_TOLD else "any part"
                    raise NotBalanced(self.limit.format(part), reached) from None
                continue
            before = forces, Psi, reached
            forces, Psi, reached, newton_steps = new[0], new[1], share, newton_steps + new[2]
            step *= 1.5 if new[2] <= _FEW_STEPS else 0.75
        return forces, Psi, newton_steps

    def right_hand_side(self, forces, state):
        residual = -state[0]
        phase = -(forces[self.whirl] / self.turn).imag
        return np.concatenate([residual.real, residual.imag, [phase]]) / self.size

    def moved(self, forces, Psi: float, change):
        """Forces and Psi after a step in the unknowns: Re F_k, Im F_k over a typical force, then Psi over itself."""
        n = len(self.k)
        return forces + self.size * (change[:n] + 1j * change[n : 2 * n]), Psi + self.unit * change[-1]

    def jacobian(self, forces, Psi: float, state):
        """Derivative of the residual [Re, Im] and of the phase by the unknowns of `moved`, (2 n + 1, 2 n + 1)."""
        _, d, ((H, H_by_Psi), opposite), force = state
        n, k = len(self.k), self.k
        rate = 1j * k * self.beat(Psi)
        lines = lines_of(force.by_d, force.by_v, force.by_d_conj, force.by_v_conj, force.by_Psi)
        by_v, by_v_conj = toeplitz(lines[1], k), hankel(lines[3], k)
        direct = toeplitz(lines[0], k) + by_v * rate
        mirrored = hankel(lines[2], k) + by_v_conj * rate.conj()
        # change of the lines of the law through d: dd_k = -H_k dF_k - dH_k/dPsi F_k dPsi, and so of the opposite line, whose
        # column is the reverse one
        by_F, by_F_conj = np.eye(n) + direct * H, mirrored * H.conj()
        moved = -H_by_Psi * forces
        if opposite is not None:
            H_c, H_c_by_Psi = opposite
            by_F, by_F_conj = by_F + (mirrored * H_c.conj())[:, ::-1], by_F_conj + (direct * H_c)[:, ::-1]
            moved -= H_c_by_Psi * forces[::-1].conj()
        v_moved = 1j * k * self.beat_slope * d  # the beat itself changes
        by_Psi = direct @ moved + mirrored @ moved.conj() + by_v @ v_moved + by_v_conj @ v_moved.conj()
        by_Psi += lines[4, k]
        matrix = np.zeros((2 * n + 1, 2 * n + 1))
        plus, minus = by_F + by_F_conj, by_F - by_F_conj
        matrix[:n, :n], matrix[:n, n : 2 * n] = plus.real, -minus.imag
        matrix[n : 2 * n, :n], matrix[n : 2 * n, n : 2 * n] = plus.imag, minus.real
        matrix[: 2 * n, -1] = -np.concatenate([by_Psi.real, by_Psi.imag]) * self.unit / self.size
        phase = 1.0 / self.turn
        matrix[-1, self.whirl], matrix[-1, n + self.whirl] = phase.imag, phase.real
        return matrix
