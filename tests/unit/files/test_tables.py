"""Tables for notebooks, pandas and CSV: the same numbers, and no markup from a scene."""

import csv
from dataclasses import replace

import numpy as np
import pytest

import rsc
from reports import PUMP, short_report
from rsc.errors import DataError
from rsc.files.tables import SHOWN, Table

HOSTILE = "<script>alert(1)</script>"


def test_csv_has_every_digit_and_replaces_only_a_table(tmp_path):
    table = Table(("speed in Hz", "note"), [(1.0 / 3.0, 'a "quoted", note'), (2e-300, "")])
    table.to_csv(tmp_path / "table.csv")
    table.to_csv(tmp_path / "table.csv")
    with open(tmp_path / "table.csv", newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    assert head == ["speed in Hz", "note"] and [float(row[0]) for row in rows] == [1.0 / 3.0, 2e-300]
    assert rows[0][1] == 'a "quoted", note'
    (tmp_path / "other.csv").write_text("something else")
    with pytest.raises(DataError, match="did not write"):
        table.to_csv(tmp_path / "other.csv")


def test_a_long_table_is_short_in_a_notebook():
    text = Table(("n",), [(i,) for i in range(1000)])._repr_html_()
    assert text.count("<tr>") == SHOWN + 1 and "20 of 1000 rows" in text and len(text) < 2000


def test_whirls_are_a_list_and_a_table():
    whirls = rsc.predict(rsc.Scene.from_dict(PUMP), speed=40.0)
    frame = whirls.table().to_dataframe()
    assert isinstance(whirls, list) and len(frame) == len(whirls) > 0
    assert frame["frequency in Hz"].tolist() == [whirl.frequency for whirl in whirls]
    assert whirls._repr_html_().count("<tr>") == len(whirls) + 1
    assert whirls[0]._repr_html_() == rsc.Whirls(whirls[:1])._repr_html_() and whirls[0].table().rows == whirls.table().rows[:1]
    assert [type(each) for each in rsc.predict(rsc.Scene.from_dict(PUMP), speed=[40.0, 50.0])] == [rsc.Whirls] * 2


def test_a_run_and_a_report_as_tables():
    report = short_report()
    run = report.result.table().to_dataframe()
    assert run.shape == (report.result.n_time, 5 + 2 * (report.result.rotor.shape[1] + report.result.stator.shape[1]))
    assert np.array_equal(run["rotor 0 z in m"], report.result.rotor[:, 0].imag)
    assert np.array_equal(run["normal force in N"], report.result.normal_force)
    rows = report.table().to_dataframe()
    assert rows["verdict"].tolist() == [row.verdict for row in report.rows]


def test_what_a_notebook_shows_is_small_and_inert():
    report = short_report()
    hostile = replace(report.result, scene=replace(report.result.scene, title=HOSTILE))
    shown = [each._repr_html_() for each in (hostile, hostile.scene, replace(report, result=hostile))]
    for text in shown:
        assert HOSTILE not in text and "&lt;script&gt;" in text and len(text) < 6000
    assert "finished at 4 s" in shown[0] and "gap = 0.001" in shown[1] and "backward whirl" in shown[2]
