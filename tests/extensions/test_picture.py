"""A picture from outside: on the page, on paper and as PNG by one entry; what a renderer does not know it refuses in one line."""

import json
from dataclasses import replace

import pytest

from packed import unpacked
from reports import short_report
from rsc.show.page import page
from rsc.show.pictures.abscissa import Abscissa
from rsc.show.pictures.album import PICTURES, Entry, described
from rsc.show.pictures.report_pictures import draw

NAME = "rotor_speed"


@pytest.fixture(autouse=True)
def registered():
    """The picture for this file only."""
    from rotor_speed import rotor_speed

    PICTURES[NAME] = Entry(rotor_speed, "Rotor speed over the run.", section="Frequencies", file=NAME)
    yield
    del PICTURES[NAME]


def test_it_is_on_the_page_on_paper_and_in_a_file(tmp_path):
    report = short_report()
    text = page(report)
    section = text.partition("<h2>Frequencies</h2>")[2].partition("</section>")[0]
    assert f'id="{NAME}"' in section and section.count("<svg") == 2 and "<figcaption>Rotor speed over the run." in section
    data = json.loads(unpacked(text, "report"))
    assert data["pictures"][NAME]["data"][0]["y"][0] == pytest.approx(report.fall.speed[0], rel=1e-4)
    assert tmp_path / f"{NAME}.png" in draw(report, tmp_path) and (tmp_path / f"{NAME}.png").stat().st_size > 5000


def test_where_there_is_nothing_to_show_there_is_none():
    report = short_report()
    held = replace(report, fall=replace(report.fall, speed=0.0 * report.fall.speed + 50.0))
    along = Abscissa(held)
    assert NAME in described(report, Abscissa(report)) and PICTURES[NAME].describe(held, along) is None


@pytest.mark.parametrize(("kind", "ask"), [("pie", page), ("sunburst", lambda report: draw(report, None))])
def test_a_trace_that_a_renderer_does_not_know_is_refused(kind, ask, monkeypatch):
    trace = {"type": kind, "x": [0.0], "y": [1.0], "name": ""}
    picture = {"data": [trace], "layout": {"xaxis": {"title": ""}, "yaxis": {"title": ""}, "height": 240}}
    monkeypatch.setitem(PICTURES, NAME, Entry(lambda report, along: picture, "", "Energy", NAME))
    with pytest.raises(ValueError, match=f"not '{kind}'") as refused:
        ask(short_report())
    assert "\n" not in str(refused.value)


def test_a_section_that_the_page_does_not_have_is_refused(monkeypatch):
    monkeypatch.setitem(PICTURES, NAME, Entry(lambda report, along: None, section="Weather"))
    with pytest.raises(ValueError, match="no section 'Weather', only Machine, Frequencies"):
        page(short_report())
