"""What a finite-element machine costs and how right it is: two rotors of ROSS from their files to a run and a verdict.

    python bench/machine.py            prints the tables
    python bench/machine.py --write    keeps them in bench/results/machine.md

The rub rotor is that of data/reference/raw/ross_rub_rotor.toml with its own, unequal bearings. Two things are not from there: a
stator of two masses, since the data have a rigid ring, and 1.2 times the unbalance, without which a run-up stays short of the
gap (ross_rotor.py). A short stretch on a backward whirl is computed three ways:

    reduced      the scene as rsc reads it
    unreduced    rsc with all 68 coordinates in `contact_coordinates`: no motion is left out
    real         the matrices of ROSS's file in real coordinates, x and y apart, with SciPy's Radau and a contact of its own

All processor times are of one thread of linear algebra, as `rsc` runs, after a first pass that compiles; those of the commands
are user and system time of a whole process.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import scipy.integrate
import scipy.linalg

import rsc
from rsc.analysis.alone.free_vibration import free_vibrations
from rsc.machine.formats import read_matrices
from rsc.machine.reduction import contact_coordinates, turned
from rsc.machine.ross import read_ross
from rsc.machine.store import save_model
from rsc.show.answer import answer
from rsc.study.import_model import import_model
from rsc.study.start import initial_states
from rsc.system.assemble import assemble
from rsc.system.blas import one_thread

ROOT = Path(__file__).resolve().parent.parent
MACHINES = ROOT / "data" / "reference" / "machines"
SPEEDS = tomllib.loads((MACHINES / "ross_frequencies.toml").read_text())
RUB = tomllib.loads((ROOT / "data" / "reference" / "raw" / "ross_rub_rotor.toml").read_text())
sys.path[:0] = [str(ROOT / "tools")]

from pages import RESULTS, write_page  # noqa: E402

TWO_PI = 2.0 * np.pi
MORE_UNBALANCE = 1.2
MASSES, SPRINGS, RAYLEIGH = (1.0, 0.3), (1e6, 1e6, 0.0), (100.0, 1e-3)  # stator: wall, 1, 2; contact at 2
TOP = RUB["unbalance"]["speed_rpm"] / 60.0  # Hz
TOLERANCE, DURATION = 1e-4, 20.0
STRETCH, STRETCH_RATE = 0.2, 20000.0
TIGHT = 1e-9  # relative tolerance of the compared motions
# compressor: between the labyrinths, and the highest of its speeds
SEAL, NINE_THOUSAND, COMPRESSOR_BAND = 27, 150.0, ["-500 Hz", "250 Hz"]
BENDING = (100.0, 220.0)  # Hz, where its first bending modes lie


def spent(call, *arguments, **keys):
    """What a call returns, and its processor time in s."""
    begun = time.process_time()
    return call(*arguments, **keys), time.process_time() - begun


def rub_content(file, tolerance=TOLERANCE):
    """The rub rotor's scene: run-up in which it comes to touch."""
    rub, unbalance = RUB["rub"], RUB["unbalance"]
    return {
        "title": "ROSS's rub rotor",
        "rotor": {
            "model": "machine",
            "file": str(file),
            "contact": rub["node"],
            "unbalance": [[unbalance["node"], MORE_UNBALANCE * unbalance["magnitude"]]],
        },
        "reduction": {"tolerance": tolerance},
        "stator": {"model": "chain", "masses": MASSES, "stiffnesses": SPRINGS, "rayleigh": RAYLEIGH},
        "contact": {"stator_coordinate": 1} | {key: rub[key] for key in ("gap", "stiffness", "damping", "friction")},
        "drive": {"speed": [0.0, TOP], "duration": DURATION},
        "solver": {"method": "taylor8"},
    }


# ---- 1: from the file to the verdict


def whole_way(folder):
    """Lines on import, reduction, run and check, and the scene."""
    file, contact = MACHINES / "ross_rub_rotor.mat", RUB["rub"]["node"]
    for _ in range(2):  # the first pass compiles
        model, reading = spent(read_ross, file, SPEEDS["ross_rub_rotor"]["speed"])
        _, importing = spent(import_model, model, folder / "rub.toml", contact)
        scene, reducing = spent(rsc.Scene.from_dict, rub_content(folder / "rub.npz"))
        result, running = spent(rsc.simulate, scene)
        report, checking = spent(rsc.check, scene)
    times = [reading, importing, reducing, running, checking - running]
    rotor, summary = scene.rotor, result.summary
    coarse = rsc.Scene.from_dict(rub_content(folder / "rub.npz", 1e-3)).rotor
    names = ["read", "import (reduces once)", "scene and reduction", "run-up, 20 s", "prediction and comparison"]
    lines = [
        f"{rotor.coordinates_before} complex coordinates become {rotor.n_coordinates} at {TOLERANCE:g} "
        f"(error {rotor.error:.1e}) and "
        f"{coarse.n_coordinates} at 1e-3 (asked: at most 9), the highest frequency {rotor.highest_before:.0f} Hz "
        f"becomes {rotor.highest_after:.0f} Hz.",
        f"Run-up of 0 to {60.0 * TOP:g} rpm in {DURATION:g} s, taylor8: {summary.steps} steps, "
        f"{summary.contact_onsets} contacts, in contact for {summary.contact_time:.2f} s, {summary.status}, ledger residual "
        f"{abs(summary.ledger.residual) / summary.ledger.turnover:.0e} of the energies.",
        *(f"{topic}: {text}" for topic, text in answer(report)),
        "",
        "| phase | processor time, s |",
        "|---|---|",
        *(f"| {name} | {seconds:.3f} |" for name, seconds in zip(names, times, strict=True)),
        f"| sum (asked: at most 30) | {sum(times):.2f} |",
    ]
    return lines, scene


# ---- 2: a stretch in contact, three ways


def unreduced(scene):
    """Table [rotor] of the full body with the contact first, and full displacements = turn @ its own."""
    reduced, model = scene.reductions[0], read_ross(MACHINES / "ross_rub_rotor.mat")
    turn, mass = contact_coordinates(reduced.full)
    body = turned(reduced.full, turn, mass)
    content = scene.to_dict()["rotor"] | {
        "mass": mass,
        "observer_rows": [],
        "highest_after": scene.rotor.highest_before,
        "unbalance": pairs(body.unbalance.sum(axis=1)),
        "load": pairs(body.load),
    }
    content |= {name: getattr(body, name).tolist() for name in ("stiffness", "damping", "gyroscopic")}
    for name in ("anisotropic_stiffness", "anisotropic_damping"):
        full = turn.T @ getattr(model, name) @ turn
        content[name] = [pairs(row) for row in 0.5 * (full + full.T)]
    return content, turn


def pairs(values):
    """[real, imaginary] of each."""
    return [[float(item.real), float(item.imag)] for item in np.asarray(values, dtype=complex)]


def stretch(scene, duration, rate, rtol, rotor=None, start=None):
    """The scene at the top speed, on its largest backward whirl or in a state."""
    content = scene.to_dict()
    content |= {"drive": {"speed": TOP, "duration": duration}, "start": start or {"whirl": "backward"}}
    content["solver"], content["output"] = {"method": "taylor8", "rtol": rtol}, {"rate": rate}
    content["rotor"] = rotor or content["rotor"]
    return replace(rsc.Scene.from_dict(content), reductions=() if rotor else scene.reductions)


def state(start, lift):
    """Table [start] of an initial state, the rotor's displacements and velocities lifted."""
    parts = {"rotor": lift @ start.rotor, "rotor_velocity": lift @ start.rotor_velocity}
    parts |= {"stator": start.stator, "stator_velocity": start.stator_velocity}
    return {name: pairs(part) for name, part in parts.items()} | {"allow_penetration": True}


class Real:
    """The rub machine in real coordinates [lateral rows of ROSS's file; stator x, y of each mass]; q'' = f(t, q, q')."""

    def __init__(self, model):
        raw = read_matrices(MACHINES / "ross_rub_rotor.mat").matrices
        n_nodes = raw["nodes"].size
        rows = [6 * node + k for node in range(n_nodes) for k in (0, 1, 3, 4)]
        omega, rub = TWO_PI * TOP, RUB["rub"]
        k, c = springs(), RAYLEIGH[0] * np.diag(MASSES) + RAYLEIGH[1] * springs()
        part = {key: raw[key][np.ix_(rows, rows)] for key in "MKCG"}
        mass = scipy.linalg.block_diag(part["M"], np.kron(np.diag(MASSES), np.eye(2)))
        self.inverse = np.linalg.inv(mass)
        self.stiffness = scipy.linalg.block_diag(part["K"], np.kron(k, np.eye(2)))
        self.damping = scipy.linalg.block_diag(part["C"] + omega * part["G"], np.kron(c, np.eye(2)))
        self.n, self.shaft = len(mass), len(rows)
        at = 4 * rub["node"]
        self.difference = np.zeros((2, self.n))  # rotor less stator at the contact
        self.difference[[0, 1], [at, at + 1]] = 1.0
        self.difference[[0, 1], [self.shaft + 2, self.shaft + 3]] = -1.0
        self.pull = np.zeros((self.n, 2))
        self.pull[[at, at + 1], [0, 1]] = MORE_UNBALANCE * RUB["unbalance"]["magnitude"] * omega**2
        self.omega, self.rub, self.model = omega, rub, model

    def force(self, gap_vector, rate):
        """Force on the rotor, and its slopes by displacement and velocity difference (2, 2)."""
        distance = np.hypot(*gap_vector)
        normal = gap_vector / distance
        opening = normal @ rate
        parting = opening < 0.0
        push = self.rub["stiffness"] * (distance - self.rub["gap"]) + self.rub["damping"] * opening * parting
        if distance <= self.rub["gap"] or push <= 0.0:
            return np.zeros(2), np.zeros((2, 2)), np.zeros((2, 2))
        mu = self.rub["friction"]
        turn = -np.array([[1.0, -mu], [mu, 1.0]])
        across = (np.eye(2) - np.outer(normal, normal)) / distance
        by_place = self.rub["stiffness"] * normal + self.rub["damping"] * parting * (across @ rate)
        slope = turn @ (np.outer(normal, by_place) + push * across)
        return push * turn @ normal, slope, turn @ np.outer(normal, self.rub["damping"] * parting * normal)

    def __call__(self, t, y):
        """Time derivative of [q, q']."""
        q, v = y[: self.n], y[self.n :]
        force = self.force(self.difference @ q, self.difference @ v)[0]
        angle = self.omega * t
        load = self.difference.T @ force + self.pull @ np.array([np.cos(angle), np.sin(angle)])
        return np.concatenate([v, self.inverse @ (load - self.stiffness @ q - self.damping @ v)])

    def slope(self, t, y):
        """Its Jacobian."""
        q, v = y[: self.n], y[self.n :]
        _, by_place, by_rate = self.force(self.difference @ q, self.difference @ v)
        lower = [self.difference.T @ part @ self.difference for part in (by_place, by_rate)]
        left, right = self.inverse @ (lower[0] - self.stiffness), self.inverse @ (lower[1] - self.damping)
        return np.block([[np.zeros((self.n, self.n)), np.eye(self.n)], [left, right]])

    def packed(self, rotor, stator):
        """Complex displacements (or velocities) as a real vector: u = x + i y, phi = beta - i alpha."""
        q = np.zeros(self.n)
        for node, kind, value in zip(self.model.node, self.model.kind, rotor, strict=True):
            i = 4 * node
            if kind == "displacement":
                q[i], q[i + 1] = value.real, value.imag
            else:
                q[i + 2], q[i + 3] = -value.imag, value.real
        q[self.shaft :: 2], q[self.shaft + 1 :: 2] = stator.real, stator.imag
        return q


def springs():
    """Stiffness matrix of the stator's chain."""
    first, second, third = SPRINGS
    return np.array([[first + second, -second], [-second, second + third]])


def compared(scene):
    """Lines on the stretch."""
    model = read_ross(MACHINES / "ross_rub_rotor.mat")
    own = stretch(scene, STRETCH, STRETCH_RATE, TIGHT)
    [start] = initial_states([own], [assemble(own)])
    basis = scene.reductions[0].basis
    content, turn = unreduced(scene)
    full = stretch(scene, STRETCH, STRETCH_RATE, TIGHT, content, state(start, np.linalg.solve(turn, basis)))
    rsc.simulate(stretch(scene, 0.001, STRETCH_RATE, TIGHT, content, full.to_dict()["start"]))  # compiles
    rsc.simulate(own)
    (small, small_time), (large, large_time) = spent(rsc.simulate, own), spent(rsc.simulate, full)
    real, times = Real(model), small.time
    begin = [real.packed(basis @ start.rotor, start.stator), real.packed(basis @ start.rotor_velocity, start.stator_velocity)]
    gap = RUB["rub"]["gap"]
    near = np.repeat([1e-8 * gap, 1e-8 * gap * 1e3], real.n)
    radau, radau_time = spent(
        scipy.integrate.solve_ivp,
        real,
        (0.0, STRETCH),
        np.concatenate(begin),
        "Radau",
        times,
        jac=real.slope,
        rtol=1e-8,
        atol=near,
    )
    at, stator = 4 * RUB["rub"]["node"], real.shaft + 2
    theirs = [radau.y[i] + 1j * radau.y[i + 1] for i in (at, stator)]
    moves = np.flatnonzero(model.kind == "displacement")
    nodes = np.array([radau.y[4 * model.node[i]] + 1j * radau.y[4 * model.node[i] + 1] for i in moves]).T
    everywhere = [(result.rotor @ lift.T)[:, moves] for result, lift in ((small, basis), (large, turn))]
    motions = {
        "reduced": (small.contact_rotor(), small.contact_stator(), everywhere[0], small.steps, small_time),
        "unreduced": (large.contact_rotor(), large.contact_stator(), everywhere[1], large.steps, large_time),
        "real, Radau": (*theirs, nodes, radau.nlu, radau_time),
    }
    return stretch_lines(motions, scene, small, large_time)


def stretch_lines(motions, scene, small, large_time):
    """Lines of the comparison."""
    gap = RUB["rub"]["gap"]
    last = motions["real, Radau"]
    lines = [
        f"{STRETCH:g} s at {60.0 * TOP:g} rpm from the state of the predicted backward whirl, in contact for "
        f"{small.summary.contact_time:.3f} s; rotor at the contact up to {abs(small.contact_rotor()).max() / gap:.2f} gaps, "
        f"stator up to {abs(small.contact_stator()).max() / gap:.2f}. "
        "Differences: the largest over the motion, in gaps, from the last row.",
        "",
        "| engine | rotor at the contact | stator at the contact | any node of the shaft | steps | processor time, s |",
        "|---|---|---|---|---|---|",
    ]
    for name, (*parts, steps, seconds) in motions.items():
        errors = [f"{np.abs(part - other).max() / gap:.1e}" for part, other in zip(parts, last, strict=False)]
        counts = f"{steps} factorizations" if name.startswith("real") else f"{steps}"
        lines.append(f"| {name} | {' | '.join(errors if name != 'real, Radau' else '---')} | {counts} | {seconds:.2f} |")
    whole = stretch(scene, DURATION, 2000.0, TIGHT)
    result, seconds = spent(rsc.simulate, whole)
    ratio = large_time * DURATION / STRETCH / seconds
    lines += [
        "",
        f"{DURATION:g} s of the same, reduced and at the same tolerance ({TIGHT:g}): {seconds:.2f} s of processor "
        f"time, {result.steps} steps. "
        f"Unreduced they would take {large_time * DURATION / STRETCH:.0f} s, extrapolated from the stretch: "
        f"{ratio:.0f} times as much "
        "(asked: 300).",
    ]
    return lines


# ---- 3: the compressor


def compressor_scene(folder, model, tolerance=1e-3):
    """A scene of the compressor, up to 9,000 rpm, contact at a seal; the stator is any."""
    save_model(model, folder / "compressor.npz")
    return rsc.Scene.from_dict(
        {
            "rotor": {
                "model": "machine",
                "file": str(folder / "compressor.npz"),
                "contact": SEAL,
                "unbalance": [[SEAL, "G 2.5"]],
            },
            "reduction": {"tolerance": tolerance, "band": COMPRESSOR_BAND},
            "stator": {"model": "rigid"},
            "contact": {"gap": 2e-4, "friction": 0.1, "stiffness": 1e8},
            "drive": {"speed": [0.0, NINE_THOUSAND], "duration": 10.0},
        }
    )


def full_decrements(model, speed):
    """Logarithmic decrements of the first backward and forward bending mode of a Model, from all its coordinates."""
    mass, damping, stiffness = (np.asarray(part) for part in model.with_conjugate(speed))
    n = len(mass)
    lower = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    values, vectors = np.linalg.eig(np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower]))
    sizes = [np.sqrt(np.abs(np.einsum("ik,ij,jk->k", p.conj(), model.mass, p))) for p in (vectors[: n // 2], vectors[n // 2 : n])]
    kept = values[sizes[0] > sizes[1]]  # the others are the same motions seen by conj(z)
    return first_two(kept.imag / TWO_PI, kept.real)


def reduced_decrements(scene, speed):
    """The same of a scene's rotor."""
    found = free_vibrations(assemble(scene), speed)
    return first_two(np.array([item.frequency for item in found]), np.array([item.growth_rate for item in found]))


def first_two(frequency, growth):
    """-growth / |frequency| of the lowest frequency of each sense within BENDING: backward, forward."""
    pair = []
    for sense in (-1.0, 1.0):
        of_sense = np.flatnonzero((sense * frequency > BENDING[0]) & (sense * frequency < BENDING[1]))
        i = of_sense[np.argmin(np.abs(frequency[of_sense]))]
        pair.append(float(-growth[i] / abs(frequency[i])))
    return tuple(pair)


def compressor(folder):
    """Lines on the compressor."""
    model = read_ross(MACHINES / "ross_compressor.mat", SPEEDS["ross_compressor"]["speed"])
    symmetric = {name: getattr(model, name).real + 0j for name in ("anisotropic_stiffness", "anisotropic_damping")}
    plain = replace(model, skew_stiffness=None, skew_damping=None, **symmetric)  # k_xy and k_yx are zero
    rows = []
    for name, own, wanted in (("as it is", model, "1.77, 0.73"), ("without cross-coupling", plain, "1.21, 1.28")):
        scene = compressor_scene(folder, own)
        both = [full_decrements(own, NINE_THOUSAND), reduced_decrements(scene, NINE_THOUSAND)]
        shown = " | ".join(f"{backward:.4f}, {forward:.4f}" for backward, forward in both)
        rows.append(f"| {name} | {scene.rotor.n_coordinates} | {scene.rotor.error:.1e} | {wanted} | {shown} |")
    return [
        f"{model.n} complex coordinates, contact at node {SEAL}, tolerance 1e-3 from -500 to 250 Hz and 0 to 9,000 rpm; asked: "
        f"at most 12 coordinates. Coefficients of bearings and seals are those at {60.0 * model.speed:g} rpm.",
        "Logarithmic decrements of the first bending mode, backward and forward, at 9,000 rpm:",
        "",
        "| compressor | coordinates | error at the contact | asked | full | reduced |",
        "|---|---|---|---|---|---|",
        *rows,
    ]


# ---- 4: the prediction


def predictions(folder, scene):
    """Lines on `rsc predict` as a command."""
    content, _ = unreduced(scene)
    full = scene.to_dict() | {"rotor": content}
    (folder / "full.toml").write_text(rsc.Scene.from_dict(full).to_toml())
    (folder / "small.toml").write_text(scene.to_toml())
    files = {f"reduced, {scene.rotor.n_coordinates} coordinates (asked: 3 s)": "small.toml",
             f"unreduced, {len(content['stiffness'])} coordinates (asked: 10 s)": "full.toml"}  # fmt: skip
    lines = ["| `rsc predict` | branches over the speeds, s | one speed, s |", "|---|---|---|"]
    for name, file in files.items():
        seconds = [command_time("predict", str(folder / file), *more) for more in ((), ("--speed", f"{TOP:g}"))]
        lines.append(f"| {name} | {seconds[0]:.2f} | {seconds[1]:.2f} |")
    return lines


def command_time(*arguments):
    """Processor time in s of a whole command that ends well, the second time that it runs."""
    for _ in range(2):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
        subprocess.run([sys.executable, "-m", "rsc", *arguments], check=True, capture_output=True, env=environment)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@one_thread
def tables():
    """The page."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        way, scene = whole_way(folder)
        parts = {
            "From ROSS's file to a verdict": way,
            "The compressor": compressor(folder),
            "The prediction": predictions(folder, scene),
            "A stretch in contact, three ways": compared(scene),
        }
    lines = []
    for title, text in parts.items():
        lines += [f"## {title}", "", *text, ""]
    return "\n".join(lines)


def main():
    """Print the tables, or keep them."""
    text = tables()
    print(text)
    if "--write" in sys.argv[1:]:
        write_page(RESULTS / "machine.md", "Finite-element machines", "python bench/machine.py --write", text)


if __name__ == "__main__":
    main()
