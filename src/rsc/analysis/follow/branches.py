"""Whirl branches: backward whirls over the rotor speed or over any quantity of a scene, with their ends and events."""

from collections.abc import Callable
from math import tau as TWO_PI
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from rsc.analysis.follow.branch import Branch, SetBranch, labelled
from rsc.analysis.follow.curve import Points, WhirlCurve
from rsc.analysis.follow.events import CREEPING, OSCILLATORY, Event, Told, events_of, pieces_of
from rsc.analysis.follow.lines import Join, Net, WhirlLine
from rsc.analysis.follow.patience import Note, Patience, silent
from rsc.analysis.follow.whirls import WhirlsAtOne, WhirlsOfCurve, bound_at, seeds_at_one, seeds_of_sets
from rsc.analysis.several.predict import refuse_unpredictable
from rsc.system.assemble import assemble
from rsc.system.blas import one_thread
from rsc.system.system import System

SPEEDS = 201  # points on the way of a run
LOOKED_AT, MOST = 33, 400  # of several contacts: speeds at which all whirls are looked for, and at which they are told, at most


def branches(system: System, speeds: ArrayLike, note: Note = silent) -> list[Branch]:
    """Follow the backward whirls over the rotor speed.

    Parameters
    ----------
    system : System
        With one contact of finite stiffness.
    speeds : (n,) Hz, monotonic
        The way of the run: falling speeds only change what `Branch.lost` means.
    note : callable, called every two seconds of a long search with a line of text

    Returns
    -------
    list of Branch, by label
        Every piece of every line of whirls with F_N > 0; empty without friction.
    """
    return _branches(lambda value: (system, float(value)), speeds, note, system.knot_speed / TWO_PI)


def continuation(scene: Any, key: str, values: ArrayLike, speed: float | None = None) -> list[Branch]:
    """Follow the backward whirls over a quantity of the scene at one rotor speed.

    Parameters
    ----------
    scene : Scene
    key : str
        Dotted key of a number, for example "contact.friction".
    values : (n,) float, monotonic
        In SI units (Hz for frequencies).
    speed : float, optional, Hz
        Default: the first speed of the scene's drive.

    Returns
    -------
    list of Branch, by label

    Raises
    ------
    SceneError
        A value that the scene refuses.
    """
    speed = scene.drive.speed[0] if speed is None else float(speed)
    systems: dict[float, System] = {}

    def at(value: float) -> tuple[System, float]:
        if value not in systems:
            systems[value] = assemble(scene.with_values({key: float(value)}))
        return systems[value], speed

    return _branches(at, values)


@one_thread
def _branches(
    at: Callable[[float], tuple[System, float]], values: ArrayLike, note: Note = silent, knots: ArrayLike = ()
) -> list[Branch]:
    """Branches of the whirls of value -> (System, speed in Hz) over monotonic values; knots: values where that has kinks."""
    way, patience = np.atleast_1d(np.asarray(values, dtype=float)), Patience(note)
    rising = np.sort(way)
    curve = WhirlCurve(at, (0,), rising[0], rising[-1])
    looked = with_knots(rising, knots)
    net = Net(curve, looked, seeds_at_one(curve, looked, patience), bound_at(curve, rising[0]))
    return labelled(_made(curve, net.lines(patience), way, WhirlsAtOne(curve), patience))


@one_thread
def set_branches(system: System, speeds: ArrayLike, at: int, note: Note = silent) -> list[Branch]:
    """Follow the whirls of every pressed set of several contacts over the rotor speed.

    A whirl that comes and goes between two of the speeds at which all are looked for stays unseen.

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
    refuse_unpredictable(system)
    way, patience = _evenly(np.atleast_1d(np.asarray(speeds, dtype=float)), MOST), Patience(note)
    rising = np.sort(way)
    looked = with_knots(_evenly(rising, LOOKED_AT), system.knot_speed / TWO_PI)
    made = list[Branch]()
    for contacts, whirls_of_set in seeds_of_sets(system, looked, patience).items():
        curve = WhirlCurve(lambda value: (system, value), contacts, rising[0], rising[-1])
        seeds = {speed: curve.points(whirls, speed) for speed, whirls in whirls_of_set}
        none = np.zeros((0, 2 * len(contacts) + 1))
        net = Net(curve, looked, [seeds.get(speed, none) for speed in looked.tolist()], bound_at(curve, rising[0]))
        made += _made(curve, net.lines(patience), way, WhirlsOfCurve(curve, at), patience)
    return labelled(made)


def _evenly(values: NDArray[Any], most: int) -> NDArray[Any]:
    """At most so many of some values, the first and the last among them."""
    return values[np.unique(np.linspace(0, len(values) - 1, min(len(values), most)).round().astype(int))]


def with_knots(rising: NDArray[np.float64], knots: ArrayLike) -> NDArray[np.float64]:
    """Rising values with the knots between them, where curves have kinks."""
    knots = np.asarray(knots, dtype=float)
    inside = knots[(knots > rising[0]) & (knots < rising[-1])]
    return np.union1d(rising, inside) if len(inside) else rising


def _made(curve: WhirlCurve, lines: list[WhirlLine], way: NDArray[np.float64], told: Told, patience: Patience) -> list[Branch]:
    """The branches, without labels, of lines."""
    made = []
    for i, line in enumerate(lines):
        patience.say(f"whirls and their events are computed along the lines of roots, {i} of {len(lines)} done")
        made += [branch_of(curve, piece, way, told) for piece in pieces_of(curve, line)]
    return made


def branch_of(curve: WhirlCurve, piece: WhirlLine, way: NDArray[np.float64], told: Told) -> Branch:
    """The branch, without a label, of a piece of a line: its whirls at the values of a way, and its events."""
    points = _filled(curve, piece.points, way)
    whirls = told.whirls(points)
    events = events_of(curve, points, whirls, told)
    holds = "below" if way[-1] >= way[0] else "above"
    lost = tuple(event.value for event in events if event.cause in (CREEPING, OSCILLATORY) and event.holds == holds)
    shown = np.flatnonzero(np.isin(points[:, -1], way)).tolist() or [len(points) // 2]
    kind: type[Branch] = Branch if len(curve.at(way[0])[0].contacts) == 1 else SetBranch
    begin, end = _event(piece.begin), _event(piece.end)
    return kind("", tuple(whirls[i] for i in shown), lost, points[shown, -1], begin, end, events)


def _event(join: Join) -> Event:
    return Event(join.cause, join.value, join.root / TWO_PI)


def _filled(curve: WhirlCurve, points: Points, way: NDArray[np.float64]) -> Points:
    """The points of a piece, with those at the values of a way that lie between them."""
    values = np.setdiff1d(way[(way > points[0, -1]) & (way < points[-1, -1])], points[:, -1])
    if not len(values):
        return points
    guess = np.column_stack([scipy.interpolate.pchip_interpolate(points[:, -1], points[:, :-1], values, axis=0), values])
    scale, row = curve.scale(guess, curve.high - curve.low), np.zeros(guess.shape)
    row[:, -1] = 1.0
    added, met = curve.corrected(guess, row, scale, 0.5 * (curve.low + curve.high))
    added[:, -1] = values
    met &= np.abs((added - guess) / scale).max(axis=1) < 1.0
    points = np.concatenate([points, added[met]])
    return points[np.argsort(points[:, -1], kind="stable")]
