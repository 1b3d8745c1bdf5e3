"""Short suite on the declared lower bounds of all requirements, on their newest releases, there on Numba alone (RSC_PLAIN), and
on the newest releases for every later Python that this machine has.

    python tools/versions.py                  all, one after the other; their rows go to bench/results/versions.txt
    python tools/versions.py oldest 3.13      some of them; the rows of the others stay
    python tools/versions.py --turn           one of them, by the day of the year, and no rows: for CI

Each gets a virtual environment under out/versions/ and an empty cache of compiled code. It runs the Laval reference runs and
ensembles, whose hashes must be those of the Python that runs this, and the tests marked `versions`. Exit code 1 where one fails.
"""

import argparse
import datetime
import os
import re
import resource
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PLACE = ROOT / "out" / "versions"
TABLE = ROOT / "bench" / "results" / "versions.txt"
BITS = ("tools/bits.py", "--only", "laval")
MARKED = [str(file) for file in sorted((ROOT / "tests").rglob("test_*.py")) if "@pytest.mark.versions" in file.read_text()]
# old libraries are warned by the newer ones below them, for example matplotlib by pyparsing
TESTS = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "default::DeprecationWarning", "-m", "versions", *MARKED)
TOOLS = ("pytest", "pytest-benchmark", "hypothesis")
PYTHONS = ("3.12", "3.13", "3.14")
LIBRARIES = ("oldest", "newest", "plain")
SETUPS = (*LIBRARIES, *PYTHONS)
ABSENT = "no such Python here"
HEADER = ("setup", "versions", "hashes", "tests", "processor s")


def requirements(oldest):
    """(of rsc, of its tests) as pip takes them, from pyproject.toml: exactly the declared bounds or any releases above them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    tools = [line for line in project["optional-dependencies"]["dev"] if re.split("[<>=]", line)[0] in TOOLS]
    return [line.replace(">=", "==") if oldest else line for line in project["dependencies"]], tools


def interpreter(version):
    """A Python of that version, by its name or among those of pyenv; None without any."""
    among = sorted((Path.home() / ".pyenv" / "versions").glob(f"{version}.*/bin/python"))
    for path in (shutil.which(f"python{version}"), *among):
        if path and subprocess.run([path, "--version"], capture_output=True, check=False).returncode == 0:
            return path
    return None


def environment(setup):
    """The interpreter of a fresh virtual environment; the plain path uses that of the newest versions. None: it cannot be had."""
    folder = PLACE / ("newest" if setup == "plain" else setup)
    python = folder / "bin" / "python"
    if setup != "plain" or not python.exists():
        own, tools = requirements(setup == "oldest")
        base = interpreter(setup) if setup in PYTHONS else sys.executable
        if base is None:
            return None
        subprocess.run([base, "-m", "venv", "--clear", folder], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "--only-binary=:all:", *own, *tools], check=True)
    return python


def output(python, *arguments, **more):
    """(standard output, processor time in s) of a run in the repository; its errors are seen."""
    settings = os.environ | {"PYTHONPATH": str(ROOT / "src")} | more
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([python, *arguments], cwd=ROOT, env=settings, stdout=subprocess.PIPE, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def installed(python):
    """Names and versions of the requirements, in a line."""
    names = [re.split("[<>=]", line)[0] for line in requirements(True)[0]]
    program = f"import importlib.metadata, platform; print('python', platform.python_version(), end='')\n\
for name in {names!r}: print(',', name, importlib.metadata.version(name), end='')"
    return output(python, "-c", program)[0]


def row(setup, expected):
    """What a setup did: (setup, versions, hashes, tests, seconds), and whether all of it was right."""
    python, cache = environment(setup), PLACE / f"cache_{setup}"
    if python is None:
        return (setup, ABSENT, "-", "-", "0"), True
    shutil.rmtree(cache, ignore_errors=True)
    more = {"XDG_CACHE_HOME": str(cache)} | ({"RSC_PLAIN": "1"} if setup == "plain" else {})
    hashes, first = output(python, *BITS, **more)
    tests, second = output(python, *TESTS, **more)
    said = tests.strip().splitlines()[-1] if tests else "none ran"
    same, passed = hashes == expected != "", re.fullmatch(r"=*\s*\d+ passed[^,]*(, \d+ (deselected|warnings?))* in .*", said)
    if not passed:
        print(tests)
    cells = setup, installed(python), "equal" if same else "DIFFER", said.strip("= "), f"{first + second:.0f}"
    return cells, bool(same and passed)


def note(cells):
    """Put a row into the table of results, in the place of an earlier one of its setup."""
    rows = [line.split("\t") for line in TABLE.read_text().splitlines()[1:]] if TABLE.exists() else []
    rows = {row[0]: row for row in [*rows, list(cells)]}
    ordered = [HEADER, *(rows[setup] for setup in SETUPS if setup in rows)]
    TABLE.write_text("".join("\t".join(row) + "\n" for row in ordered))


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("setups", nargs="*", metavar="SETUP", help=", ".join(SETUPS))
    parser.add_argument("--turn", action="store_true", help="one of them, by the day of the year")
    options = parser.parse_args()
    if unknown := set(options.setups) - set(SETUPS):
        parser.error(f"unknown: {', '.join(sorted(unknown))}")
    day = datetime.datetime.now(datetime.UTC).timetuple().tm_yday
    setups = (LIBRARIES[day % len(LIBRARIES)],) if options.turn else options.setups or SETUPS
    expected, fine = output(sys.executable, *BITS)[0], True
    for setup in setups:
        cells, right = row(setup, expected)
        fine &= right
        print(*(f"{name:12} {cell}" for name, cell in zip(HEADER, cells, strict=True)), sep="\n", flush=True)
        if not options.turn:
            note(cells)
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
