"""report.html without a browser: what it says, that it is whole, bounded and inert; in a browser: test_page_browser."""

import base64
import hashlib
import json
import math
import re
from dataclasses import replace
from html import escape

import numpy as np
import pytest

from packed import Elements, unpacked
from reports import PUMP, report_of_dict, short_report
from rsc.errors import DataError
from rsc.measure.catalogue import WHIRLING
from rsc.measure.changes import Transition
from rsc.measure.features import turns
from rsc.measure.kinds import BACKWARD, Kind
from rsc.measure.stretches import COLUMNS as STRETCH_COLUMNS
from rsc.measure.stretches import Stretches
from rsc.measure.verdict import Window
from rsc.measure.windows import Best
from rsc.measure.words import AGREES, AMPLITUDE
from rsc.show.page import page, write_page
from rsc.show.page.svg import _corners, _tenths, svg, ticks
from rsc.show.pictures import paths, pictures
from rsc.show.pictures.abscissa import Abscissa
from rsc.show.pictures.moments import MOST, marks_of, moments, once_per_turn
from rsc.show.pictures.traces import BLUE, line, thinned
from rsc.show.words.answer import COLUMNS, answer, answer_text
from rsc.show.words.reasons import percent
from rsc.show.words.wording import hertz

HOSTILE = '</title><script>alert("x")</script><img src=x onerror=alert(1)> </script> $ & \u2028 <!-- '


@pytest.fixture(scope="module")
def report():
    return short_report()


@pytest.fixture(scope="module")
def text(report):
    return page(report)


def data_of(text):
    return json.loads(unpacked(text, "report"))


def test_the_page_asks_for_nothing_outside_and_is_small(text):
    assert len(text.encode()) < 0.9e6
    for tag, attributes in Elements(text).tags:
        for name in ("src", "href", "action"):
            assert attributes.get(name, "data:").startswith("data:"), tag
    assert "default-src 'none'" in text


def test_every_picture_is_there_on_paper_and_for_the_script(text, report):
    elements = Elements(text)
    names = {attributes["id"] for tag, attributes in elements.tags if attributes.get("class") == "plot"}
    assert names == set(data_of(text)["pictures"])
    assert {"campbell", "amplitude", "whirl_line", "force", "power", "share", "polar", "energy"} <= names
    assert {"bode_amplitude", "bode_phase"} <= names
    assert sum(name.startswith("moment") for name in names) == len(moments(report))
    assert sum(attributes.get("class") == "static" for _, attributes in elements.tags) == len(names)
    for words in ("gap = ", "SHA-256", report.result.summary.versions, "error of a step", "begin and end"):
        assert words in text


@pytest.mark.parametrize("title", [HOSTILE, "", "x" * 5000, "$\\frac{1}{$ %s {0}"])
def test_a_title_is_text_and_nothing_else(report, title):
    plain, scene = page(report), report.result.scene
    hostile = page(replace(report, result=replace(report.result, scene=replace(scene, title=title))))
    kinds = [[tag for tag, _ in Elements(page_).tags] for page_ in (plain, hostile)]
    assert kinds[0] == kinds[1]
    assert not any(name.startswith("on") for _, attributes in Elements(hostile).tags for name in attributes)
    data_of(hostile)


def test_texts_of_a_report_cannot_end_the_script_of_its_data(report):
    windows = [Window(*(replace(row, verdict=HOSTILE, branch=HOSTILE) for row in window)) for window in report.windows]
    hostile = page(replace(report, windows=windows, warnings=[HOSTILE], agreement=HOSTILE))
    assert data_of(hostile)["cursor"]["verdict"][0] == HOSTILE
    assert [tag for tag, _ in Elements(hostile).tags].count("script") == 4  # data, plotly, its licences, page.js
    assert [tag for tag, _ in Elements(hostile).tags].count("img") == 0


def test_a_warning_stands_with_the_answer(report):
    text = page(replace(report, warnings=["the contact gives way"]))
    assert "<dt>note</dt><dd>the contact gives way</dd></dl></section>" in text and text.count("the contact gives way") == 1


def test_numbers_that_are_none_do_not_reach_the_page(report):
    best = Best(*(np.full(len(report.fall.speed), np.nan) for _ in range(7)))
    bare = replace(report, branches=[], transitions=[], best=best, rub=(report.rub[0], np.full_like(report.rub[1], np.nan)))
    text = page(bare)
    assert "NaN" not in unpacked(text, "report").decode() and not re.search(r'[ "](nan|inf)[ "<]', text.partition("<script")[0])
    assert "No whirl that slides is predicted" in text


def test_amplitudes_keep_the_largest_of_what_they_thin(report, monkeypatch):
    monkeypatch.setattr(pictures, "MOST_ROWS", 5)
    monkeypatch.setattr(pictures, "MOST_COLUMNS", 7)
    place = np.unravel_index(report.fall.amplitude.argmax(), report.fall.amplitude.shape)
    spiked = report.fall.amplitude.copy()
    spiked[place] *= 1000.0
    along = Abscissa(report)
    traces = pictures.campbell(replace(report, fall=replace(report.fall, amplitude=spiked)), along)["data"]
    (drawn,) = [trace for trace in traces if "z" in trace]
    levels = np.frombuffer(base64.b64decode(drawn["z"]["bdata"]), dtype=np.int8)
    assert levels.size == 35 and levels.max() == 0 and (levels == 0).sum() == 1


def test_a_thinned_line_keeps_its_spikes():
    y = np.zeros(100_000)
    y[[37_123, 61_001]] = 5.0, -7.0
    x, kept = thinned(np.arange(y.size), y, 600)
    assert len(x) <= 600 and kept.max() == 5.0 and kept.min() == -7.0
    assert x[kept == 5.0] == 37_123


def test_backward_is_left_and_predictions_are_full_where_stable(report):
    along = Abscissa(report)
    traces = pictures.campbell(report, along)["data"]
    stable = [trace for trace in traces if trace["name"] == "predicted whirl, stable"]
    assert stable and all(trace["line"]["dash"] == "solid" for trace in stable)
    assert all(value is None or value < 0.0 for trace in stable for value in trace["x"])


def test_moments_are_few_in_order_and_hold_the_largest_motion(report):
    chosen = moments(report)
    windows = [moment.window for moment in chosen]
    assert 1 <= len(chosen) <= MOST and windows == sorted(set(windows))
    assert int(np.argmax(np.abs(report.orbits.rotor).max(axis=1))) in windows


def test_marks_of_a_path_are_a_turn_apart(report):
    for window in (0, len(report.fall.speed) - 1):
        times = report.orbits.time[window][marks_of(report, window)]
        step = np.diff(report.orbits.time[window])[0]
        assert np.diff(times) == pytest.approx(1.0 / report.fall.speed[window], abs=1.5 * step)


def test_positions_once_a_turn_are_those_between_the_samples(report):
    scene, window = report.result.scene, 3
    path = 1e-3 * np.exp(-2j * np.pi * 44.0 * report.orbits.time)
    found = once_per_turn(replace(report, orbits=replace(report.orbits, rotor=path)), window)
    fine = np.linspace(*report.orbits.time[window][[0, -1]], 200_001)
    exact = 1e-3 * np.exp(-2j * np.pi * 44.0 * fine[1:][np.diff(np.floor(turns(scene.drive, fine))) > 0.0])
    assert len(found) >= len(exact) - 1 > 0
    assert max(np.abs(exact - each).min() for each in found) < 5e-6


def test_the_whirl_line_stands_beside_its_prediction(report):
    drawn = pictures.whirl_line(report, Abscissa(report))
    rows = [row for row in report.rows if row.quantity == AMPLITUDE]
    assert len(drawn["data"]) == 2 and all(row.branch for row in rows)
    for trace, name in zip(drawn["data"], ("simulated", "predicted"), strict=True):
        assert name in trace["name"] and drawn["layout"]["yaxis"]["title"] == "whirl line in mm"
        assert trace["y"] == pytest.approx([1e3 * getattr(row, name) for row in rows], rel=1e-4)
    lost = [Window(*(replace(row, branch="") for row in window)) for window in report.windows]
    assert pictures.whirl_line(replace(report, windows=lost), Abscissa(report)) is None
    assert "whirl_line" not in data_of(page(replace(report, windows=lost)))["pictures"]


def test_a_loaded_shaft_has_its_centre_line(report):
    assert paths.centre_line(report, Abscissa(report)) is None
    lowered = paths.centre_line(replace(report, centre=report.centre - 0.3e-3j), Abscissa(report))
    centre = next(trace for trace in lowered["data"] if trace["name"] == "centre")
    assert np.mean(centre["y"]) == pytest.approx(-0.3, abs=0.02) and lowered["layout"]["equal"]


def test_the_paths_of_the_cursor_are_those_of_the_run(report):
    along = Abscissa(report)
    cursor = paths.at_cursor(report, along)
    rotor = np.array(cursor["paths"])[0, 0]
    for _ in range(3):  # third differences
        rotor = rotor.cumsum(axis=1)
    path = cursor["scale"][0] * (rotor[0] + 1j * rotor[1])
    own = report.orbits.rotor[0] * cursor["gap"] / report.result.scene.contact.gap
    assert np.abs(path - own).max() < 1e-3 * np.abs(own).max()  # half a pixel of 500


def test_the_answer_fits_a_terminal_and_says_no_agreement_without_its_tolerance(report):
    lines = answer_text(report).splitlines()
    assert max(map(len, lines)) <= COLUMNS and len(lines) <= 28
    topics = dict(answer(report))
    assert topics["whirl"].startswith("backward whirl, sliding at a rotor speed of") and "rpm" in topics["whirl"]
    assert "gaps" in topics["vibration"] and "% of the clearance" in topics["closest approach"] and " N" in topics["force"]
    assert "power input by friction up to " in topics["force"]
    rows = report.stretches.rows.copy()
    rows[:, list(STRETCH_COLUMNS).index("friction_work")] *= -1.0
    braked = replace(report, stretches=Stretches(rows))
    assert dict(answer(braked))["force"] == topics["force"].replace("input by", "lost to")
    assert "within 0.5 %" in topics["check"] and "impacts" in topics["after an impact"]


@pytest.mark.parametrize("kind", list(Kind))
def test_the_answer_tells_the_kind_of_the_windows_and_nothing_else(report, kind):
    kinds = np.full(len(report.features.kind), str(kind))
    features = replace(report.features, kind=kinds, why=np.full(len(kinds), "1.0 turns: too short"))
    told = dict(answer(replace(report, features=features)))
    whirls = kind in (*BACKWARD, Kind.FORWARD_WHIRL)
    assert ("frequency" in told) == whirls and told["at the end"].startswith(str(kind))
    assert told["whirl"].startswith(str(kind) if kind in WHIRLING else "no backward whirl")
    if kind == Kind.NOT_RESOLVED:
        assert "1.0 turns: too short" in told["whirl"] and "where the motion is resolved" in told["whirl"]
    elif kind not in (*WHIRLING, Kind.NO_CONTACT):
        assert f"{kind} at " in told["whirl"]


def test_a_change_is_told_only_of_a_whirl_that_is(report):
    """A forward motion may have backward lines that pass predicted whirls: no whirl, and no change of whirl."""
    label = report.rows[-1].branch
    change = Transition("", label, 40.0, 41.0, math.nan, math.nan, math.nan, AGREES, "a whirl sets in")
    report = replace(report, transitions=[change])
    assert dict(answer(report))["change"] == f"no whirl to whirl {label} at 41.0 Hz"
    features = replace(report.features, kind=np.full(len(report.features.kind), str(Kind.FORWARD_RUB)))
    told = dict(answer(replace(report, features=features)))
    assert told["whirl"].startswith("no backward whirl; forward rub at") and "change" not in told


def test_amplitude_and_force_are_those_of_the_steps_in_units_that_read_well(report):
    rows = report.stretches.rows.copy()
    rows[3, list(STRETCH_COLUMNS).index("force_max")] = 68.4e3
    rows[5, list(STRETCH_COLUMNS).index("rotor_max")] = 9.87e-3
    told = dict(answer(replace(report, stretches=Stretches(rows))))
    gap = report.result.scene.contact.gap
    assert "up to 68.4 kN normal" in told["force"]
    assert f"orbit up to {9.87e-3 / gap:.2f} gaps (9.87 mm) from the bearing centre" in told["vibration"]
    assert told["vibration"].startswith(f"up to {1e6 * report.features.peak_to_peak.max():.0f} um pk-pk at ")


@pytest.mark.parametrize(("value", "text"), [(-0.1579, "-0.1579"), (-60.664, "-60.66"), (1698.23, "1698.2"), (0.0, "0.0")])
def test_a_frequency_has_the_digits_that_its_size_asks_for(value, text):
    assert hertz(value) == text


def test_a_run_without_contact_and_one_of_a_single_window_have_a_page(tmp_path):
    free = report_of_dict(PUMP, contact={"gap": 1.0}, start={"rest": True})
    assert dict(answer(free))["whirl"] == "no backward whirl; no contact" and "force" not in dict(answer(free))
    short = report_of_dict(PUMP, drive={"speed": 50.0, "duration": 0.05})
    for report in (free, short):
        assert write_page(report, tmp_path / "report.html").stat().st_size < 0.9e6
        data_of((tmp_path / "report.html").read_text(encoding="utf-8"))


def test_a_steady_forward_rub_is_called_so_and_has_axes_of_a_sensible_length():
    rub = report_of_dict(PUMP, drive={"speed": 33.0, "duration": 4.0}, start={"rest": True}, rotor={"eccentricity": 2e-4})
    whirl = dict(answer(rub))["whirl"]
    assert re.match(r"no backward whirl; forward rub at 33.00 Hz \(1980 rpm\), .* to 4 s; partial rub at", whirl), whirl
    low, high = pictures.bode_phase(rub, Abscissa(rub))["layout"]["yaxis"]["range"]
    left, right = pictures.polar(rub, Abscissa(rub))["layout"]["xaxis"]["range"]
    assert high - low >= 20.0 and left < 0.0 < right


@pytest.mark.parametrize(
    ("share", "text"), [(0.193, "19 %"), (0.0149, "1.5 %"), (0.9981, "99.8 %"), (0.9999, "100 %"), (2.34, "234 %")]
)
def test_percentages_have_no_powers_of_ten(share, text):
    assert percent(share) == text


def test_a_run_that_was_cut_short_has_a_page_that_says_so(tmp_path):
    report = report_of_dict(PUMP, solver={"max_steps": 20_000})
    assert report.result.status == "too many steps"
    write_page(report, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    data_of(text)
    assert re.search(r"too many steps at \d", text) and "the run stopped early (too many steps)" in text
    assert escape(report.result.summary.advice) in text


def test_a_page_that_cannot_be_written_is_told(report, tmp_path):
    with pytest.raises(DataError, match="cannot be written"):
        write_page(report, tmp_path / "missing" / "report.html")


def test_ticks_are_round_and_inside():
    for low, high in ((0.0, 1.0), (-172.5, 172.5), (20.0, 150.0), (-1e-9, 3e-9), (0.9999, 1.0001)):
        values = ticks(low, high)
        assert 2 <= len(values) <= 9 and low - 1e-9 <= values.min() and values.max() <= high + abs(1e-9 * high)


def test_a_line_on_paper_is_broken_where_it_has_no_value():
    trace = line([0.0, 1.0, 2.0, 3.0], [0.0, np.nan, 1.0, 1.0], "a < b", BLUE)
    drawn = svg({"data": [trace], "layout": pictures.axes("x", "y", 200)}, "a < b")
    (path,) = re.findall(r'<path d="(M[^"]+)" fill="none"', drawn)[:1]
    assert path.count("M") == 2 and "a &lt; b" in drawn


def test_points_that_a_line_on_paper_leaves_out_lie_on_it():
    x = np.linspace(0.0, 6.0, 700)
    points = _tenths(90.0 * x, 200.0 + 150.0 * np.sin(x) * np.exp(np.cos(40.0 * x)) * (x > 2.0))
    kept = _corners(points)
    assert len(kept) < 0.8 * len(points) and set(kept) <= set(points) and kept[0] == points[0] and kept[-1] == points[-1]
    begin, along = kept[:-1], np.diff(kept)
    share = np.clip(((points[:, None] - begin) * along.conj()).real / np.abs(along) ** 2, 0.0, 1.0)
    assert np.abs(points[:, None] - begin - share * along).min(axis=1).max() <= 0.5  # half a tenth of a pixel
    assert list(_corners(np.zeros(3, complex))) == [0.0, 0.0]


def test_what_is_compressed_does_not_tell_the_operating_system(text):
    assert base64.b85decode(Elements(text).scripts["report"][:20].replace(",", "<"))[9] == 255


def test_other_runs_stand_in_the_amplitude_picture(report):
    along = Abscissa(report)
    names = [trace["name"] for trace in pictures.amplitude(report, along, [report])["data"]]
    assert "run 30 to 60 Hz, largest" in names


def test_the_page_carries_the_published_script(report):
    """The script is the one of npm's plotly.js-cartesian-dist-min 4.1.1, byte for byte, and knows every kind of trace drawn."""
    text = page(report)
    published = "79542150855a52c567260e3137095dbe2b744e6d702a5cabe67da246942fba7a"
    assert hashlib.sha256(unpacked(text, "library")).hexdigest() == published
    drawn = data_of(text)["pictures"]
    kinds = {trace["type"] for picture in drawn.values() for trace in picture["data"]}
    assert kinds <= {"scatter", "bar", "heatmap"}
    assert "@plotly/d3 3.8.2 (BSD-3-Clause): Copyright (c) 2010-2016, Michael Bostock" in text  # licences of what it bundles
