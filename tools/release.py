"""What is checked before a version is released; `make release` runs it behind the short tests and the documents.

    python tools/release.py          of the version in pyproject.toml, as committed

The version and its date are the same in pyproject.toml, CITATION.cff and CHANGELOG.md, whose newest version takes at most 60
lines. The committed files, exported twice to folders of different names, give the same wheel and the same source distribution,
byte for byte. The wheel, installed with the libraries of constraints.txt in a new environment, computes a reference run.

Exit code 1 with what is wrong, one line each; else the SHA-256 of both files.
"""

import hashlib
import re
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MOST_LINES, MOST_UNRELEASED = 60, 20
SCENE = "data/reference/laval.toml"


def sections(changelog):
    """(heading, number of lines) of every version in CHANGELOG.md, the newest first."""
    parts = re.split(r"^## (.*)$", changelog, flags=re.MULTILINE)[1:]
    return [(head, len(text.strip().splitlines())) for head, text in zip(parts[::2], parts[1::2], strict=True)]


def wrong_words(version, citation, changelog):
    """Where the version, its date and the length of its changes do not fit, in words.

    version : str; citation, changelog : str, content of CITATION.cff and CHANGELOG.md
    """
    cited = dict(re.findall(r"^(version|date-released): \"?([^\"\n]*)\"?$", citation, re.MULTILINE))
    wanted, listed = f"{version} ({cited.get('date-released')})", sections(changelog)
    if cited.get("version") != version:
        yield f"CITATION.cff is of version {cited.get('version')}, pyproject.toml of {version}"
    if listed and listed[0][0] == "Unreleased":
        lines = listed.pop(0)[1]
        if lines > MOST_UNRELEASED:
            yield f"CHANGELOG.md: {lines} lines are unreleased, at most {MOST_UNRELEASED}: shorten them, details go to changes.md"
    if not listed or listed[0][0] != wanted:
        yield f"CHANGELOG.md: the newest version is \"{listed[0][0] if listed else ''}\", not \"{wanted}\""
    elif listed[0][1] > MOST_LINES:
        yield f"CHANGELOG.md: {version} takes {listed[0][1]} lines, at most {MOST_LINES}"


def exported(folder):
    """The committed files, below a folder."""
    archive = folder.with_suffix(".tar")
    subprocess.run(["git", "-C", ROOT, "archive", "--output", archive, "HEAD"], check=True)
    with tarfile.open(archive) as files:
        files.extractall(folder, filter="data")
    return folder


def built(folder):
    """Names and content of the distributions of a folder."""
    subprocess.run([sys.executable, "-m", "build", "--outdir", folder / "dist", folder], check=True, stdout=subprocess.DEVNULL)
    return {path.name: path for path in sorted((folder / "dist").iterdir())}


def tried(wheel, folder):
    """Install a wheel in a new environment and compute a reference run with it."""
    venv.create(folder, with_pip=True)
    programs = folder / ("Scripts" if sys.platform == "win32" else "bin")
    install = [programs / "python", "-m", "pip", "install", "--quiet", wheel, "--constraint", ROOT / "constraints.txt"]
    subprocess.run(install, check=True)
    run = [programs / "rsc", "run", ROOT / SCENE, "--output", folder / "laval.h5"]
    subprocess.run(run, check=True, cwd=folder, stdout=subprocess.DEVNULL)


def main():
    """Check the release; exit code 1 where something is wrong."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    texts = [(ROOT / name).read_text(encoding="utf-8") for name in ("CITATION.cff", "CHANGELOG.md")]
    problems = list(wrong_words(version, *texts))
    if subprocess.run(["git", "-C", ROOT, "status", "--porcelain"], capture_output=True, check=True).stdout:
        problems.append("the work tree has changes that are not committed")
    if not problems:
        with tempfile.TemporaryDirectory() as place:
            one, other = (built(exported(Path(place) / name)) for name in ("once", "a second time"))
            changed = [name for name in one if one[name].read_bytes() != other[name].read_bytes()]
            problems += [f"{name} has other bytes when it is built again" for name in changed]
            if not problems:
                tried(next(path for name, path in one.items() if name.endswith(".whl")), Path(place) / "installed")
                for name, path in one.items():
                    print(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {name}")
    print("\n".join(problems), file=sys.stderr, end="\n" if problems else "")
    return bool(problems)


if __name__ == "__main__":
    sys.exit(main())
