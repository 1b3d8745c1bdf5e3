"""`rsc import`: from the files of other programs to a scene that runs."""

import csv

import numpy as np
import pytest
import scipy.io

import rsc
from fe_bodies import casing, rotor
from rsc.cli import main
from systems import REFERENCE

ROSS = REFERENCE / "machines" / "ross_coaxrotor.mat"


def written_fe(folder, body):
    """Matrix Market files and the coordinate table of a body (matrices, nodes, directions)."""
    matrices, nodes, directions = body
    for name, matrix in matrices.items():
        scipy.io.mmwrite(folder / f"{name}.mtx", matrix)
    with open(folder / "table.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("node", "direction"))
        short = {"z": "other", "rz": "other"}
        writer.writerows((node, short.get(direction, direction)) for node, direction in zip(nodes, directions, strict=True))
    return [f"--{name}={folder / name}.mtx" for name in matrices] + ["--coordinates", str(folder / "table.csv")]


def test_a_rotor_of_ross_becomes_a_scene_that_runs(tmp_path, capsys):
    scene = tmp_path / "coax.toml"
    assert main(["import", "ross", str(ROSS), "-o", str(scene), "--contact", "5"]) == 0
    assert f"written: {scene}" in capsys.readouterr().out
    loaded = rsc.load_scene(scene)
    assert loaded.rotor.coordinates_before == 38 and loaded.rotor.n_coordinates < 20
    assert main(["predict", str(scene), "--speed", "600 rpm"]) == 0
    assert "the rotor is reduced from 38 to" in capsys.readouterr().out
    assert rsc.simulate(loaded.with_values({"drive.duration": 0.1})).status == "finished"


def test_matrices_with_a_table_become_a_scene(tmp_path, capsys):
    files = written_fe(tmp_path, rotor())
    scene = tmp_path / "shaft.toml"
    assert main(["import", "fe", *files, "-o", str(scene), "--contact", "2,3,0.5", "--unbalance", "3"]) == 0
    loaded = rsc.load_scene(scene)
    assert "contact at ['2', '3', 0.5]" in loaded.rotor.origin or "[2, 3, 0.5]" in loaded.rotor.origin


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


def test_a_scene_that_was_not_imported_is_not_replaced(tmp_path, capsys):
    (tmp_path / "out.toml").write_text("title = 'mine'")
    assert main(["import", "ross", str(ROSS), "-o", str(tmp_path / "out.toml"), "--contact", "5"]) == 4
    assert "another kind" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["out.toml"] and (tmp_path / "out.toml").read_text() == "title = 'mine'"
