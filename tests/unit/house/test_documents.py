"""Examples of README and docs/users run as they stand there, and print what is shown; the reference names every export.

Rules: a `toml` block that begins with "# NAME.toml" is saved under that name ("# NAME.toml = OTHER.toml with another [table]": as
a copy of the other with its last table replaced). Lines "$ command" of a `console` block are run ("> NAME" saves the output);
lines under them must occur in the output, in that order. A `python` block is run in the namespace of its page; the next `text`
block is what it and its predecessors printed since the last one.
"""

import contextlib
import importlib
import io
import os
import re
import shlex
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

import rsc
from rsc.cli import main
from rsc.scene.scene import load_scene

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists())
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
USERS = ROOT / "docs" / "users"
NAMES = ("tutorial", "measured", "modes", "journal", "numbers")
SLOW = {"journal", "measured"}  # half a minute each, where a kernel is compiled
PAGES = [ROOT / "README.md", ROOT / "docs" / "index.md", *(USERS / f"{name}.md" for name in NAMES)]


class Page:
    """The examples of one page, run in a folder."""

    def __init__(self):
        self.names, self.printed = {}, ""

    def run(self, kind, text):
        """Run one block; other kinds are prose."""
        run = {"toml": self.save, "console": self.command, "python": self.python, "text": self.compare}.get(kind)
        if run is not None:
            run(text)

    def save(self, text):
        """A scene under the name in its first line."""
        named = re.match(r"# (\w+\.toml)(?: = (\w+\.toml) with another (\[\w+\]))?\n", text)
        if named is None:
            tomllib.loads(text)
            return
        name, other, table = named.groups()
        if other:
            text = Path(other).read_text(encoding="utf-8").partition(table)[0] + text
        Path(name).write_text(text, encoding="utf-8")
        if "[measured]" not in text:  # the table of a measured run, whose data may come later on the page
            load_scene(name)

    def command(self, text):
        """Commands of rsc, each with lines that its output must have."""
        for part in text.split("$ ")[1:]:
            command, _, wanted = part.partition("\n")
            program, *arguments = shlex.split(command, comments=True)
            assert program == "rsc"
            arguments, file = (arguments[:-2], arguments[-1]) if ">" in arguments else (arguments, "")
            code, output = printed_by(lambda arguments=arguments: main(arguments))
            assert code == 0, command
            if file:
                Path(file).write_text(output, encoding="utf-8")
            occur_in_order(wanted, output)

    def python(self, text):
        """Python in the namespace of the page."""
        self.printed += printed_by(lambda: exec(text, self.names))[1]

    def compare(self, text):
        """What Python printed."""
        assert self.printed == text
        self.printed = ""


def printed_by(run):
    """(what a call returns, what it prints)."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        value = run()
    return value, output.getvalue()


def occur_in_order(wanted, output):
    """Every line occurs in the output, one after the other."""
    lines = iter(line.strip() for line in output.splitlines())
    for line in filter(None, map(str.strip, wanted.splitlines())):
        assert line in lines, f"not in the output, or not there: {line}"


@pytest.mark.parametrize(
    "path", [pytest.param(path, id=path.stem, marks=[pytest.mark.nightly] * (path.stem in SLOW)) for path in PAGES]
)
def test_examples_run_and_give_what_they_show(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page, blocks = Page(), BLOCK.findall(path.read_text(encoding="utf-8"))
    assert "python" in {kind for kind, _ in blocks}
    for kind, text in blocks:
        page.run(kind, text)
    assert not page.printed.strip() or "text" not in {kind for kind, _ in blocks}


@pytest.mark.nightly
def test_the_install_block_of_the_tutorial_leads_to_a_page(tmp_path):
    """In a fresh environment, from the sources alone; needs a package index."""
    sources = tmp_path / "sources"
    sources.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, sources)
    shutil.copytree(ROOT / "src" / "rsc", sources / "src" / "rsc", ignore=shutil.ignore_patterns("__pycache__"))
    (block,) = [text for kind, text in BLOCK.findall((USERS / "tutorial.md").read_text(encoding="utf-8")) if kind == "sh"]
    script = f"set -e\n{block}\nmkdir work; cd work\nrsc new laval > scene.toml\nrsc check scene.toml\n"
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(["bash", "-c", script], cwd=sources, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0 and "whirl:  " in done.stdout, done.stderr
    assert (sources / "work" / "out" / "scene" / "report.html").stat().st_size > 0.6e6


def test_no_other_page_has_examples_that_nobody_runs():
    pages = set(ROOT.glob("docs/users/*.md")) | {ROOT / "docs" / "index.md", ROOT / "CONTRIBUTING.md"}
    for path in pages - set(PAGES):
        kinds = {kind for kind, _ in BLOCK.findall(path.read_text(encoding="utf-8"))} if path.exists() else set()
        assert not kinds & {"console", "python"}, path.name


def test_the_reference_names_every_export():
    page = (ROOT / "docs" / "users" / "api.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\.\. auto\w+:: (\w+)$", page, re.MULTILINE)
    assert sorted(listed) == sorted(rsc.__all__)


def test_the_speed_picture_has_rsc_and_the_best_peers(monkeypatch):
    """Five lines; of the peers those that the table of the results names as the best."""
    monkeypatch.syspath_prepend(str(ROOT / "bench"))
    speed_picture = importlib.import_module("speed_picture")
    results = ROOT / "bench" / "results"
    rows = speed_picture.work_precision.read(speed_picture.PROBLEM, results)[0]
    labels = [line.get_label() for line in speed_picture.picture(rows).axes[0].lines]
    table = (results / "work_precision.txt").read_text(encoding="utf-8")
    named = re.findall(rf"^{speed_picture.PROBLEM} .* best peer (.+?) [\d.]+ s", table, re.MULTILINE)
    assert labels[:2] == ["rsc rk45", "rsc taylor8"]
    assert len(set(labels)) == 5 and set(named) <= set(labels)
