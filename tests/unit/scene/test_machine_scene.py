"""Scenes with bodies of finite-element models: read, reduced, kept in results, refused."""

from dataclasses import replace

import numpy as np
import pytest

import rsc
from fe_bodies import rotor
from rsc.machine.imports.build import rotor_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.imports.store import load_model, save_model
from rsc.machine.model.contact import Unbalance, amounts_of, total_mass
from rsc.scene.values import with_entries
from rsc.study.prediction.reductions import coefficient_remarks, reduction_remarks
from rsc.system.assemble import assemble

TWO_PI = 2.0 * np.pi
SCENE = """
[rotor]
model = "machine"
file = "rotor.npz"
{rotor}
[stator]
model = "laval"
mass = 2.0
frequency = 60.0
damping_ratio = 0.05
[contact]
gap = 1e-4
friction = 0.2
stiffness = 2e7
damping_ratio = 0.05
[drive]
speed = {speed}
duration = 0.2
{more}
"""


@pytest.fixture(scope="module")
def model():
    matrices, nodes, directions = rotor(n_elements=12)
    table = Coordinates(nodes, directions, {}, {i: i / 12 for i in range(13)})
    return rotor_model(matrices, table, "a shaft", units="m")


def written(folder, model, rotor_keys, speed="[10.0, 40.0]", more=""):
    save_model(model, folder / "rotor.npz")
    path = folder / "scene.toml"
    path.write_text(SCENE.format(rotor=rotor_keys, speed=speed, more=more))
    return path


PLAIN = 'contact = 6\nunbalance = [[6, "50 g*mm", 90.0]]'


def test_a_model_is_read_back_as_it_was_written(model, tmp_path):
    digest = save_model(model, tmp_path / "a.npz")
    again, other = load_model(tmp_path / "a.npz")
    assert digest == other and again.notes == model.notes and again.position == model.position
    for name in ("mass", "damping", "gyroscopic", "stiffness", "node"):
        assert np.array_equal(getattr(again, name), getattr(model, name))
    assert again.skew_stiffness is None and again.isotropic


def test_the_reduced_rotor_answers_at_the_contact_as_the_full_one(model, tmp_path):
    scene = rsc.load_scene(written(tmp_path, model, PLAIN))
    system, row = assemble(scene), model.row_at(6)
    assert scene.rotor.model == "reduced" and scene.rotor.coordinates_before == model.n == 26 > system.n_rotor
    for Psi, Omega in ((-TWO_PI * 70.0, TWO_PI * 20.0), (TWO_PI * 40.0, TWO_PI * 40.0)):
        stiff = [
            k - Psi**2 * m + 1j * Psi * b + Psi * Omega * g
            for m, b, g, k in (
                (model.mass, model.damping, model.gyroscopic, model.stiffness),
                (system.rotor.mass, system.rotor.damping, system.rotor.gyroscopic, system.rotor.stiffness),
            )
        ]
        full = row @ np.linalg.solve(stiff[0], row + 0j)
        assert system.rotor.contact @ np.linalg.solve(stiff[1], system.rotor.contact + 0j) == pytest.approx(full, rel=1e-4)
        forced = row @ np.linalg.solve(stiff[0], 50e-6 * 1j * row)  # 50 g mm, a quarter of a turn ahead
        assert system.rotor.contact @ np.linalg.solve(stiff[1], system.rotor.unbalance) == pytest.approx(forced, rel=1e-3)
    assert np.array_equal(system.rotor.unbalance, system.rotor.unbalance_euler)


def test_a_scene_of_a_result_needs_no_file(model, tmp_path):
    scene = rsc.load_scene(written(tmp_path, model, PLAIN + "\nobservers = [0, 3]"))
    again = rsc.Scene.from_toml(scene.to_toml())
    assert again == scene and again.reductions == () and len(scene.reductions) == 1
    assert again.with_values({"contact.gap": 2e-4}).contact.gap == 2e-4
    with pytest.raises(rsc.SceneError, match=r"drive.speed = .*: must be within 0 to 40 Hz, for which the rotor was reduced"):
        again.with_values({"drive.speed": [10.0, 41.0]})


def test_observed_nodes_can_be_recovered(model, tmp_path):
    scene = rsc.load_scene(written(tmp_path, model, PLAIN + "\nobservers = [3]", speed="[30.0, 30.0]"))
    result = rsc.simulate(scene)
    shape = np.linalg.solve(model.stiffness, model.row_at(6))
    static = scene.reductions[0].recover(np.linalg.solve(assemble(scene).rotor.stiffness, assemble(scene).rotor.contact))
    assert static == pytest.approx(shape, rel=1e-4)
    seen = result.rotor @ np.array(scene.rotor.observer_rows).T
    assert 0.3 < np.abs(seen).max() / np.abs(result.contact_rotor()).max() < 1.0


@pytest.mark.nightly
def test_the_simulation_of_the_reduced_rotor_is_that_of_the_full_one(model, tmp_path):
    """In and out of contact, within ten times the tolerance of the reduction."""
    scene = rsc.load_scene(written(tmp_path, model, PLAIN, speed="[40.0, 40.0]"))
    content = scene.to_dict() | {"rotor": {
        "model": "matrices", "mass": model.mass.tolist(), "damping": model.damping.tolist(),
        "stiffness": model.stiffness.tolist(), "gyroscopic": model.gyroscopic.tolist(),
        "tilt_coordinates": np.flatnonzero(model.kind == "tilt").tolist(),
        "eccentricity": [[float(abs(e)), float(np.degrees(np.angle(e)))] for e in _eccentricity(model)],
    }}  # fmt: skip
    content["contact"]["rotor_coordinate"] = int(np.flatnonzero(model.row_at(6))[0])
    del content["contact"]["damping_ratio"], content["start"]
    content["contact"]["damping"] = scene.contact.damping
    free = abs(rsc.simulate(scene).contact_rotor()).max()
    exact = {"solver.rtol": 1e-9, "contact.gap": 0.8 * free}
    reduced, full = (rsc.simulate(each.with_values(exact)) for each in (scene, rsc.Scene.from_dict(content)))
    assert (reduced.normal_force > 0.0).any() and reduced.contact_releases > 1
    difference = np.abs(reduced.contact_rotor() - full.contact_rotor())
    assert difference.max() < 1e-3 * free


def _eccentricity(model):
    """Eccentricities whose unbalance is 50 g mm at node 6, a quarter of a turn ahead."""
    return np.linalg.solve(model.mass - model.gyroscopic * (model.kind == "tilt"), 50e-6 * 1j * model.row_at(6))


def test_a_balance_grade_is_of_the_whole_rotor_at_the_highest_speed(model, tmp_path):
    scene = rsc.load_scene(written(tmp_path, model, 'contact = 6\nunbalance = [[6, "G 6.3"]]'))
    moving = (model.kind == "displacement").astype(float)
    amount = 6.3e-3 * (moving @ model.mass @ moving) / (TWO_PI * 40.0)
    row, system = model.row_at(6), assemble(scene)
    static = row @ np.linalg.solve(model.stiffness, amount * row)
    deflection = np.linalg.solve(system.rotor.stiffness, system.rotor.unbalance)
    assert system.rotor.contact @ deflection == pytest.approx(static, rel=1e-3)


def test_a_grade_in_two_planes_is_that_of_the_whole_rotor(model):
    """ISO 21940-11: the unbalance that the grade allows, shared so that its centre is the centre of mass."""
    placed = replace(model, position={node: 0.1 * node for node in range(13)})
    rigid = np.where(placed.kind == "tilt", 1.0, [placed.position[node] for node in placed.node.tolist()])
    whole = amounts_of(placed, [Unbalance(6, "G 2.5")], 40.0)[0]
    first, exact, second = amounts_of(placed, [Unbalance(1, "G 2.5"), Unbalance(4, 1e-6), Unbalance(8, "G 2.5")], 40.0)
    assert (first + second, exact) == (pytest.approx(whole, rel=1e-12), 1e-6)
    pushed = placed.mass @ (placed.kind == "displacement").astype(float)
    assert (0.1 * first + 0.8 * second) / whole == pytest.approx(pushed @ rigid / total_mass(placed), rel=1e-12)
    wrong = {
        "at most two planes": [Unbalance(node, "G 2.5") for node in (1, 4, 8)],
        "one grade": [Unbalance(1, "G 2.5"), Unbalance(8, "G 6.3")],
        "on both sides": [Unbalance(7, "G 2.5"), Unbalance(8, "G 2.5")],
    }
    for words, planes in wrong.items():
        with pytest.raises(ValueError, match=f"{words}.* kg m"):
            amounts_of(placed, planes, 40.0)
    with pytest.raises(ValueError, match="without node positions"):
        amounts_of(replace(model, position={}), [Unbalance(1, "G 2.5"), Unbalance(8, "G 2.5")], 40.0)


def test_the_unbalance_of_a_machine_turns_and_grows_as_a_whole(model, tmp_path):
    """As at the angle and of the amount in its file; a sweep varies both by their names."""
    heavy = 'contact = 6\nunbalance = [[4, "20 g*mm", {0}], [8, "{1} g*mm", {2}]]\n'
    scene = rsc.load_scene(written(tmp_path, model, heavy.format(0.0, 10.0, 50.0)))
    turned = rsc.load_scene(written(tmp_path, model, heavy.format(70.0, 10.0, 120.0)))
    u, wanted = np.array(scene.rotor.unbalance), np.array(turned.rotor.unbalance)
    lead = np.rad2deg(np.angle(wanted[0]))
    changed = scene.with_values({"rotor.unbalance.angle": lead, "rotor.unbalance.amount": 2.0 * abs(wanted[0])})
    assert np.array(changed.rotor.unbalance) == pytest.approx(2.0 * wanted, rel=1e-12)
    assert np.array(with_entries(scene, {"rotor.unbalance[0][1]": 0.25}).rotor.unbalance)[1:] == pytest.approx(u[1:], rel=1e-15)
    data = rsc.sweep(scene, {"rotor.unbalance.angle": "0:180:3"}, "predict")
    assert data.sizes["rotor.unbalance.angle"] == 3
    for name in ("rotor.load.angle", "rotor.unbalance.size"):
        with pytest.raises(rsc.SceneError, match=name.replace(".", r"\.")):
            scene.with_values({name: 1.0})


def test_gravity_and_forces_bend_the_rotor_as_the_full_one(model, tmp_path):
    scene = rsc.load_scene(written(tmp_path, model, PLAIN + "\ngravity = 9.81\nload = [[3, [100.0, 0.0]]]"))
    moving, system = (model.kind == "displacement").astype(float), assemble(scene)
    force = -9.81j * (model.mass @ moving) + 100.0 * model.row_at(3)
    full = model.row_at(6) @ np.linalg.solve(model.stiffness, force)
    assert system.rotor.contact @ np.linalg.solve(system.rotor.stiffness, system.rotor.load) == pytest.approx(full, rel=1e-4)
    # from rest it begins there, or pressed against the wall of a gap that is too small for it, and without friction stays
    for gap in (2.0 * abs(full), 0.5 * abs(full)):
        values = {"contact.gap": gap, "contact.friction": 0.0, "rotor.unbalance": [[0.0, 0.0]] * system.n_rotor}
        result = rsc.simulate(scene.with_values(values | {"drive.duration": 0.05}))
        assert (result.normal_force[0] > 0.0) == (gap < abs(full))
        assert abs(result.contact_rotor() - result.contact_rotor()[0]).max() < 1e-4 * gap
        if gap > abs(full):
            assert result.contact_rotor()[0] == pytest.approx(full, rel=1e-3)


def test_the_contact_may_lie_between_two_nodes(model, tmp_path):
    scene = rsc.load_scene(written(tmp_path, model, "contact = [6, 7, 0.4]"))
    row, system = model.row_between(6, 7, 0.4), assemble(scene)
    full = row @ np.linalg.solve(model.stiffness, row)
    assert system.rotor.contact @ np.linalg.solve(system.rotor.stiffness, system.rotor.contact) == pytest.approx(full, rel=1e-5)


def test_a_tighter_tolerance_keeps_more_coordinates_and_moves_whirls_by_what_was_told(model, tmp_path):
    coarse = rsc.load_scene(written(tmp_path, model, PLAIN, more="[reduction]\ntolerance = 1e-2"))
    fine = rsc.load_scene(written(tmp_path, model, PLAIN, more="[reduction]\ntolerance = 1e-8"))
    assert coarse.rotor.n_coordinates < fine.rotor.n_coordinates
    whirl = next(w for w in rsc.predict(coarse, 30.0) if w.frequency > -480.0)
    full = min(rsc.predict(fine, 30.0), key=lambda w: abs(w.frequency - whirl.frequency))
    told = reduction_remarks(coarse, [whirl])
    assert told[0].startswith("the rotor is reduced from 26 to") and "tolerance 0.01" in told[0]
    shift = float(told[1].partition("lies ")[2].split()[0])
    assert shift == pytest.approx(full.frequency - whirl.frequency, rel=0.2)
    assert reduction_remarks(rsc.Scene.from_dict(coarse.to_dict()), [whirl]) == told[:1]


def test_coefficients_taken_at_a_speed_are_told(model, tmp_path):
    scene = rsc.load_scene(written(tmp_path, replace(model, speed=25.0), PLAIN))
    (told,) = coefficient_remarks(scene)
    assert "those at 25 Hz, the run turns at 10 to 40 Hz" in told
    assert told in rsc.check(scene.with_values({"drive.duration": 0.2})).warnings  # which the terminal prints as well
    assert coefficient_remarks(rsc.load_scene(written(tmp_path, model, PLAIN))) == []


def test_a_whirl_outside_the_band_is_told(model, tmp_path):
    scene = rsc.load_scene(written(tmp_path, model, PLAIN, more="[reduction]\nband = [-60.0, 40.0]"))
    outside = [w for w in rsc.predict(scene, 30.0) if w.frequency < -60.0]
    assert outside and "outside the band of the reduction, -60 to 40 Hz" in reduction_remarks(scene, outside)[1]


@pytest.mark.parametrize(
    "keys, more, problem",
    [
        ("contact = 99", "", r"rotor.contact = 99: must be a place of the model \(no node 99"),
        ('contact = 6\nsha256 = "0123"', "", r"rotor.file = 'rotor.npz': must be the file whose SHA-256 is 0123"),
        ('contact = 6\nunbalance = [[6, "3 N"]]', "", r"rotor.unbalance\[0\]\[1\]"),
        ('contact = 6\nunbalance = [[6, "G x"]]', "", r"rotor.unbalance"),
        ("contact = 6\nmass = 3.0", "", r"rotor.mass"),
        ("contact = 6", "[reduction]\ntolerance = 1e-20", r"reduction.tolerance"),
        ("contact = 6", "[reduction]\nband = [10.0, -10.0]", r"reduction.band"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(model, tmp_path, keys, more, problem):
    with pytest.raises(rsc.SceneError, match=problem) as refusal:
        rsc.load_scene(written(tmp_path, model, keys, more=more))
    assert "\n" not in str(refusal.value)


def test_a_file_that_is_no_model_is_refused(model, tmp_path):
    path = written(tmp_path, model, PLAIN)
    np.savez(tmp_path / "rotor.npz", mass=np.eye(3))
    with pytest.raises(rsc.SceneError, match="not a model written by `rsc import`"):
        rsc.load_scene(path)


def test_a_reduction_without_a_machine_is_refused():
    content = {
        "rotor": {"model": "laval", "mass": 1.0, "frequency": 30.0},
        "stator": {"model": "rigid"},
        "contact": {"gap": 1e-3, "friction": 0.1, "stiffness": 1e6},
        "drive": {"speed": 20.0, "duration": 1.0},
        "reduction": {"tolerance": 1e-3},
    }
    with pytest.raises(rsc.SceneError, match=r"reduction\.tolerance"):
        rsc.Scene.from_dict(content)


def doubled(matrices, Psi, Omega, row):
    """Displacement l z of a body with terms in conj(z) under the force l e^{i Psi t}, its line at Psi."""
    m, b, g, k, q, s, c, e = matrices
    own = k + 1j * s - Psi**2 * m + 1j * Psi * (b + 1j * q) + Psi * Omega * g
    mirror = np.conj(k + 1j * s - Psi**2 * m - 1j * Psi * (b + 1j * q) - Psi * Omega * g)
    to_mirror, to_own = np.conj(e) + 1j * Psi * np.conj(c), e + 1j * Psi * c
    n = len(row)
    whole = np.block([[own, to_own], [to_mirror, mirror]])
    return row @ np.linalg.solve(whole, np.concatenate([row, 0.0 * row]) + 0j)[:n]


def test_bearings_that_differ_in_x_and_y_and_seals_are_reduced_with_the_rotor(tmp_path):
    matrices, nodes, directions = rotor(n_elements=12, bearing=((1e7, 6e6), (8e6, 1e7)), cross=4e5)
    table = Coordinates(nodes, directions, {}, {i: i / 12 for i in range(13)})
    model = rotor_model(matrices, table, "a shaft", units="m")
    scene = rsc.load_scene(written(tmp_path, model, PLAIN))
    system = assemble(scene)
    assert not system.isotropic and system.skew and rsc.Scene.from_toml(scene.to_toml()) == scene
    none = np.zeros((model.n, model.n))
    full = (
        model.mass, model.damping, model.gyroscopic, model.stiffness,
        none if model.skew_damping is None else model.skew_damping, model.skew_stiffness,
        none if model.anisotropic_damping is None else model.anisotropic_damping, model.anisotropic_stiffness,
    )  # fmt: skip
    small = np.zeros((system.n_rotor,) * 2)
    names = ("mass", "damping", "gyroscopic", "stiffness", "skew_damping", "skew_stiffness")
    names += ("anisotropic_damping", "anisotropic_stiffness")
    reduced = tuple(small if getattr(system.rotor, name) is None else getattr(system.rotor, name) for name in names)
    for Psi in (-TWO_PI * 70.0, TWO_PI * 40.0):
        wanted = doubled(full, Psi, TWO_PI * 30.0, model.row_at(6))
        assert doubled(reduced, Psi, TWO_PI * 30.0, system.rotor.contact) == pytest.approx(wanted, rel=1e-3)
        mean = doubled((*full[:6], none, none), Psi, TWO_PI * 30.0, model.row_at(6))
        assert abs(mean / wanted - 1.0) > 5e-3


def test_speeds_for_which_the_rotor_was_not_reduced_are_refused(model, tmp_path, capsys):
    from rsc.cli import main

    path = written(tmp_path, model, PLAIN)
    scene = rsc.load_scene(path)
    assert rsc.predict(scene, [0.0, 40.0]) and rsc.predict_many([scene], [20.0]) is not None
    wanted = "must be within 0 to 40 Hz, for which the rotor was reduced"
    for speed in (40.5, -1.0):
        for predicted in (lambda: rsc.predict(scene, speed), lambda: rsc.predict_many([scene], [20.0, speed])):  # noqa: B023
            with pytest.raises(rsc.SceneError, match=wanted):
                predicted()
    for speed in ("41", "-1"):  # also where the rotor would be looked at in the mirror image
        assert main(["predict", str(path), "--speed", speed]) == 2
        assert f"speed = {speed}.0: {wanted}" in capsys.readouterr().err
