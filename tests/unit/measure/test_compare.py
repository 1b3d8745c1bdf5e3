"""Verdicts on made-up runs: every kind of row and change, from features whose answer is known."""

from dataclasses import replace

import numpy as np
import pytest

from rsc.analysis.branches import branches
from rsc.measure.verdict import AGREES, DIFFERS, NO_PREDICTION, NO_WHIRL, OUTSIDE, Features, Rolls, Steady, compare, summary
from systems import reference

GAP = 1e-3
SPEEDS = np.linspace(25.0, 145.0, 121)
STEADY = Steady(alone=1e-4 + 1e-9 * SPEEDS, rub=2e-3 + 1e-9 * SPEEDS)


@pytest.fixture(scope="module")
def found():
    return branches(reference("gyroscopic_transition"), SPEEDS)


def on_branch(branch, speeds=SPEEDS):
    """Features of a run that follows a branch exactly, at 1 Hz/s."""
    whirls = [branch.at(speed) for speed in speeds]
    nothing = np.full(speeds.shape, np.nan)
    return Features(
        speed=speeds,
        time=np.abs(speeds - speeds[0]),
        share=np.ones(speeds.shape),
        frequency=np.array([w.frequency for w in whirls]),
        amplitude=np.array([w.rotor_amplitude for w in whirls]),
        second_frequency=nothing,
        second_amplitude=nothing,
        synchronous=np.array([w.synchronous.consistent.amplitude for w in whirls]),
        rolling=np.zeros(speeds.shape),
    )


def verdicts(rows, quantity="whirl frequency"):
    return [row.verdict for row in rows if row.quantity == quantity]


def test_a_run_on_a_predicted_whirl_agrees(found):
    for label in "AB":
        branch = next(b for b in found if b.label == label)
        rows, transitions = compare(on_branch(branch), found, STEADY, GAP)
        assert {row.verdict for row in rows} == {AGREES} and {row.branch for row in rows} == {label}
        assert transitions == []
        assert summary(rows, transitions, "finished").startswith("agrees")


@pytest.mark.parametrize("factor, verdict", [(1.004, AGREES), (1.006, DIFFERS), (0.994, DIFFERS)])
def test_frequency_tolerance_is_half_a_percent(found, factor, verdict):
    branch = next(b for b in found if b.label == "B")
    features = on_branch(branch, SPEEDS[60:])
    rows, _ = compare(replace(features, frequency=factor * features.frequency), found, STEADY, GAP)
    assert set(verdicts(rows)) == {verdict}
    assert rows[0].difference == pytest.approx(factor - 1.0, rel=1e-9)


def test_no_line_is_no_whirl_and_no_branch_no_prediction(found):
    features = on_branch(found[1])
    rows, _ = compare(replace(features, amplitude=0.0 * features.amplitude), found, STEADY, GAP)
    assert set(verdicts(rows)) == {NO_WHIRL}
    rows, transitions = compare(features, [], STEADY, GAP)
    assert set(verdicts(rows)) == {NO_PREDICTION}
    assert summary(rows, transitions, "finished").startswith("differs in places")


def test_lost_contact_puts_a_difference_outside_the_assumptions(found):
    features = on_branch(next(b for b in found if b.label == "B"))
    lost = replace(features, frequency=1.02 * features.frequency, share=0.9 + 0.0 * SPEEDS)
    rows, _ = compare(lost, found, STEADY, GAP)
    assert set(verdicts(rows)) == {OUTSIDE}
    assert "permanent contact (90 % simulated)" in rows[0].note


def joined(found, first, second, jump):
    """A run on one branch up to a speed and on another beyond."""
    a, b = (on_branch(next(x for x in found if x.label == label)) for label in (first, second))
    late = a.speed > jump
    lines = ("frequency", "amplitude", "synchronous")
    return replace(a, **{name: np.where(late, getattr(b, name), getattr(a, name)) for name in lines})


def test_a_jump_after_the_loss_of_stability_is_explained_by_the_growth(found):
    (change,) = compare(joined(found, "A", "B", 110.0), found, STEADY, GAP)[1]
    assert (change.before, change.after, change.verdict) == ("A", "B", AGREES)
    assert change.predicted == pytest.approx(68.6, abs=0.1)
    whirl = next(b for b in found if b.label == "A")
    speeds = np.linspace(change.predicted, 111.0, 2001)
    growth = np.interp(speeds, whirl.speed, whirl.growth_rate)
    assert change.folds == pytest.approx(np.trapezoid(growth, speeds), rel=0.02)  # 1 Hz/s: speed is time


def test_a_jump_before_the_loss_of_stability_is_a_disagreement(found):
    rows, (change,) = compare(joined(found, "A", "B", 50.0), found, STEADY, GAP)
    assert change.verdict == DIFFERS
    assert summary(rows, [change], "finished").startswith("simulation and prediction disagree")


def test_a_jump_too_late_for_any_disturbance_is_a_disagreement(found):
    features = joined(found, "A", "B", 130.0)
    slow = replace(features, time=10.0 * features.time)
    (change,) = compare(slow, found, STEADY, GAP)[1]
    assert change.folds > 40.0 and change.verdict == DIFFERS


def test_the_new_line_is_seen_before_it_takes_over(found):
    features = joined(found, "A", "B", 110.0)
    early = (features.speed > 100.0) & (features.speed <= 110.0)
    new = on_branch(next(b for b in found if b.label == "B")).frequency
    (change,) = compare(replace(features, second_frequency=np.where(early, new, np.nan)), found, STEADY, GAP)[1]
    assert change.first_seen == 101.0 and change.taken_over == 111.0


def test_a_stopped_run_is_said_so(found):
    rows, transitions = compare(on_branch(found[1]), found, STEADY, GAP)
    assert summary(rows, transitions, "diverged").startswith("the run stopped early (diverged)")


@pytest.mark.parametrize("share, size, note", [(0.0, 1e-4, "without contact"), (1.0, 2e-3, "forward rub")])
def test_the_synchronous_line_without_a_whirl_is_compared_with_its_own_motion(found, share, size, note):
    features = on_branch(found[1])
    line = {"amplitude": 0.0 * SPEEDS, "frequency": np.nan * SPEEDS, "synchronous": 1.01 * size + 0.0 * SPEEDS}
    quiet = replace(features, share=share + 0.0 * SPEEDS, **line)
    rows, _ = compare(quiet, found, STEADY, GAP)
    assert set(verdicts(rows, "synchronous line")) == {AGREES} and rows[2].note == note
    rows, _ = compare(replace(quiet, synchronous=1.1 * quiet.synchronous), found, STEADY, GAP)
    assert set(verdicts(rows, "synchronous line")) == {DIFFERS}


def test_a_line_in_partial_contact_near_no_whirl_is_outside_the_assumptions(found):
    features = on_branch(next(b for b in found if b.label == "B"))
    far = replace(features, frequency=1.5 * features.frequency)
    rows, _ = compare(replace(far, share=0.3 + 0.0 * SPEEDS), found, STEADY, GAP)
    assert set(verdicts(rows)) == {OUTSIDE}
    assert set(verdicts(compare(far, found, STEADY, GAP)[0])) == {NO_PREDICTION}


def test_a_line_that_still_settles_after_a_change_is_outside_the_assumptions(found):
    features = joined(found, "A", "B", 110.0)
    off = np.where(features.speed == 112.0, 1.006, 1.0)
    late = np.where(features.speed == 140.0, 1.006, 1.0)
    rows, _ = compare(replace(features, frequency=off * late * features.frequency), found, STEADY, GAP)
    by_speed = {row.speed: row for row in rows if row.quantity == "whirl frequency"}
    assert by_speed[112.0].verdict == OUTSIDE and "changing from A to B" in by_speed[112.0].note
    assert by_speed[140.0].verdict == DIFFERS


def rolling(features, loss=0.0):
    """The same windows, all rolling, and Rolls that they follow but for nine tenths of the amplitude that may be lost."""
    simulated = replace(features, rolling=np.ones(SPEEDS.shape), amplitude=(1.0 - 0.9 * loss) * features.amplitude)
    return simulated, Rolls(features.frequency, features.amplitude, np.full(SPEEDS.shape, -1.0), np.full(SPEEDS.shape, loss))


def test_a_window_that_rolls_is_compared_with_the_whirl_that_rolls_not_with_those_that_slide(found):
    features, rolls = rolling(on_branch(next(b for b in found if b.label == "B")))
    rows, transitions = compare(features, found, STEADY, GAP, rolls=rolls)
    assert set(verdicts(rows)) == {AGREES} == set(verdicts(rows, "whirl amplitude"))
    assert {row.branch for row in rows} == {"roll"} and transitions == []
    assert set(verdicts(rows, "synchronous line")) == {NO_PREDICTION}
    off = replace(features, frequency=1.006 * features.frequency)
    assert set(verdicts(compare(off, found, STEADY, GAP, rolls=rolls)[0])) == {DIFFERS}
    lifting = replace(off, share=0.9 + 0.0 * SPEEDS)
    rows, _ = compare(lifting, found, STEADY, GAP, rolls=rolls)
    assert set(verdicts(rows)) == {OUTSIDE} and "permanent contact (90 % simulated)" in rows[0].note
    unstable = replace(rolls, growth_rate=-rolls.growth_rate)
    rows, _ = compare(off, found, STEADY, GAP, rolls=unstable)
    assert set(verdicts(rows)) == {OUTSIDE} and "stable" in rows[0].note
    rows, _ = compare(features, found, STEADY, GAP, rolls=unstable)
    assert set(verdicts(rows)) == {AGREES} and "unstable" in rows[0].note


def test_a_line_that_moves_during_a_window_explains_a_smaller_amplitude_but_no_frequency(found):
    features, rolls = rolling(on_branch(next(b for b in found if b.label == "B")), loss=0.3)
    rows, _ = compare(features, found, STEADY, GAP, rolls=rolls)
    assert set(verdicts(rows)) == {AGREES} and set(verdicts(rows, "whirl amplitude")) == {OUTSIDE}
    assert "30 % lost as it moves" in rows[1].note
    more = replace(features, amplitude=0.95 * features.amplitude, frequency=1.006 * features.frequency)
    rows, _ = compare(more, found, STEADY, GAP, rolls=rolls)
    assert set(verdicts(rows)) == {DIFFERS} == set(verdicts(rows, "whirl amplitude"))


def test_rolling_near_no_whirl_that_is_predicted_to_is_told(found):
    features, rolls = rolling(on_branch(next(b for b in found if b.label == "B")))
    for known in (None, replace(rolls, frequency=np.full(SPEEDS.shape, np.nan))):
        rows, _ = compare(replace(features, frequency=3.0 * features.frequency), found, STEADY, GAP, rolls=known)
        assert set(verdicts(rows)) == {NO_PREDICTION} and "rolls for 100 % of the time" in rows[0].note
