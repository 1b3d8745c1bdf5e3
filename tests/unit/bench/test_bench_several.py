"""Whirls at several contacts: the first of bench/several.py, predicted by the analysis and simulated by the kernel."""

import itertools
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[3] / "bench"))

from several import errors, whirls


@pytest.mark.nightly
@pytest.mark.parametrize("count", [2])
def test_a_predicted_stable_whirl_is_the_end_of_a_run_beside_it(count):
    at_all = ((scene, whirl) for scene, whirl in whirls(3) if len(whirl.pressed) == count)
    fast = (pair for pair in at_all if pair[1].stable and pair[1].growth_rate < -4.0)
    for scene, whirl in itertools.islice(fast, 1):
        assert errors(scene, whirl).max() < 1e-5
