"""The whirl condition (W) of one pressed set over a parameter: a curve in the space of its unknowns and that parameter.

With N_j = k_j s_j m_j cot(theta), the m_j adding up to 1, (W) of docs/users/physics.md section 3.10 reads

    H f + d = 0,   f_j = c_j k_j s_j m_j cos(theta) u_j,   d_j = s_j (sin(theta) + m_j cos(theta)) u_j.

It is regular where all forces pass beyond all bounds, theta = 0; multiplied by (H + Z)^-1, with a compliance Z of the size of H,
also where they vanish at a pole of H, theta = pi/2. The set is pressed in between. Of one contact tan(theta) = k_C s/F_N. A
point is [Psi in rad/s, theta, m_1 .. m_(n-1), phi_2 .. phi_n, parameter], points are (m, 2 n + 1).
"""

import contextlib
from collections.abc import Callable
from dataclasses import replace
from math import tau as TWO_PI
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.paper.receptance import transposed
from rsc.analysis.several.condition import Pressed, Whirling, pressed
from rsc.system.system import System, together

Points = NDArray[np.float64]

# sizes of a step of length 1: of Psi and cos(theta) in shares of themselves, of the m_j, and of the phases in rad
_STEP_PSI, _STEP_FORCE, _STEP_M, _STEP_PHI = 0.05, 0.5, 0.2, 0.3
_FORCELESS = 1e-6  # cos(theta) below which such a step is no smaller
_DIFFERENCE = 1e-7  # of the range of the parameter
_NEWTON_STEPS = 8
_SETTLED = 1e-7  # a step of this length leaves the square of it


class WhirlCurve:
    """(W) of a pressed set of contacts over a parameter.

    Parameters
    ----------
    at : function, value of the parameter -> (System, rotor speed in Hz)
    contacts : tuple of int, the pressed contacts
    low, high : float, range of the parameter
    """

    def __init__(self, at: Callable[[float], tuple[System, float]], contacts: tuple[int, ...], low: float, high: float) -> None:
        self.at, self.contacts, self.low, self.high = at, contacts, low, high
        self.n = len(contacts)
        self._difference = _DIFFERENCE * max(high - low, abs(high), abs(low))
        self._constant: tuple[System, Pressed] | None = None

    def systems(self, values: NDArray[np.float64]) -> tuple[list[System], NDArray[np.float64]]:
        """The systems at some values of the parameter and their rotor speeds (m,) in Hz."""
        systems, speeds = zip(*(self.at(value) for value in values.tolist()), strict=True)
        return list(systems), np.array(speeds)

    def pressed(self, values: NDArray[np.float64]) -> Pressed:
        """The `Pressed` of the set at some values, a stack of them."""
        systems, speeds = self.systems(values)
        system, Omega = together(systems), TWO_PI * speeds
        if system.follows or system.rotor.mass.ndim > 2:
            return pressed(system, Omega, self.contacts)
        if self._constant is None or self._constant[0] is not system:
            self._constant = system, pressed(system, 0.0, self.contacts)
        return replace(self._constant[1], Omega=Omega)

    def pressed_at(self, value: float) -> Pressed:
        """The `Pressed` of the set at one value."""
        system, speed = self.at(value)
        return pressed(system, TWO_PI * speed, self.contacts)

    def points(self, whirls: Whirling, value: float) -> Points:
        """Whirls at a value of the parameter as points."""
        own = self.pressed(np.array([value]))
        parts = whirls.N / (own.stiffness * own.gap)
        total = parts.sum(axis=1, keepdims=True)
        values, m = np.full(len(whirls.Psi), value), parts / total
        return np.column_stack([whirls.Psi, np.arctan(1.0 / total), m[:, :-1], whirls.phi[:, 1:], values])

    def whirls(self, points: Points) -> Whirling:
        """Frequencies, forces and phases at points."""
        own = self.pressed(points[:, -1])
        m, phi = self._parts(points)
        with np.errstate(divide="ignore"):
            N = own.stiffness * own.gap * m / np.tan(points[:, 1:2])
        return Whirling(points[:, 0], N, np.angle(np.exp(1j * phi)))

    def held(self, points: Points) -> NDArray[np.float64]:
        """(m,), positive where every contact of the set is pressed: the least of sin(2 theta) and, of several, the m_j."""
        force = np.sin(2.0 * points[:, 1])
        return force if self.n == 1 else np.minimum(force, self._parts(points)[0].min(axis=1))

    def unwrapped(self, points: Points) -> Points:
        """Points (n, k) of one curve with angles that go on from one to the next: phases by turns, and theta by half ones."""
        points = points.copy()
        points[:, 1] = np.unwrap(points[:, 1], period=np.pi)
        points[:, self.n + 1 : -1] = np.unwrap(points[:, self.n + 1 : -1], axis=0)
        return points

    def apart(self, one: Points, other: Points) -> Points:
        """Differences of the unknowns that tell points apart, in steps: not theta, which follows from the others."""
        n, apart = self.n, (one - other)[..., :-1]
        turn = apart[..., n + 1 :]
        apart[..., n + 1 :] = np.angle(np.exp(1j * turn)) if n > 1 else turn
        return np.delete(apart / self.scale(np.broadcast_to(other, one.shape), 1.0)[..., :-1], 1, axis=-1)

    def _parts(self, points: Points) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """m (m, n) and phi (m, n)."""
        first = points[:, 2 : self.n + 1]
        m = np.concatenate([first, 1.0 - first.sum(axis=1, keepdims=True)], axis=1)
        return m, np.concatenate([np.zeros((len(points), 1)), points[:, self.n + 1 : -1]], axis=1)

    def evaluated(self, points: Points, towards: float) -> tuple[Points, NDArray[np.float64]]:
        """What is left of (W) (m, 2 n), and its derivatives (m, 2 n, 2 n + 1), that by the parameter from a difference towards a
        value."""
        step = np.where(points[:, -1] < towards, self._difference, -self._difference)
        own, beyond = self.pressed(points[:, -1]), self.pressed(points[:, -1] + step)
        (m, phi), cos, sin = self._parts(points), np.cos(points[:, 1:2]), np.sin(points[:, 1:2])
        u, each = np.exp(1j * phi), np.eye(self.n)
        H, H_slope, H_by_p = _receptances(own, beyond, points[:, 0], step)
        # force and gap of every contact, (n,) or (m, n), and by how much they change with the parameter
        push, gap = own.turn * own.stiffness * own.gap, own.gap
        push_by_p = (beyond.turn * beyond.stiffness * beyond.gap - push) / step[:, None]
        gap_by_p = (beyond.gap - gap) / step[:, None]
        pressed, deflected = m * cos * u, (sin + m * cos) * u
        f, d, size = push * pressed, gap * deflected, np.abs(push)
        Z = -1j * size / push * np.abs(d) / np.maximum(np.abs(f), _FORCELESS * size)
        G = _inverse(H + each * Z[:, None, :])
        GH, through = G @ H, _applied(G, Z * f - d)

        def over_force(f: NDArray[Any], d: NDArray[Any]) -> NDArray[Any]:
            return (_applied(GH, f) + _applied(G, d)) / size

        left = over_force(f, d)
        by_Psi = _applied(G, _applied(H_slope, through)) / size
        by_theta = over_force(-push * m * sin * u, gap * (cos - m * sin) * u)
        by_p = _applied(G, _applied(H_by_p, through)) / size + over_force(push_by_p * pressed, gap_by_p * deflected)
        by_m = (GH * push[..., None, :] + G * gap[..., None, :]) * (cos * u)[:, None, :] / size[..., :, None]
        by_phi = 1j * (GH * f[:, None, :] + G * d[:, None, :]) / size[..., :, None]
        parts = [by_Psi[:, :, None], by_theta[:, :, None], by_m[:, :, :-1] - by_m[:, :, -1:], by_phi[:, :, 1:], by_p[:, :, None]]
        slopes = np.concatenate(parts, axis=2)
        return np.concatenate([left.real, left.imag], axis=1), np.concatenate([slopes.real, slopes.imag], axis=1)

    def scale(self, points: Points, width: float) -> Points:
        """How much of every unknown a step of length 1 is; width : of the parameter."""
        n, scale = self.n, np.empty(points.shape)
        scale[..., 0] = _STEP_PSI * np.abs(points[..., 0])
        scale[..., 1] = _STEP_FORCE * np.maximum(np.abs(np.cos(points[..., 1])), _FORCELESS)
        scale[..., 2 : n + 1], scale[..., n + 1 : -1], scale[..., -1] = _STEP_M, _STEP_PHI, width
        return scale

    def tangents(self, slopes: NDArray[np.float64], scale: Points) -> Points:
        """Unit tangents in steps of the scale, given the derivatives. Along a curve they turn steadily: the determinant of the
        derivatives and the tangent is positive, and neighbouring curves run against each other."""
        scaled = slopes * scale[:, None, :]
        sound = np.isfinite(scaled).all(axis=(1, 2))
        scaled[~sound] = 0.0
        tangents = np.linalg.svd(scaled)[2][:, -1]
        sign = np.linalg.slogdet(np.concatenate([scaled, tangents[:, None, :]], axis=1))[0]
        tangents *= np.where(sign < 0.0, -1.0, 1.0)[:, None]
        tangents[~sound] = np.nan
        return tangents

    def corrected(self, guess: Points, rows: Points, scale: Points, towards: float) -> tuple[Points, NDArray[np.bool_]]:
        """Newton's method across some directions.

        Parameters
        ----------
        guess : (m, 2 n + 1)
        rows : (m, 2 n + 1), in steps of the scale: along them a point stays where its guess is
        scale, towards : as elsewhere

        Returns
        -------
        points : (m, 2 n + 1)
        met : (m,) bool
        """
        points, met = guess.copy(), np.zeros(len(guess), bool)
        active = np.arange(len(guess))
        for _ in range(_NEWTON_STEPS):
            left, slopes = self.evaluated(points[active], towards)
            along = (rows[active] * (points[active] - guess[active]) / scale[active]).sum(axis=1)
            matrix = np.concatenate([slopes * scale[active][:, None, :], rows[active][:, None, :]], axis=1)
            steps = solved(matrix, -np.concatenate([left, along[:, None]], axis=1))
            size = np.abs(steps).max(axis=1)
            points[active] += scale[active] * np.where(np.isfinite(steps), steps, 0.0)
            points[active, -1] = np.clip(points[active, -1], self.low, self.high)  # beyond the range there may be no scene
            met[active] = size < _SETTLED
            # what goes further than any step is lost
            active = active[(size >= _SETTLED) & (size < 1e3) & (points[active, 0] * guess[active, 0] > 0.0)]
            if not len(active):
                break
        return points, met


def _receptances(
    own: Pressed, beyond: Pressed, Psi: NDArray[np.float64], step: NDArray[np.float64]
) -> tuple[NDArray[np.complex128], ...]:
    """H, dH/dPsi and dH/dp (m, n, n), p the parameter, given the `Pressed` a step of it further on: A is smooth in the
    parameter, while H may be beside a pole."""
    solved = own.solved(Psi)
    by_Psi = own.bodies.by_frequency(own.Omega) @ solved - 2.0 * Psi[:, None, None] * (own.bodies.mass @ solved)
    by_p = (beyond.dynamic_stiffness(Psi) - own.dynamic_stiffness(Psi)) @ solved / step[:, None, None]
    left, moved = own.left(Psi, solved), beyond.rows - own.rows
    rows_by_p = (moved @ solved + left @ transposed(moved)) / step[:, None, None]
    return own.rows @ solved, -left @ by_Psi, rows_by_p - left @ by_p


def _inverse(matrices: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Inverses (m, n, n); not a number where there is none."""
    if matrices.shape[-1] == 1:
        with np.errstate(divide="ignore", invalid="ignore"):
            return 1.0 / matrices
    made = np.full(matrices.shape, np.nan + 0j)
    for i in np.flatnonzero(np.isfinite(matrices).all(axis=(1, 2))):
        with contextlib.suppress(np.linalg.LinAlgError):
            made[i] = np.linalg.inv(matrices[i])
    return made


def _applied(matrices: NDArray[Any], vectors: NDArray[Any]) -> NDArray[Any]:
    return (matrices @ vectors[:, :, None])[:, :, 0]


def solved(matrices: NDArray[np.float64], right: Points) -> Points:
    """Solutions (m, k) of (m, k, k) matrices; not a number where one is singular."""
    sound = np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(right).all(axis=1)
    steps = np.full(right.shape, np.nan)
    try:
        steps[sound] = np.linalg.solve(matrices[sound], right[sound][:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        for i in np.flatnonzero(sound):
            try:
                steps[i] = np.linalg.solve(matrices[i], right[i])
            except np.linalg.LinAlgError:
                continue
    return steps
