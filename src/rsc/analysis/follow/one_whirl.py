"""One whirl followed over the rotor speed without the others: where it folds, loses its stability, and where a run leaves it."""

from math import tau as TWO_PI

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rsc.analysis.follow.branch import Branch
from rsc.analysis.follow.branches import SPEEDS, branch_of, with_knots
from rsc.analysis.follow.curve import WhirlCurve
from rsc.analysis.follow.delayed_jump import Delay, delayed_jump, way_of
from rsc.analysis.follow.events import CREEPING, OSCILLATORY, Event, pieces_of
from rsc.analysis.follow.lines import FOLD, RANGE_END, Net, WhirlLine
from rsc.analysis.follow.patience import Patience, silent
from rsc.analysis.follow.whirls import WhirlsAtOne, bound_at, seeds_at_one
from rsc.analysis.paper.predict import MOST_SPEED, refuse_backwards
from rsc.arguments import POSITIVE, REAL, ROTOR_SPEEDS, SCENE, optional, takes
from rsc.errors import SceneError, SolverError, shown
from rsc.system.assemble import SceneLike, assemble
from rsc.system.blas import one_thread
from rsc.system.system import System

_SPEEDS = 33  # points on the way from one speed to another, besides those where the whirl bends


def whirl_line(system: System, near: float, speeds: ArrayLike) -> tuple[WhirlCurve, NDArray[np.float64], WhirlLine]:
    """Follow the root of the backward whirl next to a frequency.

    Parameters
    ----------
    system : System
        With one contact of finite stiffness.
    near : float, Hz
        The whirl at the first speed that is next to it is followed.
    speeds : (n,) Hz, monotonic
        The way.

    Returns
    -------
    curve : WhirlCurve
        Over the speed in Hz.
    way : (n,) Hz
    line : WhirlLine
        From the first speed to the last or to a fold.

    Raises
    ------
    SceneError
        No whirl at the first speed; speeds that no drive may have or that turn back; a frequency that no whirl can have.
    SolverError
        The root is lost.
    """
    way = _checked_way(speeds)
    if not -MOST_SPEED <= near < 0.0:
        wanted = f"a frequency in Hz from {-MOST_SPEED:g} to below 0"
        raise SceneError("follow", "near", float(near), wanted, "only backward whirls are followed")
    curve = WhirlCurve(lambda speed: (system, speed), (0,), way.min(), way.max())
    values = with_knots(np.sort(way), system.knot_speed / TWO_PI)
    seeds, rising = seeds_at_one(curve, values, Patience(silent)), bool(way[-1] >= way[0])
    first = 0 if rising else len(values) - 1
    Psi = np.where(curve.held(seeds[first]) > 0.0, seeds[first][:, 0], np.nan)
    if not np.isfinite(Psi).any():
        wanted = f"next to a backward whirl at {way[0]:g} Hz, the first speed"
        raise SceneError("follow", "near", float(near), wanted, "none is predicted there")
    net = Net(curve, values, seeds, bound_at(curve, values[0]))
    line = net.line_of((first, int(np.nanargmin(np.abs(Psi / TWO_PI - near)))), rising)
    end = line.end if rising else line.begin
    if end.cause not in (FOLD, RANGE_END):
        place = f"{end.root / TWO_PI:.6g} Hz cannot be followed beyond a rotor speed of {end.value:.6g} Hz"
        raise SolverError(f"the whirl at {place}: another one is too close, or its frequency is a pole of the receptance")
    return curve, way, line


def _checked_way(speeds: ArrayLike) -> NDArray[np.float64]:
    """Speeds (n,) Hz as an array; SceneError for some that no drive may have or that do not rise or fall all the way."""
    try:
        way = np.asarray(speeds, dtype=float)
    except (TypeError, ValueError):
        way = np.zeros(0)
    steps = np.diff(way) if way.ndim == 1 else np.zeros(1)
    if way.size == 0 or not (np.abs(way) <= MOST_SPEED).all() or not ((steps > 0.0).all() or (steps < 0.0).all()):
        wanted = f"rising or falling speeds in Hz between {-MOST_SPEED:g} and {MOST_SPEED:g}"
        raise SceneError("follow", "speeds", shown(speeds), wanted)
    refuse_backwards("follow", float(way.min()))
    return way


@one_thread
def follow(system: System, near: float, speeds: ArrayLike) -> Branch:
    """Follow the backward whirl next to a frequency over the rotor speed, and no other.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    near : float, Hz
        The whirl at the first speed that is next to it is followed.
    speeds : (n,) Hz, monotonic
        The way, as for `branches`.

    Returns
    -------
    Branch
        That of `branches` on which the whirl lies, from the first speed on; its label is "".

    Raises
    ------
    SceneError
        No whirl at the first speed, or speeds or a frequency that cannot be.
    SolverError
        The whirl cannot be followed.
    """
    curve, way, line = whirl_line(system, near, speeds)
    piece = pieces_of(curve, line)[0 if way[-1] >= way[0] else -1]
    return branch_of(curve, piece, way, WhirlsAtOne(curve))


@takes(scene=SCENE, near=REAL, speeds=ROTOR_SPEEDS)
def fold(scene: SceneLike, near: float, speeds: tuple[float | str, float | str]) -> Event | None:
    """Find the fold where a whirl ends: it merges with the other root of its pair.

    Parameters
    ----------
    scene : rsc.Scene
    near : float, Hz
        The backward whirl at the first speed that is next to this frequency (negative) is meant.
    speeds : (first, last) Hz, also with their units: "3000 rpm"
        The whirl is followed from the first speed to the last, rising or falling.

    Returns
    -------
    Event or None
        `value` is the speed, `frequency` that of both roots there. None if the whirl reaches the last speed, or before that a
        speed beyond which the contact is too soft to hold it.

    Raises
    ------
    SceneError
        No backward whirl at the first speed, speeds that no drive may have, or a frequency that no whirl can have.
    SolverError
        The whirl cannot be followed: another one is too close, or without damping its frequency is a pole of the receptance.

    Examples
    --------
    >>> scene = rsc.load_scene("disk.toml")
    >>> end = rsc.fold(scene, near=-48.0, speeds=(100.0, 20.0))
    >>> round(end.value, 2), round(end.frequency, 2)  # rotor speed and whirl frequency in Hz
    (24.73, -50.49)
    """
    _, way, line = whirl_line(assemble(scene), near, _way(speeds))
    end = line.end if way[-1] >= way[0] else line.begin
    return Event(end.cause, end.value, float(end.root) / TWO_PI) if end.cause == FOLD else None


@takes(scene=SCENE, near=REAL, speeds=ROTOR_SPEEDS)
def crossing(scene: SceneLike, near: float, speeds: tuple[float | str, float | str]) -> Event | None:
    """Find the first speed of a way at which the growth rate of a whirl crosses zero.

    Parameters
    ----------
    scene, near, speeds : as `rsc.fold`

    Returns
    -------
    Event or None
        `value` is the speed, `cause` tells whether the eigenvalue that crosses is real ("stable (creeping)") or one of a pair
        ("stable (oscillatory)"), `holds` on which side of the speed the whirl is stable. None if the whirl keeps its stability
        up to the last speed or to its end. Two crossings within a 32nd of the way, without a dip of the growth rate at the
        speeds beside them, are not seen.

    Raises
    ------
    SceneError, SolverError
        As `rsc.fold`.

    Examples
    --------
    >>> scene = rsc.load_scene("disk.toml").with_values({"contact.friction": 0.5})
    >>> change = rsc.crossing(scene, near=-37.7, speeds=(20.0, 150.0))
    >>> round(change.value, 2), change.cause, change.holds
    (23.53, 'stable (oscillatory)', 'above')
    """
    way = _way(speeds)
    branch = follow(assemble(scene), near, way)
    changes = [event for event in branch.events if event.cause in (CREEPING, OSCILLATORY)]
    return (min if way[-1] >= way[0] else max)(changes, key=lambda event: event.value, default=None)


@takes(scene=SCENE, near=REAL, start_level=optional(POSITIVE), floor=optional(POSITIVE))
def delay(scene: SceneLike, near: float, start_level: float | None = None, floor: float | None = None) -> Delay:
    """Predict where the run of a scene leaves a whirl that loses its stability on the way: later than it does.

    Parameters
    ----------
    scene : rsc.Scene
        Its drive is the run; counted up to where the speed turns back.
    near : float, Hz
        The backward whirl at the first speed that is next to this frequency (negative) is meant.
    start_level, floor : float above 0, optional
        Disturbances at the start and at all times, over the amplitude of the whirl; default: those of a simulation that starts on
        the whirl (`rsc.analysis.follow.delayed_jump`).

    Returns
    -------
    rsc.analysis.follow.delayed_jump.Delay

    Raises
    ------
    SceneError, SolverError
        As `rsc.fold`; also for a run at constant speed, or with a torque in its drive.

    Examples
    --------
    >>> scene = rsc.load_scene("disk.toml").with_values({"contact.friction": 0.6, "drive.speed": [60.0, 20.0]})
    >>> left = rsc.delay(scene, near=-24.0)
    >>> print(f"unstable from {left.crossing:.1f} Hz down, seen to leave at {left.jump:.1f} Hz")
    unstable from 41.4 Hz down, seen to leave at 35.7 Hz
    """
    system = assemble(scene)
    speed = way_of(system)[1]
    if system.drive is not None:
        raise SceneError("delay", "drive.torque", None, "left out", "a jump is predicted along a prescribed speed")
    if speed[0] == speed[-1]:
        hint = "at constant speed rsc.predict tells the growth rate"
        raise SceneError("delay", "drive.speed", list(scene.drive.speed), "a speed that changes", hint)
    branch = follow(system, near, np.linspace(speed[0], speed[-1], SPEEDS))
    return delayed_jump(system, branch, start_level, floor)


def _way(speeds: tuple[float | str, float | str]) -> NDArray[np.float64]:
    ends = _checked_way(speeds)
    return np.linspace(ends[0], ends[-1], _SPEEDS)
