"""What is said of motions under a torque-limited drive, judged: every sentence on random machines by another integration.

    python bench/drive_outcomes.py [COUNT] [--seed 1] [--first 0] [--write]     default 50

Each machine is one of several rotors in a rigid or an elastic stator, with a motor whose torque falls over the speed or that has
tripped. Every motion that `rsc.motions` lists is released by the third engine (third_engine.py) from the state in which its run
stood, for longer than the sentence needs. Asked: what it ends in, the final speed within 0.5 %, the time of a stop within 2 %,
contact and sense of turning at the end, and that a motion which is left is there until then. A release on which runs of the third
engine with two lengths of steps, or from beside the start, disagree is skipped and counted. --write: results/drive_outcomes.md.
Exit code 1 if a sentence is false.
"""

import argparse
import collections
import random
import sys
import time
from pathlib import Path

import numpy as np

sys.path += [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1] / "tools")]

import rsc
from pages import RESULTS, write_page
from rsc.measure.kinds import BACKWARD, Kind
from rsc.show.words.held import outcome_text
from rsc.study.motions.release import with_held
from rsc.study.motions.search import Search
from rsc.study.motions.settle import shown
from rsc.system.assemble import assemble
from rsc.system.held import BRAKES, CAPTURED, HOLDS, SPEEDS_UP, STOPS, UNKNOWN
from third_engine import GAP, TooStiff, machine_of, release, step_of

SPEED, STOP, IMPACTS = 0.005, 0.02, 6
MOST_STEPS = 400_000  # of the third engine, some 20 s
LONGER, FINER = 1.6, 1.6  # times the time that a sentence tells, and steps so many times shorter


def machine(seed, number):
    """A random scene with a torque-limited drive."""
    dice = random.Random(f"{seed}/{number}")

    def log(low, high):
        return float(np.exp(dice.uniform(np.log(low), np.log(high))))

    mass, frequency, gap = log(1.0, 20.0), log(12.0, 50.0), log(1e-4, 5e-4)
    stiffness = mass * (2.0 * np.pi * frequency) ** 2
    rotor = {"model": "laval", "mass": mass, "frequency": frequency, "damping_ratio": log(0.01, 0.08)}
    if dice.random() < 0.3:
        rotor = {
            "model": "chain", "masses": [mass, mass * dice.uniform(0.5, 2.0)], "damping_ratio": rotor["damping_ratio"],
            "stiffnesses": [stiffness * dice.uniform(0.5, 2.0) for _ in range(3)],
        }  # fmt: skip
    ecc = gap * log(0.01, 0.3)
    rotor["eccentricity"] = ecc if rotor["model"] == "laval" else [ecc, 0.0]
    if dice.random() < 0.25:
        support = stiffness * log(0.05, 0.3)
        rotor["supports"] = [[0, [support, 0.0, 0.0, 0.6 * support], [0.0, 0.0, 0.0, 0.0]]]
    stator = {"model": "rigid"}
    if dice.random() < 0.6:
        stator = {"model": "laval", "mass": mass * log(0.2, 2.0), "frequency": frequency * log(2.0, 6.0), "damping_ratio": 0.05}
    speed = frequency * log(0.5, 2.5)
    diameter = log(0.02, 0.1)
    contact = {
        "gap": gap, "friction": log(0.03, 0.4), "stiffness": stiffness * log(20.0, 200.0), "damping_ratio": 0.1,
        "diameter": diameter, "slip_velocity": np.pi * speed * diameter * log(0.01, 0.1),
    }  # fmt: skip
    inertia = mass * (0.5 * diameter) ** 2 * log(0.5, 20.0)
    strong = inertia * 2.0 * np.pi * speed / log(0.3, 3.0)  # N m: it would stop the rotor in such a time
    kind = dice.choice(("motor", "motor", "weak", "coast", "constant"))
    torque = {
        "motor": [[0.0, strong], [speed, 0.2 * strong], [1.2 * speed, -0.3 * strong]],
        "weak": [[0.0, 0.05 * strong], [1.3 * speed, 0.0], [2.0 * speed, -0.3 * strong]],
        "coast": [[0.0, -0.05 * strong], [speed, -0.3 * strong]],
        "constant": [[0.0, 0.1 * strong], [2.0 * speed, 0.1 * strong], [2.1 * speed, -0.1 * strong]],
    }[kind]
    drive = {"speed": speed, "duration": 2.0, "inertia": inertia, "torque": torque}
    tables = {"title": f"drive {seed}/{number}: {kind}", "rotor": rotor, "stator": stator, "contact": contact, "drive": drive}
    return rsc.Scene.from_dict(tables)


def judged(scene, speed, starts=IMPACTS, seed=0):
    """(outcome, sentence, what is false of it or "", whether it was skipped) of every released motion of a scene."""
    search = Search(scene.steady(speed), speed)
    yield from judged_held(scene, search, with_held(search, search.motions(starts, seed), scene))


def judged_held(scene, search, listed):
    """The same of a list that a search has made; scene: with its torque."""
    system = assemble(scene)
    for group, motion in zip(search.groups, listed.motions, strict=True):
        end = shown(group)
        for one in motion.held:
            table = scene.drive.coast if one.coasting else scene.drive.torque
            sentence = f"{motion.motion}: {outcome_text(one)}"
            try:
                false = list(_false(system, end, motion, one, table))
                skipped = bool(false) and not _agrees(system, end, one, table)
            except TooStiff:
                false, skipped = ["too stiff for the third engine"], True
            yield one.outcome, sentence, "; ".join(false), skipped


def _length(system, one):
    """Length in s of a run that a sentence is judged by, and whether that is long enough."""
    wanted = LONGER * one.time + 20.0 / one.begin if one.outcome != UNKNOWN else one.time
    most = MOST_STEPS * step_of(machine_of(system), one.begin)
    return min(wanted, most), wanted <= most


def _false(system, end, motion, one, table):
    """What is false of a sentence."""
    length, enough = _length(system, one)
    path = release(system, end.state, end.turns, one.begin, table, length)
    last = path.time[-1]
    if one.outcome == STOPS:
        if path.speed[-1] > 0.0:
            if enough:
                yield f"at {path.speed[-1]:.4g} Hz after {last:.3g} s"
        elif abs(last - one.time) > STOP * one.time + 1.0 / one.begin:
            yield f"stops after {last:.4g} s"
        return
    if path.speed[-1] <= 0.0:
        yield f"stops after {last:.4g} s"
        return
    if not enough:
        return
    speed = path.mean(0.9 * last, last) if one.outcome != UNKNOWN else path.mean(last - 2.0 / one.begin, last)
    if abs(speed - one.speed) > SPEED * one.speed:
        yield f"at {speed:.5g} Hz after {last:.3g} s"
    if {HOLDS: abs(speed - one.begin) > 2.0 * SPEED * one.begin, SPEEDS_UP: speed < one.begin, CAPTURED: speed < one.begin,
        BRAKES: speed > one.begin}.get(one.outcome, False):  # fmt: skip
        yield f"{one.outcome} from {one.begin:.5g} Hz to {speed:.5g} Hz"
    kinds = _kinds(path, 0.85 * last, last)
    if one.motion not in kinds:
        yield f"ends in {' or '.join(sorted(kinds))}"
    before = 0.3 * one.left_time, 0.8 * one.left_time
    if one.left_time > 0.1 * last and motion.motion not in _kinds(path, *before):
        yield f"has left it before {one.left_time:.3g} s"


def _kinds(path, begin, end):
    """What a part of a run may be called: by its share of contact and the turns of the deflection beside the shaft's, at any of
    the contacts that touch."""
    own = slice(int(np.searchsorted(path.time, begin)), int(np.searchsorted(path.time, end)) + 1)
    shaft, kinds = path.turns[own][-1] - path.turns[own][0], set()
    for d, gap in zip(path.d[own].T, path.machine.surfaces[:, GAP], strict=True):
        share = float((abs(d) > gap).mean())
        if share == 0.0:
            continue
        turned = np.unwrap(np.angle(d))
        kinds |= _kinds_at(share, float(turned[-1] - turned[0]) / (2.0 * np.pi), shaft)
    return kinds or {str(Kind.NO_CONTACT)}


def _kinds_at(share, turned, shaft):
    """The same of a contact: its share of the time in contact, turns of its deflection and of the shaft."""
    kinds = {str(Kind.NOT_RESOLVED)}
    if turned < 0.0:
        kinds |= {str(kind) for kind in BACKWARD}
    if share > 0.98 and abs(turned - shaft) < 1.0 + 0.02 * shaft:
        kinds |= {str(Kind.FORWARD_RUB)}
    if share > 0.98 and abs(turned) < 3.0:
        kinds |= {str(Kind.RESTING)}
    if share > 0.45 and turned > 0.0:
        kinds |= {str(Kind.FORWARD_WHIRL)}
    return kinds | ({str(Kind.PARTIAL_RUB)} if share < 0.995 or abs(turned) < 3.0 else set())


def _agrees(system, end, one, table):
    """Whether runs of the third engine end alike: with two lengths of steps, and from beside the start."""
    length, _ = _length(system, one)
    ways = (1.0, 0), (FINER, 0), (1.0, 1), (1.0, 2)
    paths = [release(system, end.state, end.turns, one.begin, table, length, *way) for way in ways]
    ends = [path.mean(0.9 * path.time[-1], path.time[-1]) for path in paths]
    return max(ends) - min(ends) <= SPEED * max(ends) and float(np.ptp([path.time[-1] for path in paths])) < STOP * length


def table_of(machines, cases):
    """Lines of Markdown on (outcome, sentence, what is false, whether it was skipped) of some machines."""
    wrong, skips = (sum(bool(false) and skipped == own for *_, false, skipped in cases) for own in (False, True))
    lines = [f"{machines} machines, {len(cases)} sentences: {wrong} false, {skips} skipped.", ""]
    lines += ["| outcome | sentences | false | skipped |", "|---|---|---|---|"]
    for outcome, n in collections.Counter(case[0] for case in cases).most_common():
        own = [(bool(false), skipped) for name, _, false, skipped in cases if name == outcome]
        lines.append(f"| {outcome} | {n} | {own.count((True, False))} | {own.count((True, True))} |")
    return lines


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--write", action="store_true", help="write the table to bench/results")
    options = parser.parse_args()
    cases = []
    for number in range(options.first, options.first + options.count):
        begun, scene = time.process_time(), machine(options.seed, number)
        for case in judged(scene, scene.drive.speed[0]):
            cases.append(case)
            _, sentence, false, skipped = case
            print(f"{number} {sentence}" + (f"\n    {'skipped' if skipped else 'FALSE'}: {false}" if false else ""), flush=True)
        print(f"{number} {scene.title}: {time.process_time() - begun:.1f} s", flush=True)
    text = "\n".join(table_of(options.count, cases))
    print(text)
    if options.write:
        command = f"python bench/drive_outcomes.py {options.count} --seed {options.seed} --first {options.first} --write"
        title = "What is said of motions under a drive, judged by a third engine"
        write_page(RESULTS / "drive_outcomes.md", title, command, text)
    return 1 if any(false and not skipped for *_, false, skipped in cases) else 0


if __name__ == "__main__":
    sys.exit(main())
