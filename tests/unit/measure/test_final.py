"""The motion in which a run ends, from stretches that are known."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from rsc.measure.final import final_motion
from rsc.measure.stretches import COLUMNS, Stretches

GAP, SPEED, LENGTH = 1e-3, 50.0, 0.1  # m, Hz, s of a stretch


def row(end, hertz, share=1.0, **more):
    """The facts of a stretch that turns at so many Hz."""
    values = dict.fromkeys(COLUMNS, 0.0) | {"rotor_max": 1.3e-3, "rotor_min": 1e-3, "friction_work": 1.0, "force_max": 7.0}
    values |= {"end": end, "turns": hertz * LENGTH, "contact_time": share * LENGTH, "onsets": 3.0 * (share < 1.0)} | more
    return [values[name] for name in COLUMNS]


def run(hertz, share=None, status="finished", speeds=(SPEED, SPEED), diameter=None, **more):
    """A run whose stretches turn at these rates (Hz)."""
    shares = [1.0] * len(hertz) if share is None else share
    rows = [row((i + 1) * LENGTH, *pair, **more) for i, pair in enumerate(zip(hertz, shares, strict=True))]
    contact = SimpleNamespace(gap=GAP, diameter=diameter)
    drive = SimpleNamespace(time=[0.0, len(rows) * LENGTH], speed=list(speeds))
    stretches = Stretches(np.array(rows).reshape(len(rows), len(COLUMNS)))
    scene = SimpleNamespace(contacts=[contact], clearances=[], drive=drive)
    return SimpleNamespace(scene=scene, status=status, stretches=lambda: stretches)


def test_the_last_quarter_tells():
    motion = final_motion(run([50.0] * 30 + [-37.3] * 10))
    assert motion.motion == "backward whirl, sliding" and motion.frequency == pytest.approx(-37.3)
    assert (motion.amplitude_max, motion.amplitude_min, motion.force_max) == (1.3e-3, 1e-3, 7.0)
    assert final_motion(run([-37.3] * 30 + [50.0] * 10)).motion == "forward rub"


def test_what_ended_before_the_last_stretches_is_not_what_it_ends_in():
    hertz, share = [-37.3] * 34 + [50.0] * 6, [1.0] * 34 + [0.0] * 6
    assert final_motion(run(hertz, share)).motion == "no contact"
    assert final_motion(run([50.0] * 34 + [-37.3] * 6, [0.0] * 34 + [1.0] * 6)).motion == "backward whirl, sliding"


def test_a_run_that_diverged_ran_away_and_one_without_a_stretch_is_not_resolved():
    assert final_motion(run([-37.3] * 8, status="diverged")).motion == "running away"
    assert final_motion(run([])).motion == "not resolved"
    assert math.isnan(final_motion(run([0.1, -0.2] * 8, share=[0.3] * 16)).frequency)


def test_the_drive_pays_for_friction():
    """A friction impulse of 2 N s and a work of 12 J in every 0.1 s on a radius of 20 mm."""
    motion = final_motion(run([-37.3] * 40, diameter=0.04, friction_impulse=2.0, drive_work=12.0, normal_impulse=10.0))
    assert motion.torque == pytest.approx(20.0 * 0.02) and motion.power == pytest.approx(120.0)
    assert motion.force_mean == pytest.approx(100.0)
    assert math.isnan(final_motion(run([-37.3] * 40)).torque)


def test_where_the_speed_changes_the_last_part_is_shorter():
    """At 100 Hz/s a tenth of a second; four stretches at least."""
    hertz = [50.0] * 36 + [-37.3] * 4
    assert final_motion(run(hertz)).motion == "partial rub"
    assert final_motion(run(hertz, speeds=(0.0, 400.0))).motion == "backward whirl, sliding"
