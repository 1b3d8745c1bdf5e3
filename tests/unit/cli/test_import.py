"""`rsc import`: from the files of other programs to a scene that runs."""

import re
import tracemalloc

import numpy as np
import pytest
import scipy.io
import scipy.linalg

import rsc
from fe_bodies import casing, rotor
from matrix_writers import written_fe
from rsc.cli import main
from systems import REFERENCE

ROSS = REFERENCE / "machines" / "ross_coaxrotor.mat"


def test_a_rotor_of_ross_becomes_a_scene_that_runs(tmp_path, capsys):
    scene = tmp_path / "coax.toml"
    assert main(["import", "ross", str(ROSS), "-o", str(scene), "--contact", "5"]) == 0
    assert f"written: {scene}" in capsys.readouterr().out
    loaded = rsc.load_scene(scene)
    assert loaded.rotor.coordinates_before == 38 and loaded.rotor.n_coordinates < 20
    assert main(["predict", str(scene), "--speed", "300 rpm"]) == 0
    assert "the rotor is reduced from 38 to" in capsys.readouterr().out
    assert rsc.simulate(loaded.with_values({"drive.duration": 0.1})).status == "finished"


def test_matrices_with_a_table_become_a_scene(tmp_path, capsys):
    files = written_fe(tmp_path, rotor())
    scene = tmp_path / "shaft.toml"
    assert main(["import", "fe", *files, "-o", str(scene), "--contact", "2,3,0.5", "--unbalance", "3"]) == 0
    loaded = rsc.load_scene(scene)
    assert "contact at ['2', '3', 0.5]" in loaded.rotor.origin or "[2, 3, 0.5]" in loaded.rotor.origin


def test_a_free_rotor_becomes_a_scene_with_bearings(tmp_path, capsys):
    files = written_fe(tmp_path, rotor(bearing=((0.0, 0.0), (0.0, 0.0))))
    command = ["import", "fe", *files, "-o", str(tmp_path / "shaft.toml"), "--contact", "3"]
    assert main(command) == 4
    error = capsys.readouterr().err
    assert "bearings are missing (rsc import --bearings adds them): 2 rigid-body" in error and error.count("\n") == 1
    assert main([*command, "--bearings", "0", "6"]) == 0
    scene = rsc.load_scene(tmp_path / "shaft.toml")
    assert "bearings = [[0, " in (tmp_path / "shaft.toml").read_text() and scene.rotor.n_coordinates > 2
    assert main(["predict", str(tmp_path / "shaft.toml"), "--speed", "20"]) == 0


@pytest.mark.parametrize("number", range(8))
def test_remarks_of_an_import_are_those_of_its_own_modes(tmp_path, capsys, number):
    """Random supports, of one stiffness or two, damped in the matrices, in what rotates, or not at all."""
    rng, kind = np.random.default_rng(number), ("none", "damping", "rotating-damping")[number % 3]
    each = [tuple(10.0 ** rng.uniform(4.0, 8.0, 2)) if number % 2 else (10.0 ** rng.uniform(4.0, 8.0),) * 2 for _ in range(2)]
    matrices, nodes, directions = rotor(n_elements=4, bearing=tuple(each))
    damped = 1e-4 * matrices["stiffness"]
    matrices["damping"] = damped if kind == "damping" else 0.0 * damped
    files = written_fe(tmp_path, (matrices, nodes, directions))
    if kind == "rotating-damping":
        scipy.io.mmwrite(tmp_path / "turning.mtx", 1e-5 * (rotor(n_elements=4)[0]["mass"]))
        files.append(f"--rotating-damping={tmp_path / 'turning.mtx'}")
    assert main(["import", "fe", *files, "-o", str(tmp_path / "s.toml"), "--contact", "2"]) == 0
    told = capsys.readouterr().out
    own = np.isin(directions, ["x", "y", "rx", "ry"])
    stiffness, mass = (matrices[name][np.ix_(own, own)] for name in ("stiffness", "mass"))
    slowest = np.sqrt(scipy.linalg.eigvalsh(stiffness, mass)[0]) / (2.0 * np.pi)
    first = float(re.search(r"of the full model: ([0-9.e+]+) Hz", told)[1])
    assert first == pytest.approx(slowest, rel=2e-2)
    assert (kind == "none") == ("nothing damps the 4 lowest modes" in told) == ("undamped" in told)


def test_a_casing_becomes_a_stator(tmp_path, capsys):
    matrices, nodes, directions = casing()
    files = written_fe(tmp_path, ({k: v for k, v in matrices.items() if k != "gyroscopic"}, nodes, directions))
    path = tmp_path / "casing.npz"
    assert main(["import", "fe", *files, "--stator", "-o", str(path), "--contact", "0"]) == 0
    table = capsys.readouterr().out.partition("[stator]")[2]
    scene = tmp_path / "scene.toml"
    assert main(["import", "ross", str(ROSS), "-o", str(scene), "--contact", "5"]) == 0
    head, _, rest = scene.read_text().partition("[stator]")
    scene.write_text(head + "[stator]" + table + rest[rest.index("[contact]") :])
    loaded = rsc.load_scene(scene)
    assert loaded.stator.model == "reduced" and np.isfinite(loaded.stator.error) and len(loaded.reductions) == 2


@pytest.mark.parametrize(
    "arguments, problem",
    [
        (["ross", str(ROSS), "--contact", "99"], "no node 99"),
        (["ross", str(REFERENCE / "laval.toml"), "--contact", "1"], "laval.toml"),
        (["ross", "nowhere.mat", "--contact", "1"], "nowhere.mat"),
        (["fe", "--mass", "nowhere.mtx", "--stiffness", "nowhere.mtx", "--contact", "1"], "nowhere.mtx"),
    ],
)
def test_what_cannot_be_imported_is_refused_in_one_line_and_leaves_nothing(tmp_path, capsys, arguments, problem):
    assert main(["import", *arguments, "-o", str(tmp_path / "out.toml")]) != 0
    error = capsys.readouterr().err
    assert problem in error and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def changed(name, change):
    """A matrix file of the rotor, its matrix changed."""

    def apply(folder, matrices):
        scipy.io.mmwrite(folder / f"{name}.mtx", change(matrices[name].copy()))

    return apply


def entry(i, j, value):
    def change(matrix):
        matrix[i, j] = value
        return matrix

    return change


def rewritten(old, new):
    """The coordinate table with a text replaced."""

    def apply(folder, matrices):
        table = folder / "table.csv"
        text = table.read_text()
        assert old in text
        table.write_text(text.replace(old, new, 1))

    return apply


def announced(folder, matrices):
    """Ten million degrees of freedom in a small file."""
    head = "%%MatrixMarket matrix coordinate real symmetric\n"
    (folder / "stiffness.mtx").write_text(head + "10000000 10000000 1\n1 1 1.0\n")


BAD = {  # what is wrong with the files, more arguments, words of the refusal
    "a table one row short": (rewritten("6,y\n", ""), [], "but the table has 41 rows"),
    "a node twice": (rewritten("1,x", "0,x"), [], "direction x of node 0 occurs twice"),
    "no such direction": (rewritten("1,x", "1,q"), [], "direction"),
    "a direction without its partner": (rewritten("1,y", "1,other"), [], "node 1 has direction x but not y"),
    "an unsymmetric stiffness": (changed("stiffness", entry(0, 6, 1e3)), [], "the stiffness is not symmetric"),
    "an indefinite mass": (changed("mass", np.negative), [], "the mass matrix is indefinite"),
    "an indefinite stiffness": (changed("stiffness", lambda k: k - 1e7 * np.eye(42)), [], "the stiffness is indefinite"),
    "free motions": (changed("stiffness", lambda k: k - free(k)), [], ": 2 rigid-body or other motions have no stiffness"),
    "a crosswise mass": (changed("mass", lambda m: entry(0, 1, 0.1)(entry(1, 0, -0.1)(m))), [], "the mass matrix"),
    "a symmetric gyroscopic matrix": (changed("gyroscopic", np.abs), [], "gyroscopic matrix"),
    "coupling with the axial motion": (changed("stiffness", lambda k: entry(0, 2, 1e5)(entry(2, 0, 1e5)(k))), [], "couples"),
    "nan": (changed("stiffness", entry(3, 3, np.nan)), [], "an entry of stiffness is nan or infinite"),
    "infinity": (changed("mass", entry(3, 3, np.inf)), [], "an entry of mass is nan or infinite"),
    "complex entries": (changed("mass", lambda m: m + 1j), [], "complex"),
    "a matrix that is not square": (changed("damping", lambda c: c[:, :-1]), [], "damping"),
    "ten million degrees of freedom": (announced, [], "at most 2000000 coordinates are read"),
    "a share beyond the way": (None, ["--contact", "2,3,1.5"], "fraction 1.5: must be from 0 to 1"),
    "a place of two nodes": (None, ["--contact", "2,3"], "2,3"),
    "an unbalance at no node": (None, ["--unbalance", "77"], "no node 77"),
}


def free(stiffness):
    """What the bearings add: the diagonal entries that hold a straight motion of the shaft."""
    held, translation = np.zeros_like(stiffness), np.tile([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], len(stiffness) // 6)
    along_x = np.flatnonzero(np.abs(stiffness @ translation) > 1.0)
    for i in along_x:
        held[i, i] = held[i + 1, i + 1] = (stiffness @ translation)[i]
    return held


@pytest.mark.parametrize("kind", BAD)
def test_bad_files_are_refused_in_one_line_and_leave_nothing(tmp_path, capsys, kind):
    change, more, problem = BAD[kind]
    files = written_fe(tmp_path, rotor())
    if change is not None:
        change(tmp_path, rotor()[0])
    there = sorted(tmp_path.iterdir())
    tracemalloc.start()
    try:
        code = main(["import", "fe", *files, "-o", str(tmp_path / "out.toml"), "--contact", "2", *more])
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    error = capsys.readouterr().err
    assert code == (2 if "--unbalance" in more else 4)  # a scene that cannot be, or a file
    assert problem in error and error.startswith("error: ") and error.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == there and peak < 50e6


def test_a_share_of_the_way_must_be_a_number(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["import", "ross", str(ROSS), "-o", str(tmp_path / "out.toml"), "--contact", "2,3,half"])
    told = "2,3,half: the fraction of the distance must be a number from 0 to 1"
    assert ended.value.code == 2 and told in capsys.readouterr().err


def test_millimetres_and_tonnes_are_noticed(tmp_path, capsys):
    matrices, nodes, directions = rotor(n_elements=12)
    tilts = np.isin(directions, ("rx", "ry", "rz"))
    scale = np.diag(np.where(tilts, 1e3, 1.0))  # N mm/rad and N/mm, tonnes
    in_mm = {name: 1e-3 * scale @ matrix @ scale for name, matrix in matrices.items()}
    files = written_fe(tmp_path, (in_mm, nodes, directions))
    there = sorted(tmp_path.iterdir())
    arguments = ["import", "fe", *files, "-o", str(tmp_path / "out.toml"), "--contact", "2"]
    assert main(arguments) == 4
    assert "units mm" in capsys.readouterr().err and sorted(tmp_path.iterdir()) == there
    assert main([*arguments, "--units", "mm"]) == 0


def test_a_tolerance_that_cannot_be_met_is_refused_in_one_line(tmp_path, capsys):
    scene = tmp_path / "coax.toml"
    assert main(["import", "ross", str(ROSS), "-o", str(scene), "--contact", "5"]) == 0
    capsys.readouterr()
    for tolerance, problem in (("1e-10", "tolerance = 1e-10 cannot be met"), ("1e-12", "must be"), ("nan", "must be")):
        scene.write_text(re.sub(r"tolerance = \S+", f"tolerance = {tolerance}", scene.read_text()))
        assert main(["predict", str(scene), "--speed", "10"]) == 2
        error = capsys.readouterr().err
        assert problem in error and error.count("\n") == 1


def test_a_scene_that_was_not_imported_is_not_replaced(tmp_path, capsys):
    (tmp_path / "out.toml").write_text("title = 'mine'")
    assert main(["import", "ross", str(ROSS), "-o", str(tmp_path / "out.toml"), "--contact", "5"]) == 4
    assert "did not write" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["out.toml"] and (tmp_path / "out.toml").read_text() == "title = 'mine'"
