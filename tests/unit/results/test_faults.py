"""A run ended at some of its writes, by a kill or a full disk, or without memory, goes on to the same bits.

`tools/faults.py` tries every write."""

from collections import Counter

import pytest

import run_faults as faults


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return faults.shim(tmp_path_factory.mktemp("shim")) or pytest.skip("needs Linux and a C compiler")


def test_a_run_ended_at_any_write_goes_on_to_the_same_bits(library):
    """F2 and F3: the first write, the last (the rename) and some between; each killed before it, torn by a kill, and refused."""
    calls, rows = faults.driven(library, 0.016)
    assert calls > 200 and len(rows) >= 12
    assert [row for row in rows if row[3] != "same"] == []
    left = Counter((mode, left) for mode, _, left, _ in rows)
    assert left["killed before the call", "a part"] >= 3 and left["no space from the call on", "a part"] >= 2


def test_a_run_killed_while_it_writes_its_summary_goes_on(library):
    """Each of the last calls: the last samples with their checkpoint, the last stretches, the summary, the rename."""
    _, rows = faults.driven(library, 20, "end")
    assert Counter((left, verdict) for *_, left, verdict in rows) == {("a part", "same"): 19, ("result", "same"): 1}


def test_a_run_without_memory_ends_with_an_error_and_its_samples(library):
    """F19: an allocation of HDF5 or NumPy that fails, the first, the last and some between; alone, and all from then on."""
    calls, rows = faults.driven(library, 0.0003, "memory")
    assert calls > 5000 and len(rows) >= 8
    assert [row for row in rows if row[3] != "same"] == []
    assert {left for _, _, left, _ in rows} >= {"a part", "result"}
