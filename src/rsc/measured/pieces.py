"""Shaft angle between pulses: unambiguous pieces, the gaps between them, and the ends of a run."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.measured.smooth import Events, smoothed

_LEAST = 5  # events of a piece
_RESTS = 1.5  # teeth in which an even fall of the speed, or fall and rise together, must end at rest, so that a shaft stands
_SHORT_OF_ONE = 0.99  # of a tooth, that passes at most where no pulse comes
_STRETCHED = 2.0  # times as far as an even fall of the speed goes on, that a shaft may coast to a tooth that is seen later
_DUE = 1.5  # teeth that may pass before the first pulse and behind the last by what the speed beside tells
_EVEN = 0.02  # of the speed, by which an even rise on one side of a gap may miss the other side
_WHOLE = 0.25  # of a tooth, by which the count through a gap may miss a whole number


class Known(NamedTuple):
    """turns, speed, known : (n,) as those of `Shaft`; filled : int, pulses missing in gaps that were bridged
    jitter : s, of events; told : lines."""

    turns: NDArray[np.float64]
    speed: NDArray[np.float64]
    known: NDArray[np.bool_]
    filled: int
    jitter: float
    told: tuple[str, ...]


class _Piece:
    """Events between which nothing is in doubt; at, speed, rise (k,): turns, Hz and Hz/s there; jitter in s of their times."""

    def __init__(self, events: Events) -> None:
        self.events = events
        (at, speed, self.rise), self.jitter = smoothed(events)
        # of a cubic that never falls between rising values
        chords = np.diff(at) / np.diff(events.times)
        rising = np.maximum(np.minimum(np.append(chords, chords[-1]), np.append(chords[0], chords)), 0.0)
        self.at, self.speed = np.maximum.accumulate(at), np.clip(speed, 0.0, 3.0 * rising)

    @property
    def times(self) -> NDArray[np.float64]:
        """(k,) s."""
        return self.events.times

    @property
    def turns(self) -> NDArray[np.float64]:
        """(k,) of the events themselves."""
        return self.events.turns


class _Gap(NamedTuple):
    """What lies between two pieces: how it is bridged, "even", "rest" or "not known", and the turns that pass."""

    how: str
    turns: float


def known_between(
    time: NDArray[np.float64], events: Events, unsure: NDArray[np.bool_], tooth: float, counts: bool
) -> Known | None:
    """Turns and speed at times (n,) s of a shaft, from its events; None where no five of them follow each other without doubt.

    Parameters
    ----------
    events : Events, k of them
    unsure : (k - 1,) bool, steps between them in doubt
    tooth : float, turns between two pulses at most
    counts : bool, whether turns beyond a step in doubt are counted from here; else they are known but for whole ones
    """
    edges = np.concatenate([[0], np.flatnonzero(unsure) + 1, [len(events.times)]])
    whole = [slice(a, b) for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True) if b - a >= _LEAST]
    if not whole:
        return None
    pieces, gaps, filled = [_Piece(events.part(whole[0]))], [], 0
    for before, own in pairwise(whole):
        last, piece = pieces[-1], _Piece(events.part(own))
        gap = _at_rest(last, piece, tooth, counts) if before.stop == own.start else None
        if gap is None:
            last, piece = _without(last, -1), _without(piece, 0)
            gap = _between(last, piece, tooth, counts)
        later = piece.events.moved(last.turns[-1] + gap.turns - piece.turns[0])
        pieces[-1] = last
        if gap.how == "even":
            filled += max(round(gap.turns / tooth) - 3, 0)  # without those left out on both sides
            pieces[-1] = _Piece(last.events.with_later(later))
        else:
            pieces.append(_Piece(later))
            gaps.append(gap)
    return _put_together(time, pieces, gaps, tooth, filled)


def _without(piece: _Piece, end: int) -> _Piece:
    """A piece without its first or last event: pulses next to a gap may be truncated."""
    return _Piece(piece.events.part(slice(None, -1) if end else slice(1, None)))


def _at_rest(last: _Piece, piece: _Piece, tooth: float, counts: bool) -> _Gap | None:
    """The gap between two pieces of a shaft that comes to rest and starts again without a lost pulse; None where it does not."""
    span = piece.times[0] - last.times[-1]
    v, w, fall, rise = last.speed[-1], piece.speed[0], last.rise[-1], piece.rise[0]
    if not (_rests(v, -fall, tooth) and _rests(w, rise, tooth)):
        return None
    ahead, behind = _to_rest(v, -fall), _to_rest(w, rise)
    if ahead + behind > _RESTS * tooth:
        return None
    share = min(tooth / (ahead + behind), _STRETCHED)
    if share * (2.0 * ahead / v + 2.0 * behind / w) > span:
        return None
    return _Gap("rest", tooth if counts else _to_next(last, piece))


def _between(last: _Piece, piece: _Piece, tooth: float, counts: bool) -> _Gap:
    """What lies between two pieces of a shaft that turns on."""
    span = piece.times[0] - last.times[-1]
    v, w, fall, rise = last.speed[-1], piece.speed[0], last.rise[-1], piece.rise[0]
    passed = 0.5 * (v + w) * span
    if counts:
        turns = tooth * max(round(passed / tooth), 1)
    else:
        told = _to_next(last, piece)
        turns = told + max(round(passed - told), 0)
    missed = max(abs(v + fall * span - w), abs(w - rise * span - v))
    even = missed <= _EVEN * max(v, w) and abs(turns - passed) <= _WHOLE * tooth
    return _Gap("even" if even else "not known", turns)


def _to_next(last: _Piece, piece: _Piece) -> float:
    """Turns from the end of a piece to the next one's begin, less whole turns, of a wheel with a mark."""
    return float((piece.turns[0] - last.turns[-1]) % 1.0) or 1.0


def _to_rest(speed: float, fall: float) -> float:
    """Turns until an even fall of the speed, Hz/s, ends at rest."""
    return 0.5 * speed**2 / fall


def _rests(speed: float, fall: float, tooth: float) -> bool:
    return bool(fall > 0.0 < speed and _to_rest(speed, fall) <= _RESTS * tooth)


def _put_together(time: NDArray[np.float64], pieces: list[_Piece], gaps: list[_Gap], tooth: float, filled: int) -> Known:
    ends = {}
    for k, sign in ((0, -1.0), (-1, 1.0)):
        ends[k] = _end(time, pieces[k], sign, tooth)
        if not ends[k].known and len(pieces[k].times) >= _LEAST:
            pieces[k] = _without(pieces[k], k)
            ends[k] = _end(time, pieces[k], sign, tooth)._replace(known=False)
    turns, speed, known = np.zeros(len(time)), np.zeros(len(time)), np.ones(len(time), dtype=bool)
    stands: list[tuple[float, float]] = []
    lost: list[tuple[float, float]] = []
    for piece in pieces:
        own = _inside(time, piece.times[0], piece.times[-1])
        turns[own] = scipy.interpolate.CubicHermiteSpline(piece.times, piece.at, piece.speed)(time[own])
        speed[own] = np.interp(time[own], piece.times, piece.speed)
    for last, piece, gap in zip(pieces[:-1], pieces[1:], gaps, strict=True):
        begin, end = last.times[-1], piece.times[0]
        own = _inside(time, begin, end)
        if gap.how == "rest":
            turns[own], speed[own], still = _through_rest(time[own], last, piece)
            stands.append(still)
        else:
            at, speeds = np.array([last.at[-1], piece.at[0]]), np.array([last.speed[-1], piece.speed[0]])
            slopes = np.minimum(speeds, 3.0 * (at[1] - at[0]) / (end - begin))
            turns[own] = scipy.interpolate.CubicHermiteSpline([begin, end], at, slopes)(time[own])
            speed[own] = np.interp(time[own], [begin, end], speeds)
            known[own] = False
            lost.append((begin, end))
    for end in ends.values():
        turns[end.own], speed[end.own], known[end.own] = end.turns, end.speed, end.known
        if not end.known:
            lost.append(end.span)
        elif end.stands is not None:
            stands.append(end.stands)
    jitter = max(pieces, key=lambda piece: len(piece.times)).jitter
    return Known(turns, speed, known, filled, jitter, tuple(_told(stands, lost)))


def _inside(time: NDArray[np.float64], begin: float, end: float) -> slice:
    return slice(int(np.searchsorted(time, begin)), int(np.searchsorted(time, end, side="right")))


def _through_rest(
    time: NDArray[np.float64], last: _Piece, piece: _Piece
) -> tuple[NDArray[np.float64], NDArray[np.float64], tuple[float, float]]:
    """Turns and speed at times between two pieces of a shaft that comes to rest and starts again, and when it stands.

    Fall and rise are as even as beside the gap, but so much steeper or less steep that the turns that are seen pass.
    """
    v, w, begin, end = last.speed[-1], piece.speed[0], last.times[-1], piece.times[0]
    ahead, behind = _to_rest(v, -last.rise[-1]), _to_rest(w, piece.rise[0])
    share = min((piece.at[0] - last.at[-1]) / (ahead + behind), _STRETCHED)
    ahead, behind = share * ahead, share * behind
    stop, start = begin + 2.0 * ahead / v, end - 2.0 * behind / w
    speed = np.interp(time, [begin, stop, start, end], [v, 0.0, 0.0, w])
    still = last.at[-1] + ahead, piece.at[0] - behind  # the same but for a tooth that passes more slowly than foretold
    turns = np.where(
        time < stop,
        still[0] - 0.5 * speed * (stop - time),
        np.where(time > start, still[1] + 0.5 * speed * (time - start), np.interp(time, [stop, start], still)),
    )
    return turns, speed, (stop, start)


class _Margin(NamedTuple):
    """A run before its first pulse, or after its last.

    own : (n,) bool, its samples; turns, speed : of these; known : bool; span : s, from when to when; stands : the same of a
    standstill, or None
    """

    own: NDArray[np.bool_]
    turns: NDArray[np.float64]
    speed: NDArray[np.float64]
    known: bool
    span: tuple[float, float]
    stands: tuple[float, float] | None


def _end(time: NDArray[np.float64], piece: _Piece, sign: float, tooth: float) -> _Margin:
    """The run after the last pulse of a piece (sign 1), or before its first (-1).

    It goes on as evenly as beside it, to rest where that is near. Where no pulse comes though one was due, nothing is known.
    """
    k = -1 if sign > 0.0 else 0
    at, speed, rise = piece.times[k], piece.speed[k], sign * piece.rise[k]
    own = sign * (time - at) > 0.0
    later = sign * (time[own] - at)
    span = float(later.max(initial=0.0))

    def end(passed: NDArray[np.float64], speeds: NDArray[np.float64], known: bool, stop: float = np.inf) -> _Margin:
        stands = _in_order(at + sign * stop, at + sign * span) if stop < span else None
        return _Margin(own, piece.at[k] + sign * passed, speeds, known, _in_order(at, at + sign * span), stands)

    if _rests(speed, -rise, tooth):
        far = min(_to_rest(speed, -rise), _SHORT_OF_ONE * tooth)
        left = np.maximum(1.0 - 0.5 * later * speed / far, 0.0)
        return end(far * (1.0 - left**2), speed * left, True, 2.0 * far / speed)
    moving = np.minimum(later, -speed / rise) if rise < 0.0 else later
    passed = (speed + 0.5 * rise * moving) * moving
    if passed.max(initial=0.0) > _DUE * tooth:
        return end(speed * later, np.full(len(later), speed), False)
    return end(passed, speed + rise * moving, True)


def _in_order(a: float, b: float) -> tuple[float, float]:
    return (a, b) if a <= b else (b, a)


def _told(stands: list[tuple[float, float]], lost: list[tuple[float, float]]) -> list[str]:
    told = []
    if lost:
        where = "an unknown number of shaft pulses is missing there: windows there are empty"
        told.append(f"how the shaft turns is not known from {_spans(lost)}: {where}")
    if stands:
        told.append(f"the shaft is at rest from {_spans(stands)}: no pulses, and the speed falls to zero")
    return told


def _spans(spans: list[tuple[float, float]]) -> str:
    begin, end = min(spans)
    more = f" and in {len(spans) - 1} more places" if len(spans) > 1 else ""
    return f"{begin:.4g} to {end:.4g} s{more}"
