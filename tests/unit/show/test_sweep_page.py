"""The page of a sweep: what it says, that it is inert, and that `rsc report` writes it."""

import re
from dataclasses import replace

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.results.labelled import Labelled
from rsc.show.sweeps import words as sweep_words
from rsc.show.sweeps.page import sweep_page
from rsc.study.sweep.plan import make_plan
from rsc.study.sweep.sweep import computed
from scenes import LAVAL, changed

HOSTILE = '</title><script>alert("x")</script><img src="https://example.org/x">'


@pytest.fixture(scope="module")
def data():
    scene = rsc.Scene.from_dict(changed(LAVAL, title=HOSTILE, drive={"duration": 0.2}, start={"whirl": "backward"}))
    cases = rsc.cases(scene, {"contact.friction": [0.001, 0.1, 0.15], "drive.speed": [50.0, 60.0]})
    return computed(make_plan(scene, cases, "predict,run"), None, threads=1)


def test_it_tells_what_the_sweep_found(data):
    text = sweep_page(data)
    assert "4 finished, 2 impossible" in text and "the run ends in a whirl in 4 cases" in text
    assert "2 x such as start.whirl" in text
    place = np.unravel_index(np.nanargmax(data["largest_force"]), (3, 2))
    friction, speed = (data.coordinates[key][1][i] for key, i in zip(("contact.friction", "drive.speed"), place, strict=True))
    assert f"{data['largest_force'].max(where=np.isfinite(data['largest_force']), initial=0.0):.4g} N at " in text
    assert f"at contact.friction = {friction:.6g}, drive.speed = {speed:.6g} Hz" in text
    assert text.count("<img src=\"data:image/png;base64,") == text.count("<figure>") == 7


def test_it_is_inert_and_asks_for_nothing(data):
    text = sweep_page(data)
    assert "<script" not in text and not re.search(r'(?:src|href)="(?!data:)', text)
    assert "&lt;script&gt;" in text


def test_a_sweep_in_which_nothing_finished_has_a_page(data):
    nothing = {name: (dims, np.full_like(values, "impossible" if name == "status" else values.flat[0]), about)
               for name, (dims, values, about) in data.variables.items()}  # fmt: skip
    text = sweep_page(replace(data, variables=nothing))
    assert "6 impossible" in text and "no whirl predicted or found in 6 cases" in text


def test_extremes_have_units_and_places(data):
    rows = dict((text, (value, where)) for text, value, where in sweep_words.extremes(data))
    value, where = rows["largest amplitude of a run"]
    assert value.endswith("mm") and float(value.split()[0]) == pytest.approx(1e3 * np.nanmax(data["largest_amplitude"]), rel=1e-3)
    assert "Hz" in where


def test_the_command(tmp_path, capsys, data):
    data.save(tmp_path / "sweep.nc")
    assert main(["report", str(tmp_path / "sweep.nc"), "-o", str(tmp_path)]) == 0
    assert (tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>")


def test_reasons_that_differ_in_numbers_and_names_of_tasks_are_told_once():
    keys = ("6983d0507b2aca5b", "db604c6bcb3a0691")
    reasons = [f"FutureCancelledError: compute_part-{key} cancelled for reason: lost" for key in keys]
    columns = {"status": np.array(["missing", "missing"]), "reason": np.array(reasons)}
    data = Labelled({"case": 2}, {}, {name: (("case",), values, {}) for name, values in columns.items()}, {})
    assert sweep_words.reasons(data) == [f"2 x such as {reasons[0]}"]
