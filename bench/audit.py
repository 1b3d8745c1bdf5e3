"""No switch is missed: every accepted step of many contacts looked at in 64 places, by equations that are not the kernel's.

    python bench/audit.py [--contacts 24000] [--write]

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

A switch of the damper, the clipped force or the friction is judged by what it leaves: in every place the force of the state the
kernel believed is compared with that of the law. Where they differ in a stretch that ends before the step does, or that no switch
follows, the velocity of d is wrong by the force's impulse times the mobility; that is *unmet* when it is more than one step may
err in d' at the tolerance, rtol sum |Phi_i| (scale_v_i + |v_i|^2)^(1/2), and more than the damper makes of what it may err in d.

Scenes, with a fixed seed: variants of data/reference/bouncing.toml, in turn along ramps of the speed, grazing at a constant one
(by 1e-9 to 1e-2 gaps at first), and with all that a scene can have (audit_scenes.py); the table says how many of the contacts
were shallow.
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

from audit_scenes import scenes
from rsc.kernel import model as kernel
from rsc.kernel.contact import CLIPPED, CLOSING, CREEPING, OPEN, OPENING
from rsc.kernel.march import march
from rsc.simulation.pack import pack
from rsc.simulation.run import new_work
from rsc.simulation.stretches import room_for
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from pages import RESULTS, write_page  # noqa: E402

PLACES = 64
TOLERANCES = {"rk45": (1e-4, 1e-5, 1e-6, 1e-8), "taylor8": (1e-4, 1e-6, 1e-8, 1e-10)}
SAMPLE_RATE = 50.0  # Hz; the samples are not looked at
CONTACTS_A_RUN = 200
QUIET_STEPS = 20_000  # a run that neither touches nor parts for so many steps has nothing more to show

COUNTS = ("contacts", "shallow", "very_shallow", "steps", "open_steps", "grazes", "missed", "false", "unmet", "runs")
COUNTS += ("unfinished",)
CONTACTS, SHALLOW, VERY_SHALLOW, STEPS, OPEN_STEPS, GRAZES, MISSED, FALSE, UNMET, RUNS, UNFINISHED = range(len(COUNTS))


class View(NamedTuple):
    """d and its acceleration from the kernel's complex coordinates x: rows made of the System's matrices."""

    deflection: np.ndarray  # (n,) d = row x + ring e^(i phi)
    stiffness: np.ndarray  # (2, n) d'' = -rows (x, conj x) ...
    damping: np.ndarray  # (2, n) ... - rows (x', conj x') + i Omega gyroscopic row x' ...
    gyroscopic: np.ndarray  # (n,)
    unbalance: complex  # ... + (Omega^2 unbalance - i Omega' euler) e^(i phi) + load - mobility F_C
    euler: complex
    load: complex
    ring: complex  # m
    mobility: float  # 1/kg
    time: np.ndarray  # (k,) s, corners of the schedule
    speed: np.ndarray  # (k,) rad/s there
    phase: np.ndarray  # (k,) rad there
    gap: float
    friction: float
    radius: float  # m, 0 for friction of one side
    slip_velocity: float
    k_c: float
    b_c: float


def view_of(system, packed):
    """`View` of a scene."""
    rotor, stator = packed.rotor.shape, packed.stator.shape
    by_r, by_s = (np.linalg.solve(body.mass, body.contact) for body in system.bodies)
    law = system.law

    def row(matrix_r, matrix_s):
        return np.concatenate([by_r @ matrix_r @ rotor, -by_s @ matrix_s @ stator]).astype(complex)

    def rows(kind):
        parts = []
        for body in system.bodies:
            plain = getattr(body, kind)
            none = np.zeros_like(plain)
            skew, unequal = (getattr(body, f"{name}_{kind}") for name in ("skew", "anisotropic"))
            parts.append((plain + 1j * (none if skew is None else skew), none if unequal is None else unequal))
        return np.stack([row(parts[0][i], parts[1][i]) for i in range(2)])

    time, speed = np.array(system.schedule_time), np.array(system.schedule_speed)
    phase = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    diameter, slip_velocity = (1.0 if value is None else float(value) for value in (law.diameter, law.slip_velocity))
    return View(
        np.concatenate([system.rotor.contact @ rotor, -system.stator.contact @ stator]),
        rows("stiffness"),
        rows("damping"),
        row(system.rotor.gyroscopic, 0.0 * system.stator.mass),
        complex(by_r @ system.rotor.unbalance),
        complex(by_r @ system.rotor.unbalance_euler),
        complex(by_r @ system.rotor.load),
        complex(system.contact.ring),
        float(by_r @ system.rotor.contact + by_s @ system.stator.contact),
        time,
        speed,
        phase,
        float(system.contact.gap),
        float(system.law.friction),
        0.0 if system.law.diameter is None else 0.5 * diameter,
        slip_velocity,
        float(system.law.stiffness),
        float(system.law.damping),
    )


@numba.njit(error_model="numpy")
def _speeds(view, t, inside):
    """(phi, Omega, Omega') at a time t of the piece of the schedule in which the time `inside` lies."""
    i = min(max(np.searchsorted(view.time, inside) - 1, 0), view.time.size - 2)
    rise = (view.speed[i + 1] - view.speed[i]) / (view.time[i + 1] - view.time[i])
    tau = t - view.time[i]
    return view.phase[i] + (view.speed[i] + 0.5 * rise * tau) * tau, view.speed[i] + rise * tau, rise


@numba.njit(error_model="numpy")
def _free(view, x, v, speeds):
    """(d, d', d'' without contact); speeds = (phi, Omega, Omega')."""
    (_, omega, rise), turn = speeds, np.exp(1j * speeds[0])
    d, rate = view.ring * turn, 1j * omega * view.ring * turn
    a = view.load + ((view.unbalance - view.ring) * omega * omega + 1j * rise * (view.ring - view.euler)) * turn
    for i in range(view.deflection.size):
        z, w = complex(x[2 * i], x[2 * i + 1]), complex(v[2 * i], v[2 * i + 1])
        d += view.deflection[i] * z
        rate += view.deflection[i] * w
        a -= view.stiffness[0, i] * z + view.stiffness[1, i] * z.conjugate()
        a -= (view.damping[0, i] - 1j * omega * view.gyroscopic[i]) * w + view.damping[1, i] * w.conjugate()
    return d, rate, a


@numba.njit(error_model="numpy")
def _force(view, modes, d, rate, omega):
    """The contact's force on d in modes (normal, friction), N."""
    normal, friction = modes
    if normal in (OPEN, CLIPPED):
        return 0j
    distance = abs(d)
    along = rate * d.conjugate() / distance
    force = view.k_c * (distance - view.gap)
    if normal == OPENING:
        force += view.b_c * along.real
    sigma = (omega * view.radius + along.imag) / view.slip_velocity if friction == CREEPING else float(friction)
    return force * (1.0 + 1j * view.friction * sigma) * d / distance


@numba.njit(error_model="numpy")
def _modes(view, d, rate, omega):
    """Modes (normal, friction) of the law."""
    distance = max(abs(d), 1e-300)
    along = rate * d.conjugate() / distance
    p, slip, friction, normal = distance - view.gap, omega * view.radius + along.imag, 1, CLOSING
    if view.radius > 0.0 and slip < view.slip_velocity:
        friction = CREEPING if slip > -view.slip_velocity else -1
    if p <= 0.0:
        normal = OPEN
    elif view.b_c > 0.0 and along.real < 0.0:
        normal = OPENING if view.k_c * p + view.b_c * along.real >= 0.0 else CLIPPED
    return normal, friction


@numba.njit(error_model="numpy")
def _look_inside(view, modes, start, end, omega, places):
    """Penetrations in places inside a step and at its end, and the largest impulse of a force that differs from the law's, N s,
    (in a stretch that ends before the step does, in the last); start, end = (d, d', d''); omega = ((Omega, Omega'), h)."""
    (d0, v0, a0), (d1, v1, a1), (speed, h) = start, end, omega
    c1, c2 = h * v0, 0.5 * h * h * a0
    rise, slope, bend = d1 - d0 - c1 - c2, h * v1 - c1 - 2.0 * c2, h * h * a1 - 2.0 * c2
    c3 = 10.0 * rise - 4.0 * slope + 0.5 * bend
    c4 = -15.0 * rise + 7.0 * slope - bend
    c5 = 6.0 * rise - 3.0 * slope + 0.5 * bend
    largest, impulse, begun = 0.0, 0j, False
    for k in range(places.size):
        u = (k + 1.0) / places.size
        d = d0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
        rate = (c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h
        places[k] = abs(d) - view.gap
        now = speed[0] + speed[1] * u * h
        law = _modes(view, d, rate, now)
        pressed = law[0] != OPEN and law[0] != CLIPPED
        if law[0] == modes[0] and (law[1] == modes[1] or not pressed):
            # a state begins just behind its switch: what is wrong in the first place is of the step before
            largest, impulse, begun = max(largest, abs(impulse)), 0j, True
        elif begun:
            impulse += (_force(view, modes, d, rate, now) - _force(view, law, d, rate, now)) * (h / places.size)
    return largest, abs(impulse)


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
def _tolerance(view, scale, x, rtol):
    """How far one step may err in d, m, or with the scale of the velocities in d', m/s."""
    total = 0.0
    for i in range(view.deflection.size):
        total += abs(view.deflection[i]) * math.sqrt(scale[2 * i] + x[2 * i] ** 2 + x[2 * i + 1] ** 2)
    return rtol * total


@numba.njit(error_model="numpy")
def _judge(count, found, modes, places, allowed):
    """Book one step; found = (deepest pass over a contact or a gap, latest switch) in tolerances so far, modes = (in the step,
    after it)."""
    over, late = found
    mode, mode_after = modes
    if mode == CLIPPED:
        passed = _goes_back_in(places)
        if mode_after in (CLOSING, OPENING):
            return over, max(late, passed / allowed)
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
def _believed(work):
    return work.count[kernel.NORMAL], work.count[kernel.FRICTION]


@numba.njit(error_model="numpy")
def _with_contact(view, modes, free, omega):
    """(d, d', d'') in modes from those without contact."""
    return free[0], free[1], free[2] - view.mobility * _force(view, modes, free[0], free[1], omega)


@numba.njit(error_model="numpy")
def audit(view, model, work, where, lanes, stages, count, most):
    """Walk a run to its end or to its contact number `most`, booking into count; returns (deepest pass over a contact or a
    gap, latest switch, largest impulse of a switch not met) in tolerances."""
    real, places, found = work.real, np.empty(PLACES), (0.0, 0.0, 0.0)
    t, depth, quiet = 0.0, 0.0, 0
    contacts = count[CONTACTS]
    while count[CONTACTS] - contacts < most and quiet < QUIET_STEPS:
        steps, modes, hi, lo = work.count[kernel.STEPS], _believed(work), real[kernel.T_HI], real[kernel.T_LO]
        x, v = work.x.copy(), work.v.copy()
        code, _ = march(model, work, where[0], where[1], lanes, stages, 1)
        if work.count[kernel.STEPS] == steps:
            if code in (kernel.RUNNING, kernel.BUFFER_FULL):
                continue  # the attempt was too long
            count[UNFINISHED] += 1
            break
        h, begun = (real[kernel.T_HI] - hi) + (real[kernel.T_LO] - lo), t
        t = real[kernel.T_HI] + real[kernel.T_LO]
        speeds, ahead = _speeds(view, begun, begun + 0.5 * h), _speeds(view, t, begun + 0.5 * h)
        ends = _with_contact(view, modes, _free(view, x, v, speeds), speeds[1]), _with_contact(
            view, modes, _free(view, work.x, work.v, ahead), ahead[1]
        )
        inside, last = _look_inside(view, modes, ends[0], ends[1], ((speeds[1], speeds[2]), h), places)
        after = _believed(work)
        mode, mode_after = modes[0], after[0]
        over, late = _judge(count, found[:2], (mode, mode_after), places, _tolerance(view, model.scale_x, work.x, model.rtol))
        wrong = view.mobility * (max(inside, last) if after == modes else inside)
        allowed = _tolerance(view, model.scale_v, work.v, model.rtol)
        wrong /= allowed + view.mobility * view.b_c * _tolerance(view, model.scale_x, work.x, model.rtol)
        count[UNMET] += wrong > 1.0
        found = over, late, max(found[2], wrong)
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
        if code not in (kernel.RUNNING, kernel.BUFFER_FULL):
            count[UNFINISHED] += code != kernel.FINISHED
            break
    return found


def audited(method, rtol, contacts):
    """(counts, deepest pass over a contact or a gap, latest switch, largest impulse not met) of so many contacts, the last three
    in tolerances."""
    count, worst = np.zeros(len(COUNTS), dtype=np.int64), (0.0, 0.0, 0.0)
    for scene in scenes():
        solver = dataclasses.replace(scene.solver, rtol=rtol, method=method, max_steps=10**9)
        system = assemble(scene)
        packed = pack(system, solver, SAMPLE_RATE)
        work = new_work(packed, initial_state(scene, system))
        where = np.zeros((64, work.x.size + 3)), room_for(packed.model)
        view, most = view_of(system, packed), min(contacts - count[CONTACTS], CONTACTS_A_RUN)
        before = count[CONTACTS]
        march(packed.model, work, *where, packed.width, packed.method, 0)  # the mode is told from the state
        found = audit(view, packed.model, work, where, packed.width, packed.method, count, most)
        assert work.count[kernel.ONSETS] == count[CONTACTS] - before
        worst = tuple(np.maximum(worst, found))
        count[RUNS] += 1
        if count[CONTACTS] >= contacts:
            return count, *worst


def table(rows):
    """Markdown of (method, rtol, counts, deepest pass over, latest switch, largest impulse not met, seconds)."""
    lines = [
        "| method | rtol | contacts | below 1e-3, 1e-5 gaps | steps | places | missed | false | unmet | grazes "
        "| deepest | latest | unmet at most | s |",
        "|---|" + 13 * "---|",
    ]
    total = (sum(row[2] for row in rows), *np.max([row[3:6] for row in rows], axis=0), sum(row[6] for row in rows))
    for method, rtol, c, over, late, wrong, seconds in [*rows, ("all", None, *total)]:
        cells = [method, "" if rtol is None else f"{rtol:.0e}", f"{c[CONTACTS]:,}", f"{c[SHALLOW]:,}, {c[VERY_SHALLOW]:,}"]
        cells += [f"{c[STEPS]:,}", f"{PLACES * c[STEPS]:,}", f"{c[MISSED]}", f"{c[FALSE]}", f"{c[UNMET]}", f"{c[GRAZES]:,}"]
        lines.append("| " + " | ".join([*cells, f"{over:.2g}", f"{late:.2g}", f"{wrong:.2g}", f"{seconds:.0f}"]) + " |")
    return "\n".join(lines)


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--contacts", type=int, default=24_000, help="of all methods and tolerances together")
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
        command = f"python bench/audit.py --contacts {options.contacts} --write"
        write_page(RESULTS / "audit.md", "Contacts missed", command, table(rows))
    return 1 if any(row[2][[MISSED, FALSE, UNMET]].any() for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
