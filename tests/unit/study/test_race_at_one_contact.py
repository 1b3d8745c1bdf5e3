"""A rotor in one auxiliary bearing whose inner race turns: what is predicted, and what a run makes of it."""

import numpy as np
import pytest

import rsc
from rsc.analysis.follow.least_friction import mu_min
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.paper.synchronous import forward_rub
from rsc.study.report.check import report
from rsc.system.assemble import assemble

TWO_PI = 2.0 * np.pi
SCENE = {
    "rotor": {"model": "laval", "mass": 10.0, "stiffness": 1e5, "damping": 200.0, "eccentricity": 1e-4},
    "stator": {"model": "laval", "mass": 1.2, "stiffness": 2e7, "damping": 3e3},
    "contact": {"gap": 2.5e-4, "friction": 0.3, "stiffness": 1e8, "damping": 2e3, "diameter": 0.05},
    "drive": {"speed": 200.0, "duration": 0.2},
}
RACE = {"race_inertia": 2e-4, "race_drag": 2e-5}


def with_race(**race):
    return rsc.Scene.from_dict(SCENE | {"contact": SCENE["contact"] | race})


def stable(scene):
    (whirl,) = (whirl for whirl in rsc.predict(scene, 200.0) if whirl.stable)
    return whirl


def started(scene, whirl, **more):
    """A run of the scene that begins on a whirl."""
    turning = 2j * np.pi * whirl.frequency
    start = {"allow_penetration": True}
    for name in ("rotor", "stator"):
        (z,) = getattr(whirl, f"{name}_shape")
        v = turning * z
        start |= {name: [[float(z.real), float(z.imag)]], f"{name}_velocity": [[float(v.real), float(v.imag)]]}
    content = scene.to_dict() | {"start": start}
    content["rotor"]["eccentricity"] = 0.0
    return rsc.simulate(rsc.Scene.from_dict(content).with_values(more))


def test_whirls_are_those_of_a_fixed_stator_and_slide_only_where_drag_holds_the_race():
    fixed, held, free = (stable(scene) for scene in (with_race(), with_race(**RACE | {"race_drag": 1e6}), with_race(**RACE)))
    for whirl in (held, free):
        assert (whirl.frequency, whirl.normal_force, whirl.growth_rate) == (
            fixed.frequency, fixed.normal_force, fixed.growth_rate
        )  # fmt: skip
    assert held.conditions["sliding"] == pytest.approx(fixed.conditions["sliding"], rel=1e-6)
    assert "sliding" not in fixed.violated and "sliding" not in held.violated and "sliding" in free.violated


def test_a_run_stays_on_the_whirl_while_the_race_is_slow_and_leaves_it_when_it_turns():
    whirl = stable(with_race())
    heavy, light = (started(with_race(**RACE | {"race_inertia": inertia}), whirl) for inertia in (1e3, 2e-4))
    whole = heavy.stretches().whole()
    assert whole.turns / 0.2 == pytest.approx(whirl.frequency, rel=0.01) and whole.share > 0.99
    assert light.race_speed[-1] > 100.0
    last = light.contact_rotor()[-100:]
    assert np.abs(last).max() < 0.5 * whirl.rotor_amplitude


def test_on_a_race_nothing_rolls_and_no_forward_rub_is_predicted():
    fixed, turning = assemble(with_race()), assemble(with_race(**RACE))
    assert any(rolling_whirls(fixed, TWO_PI * speed) for speed in (50.0, 100.0, 200.0, 400.0))
    assert not any(rolling_whirls(turning, TWO_PI * speed) for speed in (50.0, 100.0, 200.0, 400.0))
    resonance = 16.0
    assert any(forward_rub(fixed, TWO_PI * speed) for speed in np.linspace(resonance, 3.0 * resonance, 20))
    assert not any(forward_rub(turning, TWO_PI * speed) for speed in np.linspace(resonance, 3.0 * resonance, 20))


def test_the_least_friction_counts_what_the_race_takes_along():
    """Drag that holds the race changes nothing; with less of it whirls slide from a larger friction on, or none does."""
    fixed, held, dragged, free = (
        mu_min(with_race(**race), 200.0) for race in ({}, *(RACE | {"race_drag": drag} for drag in (1e6, 3e-4, 1e-4)))
    )
    assert held.value == pytest.approx(fixed.value, rel=1e-9)
    assert dragged.value > 1.3 * fixed.value and dragged.cause.startswith("it rolls")
    assert free is None

    def slides(friction):
        whirls = rsc.predict(with_race(**RACE | {"race_drag": 3e-4, "friction": friction}), 200.0)
        return any(whirl.frequency < 0.0 and "sliding" not in whirl.violated for whirl in whirls)

    assert slides(1.01 * dragged.value) and not slides(0.99 * dragged.value)


def test_such_a_run_is_checked_and_its_motions_are_listed():
    fixed, scene = (with_race(**race).with_values({"drive.speed": [10.0, 60.0]}) for race in ({}, RACE))
    told = report(rsc.simulate(scene), lists=False)
    assert [branch.whirls[0].frequency for branch in told.branches if branch.stable.any()]
    assert np.isnan(told.resonance)  # that of a forward rub, which is predicted for a fixed stator alone
    assert report(rsc.simulate(fixed), lists=False).resonance > 10.0
    listed = rsc.motions(with_race(**RACE), 200.0, starts=4)
    predicted = [*listed.not_reached, *(one.predicted for one in listed.motions if one.predicted)]
    assert listed.motions and predicted and not {one.label for one in predicted} & {"forward rub", "roll"}
