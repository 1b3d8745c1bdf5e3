"""The line at the rotor speed without contact, where the speed passes a resonance faster than the motion can follow."""

from dataclasses import replace

import numpy as np
import pytest

import rsc
from rsc.measure.words import AGREES, NO_PREDICTION, OUTSIDE, SYNCHRONOUS
from rsc.scene.templates import template
from rsc.study.alone import moving_lines
from rsc.study.check import observed
from rsc.system.assemble import assemble


def scene():
    """Two coordinates and a stator; the second resonance, at 25.5 Hz, is passed without contact."""
    return rsc.Scene.from_toml(template("matrices", "rest")).with_values({"drive.speed": [17.0, 32.0], "drive.duration": 20.0})


def lines_of(report):
    return [row for row in report.rows if row.quantity == SYNCHRONOUS]


def test_behind_a_resonance_the_line_is_that_of_the_motion_that_rings_down():
    report = rsc.check(scene())
    rows = lines_of(report)
    assert {row.verdict for row in rows} == {AGREES}
    steady = [abs(row.simulated / alone - 1.0) for row, alone in zip(rows, report.alone, strict=True)]
    assert max(steady) > 1.0 and max(abs(row.difference) for row in rows if row.speed > 20.0) < 0.02


@pytest.fixture(scope="module")
def run():
    result = rsc.simulate(scene())
    system = assemble(result.scene)
    return system, observed(result, system)[0].features


def test_only_windows_around_a_resonance_are_computed(run):
    system, features = run
    assert np.isnan(moving_lines(system, features, np.full(len(features.speed), 1e-5))[0]).all()
    peak = 1e-5 + 1e-4 * (abs(features.speed - 25.5) < 0.5)
    seen = features.speed[np.isfinite(moving_lines(system, features, peak)[0])]
    assert 19.0 < seen.min() < 22.0 and 29.0 < seen.max() < 31.5


def test_free_vibrations_are_left_from_the_last_contact_on(run):
    """As many as the slowest one leaves; a window in contact has no such line."""
    system, features = run
    peak = 1e-5 + 1e-4 * (abs(features.speed - 25.5) < 0.5)
    from_start = moving_lines(system, features, peak)[1]
    touched = int(np.flatnonzero(features.speed > 25.0)[0])
    share = np.where(np.arange(len(peak)) == touched, 0.3, 0.0)
    lines, left = moving_lines(system, replace(features, share=share), peak)
    assert np.isnan(lines[touched]) and left[touched + 1] == 1.0 and 0.0 < left[touched + 3] < left[touched + 2] < 1.0
    assert left[touched - 1] == from_start[touched - 1] < left[touched + 1]


def test_what_a_start_leaves_is_told_at_constant_speed_too():
    """From rest beside a lightly damped resonance: the beat has a reason, and what is left is less and less."""
    values = {"drive.speed": 28.5, "drive.duration": 8.0, "rotor.damping_ratio": 0.002, "rotor.eccentricity": 1e-5}
    rows = lines_of(rsc.check(rsc.Scene.from_toml(template("laval", "rest")).with_values(values)))
    told = [row.verdict for row in rows]
    assert set(told) <= {AGREES, NO_PREDICTION, OUTSIDE} and OUTSIDE in told
    assert all("free vibration since contact or start" in row.note for row in rows if row.verdict != AGREES)
