"""Random rotors of finite elements, imported: does any remark contradict the modes of what was written?

    python bench/import_remarks.py [--imports 300] [--write]

Shafts of 2 to 6 elements, now and then of 170, with and without gyroscopics; bearings that are stiff or soft, alike in both
directions or not, cross-coupled, damped not at all, a little or beyond oscillating; damping of the whole, rotating damping,
bearings that the import adds, coefficients that follow the speed. The modes are those of the matrices in the written .npz, with
the bearings that the written scene adds, from a companion matrix of their own. Asked of what the import prints: modes that are
there, each with its decrement, none of the slower ones left out; nothing damped where it says so; the rotor speed without effect
where it says so, and with an effect where it says that. --write: the page bench/results/import_remarks.md.
"""

import argparse
import collections
import contextlib
import io
import re
import sys
import tempfile
import tomllib
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path += [str(ROOT / "tests" / "support"), str(ROOT / "tools")]

import pages  # noqa: E402
from fe_bodies import rotor  # noqa: E402
from rsc.cli import main as rsc  # noqa: E402
from rsc.machine.imports.store import load_model  # noqa: E402

ROUNDED = 5e-3  # of decrements, which are printed with three digits
STILL = 1e-7  # growth rate over its eigenvalue: rounding
TOLD = re.compile(r"lowest modes? at (\S+) Hz of the full model: (.*); more by")
MODE = re.compile(r"(-?[\d.e+-]+) Hz \((undamped|does not oscillate|decrement (-?[\d.e+-]+))\)")


def drawn(number, folder):
    """Options of the import of a random rotor, whose files are in the folder; what it is, in words."""
    rng, words = np.random.default_rng([7, number]), []
    k = 10.0 ** rng.uniform(5.5, 8.0)
    shape = rng.choice(["alike", "unequal", "cross-coupled"])
    ky = k * (rng.uniform(0.4, 0.9) if shape == "unequal" else 1.0)
    cross = k * 10.0 ** rng.uniform(-3.0, -0.5) if shape == "cross-coupled" else 0.0
    n_elements = 170 if number % 100 == 29 else int(rng.integers(2, 7))
    matrices, nodes, directions = rotor(n_elements, rng.uniform(0.5, 1.5), ((k, ky), (k, ky)), cross)
    matrices["damping"] *= {"none": 0.0, "little": rng.uniform(0.1, 3.0), "strong": 10.0 ** rng.uniform(2.0, 3.5)}[
        damped := str(rng.choice(["none", "little", "strong"]))
    ]
    words += [f"bearings {shape}", f"their damping {damped}"]
    if rng.random() < 0.3:
        matrices["damping"] += 10.0 ** rng.uniform(-7.0, -4.0) * matrices["stiffness"] * (shape != "cross-coupled")
    if rng.random() < 0.3:
        shaft = rotor(n_elements, bearing=((0.0, 0.0),) * 2)[0]["stiffness"]
        matrices["rotating_damping"] = 10.0 ** rng.uniform(-7.0, -4.0) * shaft
        words.append("rotating damping")
    if rng.random() < 0.4:
        del matrices["gyroscopic"]
        words.append("no gyroscopics")
    options, last = [], int(nodes.max())
    for role, matrix in matrices.items():
        np.savez(folder / f"{role}.npz", matrix)
        options += [f"--{role.replace('_', '-')}", str(folder / f"{role}.npz")]
    lines = [f"{node},{direction}" for node, direction in zip(nodes, directions, strict=True)]
    (folder / "table.csv").write_text("node,direction\n" + "\n".join(lines) + "\n")
    more = str(rng.choice(["nothing more", "bearings added", "supports over the speed", "speed of the coefficients"]))
    if more == "bearings added":
        options += ["--bearings", "0", str(last)]
    elif more == "supports over the speed":
        rows = [f"{node},{hz},{k * (1 + hz / 50)},{ky * (1 + hz / 50)},{1e-4 * k}" for node in (0, last) for hz in (10, 60)]
        (folder / "supports.csv").write_text("\n".join(["node,hz,k_xx,k_yy,c_xx", *rows, ""]))
        options += ["--supports", str(folder / "supports.csv")]
    elif more == "speed of the coefficients":
        options += ["--speed", f"{rng.uniform(600.0, 6000.0):.0f} rpm"]
    return [*options, "--coordinates", str(folder / "table.csv"), "--contact", str(last // 2)], [*words, more]


def eigenvalues(model, added, speed):
    """Those of what was written, at a speed in Hz, with the bearings of the scene."""
    mass, damping, stiffness = (np.asarray(m.todense() if hasattr(m, "todense") else m) for m in model.with_conjugate(speed))
    for node, *coefficients in added:
        for own, value in zip((stiffness, damping), coefficients, strict=True):
            row = np.tile(model.row_at(node), 2)
            own[np.diag_indices_from(own)] += value * row
    inverse = np.linalg.inv(mass)
    zero, one = np.zeros_like(inverse), np.eye(len(inverse))
    return np.linalg.eigvals(np.block([[zero, one], [-inverse @ stiffness, -inverse @ damping]]))


def contradictions(text, folder):
    """What the printed remarks say that the written machine does not do."""
    model, added = load_model(folder / "m.npz")[0], tomllib.loads((folder / "m.toml").read_text())["rotor"].get("bearings", [])
    told = TOLD.search(text)
    if told is None:
        return ["no modes are printed"]
    values, found = eigenvalues(model, added, float(told[1])), []
    slow = np.sort_complex(values[np.argsort(np.abs(values))])
    largest = 0.0
    for hz, word, decrement in MODE.findall(told[2]):
        omega = 2.0 * np.pi * abs(float(hz))
        if word == "does not oscillate":
            continue
        growth = 0.0 if word == "undamped" else -abs(float(hz)) * float(decrement)
        away = np.abs(np.abs(slow.imag) - omega) + np.abs(slow.real - growth)
        largest = max(largest, abs(complex(growth, omega)))
        if away.min() > ROUNDED * abs(complex(growth, omega)) + STILL * omega:
            found.append(f"no mode is at {hz} Hz ({word})")
    for value in slow[(slow.imag > 0.0) & (np.abs(slow) < (1.0 - ROUNDED) * largest)]:
        listed = [abs(float(hz)) for hz, *_ in MODE.findall(told[2])]
        if min(abs(one - value.imag / 2.0 / np.pi) for one in listed) > ROUNDED * abs(value) / 2.0 / np.pi:
            found.append(f"a mode at {value.imag / 2.0 / np.pi:.4g} Hz is left out")
    damped = np.abs(slow.real) > 100.0 * STILL * np.abs(slow)
    if "nothing damps" in text and damped[np.abs(slow) <= largest * (1.0 - ROUNDED)].any():
        found.append("something is damped")
    here, there = (np.sort_complex(eigenvalues(model, added, hz)) for hz in (20.0, 50.0))
    apart = np.abs(np.sort(np.abs(here)) - np.sort(np.abs(there))).max() > 1e-6 * np.abs(here).max()
    same_growth = abs(here.real.max() - there.real.max()) <= 1e-6 * np.abs(here).max()
    if "nothing depends on the rotor speed" in text and (apart or not same_growth):
        found.append("the rotor speed has an effect")
    if "coefficients follow the rotor speed" in text and not apart:
        found.append("the rotor speed has no effect")
    if "magnetic" in text:
        found.append("there is no magnetic bearing")
    return found


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--imports", type=int, default=300)
    parser.add_argument("--first", type=int, default=0, help="number of the first import")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    kinds, ends, wrong = collections.Counter(), collections.Counter(), 0
    for number in range(options.first, options.first + options.imports):
        with tempfile.TemporaryDirectory() as name:
            folder, told, errors = Path(name), io.StringIO(), io.StringIO()
            arguments, words = drawn(number, folder)
            with contextlib.redirect_stdout(told), contextlib.redirect_stderr(errors):
                code = rsc(["import", "fe", *arguments, "-o", str(folder / "m.toml")])
            found = contradictions(told.getvalue(), folder) if code == 0 else []
        ends["imported" if code == 0 else "refused"] += 1
        kinds.update(words if code == 0 else [])
        if found:
            wrong += 1
            print(f"import {number} ({', '.join(words)}): {'; '.join(found)}\n{told.getvalue()}", file=sys.stderr, flush=True)
        elif code:
            print(f"import {number} ({', '.join(words)}): {errors.getvalue().strip()}", file=sys.stderr, flush=True)
    counts = f"{options.imports} random imports: {ends['imported']} imported, {ends['refused']} refused"
    lines = [f"{counts}; {wrong} whose remarks contradict the modes of the written machine.", ""]
    lines += ["| imported, with | imports |", "|---|---|", *(f"| {word} | {count} |" for word, count in sorted(kinds.items()))]
    print("\n".join(lines))
    if options.write and not wrong:
        command = f"python bench/import_remarks.py --imports {options.imports} --write"
        pages.write_page(ROOT / "bench" / "results" / "import_remarks.md", "Remarks of imports", command, "\n".join(lines))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
