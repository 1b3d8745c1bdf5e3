"""One whirl root followed over the rotor speed without the others: a step along its tangent, then Newton's method on the phase.

`rsc.analysis.lines.rootlines` knows all roots at every speed and pairs them. This knows one, asks of every step that the tangents
of both ends meet, and solves no eigenvalue problem after the first speed. Where the fold of
another pair comes closer than a step can tell it may go over to that pair.
"""

import math
from math import tau as TWO_PI
from typing import NamedTuple

import numpy as np

from rsc.analysis.lines.rootlines import HALVINGS, NEAR, RANGE_END, Family, Join, RootLine, fold_between
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.predict import MOST_SPEED, refuse_backwards
from rsc.analysis.paper.receptance import contact_receptance
from rsc.analysis.paper.whirls import steady_whirls
from rsc.errors import SceneError, SolverError, shown

# the tangents of both ends of a step miss the other end by less than `NEAR` of the frequency, and by less than this share of the
# distance to the extremum of the phase, beyond which the next root lies
_CLEAR = 0.1
# a fold is looked for where the extremum of the phase is this close, as a share of the frequency
_NEAR_FOLD = 0.05
# it is the root's own if it lies at that extremum, up to this share of the distance
_OWN = 0.2
_NEWTON_STEPS = 8
_CONVERGED = 1e-12


class _Point(NamedTuple):
    """A root (rad/s) at a value of the parameter: dPsi/dp, distance to the extremum of the phase by its first two derivatives,
    and whether F_N > 0."""

    value: float
    root: float
    slope: float
    to_extremum: float
    pressed: bool


def whirl_line(system, near, speeds):
    """Follow the root of the backward whirl next to a frequency.

    Parameters
    ----------
    system : System
    near : float, Hz
        The whirl at the first speed that is next to it is followed.
    speeds : (n,) Hz, monotonic
        The way; the line has a point at each speed that it reaches, and more where it bends.

    Returns
    -------
    family : Family
        System and speed over the speed in Hz.
    way : (n,) Hz
    line : RootLine
        From the first speed to the last, to a fold, or to the first point without normal force.

    Raises
    ------
    SceneError
        No whirl at the first speed; speeds that no drive may have or that turn back; a frequency that no whirl can have.
    SolverError
        The root is lost.
    """
    way = checked_way(speeds)
    if not -MOST_SPEED <= near < 0.0:
        wanted = f"a frequency in Hz from {-MOST_SPEED:g} to below 0"
        raise SceneError("follow", "near", float(near), wanted, "only backward whirls are followed")
    Psi = steady_whirls(system, TWO_PI * way[0])[0]
    Psi = Psi[Psi < 0.0]
    if len(Psi) == 0:
        wanted = f"next to a backward whirl at {way[0]:g} Hz, the first speed"
        raise SceneError("follow", "near", float(near), wanted, "none is predicted there")
    family = Family(lambda speed: (system, TWO_PI * speed), way.min(), way.max())
    return family, way, _line(family, way, float(Psi[np.argmin(np.abs(Psi / TWO_PI - near))]))


def checked_way(speeds):
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


def _line(family, way, root):
    points = [_point(family, float(way[0]), root)]
    begin, end = Join(float(way[0]), root, RANGE_END), None
    for target in way[1:]:
        end = _advanced(family, points, float(target))
        if end is not None:
            break
    ends = [begin, end or Join(points[-1].value, points[-1].root, RANGE_END)]
    if way[-1] < way[0]:
        points.reverse()
        ends.reverse()
    return RootLine(*np.array([point[:3] for point in points]).T, *ends)


def _advanced(family, points, target):
    """Add points up to a target, or up to the first without normal force; the Join where the line folds before it, or None."""
    width = target - points[-1].value
    least = 0.5**HALVINGS * abs(width)
    while points[-1].value != target and points[-1].pressed:
        value, root = points[-1][:2]
        ahead = target if abs(target - value) <= 1.001 * abs(width) else value + width
        point = _next_point(family, points[-1], ahead)
        if point is not None:
            points.append(point)
            width *= 2.0
            continue
        fold = _fold_ahead(family, points[-1], ahead)
        if fold is not None:
            return fold
        width = 0.5 * (ahead - value)
        if abs(width) < least:
            place = f"{root / TWO_PI:.6g} Hz cannot be followed beyond a rotor speed of {value:.6g} Hz"
            raise SolverError(f"the whirl at {place}: another one is too close, or its frequency is a pole of the receptance")
    return None


def _point(family, value, root):
    """The `_Point` at a value."""
    system, Omega = family.at(value)
    H, first, second = (part[0] for part in contact_receptance(system, Omega, np.array([root])))
    # as in `Family.node`, the difference looks into the range
    step = 1e-7 * max(family.high - family.low, abs(family.high), abs(family.low))
    step = step if value <= 0.5 * (family.low + family.high) else -step
    beyond = contact_receptance(*family.at(value + step), np.array([root]))[0][0]
    with np.errstate(divide="ignore", invalid="ignore"):  # a pole of an undamped body: no step is taken from there
        by_root, bend = (first / H).imag, (second / H - (first / H) ** 2).imag
        slope, to_extremum = -np.angle(H.conj() * beyond) / step / by_root, -by_root / bend
    return _Point(value, root, slope, to_extremum, law_of(system).held(H.real) > 0.0)


def _next_point(family, point, ahead):
    """The point of the line at a value ahead, or None where the tangents do not meet."""
    guess = point.root + (ahead - point.value) * point.slope
    root = _root_next_to(family, ahead, guess) if -math.inf < guess < 0.0 else math.nan
    if not abs(root - guess) <= _miss(point):
        return None
    after = _point(family, ahead, root)
    back = root - (ahead - point.value) * after.slope
    return after if max(abs(back - point.root), abs(root - guess)) <= _miss(after) else None


def _miss(point):
    """By how much a tangent may miss a point: the next roots lie beyond the extrema of the phase."""
    return min(NEAR * abs(point.root), _CLEAR * abs(point.to_extremum))


def _root_next_to(family, value, Psi):
    """Newton's method on the phase of cH (modulo pi); NaN if it does not arrive."""
    system, Omega = family.at(value)
    for _ in range(_NEWTON_STEPS):
        H, first, _ = (part[0] for part in contact_receptance(system, Omega, np.array([Psi])))
        with np.errstate(divide="ignore", invalid="ignore"):
            phase, slope = 0.5 * np.angle(H * H), (first / H).imag
        if not (np.isfinite(phase) and slope != 0.0):
            return math.nan
        step = phase / slope
        Psi = float(Psi - step)
        if abs(step) <= _CONVERGED * abs(Psi):
            return Psi
    return math.nan


def _fold_ahead(family, point, ahead):
    """The Join where the root of a point merges with a neighbour before a value ahead, or None.

    Beside a fold the root keeps a distance a sqrt(d) from the extremum of the phase and moves at a / (2 sqrt(d)): the fold is d =
    distance / (2 dPsi/dp) away.
    """
    away = point.to_extremum / (2.0 * point.slope) if point.slope != 0.0 else math.nan
    if not (abs(point.to_extremum) <= _NEAR_FOLD * abs(point.root) and 0.0 < away / (ahead - point.value) <= 1.0):
        return None
    extremum = point.root + point.to_extremum
    beyond = point.value + min(2.0 * away, ahead - point.value, key=abs)
    fold = fold_between(family, *sorted((point.value, beyond)), extremum)
    return fold if fold is not None and abs(fold.root - extremum) <= _OWN * abs(point.to_extremum) else None
