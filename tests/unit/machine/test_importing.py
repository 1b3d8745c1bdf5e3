"""From files to a model: every format gives the same rotor, labels stand for a table, the matrix meant is found or asked for."""

import numpy as np
import pytest
import scipy.io
import scipy.sparse

from fe_bodies import casing, rotor
from matrix_writers import WRITERS
from rsc.errors import DataError
from rsc.machine.formats import read_matrices
from rsc.machine.imports.importing import import_fe

EXACT = [name for name in WRITERS if name not in ("DMIG, small", "DMIG, wide")]  # the others round to 3 and 10 digits


def symmetric_rotor():
    """Mass and stiffness of the rotor, whose rows are those of `matrix_writers.labels`, node 10 first."""
    matrices, nodes, directions = rotor(n_elements=4)
    return matrices, nodes + 10, directions


def write_table(folder, nodes, directions):
    lines = [f"{node},{direction},{'disc' if node == 12 else ''}" for node, direction in zip(nodes, directions, strict=True)]
    (folder / "table.csv").write_text("node,direction,name\n" + "\n".join(lines) + "\n")
    return folder / "table.csv"


def written(folder, kind, matrices):
    """Paths of mass and stiffness in one format."""
    name, write, *_ = WRITERS[kind]
    paths = {}
    for role in ("mass", "stiffness"):
        (folder / role).mkdir()
        paths[role] = folder / role / name
        write(paths[role], matrices[role])
    return paths


@pytest.mark.parametrize("kind", EXACT)
def test_every_format_gives_the_same_rotor(kind, tmp_path):
    matrices, nodes, directions = symmetric_rotor()
    paths = written(tmp_path, kind, matrices)
    key = WRITERS[kind][2] if kind.startswith("MAT") else None
    wanted = {role: (path, key) if key else path for role, path in paths.items()}
    model = import_fe(**wanted, coordinates=write_table(tmp_path, nodes, directions), contact="disc", speed=20.0)
    assert model.n == 10 and model.names == {"disc": 12} and model.speed == 20.0 and model.isotropic
    i = np.flatnonzero(np.isin(directions, ("x", "ry")))  # in this order also in the model
    stiffness = model.stiffness.toarray() if model.is_sparse else model.stiffness
    assert np.allclose(stiffness, matrices["stiffness"][np.ix_(i, i)], rtol=1e-12, atol=1e-3)
    assert "no gyroscopic matrix" in model.notes[-1]


@pytest.mark.parametrize("kind", ["DMIG, wide", "DMIG, free", "Abaqus, labels", "CalculiX"])
def test_labels_stand_for_a_table(kind, tmp_path):
    matrices, _, _ = symmetric_rotor()
    model = import_fe(**written(tmp_path, kind, matrices), contact=12)
    assert model.n == 10 and set(model.node.tolist()) == {10, 11, 12, 13, 14}
    assert np.count_nonzero(model.row_at(12)) == 1


def test_rows_that_only_the_stiffness_has_carry_no_mass(tmp_path):
    """A lumped mass without rotary inertia: Abaqus and DMIG leave those rows out of the mass matrix."""
    matrices, _, _ = symmetric_rotor()
    turning = np.isin(np.arange(30) % 6, (3, 4, 5))
    matrices["mass"] = np.diag(np.where(turning, 0.0, np.diag(matrices["mass"])))
    model = import_fe(**written(tmp_path, "Abaqus, labels", matrices))
    assert model.n == 10 and np.array_equal(model.mass.diagonal() == 0.0, model.kind == "tilt")


def test_the_matrix_meant_is_found_by_its_customary_name_or_asked_for(tmp_path):
    matrices, nodes, directions = symmetric_rotor()
    table, path = write_table(tmp_path, nodes, directions), tmp_path / "model.mat"
    scipy.io.savemat(path, {"model": {"M": matrices["mass"], "K": matrices["stiffness"], "G": matrices["gyroscopic"]}})
    model = import_fe(path, path, gyroscopic=path, coordinates=table)
    assert model.gyroscopic[5, 5] > 0.05
    with pytest.raises(DataError, match=r"which matrix is the damping\? It has model.G, model.K, model.M; name one"):
        import_fe(path, path, path, coordinates=table)
    with pytest.raises(DataError, match=r"which matrix is the mass matrix\?"):
        import_fe((path, "model.X"), path, coordinates=table)


def test_a_table_is_asked_for_and_must_fit(tmp_path):
    matrices, nodes, directions = symmetric_rotor()
    paths = written(tmp_path, "npz", matrices)
    with pytest.raises(DataError, match="a coordinate table is needed"):
        import_fe(**paths)
    with pytest.raises(DataError, match="has size 30x30 but the table has 24 rows"):
        import_fe(**paths, coordinates=write_table(tmp_path, nodes[:24], directions[:24]))
    labelled = tmp_path / "labelled"
    labelled.mkdir()
    with pytest.raises(DataError, match="are not those of the files' rows"):
        import_fe(**written(labelled, "CalculiX", matrices), coordinates=write_table(tmp_path, nodes + 1, directions))


def test_a_stator_needs_its_contact_and_gets_one_direction(tmp_path):
    matrices, nodes, directions = casing()
    paths = {}
    for role in ("mass", "stiffness"):
        paths[role] = tmp_path / f"{role}.npz"
        scipy.sparse.save_npz(paths[role], scipy.sparse.csc_array(matrices[role]))
    table = write_table(tmp_path, nodes, directions)
    with pytest.raises(DataError, match="needs the node of its contact"):
        import_fe(**paths, coordinates=table, stator=True)
    model = import_fe(**paths, coordinates=table, stator=True, contact=0, band=100.0)
    assert model.is_sparse and model.n == 15 and "up to 100 Hz" in model.notes[0]


def test_an_import_leaves_its_files_as_they_are(tmp_path):
    matrices, nodes, directions = symmetric_rotor()
    paths = written(tmp_path, "Matrix Market, coordinate", matrices)
    before = read_matrices(paths["stiffness"]).matrices["K"].toarray()
    with pytest.raises(TypeError, match="unknown option unit"):
        import_fe(**paths, coordinates=write_table(tmp_path, nodes, directions), unit="mm")
    import_fe(**paths, coordinates=tmp_path / "table.csv")
    assert np.array_equal(read_matrices(paths["stiffness"]).matrices["K"].toarray(), before)
