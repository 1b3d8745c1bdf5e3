"""Units of display: one table, chosen by a command or a scene; what is computed and JSON stay as they are."""

import json
import re

import numpy as np
import pytest

import rsc
from reports import PUMP, report_of_dict
from rsc.analysis.alone.critical_map import CriticalMap, MappedBearing
from rsc.cli import main
from rsc.errors import SceneError
from rsc.scene.tables import display
from rsc.show.page import page
from rsc.show.pictures.abscissa import Abscissa
from rsc.show.pictures.album import described
from rsc.show.pictures.critical_map import critical_speeds, map_text
from rsc.show.sweeps import pictures as sweep_pictures
from rsc.show.sweeps.page import sweep_page
from rsc.show.words.answer import answer
from rsc.show.words.plain import report_plain
from rsc.show.words.table import exact, in_units
from rsc.show.words.text import report_text
from rsc.show.words.units import SYSTEMS, column, shown_in, unit_for
from rsc.show.words.wording import amount, frequency_text, length, sentence_in_units, speed_range, speed_text, vibration
from rsc.study.sweep.plan import make_plan
from rsc.study.sweep.sweep import computed
from rsc.study.sweep.vary import cases


@pytest.fixture(scope="module")
def report():
    return report_of_dict(PUMP, start={"whirl": "backward"}, drive={"speed": [30.0, 40.0], "duration": 2.0})


def test_the_systems_are_those_that_a_scene_may_name():
    assert tuple(SYSTEMS) == display.SYSTEMS


@pytest.mark.parametrize(
    ("system", "texts"),
    [
        ("si", ["25.4 um", "1.2 mm", "4.45 N", "50.00 Hz (3000 rpm)", "25.4 um pk-pk", "746 W", "113 mN m"]),
        ("metric", ["25.4 um", "1.2 mm", "4.45 N", "3000 rpm", "25.4 um pk-pk", "746 W", "113 mN m"]),
        ("us", ["1 mil", "47.2 mil", "1 lbf", "3000 rpm", "1 mil pk-pk", "1 hp", "1 lbf in"]),
    ],
)
def test_a_quantity_has_the_unit_of_the_system(system, texts):
    with shown_in(system):
        told = [length(25.4e-6), length(1.2e-3), amount(4.4482216, "N"), speed_text(50.0), vibration(25.4e-6)]
        assert [*told, amount(745.69987, "W"), amount(0.11298483, "N m")] == texts
    assert column("Hz") == (1.0, "Hz")  # it has ended


@pytest.mark.parametrize(("size", "text"), [(0.0253, "996 mil"), (0.0255, "1 in"), (0.0, "0 mil"), (float("inf"), "inf mil")])
def test_a_unit_fits_the_size(size, text):
    with shown_in("us"):
        assert length(size) == text
    with shown_in("metric"):
        assert unit_for(0.9e-3, "m")[1] == "um" and unit_for(1.1e-3, "m")[1] == "mm"


def test_frequencies_keep_their_digits_and_their_sign():
    assert frequency_text(-67.93) == "-67.93 Hz" and frequency_text(70.04, ".1f") == "70.0 Hz"
    with shown_in("metric"):
        assert frequency_text(-67.93) == "-4076 rpm" == frequency_text(-67.93, ".1f")
        assert speed_range([20.0, 60.0]) == "1200 to 3600 rpm" and speed_range([50.0, 50.0]) == "3000 rpm"


@pytest.mark.parametrize(("text", "shown"), [
    ("whirl -67.9000 Hz: grows at 1.5 1/s", "whirl -4074 rpm: grows at 1.5 1/s"),
    ("coefficients from 10 to 80 Hz are constant beyond", "coefficients from 600 to 4800 rpm are constant beyond"),
    ("F_N 444.82216 N, 2 N s, 3 N/m, 4 Hz/s", "F_N 100 lbf, 2 N s, 3 N/m, 4 Hz/s"),
    ("a gap of 0.254 mm, no rotor stands 500 m/s", "a gap of 10 mil, no rotor stands 19685 in/s"),
])  # fmt: skip
def test_remarks_of_the_analysis_follow_the_units(text, shown):
    assert sentence_in_units(text) == text
    with shown_in("us"):
        assert sentence_in_units(text) == shown


def test_maps_of_a_sweep_follow_the_units():
    scene = rsc.Scene.from_dict({**report_scene(), "report": {"units": "us"}})
    data = computed(make_plan(scene, cases(scene, {"drive.speed": "45,50"}), "predict"), None)
    assert sweep_pictures.side(data, "drive.speed").label.endswith("in Hz")
    (figure,) = sweep_pictures.pictures(data).values()
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert figure.axes[-1].get_xlabel().endswith("in rpm")
    assert {"whirl frequency\nin rpm", "normal force\nin lbf"} <= set(labels)
    text = sweep_page(data)
    assert " lbf" in text and " rpm" in text
    with shown_in("si"):
        assert " lbf" not in sweep_page(data).partition("Origin")[0]


def test_run_and_info_tell_energies_in_the_units_that_are_chosen(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(rsc.Scene.from_dict(report_scene()).to_toml(), encoding="utf-8")
    result = str(tmp_path / "run.h5")
    assert main(["run", str(tmp_path / "scene.toml"), "-o", result, "--units", "us"]) == 0
    told = capsys.readouterr().out
    assert "energy in ft lbf: in " in told
    assert main(["info", result]) == 0
    plain = capsys.readouterr().out
    assert "energy in J: in " in plain
    feet, joules = (float(re.search(r": in ([-\d.e+]+)", text)[1]) for text in (told, plain))
    assert joules == pytest.approx(1.3558 * feet, rel=2e-3)


def test_columns_of_tables_are_in_the_unit_of_their_header():
    header, rows = ("speed Hz", "rpm", "|r|/gap", "F_N N", "motion"), [("50", "3000", "2.143", "681.8", "whirl of 3 N")]
    assert in_units(header, rows) == (header, rows)
    with shown_in("us"):
        names, cells = in_units(header, [*rows, ("20 .. 60", "1200", "1", "-", "")])
    assert names == ("speed rpm", "|r|/gap", "F_N lbf", "motion")  # rpm are there once
    assert cells == [["3000", "2.143", "153.3", "whirl of 3 N"], ["1200 .. 3600", "1", "-", ""]]


def test_a_speed_is_rounded_once_in_the_unit_that_is_shown(capsys, tmp_path):
    """7000 rpm are 116.7 Hz, which are 7002 rpm."""
    (tmp_path / "scene.toml").write_text(rsc.Scene.from_dict({**PUMP, "drive": {"speed": 50.0, "duration": 0.1}}).to_toml())
    for options in (["modes", "--speeds", "6000:7000 rpm:4"], ["predict", "--speed", "7000 rpm"]):
        command, *rest = options
        assert main([command, str(tmp_path / "scene.toml"), *rest, "--units", "metric"]) == 0
        told = capsys.readouterr().out
        assert re.search(r"^\s*7000 ", told, re.MULTILINE), told
    with shown_in("metric"):
        assert in_units(("speed Hz", ""), [(exact("0.3333 .. 116.7", 1.0 / 3.0, 7000.0 / 60.0), "")])[1] == [["20 .. 7000", ""]]


def test_the_map_over_the_stiffness_has_the_units_of_its_table():
    bearing = MappedBearing("left", np.array([0.0]), np.array([1e7]), True)
    made = CriticalMap(np.array([1e6, 1e8]), np.array([[50.0], [100.0]]), (bearing,))
    with shown_in("us"):
        text, layout = map_text(made, ""), critical_speeds(made)
    assert "stiffness lbf/in" in text and "in rpm" in text and " N/m" not in text and " Hz" not in text
    titles = [layout["layout"][axis]["title"] for axis in ("xaxis", "yaxis")]
    assert titles == ["stiffness of the bearings in lbf/in", "rotor speed in rpm"]
    curve = layout["data"][0]
    assert curve["y"] == pytest.approx([3000.0, 6000.0]) and curve["x"][0] == pytest.approx(1e6 * 0.0254 / 4.4482216, rel=1e-4)


def test_the_answer_has_no_other_units_and_json_has_none_of_them(report):
    si = report_plain(report)
    with shown_in("us"):
        told = dict(answer(report))
        assert json.dumps(report_plain(report)) == json.dumps(si)
    for topic in ("whirl", "frequency", "vibration", "closest approach", "force", "at the end"):
        assert not re.search(r"\b(Hz|N|um|mm|W)\b", told[topic]), told[topic]
    texts = dict(answer(report))["vibration"], told["vibration"]
    microns, mils = (float(re.match(r"up to ([\d.]+)", text)[1]) for text in texts)
    assert mils == pytest.approx(microns / 25.4, rel=0.01)


def test_axes_of_pictures_and_what_is_drawn_along_them_change_together(report):
    si = described(report, Abscissa(report))
    with shown_in("us"):
        us = described(report, Abscissa(report))
    for name, picture in us.items():
        titles = [picture["layout"][axis]["title"] for axis in ("xaxis", "yaxis")]
        assert not [title for title in titles if re.search(r"in (Hz|[µm]?m|k?N|k?W)\b", title)], (name, titles)
    along = [(picture["campbell"]["data"][0]["y"], picture["campbell"]["data"][0]["x"]) for picture in (si, us)]
    for letter in (0, 1):
        assert along[1][letter] == pytest.approx([60.0 * value for value in along[0][letter]], rel=1e-4)
    ranges = [picture["campbell"]["layout"]["xaxis"]["range"] for picture in (si, us)]
    assert ranges[1] == pytest.approx([60.0 * x for x in ranges[0]])
    gaps = [next(trace for trace in picture["amplitude"]["data"] if trace["name"] == "gap")["y"][0] for picture in (si, us)]
    gap = report.contact.gap
    assert gaps[1] == pytest.approx(gap / 25.4e-6, rel=1e-3) or gaps[1] == pytest.approx(gap / 25.4e-3, rel=1e-3)


def test_a_scene_chooses_units_and_an_option_goes_before_it(tmp_path, capsys):
    content = rsc.Scene.from_dict({**report_scene(), "report": {"units": "metric"}})
    assert rsc.Scene.from_toml(content.to_toml()) == content and content.mirrored().report == content.report
    (tmp_path / "scene.toml").write_text(content.to_toml(), encoding="utf-8")
    path = str(tmp_path / "scene.toml")

    def header(*options):
        assert main(["predict", path, "--speed", "50", *options]) == 0
        return capsys.readouterr().out.splitlines()[0].split("  ")[0]

    assert header() == "speed rpm" and header("--units", "si") == "speed Hz" and header("--units", "us") == "speed rpm"
    assert column("Hz") == (1.0, "Hz")  # the next command asks its own scene
    plain = []
    for options in ((), ("--units", "us")):
        assert main(["predict", path, "--speed", "50", "--json", *options]) == 0
        plain.append(capsys.readouterr().out)
    assert plain[0] == plain[1]


def report_scene():
    return {**PUMP, "drive": {"speed": 50.0, "duration": 0.1}}


def test_the_interface_shows_what_the_scene_asks_for():
    report = report_of_dict(PUMP, drive={"speed": 50.0, "duration": 0.3}, start={"rest": True}, report={"units": "us"})
    assert "rpm" in report_text(report) and " Hz" not in report_text(report).split("mu_min")[0].split("not excluded")[0]
    assert "amplitude in" not in page(report) or "mil" in page(report)


def test_other_units_are_refused_in_one_line():
    with pytest.raises(SceneError, match=r"report\.units = 'furlong': must be one of"):
        rsc.Scene.from_dict({**report_scene(), "report": {"units": "furlong"}})
    with pytest.raises(SceneError, match=r"report\.unit\b"):
        rsc.Scene.from_dict({**report_scene(), "report": {"unit": "us"}})
