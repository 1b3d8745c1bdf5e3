"""Does a whirl lose its stability towards another where its normal force falls below half of the other's?

    nice python bench/transition_criterion.py [SCENES]    default 300; writes results/transition_criterion.csv and .md
    python bench/transition_criterion.py --page           writes the .md alone, from the .csv

Random rotors with gyroscopics in light stators, of 2 to 4 coordinates and 1 or 2, are searched over rotor speed for pairs of
whirls that exist together, until SCENES of them have shown a crossing. A row of the .csv is

- a crossing: an eigenvalue at which whirl A begins (or ends) to grow a line next to whirl B, beside the speeds nearest to it on
  the pair where F_A = F_B/2 (`half_Hz`) and where F_A = least F_B with the mirror line to first order (`mirrored_Hz`);
- or a false alarm: a place where one of the two is fulfilled on a stable A and no eigenvalue crosses.

The page tells besides whether, at three random speeds of each of 1000 other random rotors, the ratio tells the stability of A.

The derivation stands in docs/maintainers/analysis.md, its numerics in src/rsc/analysis/lines/force_ratio.py.
"""

import argparse
import contextlib
import csv
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from rsc.analysis.lines.branches import branches
from rsc.analysis.lines.events import OSCILLATORY
from rsc.analysis.lines.force_ratio import PairLimit, pair_limit
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.small_motions import small_motion
from rsc.analysis.paper.whirls import normal_force, whirl_roots
from rsc.system.blas import one_thread

BENCH = Path(__file__).parent
sys.path[:0] = [str(BENCH.parent / "tests" / "support"), str(BENCH.parent / "tools")]

from pages import RESULTS, write_page  # noqa: E402
from systems import TWO_PI, random_rotor  # noqa: E402

TABLE = RESULTS / "transition_criterion.csv"
SPEEDS = np.linspace(5.0, 200.0, 79)  # Hz
TOWARDS = 0.05  # a growing line belongs to a whirl within this share of its frequency
CRITERIA = {"half": "F_A = F_B/2", "mirrored": "with the mirror line to first order (`least`)"}
COLUMNS = (
    "scene", "n_rotor", "n_stator", "a", "b", "crossing_Hz", "half_Hz", "mirrored_Hz", "Psi_A_Hz", "Psi_B_Hz",
    "ratio", "least", "mirror_share", "slope", "stable_above", "gains",
)  # fmt: skip
BINS = ((0.0, 0.03), (0.03, 0.1), (0.1, 0.3), (0.3, 1.0), (1.0, np.inf))


def force_at(system, speed, near):
    """(Psi rad/s, F_N) of the whirl next to a frequency; NaN where none is within 10 %."""
    roots = whirl_roots(system, TWO_PI * speed)
    force = normal_force(system, roots, TWO_PI * speed)
    roots, force = roots[(force > 0.0) & (roots < 0.0)], force[(force > 0.0) & (roots < 0.0)]
    if not len(roots):
        return np.nan, np.nan
    i = int(np.argmin(np.abs(roots - near)))
    return (roots[i], force[i]) if abs(roots[i] / near - 1.0) < 0.1 else (np.nan, np.nan)


class Pair:
    """Two branches A and B of a system over the rotor speeds at which both have a whirl."""

    def __init__(self, system, a, b):
        self.system, self.a, self.b = system, a, b
        self.speed, i, j = np.intersect1d(a.speed, b.speed, return_indices=True)
        together = [[branch.whirls[m] for m in places] for branch, places in ((a, i), (b, j))]
        Psi = TWO_PI * np.array([[w.frequency for w in whirls] for whirls in together])
        F_N = np.array([[w.normal_force for w in whirls] for whirls in together])
        self.ratio = F_N[0] / F_N[1]
        self._levels = self._level(Psi, F_N, TWO_PI * self.speed)

    def _level(self, Psi, F_N, Omega):
        """F_A/F_B over its limit, by criterion."""
        ratio = F_N[0] / F_N[1]
        return {"half": 2.0 * ratio, "mirrored": ratio / pair_limit(self.system, Psi, F_N, Omega).least}

    def at(self, speed):
        """(Psi, F_N, PairLimit) at a speed, each of Psi and F_N two arrays of one number."""
        near = [TWO_PI * branch.at(speed).frequency for branch in (self.a, self.b)]
        Psi, F_N = np.transpose([force_at(self.system, speed, psi) for psi in near])[:, :, None]
        return Psi, F_N, pair_limit(self.system, Psi, F_N, TWO_PI * speed)

    def met(self, criterion):
        """Speeds where F_A/F_B passes its limit."""
        excess = self._levels[criterion] - 1.0
        found = []
        for k in np.flatnonzero(excess[:-1] * excess[1:] < 0.0):

            def level(speed):
                Psi, F_N, _ = self.at(speed)
                return float(self._level(Psi, F_N, TWO_PI * speed)[criterion][0]) - 1.0

            low, high = self.speed[k : k + 2]
            # not a number where a whirl moves away from where it was looked for
            with np.errstate(invalid="ignore"), contextlib.suppress(ValueError):
                found.append(brentq(level, low, high, xtol=1e-4))
        return found

    def stable_above(self, speed, holds):
        """1 where A is stable on the side of the larger F_A/F_B, -1 on the other; `holds` as `Event.holds`."""
        if len(self.speed) < 2:
            return np.nan
        rises = np.interp(speed, self.speed, np.gradient(self.ratio, self.speed)) > 0.0
        return 1.0 if rises == (holds == "above") else -1.0


def crossings(system, a, found):
    """(event, branch B) of every eigenvalue crossing of branch A whose growing line lies next to another whirl."""
    for event in (event for event in a.events if event.cause == OSCILLATORY):
        Psi, _ = force_at(system, event.value, TWO_PI * event.frequency)
        force = normal_force(system, np.array([Psi]), TWO_PI * event.value)[0]
        motion = small_motion(system, Psi, force, TWO_PI * event.value)
        lines = [Psi + sign * abs(motion.eigenvalue.imag) for sign in (-1.0, 1.0)]
        others = [(b, b.at(event.value)) for b in found if b is not a]
        near = [(abs(line / (TWO_PI * w.frequency) - 1.0), b) for b, w in others if w is not None for line in lines]
        distance, b = min(near, key=lambda pair: pair[0], default=(np.inf, None))
        if distance < TOWARDS and b.speed.min() <= event.value <= b.speed.max():
            yield event, b


def rows_of(number, system):
    """A row for every crossing, and for every place where a criterion is fulfilled and nothing crosses."""
    found = [b for b in branches(system, SPEEDS) if len(b.whirls) > 1]
    for i, a in enumerate(found):
        crossed = [(event, b) for event, b in crossings(system, a, found)]
        for j, b in enumerate(found):
            if b is a or not len(np.intersect1d(a.speed, b.speed)):
                continue
            pair = Pair(system, a, b)
            met = {criterion: pair.met(criterion) for criterion in CRITERIA}
            scene = (number, system.n_rotor, system.n_stator, i, j)
            used = {criterion: set() for criterion in CRITERIA}
            for event in (event for event, towards in crossed if towards is b):
                nearest = [min(met[c], key=lambda value: abs(value - event.value), default=np.nan) for c in CRITERIA]
                for criterion, value in zip(CRITERIA, nearest, strict=True):
                    used[criterion].add(value)
                sides = pair.stable_above(event.value, event.holds), float(event.holds == "above")
                yield (*scene, event.value, *nearest, *of_pair(pair, event.value), *sides)
            for c in CRITERIA:
                for value in (value for value in met[c] if value not in used[c] and a.at(value).stable):
                    places = [value if criterion == c else np.nan for criterion in CRITERIA]
                    yield (*scene, np.nan, *places, *of_pair(pair, value), np.nan, np.nan)


def of_pair(pair, speed):
    """Frequencies in Hz, F_A/F_B, its limit, the mirror share and the slope of B at a speed."""
    Psi, F_N, limit = pair.at(speed)
    values = (Psi[0] / TWO_PI, Psi[1] / TWO_PI, F_N[0] / F_N[1], limit.least, limit.mirror_share, limit.slope)
    return tuple(float(value[0]) for value in values)


def quantiles(values, form=".3g"):
    """The 10th, 50th, 90th and 99th percentile, as a cell."""
    return ", ".join(f"{value:{form}}" for value in np.quantile(values, (0.1, 0.5, 0.9, 0.99))) if len(values) else "-"


def table(header, rows):
    """Lines of a table in Markdown."""
    lines = ["| " + " | ".join(str(cell) for cell in row) + " |" for row in (header, *rows)]
    return "\n".join([lines[0], "|---" * len(header) + "|", *lines[1:]])


def report(rows):
    """What the rows say."""
    column = dict(zip(COLUMNS, rows.T, strict=True))
    crossed, negative = np.isfinite(column["crossing_Hz"]), column["slope"] < 0.0
    own = crossed & negative
    scenes, aligned = len(np.unique(column["scene"][crossed])), (column["stable_above"][own] > 0.0).sum()
    head = (
        f"{int(column['scene'].max())} random scenes. {crossed.sum()} crossings of a whirl A next to a whirl B that exists, in "
        f"{scenes} scenes; {(crossed & ~negative).sum()} of them next to a B with a positive slope of Im cH, left out below. "
        f"A is stable on the side of the larger F_A/F_B at {aligned} of {own.sum()}. F_A/F_B at the crossing: "
        f"{quantiles(column['ratio'][own])}. Quantiles are 10, 50, 90 and 99 %."
    )
    exchanged = "Rule with A and B exchanged: B gains stability at F_A = 2 F_B"
    parts = [f"## Limit: {text}\n\n{misses(column, own, name)}" for name, text in CRITERIA.items()]
    parts += [f"## {exchanged}\n\n{exchanged_rule(column, own)}"]
    parts += [f"## Pairs at random speeds\n\n{pairs_table(np.random.default_rng(2))}"]
    return "\n\n".join([head, *parts])


def classes(limit):
    """(name, (n,) bool) of the rows of a table: by mirror share, B with a negative slope, and where rsc tells the limit."""
    share, negative = limit.mirror_share, limit.slope < 0.0
    bins = [(f"{low:g} to {high:g}", (share >= low) & (share < high) & negative) for low, high in BINS]
    return [*bins, ("told by rsc", limit.holds)]


def limit_of(column):
    """The `PairLimit` of rows."""
    return PairLimit(*(column[name] for name in ("least", "mirror_share", "slope")))


def misses(column, own, criterion):
    """Table of the misses of one criterion."""
    place, met = column[f"{criterion}_Hz"], np.isfinite(column[f"{criterion}_Hz"])
    least = column["least"] if criterion == "mirrored" else 0.5
    miss, off = np.abs(column["ratio"] / least - 1.0), np.abs(place - column["crossing_Hz"])
    header = ("mirror share", "crossings", "miss in F_A/F_B, %", "met on the pair", "miss in speed, Hz", "met, A stays stable")
    rows = []
    for name, inside in classes(limit_of(column)):
        crosses, alarms = inside & own, inside & met & ~np.isfinite(column["crossing_Hz"])
        both = crosses & met
        cells = (quantiles(100.0 * miss[crosses], ".2g"), both.sum(), quantiles(off[both], ".2g"), alarms.sum())
        rows.append((name, crosses.sum(), *cells))
    return table(header, rows)


def exchanged_rule(column, own):
    """Misses by direction, and the pairs that show both crossings."""
    told, miss = own & limit_of(column).holds, np.abs(column["ratio"] / column["least"] - 1.0)
    rows = [
        (name, (told & (column["gains"] == gains)).sum(), quantiles(100.0 * miss[told & (column["gains"] == gains)], ".2g"))
        for name, gains in (("loses", 0.0), ("gains", 1.0))
    ]
    by_direction = table(("with rising speed A ... stability", "crossings told by rsc", "miss in F_A/F_B, %"), rows)
    pairs = np.transpose([column[name] for name in ("scene", "a", "b")])
    of_a = {tuple(pair[[0, 2, 1]]) for pair in pairs[own]}
    both = np.array([tuple(pair) in of_a for pair in pairs]) & np.isfinite(column["half_Hz"])
    near = np.abs(column["half_Hz"] - column["crossing_Hz"]) < 0.02 * column["half_Hz"]
    rows = [(name, (inside & both).sum(), (inside & both & near).sum()) for name, inside in classes(limit_of(column))]
    header = ("mirror share of B", "F_A = 2 F_B on a pair on which A crosses", "B crosses within 2 % of that speed")
    return f"{by_direction}\n\n{table(header, rows)}"


def pairs_table(rng, n_systems=1000, n_speeds=3):
    """Whether the ratio of forces tells the stability of A, for every pair of whirls at random speeds."""
    rows = []
    for _ in range(n_systems):
        system = random_rotor(rng)
        for speed in rng.uniform(SPEEDS[0], SPEEDS[-1], n_speeds):
            whirls = [w for w in predict_system(system, speed) if w.frequency < 0.0]
            pairs = [(a, b) for a in whirls for b in whirls if a is not b]
            if pairs:
                Psi = TWO_PI * np.array([[w.frequency for w in pair] for pair in pairs]).T
                F_N = np.array([[w.normal_force for w in pair] for pair in pairs]).T
                limit, exchanged = (pair_limit(system, Psi[way], F_N[way], TWO_PI * speed) for way in ([0, 1], [1, 0]))
                slope = np.maximum(limit.slope, exchanged.slope)  # negative: neither of the two creeps
                rows.append(np.array([limit.least, limit.mirror_share, slope, F_N[0] / F_N[1], [a.stable for a, _ in pairs]]))
    *of_limit, ratio, stable = np.concatenate(rows, axis=1)
    limit, cells = PairLimit(*of_limit), []
    for name, inside in classes(limit):
        low_ratios = [inside & (ratio < 0.5), inside & (ratio < limit.least), inside & (ratio >= limit.least)]
        parts = [part for chosen in low_ratios for part in (chosen.sum(), (chosen & (stable > 0.0)).sum())]
        cells.append((name, *parts))
    header = ("mirror share", "below a half", "A stable", "below least", "A stable", "above least", "A stable")
    return f"{n_systems} random scenes at {n_speeds} speeds each, both whirls with a negative slope.\n\n{table(header, cells)}"


@one_thread
def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", type=int, nargs="?", default=300)
    parser.add_argument("--page", action="store_true")
    options = parser.parse_args()
    if not options.page:
        rng, rows, tried = np.random.default_rng(1), [], 0
        while len({row[0] for row in rows if np.isfinite(row[COLUMNS.index("crossing_Hz")])}) < options.scenes:
            tried += 1
            rows.extend(rows_of(tried, random_rotor(rng)))
        with open(TABLE, "w", encoding="utf-8", newline="") as stream:
            csv.writer(stream).writerows([COLUMNS, *([f"{value:.6g}" for value in row] for row in rows)])
    text = report(np.genfromtxt(TABLE, delimiter=",", skip_header=1))
    title = "Half the force: whirls that lose their stability towards another"
    write_page(TABLE.with_suffix(".md"), title, "nice python bench/transition_criterion.py", text)


if __name__ == "__main__":
    main()
