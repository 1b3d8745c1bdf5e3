"""What is checked before a version is released; `make release` runs it behind the short tests and the documents.

    python tools/release.py            of the version in pyproject.toml, as committed; files in out/release
    python tools/release.py --hashes   writes requirements.txt anew: the libraries of constraints.txt with their hashes

The version and its date are the same in pyproject.toml, CITATION.cff and CHANGELOG.md, whose newest version takes at most 60
lines. The committed files, exported twice to folders of different names, give the same wheel and the same source distribution,
byte for byte. requirements.txt has the versions of constraints.txt and a hash of every file of theirs. The wheel, installed with
exactly these in a new environment, computes a reference run. What is installed there and what plotly's script bundles is listed
in a software bill of materials (CycloneDX).

Exit code 1 with what is wrong, one line each; else the SHA-256 of the files in out/release.
"""

import hashlib
import json
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PLACE = ROOT / "out" / "release"
MOST_LINES, MOST_UNRELEASED = 60, 20
SCENE = "data/reference/laval.toml"
CONSTRAINTS, HASHED = ROOT / "constraints.txt", ROOT / "requirements.txt"
NOTICE = ROOT / "src" / "rsc" / "show" / "page" / "plotly" / "NOTICE"


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


def pinned(text):
    """name -> version of the lines `name==version` of a requirements file."""
    return dict(re.findall(r"^([A-Za-z0-9._-]+)==([^ ;\\\n]+)", text, re.MULTILINE))


def write_hashes():
    """requirements.txt from constraints.txt, with the hashes that the package index gives."""
    command = ["uv", "pip", "compile", "--quiet", "--universal", "--no-deps", "--generate-hashes", "--no-annotate", "--no-header"]
    subprocess.run([sys.executable, "-m", *command, CONSTRAINTS, "--output-file", HASHED], check=True, stdout=subprocess.DEVNULL)


def tried(wheel, folder):
    """Install a wheel and exactly the hashed libraries in a new environment and compute a reference run with it; its Python."""
    venv.create(folder, with_pip=True)
    programs = folder / ("Scripts" if sys.platform == "win32" else "bin")
    install = [programs / "python", "-m", "pip", "install", "--quiet"]
    subprocess.run([*install, "--require-hashes", "--requirement", HASHED], check=True)
    subprocess.run([*install, "--no-deps", wheel], check=True)
    run = [programs / "rsc", "run", ROOT / SCENE, "--output", folder / "laval.h5"]
    subprocess.run(run, check=True, cwd=folder, stdout=subprocess.DEVNULL)
    return programs / "python"


def bundled(notice):
    """Components of a bill of materials: the packages that plotly's script holds, from lines `name version (licence): ...`."""
    for name, version, licence in re.findall(r"^(\S+) (\d\S*) \((\S+)\): ", notice, re.MULTILINE):
        yield {
            "type": "library", "name": name, "version": version, "purl": f"pkg:npm/{name.replace('@', '%40')}@{version}",
            "bom-ref": f"plotly script: {name}", "licenses": [{"license": {"id": licence}}],
        }  # fmt: skip


def write_bill(python, path):
    """The CycloneDX bill of materials of an environment and of plotly's script, the same for the same versions."""
    command = [sys.executable, "-m", "cyclonedx_py", "environment", "--output-reproducible"]
    subprocess.run([*command, "--pyproject", ROOT / "pyproject.toml", "--output-file", path, python], check=True)
    bill = json.loads(path.read_text(encoding="utf-8"))
    bill["components"] += bundled(NOTICE.read_text(encoding="utf-8"))
    path.write_text(json.dumps(bill, indent=1) + "\n", encoding="utf-8")


def main():
    """Check the release and keep its files; exit code 1 where something is wrong."""
    if sys.argv[1:] == ["--hashes"]:
        return write_hashes()
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    texts = [(ROOT / name).read_text(encoding="utf-8") for name in ("CITATION.cff", "CHANGELOG.md")]
    problems = list(wrong_words(version, *texts))
    if pinned(CONSTRAINTS.read_text(encoding="utf-8")) != pinned(HASHED.read_text(encoding="utf-8")):
        problems.append("requirements.txt has other versions than constraints.txt: python tools/release.py --hashes")
    if subprocess.run(["git", "-C", ROOT, "status", "--porcelain"], capture_output=True, check=True).stdout:
        problems.append("the work tree has changes that are not committed")
    if not problems:
        with tempfile.TemporaryDirectory() as place:
            one, other = (built(exported(Path(place) / name)) for name in ("once", "a second time"))
            changed = [name for name in one if one[name].read_bytes() != other[name].read_bytes()]
            problems += [f"{name} has other bytes when it is built again" for name in changed]
            if not problems:
                python = tried(next(path for name, path in one.items() if name.endswith(".whl")), Path(place) / "installed")
                shutil.rmtree(PLACE, ignore_errors=True)
                PLACE.mkdir(parents=True)
                for path in one.values():
                    shutil.copy(path, PLACE)
                write_bill(python, PLACE / f"rsc-{version}.cdx.json")
                sums = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in sorted(PLACE.iterdir())]
                (PLACE / "SHA256SUMS").write_text("".join(sums), encoding="utf-8")
                print("".join(sums), end="")
    print("\n".join(problems), file=sys.stderr, end="\n" if problems else "")
    return bool(problems)


if __name__ == "__main__":
    sys.exit(main())
