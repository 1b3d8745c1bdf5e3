"""Clock of a run: time without drift, rotation in turns, and the segment of the speed schedule."""

from typing import NamedTuple

from rsc.kernel.drive import TorqueLine, angle_of, line_at, speed_of, torque_in, torques_of, turn_at
from rsc.kernel.model import following_of
from rsc.kernel.questions import follows, is_driven, is_none
from rsc.kernel.race import without_ways
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import question, static
from rsc.kernel.states import matrices_in, matrices_of, without_integrals
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
    torque: tuple  # `drive.TorqueLine` of the step that starts here, () if the speed is prescribed
    states: tuple  # see `Segment`


class Segment(NamedTuple):
    """One linear segment of the speed schedule."""

    begin: float  # s
    end: float
    speed: float  # Hz at `begin`
    speed_rate: float  # Hz/s
    # speed-dependent coefficients: addresses of (K_a, K_b) or (K_a, K_b, B_a, B_b), K = K_a + Omega K_b between the two knots
    # that enclose the segment; () if all are constant
    following: tuple
    torque: tuple  # `drive.torque_in`
    states: tuple  # `states.matrices_in`


class Corners(NamedTuple):
    """The speed schedule, with the knots it passes as corners: addresses of times in s and speeds in Hz, number of corners."""

    time: int
    speed: int
    count: int
    following: tuple  # `model.following_of`
    torque: tuple  # `drive.torques_of`
    states: tuple  # `states.matrices_of`


@inlined
def corners_of(model):
    """The Corners of a model."""
    following = following_of(model.following_stiffness, model.following_damping, model.corner_interval)
    times, speeds, count = vec.address(model.corner_time), vec.address(model.corner_speed), model.corner_time.shape[0]
    return Corners(times, speeds, count, following, torques_of(model.drive), matrices_of(model.states))


@static
def _matrices_of(following, i):
    """`Segment.following` of segment i."""
    return () if is_none(following) else _matrices_in(following, int(vec.number_at(following[0], i)))


@question
def _stiffness_alone(following):
    """Whether only the stiffness is speed-dependent; `following` as from `model.following_of`."""
    return len(following) == 3


@static
def _matrices_in(following, interval):
    """`Segment.following` for an interval between knots."""
    size, beyond = following[1], 2 * following[1] * interval
    stiffness = following[2] + beyond
    if _stiffness_alone(following):
        return stiffness, stiffness + size
    damping = following[3] + beyond
    return stiffness, stiffness + size, damping, damping + size


@inlined
def segment_of(corners, i):
    """Segment i of the schedule."""
    t0, t1 = vec.number_at(corners.time, i), vec.number_at(corners.time, i + 1)
    f0 = vec.number_at(corners.speed, i)
    rate = (vec.number_at(corners.speed, i + 1) - f0) / (t1 - t0)
    following, torque = _matrices_of(corners.following, i), torque_in(corners.torque, i)
    return Segment(t0, t1, f0, rate, following, torque, matrices_in(corners.states, i))


@inlined
def clock_at(segment, hi, lo, phase):
    """The Clock at a time and phase, for a prescribed speed."""
    speed = segment.speed + segment.speed_rate * ((hi - segment.begin) + lo)
    c, s = cos_sin_at(phase)
    return Clock(hi, lo, phase, speed, segment.speed_rate, c, s, segment.following, (), segment.states)


@inlined
def _later(clock, h):
    """Time hi + lo a step h later, in two parts so that rounding does not accumulate over a long run."""
    # Knuth's two-sum: lo holds the rounding error of hi + h
    hi = clock.hi + h
    part = hi - clock.hi
    lo = clock.lo + ((clock.hi - (hi - part)) + (h - part))
    top = hi + lo
    return top, lo - (top - hi)


@inlined
def ahead(segment, clock, h):
    """The Clock a step h later, for a prescribed speed."""
    hi, lo = _later(clock, h)
    phase = clock.phase + (clock.speed + 0.5 * clock.speed_rate * h) * h
    return clock_at(segment, hi, lo, phase - float(int(phase)))


@static
def _between_knots(con, following, omega, rising, line):
    """(`Segment.following`, TorqueLine) at an integrated speed, of the interval between two knots that a step must not leave; at
    a knot the interval above if the speed is rising, else the one below."""
    if not follows(con):
        return following, line
    base, count = con.drive.knots
    i = 0
    while i < count and (vec.number_at(base, i) < omega or (rising and vec.number_at(base, i) == omega)):
        i += 1
    low = max(line.low, vec.number_at(base, i - 1)) if i > 0 else line.low
    high = min(line.high, vec.number_at(base, i)) if i < count else line.high
    return _matrices_in(con.following, i), TorqueLine(line.a, line.b, low, high)


@static
def clock_in(con, segment, hi, lo, phase, v):
    """The Clock at a time and phase with velocities v."""
    if not is_driven(con):
        return clock_at(segment, hi, lo, phase)
    omega = speed_of(con.drive, v)
    c, s = cos_sin_at(phase)
    following, line = _between_knots(con, segment.following, omega, True, line_at(segment.torque, omega, True))
    return Clock(hi, lo, phase, omega / TWO_PI, 0.0, c, s, following, line, segment.states)


@static
def planned(con, segment, clock, h):
    """The Clock after a step h, cut off at the end of the segment; with an integrated speed only its time is advanced."""
    if not is_driven(con):
        end = ahead(segment, clock, h)
        if h >= (segment.end - clock.hi) - clock.lo:
            end = clock_at(segment, segment.end, 0.0, end.phase)
        return end
    hi, lo = _later(clock, h)
    if h >= (segment.end - clock.hi) - clock.lo:
        hi, lo = segment.end, 0.0
    c = clock
    return Clock(hi, lo, c.phase, c.speed, 0.0, c.cos, c.sin, c.following, c.torque, c.states)


@inlined
def _phase_reached(con, clock, x):
    phase = clock.phase + angle_of(con.drive, x) / TWO_PI
    return phase - float(int(phase))


@inlined
def angle_reached(con, clock, x):
    """The Turn at the end of a step from a clock to coordinates x with integrated speed; only sine and cosine are set."""
    c, s = cos_sin_at(_phase_reached(con, clock, x))
    return Turn(c, s, 0.0, 0.0, 0.0, 0.0)


@static
def passed_knot(con, start, end):
    """Whether a step left its interval of torque and coefficients, so that its last slopes cannot serve as first slopes of the
    next step."""
    if not is_driven(con):
        return False
    return start.torque.low != end.torque.low or start.torque.high != end.torque.high


@static
def reached(con, clock, end, x, v):
    """The Clock at the end of a step with state (x, v): `end` as planned, with angle and speed if the speed is integrated."""
    if not is_driven(con):
        return end
    phase = _phase_reached(con, clock, x)
    c, s = cos_sin_at(phase)
    speed = speed_of(con.drive, v) / TWO_PI
    return Clock(end.hi, end.lo, phase, speed, 0.0, c, s, end.following, clock.torque, end.states)


@static
def settled(con, segment, clock, a):
    """The Clock for accelerations a: with an integrated speed, its rate and the torque line of the next step are set."""
    if not is_driven(con):
        return clock
    omega, rate = TWO_PI * clock.speed, speed_of(con.drive, a)
    line = line_at(segment.torque, omega, rate > 0.0)
    following, line = _between_knots(con, clock.following, omega, rate > 0.0, line)
    c = clock
    return Clock(c.hi, c.lo, c.phase, c.speed, rate / TWO_PI, c.cos, c.sin, following, line, c.states)


@static
def at_start(con, x):
    """Coordinates at the start of a step: the angle of an integrated speed, distances travelled by races and integrals of states
    are reset to zero."""
    fresh = without_integrals(con, x)
    if not is_driven(con):
        return without_ways(con.contacts, fresh)
    return without_ways(con.contacts, fresh - angle_of(con.drive, fresh) * con.drive.spin)


@inlined
def turn_of(clock):
    """The Turn at a Clock."""
    return turns_of(clock.cos, clock.sin, clock.speed, clock.speed_rate)


@inlined
def turns_after(clock, tau):
    """The Turns at times tau (a vector) after a Clock, each at most `Model.h_max`."""
    rate, speed = vec.spread(clock.speed_rate, tau), vec.spread(clock.speed, tau)
    angle = tau * vec.fma(tau, 0.5 * rate, speed)
    c, s = turned(vec.spread(clock.cos, tau), vec.spread(clock.sin, tau), angle)
    return turns_of(c, s, vec.fma(tau, rate, speed), clock.speed_rate)


@inlined
def turn_inside(clock, tau):
    """The Turn a time tau later."""
    return pick(turns_after(clock, vec.from_numbers((tau, tau), tau)), 0)


@static
def contact_turn(con, clock, tau, motion):
    """The Turn a time tau later, with state `motion` = (x, v), as far as the contact needs it: sine and cosine only with an
    eccentric ring."""
    if is_driven(con):
        return driven_turn(con, clock, motion[0], motion[1])
    if con.has_ring:
        return turn_inside(clock, tau)
    speed = clock.speed + clock.speed_rate * tau
    return Turn(1.0, 0.0, TWO_PI * speed, 0.0, 0.0, 0.0)


@inlined
def driven_turn(con, clock, x, v):
    """The Turn for an integrated speed at a state (x, v) within a step that started at a Clock."""
    return turn_at(con.drive, clock.cos, clock.sin, x, speed_of(con.drive, v))


@static
def speeds_after(con, clock, h, v, a):
    """(Hz, Hz/s) of the rotor speed a time h after a Clock, with velocities v and accelerations a."""
    if is_driven(con):
        return speed_of(con.drive, v) / TWO_PI, speed_of(con.drive, a) / TWO_PI
    return clock.speed + clock.speed_rate * h, clock.speed_rate
