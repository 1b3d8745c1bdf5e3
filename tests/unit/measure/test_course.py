"""A run measured piece by piece is the run measured at once."""

import tracemalloc
from dataclasses import fields, replace

import numpy as np
import pytest

import rsc
from reports import PUMP, report_of_dict, short_report
from rsc.measure import course as module
from rsc.measure import spectra
from rsc.measure.course import course, steepest, windows_of
from rsc.measure.features import envelope, revolution_marks, turns, waterfall


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.h5"
    short_report().result.save(path)
    return rsc.load(path)


def columns(part):
    values = {field.name: getattr(part, field.name) for field in fields(part)}
    return {name: np.asarray(value) for name, value in values.items() if value is not None}


@pytest.mark.parametrize("loaded", [False, True])
def test_pieces_join_to_the_whole(run, monkeypatch, loaded):
    windows = windows_of(run)
    whole = course(run, windows, loaded)
    monkeypatch.setattr(module, "PIECE", 2 * windows.n_samples + 7)
    pieces = course(run, windows, loaded)
    for name in ("fall", "stator_fall", "features", "strip", "orbits", "envelope"):
        joined = columns(getattr(pieces, name))
        for column, values in columns(getattr(whole, name)).items():
            alike = values if values.dtype.kind == "U" else pytest.approx(values, rel=1e-9, abs=1e-12, nan_ok=True)
            assert np.all(joined[column] == alike), (name, column)
    assert pieces.centre == pytest.approx(whole.centre, abs=1e-12)
    assert pieces.order == pytest.approx(whole.order)
    assert whole.stretches.whole().rotor_max == pytest.approx(np.abs(run.contact_rotor()).max(), rel=1e-3)


def test_the_course_has_the_spectra_and_the_envelope_of_the_whole_arrays(run):
    seen = course(run, windows_of(run), False)
    fall, edge = waterfall(run), envelope(run)
    moving = np.abs(fall.frequency) * fall.window > 1.5  # in the other bins the mean of a window is taken out
    assert seen.fall.amplitude[:, moving] == pytest.approx(fall.amplitude[:, moving], rel=1e-9, abs=1e-15)
    assert not seen.fall.amplitude[:, fall.frequency == 0.0].any()
    assert seen.fall.speed == pytest.approx(fall.speed) and seen.fall.time == pytest.approx(fall.time)
    assert seen.envelope.maximum == pytest.approx(edge.maximum) and seen.envelope.speed == pytest.approx(edge.speed)


def test_the_spectra_show_what_moves_and_not_how_far_the_rotor_hangs(run):
    """A waterfall at whose 0 Hz a sag of a hundred amplitudes stood is that of the same motion about its bearing's centre."""
    windows, sag = windows_of(run), 0.3 - 0.4j

    class Hanging:
        scene, n_time, status, stretches = run.scene, run.n_time, run.status, run.stretches

        def samples(self, first, last):
            part = run.samples(first, last)
            return replace(part, rotor=part.rotor + sag)

    hanging, plain = course(Hanging(), windows, True), course(run, windows, True)
    scale = plain.fall.amplitude.max()
    assert hanging.fall.amplitude == pytest.approx(plain.fall.amplitude, rel=1e-6, abs=1e-9 * scale)
    assert hanging.centre == pytest.approx(plain.centre + sag)


def test_a_long_waterfall_keeps_the_largest_of_neighbouring_bins(run, monkeypatch):
    windows = windows_of(run)
    full = course(run, windows, False)
    monkeypatch.setattr(module, "MOST_CELLS", 2 * 64 * len(windows.starts))
    seen = course(run, windows, False)
    thin = seen.fall
    assert seen.stator_fall.amplitude.shape == thin.amplitude.shape
    assert thin.amplitude.shape == (len(windows.starts), 64) and thin.amplitude.dtype == np.float32
    assert thin.amplitude.max(axis=1) == pytest.approx(full.fall.amplitude.max(axis=1), rel=1e-6)
    places = np.abs(thin.frequency[thin.amplitude.argmax(axis=1)] - full.fall.frequency[full.fall.amplitude.argmax(axis=1)])
    assert places.max() < np.diff(thin.frequency).max()


def test_so_many_windows_that_they_stand_apart(run, monkeypatch):
    monkeypatch.setattr(module, "MOST_WINDOWS", 5)
    windows = windows_of(run)
    assert len(windows.starts) <= 6 and windows.starts[-1] + windows.n_samples <= run.n_time
    assert len(course(run, windows, False).features.speed) == len(windows.starts)


def test_memory_does_not_grow_with_the_length_of_a_run(run):
    asked = []

    class Long:
        scene = rsc.Scene.from_dict(PUMP | {"drive": {"speed": [30.0, 60.0], "duration": 1500.0}, "output": {"rate": 2000.0}})
        n_time, status, stretches = 3_000_001, run.status, run.stretches  # 48 MB a motion

        def samples(self, first, last):
            asked.append(last - first)
            time, zero = np.arange(first, last) / 2000.0, np.zeros(last - first)
            still = {"speed": zero + 45.0, "friction_force": zero, "tangential_velocity": zero, "stator": 0j * zero}
            moving = {"rotor": 1e-3 * np.exp(-200j * time), "normal_force": zero + (first == 0)}
            return replace(run.samples(0, 1), scene=self.scene, time=time, **still, **moving)

    tracemalloc.start()
    seen = course(Long(), windows_of(Long()), False)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 160e6 and max(asked) <= 1.5 * module.PIECE
    assert len(seen.fall.speed) <= module.MOST_WINDOWS + 1 and seen.fall.amplitude.size <= module.MOST_CELLS
    assert seen.features.frequency == pytest.approx(np.full(len(seen.fall.speed), -100.0 / np.pi), rel=1e-6)
    assert np.abs(seen.centre).max() < 1e-5


def test_samples_are_rows_of_the_arrays(run):
    memory = short_report().result
    for source in (run, memory):
        part = source.samples(100, 5000)
        assert np.array_equal(part.time, run.time[100:5000]) and np.array_equal(part.rotor, run.contact_rotor()[100:5000])
        assert np.array_equal(part.stator, run.contact_stator()[100:5000])
        assert source.n_time == len(run.time)


def test_turns_are_the_integral_of_a_schedule():
    scene = rsc.Scene.from_dict(PUMP | {"drive": {"schedule": [[0.0, 10.0], [2.0, 30.0], [3.0, 30.0], [5.0, 5.0]]}})
    time = np.linspace(0.0, 5.0, 200_001)
    speed = np.interp(time, scene.drive.time, scene.drive.speed)
    by_sum = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    assert turns(scene.drive, time) == pytest.approx(by_sum, abs=1e-6)


def test_revolutions_of_a_part_are_those_of_the_run(run):
    marks = revolution_marks(run)
    part = revolution_marks(run.samples(1000, 6000)) + 1000
    assert np.array_equal(part, marks[(marks > 1000) & (marks < 6000)])


def test_the_line_at_the_rotor_speed_is_that_of_a_turning_vector(run):
    windows = windows_of(run)
    vector = 3e-4 * np.exp(0.7j)

    class Turning:
        scene, n_time, status, stretches = run.scene, run.n_time, run.status, run.stretches

        def samples(self, first, last):
            part = run.samples(first, last)
            return replace(part, rotor=vector * np.exp(2j * np.pi * turns(run.scene.drive, part.time)))

    order = course(Turning(), windows, False).order
    assert order == pytest.approx(np.full(len(order), vector), rel=1e-9)


def test_only_the_part_of_the_schedule_that_was_run_decides_the_window(run):
    drive = rsc.Scene.from_dict(PUMP | {"drive": {"schedule": [[0.0, 10.0], [100.0, 30.0], [101.0, 90.0]]}})
    early = replace(run, scene=drive)
    assert steepest(early) == pytest.approx(0.2)


def test_the_waterfall_of_the_stator_is_that_of_its_motion(run):
    windows = windows_of(run)
    own = course(run, windows, loaded=False).stator_fall
    speed = np.interp(run.time, run.scene.drive.time, run.scene.drive.speed)
    whole = spectra.waterfall(run.time, run.contact_stator(), speed, window=windows.window)
    moving = np.abs(whole.frequency) * whole.window > 1.5
    assert own.amplitude[:, moving] == pytest.approx(whole.amplitude[:, moving], rel=1e-9, abs=1e-15)
    assert own.amplitude.max() > 1e-4
    rest = {key: table for key, table in PUMP.items() if key != "start"} | {"stator": {"model": "rigid"}}
    assert report_of_dict(rest, drive={"speed": [10.0, 12.0], "duration": 1.0}).stator_fall is None


class Ellipse:
    """A run of a rotor on unequal supports in a still stator: the unbalance's ellipse, and beside it a whirl of `size` gaps."""

    def __init__(self, run, whirl, size):
        self.scene, self.n_time, self._run, self._whirl, self._size = run.scene, run.n_time, run, whirl, size
        self.status, self.stretches = run.status, run.stretches

    def samples(self, first, last):
        part = self._run.samples(first, last)
        phi, gap = 2.0 * np.pi * turns(self.scene.drive, part.time), self.scene.contact.gap
        motion = 2.0 * np.exp(1j * phi) + 1.6 * np.exp(-1j * phi)
        motion += self._size * np.exp(-2j * np.pi * self._whirl * part.time)
        return replace(part, rotor=gap * motion, stator=np.zeros(len(motion), dtype=complex))


def test_the_other_half_of_an_ellipse_is_no_whirl_where_directions_differ(run):
    windows, gap, whirl, size = windows_of(run), run.scene.contact.gap, 11.3, 0.1
    for unequal in (False, True):
        features = course(Ellipse(run, whirl, size), windows, False, unequal).features
        wanted = (-whirl, size) if unequal else (-features.speed, 1.6)
        assert np.abs(features.frequency - wanted[0]).max() < 0.5
        assert np.abs(features.size / gap - wanted[1]).max() < 0.1 * wanted[1]
        assert features.other_frequency.shape == (len(features.speed), 2)
    alone = course(Ellipse(run, whirl, 0.0), windows, False, True).features
    assert alone.size.max() < 0.01 * gap
    passing = course(Ellipse(run, 45.0, 4.0), windows, False, True).features  # larger than the forward line: it stays
    assert np.abs(passing.speed - 45.0).min() < 1.0 / windows.window
    assert np.abs(passing.frequency + 45.0).max() < 1.0 / windows.window
