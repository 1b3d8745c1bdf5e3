"""Closed forms of motion without contact in arbitrary precision: nothing of rsc is imported here.

All of physics.md section 2 with F_C = 0:  M r'' + (B - i Omega G) r' + K r = (U phi'^2 - i W phi'') e^{i phi}.
"""

import mpmath as mp
import numpy as np

DIGITS = 50


def free_motion(matrices, start, step, count):
    """r at 0, step, ..., count * step by the matrix exponential; matrices = (M, B, Omega G, K), start = (r, r')."""
    mass, damping, gyroscopic, stiffness = (mp.matrix(np.atleast_2d(m).tolist()) for m in matrices)
    n = mass.rows
    with mp.workdps(DIGITS):
        inverse = mass**-1
        lower = -(inverse * stiffness), -(inverse * (damping - mp.mpc(0, 1) * gyroscopic))
        rate = mp.zeros(2 * n)
        for i in range(n):
            rate[i, n + i] = 1
            for j in range(n):
                rate[n + i, j], rate[n + i, n + j] = lower[0][i, j], lower[1][i, j]
        ahead = mp.expm(rate * mp.mpf(step))
        state = mp.matrix([mp.mpc(complex(v)) for part in start for v in part])
        rows = []
        for _ in range(count + 1):
            rows.append([complex(state[i]) for i in range(n)])
            state = ahead * state
    return np.array(rows)


def steady_response(matrices, unbalance, speed):
    """R of r = R e^{i Omega t}: (K - Omega^2 M + i Omega (B - i Omega G)) R = Omega^2 U; matrices = (M, B, G, K), speed in Hz."""
    mass, damping, gyroscopic, stiffness = (mp.matrix(np.atleast_2d(m).tolist()) for m in matrices)
    with mp.workdps(DIGITS):
        omega = 2 * mp.pi * mp.mpf(speed)
        dynamic = stiffness - omega**2 * mass + mp.mpc(0, 1) * omega * (damping - mp.mpc(0, 1) * omega * gyroscopic)
        right = mp.matrix([omega**2 * mp.mpc(complex(u)) for u in unbalance])
        solution = mp.lu_solve(dynamic, right)
        return np.array([complex(solution[i]) for i in range(mass.rows)])


class RunUp:
    """A Laval rotor from rest through its resonance, phi = w0 t + a t^2/2, eccentricity 1.

    With u = e^{i phi} the imposed acceleration is -u''. Duhamel's integral over each of the two exponentials e^{lambda t} is
    integrated by parts twice, which leaves J = int_0^t e^{lambda (t - tau)} u(tau) dtau: an error function of complex argument.
    """

    def __init__(self, frequency, ratio, speeds, duration):
        with mp.workdps(DIGITS):
            omega = 2 * mp.pi * mp.mpf(frequency)
            decay = mp.mpf(ratio) * omega
            turning = mp.sqrt(omega**2 - decay**2)
            self.rates = (mp.mpc(-decay, turning), mp.mpc(-decay, -turning))
            self.first = 2 * mp.pi * mp.mpf(speeds[0])
            self.rise = 2 * mp.pi * (mp.mpf(speeds[1]) - mp.mpf(speeds[0])) / mp.mpf(duration)

    def rotation(self, t):
        """u and u' at time t."""
        u = mp.expj(self.first * t + self.rise * t**2 / 2)
        return u, mp.mpc(0, 1) * (self.first + self.rise * t) * u

    def _duhamel(self, rate, t):
        b, q = mp.mpc(0, 1) * self.first - rate, mp.mpc(0, 1) * self.rise / 2
        root = mp.sqrt(-q)
        edges = mp.erf(root * (t + b / (2 * q))) - mp.erf(root * b / (2 * q))
        j = mp.exp(rate * t - b**2 / (4 * q)) * mp.sqrt(mp.pi) / (2 * root) * edges
        (u, v), (u_0, v_0), decayed = self.rotation(t), self.rotation(mp.mpf(0)), mp.exp(rate * t)
        return -v + decayed * v_0 - rate * (u - decayed * u_0 + rate * j)

    def at(self, t):
        """r / eccentricity at time t, complex."""
        with mp.workdps(DIGITS):
            t = mp.mpf(t)
            one, two = self.rates
            return complex((self._duhamel(one, t) - self._duhamel(two, t)) / (one - two))

    def by_quadrature(self, t):
        """The same by numerical quadrature of Duhamel's integral as it stands (for short times)."""
        with mp.workdps(25):
            t = mp.mpf(t)
            one, two = self.rates

            def integrand(tau):
                u, v = self.rotation(tau)
                imposed = -(mp.mpc(0, 1) * self.rise * u + mp.mpc(0, 1) * (self.first + self.rise * tau) * v)
                return (mp.exp(one * (t - tau)) - mp.exp(two * (t - tau))) / (one - two) * imposed

            return complex(mp.quad(integrand, mp.linspace(0, t, 41)))
