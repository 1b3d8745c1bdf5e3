"""The lag of a whirl that the rotor speed moves: none at rest, first order in the run-up rate, closed form far from the start."""

import numpy as np
import pytest

from rsc.analysis.follow.lag import lag
from rsc.analysis.paper.stability import whirl_growth
from rsc.analysis.paper.whirls import steady_whirls
from systems import TWO_PI, reference


def along(system, speeds, near):
    """Psi and F_N of the whirl next to a frequency in Hz at speeds in Hz."""
    found = []
    for speed in speeds:
        Psi, F_N = steady_whirls(system, TWO_PI * speed)
        i = np.argmin(np.abs(Psi - TWO_PI * near))
        found.append((Psi[i], F_N[i]))
        near = Psi[i] / TWO_PI
    return np.array(found).T


@pytest.fixture(scope="module")
def system():
    return reference("gyroscopic_disk_very_light")


def run(system, rate, seconds, shift=0.0, steps=400):
    time = np.linspace(0.0, seconds, steps + 1)
    speeds = 120.0 + rate * time
    return time, lag(system, time, TWO_PI * speeds, *along(system, speeds, -15.0), np.full(steps + 1, shift))


def test_a_whirl_at_constant_speed_does_not_lag(system):
    _, behind = run(system, 0.0, 5.0)
    assert np.abs([behind.rotor, behind.stator, behind.frequency]).max() < 1e-13


def test_lag_grows_from_nothing_and_is_proportional_to_the_rate(system):
    _, slow = run(system, -0.02, 40.0)
    _, fast = run(system, -0.04, 40.0)
    assert slow.rotor[0] == slow.stator[0] == slow.frequency[0] == 0.0
    assert fast.rotor[-1] / slow.rotor[-1] == pytest.approx(2.0, rel=0.02)
    assert fast.stator[-1] / slow.stator[-1] == pytest.approx(2.0, rel=0.02)


def test_lag_builds_up_with_the_slowest_decay(system):
    """What is missing from the final lag decays with the growth rate of the whirl, faster where a shift says so."""
    Psi, F_N = along(system, [120.0], -15.0)
    rate = whirl_growth(system, Psi[0], F_N[0], TWO_PI * 120.0).rate
    assert -0.5 < rate < -0.1
    final = []
    for shift in (0.0, rate):
        time, behind = run(system, -0.02, 60.0, shift)
        missing = 1.0 - behind.rotor / behind.rotor[-1]
        early = (time > 2.0) & (time < 8.0)
        slope = np.polyfit(time[early], np.log(missing[early]), 1)[0]
        assert slope == pytest.approx(rate + shift, rel=0.05)
        final.append(behind.rotor[-1])
    assert final[0] / final[1] == pytest.approx(2.0, rel=0.05)


def test_a_whirl_that_would_not_decay_is_left_out(system):
    """What grows leaves the whirl, and is no lag."""
    _, held = run(system, -0.02, 10.0, 1.0)
    _, follows = run(system, -0.02, 10.0)
    assert 0.0 < abs(held.rotor[-1]) < 0.1 * abs(follows.rotor[-1])


def test_a_single_instant_has_no_lag(system):
    Psi, F_N = along(system, [120.0], -15.0)
    assert lag(system, np.zeros(1), np.array([TWO_PI * 120.0]), Psi, F_N).rotor == 0.0
