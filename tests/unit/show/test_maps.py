"""Maps of sweeps: what is drawn is what was given, on the side and in the units that its label tells."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgb

import rsc
from rsc.cli import main
from rsc.measure.kinds import RANK, Kind
from rsc.show.pictures import maps
from rsc.show.pictures.maps import Curve, Panel, Side
from rsc.show.sweeps import pictures as sweep_pictures
from rsc.show.sweeps import words as sweep_words
from rsc.study.sweep.dataset import load_dataset
from rsc.study.sweep.plan import make_plan
from rsc.study.sweep.sweep import computed
from scenes import LAVAL, changed

FIGURE = Path(__file__).parents[3] / "data" / "reference" / "gyroscopic_figure3_right.toml"
SCENE = rsc.Scene.from_dict(changed(LAVAL, drive={"duration": 0.2}), "laval.toml")


def mesh_of(figure):
    (mesh,) = [item for item in figure.axes[0].collections if isinstance(item, QuadMesh)]
    return mesh


def cells_of(figure, x, y):
    """The value that stands at a place of a map."""
    mesh = mesh_of(figure)
    corners = mesh.get_coordinates()
    column = np.searchsorted(corners[0, :, 0], x) - 1
    return mesh.get_array()[np.searchsorted(corners[:, 0, 1], y) - 1, column]


def legend_of(figure):
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def dataset(vary, compute="predict", scene=SCENE, **how):
    return computed(make_plan(scene, rsc.cases(scene, vary, **how), compute), None, threads=1)


def luminance(colour):
    """Relative luminance of a colour (sRGB): 0 black, 1 white."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    return np.dot(linear, (0.2126, 0.7152, 0.0722))


def test_danger_gets_darker_without_help_of_its_hue():
    light = [luminance(colour) for colour in maps.DANGER_COLOURS]
    assert all(before - after > 0.1 for before, after in pairwise(light))


def test_every_kind_of_motion_has_a_colour_and_two_are_left_for_whirls_told_apart():
    assert len(set(maps.CLASS_COLOURS)) == len(Kind) + sweep_pictures.MOST_WHIRLS - 1
    assert sorted(RANK) == sorted(Kind)


def test_classes_stand_where_they_belong_and_their_shares_are_told():
    x, y = Side(np.array([1.0, 10.0, 100.0]), "speed in Hz"), Side(np.array([0.1, 0.2]), "friction")
    legend = list(zip("abc", maps.DANGER_COLOURS, strict=False))
    figure = maps.plot_classes(x, y, [[0, 1, 2], [-1, 1, 1]], legend, title="cost: $5")
    assert cells_of(figure, 100.0, 0.1) == 2 and np.ma.is_masked(cells_of(figure, 1.0, 0.2))
    assert legend_of(figure) == ["a (17 %)", "b (50 %)", "c (17 %)", "no value (17 %)"]
    axes = figure.axes[0]
    assert axes.get_xscale() == "log" and axes.get_yscale() == "linear" and axes.get_xlabel() == "speed in Hz"
    figure.canvas.draw()
    assert [tick.get_text() for tick in axes.get_xticklabels() if tick.get_text()].count("10") == 1


def test_values_are_in_the_unit_of_the_bar():
    x, y = Side(np.linspace(1.0, 3.0, 3), "x"), Side(np.linspace(1.0, 4.0, 4), "y")
    values = 1e-3 * (x.values + 10.0 * y.values[:, None])
    figure = maps.plot_values(x, y, values, quantity="amplitude", unit="m", title="")
    assert cells_of(figure, 3.0, 2.0) == pytest.approx(23.0) and figure.axes[1].get_ylabel() == "amplitude in mm"
    mesh = mesh_of(figure)
    assert luminance(mesh.cmap(0.0)) > luminance(mesh.cmap(0.5)) > luminance(mesh.cmap(1.0))


def test_values_over_decades_have_logarithmic_colours_and_plain_numbers():
    x, y = Side(np.linspace(1.0, 3.0, 3), "x"), Side(np.linspace(1.0, 3.0, 3), "y")
    figure = maps.plot_values(x, y, np.outer([1.0, 10.0, 100.0], [1.0, 2.0, 3.0]), quantity="force", unit="N", title="")
    assert mesh_of(figure).norm(10.0) == pytest.approx(np.log(10.0) / np.log(300.0))
    figure.canvas.draw()
    assert {"10", "100"} <= {tick.get_text() for tick in figure.axes[1].get_yticklabels()}


def test_words_are_ticks():
    x, y = Side(np.array(["rk45", "taylor8"]), "method"), Side(np.array([1.0, 2.0]), "y")
    figure = maps.plot_values(x, y, [[1.0, 2.0], [3.0, 4.0]], quantity="q", unit="1", title="")
    assert [tick.get_text() for tick in figure.axes[0].get_xticklabels()] == ["rk45", "taylor8"]
    assert figure.axes[1].get_ylabel() == "q"


def test_panels_share_one_legend():
    x = Side(np.array([1.0, 2.0]), "x")
    forces = [Curve("one", [1.0, 2.0]), Curve("two", [5.0, 6.0])]
    panels = [Panel("a", "m", [Curve("one", [1e-6, 2e-6])]), Panel("b", "N", forces)]
    figure = maps.plot_panels(x, panels, title="t")
    assert legend_of(figure) == ["one", "two"] and figure.axes[0].get_ylabel() == "a\nin µm"
    assert figure.axes[0].lines[0].get_ydata().tolist() == pytest.approx([1.0, 2.0])


def test_a_sweep_over_two_keys_becomes_maps():
    data = dataset({"contact.friction": [0.3, 0.03, 0.1], "drive.speed": "50:60:4"}, "predict,run,mu_min")
    figures = sweep_pictures.pictures(data)
    assert set(figures) == {"danger", "severity", "motion", "amplitude_predicted", "force_predicted", "amplitude", "force"}
    assert figures["danger"].axes[0].get_xlabel() == "rotor speed (drive.speed) in Hz"
    for i, friction in enumerate([0.3, 0.03, 0.1]):
        for k, speed in enumerate(np.linspace(50.0, 60.0, 4)):
            assert cells_of(figures["danger"], speed, friction) == data["danger"][i, k]
            factor = {"N": 1.0, "kN": 1e-3}[figures["force"].axes[1].get_ylabel().rpartition(" ")[2]]
            value = cells_of(figures["force"], speed, friction)
            assert value == pytest.approx(factor * data["largest_force"][i, k], rel=1e-12)
    squeezed = dataset({"contact.friction": [0.05, 0.1], "drive.speed": "50:60:4", "contact.gap": ["1 mm"]}, "predict,run")
    assert "motion" in sweep_pictures.pictures(squeezed)  # a key with one value is no dimension
    (line,) = figures["danger"].axes[0].lines
    assert line.get_ydata() == pytest.approx(data["mu_min"].max(axis=0))


@pytest.mark.parametrize("number", [1e308, -1e308, 1e101])
@pytest.mark.parametrize("name", ["drive.speed", "contact.friction", "whirl_amplitude", "whirl_force"])
def test_numbers_that_no_axis_can_carry_are_refused_in_one_line(name, number):
    """As files hold that others made; NaN and infinite values are no numbers and stay undrawn."""
    data = dataset({"contact.friction": [0.05, 0.1], "drive.speed": "50:60:4"})
    values = data[name]
    values[...] = np.where(np.arange(values.size).reshape(values.shape) == 1, number, values)
    with pytest.raises(rsc.RscError, match=rf"{name} has numbers beyond 1e\+100, which cannot be drawn") as refused:
        sweep_pictures.pictures(data)
    assert "\n" not in str(refused.value)


def test_cases_that_were_not_predicted_are_no_safe_cases():
    """Fewer samples a second than the run has turns are no scene."""
    scene = SCENE.with_values({"contact.friction": 0.1})
    data = dataset({"output.rate": [10.0, 2000.0], "drive.speed": "50:60:4"}, scene=scene)
    assert data["danger"].tolist() == [[-1] * 4, [1] * 4] and set(data["status"][0]) == {"impossible"}
    danger = sweep_pictures.pictures(data)["danger"]
    assert np.ma.is_masked(cells_of(danger, 60.0, 10.0))
    assert legend_of(danger) == ["a whirl is predicted only (50 %)", "no value (50 %)"]
    assert sweep_words.dangers(data) == "backward whirl: a whirl is predicted only in 4 cases, not predicted in 4 cases"


def test_a_class_without_its_run_is_marked_as_predicted_only():
    """There is no stable whirl to start on at the friction of 0.05 and at that of 0.3, and both are no outcome of a run."""
    scene = SCENE.with_values({"start.whirl": "backward"})
    data = dataset({"contact.friction": [0.05, 0.1, 0.3], "drive.speed": "50:60:4"}, "predict,run", scene)
    assert data["danger"][:, 0].tolist() == [0, 3, 1]
    danger = sweep_pictures.pictures(data)["danger"]
    (crosses,) = danger.axes[0].lines
    marked = {(round(float(x), 6), float(y)) for x, y in crosses.get_xydata()}
    speeds = [round(float(speed), 6) for speed in np.linspace(50.0, 60.0, 4)]
    assert marked == {(speed, friction) for speed in speeds for friction in (0.05, 0.3)}
    assert "predicted only, its run is impossible (67 %)" in legend_of(danger)


def test_of_a_third_key_the_worst_is_shown():
    data = dataset({"contact.gap": ["1 mm", "2 mm"], "contact.friction": [0.05, 0.1, 0.2], "drive.speed": "50:60:4"})
    figures = sweep_pictures.pictures(data)
    assert "the worst over contact.gap" in figures["danger"].axes[0].get_title()
    assert cells_of(figures["amplitude_predicted"], 50.0, 0.1) == pytest.approx(1e3 * np.nanmax(data["whirl_amplitude"][:, 1, 0]))


def test_a_sweep_over_one_key_becomes_curves():
    data = dataset({"drive.speed": [60.0, 50.0, 40.0]}, "predict,run", SCENE.with_values({"contact.friction": 0.1}))
    (figure,) = sweep_pictures.pictures(data).values()
    frequency = figure.axes[0]
    assert frequency.get_ylabel() == "whirl frequency\nin Hz" and frequency.lines[0].get_xdata().tolist() == [40.0, 50.0, 60.0]
    whirls = [line.get_ydata() for line in frequency.lines if line.get_label() != "end of the run"]
    drawn = {round(float(y), 6) for y in np.concatenate(whirls) if np.isfinite(y)}
    told = data["frequency"][data["admissible"] & (data["frequency"] < 0.0)]
    assert {round(float(y), 6) for y in told} <= drawn
    dots = next(line for line in frequency.lines if line.get_label() == "end of the run")
    assert dots.get_ydata() == pytest.approx(data["turning_frequency"][::-1], nan_ok=True)


def test_whirls_of_two_frequencies_are_two_classes():
    scene = rsc.load_scene(FIGURE).with_values({"drive.speed": 60.0, "drive.duration": 1.0, "start.whirl": -35.8})
    data = dataset({"start.impulse[0]": [-0.5, 0.0, 0.5], "start.impulse[1]": [0.0, 0.1]}, "run", scene)
    motion = data.variables["motion"][1]
    motion[0, 1], data["turning_frequency"][:] = b"running away", [[-44.02, -700.0], [-35.8, -35.81], [-35.79, -44.0]]
    motion[1:], motion[0, 0] = b"backward whirl, sliding", b"backward whirl, sliding"
    figure = sweep_pictures.pictures(data)["motion"]
    names = ["backward whirl, sliding at -44.02 Hz (33 %)", "running away (17 %)", "backward whirl, sliding at -35.81 Hz (50 %)"]
    assert sorted(legend_of(figure)) == sorted(names)
    assert figure.axes[0].get_xlabel() == "impulse on the rotor at time 0 (start.impulse[0]) in mN s"
    assert figure.axes[0].get_aspect() == 1.0
    # axes in mN s
    assert cells_of(figure, 500, 100) == cells_of(figure, -500, 0) != cells_of(figure, 500, 0) == cells_of(figure, 0, 100)


def test_scattered_values_become_bars_for_each_whirl():
    """Of two whirls at 55 Hz; the percentiles are those of the predictions themselves."""
    scene = rsc.load_scene(FIGURE)
    scattered = {"contact.gap": "normal:1e-3:2e-5", "drive.speed": [100.0, 55.0]}
    data = dataset(scattered, "predict", scene, random=40)
    (figure,) = sweep_pictures.pictures(data).values()
    force = figure.axes[2]
    (unit,) = set(force.get_ylabel().split()) & {"N", "mN"}
    low_whirl, high_whirl = (container.lines[0].get_ydata() for container in force.containers[:2])
    gaps = data.coordinates["contact.gap"][1]
    assert len(gaps) == 40
    for speed, drawn in ((55.0, (low_whirl[0], high_whirl[0])), (100.0, (low_whirl[1],))):
        whirls = [whirl for whirl in rsc.predict(scene, speed) if whirl.stable and whirl.admissible and whirl.frequency < 0.0]
        expected = [whirl.normal_force * np.median(gaps) / 1e-3 * {"N": 1.0, "mN": 1e3}[unit] for whirl in whirls]
        assert list(drawn) == pytest.approx(expected, rel=1e-9)
    assert np.isnan(high_whirl[1]) and figure.axes[3].lines[0].get_ydata() == pytest.approx([1.0, 1.0])


def test_samples_are_drawn_over_each_scattered_value():
    vary = {"contact.friction": "normal:0.15:0.02", "contact.gap": "uniform:0.9mm:1.1mm"}
    data = dataset(vary, "predict,mu_min", sobol=16, seed=1)
    figures = sweep_pictures.pictures(data)
    assert set(figures) == {"over_contact.friction", "over_contact.gap"}
    axes = figures["over_contact.gap"].axes[1]
    assert figures["over_contact.gap"].axes[-1].get_xlabel().endswith("(contact.gap) in mm")
    order = np.argsort(data["contact.gap"])
    stable = np.where(data["stable"] & data["admissible"], data["rotor_amplitude"], np.nan)[order]
    factor = {"mm": 1e3, "µm": 1e6}[axes.get_ylabel().rpartition(" ")[2]]
    drawn = np.column_stack([line.get_ydata() for line in axes.lines if line.get_markerfacecolor() != "white"])
    assert np.nanmax(drawn, axis=1) == pytest.approx(factor * np.nanmax(stable, axis=1))
    assert axes.lines[0].get_xdata() == pytest.approx(1e3 * data["contact.gap"][order])


def test_jumps_are_drawn_over_the_run_up_rate():
    scene = SCENE.with_values({"drive.speed": [50.0, 60.0], "start.whirl": -60.0, "contact.friction": 0.2})
    data = dataset({"drive.duration": [10.0, 20.0, 40.0], "contact.friction": [0.2, 0.25]}, "jump", scene)
    (figure,) = sweep_pictures.pictures(data).values()
    axes = figure.axes[0]
    assert axes.get_xlabel() == "run-up rate in Hz/s"
    assert legend_of(figure) == ["contact.friction = 0.2", "contact.friction = 0.25"]
    assert axes.lines[0].get_xdata() == pytest.approx([0.25, 0.5, 1.0])
    assert axes.lines[1].get_ydata() == pytest.approx(data["jump_speed"][::-1, 1], nan_ok=True)


def test_rsc_plot_draws_the_sweeps_among_its_files(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    data = dataset({"contact.friction": [0.05, 0.1], "drive.speed": "50:60:4"})
    data.save("one.nc")
    load_dataset("one.nc").save("two.nc")
    assert main(["plot", "one.nc", "-o", "pictures"]) == 0
    assert "pictures/danger.png" in capsys.readouterr().out
    assert main(["plot", "one.nc", "two.nc", "-o", "both"]) == 0
    assert sorted(path.parent.name for path in (tmp_path / "both").rglob("danger.png")) == ["_one", "_two"]
    dataset({"contact.friction": [0.1]}).save("point.nc")
    assert main(["plot", "point.nc"]) == 4
    assert "nothing to draw" in capsys.readouterr().err
