"""Questions about one whirl over the rotor speed, answered without the others: where it folds, where its stability changes, where
a run leaves it."""

from math import tau as TWO_PI

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.lines.branches import SPEEDS, follow
from rsc.analysis.lines.delayed_jump import Delay, delayed_jump, way_of
from rsc.analysis.lines.events import CREEPING, OSCILLATORY, Event
from rsc.analysis.lines.one_line import checked_way, whirl_line
from rsc.analysis.lines.rootlines import FOLD
from rsc.arguments import POSITIVE, REAL, ROTOR_SPEEDS, SCENE, optional, takes
from rsc.errors import SceneError
from rsc.system.assemble import SceneLike, assemble

_SPEEDS = 33  # points on the way from one speed to another, besides those where the whirl bends


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
        the whirl (`rsc.analysis.lines.delayed_jump`).

    Returns
    -------
    rsc.analysis.lines.delayed_jump.Delay

    Raises
    ------
    SceneError, SolverError
        As `rsc.fold`; also for a run at constant speed, or with a torque in its drive.
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
    ends = checked_way(speeds)
    return np.linspace(ends[0], ends[-1], _SPEEDS)
