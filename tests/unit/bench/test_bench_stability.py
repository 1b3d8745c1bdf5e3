"""Studies of bench/stability: their oracles call a right motion right and a wrong one wrong."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[3] / "bench" / "stability"))

import dozen
from hard_scenes import SETTINGS
from oracles import ORACLES


def setting_of(scene, number=0):
    return [setting for setting in SETTINGS if setting.scene == scene][number]


@pytest.fixture(scope="module")
def wall():
    """Impacts on a wall of 2000 rotor stiffnesses, and its oracle."""
    case = dozen.make(setting_of("S1", 1))
    return case, ORACLES[case.setting.oracle](case)


@pytest.mark.parametrize(("method", "verdict"), [("rsc rk45", dozen.RIGHT), ("rsc taylor8", dozen.RIGHT), ("RK4", dozen.WRONG)])
def test_a_stiff_wall_is_right_with_located_switches_and_wrong_with_fixed_steps(wall, method, verdict):
    case, oracle = wall
    row = dozen.judge(case, method, oracle, dozen.attempt(case, method, limit=20.0))
    assert row["class"] == verdict


def test_an_oracle_notices_a_motion_that_is_off(wall):
    case, oracle = wall
    found = dozen.attempt(case, "rsc taylor8", limit=20.0)
    shifted = found._replace(states=np.roll(found.states, 1, axis=0))
    assert dozen.judge(case, "rsc taylor8", oracle, shifted)["class"] == dozen.WRONG


def test_a_gap_of_zero_is_refused_before_the_start():
    case = dozen.make(setting_of("S6", 2))
    assert dozen.run_rsc(case, "rk45", limit=1.0).end == dozen.REFUSED


def test_an_attempt_that_does_not_end_well_is_never_right():
    assert dozen.classify("time limit", False, 1.0, 0.0, 1.0, 1e-3) == dozen.TIME
    assert dozen.classify("finished", True, np.inf, 0.0, 1.0, 1e-3) == dozen.NAN
    assert dozen.classify("finished", True, 1.0, np.nan, 1.0, 1e-3) == dozen.WRONG
