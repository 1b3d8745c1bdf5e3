"""Several contacts on finite-element rotors and casings: the reduction keeps every contact, runs and whirls stay the same."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse

import rsc
from fe_bodies import rotor
from machines import on_unequal_bearings, random_machine, shaft
from rsc.errors import ReductionError, SceneError
from rsc.machine.imports.build import rotor_model, stator_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.imports.store import save_model
from rsc.machine.reduction.body import FEW
from rsc.machine.reduction.directions import FrequencyPoint, reduce_unequal, responses
from rsc.machine.reduction.points import natural_frequencies
from rsc.machine.reduction.reduction import reduce
from rsc.study.prediction.predictions import predictions
from rsc.system.assemble import assemble

TWO_PI = 2.0 * np.pi
N_ELEMENTS = 12
PLACES = 4, 9  # nodes of the seals
STATOR = '[stator]\nmodel = "chain"\nmasses = [4.8, 1.2]\nstiffnesses = [1.2e7, 7.7e6, 1.05e7]\ndamping_ratio = 0.2\n'
CONTACTS = """
[[contact]]
name = "seal"
rotor_node = 4
stator_coordinate = 0
gap = 2e-4
friction = 0.14
stiffness = 2e7
damping_ratio = 0.05
diameter = 0.05
[[contact]]
name = "bush"
rotor_node = 9
stator_coordinate = 1
gap = 2.5e-4
friction = 0.26
stiffness = 3e7
damping_ratio = 0.05
diameter = 0.05
"""


def with_rows(body, *others):
    """A body whose contact row is joined by others."""
    from dataclasses import replace

    return replace(body, contact=np.array([body.contact, *others]))


def unit(body, i):
    return np.eye(body.n_coordinates)[i]


def receptances(body, Psi, Omega):
    """(c, c) between the contacts, written out once more."""
    zero = 0.0 * body.mass
    S, Q, G = (zero if m is None else m for m in (body.skew_stiffness, body.skew_damping, body.gyroscopic))
    A = body.stiffness - Psi**2 * body.mass + 1j * Psi * (body.damping + 1j * Q - 1j * Omega * G) + 1j * S
    return body.contact @ np.linalg.solve(A, body.contact.T + 0j)


def shaft_model():
    matrices, nodes, directions = rotor(N_ELEMENTS, total=1.2, bearing=((8e6, 8e6), (8e6, 8e6)), disc=(12.0, 0.06, 0.1))
    matrices["damping"] = 2e-5 * matrices["stiffness"]
    for row in (0, 1, 6 * N_ELEMENTS, 6 * N_ELEMENTS + 1):
        matrices["damping"][row, row] += 700.0
    table = Coordinates(nodes, directions, {"drive end": 0}, {i: 0.1 * i for i in range(N_ELEMENTS + 1)})
    return rotor_model(matrices, table, "a shaft", units="m")


@pytest.fixture(scope="module")
def model():
    return shaft_model()


def head(more='unbalance = [[6, "100 g*mm"]]'):
    return f'[rotor]\nmodel = "machine"\nfile = "rotor.npz"\n{more}\n'


def scene_of(folder, model, text):
    save_model(model, folder / "rotor.npz")
    path = folder / "scene.toml"
    path.write_text(text)
    return rsc.load_scene(path)


def two_seals(folder, model, contacts=CONTACTS, stator=STATOR, tolerance=1e-5, drive="speed = 50.0\nduration = 0.5", more=""):
    end = f"[drive]\n{drive}\n[reduction]\ntolerance = {tolerance}\nband = [-1500, 1500]\n"
    return scene_of(folder, model, head() + more + stator + contacts + end)


def in_full(scene, model):
    """The same scene with all coordinates of the rotor as matrices, without unbalance."""
    content = scene.to_dict()
    content["rotor"] = {
        "model": "matrices", "mass": model.mass.tolist(), "stiffness": model.stiffness.tolist(),
        "damping": model.damping.tolist(), "gyroscopic": model.gyroscopic.tolist(),
        "tilt_coordinates": np.flatnonzero(model.kind == "tilt").tolist(),
        "eccentricity": [0.0] * model.n,
    }  # fmt: skip
    for contact, node in zip(content["contact"], PLACES, strict=True):
        contact["rotor_coordinate"] = int(np.flatnonzero(model.row_at(node))[0])
    return rsc.Scene.from_dict(content)


@pytest.mark.parametrize(("skew", "order"), [(False, [0, 1, 2]), (True, [1, 2, 0]), (False, [2, 1, 0])])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-5])
def test_the_whole_matrix_of_receptances_is_within_the_tolerance(skew, order, tolerance):
    machine = random_machine(np.random.default_rng(11), skew=skew)
    n = machine.rotor.n_coordinates
    body = with_rows(machine.rotor, unit(machine.rotor, 2), unit(machine.rotor, n - 4))
    body = replace(body, contact=body.contact[order])
    reduced = reduce(body, machine.band, machine.speeds, tolerance)
    assert reduced.error <= tolerance
    rng = np.random.default_rng(1)
    places = np.column_stack([rng.uniform(*machine.band, 200), rng.uniform(*machine.speeds, 200)])
    full, small = (np.array([receptances(part, *place) for place in places]) for part in (body, reduced.body))
    floor = 0.1 * np.median(np.abs(full), axis=0)  # antiresonances have a scale of their own
    assert (np.abs(full - small) <= reduced.error * np.maximum(np.abs(full), floor)).all()


def test_contacts_are_the_first_coordinates_and_their_masses_alone_are_coupled():
    machine = random_machine(np.random.default_rng(11))
    body = with_rows(machine.rotor, unit(machine.rotor, 2))
    reduced = reduce(body, machine.band, machine.speeds, 1e-4)
    small, r = reduced.body, reduced.body.n_coordinates
    assert (small.contact == np.eye(r)[:2]).all()
    rest = small.mass.copy()
    rest[:2, :2] = small.mass[0, 0] * np.eye(2)
    assert (rest == small.mass[0, 0] * np.eye(r)).all() and abs(small.mass[0, 1]) > 0.0
    scale = np.abs(reduced.basis).T @ np.abs(body.mass) @ np.abs(reduced.basis)
    assert (np.abs(small.mass - reduced.basis.T @ body.mass @ reduced.basis) <= 1e-9 * scale).all()
    assert np.abs(body.contact @ reduced.basis - np.eye(r)[:2]).max() < 1e-9
    held = small.stiffness[2:, 2:]
    assert np.abs(held - np.diag(held.diagonal())).max() < 1e-9 * held.max()


@pytest.mark.nightly
def test_a_large_sparse_body_with_two_contacts_is_within_the_tolerance():
    from dataclasses import replace

    rng = np.random.default_rng(3)
    body = shaft(rng, FEW // 2 + 20, False)
    body = with_rows(body, unit(body, 60))
    natural = natural_frequencies(body, 0.0)
    first, fourth = natural[natural > 0.0][[0, 3]]
    band, speeds = (-1.2 * fourth, 0.7 * fourth), (0.0, 1.5 * first)
    sparse = replace(body, **{name: scipy.sparse.csc_array(matrix) for name, matrix in body.terms.items()})
    reduced = reduce(sparse, band, speeds, 1e-4)
    assert all(check.estimated for check in reduced.checks)
    for Psi, Omega in np.column_stack([rng.uniform(*band, 30), rng.uniform(*speeds, 30)]):
        full, small = (receptances(part, Psi, Omega) for part in (body, reduced.body))
        static = np.sqrt(np.outer(full.diagonal(), full.diagonal()))
        assert (np.abs(full - small) < 1e-4 * np.maximum(np.abs(full), 0.01 * np.abs(static))).all()


def test_with_unequal_directions_both_lines_at_both_contacts_are_within_the_tolerance():
    rng = np.random.default_rng(2)
    machine = random_machine(rng)
    body, unequal = on_unequal_bearings(rng, machine.rotor)
    body = with_rows(body, unit(body, 4))
    reduced = reduce_unequal(body, unequal, machine.band, machine.speeds, 1e-3)
    small = unequal.projected(reduced.basis)
    for Psi in np.linspace(*machine.band, 60):
        place = FrequencyPoint(Psi, 0.5 * machine.speeds[1], [0, 1, 2, 3])
        full, own = (
            np.kron(np.eye(2), part.contact) @ responses(part, part_unequal, place)
            for part, part_unequal in ((body, unequal), (reduced.body, small))
        )
        scale = np.abs(full).max(axis=0)
        clear = scale > 0.05 * np.median(scale)
        assert (np.abs(full - own).max(axis=0) <= 1e-3 * scale)[clear].all()


def test_whirls_at_both_seals_are_those_of_the_full_rotor(model, tmp_path):
    coarse, fine = (two_seals(tmp_path, model, tolerance=tolerance) for tolerance in (1e-2, 1e-8))
    full = rsc.predict(in_full(fine, model), 50.0)
    for scene, close in ((fine, 1e-7), (coarse, 1e-2)):
        own = [whirl for whirl in rsc.predict(scene, 50.0) if whirl.stable]
        known = [whirl for whirl in full if whirl.stable]
        assert own and [whirl.pressed for whirl in own] == [whirl.pressed for whirl in known]
        for whirl, other in zip(own, known, strict=True):
            assert whirl.frequency == pytest.approx(other.frequency, rel=close)
            for name in ("seal", "bush"):
                assert whirl.contacts[name].normal_force == pytest.approx(other.contacts[name].normal_force, rel=100 * close)


def test_the_remark_tells_how_far_the_whirl_of_the_full_model_lies(model, tmp_path):
    coarse = two_seals(tmp_path, model, tolerance=1e-2)
    told = predictions(coarse, [50.0])[0]
    (whirl,) = (whirl for whirl in told.whirls if whirl.stable)
    (known,) = (whirl for whirl in rsc.predict(in_full(coarse, model), 50.0) if whirl.stable)
    (remark,) = (text for text in told.remarks if "of the full model lies" in text)
    assert " at seal and bush " in remark
    stated = float(remark.partition("lies ")[2].split()[0])
    assert stated == pytest.approx(known.frequency - whirl.frequency, rel=0.1)


@pytest.mark.nightly  # three quarters of a minute for each kernel
@pytest.mark.parametrize("method", ["rk45", "taylor8"])
def test_an_impact_ends_in_the_whirl_at_both_as_in_the_full_rotor(model, tmp_path, method):
    scene = two_seals(tmp_path, model, tolerance=1e-6)
    (whirl,) = (whirl for whirl in rsc.predict(scene, 50.0) if whirl.stable)
    start = {"rotor": [[z.real, z.imag] for z in whirl.rotor_shape], "stator": [[z.real, z.imag] for z in whirl.stator_shape]}
    turning = 2j * np.pi * whirl.frequency
    start |= {
        f"{name}_velocity": [[(turning * z).real, (turning * z).imag] for z in shape]
        for name, shape in (("rotor", whirl.rotor_shape), ("stator", whirl.stator_shape))
    }
    content = scene.to_dict() | {"start": start | {"allow_penetration": True}}
    content["solver"]["method"] = method
    result = rsc.simulate(rsc.Scene.from_dict(content))
    assert result.status == "finished"
    facts = result.stretches("seal").whole(), result.stretches("bush").whole()
    assert all(own.share > 0.99 for own in facts)
    z = result.rotor[-800:, 0]
    turned = np.angle(z[1:] / z[:-1]).sum() / TWO_PI / (result.time[-1] - result.time[-800])
    assert turned == pytest.approx(whirl.frequency, rel=1e-3)


def test_a_result_keeps_the_contacts_without_the_file(model, tmp_path):
    scene = two_seals(tmp_path, model, drive="speed = [20.0, 50.0]\nduration = 0.05")
    assert [contact.rotor_coordinate for contact in scene.contacts] == [0, 1]
    rsc.simulate(scene).save(tmp_path / "run.h5")
    kept = rsc.load(tmp_path / "run.h5").scene
    assert kept.rotor == scene.rotor and kept.contacts == scene.contacts
    assert np.array_equal(assemble(kept).rotor.mass, assemble(scene).rotor.mass)
    assert "contact at [4, 9]" in kept.rotor.origin


def test_a_casing_has_a_node_for_each_contact(model, tmp_path):
    matrices, nodes, directions = rotor(4, total=0.8, bearing=((3e7, 3e7), (3e7, 3e7)), disc=(5.0, 0.02, 0.0))
    del matrices["gyroscopic"]
    matrices["damping"] = 1e-4 * matrices["stiffness"]
    table = Coordinates(nodes, directions, {}, {i: 0.2 * i for i in range(5)})
    casing = stator_model(matrices, table, "a casing", 1, 500.0, units="m")
    save_model(casing, tmp_path / "casing.npz")
    contacts = CONTACTS.replace("stator_coordinate = 0", "stator_node = 1").replace("stator_coordinate = 1", "stator_node = 3")
    scene = two_seals(tmp_path, model, contacts, '[stator]\nmodel = "machine"\nfile = "casing.npz"\n')
    system, rows = assemble(scene), np.array([casing.row_at(1), casing.row_at(3)])
    for Psi in (-TWO_PI * 70.0, TWO_PI * 200.0):
        full = rows @ np.linalg.solve(casing.stiffness - Psi**2 * casing.mass + 1j * Psi * casing.damping, rows.T + 0j)
        body = system.stator
        own = np.linalg.solve(body.stiffness - Psi**2 * body.mass + 1j * Psi * body.damping, np.eye(body.n_coordinates) + 0j)
        places = [contact.stator_coordinate for contact in scene.contacts]
        assert own[np.ix_(places, places)] == pytest.approx(full, rel=1e-4)


def test_contacts_at_one_node_share_its_coordinate(model, tmp_path):
    scene = two_seals(tmp_path, model, CONTACTS.replace("rotor_node = 9", "rotor_node = 4"))
    assert [contact.rotor_coordinate for contact in scene.contacts] == [0, 0] and scene.rotor.contact_masses is None


def test_the_mass_at_a_contact_does_not_change_with_a_contact_beside_it(model, tmp_path):
    """The masses of neighbours are coupled: that at a contact, from which its damping follows, is not on the diagonal."""
    scene = two_seals(tmp_path, model, CONTACTS.replace("rotor_node = 9", "rotor_node = 5"), tolerance=1e-8)
    mass = assemble(scene).rotor.mass
    alone = 1.0 / np.linalg.inv(mass).diagonal()[:2]
    assert [scene.rotor.mass_at(i) for i in (0, 1)] == pytest.approx(alone, rel=1e-9)
    assert (mass.diagonal()[:2] > 1.01 * alone).all()


@pytest.mark.parametrize(
    ("contacts", "more", "wanted"),
    [
        (CONTACTS.replace("rotor_node = 9\n", ""), "", "contact.bush.rotor_node = .missing.: must be given"),
        (CONTACTS, "contact = 6\n", "rotor.contact = 6: must be left out .contact.seal has rotor_node"),
        (CONTACTS.replace("rotor_node = 9", "rotor_node = 9\nrotor_coordinate = 1"), "", "contact.bush.rotor_coordinate"),
        (CONTACTS.replace("rotor_node = 4\n", "").replace("rotor_node = 9\n", ""), "", "rotor.contact = .missing.: must be"),
        (CONTACTS.replace("rotor_node = 9", "rotor_node = 99"), "", "no node 99"),
        (CONTACTS.replace("rotor_node = 9", "rotor_node = {node = 9, against = 3}"), "", "leave .stator. out"),
        (CONTACTS.replace("stator_coordinate = 1", "stator_node = 1"), "", "contact.bush.stator_node = 1: must be left out"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(model, tmp_path, contacts, more, wanted):
    with pytest.raises(SceneError, match=wanted) as error:
        two_seals(tmp_path, model, contacts, more=more)
    assert "\n" not in str(error.value)


def test_a_coordinate_that_is_no_contact_of_a_machine_is_refused(model, tmp_path):
    contact = "[contact]\nrotor_coordinate = 1\ngap = 1e-4\nfriction = 0.1\nstiffness = 1e7\n"
    with pytest.raises(SceneError, match="rotor_coordinate = 1: must be a whole number from 0 to 0"):
        scene_of(tmp_path, model, head("contact = 4") + STATOR + contact + "[drive]\nspeed = 50.0\nduration = 0.5\n")


def test_contacts_that_move_alike_are_refused():
    machine = random_machine(np.random.default_rng(11))
    body = with_rows(machine.rotor, machine.rotor.contact)
    with pytest.raises(ReductionError, match="move together"):
        reduce(body, machine.band, machine.speeds, 1e-2)
