"""The best prediction for the whirl that each window of a run follows: the whole unbalance and the lag of a moving whirl."""

import itertools
from collections.abc import Sequence
from math import tau as TWO_PI
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.balance.balance import HARMONICS, Balance, balance, balance_rolling
from rsc.analysis.balance.elliptic_whirl import EllipticWhirl, elliptic_whirl
from rsc.analysis.balance.floquet import balance_growth
from rsc.analysis.balance.problem import NotBalanced
from rsc.analysis.follow.lag import lag
from rsc.analysis.paper.rolling import Roll
from rsc.measure.windows import Best, Features, Followed, same_branch
from rsc.system.system import System

# windows from one harmonic balance to the next; another is made between two whose corrections are less alike than this
STRIDE, ALIKE = 8, 2e-3
# a whirl that lags by less, or whose amplitude the unbalance changes by less, decays as without unbalance for all that matters
SMALL_LAG, SAME_AMPLITUDE = 0.01, 0.005
# what the balance corrects, each as a ratio to its first order
CORRECTED = ("frequency", "amplitude", "stator_amplitude", "synchronous", "force")

Correction = NDArray[np.float64]  # (5,) ratios of `CORRECTED`
# (n,) time in s, rotor speed and whirl frequency in rad/s, normal force in N along a stretch
Whirling = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def best_predictions(system: System, features: Features, pairs: Sequence[Followed | None]) -> Best:
    """Predictions with the whole unbalance and with lag, for the windows of a run that follow a whirl.

    Parameters
    ----------
    system : System
    features : Features
    pairs : (n_w,) of `rsc.measure.windows.followed`

    Returns
    -------
    Best
    """
    values = vars(no_predictions(len(pairs)))
    first = 0
    while first < len(pairs):
        end = first + 1
        while same_branch(pairs, first, end):
            end += 1
        whirls = [pair.whirl for pair in pairs[first:end] if pair is not None]
        if whirls:
            place = slice(first, end)
            for name, column in _of_stretch(system, features.time[place], TWO_PI * features.speed[place], whirls).items():
                values[name][place] = column
        first = end
    return Best(**values)


def no_predictions(n_windows: int) -> Best:
    """Nothing better than the first order in the unbalance in any of some windows."""
    return Best(**{name: np.full(n_windows, np.nan) for name in Best.__dataclass_fields__})


def _of_stretch(
    system: System, time: NDArray[np.float64], Omega: NDArray[np.float64], whirls: Sequence[Any]
) -> dict[str, NDArray[np.float64]]:
    """Fields of `Best` for consecutive windows on one whirl."""
    balanced = _Balanced(system, whirls)
    ratio = balanced.corrections()
    known = np.isfinite(ratio)
    frequency, amplitude, stator, synchronous, force = (np.where(known, ratio, 1.0) * balanced.first_order).T
    whirl = time, Omega, TWO_PI * frequency, force
    behind = _lags(system, whirl, known[:, 0], np.zeros(len(time)))
    shift = balanced.shifts(behind[0])
    if shift.any():
        behind = _lags(system, whirl, known[:, 0], shift)
    rotor_lag, stator_lag, frequency_lag = behind
    return {
        "frequency": frequency + frequency_lag,
        "amplitude": amplitude * (1.0 + rotor_lag),
        "stator_amplitude": stator * (1.0 + stator_lag),
        "synchronous": np.where(known[:, 3], synchronous, np.nan),
        "reached": balanced.reached,
        "growth_rate": balanced.growth_rate,
        "lag": rotor_lag,
    }


def _lags(system: System, whirl: Whirling, known: NDArray[np.bool_], shift: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, n) lag of rotor, stator and frequency along a stretch, `rsc.analysis.follow.lag`.

    Where there is no steady whirl with the whole unbalance, a motion has nothing to lie behind: the lag begins anew there and
    behind it. `known`: (n,), where there is one.
    """
    time, speed, Psi, F_N = whirl
    behind = np.zeros((3, len(known)))
    begins = np.flatnonzero(np.diff(known, prepend=not known[0]))
    for first, end in itertools.pairwise([*begins, len(known)]):
        own = slice(first, end)
        moving = lag(system, time[own], speed[own], Psi[own], F_N[own], shift[own])
        behind[:, own] = moving.rotor, moving.stator, moving.frequency
    return behind


def rolling_motion(system: System, roll: Roll, speed: float) -> tuple[float, ...]:
    """Frequency (Hz), amplitudes of rotor and stator and the rotor's line at its speed (m) of a whirl that rolls.

    With the whole unbalance if such a motion is found, else without it and NaN for the line.
    """
    try:
        if not system.isotropic:
            raise NotBalanced("the directions differ")
        return tuple(float(value) for value in _with_unbalance(system, balance_rolling(system, roll, speed))[:4])
    except NotBalanced:
        return roll.Psi / TWO_PI, roll.rotor_amplitude, roll.stator_amplitude, np.nan


class _Balanced:
    """Harmonic balances at some windows on one whirl, interpolated to corrections for all of them."""

    def __init__(self, system: System, whirls: Sequence[Any]) -> None:
        self.system, self.whirls = system, whirls
        self.first_order = np.array([_first_order(whirl) for whirl in whirls])
        self.reached, self.growth_rate = np.full((2, len(whirls)), np.nan)
        self.motions: dict[int, Balance] = {}  # at the windows that have a balance of their own

    def corrections(self) -> NDArray[np.float64]:
        """(n, 5) ratios of `CORRECTED`, NaN where no motion with the whole unbalance was found."""
        n = len(self.whirls)
        nodes = [*range(0, n - 1, STRIDE), n - 1]
        corrections = {k: self.correction(k) for k in nodes}
        between = list(itertools.pairwise(nodes))
        ratio = np.full((n, len(CORRECTED)), np.nan)
        while between:
            a, b = between.pop()
            low, high = corrections[a], corrections[b]
            if low is not None and high is not None and np.nanmax(np.abs(high - low)) < ALIKE:
                ratio[a : b + 1] = np.linspace(low, high, b - a + 1)
            elif b - a > 1:
                middle = (a + b) // 2
                corrections[middle] = self.correction(middle)
                between += [(a, middle), (middle, b)]
        for k, own in corrections.items():
            ratio[k] = np.nan if own is None else own
        return ratio

    def correction(self, k: int) -> Correction | None:
        """Ratios of `CORRECTED` at window k, None where there is no motion with the whole unbalance.

        Where directions differ that is the elliptic whirl, without its unbalance.

        Every balance starts at the first order of its own speed: from that of another speed Newton's method can end on the
        unstable partner of the whirl.
        """
        whirl, own = self.whirls[k], self.first_order[k]
        try:
            if not self.system.isotropic:
                ellipse = _with_directions(self.system, elliptic_whirl(self.system, whirl.frequency, whirl.speed))
                return np.array([*ellipse / np.where(own[:3] == 0.0, 1.0, own[:3]), np.nan, 1.0])
            motion = balance(self.system, whirl.frequency, whirl.speed)
        except NotBalanced as failure:
            self.reached[k] = failure.reached
            return None
        self.motions[k] = motion
        if motion.contact_share < 1.0:
            self.growth_rate[k] = balance_growth(self.system, motion).rate
        return np.where(own == 0.0, 1.0, _with_unbalance(self.system, motion) / np.where(own == 0.0, 1.0, own))

    def shifts(self, behind: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) 1/s, what the unbalance adds to the growth rate of the whirls where that tells in their lag; 0 elsewhere.

        behind : (n,) lag of the rotor, without it
        """
        own = np.zeros(len(self.whirls))
        for k, motion in self.motions.items():
            amplitude = abs(motion.rotor[HARMONICS])
            if abs(behind[k]) > SMALL_LAG and abs(amplitude / self.whirls[k].rotor_amplitude - 1.0) > SAME_AMPLITUDE:
                own[k] = balance_growth(self.system, motion).rate - self.whirls[k].growth_rate
        nodes = sorted(self.motions)
        return np.interp(np.arange(len(own)), nodes, own[nodes]) if nodes else own


def _first_order(whirl: Any) -> list[float]:
    synchronous = whirl.synchronous.consistent.amplitude
    return [whirl.frequency, whirl.rotor_amplitude, whirl.stator_amplitude, synchronous, whirl.normal_force]


def _with_directions(system: System, motion: EllipticWhirl) -> NDArray[np.float64]:
    """Frequency and amplitudes of rotor and stator of a whirl without unbalance in supports whose directions differ."""
    own = motion.motion[len(motion.lines) // 2 - 1]
    return np.array([motion.frequency, motion.amplitude, abs(own[system.n_rotor :] @ system.stator.contact)])


def _with_unbalance(system: System, motion: Balance) -> NDArray[np.float64]:
    """Values of `CORRECTED` of a balance."""
    force = motion.forces[HARMONICS] / (1.0 + 1j * system.law.friction)
    lines = abs(motion.rotor[HARMONICS]), abs(motion.stator[HARMONICS]), abs(motion.rotor[HARMONICS + 1])
    return np.array([motion.frequency, *lines, force.real])
