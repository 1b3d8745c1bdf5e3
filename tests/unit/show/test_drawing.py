"""The drawing of a shaft by its stations, and the shapes of its modes."""

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.machine.model.modes import slowest_shapes
from rsc.scene.files.templates import template
from rsc.show.pictures.drawing import drawing, shapes


@pytest.fixture(scope="module")
def rig():
    return rsc.Scene.from_toml(template("rig"))


def test_every_station_is_drawn_where_it_is(rig):
    traces = drawing(rig)["data"]
    of = {name: [trace for trace in traces if trace["name"] == name] for name in ("shaft", "disk", "bearing", "contact")}
    assert of["shaft"][0]["x"] == [0.0, 0.0, 560.0, 560.0] and of["shaft"][0]["y"] == [0.0, 5.0, 5.0, 0.0]
    assert [trace["x"][0] for trace in of["disk"]] == [187.5, 187.5, 347.5, 347.5] and max(of["disk"][0]["y"]) == 37.5
    assert of["bearing"][0]["x"] == [40.0, 520.0] and of["bearing"][0]["text"] == ["motor_side", "free_side"]
    assert of["contact"][0]["x"] == [280.0] and of["contact"][0]["y"] == [5.0]


def test_shapes_have_the_sense_of_their_modes_at_every_node(rig):
    """The first pair bends once between the bearings; its backward mode is red at all nodes, its forward mode blue."""
    model = rig.reductions[0].model
    found = slowest_shapes(model, 20.0, 2)
    for (mode, _), picture in zip(found, shapes(model, found), strict=True):
        assert [trace["name"] for trace in picture["data"][2:]] == ["forward" if mode.frequency > 0.0 else "backward"]
        bent = np.array(picture["data"][0]["y"])
        assert np.abs(bent).max() == pytest.approx(1.0) and np.count_nonzero(np.diff(np.sign(bent[np.abs(bent) > 0.05]))) == 2


def test_nodes_may_whirl_against_each_other():
    """The fan's supports are stiffer in z: one of its slowest modes has forward and backward nodes, as `rsc modes` says."""
    scene = rsc.Scene.from_toml(template("fan"))
    assert "mixed" in [mode.sense for mode in rsc.modes(scene, 16.5).rotor[:6]]
    model = scene.reductions[0].model
    pictures = shapes(model, slowest_shapes(model, 16.5, 6))
    assert any(len(picture["data"]) == 4 for picture in pictures)


def test_the_command_draws_a_shaft_and_nothing_else(tmp_path, capsys):
    (tmp_path / "rig.toml").write_text(template("rig"))
    (tmp_path / "laval.toml").write_text(template("laval"))
    assert main(["modes", str(tmp_path / "rig.toml"), "-o", str(tmp_path / "rig.png")]) == 0
    assert (tmp_path / "rig.png").read_bytes()[:4] == b"\x89PNG"
    assert main(["modes", str(tmp_path / "laval.toml"), "-o", str(tmp_path / "laval.png")]) == 2
    assert "a scene with a shaft model" in capsys.readouterr().err and not (tmp_path / "laval.png").exists()
    assert drawing(rsc.Scene.from_toml(template("laval"))) is None
