"""Normal forces of two whirls that exist together: the limit of their ratio against the eigenvalues of the first."""

from dataclasses import replace

import numpy as np
import pytest

import rsc
from rsc.analysis.follow.branches import branches
from rsc.analysis.follow.events import OSCILLATORY
from rsc.analysis.follow.force_ratio import SMALL, force_ratios, pair_limit, ratio_places, ratios_of
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.receptance import contact_receptance, receptance
from rsc.analysis.paper.small_motions import small_motion
from rsc.analysis.several.predict import predict
from rsc.analysis.survey.survey import survey
from rsc.errors import SceneError
from rsc.show.pictures.branch_map import branch_map
from rsc.show.words.plain import survey_plain, whirls_plain
from rsc.show.words.text import survey_text, whirls_text
from systems import TWO_PI, changed, random_rotor, reference, reference_scene

SPEEDS = np.linspace(20.0, 150.0, 66)


def crossing_and_place(system):
    """The event at which branch A loses its stability, and the `RatioPlace` of A towards another."""
    found = branches(system, SPEEDS)
    a = next(branch for branch in found if branch.lost)
    [event] = [event for event in a.events if event.cause == OSCILLATORY]
    [place] = [place for place in ratio_places(system, found) if place.label == a.label]
    return event, place, found


@pytest.mark.parametrize("softer", [1.0, 0.2])
def test_a_growing_line_meets_the_condition_of_the_derivation_exactly(softer):
    system = reference("gyroscopic_transition")
    system = changed(system, contact_damping=0.0, contact_stiffness=softer * system.law.stiffness)
    event, _, _ = crossing_and_place(system)
    Psi, Omega = TWO_PI * event.frequency, TWO_PI * event.value
    [F_N] = [w.normal_force for w in predict_system(system, event.value) if abs(w.frequency - event.frequency) < 1e-3]
    line = Psi - abs(small_motion(system, Psi, F_N, Omega).eigenvalue.imag)
    c = 1.0 + 1j * system.law.friction
    flexible = receptance(system, np.array([line, 2.0 * Psi - line]), Omega) + 1.0 / (c * system.law.stiffness)
    q = system.contact.gap / (2.0 * c * F_N)
    e = abs(q) ** 2 / np.conj(flexible[1] + q)
    assert abs(flexible[0] + q - e) < 1e-6 * abs(q)
    assert abs(e) > 1e-2 * abs(q)  # so that the mirror line is seen


@pytest.mark.parametrize("softer", [1.0, 0.2])
def test_stability_is_lost_at_the_least_ratio(softer):
    system = reference("gyroscopic_transition")
    system = changed(system, contact_damping=0.0, contact_stiffness=softer * system.law.stiffness)
    event, place, found = crossing_and_place(system)
    assert place.speed == pytest.approx(event.value, rel=3e-4)
    assert place.frequency == pytest.approx(event.frequency, rel=1e-4) and place.holds == event.holds == "below"
    # the forces of the two whirls at that speed
    whirls = {b.label: b.at(place.speed).frequency for b in found if b.label in (place.label, place.towards)}
    force = {
        label: min(predict_system(system, place.speed), key=lambda w, f=f: abs(w.frequency - f)).normal_force
        for label, f in whirls.items()
    }
    assert place.ratio == pytest.approx(force[place.label] / force[place.towards], rel=1e-6)
    assert abs(place.ratio - 0.5) < 0.01 and place.mirror_share < 0.1


@pytest.mark.parametrize("speed", [60.0, 90.0])
def test_the_line_grows_at_the_rate_of_the_derivation(speed):
    # s (1/F_B - 1/(2 F_A)) Im(cH)' / |(cH)'|^2 at Psi_B, but for the mirror line
    system = changed(reference("gyroscopic_transition"), contact_damping=0.0)
    b, a = sorted(predict_system(system, speed), key=lambda w: -w.normal_force)[:2]
    slope = contact_receptance(system, TWO_PI * speed, np.array([TWO_PI * b.frequency]))[1][0]
    rate = system.contact.gap * (1.0 / b.normal_force - 0.5 / a.normal_force) * slope.imag / abs(slope) ** 2
    assert a.growth_rate == pytest.approx(rate, rel=0.02) and (rate > 0.0) == (a.normal_force < 0.5 * b.normal_force)


def test_a_whirl_below_its_limit_is_unstable_on_random_rotors():
    rng = np.random.default_rng(7)
    below, above, wrong = 0, 0, []
    for _ in range(150):
        system = random_rotor(rng)
        whirls = predict_system(system, rng.uniform(5.0, 200.0))
        stable = {w.frequency: w.stable for w in whirls}
        for pair in ratios_of(system, whirls):
            assert pair.mirror_share < SMALL and abs(0.5 / pair.least - 1.0) < SMALL
            low = pair.ratio < pair.least
            below, above = below + low, above + (not low and stable[pair.frequency])
            if low and stable[pair.frequency]:
                wrong.append(pair)
    assert wrong == [] and below > 30 and above > 20


def test_pairs_are_those_that_mean_something():
    scene, system = reference_scene("gyroscopic_transition"), reference("gyroscopic_transition")
    whirls = predict(scene, 75.0)
    pairs = force_ratios(scene, 75.0)
    assert len(pairs) == 2 < len(whirls) * (len(whirls) - 1)
    assert {(p.frequency, p.towards) for p in pairs} == {(p.towards, p.frequency) for p in pairs}
    by_frequency = {w.frequency: w for w in whirls}
    for pair in pairs:
        a, b = by_frequency[pair.frequency], by_frequency[pair.towards]
        assert a.admissible and b.admissible
        assert pair.ratio == pytest.approx(a.normal_force / b.normal_force) and (pair.ratio > pair.least) == a.stable
    # a whirl that fails a side condition is in no pair, but for the condition on the unbalance
    for name, count in (("rotor_amplitude_exceeds_gap", 0), ("sliding", 0), ("asynchronous_force_dominates", 2)):
        changed_whirls = [replace(w, violated=(name,)) if w is b else w for w in whirls]
        assert len(ratios_of(system, changed_whirls)) == count
    # of all roots only these have a small share and a B on the stable side of its fold
    Psi = TWO_PI * np.array([[a.frequency, b.frequency] for a in whirls for b in whirls if a is not b]).T
    F_N = np.array([[a.normal_force, b.normal_force] for a in whirls for b in whirls if a is not b]).T
    limit = pair_limit(system, Psi, F_N, TWO_PI * 75.0)
    assert limit.holds.sum() == 2 < min((limit.mirror_share < SMALL).sum(), (limit.slope < 0.0).sum())
    assert force_ratios(scene) == force_ratios(scene, scene.drive.speed[0]) == rsc.force_ratios(scene, 20.0)
    with pytest.raises(SceneError, match="speed = nan"):
        force_ratios(scene, float("nan"))


def test_without_gyroscopics_or_whirls_there_is_no_place():
    system = reference("mdof_2x2")
    assert not system.turns and ratio_places(system, branches(system, SPEEDS)) == []
    assert force_ratios(reference_scene("laval").with_values({"contact.friction": 0.0}), 50.0) == []


def test_tables_and_json_tell_ratio_limit_and_share():
    scene, system = reference_scene("gyroscopic_transition"), reference("gyroscopic_transition")
    whirls = predict(scene, 75.0)
    ratios = ratios_of(system, whirls)
    [text] = [line for line in whirls_text(whirls, scene.contact.gap, (), ratios).splitlines() if "unstable towards it" in line]
    assert text.split()[:3] == ["-33.2142", "-49.7159", "0.4819"]
    assert "F_N ratio" not in whirls_text(whirls, scene.contact.gap)
    plain = {w["frequency"]: w["towards"] for w in whirls_plain(whirls, ratios)}
    assert [len(plain[w.frequency]) for w in whirls] == [0, 1, 0, 1, 0]
    pair = next(r for r in ratios if r.ratio < r.least)
    wanted = {name: getattr(pair, name) for name in ("frequency", "towards", "ratio", "least", "mirror_share")}
    assert plain[pair.frequency] == [wanted]
    found = survey(scene)
    [place] = found.ratios
    assert f"whirl A holds against B below {place.speed:.4f} Hz" in survey_text(found)
    assert survey_plain(found)["force_ratios"][0]["ratio"] == place.ratio
    # the map marks it on both branches
    [line] = [line for line in branch_map(found).axes[0].lines if line.get_label() == "F_N of A is 0.501 F_N of B"]
    ends = [np.interp(place.speed, b.speed, b.frequency) for b in found.branches if b.label in "AB"]
    np.testing.assert_allclose(line.get_xydata(), [[place.speed, ends[0]], [place.speed, ends[1]]], rtol=1e-4)  # five digits
