"""Every source file, test and name in code that the maintainers' documents name exists, so that a renaming mends them too."""

import re
import subprocess
from functools import cache
from pathlib import Path

import pytest

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").is_file())
PAGES = [*ROOT.glob("docs/maintainers/*.md"), *ROOT.glob("docs/maintainers/decisions/*.md"), ROOT / "docs/users/validation.md"]
DOCUMENTS = [page for page in PAGES if page.name != "glossary.md"]  # which also names words that the code must not use
FILE = re.compile(r"[\w./-]*\w\.(?:py|toml|csv|txt|c)\b")
TEST = re.compile(r"\btest_\w+")
NAME = re.compile(r"`([A-Za-z]\w*(?:\.\w+)*)(?<!_)(?:\(\))?`")  # a prefix such as n_ is none


@cache
def tracked():
    """Names of the files of the repository, new ones included."""
    call = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    return subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()


@cache
def words():
    """Words of all code but this file."""
    sources = [ROOT / name for name in tracked() if name.endswith((".py", ".toml", ".c"))]
    texts = [path.read_text(encoding="utf-8") for path in sources if path.is_file() and path != Path(__file__)]
    return set(re.findall(r"\w+", "\n".join(texts)))


def unknown(text):
    """Files, tests and names that a text names and that are nowhere."""
    files = [f"/{name}" for name in tracked() if (ROOT / name).exists()]
    stems = {Path(name).stem for name in files}
    lost = [name for name in FILE.findall(text) if not any(file.endswith("/" + name.lstrip("./")) for file in files)]
    lost += [name for name in TEST.findall(text) if name not in stems and name not in words()]
    return lost + [name for name in NAME.findall(text) if name.split(".")[-1] not in words() | stems]


@pytest.mark.parametrize("page", DOCUMENTS, ids=lambda page: page.stem)
def test_what_a_document_names_exists(page):
    assert not unknown(page.read_text(encoding="utf-8"))


@pytest.mark.parametrize("text", ["kernel/no_such_file.py", "see test_no_such_thing", "`pack.no_such_name`", "`no_such_name()`"])
def test_what_does_not_exist_is_noticed(text):
    assert len(unknown(text)) == 1


def test_every_equation_of_the_paper_names_its_function():
    """The last table of physics.md leads from a number to a function that is there, in the module that it names."""
    table = (ROOT / "docs/users/physics.md").read_text(encoding="utf-8").rpartition("## 6.")[2]
    rows = re.findall(r"^\| \(\d+\) \|.*\| (.*) \|$", table, re.MULTILINE)
    assert len(rows) == 19
    for row in rows:
        pairs = re.findall(r"`(\w+)\.(\w+)`", row)
        assert pairs
        for module, name in pairs:
            sources = [file for file in tracked() if re.search(rf"rsc/(analysis|kernel)/([\w/]+/)?{module}\.py$", file)]
            assert any(re.search(rf"^ *def {name}\(", (ROOT / file).read_text("utf-8"), re.MULTILINE) for file in sources), name
