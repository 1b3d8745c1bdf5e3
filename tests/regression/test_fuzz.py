"""Mutated scenes, damaged and forged files by the hundred; `tools/fuzz.py` runs 128,000 others."""

from collections import Counter

import pytest

import forge_measured
import forge_reports
import fuzz_cases as fuzz
import import_fuzz
import matrix_fuzz
import rsc
from rsc.measured import formats
from scenes import SCENES


def test_mutated_scenes_are_run_or_refused(tmp_path):
    outcomes = Counter(outcome for _, outcome, _ in fuzz.scenes(range(60), tmp_path))
    assert outcomes["refused (exit 2)"] > 25 and sum(n for o, n in outcomes.items() if o.startswith("run:")) > 3


@pytest.mark.parametrize("velocities", [False, True])
def test_damaged_results_are_refused_or_whole(velocities, tmp_path):
    scene = rsc.Scene.from_dict(SCENES["chains"]).with_values({"output.velocities": velocities})
    found = fuzz.results(range(25), tmp_path, scene)
    outcomes = Counter(outcome for _, outcome, _ in found)
    assert outcomes["refused (exit 4)"] > 15


def test_damaged_matrix_files_are_read_or_refused(tmp_path):
    outcomes = Counter(outcome.rpartition(": ")[2] for _, outcome, _ in matrix_fuzz.files(range(360), tmp_path))
    assert outcomes["refused"] > 200 and outcomes["read"] > 25 and outcomes.total() == 360


def test_imports_of_damaged_files_end_with_a_documented_code(tmp_path):
    outcomes = Counter(outcome.rpartition(": ")[2] for _, outcome, _ in import_fuzz.imports(range(120), tmp_path))
    assert outcomes["refused (exit 4)"] > 60 and outcomes["imported (exit 0)"] > 10 and outcomes.total() == 120


def test_a_forged_analysis_is_used_or_made_anew(tmp_path):
    outcomes = Counter(outcome for _, outcome, _ in forge_reports.reports(range(6), tmp_path))
    assert outcomes["made anew"] > 2 and outcomes["used"] > 0 and outcomes.total() == 6


def test_forged_measured_files_are_read_or_refused(tmp_path):
    outcomes = Counter(outcome.rpartition(": ")[2] for _, outcome, _ in forge_measured.measurements(range(100), tmp_path))
    assert outcomes["refused"] > 30 and outcomes["read"] > 25 and outcomes["compared"] > 0 and outcomes.total() == 100


def test_a_case_that_takes_too_long_is_stopped(monkeypatch):
    monkeypatch.setattr(fuzz, "LIMIT", 0.05)
    with pytest.raises(fuzz.TooLong), fuzz.Clock():
        while True:
            pass


def test_every_format_of_measured_files_is_damaged(tmp_path):
    """A kind in forge_measured.py for each reader."""
    rows, kinds = forge_measured.signals(), forge_measured.KINDS
    damaged = {formats.reader_of(forge_measured.content_of(kind, rows, tmp_path)).name for kind in kinds}
    assert damaged == {reader.name for reader in (formats.TEXT, *formats.READERS)}
