"""ROSS's own model file into a shaft by its stations: the matrices of ROSS, tables over the speed, and what is refused."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.errors import DataError
from rsc.machine.imports.ross import read_ross
from rsc.machine.shaft.assembly import model_of
from rsc.machine.shaft.ross_model import shaft_of

DATA = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists()) / "data" / "reference"
SHAFT = """
["ShaftElement_ShaftElement {n}"]
L = 0.25
idl = 0.0
odl = 0.05
idr = 0.0
odr = 0.05
n = {n}
shear_effects = true
tag = "ShaftElement {n}"
[ "ShaftElement_ShaftElement {n}".material]
name = "Steel"
rho = 7810.0
E = 211000000000.0
G_s = 81200000000.0
"""
DISK = """
["DiskElement_Disk {i}"]
n = {n}
m = 32.58972765304033
Id = 0.17808928257067666
Ip = 0.32956362089137037
tag = "Disk {i}"
"""
BEARING = '["BearingElement_Bearing {i}"]\nn = {n}\nkxx = [1e6]\nkyy = [8e5]\ncxx = [0.0]\ntag = "Bearing {i}"\n'
MODEL = 'ross_version = "2.3.0"\n[parameters]\n' + "".join(SHAFT.format(n=n) for n in range(6))
MODEL += DISK.format(i=0, n=2) + DISK.format(i=1, n=4) + BEARING.format(i=0, n=0) + BEARING.format(i=1, n=6)


def test_the_rotor_of_the_tutorial_has_the_matrices_of_ross():
    shaft, notes = shaft_of(tomllib.loads(MODEL), "model.toml")
    model, reference = model_of(shaft, shaft.stations, "model"), read_ross(DATA / "machines" / "ross_rotor.mat")
    assert not notes
    for name in ("mass", "stiffness", "gyroscopic", "anisotropic_stiffness"):
        own, other = getattr(model, name), getattr(reference, name)
        assert abs(own - other).max() < 1e-9 * abs(other).max()


def test_the_command_writes_a_scene_that_loads_with_the_same_matrices(tmp_path, capsys):
    (tmp_path / "model.toml").write_text(MODEL)
    out = tmp_path / "scene.toml"
    assert main(["import", "ross", str(tmp_path / "model.toml"), "-o", str(out), "--contact", "3"]) == 0
    assert "6 sections and 6 elements" in capsys.readouterr().out
    scene, reference = rsc.load_scene(out), read_ross(DATA / "machines" / "ross_rotor.mat")
    assert scene.reductions[0].model.stiffness == pytest.approx(reference.stiffness, rel=1e-9, abs=1e-3)
    assert scene.reductions[0].model.names["Disk 0"] == 2 and scene.contact.diameter == 0.05
    out.write_text("mine")
    assert main(["import", "ross", str(tmp_path / "model.toml"), "-o", str(out), "--contact", "3"]) == 4
    assert "did not write that file" in capsys.readouterr().err and out.read_text() == "mine"


def test_sleeves_and_coefficients_over_the_speed(tmp_path):
    second, follows = SHAFT.format(n=2), BEARING.format(i=2, n=5)
    for old, new in (("ShaftElement 2", "Sleeve"), (" = 0.05", " = 0.09"), (" = 0.0\n", " = 0.05\n"), ("211000", "81200")):
        second = second.replace(old, new)
    for old, new in (("[1e6]", "[1e5, 3e5]"), ("[8e5]", "[1e5, 3e5]"), ("[0.0]", "[10.0, 30.0]")):
        follows = follows.replace(old, new)
    (tmp_path / "model.toml").write_text(MODEL + second + follows + "frequency = [100.0, 300.0]\n")
    out = tmp_path / "scene.toml"
    assert main(["import", "ross", str(tmp_path / "model.toml"), "-o", str(out), "--contact", "2,3,0.5"]) == 0
    model = rsc.load_scene(out).reductions[0].model
    assert model.position[model.names["0.625 m"]] == 0.625 and model.knots is not None
    i = int(np.flatnonzero(model.row_at("Bearing 2"))[0])
    slow, fast = (model.at_speed(speed / (2.0 * np.pi)).stiffness[i, i] for speed in (100.0, 200.0))
    assert fast - slow == pytest.approx(1e5, rel=1e-6)
    assert model.diameter_at("0.625 m") == 0.09


@pytest.mark.parametrize(
    "text, problem",
    [
        ("a = 1\n", "needs shaft elements and bearings"),
        (MODEL + '["GearElement_Gear"]\nn = 2\n', "GearElement_Gear: only shaft elements, disks, bearings and seals"),
        (MODEL.replace("n = 3\n", "n = 9\n"), "are not contiguous"),
        (MODEL.replace("L = 0.25", "L = 0.0", 1), "ShaftElement 0: its length, diameters or moduli are impossible"),
        (MODEL.replace("m = 32", 'm = "32"\nx = 32', 1), "Disk 0: its m must be a number"),
        (MODEL + BEARING.format(i=3, n=7), "Bearing 3: it must be between a node of the shaft and ground"),
        (MODEL + BEARING.format(i=3, n=3) + "n_link = 8\n", "Bearing 3: it must be between"),
        (MODEL.replace("kxx = [1e6]", "kxx = [1e6, 2e6]", 1), "its coefficients do not match its 1 frequencies"),
        (MODEL.replace("shear_effects = true", "shear_effects = false", 1), "shear or damping of its shaft elements differ"),
    ],
)
def test_what_cannot_be_stations_is_refused(text, problem):
    with pytest.raises(DataError, match=problem):
        shaft_of(tomllib.loads(text), "model.toml")


def test_what_is_left_out_is_told():
    _, notes = shaft_of(tomllib.loads(MODEL.replace("n = 1\n", "n = 1\naxial_force = 5.0\n", 1) + "mxx = [3.0]\n"), "model.toml")
    assert notes == ["axial forces of shaft elements are left out.", "added masses of bearings and seals are left out."]


def test_options_that_a_model_file_answers_are_refused(tmp_path, capsys):
    (tmp_path / "model.toml").write_text(MODEL)
    command = ["import", "ross", str(tmp_path / "model.toml"), "-o", str(tmp_path / "s.toml"), "--contact"]
    assert main([*command, "3", "--speed", "10"]) == 2 and "--speed" in capsys.readouterr().err
    assert main([*command, "77"]) == 4 and "no node 77 (nodes 0 to 6)" in capsys.readouterr().err
    assert main([*command[:3], "-o", str(tmp_path / "s.npz"), "--contact", "3"]) == 4 and not (tmp_path / "s.toml").exists()
