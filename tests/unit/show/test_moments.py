"""Filtered paths of windows: ellipses of known signals, the exact orbit of a rotor whose bearing differs between directions."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from directions import assembled, of_bearing
from reports import short_report
from rsc.scene.scene import Scene
from rsc.show.pictures import paths, pictures
from rsc.show.pictures.abscissa import Abscissa
from rsc.show.pictures.moments import LEAST, filtered, seen_lines
from rsc.study.report.check import report as report_of
from rsc.study.run.simulate import simulate
from scenes import changed

STIFFNESS, DAMPING, SPEED, ECCENTRICITY = [[5e4, 1.2e4], [0.3e4, 8e4]], [[12.0, 3.0], [5.0, 25.0]], 37.0, 5e-5
BEARING = changed(
    stator={"model": "rigid"},
    rotor={"mass": 1.0, "frequency": 40.0, "damping_ratio": 0.0, "eccentricity": ECCENTRICITY},
    contact={"gap": 1e-3},
    drive={"speed": SPEED, "duration": 4.0},
    start={"rotor": [[0.0, 0.0]], "rotor_velocity": [[0.0, 0.0]]},
)
WINDOW = 3


def with_motion(report, motion, line):
    """The report with samples `motion(time)` of the rotor, and the strongest backward line of every window at `line` Hz."""
    scene, n_windows = report.result.scene, len(report.fall.speed)

    def samples(first, last):
        time = np.arange(first, last) / scene.output.rate
        return SimpleNamespace(time=time, contact_rotor=lambda: motion(time))

    features = replace(report.features, frequency=np.full(n_windows, line))
    return replace(report, result=SimpleNamespace(scene=scene, samples=samples), features=features, centre=np.zeros(n_windows))


def test_paths_are_ellipses_at_1x_and_at_the_whirl():
    report = short_report()
    drive, gap = report.result.scene.drive, report.result.scene.contact.gap
    rate = (drive.speed[1] - drive.speed[0]) / drive.time[1]
    line = 0.5 * report.fall.speed[WINDOW]

    def motion(time):
        phi, psi = 2.0 * np.pi * (drive.speed[0] * time + 0.5 * rate * time**2), 2.0 * np.pi * line * time
        once = 0.3 * np.exp(1j * (phi + 0.4)) + 0.1 * np.exp(-1j * phi)
        return gap * (once + 0.7 * np.exp(-1j * psi) + 0.2 * np.exp(1j * (psi - 0.9)))

    known = with_motion(report, motion, -line)
    found = filtered(known, WINDOW)
    for name, wanted in {"filtered at 1X": (0.3, 0.1), "filtered at the whirl": (0.2, 0.7)}.items():
        assert np.abs(found[name][1:]) / gap == pytest.approx(wanted, abs=0.01)
    traces = {trace["name"]: trace for trace in paths.orbit(replace(known, orbits=report.orbits), WINDOW)["data"]}
    for name, (longest, shortest) in {"filtered at 1X": (0.4, 0.2), "filtered at the whirl": (0.9, 0.5)}.items():
        distance = np.hypot(traces[name]["x"], traces[name]["y"])  # mm, of a gap of 1 mm
        assert (distance.max(), distance.min()) == pytest.approx((longest, shortest), abs=0.02)


def test_small_paths_slow_lines_and_those_beside_1x_are_left_out():
    report = short_report()
    speed, gap, window = report.fall.speed[WINDOW], report.result.scene.contact.gap, report.fall.window

    def names(line, size):
        known = with_motion(report, lambda time: size * gap * np.exp(-2j * np.pi * line * time), -line)
        return list(filtered(known, WINDOW))

    assert names(0.5 * speed, 2.0 * LEAST) == ["filtered at the whirl"]
    assert names(0.5 * speed, 0.9 * LEAST) == []
    assert names(1.9 / window, 1.0) == []
    assert "filtered at the whirl" not in names(speed + 1.9 / window, 1.0)
    assert "filtered at the whirl" in names(speed + 2.1 / window, 1.0)
    assert names(np.nan, 0.0) == []


def test_the_path_at_1x_is_the_exact_orbit_in_a_bearing_whose_directions_differ(monkeypatch):
    assembled(monkeypatch, lambda system: of_bearing(system, STIFFNESS, DAMPING))
    report = report_of(simulate(Scene.from_dict({**BEARING, "solver": {"rtol": 1e-9}})))
    window, omega = len(report.fall.speed) - 1, 2.0 * np.pi * SPEED
    # [-omega^2 + i omega C + K] (y, z) e^(i omega t) = e omega^2 (1, -i) e^(i omega t), of which the real part is the motion
    matrix = -(omega**2) * np.eye(2) + 1j * omega * np.array(DAMPING) + np.array(STIFFNESS)
    y, z = np.linalg.solve(matrix, ECCENTRICITY * omega**2 * np.array([1.0, -1.0j]))
    forward, backward = 0.5 * (y + 1j * z), 0.5 * (y.conj() + 1j * z.conj())
    assert abs(backward) > 0.3 * abs(forward)
    found = filtered(report, window)
    assert list(found) == ["filtered at 1X"]
    assert found["filtered at 1X"][1:] == pytest.approx((forward, backward), abs=1e-5 * abs(forward))  # the window leaks 1.3e-6


def test_small_lines_set_no_scale():
    report = short_report()
    largest, line = report.fall.amplitude.max(), np.linspace(-900.0, -100.0, len(report.fall.speed))
    for share, seen in ((0.03, True), (0.01, False)):
        features = replace(report.features, frequency=line, size=share * largest + 0.0 * line)
        assert np.isfinite(seen_lines(replace(report, features=features))).all() == seen
        reach = pictures.campbell(replace(report, features=features), Abscissa(report))["layout"]["xaxis"]["range"][1]
        assert (reach > 900.0) == seen
