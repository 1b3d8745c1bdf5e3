"""`plot` of every result: on the axes that are given, in the descriptions of the page; and reprs that fit a terminal."""

from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

import rsc
from rsc.show.pictures.album import PICTURES
from scenes import LAVAL, changed

matplotlib.use("Agg")
ROOT = Path(__file__).parents[3]
SCENE = rsc.Scene.from_dict(changed(LAVAL, drive={"speed": 50.0, "duration": 0.5}))


@pytest.fixture(scope="module")
def report():
    return rsc.check(SCENE)


@pytest.fixture(scope="module")
def listed():
    return rsc.motions(SCENE, 50.0, starts=6)


@pytest.fixture
def ax():
    return Figure().subplots()


def drawn_lines(ax):
    return {line.get_label(): line for line in ax.lines}


def test_an_orbit_is_that_of_the_samples(report, ax):
    run = report.result
    assert run.plot("orbit", ax, time=(0.3, 0.4)) is ax
    inside = (run.time >= 0.3) & (run.time < 0.4)
    shown = drawn_lines(ax)["rotor"].get_xydata()
    assert np.allclose(shown[:, 0], 1e3 * run.contact_rotor()[inside].real, atol=1e-4)
    assert ax.get_xlabel() == "y in mm" and ax.get_legend() is not None


def test_an_envelope_and_a_spectrum(report, ax):
    run = report.result
    run.plot("envelope", ax)
    assert drawn_lines(ax)["largest"].get_ydata().max() == pytest.approx(1e3 * np.abs(run.contact_rotor()).max(), rel=1e-3)
    ax.clear()
    run.plot("spectrum", ax, time=0.25)
    x, y = drawn_lines(ax)["at 50 Hz"].get_data()
    whirl = next(whirl for whirl in rsc.predict(SCENE, 50.0) if whirl.stable)
    assert x[np.argmax(y)] == pytest.approx(whirl.frequency, abs=1.0 / run.scene.drive.duration * 4)


@pytest.mark.parametrize("arguments", [{"kind": "orbits"}, {"time": 7.0}, {"time": (0.4, 0.3)}])
def test_what_cannot_be_drawn_of_a_run_is_refused(arguments, report, ax):
    with pytest.raises(rsc.SceneError):
        report.result.plot(ax=ax, **arguments)


def test_every_picture_of_a_report_draws_what_page_and_files_have(report):
    seen = 0
    for name in ("orbit", *PICTURES):
        ax = Figure().subplots()
        try:
            assert report.plot(name, ax) is ax and ax.has_data()
            seen += 1
        except rsc.SceneError as error:
            assert "something to show" in str(error)
    assert seen > 8
    with pytest.raises(rsc.SceneError, match="one of orbit, machine"):
        report.plot("cambell")


def test_a_style_is_matplotlibs(report, ax):
    report.result.plot("envelope", ax, color="black", lw=3)
    assert {line.get_color() for line in ax.lines} == {"black"} and {line.get_linewidth() for line in ax.lines} == {3.0}


def test_spectra_and_their_cascade(report):
    fall = rsc.waterfall(report.result)
    for draw in (fall.plot, fall.plot_cascade, report.envelope.plot):
        assert draw(Figure().subplots()).has_data()


def test_whirls_over_the_speed(ax):
    speeds = np.linspace(20.0, 80.0, 13)
    many = rsc.predict_many([SCENE], speeds)
    many.plot(ax)
    shown = drawn_lines(ax)["predicted whirl, stable"].get_xydata()
    expected = many.frequency[0][many.stable[0]]
    assert sorted(shown[:, 1]) == pytest.approx(sorted(expected), rel=1e-4)
    assert rsc.predict(SCENE, 50.0).plot(Figure().subplots()).has_data()
    assert rsc.modes(SCENE, [20.0, 40.0, 60.0]).plot(Figure().subplots()).has_data()


def test_motions_are_a_sequence_and_draw_their_impacts(listed, ax):
    assert len(listed) == len(listed.motions) and list(listed) == listed.motions and listed[0] is listed.motions[0] and listed
    listed.plot(ax)
    assert sum(len(line.get_xdata()) for line in ax.lines) >= 6


def test_without_axes_a_figure_of_pyplot_is_made(report):
    from matplotlib import pyplot

    before = pyplot.get_fignums()
    ax = report.result.plot()
    assert len(pyplot.get_fignums()) == len(before) + 1
    pyplot.close(ax.figure)


def test_the_page_is_written_as_the_command_writes_it(report, tmp_path):
    from rsc.show.page import page

    report.save_html(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8").count("<figure") == page(report).count("<figure") > 5
    (tmp_path / "mine.html").write_text("mine")
    with pytest.raises(rsc.DataError):
        report.save_html(tmp_path / "mine.html")
    report.save_html(tmp_path / "mine.html", overwrite=True)


def test_reprs_fit_a_terminal(report, listed):
    fall = rsc.waterfall(report.result)
    whirls = rsc.predict(SCENE, 50.0)
    many = rsc.predict_many([SCENE], np.linspace(10.0, 90.0, 81))
    campbell = rsc.modes(SCENE, np.linspace(10.0, 90.0, 9))
    peaks = rsc.spectral_peaks(report.result)
    for value in (SCENE, report, report.result, fall, peaks, report.envelope, whirls, many, campbell, campbell[0], listed):
        text = repr(value)
        assert text.count("\n") < 5 and len(text) <= 520 and type(value).__name__ in text, text
    assert "finished at 0.5 s" in repr(report.result) and "float64" in repr(fall)


@pytest.fixture(scope="module")
def grid():
    return rsc.sweep(SCENE, {"contact.friction": "0.05:0.3:4", "drive.speed": "40:60:3"}, ["predict", "mu_min"])


def test_a_map_of_a_sweep_is_that_of_the_command(grid, ax, tmp_path):
    """The cells of the axes are those of the file's picture; also of a dataset that went through a file."""
    import xarray

    from rsc.show.sweeps.pictures import pictures
    from rsc.study.sweep.plan import make_plan
    from rsc.study.sweep.sweep import computed

    varied = rsc.cases(SCENE, {"contact.friction": "0.05:0.3:4", "drive.speed": "40:60:3"})
    kept = computed(make_plan(SCENE, varied, "predict"), None)
    kept.save(tmp_path / "sweep.nc")
    drawn = pictures(kept)["force_predicted"].axes[0]
    with xarray.open_dataset(tmp_path / "sweep.nc") as data:
        assert rsc.plot_sweep(data, "force_predicted", ax) is ax
    cells, expected = (each.collections[0].get_array().filled(-1.0) for each in (ax, drawn))
    assert np.array_equal(cells, expected) and expected.max() > 100.0
    assert (ax.get_xlabel(), ax.get_ylabel()) == (drawn.get_xlabel(), drawn.get_ylabel())
    assert rsc.plot_sweep(grid).get_legend().get_texts()[0].get_text().startswith(("no whirl", "a whirl"))


def test_quantities_over_one_key_stand_alone(grid, ax):
    part = grid.sel({"drive.speed": 50.0})
    rsc.plot_sweep(part, "normal_force", ax)
    forces = part.normal_force.values[part.stable.values & part.admissible.values & (part.frequency.values < 0.0)]
    shown = np.concatenate([line.get_ydata() for line in ax.lines if line.get_markerfacecolor() != "white"])
    assert np.nanmax(shown) == pytest.approx(forces.max(), rel=1e-6) and "normal force" in ax.get_ylabel()


def test_what_a_sweep_does_not_have_is_refused_with_what_it_has(grid, ax):
    with pytest.raises(rsc.SceneError, match=r"one of danger, .*force_predicted"):
        rsc.plot_sweep(grid, "verdict", ax)
    with pytest.raises(rsc.SceneError, match="2 values or more"):
        rsc.plot_sweep(grid.isel({"drive.speed": 0, "contact.friction": 0}), ax=ax)
    with pytest.raises(rsc.SceneError, match="Dataset of"):
        rsc.plot_sweep(grid.assign_attrs(computed="predict").drop_attrs(), ax=ax)


def test_the_amplitudes_of_another_run_stand_beside(ax):
    up, down = (rsc.check(SCENE.with_values({"drive.speed": speeds})) for speeds in ([40.0, 60.0], [60.0, 40.0]))
    alone, both = up.plot("amplitude", Figure().subplots()), up.plot("amplitude", ax, others=[down])
    assert len(both.lines) > len(alone.lines)
