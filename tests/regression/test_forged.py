"""The first 20 forged files of runs and sweeps; `tools/forged.py` tries 20,000."""

import tempfile
from collections import Counter

import pytest

import trials


@pytest.fixture(scope="module")
def outcomes():
    """Command -> Counter of what became of the cases; and the problems, one for a case."""
    commands, problems = {}, []
    with tempfile.TemporaryDirectory() as folder, trials.samples(folder, pictures=False) as pairs:
        for number, ends, problem in trials.trials(range(20), pairs, trials.swept(folder), folder):
            for command, word in (ends or {}).items():
                commands.setdefault(command, Counter())[word] += 1
            if problem:
                problems.append(f"case {number}: {problem}")
    return commands, problems


def test_every_command_ends_as_documented(outcomes):
    """With exit code 0, 2, 4 or 5 and one line; no signal, no traceback, in 2 s of processor time (10 s to compute or draw) and
    300 MB; nothing else is changed, and a part that is another one's is computed again."""
    assert not outcomes[1]


def test_most_forgeries_are_refused_and_some_files_are_read(outcomes):
    """Half of what is forged changes nothing that a command looks at; of results less than a tenth is verified bit for bit, which
    so few cases need not show (docs/maintainers/tables/forged.md)."""
    for command, counts in outcomes[0].items():
        refused = sum(n for word, n in counts.items() if word.startswith("refused"))
        assert refused > 1 and (counts["done (exit 0)"] > 0 or command == "verify"), command
