"""The line at the rotor speed without contact, where the speed passes a resonance faster than the motion can follow."""

from dataclasses import replace

import numpy as np
import pytest

import rsc
from rsc.analysis.alone.free_vibration import free_vibrations
from rsc.analysis.follow.forward_rub import rub_growth
from rsc.analysis.paper.synchronous import forward_rub
from rsc.measure.kinds import Kind
from rsc.measure.words import AGREES, NOT_YET_STEADY, SYNCHRONOUS
from rsc.scene.files.templates import template
from rsc.show.words.reasons import note
from rsc.study.report.alone import moving_lines, settling_rates
from rsc.study.report.check import observed
from rsc.system.assemble import assemble

TWO_PI = 2.0 * np.pi


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
    assert np.isnan(moving_lines(system, features, np.full(len(features.speed), 1e-5))).all()
    peak = 1e-5 + 1e-4 * (abs(features.speed - 25.5) < 0.5)
    seen = features.speed[np.isfinite(moving_lines(system, features, peak))]
    assert 19.0 < seen.min() < 22.0 and 29.0 < seen.max() < 31.5
    # windows so far apart that the motion between them would take millions of steps
    assert np.isnan(moving_lines(system, replace(features, time=1e5 * features.time), peak)).all()


def test_rates_are_those_of_free_vibrations_and_of_the_rub(run):
    """A window in contact for a part of the time, or with a backward line, has none."""
    system, features = run
    slowest = max(vibration.growth_rate for vibration in free_vibrations(system, 25.0))
    assert settling_rates(system, features) == pytest.approx(np.full(len(features.speed), slowest), rel=1e-6)
    share = np.where(np.arange(len(features.speed)) < 3, 0.3, 1.0)
    speed = np.full(len(share), 10.0)  # where the rotor rubs forward
    kinds = np.where(share < 1.0, str(Kind.PARTIAL_RUB), str(Kind.FORWARD_RUB))
    quiet = replace(features, share=share, speed=speed, kind=kinds)
    rates = settling_rates(system, quiet)
    rub = rub_growth(system, forward_rub(system, TWO_PI * 10.0)[-1], TWO_PI * 10.0).rate
    assert np.isnan(rates[:3]).all() and rates[3:] == pytest.approx(np.full(len(share) - 3, rub), rel=1e-9)
    assert np.isnan(settling_rates(system, replace(quiet, kind=np.full(len(share), str(Kind.SLIDING))))).all()


def test_what_a_start_leaves_is_told_at_constant_speed_too():
    """From rest beside a lightly damped resonance: the beat has a reason, and what is left is less and less."""
    values = {"drive.speed": 28.5, "drive.duration": 8.0, "rotor.damping_ratio": 0.002, "rotor.eccentricity": 1e-5}
    rows = lines_of(rsc.check(rsc.Scene.from_toml(template("laval", "rest")).with_values(values)))
    told = [row.verdict for row in rows]
    assert set(told) == {AGREES, NOT_YET_STEADY}
    assert all("decays at 0.3" in note(row) for row in rows if row.verdict != AGREES)
