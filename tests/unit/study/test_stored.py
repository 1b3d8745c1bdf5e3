"""The analysis kept beside a result: used where it is of this result, made anew otherwise, whatever the file holds."""

import json
import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest

import rsc
from reports import short_report
from rsc.cli import main
from rsc.results.labelled import is_labelled
from rsc.show.page import page
from rsc.show.words.answer import answer
from rsc.study.report import stored as module
from rsc.study.report.stored import NAME, report_of, write_stored


@pytest.fixture
def result(tmp_path):
    path = tmp_path / "result.h5"
    short_report().result.save(path)
    return path


@pytest.fixture
def no_analysis(monkeypatch):
    """Analysing again is an error."""
    monkeypatch.setattr("rsc.study.report.check.report", lambda result: pytest.fail("analysed again"))


def with_analysis(result):
    """The file of an analysis beside a result."""
    from rsc.study.report.check import report

    write_stored(report(rsc.load(result)), result.with_name(NAME))
    return result.with_name(NAME)


def test_a_stored_analysis_gives_the_same_answer_pictures_and_page(result, no_analysis, monkeypatch):
    monkeypatch.undo()
    with_analysis(result)
    own = short_report()
    monkeypatch.setattr("rsc.study.report.check.report", lambda result: pytest.fail("analysed again"))
    found = report_of(rsc.load(result), result)
    assert answer(found) == answer(own)
    assert found.rows[5] == own.rows[5] and len(found.rows) == len(own.rows)
    assert np.array_equal(found.branches[0].frequency, own.branches[0].frequency)
    stripped = [text.partition("<dl>")[2].partition('<section class="live">')[0] for text in (page(found), page(own))]
    assert stripped[0] == stripped[1]
    assert main(["plot", str(result), "-o", str(result.parent / "pictures")]) == 0
    assert main(["report", str(result), "-o", str(result.parent / "pages")]) == 0
    assert (result.parent / "pages" / "report.html").stat().st_size > 600_000


def damaged(path):
    content = json.loads(path.read_text())
    yield "no JSON", "{"
    yield "a list", "[]"
    yield "another result", json.dumps(content | {"result": "0" * 64})
    yield "another version", json.dumps(content | {"made_by": "rsc-report-0"})
    yield "no rows", json.dumps(content | {"rows": []})
    yield "rows of texts", json.dumps(content | {"rows": ["x"] * len(content["rows"])})
    yield "no branches", json.dumps({k: v for k, v in content.items() if k != "branches"})
    branch = content["branches"][0]
    yield "a short column", json.dumps(content | {"branches": [branch | {"speed": branch["speed"][:-1]}]})
    yield "a window of nothing", json.dumps(content | {"window": 0.0})
    yield "an endless window", json.dumps(content | {"window": 1e300})
    yield "a number beyond all floats", json.dumps(content | {"resonance": 10**400})
    yield "predictions of other windows", json.dumps(content | {"alone": content["alone"][:-1]})
    yield "natural frequencies of no speed", json.dumps(content | {"natural": {"coupled": [[], [[1.0]]]}})
    yield "lists without end", "[" * 200_000
    first, *others = content["rows"]
    words = ("nonsense", []), ("short", ["\x1b[31m"]), ("short", [])
    reasons = [[{"code": code, "names": names, "numbers": []}] for code, names in words]
    wrong = {"quantity": ("nonsense", "whirl amplitude"), "verdict": ("nonsense",), "reasons": ("x", *reasons)}
    for key, word in ((key, word) for key, words in wrong.items() for word in words):
        yield f"{key} {word!r}", json.dumps(content | {"rows": [first | {key: word}, *others]})
    yield "mathematics in a label", json.dumps(content | {"branches": [branch | {"label": "$\\frac$"}]})
    yield "a branch of bits", json.dumps(content | {"branches": [branch | {"stable": [[[]]] * len(branch["stable"])}]})


def test_whatever_stands_beside_a_result_is_used_only_if_it_is_of_it(result, monkeypatch):
    path = with_analysis(result)
    anew = object()
    monkeypatch.setattr("rsc.study.report.check.report", lambda result: anew)
    for name, text in damaged(path):
        path.write_text(text)
        assert report_of(rsc.load(result), result) is anew, name
    path.unlink()
    assert report_of(rsc.load(result), result) is anew
    path.write_bytes(b"\xff" * 100)
    assert report_of(rsc.load(result), result) is anew
    monkeypatch.setattr(module, "LARGEST", 10)
    assert report_of(rsc.load(result), result) is anew


def test_pages_of_results_of_one_name_do_not_overwrite_each_other(result, tmp_path, no_analysis, monkeypatch, capsys):
    monkeypatch.undo()
    with_analysis(result)
    pages = tmp_path / "pages"
    assert main(["report", str(result), str(result), "-o", str(pages)]) == 0
    written = sorted(path.name for path in pages.iterdir())
    assert len(written) == 2 and all(name in capsys.readouterr().out for name in written[-1:])


def test_a_result_of_another_version_is_refused_in_one_line(result, capsys):
    with h5py.File(result, "r+") as file:
        file.attrs["format"] = "rsc-result-1"
    for command in (["report", str(result)], ["plot", str(result), "-o", str(result.parent / "pictures")]):
        assert main(command) in (2, 4)
        captured = capsys.readouterr()
        assert captured.err.count("\n") == 1 and captured.err.startswith("error: ")


def test_a_long_result_is_not_read_to_see_that_it_is_no_sweep(tmp_path):
    with h5py.File(tmp_path / "long.h5", "w") as file:
        file["rotor"] = np.zeros(4_000_000)
    (tmp_path / "text.h5").write_text("no HDF5")
    tracemalloc.start()
    assert not any(is_labelled(tmp_path / name) for name in ("long.h5", "text.h5", "missing.h5"))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 5e6  # of 32 MB


def test_a_run_in_memory_has_no_digest():
    assert short_report().result.digest == ""
    assert not Path(NAME).exists()
