"""Rotors that nothing holds run as with next to no stiffness; what cannot exist then is refused in a line."""

import math

import numpy as np
import pytest

import rsc
from rsc.errors import SceneError

GAP, G = 0.25e-3, 9.81
FREE_CHAIN = [[1e5, -1e5, 0.0], [-1e5, 3e5, -2e5], [0.0, -2e5, 2e5]]
DISK = {"model": "disk", "mass": 10.0, "diametral_inertia": 0.1, "polar_inertia": 0.18, "eccentricity": 1e-5}
ROTORS = {
    "laval": {"model": "laval", "mass": 10.0, "stiffness": 0.0},
    "chain": {"model": "chain", "masses": [2.0, 3.0], "stiffnesses": [0.0, 1e5, 0.0], "damping_ratio": 0.02},
    "loose chain": {"model": "chain", "masses": [2.0, 3.0], "stiffnesses": [0.0] * 3, "dampings": [3.0] * 3},
    "matrices": {"model": "matrices", "mass": np.diag([2.0, 3.0, 4.0]).tolist(), "stiffness": FREE_CHAIN, "damping_ratio": 0.02},
    "disk": {**DISK, "stiffness": [[0.0, 0.0], [0.0, 0.0]], "damping": [[30.0, 0.0], [0.0, 0.1]]},
    "disk on a hinge": {**DISK, "stiffness": [[1e5, 1e4], [1e4, 1e3]], "damping_ratio": 0.02},
    "free in z": {"model": "laval", "mass": 10.0, "stiffness": 1e5, "supports": [[0, [1e5, 0.0, 0.0, -1e5]]]},
}


def scene_of(rotor, start=None, **drive):
    return rsc.Scene.from_dict(
        {
            "rotor": {"gravity": G, **rotor},
            "stator": {"model": "laval", "mass": 1.2, "stiffness": 2e7, "damping": 3e3},
            "contact": {"gap": GAP, "friction": 0.3, "stiffness": 1e8, "damping_ratio": 0.05, "diameter": 0.05}
            | {"slip_velocity": 0.01},
            "drive": {"speed": 100.0, "duration": 0.05} | drive,
            "start": start or {"centre": True},
            "output": {"rate": 20_000.0},
        }
    )


def barely_held(rotor):
    """The rotor with one millionth of a newton per metre more at its first coordinate."""
    if rotor["model"] == "chain":
        return {**rotor, "stiffnesses": [1e-6, *rotor["stiffnesses"][1:]]}
    if rotor["model"] == "laval":
        return {**rotor, "stiffness": rotor["stiffness"] + 1e-6}
    stiffness = np.array(rotor["stiffness"])
    stiffness[0, 0] += 1e-6
    return {**rotor, "stiffness": stiffness.tolist()}


@pytest.mark.parametrize("name", ROTORS)
def test_a_free_rotor_falls_and_bounces_as_with_next_to_no_stiffness(name):
    free, held = (rsc.simulate(scene_of(rotor)) for rotor in (ROTORS[name], barely_held(ROTORS[name])))
    assert free.status == held.status == "finished"
    before = free.time < 0.012  # later the bounces multiply every difference
    np.testing.assert_allclose(free.rotor[before], held.rotor[before], rtol=0.0, atol=1e-5 * GAP)
    largest = held.normal_force.max()
    np.testing.assert_allclose(free.normal_force[before], held.normal_force[before], rtol=0.0, atol=1e-3 * largest)
    if name in ("laval", "loose chain"):  # in these nothing but damping hinders the fall
        touch = free.time[np.argmax(free.normal_force > 0.0)]
        assert touch == pytest.approx(math.sqrt(2.0 * GAP / G), rel=0.02)


def test_a_free_rotor_comes_to_rest_at_the_angle_of_friction():
    """F_N = m g/sqrt(1 + mu^2) at -90 degrees - atan(mu), where gravity is balanced by contact alone."""
    scene = scene_of({**ROTORS["laval"], "damping": 200.0}, duration=1.5)
    result = rsc.simulate(scene.with_values({"contact.damping_ratio": 0.3}))
    mu = scene.contact.friction
    assert np.angle(result.rotor[-1, 0] - result.stator[-1, 0]) == pytest.approx(-math.pi / 2 - math.atan(mu), abs=1e-3)
    assert result.normal_force[-1] == pytest.approx(10.0 * G / math.hypot(1.0, mu), rel=1e-3)


@pytest.mark.parametrize("speed", [0.0, 100.0])
@pytest.mark.parametrize("name", ROTORS)
def test_a_free_rotor_runs_without_contact_only_where_nothing_pulls_it(name, speed):
    running = scene_of({**ROTORS[name], "gravity": 0.0}, {"running": True}, speed=speed)
    assert rsc.simulate(running).normal_force.max() == 0.0
    with pytest.raises(SceneError, match=r"start\.running = True: .*nothing holds the rotor against its load"):
        rsc.simulate(running.with_values({"rotor.gravity": G}))
