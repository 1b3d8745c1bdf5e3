"""The least friction of a whirl against dense scans and closed forms."""

import numpy as np
import pytest

from rsc.analysis.follow.escape import ESCAPES
from rsc.analysis.follow.events import FOLD
from rsc.analysis.follow.least_friction import LIMIT, ROLLS, least_frictions, mu_min
from rsc.analysis.paper.receptance import receptance, receptance_rotor, receptance_stator
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.several.predict import predict
from rsc.scene.scene import Scene
from rsc.study.run.simulate import simulate
from rsc.system.assemble import assemble
from systems import TWO_PI, reference_scene


def whirl_min(scene, speed=None):
    """The least friction of whirls that slide or roll."""
    return least_frictions(scene, speed)[1]


@pytest.mark.parametrize("name", ["laval", "mdof_2x2", "gyroscopic_transition", "chain_10"])
def test_least_friction_is_that_of_a_dense_scan(name):
    scene = reference_scene(name)
    least = whirl_min(scene, 50.0)
    system, Psi = assemble(scene), -TWO_PI * np.linspace(1.0, 1000.0, 50_001)
    H, H_r = receptance(system, Psi, TWO_PI * 50.0), receptance_rotor(system, Psi, TWO_PI * 50.0)
    allowed = (H.real < 0.0) & (np.abs(H_r) >= np.abs(H)) & (H.imag > 0.0)
    scanned = (-H.imag / H.real)[allowed].min()
    # a scan cannot undercut the minimum
    assert scanned * (1.0 - 1e-4) < least.value <= scanned
    assert least.cause == FOLD


def test_no_damping_needs_no_friction_and_a_rigid_wall_neither():
    scene = reference_scene("laval")
    undamped = scene.with_values({"rotor.damping": 0.0, "stator.damping": 0.0})
    assert whirl_min(undamped).value == 0.0
    content = scene.to_dict()
    wall = type(scene).from_dict({**content, "stator": {"model": "rigid"}, "start": {"rest": True}})
    # the less friction, the faster the whirl, until the contact is pressed in by as much as the gap: m Psi^2 - k = k_C s/(2 s)
    system, least = assemble(wall), whirl_min(wall)
    m, b, k = (matrix[0, 0] for matrix in (system.rotor.mass, system.rotor.damping, system.rotor.stiffness))
    Psi = -np.sqrt((k + 0.5 * system.law.stiffness) / m)
    assert least.value == pytest.approx(-b * Psi / (m * Psi**2 - k), rel=1e-6) and least.cause == LIMIT
    assert least.frequency == pytest.approx(Psi / TWO_PI, rel=1e-6)


@pytest.mark.parametrize("diameter", [0.01, 0.1])
def test_least_friction_in_a_rigid_wall_is_that_of_rolling(diameter):
    content = reference_scene("laval").to_dict()
    contact = {**content["contact"], "diameter": diameter, "slip_velocity": 1e-3}
    change = {"stator": {"model": "rigid"}, "start": {"rest": True}, "contact": contact}
    scene = type(reference_scene("laval")).from_dict({**content, **change})
    least, system = mu_min(scene, 50.0), assemble(scene)
    assert least == whirl_min(scene, 50.0)
    # r = |d| e^{i psi}: m psi'' + b psi' + mu (m psi'^2 - k) = 0, F_N = (m psi'^2 - k) |d|, at psi' = -Omega d_R/(2 |d|)
    m, b, k = (matrix[0, 0] for matrix in (system.rotor.mass, system.rotor.damping, system.rotor.stiffness))
    distance = system.contact.gap
    for _ in range(200):
        rolling = -TWO_PI * 50.0 * diameter / (2.0 * distance)
        distance += 0.5 * (system.contact.gap + (m * rolling**2 - k) * distance / system.law.stiffness - distance)
    assert least.value == pytest.approx(-b * rolling / (m * rolling**2 - k), rel=1e-4)  # the slip of the friction law is 1 mm/s
    assert least.frequency == pytest.approx(rolling / TWO_PI, rel=1e-4) and least.cause == ROLLS
    # a light stator gives a fold long before
    with_stator = reference_scene("laval").with_values({"contact.diameter": diameter, "contact.slip_velocity": 1e-3})
    fold, least = whirl_min(reference_scene("laval"), 50.0), whirl_min(with_stator, 50.0)
    assert least == fold if diameter == 0.01 else least.value < fold.value and least.cause == ROLLS


# an overhung fan on a contact softer than its shaft: rolling lasts, where a rigid contact would have no whirl with |r_R| >= s
FAN = {
    "rotor": {
        "model": "disk", "mass": 180.0, "diametral_inertia": 18.0, "polar_inertia": 32.0, "damping_ratio": 0.02,
        "stiffness": [[37.6e6, -11.27e6], [-11.27e6, 4.509e6]],
    },
    "stator": {"model": "laval", "mass": 12.0, "frequency": 45.0, "damping_ratio": 0.05},
    "contact": {"gap": 2e-3, "friction": 0.3, "stiffness": 5e6, "damping_ratio": 0.05, "diameter": 0.8},
    "drive": {"speed": [5.0, 24.67], "duration": 40.0},
}  # fmt: skip


def lasting(scene, speed, friction):
    """Whether predictions at a friction show a backward whirl that may last, sliding or rolling."""
    tried = scene.with_values({"contact.friction": friction})
    whirls = [whirl for whirl in predict(tried, speed) if whirl.frequency < 0.0]
    slides = any(set(whirl.violated) <= {"asynchronous_force_dominates"} for whirl in whirls)
    return slides or bool(rolling_whirls(assemble(tried), TWO_PI * speed))


@pytest.mark.parametrize("speed", [1.0, 5.0, 10.0, 20.0, 24.67])
def test_the_least_friction_on_a_soft_contact_is_that_of_the_predictions(speed):
    scene = Scene.from_dict(FAN)
    least = whirl_min(scene, speed)
    assert 0.04 < least.value < 0.08 and least.cause == ROLLS
    assert lasting(scene, speed, 1.01 * least.value) and not lasting(scene, speed, 0.99 * least.value)


def test_no_friction_that_a_scene_may_have_gives_a_whirl():
    damped = reference_scene("laval").with_values({"rotor.damping_ratio": 1.5, "stator.damping_ratio": 1.5})
    least = whirl_min(damped, 50.0)
    assert least is None and not any(lasting(damped, 50.0, mu) for mu in (0.1, 1.0, 5.0))


def test_whirls_outside_the_band_of_a_reduced_machine_do_not_count(monkeypatch):
    scene = reference_scene("laval")
    whole = whirl_min(scene, 50.0)
    for low, cause in ((-500.0, FOLD), (0.99 * whole.frequency, LIMIT), (-40.0, LIMIT)):
        monkeypatch.setattr("rsc.analysis.follow.least_friction.band_of", lambda scene, low=low: (TWO_PI * low, TWO_PI * 250.0))
        least = whirl_min(scene, 50.0)
        assert least.cause == cause and least.frequency >= low * (1.0 + 1e-9)
        assert least.value > whole.value or cause == FOLD


@pytest.mark.parametrize("seed", range(4))
def test_in_a_rigid_wall_motions_run_away_from_where_friction_outweighs_damping(seed):
    """m r'' + b r' + (k + (1 + i mu) k_C) r = 0 has a real Psi = -sqrt((k + k_C)/m) with mu = b |Psi|/k_C."""
    dice = np.random.default_rng(seed)
    content = reference_scene("laval").to_dict()
    contact = content["contact"] | {"stiffness": float(10.0 ** dice.uniform(5.0, 8.0))}
    rotor = content["rotor"] | {"damping_ratio": float(dice.uniform(0.002, 0.05))}
    scene = Scene.from_dict(content | {"rotor": rotor, "contact": contact, "stator": {"model": "rigid"}, "start": {"rest": True}})
    least, system = mu_min(scene, 50.0), assemble(scene)
    m, b, k = (matrix[0, 0] for matrix in (system.rotor.mass, system.rotor.damping, system.rotor.stiffness))
    fastest = np.sqrt((k + system.law.stiffness) / m)
    assert least.cause == ESCAPES and least.frequency == pytest.approx(-fastest / TWO_PI, rel=1e-4)
    assert least.value == pytest.approx(b * fastest / system.law.stiffness, rel=1e-6)
    backward = mu_min(scene, -50.0)
    assert backward.value == pytest.approx(least.value) and backward.frequency == pytest.approx(-least.frequency)


# motions run away at frictions far below those of the whirls within a gap
ESCAPING = {
    "rotor": {"model": "laval", "mass": 7.7377, "frequency": 41.997, "damping_ratio": 0.016075, "eccentricity": 5.4913e-5},
    "stator": {"model": "laval", "mass": 3.2485, "frequency": 113.85, "damping_ratio": 0.15715},
    "contact": {"gap": 2.189e-4, "friction": 0.0994, "stiffness": 7.9018e6, "damping_ratio": 0.05},
    "drive": {"speed": 42.887, "duration": 1.0},
}  # fmt: skip


def pressed_run(scene, depth):
    """The run of a scene from a circle on the growing motion, so many gaps beyond the gap."""
    least = mu_min(scene)
    system, Psi = assemble(scene), TWO_PI * least.frequency
    # force that holds d = 1 on that circle, and what it does to both bodies
    force = -1.0 / complex(receptance(system, Psi, TWO_PI * scene.drive.speed[0]))
    r, s = (complex(part) * force for part in (
        receptance_rotor(system, Psi, TWO_PI * scene.drive.speed[0]), -receptance_stator(system, Psi)))  # fmt: skip
    parts = np.array([-r, -s]) * -depth * system.contact.gap
    values = {"start.rotor": [[parts[0].real, parts[0].imag]], "start.stator": [[parts[1].real, parts[1].imag]]}
    speeds = 1j * Psi * parts
    values |= {"start.rotor_velocity": [[speeds[0].real, speeds[0].imag]],
               "start.stator_velocity": [[speeds[1].real, speeds[1].imag]], "start.allow_penetration": True}  # fmt: skip
    return simulate(scene.with_values(values | {"drive.duration": 2.0}))


@pytest.mark.parametrize(("share", "grows"), [(1.1, True), (0.9, False)])
def test_a_simulated_motion_runs_away_above_that_friction_only(share, grows):
    scene = Scene.from_dict(ESCAPING)
    least = mu_min(scene)
    assert least.cause == ESCAPES and least.value < 0.0994 < whirl_min(scene).value
    whole = pressed_run(scene.with_values({"contact.friction": share * least.value}), 400.0)
    size = np.abs(whole.rotor)
    assert (size[-200:].max() > 2.0 * size[:200].max()) == grows and (size[-200:].max() < size[:200].max()) == (not grows)
