"""The motion in which a run ends, told from signals that are known."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from rsc.measure import spectra
from rsc.measure.final import final_motion, final_motions
from rsc.results.summary import Status

RATE, SPEED, GAP = 2000.0, 50.0, 1e-3
TIME = np.arange(4001) / RATE


@dataclass
class Signal:
    """A run made of circles."""

    motion: np.ndarray
    normal_force: np.ndarray
    tangential_velocity: np.ndarray
    speed: np.ndarray
    scene: object
    time: np.ndarray
    status: str = "finished"

    def contact_rotor(self):
        return self.motion


def run(lines, share=1.0, diameter=None, slip=0.0, samples=None):
    """Circles {Hz: m}, in contact for a share of the time."""
    motion = sum(size * np.exp(2j * np.pi * frequency * TIME) for frequency, size in lines.items())
    force = np.where(np.arange(len(TIME)) % 100 < 100 * share, 7.0, 0.0)
    contact = SimpleNamespace(gap=GAP, diameter=diameter, slip_velocity=0.01)
    tangential = np.full(len(TIME), slip - (np.pi * SPEED * diameter if diameter else 0.0))
    arrays = (motion, force, tangential, np.full(len(TIME), SPEED))
    scene = SimpleNamespace(contact=contact, output=SimpleNamespace(rate=RATE))
    return Signal(*(array[:samples] for array in arrays), scene, TIME[:samples])


@pytest.mark.parametrize(
    ("signal", "word"),
    [
        (run({50.0: 1e-4}, share=0.0), "no contact"),
        (run({-37.3: 2e-3, 50.0: 1e-4}), "backward whirl"),
        (run({-37.3: 2e-3, 50.0: 1e-4}, share=0.0), "no contact"),
        (run({50.0: 1.2e-3}), "forward rub"),
        (run({50.0: 1.2e-3, -37.3: 1.5e-5}), "forward rub"),  # 1.5 % of the gap, beside a motion that is clearly forward
        (run({50.0: 1.2e-3, -37.3: 5e-5}), "backward whirl"),
        (run({50.0: 1.0e-3}, share=0.4), "intermittent contact"),
        (run({50.0: 1.0e-3, -50.0: 4e-4}, share=0.4), "intermittent contact"),  # an ellipse
        (run({50.0: 4e-4, -50.0: 1e-3}, share=0.4), "intermittent contact"),  # one that turns backward, between two resonances
        (run({50.0: 1.2e-3, -50.0: 4e-4}), "forward rub"),
        (run({50.0: 4e-4, -50.0: 2e-3}), "backward whirl"),  # one that has the rotor speed by chance
        (run({50.0: 1.0e-3, -52.0: 4e-4}, share=0.4), "backward whirl"),
        (run({-37.3: 2e-3}, diameter=0.1, slip=0.005), "rolling"),
        (run({-37.3: 2e-3}, diameter=0.1, slip=0.5), "backward whirl"),
        (run({-37.3: 2e-3}, samples=10), "unknown"),
        (run({-37.3: np.nan}), "unknown"),
    ],
)
def test_a_motion_has_its_word(signal, word):
    assert final_motion(signal).motion == word


@pytest.mark.parametrize("samples", [10, None])
def test_a_run_that_diverged_ran_away(samples):
    signal = run({-37.3: 2e3}, samples=samples)
    signal.status = Status.DIVERGED
    assert final_motion(signal).motion == "runs away"


def test_the_numbers_are_those_of_the_last_window():
    signal = run({-37.3: 2e-3, 50.0: 1e-4}, share=0.4)
    motion = final_motion(signal)
    assert motion.backward_frequency == pytest.approx(-37.3, abs=1e-3)
    assert motion.backward_amplitude == pytest.approx(2e-3, rel=1e-4)
    assert motion.synchronous_amplitude == pytest.approx(1e-4, rel=1e-3)
    assert (motion.amplitude_min, motion.amplitude_max) == pytest.approx((1.9e-3, 2.1e-3), rel=1e-3)
    assert (motion.force_max, motion.force_mean, motion.contact_share) == (7.0, pytest.approx(2.8), pytest.approx(0.4))
    fall = spectra.waterfall(TIME[-1000:], signal.motion[-1000:], signal.speed[-1000:], window=0.5)
    peaks = spectra.spectral_peaks(fall, count=1)
    assert (motion.backward_frequency, motion.backward_amplitude) == (peaks.frequency[0, 0], peaks.amplitude[0, 0])


def test_many_runs_have_the_numbers_that_each_has_alone():
    draw = np.random.default_rng(2)
    signals = [run({-f: 2e-3, 50.0: a}, samples=n) for f, a, n in zip(
        draw.uniform(20, 80, 30), draw.uniform(0, 1e-3, 30), draw.choice([len(TIME), 1000, 5], 30), strict=True
    )]  # fmt: skip
    assert repr(final_motions(signals)) == repr([final_motion(signal) for signal in signals])
