"""The drawing of a rotor by its stations, and the shapes of its modes: in files, on the page and in Python."""

from dataclasses import replace

import numpy as np
import pytest

import rsc
from rsc.analysis.alone.mode_shapes import shape_of
from rsc.cli import main
from rsc.machine.model.modes import slowest_shapes
from rsc.scene.files.templates import template
from rsc.show.page.svg import svg
from rsc.show.pictures.drawing import drawing
from rsc.show.pictures.plots import save, stacked
from rsc.show.pictures.shapes import oscillating, shape
from shaft_scenes import text


@pytest.fixture(scope="module")
def rig():
    return rsc.Scene.from_toml(template("rig"))


@pytest.fixture(scope="module")
def pump():
    """With disks of known and unknown shape, a bore, a cone, and a clearance."""
    return rsc.Scene.from_toml(text(more='[[clearance]]\nname = "labyrinth"\nat = "impeller"\ngap = "0.3 mm"'))


def named(picture, name):
    return [trace for trace in picture["data"] if trace["name"] == name]


def words(picture):
    """Names in the drawing, with their place."""
    texts = [trace for trace in picture["data"] if trace["mode"] == "text"]
    return {word: x for trace in texts for word, x in zip(trace["text"], trace["x"], strict=True)}


def test_every_station_is_drawn_where_it_is(pump):
    picture = drawing(pump)
    shaft = named(picture, "shaft")
    assert len(shaft) == 1 + 2 + 1  # a section with a bore is cut into two halves
    assert shaft[1]["x"] == [120.0, 420.0, 420.0, 120.0, 120.0] and shaft[1]["y"] == [30.0, 30.0, 10.0, 10.0, 30.0]
    assert shaft[3]["y"] == [30.0, 20.0, -20.0, -30.0, 30.0]  # the cone
    assert named(picture, "disk")[0]["x"][:2] == [385.0, 415.0] and max(named(picture, "disk")[0]["y"]) == 100.0
    assert [trace["x"][0] for trace in named(picture, "bearing")[::2]] == [20.0, 480.0]
    assert max(named(picture, "bearing")[0]["y"]) == -20.0  # below the shaft
    for name, place, radius in (("contact", 330.0, 30.0), ("clearance", 270.0, 30.0)):
        pieces = named(picture, name)
        assert len(pieces) == 2 and np.mean(pieces[0]["x"][:4]) == pytest.approx(place)
        assert min(pieces[0]["y"]) > radius and max(pieces[1]["y"]) < -radius
    assert {"impeller", "drive end", "bearing", "contact 200 um", "labyrinth 300 um"} == set(words(picture))


def test_a_disk_of_unknown_shape_is_a_thin_one_of_its_polar_inertia_at_its_place(pump):
    (upper, lower) = named(drawing(pump), "disk, diameter of its polar inertia")
    radius, width = 1e-3 * max(upper["y"]), np.ptp(upper["x"])
    assert 0.5 * 12.0 * radius**2 == pytest.approx(0.12, rel=1e-4)
    assert 0.0 < width < 5.0 and np.mean(upper["x"][:4]) == pytest.approx(270.0)
    assert lower["line"]["dash"] == "dash"


@pytest.mark.parametrize("kept", [False, True])
def test_an_overhung_disk_with_its_width_is_drawn_beyond_the_end_of_the_shaft(kept):
    scene = rsc.Scene.from_toml(text().replace('at = "270 mm", mass', 'at = "10 mm", width = "60 mm", mass'))
    picture = drawing(rsc.Scene.from_toml(scene.to_toml()) if kept else scene)
    (upper, _) = named(picture, "disk, diameter of its polar inertia")
    assert (min(upper["x"]), max(upper["x"])) == (-20.0, 40.0)
    assert picture["layout"]["xaxis"]["range"][0] < -20.0


@pytest.mark.parametrize("name", ["pump", "fan", "compressor"])
def test_names_overlap_neither_each_other_nor_the_rotor_on_a_narrow_page(name):
    picture = drawing(rsc.Scene.from_toml(template(name)))
    (low, high), height = picture["layout"]["yaxis"]["range"], picture["layout"]["height"] - 58
    left, right = picture["layout"]["xaxis"]["range"]
    boxes = []
    for trace in (trace for trace in picture["data"] if trace["mode"] == "text"):
        for word, x, y in zip(trace["text"], trace["x"], trace["y"], strict=True):
            middle, half = 270.0 * (x - left) / (right - left), 3.2 * len(word)
            boxes.append((middle - half, middle + half, height * (y - low) / (high - low)))
            assert middle - half > -1.0 and middle + half < 271.0, word
    solid = max(max(trace["y"]) for trace in picture["data"] if trace["name"].startswith(("shaft", "disk", "sleeve")))
    reach = height * (solid - low) / (high - low)
    for i, (start, end, y) in enumerate(boxes):
        assert y > reach or y < height - reach + 30.0
        assert all(end <= s or start >= e or abs(y - z) > 12.0 for s, e, z in boxes[:i])


def test_shapes_are_those_of_the_full_model_with_their_senses(rig):
    """Alike up to a factor: the angle between both vectors is 0."""
    modes, full = rsc.modes(rig, 20.0), slowest_shapes(rig.reductions[0].model, 20.0, 8)
    model = rig.reductions[0].model
    rows = np.flatnonzero(model.kind == "displacement")
    order = rows[np.argsort([model.position[node] for node in model.node[rows]])]
    for i in oscillating(modes)[:2]:
        own, (_, vector) = modes.shapes[i], min(full, key=lambda one: abs(one[0].frequency - modes.rotor[i].frequency))
        circle = own.positive if modes.rotor[i].frequency > 0.0 else own.negative
        cosine = abs(np.vdot(circle, vector[order])) / np.linalg.norm(circle) / np.linalg.norm(vector[order])
        assert cosine == pytest.approx(1.0, abs=1e-6)
        assert (own.is_positive[own.size > 0.01] == (modes.rotor[i].frequency > 0.0)).all()
        assert own.size.max() == pytest.approx(1.0) and abs(own.at(0.0)).max() == pytest.approx(1.0)


def test_nodes_may_whirl_against_each_other():
    """The fan's supports are stiffer in z: one of its slowest modes has forward and backward nodes, as `rsc modes` says."""
    modes = rsc.modes(rsc.Scene.from_toml(template("fan")), 16.5)
    mixed = next(i for i, mode in enumerate(modes.rotor) if mode.sense == "mixed")
    picture = shape(modes, mixed)
    assert named(picture, "node, forward") and named(picture, "node, backward")
    own = modes.shapes[mixed]
    ellipse = np.abs([own.at(phi) for phi in np.linspace(0.0, 2.0 * np.pi, 400)]).max(axis=0)
    assert ellipse == pytest.approx(own.size, rel=1e-3)


def test_a_rotor_that_turns_backwards_has_forward_modes_the_other_way():
    scene = rsc.Scene.from_toml(template("rig"))
    mirrored = scene.mirrored()
    own, other = rsc.modes(scene, 20.0), rsc.modes(mirrored, -20.0)
    for i in oscillating(own):
        assert own.rotor[i].sense == other.rotor[i].sense
        assert (own.shapes[i].is_positive != other.shapes[i].is_positive)[own.shapes[i].size > 1e-3].all()
        senses = [{trace["name"] for trace in shape(each, i)["data"]} for each in (own, other)]
        assert senses[0] == senses[1]


def test_points_that_move_are_on_their_orbits(rig):
    modes = rsc.modes(rig, 20.0)
    picture = shape(modes, oscillating(modes)[0])
    (shaft,) = named(picture, "shaft")
    half = np.pi / 3.0
    moved = [np.array(shaft["rest"][axis]) + (np.array(shaft[axis]) - shaft["rest"][axis]) * np.cos(half)
             + (np.array(shaft["quarter"][axis]) - shaft["rest"][axis]) * np.sin(half) for axis in "xy"]  # fmt: skip
    own = modes.shapes[oscillating(modes)[0]]
    heights = [own.at(phi).imag + 0.45 * own.at(phi).real for phi in np.linspace(0.0, 2.0 * np.pi, 3601)]
    highest = int(np.argmax([one[own.size.argmax()] for one in heights]))  # there the picture stands still
    assert shaft["y"] == pytest.approx(heights[highest], abs=1e-3)
    r = own.at(2.0 * np.pi * highest / 3600.0 + half)
    assert moved[1] == pytest.approx(r.imag + 0.45 * r.real, abs=1e-3)
    assert moved[0] == pytest.approx(1e3 * own.position + 0.035 * 560.0 * r.real, abs=0.05)


def test_a_result_keeps_the_drawing_and_the_shapes(pump, tmp_path):
    kept = rsc.Scene.from_toml(pump.to_toml())
    assert kept == pump and kept.reductions == () and drawing(kept) == drawing(pump)
    before, after = (rsc.modes(each, 50.0).shapes for each in (pump, kept))
    assert all((one.positive == other.positive).all() for one, other in zip(before, after, strict=True))
    report = rsc.check(pump.with_values({"drive.duration": 0.1}))
    report.result.save(tmp_path / "run.h5")
    stored = replace(report, result=rsc.load(tmp_path / "run.h5"))
    for name in ("machine", "mode_1"):
        axes = stored.plot(name)
        assert axes.get_xlabel() == "from the left end in mm"
    stored.save_html(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    for told in ("centre of gravity", "critical speeds", "<h3>Bearings</h3>", "k_yz N/m"):
        assert told in page
    for told in ("<h2>Machine</h2>", "labyrinth 300 um", 'id="mode_1"', 'id="animate"', "backward, logarithmic decrement"):
        assert told in page


def test_python_draws_the_machine_and_its_modes(pump):
    assert "radius in mm" in pump.plot().get_ylabel()
    axes = rsc.modes(pump, 50.0).plot(1)
    assert "logarithmic decrement" in axes.get_title()
    with pytest.raises(rsc.SceneError, match=r"mode = 99: must be a whole number from 0 to"):
        rsc.modes(pump, 50.0).plot(99)
    laval = rsc.Scene.from_toml(template("laval"))
    assert drawing(laval) is None and rsc.modes(laval).shapes == ()
    with pytest.raises(rsc.SceneError, match="given by its stations"):
        laval.plot()
    with pytest.raises(rsc.SceneError, match="given by its stations"):
        rsc.modes(laval).plot()


def test_paper_has_the_same_drawing(pump, tmp_path):
    picture = drawing(pump)
    drawn = svg(picture, "machine")
    assert all(f">{word}</text>" in drawn for word in words(picture)) and 'text-anchor="middle"' in drawn
    save(stacked([picture], "pump"), tmp_path / "pump.svg")
    assert "<svg" in (tmp_path / "pump.svg").read_text()


def test_the_command_draws_a_shaft_and_nothing_else(tmp_path, capsys):
    (tmp_path / "rig.toml").write_text(template("rig"))
    (tmp_path / "laval.toml").write_text(template("laval"))
    assert main(["modes", str(tmp_path / "rig.toml"), "-o", str(tmp_path / "rig.png")]) == 0
    assert (tmp_path / "rig.png").read_bytes()[:4] == b"\x89PNG"
    assert main(["modes", str(tmp_path / "laval.toml"), "-o", str(tmp_path / "laval.png")]) == 2
    assert "a scene with a shaft model" in capsys.readouterr().err and not (tmp_path / "laval.png").exists()


def test_circles_of_a_mode_may_differ_from_node_to_node():
    """A vibration whose nodes run opposite ways keeps both, scaled to the largest distance."""

    class Vibration:
        frequency, shape, mirror_shape = -5.0, np.array([2.0, 0.5j]), np.array([1.0, 2.0])

    own = shape_of(Vibration, np.array([0.0, 1.0]), np.eye(2))
    assert own.size == pytest.approx([1.0, 2.5 / 3.0]) and own.is_positive.tolist() == [False, True]
