"""What is drawn is what was given: data in the artists, orientation, units, limits; and no global state."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.text import Text

from reports import short_report
from rsc.analysis.lines.forward_rub import TOUCH, RubEvent, RubRange
from rsc.analysis.lines.rootlines import RANGE_END
from rsc.errors import DataError
from rsc.measure.envelopes import Envelope, envelope
from rsc.measure.spectra import Peaks, Waterfall, waterfall
from rsc.show import plots
from rsc.show.branch_map import plot_map
from rsc.show.orbits import plot_orbits
from rsc.show.report_pictures import campbell, draw
from rsc.show.stability import stability
from rsc.show.text import stable_stretches


def fall_of(amplitude, speed, f_max=100.0):
    amplitude, speed = np.asarray(amplitude, float), np.asarray(speed, float)
    n_f = amplitude.shape[1]
    return Waterfall(np.linspace(-f_max, f_max, n_f), speed, np.arange(speed.size) * 0.5, amplitude, 0.5, n_f)


def run_up(seconds=8.0, down=False):
    """20 to 60 Hz with a forward 1X line of 0.1 mm and, above 40 Hz, a backward line of 0.3 mm at -17 Hz."""
    time = np.arange(int(seconds * 1000)) / 1000.0
    speed = 20.0 + 40.0 * time / seconds
    turn = 2 * np.pi * (20.0 * time + 20.0 * time**2 / seconds)
    signal = 1e-4 * np.exp(1j * turn) + np.where(speed > 40, 3e-4, 0) * np.exp(-2j * np.pi * 17.0 * time)
    return (time, signal[::-1].conj(), speed[::-1]) if down else (time, signal, speed)


def mesh_of(figure):
    """x and y centres and levels of the picture in the first axes."""
    (mesh,) = [item for item in figure.axes[0].collections if isinstance(item, QuadMesh)]
    corners = mesh.get_coordinates()
    x, y = corners[0, :, 0], corners[:, 0, 1]
    return 0.5 * (x[1:] + x[:-1]), 0.5 * (y[1:] + y[:-1]), mesh.get_array(), mesh


def line_with(axes, label):
    (line,) = [line for line in axes.lines if line.get_label() == label]
    return line


def stacked_lines(figure):
    return [line for line in figure.axes[0].lines if len(line.get_xdata()) > 100]


def texts_of(figure):
    return [text.get_text() for text in figure.findobj(lambda artist: hasattr(artist, "get_text"))]


@pytest.mark.parametrize("down", [False, True])
def test_campbell_backward_is_left_and_high_speed_is_up(down):
    figure = plots.plot_campbell(waterfall(*run_up(down=down)), title="t")
    x, y, level, mesh = mesh_of(figure)
    assert mesh.get_clim() == (-60, 0)
    assert level.max() == pytest.approx(0.0, abs=1e-9)
    lower, upper = level[y < 38], level[y > 43]
    assert lower.max() == pytest.approx(20 * np.log10(1 / 3), abs=1.4)  # a bin raster costs up to 1.4 dB
    assert np.all(np.abs(x[np.argmax(upper, axis=1)] + 17) < 2)  # backward whirl: negative, upper half only
    assert np.all(np.abs(x[np.argmax(lower, axis=1)] - y[y < 38]) < 4)  # synchronous line: x = +speed
    axes = figure.axes[0]
    assert axes.get_ylim()[0] < axes.get_ylim()[1] and axes.get_xlim()[0] < -60 < 60 < axes.get_xlim()[1]
    assert "Hz" in axes.get_xlabel() and axes.get_ylabel() == "rotor speed in Hz"


def test_campbell_colours_are_dark_for_large_and_the_bar_names_its_reference():
    figure = plots.plot_campbell(waterfall(*run_up()), title="a title")
    mesh = mesh_of(figure)[3]
    assert np.sum(mesh.cmap(1.0)[:3]) < 0.1 < 2.9 < np.sum(mesh.cmap(0.0)[:3])
    label = figure.axes[1].get_ylabel()
    assert "dB re" in label and "µm" in label
    assert 255 <= float(label.split("re ")[1].split(" ")[0]) <= 300  # 300 µm less at most the loss of a bin raster
    assert figure.axes[0].get_title() == "a title"


def test_campbell_overlays_hold_the_given_data():
    speed = np.linspace(20, 60, 9)
    stable = speed > 38
    backward = -15.0 - 0.1 * speed
    coupled_modes = np.column_stack([30 + 0.1 * speed, -30 - 0.1 * speed])
    natural = {"coupled": (speed, coupled_modes), "uncoupled": (speed, 33 + 0 * speed)}
    peaks = Peaks(speed, speed, np.column_stack([backward, speed]), np.ones((9, 2)), "negative")
    fall = waterfall(*run_up())
    rolls = np.where(fall.speed > 40.0, -2.0 * fall.speed, np.nan)
    figure = plots.plot_campbell(
        fall, title="t", natural=natural, whirls=[(speed, backward, stable)], rolls=rolls, peaks=[peaks]
    )
    axes = figure.axes[0]
    rolling = line_with(axes, "predicted whirl, rolling")
    np.testing.assert_array_equal(rolling.get_xdata(), rolls)
    np.testing.assert_array_equal(rolling.get_ydata(), fall.speed)
    solid, dashed = line_with(axes, "predicted whirl, stable"), line_with(axes, "predicted whirl, unstable")
    assert (solid.get_linestyle(), dashed.get_linestyle()) == ("-", "--")
    np.testing.assert_array_equal(solid.get_xdata()[stable], backward[stable])
    np.testing.assert_array_equal(solid.get_ydata()[stable], speed[stable])
    assert np.isnan(solid.get_xdata()[~stable]).all()
    np.testing.assert_array_equal(dashed.get_xdata()[~stable], backward[~stable])
    # one point shared, so that there is no hole where stability changes, and no more
    assert np.isfinite(dashed.get_xdata()).sum() == np.sum(~stable) + 1
    coupled = line_with(axes, "natural frequencies, coupled")
    assert coupled.get_linestyle() == "-."
    np.testing.assert_array_equal(coupled.get_xdata(), natural["coupled"][1][:, 0])
    np.testing.assert_array_equal(coupled.get_ydata(), speed)
    assert coupled.get_color() != line_with(axes, "natural frequencies, uncoupled").get_color()
    assert sum(line.get_linestyle() == "-." for line in axes.lines) == 3
    nothing = plots.plot_campbell(fall, title="t", rolls=np.full(fall.speed.shape, np.nan))
    assert all("rolling" not in str(line.get_label()) for line in nothing.axes[0].lines)
    measured = line_with(axes, "measured lines")
    np.testing.assert_array_equal(measured.get_xdata().reshape(9, 2), peaks.frequency)
    np.testing.assert_array_equal(measured.get_ydata().reshape(9, 2), np.column_stack([speed, speed]))


def test_campbell_order_lines_and_their_names():
    figure = plots.plot_campbell(waterfall(*run_up()), title="t", f_range=(-130, 90))
    axes = figure.axes[0]
    slopes = sorted(float(x[-1] / y[-1]) for x, y in (line.get_data() for line in axes.lines) if abs(x[-1]) > 1)
    np.testing.assert_allclose(slopes, [-2, -1, 1, 2])
    assert axes.get_xlim() == (-130, 90)
    names = {text.get_text(): text.xy for text in axes.texts}
    assert set(names) == {"\N{MINUS SIGN}2X", "\N{MINUS SIGN}1X", "+1X", "+2X"}
    for order, name in zip((-2, -1, 1, 2), ("\N{MINUS SIGN}2X", "\N{MINUS SIGN}1X", "+1X", "+2X"), strict=True):
        assert names[name][0] == pytest.approx(order * names[name][1])  # each name stands on its own line
    assert names["+2X"][0] == 90  # which leaves through the side, the others through the top
    assert names["+1X"][1] == axes.get_ylim()[1]


@pytest.mark.parametrize("kind", ["constant", "up and down"])
def test_campbell_over_time_where_the_speed_does_not_run_one_way(kind):
    time = np.arange(8000) / 1000.0
    speed = np.full(8000, 50.0) if kind == "constant" else 60 - 10 * np.abs(time - 4)
    fall = waterfall(time, 1e-4 * np.exp(-2j * np.pi * 17 * time), speed, window=0.5)
    branch = (np.array([40.0, 70.0]), np.array([-10.0, -16.0]), np.array([True, True]))
    figure = plots.plot_campbell(fall, title="t", whirls=[branch])
    axes = figure.axes[0]
    assert axes.get_ylabel() == "time in s"
    line = line_with(axes, "predicted whirl, stable")
    reached = fall.speed >= 40 - 1e-9
    assert reached.any() and (kind == "constant" or not reached.all())
    np.testing.assert_array_equal(line.get_ydata()[reached], fall.time[reached])
    np.testing.assert_allclose(line.get_xdata()[reached], -10 - (fall.speed[reached] - 40) / 5, atol=1e-9)
    assert np.isnan(line.get_xdata()[~reached]).all()
    assert not any("unstable" in str(line.get_label()) for line in axes.lines)
    x, _, level, _ = mesh_of(figure)
    assert np.all(np.abs(x[np.argmax(level, axis=1)] + 17) < 2)


def test_thinning_never_loses_a_line():
    """One hot cell among 3000 x 5001: still there at full level, in its place, in a picture of at most 700 x 1000."""
    amplitude = np.full((3000, 5001), 1e-9)
    amplitude[1234, 777] = 1e-3
    fall = fall_of(amplitude, np.linspace(20, 80, 3000))
    x, y, level, _ = mesh_of(plots.plot_campbell(fall, title="t", f_range=(-100, 100)))
    assert level.shape == (y.size, x.size) and y.size <= 700 and x.size <= 1000
    row, column = np.unravel_index(np.argmax(level), level.shape)
    assert level[row, column] == pytest.approx(0.0) and np.sum(level > -60) == 1
    assert x[column] == pytest.approx(fall.frequency[777], abs=0.2)
    assert y[row] == pytest.approx(fall.speed[1234], abs=0.1)
    stacked = stacked_lines(plots.plot_waterfall(fall, title="t", f_range=(-100, 100)))
    assert len(stacked) == 50
    line = max(stacked, key=lambda item: np.ptp(item.get_ydata()))
    assert line.get_xdata()[np.argmax(line.get_ydata())] == pytest.approx(fall.frequency[777], abs=0.2)


def test_windows_without_finite_data_are_marked_not_white():
    amplitude = np.full((6, 41), 1e-9)
    amplitude[:, 10] = 1e-4
    amplitude[4:] = np.nan
    figure = plots.plot_campbell(fall_of(amplitude, np.arange(6.0) + 20), title="t")
    _, _, level, mesh = mesh_of(figure)
    assert np.ma.getmaskarray(level)[4:].all() and not np.ma.getmaskarray(level)[:4].any()
    assert tuple(mesh.cmap.get_bad()) != tuple(mesh.cmap(0.0))
    assert "no finite data" in texts_of(figure)
    plots.plot_waterfall(fall_of(amplitude, np.arange(6.0) + 20), title="t")
    with pytest.raises(DataError, match="nothing to draw"):
        plots.plot_campbell(fall_of(amplitude * np.nan, np.arange(6.0)), title="t")
    with pytest.raises(DataError, match="nothing to draw"):
        plots.plot_waterfall(fall_of(amplitude * 0, np.arange(6.0)), title="t")


def test_waterfall_lines_stand_on_their_speed_and_the_scale_bar_is_true():
    amplitude = np.zeros((5, 201))
    amplitude[3, 60] = 3e-4  # backward, -40 Hz
    amplitude[1, 120] = 1e-4
    fall = fall_of(amplitude, [20, 30, 40, 50, 60])
    figure = plots.plot_waterfall(fall, title="t", f_range=(-90, 90))
    axes, stacked = figure.axes[0], stacked_lines(figure)
    np.testing.assert_allclose([np.min(line.get_ydata()) for line in stacked], fall.speed)
    heights = [np.ptp(line.get_ydata()) for line in stacked]
    assert heights[3] == pytest.approx(3 * heights[1]) and heights[0] == 0
    assert stacked[3].get_xdata()[np.argmax(stacked[3].get_ydata())] == pytest.approx(-40)
    orders = [line.get_zorder() for line in stacked]
    assert orders == sorted(orders, reverse=True)  # lower lines in front
    (bar,) = [line for line in axes.lines if line.get_linewidth() == 2]
    (label,) = [text.get_text() for text in axes.texts if "m" in text.get_text()]
    assert label == "100 µm"
    assert np.ptp(bar.get_ydata()) == pytest.approx(heights[1])
    assert all(15 <= mark <= 65 for mark in axes.get_yticks())


def test_amplitude_holds_runs_predictions_gap_and_transition():
    time, signal, speed = run_up()
    up, down = envelope(time, signal, speed, 0.25), envelope(*run_up(down=True), 0.25)
    branch_speed = np.linspace(25, 70, 10)
    size, stable = np.full(10, 3e-4), branch_speed > 41
    predicted = [
        (branch_speed, size, stable, size - 1e-4, size + 1e-4),
        (branch_speed, 0.5 * size, ~stable, None, None),
    ]
    figure = plots.plot_amplitude(
        [("run-up", up), ("run-down", down)], gap=2e-4, title="t", predicted=predicted,
        synchronous=(branch_speed, 0 * size + 1.1e-4), transition={"jump": 40.0, "end of whirl": 41.0},
        unbalance_line=(branch_speed, 0 * size + 2e-5, 0 * size + 3e-5),
    )
    axes = figure.axes[0]
    assert "µm" in axes.get_ylabel() and axes.get_xlabel() == "rotor speed in Hz"
    for label, run in (("run-up", up), ("run-down", down)):
        highest = line_with(axes, f"{label}: min and max of |r|")
        np.testing.assert_allclose(highest.get_ydata(), 1e6 * run.maximum)
        np.testing.assert_array_equal(highest.get_xdata(), run.speed)
        lowest = axes.lines[axes.lines.index(highest) + 1]
        np.testing.assert_allclose(lowest.get_ydata(), 1e6 * run.minimum)
        assert lowest.get_color() == highest.get_color()
    np.testing.assert_allclose(line_with(axes, "gap").get_ydata(), 200)
    solid = line_with(axes, "predicted whirl, stable")
    np.testing.assert_allclose(solid.get_ydata()[stable], 300)
    assert np.isnan(solid.get_ydata()[~stable]).all()
    np.testing.assert_allclose(line_with(axes, "forward rub, closed form").get_ydata(), 110)
    np.testing.assert_allclose(line_with(axes, "unbalance line on the whirl").get_ydata(), 20)
    np.testing.assert_allclose(line_with(axes, "predicted unbalance line").get_ydata(), 30)
    (band,) = [item for item in axes.collections if item.get_label() == "predicted envelope, first order"]
    corners = band.get_paths()[0].vertices
    assert (corners[:, 1].min(), corners[:, 1].max()) == pytest.approx((200, 400))
    assert corners[:, 0].min() > 41  # the band belongs to the stable part
    assert {text.get_text(): text.xy[0] for text in axes.texts} == {"jump: 40 Hz": 40, "end of whirl: 41 Hz": 41}
    sides = [text.get_ha() for text in axes.texts]
    assert sides == ["right", "left"]  # two names close to each other do not overlap
    assert axes.get_ylim()[0] == 0 and axes.get_ylim()[1] > 1e6 * up.maximum.max()


@pytest.mark.parametrize(
    ("scale", "unit"), [(1e-9, "nm"), (3e-5, "µm"), (9.99e-4, "µm"), (1e-3, "mm"), (0.5, "mm"), (20.0, "m")]
)
def test_lengths_are_drawn_in_a_unit_that_suits_them(scale, unit):
    speed = np.array([20.0, 30.0])
    run = Envelope(speed, speed, np.zeros(2), np.full(2, scale))
    axes = plots.plot_amplitude([("run", run)], gap=0.5 * scale, title="t").axes[0]
    assert axes.get_ylabel().endswith(f" {unit}")
    assert 1 <= line_with(axes, "run: min and max of |r|").get_ydata().max() * (1 + 1e-9) < 1000


def test_no_kilometres_where_a_run_diverged():
    speed = np.array([20.0, 30.0])
    run = Envelope(speed, speed, np.zeros(2), np.full(2, 5e6))
    assert plots.plot_amplitude([("run", run)], gap=1e-3, title="t").axes[0].get_ylabel().endswith(" m")


def test_centre_line_lies_within_the_gap_in_the_order_of_the_run():
    centre = 1e-4 * np.linspace(1.0, 5.0, 7) * np.exp(-1j * np.linspace(0.0, 1.0, 7))
    axes = plots.plot_centre_line(centre, gap=1e-3, title="t").axes[0]
    path, begin, end = (line_with(axes, name) for name in ("mean position of a window", "begin of the run", "end of the run"))
    np.testing.assert_allclose(path.get_xdata() + 1j * path.get_ydata(), 1e3 * centre)
    assert (begin.get_xdata()[0], begin.get_ydata()[0]) == pytest.approx((0.1, 0.0))
    assert (end.get_xdata()[0], end.get_ydata()[0]) == pytest.approx((0.5 * np.cos(1.0), -0.5 * np.sin(1.0)))
    np.testing.assert_allclose(np.hypot(*line_with(axes, "gap").get_data()), 1.0)
    assert axes.get_aspect() == 1.0 and (axes.get_xlabel(), axes.get_ylabel()) == ("y in mm", "z in mm")


def test_once_a_turn_shows_every_distance_beside_the_gap():
    speed, distance = np.repeat([20.0, 30.0, 40.0], 4), 1e-4 * np.arange(12)
    axes = plots.plot_once_a_turn(speed, distance, gap=1e-3, title="t").axes[0]
    dots = line_with(axes, "once a revolution")
    assert (dots.get_linestyle(), dots.get_marker()) == ("None", "o")
    np.testing.assert_array_equal(dots.get_xdata(), speed)
    np.testing.assert_allclose(dots.get_ydata(), 1e3 * distance)
    assert set(line_with(axes, "gap").get_ydata()) == {1.0} and axes.get_ylim()[0] == 0.0
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("rotor speed in Hz", "|r| at the contact in mm")
    assert plots.plot_once_a_turn(speed, distance, gap=1e-3, title="t", x_label="time in s").axes[0].get_xlabel() == "time in s"


def test_contact_panels():
    speed = np.linspace(20, 60, 40)
    share = np.linspace(0, 1, 40)
    slip = np.linspace(0.5, -0.2, 40)
    figure = plots.plot_contact(speed, share, 2e3 * share, slip, 50 * share, title="t")
    assert len(figure.axes) == 4
    labels = [" ".join(axes.get_ylabel().split()) for axes in figure.axes]
    assert labels == ["contact share in %", "normal force in kN", "slip velocity in mm/s", "friction power in W"]
    for axes, values in zip(figure.axes, (100 * share, 2 * share, 1e3 * slip, 50 * share), strict=True):
        np.testing.assert_array_equal(axes.lines[0].get_xdata(), speed)
        np.testing.assert_allclose(axes.lines[0].get_ydata(), values)
    np.testing.assert_array_equal(line_with(figure.axes[2], "rolling limit").get_ydata(), 0)
    assert figure.axes[-1].get_xlabel() == "rotor speed in Hz"
    without = plots.plot_contact(speed, share, 2e3 * share, None, 50 * share, title="t", x_label="time in s")
    assert len(without.axes) == 3 and not any("slip" in axes.get_ylabel() for axes in without.axes)
    assert without.axes[-1].get_xlabel() == "time in s"


def test_contact_keeps_a_spike_of_one_sample():
    time = np.arange(100_000) / 1000.0
    force = np.sin(time)
    force[77_777] = 40.0
    figure = plots.plot_contact(time, 0 * time, force, None, 0 * time, title="t", x_label="time in s")
    line = figure.axes[1].lines[0]
    assert line.get_xdata().size <= 4000
    assert line.get_ydata().max() == 40.0
    assert line.get_xdata()[np.argmax(line.get_ydata())] == time[77_777]
    assert np.all(np.diff(line.get_xdata()) > 0)
    force[:] = np.nan
    plots.plot_contact(time, 0 * time, force, force, 0 * time, title="all missing")


@pytest.mark.parametrize(("name", "start"), [("a.png", b"\x89PNG"), ("a.pdf", b"%PDF"), ("a.svg", b"<?xml")])
def test_save_writes_what_the_ending_says(tmp_path, name, start):
    figure = plots.plot_campbell(waterfall(*run_up()), title="t")
    plots.save(figure, tmp_path / name)
    assert (tmp_path / name).read_bytes().startswith(start)


def test_save_refuses_in_one_line(tmp_path):
    figure = plots.plot_centre_line(np.ones(3, complex), gap=1.0, title="t")
    for path in (tmp_path / "a.unknown", tmp_path / "no folder" / "a.png"):
        with pytest.raises(DataError, match=r"picture not written|cannot be written"):
            plots.save(figure, path)


def test_the_map_joins_the_whirls_whose_forces_pass_their_limit():
    speed, stable = np.array([20.0, 60.0, 100.0]), np.array([True, True, False])
    one = np.ones(3)
    branches = [("A", speed, -0.3 * speed, 3e-3 - 1e-5 * speed, stable), ("B", speed, -60.0 * one, 5e-3 * one, stable)]
    text = "F_N of A is 0.493 F_N of B"
    figure = plot_map(
        branches, [(62.0, -18.6, 2.38e-3, "stable (oscillatory)")], gap=1e-3, title="map",
        ratios=[(61.0, (-18.3, -60.0), (2.39e-3, 5e-3), text)],
    )
    top, bottom = figure.axes
    line = line_with(top, text)
    [below] = [other for other in bottom.get_lines() if list(other.get_xdata()) == [61.0, 61.0]]
    np.testing.assert_allclose(line.get_xydata(), [[61.0, -18.3], [61.0, -60.0]])
    np.testing.assert_allclose(below.get_xydata(), [[61.0, 2.39], [61.0, 5.0]])
    # the cross stands on A alone, over the mark of the event beside it
    assert line.get_marker() == "x" and line.get_markevery() == [0]
    assert line.get_zorder() > line_with(top, "stable (oscillatory)").get_zorder()
    assert text in texts_of(figure)
    plain = plot_map(branches, [], gap=1e-3, title="map")
    assert len(plain.axes[0].get_lines()) < len(top.get_lines())


def test_the_map_and_the_text_say_alike_what_is_claimed_of_a_forward_rub():
    """Unstable, stable, no circle and stable again, over 80 to 100 Hz; the changes lie within a step of the grid."""
    speed, changes = np.linspace(80.0, 100.0, 41), (84.6, 90.2, 93.3)
    kinds = np.searchsorted(changes, speed)
    events = tuple(RubEvent("some", change) for change in changes)
    rates, mirror = np.where(kinds > 0, -1.0, 1.0), np.where(kinds == 2, 0.3, 0.05)
    rub = RubRange(1, RubEvent(TOUCH, 79.8), RubEvent(RANGE_END, 100.0), events, speed, 2e-3 + 0.0 * speed, rates, mirror)
    bottom = plot_map([], [], gap=1e-3, title="map", rubs=[(rub.speed, rub.amplitude, stability(rub))]).axes[1]
    told = {"unstable": ("--", kinds == 0), "stable": ("-", kinds % 2 == 1), "no circle: nothing claimed": (":", kinds == 2)}
    for name, (style, wanted) in told.items():
        line = line_with(bottom, f"forward rub, {name}")
        drawn = np.isfinite(line.get_ydata())
        assert line.get_linestyle() == style and drawn[wanted].all()
        reach = wanted | np.append(wanted[1:], False) | np.insert(wanted[:-1], 0, False)
        assert not drawn[~reach].any() and (name != "stable" or not drawn[~wanted].any())  # no hole, and nothing more
    words = "stable 84.6 .. 90.2 Hz and 93.3 .. 100 Hz, no circle (nothing is claimed) 90.2 .. 93.3 Hz"
    assert stable_stretches(rub) == words
    assert stable_stretches(replace(rub, mirror=0.0 * mirror)) == "stable 84.6 .. 100 Hz"
    assert stable_stretches(replace(rub, growth_rate=1.0 + 0.0 * rates)) == "unstable"
    assert stable_stretches(replace(rub, growth_rate=-1.0 + 0.0 * rates, mirror=0.0 * mirror)) == "stable"
    nothing = replace(rub, growth_rate=-1.0 + 0.0 * rates, mirror=1.0 + mirror)
    assert stable_stretches(nothing) == "no circle: nothing is claimed"


@pytest.mark.parametrize("kind", ["campbell", "waterfall", "amplitude", "orbit", "contact", "centre_line", "once_a_turn"])
def test_text_is_inside_the_figure_and_nowhere_over_other_text(kind, monkeypatch):
    time, signal, speed = run_up()
    fall, run, branch = waterfall(time, signal, speed), envelope(time, signal, speed, 0.2), np.array([20.0, 60.0])
    stable = np.array([True, False])
    figure = {
        "campbell": lambda: plots.plot_campbell(
            fall, title="A title of the usual length", whirls=[(branch, 0 * branch - 17, stable)],
            natural={"coupled": (branch, branch), "uncoupled": (branch, -branch)},
        ),
        "waterfall": lambda: plots.plot_waterfall(fall, title="A title of the usual length"),
        "amplitude": lambda: plots.plot_amplitude(
            [("run-up", run)], gap=2e-4, title="A title of the usual length", synchronous=(branch, 1e-5 * branch),
            predicted=[(branch, 4e-6 * branch, stable, 3e-6 * branch, 5e-6 * branch)],
            transition={"jump": 39.0, "jump, predicted": 40.0},
        ),
        "orbit": lambda: plot_orbits(
            [("whirl A, 45.1 Hz", signal, 0.1 * signal, np.array([0, 50]), np.abs(signal), {})] * 4, gap=2e-4,
            title="A title of the usual length",
        ),
        "centre_line": lambda: plots.plot_centre_line(0.1 * signal, gap=2e-4, title="A title of the usual length"),
        "once_a_turn": lambda: plots.plot_once_a_turn(speed, np.abs(signal), gap=2e-4, title="A title of the usual length"),
        "contact": lambda: plots.plot_contact(
            run.speed, 0 * run.speed, 300 * run.speed, run.speed - 40, run.speed, title="A title of the usual length"
        ),
    }[kind]()
    figure.canvas.draw()  # the layout settles
    drawn = []
    monkeypatch.setattr(Text, "draw", lambda text, renderer: drawn.append(text))
    figure.canvas.draw()
    drawn = [text for text in drawn if text.get_visible() and text.get_text().strip()]
    boxes = [(text.get_text(), text.get_window_extent()) for text in drawn]
    assert len(boxes) > 15
    for name, box in boxes:
        assert box.x0 >= 0 and box.y0 >= 0, name
        assert box.x1 <= figure.bbox.width and box.y1 <= figure.bbox.height, name
    for i, (name, box) in enumerate(boxes):
        for other_name, other in boxes[:i]:
            assert not box.overlaps(other), (name, other_name)


def test_threads_draw_the_same_picture(tmp_path):
    fall = waterfall(*run_up())

    def draw(i):
        plots.save(plots.plot_campbell(fall, title="t"), tmp_path / f"{i}.png")
        return (tmp_path / f"{i}.png").read_bytes()

    with ThreadPoolExecutor(4) as pool:
        pictures = list(pool.map(draw, range(4)))
    assert all(picture == pictures[0] for picture in pictures)


def test_matplotlib_is_lazy_and_pyplot_never_loaded():
    code = (
        "import sys, rsc, rsc.measure.spectra; assert 'matplotlib' not in sys.modules, 'early'; "
        "import rsc.show.plots; assert 'matplotlib.pyplot' not in sys.modules, 'pyplot'"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_title_that_is_no_mathematics_is_drawn_as_it_is(tmp_path):
    title = r"50 $ rotor, \frac{1 $"
    figure = plots.plot_campbell(waterfall(*run_up()), title=title)
    plots.save(figure, tmp_path / "a.png")
    assert title.replace("$", r"\$") in texts_of(figure) and (tmp_path / "a.png").stat().st_size > 10_000
    plots.save(plots.plot_waterfall(waterfall(*run_up()), title=title), tmp_path / "a.png")


def test_a_picture_does_not_replace_what_is_none(tmp_path):
    figure = plots.plot_campbell(waterfall(*run_up()), title="t")
    (tmp_path / "a.png").write_text("notes")
    for name, problem in {"a.png": "another kind", "a.toml": "must end with", "": "must end with"}.items():
        with pytest.raises(DataError, match=problem):
            plots.save(figure, tmp_path / name)
    assert (tmp_path / "a.png").read_text() == "notes"


def test_a_stator_that_moves_has_a_campbell_picture(tmp_path):
    report = short_report()
    names = [path.name for path in draw(report, tmp_path)]
    assert "campbell_stator.png" in names and (tmp_path / "campbell_stator.png").stat().st_size > 10_000
    level = mesh_of(campbell(report, "t", report.stator_fall))[2]
    assert not np.array_equal(level, mesh_of(campbell(report, "t"))[2])
    still = replace(report.stator_fall, amplitude=np.zeros_like(report.stator_fall.amplitude))
    for none in (None, still):
        (tmp_path / "campbell_stator.png").unlink(missing_ok=True)
        assert "campbell_stator.png" not in [path.name for path in draw(replace(report, stator_fall=none), tmp_path)]


def test_a_report_has_a_centre_line_where_the_rotor_leaves_the_middle(tmp_path):
    report = short_report()
    gap, n_windows = report.result.scene.contact.gap, len(report.centre)
    names = {}
    for share in (0.0, 0.01, 0.03):
        centre = np.full(n_windows, share * gap * 1j)
        names[share] = [path.name for path in draw(replace(report, centre=centre), tmp_path)]
    assert ["centre_line.png" in each for each in names.values()] == [False, False, True]
    assert all("once_a_turn.png" in each for each in names.values())


def test_orbits_show_their_filtered_paths_and_name_them_once():
    path, force = 1e-3 * np.exp(2j * np.pi * np.arange(100) / 50), np.zeros(100)
    parts = {"filtered at 1X": (1e-4j, 2e-4, 1e-4)}, {"filtered at 1X": (0j, 3e-4, 0j), "filtered at the whirl": (0j, 0j, 1e-3)}
    figure = plot_orbits([("a", path, 0 * path, np.array([3]), force, part) for part in parts], gap=1e-3, title="t")
    ellipse = line_with(figure.axes[0], "filtered at 1X")
    np.testing.assert_allclose((ellipse.get_xdata() / 0.3) ** 2 + ((ellipse.get_ydata() - 0.1) / 0.1) ** 2, 1.0)
    named = [text.get_text() for text in figure.legends[0].get_texts()]
    assert named.count("filtered at 1X") == named.count("filtered at the whirl") == 1
    figure.canvas.draw()
    box = figure.legends[0].get_window_extent()
    assert box.x0 >= 0.0 and box.x1 <= figure.bbox.width
