"""No contact is missed: every accepted step of a million contacts looked at in 64 places, by equations that are not the kernel's.

    python bench/audit.py [--contacts 1000000] [--write]

The kernel is walked step by step. From the states at both ends of a step, and the accelerations of the contact deflection d
that the matrices of the `System` give there in the mode the kernel believed, the motion of d inside is the quintic that meets d,
d' and d'' at both ends: neither the stages nor the interpolant of the kernel. On it, in 64 places:

- a step believed open in which d goes beyond the gap and comes back, or after which no force follows, has passed over a
  contact. It is *missed* when it is deeper than one step may err in d at the tolerance, rtol sum |Phi_i| (gap^2 + |x_i|^2)^(1/2):
  whether there is a contact below that is decided by an error that was allowed. Shallower ones are counted as grazes;
- a step believed without force after a release (clipped) in which d goes back in has missed a contact in the same sense;
- a step believed pressed in which the gap opens and closes, or after which no release follows, holds a *false* contact in the
  same sense: its spring pulls.

A step that ends beyond the switch that follows it has met it late; how far is told in the same measure, but is no miss: the
kernel lets a switch be late while the force that is wrong meanwhile leaves an error of the velocity below a share of rtol.

Scenes: variants of data/reference/bouncing.toml with a fixed seed, along ramps of the speed and grazing at a constant one (by
1e-9 to 1e-2 gaps at first), with weight (an elliptic orbit touches in one place), soft and stiff: the table says how many of the
contacts were shallow.
"""

import argparse
import dataclasses
import math
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np

from rsc import load_scene
from rsc.kernel import model as kernel
from rsc.kernel.contact import CLIPPED, OPEN, OPENING
from rsc.kernel.march import march
from rsc.simulation.pack import pack
from rsc.simulation.run import _new_work
from rsc.study.start import initial_state
from rsc.system.assemble import assemble

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from pages import RESULTS, write_page  # noqa: E402

PLACES = 64
TOLERANCES = {"rk45": (1e-4, 1e-5, 1e-6, 1e-8), "taylor8": (1e-4, 1e-6, 1e-8, 1e-10)}
SEED = 20260104
SAMPLE_RATE = 50.0  # Hz; the samples are not looked at
CONTACTS_A_RUN = 200
QUIET_STEPS = 20_000  # a run that neither touches nor parts for so many steps has nothing more to show

COUNTS = ("contacts", "shallow", "very_shallow", "steps", "open_steps", "grazes", "missed", "false", "runs", "unfinished")
CONTACTS, SHALLOW, VERY_SHALLOW, STEPS, OPEN_STEPS, GRAZES, MISSED, FALSE, RUNS, UNFINISHED = range(len(COUNTS))


class View(NamedTuple):
    """d and its acceleration from the kernel's complex coordinates x: real rows made of the System's matrices."""

    deflection: np.ndarray  # (n,) d = row x
    stiffness: np.ndarray  # (n,) d'' = -row x ...
    damping: np.ndarray  # (n,) ... - row x' + i Omega gyroscopic row x' ...
    gyroscopic: np.ndarray  # (n,)
    unbalance: complex  # ... + (Omega^2 unbalance - i Omega' euler) e^(i phi) + load - mobility F_C
    euler: complex
    load: complex
    mobility: float  # 1/kg
    speed: float  # rad/s at t = 0
    speed_rate: float  # rad/s^2
    gap: float
    friction: float
    k_c: float
    b_c: float


def view_of(system, packed):
    """`View` of a scene with a straight speed schedule, a centred contact ring and the one-sided friction law."""
    assert system.ring_ecc == 0.0 and system.diameter is None and system.schedule_time.size == 2
    rotor, stator = packed.rotor.shape, packed.stator.shape
    by_r, by_s = np.linalg.solve(system.mass_r, system.contact_r), np.linalg.solve(system.mass_s, system.contact_s)

    def row(matrix_r, matrix_s):
        return np.concatenate([by_r @ matrix_r @ rotor, -by_s @ matrix_s @ stator])

    (start, end), (_, duration) = system.schedule_speed, system.schedule_time
    return View(
        np.concatenate([system.contact_r @ rotor, -system.contact_s @ stator]),
        row(system.stiffness_r, system.stiffness_s),
        row(system.damping_r, system.damping_s),
        row(system.gyroscopic_r, 0.0 * system.mass_s),
        complex(by_r @ system.unbalance),
        complex(by_r @ system.unbalance_euler),
        complex(by_r @ system.load),
        float(by_r @ system.contact_r + by_s @ system.contact_s),
        float(start),
        float((end - start) / duration),
        float(system.gap),
        float(system.friction),
        float(system.contact_stiffness),
        float(system.contact_damping),
    )


@numba.njit(error_model="numpy")
def _free(view, x, v, t):
    """(d, d', d'' without contact)."""
    phi, omega = view.speed * t + 0.5 * view.speed_rate * t * t, view.speed + view.speed_rate * t
    d, rate, a = 0j, 0j, view.load + (omega * omega * view.unbalance - 1j * view.speed_rate * view.euler) * np.exp(1j * phi)
    for i in range(view.deflection.size):
        z, w = complex(x[2 * i], x[2 * i + 1]), complex(v[2 * i], v[2 * i + 1])
        d += view.deflection[i] * z
        rate += view.deflection[i] * w
        a -= view.stiffness[i] * z + (view.damping[i] - 1j * omega * view.gyroscopic[i]) * w
    return d, rate, a


@numba.njit(error_model="numpy")
def _pressed(view, mode, d, rate):
    """Acceleration of d by the contact in a mode."""
    if mode in (OPEN, CLIPPED):
        return 0j
    distance = abs(d)
    force = view.k_c * (distance - view.gap)
    if mode == OPENING:
        force += view.b_c * (rate * d.conjugate()).real / distance
    return -view.mobility * force * (1.0 + 1j * view.friction) * d / distance


@numba.njit(error_model="numpy")
def _look_inside(view, start, end, h, places):
    """Penetrations in places inside a step of length h and at its end; start, end = (d, d', d'')."""
    (d0, v0, a0), (d1, v1, a1) = start, end
    c1, c2 = h * v0, 0.5 * h * h * a0
    rise, slope, bend = d1 - d0 - c1 - c2, h * v1 - c1 - 2.0 * c2, h * h * a1 - 2.0 * c2
    c3 = 10.0 * rise - 4.0 * slope + 0.5 * bend
    c4 = -15.0 * rise + 7.0 * slope - bend
    c5 = 6.0 * rise - 3.0 * slope + 0.5 * bend
    for k in range(places.size):
        u = (k + 1.0) / places.size
        d = d0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
        places[k] = abs(d) - view.gap


@numba.njit(error_model="numpy")
def _passed_over(places):
    """Depth of the deepest stretch of places beyond the gap that ends before the step does, m; 0 for none."""
    deepest, depth = 0.0, 0.0
    for p in places:
        if p > 0.0:
            depth = max(depth, p)
        else:
            deepest, depth = max(deepest, depth), 0.0
    return deepest


@numba.njit(error_model="numpy")
def _goes_back_in(places):
    """How far d goes back in after its least penetration in a step, m, where it is beyond the gap; 0 for not at all."""
    least, back = np.inf, 0.0
    for p in places:
        least = min(least, p)
        if p > 0.0:
            back = max(back, p - max(least, 0.0))
    return back


@numba.njit(error_model="numpy")
def _tolerance(view, x, rtol):
    """How far one step may err in d, m."""
    total = 0.0
    for i in range(view.deflection.size):
        total += abs(view.deflection[i]) * math.sqrt(view.gap**2 + x[2 * i] ** 2 + x[2 * i + 1] ** 2)
    return rtol * total


@numba.njit(error_model="numpy")
def _judge(count, found, modes, places, allowed):
    """Book one step; found = (deepest pass over a contact or a gap, latest switch) in tolerances so far, modes = (in the step,
    after it)."""
    over, late = found
    mode, mode_after = modes
    if mode == CLIPPED:
        passed = _goes_back_in(places)
        count[MISSED] += passed > allowed
        return max(over, passed / allowed), late
    sign = 1.0 if mode == OPEN else -1.0
    passed, beyond = _passed_over(sign * places), max(0.0, sign * places[-1])
    if (mode == OPEN) == (mode_after == OPEN):
        passed = max(passed, beyond)  # beyond at the end, and no switch follows
    elif mode_after == CLIPPED:
        passed = max(passed, places.max())  # came and turned back without having been pressed
    else:
        late = max(late, beyond / allowed)
    count[OPEN_STEPS] += mode == OPEN
    count[GRAZES] += 0.0 < passed <= allowed
    count[MISSED if mode == OPEN else FALSE] += passed > allowed
    return max(over, passed / allowed), late


@numba.njit(error_model="numpy")
def audit(view, model, work, out, lanes, stages, count, most):
    """Walk a run to its end or to its contact number `most`, booking into count; returns (deepest pass over a contact or a
    gap, latest switch) in tolerances."""
    real, places, found = work.real, np.empty(PLACES), (0.0, 0.0)
    t, depth, quiet = 0.0, 0.0, 0
    d, rate, free = _free(view, work.x, work.v, t)
    contacts = count[CONTACTS]
    while count[CONTACTS] - contacts < most and quiet < QUIET_STEPS:
        steps, mode, hi, lo = work.count[kernel.STEPS], work.count[kernel.NORMAL], real[kernel.T_HI], real[kernel.T_LO]
        code, _ = march(model, work, out, lanes, stages, 1)
        if work.count[kernel.STEPS] == steps:
            if code in (kernel.RUNNING, kernel.BUFFER_FULL):
                continue  # the attempt was too long
            count[UNFINISHED] += 1
            break
        h = (real[kernel.T_HI] - hi) + (real[kernel.T_LO] - lo)
        t = real[kernel.T_HI] + real[kernel.T_LO]
        d_new, rate_new, free_new = _free(view, work.x, work.v, t)
        begin = d, rate, free + _pressed(view, mode, d, rate)
        _look_inside(view, begin, (d_new, rate_new, free_new + _pressed(view, mode, d_new, rate_new)), h, places)
        mode_after = work.count[kernel.NORMAL]
        found = _judge(count, found, (mode, mode_after), places, _tolerance(view, work.x, model.rtol))
        count[STEPS] += 1
        quiet = quiet + 1 if (mode == OPEN) == (mode_after == OPEN) else 0
        if mode != OPEN:
            depth = max(depth, places.max())
        if mode == OPEN and mode_after != OPEN:
            count[CONTACTS] += 1
            depth = places[-1]
        if mode != OPEN and mode_after == OPEN:
            count[SHALLOW] += depth < 1e-3 * view.gap
            count[VERY_SHALLOW] += depth < 1e-5 * view.gap
        d, rate, free = d_new, rate_new, free_new
        if code not in (kernel.RUNNING, kernel.BUFFER_FULL):
            count[UNFINISHED] += code != kernel.FINISHED
            break
    return found


def scenes(seed=SEED):
    """Variants of the bouncing rotor without end: in turn along a ramp of the speed from rest and grazing at a constant speed."""
    base, rng = load_scene(ROOT / "data" / "reference" / "bouncing.toml"), np.random.default_rng(seed)
    while True:
        ratio, speed = rng.uniform(0.005, 0.05), rng.uniform(15.0, 100.0, 2)
        values = {
            "rotor.damping_ratio": ratio,
            "stator.mass": 10.0 ** rng.uniform(-1.3, 0.3),
            "stator.frequency": rng.uniform(40.0, 200.0),
            "contact.friction": rng.uniform(0.0, 0.15),
            "contact.stiffness": 10.0 ** rng.uniform(6.0, 8.0),
            "contact.damping_ratio": rng.uniform(0.0, 0.2),
            "drive.duration": 20.0,
        }
        ramp = {"rotor.gravity": rng.uniform(0.0, 20.0), "rotor.eccentricity": 10.0 ** rng.uniform(-4.0, -3.0)}
        yield base.with_values(values | ramp | {"drive.speed": speed.tolist()})
        yield base.with_values(values | _grazing(base, ratio, speed[0], rng.uniform(0.1, 0.6), 10.0 ** rng.uniform(-9.0, -2.0)))


def _grazing(base, ratio, speed, share, depth):
    """Values of a start on the elliptic orbit, lowered by a share of the gap, that goes beyond the gap by a depth in gaps."""
    omega, Omega, gap = 2.0 * np.pi * base.rotor.frequency, 2.0 * np.pi * speed, base.contact.gap
    gain = Omega**2 / (omega**2 - Omega**2 + 2j * ratio * omega * Omega)
    radius = gap * (1.0 + depth - share)
    begin, rate = radius * gain / abs(gain) - 1j * share * gap, 1j * Omega * radius * gain / abs(gain)
    return {
        "rotor.gravity": share * gap * omega**2,
        "rotor.eccentricity": radius / abs(gain),
        "drive.speed": [speed, speed],
        "start.rotor": [[begin.real, begin.imag]],
        "start.rotor_velocity": [[rate.real, rate.imag]],
        "start.allow_penetration": True,
    }


def audited(method, rtol, contacts):
    """(counts, deepest pass over a contact or a gap, latest switch) of so many contacts, the last two in tolerances."""
    count, over, late = np.zeros(len(COUNTS), dtype=np.int64), 0.0, 0.0
    for scene in scenes():
        solver = dataclasses.replace(scene.solver, rtol=rtol, method=method, max_steps=10**9)
        system = assemble(scene)
        packed = pack(system, solver, SAMPLE_RATE)
        work = _new_work(packed, initial_state(scene, system))
        out = np.zeros((64, work.x.size + 3))
        view, most = view_of(system, packed), min(contacts - count[CONTACTS], CONTACTS_A_RUN)
        before = count[CONTACTS]
        march(packed.model, work, out, packed.width, packed.method, 0)  # the mode is told from the state
        found = audit(view, packed.model, work, out, packed.width, packed.method, count, most)
        assert work.count[kernel.ONSETS] == count[CONTACTS] - before
        over, late = max(over, found[0]), max(late, found[1])
        count[RUNS] += 1
        if count[CONTACTS] >= contacts:
            return count, over, late


def table(rows):
    """Markdown of (method, rtol, counts, deepest pass over, latest switch, seconds)."""
    lines = [
        "| method | rtol | contacts | below 1e-3, 1e-5 gaps | steps | places | missed | false | grazes | deepest | latest | s |",
        "|---|" + 11 * "---|",
    ]
    total = (sum(row[2] for row in rows), *np.max([row[3:5] for row in rows], axis=0), sum(row[5] for row in rows))
    for method, rtol, c, over, late, seconds in [*rows, ("all", None, *total)]:
        cells = [method, "" if rtol is None else f"{rtol:.0e}", f"{c[CONTACTS]:,}", f"{c[SHALLOW]:,}, {c[VERY_SHALLOW]:,}"]
        cells += [f"{c[STEPS]:,}", f"{PLACES * c[STEPS]:,}", f"{c[MISSED]}", f"{c[FALSE]}", f"{c[GRAZES]:,}"]
        lines.append("| " + " | ".join([*cells, f"{over:.2g}", f"{late:.2g}", f"{seconds:.0f}"]) + " |")
    return "\n".join(lines)


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--contacts", type=int, default=1_000_000, help="of all methods and tolerances together")
    parser.add_argument("--write", action="store_true", help="keep the table in bench/results")
    options = parser.parse_args()
    pairs = [(method, rtol) for method, tolerances in TOLERANCES.items() for rtol in tolerances]
    rows = []
    for method, rtol in pairs:
        begun = time.process_time()
        found = audited(method, rtol, -(-options.contacts // len(pairs)))
        rows.append((method, rtol, *found, time.process_time() - begun))
    print(table(rows))
    if options.write:
        write_page(RESULTS / "audit.md", "Contacts missed", "python bench/audit.py --write", table(rows))
    return 1 if any(row[2][[MISSED, FALSE]].any() for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
