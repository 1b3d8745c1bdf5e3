"""A rotor that turns backwards is the mirror image of one that turns forward, in every number; words are told in the mirror."""

from dataclasses import fields, replace

import numpy as np
import pytest

import rsc
from rsc.analysis.follow.force_ratio import force_ratios
from rsc.analysis.follow.least_friction import mu_min
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.survey.survey import survey
from rsc.cli import main
from rsc.study.report.check import report
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from scenes import LAVAL, SCENES, changed
from systems import TWO_PI, quantities

PUMP = {
    "rotor": {"model": "laval", "mass": 12.0, "frequency": 2600 / 60, "damping_ratio": 0.02, "eccentricity": [2e-5, 40.0]},
    "stator": {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1},
    "contact": {"gap": 2.5e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05, "diameter": 0.08},
    "drive": {"speed": 50.0, "duration": 0.5},
}
DIRECTED = changed(
    LAVAL,
    rotor={"supports": [[0, [4e3, 1e3, -2e3, -2e3], [2.0, 0.5, 0.1, 1.0]]], "load": [[3.0, -20.0]]},
    contact={"diameter": 0.04, "ring_eccentricity": [2e-5, 70.0]},
    start={"running": True, "impulse": [0.01, 0.02]},
)
FALLING = {"speed": [50.0, 45.0], "duration": 0.4}
BODIES = changed(SCENES["gyroscopic disk"], contact={"diameter": 0.04}, drive=FALLING, start={"whirl": -67.8})
MATRICES = {
    **LAVAL,
    "rotor": {
        "model": "matrices", "mass": [[2.0, 0.1], [0.1, 1.0]], "stiffness": [[2e5, -5e4], [-5e4, 1e5]], "damping_ratio": 0.03,
        "gyroscopic": [[0.0, 0.0], [0.0, 0.3]], "tilt_coordinates": [1], "eccentricity": [[1e-5, 20.0], 1e-5],
        "skew_stiffness": [[500.0, 0.0], [0.0, 0.0]], "skew_damping": [[0.3, 0.0], [0.0, 0.1]],
    },
    "contact": {**LAVAL["contact"], "diameter": 0.04},
    "start": {"rotor": [[0.9e-3, 1e-4], [0.0, 1e-4]], "rotor_velocity": [[0.1, -0.3], [0.0, 0.0]]},
}  # fmt: skip
ALL = {"pump": PUMP, "directed": DIRECTED, "disk": BODIES, "matrices": MATRICES}
# what a weight acts on: an offset, a place to start from, a heavy spot beside y and an impact
HEAVY = changed(
    LAVAL,
    rotor={"supports": DIRECTED["rotor"]["supports"], "gravity": 9.81, "eccentricity": [5e-5, 33.0]},
    contact={"diameter": 0.04, "ring_eccentricity": [2e-5, 70.0], "offset": [1e-4, 5e-5]},
)
HEAVY["start"] = {"rotor": [[3e-4, -8e-4]], "rotor_velocity": [[0.1, -0.3]], "impulse": [0.01, 0.02]}
RESTING = {**changed(HEAVY, rotor={"gravity": 400.0}, contact={"offset": None}), "start": {"rest": True}}
BEARING = {"negative_stiffness": 2e4, "proportional": 6e4, "integral": 1e5, "derivative": 40.0, "derivative_filter": 1e4,
           "amplifier": 500.0, "off": 0.05}  # fmt: skip
HEAVY_ALL = {
    "heavy": HEAVY,
    "resting": RESTING,
    "levitated": changed(
        HEAVY,
        rotor={"gravity": 60.0, "magnetic_bearings": [[0, BEARING]]},
        start={"rotor": [[3e-4, -8e-4]], "rotor_states": [[1e-4, 2e-4]] * 3},
    ),
    "heavy whirl": changed(BODIES, rotor={"gravity": 9.81}),
}
# without a diameter, whose friction drives one way; the last turns both ways
ONE_SIDED = {f"{name}, one-sided": changed(scene, contact={"diameter": None}) for name, scene in ALL.items()}
ONE_SIDED["both ways"] = changed(LAVAL, drive={"speed": [50.0, -20.0]})


def pair(content):
    scene = rsc.Scene.from_dict(content)
    mirror = scene.mirrored()
    assert mirror.drive.speed == tuple(-speed for speed in scene.drive.speed) and mirror.mirrored() == scene
    return scene, mirror


def image(r):
    """y + i z in the mirror image: -y + i z."""
    return -np.conj(r)


@pytest.mark.parametrize("name", [*ALL, "resting", "heavy whirl"])
def test_the_system_of_the_mirrored_scene_is_the_mirrored_system(name):
    scene, mirror = pair((ALL | HEAVY_ALL)[name])
    found, wanted = quantities(assemble(mirror)), quantities(assemble(scene).mirrored())
    for place, value in found.items():
        if value is not None or wanted[place] is not None:
            np.testing.assert_allclose(value, wanted[place], rtol=1e-14, atol=0.0, err_msg=str(place))
    assert assemble(scene).skew == (name in ("directed", "matrices", "resting"))


@pytest.mark.parametrize("name", ALL | ONE_SIDED | HEAVY_ALL)
def test_a_run_of_the_mirrored_scene_is_the_mirror_image(name):
    """To the last bit; the weight acts along -z in both."""
    result, mirror = (rsc.simulate(scene) for scene in pair((ALL | ONE_SIDED | HEAVY_ALL)[name]))
    assert name not in HEAVY_ALL or result.normal_force.max() > 0.0
    np.testing.assert_array_equal(mirror.rotor, image(result.rotor))
    np.testing.assert_array_equal(mirror.stator, image(result.stator))
    np.testing.assert_array_equal(mirror.normal_force, result.normal_force)
    np.testing.assert_array_equal(mirror.friction_force, -result.friction_force)
    for watched in ("least_diameter", "sliding_lost", "status"):
        assert getattr(mirror.summary, watched) == getattr(result.summary, watched)
    state, mirrored = (initial_state(scene, assemble(scene)) for scene in pair((ALL | ONE_SIDED | HEAVY_ALL)[name]))
    assert mirrored.races is None and state.races is None
    for item in fields(state):
        assert (getattr(mirrored, item.name) is None) == (getattr(state, item.name) is None)
        if getattr(state, item.name) is not None:
            np.testing.assert_allclose(getattr(mirrored, item.name), image(getattr(state, item.name)), rtol=1e-12)


@pytest.mark.parametrize("name", ALL)
def test_predictions_of_the_mirrored_scene_have_the_other_sign(name):
    scene, mirror = pair(ALL[name])
    for speed in (20.0, 50.0):
        whirls, turned = rsc.predict(scene, speed), rsc.predict(mirror, -speed)
        assert len(whirls) == len(turned) > 0
        assert [w.frequency for w in turned] == sorted(w.frequency for w in turned)
        for whirl, image in zip(whirls, turned[::-1], strict=True):
            assert (image.frequency, image.speed) == (pytest.approx(-whirl.frequency, rel=1e-12), -speed)
            assert (image.stable, image.violated) == (whirl.stable, whirl.violated)
            assert image.synchronous.mirror_frequency == pytest.approx(-whirl.synchronous.mirror_frequency, rel=1e-12)
            for quantity in ("growth_rate", "normal_force", "rotor_amplitude", "stator_amplitude"):
                assert getattr(image, quantity) == pytest.approx(getattr(whirl, quantity), rel=1e-9)
            np.testing.assert_allclose(image.rotor_shape, whirl.rotor_shape.conj(), rtol=1e-9, atol=1e-15)
        least, other = mu_min(scene, speed), mu_min(mirror, -speed)
        assert (other.value, other.frequency) == (pytest.approx(least.value, rel=1e-9), pytest.approx(-least.frequency, rel=1e-9))
        rolls, turned = (rolling_whirls(assemble(of), TWO_PI * v) for of, v in ((scene, speed), (mirror, -speed)))
        for roll, image in zip(rolls, turned[::-1], strict=True):
            assert (image.Psi, image.traction) == (pytest.approx(-roll.Psi, rel=1e-9), pytest.approx(-roll.traction, rel=1e-6))
            assert image.normal_force == pytest.approx(roll.normal_force, rel=1e-6)


def test_many_predictions_at_speeds_of_both_signs_are_those_of_predict():
    scenes = [rsc.Scene.from_dict(changed(BODIES, contact={"friction": mu})) for mu in (0.1, 0.3)]
    speeds = [-60.0, 20.0, -35.0]
    arrays, near = rsc.predict_many(scenes, speeds), rsc.predict_many(scenes, speeds, [60.0, -60.0])
    for i, scene in enumerate(scenes):
        for j, whirls in enumerate(rsc.predict(scene, speeds)):
            frequency = np.array([whirl.frequency for whirl in whirls])
            assert arrays.frequency[i, j, : len(whirls)] == pytest.approx(frequency, rel=1e-12)
            assert arrays.growth_rate[i, j, : len(whirls)] == pytest.approx([w.growth_rate for w in whirls], rel=1e-9)
            assert not arrays.exists[i, j, len(whirls) :].any()
            for k, target in enumerate((60.0, -60.0)):
                assert near.frequency[i, j, k] == pytest.approx(frequency[abs(frequency - target).argmin()], rel=1e-12)


def test_lines_of_the_unbalance_are_those_of_the_mirror_image():
    scene, mirror = pair({**PUMP, "rotor": {**PUMP["rotor"], "gravity": 9.81}})
    own, other = rsc.predict_many([scene], [50.0]), rsc.predict_many([mirror], [-50.0])
    assert own.line.size and abs(own.line.real).min() > 0.0
    np.testing.assert_allclose(other.line[..., ::-1], image(own.line), rtol=1e-9)


def test_impacts_of_a_list_are_those_of_the_mirror_image():
    scene, mirror = pair({**PUMP, "rotor": {**PUMP["rotor"], "gravity": 9.81}, "drive": {"speed": 50.0, "duration": 0.1}})
    own, other = rsc.motions(scene, starts=3), rsc.motions(mirror, starts=3)
    assert other.speed == -own.speed and len(own.motions) == len(other.motions)
    np.testing.assert_array_equal(other.impulse, own.impulse * [-1.0, 1.0])
    assert own.smallest.direction + other.smallest.direction in (180.0, 540.0)


def test_the_pump_backwards_whirls_with_a_positive_frequency():
    scene = rsc.Scene.from_dict({**PUMP, "drive": {"speed": -50.0, "duration": 0.5}, "start": {"whirl": "backward"}})
    (stable,) = [whirl for whirl in rsc.predict(scene, -50.0) if whirl.stable]
    assert stable.frequency == pytest.approx(67.93, abs=0.01) and "sliding" not in stable.violated
    state = initial_state(scene, assemble(scene))
    assert (state.rotor_velocity[0] / state.rotor[0]).imag == pytest.approx(TWO_PI * stable.frequency)


def test_a_report_of_a_rotor_that_turns_backwards_is_that_of_its_mirror_image(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    forward = rsc.Scene.from_dict({**PUMP, "start": {"whirl": "backward"}})
    backwards = replace(forward.mirrored(), source="pump.toml")
    wanted, found = rsc.check(forward), rsc.check(backwards)
    assert found.agreement == wanted.agreement and found.result.scene.drive.speed == (50.0, 50.0)
    assert "turns backward: shown in the mirror image" in found.result.scene.title
    np.testing.assert_array_equal(found.result.rotor, wanted.result.rotor)
    for refused in (survey, force_ratios, rsc.sensitivity):
        with pytest.raises(rsc.SceneError, match=r"speed = -50\.0: must be at least 0 Hz"):
            refused(backwards)
    with pytest.raises(rsc.SceneError, match=r"speed = -50\.0: must be at least 0 Hz"):
        report(rsc.simulate(backwards))
    with pytest.raises(rsc.SceneError, match="must be of one sign, or 0"):
        rsc.check(forward.with_values({"drive.speed": [-50.0, 50.0]}))
    (tmp_path / "pump.toml").write_text(backwards.to_toml())
    (tmp_path / "forward.toml").write_text(forward.to_toml())
    told = []
    for arguments in (["forward.toml", "--speed", "50"], ["pump.toml", "--speed", "-50"], ["forward.toml"], ["pump.toml"]):
        assert main(["predict", *arguments]) == 0
        told.append(capsys.readouterr())
    assert told[0].out == told[1].out and told[2].out == told[3].out
    assert told[1].err == told[3].err and "turns backward" in told[1].err and not told[0].err


def test_the_smallest_impulse_and_a_sweep_of_a_rotor_that_turns_backwards():
    scene, mirror = pair({**PUMP, "drive": {"speed": 45.0, "duration": 0.3}})
    impacts, turned = (rsc.smallest_impulse(one, directions=3, largest=3.0) for one in (scene, mirror))
    assert turned.speed == -45.0 and turned.direction.tolist() == [180.0, 60.0, 300.0]
    np.testing.assert_array_equal(turned.impulse, impacts.impulse)
    np.testing.assert_array_equal(turned.frequency, -impacts.frequency)
