"""What each trick of the kernel is worth: the sources with one trick taken out, timed beside the sources as they are.

    python bench/ablation.py [--problems P1 P1c P2 gyro] [--tol 1e-6] [--repeats 9] [--copies 3] [--only NAME ...]
    python bench/ablation.py --against COMMIT [--method taylor8] [--without-avx512]      what a change of the sources costs

All variants live in one process and take turns, in a rolling order, so that another load on the machine hits all alike; so does
the plain C of the same algorithm, with and without ledger. Where in memory a variant happens to lie moves its times by some
percent: of each there are several copies, compiled apart. Prints nanoseconds per attempted step (mean over the copies of the
least of each, and half their range), the ratio to the kernel as it is, attempts and error; writes results/ablation.csv. A patch
that no longer fits the sources is an error (tests/unit/test_seeded_bugs.py tells at once). With --against the sources of a commit
take the place of the patches, and nothing is written; the code of a processor without AVX-512 can be had on any.
"""

import argparse
import contextlib
import csv
import importlib
import itertools
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import llvmlite.binding
import numpy as np

BENCH = Path(__file__).resolve().parent
sys.path.append(str(BENCH.parent / "tools"))

from anchors import Package  # noqa: E402

RESULTS = BENCH / "results"
PROBLEMS = ("P1", "P1c", "P2", "gyro")

LIBRARY_SINE = """
return _library_cos(TWO_PI * phase), _library_sin(TWO_PI * phase)
halves = vec.whole(2.0 * phase)
"""
LIBRARY = """
from rsc.kernel.simd.registers import call_lanewise, each

def _library(name):
    def by_register(kind, builder, a):
        return each(builder, kind, lambda part: call_lanewise(builder, name, part), a)

    return vec.of_one(by_register)

_library_cos, _library_sin = _library("llvm.cos"), _library("llvm.sin")
"""
TURNED = "turned(vec.spread(clock.cos, tau), vec.spread(clock.sin, tau), angle)"
FROM_PHASES = [
    ("turns_after", TURNED, "cos_sin(vec.spread(clock.phase, tau) + angle)"),
    ("turns_after", "", "from rsc.kernel.turn import cos_sin"),
]

NO_POWERS = [("rhs._uncoupled", "return a, (), vec.product(v, imposed), (), (), ()", "return a, (), motion[2], (), (), ()")]
ADDRESSES = (
    "_addresses_of(model.damping_columns, model.gyroscopic_columns, model.stiffness_columns, model.rotating_columns, "
    "model.following_stiffness, model.states)"
)
FIRST = "first_share(con, start, h, weight), vec.fma(part, p.drive, before.drive)"
STAGE_DRIVEN = "vec.fma(weight, vec.product(v, imposed), work.drive)"
LOSSES = "lost_until(con, field_h, before.damping, work.damping, (begin[1], mean, v), slopes)"
RTOL = "vec.spread(con.per_rtol2, step.x0)"
NEAR = "g_near = max(exit_margin(con, contact[0], contact[1], kin), 0.0)"
MET = "_defect2(con, 0.5 * _wrong_force(con, contact, kin_new), tau, path.step.v) <= con.switch_tol * con.switch_tol"
FACTS = "add_steps(con.contacts, stretch, tally, contacts.each, start, new, before, h_try)"
UNKNOWN_ZEROS = "(int(model.rtol < 0.0), int(model.rtol < 0.0))"  # to the compiler
AS_IT_IS = "as it is"

# name: [(place, text, text instead), ...], edits of tools/anchors.py
PATCHES = {
    AS_IT_IS: [],
    "sine and cosine by the library in every stage": [
        ("cos_sin", "", LIBRARY),
        ("cos_sin", "halves = vec.whole(2.0 * phase)", LIBRARY_SINE),
        *FROM_PHASES,
    ],
    "rotations of the stages from their phases": FROM_PHASES,
    "step-size power by the library": [
        ("control.factor", "max(log2_roughly(error2), -40.0)", "max(math.log2(error2), -40.0)"),
        ("control.factor", "_exp2(min(max(power, -2.3), 2.3))", "2.0 ** min(max(power, -2.3), 2.3)"),
    ],
    "force waits for the velocity in every mode": [("_pushed_by", "law.b > 0.0", "law.b >= 0.0")],
    "friction and ring by selections, not branches": [
        ("_pushed_by", "branched(law.mu_slope)", "law.mu_slope"),
        ("contact.motion", "branched(place.ring_y)", "place.ring_y"),
    ],
    "few numbers in registers of eight": [
        ("registers", "FEW = 16", "FEW = 4"),
        ("from_numbers", "4 if is_vec(pattern) and pattern.largest < 8 else 8", "8"),
    ],
    "root, then division": [("direction", "distance * (1.0 / square)", "1.0 / distance")],
    "stack not aligned": [("kernel.march", "aligned_stack()", "")],
    "matrices not on cache lines": [
        ("on_lines", "-room.ctypes.data % (8 * _LINE) // 8", "-room.ctypes.data % (8 * _LINE) // 8 + 2")
    ],
    "code for matrices that the scene has not": [
        ("constants", ADDRESSES, UNKNOWN_ZEROS)
    ],
    "code for a contact ring that the scene has not": [("_contact_of", "len(data.ring) > 0", "data.gap < 0.0")],
    "weights and coefficients as constants of the code": [("stored", "builder.load(place)", "place.initializer")],
    "division by the scale after the errors": [
        (
            "weighed_square",
            "vec.pair_sums(e_x * e_x, e_v * e_v) * weight",
            "vec.pair_sums(e_x * e_x, e_v * e_v) / (vec.spread(1.0, weight) / weight)",
        ),
    ],
    "no energy ledger": [
        ("_pushed_by", "weight != 0.0", "weight > 1e9"),
        ("rhs._uncoupled", "weight == 0.0", "weight < 1e9"),
        ("rhs._coupled", "weight == 0.0", "weight < 1e9"),
        *NO_POWERS,
        ("begun", FIRST, FIRST[: FIRST.index(" vec")] + " before.drive"),
        ("begun", "with_shares(part, p.contact, before.contact), with_shares(part, p.friction, before.friction)",
         "before.contact, before.friction"),
        ("_pair_step", LOSSES, "before.damping"),
    ],
    "no work of the dampers": [("_pair_step", LOSSES, "before.damping")],
    "no work of the drive": [
        ("rhs._uncoupled", STAGE_DRIVEN, "work.drive"),
        *NO_POWERS,
        ("begun", FIRST, FIRST.replace("vec.fma(part, p.drive, before.drive)", "before.drive")),
    ],
    "no facts of stretches": [("walk", FACTS, "")],
    "no sizes of rotor and stator among them": [("facts._add_step", "_see_size(con, at, start, new, kins[1].place, h)", "")],
    "no forces among them": [
        ("facts._add_step", "_see_force(con, at, contact, kins, _raced(con, start.v, new.v), slopes, fed, (h, new.clock.hi))", "")
    ],
    "switches passed over": [("search", NEAR, "if path.h > 0.0:\n    return 0.0\n" + NEAR)],
    "a step made to end on a switch searched again": [("search", f"met = {MET}", "met = False")],
    "switches met to rounding": [
        ("_shorter", "defect2 <= con.switch_tol * con.switch_tol", "defect2 <= 1e-12 * con.switch_tol * con.switch_tol"),
        ("search", MET, f"1e12 * {MET}"),
    ],
    "a step length about right is not kept": [
        ("kept_between", "return _aim(method), 0.5 if estimate_order(method) == 5 else 0.25", "return 1.0, 0.0")
    ],
}


@contextlib.contextmanager
def sources(folder):
    """While it lasts `rsc` and the modules here are imported anew, rsc from a folder and with its own cache of compiled code."""
    ours = {"rsc", "peers", *(file.stem for file in BENCH.glob("*.py"))}
    kept = {name: module for name, module in sys.modules.items() if name.split(".")[0] in ours}
    cache = os.environ.get("XDG_CACHE_HOME")
    for name in kept:
        del sys.modules[name]
    sys.path.insert(0, str(folder))
    os.environ["XDG_CACHE_HOME"] = str(folder / "cache")
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        for name in [name for name in sys.modules if name.split(".")[0] in ours]:
            del sys.modules[name]
        sys.modules.update(kept)
        del os.environ["XDG_CACHE_HOME"]
        if cache is not None:
            os.environ["XDG_CACHE_HOME"] = cache


def patched(folder, edits, commit=None):
    """A copy of src/, as it is or in a commit, with edits applied."""
    if commit is None:
        shutil.copytree(BENCH.parent / "src", folder)
    else:
        folder.mkdir()
        archive = subprocess.run(["git", "archive", f"{commit}:src"], cwd=BENCH.parent, check=True, capture_output=True)
        subprocess.run(["tar", "-x", "-C", folder], input=archive.stdout, check=True)
    for path, source in Package(folder / "rsc").after(edits).sources.items():
        path.write_bytes(source)
    return folder


def variant(folder, method, patches, commit=None):
    """name of a problem -> `own.Rsc` on patched sources."""
    with sources(patched(folder, patches, commit)):
        own, problems = map(importlib.import_module, ("peers.own", "problems"))
    # a run in one call: Numba takes a third of a millisecond a call to tell the types of a second class of the same name
    own.CHUNK_STEPS = 10**9
    return lambda name: own.Rsc(problems.problem(name), method)


def in_c(ledger):
    """name of a problem -> the plain C of the same algorithm, or None without a compiler."""
    own, problems = importlib.import_module("peers.own"), importlib.import_module("problems")

    def make(name):
        try:
            return own.PlainC(problems.problem(name), ledger)
        except own.Absent:
            return None

    return make


def measured(name, makers, tol, repeats):
    """Rows (variant, seconds, their scatter, ratio to the first variant, attempts, error in gaps or NaN) of one problem.

    Seconds: mean over the copies of a variant of the least of each; scatter: largest over smallest of these, less one.
    """
    from problems import problem
    from reference import solution

    case = problem(name)
    runs = [(label, run) for label, copies in makers.items() for make in copies if (run := make(name)) is not None]
    outcomes = [run(tol) for _, run in runs]  # compiles
    exact, seconds = solution(case).motion, np.zeros((repeats, len(runs)))
    for turn in range(repeats):
        for i in np.roll(np.arange(len(runs)), turn):
            seconds[turn, i] = runs[i][1](tol).seconds
    least, base = seconds.min(axis=0), None
    for label in dict.fromkeys(label for label, _ in runs):
        mine = [i for i, run in enumerate(runs) if run[0] == label]
        mean, scatter, outcome = least[mine].mean(), least[mine].max() / least[mine].min() - 1.0, outcomes[mine[0]]
        base = base or mean
        error = float("nan") if outcome.motion is None else float(abs(outcome.motion - exact).max() / case.matrices.gap)
        yield label, mean, scatter, mean / base, outcome.calls // 6, error


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--problems", nargs="+", default=PROBLEMS)
    parser.add_argument("--tol", type=float, default=1e-6)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--copies", type=int, default=3)
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--against", metavar="COMMIT")
    parser.add_argument("--method", default="rk45")
    parser.add_argument("--without-avx512", action="store_true")
    options = parser.parse_args()
    if options.without_avx512:
        os.environ |= {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": ""}  # read when numba is imported
        llvmlite.binding.get_host_cpu_features = dict  # which older sources ask
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        places = (Path(folder) / str(i) for i in itertools.count())
        if options.against:
            variants = {options.against: ([], options.against), AS_IT_IS: ([],)}
        else:
            chosen = [AS_IT_IS, *(options.only or PATCHES)]
            variants = {name: (patches,) for name, patches in PATCHES.items() if name in chosen}
        copies, method = range(options.copies), options.method
        makers = {name: [variant(next(places), method, *parts) for _ in copies] for name, parts in variants.items()}
        if not options.against:
            makers |= {"plain C": [in_c(True)], "plain C, no energy ledger": [in_c(False)]}
        for problem in options.problems:
            for name, seconds, scatter, ratio, attempts, error in measured(problem, makers, options.tol, options.repeats):
                rows.append((problem, name, options.tol, seconds, scatter, ratio, attempts, error))
                said = f"error {error:.1e}" if error == error else "diverged"
                each = f"{1e9 * seconds / attempts:6.0f} ns +- {50.0 * scatter:3.1f} % {ratio:6.3f} {attempts:9,} attempts"
                print(f"{problem:5}{name:48}{each}  {said}", flush=True)
    if not options.against:
        write(RESULTS / "ablation.csv", rows)


def write(path, rows):
    """Write rows, and keep those of other problems in a file that is there."""
    path.parent.mkdir(exist_ok=True)
    measured_now = {row[0] for row in rows}
    kept = list(csv.reader(path.open(newline="")))[1:] if path.exists() else []
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["problem", "variant", "tolerance", "seconds", "scatter", "ratio", "attempts", "error_gaps"])
        writer.writerows([row for row in kept if row[0] not in measured_now] + rows)


if __name__ == "__main__":
    main()
