"""Verdicts on made-up runs: every kind of row and change, from features whose answer is known."""

from dataclasses import fields, replace

import numpy as np
import pytest

from rsc.analysis.follow.branches import branches
from rsc.measure.changes import transitions
from rsc.measure.comparison import compare
from rsc.measure.kinds import Kind
from rsc.measure.resonances import resonances
from rsc.measure.verdict import Window
from rsc.measure.windows import Best, Features, Rolls, Steady
from rsc.measure.words import AGREES, DIFFERS, NO_PREDICTION, NO_WHIRL, NOT_RESOLVED, NOT_YET_STEADY, OUTSIDE
from rsc.show.words.headline import summary
from rsc.show.words.reasons import note, note_of_change
from systems import reference

GAP = 1e-3
SPEEDS = np.linspace(25.0, 145.0, 121)
STEADY = Steady(alone=1e-4 + 1e-9 * SPEEDS, rub=2e-3 + 1e-9 * SPEEDS, moving=np.nan * SPEEDS, growth_rate=np.nan * SPEEDS)
AMPLITUDES = ("size", "amplitude", "stator_amplitude")


@pytest.fixture(scope="module")
def found():
    return branches(reference("gyroscopic_transition"), SPEEDS)


def named(found, label):
    return next(branch for branch in found if branch.label == label)


def on_branch(branch, speeds=SPEEDS):
    """Features of a run that follows a branch exactly, at 1 Hz/s in windows of 1 s."""
    whirls = [branch.at(speed) for speed in speeds]
    amplitude = np.array([w.rotor_amplitude for w in whirls])
    synchronous = np.array([w.synchronous.consistent.amplitude for w in whirls])
    nothing = np.full(speeds.shape, np.nan)
    return Features(
        window=1.0,
        rate=2000.0,
        speed=speeds,
        time=np.abs(speeds - speeds[0]),
        share=np.ones(speeds.shape),
        frequency=np.array([w.frequency for w in whirls]),
        size=amplitude,
        amplitude=amplitude,
        stator_amplitude=0.1 * amplitude,
        other_frequency=np.stack([nothing, nothing], axis=1),
        other_size=np.stack([nothing, nothing], axis=1),
        synchronous=synchronous,
        kind=kinds(Kind.SLIDING, speeds),
        why=kinds("", speeds),
        turning=np.array([w.frequency for w in whirls]),
        rolling=np.zeros(speeds.shape),
        largest=amplitude,
        peak_to_peak=2.0 * amplitude,
        stator_largest=0.1 * amplitude,
        force=np.ones(speeds.shape),
        force_max=np.ones(speeds.shape),
    )


def kinds(kind, speeds=SPEEDS):
    """One kind, or reason, in all windows."""
    return np.full(np.shape(speeds), str(kind), dtype="U40")


STEADY_KINDS = {0.0: kinds(Kind.NO_CONTACT), 1.0: kinds(Kind.FORWARD_RUB)}


def scaled(features, factor, *names):
    return replace(features, **{name: factor * getattr(features, name) for name in names})


def rows_of(*args, **more):
    """The comparisons of all windows."""
    return [row for window in compare(*args, **more) for row in window]


def windows_of(rows):
    """The windows of comparisons in their order."""
    return [Window(*own) for own in zip(*[iter(rows)] * 3, strict=True)]


def verdicts(rows, quantity="whirl frequency"):
    return [row.verdict for row in rows if row.quantity == quantity]


def test_a_run_on_a_predicted_whirl_agrees(found):
    for label in "AB":
        features = on_branch(named(found, label))
        rows = rows_of(features, found, STEADY)
        assert {row.verdict for row in rows} == {AGREES} and {row.branch for row in rows} == {label}
        assert {row.by for row in rows} == {"first order"}
        assert transitions(features, found, {}) == []


@pytest.mark.parametrize("factor, verdict", [(1.004, AGREES), (1.006, DIFFERS), (0.994, DIFFERS)])
def test_frequency_tolerance_is_half_a_percent(found, factor, verdict):
    features = on_branch(named(found, "B"), SPEEDS[60:])
    rows = rows_of(scaled(features, factor, "frequency"), found, STEADY)
    assert set(verdicts(rows)[5:]) == {verdict}
    assert rows[0].difference == pytest.approx(factor - 1.0, rel=1e-9)


def test_a_difference_that_stays_where_the_motion_should_decay_is_one(found):
    """Of the first windows only a disturbance from elsewhere is excused, and only as far as it can remain."""
    features = scaled(on_branch(named(found, "B"), SPEEDS[60:]), 1.03, *AMPLITUDES)
    told = verdicts(rows_of(features, found, STEADY), "whirl amplitude")
    assert told[0] == NOT_YET_STEADY and set(told[5:]) == {DIFFERS}


def test_a_difference_that_decays_at_the_predicted_rate_is_not_yet_steady(found):
    branch = named(found, "B")
    features = on_branch(branch, SPEEDS[60:])
    rates = np.array([branch.at(speed).growth_rate for speed in features.speed])
    assert (rates < 0.0).all()
    exponent = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(features.time))])
    for speed_up, verdict in ((1.05, NOT_YET_STEADY), (0.5, DIFFERS)):
        wave = {name: getattr(features, name) * (1.0 - 0.3 * np.exp(speed_up * exponent)) for name in AMPLITUDES}
        rows = rows_of(replace(features, **wave), found, STEADY)
        late = [row for row in rows if row.quantity == "whirl amplitude" and 0.02 < abs(row.difference) < 0.1]
        assert late and {row.verdict for row in late} == {verdict}
        assert verdict == DIFFERS or "decays at" in note(late[0])


def test_behind_a_place_without_a_steady_whirl_the_motion_settles_anew(found):
    branch = named(found, "B")
    features = on_branch(branch, SPEEDS[60:])
    rates = np.array([branch.at(speed).growth_rate for speed in features.speed])
    late = features.time >= 20.0
    decay = np.exp(np.where(late, np.cumsum(np.where(late, rates, 0.0)), -np.inf))
    wave = {name: getattr(features, name) * (1.0 - 0.2 * decay) for name in AMPLITUDES}
    upset = best_of(features, reached=np.where(features.time == 19.0, 0.9, np.nan))
    for best, verdict in ((upset, NOT_YET_STEADY), (best_of(features), DIFFERS)):
        rows = rows_of(replace(features, **wave), found, STEADY, best=best)
        told = [row for row in rows if row.quantity == "whirl amplitude" and 0.025 < abs(row.difference) < 0.1]
        assert told and {row.verdict for row in told} == {verdict}


def test_a_difference_that_grows_on_an_unstable_whirl_is_covered_by_its_growth(found):
    branch = named(found, "A")
    features = on_branch(branch, SPEEDS[SPEEDS > 80.0])
    assert not any(branch.at(speed).stable for speed in features.speed)
    rates = np.array([branch.at(speed).growth_rate for speed in features.speed])
    exponent = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(features.time))])
    growing = 1.0 - 1e-4 * np.exp(0.9 * exponent)
    wave = {name: getattr(features, name) * np.maximum(growing, 0.9) for name in AMPLITUDES}
    told = [row for row in rows_of(replace(features, **wave), found, STEADY) if row.quantity == "whirl amplitude"]
    assert told[0].verdict == AGREES and "not yet left" in note(told[0])
    leaving = [row for row in told if 0.02 < abs(row.difference) < 0.09]
    assert leaving and {row.verdict for row in leaving} == {OUTSIDE} and "departure from an unstable whirl" in note(leaving[0])
    assert told[-1].verdict == NO_PREDICTION and "must have been left" in note(told[-1])
    sudden = replace(features, **{name: getattr(features, name) * np.where(features.time < 1.0, 1.0, 0.5) for name in AMPLITUDES})
    assert verdicts(rows_of(sudden, found, STEADY), "whirl amplitude")[1] == DIFFERS


def test_what_does_not_turn_backward_is_no_whirl_and_no_branch_no_prediction(found):
    features = on_branch(found[1])
    rows = rows_of(replace(features, kind=kinds(Kind.PARTIAL_RUB)), found, STEADY)
    assert set(verdicts(rows)) == {NO_WHIRL} and note(rows[0]) == "partial rub"
    unknown = replace(features, kind=kinds(Kind.NOT_RESOLVED), why=kinds("1.2 turns: too short"))
    rows = rows_of(unknown, found, STEADY)
    assert set(verdicts(rows)) == {NOT_RESOLVED} and note(rows[0]) == "1.2 turns: too short"
    rows = rows_of(features, [], STEADY)
    assert set(verdicts(rows)) == {NO_PREDICTION}


def test_a_whirl_of_the_stator_alone_is_a_whirl(found):
    """The line is judged on the relative motion, its size on the body that moves more."""
    branch = named(found, "B")
    features = replace(on_branch(branch, SPEEDS[60:]), amplitude=1e-5 * GAP * np.ones(61))
    stator = np.array([branch.at(speed).stator_amplitude for speed in features.speed])
    rows = rows_of(replace(features, stator_amplitude=stator), found, STEADY)
    assert set(verdicts(rows)) == {AGREES} == set(verdicts(rows, "whirl amplitude"))
    assert note(rows[1]) == "of the stator"
    rows = rows_of(replace(features, stator_amplitude=1.1 * stator), found, STEADY)
    assert set(verdicts(rows, "whirl amplitude")[5:]) == {DIFFERS}


def test_too_few_periods_in_a_window_are_not_resolved(found):
    features = replace(on_branch(named(found, "B"), SPEEDS[60:]), window=0.06)
    assert set(verdicts(rows_of(features, found, STEADY))) == {NOT_RESOLVED}
    assert "periods in a window" in note(rows_of(features, [], STEADY)[0])


def test_a_contact_that_turns_too_fast_for_the_samples_is_not_resolved(found):
    features = replace(on_branch(named(found, "B"), SPEEDS[60:]), turning=np.full(61, -1001.0))
    features = scaled(features, 0.0, *AMPLITUDES)
    rows = rows_of(features, found, STEADY)
    assert set(verdicts(rows)) == {NOT_RESOLVED} and "output.rate = 2000 Hz" in note(rows[0])
    assert NOT_RESOLVED not in verdicts(rows_of(replace(features, turning=np.full(61, -999.0)), found, STEADY))


def test_an_effect_as_large_as_the_prediction_itself_leaves_none(found):
    features = scaled(on_branch(named(found, "B"), SPEEDS[60:]), 0.5, *AMPLITUDES)
    size = np.stack([0.6 * features.size, 0.0 * features.size], axis=1)
    other = replace(features, other_frequency=-20.0 * np.ones((61, 2)), other_size=size)
    rows = rows_of(other, found, STEADY)
    assert set(verdicts(rows, "whirl amplitude")[5:]) == {NO_PREDICTION} and "too far from a steady motion" in note(rows[-2])


def test_frequency_and_amplitude_agree_only_for_one_line(found):
    """A frequency that fits beside an amplitude far off for a known reason is a coincidence, and so the other way round."""
    features = on_branch(named(found, "B"), SPEEDS[60:])
    size = np.stack([0.6 * features.size, 0.0 * features.size], axis=1)
    two_lines = replace(features, other_frequency=-20.0 * np.ones((61, 2)), other_size=size)
    rows = rows_of(scaled(two_lines, 0.1, *AMPLITUDES, "other_size"), found, STEADY)
    assert AGREES not in verdicts(rows)
    rows = rows_of(scaled(two_lines, 1.05, "frequency"), found, STEADY)
    assert AGREES not in verdicts(rows, "whirl amplitude")
    rows = rows_of(scaled(features, 0.1, *AMPLITUDES), found, STEADY)
    assert set(verdicts(rows)[5:]) == {AGREES} and set(verdicts(rows, "whirl amplitude")[5:]) == {DIFFERS}


def test_another_line_excuses_what_its_square_can_make(found):
    features = scaled(on_branch(named(found, "B"), SPEEDS[60:]), 0.96, *AMPLITUDES)
    for second, verdict in ((0.11, OUTSIDE), (0.09, DIFFERS)):
        size = np.stack([second * features.size, 0.0 * features.size], axis=1)
        other = replace(features, other_frequency=-20.0 * np.ones((61, 2)), other_size=size)
        told = [row for row in rows_of(other, found, STEADY) if row.quantity == "whirl amplitude"]
        assert {row.verdict for row in told[5:]} == {verdict}
        assert verdict == DIFFERS or "another backward line" in note(told[-1])


def test_a_constant_load_excuses_what_its_square_can_make(found):
    features = scaled(on_branch(named(found, "B"), SPEEDS[60:]), 0.97, *AMPLITUDES)
    size = features.size.max()
    for load, verdict in ((0.1 * size, OUTSIDE), (0.05 * size, DIFFERS)):
        rows = rows_of(features, found, STEADY, load=load)
        assert set(verdicts(rows, "whirl amplitude")[5:]) == {verdict}


def test_an_unbalance_line_that_is_not_steady_excuses_what_its_square_can_make(found):
    features = scaled(on_branch(named(found, "B"), SPEEDS[60:]), 0.96, *AMPLITUDES)
    for factor, verdict in ((0.12, OUTSIDE), (0.06, DIFFERS)):
        moving = replace(features, synchronous=np.hypot(features.synchronous, factor * features.size))
        rows = rows_of(moving, found, STEADY)
        assert set(verdicts(rows, "whirl amplitude")[5:]) == {verdict}


def best_of(features, **values):
    nothing = np.full(features.speed.shape, np.nan)
    return Best(**{field.name: values.get(field.name, nothing) for field in fields(Best)})


def test_a_window_is_compared_with_the_best_prediction_at_hand(found):
    features = scaled(on_branch(named(found, "B"), SPEEDS[60:]), 0.9, *AMPLITUDES)
    best = best_of(
        features,
        frequency=features.frequency,
        amplitude=features.amplitude,
        stator_amplitude=features.stator_amplitude,
        synchronous=features.synchronous,
    )
    rows = rows_of(features, found, STEADY, best=best)
    assert {row.verdict for row in rows} == {AGREES} and {row.by for row in rows} == {"balance"}
    rows = rows_of(features, found, STEADY, best=replace(best, amplitude=1.03 * features.amplitude))
    assert set(verdicts(rows, "whirl amplitude")[5:]) == {DIFFERS}


def test_a_difference_where_the_unbalance_leaves_no_steady_whirl_has_no_prediction(found):
    features = scaled(on_branch(named(found, "B"), SPEEDS[60:]), 0.9, *AMPLITUDES)
    rows = rows_of(features, found, STEADY, best=best_of(features, reached=0.7 * np.ones(61)))
    assert set(verdicts(rows, "whirl amplitude")[5:]) == {NO_PREDICTION}
    assert "no steady whirl with more than 70 %" in note(rows[-2])


def joined(found, first, second, jump):
    """A run on one branch up to a speed and on another beyond."""
    a, b = (on_branch(named(found, label)) for label in (first, second))
    late = a.speed > jump
    lines = ("frequency", "synchronous", *AMPLITUDES)
    return replace(a, **{name: np.where(late, getattr(b, name), getattr(a, name)) for name in lines})


def test_a_jump_after_the_loss_of_stability_is_explained_by_the_growth(found):
    (change,) = transitions(joined(found, "A", "B", 110.0), found, {})
    assert (change.before, change.after, change.verdict) == ("A", "B", AGREES)
    assert change.predicted == pytest.approx(68.6, abs=0.1)
    whirl = named(found, "A")
    speeds = np.linspace(change.predicted, 111.0, 2001)
    growth = np.interp(speeds, whirl.speed, whirl.growth_rate)
    assert change.folds == pytest.approx(np.trapezoid(growth, speeds), rel=0.02)  # 1 Hz/s: speed is time


def test_a_whirl_that_ends_after_it_lost_its_stability_is_left_for_the_loss(found):
    """Cut off at 80 Hz, whirl A has lost its stability at 68.6 Hz where it ends."""
    whole = named(found, "A")
    keep = whole.speed <= 80.0
    cut = replace(whole, whirls=tuple(w for w, k in zip(whole.whirls, keep, strict=True) if k), values=whole.values[keep])
    others = [branch for branch in found if branch is not whole]
    features = joined(found, "A", "B", 79.0)
    (change,) = transitions(features, [cut, *others], {})
    assert change.predicted == pytest.approx(68.6, abs=0.1)


def test_a_jump_before_the_loss_of_stability_is_a_disagreement(found):
    features = joined(found, "A", "B", 50.0)
    (change,) = transitions(features, found, {})
    assert change.verdict == DIFFERS
    rows = rows_of(features, found, STEADY)
    assert summary(windows_of(rows), [change], "finished").startswith("simulation and prediction disagree on a change of whirl")


def test_a_line_that_leaves_a_whirl_unstable_everywhere_is_no_disagreement(found):
    whole = named(found, "A")
    never = replace(whole, whirls=tuple(replace(w, growth_rate=5.0, stable=False) for w in whole.whirls), lost=())
    others = [branch for branch in found if branch is not whole]
    (change,) = transitions(joined(found, "A", "B", 50.0), [never, *others], {})
    assert change.verdict == NO_PREDICTION and "unstable at all speeds" in note_of_change(change)


@pytest.mark.parametrize("field, value, words", [("reached", 0.8, "more than 80 % of it"), ("growth_rate", 2.0, "unstable")])
def test_a_jump_is_explained_where_the_unbalance_ends_the_whirl(found, field, value, words):
    features = joined(found, "A", "B", 50.0)
    at = np.where(np.abs(SPEEDS - 48.0) < 1.5, value, np.nan)
    (change,) = transitions(features, found, {}, best_of(features, **{field: at}))
    assert change.verdict == AGREES and change.predicted == 47.0 and words in note_of_change(change)
    (change,) = transitions(features, found, {}, best_of(features, **{field: np.roll(at, -20)}))
    assert change.verdict == DIFFERS  # that was long before


def test_a_jump_too_late_for_any_disturbance_is_a_disagreement(found):
    features = joined(found, "A", "B", 130.0)
    (change,) = transitions(replace(features, time=10.0 * features.time), found, {})
    assert change.folds > 40.0 and change.verdict == DIFFERS


def test_the_new_line_is_seen_before_it_takes_over(found):
    features = joined(found, "A", "B", 110.0)
    early = (features.speed > 100.0) & (features.speed <= 110.0)
    new = on_branch(named(found, "B")).frequency
    others = np.stack([-300.0 + 0.0 * new, np.where(early, new, np.nan)], axis=1)
    (change,) = transitions(replace(features, other_frequency=others), found, {})
    assert change.first_seen == 101.0 and change.taken_over == 111.0


def test_the_summary_counts_windows_and_quantities(found):
    features = on_branch(named(found, "B"))
    off = replace(features, amplitude=np.where(SPEEDS > 141.5, 1.1, 1.0) * features.amplitude)
    rows = rows_of(off, found, STEADY)
    told = summary(windows_of(rows), [], "finished")
    n = len(SPEEDS)
    agree = f"frequency agrees within 0.5 % in {n} of {n} windows with a backward line, amplitude within 2 % in {n - 4}"
    assert told.startswith(agree)
    assert told.endswith("other amplitudes: 4 differs")
    assert summary(windows_of(rows), [], "diverged").startswith("the run stopped early (diverged): frequency")


def test_the_resonance_on_a_whirl_is_that_of_its_line(found):
    features = on_branch(named(found, "B"), SPEEDS[SPEEDS < 90.0][20:])
    rows = rows_of(features, found, STEADY)
    (peak,) = resonances(windows_of(rows), features.synchronous) or [None]
    assert peak.speed == peak.predicted_speed == peak.first_order_speed
    assert peak.height == pytest.approx(features.synchronous.max(), rel=0.05)


def test_where_the_speed_turns_round_is_no_resonance(found):
    rising = SPEEDS[SPEEDS < 90.0][20:]
    features = on_branch(named(found, "B"), rising)
    (peak,) = resonances(compare(features, found, STEADY), features.synchronous)
    falling = rising[rising > peak.speed + 2.0][::-1]
    features = on_branch(named(found, "B"), np.concatenate([falling, falling[-2::-1]]))
    rows = rows_of(features, found, STEADY)
    assert np.argmax(features.synchronous) == len(falling) - 1
    assert resonances(windows_of(rows), features.synchronous) == []


@pytest.mark.parametrize("share, size, by", [(0.0, 1e-4, "without contact"), (1.0, 2e-3, "forward rub")])
def test_the_synchronous_line_without_a_whirl_is_compared_with_its_own_motion(found, share, size, by):
    line = {"frequency": np.nan * SPEEDS, "synchronous": 1.01 * size + 0.0 * SPEEDS}
    quiet = replace(scaled(on_branch(found[1]), 0.0, *AMPLITUDES), share=share + 0.0 * SPEEDS, kind=STEADY_KINDS[share], **line)
    rows = rows_of(quiet, found, STEADY)
    assert set(verdicts(rows, "synchronous line")) == {AGREES} and rows[2].by == by
    assert summary(windows_of(rows), [], "finished").startswith("1X amplitude agrees within 5 % in 121 of 121 windows without")
    assert summary(windows_of(rows)[:1], [], "finished").startswith("1X amplitude agrees within 5 % in 1 of 1 window without")
    rows = rows_of(replace(quiet, synchronous=1.1 * quiet.synchronous), found, STEADY)
    assert set(verdicts(rows, "synchronous line")) == {DIFFERS}
    told = summary(windows_of(rows), [], "finished")
    assert told.startswith("1X amplitude agrees within 5 % in 0 of 121 windows") and told.endswith("; other windows: 121 differs")


def test_a_line_beside_a_backward_one_is_not_that_of_a_forward_rub(found):
    """In permanent contact and near no predicted whirl: nothing is claimed of the line at the rotor speed."""
    far = scaled(on_branch(named(found, "B")), 1.5, "frequency")
    rows = rows_of(replace(far, share=1.0 + 0.0 * SPEEDS), found, STEADY)
    assert set(verdicts(rows, "synchronous line")) == {NO_PREDICTION} and {row.by for row in rows} == {""}


def test_at_a_resonance_the_line_may_be_as_far_off_as_its_steady_size_changes(found):
    """Its neighbours are alike there: what tells is how far they lie below it."""
    line, simulated, k = 1e-4 * np.ones(len(SPEEDS)), 1e-4 * np.ones(len(SPEEDS)), 60
    line[k], simulated[k] = 1.4e-4, 1.1e-4
    own = {"frequency": np.nan * SPEEDS, "share": 0.0 * SPEEDS, "synchronous": simulated, "kind": STEADY_KINDS[0.0]}
    quiet = replace(scaled(on_branch(found[1]), 0.0, *AMPLITUDES), **own)
    told = verdicts(rows_of(quiet, found, replace(STEADY, alone=line)), "synchronous line")
    assert told[k] == OUTSIDE and set(told[:k]) == {AGREES}


@pytest.mark.parametrize(("share", "size"), [(0.0, 1e-4), (1.0, 2e-3)])
def test_a_line_without_a_whirl_settles_at_the_rate_of_small_motions(found, share, size):
    """What it is off at first may be as large as itself, or what its first windows show; what stays is a difference."""
    time = 0.5 * np.arange(len(SPEEDS))
    own = {"share": share + 0.0 * SPEEDS, "time": time, "frequency": np.nan * SPEEDS, "kind": STEADY_KINDS[share]}
    quiet = replace(scaled(on_branch(found[1]), 0.0, *AMPLITUDES), **own)
    steady = replace(STEADY, alone=size + 0.0 * SPEEDS, rub=size + 0.0 * SPEEDS, growth_rate=-0.4 + 0.0 * SPEEDS)

    def told(difference, steady=steady):
        return verdicts(rows_of(replace(quiet, synchronous=size * (1.0 + difference)), found, steady), "synchronous line")

    decays = np.exp(-0.41 * time)
    assert told(0.9 * decays)[:5] == [NOT_YET_STEADY] * 5 and set(told(0.9 * decays)[20:]) == {AGREES}
    assert told(8.0 * decays)[:6] == [NO_PREDICTION] + [NOT_YET_STEADY] * 5 and DIFFERS not in told(8.0 * decays)
    assert set(told(0.3 + 0.0 * time)[8:]) == {DIFFERS}
    assert told(9.0 + 0.0 * time)[:4] == [NO_PREDICTION, NO_PREDICTION, NO_PREDICTION, DIFFERS]
    assert set(told(0.9 * decays, replace(steady, growth_rate=np.nan * SPEEDS))[:5]) == {DIFFERS}


def test_a_line_in_partial_contact_near_no_whirl_has_no_prediction(found):
    far = scaled(on_branch(named(found, "B")), 1.5, "frequency")
    rows = rows_of(replace(far, share=0.3 + 0.0 * SPEEDS), found, STEADY)
    assert set(verdicts(rows)) == {NO_PREDICTION} and "contact for 30 % of the time" in note(rows[0])


def rolling(features, loss=0.0):
    """The same windows, all rolling, and Rolls that they follow but for nine tenths of the amplitude that may be lost."""
    n = features.speed.shape
    rolls = Rolls(
        features.frequency,
        features.amplitude,
        features.stator_amplitude,
        np.full(n, np.nan),
        np.full(n, -10.0),
        np.full(n, loss),
    )
    rolls_all = {"kind": kinds(Kind.ROLLING, features.speed), "rolling": np.ones(n)}
    return replace(scaled(features, 1.0 - 0.9 * loss, *AMPLITUDES), **rolls_all), rolls


def test_a_window_that_rolls_is_compared_with_the_whirl_that_rolls_not_with_those_that_slide(found):
    features, rolls = rolling(on_branch(named(found, "B")))
    rows = rows_of(features, found, STEADY, rolls)
    assert set(verdicts(rows)) == {AGREES} == set(verdicts(rows, "whirl amplitude"))
    assert {row.branch for row in rows} == {"roll"} and transitions(features, found, {}) == []
    assert set(verdicts(rows, "synchronous line")) == {NO_PREDICTION}
    off = scaled(features, 1.006, "frequency")
    assert set(verdicts(rows_of(off, found, STEADY, rolls))[5:]) == {DIFFERS}
    balanced = replace(rolls, synchronous=features.synchronous)
    assert set(verdicts(rows_of(features, found, STEADY, balanced), "synchronous line")) == {AGREES}
    unstable = replace(rolls, growth_rate=-rolls.growth_rate)
    rows = rows_of(features, found, STEADY, unstable)
    assert set(verdicts(rows)) == {AGREES} and "unstable" in note(rows[0])


def test_a_window_that_rolls_for_a_part_of_the_beat_rolls_where_no_sliding_whirl_is_near(found):
    features, rolls = rolling(on_branch(named(found, "B")))
    partly = replace(features, kind=kinds(Kind.SLIDING), rolling=np.full(SPEEDS.shape, 0.4))
    assert {row.branch for row in rows_of(partly, found, STEADY, rolls)} == {"B"}
    assert {row.branch for row in rows_of(partly, [], STEADY, rolls)} == {"roll"}


def test_a_line_that_moves_during_a_window_explains_a_smaller_amplitude_but_no_frequency(found):
    features, rolls = rolling(on_branch(named(found, "B")), loss=0.3)
    rows = rows_of(features, found, STEADY, rolls)
    assert set(verdicts(rows)) == {AGREES} and set(verdicts(rows, "whirl amplitude")) == {OUTSIDE}
    assert "motion during the window" in note(rows[1])
    more = scaled(scaled(features, 0.9, *AMPLITUDES), 1.006, "frequency")
    rows = rows_of(more, found, STEADY, rolls)
    assert set(verdicts(rows)[5:]) == {DIFFERS} == set(verdicts(rows, "whirl amplitude")[5:])


def test_rolling_near_no_whirl_that_is_predicted_to_is_told(found):
    features, rolls = rolling(on_branch(named(found, "B")))
    for known in (None, replace(rolls, frequency=np.full(SPEEDS.shape, np.nan))):
        rows = rows_of(scaled(features, 3.0, "frequency"), found, STEADY, known)
        assert set(verdicts(rows)) == {NO_PREDICTION} and "rolls for 100 % of the time" in note(rows[0])
