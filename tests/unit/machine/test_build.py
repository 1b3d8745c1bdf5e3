"""Models from real matrices: the physics survives the complex coordinates, and impossible matrices are refused."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg

from fe_bodies import casing, cylinder, rotor
from rsc.errors import DataError
from rsc.machine.checks.checks import has_negative
from rsc.machine.imports.build import rotor_model, stator_model
from rsc.machine.imports.casing import receptances
from rsc.machine.imports.coordinates import Coordinates

TWO_PI = 2.0 * np.pi


def table(nodes, directions):
    plane = np.where(np.isin(directions, ("z", "rz")), "other", directions)
    return Coordinates(nodes, plane, {"disc": 3}, {node: node / 6.0 for node in set(nodes.tolist())})


def built(changes=None, **options):
    matrices, nodes, directions = rotor(**options)
    for name, change in (changes or {}).items():
        matrices[name] = change(matrices[name])
    return rotor_model(matrices, table(nodes, directions), "test")


def eigenvalues(mass, damping, stiffness):
    n = len(mass)
    upper = np.hstack([np.zeros((n, n)), np.eye(n)])
    lower = np.hstack([-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)])
    return np.linalg.eigvals(np.vstack([upper, lower]))


@pytest.mark.parametrize("options", [{}, {"bearing": ((1e7, 2e7), (1e7, 1e7))}, {"bearing": ((1e7, 3e6),) * 2, "cross": 2e6}])
def test_eigenvalues_are_those_of_the_real_matrices(options):
    """Isotropic, anisotropic, and cross-coupled as well: the roots of both directions, from the form and its conjugate."""
    matrices, _, directions = rotor(**options)
    model, speed = built(**options), 60.0
    lateral = np.flatnonzero(np.isin(directions, ("x", "y", "rx", "ry")))
    real = {name: matrix[np.ix_(lateral, lateral)] for name, matrix in matrices.items()}
    wanted = eigenvalues(real["mass"], real["damping"] + TWO_PI * speed * real["gyroscopic"], real["stiffness"])
    found = eigenvalues(*model.with_conjugate(speed))
    assert len(found) == len(wanted)
    assert max(np.min(np.abs(found - root)) / abs(root) for root in wanted) < 1e-8
    assert model.isotropic == (not options) and (model.skew_stiffness is not None) == ("cross" in options)


def test_forward_whirl_is_positive_and_stiffened_by_the_gyroscopics():
    model = built(bearing=((1e7, 1e7),) * 2)
    Omega = TWO_PI * 200.0
    roots = eigenvalues(model.mass, model.damping - 1j * Omega * model.gyroscopic, model.stiffness).imag / TWO_PI
    rest = np.sort(np.sqrt(scipy.linalg.eigvalsh(model.stiffness, model.mass))) / TWO_PI
    second = rest[1]  # a conical mode, in which the disc tilts most
    forward, backward = roots[roots > 0.0], -roots[roots < 0.0]
    assert np.min(np.abs(forward - second)) > 1.0
    assert np.sum(forward < second * 1.001) < np.sum(backward < second * 1.001)


def test_a_unit_rotation_gives_the_disc_its_angular_momentum():
    """-i Omega G phi' with phi = ry - i rx: the torque on a disc that tilts, against rotating rigid bodies."""
    with_disc, without = built(disc=(8.0, 0.03, 0.05)), built(disc=(8.0, 0.03, 0.0))
    i = np.flatnonzero((with_disc.node == 3) & (with_disc.kind == "tilt"))[0]
    difference = with_disc.gyroscopic - without.gyroscopic
    assert difference[i, i] == pytest.approx(0.05) and np.count_nonzero(difference) == 1


def test_sparse_matrices_stay_sparse_and_are_the_same():
    matrices, nodes, directions = rotor(bearing=((1e7, 2e7), (1e7, 1e7)), cross=1e6)
    packed = {name: scipy.sparse.csc_array(matrix) for name, matrix in matrices.items()}
    model = rotor_model(packed, table(nodes, directions), "test")
    dense = built(bearing=((1e7, 2e7), (1e7, 1e7)), cross=1e6)
    assert model.is_sparse and not dense.is_sparse
    for name in ("mass", "damping", "gyroscopic", "stiffness", "skew_stiffness", "anisotropic_stiffness", "anisotropic_damping"):
        matrix = getattr(model, name)
        assert scipy.sparse.issparse(matrix), name
        assert np.allclose(matrix.toarray(), getattr(dense, name), rtol=1e-14, atol=0.0), name


def test_rows_of_places():
    model = built()
    z = np.where(model.kind == "tilt", 3.0 * (model.node / 6.0) ** 2 - 1j, (model.node / 6.0) ** 3 - 1j * model.node / 6.0)
    assert model.row_at("disc") @ z == pytest.approx(0.5**3 - 0.5j)
    assert model.row_between(2, 3, 0.25) @ z == pytest.approx((2.25 / 6.0) ** 3 - 2.25j / 6.0)  # the cubic is exact
    straight = replace(model, position={})
    assert straight.row_between(2, 3, 0.25) @ z == pytest.approx((0.75 * 2**3 + 0.25 * 3**3) / 6.0**3 - 2.25j / 6.0)
    for place, hint in ((99, "no node 99"), ("disk", "did you mean")):
        with pytest.raises(DataError, match=hint):
            model.row_at(place)
    for places, hint in (((3, 2, 0.5), "further along"), ((2, 3, 2.0), "from 0 to 1")):
        with pytest.raises(DataError, match=hint):
            model.row_between(*places)


def changed(i, j, value, factor=1.0):
    """A change of one entry and of its mirror image."""

    def change(matrix):
        matrix = matrix.copy()
        for place in {(i, j), (j, i)}:
            matrix[place] = matrix[place] * factor + value
        return matrix

    return change


def one_sided(i, j):
    def change(matrix):
        matrix = matrix.copy()
        matrix[i, j] *= 1.1
        return matrix

    return change


BEARINGS = {"bearing": ((0.0, 0.0),) * 2}
REFUSED = {  # changes of matrices, options of the rotor, words of the refusal
    "size": ({"damping": lambda m: m[:-1, :-1]}, {}, "the damping has size 41x41 but the table has 42 rows"),
    "unsymmetric mass": ({"mass": one_sided(0, 4)}, {}, "the mass matrix is not symmetric"),
    "indefinite mass": (
        {"mass": lambda m: changed(19, 19, 0.0, -1.0)(changed(18, 18, 0.0, -1.0)(m))},
        {},
        "mass matrix is indefinite",
    ),
    "indefinite stiffness": ({"stiffness": lambda m: m - 1e7 * np.eye(42)}, {}, "the stiffness is indefinite"),
    "unsymmetric stiffness": ({"stiffness": one_sided(0, 6)}, {}, "the stiffness is not symmetric"),
    "coupled with z": ({"stiffness": changed(0, 2, 1e5)}, {}, "torsion or axial motion, as with gears, is not"),
    "crosswise mass": ({"mass": changed(0, 7, 0.1)}, {}, "mass matrix cross-couples x and y"),
    "symmetric gyroscopics": ({"gyroscopic": np.abs}, {}, "the gyroscopic matrix depends on the direction"),
    "not skew gyroscopics": ({"gyroscopic": changed(0, 0, 0.1)}, {}, "the gyroscopic matrix is not skew-symmetric"),
    "gyroscopics the other way": ({"gyroscopic": np.negative}, {}, "sign of rotation from y to x"),
    "no bearings": ({}, BEARINGS, ": 2 rigid-body or other motions have no stiffness"),
    "one bearing": ({}, {"bearing": ((1e7, 1e7), (0.0, 0.0))}, "1 rigid-body or other motions"),
    "newtons per million kilometres": ({"stiffness": lambda m: 1e-12 * m}, {}, "units of mass and stiffness are inconsistent"),
}


@pytest.mark.parametrize("kind", REFUSED)
@pytest.mark.parametrize("packed", [False, True], ids=["dense", "sparse"])
def test_impossible_rotors_are_refused(kind, packed):
    changes, options, words = REFUSED[kind]
    matrices, nodes, directions = rotor(**options)
    for name, change in changes.items():
        matrices[name] = change(matrices[name])
    if packed:
        matrices = {name: scipy.sparse.csc_array(matrix) for name, matrix in matrices.items()}
    with pytest.raises(DataError) as caught:
        rotor_model(matrices, table(nodes, directions), "test")
    assert words in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", ["indefinite mass", "indefinite stiffness", "no bearings", "one bearing"])
def test_impossible_large_rotors_are_refused(kind, monkeypatch):
    """Where pivots are not counted negative eigenvalues are looked for."""
    monkeypatch.setattr("rsc.machine.checks.checks._COUNTED", 10)
    changes, options, words = REFUSED[kind]
    matrices, nodes, directions = rotor(**options)
    matrices = {name: scipy.sparse.csc_array(changes.get(name, np.copy)(matrix)) for name, matrix in matrices.items()}
    with pytest.raises(DataError, match=words):
        rotor_model(matrices, table(nodes, directions), "test")


def test_a_large_rotor_that_is_possible_is_taken(monkeypatch):
    monkeypatch.setattr("rsc.machine.checks.checks._COUNTED", 10)
    matrices, nodes, directions = rotor(n_elements=40)
    sparse = {name: scipy.sparse.csc_array(matrix) for name, matrix in matrices.items()}
    large = rotor_model(sparse, table(nodes, directions), "test")
    assert abs(large.stiffness - rotor_model(matrices, table(nodes, directions), "test").stiffness).max() == 0.0


def test_negative_eigenvalues_are_found_at_the_end_of_the_spectrum():
    values = np.append(np.geomspace(1e-9, 1.0, 3000), -1e-3)
    assert has_negative(lambda x: values * x, 3001, 200, 1e-9)
    assert not has_negative(lambda x: abs(values) * x, 3001, 200, 1e-9)
    values[-1] = -1e-7
    assert has_negative(lambda x: x / values, 3001, 40, 1e-4)
    assert not has_negative(lambda x: x / abs(values), 3001, 40, 1e-4)


def test_solid_elements_are_told_as_such():
    matrices, nodes, directions = casing()
    with pytest.raises(DataError, match=r"couples x, y, rx or ry with other directions.*solid elements: use beam"):
        rotor_model(matrices, table(nodes, directions), "test")


def test_entries_beyond_any_machine_are_refused():
    matrices, nodes, directions = rotor()
    matrices["stiffness"][0, 6] = matrices["stiffness"][6, 0] = 1e40
    with pytest.raises(DataError, match="the stiffness has an entry of 1e\\+40, which is impossible in a machine"):
        rotor_model(matrices, table(nodes, directions), "test")


def test_a_direction_without_its_partner_is_refused():
    matrices, nodes, directions = rotor()
    rows = np.flatnonzero(~((nodes == 2) & (directions == "y")))
    part = {name: matrix[np.ix_(rows, rows)] for name, matrix in matrices.items()}
    with pytest.raises(DataError, match="node 2 has direction x but not y"):
        rotor_model(part, table(nodes[rows], directions[rows]), "test")


def test_millimetres_and_tonnes_are_noticed_and_turned_into_si():
    matrices, nodes, directions = rotor()
    scale = np.diag(np.where(np.isin(directions, ("rx", "ry", "rz")), 1.0, 1e-3))
    in_mm = {name: 1e3 * scale @ matrix @ scale for name, matrix in matrices.items()}
    places = replace(table(nodes, directions), position={})
    with pytest.raises(DataError, match=r"elements look .* m long: if the units are millimetres"):
        rotor_model(in_mm, places, "test")
    model = rotor_model(in_mm, places, "test", units="mm")
    assert np.allclose(model.mass, built().mass, rtol=1e-12) and np.allclose(model.stiffness, built().stiffness, rtol=1e-12)
    with pytest.raises(DataError, match="units 'inch': must be m or mm"):
        rotor_model(in_mm, places, "test", units="inch")


def test_held_coordinates_are_left_out():
    """Abaqus puts 1e36 on the diagonal of a coordinate that is held: here the axial one at node 0, and a pinned node 6."""
    matrices, nodes, directions = rotor()
    pinned = np.flatnonzero((nodes == 6) | ((nodes == 0) & (directions == "z")))
    matrices["stiffness"][pinned, pinned] = 1e36
    model = rotor_model(matrices, table(nodes, directions), "test")
    assert 6 not in model.node and model.n == 12 and "7 coordinates are left out" in model.notes[0]


def test_a_casing_with_coupled_axial_motion_answers_in_one_direction_as_in_both():
    """The complex displacement of the hub for a turning force, from the real matrices and from the model of one direction."""
    matrices, nodes, directions = casing()
    model = stator_model(matrices, table(nodes, directions), "test", contact=0, band=200.0)
    row, omega = model.row_at(0), TWO_PI * 130.0
    dynamic = matrices["stiffness"] - omega**2 * matrices["mass"] + 1j * omega * matrices["damping"]
    force = np.zeros(15, complex)
    force[[0, 1]] = 1.0, -1j  # the real part of (1, -i) e^{i omega t} turns from x to y
    q = np.linalg.solve(dynamic, force)
    h = row @ np.linalg.solve(model.stiffness - omega**2 * model.mass + 1j * omega * model.damping, row)
    forward = 0.5 * (q[0] + 1j * q[1])  # of x + i y, the part with e^{i omega t}
    backward = 0.5 * (q[0] - 1j * q[1])
    assert forward == pytest.approx(h, rel=1e-10) and abs(backward) < 1e-10 * abs(h)
    assert "differ by" in model.notes[0]


def test_receptances_are_those_of_the_dynamic_stiffness():
    """Of a cylinder with several resonances up to the highest frequency, from one factorisation at rest."""
    matrices, nodes, directions = cylinder(8, 10)
    matrices["damping"] = 1e-5 * matrices["stiffness"]
    model = stator_model(matrices, table(nodes, directions), "test", contact=int(nodes[-1]), band=100.0)
    lowest = np.sqrt(scipy.sparse.linalg.eigsh(matrices["stiffness"], 4, M=matrices["mass"], sigma=0.0)[0]) / TWO_PI
    rows, frequencies = np.array([model.n - 3, model.n - 2]), np.linspace(0.0, 1.1 * lowest[-1], 4)
    found = receptances(model, rows, frequencies, lambda f: scipy.sparse.linalg.spsolve(matrices["stiffness"], f))
    for frequency, h in zip(frequencies, found, strict=True):
        omega = TWO_PI * frequency
        dynamic = (matrices["stiffness"] * (1.0 + 1e-5j * omega) - omega**2 * matrices["mass"]).toarray()
        exact = np.linalg.inv(dynamic)[np.ix_(rows, rows)]
        assert np.abs(h - exact).max() < 2e-4 * np.abs(exact).max()


def test_a_casing_whose_directions_differ_is_refused_with_the_difference():
    matrices, nodes, directions = casing(soft=0.5)
    with pytest.raises(DataError, match=r"at node 0 they differ by \d+(\.\d+)? % of their mean receptance at"):
        stator_model(matrices, table(nodes, directions), "test", contact=0, band=200.0)


@pytest.mark.parametrize("packed", [False, True], ids=["dense", "sparse"])
def test_impossible_stators_are_refused(packed):
    def refused(matrices, nodes, directions, contact=0):
        if packed:
            matrices = {name: scipy.sparse.csc_array(matrix) for name, matrix in matrices.items()}
        with pytest.raises(DataError) as caught:
            stator_model(matrices, table(nodes, directions), "test", contact, band=100.0)
        return str(caught.value)

    matrices, nodes, directions = rotor(cross=1e6)
    del matrices["gyroscopic"]
    assert "the stiffness is not symmetric" in refused(matrices, nodes, directions)
    matrices, nodes, directions = rotor()
    assert "a stator has no gyroscopic matrix" in refused(matrices, nodes, directions)
    matrices, nodes, directions = casing()
    feetless = {**matrices, "stiffness": matrices["stiffness"] - matrices["stiffness"]}
    assert "fix its feet" in refused(feetless, nodes, directions) or "neither" in refused(feetless, nodes, directions)
    assert "no node 9" in refused(matrices, nodes, directions, contact=9)
    assert "the damping is indefinite" in refused({**matrices, "damping": -matrices["damping"]}, nodes, directions)


def test_a_stator_whose_directions_are_coupled_to_nothing_else_gets_complex_coordinates():
    matrices, nodes, directions = rotor(bearing=((1e7, 2e7), (1e7, 1e7)))
    del matrices["gyroscopic"]
    model = stator_model(matrices, table(nodes, directions), "test", contact="disc", band=100.0)
    assert model.n == 14 and not model.isotropic and not model.gyroscopic.any()


def test_a_solid_casing_in_millimetres_is_noticed():
    """Without rotations only stiffness and mass of its elements tell; a user who knows better says so."""
    matrices, nodes, directions = cylinder(6, 8)
    options = {"contact": int(nodes[-1]), "band": 100.0}
    model = stator_model(matrices, table(nodes, directions), "test", **options)
    assert model.is_sparse and model.n == 435
    in_mm = {name: 1e-3 * matrix for name, matrix in matrices.items()}  # N/mm and tonnes
    with pytest.raises(DataError, match="too soft for their mass: if the units are millimetres"):
        stator_model(in_mm, replace(table(nodes, directions), position={}), "test", **options)
    turned = stator_model(in_mm, table(nodes, directions), "test", **options, units="mm")
    assert abs(turned.stiffness - model.stiffness).max() < 1e-9 * abs(model.stiffness).max()
    assert abs(stator_model(in_mm, table(nodes, directions), "test", **options, units="m").mass - in_mm["mass"]).max() == 0.0


def test_damping_that_is_no_share_of_mass_and_stiffness_is_looked_at_too():
    matrices, nodes, directions = casing()
    matrices["damping"] = np.diag(np.arange(15.0))  # dampers
    assert stator_model(matrices, table(nodes, directions), "test", contact=0, band=1.0).damping[14, 14] == 14.0
    matrices["damping"][2, 5] = matrices["damping"][5, 2] = 50.0
    with pytest.raises(DataError, match="the damping is indefinite"):
        stator_model(matrices, table(nodes, directions), "test", contact=0, band=1.0)
