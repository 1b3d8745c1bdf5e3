"""Where a machine rests under its load: the simulation, which knows nothing of it, finds it at rest there."""

import math

import numpy as np
import pytest

import rsc
from rsc.analysis.alone.at_rest import at_rest, static_deflection
from rsc.errors import SceneError
from rsc.system.assemble import assemble
from tiers import alternating

GAP, G = 0.25e-3, 9.81
SKEW, UNEQUAL = [[0, [0.0, -3e4, 3e4, 0.0]]], [[0, [1e5, 3e4, -5e4, -2e4]]]
LAVAL = {"model": "laval", "mass": 10.0, "stiffness": 1e5, "damping": 20.0}
ROTORS = {
    "laval": LAVAL,
    "stiff": {**LAVAL, "stiffness": 1e6},
    "skew": {**LAVAL, "supports": SKEW},
    "unequal": {**LAVAL, "supports": UNEQUAL},
    "unequal and stiff": {**LAVAL, "stiffness": 1e6, "supports": UNEQUAL},
    "held in y alone": {**LAVAL, "supports": [[0, [1e5, 0.0, 0.0, -1e5]]]},
    "free": {**LAVAL, "stiffness": 0.0},
    "free chain": {"model": "chain", "masses": [2.0, 3.0, 4.0], "stiffnesses": [0.0, 1e5, 2e5, 0.0], "damping_ratio": 0.02},
    "disk": {
        "model": "disk", "mass": 10.0, "diametral_inertia": 0.1, "polar_inertia": 0.18, "stiffness": [[1e5, 1e4], [1e4, 3e3]],
        "damping_ratio": 0.02,
    },
    "matrices": {
        "model": "matrices", "mass": [[2.0, 0.1], [0.1, 1.0]], "stiffness": [[2e4, -5e3], [-5e3, 1e4]], "damping_ratio": 0.03,
        "gyroscopic": [[0.0, 0.0], [0.0, 0.3]], "tilt_coordinates": [1], "skew_stiffness": [[500.0, 0.0], [0.0, 0.0]],
    },
}  # fmt: skip
STATORS = {"rigid": {"model": "rigid"}, "laval": {"model": "laval", "mass": 1.2, "stiffness": 2e6, "damping": 3e3}}


def scene_of(rotor, stator="rigid", **tables):
    content = {
        "rotor": {"gravity": G, **rotor},
        "stator": STATORS[stator],
        "contact": {"gap": GAP, "friction": 0.0, "stiffness": 1e8, "damping_ratio": 0.05, "diameter": 0.05},
        "drive": {"speed": [20.0, 30.0], "duration": 0.2},
    }
    return rsc.Scene.from_dict({**content, **{name: {**content.get(name, {}), **keys} for name, keys in tables.items()}})


SLOW = ("disk", "matrices")  # their numbers of coordinates have kernels to compile


@pytest.mark.parametrize(("name", "stator"), alternating(ROTORS, STATORS, SLOW))
def test_a_run_from_rest_without_friction_stays_there(name, stator):
    result = rsc.simulate(scene_of(ROTORS[name], stator))
    assert abs(result.rotor - result.rotor[0]).max() < 1e-5 * GAP
    first, force = result.normal_force[0], result.normal_force
    assert (first == 0.0) == (name in ("stiff", "unequal and stiff"))
    np.testing.assert_allclose(force, first, rtol=2e-3, atol=0.0)


def test_the_static_deflection_of_a_laval_rotor_is_its_sag():
    """x = -i m g/k, with skew stiffness -i m g/(k + i S); on the wall k x + F_N = m g."""
    stiff, skew, soft = (assemble(scene_of(ROTORS[name])) for name in ("stiff", "skew", "laval"))
    assert at_rest(stiff)[0][0] == pytest.approx(-10j * G / 1e6, rel=1e-12)
    assert static_deflection(skew)[0] == pytest.approx(-10j * G / (1e5 + 3e4j), rel=1e-12)
    depth = (10.0 * G - 1e5 * GAP) / (1e5 + 1e8)  # of the contact, of which the spring takes its share
    assert at_rest(soft)[0][0] == pytest.approx(-1j * (GAP + depth), rel=1e-9)
    assert static_deflection(assemble(scene_of(ROTORS["free"])))[0] == np.inf


def test_an_eccentric_ring_lies_on_the_wall_with_its_lowest_point():
    """The ring's centre, not the shaft, lies beneath the bearing centre, and the shaft beside it."""
    scene = scene_of(ROTORS["free"], contact={"ring_eccentricity": [1e-4, 0.0]})
    (place,), _ = at_rest(assemble(scene))
    assert place == pytest.approx(-1e-4 - 1j * (GAP + 10.0 * G / 1e8), rel=1e-9)


def test_the_mirror_image_rests_in_the_mirror():
    scene = scene_of(ROTORS["unequal"], "laval").with_values({"rotor.load": [[30.0, -98.0]]})
    for own, image in zip(at_rest(assemble(scene)), at_rest(assemble(scene.mirrored())), strict=True):
        np.testing.assert_allclose(image, -own.conj(), rtol=1e-9)


def test_only_a_start_at_the_centre_falls():
    """A machine that sags by 0.66 gaps and shakes a little: at rest it never touches, from the centre it does."""
    rotor = {"model": "laval", "mass": 100.0, "frequency": 25.0, "damping_ratio": 0.02, "eccentricity": 1e-5}
    contact = {"gap": 0.6e-3, "friction": 0.2, "stiffness": 2e7, "diameter": 0.1}
    drive = {"speed": [5.0, 15.0], "duration": 10.0}
    for start, touches in (({}, False), ({"rest": True}, False), ({"centre": True}, True)):
        scene = scene_of(rotor, "laval", contact=contact, drive=drive, start=start)
        assert rsc.Scene.from_toml(scene.to_toml()) == scene
        result = rsc.simulate(scene)
        assert bool(result.normal_force.any()) == touches
        assert result.rotor[0, 0] == pytest.approx(0.0 if touches else -1j * G / (2 * math.pi * 25.0) ** 2, rel=1e-12)


def test_what_nothing_holds_cannot_rest():
    loose = {"model": "chain", "masses": [2.0, 3.0], "stiffnesses": [0.0, 0.0, 0.0]}
    with pytest.raises(SceneError, match=r"start\.rest = True: .*\(nothing holds it; start\.centre = true lets it fall\)"):
        rsc.simulate(scene_of(loose))
    assert rsc.simulate(scene_of(loose, start={"centre": True})).contact_onsets > 0
