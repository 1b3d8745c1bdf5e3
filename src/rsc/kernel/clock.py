"""Where a run is: time without drift, rotation in turns, and the segment of the speed schedule."""

from typing import NamedTuple

from rsc.kernel.model import following_of
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.turn import TWO_PI, Turn, cos_sin_at, pick, turned, turns_of


class Clock(NamedTuple):
    """Time as a sum hi + lo, rotation in turns modulo one, speed in Hz; cosine and sine of the rotation."""

    hi: float
    lo: float
    phase: float
    speed: float
    speed_rate: float
    cos: float
    sin: float
    following: tuple  # see `Segment`


class Segment(NamedTuple):
    """One straight piece of the speed schedule."""

    begin: float  # s
    end: float
    speed: float  # Hz at its begin
    speed_rate: float  # Hz/s
    # where coefficients follow the speed, addresses of the matrices (K_a, K_b) or (K_a, K_b, B_a, B_b) of K_a + Omega K_b between
    # the two knots that the segment lies between; () elsewhere
    following: tuple


class Corners(NamedTuple):
    """The speed schedule, of which passed knots are corners: addresses of times in s and speeds in Hz, how many there are."""

    time: int
    speed: int
    count: int
    following: tuple  # `model.following_of`


@inlined
def corners_of(model):
    """The schedule of a model."""
    following = following_of(model.following_stiffness, model.following_damping, model.corner_interval)
    return Corners(vec.address(model.corner_time), vec.address(model.corner_speed), model.corner_time.shape[0], following)


@unrolled
def _matrices_of(following, i):
    """`Segment.following` of segment i."""
    if not len(following):
        return lambda following, i: ()

    def of_stiffness(following, i):
        first = following[2] + 2 * following[1] * int(vec.number_at(following[0], i))
        return first, first + following[1]

    def of_both(following, i):
        beyond = 2 * following[1] * int(vec.number_at(following[0], i))
        stiffness, damping = following[2] + beyond, following[3] + beyond
        return stiffness, stiffness + following[1], damping, damping + following[1]

    return of_stiffness if len(following) == 3 else of_both


@inlined
def segment_of(corners, i):
    """Segment i of the schedule."""
    t0, t1 = vec.number_at(corners.time, i), vec.number_at(corners.time, i + 1)
    f0 = vec.number_at(corners.speed, i)
    return Segment(t0, t1, f0, (vec.number_at(corners.speed, i + 1) - f0) / (t1 - t0), _matrices_of(corners.following, i))


@inlined
def clock_at(segment, hi, lo, phase):
    """The clock at a time and phase."""
    speed = segment.speed + segment.speed_rate * ((hi - segment.begin) + lo)
    c, s = cos_sin_at(phase)
    return Clock(hi, lo, phase, speed, segment.speed_rate, c, s, segment.following)


@inlined
def ahead(segment, clock, h):
    """The clock a step later; time is summed in two parts, so that a long run does not drift."""
    # Knuth's exact sum: lo holds what the rounding of hi + h lost
    hi = clock.hi + h
    part = hi - clock.hi
    lo = clock.lo + ((clock.hi - (hi - part)) + (h - part))
    top = hi + lo
    phase = clock.phase + (clock.speed + 0.5 * clock.speed_rate * h) * h
    return clock_at(segment, top, lo - (top - hi), phase - float(int(phase)))


@inlined
def turn_of(clock):
    """Rotation at a clock."""
    return turns_of(clock.cos, clock.sin, clock.speed, clock.speed_rate)


@inlined
def turns_after(clock, tau):
    """Rotations at times tau (a vector) after a clock, none longer than `Model.h_max`."""
    rate, speed = vec.spread(clock.speed_rate, tau), vec.spread(clock.speed, tau)
    angle = tau * vec.fma(tau, 0.5 * rate, speed)
    c, s = turned(vec.spread(clock.cos, tau), vec.spread(clock.sin, tau), angle)
    return turns_of(c, s, vec.fma(tau, rate, speed), clock.speed_rate)


@inlined
def turn_inside(clock, tau):
    """Rotation a time tau later."""
    return pick(turns_after(clock, vec.from_numbers((tau, tau), tau)), 0)


@inlined
def contact_turn(con, clock, tau):
    """Rotation a time tau later as far as the contact needs it: sine and cosine only for an eccentric ring."""
    if con.has_ring:
        return turn_inside(clock, tau)
    speed = clock.speed + clock.speed_rate * tau
    return Turn(1.0, 0.0, TWO_PI * speed, 0.0, 0.0, 0.0)
