"""The house in order: a stray file or a forbidden import breaks a contract, functions and files are short, every test is run."""

import ast
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SOURCES = sorted((ROOT / "src" / "rsc").rglob("*.py"))
LONGEST_BODY, LONGEST_FILE = 60, 450  # lines, of a file those that are not blank
LINT = "from importlinter.cli import lint_imports_command as lint; lint()"

STRAYS = {
    "a file in no wing": ({"stray.py": ""}, {"wings"}),
    "imports against the floors and past the doors": (
        {
            "analysis/paper/stray.py": "import rsc.kernel.step",
            "analysis/alone/stray.py": "import rsc.analysis.lines.events",
            "kernel/simd/stray.py": "import rsc.kernel.step",
            "measure/stray.py": "import matplotlib",
            "show/stray.py": "import h5py",
        },
        {"wings", "two witnesses", "floors of the kernel", "floors of the analysis", "matplotlib", "h5py"},
    ),
}


@pytest.mark.parametrize(("files", "contracts"), STRAYS.values(), ids=STRAYS)
def test_a_stray_file_breaks_the_contract_that_is_there_for_it(files, contracts, tmp_path):
    shutil.copytree(ROOT / "src" / "rsc", tmp_path / "rsc", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for name, text in files.items():
        (tmp_path / "rsc" / name).write_text(text + "\n")
    command = [sys.executable, "-c", LINT, "--no-cache"]
    told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, env={"PYTHONPATH": str(tmp_path)})
    assert told.returncode == 1, told.stderr
    broken = re.findall(r"^(.+) BROKEN\b", told.stdout, re.MULTILINE)
    assert len(broken) == len(contracts)
    assert all(any(name.startswith(contract) for name in broken) for contract in contracts)


def test_what_stands_beside_the_modules_is_installed_with_them():
    """Tests run rsc from its sources, where nothing is missing; a wheel has only what pyproject.toml names."""
    package = ROOT / "src" / "rsc"
    named = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["package-data"]["rsc"]
    files = {path for path in package.rglob("*") if path.is_file() and "__pycache__" not in path.parts}
    assert {path.relative_to(package).as_posix() for path in files if path.suffix != ".py"} == set(named)


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(ROOT / "src").as_posix())
def test_functions_and_files_are_short(path):
    text = path.read_text(encoding="utf-8")
    assert sum(bool(line.strip()) for line in text.splitlines()) <= LONGEST_FILE
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            begin = node.body[0].end_lineno if ast.get_docstring(node) else node.body[0].lineno - 1
            assert node.end_lineno - begin <= LONGEST_BODY, node.name


def test_every_test_is_in_a_file_that_is_collected():
    """In a room of tests/, under a name that pytest looks for, once; `make test` runs all that is collected and not nightly."""
    texts = {path: path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py")}
    files = [path for path, text in texts.items() if re.search(r"^def test_", text, re.MULTILINE)]
    assert [path for path in files if not path.name.startswith("test_")] == []
    rooms = {path.relative_to(ROOT / "tests").parts[0] for path in files}
    assert rooms == {"extensions", "laws", "literature", "regression", "unit"}
    assert len({path.name for path in files}) == len(files)


def test_the_unit_tests_stand_in_the_wing_that_they_test():
    wings = {path.name for path in (ROOT / "src" / "rsc").iterdir() if path.is_dir() and path.name != "__pycache__"}
    rooms = {path.name for path in (ROOT / "tests" / "unit").iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert rooms == wings | {"cli", "bench", "house"}
