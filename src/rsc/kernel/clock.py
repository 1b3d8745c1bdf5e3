"""Where a run is: time without drift, rotation in turns, and the segment of the speed schedule."""

from typing import NamedTuple

from rsc.kernel.drive import TorqueLine, angle_of, line_at, speed_of, torque_in, torques_of, turn_at
from rsc.kernel.model import following_of
from rsc.kernel.questions import follows, is_driven, is_none
from rsc.kernel.race import without_ways
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import question, static
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
    torque: tuple  # the `drive.TorqueLine` of the step that starts here, () of a prescribed speed


class Segment(NamedTuple):
    """One straight piece of the speed schedule."""

    begin: float  # s
    end: float
    speed: float  # Hz at its begin
    speed_rate: float  # Hz/s
    # where coefficients follow the speed, addresses of the matrices (K_a, K_b) or (K_a, K_b, B_a, B_b) of K_a + Omega K_b between
    # the two knots that the segment lies between; () elsewhere
    following: tuple
    torque: tuple  # `drive.torque_in`


class Corners(NamedTuple):
    """The speed schedule, of which passed knots are corners: addresses of times in s and speeds in Hz, how many there are."""

    time: int
    speed: int
    count: int
    following: tuple  # `model.following_of`
    torque: tuple  # `drive.torques_of`


@inlined
def corners_of(model):
    """The schedule of a model."""
    following = following_of(model.following_stiffness, model.following_damping, model.corner_interval)
    times, speeds, count = vec.address(model.corner_time), vec.address(model.corner_speed), model.corner_time.shape[0]
    return Corners(times, speeds, count, following, torques_of(model.drive))


@static
def _matrices_of(following, i):
    """`Segment.following` of segment i."""
    return () if is_none(following) else _matrices_in(following, int(vec.number_at(following[0], i)))


@question
def _stiffness_alone(following):
    """Whether of coefficients that follow the speed, `model.following_of`, there are those of stiffness only."""
    return len(following) == 3


@static
def _matrices_in(following, interval):
    """`Segment.following` of an interval between knots."""
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
    return Segment(t0, t1, f0, rate, _matrices_of(corners.following, i), torque_in(corners.torque, i))


@inlined
def clock_at(segment, hi, lo, phase):
    """The clock at a time and phase."""
    speed = segment.speed + segment.speed_rate * ((hi - segment.begin) + lo)
    c, s = cos_sin_at(phase)
    return Clock(hi, lo, phase, speed, segment.speed_rate, c, s, segment.following, ())


@inlined
def _later(clock, h):
    """(hi, lo) a time h later; time is summed in two parts, so that a long run does not drift."""
    # Knuth's exact sum: lo holds what the rounding of hi + h lost
    hi = clock.hi + h
    part = hi - clock.hi
    lo = clock.lo + ((clock.hi - (hi - part)) + (h - part))
    top = hi + lo
    return top, lo - (top - hi)


@inlined
def ahead(segment, clock, h):
    """The clock a step later, of a prescribed speed."""
    hi, lo = _later(clock, h)
    phase = clock.phase + (clock.speed + 0.5 * clock.speed_rate * h) * h
    return clock_at(segment, hi, lo, phase - float(int(phase)))


@static
def _between_knots(con, following, omega, rising, line):
    """(`Segment.following`, TorqueLine) at an integrated speed: of the interval between two knots, in which a step stays; at a
    knot the one above if the speed is `rising`, else the one below."""
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
    """The clock at a time and phase, where the velocities are v."""
    if not is_driven(con):
        return clock_at(segment, hi, lo, phase)
    omega = speed_of(con.drive, v)
    c, s = cos_sin_at(phase)
    following, line = _between_knots(con, segment.following, omega, True, line_at(segment.torque, omega, True))
    return Clock(hi, lo, phase, omega / TWO_PI, 0.0, c, s, following, line)


@static
def planned(con, segment, clock, h):
    """The clock a step of length h later, ending at the latest at the segment's end; of an integrated speed its time only."""
    if not is_driven(con):
        end = ahead(segment, clock, h)
        if h >= (segment.end - clock.hi) - clock.lo:
            end = clock_at(segment, segment.end, 0.0, end.phase)
        return end
    hi, lo = _later(clock, h)
    if h >= (segment.end - clock.hi) - clock.lo:
        hi, lo = segment.end, 0.0
    return Clock(hi, lo, clock.phase, clock.speed, 0.0, clock.cos, clock.sin, clock.following, clock.torque)


@inlined
def _phase_reached(con, clock, x):
    phase = clock.phase + angle_of(con.drive, x) / TWO_PI
    return phase - float(int(phase))


@inlined
def angle_reached(con, clock, x):
    """The Turn of an integrated speed at the end of a step from a clock to coordinates x, sine and cosine only."""
    c, s = cos_sin_at(_phase_reached(con, clock, x))
    return Turn(c, s, 0.0, 0.0, 0.0, 0.0)


@static
def passed_knot(con, start, end):
    """Whether a step from one clock to another has left the interval of its torque and coefficients, so that its last slopes are
    not those from which the next one starts."""
    if not is_driven(con):
        return False
    return start.torque.low != end.torque.low or start.torque.high != end.torque.high


@static
def reached(con, clock, end, x, v):
    """The clock at a step's end where the state is (x, v): the one `planned`, of an integrated speed with its angle and speed."""
    if not is_driven(con):
        return end
    phase = _phase_reached(con, clock, x)
    c, s = cos_sin_at(phase)
    speed = speed_of(con.drive, v) / TWO_PI
    return Clock(end.hi, end.lo, phase, speed, 0.0, c, s, end.following, clock.torque)


@static
def settled(con, segment, clock, a):
    """The clock of a state with the accelerations a: of an integrated speed with its rate and the torque of what follows."""
    if not is_driven(con):
        return clock
    omega, rate = TWO_PI * clock.speed, speed_of(con.drive, a)
    line = line_at(segment.torque, omega, rate > 0.0)
    following, line = _between_knots(con, clock.following, omega, rate > 0.0, line)
    return Clock(clock.hi, clock.lo, clock.phase, clock.speed, rate / TWO_PI, clock.cos, clock.sin, following, line)


@static
def at_start(con, x):
    """Coordinates where a step starts: an integrated speed's angle and the ways of races count from there."""
    if not is_driven(con):
        return without_ways(con.contacts, x)
    return without_ways(con.contacts, x - angle_of(con.drive, x) * con.drive.spin)


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


@static
def contact_turn(con, clock, tau, motion):
    """Rotation a time tau later, where the state is `motion` = (x, v), as far as the contact needs it: sine and cosine only for
    an eccentric ring."""
    if is_driven(con):
        return driven_turn(con, clock, motion[0], motion[1])
    if con.has_ring:
        return turn_inside(clock, tau)
    speed = clock.speed + clock.speed_rate * tau
    return Turn(1.0, 0.0, TWO_PI * speed, 0.0, 0.0, 0.0)


@inlined
def driven_turn(con, clock, x, v):
    """Rotation of an integrated speed at a state (x, v) of a step that started at a clock."""
    return turn_at(con.drive, clock.cos, clock.sin, x, speed_of(con.drive, v))


@static
def speeds_after(con, clock, h, v, a):
    """(Hz, Hz/s) a time h after a clock, where velocities and accelerations are v and a."""
    if is_driven(con):
        return speed_of(con.drive, v) / TWO_PI, speed_of(con.drive, a) / TWO_PI
    return clock.speed + clock.speed_rate * h, clock.speed_rate
