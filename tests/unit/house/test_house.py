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
LONGEST_BODY, LONGEST_FILE = 60, 400  # lines
LINT = "from importlinter.cli import lint_imports_command as lint; lint()"

STRAYS = {
    "a file in no wing": ({"stray.py": ""}, {"wings"}),
    "imports against the floors and past the doors": (
        {
            "analysis/paper/stray.py": "import rsc.kernel.step",
            "analysis/alone/stray.py": "import rsc.analysis.follow.events",
            "kernel/simd/stray.py": "import rsc.kernel.step",
            "measure/stray.py": "import matplotlib",
            "measured/stray.py": "import h5py",
            "show/page/stray.py": "import h5py",
        },
        {"wings", "two witnesses", "floors of the kernel", "floors of the analysis", "matplotlib", "h5py"},
    ),
    "imports against the rooms": (
        {
            "scene/keys/stray.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import rsc.scene.scene",
            "machine/formats/stray.py": "import rsc.machine.model.model",
            "show/words/stray.py": "import rsc.show.pictures.plots",
            "study/run/stray.py": "import rsc.study.report.check",
        },
        {"rooms of scene", "rooms of machine", "rooms of show", "rooms of study"},
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


def test_the_order_of_wings_in_contributing_is_the_contracts():
    told = re.search(r"^    (cli > .*\n +> .*errors)$", (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"), re.MULTILINE)
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]
    assert [" ".join(floor.split()) for floor in told.group(1).split(">")] == contracts[0]["layers"]


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(ROOT / "src").as_posix())
def test_functions_and_files_are_short(path):
    text = path.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= LONGEST_FILE
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            begin = node.body[0].end_lineno if ast.get_docstring(node) else node.body[0].lineno - 1
            assert node.end_lineno - begin <= LONGEST_BODY, node.name


# what differs between operating systems beside names that only some have: those mypy tells (`make lint`, --platform win32)
SYSTEM_MODULES = {"fcntl", "resource", "msvcrt", "pwd", "grp", "termios", "tty", "pty", "winreg", "posix", "nt"}
SYSTEM_NAMES = {
    "os": {"replace", "rename", "kill", "name", "link", "symlink", "chmod", "umask", "geteuid", "pread", "fork", "cpu_count"},
    "sys": {"platform", "getwindowsversion"},
    "platform": {"system", "uname", "machine", "release", "win32_ver"},
    "signal": {"SIGTERM", "SIGKILL", "SIGBREAK", "SIGHUP", "SIGALRM"},
}
SYSTEM_WORDS = re.compile(r"/proc/|XDG_|LOCALAPPDATA|win32")
PORTABLE_FLAGS = {"O_RDONLY", "O_WRONLY", "O_RDWR", "O_CREAT", "O_EXCL", "O_TRUNC"}


def of_a_system(tree):
    """What in a syntax tree is not the same in all operating systems."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from {each.name for each in node.names} & SYSTEM_MODULES
        elif isinstance(node, ast.ImportFrom) and node.module in (SYSTEM_MODULES | set(SYSTEM_NAMES)):
            yield node.module
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            name, flag = node.attr, node.value.id == "os" and node.attr.startswith("O_")
            if name in SYSTEM_NAMES.get(node.value.id, ()) or (flag and name not in PORTABLE_FLAGS):
                yield f"{node.value.id}.{name}"
        elif isinstance(node, ast.keyword) and node.arg in ("dir_fd", "src_dir_fd", "dst_dir_fd"):
            yield node.arg
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and SYSTEM_WORDS.search(node.value):
            yield node.value


def test_what_differs_between_operating_systems_stands_in_its_wing():
    found = {}
    for path in SOURCES:
        wing, *_ = path.relative_to(ROOT / "src" / "rsc").parts
        if names := sorted(set(of_a_system(ast.parse(path.read_text(encoding="utf-8"))))):
            found.setdefault(wing, {})[path.name] = names
    here = found.pop("operating_system")
    assert found == {} and {"posix.py", "windows.py"} <= set(here)


def test_every_test_is_in_a_file_that_is_collected():
    """In a room of tests/, under a name that pytest looks for, once; `make test` runs all that is collected and not nightly."""
    texts = {path: path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py")}
    files = [path for path, text in texts.items() if re.search(r"^def test_", text, re.MULTILINE)]
    assert [path for path in files if not path.name.startswith("test_")] == []
    rooms = {path.relative_to(ROOT / "tests").parts[0] for path in files}
    assert rooms == {"extensions", "laws", "literature", "regression", "unit"}
    assert len({path.name for path in files}) == len(files)


def imported(tree):
    """Names of the modules, or what stands in them, that a syntax tree imports, and its texts, by which some are imported."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            yield node.module
            yield from (f"{node.module}.{each.name}" for each in node.names)
        elif isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def test_every_module_is_used():
    """One that nothing imports does nothing: a reader of a format without an entry in its table, for example."""
    names = {name for path in SOURCES for name in imported(ast.parse(path.read_text(encoding="utf-8")))}
    modules = {".".join(path.relative_to(ROOT / "src").with_suffix("").parts) for path in SOURCES if path.name[:2] != "__"}
    assert sorted(modules - names) == []


def test_the_unit_tests_stand_in_the_wing_that_they_test():
    wings = {path.name for path in (ROOT / "src" / "rsc").iterdir() if path.is_dir() and path.name != "__pycache__"}
    rooms = {path.name for path in (ROOT / "tests" / "unit").iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert rooms == wings | {"cli", "bench", "house"}


def test_scripts_and_the_support_of_tests_share_no_name():
    """Their folders stand beside each other on the path, and which one is first depends on what was imported before."""
    folders = [ROOT / "tools", ROOT / "bench", ROOT / "bench" / "stability", ROOT / "tests" / "support"]
    names = [path.name for folder in folders for path in folder.glob("*.py")]
    assert sorted({name for name in names if names.count(name) > 1}) == []
