"""Lines of whirls over a parameter: all roots at its values are the seeds, and curves join them.

Seeds of neighbouring values belong together where the tangents of both meet the other one, run the same way and are clearly
closer to it than to any third. Every end that is left open is followed along its curve (walk.py) to a seed, round folds if it has
some. So every seed lies on a line, and a line ends at an end of the range, at a fold or where its curve is lost. A line that
comes and goes between two values, round two folds, has no seed and stays unseen.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.follow.curve import Points, WhirlCurve
from rsc.analysis.follow.patience import Patience
from rsc.analysis.follow.walk import walk

FOLD, RANGE_END = "fold of two roots", "end of the range"
UNBOUNDED, UNRESOLVED = "frequency beyond all bounds", "not resolved"
FORCE = "normal force positive"
# seeds belong together when the tangents of both meet the other this much closer than any third seed, within so much of a step
_CLEAR, _NEAR = 0.3, 0.4
_SAME = 1e-6  # of a step, up to which a point is a seed

Seed = tuple[int, int]  # number of the value, and of the seed there


@dataclass(frozen=True)
class Join:
    """Where a line begins or ends: value of the parameter, root (rad/s) there, and cause."""

    value: float
    root: float
    cause: str


@dataclass(frozen=True, eq=False)
class WhirlLine:
    """One whirl over the parameter: points (n, k) of a curve by rising parameter, and its ends."""

    points: Points
    begin: Join
    end: Join


@dataclass(frozen=True, eq=False)
class _Strand:
    """A part of a line between seeds, or from a seed to where a line ends."""

    points: Points
    begin: Seed | Join
    end: Seed | Join
    walked: bool


class Net:
    """Seeds at rising values of the parameter, joined to lines.

    Parameters
    ----------
    curve : WhirlCurve
    values : (n,) rising
    seeds : list of (m, k) points at each of the values
    bound : float, rad/s, beyond which no frequency is followed
    """

    def __init__(self, curve: WhirlCurve, values: NDArray[np.float64], seeds: Sequence[Points], bound: float) -> None:
        self.curve, self.values, self.bound = curve, values, bound
        self.seeds = [list(points) for points in seeds]
        # the strand that ends at a seed (False) and that begins there (True)
        self._strands: dict[tuple[Seed, bool], _Strand] = {}
        self._whole: list[_Strand] = []

    def lines(self, patience: Patience) -> list[WhirlLine]:
        """Join the seeds to lines."""
        self._link()
        open_ends = [
            ((i, j), rising)
            for i in range(len(self.values)) for j in range(len(self.seeds[i])) for rising in (False, True)
            if self._is_open((i, j), rising)
        ]  # fmt: skip
        count = len(open_ends)
        while open_ends:
            seed, rising = open_ends.pop()
            if self._is_open(seed, rising):
                patience.say(f"whirls are followed from value to value, {max(0, count - len(open_ends))} of {count} done")
                open_ends += self._walk(seed, rising)
        return self._chained()

    def line_of(self, seed: Seed, rising: bool) -> WhirlLine:
        """The line of one seed at the first value, or where the parameter is to fall at the last, without the others."""
        self._link()
        current: Seed | Join = seed
        while not isinstance(current, Join):
            if self._is_open(current, rising):
                self._walk(current, rising)
            strand = self._strands.get((current, rising))
            current = _range_end(self.seeds[0][0]) if strand is None else strand.end if rising else strand.begin
        point = self.seeds[seed[0]][seed[1]]
        place = 0 if rising else -1
        return next(line for line in self._chained() if np.array_equal(line.points[place][[0, -1]], point[[0, -1]]))

    def _is_open(self, seed: Seed, rising: bool) -> bool:
        edge = seed[0] == (len(self.values) - 1 if rising else 0)
        return not edge and (seed, rising) not in self._strands

    def _keep(self, strand: _Strand) -> None:
        if isinstance(strand.begin, Join) and isinstance(strand.end, Join):
            self._whole.append(strand)
        if not isinstance(strand.begin, Join):
            self._strands[strand.begin, True] = strand
        if not isinstance(strand.end, Join):
            self._strands[strand.end, False] = strand

    def _link(self) -> None:
        """Join the seeds that clearly belong together."""
        numbers = [len(points) for points in self.seeds]
        if not sum(numbers) or len(self.values) < 2:
            return
        flat = np.array([point for points in self.seeds for point in points])
        middle = 0.5 * (self.curve.low + self.curve.high)
        scale = self.curve.scale(flat, 1.0)
        tangents = self.curve.tangents(self.curve.evaluated(flat, middle)[1], scale)
        with np.errstate(divide="ignore", invalid="ignore"):
            slopes = tangents * scale / tangents[:, -1:]
        starts = np.cumsum([0, *numbers])
        for i in range(len(self.values) - 1):
            left, right = slice(*starts[i : i + 2]), slice(*starts[i + 1 : i + 3])
            width = self.values[i + 1] - self.values[i]
            one, other = np.broadcast_arrays(flat[left, None], flat[None, right])
            ahead = np.abs(self.curve.apart(one + width * slopes[left, None], other))
            back = np.abs(self.curve.apart(one, other - width * slopes[None, right]))
            miss = (ahead + back).max(axis=2)
            alike = np.sign(tangents[left, None, -1]) == np.sign(tangents[None, right, -1])
            pairs = _clear_pairs(np.where(np.isfinite(miss), miss, np.inf), alike)
            # folds end pairs of lines: where lines seem to end on both sides none of the links is sure
            if len(pairs) < min(numbers[i : i + 2]):
                continue
            for a, b in pairs:
                points = np.array([self.seeds[i][a], self.seeds[i + 1][b]])
                self._keep(_Strand(points, (i, a), (i + 1, b), False))

    def _walk(self, seed: Seed, rising: bool) -> list[tuple[Seed, bool]]:
        """Follow a curve from a seed over the next stretch, and keep its strands; the ends that this leaves open anew."""
        i, j = seed
        k = i if rising else i - 1
        stretch = float(self.values[k]), float(self.values[k + 1])
        way = walk(self.curve, self.seeds[i][j], stretch, rising, self.bound)
        strands = way.strands()
        opened: list[tuple[Seed, bool]] = []
        last = way.points[-1]
        if np.isfinite(way.landed):
            arrived = k if way.landed == stretch[0] else k + 1
            target, new = self._seed_at(arrived, last)
            if new:
                opened += [(target, False), (target, True)]
            way.points[-1] = self.seeds[target[0]][target[1]]  # the same to the last bit
            end: Seed | Join | None = self._freed((target, arrived == k), opened)
        else:
            end = None
        if end is None:
            end = _loose_end(last, self.bound)
        joins: list[Seed | Join] = [seed, *(Join(float(s[-1, -1]), float(s[-1, 0]), FOLD) for s in strands[:-1]), end]
        for n, points in enumerate(strands):
            is_rising = rising == (n % 2 == 0)
            ends = joins[n : n + 2] if is_rising else joins[n : n + 2][::-1]
            self._keep(_Strand(points if is_rising else points[::-1], ends[0], ends[1], True))
        return opened

    def _seed_at(self, i: int, point: Points) -> tuple[Seed, bool]:
        """The seed at a point, which is added where there is none, and whether it was."""
        known = np.array(self.seeds[i]).reshape(-1, len(point))
        apart = np.abs(self.curve.apart(known, point)).max(axis=1)
        if len(known) and apart.min() < _SAME:
            return (i, int(np.argmin(apart))), False
        self.seeds[i].append(point)
        return (i, len(known)), True

    def _freed(self, side: tuple[Seed, bool], opened: list[tuple[Seed, bool]]) -> Seed | None:
        """The seed of a side to which a walk came, free of a strand that was no more than likely; None where it has a walk."""
        strand = self._strands.get(side)
        if strand is None:
            return side[0]
        other = (strand.end, False) if side[1] else (strand.begin, True)
        if strand.walked:  # it came from there, unless it was lost on the way
            lost = isinstance(other[0], Join) and other[0].cause == UNRESOLVED
            return side[0] if lost else None
        assert not isinstance(other[0], Join)
        del self._strands[side], self._strands[other[0], other[1]]
        opened.append((other[0], other[1]))
        return side[0]

    def _chained(self) -> list[WhirlLine]:
        """The strands, one behind the other, as lines."""
        lines = []
        for strand in self._whole:
            assert isinstance(strand.begin, Join) and isinstance(strand.end, Join)
            lines.append(WhirlLine(self.curve.unwrapped(strand.points), strand.begin, strand.end))
        for i, points in enumerate(self.seeds):
            for j, point in enumerate(points):
                before = self._strands.get(((i, j), False))
                if before is None:
                    lines.append(self._onwards([point[None]], (i, j), _range_end(point)))
                elif isinstance(before.begin, Join):
                    lines.append(self._onwards([before.points], (i, j), before.begin))
        return lines

    def _onwards(self, parts: list[Points], seed: Seed, begin: Join) -> WhirlLine:
        """The line that goes on from a seed, given its points up to there."""
        end: Seed | Join = seed
        while not isinstance(end, Join):
            strand = self._strands.get((end, True))
            if strand is None:
                end = _range_end(self.seeds[end[0]][end[1]])
            else:
                parts.append(strand.points[1:])
                end = strand.end
        return WhirlLine(self.curve.unwrapped(np.concatenate(parts)), begin, end)


def _loose_end(point: Points, bound: float) -> Join:
    """The end of a curve that led to no seed."""
    return Join(float(point[-1]), float(point[0]), UNBOUNDED if abs(point[0]) > 0.9 * bound else UNRESOLVED)


def _range_end(point: Points) -> Join:
    return Join(float(point[-1]), float(point[0]), RANGE_END)


def _clear_pairs(miss: NDArray[np.float64], alike: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Pairs (i, j) of the rows and columns of a matrix (n, m) that meet clearly, and are alike."""
    if not miss.size:
        return []
    pairs = []
    for i, j in enumerate(miss.argmin(axis=1).tolist()):
        distance = miss[i, j]
        others = min(np.delete(miss[i], j).min(initial=np.inf), np.delete(miss[:, j], i).min(initial=np.inf))
        if alike[i, j] and distance <= _NEAR and distance <= _CLEAR * others:
            pairs.append((i, j))
    return pairs
