"""What a package index would be given: a source distribution, and the wheel that is built from it."""

import email
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LICENSES = ("LICENSE", "src/rsc/show/page/plotly/LICENSE", "src/rsc/show/page/plotly/NOTICE")


CONSTRAINTS = ROOT / "constraints.txt"


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, ROOT]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_the_wheel_has_name_licences_and_all_that_rsc_reads(built):
    (path,) = built.glob("*.whl")
    version = PROJECT["version"]
    assert path.name == f"rotor_stator_contact-{version}-py3-none-any.whl"
    with zipfile.ZipFile(path) as wheel:
        names, about = set(wheel.namelist()), f"rotor_stator_contact-{version}.dist-info"
        told = email.message_from_bytes(wheel.read(f"{about}/METADATA"))
        commands = wheel.read(f"{about}/entry_points.txt").decode()
    assert (told["Name"], told["Version"], told["License-Expression"]) == (PROJECT["name"], version, PROJECT["license"])
    assert told["Requires-Python"] == PROJECT["requires-python"] and told["Description-Content-Type"] == "text/markdown"
    assert "plotly" not in " ".join(told.get_all("Requires-Dist"))  # plotly 7 keeps ROSS from importing
    assert set(told.get_all("License-File")) == set(LICENSES) and "rsc = rsc.__main__:entry" in commands
    files = [file.relative_to(ROOT / "src") for file in (ROOT / "src" / "rsc").rglob("*") if file.is_file()]
    wanted = {file.as_posix() for file in files if "__pycache__" not in file.parts}
    assert {name for name in names if not name.startswith(about)} == wanted
    assert {f"{about}/licenses/{name}" for name in LICENSES} <= names


def test_the_source_distribution_has_what_the_wheel_is_built_from(built):
    (path,) = built.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {CONSTRAINTS.name, "README.md", "CHANGELOG.md", "SECURITY.md", "pyproject.toml", *LICENSES} <= names
    folders = ("src", "tests", "docs", "bench", "tools", "data")
    committed = subprocess.run(["git", "-C", ROOT, "ls-files", *folders], capture_output=True, text=True)
    assert {name for name in committed.stdout.splitlines() if (ROOT / name).exists()} <= names


def required(texts, extras=("",), known=None):
    """All distributions that requirements lead to, as installed here: name -> requirements that lead to it."""
    known = {} if known is None else known
    for requirement in map(Requirement, texts):
        if requirement.marker and not any(requirement.marker.evaluate({"extra": extra}) for extra in extras):
            continue
        name, wanted = canonicalize_name(requirement.name), ("", *sorted(requirement.extras))
        seen = known.setdefault(name, [])
        if requirement not in seen:
            seen.append(requirement)
            required(metadata.requires(name) or (), wanted, known)
    return known


@pytest.mark.posix
def test_the_constraints_name_every_library_with_the_version_that_was_tested():
    """Of rsc and its extras, as they are installed where this is tested, within the bounds that are declared; later Pythons need
    some fewer."""
    pins = dict(line.split("==") for line in CONSTRAINTS.read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
    extras = PROJECT["optional-dependencies"]
    known = required([*PROJECT["dependencies"], *extras["sweep"], *extras["cluster"], *extras["measured"]])
    installed = {name: metadata.version(name) for name in known}
    assert installed.items() <= pins.items() and (sys.version_info >= (3, 12) or installed == pins)
    for name, requirements in known.items():
        assert all(pins[name] in requirement.specifier for requirement in requirements), name


def test_the_documents_name_the_constraints_of_this_release():
    for name in ("README.md", "docs/users/tutorial.md", "docs/users/trust.md", "Makefile"):
        assert CONSTRAINTS.name in (ROOT / name).read_text(encoding="utf-8"), name


def test_the_classifiers_name_the_pythons_that_are_supported():
    begin = "Programming Language :: Python :: "
    named = {each.removeprefix(begin) for each in PROJECT["classifiers"] if each.startswith(f"{begin}3.")}
    assert named == {f"3.{minor}" for minor in range(11, 15)} and PROJECT["requires-python"] == ">=3.11"


def test_the_conda_recipe_is_of_this_version_and_asks_for_the_same_libraries():
    recipe = (ROOT / "tools" / "conda" / "meta.yaml").read_text(encoding="utf-8")
    run = recipe.partition("  run:\n")[2].partition("\n\n")[0].replace("matplotlib-base", "matplotlib")
    asked = [line.removeprefix("    - ").replace(" ", "") for line in run.splitlines()]
    assert asked == [f"python{PROJECT['requires-python']}", *PROJECT["dependencies"]]
    assert f'version: "{PROJECT["version"]}"' in recipe and f"license: {PROJECT['license']}\n" in recipe
    assert f"- rsc = {PROJECT['scripts']['rsc']}\n" in recipe and all(f"- {name}\n" in recipe for name in LICENSES)
