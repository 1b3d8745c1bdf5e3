"""ROSS's own rub run beside rsc's, where the laws of contact are the same.

    python bench/ross_rub.py PYTHON            PYTHON: an interpreter that has ross-rotordynamics 2.3 (with plotly < 6.1)
    python bench/ross_rub.py PYTHON --write    keeps the table in bench/results/ross_rub.md

ROSS's damper of the contact acts on the whole velocity and its friction by components, each with one sign: neither is rsc's law.
Without both the laws are one, a spring beyond the gap. Rotor, gap, stiffness and unbalance are those of
data/reference/raw/ross_rub_rotor.toml, the ring is rigid, and 1200 rpm act at once. ROSS steps by Newmark's method with all
coordinates; its difference from rsc halves with its step, so a row is extrapolated from its two shortest ones, 2 y(h) - y(2 h).
"""

import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import numpy as np

import rsc
from rsc.machine.ross import read_ross
from rsc.machine.store import save_model

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tools")]

from pages import RESULTS, write_page  # noqa: E402

SOURCE = ROOT / "data" / "reference" / "raw" / "ross_rub_rotor.toml"
RUB = tomllib.loads(SOURCE.read_text())
DURATION, STEPS = 0.3, (1e-4, 2e-5, 1e-5)  # s; the last two: a step and half of it
THEIRS = """
import sys, time, tomllib
import numpy as np, ross as rs
data = tomllib.loads(open(sys.argv[1]).read())
shaft, disc, rub = data["shaft"], data["disc"], data["rub"]
steel = rs.Material(name="Steel", rho=shaft["density"], E=shaft["youngs_modulus"], Poisson=0.2992610837438423)
more = {"material": steel, "alpha": shaft["rayleigh_alpha"], "beta": shaft["rayleigh_beta"]}
elements = [rs.ShaftElement(L, 0.0, shaft["outer_diameter"], **more) for L in np.diff(shaft["node_positions_mm"]) / 1000.0]
discs = [rs.DiskElement(n=n, m=disc["mass"], Id=disc["diametral_inertia"], Ip=disc["polar_inertia"]) for n in disc["nodes"]]
bearings = [rs.BearingElement(n=b["node"], **{key: b[key] for key in ("kxx", "kyy", "cxx", "cyy")}) for b in data["bearing"]]
rotor, h, unbalance = rs.Rotor(elements, discs, bearings), float(sys.argv[3]), data["unbalance"]
begun = time.process_time()
found = rotor.run_rubbing(n=rub["node"], distance=rub["gap"], contact_stiffness=rub["stiffness"], contact_damping=0.0,
    friction_coeff=0.0, torque=False, node=[unbalance["node"]], unbalance_magnitude=[unbalance["magnitude"]],
    unbalance_phase=[0.0], speed=unbalance["speed_rpm"] * np.pi / 30.0, t=np.arange(0.0, float(sys.argv[2]) + h / 2.0, h))
row = 6 * rub["node"]
np.savez(sys.argv[4], time=found.t, motion=found.yout[:, row] + 1j * found.yout[:, row + 1], seconds=time.process_time() - begun)
"""


def ours(folder, tolerance):
    """rsc's run of the reduced rotor, its number of coordinates first."""
    rub, unbalance, speed = RUB["rub"], RUB["unbalance"], RUB["unbalance"]["speed_rpm"] / 60.0
    save_model(read_ross(ROOT / "data" / "reference" / "machines" / "ross_rub_rotor.mat", speed), folder / "rotor.npz")
    where = {"model": "machine", "file": str(folder / "rotor.npz"), "contact": rub["node"]}
    scene = rsc.Scene.from_dict(
        {
            "rotor": where | {"unbalance": [[unbalance["node"], unbalance["magnitude"]]]},
            "reduction": {"tolerance": tolerance},
            "stator": {"model": "rigid"},
            "contact": {"gap": rub["gap"], "stiffness": rub["stiffness"], "damping": 0.0, "friction": 0.0},
            "drive": {"speed": speed, "duration": DURATION},
            "solver": {"method": "taylor8", "rtol": 1e-9},
            "output": {"rate": 1.0 / max(STEPS)},
        }
    )
    return scene.rotor.n_coordinates, rsc.simulate(scene)


def main(python, *options):
    """Print the table, and keep it."""
    gap, rows, motions = RUB["rub"]["gap"], [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (coarse, rough), (fine, run) = ours(folder, 1e-4), ours(folder, 1e-6)
        for h in STEPS:
            subprocess.run([python, "-c", THEIRS, SOURCE, str(DURATION), str(h), folder / "ross.npz"], check=True)
            theirs = np.load(folder / "ross.npz")
            motions.append(theirs["motion"][:: round(max(STEPS) / h)])
            rows.append((f"ROSS, h = {h:g} s", motions[-1], f"{float(theirs['seconds']):.1f}"))
    rows.append(("ROSS, extrapolated", 2.0 * motions[-1] - motions[-2], ""))
    own = run.contact_rotor()
    rows.append((f"rsc, {coarse} coordinates", rough.contact_rotor(), ""))
    lines = [
        f"{DURATION:g} s, {run.contact_onsets} contacts; differences from rsc with {fine} coordinates, in gaps.",
        "",
        "| run | largest difference | largest motion, gaps | processor time, s |",
        "|---|---|---|---|",
    ]
    for label, motion, seconds in rows:
        n = min(len(motion), len(own))
        largest = np.abs(motion[:n] - own[:n]).max() / gap
        lines.append(f"| {label} | {largest:.1e} | {np.abs(motion).max() / gap:.5f} | {seconds} |")
    lines.append(f"| rsc, {fine} coordinates | | {np.abs(own).max() / gap:.5f} | |")
    print("\n".join(lines))
    if "--write" in options:
        command = "python bench/ross_rub.py PYTHON --write"
        write_page(RESULTS / "ross_rub.md", "ROSS's rub run and rsc's", command, "\n".join(lines))


if __name__ == "__main__":
    main(*sys.argv[1:])
