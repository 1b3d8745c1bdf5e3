"""Contact between two places of one body: a rotor in its casing, both in the scene's one body, and no stator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rsc
from fe_bodies import rotor as fe_rotor
from rsc.machine.imports.build import rotor_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.imports.store import save_model
from rsc.system.assemble import assemble

TWO_PI = 2.0 * np.pi
CONTACT = {"gap": 1e-3, "friction": 0.2, "stiffness": 3.5e6, "diameter": 0.04, "slip_velocity": 0.02}
DRIVE = {"speed": 35.0, "duration": 0.4}
START = {"rotor": [0.5e-3, 0.9e-3], "rotor_velocity": [0.1, 0.0]}
W = TWO_PI * 30.0, TWO_PI * 150.0
MASS = np.diag([1.0, 0.25])
STIFFNESS, DAMPING = np.diag([W[0] ** 2, 0.25 * W[1] ** 2]), np.diag([2 * 0.02 * W[0], 0.25 * 2 * 0.1 * W[1]])


def two_bodies(**contact):
    """Laval rotor in a stator of one mass."""
    return rsc.Scene.from_dict({
        "rotor": {"model": "laval", "mass": 1.0, "frequency": 30.0, "damping_ratio": 0.02, "eccentricity": [5e-5, 0.0]},
        "stator": {"model": "laval", "mass": 0.25, "frequency": 150.0, "damping_ratio": 0.1},
        "contact": CONTACT | contact, "drive": DRIVE,
        "start": {"rotor": [START["rotor"]], "rotor_velocity": [START["rotor_velocity"]]},
        "solver": {"method": "taylor8", "rtol": 1e-10},
    })  # fmt: skip


def one_body(mass=MASS, stiffness=STIFFNESS, damping=DAMPING, places=(0, 1), **contact):
    """The same as one body, or another."""
    rest = [[0.0, 0.0]] * (len(mass) - 1)
    return rsc.Scene.from_dict({
        "rotor": {"model": "matrices", "mass": np.array(mass).tolist(), "stiffness": np.array(stiffness).tolist(),
                  "damping": np.array(damping).tolist(), "eccentricity": [[5e-5, 0.0]] + [[0.0, 0.0]] * (len(mass) - 1)},
        "contact": CONTACT | contact | {"rotor_coordinate": list(places)}, "drive": DRIVE,
        "start": {"rotor": [START["rotor"], *rest], "rotor_velocity": [START["rotor_velocity"], *rest]},
        "solver": {"method": "taylor8", "rtol": 1e-10},
    })  # fmt: skip


def on_a_foundation(grounded=False):
    """The same on a foundation of 20 kg, 20 Hz (or none) on which bearings and casing stand; matrices of all three."""
    mass = np.diag([1.0, 0.25, 20.0])
    stiffness, damping = np.zeros((3, 3)), np.zeros((3, 3))
    for i in range(2):
        link = np.eye(3)[i] - np.eye(3)[2] * (not grounded)
        stiffness += STIFFNESS[i, i] * np.outer(link, link)
        damping += DAMPING[i, i] * np.outer(link, link)
    stiffness[2, 2] += 20.0 * (TWO_PI * 20.0) ** 2
    damping[2, 2] += 20.0 * 2 * 0.05 * TWO_PI * 20.0
    return mass, stiffness, damping


def test_two_uncoupled_masses_of_one_body_are_rotor_and_stator():
    """Runs, whirls and energies of a body that both stand in beside those of a rotor and a stator."""
    one, two = one_body(), two_bodies()
    assert one.stator.model == "rigid" and one.contact.rotor_coordinate == (0, 1)
    assert assemble(one).contact.rotor.tolist() == [1.0, -1.0]
    own, other = rsc.simulate(one), rsc.simulate(two)
    assert own.contact_onsets == other.contact_onsets > 1
    assert own.rotor[:, 0] == pytest.approx(other.rotor[:, 0], abs=1e-6 * 1e-3)
    assert own.rotor[:, 1] == pytest.approx(other.stator[:, 0], abs=1e-6 * 1e-3)
    assert own.contact_rotor() == pytest.approx(own.rotor[:, 0] - own.rotor[:, 1])
    assert own.samples(5, 9).contact_rotor() == pytest.approx(own.contact_rotor()[5:9])
    assert not own.contact_stator().any()
    ledger, separate = own.ledger, other.ledger
    assert ledger.rotor_damping == pytest.approx(separate.rotor_damping + separate.stator_damping, rel=1e-5)
    assert ledger.friction_in == pytest.approx(separate.friction_in, rel=1e-5)
    for whirl, known in zip(rsc.predict(one, 35.0), rsc.predict(two, 35.0), strict=True):
        assert (whirl.frequency, whirl.normal_force) == pytest.approx((known.frequency, known.normal_force), rel=1e-9)
        assert whirl.stable == known.stable
        assert whirl.rotor_amplitude == pytest.approx(abs(known.normal_force / CONTACT["stiffness"]) + CONTACT["gap"], rel=1e-9)


def test_of_several_contacts_one_may_be_between_two_places_of_the_rotor():
    content = one_body().to_dict()
    content["stator"] = {"model": "laval", "mass": 1.0, "frequency": 10.0}
    ring = content["contact"] | {"name": "ring", "rotor_coordinate": 1}
    content["contact"] = [content["contact"] | {"name": "own"}, ring]
    own, other = assemble(rsc.Scene.from_dict(content)).contacts
    assert own.rotor.tolist() == [1.0, -1.0] and own.stator.tolist() == [0.0]
    assert other.rotor.tolist() == [0.0, 1.0] and other.stator.tolist() == [1.0]


def force(d, d_dot, Omega):
    """Contact force on the first place as complex number: spring, Coulomb friction within the slip velocity; no damper."""
    distance = abs(d)
    normal = max(0.0, CONTACT["stiffness"] * (distance - CONTACT["gap"]))
    if not normal:
        return 0.0
    slip = Omega * CONTACT["diameter"] / 2.0 + np.imag(d_dot * np.conj(d)) / distance
    share = np.clip(slip / CONTACT["slip_velocity"], -1.0, 1.0)
    return -(1.0 + 1j * CONTACT["friction"] * share) * normal * d / distance


def test_the_run_on_a_foundation_is_that_of_an_integration_in_y_and_z():
    mass, stiffness, damping = on_a_foundation()
    scene = one_body(mass, stiffness, damping)
    Omega, inverse = TWO_PI * 35.0, np.linalg.inv(mass)
    start = [[0.8, 0.0], [0.0, 0.0], [0.0, 0.0]]
    result = rsc.simulate(scene.with_values({"drive.duration": 0.15, "start.rotor_velocity": start}))

    def f(t, state):
        r, v = state[:3] + 1j * state[3:6], state[6:9] + 1j * state[9:]
        F = force(r[0] - r[1], v[0] - v[1], Omega) * np.array([1.0, -1.0, 0.0])
        a = inverse @ (F + 5e-5 * Omega**2 * np.exp(1j * Omega * t) * np.eye(3)[0] - damping @ v - stiffness @ r)
        return np.concatenate([v.real, v.imag, a.real, a.imag])

    start = np.zeros(12)
    start[[0, 3, 6]] = *START["rotor"], 0.8
    exact = solve_ivp(f, (0.0, 0.15), start, "DOP853", t_eval=result.time, rtol=1e-10, atol=1e-14, max_step=1e-4).y
    assert result.summary.contact_time > 0.002 and result.contact_onsets > 1
    assert abs(result.rotor.T - (exact[:3] + 1j * exact[3:6])).max() < 1e-4 * 1e-3
    assert abs(result.ledger.residual) < 1e-6 * result.ledger.turnover


def whirling(scene):
    """Without unbalance, sliding forward all the time, from a predicted whirl."""
    content = scene.to_dict() | {"start": {"whirl": "backward"}}
    content["contact"] = {name: value for name, value in content["contact"].items() if name not in ("diameter", "slip_velocity")}
    content["rotor"] = {name: value for name, value in content["rotor"].items() if name not in ("eccentricity", "unbalance")}
    if scene.rotor.model == "reduced":
        content["rotor"]["unbalance"] = [[0.0, 0.0]] * scene.rotor.n_coordinates
    return rsc.Scene.from_dict(content)


def test_a_predicted_whirl_on_a_foundation_is_simulated_and_is_another_than_with_grounded_bearings():
    """Frequency and force; a foundation that does not take part gives others by percents."""
    mass, stiffness, damping = on_a_foundation()
    scene = whirling(one_body(mass, stiffness, damping))
    result = rsc.simulate(scene)
    d = result.contact_rotor()
    turned = np.unwrap(np.angle(d))
    frequency = (turned[-1] - turned[0]) / (TWO_PI * result.time[-1])
    whirl = min(rsc.predict(scene, 35.0), key=lambda one: abs(one.frequency - frequency))
    assert whirl.stable and frequency == pytest.approx(whirl.frequency, abs=1e-5)
    assert result.normal_force[1:].mean() == pytest.approx(whirl.normal_force, rel=1e-5)
    assert abs(d).max() == pytest.approx(whirl.rotor_amplitude, rel=1e-6)
    grounded = whirling(one_body(*on_a_foundation(grounded=True)))
    nearest = min(rsc.predict(grounded, 35.0), key=lambda one: abs(one.frequency - frequency))
    assert abs(nearest.frequency - whirl.frequency) > 0.5


def test_results_and_scenes_keep_the_two_places(tmp_path):
    path = tmp_path / "run.h5"
    scene = one_body().with_values({"drive.duration": 0.05})
    result = rsc.simulate(scene, path=path)
    loaded = rsc.load(path)
    assert loaded.scene == scene == rsc.Scene.from_toml(scene.to_toml())
    assert loaded.contact_rotor() == pytest.approx(result.rotor[:, 0] - result.rotor[:, 1])
    assert scene.mirrored().contact.rotor_coordinate == (0, 1)


@pytest.mark.parametrize(
    ("places", "more", "problem"),
    [
        ([0, 0], {}, "two coordinates"),
        ([0, 2], {}, "a whole number from 0 to 1"),
        ([0, -1], {}, "from 0"),
        ([0, 1.5], {}, "whole number"),
        ([0], {}, "two for contact with each other"),
        ([0, 1, 1], {}, "two for contact with each other"),
        ([0, 1], {"stator": {"model": "laval", "mass": 1.0, "frequency": 10.0}}, "leave .stator. out"),
        (0, {}, "given as a table .stator."),
    ],
)
def test_places_that_cannot_be_are_refused(places, more, problem):
    content = one_body().to_dict() | more
    del content["start"]
    if not more:
        del content["stator"]
    content["contact"]["rotor_coordinate"] = places
    with pytest.raises(rsc.SceneError, match=problem) as told:
        rsc.Scene.from_dict(content)
    assert "\n" not in str(told.value)


MACHINE = """
[rotor]
model = "machine"
file = "rotor.npz"
contact = {contact}
unbalance = [[2, 5e-5]]
{stator}
[contact]
gap = 1e-3
friction = 0.2
stiffness = 3.5e6
[drive]
speed = 35.0
duration = 0.1
"""


@pytest.fixture
def machine(tmp_path):
    """A shaft of four elements and a casing, nodes 10 and 11, on one foundation: node 12 below the bearings."""
    matrices, nodes, directions = fe_rotor(n_elements=4, bearing=((0.0, 0.0), (0.0, 0.0)))
    size = len(nodes)
    whole = {name: np.zeros((size + 9, size + 9)) for name in matrices}
    for name, matrix in matrices.items():
        whole[name][:size, :size] = matrix
    x = {node: 6 * node for node in (0, 4)} | {10: size, 11: size + 3, 12: size + 6}
    for k in range(3):
        for node, m in ((10, 3.0), (11, 2.0), (12, 80.0)):
            whole["mass"][x[node] + k, x[node] + k] = m
        ground = 80.0 * (TWO_PI * 20.0) ** 2
        for a, b, stiff in ((0, 12, 1e7), (4, 12, 1e7), (10, 12, 4e6), (10, 11, 6e6), (12, None, ground)):
            link = np.zeros(size + 9)
            link[x[a] + k] = 1.0
            if b is not None:
                link[x[b] + k] = -1.0
            whole["stiffness"] += stiff * np.outer(link, link)
            whole["damping"] += 2e-4 * stiff * np.outer(link, link)
    rows = np.concatenate([nodes, np.repeat([10, 11, 12], 3)])
    table = Coordinates(rows, np.array([*directions, *["x", "y", "z"] * 3]), {}, {})
    table.direction[np.isin(table.direction, ("z", "rz"))] = "other"
    model = rotor_model(whole, table, "a pump", units="m")
    save_model(model, tmp_path / "rotor.npz")

    def scene(contact, stator=""):
        (tmp_path / "scene.toml").write_text(MACHINE.format(contact=contact, stator=stator))
        return rsc.load_scene(tmp_path / "scene.toml")

    return model, scene


@pytest.mark.nightly  # half a minute for its kernel
def test_two_nodes_of_a_machine_touch_each_other(machine):
    """The receptance is that of the difference of both nodes, and its whirls are those of the full matrices."""
    model, scene = machine
    read = scene("{node = 2, against = 11}")
    body, row = assemble(read).rotor, model.row_at(2) - model.row_at(11)
    assert read.stator.model == "rigid" and body.n_coordinates < model.n
    for Psi in TWO_PI * np.array([-46.0, -20.0, 33.0]):
        A = model.stiffness - Psi**2 * model.mass + 1j * Psi * model.damping + Psi * TWO_PI * 35.0 * model.gyroscopic
        full = row @ np.linalg.solve(A, row)
        small = body.contact @ np.linalg.solve(body.dynamic_stiffness(Psi, TWO_PI * 35.0), body.contact)
        assert small == pytest.approx(full, rel=1e-4)
    assert rsc.Scene.from_toml(read.to_toml()) == read
    result = rsc.simulate(whirling(read))
    turned = np.unwrap(np.angle(result.contact_rotor()))
    frequency = (turned[-1] - turned[0]) / result.time[-1]
    A = model.stiffness - frequency**2 * model.mass + 1j * frequency * model.damping
    A = A + frequency * TWO_PI * 35.0 * model.gyroscopic
    H = row @ np.linalg.solve(A, row)
    assert frequency < 0.0 and abs(((1.0 + 0.2j) * H).imag) < 1e-4 * abs(H)


@pytest.mark.parametrize(
    ("contact", "stator", "problem"),
    [
        ("{node = 2, against = 2}", "", "cannot touch itself"),
        ("{node = 2, against = 99}", "", "no node 99"),
        ("{node = 2}", "", "node = ..., against = ..."),
        ("{node = 2, to = 11}", "", "node = ..., against = ..."),
        ("{node = 2, against = {node = 1, against = 3}}", "", "contact.against"),
        ("{node = 2, against = 11}", "[stator]\nmodel = \"laval\"\nmass = 1.0\nfrequency = 10.0", "leave .stator. out"),
        ("2", "", "given as a table .stator."),
    ],
)
def test_nodes_that_cannot_touch_are_refused(machine, contact, stator, problem):
    with pytest.raises(rsc.SceneError, match=problem) as told:
        machine[1](contact, stator)
    assert "\n" not in str(told.value)
