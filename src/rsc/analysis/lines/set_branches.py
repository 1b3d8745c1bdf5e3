"""Branches of the whirls at several contacts: those of every pressed set, followed over the rotor speed.

All whirls are looked for at some of the speeds, and Newton's method follows each from speed to speed. A whirl that comes and goes
between two speeds where all are looked for stays unseen; where one begins there, or ends, is known to a step of the speeds.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import tau as TWO_PI
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rsc.analysis.lines.branches import Branch, labelled
from rsc.analysis.lines.events import Event
from rsc.analysis.lines.patience import Note, Patience, silent
from rsc.analysis.lines.rootlines import RANGE_END, UNRESOLVED
from rsc.analysis.several.condition import Pressed, Whirling, newton, pressed
from rsc.analysis.several.described import described
from rsc.analysis.several.predict import refuse_offset
from rsc.analysis.several.search import WhirlsOfSet, whirls_of_sets
from rsc.analysis.several.whirl import SeveralWhirl
from rsc.system.blas import one_thread
from rsc.system.system import System

LOOKED_AT, MOST = 33, 400  # speeds at which all whirls are looked for, and at which they are told, at most
# how far from where its tangent led a whirl is followed: its frequency in shares of itself, forces in shares of their sum
_STEP_PSI, _STEP_N = 0.05, 0.3
_ONE = 1e-6  # of the frequency: two whirls that are one; of the forces a thousand times as much


@dataclass(frozen=True)
class SetBranch(Branch):
    """One whirl at a pressed set of several contacts over the rotor speed, as far as it was seen. Its whirls are `SeveralWhirl`;
    what is of one contact is told at the one that was asked for."""

    whirls: tuple[SeveralWhirl, ...]

    @property
    def pressed(self) -> tuple[str, ...]:
        """Names of the pressed set."""
        return self.whirls[0].pressed

    @property
    def at_contacts(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Contact -> "normal_force" N, "over_gap" and "phase" deg, (n,) each."""
        names = "normal_force", "over_gap", "phase"
        return {
            contact: {name: np.array([getattr(whirl.contacts[contact], name) for whirl in self.whirls]) for name in names}
            for contact in self.whirls[0].contacts
        }


Course = dict[int, Whirling]  # number of the speed -> a whirl there, scalars and (n,)


@one_thread
def set_branches(system: System, speeds: ArrayLike, at: int, note: Note = silent) -> list[SetBranch]:
    """Follow the whirls of every pressed set over the rotor speed.

    Parameters
    ----------
    system : System
        With several contacts.
    speeds : (n,) Hz, monotonic
        The way of the run; of more than 400 as many are taken.
    at : int
        Number of the contact at which amplitude, force and lines are told.
    note : callable, called every two seconds of a long search with a line of text

    Returns
    -------
    list of SetBranch, by label

    Raises
    ------
    SolverError
        As `rsc.predict`.
    """
    refuse_offset(system)
    grid = _evenly(np.atleast_1d(np.asarray(speeds, dtype=float)), MOST)
    looked = _evenly(np.arange(len(grid)), LOOKED_AT) if system.turns else np.array([0])
    patience, seeds = Patience(note), dict[tuple[int, ...], dict[int, Whirling]]()
    for count, k in enumerate(looked.tolist()):
        for own in whirls_of_sets(system, TWO_PI * grid[k]):
            seeds.setdefault(own.contacts, {})[k] = own.whirls
        patience.say(f"whirls of every pressed set at {count + 1} of {len(looked)} speeds")
    courses = [(contacts, course) for contacts, own in seeds.items() for course in _courses(system, grid, own, contacts)]
    told = _told(system, grid, courses, at)
    made: list[SetBranch] = labelled([_branch(grid, own, course) for (_, course), own in zip(courses, told, strict=True)])
    return made


def _evenly(values: NDArray[Any], most: int) -> NDArray[Any]:
    """At most so many of some values, the first and the last among them."""
    return values[np.unique(np.linspace(0, len(values) - 1, min(len(values), most)).round().astype(int))]


def _courses(
    system: System, grid: NDArray[np.float64], seeds: Mapping[int, Whirling], contacts: tuple[int, ...]
) -> list[Course]:
    """The whirls of one set, each over a stretch of the speeds; seeds: number of a speed -> all whirls there."""
    if not system.turns:  # the same at every speed
        return [dict.fromkeys(range(len(grid)), seeds[0].at(i)) for i in range(len(seeds[0].Psi))] if 0 in seeds else []
    closed, going = list[Course](), list[Course]()
    for k, speed in enumerate(grid.tolist()):
        reached = _reached(pressed(system, TWO_PI * speed, contacts), going, k)
        goes_on = list[Course]()
        for course, whirl in zip(going, reached, strict=True):
            if whirl is None or any(_same(whirl, other[k]) for other in goes_on):
                closed.append(course)
            else:
                goes_on.append(course | {k: whirl})
        known = seeds.get(k)
        new = [] if known is None else [known.at(i) for i in range(len(known.Psi))]
        going = goes_on + [{k: whirl} for whirl in new if not any(_same(whirl, course[k]) for course in goes_on)]
    return closed + going


def _reached(own: Pressed, courses: Sequence[Course], k: int) -> list[Whirling | None]:
    """The whirls at speed k that go on from those of some courses at the speeds before; None where there is none."""
    if not courses:
        return []
    guesses = [_ahead(course, k) for course in courses]
    guess = Whirling(*(np.array(each) for each in zip(*guesses, strict=True)))
    roots, met = newton(own, guess)
    near = np.abs(roots.Psi / guess.Psi - 1.0) < _STEP_PSI
    near &= (np.abs(roots.N - guess.N) < _STEP_N * guess.N.sum(axis=1)[:, None]).all(axis=1)
    holds = met & near & (roots.N > 0.0).all(axis=1)
    return [roots.at(i) if holds[i] else None for i in range(len(courses))]


def _ahead(course: Course, k: int) -> Whirling:
    """Where a course leads to at speed k, along the tangent of its last two whirls."""
    last, before = course[k - 1], course.get(k - 2)
    if before is None:
        return last
    return Whirling(2.0 * last.Psi - before.Psi, np.maximum(2.0 * last.N - before.N, 0.0), 2.0 * last.phi - before.phi)


def _same(one: Whirling, other: Whirling) -> bool:
    return bool(abs(one.Psi / other.Psi - 1.0) < _ONE and np.abs(one.N - other.N).max() < 1e3 * _ONE * one.N.max())


def _told(
    system: System, grid: NDArray[np.float64], courses: Sequence[tuple[tuple[int, ...], Course]], at: int
) -> list[list[SeveralWhirl]]:
    """The whirls of every course, as they are told."""
    told: list[list[SeveralWhirl]] = [[] for _ in courses]
    for k, speed in enumerate(grid.tolist()):
        for contacts in dict.fromkeys(contacts for contacts, _ in courses):
            own = [i for i, (others, course) in enumerate(courses) if others == contacts and k in course]
            if own:
                whirls = Whirling(*(np.array(each) for each in zip(*(courses[i][1][k] for i in own), strict=True)))
                of_set = WhirlsOfSet(contacts, pressed(system, TWO_PI * speed, contacts), whirls)
                for i, whirl in zip(own, described(system, of_set, speed, at), strict=True):
                    told[i].append(whirl)
    return told


def _branch(grid: NDArray[np.float64], whirls: Sequence[SeveralWhirl], course: Course) -> SetBranch:
    """A branch without its label."""
    lost = tuple(after.speed for before, after in itertools.pairwise(whirls) if before.decays and not after.decays)
    ends = zip((min(course), max(course)), (whirls[0], whirls[-1]), strict=True)
    begin, end = sorted(
        (Event(RANGE_END if k in (0, len(grid) - 1) else UNRESOLVED, own.speed, own.frequency) for k, own in ends),
        key=lambda event: event.value,
    )
    rising = tuple(sorted(whirls, key=lambda whirl: whirl.speed))
    return SetBranch("", rising, lost, np.array([whirl.speed for whirl in rising]), begin, end, ())
