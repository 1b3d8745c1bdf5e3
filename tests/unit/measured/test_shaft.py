"""The shaft of a measured run: where pulses tell its angle and speed, where it stands, and where nobody knows."""

import numpy as np
import pytest

import rsc
from probes import pulses_of, written
from rsc.errors import DataError
from rsc.measured.shaft import shaft_of
from scenes import LAVAL
from shafts import apart_from_corners, shaft

RATE = 5000.0


def turned(times, speeds, rate=RATE):
    """time, speed and turns of a speed on straight pieces."""
    time = np.arange(0.0, times[-1], 1.0 / rate)
    speed = np.interp(time, times, speeds)
    return time, speed, np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / rate)])


def wheel(turns, teeth, kept, width=0.4):
    """Pulses of a wheel with those teeth, counted from its mark."""
    tooth = np.floor(turns * teeth) % teeth
    return (((turns * teeth) % 1.0 < width) & np.isin(tooth, list(kept))).astype(float)


@pytest.mark.parametrize("number", range(16))
def test_the_speed_of_any_shaft_is_met_or_called_unknown(number):
    """bench/measured_shafts.py tries 200."""
    one = shaft(np.random.default_rng([0, number]))
    seen = shaft_of(one.time, one.pulses, one.teeth)
    off = np.abs(seen.speed - one.speed) / one.speed.max()
    assert off[seen.known & apart_from_corners(one)].max() < 0.005
    assert seen.speed.min() >= 0.0 and np.diff(seen.turns).min() > -1e-9
    assert seen.marked == (one.teeth == 1 or one.lacking > 0)
    if one.lost is None:
        assert seen.known.all() and seen.missing == seen.extra == 0
    if seen.marked:
        turning = seen.known & (one.speed > 0.05 * one.speed.max())
        assert np.abs((seen.turns - one.turns + 0.5) % 1.0 - 0.5)[turning].max() < 0.01


@pytest.mark.parametrize(("times", "speeds"), [([0, 2, 8, 11], [30, 30, 0, 0]), ([0, 2, 8, 10], [0, 0, 30, 30])])
def test_a_run_from_or_to_rest_stands_there_and_is_compared(tmp_path, times, speeds):
    time, speed, turns = turned(times, speeds)
    motion = 40e-6 * np.exp(2j * np.pi * turns)
    run = rsc.read_measured(written(tmp_path, time, motion, pulses_of(turns)))
    assert np.abs(run.speed - speed).max() < 0.5 and run.speed.min() >= 0.0
    assert run.speed[speed == 0.0].max() < 0.1
    (line,) = run.warnings
    assert line.startswith("the shaft is at rest from")
    report = rsc.compare(rsc.Scene.from_dict(LAVAL), run)
    assert np.isfinite(report.order).all() and set(report.features.kind[report.features.speed < 0.1]) == {"not resolved"}


def test_a_stop_between_is_no_lost_pulse():
    time, speed, turns = turned([0, 6, 8, 14], [30, 0, 0, 40])
    seen = shaft_of(time, -pulses_of(turns + 0.3), 1)
    assert np.abs(seen.speed - speed).max() < 0.1 and seen.known.all() and seen.missing == 0
    assert np.abs((seen.turns - turns - 0.3)[speed > 1.0] % 1.0 - 0.5).min() > 0.49


@pytest.mark.parametrize("lost", [(1.5, 2.5), (0.0, 1.0), (3.2, 4.0)])
def test_lost_pulses_are_counted_between_even_sides_and_told_at_the_ends(tmp_path, lost):
    time, speed, turns = turned([0, 4], [40, 60])
    pulses = np.where((time >= lost[0]) & (time < lost[1]), 0.0, pulses_of(turns))
    run = rsc.read_measured(written(tmp_path, time, 1e-4 * np.exp(2j * np.pi * turns), pulses))
    known = np.isfinite(run.deflection)
    assert np.abs(run.speed - speed)[known].max() < 0.1
    if lost == (1.5, 2.5):
        assert known.all() and run.warnings[0].startswith("50 of 199 pulses")
    else:
        away = (time < lost[0] - 0.05) | (time > lost[1] + 0.05)
        assert known[away].all() and not known[(time > lost[0] + 0.05) & (time < lost[1] - 0.05)].any()
        assert "not known" in run.warnings[0] and "windows there are empty" in run.warnings[0]


def test_a_gap_across_a_corner_of_the_speed_is_not_bridged():
    time, _, turns = turned([0, 4, 8], [20, 60, 20])
    pulses = np.where((time >= 3.0) & (time < 5.0), 0.0, pulses_of(turns))
    seen = shaft_of(time, pulses, 1)
    assert not seen.known[(time > 3.1) & (time < 4.9)].any() and seen.known[(time < 2.9) | (time > 5.1)].all()
    assert np.abs((seen.turns - turns)[seen.known] % 1.0 - 0.5).min() > 0.48  # the mark is met behind it


def test_one_pulse_lost_beside_the_last_is_noticed():
    time, _, turns = turned([0, 2], [50, 50])
    pulses = pulses_of(turns)
    pulses[np.floor(turns + 0.5) == np.floor(turns[-1]) - 1] = 0.0
    seen = shaft_of(time, pulses, 1)
    assert seen.missing == 1 and np.abs(seen.speed - 50.0).max() < 1e-6


@pytest.mark.parametrize("teeth", [3, 5, 36, 60])
@pytest.mark.parametrize("lacking", [1, 2])
def test_missing_teeth_give_the_mark(teeth, lacking):
    if teeth - lacking < 2:
        return
    time, speed, turns = turned([0, 3], [12, 20], 20e3)
    seen = shaft_of(time, wheel(turns + 0.37, teeth, range(teeth - lacking)), teeth)
    assert seen.marked and seen.missing == 0 and np.abs(seen.speed - speed).max() < 0.1
    np.testing.assert_allclose((seen.turns - turns - 0.37 + 0.5) % 1.0, 0.5, atol=0.005)


def test_an_additional_tooth_is_the_mark():
    time, speed, turns = turned([0, 3], [12, 20], 20e3)
    pulses = wheel(turns, 12, range(12)) + (((turns * 12) % 12 > 3.5) & ((turns * 12) % 12 < 3.7))
    seen = shaft_of(time, pulses, 12)
    assert seen.marked and np.abs(seen.speed - speed).max() < 0.1
    np.testing.assert_allclose((seen.turns - turns + 3.5 / 12 + 0.5) % 1.0, 0.5, atol=0.005)


def test_a_wheel_counted_without_its_missing_teeth_is_refused(tmp_path):
    time, _, turns = turned([0, 3], [12, 20], 20e3)
    path = written(tmp_path, time, 1e-4 * np.exp(2j * np.pi * turns), wheel(turns, 60, range(58)), more="events_per_turn = 58")
    with pytest.raises(DataError, match="a wheel of 60 teeth that lacks 2: events_per_turn must be 60"):
        rsc.read_measured(path)


def test_an_even_wheel_has_no_mark_and_says_so(tmp_path):
    time, speed, turns = turned([0, 4], [40, 60])
    path = written(tmp_path, time, 1e-4 * np.exp(2j * np.pi * turns), wheel(turns, 8, range(8)), more="events_per_turn = 8")
    run = rsc.read_measured(path)
    assert not run.marked and run.jitter is not None and np.abs(run.speed - speed).max() < 0.3
    assert any(line.startswith("it is unknown which of 8 pulses in a turn is the mark") for line in run.warnings)


def test_a_pulse_that_every_turn_is_seen_twice_counts_once():
    time, speed, turns = turned([0, 4], [40, 60])
    seen = shaft_of(time, ((turns % 1.0 < 0.05) | (np.abs(turns % 1.0 - 0.3) < 0.02)).astype(float), 1)
    assert np.abs(seen.speed - speed).max() < 0.1 and seen.extra > 190
    np.testing.assert_allclose((seen.turns - turns + 0.5) % 1.0, 0.5, atol=0.01)


@pytest.mark.parametrize("offset", [-3.0, 3.0])
def test_a_speed_signal_with_a_small_offset_stands_at_rest(tmp_path, offset):
    time, speed, turns = turned([0, 2, 8, 11], [30, 30, 0, 0])
    path = written(tmp_path, time, 4e-5 * np.exp(2j * np.pi * turns), 60.0 * speed + offset)
    path.write_text(path.read_text().replace('keyphasor = "KPH"', 'speed = "KPH"\nspeed_unit = "1 rpm"'))
    run = rsc.read_measured(path)
    assert run.speed.min() >= 0.0 and np.abs(run.speed - speed).max() <= abs(offset) / 60.0 + 1e-9
    rsc.compare(rsc.Scene.from_dict(LAVAL), run)


def test_a_shaft_that_reverses_is_refused_with_what_to_give(tmp_path):
    time, speed, turns = turned([0, 4, 8], [30, 0, -30])
    path = written(tmp_path, time, 4e-5 * np.exp(2j * np.pi * turns), speed)
    path.write_text(path.read_text().replace("keyphasor", "speed"))
    with pytest.raises(DataError, match=r"the shaft reverses; give the rows of each direction in a separate file"):
        rsc.read_measured(path)


def test_runout_is_not_taken_off_where_a_wheel_without_mark_loses_count(tmp_path):
    time, _, turns = turned([0, 4, 8], [5, 60, 5])
    pulses = np.where((time >= 3.0) & (time < 5.0), 0.0, wheel(turns, 4, range(4)))
    more = "events_per_turn = 4\nslow_roll = [5.0, 12.0]"
    path = written(tmp_path, time, 1e-4 * np.exp(2j * np.pi * turns), pulses, more=more)
    with pytest.raises(DataError, match="loses count of a wheel without a mark"):
        rsc.read_measured(path)


def test_the_polarity_is_that_of_short_stays_even_where_the_shaft_stands_on_its_mark():
    time, _, turns = turned([0, 2, 4, 12], [30, 30, 0, 0])
    turns += 0.03 - turns[-1] % 1.0
    pulses = pulses_of(turns)
    assert np.median(pulses) == pulses.min()
    off = (shaft_of(time, pulses, 1).turns - turns)[time < 3.8]
    np.testing.assert_allclose(off - np.round(off), 0.0, atol=0.01)
