"""The yardstick: textbook Dormand-Prince 5(4) in Numba, dense matrices, kinks ignored, dense output; no trick of rsc's kernel.

The right-hand side stands inside the stage loop (Numba inlines nothing better by a call); the 1+1 problems have it written out in
scalars, as anyone would for eight states, the others multiply their matrices.
"""

import math

import numba
import numpy as np
from scipy.integrate import RK45

from driven import DrivenMatrices, right_hand_side_driven

A = np.zeros((7, 7))
A[:6, :5] = RK45.A
A[6, :6] = RK45.B
C = np.append(RK45.C, 1.0)
E = RK45.E.copy()
# weights of the continuous extension of dopri5 (Hairer, Norsett, Wanner), as a correction to the cubic Hermite interpolant
D = np.array([-12715105075 / 11282082432, 0.0, 87487479700 / 32700410799, -10690763975 / 1880347072,
              701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423])  # fmt: skip


@numba.njit(error_model="numpy")
def right_hand_side(m, t, y, out):
    """dy/dt for any numbers of coordinates."""
    n, k = m.stiffness_r.shape[0], m.stiffness_s.shape[0]
    half = 2 * (n + k)
    phi = m.omega * t + 0.5 * m.omega_dot * t * t
    omega = m.omega + m.omega_dot * t
    c, s = math.cos(phi), math.sin(phi)
    u_y = omega * omega * c + m.omega_dot * s
    u_z = omega * omega * s - m.omega_dot * c
    for i in range(half):
        out[i] = y[half + i]
    for i in range(n):
        a_y, a_z = m.unbalance[i] * u_y, m.unbalance[i] * u_z
        for j in range(n):
            a_y -= m.stiffness_r[i, j] * y[j] + m.damping_r[i, j] * y[half + j]
            a_z -= m.stiffness_r[i, j] * y[n + j] + m.damping_r[i, j] * y[half + n + j]
        out[half + i] = a_y
        out[half + n + i] = a_z
    for i in range(k):
        a_y, a_z = 0.0, 0.0
        for j in range(k):
            a_y -= m.stiffness_s[i, j] * y[2 * n + j] + m.damping_s[i, j] * y[half + 2 * n + j]
            a_z -= m.stiffness_s[i, j] * y[2 * n + k + j] + m.damping_s[i, j] * y[half + 2 * n + k + j]
        out[half + 2 * n + i] = a_y
        out[half + 2 * n + k + i] = a_z
    r, q = m.i_r, 2 * n + m.i_s
    d_y, d_z = y[r] - y[q], y[n + r] - y[q + k]
    distance = math.sqrt(d_y * d_y + d_z * d_z)
    delta = m.gap - distance
    if delta < 0.0:
        v_y, v_z = y[half + r] - y[half + q], y[half + n + r] - y[half + q + k]
        delta_dot = -(d_y * v_y + d_z * v_z) / distance
        force = max(0.0, -m.k_c * delta - m.b_c * max(delta_dot, 0.0))
        f_y = force * (d_y - m.friction * d_z) / distance
        f_z = force * (d_z + m.friction * d_y) / distance
        out[half + r] -= f_y * m.per_mass_r
        out[half + n + r] -= f_z * m.per_mass_r
        out[half + q] += f_y * m.per_mass_s
        out[half + q + k] += f_z * m.per_mass_s


@numba.njit(error_model="numpy")
def right_hand_side_1_1(m, t, y, out):
    """dy/dt of one rotor and one stator mass, in scalars."""
    phi = m.omega * t + 0.5 * m.omega_dot * t * t
    omega = m.omega + m.omega_dot * t
    c, s = math.cos(phi), math.sin(phi)
    ecc, k_r, b_r, k_s, b_s = m.unbalance[0], m.stiffness_r[0, 0], m.damping_r[0, 0], m.stiffness_s[0, 0], m.damping_s[0, 0]
    d_y, d_z = y[0] - y[2], y[1] - y[3]
    f_y, f_z = 0.0, 0.0
    distance = math.sqrt(d_y * d_y + d_z * d_z)
    delta = m.gap - distance
    if delta < 0.0:
        delta_dot = -(d_y * (y[4] - y[6]) + d_z * (y[5] - y[7])) / distance
        force = max(0.0, -m.k_c * delta - m.b_c * max(delta_dot, 0.0))
        f_y = force * (d_y - m.friction * d_z) / distance
        f_z = force * (d_z + m.friction * d_y) / distance
    out[0], out[1], out[2], out[3] = y[4], y[5], y[6], y[7]
    out[4] = ecc * (omega * omega * c + m.omega_dot * s) - k_r * y[0] - b_r * y[4] - f_y * m.per_mass_r
    out[5] = ecc * (omega * omega * s - m.omega_dot * c) - k_r * y[1] - b_r * y[5] - f_z * m.per_mass_r
    out[6] = -k_s * y[2] - b_s * y[6] + f_y * m.per_mass_s
    out[7] = -k_s * y[3] - b_s * y[7] + f_z * m.per_mass_s


@numba.njit(error_model="numpy")
def right_hand_side_turning(m, t, y, out):
    """dy/dt with gyroscopics and perhaps a rigid stator: the general case behind the two above."""
    n, k = m.stiffness_r.shape[0], m.stiffness_s.shape[0]
    half = 2 * (n + k)
    phi = m.omega * t + 0.5 * m.omega_dot * t * t
    omega = m.omega + m.omega_dot * t
    c, s = math.cos(phi), math.sin(phi)
    for i in range(half):
        out[i] = y[half + i]
    for i in range(n):
        a_y = m.unbalance[i] * omega * omega * c + m.euler[i] * m.omega_dot * s
        a_z = m.unbalance[i] * omega * omega * s - m.euler[i] * m.omega_dot * c
        for j in range(n):
            v_y, v_z, gyro = y[half + j], y[half + n + j], omega * m.gyroscopic_r[i, j]
            a_y -= m.stiffness_r[i, j] * y[j] + m.damping_r[i, j] * v_y + gyro * v_z
            a_z -= m.stiffness_r[i, j] * y[n + j] + m.damping_r[i, j] * v_z - gyro * v_y
        out[half + i] = a_y
        out[half + n + i] = a_z
    for i in range(k):
        a_y, a_z = 0.0, 0.0
        for j in range(k):
            a_y -= m.stiffness_s[i, j] * y[2 * n + j] + m.damping_s[i, j] * y[half + 2 * n + j]
            a_z -= m.stiffness_s[i, j] * y[2 * n + k + j] + m.damping_s[i, j] * y[half + 2 * n + k + j]
        out[half + 2 * n + i] = a_y
        out[half + 2 * n + k + i] = a_z
    r, q = m.i_r, 2 * n + m.i_s
    d_y, d_z, v_y, v_z = y[r], y[n + r], y[half + r], y[half + n + r]
    if k > 0:
        d_y, d_z, v_y, v_z = d_y - y[q], d_z - y[q + k], v_y - y[half + q], v_z - y[half + q + k]
    distance = math.sqrt(d_y * d_y + d_z * d_z)
    delta = m.gap - distance
    if delta < 0.0:
        force = max(0.0, -m.k_c * delta - m.b_c * max(-(d_y * v_y + d_z * v_z) / distance, 0.0))
        f_y = force * (d_y - m.friction * d_z) / distance
        f_z = force * (d_z + m.friction * d_y) / distance
        out[half + r] -= f_y * m.per_mass_r
        out[half + n + r] -= f_z * m.per_mass_r
        if k > 0:
            out[half + q] += f_y * m.per_mass_s
            out[half + q + k] += f_z * m.per_mass_s


def right_hand_side_of(matrices):
    """The shortest of the right-hand sides that a problem needs."""
    if isinstance(matrices, DrivenMatrices):
        return right_hand_side_driven
    if not matrices.plain:
        return right_hand_side_turning
    return right_hand_side_1_1 if matrices.stiffness_r.size == matrices.stiffness_s.size == 1 else right_hand_side


def _stepper(f):  # noqa: C901 - the textbook loop in one piece, on purpose
    # compiled together with f, so that LLVM merges it into the stage loop
    @numba.njit(error_model="numpy")
    def run(m, start, duration, rate, tol, out):  # noqa: C901
        """Returns (accepted, rejected) steps; out gets the state on the output grid."""
        n = start.shape[0]
        y, stage, y_new, dense = start.copy(), np.empty(n), np.empty(n), np.empty((5, n))
        k = np.empty((7, n))
        atol_x, atol_v = tol * m.gap, tol * 300.0 * m.gap
        t, h = 0.0, 1e-5
        f(m, t, y, k[0])
        row, accepted, rejected = 0, 0, 0
        while t < duration:
            h = min(h, duration - t)
            for s in range(1, 7):
                for i in range(n):
                    total = 0.0
                    for j in range(s):
                        total += A[s, j] * k[j, i]
                    stage[i] = y[i] + h * total
                f(m, t + C[s] * h, stage, k[s])
            y_new[:] = stage
            norm = 0.0
            for i in range(n):
                error = 0.0
                for j in range(7):
                    error += E[j] * k[j, i]
                scale = (atol_x if 2 * i < n else atol_v) + tol * max(abs(y[i]), abs(y_new[i]))
                norm += (h * error / scale) ** 2
            norm = math.sqrt(norm / n)
            if norm <= 1.0:
                if row < out.shape[0] and row / rate <= t + h:
                    for i in range(n):
                        total = 0.0
                        for j in range(7):
                            total += D[j] * k[j, i]
                        dense[0, i] = y[i]
                        dense[1, i] = y_new[i] - y[i]
                        dense[2, i] = h * k[0, i] - dense[1, i]
                        dense[3, i] = dense[1, i] - h * k[6, i] - dense[2, i]
                        dense[4, i] = h * total
                    while row < out.shape[0] and row / rate <= t + h:
                        u = (row / rate - t) / h
                        w = 1.0 - u
                        for i in range(n):
                            inner = dense[2, i] + u * (dense[3, i] + w * dense[4, i])
                            out[row, i] = dense[0, i] + u * (dense[1, i] + w * inner)
                        row += 1
                t += h
                for i in range(n):
                    y[i] = y_new[i]
                    k[0, i] = k[6, i]
                accepted += 1
            else:
                rejected += 1
            h *= min(5.0, max(0.2, 0.9 * norm**-0.2)) if norm > 0.0 else 5.0
        return accepted, rejected

    return run


MARCHES = {f: _stepper(f) for f in (right_hand_side_1_1, right_hand_side, right_hand_side_turning, right_hand_side_driven)}


def naive_run(problem, tol, rate):
    """(states on the output grid, accepted, rejected)."""
    rows = round(problem.duration * rate) + 1
    out = np.zeros((rows, problem.start.size))
    run = MARCHES[right_hand_side_of(problem.matrices)]
    accepted, rejected = run(problem.matrices, problem.start, problem.duration, rate, tol, out)
    return out, accepted, rejected
