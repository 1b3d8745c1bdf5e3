"""The table of the paper's numbers (bench/paper.py): it holds every published number, and its predictions are those of today."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[2] / "bench"))
import paper


def committed():
    """(figure, quantity) -> cells of bench/results/paper.md by the names of its columns."""
    lines = (paper.RESULTS / "paper.md").read_text(encoding="utf-8").splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
    return {tuple(row[:2]): dict(zip(paper.HEADER, row, strict=True)) for row in rows[1:]}


def test_every_published_number_is_in_the_table():
    rows = paper.published()
    names = [(row["figure"], row["quantity"]) for row in rows]
    assert names == list(paper.STATEMENTS) == list(committed())
    for row, cells in zip(rows, committed().values(), strict=True):
        value = row["value"]
        assert cells["Printed, Hz"] == (f"{value:g}" if value == value else "none")
        assert row["unit"] == "Hz"


@pytest.mark.parametrize("name", paper.STATEMENTS, ids=" ".join)
def test_the_predictions_of_the_committed_table_still_hold(name):
    assert committed()[name]["Predicted, Hz"] == paper.number(paper.STATEMENTS[name].predicted())


def test_the_differences_of_the_table_are_those_of_its_columns():
    for cells in committed().values():
        for who in ("Predicted", "Simulated"):
            difference, value = cells[f"{who} less printed"], cells[f"{who}, Hz"]
            if "none" in (cells["Printed, Hz"], value):
                assert difference == "none"
            else:
                assert float(difference) == pytest.approx(float(value) - float(cells["Printed, Hz"]), abs=0.011)
