"""One whirl followed without the others: its branch, fold, crossing and delay are those that all branches give, and refusals."""

import numpy as np
import pytest

import rsc
from rsc.analysis.follow.branches import branches
from rsc.analysis.follow.delayed_jump import delayed_jump
from rsc.analysis.follow.events import FOLD, FORCE
from rsc.analysis.follow.one_whirl import follow, whirl_line
from rsc.errors import SceneError
from rsc.system.assemble import assemble
from systems import TWO_PI, changed, random_system, reference, reference_scene

PAIR, TRANSITION = "gyroscopic_disk_very_light", "gyroscopic_transition"


def first_whirls(found, speed):
    """(branch, frequency in Hz) of every branch that begins at the first speed of a way."""
    return [(b, b.frequency[int(np.flatnonzero(b.values == speed)[0])]) for b in found if speed in b.values]


def same_branch(one, other):
    """Whether two branches have the same whirls, ends and events."""
    places = [(b.begin, *b.events, b.end) for b in (one, other)]
    return (
        np.array_equal(np.sort(one.values), np.sort(other.values))
        and np.allclose(one.frequency, other.frequency, rtol=1e-11, atol=0.0)
        and np.allclose(one.growth_rate, other.growth_rate, rtol=1e-9, atol=1e-9)
        and np.allclose(one.envelope(1), other.envelope(1), rtol=1e-9, atol=0.0)
        and [(e.cause, e.holds) for e in places[0]] == [(e.cause, e.holds) for e in places[1]]
        and np.allclose([(e.value, e.frequency) for e in places[0]], [(e.value, e.frequency) for e in places[1]], rtol=1e-7)
        and np.allclose(one.lost, other.lost, rtol=1e-9)
    )


@pytest.mark.parametrize("way", [np.linspace(20.0, 150.0, 53), np.linspace(60.0, 10.0, 41), np.array([40.0])], ids=len)
@pytest.mark.parametrize("name", [PAIR, TRANSITION])
def test_a_whirl_followed_alone_has_its_branch(name, way):
    system = reference(name)
    found = first_whirls(branches(system, way), way[0])
    assert len(found) > 2
    for branch, frequency in found:
        assert same_branch(branch, follow(system, frequency, way)), branch.label


def test_whirls_of_random_systems_have_their_branches():
    rng, folds = np.random.default_rng(1), 0
    for k in range(16):
        system = random_system(rng, most=3)
        system = changed(system, gyroscopic_r=2.0 * system.rotor.gyroscopic, contact_damping=10.0)
        way = np.linspace(2.0, 120.0, 25)[:: 1 if k % 2 else -1]
        for branch, frequency in first_whirls(branches(system, way), way[0]):
            folds += FOLD in (branch.begin.cause, branch.end.cause)
            assert same_branch(branch, follow(system, frequency, way)), (k, branch.label)
    assert folds > 1


def random_systems(seed, count):
    """Systems of up to 4 + 4 coordinates with strong gyroscopics."""
    rng = np.random.default_rng(seed)
    systems = [random_system(rng, most=4) for _ in range(count)]
    return [changed(system, gyroscopic_r=2.0 * system.rotor.gyroscopic, contact_damping=10.0) for system in systems]


def test_a_whirl_ends_where_its_force_passes_infinity():
    system, way = random_systems(2, 27)[26], np.linspace(2.0, 120.0, 60)
    branch, frequency = next(pair for pair in first_whirls(branches(system, way), way[0]) if pair[0].end.cause == FORCE)
    alone = follow(system, frequency, way)
    assert alone.end.cause == FORCE and alone.end.value == pytest.approx(branch.end.value, rel=1e-9)


@pytest.mark.parametrize(
    ("number", "near", "way"), [(18, -83.4, (2.0, 120.0)), (22, -31.77, (2.0, 120.0)), (129, -151.75, (120.0, 2.0))]
)
def test_a_long_step_does_not_go_over_to_another_pair(number, near, way):
    """Beside the fold of these whirls another pair begins, whose tangents almost continue theirs."""
    system = random_systems(2, number + 1)[number]
    fine = branches(system, np.linspace(*way, 120))
    branch = min(first_whirls(fine, way[0]), key=lambda pair: abs(pair[1] - near))[0]
    begin, end = (branch.begin, branch.end) if way[0] < way[1] else (branch.end, branch.begin)
    assert end.cause == FOLD and begin.value == way[0]
    line = whirl_line(system, near, np.linspace(*way, 12))[2]
    assert (line.end if way[0] < way[1] else line.begin).value == pytest.approx(end.value, rel=1e-9)


def whirls_near(scene, frequency, speed):
    return [whirl for whirl in rsc.predict(scene, speed) if abs(whirl.frequency / frequency - 1.0) < 0.02]


def test_both_roots_of_a_pair_meet_at_their_fold():
    scene = reference_scene(PAIR)
    fold, other = (rsc.fold(scene, near, (60.0, 10.0)) for near in (-48.8, -45.2))
    assert fold == rsc.fold(scene, -48.8, (60.0, 10.0)) and fold.cause == other.cause == FOLD
    assert (fold.value, fold.frequency) == pytest.approx((other.value, other.frequency), rel=1e-6)
    assert len(whirls_near(scene, fold.frequency, fold.value * (1.0 + 1e-7))) == 2
    assert len(whirls_near(scene, fold.frequency, fold.value * (1.0 - 1e-7))) == 0
    assert rsc.fold(scene, -48.8, (60.0, 25.0)) is None and rsc.fold(scene, -24.1, (60.0, 10.0)) is None


@pytest.mark.parametrize(
    ("name", "near", "speeds", "holds"),
    [
        (TRANSITION, -38.8, (20.0, 150.0), "below"),
        (TRANSITION, -33.7, (75.0, 20.0), "below"),
        (PAIR, -48.8, (60.0, 10.0), "above"),
        (PAIR, -47.9, (120.0, 25.0), "below"),  # the first of two
    ],
)
def test_the_growth_rate_passes_zero_at_the_crossing(name, near, speeds, holds):
    scene = reference_scene(name)
    crossing = rsc.crossing(scene, near, speeds)
    assert (crossing.cause, crossing.holds) == ("stable (oscillatory)", holds)
    rates = []
    for share in (-1e-3, -1e-9, 1e-9, 1e-3):
        (whirl,) = whirls_near(scene, crossing.frequency, crossing.value * (1.0 + share))
        rates.append(whirl.growth_rate)
    assert abs(crossing.value - speeds[0]) < 50.0
    below, above = (rates[0], rates[3]) if holds == "below" else (rates[3], rates[0])
    assert below < 0.0 < above
    assert max(abs(rates[1]), abs(rates[2])) < 1e-4 * (above - below)


def test_no_crossing_before_the_way_ends():
    assert rsc.crossing(reference_scene(TRANSITION), -38.8, (20.0, 60.0)) is None


def test_the_delay_is_that_of_the_branch():
    scene, system = reference_scene(TRANSITION), reference(TRANSITION)
    branch = next(b for b in branches(system, np.linspace(20.0, 150.0, 201)) if b.lost)
    for levels in ((None, None), (1.0, 1e-6)):
        alone, wanted = rsc.delay(scene, -38.8, *levels), delayed_jump(system, branch, *levels)
        for name in ("crossing", "first_seen", "jump", "undisturbed", "start_level", "floor", "level_at_crossing", "towards"):
            assert getattr(alone, name) == pytest.approx(getattr(wanted, name), rel=1e-9), name
        assert alone.source == wanted.source


@pytest.mark.parametrize(
    ("near", "speeds", "reason"),
    [
        (np.nan, (20.0, 60.0), r"near = nan: must be a frequency in Hz from -1e\+06 to below 0 \(only backward"),
        (0.0, (20.0, 60.0), r"near = 0\.0: must be a frequency"),
        (-2e6, (20.0, 60.0), r"near = -2000000\.0: must be a frequency"),
        (38.8, (20.0, 60.0), r"near = 38\.8: must be a frequency"),
        (-38.8, (20.0, 20.0), r"speeds = .*: must be rising or falling speeds in Hz between -1e\+06 and 1e\+06"),
        (-38.8, (20.0, np.nan), r"speeds = .*: must be rising or falling"),
        (-38.8, (20.0, -2e6), r"speeds = .*: must be rising or falling"),
        (-38.8, (), r"speeds = .*: must be rising or falling"),
        (-38.8, 20.0, r"speeds = 20\.0: must be rising or falling"),
    ],
)
def test_what_cannot_be_resolved_is_refused_with_the_reason(near, speeds, reason):
    for question in (rsc.fold, rsc.crossing):
        with pytest.raises(SceneError, match=f"^follow: {reason}"):
            question(reference_scene(TRANSITION), near, speeds)


def test_a_speed_that_is_no_speed_is_refused():
    for question in (rsc.fold, rsc.crossing):
        with pytest.raises(SceneError, match="speeds = 'slow': must be a number in Hz, or a text with a unit"):
            question(reference_scene(TRANSITION), -38.8, "slow")


def test_a_whirl_that_does_not_exist_is_refused():
    scene = reference_scene("laval").with_values({"contact.friction": 0.0})
    with pytest.raises(SceneError, match=r"must be next to a backward whirl at 50 Hz, the first speed \(none is"):
        rsc.fold(scene, -20.0, (50.0, 60.0))


def test_a_forward_whirl_is_not_followed():
    """With negative damping the whirl next to -5 Hz turns forward."""
    content = reference_scene("laval").to_dict()
    content["rotor"] |= {"damping_ratio": -0.02, "allow_negative_damping": True}
    system = assemble(rsc.Scene.from_dict(content))
    assert whirl_line(system, -5.0, [50.0])[2].points[:, 0] == pytest.approx([-65.2126 * TWO_PI], rel=1e-5)


def test_a_run_at_constant_speed_has_no_delay():
    with pytest.raises(SceneError, match=r"drive\.speed = .*: must be a speed that changes"):
        rsc.delay(reference_scene("laval").with_values({"drive.speed": 50.0}), -20.0)


def test_a_pole_is_no_whirl_to_be_followed():
    system = reference("mdof_2x2")
    undamped = changed(system, damping_r=0.0 * system.rotor.damping, damping_s=0.0 * system.stator.damping)
    with pytest.raises(rsc.SceneError, match=r"must be next to a backward whirl at 20 Hz, .*none is predicted there"):
        whirl_line(undamped, -9.3, (20.0, 30.0))
