"""The glossary and the code say the same: its paths exist, and the fillers that it bans are no names in the code."""

import ast
import re
from pathlib import Path

import pytest

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists())
SOURCES = ROOT / "src/rsc"
MODULES = sorted(SOURCES.rglob("*.py"))
GLOSSARY = (ROOT / "docs/maintainers/glossary.md").read_text()


def rows():
    """[word, meaning, where, not called] of every word."""
    lines = [line.strip("|").split(" | ") for line in GLOSSARY.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in cells] for cells in lines if cells[0].strip() != "word" and "---" not in cells[0]]


def fillers():
    """Words of the sentence that bans them."""
    sentence = re.search(r"Pronouns and\s+fillers \(([^)]*)\)", GLOSSARY)
    return set(re.findall(r"`(\w+)`", sentence[1]))


def names_in_functions(tree):
    """(name, line) of arguments and variables of all functions; fields of a class are keys of a scene."""
    for function in ast.walk(tree):
        if isinstance(function, (ast.FunctionDef, ast.Lambda)):
            for node in ast.walk(function):
                if isinstance(node, ast.arg):
                    yield node.arg, node.lineno
                elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                    yield node.id, node.lineno


def test_every_word_has_one_row():
    words = [row[0] for row in rows()]
    assert len(words) > 25 and len(set(words)) == len(words)
    assert all(len(row) == 4 for row in rows())


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[0])
def test_paths_exist(row):
    for path in re.findall(r"`([\w/]+(?:\.py|/))`", row[2]):
        assert (SOURCES / path).exists(), path


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(SOURCES)))
def test_fillers_are_no_names(path):
    names = {f"{name} (line {line})" for name, line in names_in_functions(ast.parse(path.read_text())) if name in fillers()}
    assert not names
