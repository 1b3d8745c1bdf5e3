"""Whirl branches: no swaps, ends and events against closed forms, dense scans and the roots themselves."""


from dataclasses import replace

import numpy as np
import pytest

from rsc.analysis.follow.branches import branches, continuation
from rsc.analysis.follow.curve import WhirlCurve
from rsc.analysis.follow.events import AMPLITUDE, CREEPING, FOLD, FORCE, OSCILLATORY, RANGE_END, SLIDING, UNBOUNDED
from rsc.analysis.follow.lines import Net
from rsc.analysis.follow.patience import Patience, silent
from rsc.analysis.follow.whirls import bound_at, seeds_at_one
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.receptance import phase_slopes, receptance
from rsc.analysis.paper.roots import whirl_roots
from rsc.analysis.paper.stability import whirl_growths
from rsc.analysis.paper.whirls import normal_force, steady_whirls
from rsc.errors import SceneError
from rsc.system.assemble import assemble
from rsc.system.knots import Knots
from systems import TWO_PI, changed, expected, jeffcott, random_rotor, random_system, reference, reference_scene, with_skew
from tiers import first


def nearest(system, frequency, speed):
    return min(predict_system(system, speed), key=lambda w: abs(w.frequency - frequency))


def backward(system, speed):
    roots = whirl_roots(system, TWO_PI * speed)
    return roots[roots < 0.0]


def pressed_roots(system, speed):
    roots = steady_whirls(system, TWO_PI * speed)[0]
    return roots[roots < 0.0]


def root_lines(at, values):
    """(seeds at every value, lines) of the roots of value -> (System, speed in Hz)."""
    curve = WhirlCurve(at, (0,), values[0], values[-1])
    seeds = seeds_at_one(curve, values, Patience(silent))
    return seeds, Net(curve, values, seeds, bound_at(curve, values[-1])).lines(Patience(silent))


def events(found, cause):
    return [(b, e) for b in found for e in b.events if e.cause == cause]


@pytest.fixture(scope="module")
def very_light():
    system = reference("gyroscopic_disk_very_light")
    return system, branches(system, np.linspace(5.0, 150.0, 59))


@pytest.fixture(scope="module")
def transition():
    system = reference("gyroscopic_transition")
    return system, branches(system, np.linspace(20.0, 150.0, 40))


# ---------------------------------------------------------------- lines


def test_every_whirl_of_every_speed_is_on_one_branch(very_light):
    system, found = very_light
    for speed in np.linspace(5.0, 150.0, 59):
        wanted = [w.frequency for w in predict_system(system, speed) if w.frequency < 0.0]
        on_branches = [w.frequency for b in found for w in b.whirls if w.speed == speed]
        assert sorted(on_branches) == wanted


def test_a_coarse_grid_gives_the_branches_of_a_fine_one():
    rng = np.random.default_rng(3)
    n_branches = 0
    for _ in range(4):
        system = random_system(rng, most=4)
        if system.n_rotor < 2:
            continue
        system = changed(system, gyroscopic_r=3.0 * system.rotor.gyroscopic)
        coarse, fine = (branches(system, np.linspace(2.0, 120.0, n)) for n in (7, 61))
        assert [(b.begin.cause, b.end.cause) for b in coarse] == [(b.begin.cause, b.end.cause) for b in fine]
        for one, other in zip(coarse, fine, strict=True):
            shared = [w.frequency for w in other.whirls if np.abs(one.values - w.speed).min() < 1e-9]
            if len(shared) == len(one.whirls):
                assert one.frequency == pytest.approx(shared, rel=1e-9)
            for place, same in ((one.begin, other.begin), (one.end, other.end)):
                assert place.value == pytest.approx(same.value, rel=1e-9)
                assert place.frequency == pytest.approx(same.frequency, rel=1e-6)
            assert [e.value for e in one.events] == pytest.approx([e.value for e in other.events], rel=1e-7)
        n_branches += len(fine)
    assert n_branches > 20


@pytest.mark.parametrize("ratio", first([1e-4, 1e-3]))
def test_lines_do_not_swap_where_roots_nearly_cross(ratio):
    # a rotor mode falls through a hardly damped stator mode at 20 Hz: roots come within 1e-4 Hz of each other
    system = reference("gyroscopic_disk_light")
    stiffness = system.stator.mass * (TWO_PI * 20.0) ** 2
    damping = 2.0 * ratio * TWO_PI * 20.0 * system.stator.mass
    system = changed(system, damping_r=0.01 * system.rotor.damping, stiffness_s=stiffness, damping_s=damping)
    found = []
    for n in (5, 201):
        seeds, lines = root_lines(lambda speed: (system, speed), np.linspace(20.0, 150.0, n))
        for value in (20.0, 150.0):
            own = sorted(p.root for line in lines for p in (line.begin, line.end) if p.value == value)
            assert own == pytest.approx(backward(system, value), rel=1e-12)
        found.append(sorted((line.begin.value, line.end.value, line.begin.root, line.end.root) for line in lines))
    assert np.array(found[0]) == pytest.approx(np.array(found[1]), rel=1e-8)
    assert min(np.diff(points[:, 0]).min() for points in seeds) < TWO_PI * 1e-2


def test_tangents_are_those_of_the_roots():
    system = reference("gyroscopic_disk_light")
    curve = WhirlCurve(lambda speed: (system, speed), (0,), 20.0, 150.0)
    for speed in (20.0, 150.0):
        below, here, above = seeds_at_one(curve, speed + np.array([-1e-4, 0.0, 1e-4]), Patience(silent))
        left, slopes = curve.evaluated(here, 85.0)
        assert np.abs(left).max() < 1e-9
        tangents = curve.tangents(slopes, np.ones(here.shape))
        assert tangents[:, 0] / tangents[:, -1] == pytest.approx((above - below)[:, 0] / 2e-4, rel=1e-4, abs=1e-6)
    Psi, step = np.array([-200.0, 150.0]), 1e-3
    ends = [phase_slopes(system, 300.0, Psi + off)[0] for off in (-step, step)]
    assert phase_slopes(system, 300.0, Psi)[1] == pytest.approx((ends[1] - ends[0]) / (2.0 * step), rel=1e-6)


def test_whirls_that_can_exist_have_the_first_labels_then_frequency_decides(transition):
    _, found = transition
    assert [b.label for b in found] == list("ABCDE")
    assert [bool(b.stable.any()) for b in found] == [True, True, False, False, False]
    for starts in ([abs(b.frequency[0]) for b in part] for part in (found[:2], found[2:])):
        assert starts == sorted(starts)
    assert found[0].frequency[0] == pytest.approx(-38.8128, abs=1e-4)
    assert found[0].at(70.0).frequency == pytest.approx(-33.6985, abs=1e-4)
    assert found[0].at(170.0) is None


def following(dice, kind):
    """A random rotor, with a term that follows the speed or drives it."""
    system = random_rotor(dice)
    if kind == "cross-coupled":
        return with_skew(dice, system)
    rotor = system.rotor
    if kind == "rotating damping":
        return replace(system, rotor=replace(rotor, rotating_damping=0.5 * rotor.damping))
    if kind == "knots":
        shares = np.array([0.0, *dice.uniform(0.0, 1.0, 3)])[:, None, None]
        return replace(system, rotor=replace(rotor, knots=Knots(TWO_PI * np.array([2.0, 30.0, 60.0, 120.0]), {
            "stiffness": shares * np.diag(np.diag(rotor.stiffness))})))  # fmt: skip
    return system


@pytest.mark.parametrize("kind", first(["constant", "cross-coupled", "rotating damping", "knots"], 3))
def test_between_the_speeds_of_the_grid_no_whirl_is_missing_and_none_extra(kind):
    """Roots counted at other speeds, and beside every fold; growth rates beside every change of stability."""
    dice, folds, changes = np.random.default_rng(13), 0, 0
    for _ in range(4):
        system = following(dice, kind)
        found = branches(system, np.linspace(2.0, 120.0, 60))
        for speed in dice.uniform(2.0, 120.0, 6):
            assert sum(b.begin.value < speed < b.end.value for b in found) == len(pressed_roots(system, speed))
        for end, inside in [(b.begin, 1.0) for b in found] + [(b.end, -1.0) for b in found]:
            if end.cause == FOLD:
                within, beyond = (len(pressed_roots(system, end.value * (1.0 + inside * off))) for off in (1e-7, -1e-7))
                assert within == beyond + 2
                folds += 1
        for _, event in events(found, OSCILLATORY) + events(found, CREEPING):
            rates = [nearest(system, event.frequency, event.value * (1.0 + off)).growth_rate for off in (-1e-6, 1e-6)]
            assert (rates[0] < 0.0 < rates[1]) if event.holds == "below" else (rates[1] < 0.0 < rates[0])
            changes += 1
    assert folds > 1


# ---------------------------------------------------------------- ends and events over the speed


def test_a_pair_is_born_at_a_fold(very_light):
    system, found = very_light
    born = [b for b in found if b.begin.cause == FOLD]
    assert len(born) == 2 and born[0].begin == born[1].begin
    fold = born[0].begin
    # roots counted as sign changes on a dense scan
    before, beyond = (backward(system, fold.value * (1.0 + off)) for off in (-1e-6, 1e-6))
    assert len(beyond) == len(before) + 2
    new = sorted(beyond, key=lambda psi: abs(psi / TWO_PI - fold.frequency))[:2]
    assert new[0] / TWO_PI == pytest.approx(fold.frequency, rel=1e-3) and new[0] != new[1]
    H = (1.0 + 1j * system.law.friction) * receptance(system, TWO_PI * fold.frequency, TWO_PI * fold.value)
    assert abs(H.imag) < 1e-9 * abs(H)
    assert all(b.end.cause == RANGE_END for b in found)


def test_stability_is_lost_where_the_growth_rate_changes_sign(transition, very_light):
    wanted = expected("gyroscopic_transition")["transition"]["stability_lost"]
    (system, found), (other, more) = transition, very_light
    [(branch, lost)] = events(found, OSCILLATORY)
    assert lost.value == pytest.approx(wanted, abs=0.1)
    assert lost.holds == "below" and branch.lost == (lost.value,)
    checked = [(system, lost), *((other, e) for _, e in events(more, OSCILLATORY))]
    assert len(checked) == 3
    for scene_system, event in checked:
        below, above = (nearest(scene_system, event.frequency, event.value * (1.0 + off)) for off in (-1e-6, 1e-6))
        assert (below.stable, above.stable) == ((True, False) if event.holds == "below" else (False, True))
        assert below.growth_frequency > 1.0


def test_lost_is_lost_on_the_way_of_the_run(very_light):
    system, rising = very_light
    falling = branches(system, np.linspace(150.0, 5.0, 59))
    assert [b.label for b in falling] == [b.label for b in rising]
    up, down = (next(b for b in found if b.lost) for found in (rising, falling))
    assert up.label == down.label and up.events == down.events
    assert up.lost == (up.events[1].value,) and down.lost == (down.events[0].value,)


def test_two_crossings_between_two_speeds_are_found():
    # with this friction a whirl is stable from 48.2 to 62.2 Hz only: no speed of this grid lies in between
    system = changed(reference("gyroscopic_disk_very_light"), friction=0.26)
    found = branches(system, [40.0, 47.5, 63.0, 80.0, 95.0])
    assert [round(e.value, 2) for _, e in events(found, OSCILLATORY)] == [48.25, 62.25]


def test_sliding_ends_where_the_surfaces_roll():
    scene = reference_scene("laval").with_values({"contact.diameter": 0.1, "contact.slip_velocity": 1e-6})
    system = assemble(scene)
    found = branches(system, np.linspace(1.0, 100.0, 30))
    rolling = [(b, e) for b, e in events(found, SLIDING) if abs(e.frequency + 60.66) < 0.1]
    assert len(rolling) == 1
    [(_, event)] = rolling
    F_N = normal_force(system, TWO_PI * event.frequency, TWO_PI * event.value)
    distance = system.contact.gap + F_N / system.law.stiffness
    # (12): the surface speed Omega d_R / 2 equals the whirl's own
    assert TWO_PI * event.value * 0.05 == pytest.approx(-TWO_PI * event.frequency * distance + 1e-6, rel=1e-6)
    assert event.holds == "above"


def test_a_scene_without_friction_has_no_branches():
    assert branches(changed(reference("laval"), friction=0.0), np.linspace(20.0, 100.0, 5)) == []


def test_one_speed_is_a_range_too():
    found = branches(reference("mdof_2x2"), [10.0])
    assert sorted((b.whirls[0].frequency for b in found), key=abs)[:2] == pytest.approx([-9.47, -12.9], abs=1e-3)
    assert all(b.begin.cause == b.end.cause == RANGE_END and b.at(10.0) is b.whirls[0] for b in found)


def test_dry_whirl_on_a_rigid_wall_is_unstable():
    system = changed(jeffcott(), contact_stiffness=4e6)
    found = branches(system, np.linspace(10.0, 50.0, 5))
    assert len(found) == 1 and not found[0].stable.any()


# ---------------------------------------------------------------- over other quantities


def test_too_soft_a_contact_ends_a_whirl():
    scene = reference_scene("gyroscopic_transition")
    found = continuation(scene, "contact.stiffness", np.linspace(1e3, 4e6, 21), speed=70.0)
    rigid = assemble(scene)
    assert len(found) == 5
    for branch in found:
        assert branch.begin.cause == FORCE
        F_rigid = normal_force(rigid, TWO_PI * branch.begin.frequency, TWO_PI * 70.0, rigid=True)
        assert branch.begin.value == pytest.approx(F_rigid / rigid.contact.gap, rel=1e-6)


def test_branches_over_the_friction():
    scene = reference_scene("gyroscopic_transition")
    found = continuation(scene, "contact.friction", np.linspace(0.0, 1.0, 41), speed=70.0)
    folds = sorted({(b.begin.value, b.begin.frequency) for b in found if b.begin.cause == FOLD})
    assert len(folds) == 2
    system = assemble(scene)
    for mu, _ in folds:
        counts = [len(backward(system.with_friction(mu * (1.0 + off)), 70.0)) for off in (-1e-6, 1e-6)]
        assert counts[1] == counts[0] + 2
    [(_, small)] = events(found, AMPLITUDE)
    whirl = nearest(assemble(scene.with_values({"contact.friction": small.value})), small.frequency, 70.0)
    assert whirl.rotor_amplitude == pytest.approx(system.contact.gap, rel=1e-6)
    with pytest.raises(SceneError):
        continuation(scene, "contact.friction", [-1.0, 0.5])


def test_roots_that_come_from_infinity_are_named():
    system = reference("laval")
    _, lines = root_lines(lambda mu: (system.with_friction(mu), 50.0), np.linspace(0.0, 0.5, 11))
    assert sorted(line.begin.cause for line in lines) == sorted([FOLD, FOLD, UNBOUNDED])


# ---------------------------------------------------------------- least friction


def test_creeping_and_oscillatory_losses_are_told_apart():
    # along the friction the laval whirls exchange stability at their fold, a real eigenvalue, without any event between
    scene = reference_scene("laval")
    found = continuation(scene, "contact.friction", np.linspace(0.01, 0.4, 14), speed=50.0)
    pair = [b for b in found if b.begin.cause == FOLD]
    assert len(pair) == 2 and {bool(b.stable[0]) for b in pair} == {True, False}
    assert not events(pair, CREEPING)
    [(_, lost)] = events(pair, OSCILLATORY)
    assert nearest(assemble(scene.with_values({"contact.friction": lost.value})), lost.frequency, 50.0).growth_frequency > 1.0


# ---------------------------------------------------------------- each growth rate once


@pytest.mark.parametrize(("name", "most"), [("laval", 4), ("gyroscopic_transition", 430)])
def test_growth_rates_are_those_of_every_speed_and_computed_once(name, most, monkeypatch):
    """Without gyroscopics one speed tells them for all; with them 80 speeds of five whirls and a few places between do."""
    system, speeds, asked = reference(name), np.linspace(20.0, 150.0, 80), []

    def counted(system, Psi, F_N, Omega):
        asked.extend(Psi)
        return whirl_growths(system, Psi, F_N, Omega)

    monkeypatch.setattr("rsc.analysis.follow.whirls.whirl_growths", counted)
    found = branches(system, speeds)
    assert 0 < len(asked) <= most
    whirls = [whirl for branch in found for whirl in branch.whirls]
    assert len(whirls) >= 80
    for whirl in whirls:
        assert whirl.growth_rate == nearest(system, whirl.frequency, whirl.speed).growth_rate
