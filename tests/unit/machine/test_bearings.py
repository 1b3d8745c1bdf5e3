"""Bearings that a scene adds at nodes of a model."""

import numpy as np
import pytest

import rsc
from fe_bodies import rotor
from rsc.machine.imports.bearings import Bearing, with_bearings
from rsc.machine.imports.build import rotor_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.imports.store import save_model
from rsc.machine.model.model import FiniteElementModel
from rsc.system.assemble import assemble

FREE = ((0.0, 0.0), (0.0, 0.0))
SCENE = """
[rotor]
model = "machine"
file = "rotor.npz"
{rotor}
[stator]
model = "rigid"
[contact]
gap = 1e-4
friction = 0.2
stiffness = 2e7
[drive]
speed = [0.0, 30.0]
duration = 0.2
"""
ENDS = [(0, (3e6, 2e5, -4e5, 5e6), (300.0, 10.0, -20.0, 500.0)), (6, (4e6, 0.0, 0.0, 4e6), (0.0,) * 4)]


def model(bearings=(), packed=False, **options) -> FiniteElementModel:
    """The shaft of `fe_bodies` without bearings, or with these in its real matrices."""
    matrices, nodes, directions = rotor(bearing=FREE, **options)
    for node, stiffness, damping in bearings:
        rows = 6 * node + np.arange(2)
        matrices["stiffness"][np.ix_(rows, rows)] += np.reshape(stiffness, (2, 2))
        matrices["damping"][np.ix_(rows, rows)] += np.reshape(damping, (2, 2))
    table = Coordinates(nodes, directions, {"left": 0}, {i: i / 6 for i in range(7)})
    if packed:
        import scipy.sparse

        matrices = {name: scipy.sparse.csc_array(matrix) for name, matrix in matrices.items()}
    return rotor_model(matrices, table, "a shaft", units="m", free=not bearings)


def scene_with(folder, body, rotor_keys="", contact=3):
    save_model(body, folder / "rotor.npz")
    (folder / "scene.toml").write_text(SCENE.format(rotor=f"contact = {contact}\n{rotor_keys}"))
    return rsc.load_scene(folder / "scene.toml")


@pytest.mark.parametrize("packed", [False, True], ids=["dense", "sparse"])
def test_they_are_those_of_the_matrices(packed):
    """Also cross-coupled and unequal ones."""
    own, added = model(ENDS, packed), with_bearings(model(packed=packed), [Bearing(*one) for one in ENDS])
    assert model(packed=packed).free and not added.free
    for name in ("stiffness", "damping", "skew_stiffness", "skew_damping", "anisotropic_stiffness", "anisotropic_damping"):
        one, other = (matrix.toarray() if packed else matrix for matrix in (getattr(own, name), getattr(added, name)))
        assert np.abs(one - other).max() <= 1e-12 * np.abs(one).max(), name


def test_a_scene_with_them_is_that_of_the_matrices(tmp_path):
    lines = "bearings = [[\"left\", [3e6, 2e5, -4e5, 5e6], [300, 10, -20, 500]], [6, 4e6]]"
    (tmp_path / "a").mkdir(), (tmp_path / "b").mkdir()
    own, added = scene_with(tmp_path / "a", model(ENDS)), scene_with(tmp_path / "b", model(), lines)
    assert own.rotor.n_coordinates == added.rotor.n_coordinates
    whirls = [rsc.predict(scene, 20.0) for scene in (own, added)]
    assert [w.frequency for w in whirls[0]] == pytest.approx([w.frequency for w in whirls[1]], rel=1e-6)
    assert [w.mirror.share for w in whirls[0]] == pytest.approx([w.mirror.share for w in whirls[1]], rel=1e-5)
    # a result holds the reduced body, and needs neither file nor bearings
    assert rsc.Scene.from_toml(added.to_toml()) == added


def test_a_stiff_shaft_on_soft_bearings_has_the_frequencies_of_the_closed_form(tmp_path):
    """sqrt(2 k / m) and sqrt(2 k (L/2)^2 / J) of a rigid body, and the damping c / k omega^2 / 2."""
    k, c, length = 2e3, 0.5, 0.3
    body = model(total=length)
    system = assemble(scene_with(tmp_path, body, f"bearings = [[0, {k}, {c}], [6, {k}, {c}]]", contact=1))
    state = np.block([
        [np.zeros_like(system.rotor.mass), np.eye(system.n_rotor)],
        [-np.linalg.solve(system.rotor.mass, system.rotor.stiffness), -np.linalg.solve(system.rotor.mass, system.rotor.damping)],
    ])
    values = np.linalg.eigvals(state)
    values = values[values.imag > 0.0]
    moving, place = (body.kind == "displacement").astype(float), np.arange(7) / 6 * length - length / 2
    arm = np.where(body.kind == "tilt", 1.0, 0.0)
    arm[body.kind == "displacement"] = place
    for omega in (np.sqrt(2 * k / (moving @ body.mass @ moving)), np.sqrt(2 * k * (length / 2) ** 2 / (arm @ body.mass @ arm))):
        nearest = values[np.argmin(abs(values.imag - omega))]
        assert nearest.imag == pytest.approx(omega, rel=2e-3)
        assert nearest.real == pytest.approx(-0.5 * c / k * omega**2, rel=5e-3)


REFUSED = {
    "": "bearings are missing; without them contacts at two or more places must hold the rotor: 1 rigid-body or other motions",
    "bearings = [[3, 1e7]]": "at two or more places must hold the rotor: 1 rigid-body or other motions have no stiffness",
    "bearings = [[0, 1e7], [99, 1e7]]": "no node 99",
    "bearings = [[0, 1e7], [6, -1e9]]": "indefinite",
    "bearings = [[0]]": "rotor.bearings[0] = [0]: must be a list of [node, stiffness in N/m]",
    "bearings = [[0, [1, 2, 3]]]": "rotor.bearings[0][1] = [1, 2, 3]: must be a number in N/m, or [yy, yz, zy, zz]",
    "bearings = [[0, \"1 kg\"]]": "rotor.bearings[0][1] = '1 kg'",
    "bearings = [[1.5, 1e7]]": "rotor.bearings[0][0] = 1.5: must be a node, number or name",
    "bearings = 7": "rotor.bearings = 7: must be a list",
}


@pytest.mark.parametrize("keys", REFUSED)
def test_what_cannot_be_is_refused_in_one_line(keys, tmp_path):
    with pytest.raises(rsc.SceneError) as caught:
        scene_with(tmp_path, model(), keys)
    assert REFUSED[keys] in str(caught.value) and "\n" not in str(caught.value)
