"""`rsc import` of a small rotor of which one file is damaged, numbered like the cases of fuzz_cases.py: documented exit codes."""

import contextlib
import io
import random
import resource
import shutil
from pathlib import Path

import numpy as np
import scipy.io

import fuzz_cases as fuzz
import matrix_fuzz
from fe_bodies import rotor
from matrix_writers import DECK, WRITERS
from rsc.cli import main

LIMIT = 10.0  # s of processor time, of one import
MOST_GROWTH = 600e6  # bytes that one import may take beyond those before it
# ten formats, the table, the file of ROSS's save_mat and a deck with a gap: name of the case -> writer
KINDS = {
    "Matrix Market": "Matrix Market, coordinate", "Matrix Market, array": "Matrix Market, array",
    "Harwell-Boeing": "Harwell-Boeing",
    "MAT-file 5": "MAT-file of level 5", "MAT-file 7.3": "MAT-file of level 7.3, struct", "npz": "npz",
    "OUTPUT4": "OUTPUT4, dense", "DMIG": "DMIG, wide", "Abaqus": "Abaqus, labels", "CalculiX": "CalculiX",
}  # fmt: skip
MORE = ("coordinate table", "ROSS", "NLRGAP")
CODES = {0: "imported (exit 0)", 2: "refused (exit 2)", 4: "refused (exit 4)"}


def originals(folder):
    """name of a case -> (arguments of `rsc import`, files that may be damaged, with their content)."""
    matrices, nodes, directions = rotor(n_elements=3)
    nodes = nodes + 10
    lines = [f"{node},{direction},{node / 10}" for node, direction in zip(nodes, directions, strict=True)]
    (folder / "table.csv").write_text("node,direction,position\n" + "\n".join(lines) + "\n")
    cases = {}
    for kind, writer in KINDS.items():
        name, write, key, *_ = WRITERS[writer]
        place = folder / kind
        for role in ("mass", "stiffness"):
            (place / role).mkdir(parents=True)
            write(place / role / name, matrices[role])
        files = sorted(path for path in place.rglob("*") if path.is_file())
        arguments = [f"--{role}={place / role / name}" + f":{key}" * kind.startswith("MAT") for role in ("mass", "stiffness")]
        cases[kind] = ["fe", *arguments, "--coordinates", str(folder / "table.csv")], files
    cases["coordinate table"] = cases["npz"][0], [folder / "table.csv"]
    (folder / "gap.bdf").write_text(DECK)
    cases["NLRGAP"] = [*cases["npz"][0], "--gap", str(folder / "gap.bdf")], [folder / "gap.bdf"]
    path = folder / "ross.mat"
    ross = {name: matrices[role] for name, role in (("M", "mass"), ("K", "stiffness"), ("C", "damping"), ("G", "gyroscopic"))}
    scipy.io.savemat(path, ross | {"nodes": np.arange(4) / 3.0})
    cases["ROSS"] = ["ross", str(path)], [path]
    return {kind: (arguments, {file: file.read_bytes() for file in files}) for kind, (arguments, files) in cases.items()}


def one_import(number, folder, cases):
    """Import with a damaged file; returns what became of it, in a word."""
    dice = random.Random(number)
    kind = sorted(cases)[number % len(cases)]
    arguments, files = cases[kind]
    path = dice.choice(sorted(files))
    path.write_bytes(matrix_fuzz.damaged(files[path], dice))
    output, errors = folder / "out", io.StringIO()
    output.mkdir()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(errors):
            code = main(["import", *arguments, "-o", str(output / "scene.toml"), "--contact", "1" if kind == "ROSS" else "11"])
        written = sorted(file.name for file in output.iterdir())
    finally:
        path.write_bytes(files[path])
        shutil.rmtree(output)
    said = errors.getvalue()
    if code not in CODES or written != ([] if code else ["scene.npz", "scene.toml"]):
        raise AssertionError(f"exit code {code} of {kind}, {written} written: {said}")
    if code and (said.count("\n") != 1 or not said.startswith("error: ") or len(said) > 1500):
        raise AssertionError(f"a refusal is no line: {said!r}")
    if 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) > MOST_GROWTH:
        raise AssertionError("too much memory was taken")
    return f"{kind}: {CODES[code]}"


def imports(numbers, folder):
    """(case, outcome, seconds) of imports with a damaged file."""
    cases = originals(Path(folder))
    for number in numbers:
        yield fuzz.case(number, one_import, Path(folder), cases, limit=LIMIT)
