"""Delay of the jump: the law of growth against closed forms, the predicted run-ups against simulated ones."""

import numpy as np
import pytest

import rsc
from rsc.analysis.follow.branches import branches
from rsc.analysis.follow.delayed_jump import delayed_jump, rounding_floor, starting_level
from systems import TWO_PI, changed, reference, reference_scene
from tiers import nightly

SPEEDS = np.linspace(20.0, 150.0, 131)


@pytest.fixture(scope="module")
def scene():
    return reference_scene("gyroscopic_transition")


@pytest.fixture(scope="module")
def found():
    return branches(reference("gyroscopic_transition"), SPEEDS)


def run(duration, speeds=(20.0, 150.0)):
    """The transition scene with another run-up."""
    times = np.array([0.0, duration])
    return changed(reference("gyroscopic_transition"), schedule_time=times, schedule_speed=TWO_PI * np.array(speeds))


def line(result, frequency, middle, length):
    """Amplitude of the contact coordinate at a frequency, in a window with side lobes below 1e-12."""
    step = result.time[1] - result.time[0]
    n = int(length / step)
    first = round(middle / step) - n // 2
    window = np.kaiser(n, 30.0)
    part = result.contact_rotor()[first : first + n]
    near = frequency + np.linspace(-0.4, 0.4, 17)
    turned = np.exp(-2j * np.pi * near[:, None] * result.time[first : first + n])
    return np.abs(turned @ (part * window)).max() / window.sum()


def taken_over(result, old, new, share):
    """Rotor speed at which the line of the new whirl has a share of the old one's (it grows all the time before)."""
    low, high = 0.45 * result.time[-1], 0.97 * result.time[-1]
    while high - low > 1e-3 * result.time[-1]:
        middle = 0.5 * (low + high)
        speed = np.interp(middle, result.time, result.speed)
        lines = [line(result, branch.at(speed).frequency, middle, 2.0) for branch in (old, new)]
        low, high = (low, middle) if lines[1] >= share * lines[0] else (middle, high)
    return np.interp(high, result.time, result.speed)


# the run of 240 s leaves whirl A as predicted but is caught, up to 120 Hz, by a motion with both lines that loses contact
@pytest.mark.parametrize("duration, source, share", [(120.0, "start", 1.0), (240.0, "floor", 0.5), nightly(480.0, "floor", 1.0)])
def test_predicted_jump_is_that_of_the_simulated_run_up(scene, found, duration, source, share):
    # a tolerance whose own noise lies below rounding: at 1e-6 it is louder and the run leaves some 5 % earlier
    quiet = {"drive.duration": duration, "output.rate": 600.0, "solver.rtol": 1e-8}
    result = rsc.simulate(scene.with_values(quiet))
    delay = delayed_jump(run(duration), found[0])
    assert delay.source == source
    assert delay.crossing == pytest.approx(68.602, abs=0.001)
    # issue 3 asks for 5 %; the disturbance is stated beforehand, nothing is fitted
    assert delay.jump == pytest.approx(taken_over(result, found[0], found[1], share), rel=0.05)
    assert delay.first_seen == pytest.approx(taken_over(result, found[0], found[1], 1e-3), rel=0.05)
    assert delay.towards == pytest.approx(found[1].at(70.0).frequency, rel=0.01)


def test_the_start_disturbance_decays_as_predicted(scene, found):
    result = rsc.simulate(scene.with_values({"drive.duration": 120.0, "output.rate": 600.0}))
    level = starting_level(run(120.0), found[0], 20.0)
    for speed in (26.0, 32.0, 38.0):
        time = (speed - 20.0) / 130.0 * 120.0
        whirl = found[0].at(speed)
        mode = whirl.frequency - whirl.growth_frequency
        there = (found[0].speed <= speed).nonzero()[0]
        gained = np.trapezoid(found[0].growth_rate[there], found[0].speed[there]) * 120.0 / 130.0
        # of the amplitude at the start; eight e-foldings are met to a third of one
        expected = np.log(level) + gained
        assert np.log(line(result, mode, time, 4.0) / whirl.rotor_amplitude) == pytest.approx(expected, abs=0.5)


def test_slow_limit_is_the_crossing_for_any_floor_and_the_balance_of_growth_without(found):
    slow = [delayed_jump(run(duration), found[0], start_level=1.0, floor=1e-6) for duration in (1e3, 1e4, 1e5, 1e6)]
    late = [delay.jump / delay.crossing - 1.0 for delay in slow]
    # the growth rate rises linearly: the delay in time with the root of the duration, in speed with its inverse
    assert late[-1] == pytest.approx(late[-2] / np.sqrt(10.0), rel=0.05) and 0.0 < late[-1] < 0.01
    assert all(delay.undisturbed == pytest.approx(slow[0].undisturbed, rel=1e-9) for delay in slow)
    speeds, growth = found[0].speed, found[0].growth_rate
    fine = np.linspace(20.0, slow[0].undisturbed, 20001)
    assert abs(np.trapezoid(np.interp(fine, speeds, growth), fine)) < 0.01


def test_a_linear_growth_rate_has_a_closed_form(found):
    # growth = g (speed - crossing): level 1 from a floor after sqrt(2 ln(1/floor) / (g rate)) s
    delay = delayed_jump(run(2e5, (60.0, 80.0)), found[0], start_level=1e-9, floor=1e-9)
    slope = np.interp(69.6, SPEEDS, found[0].growth_rate) - np.interp(68.6, SPEEDS, found[0].growth_rate)
    wanted = np.sqrt(2.0 * np.log(1e9) / (slope * 20.0 / 2e5)) * 20.0 / 2e5
    assert delay.jump - delay.crossing == pytest.approx(wanted, rel=0.01)
    assert delay.level_at_crossing == pytest.approx(1e-9, rel=1e-2)


def test_more_noise_jumps_earlier_and_a_fast_run_never(found):
    quiet, loud = (delayed_jump(run(480.0), found[0], floor=floor) for floor in (1e-14, 1e-4))
    assert loud.jump < quiet.jump - 5.0
    assert np.isnan(delayed_jump(run(20.0), found[0]).jump)


def test_a_stable_whirl_is_not_left(found):
    delay = delayed_jump(run(120.0), found[1])
    assert np.isnan(delay.crossing) and np.isnan(delay.jump)


def test_a_run_down_leaves_where_the_whirl_ends():
    system = reference("gyroscopic_disk_very_light")
    down = np.linspace(60.0, 10.0, 101)
    whirl = next(b for b in branches(system, down) if b.lost)
    times = np.array([0.0, 100.0])
    slow = changed(system, schedule_time=times, schedule_speed=TWO_PI * np.array([60.0, 10.0]))
    delay = delayed_jump(slow, whirl, start_level=1e-12, floor=1e-12)
    assert delay.crossing == pytest.approx(31.75, abs=0.01)
    # growth is too slow to be seen before the whirl folds away
    assert delay.jump == pytest.approx(whirl.begin.value, abs=0.02)
    with pytest.raises(ValueError, match="does not exist at 10 Hz"):
        delayed_jump(changed(slow, schedule_speed=slow.schedule_speed[::-1]), whirl)


def test_rounding_floor_grows_with_the_root_of_the_steps():
    system = reference("gyroscopic_transition")
    floors = []
    for duration in (100.0, 400.0):
        time = np.linspace(0.0, duration, 1001)
        floors.append(rounding_floor(system, time, 2.0 * time / duration - 1.0))
    assert 1e-14 < floors[0] < 1e-12
    assert floors[1] / floors[0] == pytest.approx(2.0**0.5, rel=1e-6)
