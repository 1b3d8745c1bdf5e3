"""Whirls of every pressed set followed over the rotor speed: at every speed they are those that are looked for there anew."""

import numpy as np
import pytest

from rsc.analysis.follow.branches import LOOKED_AT, set_branches
from rsc.analysis.follow.events import CREEPING, OSCILLATORY
from rsc.analysis.follow.lines import FOLD, RANGE_END
from rsc.analysis.several.predict import predict_several
from rsc.errors import SolverError
from rsc.system.assemble import assemble
from several_systems import random_several
from tiers import first
from two_seals import pump


@pytest.mark.parametrize("seed", first([1, 2]))
def test_at_every_speed_they_are_the_whirls_of_that_speed(seed):
    """Among them two pairs that begin at a fold; more speeds than those at which all whirls are looked for."""
    system, speeds = random_several(np.random.default_rng(seed)), np.linspace(60.0, 90.0, 3 * LOOKED_AT)
    branches = set_branches(system, speeds, 0)
    missed = 0
    for speed in speeds[1:-1:5]:
        own = [(branch, branch.whirls[i]) for branch in branches for i in np.flatnonzero(branch.speed == speed)]
        wanted = predict_several(system, speed)
        followed = sorted((branch.pressed, whirl.frequency) for branch, whirl in own)
        known = sorted((whirl.pressed, whirl.frequency) for whirl in wanted)
        missed += len(known) - len(followed)
        for pressed, frequency in followed:
            assert min(abs(frequency / other - 1.0) for names, other in known if names == pressed) < 1e-8
        for _, whirl in own:
            twin = min(wanted, key=lambda other: (other.pressed != whirl.pressed, abs(other.frequency - whirl.frequency)))
            assert whirl.growth_rate == pytest.approx(twin.growth_rate, rel=1e-5, abs=1e-5)
            for name, at in whirl.contacts.items():
                assert at.normal_force == pytest.approx(twin.contacts[name].normal_force, rel=1e-6)
    assert missed == 0
    ends = {event.cause for branch in branches for event in (branch.begin, branch.end)}
    assert ends == {RANGE_END, FOLD} and len({branch.label for branch in branches}) == len(branches)


def test_folds_and_changes_of_stability_are_located():
    """Two whirls of the set more on one side of a fold; the growth rate changes its sign where it is said to."""
    system, folds, changes = random_several(np.random.default_rng(1)), 0, 0
    for branch in set_branches(system, np.linspace(60.0, 100.0, 21), 0):
        for end, inside in ((branch.begin, 1.0), (branch.end, -1.0)):
            if end.cause == FOLD:
                within, beyond = (whirls_of(system, branch, end.value * (1.0 + inside * off)) for off in (1e-7, -1e-7))
                assert len(within) == len(beyond) + 2
                folds += 1
        for event in branch.events:
            if event.cause in (CREEPING, OSCILLATORY):
                sides = [whirls_of(system, branch, event.value * (1.0 + off)) for off in (-1e-6, 1e-6)]
                below, above = (min(whirls, key=lambda w: abs(w.frequency - event.frequency)).growth_rate for whirls in sides)
                assert (below < 0.0 < above) if event.holds == "below" else (above < 0.0 < below)
                changes += 1
    assert folds > 1 and changes > 0


def whirls_of(system, branch, speed):
    """The whirls of a branch's set at a speed."""
    return [whirl for whirl in predict_several(system, speed) if whirl.pressed == branch.pressed]


@pytest.mark.nightly
def test_a_run_down_has_the_same_branches_and_loses_its_stability_the_other_way():
    system, speeds = random_several(np.random.default_rng(1)), np.linspace(78.0, 100.0, 45)
    up, down = set_branches(system, speeds, 0), set_branches(system, speeds[::-1], 0)
    for one, other in zip(up, down, strict=True):
        assert one.pressed == other.pressed and np.array_equal(one.speed, other.speed)
        assert one.frequency == pytest.approx(other.frequency, rel=1e-8)
    (lost,) = [branch for branch in down if branch.lost]
    (kept,) = [branch for branch in up if branch.label == lost.label]
    assert not kept.lost and lost.decays[-1] and not lost.decays[0]


def test_what_is_of_one_contact_is_told_at_the_one_that_was_asked_for():
    """Also where that is not pressed, as for the whirl at the bush alone."""
    system = assemble(pump())
    seal, bush = (set_branches(system, [40.0, 60.0], at) for at in (0, 1))
    for one, other in zip(seal, bush, strict=True):
        assert one.pressed == other.pressed
        assert one.amplitude[0] == pytest.approx(abs(one.whirls[0].rotor_shape[1]), rel=1e-12)
        assert other.amplitude[0] == pytest.approx(abs(one.whirls[0].rotor_shape[2]), rel=1e-12)
        assert one.normal_force[0] == one.at_contacts["seal"]["normal_force"][0]
        assert other.normal_force[0] == one.at_contacts["bush"]["normal_force"][0]
    alone = next(branch for branch in seal if branch.pressed == ("bush",))
    assert alone.normal_force[0] == 0.0 and alone.whirls[0].synchronous.consistent.force == 0.0
    low, high = alone.whirls[0].synchronous.consistent.envelope
    assert low < alone.amplitude[0] < high


def test_without_gyroscopics_whirls_are_the_same_at_every_speed_and_their_unbalance_is_not():
    branches = set_branches(assemble(pump()), np.linspace(30.0, 90.0, 20), 0)
    lines = np.array([whirl.synchronous.consistent.amplitude for whirl in branches[0].whirls])
    assert branches[0].pressed == ("seal", "bush") and np.ptp(branches[0].frequency) == 0.0 and np.ptp(lines) > 0.1 * lines.max()
    assert branches[0].stable.all() and not any(branch.stable.any() for branch in branches[1:])


def test_an_offset_is_refused():
    with pytest.raises(SolverError, match=r"contact\.bush\.offset"):
        set_branches(assemble(pump(bush={"offset": [1e-5, 0.0]})), [50.0], 0)
