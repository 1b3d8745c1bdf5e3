"""The oracles of the hard dozen, each from another family than rsc's kernel: closed forms, mpmath, other integrators, statistics.

    line          exact motion between walls, eigen-solutions and roots to 40 digits (tests/support/piecewise_line.py)
    free_line, orbit  closed form without contact force; a touch 1e-9 gap deep bends it by less than 1e-7 gaps
    reference     DOP853 with fixed substeps, every switch located by bisection (bench/reference.py)
    extrapolated  extrapolated midpoint rule in extended precision, switches located (tests/support/engines.py)
    radau         scipy's Radau restarted at every located switch (tests/support/engines.py)
    energy        conservation: amplitude of every free flight, no damping anywhere
    run_up        Duhamel's integral by error functions of complex argument, 50 to 300 digits (tests/support/closed_forms.py)
    statistics    distribution of |r| of a long run of RK4 at 10 us, compared by the Kolmogorov-Smirnov distance
"""

import dataclasses
import math
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from fixed_step import fixed_step
from hard_scenes import GAP, OMEGA_R

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "bench"), str(ROOT / "tests" / "support")]

import closed_forms  # noqa: E402
from engines import Rub, _step_to_switch, by_radau  # noqa: E402
from piecewise_line import CLIPPED, Line  # noqa: E402
from problems import Problem, displacements, matrices_of, state_of  # noqa: E402
from reference import reference_run  # noqa: E402

BLOCKS = 20


class Oracle(NamedTuple):
    """`error` maps displacements (rows, n) complex on the whole output grid to one number; `limit`: above it they are wrong."""

    name: str
    own_error: float
    error: object
    limit: float
    scale: float  # m, largest displacement


def _against(name, motion, own, rtol, rows=slice(None)):
    """Largest error over the rows, over the largest displacement; wrong beyond 1000 times the tolerance."""
    scale = float(abs(motion).max())

    def error(found):
        return float(abs(found[rows][:, : motion.shape[1]] - motion).max()) / scale

    return Oracle(name, own / scale, error, 1e3 * rtol, scale)


class _Line(Line):
    """Line whose search for a switch is fine enough for the short moment when the damper would pull."""

    def _next_switch(self, motion, kind, side, left):
        if kind == CLIPPED:
            motion.fastest = (self.k / self.bodies[0][0]) ** 0.5
        return super()._next_switch(motion, kind, side, left)


def line(case):
    """Exact motion between two walls."""
    s = case.system
    rotor = float(s.rotor.mass[0, 0]), float(s.rotor.damping[0, 0]), float(s.rotor.stiffness[0, 0])
    start = [float(case.start[0].real), float(case.start[1].real)]
    rows, _ = _Line(rotor, None, (s.contact.gap, s.law.stiffness, s.law.damping)).march(start, case.time)
    return _against("exact, 40 digits", rows[:, :1].astype(complex), 0.0, case.rtol)


def free_line(case, excess):
    """A undamped oscillation that touches or just misses."""
    return _against("closed form", (GAP * (1.0 + excess) * np.sin(OMEGA_R * case.time))[:, None] + 0j, 1e-10, case.rtol)


def orbit(case, excess):
    """A circle at the gap."""
    turn = np.exp(1j * case.system.schedule_speed[0] * case.time)
    return _against("closed form", (GAP * (1.0 + excess) * turn)[:, None], 1e-10, case.rtol)


def reference(case, fastest):
    """Located DOP853; substeps so that the fastest rate, rad/s, is resolved."""
    state = state_of(_split(case, case.start))
    problem = Problem("", None, case.system, matrices_of(case.system), state, float(case.system.schedule_time[1]))
    rate = case.grid[0]
    substeps = max(12, math.ceil(fastest / rate / 0.8))
    coarse, fine = (displacements(reference_run(problem, rate, k)[0], problem) for k in (substeps, math.ceil(1.4 * substeps)))
    return _against("located DOP853", fine, abs(fine - coarse).max(), case.rtol)


class _State(NamedTuple):
    rotor: np.ndarray
    stator: np.ndarray
    rotor_velocity: np.ndarray
    stator_velocity: np.ndarray


def _split(case, z):
    n, m = case.system.n_rotor, case.system.n_stator
    return _State(z[:n], z[n : n + m], z[n + m : 2 * n + m], z[2 * n + m :])


def extrapolated(case, h_max=2e-4):
    """Extended precision, one straight piece of the schedule after the other in a frame turned by the phase it starts at.

    The own error is what halving the largest step changes.
    """
    p, runs = case.plain, []
    for h in (h_max, 0.5 * h_max):
        # off the centre, where the direction of the contact is undefined, by nothing that matters
        z, motion = case.start + 1e-25 * (np.arange(case.start.size) == 0), [case.start[None]]
        for i in range(len(p.corner_time) - 1):
            ends = p.corner_time[i : i + 2]
            piece = dataclasses.replace(case.system, schedule_time=ends - ends[0], schedule_speed=p.corner_speed[i : i + 2])
            turn = np.exp(1j * p.corner_phase[i])
            rows = _march(Rub(piece, np.longdouble, np.clongdouble), z / turn, (ends[1] - ends[0], case.grid[0]), h) * turn
            motion.append(rows)
            z = rows[-1]
        runs.append(np.concatenate(motion)[:, : z.size // 2])
    return _against("extrapolation, 80 bit", runs[1], abs(runs[1] - runs[0]).max(), case.rtol)


def _march(rub, start, span, h_max):
    """States (rows, 2n) after the start on a grid; span = (duration, rate)."""
    t, y, rows = np.longdouble(0), start.astype(np.clongdouble), []
    mode = rub.mode_at(0.0, y)
    for goal in np.arange(1, round(span[0] * span[1]) + 1, dtype=np.longdouble) / span[1]:
        while t < goal:
            h = min(np.longdouble(h_max), goal - t)
            new, left, entered = _step_to_switch(rub, t, y, mode, h)
            t, y = (goal if left == goal - t else t + left), new
            if entered is not None:
                mode = rub.mode_at(t, y, entered)
        rows.append(y)
    return np.array(rows).astype(complex)


def radau(case):
    """Implicit, for stiff friction; the own error is what a tenfold tolerance changes."""
    runs = [np.hstack(by_radau(case.system, _split(case, case.start), case.time, rtol)[:2]) for rtol in (1e-7, 1e-8)]
    return _against("located Radau", runs[1], abs(runs[1] - runs[0]).max(), case.rtol)


def energy(case):
    """Energy after many impacts, by the amplitude of the last free flights; wrong beyond 1000 rtol per 100 impacts."""
    rate, rows = case.grid
    gap, v0 = case.system.contact.gap, abs(case.start[1])
    step = OMEGA_R / rate
    own_amplitude = v0 / OMEGA_R
    mass, k_r, k_c = float(case.system.rotor.mass[0, 0]), float(case.system.rotor.stiffness[0, 0]), case.system.law.stiffness
    flight = 2.0 * math.asin(gap / own_amplitude) / OMEGA_R
    touch = _contact_time(mass, k_r, k_c, gap, own_amplitude)
    impacts = case.time[-1] / (flight + touch)

    def error(found):
        x = found[-rows // 10 :, 0].real
        a, b = x[:-1], x[1:]
        free = (abs(a) < 0.98 * gap) & (abs(b) < 0.98 * gap)
        amplitude2 = (a**2 + b**2 - 2.0 * a * b * math.cos(step)) / math.sin(step) ** 2
        drift = np.median(amplitude2[free]) / own_amplitude**2 - 1.0 if free.any() else math.inf
        return abs(float(drift)) * 100.0 / impacts

    return Oracle(f"conservation, {impacts:.0f} impacts", 0.0, error, 1e3 * case.rtol, 1.1 * gap)


def _contact_time(mass, k_r, k_c, gap, amplitude):
    """Time from touch to release of an elastic wall."""
    omega = math.sqrt((k_r + k_c) / mass)
    rest = k_c * gap / (k_r + k_c)
    velocity = OMEGA_R * math.sqrt(amplitude**2 - gap**2)
    return 2.0 * math.atan2(velocity / omega, gap - rest) / omega


def run_up(case):
    """Run-up or coast-down without contact, at 400 of the times."""
    s = case.system
    omega = math.sqrt(float(s.rotor.stiffness[0, 0]))
    ratio = float(s.rotor.damping[0, 0]) / (2.0 * omega)
    speeds = s.schedule_speed / (2.0 * np.pi)
    exact = closed_forms.RunUp(omega / (2.0 * np.pi), ratio, speeds, s.schedule_time[1])
    rows = np.unique(np.linspace(1, case.time.size - 1, 100).astype(int))
    ecc = abs(s.rotor.unbalance[0]) / float(s.rotor.mass[0, 0])
    # parts of size e^(decay rate (Omega + omega) / rise) cancel
    rise = abs(speeds[1] - speeds[0]) / s.schedule_time[1]
    closed_forms.DIGITS = 50 + int((speeds.max() + omega / (2.0 * np.pi)) * ratio * omega / rise / math.log(10.0))
    motion = np.array([[ecc * exact.at(case.time[i])] for i in rows])
    return _against("closed form (erf)", motion, 0.0, case.rtol, rows)


def statistics(case):
    """Distribution of |r| once per sample after a tenth of the run."""
    rows = case.grid[1]
    long = fixed_step("RK4", case.plain, case.start, 1e-5, case.grid, 60.0)
    assert long.end == "finished"
    known = abs(long.states[rows // 10 :, 0])
    limit = block_bootstrap(known)

    def error(found):
        return ks_distance(abs(found[rows // 10 :, 0]), known)

    return Oracle("statistics, RK4 at 10 us", 0.0, error, limit, float(known.max()))


def ks_distance(a, b):
    """Kolmogorov-Smirnov distance of two samples."""
    a, b = np.sort(a), np.sort(b)
    at = np.concatenate([a, b])
    return float(abs(np.searchsorted(a, at, "right") / a.size - np.searchsorted(b, at, "right") / b.size).max())


def block_bootstrap(values, blocks=BLOCKS, draws=400, alarm=0.01, seed=1):
    """KS distance that two runs of the same process exceed with probability `alarm`: blocks of one run drawn with replacement."""
    generator = np.random.default_rng(seed)
    pieces_ = np.array_split(values[:: max(1, values.size // 20_000)], blocks)
    found = []
    for _ in range(draws):
        one, two = (np.concatenate([pieces_[i] for i in generator.integers(0, blocks, blocks)]) for _ in range(2))
        found.append(ks_distance(one, two))
    return float(np.quantile(found, 1.0 - alarm))


ORACLES = {f.__name__: f for f in (line, free_line, orbit, reference, extrapolated, radau, energy, run_up, statistics)}
