"""`predict_many`: every array holds what `predict` tells one by one; what cannot be resolved is refused with the reason."""

import numpy as np
import pytest

import rsc
from rsc.errors import SceneError
from systems import REFERENCE, reference_scene

VALUES = ("frequency", "normal_force", "rotor_amplitude", "stator_amplitude", "growth_rate", "growth_frequency")
SPEEDS = [3.0, 20.0, 55.0, 90.0, 140.0]


def body(rng, n):
    """Random matrices of n coordinates."""
    mass = np.diag(10.0 ** rng.uniform(-0.7, 0.7, n))
    omega = 2.0 * np.pi * 10.0 ** rng.uniform(1.0, 2.3, n)
    shape = np.sqrt(mass) @ np.linalg.qr(rng.normal(size=(n, n)))[0]
    damping, stiffness = (shape @ np.diag(d) @ shape.T for d in (0.05 * omega * rng.uniform(0.3, 3.0, n), omega**2))
    return {"model": "matrices", "mass": mass.tolist(), "damping": damping.tolist(), "stiffness": stiffness.tolist()}


def random_scenes(shape, count, seed):
    """Random scenes of one shape that differ in everything: gyroscopics, unbalance, ring, load, diameter (every other one)."""
    rng, scenes = np.random.default_rng(seed), []
    n, m = shape
    for i in range(count):
        rotor, stator = body(rng, n), body(rng, m) if m else {"model": "rigid"}
        polar = np.diag(rng.uniform(0.0, 1.5, n) * np.diag(rotor["mass"]) * (np.arange(n) > 0))
        rotor |= {"gyroscopic": polar.tolist(), "eccentricity": rng.uniform(0.0, 2e-4, n).tolist()}
        rotor["tilt_coordinates"] = list(range(1, n))
        contact = {"gap": 10.0 ** rng.uniform(-3.5, -2.5), "friction": 10.0 ** rng.uniform(-1.3, 0.0), "stiffness": 3e6}
        contact |= {"damping": rng.uniform(0.0, 50.0), "ring_eccentricity": [rng.uniform(0.0, 1e-4), 30.0]}
        if i % 2:
            contact["diameter"] = rng.uniform(0.01, 0.3)
        drive = {"speed": 50.0, "duration": 1.0}
        scenes.append(rsc.Scene.from_dict({"rotor": rotor, "stator": stator, "contact": contact, "drive": drive}))
    return scenes


def assert_same(arrays, place, whirl):
    for name in VALUES:
        assert getattr(arrays, name)[place] == pytest.approx(getattr(whirl, name), rel=1e-12, abs=0.0), name
    assert {name for name, holds in arrays.conditions.items() if not holds[place]} == set(whirl.violated)
    assert (arrays.stable[place], arrays.admissible[place], arrays.exists[place]) == (whirl.stable, whirl.admissible, True)


def assert_none(arrays, place):
    assert all(np.isnan(getattr(arrays, name)[place]) for name in VALUES)
    assert not any(holds[place] for holds in (*arrays.conditions.values(), arrays.stable, arrays.admissible, arrays.exists))


@pytest.mark.parametrize("shape", [(1, 0), (1, 1), (2, 1), (3, 2)])
def test_all_whirls_are_those_of_predict(shape):
    scenes = random_scenes(shape, 8, seed=sum(shape))
    arrays, most = rsc.predict_many(scenes, SPEEDS), 0
    assert np.array_equal(arrays.speed, np.tile(SPEEDS, (8, 1)))
    for i, scene in enumerate(scenes):
        for j, whirls in enumerate(rsc.predict(scene, SPEEDS)):
            most = max(most, len(whirls))
            for k in range(arrays.frequency.shape[2]):
                if k < len(whirls):
                    assert_same(arrays, (i, j, k), whirls[k])
                else:
                    assert_none(arrays, (i, j, k))
    assert arrays.frequency.shape == (8, 5, most) and most > 0


@pytest.mark.parametrize("name", sorted(path.stem for path in REFERENCE.glob("*.toml") if "." not in path.stem))
def test_one_scene_at_several_speeds_has_the_whirls_of_predict(name):
    """A stack of one system at several speeds: no whirl stands at another speed than its own, and none is missing."""
    scene = reference_scene(name)
    speeds = np.linspace(0.2, 1.0, 5) * max(scene.drive.speed)
    each = rsc.predict(scene, speeds)
    for chosen in (speeds, speeds[::-1], speeds[2:3]):
        arrays = rsc.predict_many([scene], chosen)
        for j, speed in enumerate(chosen):
            whirls = each[int(np.flatnonzero(speeds == speed)[0])]
            assert arrays.exists[0, j].sum() == len(whirls) > 0
            for k, whirl in enumerate(whirls):
                assert_same(arrays, (0, j, k), whirl)


@pytest.mark.parametrize("together", [7, 512])  # blocks that end within a scene, and one block
def test_the_whirls_next_to_frequencies_are_those_of_predict(monkeypatch, together):
    monkeypatch.setattr("rsc.analysis.paper.predict_many._TOGETHER", together)
    scenes = random_scenes((2, 1), 10, seed=7)
    scenes[4] = scenes[4].with_values({"contact.friction": 0.0})
    speeds = np.random.default_rng(5).uniform(-30.0, 150.0, (10, 4))
    near = np.array([-25.0, -80.0, -1e4])
    arrays, absent = rsc.predict_many(scenes, speeds, near), 0
    assert arrays.frequency.shape == (10, 4, 3) and np.array_equal(arrays.speed, speeds)
    for i, scene in enumerate(scenes):
        for j, whirls in enumerate(rsc.predict(scene, speeds[i])):
            for k, target in enumerate(near):
                if whirls:
                    assert_same(arrays, (i, j, k), min(whirls, key=lambda whirl, target=target: abs(whirl.frequency - target)))
                else:
                    absent += 1
                    assert_none(arrays, (i, j, k))
    assert 12 <= absent < 60


def test_forward_whirls_of_a_rotor_with_negative_damping():
    content = reference_scene("laval").to_dict()
    content["rotor"] |= {"damping_ratio": -0.02, "allow_negative_damping": True}
    scene = rsc.Scene.from_dict(content)
    whirls, arrays = rsc.predict(scene, 50.0), rsc.predict_many([scene], [50.0])
    assert [whirl.frequency > 0.0 for whirl in whirls] == [False, False, True]
    for k, whirl in enumerate(whirls):
        assert_same(arrays, (0, 0, k), whirl)
    assert_same(rsc.predict_many([scene], [50.0], [40.0, -60.0]), (0, 0, 0), whirls[2])


def test_scenes_without_any_whirl_have_empty_arrays():
    scene = reference_scene("laval").with_values({"contact.friction": 0.0})
    arrays = rsc.predict_many([scene, scene], SPEEDS)
    assert arrays.frequency.shape == arrays.admissible.shape == (2, 5, 0)
    alone = rsc.predict_many([scene], SPEEDS, [-20.0])
    assert alone.frequency.shape == (1, 5, 1) and np.isnan(alone.growth_rate).all()


LAVAL, DISK = reference_scene("laval"), reference_scene("gyroscopic_transition")


@pytest.mark.parametrize(
    ("scenes", "speeds", "near", "reason"),
    [
        ([], [50.0], None, r"scenes = \[\]: must be at least one scene"),
        ([LAVAL, DISK], [50.0], None, r"scenes\[1\] = '2 \+ 1 coordinates': must be a scene of 1 \+ 1 coordinates"),
        ([LAVAL], [50.0, np.nan], None, r"speeds = nan: must be speeds in Hz between -1e\+06 and 1e\+06"),
        ([LAVAL], [50.0, -2e6], None, r"speeds = -2000000\.0: must be speeds in Hz"),
        ([LAVAL], [], None, r"speeds = 'array of the shape \(0,\)': must be of the shape \(n,\), or \(1, n\)"),
        ([LAVAL], 50.0, None, r"speeds = 'array of the shape \(\)'"),
        ([LAVAL] * 3, np.ones((2, 5)), None, r"speeds = 'array of the shape \(2, 5\)': must be of the shape \(n,\), or \(3, n\)"),
        ([LAVAL], ["fast"], None, r"speeds = .*: must be a number in Hz, or a text with a unit"),
        ([LAVAL], [50.0], [np.nan], r"near = nan: must be frequencies in Hz up to 1e\+06 in size, not 0 \(negative for"),
        ([LAVAL], [50.0], [-20.0, 0.0], r"near = 0\.0: must be frequencies"),
        ([LAVAL], [50.0], [2e6, -2e6], r"near = 2000000\.0: must be frequencies"),
        ([LAVAL], [50.0], [], r"near = 'array of the shape \(0,\)': must be frequencies of the shape \(n,\)"),
        ([LAVAL], [50.0], -20.0, r"near = 'array of the shape \(\)'"),
    ],
)
def test_what_cannot_be_resolved_is_refused_with_the_reason(scenes, speeds, near, reason):
    with pytest.raises(SceneError, match=f"^predict_many: {reason}"):
        rsc.predict_many(scenes, speeds, near)
