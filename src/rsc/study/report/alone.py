"""Windows without a whirl: the line that they show where the speed passes a resonance, and how fast their motion settles."""

from math import tau as TWO_PI

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.free_vibration import free_vibrations
from rsc.analysis.alone.run_up import run_up_response
from rsc.analysis.follow.forward_rub import rub_growth
from rsc.analysis.paper.synchronous import forward_rub
from rsc.measure import spectra
from rsc.measure.kinds import Kind
from rsc.measure.windows import Features
from rsc.measure.words import SYNCHRONOUS, TOLERANCES
from rsc.system.system import System

# instants of a window at which the motion is computed
SAMPLES = 32
# windows on both sides of those in which the steady line changes: as the speed moves by half a bin from one to the next, a free
# vibration left behind is then out of reach of the line
AROUND = 8
# part of the tolerance of the line by which it may change within a window and still be taken as steady
STEADY_SHARE = 0.25
# steps of a computed motion at most: windows far apart are compared with the steady line
MOST_STEPS = 20_000


def moving_lines(system: System, features: Features, alone: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotor's line at its speed in windows without contact, with all that a changing speed does to it.

    Parameters
    ----------
    system : System
    features : Features
    alone : (n_w,) m, the steady line without contact at the speed of every window

    Returns
    -------
    (n_w,) m
        NaN where the steady line tells as much, with contact, where it would take too long, and everywhere if directions differ.
    """
    lines = np.full(len(alone), np.nan)
    if not system.isotropic:
        return lines
    free, padded = features.share == 0.0, np.pad(alone, 1, mode="edge")
    change = np.ptp([padded[:-2], alone, padded[2:]], axis=0) > STEADY_SHARE * TOLERANCES[SYNCHRONOUS] * alone
    near = np.convolve(free & change, np.ones(2 * AROUND + 1))[AROUND:-AROUND] > 0.0
    for places in _stretches(free & near):
        if np.ptp(features.time[places]) * SAMPLES < MOST_STEPS * features.window:
            lines[places] = _read(system, features, places)
    return lines


def settling_rates(system: System, features: Features) -> NDArray[np.float64]:
    """(n_w,) 1/s, slowest rate of small motions in windows without contact and of a forward rub, of
    each stretch one; NaN in others."""
    rates = np.full(len(features.speed), np.nan)
    for places in _stretches(features.share == 0.0):
        vibrations = free_vibrations(system, features.speed[places[len(places) // 2]])
        rates[places] = max(vibration.growth_rate for vibration in vibrations)
    rubs = features.kind == Kind.FORWARD_RUB if len(system.contacts) == 1 else np.zeros(len(rates), bool)  # else not predicted
    for places in _stretches(rubs):
        Omega = TWO_PI * float(features.speed[places[len(places) // 2]])
        rub = forward_rub(system, Omega)
        rates[places] = rub_growth(system, rub[-1], Omega).rate if rub else np.nan
    return rates


def _stretches(chosen: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """The places of every run of consecutive chosen windows."""
    places = np.split(np.arange(len(chosen)), np.flatnonzero(np.diff(chosen)) + 1)
    return [own for own in places if chosen[own[0]]]


def _read(system: System, features: Features, places: NDArray[np.intp]) -> NDArray[np.float64]:
    """Lines of consecutive windows, read from the computed motion as they are from a simulated one."""
    window = features.window
    centres, speeds = features.time[places], features.speed[places]
    step = window / SAMPLES
    time = np.arange(centres[0] - 0.5 * window, centres[-1] + 0.5 * window + step, step)
    motion = run_up_response(system, time)
    first = np.round((centres - 0.5 * window - time[0]) / step).astype(int)
    own = first[:, None] + np.arange(SAMPLES)
    # about the speed at the centre of each window
    speed = np.asarray(system.speed_at(time))
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * step)])
    turned = angle[own] - TWO_PI * speeds[:, None] * time[own]
    starts = SAMPLES * np.arange(len(places))
    amplitude = spectra.amplitudes((motion[own] * np.exp(1j * turned)).ravel(), starts, SAMPLES)
    fall = spectra.Waterfall(spectra.frequencies(SAMPLES, 1.0 / step), speeds, centres, amplitude, window, SAMPLES)
    return spectra.line_at(fall, 0.0).amplitude
