"""Is the coverage that a list of motions claims true? Lists of small machines beside the motions that many more impacts know.

    python bench/lists_coverage.py [COUNT] [--seed 1] [--first 0] [--known 256] [--write]     default 100

Each machine is a Laval rotor in a rigid or an elastic stator, with a contact diameter or without. Its motions are known from
`--known` random impacts of another seed than those of the lists that are judged: one of 64 impacts, as `rsc.motions` makes it,
and one of 16, as `rsc.check` does. A list claims with 95 % confidence that any one motion which it lacks is started by fewer than
`excluded` of all impacts. Counted are the machines on which every known motion with at least that share is listed, and the known
motions with at least that share that are listed; once as the lists are, which begin on predictions too, and once of impacts
alone. Rare are those with at most three times that share: only they put a claim to the test. --write:
results/lists_coverage.md, anew after every ten machines. Exit code 1 if a claim holds on fewer than 95 % of the machines.
"""

import argparse
import collections
import sys
import time
from pathlib import Path

import numpy as np

sys.path += [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1] / "tools")]

import rsc
from pages import RESULTS, write_page
from rsc.measure.catalogue import CONFIDENCE
from rsc.study.motions.motions import STARTS
from rsc.study.motions.search import Search
from rsc.study.motions.settle import same
from rsc.study.sweep.compute import STARTS as OF_CHECK

KNOWN, KNOWN_SEED, EVERY, RARE = 256, 1000, 10, 3.0
WAYS = ("as listed", "impacts alone")


def machine(seed, number):
    """A random Laval rotor at one speed."""
    dice = np.random.default_rng([seed, number])

    def log(low, high):
        return float(np.exp(dice.uniform(np.log(low), np.log(high))))

    mass, frequency, gap = log(1.0, 20.0), log(12.0, 50.0), log(1e-4, 5e-4)
    stiffness = mass * (2.0 * np.pi * frequency) ** 2
    rotor = {"model": "laval", "mass": mass, "frequency": frequency, "damping_ratio": log(0.03, 0.1)}
    stator = {"model": "rigid"}
    if dice.random() < 0.8:
        own = {"mass": mass * log(0.05, 1.0), "frequency": frequency * log(1.0, 6.0), "damping_ratio": log(0.02, 0.2)}
        stator = {"model": "laval", **own}
    contact = {"gap": gap, "friction": log(0.05, 0.5), "stiffness": stiffness * log(5.0, 100.0), "damping_ratio": log(0.02, 0.3)}
    if dice.random() < 0.4:
        contact["diameter"] = log(0.004, 0.01)  # larger ones roll faster, at the cost of as many more steps
    rotor["eccentricity"] = gap * log(0.02, 0.8)
    drive = {"speed": frequency * log(0.5, 2.5), "duration": 1.0}
    tables = {"title": f"coverage {seed}/{number}", "rotor": rotor, "stator": stator, "contact": contact, "drive": drive}
    return rsc.Scene.from_dict(tables)


def listed_of(scene, starts, seed):
    """(list of motions, an End of each) of a scene at its speed."""
    search = Search(scene, scene.drive.speed[0], threads=1)
    listed = search.motions(starts, seed)
    return listed, [group[0] for group in search.groups]


def claims(known, listed, gaps):
    """way -> [(known motion that a claim is about, its share over the claimed one, whether it is there)] of two (list, Ends)."""
    (motions, ends), (own, own_ends) = known, listed
    about = [(motion, end) for motion, end in zip(motions.motions, ends, strict=True) if motion.share >= own.excluded]
    told = {}
    for way in WAYS:
        there = [end for end, motion in zip(own_ends, own.motions, strict=True) if way == WAYS[0] or own.hits(motion)]
        told[way] = [(motion, motion.share / own.excluded, any(same(one, end, gaps) for one in there)) for motion, end in about]
    return told


class Table:
    """How often the claims of lists hold: of (impacts of the list, way)."""

    def __init__(self):
        self.machines, self.several, self.kinds = 0, 0, collections.Counter()
        self.held, self.claimed, self.found, self.rare, self.unsettled = (collections.Counter() for _ in range(5))

    def add(self, scene, known, seed):
        """Judge the lists of a machine; yields what they lack."""
        gaps = [contact.gap for contact in scene.contacts]
        self.machines += 1
        self.several += sum(known[0].hits(motion) > 0 for motion in known[0].motions) > 1
        self.kinds.update(str(motion.motion) for motion in known[0].motions)
        for starts in (STARTS, OF_CHECK):
            listed = listed_of(scene, starts, seed)
            self.unsettled[starts] += listed[0].unsettled
            for way, about in claims(known, listed, gaps).items():
                absent = [f"{motion.motion} {motion.share:.1%}" for motion, _, there in about if not there]
                self.claimed[starts, way] += len(about)
                self.found[starts, way] += len(about) - len(absent)
                self.rare[starts, way] += sum(ratio < RARE for _, ratio, _ in about)
                self.held[starts, way] += not absent
                if absent:
                    yield f"{starts} impacts, {way}, below {listed[0].excluded:.1%}: not listed: {', '.join(absent)}"

    def share(self, starts, way=WAYS[0]):
        """Share of the machines on which a claim holds."""
        return self.held[starts, way] / max(self.machines, 1)

    def lines(self, known):
        """Lines of Markdown."""
        kinds = ", ".join(f"{n} {kind}" for kind, n in self.kinds.most_common())
        text = f"{self.machines} machines, {self.kinds.total()} motions known from {known} impacts each ({kinds}); "
        rows = [
            f"| {starts} | {way} | {self.share(starts, way):.0%} | {self.found[starts, way]} of {self.claimed[starts, way]} "
            f"| {self.rare[starts, way]} | {self.unsettled[starts] / (starts * max(self.machines, 1)):.2%} |"
            for starts in (STARTS, OF_CHECK) for way in WAYS
        ]  # fmt: skip
        titles = "| impacts | found | holds on machines | motions that it is about, and there | of these rare | unsettled |"
        return [text + f"impacts start more than one on {self.several} machines.", "", titles, "|---|---|---|---|---|---|", *rows]


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--known", type=int, default=KNOWN, help="impacts from which the motions of a machine are known")
    parser.add_argument("--write", action="store_true", help="write the table to bench/results")
    options = parser.parse_args()
    table = Table()
    for number in range(options.first, options.first + options.count):
        begun, scene = time.process_time(), machine(options.seed, number)
        known = listed_of(scene, options.known, KNOWN_SEED + number)
        told = list(table.add(scene, known, number))
        motions = ", ".join(f"{motion.motion} {motion.share:.1%}" for motion in known[0].motions)
        print(f"{number}: {motions}; {time.process_time() - begun:.1f} s", *told, sep="\n    ", flush=True)
        if options.write and (table.machines % EVERY == 0 or table.machines == options.count):
            command = f"python bench/lists_coverage.py {table.machines} --seed {options.seed} --first {options.first}"
            command, text = f"{command} --known {options.known} --write", "\n".join(table.lines(options.known))
            write_page(RESULTS / "lists_coverage.md", "Is the coverage that lists claim true?", command, text)
    print("\n".join(table.lines(options.known)))
    return 1 if min(table.share(STARTS), table.share(OF_CHECK)) < CONFIDENCE else 0


if __name__ == "__main__":
    sys.exit(main())
