"""What a verdict says: severities, the coverage of random impacts, the order of danger."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import rsc
from rsc.measure.catalogue import LastingMotion, Motions, Predicted, SmallestImpact
from rsc.measure.kinds import Kind
from rsc.measure.severity import RunFacts, Severity, Verdict, severity_of, verdict_of
from rsc.show.words.verdict import MEANINGS, NOT_STARTED, NOT_TOUCHED, ON_RACE, PASSING, sentences, verdict_text
from rsc.system.assemble import assemble
from rsc.system.border import Border, border_of, mass_at
from scenes import LAVAL
from two_seals import pump

INSIDE = Border(0.1, 1e-4, math.nan, 3.0, math.nan)
BEYOND = Border(3.0, 3e-3, math.nan, 3.0, math.nan)


def motion(kind, force=100.0, amplitude=1e-3, border=INSIDE, frequency=-50.0, power=math.nan):
    described = (kind, frequency, 0.0, amplitude, 2.0 * amplitude, 0.0, 0.5 * force, force, 1.0, math.nan, power, {}, {})
    return LastingMotion(*described, share=0.5, modulated=False, predicted=None, smallest_impulse=math.nan, border=border)


def listed(motions, ended, interrupted=False, touched=None, not_reached=(), **more):
    """A list of motions; ended: what each of its impacts ends in; touched: how many of them, the first ones, did (None: all)."""
    ended = np.array(ended)
    reached = np.arange(len(ended)) < (len(ended) if touched is None else touched)
    return Motions(50.0, 1e-3, motions, [*not_reached], [], len(ended), 0, 2.0, 20, np.ones((len(ended), 2)), ended, reached, 0.1,
                   -50.0, 0.1, -50.0, interrupted, **more)  # fmt: skip


NOTHING = motion(Kind.NO_CONTACT, 0.0, frequency=math.nan)


@pytest.mark.parametrize(
    ("kind", "border", "severity"),
    [
        (Kind.NO_CONTACT, INSIDE, Severity.SAFE),
        (Kind.NOT_RESOLVED, INSIDE, Severity.UNKNOWN),
        (Kind.FORWARD_RUB, INSIDE, Severity.RUB),
        (Kind.PARTIAL_RUB, INSIDE, Severity.RUB),
        (Kind.RESTING, INSIDE, Severity.RUB),
        (Kind.SLIDING, INSIDE, Severity.WHIRL),
        (Kind.BOUNCING, INSIDE, Severity.WHIRL),
        (Kind.FORWARD_WHIRL, INSIDE, Severity.WHIRL),
        (Kind.ROLLING, BEYOND, Severity.DESTRUCTIVE),
        (Kind.FORWARD_RUB, BEYOND, Severity.DESTRUCTIVE),
    ],
)
def test_the_severity_of_each_kind(kind, border, severity):
    assert severity_of(kind, border) == severity
    verdict = verdict_of(None, None, (), [listed([motion(kind, border=border), NOTHING], [0] * 8 + [1] * 8)])
    assert verdict.severity == (Severity.SAFE if kind == Kind.NO_CONTACT else severity)
    assert sentences(verdict)[-1].startswith(f"Severity: {verdict.severity} (")


def test_every_limit_is_one_of_the_motion():
    system = assemble(rsc.Scene.from_dict(LAVAL).with_values({"contact.diameter": 0.04}))
    contact = system.contact
    depth = contact.law.stiffness * contact.gap
    assert border_of(system, 50.0, [0.9 * depth], 0.019, -50.0, 1.0).passed == ()
    assert border_of(system, 50.0, [1.1 * depth], 0.019, -50.0, 1.0).passed == ("penetration",)
    assert border_of(system, 50.0, [0.0], 0.021, -50.0, 1.0).passed == ("orbit",)
    assert border_of(system, 50.0, [0.0], 0.019, -4200.0, 1.0).passed == ("surface",)
    assert border_of(system, 50.0, [0.0], 0.019, -50.0, 7.6e5 * mass_at(system, contact)).passed == ("heating",)
    assert border_of(system, 50.0, [0.0], 0.019, -50.0, 7.6e5 * mass_at(system, contact), 40.0).passed == ()  # of a whole shaft
    assert border_of(system, 50.0, [0.0], 0.019, -50.0, 7.6e5 * 40.0, 40.0).passed == ("heating",)
    free = assemble(rsc.Scene.from_dict(LAVAL))  # no diameter: neither radius nor power
    assert math.isnan(border_of(free, 50.0, [0.0], 1.0, -50.0).orbit)


@pytest.mark.parametrize(("force", "passed"), [(90.0, ()), (110.0, ("yielding",))])
def test_a_contact_yields_at_the_force_that_its_scene_gives(force, passed):
    scene = rsc.Scene.from_dict(LAVAL).with_values({"contact.yield_force": "0.1 kN"})
    border = border_of(assemble(scene), 50.0, [force], 1e-3, -50.0)
    assert border.passed == passed and border.yielding == pytest.approx(force / 100.0)
    made = listed([motion(Kind.SLIDING, force, border=border), NOTHING], [0] * 8 + [1] * 8)
    text = verdict_text(verdict_of(None, None, (), [made]))
    assert ("normal force of 1.1 times the yield force of the contact" in text) == bool(passed) == ("destructive" in text)
    assert (f"{force:.0f} N" in text) != bool(passed)  # the figure is beyond the model
    without = border_of(assemble(rsc.Scene.from_dict(LAVAL)), 50.0, [force], 1e-3, -50.0)
    assert without.passed == () and math.isnan(without.yielding)


def test_of_several_contacts_the_one_that_yields_first_counts():
    scene = pump().with_values({"contact.seal.yield_force": 1e3, "contact.bush.yield_force": 10.0})
    system = assemble(scene)
    assert border_of(system, 50.0, [100.0, 5.0], 1e-6, -50.0).yielding == pytest.approx(0.5)
    assert border_of(system, 50.0, [900.0, 5.0], 1e-6, -50.0).yielding == pytest.approx(0.9)


def test_what_no_impact_starts_is_told_and_does_not_count():
    verdict = verdict_of(None, None, (), [listed([motion(Kind.ROLLING, 1e6, border=BEYOND), NOTHING], [1] * 16)])
    assert verdict.severity == Severity.AT_RISK and verdict.impact.hits == 0
    text = verdict_text(verdict)
    assert "none of 16 impacts started backward whirl, rolling" in text and "all 16 impacts touched" in text
    assert "Severity: at risk (a motion in contact can last" in text


@pytest.mark.parametrize(
    ("growth", "possible", "touches", "severity"),
    [(-1.0, True, (), Severity.AT_RISK), (1.0, True, (), Severity.SAFE), (-1.0, False, (), Severity.SAFE),
     (-1.0, True, ("seal",), Severity.SAFE)],
)  # fmt: skip
def test_a_whirl_that_is_predicted_to_last_is_never_safe(growth, possible, touches, severity):
    whirl = Predicted("B", -50.0, 1e-3, 10.0, growth, math.nan, possible, touches)
    verdict = verdict_of(None, None, (), [listed([NOTHING], [0] * 16, not_reached=[whirl])])
    assert verdict.severity == severity and (verdict.not_reached is not None) == (severity == Severity.AT_RISK)
    told = "a backward whirl of -50.00 Hz is predicted to be stable, but no run ended in it"
    assert (told in verdict_text(verdict)) == (severity == Severity.AT_RISK)


@pytest.mark.parametrize(("turning", "told"), [(-49.5, False), (-20.0, True)])
def test_the_whirl_that_the_run_itself_shows_is_not_told_as_not_reached(turning, told):
    whirl = Predicted("B", -50.0, 1e-3, 10.0, -1.0, math.nan, True)
    features = SimpleNamespace(kind=np.array([str(Kind.SLIDING)]), turning=np.array([turning]), names=[])
    made = listed([NOTHING], [0] * 16, not_reached=[whirl])
    verdict = verdict_of(run_of(Kind.SLIDING), features, [50.0], [made])
    assert ("no run ended in it" in verdict_text(verdict)) == told and verdict.severity == Severity.WHIRL


@pytest.mark.parametrize(
    ("touched", "severity", "says"),
    [(16, Severity.SAFE, "all 16 impacts touched: "), (15, Severity.SAFE, "15 of 16 impacts touched: "),
     (0, Severity.UNKNOWN, "none of 16 impacts touched, which excludes nothing")],
)  # fmt: skip
def test_impacts_that_touch_nothing_are_no_evidence(touched, severity, says):
    made = listed([NOTHING], [0] * 16, touched=touched)
    verdict = verdict_of(None, None, (), [made])
    assert verdict.severity == severity and says in verdict_text(verdict)
    assert made.excluded == (pytest.approx(1.0 - 0.05 ** (1.0 / touched)) if touched else 1.0)
    assert (NOT_TOUCHED in verdict_text(verdict)) == (touched == 0)
    assert listed([NOTHING], [-1] * 16, touched=touched).unsettled == touched


@pytest.mark.parametrize("ended", [[1] * 16, [0] * 8 + [1] * 8])
def test_what_runs_away_has_no_size_whether_an_impact_starts_it_or_not(ended):
    away = motion(Kind.RUNNING_AWAY, 1e10, border=Border(2.5e6, 623.0, math.nan, 2.9e6, math.nan))
    text = verdict_text(verdict_of(None, None, (), [listed([away, NOTHING], ended)]))
    assert "grows without limit" in text and "beyond the model" not in text and "623" not in text and "e+06" not in text


def test_at_several_contacts_the_smallest_impact_starts_what_the_verdict_names():
    at = {name: SimpleNamespace(motion=Kind.ROLLING, force_max=900.0) for name in ("seal", "bush")}
    rolling, sliding = replace(motion(Kind.ROLLING, 900.0), contacts=at), motion(Kind.SLIDING, 10.0)
    smallest = SmallestImpact(1.0, 0.0, 0.1, 3.0, 0.5, 6, 0, 100.0, 0.01, "seal")
    made = listed([rolling, sliding, NOTHING], [0] * 8 + [1] * 8, smallest=smallest)
    text = verdict_text(verdict_of(None, None, (), [made]))
    assert "impact starts backward whirl, rolling at seal and bush" in text and "which starts" not in text
    other = verdict_text(verdict_of(None, None, (), [replace(made, smallest=replace(smallest, motion=1))]))
    assert "(which starts backward whirl, sliding)" in other


@pytest.mark.parametrize(
    ("others", "ended", "waits"),
    [([motion(Kind.ROLLING, 1e6), NOTHING], [1] * 16, True), ([motion(Kind.PARTIAL_RUB, 50.0), NOTHING], [1] * 16, False),
     ([NOTHING], [0] * 16, False)],
)  # fmt: skip
def test_beside_a_rub_a_whirl_that_waits_is_said(others, ended, waits):
    verdict = verdict_of(run_of(Kind.FORWARD_RUB), None, [50.0], [listed(others, ended)])
    assert verdict.severity == Severity.RUB and (NOT_STARTED in verdict_text(verdict)) == waits
    whirl = Predicted("B", -50.0, 1e-3, 10.0, -1.0, math.nan, True)
    predicted = verdict_of(run_of(Kind.FORWARD_RUB), None, [50.0], [listed([NOTHING], [0] * 16, not_reached=[whirl])])
    assert NOT_STARTED in verdict_text(predicted)


@pytest.mark.parametrize(
    ("rotor_velocity", "told"),
    [(0.05, "has 1 N s at seal (the momentum of the whole rotor at 50 mm/s), 3 times what just touches from the centre"),
     (math.nan, "has 1 N s at seal (100 mm/s of the shaft at the contact), 3 times")],
)  # fmt: skip
def test_an_impulse_is_compared_with_the_momentum_of_the_rotor(rotor_velocity, told):
    smallest = SmallestImpact(1.0, 0.0, 0.1, 3.0, 0.5, 6, 0, 100.0, 0.01, "seal", rotor_velocity)
    made = listed([motion(Kind.ROLLING, 900.0), NOTHING], [0] * 16, smallest=smallest)
    assert told in verdict_text(verdict_of(None, None, (), [made]))


def test_nothing_found_states_the_coverage():
    text = verdict_text(verdict_of(None, None, (), [listed([NOTHING], [0] * 16)]))
    assert "None of 16 impacts" in text and "95 %" in text and "any one motion" in text and "17.1 %" in text
    assert "Severity: safe" in text


@pytest.mark.parametrize("ended", [[-1] * 16, [0] * 3 + [-1] * 13, []])
def test_too_little_settled_is_no_safety(ended):
    assert verdict_of(None, None, (), [listed([NOTHING], ended)]).severity == Severity.UNKNOWN
    assert verdict_of(None, None, (), []).severity == Severity.UNKNOWN


def test_the_most_dangerous_motion_is_first_by_force_and_orbit_and_what_runs_away_before_all():
    sliding, rolling = motion(Kind.SLIDING, 68.0, 2.2e-3), motion(Kind.ROLLING, 11.7e3, 0.25e-3)
    away = motion(Kind.RUNNING_AWAY, 5e10)
    in_order = sorted([sliding, away, NOTHING, rolling], key=lambda one: one.danger, reverse=True)
    assert in_order == [away, rolling, sliding, NOTHING]
    assert motion(Kind.SLIDING, power=2.0).danger > motion(Kind.SLIDING, power=1.0).danger


@pytest.mark.parametrize(("starts", "unsettled", "bound"), [(16, 0, 0.171), (64, 0, 0.0457), (16, 1, 0.264), (16, 5, 0.548)])
def test_unsettled_impacts_count_against_the_coverage(starts, unsettled, bound):
    assert listed([NOTHING], [-1] * unsettled + [0] * (starts - unsettled)).excluded == pytest.approx(bound, abs=6e-4)


@pytest.mark.parametrize(("share", "lost"), [(0.05, 0.0), (0.17, 0.0), (0.3, 0.1), (0.26, 0.05)])
def test_the_coverage_is_true(share, lost):
    """A motion of a share, whose impacts have not settled with some probability, as those of others: it is either listed, or the
    claim that it has a smaller share than the bound is false in at most one of twenty lists."""
    dice = np.random.default_rng(3)
    trials, starts = 4000, 16
    own = dice.uniform(size=(trials, starts)) < share
    unsettled = dice.uniform(size=(trials, starts)) < lost
    missed = ~(own & ~unsettled).any(axis=1)
    bounds = np.array([listed([NOTHING], np.where(row, -1, 0)).excluded for row in unsettled])
    assert (missed & (share >= bounds)).mean() <= 0.05


def run_of(kind, on_race=False):
    """What a run did whose worst motion is of a kind."""
    return RunFacts(severity_of(kind), str(kind), True, (np.nan, np.nan), (50.0, 50.0), 10.0, INSIDE, on_race)


@pytest.mark.parametrize(
    ("run", "meaning"),
    [
        (run_of(Kind.TRANSIENT), PASSING),
        (run_of(Kind.PARTIAL_RUB), MEANINGS[Severity.RUB]),
        (run_of(Kind.ROLLING, on_race=True), ON_RACE),
        (run_of(Kind.ROLLING), MEANINGS[Severity.WHIRL]),
    ],
)
def test_what_a_severity_means_follows_the_motion(run, meaning):
    assert sentences(Verdict(run.severity, run, None, ()))[-1] == f"Severity: {run.severity} ({meaning})."


def test_a_motion_that_impacts_start_is_not_made_light_of_by_the_run():
    verdict = verdict_of(run_of(Kind.TRANSIENT), None, (), [listed([motion(Kind.PARTIAL_RUB), NOTHING], [0] * 8 + [1] * 8)])
    assert verdict.severity == Severity.RUB and sentences(verdict)[-1].endswith(f"({MEANINGS[Severity.RUB]}).")
