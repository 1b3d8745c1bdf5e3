"""Signals on one clock: shifted exactly, filtered where rates differ; and even times behind those that a file has."""

import numpy as np
import pytest

from rsc.errors import DataError
from rsc.measured.channel import Channel
from rsc.measured.clock import Signal, at, clock_of
from rsc.measured.keys import Probe
from rsc.measured.scales import metres
from rsc.measured.stated import meaning, parted
from rsc.measured.times import even_times

RATE = 1000.0


def tone(frequency, start, rate, seconds=4.0, name="X"):
    time = start + np.arange(int(seconds * rate)) / rate
    return Signal(name, start, 1.0 / rate, np.sin(2.0 * np.pi * frequency * time))


def on_clock(*signals):
    clock, told = clock_of(list(signals), [], "file")
    time = clock.start + clock.times
    inside = (time > clock.start + 0.2) & (time < time[-1] - 0.2)  # the filter knows both sides
    return time[inside], [at(signal, clock)[inside] for signal in signals], told


@pytest.mark.parametrize("late", [0.0, 0.007, 0.0074, 1.23456])
@pytest.mark.parametrize("frequency", [3.0, 80.0, 400.0])
def test_a_later_signal_is_shifted_by_its_start(late, frequency):
    time, values, told = on_clock(tone(frequency, 0.0, RATE), tone(frequency, late, RATE, name="Y"))
    for each in values:
        np.testing.assert_allclose(each, np.sin(2.0 * np.pi * frequency * time), atol=1e-4)
    assert bool(told) == (late > 0.0)


@pytest.mark.parametrize("ratio", [2.0, 4.0, 2.5, 1.2345])
def test_a_faster_signal_is_filtered_and_not_folded(ratio):
    for frequency in (50.0, 390.0):
        _, (slow, fast), told = on_clock(tone(frequency, 0.0, RATE), tone(frequency, 0.0, ratio * RATE, name="Y"))
        np.testing.assert_allclose(slow, fast, atol=1e-4)
        assert "X 1000, Y" in told[0] and "up to 400 Hz" in told[0]
    if ratio >= 2.0:
        _, (_, folded), _ = on_clock(tone(50.0, 0.0, RATE), tone(560.0, 0.0, ratio * RATE, name="Y"))
        assert np.abs(folded).max() < 1e-3


def test_missing_samples_stay_missing():
    signal = tone(3.0, 0.0, RATE)
    signal.values[1500:1520] = np.nan
    clock, _ = clock_of([tone(3.0, 0.00033, RATE), signal], [], "file")
    lost = np.flatnonzero(np.isnan(at(signal, clock)))
    assert lost.min() in range(1497, 1501) and lost.max() in range(1518, 1522) and len(lost) == np.ptp(lost) + 1


@pytest.mark.parametrize(
    ("other", "wanted"),
    [
        (tone(3.0, 9.0, RATE, name="Y"), "Y begins 5 s after the end of X"),
        (tone(3.0, 3.97, RATE, name="Y"), "X and Y overlap by 30 samples"),
        (tone(3.0, 0.0, 1.001 * RATE, 4.0 / 1.001, name="Y"), "their clocks run apart"),
        (tone(3.0, 0.0, RATE, 3.9, name="Y"), "samples are missing"),
    ],
)
def test_signals_that_are_of_no_one_run_are_refused(other, wanted):
    with pytest.raises(DataError, match=wanted):
        clock_of([tone(3.0, 0.0, RATE), other], [], "file")


def rounded(rate, form, seconds=20.0, start=0.0):
    return np.array([float(form % time) for time in start + np.arange(int(rate * seconds)) / rate])


@pytest.mark.parametrize(
    ("rate", "form"),
    [(5000, "%.3f"), (12800, "%.4f"), (48000, "%.5f"), (48000, "%.4f"), (8000, "%g"), (12800, "%g"), (5000, "%.9g")],
)
def test_rounded_times_are_those_of_even_samples(rate, form):
    even = even_times(rounded(rate, form), 1.0, "file")
    assert abs(even.step * rate - 1.0) < 1e-6 and even.samples == len(even.place) and (np.diff(even.place) == 1).all()
    assert ("rounded" in " ".join(even.told)) == (form != "%.9g")


def test_times_that_are_cut_off_or_late_in_the_day_are_even_as_well():
    time = np.arange(20_000) / 5000.0
    for raw in (np.floor(1000.0 * time + 1e-9) / 1000.0, rounded(5000, "%.3f", 4.0, 36_000.0)):
        assert abs(5000.0 * even_times(raw, 1.0, "file").step - 1.0) < 1e-5


@pytest.mark.parametrize("form", ["%.9g", "%.3f"])
def test_a_missing_row_is_no_rounding(form):
    even = even_times(np.delete(rounded(1000, form), 9000), 1.0, "file")
    assert "1 samples are missing" in even.told[0] and even.samples == 20_000


def test_rounded_times_with_a_gap_are_refused_with_what_to_give():
    with pytest.raises(DataError, match=r"give measured\.rate instead"):
        even_times(np.delete(rounded(5000, "%.3f"), slice(9000, 9050)), 1.0, "file")


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("um", ("length", 1e-6)), ("(µm)", ("length", 1e-6)), ("[ms]", ("time", 1e-3)), ("mil", ("length", 25.4e-6)),
        ("mV", ("voltage", 1e-3)), ("Volt", ("voltage", 1.0)), ("rpm", ("frequency", 1.0 / 60.0)),
        ("g", ("acceleration", 9.80665)), ("mm/s", ("velocity", 1e-3)), ("EU", None), ("", None), ("-", None),
        ("KPH", None), ("2", None),
    ],
)  # fmt: skip
def test_units_that_files_state(text, wanted):
    seen = meaning(text)
    assert (seen and seen[0]) == (wanted and wanted[0])
    assert wanted is None or seen[1] == pytest.approx(wanted[1], rel=1e-12)


@pytest.mark.parametrize(
    ("head", "wanted"),
    [
        ("Time (ms)", ("Time", "ms")), ("X [um]", ("X", "um")), ("X_(um)", ("X", "um")), ("Weg / µm", ("Weg", "µm")),
        ("t, s", ("t", "s")), ("probe 3", ("probe 3", "")), ("X (1)", ("X (1)", "")), ("rig/X", ("rig/X", "")),
        ("(um)", ("(um)", "")),
    ],
)  # fmt: skip
def test_names_with_units(head, wanted):
    assert parted(head) == wanted


def test_a_unit_of_the_file_is_used_where_the_table_has_none_and_held_against_it():
    probe = Probe(column="X", angle=0.0, sensitivity=None, unit=None)
    assert metres(probe, 0, Channel(("X",), 9, "mil"), 1.0, "file") == (pytest.approx(25.4e-6), [])
    same = Probe(column="X", angle=0.0, sensitivity=None, unit=25.4e-6)
    assert metres(same, 0, Channel(("X",), 9, "mil"), 1.0, "file")[0] == pytest.approx(25.4e-6)
    volts = Probe(column="X", angle=0.0, sensitivity=8000.0, unit=None)
    assert metres(volts, 0, Channel(("X",), 9, "mV"), 1.0, "file") == (pytest.approx(1e-3 / 8000.0), [])
