"""The hard dozen's judgement: an attempt gets its class from what happened, and a wrong answer is never called right."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[3] / "bench"))
from dozen import BLOWN, HONEST, NAN, REFUSED, RIGHT, STIFF, TIME, WRONG, classify
from dozen_oracles import block_bootstrap, ks_distance
from dozen_scenes import SCENES, SETTINGS


@pytest.mark.parametrize(
    ("facts", "expected"),
    [
        (("finished", True, 1e-3, 9e-4), RIGHT),
        (("finished", True, 1e-3, 2e-3), WRONG),
        (("finished", True, 1e-3, np.nan), WRONG),
        (("finished", False, 1e-3, np.nan), HONEST),
        (("finished", True, np.nan, np.nan), NAN),
        (("finished", True, 2.0, 5.0), BLOWN),
        (("blow-up", False, 1e-3, np.nan), BLOWN),
        (("time limit", False, 1e-3, np.nan), TIME),
        (("diverged", False, 2.0, np.nan), HONEST),
        (("step collapsed", False, 1e-3, np.nan), HONEST),
        (("stiff", False, 1e-3, np.nan), STIFF),
        (("refused", False, 0.0, np.nan), REFUSED),
    ],
)
def test_every_end_has_its_class(facts, expected):
    end, complete, motion, error = facts
    assert classify(end, complete, motion, error, oracle_scale=1e-3, limit=1e-3) == expected


def test_twelve_scenes_each_with_a_setting():
    assert {s.scene for s in SETTINGS} == set(SCENES) and len(SCENES) == 12


def test_distance_of_distributions_sees_a_shift_and_passes_a_repeat():
    """The limit from blocks of one sample lets a second one of the same process pass and stops one shifted by half its spread."""
    generator = np.random.default_rng(5)
    one, two = generator.normal(size=(2, 4000))
    limit = block_bootstrap(one)
    assert ks_distance(one, two) < limit < ks_distance(one, two + 0.5)
