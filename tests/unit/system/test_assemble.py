"""Matrices of each model against matrices written by hand."""

import dataclasses

import numpy as np
import pytest

from rsc.errors import SceneError
from rsc.scene.scene import Scene
from rsc.system.assemble import assemble, modal_damping

REST = {
    "contact": {"gap": 1e-3, "friction": 0.2, "stiffness": 1e6, "damping": 7.0},
    "drive": {"speed": [10.0, 40.0], "duration": 3.0},
}
LAVAL_STATOR = {"model": "laval", "mass": 0.5, "stiffness": 2e4, "damping": 3.0}


def system(rotor, stator=None, **contact):
    content = {"rotor": rotor, "stator": stator or LAVAL_STATOR, **REST}
    return assemble(Scene.from_dict({**content, "contact": {**REST["contact"], **contact}}))


def test_laval():
    rotor = {"model": "laval", "mass": 2.0, "frequency": 5.0, "damping_ratio": 0.1, "eccentricity": [1e-4, 90.0]}
    made = system({**rotor, "gravity": 9.81})
    omega = 2 * np.pi * 5.0
    assert made.rotor.mass == np.array([[2.0]])
    np.testing.assert_allclose(made.rotor.stiffness, [[2.0 * omega**2]], rtol=1e-15)
    np.testing.assert_allclose(made.rotor.damping, [[2 * 0.1 * 2.0 * omega]], rtol=1e-15)
    assert made.rotor.gyroscopic == np.zeros((1, 1))
    assert made.rotor.unbalance == made.rotor.unbalance_euler == np.array([2.0 * 1e-4j])
    assert made.rotor.load == np.array([-9.81j * 2.0])
    assert (made.stator.mass, made.stator.damping, made.stator.stiffness) == (0.5, 3.0, 2e4)
    assert made.rotor.contact == made.stator.contact == np.array([1.0])


def test_constants_and_schedule_in_radians():
    made = system({"model": "laval", "mass": 1.0, "stiffness": 1e4}, diameter=0.02, ring_eccentricity=[1e-5, 180.0])
    assert made.contact.gap == 1e-3
    assert (made.law.friction, made.law.stiffness, made.law.damping) == (0.2, 1e6, 7.0)
    assert made.contact.ring == -1e-5
    assert made.law.diameter == 0.02
    assert made.law.slip_velocity == pytest.approx(1e-3 * 2 * np.pi * 40.0 * 0.01, rel=1e-15)
    np.testing.assert_array_equal(made.schedule_time, [0.0, 3.0])
    np.testing.assert_allclose(made.schedule_speed, [2 * np.pi * 10.0, 2 * np.pi * 40.0], rtol=1e-15)
    assert made.speed_at(1.0) == pytest.approx(2 * np.pi * 20.0)


def test_disk_moment_of_a_tilted_disk():
    rotor = {
        "model": "disk",
        "mass": 3.0,
        "diametral_inertia": 0.02,
        "polar_inertia": 0.03,
        "stiffness": [[5e4, -600.0], [-600.0, 40.0]],
        "damping": [[2.0, 0.1], [0.1, 0.5]],
        "eccentricity": 1e-4,
        "angular_eccentricity": [1e-3, 270.0],
        "gravity": 10.0,
    }
    made = system(rotor)
    np.testing.assert_array_equal(made.rotor.mass, [[3.0, 0.0], [0.0, 0.02]])
    np.testing.assert_array_equal(made.rotor.gyroscopic, [[0.0, 0.0], [0.0, 0.03]])
    np.testing.assert_array_equal(made.rotor.stiffness, rotor["stiffness"])
    np.testing.assert_array_equal(made.rotor.damping, rotor["damping"])
    # physics.md section 2: (Theta_a - Theta_p) phi'^2 - i Theta_a phi'' on the tilt row
    np.testing.assert_allclose(made.rotor.unbalance, [3e-4, -1j * (0.02 - 0.03) * 1e-3], rtol=1e-15)
    np.testing.assert_allclose(made.rotor.unbalance_euler, [3e-4, -1j * 0.02 * 1e-3], rtol=1e-15)
    np.testing.assert_array_equal(made.rotor.load, [-30j, 0.0])


def test_chain_between_walls():
    rotor = {
        "model": "chain",
        "masses": [1.0, 2.0, 3.0],
        "stiffnesses": [10.0, 20.0, 30.0, 0.0],
        "dampings": [1.0, 2.0, 3.0, 4.0],
        "eccentricity": [1e-5, [2e-5, 90.0], 0.0],
        "load": [[1.0, 2.0], [0.0, 0.0], [0.0, -3.0]],
    }
    stator = {"model": "chain", "masses": [0.5, 0.25], "stiffnesses": [5.0, 6.0, 7.0], "rayleigh": [0.5, 0.25]}
    made = system(rotor, stator, rotor_coordinate=2, stator_coordinate=1)
    np.testing.assert_array_equal(made.rotor.mass, np.diag([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(made.rotor.stiffness, [[30, -20, 0], [-20, 50, -30], [0, -30, 30]])
    np.testing.assert_array_equal(made.rotor.damping, [[3, -2, 0], [-2, 5, -3], [0, -3, 7]])
    np.testing.assert_array_equal(made.rotor.unbalance, [1e-5, 4e-5j, 0.0])
    np.testing.assert_array_equal(made.rotor.load, [1 + 2j, 0, -3j])
    np.testing.assert_array_equal(made.stator.stiffness, [[11, -6], [-6, 13]])
    np.testing.assert_array_equal(made.stator.damping, 0.5 * np.diag([0.5, 0.25]) + 0.25 * made.stator.stiffness)
    np.testing.assert_array_equal(made.rotor.contact, [0, 0, 1])
    np.testing.assert_array_equal(made.stator.contact, [0, 1])


def test_one_eccentricity_stands_for_all_masses_of_a_chain():
    made = system({"model": "chain", "masses": [1.0, 2.0], "stiffnesses": [1e4, 1e4, 1e4], "eccentricity": "0.1 mm"})
    np.testing.assert_array_equal(made.rotor.unbalance, [1e-4, 2e-4])


def test_matrices_with_gyroscopics():
    mass = [[2.0, 0.1], [0.1, 0.3]]
    rotor = {
        "model": "matrices",
        "mass": mass,
        "stiffness": [[1e4, -50.0], [-50.0, 90.0]],
        "damping": [[1.0, 0.0], [0.0, 2.0]],
        "gyroscopic": [[0.2, 0.01], [0.01, 0.5]],
        "tilt_coordinates": [1],
        "eccentricity": [1e-4, [1e-3, 90.0]],
        "gravity": 10.0,
    }
    made = system(rotor)
    ecc = np.array([1e-4, 1e-3j])
    np.testing.assert_array_equal(made.rotor.mass, mass)
    np.testing.assert_array_equal(made.rotor.gyroscopic, rotor["gyroscopic"])
    inclined = np.array([0.0, ecc[1]])  # only the axis of a disk feels the polar inertia
    np.testing.assert_allclose(made.rotor.unbalance, np.array(mass) @ ecc - np.array(rotor["gyroscopic"]) @ inclined, rtol=1e-15)
    np.testing.assert_allclose(made.rotor.unbalance_euler, np.array(mass) @ ecc, rtol=1e-15)
    np.testing.assert_allclose(made.rotor.load, [-20j, -1j], rtol=1e-15)


def test_weight_of_a_beam_element_is_that_of_its_consistent_mass():
    # a uniform load w on length L: w L/2 and the moments +- w L^2/12 at its ends
    weight, length = 30.0, 0.4
    L = length
    rows = [[156, 22 * L, 54, -13 * L], [22 * L, 4 * L**2, 13 * L, -3 * L**2]]
    rows += [[54, 13 * L, 156, -22 * L], [-13 * L, -3 * L**2, -22 * L, 4 * L**2]]
    mass = (weight / 10.0 / 420.0 * np.array(rows)).tolist()
    rotor = {"model": "matrices", "mass": mass, "stiffness": np.eye(4).tolist(), "damping_ratio": 0.01}
    made = system({**rotor, "tilt_coordinates": [1, 3], "gravity": 10.0})
    np.testing.assert_allclose(made.rotor.load, [-15j, -1j, -15j, 1j], rtol=1e-12)


def test_rigid_stator_has_no_coordinates():
    made = system({"model": "laval", "mass": 1.0, "stiffness": 1e4}, {"model": "rigid"})
    assert made.stator.mass.shape == made.stator.damping.shape == made.stator.stiffness.shape == (0, 0)
    assert made.stator.contact.shape == (0,)
    assert made.n_stator == 0


def test_contact_damping_on_the_reduced_mass():
    rotor = {"model": "laval", "mass": 1.0, "stiffness": 1e4}
    content = {"rotor": rotor, "stator": LAVAL_STATOR, **REST}
    content["contact"] = {"gap": 1e-3, "friction": 0.2, "stiffness": 1e6, "damping_ratio": 0.05}
    made = assemble(Scene.from_dict(content))
    assert made.law.damping == pytest.approx(2 * 0.05 * np.sqrt(1e6 * (1.0 * 0.5 / 1.5)), rel=1e-15)
    rigid = assemble(Scene.from_dict({**content, "stator": {"model": "rigid"}}))
    assert rigid.law.damping == pytest.approx(2 * 0.05 * np.sqrt(1e6), rel=1e-15)


def test_modal_damping_gives_the_same_ratio_in_every_mode():
    rng = np.random.default_rng(3)
    root, spring = rng.normal(size=(2, 5, 5))
    mass, stiffness = root @ root.T + np.eye(5), 1e4 * (spring @ spring.T + np.eye(5))
    damping = modal_damping(mass, stiffness, 0.07)
    np.testing.assert_array_equal(damping, damping.T)
    first_order = np.block(
        [
            [np.zeros((5, 5)), np.eye(5)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
        ]
    )
    eigenvalues = np.linalg.eigvals(first_order)
    np.testing.assert_allclose(-eigenvalues.real / np.abs(eigenvalues), 0.07, rtol=1e-9)


def test_free_body_modes_stay_undamped():
    mass, stiffness = np.eye(2), np.array([[1.0, -1.0], [-1.0, 1.0]])
    damping = modal_damping(mass, stiffness, 0.1)
    np.testing.assert_allclose(damping @ [1.0, 1.0], 0.0, atol=1e-8)
    np.testing.assert_allclose(damping @ [1.0, -1.0], 2 * 0.1 * np.sqrt(2.0) * np.array([1.0, -1.0]), rtol=1e-8)


@pytest.mark.parametrize("stator", [LAVAL_STATOR, {"model": "rigid"}])
def test_arrays_are_read_only_contiguous_and_of_one_type(stator):
    rotor = {"model": "chain", "masses": [1.0, 2.0], "stiffnesses": [1e4, 1e4, 1e4], "damping_ratio": 0.1}
    made = system(rotor, stator)
    for part in (made, *made.bodies):
        for item in dataclasses.fields(part):
            value = getattr(part, item.name)
            if isinstance(value, np.ndarray) and value.size:
                kind = complex if item.name in ("unbalance", "unbalance_euler", "load") else float
                assert value.dtype == kind, item.name
                assert value.flags.c_contiguous, item.name
                assert not value.flags.writeable, item.name
    for body in made.bodies:
        for name in ("mass", "damping", "stiffness", "gyroscopic"):
            np.testing.assert_array_equal(getattr(body, name), getattr(body, name).T)


def test_supports_act_as_their_four_coefficients_in_x_and_y():
    """-(k_xx x + k_xy y) along y-axis 1, -(k_yx x + k_yy y) along the other, as mean, skew and anisotropic parts."""
    stiffness, damping = [3e5, 2e4, -5e4, 1e5], [40.0, 3.0, -7.0, 10.0]
    content = {
        "rotor": {"model": "chain", "masses": [1.0, 2.0], "stiffnesses": [1e5, 1e5, 1e5], "supports": [[1, stiffness, damping]]},
        "stator": {"model": "laval", "mass": 1.0, "frequency": 50.0, "supports": [[0, [2e3, 0, 0, 1e3]], [0, [1e3, 0, 0, 0]]]},
        "contact": {"gap": 1e-3, "friction": 0.1, "stiffness": 1e6},
        "drive": {"speed": 20.0, "duration": 1.0},
    }
    scene = Scene.from_dict(content)
    system, bare = assemble(scene), assemble(scene.with_values({"rotor.supports": [], "stator.supports": []}))
    assert Scene.from_toml(scene.to_toml()) == scene
    for coefficients, kind in ((stiffness, "stiffness"), (damping, "damping")):
        mean = getattr(system.rotor, kind) - getattr(bare.rotor, kind)
        skew, anisotropic = getattr(system.rotor, f"skew_{kind}"), getattr(system.rotor, f"anisotropic_{kind}")
        for u in (1.0, 1j, 0.3 - 0.8j):
            xx, xy, yx, yy = coefficients
            wanted = (xx * u.real + xy * u.imag) + 1j * (yx * u.real + yy * u.imag)
            force = mean[1, 1] * u + 1j * skew[1, 1] * u + anisotropic[1, 1] * np.conj(u)
            assert force == pytest.approx(wanted, rel=1e-12)
        assert not (mean[0].any() or skew[0].any() or anisotropic[0].any())
    assert system.stator.anisotropic_stiffness[0, 0] == 1000.0
    assert system.stator.stiffness[0, 0] - bare.stator.stiffness[0, 0] == pytest.approx(2e3)
    assert system.stator.skew_stiffness is None is system.stator.anisotropic_damping
    assert bare.isotropic and not bare.skew and not system.isotropic and system.skew
    negative = dataclasses.replace(bare, rotor=dataclasses.replace(bare.rotor, damping=bare.rotor.damping - 1e3 * np.eye(2)))
    assert system.driven and negative.driven and not bare.driven


@pytest.mark.parametrize(
    "supports",
    [5, [[0]], [[2, [1.0] * 4]], [[0, [1.0] * 3]], [[0, ["1 N"] * 4]], [[0.5, [1.0] * 4]], [[0, [1.0] * 4, [1.0] * 4, 1]]],
)
def test_supports_that_cannot_be_are_refused(supports):
    content = {
        "rotor": {"model": "laval", "mass": 1.0, "frequency": 30.0, "supports": supports},
        "stator": {"model": "rigid"},
        "contact": {"gap": 1e-3, "friction": 0.1, "stiffness": 1e6},
        "drive": {"speed": 20.0, "duration": 1.0},
    }
    with pytest.raises(SceneError, match=r"rotor\.supports"):
        Scene.from_dict(content)


@pytest.mark.parametrize("stiffness", [[-4e4, 0, 0, -4e4], [1e4, 0, 0, -4e4], [0, 4e4, 4e4, 0]])
def test_supports_that_push_the_body_away_are_refused(stiffness):
    """A rotor of 35.5 kN/m with less than nothing left in some direction, and a stator that may not even be free."""
    body = {"model": "laval", "mass": 1.0, "frequency": 30.0}
    content = {
        "rotor": {**body, "supports": [[0, stiffness]]},
        "stator": {"model": "rigid"},
        "contact": {"gap": 1e-3, "friction": 0.1, "stiffness": 1e6},
        "drive": {"speed": 20.0, "duration": 1.0},
    }
    with pytest.raises(SceneError, match=r"rotor\.supports = .* stays positive or zero in every direction"):
        Scene.from_dict(content)
    with pytest.raises(SceneError, match=r"stator\.supports = .* stays positive in every direction"):
        Scene.from_dict({**content, "rotor": body, "stator": content["rotor"]})
    own = (2.0 * np.pi * 30.0) ** 2
    free, cross = [-own, 0, 0, 0], [0, -5e4, 5e4, 0]  # nothing left in y; cross-coupling takes no stiffness
    Scene.from_dict({**content, "rotor": {**body, "supports": [[0, free], [0, cross]]}})
    with pytest.raises(SceneError, match=r"stator\.supports"):
        Scene.from_dict({**content, "rotor": body, "stator": {**body, "supports": [[0, free]]}})


def test_an_eccentricity_of_a_gyroscopic_coordinate_asks_whether_it_is_a_tilt():
    """A gyroscopic coordinate: M eps as a displacement, (M - G) eps as a tilt; the run-up term is M eps in both."""
    rotor = {"model": "matrices", "mass": [[1.0, 0.0], [0.0, 2.0]], "stiffness": [[1.0, 0.0], [0.0, 1.0]], "damping_ratio": 0.01,
             "gyroscopic": [[0.0, 0.0], [0.0, 0.4]], "eccentricity": [0.0, 0.01]}  # fmt: skip
    told = r"rotor\.tilt_coordinates = \(missing\): must be given \(is coordinate 1, .* a tilt\? \[1\] if"
    with pytest.raises(SceneError, match=told):
        system(rotor)
    system({**rotor, "eccentricity": [0.01, 0.0]})  # it does not matter
    for tilts, unbalance in (([], 0.02), ([1], 0.016)):
        content = {"rotor": {**rotor, "tilt_coordinates": tilts}, "stator": LAVAL_STATOR, **REST}
        scene = Scene.from_dict(content)
        made = assemble(Scene.from_toml(scene.to_toml()))
        assert made.rotor.unbalance[1] == pytest.approx(unbalance) and made.rotor.unbalance_euler[1] == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("speed", "sense"), [([10.0, 40.0], 1.0), ([-10.0, -40.0], -1.0), ([0.0, -5.0], -1.0), ([0.0, 5.0], 1.0), (0.0, 1.0)]
)
def test_a_rotor_first_turns_the_way_of_its_first_speed_that_is_not_zero(speed, sense):
    laval = {"model": "laval", "mass": 1.0, "stiffness": 1e4}
    content = {"rotor": laval, "stator": LAVAL_STATOR, **REST, "drive": {"speed": speed, "duration": 3.0}}
    assert assemble(Scene.from_dict(content)).sense == sense
