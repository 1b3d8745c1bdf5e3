"""Torque-limited drive: rotation angle and speed as two additional states, integrated with the coordinates.

With u = U_e e^{i phi} and the accelerations a_0 without the terms in Omega',

    x'' = a_0 - i Omega' M^-1 u
    J Omega' = T(Omega) - mu sigma F_N d_R/2 - Im(conj(ring e^{i phi}) F_C) + Im(r^H D_i (r' - i Omega r))
               - Im(u^H r'') + Omega Re((u - u_0)^H r') + Im(w e^{-i phi})
    so that   Omega' = (right-hand side with a_0 for r'')/(J - u^H M^-1 u).

u_0 is the unbalance multiplied by phi'^2, different from u only for an inclined disk; w = U_e^H g with gravity g is the torque of
the weight. The two states are the last pair of the kernel's vectors: (phi, 0) times `Drive.size` in x, with phi counted from the
start of the step, and (Omega, 0) in v. Stages, error estimate and dense output treat them like any other coordinate. Within a
step the torque is a line a + b Omega; a step ends where Omega leaves the interval between two knots of the torque curve.
"""

from typing import NamedTuple

from rsc.kernel.questions import is_array, is_driven, is_none
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import static
from rsc.kernel.turn import TWO_PI, Turn, turned

# a step that leaves its torque interval is repeated, shortened at most by CLOSER, until it ends within CLOSE times
# `switch_tol` beyond the knot
CLOSER, CLOSE, MOST_TRIES = 0.1, 1.0, 12


class DriveData(NamedTuple):
    """A drive in a Model; vectors (2n,) in modes per mass, like those of the Model."""

    unbalance: object  # U, m, multiplied by phi'^2
    euler: object  # U_e, m, multiplied by phi''
    spin: object  # `size` at the entry of phi, else zero
    tables: object  # (k, 3) knots of all torque curves, concatenated: rad/s, N m, and slope to the next knot, N m s
    begins: object  # (segments + 1,) index of the first knot of each segment's curve, then their total number
    knots: object  # (k,) rad/s, knots of the speed-dependent coefficients, () if all are constant
    mass: float  # kg, reference mass of the rotor modes
    inertia: float  # kg m^2, J - u^H M^-1 u
    size: float  # m, value of the state at an angle of 1 rad
    least: float  # rad/s, errors of lower speeds are measured relative to this one
    weight: tuple  # N m, real and imaginary part of w, () without gravity or unbalance


class PackedDrive(NamedTuple):
    """The drive in Constants: vectors as registers."""

    unbalance: object
    i_unbalance: object
    euler: object
    i_euler: object
    spin: object
    knots: tuple  # (address, number), () if absent
    mass: float
    inertia: float
    per_inertia: float
    size: float
    per_size: float
    least: float
    weight: tuple  # (real, imaginary part), () if absent


class TorqueLine(NamedTuple):
    """Torque a + b Omega, N m, between two speeds in rad/s."""

    a: float
    b: float
    low: float
    high: float


@static
def drive_of(data, width):
    """The PackedDrive of a DriveData; () for ()."""
    if is_none(data):
        return ()
    unbalance, euler = vec.load(data.unbalance, width), vec.load(data.euler, width)
    return PackedDrive(
        unbalance, vec.times_i(unbalance), euler, vec.times_i(euler), vec.load(data.spin, width), _knots_of(data.knots),
        data.mass, data.inertia, 1.0 / data.inertia, data.size, 1.0 / data.size, data.least, data.weight,
    )  # fmt: skip


@static
def _knots_of(knots):
    """(address, number) of knots; () if there are none."""
    return (vec.address(knots), knots.shape[0]) if is_array(knots) else ()


@static
def torques_of(data):
    """Addresses of `DriveData.tables` and `DriveData.begins`; () without a drive."""
    return () if is_none(data) else (vec.address(data.tables), vec.address(data.begins))


@static
def torque_in(torques, i):
    """(address of the knots, first index, end index) of segment i; () without a drive."""
    if is_none(torques):
        return ()
    return torques[0], int(vec.number_at(torques[1], i)), int(vec.number_at(torques[1], i + 1))


@inlined
def line_at(table, omega, rising):
    """The TorqueLine of a segment's torque at a speed; at a knot the one above if the speed is rising, else the one below."""
    base, first, end = table
    i = first
    while i < end and (vec.number_at(base, 3 * i) < omega or (rising and vec.number_at(base, 3 * i) == omega)):
        i += 1
    low = vec.number_at(base, 3 * i - 3) if i > first else -1e300
    high = vec.number_at(base, 3 * i) if i < end else 1e300
    if i == first:
        return TorqueLine(vec.number_at(base, 3 * i + 1), 0.0, low, high)
    slope = vec.number_at(base, 3 * i - 1)
    return TorqueLine(vec.number_at(base, 3 * i - 2) - slope * low, slope, low, high)


@inlined
def _last(vector):
    """First component of the last pair of a vector."""
    return vec.lane(vector, vec.width_of(vector) - 2)


@inlined
def angle_of(drive, x):
    """Rotation angle since the start of the step, rad."""
    return drive.per_size * _last(x)


@inlined
def speed_of(drive, v):
    """Omega in rad/s from velocities, Omega' from accelerations."""
    return drive.per_size * _last(v)


@inlined
def turn_at(drive, cos, sin, x, omega):
    """The Turn (with Omega' = 0) at coordinates x and a speed in a step that started at an angle with this cosine and sine."""
    turns = angle_of(drive, x) / TWO_PI
    start = vec.from_numbers((cos, cos), x), vec.from_numbers((sin, sin), x)
    cosines, sines = turned(start[0], start[1], vec.from_numbers((turns, turns), x))
    return steady(vec.lane(cosines, 0), vec.lane(sines, 0), omega)


@inlined
def steady(c, s, omega):
    """The Turn at constant speed."""
    square = omega * omega
    return Turn(c, s, omega, square * c, square * s, 0.0)


@inlined
def _turned_by(vector, i_vector, turn):
    """A vector rotating with the rotor."""
    return vec.fma(turn.cos, vector, turn.sin * i_vector)


class Braked(NamedTuple):
    """Braking torques of the contact on the rotor, times `Field.time`."""

    torque: float  # N m, mu sigma F_N d_R/2
    ring: float  # N m, Im(conj(ring e^{i phi}) F_C)


@static
def no_spin(con):
    """Initial value (zero) of the sums of the drive's work."""
    return vec.from_numbers((0.0, 0.0), con.stiffness) if is_driven(con) else ()


@static
def _weighed(weight, net, time, turn):
    """Add the torque of the weight, times `time`, to a net torque."""
    if is_none(weight):
        return net
    return vec.fma(time, weight[1] * turn.cos - weight[0] * turn.sin, net)


@inlined
def spun(con, field, motion, turn, a, braked, turning):
    """(accelerations including unbalance and Omega', powers of drive torque and friction torque, Omega'), times field.time.

    motion = (x, v, ...); `a`: accelerations without unbalance and Omega'; turning: torque of rotating damping, times field.time.
    """
    drive, line = con.drive, field.torque
    v, time = motion[1], field.time
    a = vec.fma(time * turn.real, drive.unbalance, vec.fma(time * turn.imag, drive.i_unbalance, a))
    across = _turned_by(drive.i_euler, -1.0 * drive.euler, turn)  # i u
    y, z = vec.pair_sum(vec.product(across, a))  # Im(u^H a)
    torque = vec.fma(line.b, turn.omega, line.a)
    net = vec.fma(time, torque, turning - braked.torque - braked.ring) - drive.mass * (y + z)
    if con.has_euler:
        more = _turned_by(con.euler, con.i_euler, turn)  # u - u_0
        y, z = vec.pair_sum(vec.product(more, v))
        net = vec.fma(drive.mass * time * turn.omega, y + z, net)
    rate = _weighed(drive.weight, net, time, turn) * drive.per_inertia
    powers = vec.from_numbers((time * torque * turn.omega, braked.torque * turn.omega), a)
    return vec.fma(rate, drive.spin - across, a), powers, rate


@static
def until_knot(con, path, tries):
    """Length for repeating an attempted step that left its torque interval; 0 to accept the step."""
    return _until_knot(con, path.clock, path.step.v, path.h, tries) if is_driven(con) else 0.0


@inlined
def _until_knot(con, clock, v, h, tries):
    begin, end, line = TWO_PI * clock.speed, speed_of(con.drive, v), clock.torque
    knot = end
    if end < line.low or end > line.high:
        knot = line.low if end < line.low else line.high
    knot = max(knot, 0.0) if begin > 0.0 else knot  # a run ends where the rotor stops
    beyond = abs(end - knot)
    if tries >= MOST_TRIES or not beyond > CLOSE * con.switch_tol * con.drive.least:
        return 0.0
    # Omega is nearly linear in time; aim half the allowed distance beyond the knot, so that rounding does not leave it short
    share = (abs(knot - begin) + 0.5 * CLOSE * con.switch_tol * con.drive.least) / abs(end - begin)
    return h * min(max(share, CLOSER), 1.0 - 1e-9)


@static
def stands(con, v):
    """Whether a rotor with integrated speed has stopped."""
    return speed_of(con.drive, v) <= 0.0 if is_driven(con) else False


@static
def mark_turns(con, base, row, phase, x, v):
    """Write angle (turns, modulo one) and speed (Hz) into the last pair of a sample's coordinates."""
    if not is_driven(con):
        return
    turns, place = phase + angle_of(con.drive, x) / TWO_PI, row + vec.width_of(x) - 2
    vec.store_number(base, place, turns - float(int(turns)))
    vec.store_number(base, place + 1, speed_of(con.drive, v) / TWO_PI)
