"""Finite-element rotors that are dropped: bearings switched off during a run, races, whirls, against the full model."""

from dataclasses import replace

import numpy as np
import pytest

import rsc
from full_machine import FullMachine
from rsc.analysis.several.predict import predict_several
from rsc.machine.model.contact import Unbalance
from rsc.scene.scene import Scene
from rsc.system.assemble import assemble

OFF, GAP = 5e-3, 2.5e-4
BEARINGS = '[{{at = "0.15 m", stiffness = 2e6, damping = 2e3{off}}}, {{at = "1.05 m", stiffness = 2e6, damping = 2e3{off}}}]'
ROTOR = """
[rotor]
model = "shaft"
elements = {elements}
sections = [{{length = 0.3, diameter = 0.05}}, {{length = 0.6, diameter = 0.07}}, {{length = 0.3, diameter = 0.05}}]
disks = [{{at = 0.5, diameter = 0.3, width = 0.03, name = "one"}}, {{at = 0.7, diameter = 0.3, width = 0.03, name = "two"}}]
rayleigh = [0.0, 1e-6]
bearings = {bearings}
unbalance = [{{at = "one", amount = "200 g*mm"}}]
gravity = 9.81
[stator]
model = "matrices"
mass = [[1.2, 0], [0, 1.2]]
stiffness = [[2e7, 0], [0, 2e7]]
damping = [[3e3, 0], [0, 3e3]]
[drive]
speed = "100 Hz"
duration = "25 ms"
[start]
{start}
[output]
rate = 20000
[solver]
rtol = 1e-8
[reduction]
band = ["-1500 Hz", "1000 Hz"]
"""
CONTACT = """
[[contact]]
name = "{name}"
at = "{at}"
stator_coordinate = {number}
gap = "0.25 mm"
friction = 0.2
stiffness = 1e7
damping = 1000
diameter = "50 mm"
slip_velocity = 0.02
race_inertia = 2e-4
race_drag = 2e-5
"""
ENDS = CONTACT.format(name="front", at="0.2 m", number=0) + CONTACT.format(name="rear", at="1.0 m", number=1)
AT_NODES = {"unbalances": [Unbalance("one", 2e-4)], "gravity": 9.81, "loads": []}
PLACES = ["0.2 m", "1.0 m"]


def text(off=f", off = {OFF}", bearings=None, contacts=ENDS, start="running = true", elements=3):
    own = BEARINGS.format(off=off) if bearings is None else bearings
    return ROTOR.format(bearings=own, start=start, elements=elements) + contacts


def free_model():
    """The model without bearings, with nodes at their places all the same."""
    alone = text(bearings="[]", start="centre = true").replace("sections", "observers = [0.15, 1.05]\nsections", 1)
    return Scene.from_toml(alone).reductions[0].model


@pytest.fixture(scope="module")
def dropped():
    scene = Scene.from_toml(text())
    return scene, rsc.simulate(scene)


@pytest.mark.nightly
def test_the_first_20_ms_are_those_of_the_full_machine(dropped):
    """From the orbit in its bearings, through the fall and the first contacts, with races that spin up."""
    scene, result = dropped
    held = scene.reductions[0].model
    free = free_model()
    assert held.n == free.n == 56 and scene.rotor.n_coordinates <= 26 and not held.free and free.free
    turned = 2.0 * np.pi * 100.0 * OFF
    fall = FullMachine(scene, free, PLACES, AT_NODES, turned)
    in_bearings = FullMachine(scene, held, PLACES, AT_NODES)
    later = result.time >= OFF
    deflections, races = fall.dropped(in_bearings.running(OFF), result.time[later] - OFF)
    own = result.rotor[:, :2]
    assert np.abs(own[later] - deflections).max() < 1e-3 * GAP
    np.testing.assert_allclose(result.race_speed[later], races, atol=1e-3 * races.max())
    assert result.normal_force.max() > 500.0 and races[-1].max() > 1.0
    # until then the bearings hold it on its orbit
    orbit = np.array([in_bearings.running(time)[0] @ fall.rows.T for time in result.time[~later]])
    np.testing.assert_allclose(own[~later], orbit, atol=1e-3 * GAP)
    assert not result.normal_force[~later].any()


@pytest.mark.nightly
def test_the_ledger_closes_over_the_switch_and_the_steps_end_there(dropped):
    scene, result = dropped
    ledger = result.summary.ledger
    assert abs(ledger.residual) < 1e-6 * max(abs(ledger.energy_in), abs(ledger.change))
    # two runs: in the bearings until then, and from there without them
    before = rsc.simulate(scene.with_values({"drive.duration": 3.0 * OFF, "output.velocities": True}))
    i = int(np.argmin(abs(before.time - OFF)))
    again = replace(scene, rotor=scene.rotor.at_end).to_dict()
    again["rotor"]["unbalance"] = [[own.real, own.imag] for own in
                                   np.array(scene.rotor.unbalance) * np.exp(2j * np.pi * 100.0 * OFF)]  # fmt: skip
    again["start"] = {name: [[z.real, z.imag] for z in getattr(before, name)[i]] for name in ("rotor", "rotor_velocity")}
    again["start"] |= {name: [[z.real, z.imag] for z in getattr(before, name)[i]] for name in ("stator", "stator_velocity")}
    again["drive"]["duration"] = 2.0 * OFF
    rest = rsc.simulate(Scene.from_dict(again))
    after = before.rotor[i:][: len(rest.time)]
    assert np.abs(rest.rotor[: len(after)] - after).max() < 1e-6 * GAP


@pytest.mark.nightly
def test_the_pair_whirls_are_those_of_the_full_machine():
    scene = Scene.from_toml(text())
    full = FullMachine(scene, free_model(), PLACES, AT_NODES)
    own, whole = (
        [whirl for whirl in predict_several(system, 100.0) if len(whirl.pressed) == 2 and abs(whirl.frequency) < 500.0]
        for system in (assemble(scene), full.system)
    )
    assert len(own) == len(whole) >= 1
    for one, other in zip(own, whole, strict=True):
        assert one.frequency == pytest.approx(other.frequency, rel=1e-5)
        for name in ("front", "rear"):
            assert one.contacts[name].normal_force == pytest.approx(other.contacts[name].normal_force, rel=1e-3)


def test_what_the_analysis_tells_is_of_the_machine_without_them_and_modes_are_with_them():
    scene = Scene.from_toml(text())
    free, held = Scene.from_toml(text(bearings="[]", start="centre = true")), Scene.from_toml(text(off=""))
    first = [mode.frequency for mode in rsc.modes(scene, 100.0).rotor[:4]]
    assert first == pytest.approx([mode.frequency for mode in rsc.modes(held, 100.0).rotor[:4]], rel=1e-4)
    whirls = [[whirl.frequency for whirl in rsc.predict(one, 100.0) if whirl.growth_rate < 0.0] for one in (scene, free)]
    assert whirls[0] == pytest.approx(whirls[1], rel=1e-4)
    assert scene.steady(50.0).rotor.off_times is None
    assert Scene.from_toml(scene.to_toml()) == scene and scene.mirrored().mirrored() == replace(scene, reductions=())


REFUSED = {
    "after the end": (text(off=", off = 0.1"), r"bearing 1, off = 0.1: must be before the end of the run at 0.025 s"),
    "before the start": (text(off=", off = -0.1"), r"bearing 1, off = -0.1: must be a number > 0"),
    "twice": (text(off=", off = [0.01, 0.02]"), r"bearing 1, off = \[0.01, 0.02\]: must be a number in s"),
    "one end": (
        text(bearings="[]", contacts=CONTACT.format(name="front", at="0.2 m", number=0)),
        "contacts at two or more places must hold the rotor: 1 rigid-body",
    ),
    "with a torque": (
        text().replace('speed = "100 Hz"', 'speed = "100 Hz"\ninertia = 1.0\ntorque = [[0, 10], [200, 10]]'),
        "without off where a torque drives the rotor",
    ),
}


@pytest.mark.parametrize(("scene", "message"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_is_refused_in_one_line(scene, message):
    with pytest.raises(rsc.SceneError, match=message) as caught:
        Scene.from_toml(scene)
    assert "\n" not in str(caught.value)
