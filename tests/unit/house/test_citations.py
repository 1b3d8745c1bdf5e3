"""Every document, section and equation number that code and documents cite exists: nobody is sent to a page that is not there."""

import ast
import io
import re
import subprocess
import tokenize
from functools import cache
from pathlib import Path

import pytest

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists())
PHYSICS = ROOT / "docs" / "users" / "physics.md"
CODE_FOLDERS = ("src", "bench", "tools", "tests")
LAST_EQUATION = 28  # of the paper; a larger number in brackets in a document is no equation

DOCUMENT = re.compile(r"(?<![\w/.*{}-])[\w./-]*[\w-]\.md\b")
SECTION = re.compile(r"([\w-]+\.md),? section (\d+(?:\.\d+)?)")
OWN_SECTION = re.compile(r"(?<!\.md )(?<!\.md, )\bsection (\d+(?:\.\d+)?)")
LINK = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)(?:#[^)]*)?\)")
# (24), but no call such as f(24) and no superscript such as h^(6)
EQUATION = re.compile(r"(?<![\w^)\]])\((\d{1,2})\)(?![\w(])")
HEADING = re.compile(r"^#+ (\d+(?:\.\d+)?)\.? ", re.MULTILINE)
CODE_BLOCK = re.compile(r"^ *```[\s\S]*?^ *```|^(?: {4}|\t).*$", re.MULTILINE)


def tracked(*patterns):
    """Paths of the files of the repository, new ones included, that fit a pattern of git."""
    call = ["git", "ls-files", "--cached", "--others", "--exclude-standard", *patterns]
    names = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    return [ROOT / name for name in sorted(set(names)) if (ROOT / name).is_file()]


@cache
def prose(path):
    """The words of a file: of Python code its docstrings and comments, of a document all but its code blocks."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        return CODE_BLOCK.sub("", text)
    if path.suffix != ".py":
        return text
    parts = [ast.get_docstring(node, clean=False) or "" for node in ast.walk(ast.parse(text)) if _has_docstring(node)]
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return "\n".join(parts + [token.string for token in tokens if token.type == tokenize.COMMENT])


def _has_docstring(node):
    return isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef))


def found_document(name, citing):
    """The file that a name means to the reader of a file: from the root, beside it, or the one page in docs/ of that name."""
    for start in (ROOT, citing.parent):
        if (start / name).is_file():
            return (start / name).resolve()
    pages = list((ROOT / "docs").rglob(name)) if "/" not in name else []
    return pages[0] if len(pages) == 1 else None


def sections(page):
    """Numbers of the headings of a page."""
    return set(HEADING.findall(page.read_text(encoding="utf-8")))


def wrong_documents(text, citing):
    """Documents that a text names and that do not exist."""
    return [name for name in DOCUMENT.findall(text) if found_document(name, citing) is None]


def wrong_sections(text, citing):
    """Sections "page.md section n" that do not exist; in a numbered page also its own, "section n"."""
    wrong = []
    for name, number in SECTION.findall(text):
        page = found_document(name, citing)
        if page is None or number not in sections(page):
            wrong.append(f"{name} section {number}")
    if citing.suffix == ".md" and sections(citing):
        wrong += [f"section {number}" for number in OWN_SECTION.findall(text) if number not in sections(citing)]
    return wrong


def wrong_equations(text, labelled, last=99):
    """Equation numbers up to the last one that physics.md does not list; (0) and (1) count coordinates."""
    return [number for number in map(int, EQUATION.findall(text)) if 1 < number <= last and number not in labelled]


@pytest.fixture(scope="module")
def labelled():
    """Equation numbers that physics.md lists in its section 6."""
    listing = PHYSICS.read_text(encoding="utf-8").split("\n## 6. ")[1]
    return {int(number) for number in re.findall(r"^\| \((\d+)\) \|", listing, re.MULTILINE)}


CITING = [path for folder in CODE_FOLDERS for path in tracked(f"{folder}/*.py", f"{folder}/*.toml")]
DOCUMENTS = tracked("*.md")


def faults(paths, wrong):
    """{file: what is wrong in it} of the files where something is."""
    found = {str(path.relative_to(ROOT)): wrong(prose(path), path) for path in paths if path != Path(__file__)}
    return {name: what for name, what in found.items() if what}


def test_cited_documents_and_sections_exist():
    assert len(CITING) > 100 and len(DOCUMENTS) > 5
    assert not faults(CITING + DOCUMENTS, wrong_documents)
    assert not faults(CITING + DOCUMENTS, wrong_sections)


def test_linked_files_exist():
    def wrong(text, path):
        return [name for name in LINK.findall(text) if not (path.parent / name).exists()]

    assert not faults(DOCUMENTS, wrong)


def test_equation_numbers_are_listed(labelled):
    assert len(labelled) > 15
    package = tracked("src/*.py")
    assert not faults(package, lambda text, path: wrong_equations(text, labelled))
    others = [path for path in CITING + DOCUMENTS if path not in package]
    assert not faults(others, lambda text, path: wrong_equations(text, labelled, LAST_EQUATION))


def test_every_listed_number_stands_where_the_list_says(labelled):
    """An equation shown with its number is listed, and a listed one occurs in the section that the list names."""
    text = PHYSICS.read_text(encoding="utf-8")
    body, listing = text.split("\n## 6. ")
    assert {int(number) for number in re.findall(r"\\tag\{(\d+)\}", body)} <= labelled
    for number, section in re.findall(r"^\| \((\d+)\) .* section ([\d.]+) \|$", listing, re.MULTILINE):
        part = re.split(rf"^#+ {re.escape(section)}\.? ", body, flags=re.MULTILINE)[1]
        part = re.split(r"^#", part, flags=re.MULTILINE)[0]
        assert f"\\tag{{{number}}}" in part or f"({number})" in part, (number, section)


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("as docs/users/physics.md says", []),
        ("as physics.md says", []),
        ("as docs/physics.md says", ["docs/physics.md"]),
        ("as nowhere.md says", ["nowhere.md"]),
    ],
)
def test_a_document_that_is_not_there_is_found(text, wrong):
    assert wrong_documents(text, ROOT / "src" / "rsc" / "errors.py") == wrong


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("physics.md section 3", []),
        ("(physics.md, section 3.5)", []),
        ("physics.md section 9", ["physics.md section 9"]),
        ("physics.md, section 3.99", ["physics.md section 3.99"]),
    ],
)
def test_a_section_that_is_not_there_is_found(text, wrong):
    assert wrong_sections(text, ROOT / "src" / "rsc" / "errors.py") == wrong


@pytest.mark.parametrize(("text", "wrong"), [("law (10), (11)", []), ("by (23)", [23]), ("range(9) and x^(6)", []), ("(5)", [5])])
def test_an_equation_that_is_not_listed_is_found(text, wrong, labelled):
    assert wrong_equations(text, labelled) == wrong
