"""What is drawn is what was given: data in the artists, orientation, units, limits; and no global state."""

import io
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.text import Text
from PIL import Image

from reports import PUMP, report_of_dict, short_report
from rsc.analysis.follow.events import Event
from rsc.analysis.follow.forward_rub import TOUCH, RubEvent, RubRange
from rsc.analysis.follow.lines import RANGE_END
from rsc.errors import DataError
from rsc.measure.changes import Transition
from rsc.show.pictures import paths, pictures, plots
from rsc.show.pictures.abscissa import Abscissa
from rsc.show.pictures.branch_map import branch_map
from rsc.show.pictures.moments import moments
from rsc.show.pictures.report_pictures import FRAMES, animation, campbell, draw
from rsc.show.pictures.traces import axes as layout_of
from rsc.show.pictures.traces import dots, line
from rsc.show.words.text import stable_stretches
from rsc.show.words.units import unit_for

TITLE = "A title of the usual length"


def image_of(figure):
    """The picture of amplitudes in the first axes, and its x, y and levels in dB."""
    (image,) = figure.axes[0].images
    left, right, bottom, top = image.get_extent()
    rows, columns = image.get_array().shape
    x, y = ((np.arange(n) + 0.5) / n * (high - low) + low for n, low, high in ((columns, left, right), (rows, bottom, top)))
    return image, x, y, image.get_array()


def line_with(axes, label):
    (found,) = [each for each in axes.lines if each.get_label() == label]
    return found


def stacked_lines(axes):
    return [each for each in axes.lines if each.get_color() == "#222222" and len(each.get_xdata()) > 2]


def texts_of(figure):
    return [text.get_text() for text in figure.findobj(lambda artist: hasattr(artist, "get_text"))]


def figures_of(report):
    """name -> function that makes the figure of a report, as `rsc plot` does."""
    along = Abscissa(report)
    strips = [describe(report, along) for describe in (pictures.force, pictures.power, pictures.share, pictures.slip)]
    return {
        "campbell": lambda: campbell(report, TITLE),
        "waterfall": lambda: plots.stacked([pictures.waterfall(report, along)], TITLE),
        "amplitude": lambda: plots.stacked([pictures.amplitude(report, along)], TITLE),
        "orbit": lambda: plots.side_by_side(paths.moments(report, moments(report)), TITLE),
        "contact": lambda: plots.stacked([each for each in strips if each], TITLE, 0.6),
        "once_a_turn": lambda: plots.stacked([paths.once_a_turn(report, along)], TITLE),
    }


def with_amplitudes(amplitude):
    """The report with other amplitudes of its windows."""
    report = short_report()
    return replace(report, fall=replace(report.fall, amplitude=amplitude))


def test_a_description_is_drawn_as_it_says():
    x, y = [0.0, 1.0, 2.0, 3.0], [1.0, None, -2.0, 3.0]
    marks = {"mode": "lines+text", "text": ["", "", "", "far"], "textposition": "top left", "showlegend": False}
    area = {"fill": "toself", "fillcolor": "#d55e0029"}
    data = [
        line(x, y, "one", "#0b7cc4", "dashdot", 2.0), line(x, x, "$two", "#d55e00", **marks),
        line(x, y[::-1], "three", "none", width=0, **area), dots([1.0], [2.0], "dot", "none", "#8a8a8a", 8),
    ]
    (axes,) = plots.stacked([{"data": data, "layout": layout_of("p in Hz", {"title": "q", "range": [-3.0, 5.0]}, 300)}], "t").axes
    drawn = line_with(axes, "one")
    np.testing.assert_array_equal(drawn.get_xdata(), x)
    np.testing.assert_array_equal(drawn.get_ydata(), np.array(y, float))
    assert (drawn.get_linestyle(), to_rgba(drawn.get_color())) == ("-.", to_rgba("#0b7cc4"))
    dot = line_with(axes, "dot")
    assert (dot.get_marker(), dot.get_linestyle(), dot.get_markeredgecolor()) == ("o", "None", "#8a8a8a")
    (filled,) = axes.patches
    assert filled.get_facecolor() == to_rgba("#d55e0029")
    (text,) = axes.texts
    assert (text.get_text(), text.xy, text.get_ha()) == ("far", (3.0, 3.0), "right")
    assert [label.get_text() for label in axes.figure.legends[0].get_texts()] == ["one", "dot"]  # nothing that hides its name
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_ylim()) == ("p in Hz", "q", (-3.0, 5.0))


def test_campbell_backward_is_left_and_high_speed_is_up():
    report = short_report()
    amplitude = np.full_like(report.fall.amplitude, 1e-9)
    backward = int(np.argmin(np.abs(report.fall.frequency + 40.0)))
    amplitude[-1, backward], amplitude[0, backward] = 3e-4, 1e-4
    figure = campbell(with_amplitudes(amplitude), TITLE)
    image, x, y, level = image_of(figure)
    row, column = np.unravel_index(np.argmax(level), level.shape)
    assert level[row, column] == 0.0 and image.get_clim() == (-60.0, 0.0)
    assert x[column] == pytest.approx(report.fall.frequency[backward], rel=1e-4)
    assert y[row] == pytest.approx(report.fall.speed[-1], rel=1e-4) and row == len(y) - 1
    assert level[0, column] == pytest.approx(20.0 * np.log10(1.0 / 3.0))
    assert np.sum(image.cmap(1.0)[:3]) < 0.1 < 2.9 < np.sum(image.cmap(0.0)[:3])
    label = figure.axes[1].get_ylabel()
    assert "dB re 300 µm" in label
    axes = figure.axes[0]
    assert axes.get_ylabel() == "rotor speed in Hz" and "Hz" in axes.get_xlabel()
    assert axes.get_ylim()[0] < axes.get_ylim()[1] and axes.get_title() == TITLE


def test_order_lines_have_their_names_within_the_axes():
    axes = campbell(short_report(), TITLE).axes[0]
    names = {text.get_text(): text.xy for text in axes.texts}
    assert set(names) == {"\N{MINUS SIGN}2X", "\N{MINUS SIGN}1X", "+1X", "+2X"}
    for name, (x, y) in names.items():
        assert x == pytest.approx(float(name[:-1].replace("\N{MINUS SIGN}", "-")) * y, rel=1e-3)
        assert axes.get_xlim()[0] < x < axes.get_xlim()[1] and axes.get_ylim()[0] < y < axes.get_ylim()[1]


@pytest.mark.parametrize("speed", [50.0, [[0.0, 50.0], [2.0, 55.0], [4.0, 50.0]]], ids=["constant", "up and down"])
def test_over_time_where_the_speed_does_not_run_one_way(speed):
    drive = {"speed": 50.0, "duration": 2.0} if speed == 50.0 else {"speed": None, "duration": None, "schedule": speed}
    report = report_of_dict(PUMP, drive=drive)
    for figure in (campbell(report, TITLE), figures_of(report)["waterfall"]()):
        assert figure.axes[0].get_ylabel() == "time in s"
        assert {"+1X", "\N{MINUS SIGN}1X"} <= {text.get_text() for text in figure.axes[0].texts}
    for name in ("amplitude", "contact", "once_a_turn"):
        assert figures_of(report)[name]().axes[-1].get_xlabel() == "time in s"


def test_thinning_never_loses_a_line(monkeypatch):
    """One hot cell among many thin rows and columns: still there at full level, in its place."""
    monkeypatch.setattr(pictures, "MOST_ROWS", 4)
    monkeypatch.setattr(pictures, "MOST_COLUMNS", 30)
    monkeypatch.setattr(pictures, "MOST_STACKED", 3)
    report = short_report()
    amplitude = np.full_like(report.fall.amplitude, 1e-9)
    place = int(np.argmin(np.abs(report.fall.frequency + 31.0)))
    amplitude[5, place] = 1e-3
    spiked = with_amplitudes(amplitude)
    _, x, y, level = image_of(campbell(spiked, TITLE))
    row, column = np.unravel_index(np.argmax(level), level.shape)
    assert level.shape == (4, 30) and level[row, column] == 0.0 and np.sum(level > -60.0) == 1
    assert x[column] == pytest.approx(report.fall.frequency[place], abs=x[1] - x[0])
    assert y[row] == pytest.approx(report.fall.speed[5], abs=y[1] - y[0])
    stacked = stacked_lines(figures_of(spiked)["waterfall"]().axes[0])
    assert len(stacked) == 3
    tall = max(stacked, key=lambda each: np.ptp(each.get_ydata()))
    assert tall.get_xdata()[np.argmax(tall.get_ydata())] == pytest.approx(report.fall.frequency[place], abs=x[1] - x[0])


def test_windows_without_finite_data_are_marked_not_white():
    report = short_report()
    amplitude = report.fall.amplitude.copy()
    amplitude[-2:] = np.nan
    figure = campbell(with_amplitudes(amplitude), TITLE)
    image, _, _, level = image_of(figure)
    assert np.ma.getmaskarray(level)[-2:].all() and not np.ma.getmaskarray(level)[:-2].any()
    assert tuple(image.cmap.get_bad()) != tuple(image.cmap(0.0))
    assert "no finite data" in texts_of(figure)
    for nothing in (amplitude * np.nan, 0.0 * report.fall.amplitude):
        for name in ("campbell", "waterfall"):
            figures_of(with_amplitudes(nothing))[name]().canvas.draw()


def test_waterfall_lines_stand_on_their_speed_and_the_scale_bar_is_true():
    report = short_report()
    amplitude = np.zeros_like(report.fall.amplitude)
    places = [int(np.argmin(np.abs(report.fall.frequency - f))) for f in (-40.0, 20.0)]
    amplitude[3, places[0]], amplitude[1, places[1]] = 3e-4, 1e-4
    axes = figures_of(with_amplitudes(amplitude))["waterfall"]().axes[0]
    stacked = stacked_lines(axes)[::-1]  # drawn from above
    np.testing.assert_allclose([np.min(each.get_ydata()) for each in stacked], report.fall.speed, rtol=1e-4)
    heights = [np.ptp(each.get_ydata()) for each in stacked]
    assert heights[3] == pytest.approx(3 * heights[1], rel=1e-3) and heights[0] == 0.0
    assert stacked[3].get_xdata()[np.argmax(stacked[3].get_ydata())] == pytest.approx(report.fall.frequency[places[0]], rel=1e-4)
    orders = [each.get_zorder() for each in stacked]
    assert orders == sorted(orders, reverse=True)  # lower lines in front
    (bar,) = [each for each in axes.lines if each.get_xdata()[0] > report.fall.frequency[0] and len(each.get_xdata()) == 2]
    assert "300 µm" in [text.get_text() for text in axes.texts]
    assert np.ptp(bar.get_ydata()) == pytest.approx(heights[3], rel=1e-3)


@pytest.mark.parametrize(
    ("largest", "unit", "factor"),
    [(1e-9, "nm", 1e9), (3e-5, "µm", 1e6), (9.99e-4, "µm", 1e6), (1e-3, "mm", 1e3), (20.0, "m", 1.0), (5e6, "m", 1.0)],
)
def test_lengths_are_drawn_in_a_unit_that_suits_them(largest, unit, factor):
    assert unit_for(largest, "m") == (pytest.approx(factor), unit)  # no kilometres where a run diverged


def test_names_of_changes_stand_on_their_speed_and_within_the_axes():
    report = short_report()
    places = ("A", "B", 33.0), ("B", "A", 56.0)
    changes = [Transition(*names, speed, speed, speed, speed, 1.0, "agrees", "") for *names, speed in places]
    axes = figures_of(replace(report, transitions=changes))["amplitude"]().axes[0]
    names = {text.get_text(): (text.xy[0], text.get_ha()) for text in axes.texts}
    assert names == {"A to B: 33.0 Hz": (33.0, "left"), "B to A: 56.0 Hz": (56.0, "right")}
    assert axes.get_ylim()[0] == 0.0


def test_strips_stand_above_each_other_over_one_abscissa():
    report = report_of_dict(PUMP, contact={"diameter": 0.05})
    figure = figures_of(report)["contact"]()
    labels = [" ".join(axes.get_ylabel().split()) for axes in figure.axes]
    assert [label.rpartition(" in ")[0] for label in labels] == [
        "normal force", "friction power", "time in contact", "slip velocity (0: rolling)"
    ]
    share = next(axes for axes, label in zip(figure.axes, labels, strict=True) if "time in contact" in label)
    np.testing.assert_allclose(share.lines[0].get_ydata(), 100.0 * report.strip.share, rtol=1e-4)
    assert [axes.get_xlabel() for axes in figure.axes] == ["", "", "", "rotor speed in Hz"]
    assert len({axes.get_xlim() for axes in figure.axes}) == 1


@pytest.mark.parametrize(("name", "start"), [("a.png", b"\x89PNG"), ("a.pdf", b"%PDF"), ("a.svg", b"<?xml")])
def test_save_writes_what_the_ending_says(tmp_path, name, start):
    plots.save(campbell(short_report(), TITLE), tmp_path / name)
    assert (tmp_path / name).read_bytes().startswith(start)


def test_save_refuses_in_one_line(tmp_path):
    figure = figures_of(short_report())["once_a_turn"]()
    for path in (tmp_path / "a.unknown", tmp_path / "no folder" / "a.png"):
        with pytest.raises(DataError, match=r"picture not written|cannot be written"):
            plots.save(figure, path)


def survey_of(branches=(), rubs=(), ratios=()):
    """A survey as far as its map reads it."""
    contact = SimpleNamespace(gap=1e-3)
    scene = SimpleNamespace(title="map", contact=contact, contacts=(contact,))
    return SimpleNamespace(rolls={}, scene=scene, branches=branches, rubs=rubs, ratios=ratios)


def branch_of(label, frequency, amplitude, *events):
    """A branch over 20 to 100 Hz that is unstable at the end of the range."""
    ends = (Event(RANGE_END, 20.0, 0.0), Event(RANGE_END, 100.0, 0.0))
    stable, speed = np.array([True, True, False]), np.array([20.0, 60.0, 100.0])
    motion = {"frequency": frequency, "amplitude": amplitude, "stable": stable, "growth_rate": np.where(stable, -1.0, 1.0)}
    motion |= {"touches": ((),) * 3, "pressed": ()}
    return SimpleNamespace(label=label, values=speed, begin=ends[0], end=ends[1], events=events, **motion)


def test_the_map_joins_the_whirls_whose_forces_pass_their_limit():
    speed = np.array([20.0, 60.0, 100.0])
    left = Event("stable (oscillatory)", 62.0, -18.6, "below")
    branches = [
        branch_of("A", -0.3 * speed, 3e-3 - 1e-5 * speed, left), branch_of("B", -60.0 + 0.0 * speed, 5e-3 + 0.0 * speed),
        branch_of("far out", -300.0 + 0.0 * speed, 1e-4 + 0.0 * speed),
    ]
    ratio = SimpleNamespace(label="A", towards="B", speed=61.0, ratio=0.493)
    figure = branch_map(survey_of(branches, ratios=[ratio]))
    top, bottom = figure.axes
    line, below = line_with(top, "F_N of A is 0.493 F_N of B"), line_with(bottom, "F_N of A is 0.493 F_N of B")
    np.testing.assert_allclose(line.get_xydata(), [[61.0, -18.3], [61.0, -60.0]], rtol=1e-4)
    np.testing.assert_allclose(below.get_xydata(), [[61.0, 2.39], [61.0, 5.0]], rtol=1e-4)
    (cross,) = [each for each in top.lines if each.get_marker() == "x"]
    np.testing.assert_allclose(cross.get_xydata(), [[61.0, -18.3]], rtol=1e-4)  # on A alone, over the mark of the event beside it
    mark = line_with(top, "flutter (Hopf)")
    np.testing.assert_allclose(mark.get_xydata(), [[62.0, -18.6]])
    assert cross.get_zorder() > mark.get_zorder() and mark.get_marker() == "o"
    assert {text.get_text() for text in top.texts} == {"A", "B"}  # roots below the gap are left out
    assert (top.get_xlabel(), bottom.get_xlabel()) == ("", "rotor speed in Hz")
    plain = branch_map(survey_of(branches))
    assert len(plain.axes[0].lines) < len(top.lines)


def test_the_map_and_the_text_say_alike_what_is_claimed_of_a_forward_rub():
    """Unstable, stable, no circle and stable again, over 80 to 100 Hz; the changes lie within a step of the grid."""
    speed, changes = np.linspace(80.0, 100.0, 41), (84.6, 90.2, 93.3)
    kinds = np.searchsorted(changes, speed)
    events = tuple(RubEvent("some", change) for change in changes)
    rates, mirror = np.where(kinds > 0, -1.0, 1.0), np.where(kinds == 2, 0.3, 0.05)
    size, within = 2e-3 + 0.0 * speed, 0.0 * speed
    rub = RubRange(1, RubEvent(TOUCH, 79.8), RubEvent(RANGE_END, 100.0), events, speed, size, rates, mirror, within)
    bottom = branch_map(survey_of(rubs=[rub])).axes[1]
    told = {"unstable": ("--", kinds == 0), "stable": ("-", kinds % 2 == 1)}
    told["not circular: stability not assessed"] = (":", kinds == 2)
    for name, (style, wanted) in told.items():
        line = line_with(bottom, f"forward rub, {name}")
        drawn = np.isfinite(line.get_ydata())
        assert line.get_linestyle() == style and drawn[wanted].all()
        reach = wanted | np.append(wanted[1:], False) | np.insert(wanted[:-1], 0, False)
        assert not drawn[~reach].any() and (name != "stable" or not drawn[~wanted].any())  # no hole, and nothing more
    words = "stable 84.6 .. 90.2 Hz and 93.3 .. 100 Hz, not circular (stability not assessed) 90.2 .. 93.3 Hz"
    assert stable_stretches(rub) == words
    assert stable_stretches(replace(rub, mirror=0.0 * mirror)) == "stable 84.6 .. 100 Hz"
    assert stable_stretches(replace(rub, growth_rate=1.0 + 0.0 * rates)) == "unstable"
    assert stable_stretches(replace(rub, growth_rate=-1.0 + 0.0 * rates, mirror=0.0 * mirror)) == "stable"
    nothing = replace(rub, growth_rate=-1.0 + 0.0 * rates, mirror=1.0 + mirror)
    assert stable_stretches(nothing) == "not circular: stability not assessed"


@pytest.mark.parametrize("kind", ["campbell", "waterfall", "amplitude", "orbit", "contact", "once_a_turn"])
def test_text_is_inside_the_figure_and_nowhere_over_other_text(kind, monkeypatch):
    figure = figures_of(short_report())[kind]()
    figure.canvas.draw()  # the layout settles
    drawn = []
    monkeypatch.setattr(Text, "draw", lambda text, renderer: drawn.append(text))
    figure.canvas.draw()
    drawn = [text for text in drawn if text.get_visible() and text.get_text().strip()]
    boxes = [(text.get_text(), text.get_window_extent()) for text in drawn]
    assert len(boxes) > 10
    for name, box in boxes:
        assert box.x0 >= 0 and box.y0 >= 0, name
        assert box.x1 <= figure.bbox.width and box.y1 <= figure.bbox.height, name
    for i, (name, box) in enumerate(boxes):
        for other_name, other in boxes[:i]:
            assert not box.overlaps(other), (name, other_name)


def test_threads_draw_the_same_picture(tmp_path):
    report = short_report()

    def drawn(i):
        plots.save(campbell(report, "t"), tmp_path / f"{i}.png")
        return (tmp_path / f"{i}.png").read_bytes()

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(drawn, range(4)))
    assert all(picture == found[0] for picture in found)


def test_matplotlib_is_lazy_and_pyplot_never_loaded():
    code = (
        "import sys, rsc, rsc.measure.spectra; assert 'matplotlib' not in sys.modules, 'early'; "
        "import rsc.show.pictures.plots; assert 'matplotlib.pyplot' not in sys.modules, 'pyplot'"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_title_that_is_no_mathematics_is_drawn_as_it_is(tmp_path):
    title = r"50 $ rotor, \frac{1 $"
    figure = campbell(short_report(), title)
    plots.save(figure, tmp_path / "a.png")
    assert title.replace("$", r"\$") in texts_of(figure) and (tmp_path / "a.png").stat().st_size > 10_000
    plots.save(plots.side_by_side(paths.moments(short_report(), moments(short_report())), title), tmp_path / "a.png")


def test_a_picture_does_not_replace_what_is_none(tmp_path):
    figure = figures_of(short_report())["once_a_turn"]()
    (tmp_path / "a.png").write_text("notes")
    for name, problem in {"a.png": "did not write", "a.toml": "must end with", "": "must end with"}.items():
        with pytest.raises(DataError, match=problem):
            plots.save(figure, tmp_path / name)
    assert (tmp_path / "a.png").read_text() == "notes"


def test_a_stator_that_moves_has_a_campbell_picture(tmp_path):
    report = short_report()
    names = [path.name for path in draw(report, tmp_path)]
    assert "campbell_stator.png" in names and (tmp_path / "campbell_stator.png").stat().st_size > 10_000
    assert not np.array_equal(image_of(campbell(report, "t", report.stator_fall))[3], image_of(campbell(report, "t"))[3])
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


def test_paths_have_one_unit_and_one_legend_and_no_distortion():
    figure = figures_of(short_report())["orbit"]()
    figure.canvas.draw()
    shown = [axes for axes in figure.axes if axes.get_visible()]
    assert len(shown) == len(moments(short_report())) and all(axes.get_aspect() == 1.0 for axes in shown)
    named = [text.get_text() for text in figure.legends[0].get_texts()]
    assert len(named) == len(set(named)) and {"rotor", "gap", "once a revolution"} <= set(named)
    assert {axes.get_ylabel() for axes in shown} == {"", "z in mm"}


def test_an_animation_has_a_frame_a_window(tmp_path):
    report = short_report()
    with Image.open(io.BytesIO(animation(report, tmp_path / "orbit.gif").content)) as image:
        assert image.n_frames == min(FRAMES, len(report.fall.speed))


def test_a_notebook_plays_the_orbit():
    report = short_report()
    text = report.animate()._repr_html_()
    pictures = re.findall(r'frames\[\d+\] = "data:image/png;base64,([^"]+)', text)
    assert len(pictures) == len(set(pictures)) == min(FRAMES, len(report.fall.speed)) and "<script" in text
