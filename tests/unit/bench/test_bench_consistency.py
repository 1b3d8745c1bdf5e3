"""Check, motions, sweep, map and page of random machines contradict each other nowhere, and one that did would be found."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[3] / "bench"))
import rsc
from consistency import contradictions, lists_alike, of_letters, of_page, of_verdict, scene_of
from tiers import first


@pytest.mark.parametrize("number", first(range(5), 2))
def test_all_doors_say_the_same(number):
    found, lasting = contradictions(scene_of(2, number))
    assert lasting and found == []


def test_contradictions_are_found():
    report = rsc.check(scene_of(2, 0))
    (listed,) = report.motions
    first = replace(listed.motions[0], frequency=0.9 * listed.motions[0].frequency)
    other = replace(listed, motions=[first, *listed.motions[1:]])
    assert [kind for kind, _ in lists_alike(listed, other)] == ["check and motions"]
    branch = report.branches[0]
    whirl = branch.at(listed.speed)
    wrong = replace(first.predicted or listed.not_reached[0], label=branch.label, frequency=0.5 * whirl.frequency)
    assert [kind for kind, _ in of_letters(replace(report, motions=[replace(listed, not_reached=[wrong])]))] == ["letters"]
    quiet = replace(report.features, kind=np.full(len(report.features.kind), "no contact"))
    assert list(of_page(report)) == [] and list(of_verdict(replace(report, features=quiet), listed)) == []
