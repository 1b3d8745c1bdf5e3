"""A drive that gives way: rotation angle and speed as two more states, integrated with the coordinates.

With u = U_e e^{i phi} and everything that acts on the rotor beside Omega' in the accelerations a_0,

    x'' = a_0 - i Omega' M^-1 u
    J Omega' = T(Omega) - mu sigma F_N d_R/2 - Im(conj(ring e^{i phi}) F_C) + Im(r^H D_i (r' - i Omega r))
               - Im(u^H r'') + Omega Re((u - u_0)^H r') + Im(w e^{-i phi})
    so that   Omega' = (what stands right, with a_0 for r'')/(J - u^H M^-1 u).

u_0 is the unbalance that phi'^2 multiplies, another one than u on an inclined disk only; w = U_e^H g is what gravity, the
acceleration g, has of its lever. The two states are the last pair of the kernel's vectors: (phi, 0) times `PackedDrive.size` in
x, phi counted from the step's start, and (Omega, 0) in v. So stages, errors and the motion inside a step are those of every other
coordinate. Inside a step the torque is one line a + b Omega; a step ends where
Omega leaves its interval between two knots.
"""

from typing import NamedTuple

from rsc.kernel.questions import is_array, is_driven, is_none, type_of
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.simd.static import static
from rsc.kernel.turn import TWO_PI, Turn, turned

# a step that leaves the interval of its torque is repeated, each time at least so long as before, until it ends within so many
# `switch_tol` behind the knot
CLOSER, CLOSE, MOST_TRIES = 0.1, 1.0, 12


class DriveData(NamedTuple):
    """A drive in a Model. Vectors (2n,) in modes per mass, as those of the Model."""

    unbalance: object  # U, m, multiplied by phi'^2
    euler: object  # U_e, m, multiplied by phi''
    spin: object  # `size` in the place of (phi, 0), else zeros
    tables: object  # (k, 3) knots of all torques one behind the other: rad/s, N m, and N m s slope up to the next knot
    begins: object  # (segments + 1,) the first knot of every segment's torque, and how many there are
    knots: object  # (k,) rad/s, speeds between which coefficients that follow the speed are lines, () without such
    mass: float  # kg, of the rotor's modes
    inertia: float  # kg m^2, J - u^H M^-1 u
    size: float  # m, of the state for an angle of 1 rad
    least: float  # rad/s, speeds below which their error counts as that of this speed
    weight: tuple  # N m, real and imaginary part of w, () without gravity or unbalance


class PackedDrive(NamedTuple):
    """The drive in Constants: vectors in registers."""

    unbalance: object
    i_unbalance: object
    euler: object
    i_euler: object
    spin: object
    knots: tuple  # (address, how many), () without
    mass: float
    inertia: float
    per_inertia: float
    size: float
    per_size: float
    least: float
    weight: tuple  # (real, imaginary part), () without


class TorqueLine(NamedTuple):
    """Torque a + b Omega, N m, between two speeds in rad/s."""

    a: float
    b: float
    low: float
    high: float


@static
def drive_of(data, width):
    """The PackedDrive of a DriveData, () of ()."""
    if is_none(data):
        return ()
    unbalance, euler = vec.load(data.unbalance, width), vec.load(data.euler, width)
    return PackedDrive(
        unbalance, vec.times_i(unbalance), euler, vec.times_i(euler), vec.load(data.spin, width), _knots_of(data.knots),
        data.mass, data.inertia, 1.0 / data.inertia, data.size, 1.0 / data.size, data.least, data.weight,
    )  # fmt: skip


@static
def _knots_of(knots):
    """(address, how many) of knots, () of none."""
    return (vec.address(knots), knots.shape[0]) if is_array(knots) else ()


@static
def torques_of(data):
    """Addresses of the knots and of the begins of every segment's, () without a drive."""
    return () if is_none(data) else (vec.address(data.tables), vec.address(data.begins))


@static
def torque_in(torques, i):
    """(address of the knots, first, one behind the last) of segment i, () without a drive."""
    if is_none(torques):
        return ()
    return torques[0], int(vec.number_at(torques[1], i)), int(vec.number_at(torques[1], i + 1))


@inlined
def line_at(table, omega, rising):
    """The TorqueLine of a segment's torque at a speed; at a knot the one above if the speed is `rising`, else the one below."""
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


@unrolled
def _last(vector):
    """The first number of a vector's last pair."""
    place = vector.width - 2
    return lambda vector: vec.lane(vector, place)


@inlined
def angle_of(drive, x):
    """The angle since the step's start, rad."""
    return drive.per_size * _last(x)


@inlined
def speed_of(drive, v):
    """Omega, rad/s, of velocities; of accelerations Omega'."""
    return drive.per_size * _last(v)


@inlined
def turn_at(drive, cos, sin, x, omega):
    """The Turn, as if Omega' were zero, at coordinates x and a speed, of a step from an angle with this cosine and sine."""
    turns = angle_of(drive, x) / TWO_PI
    start = vec.from_numbers((cos, cos), x), vec.from_numbers((sin, sin), x)
    cosines, sines = turned(start[0], start[1], vec.from_numbers((turns, turns), x))
    return steady(vec.lane(cosines, 0), vec.lane(sines, 0), omega)


@inlined
def steady(c, s, omega):
    """The Turn of a speed that does not change."""
    square = omega * omega
    return Turn(c, s, omega, square * c, square * s, 0.0)


@inlined
def _turned_by(vector, i_vector, turn):
    """A vector that turns with the rotor."""
    return vec.fma(turn.cos, vector, turn.sin * i_vector)


class Braked(NamedTuple):
    """What the contact does to the drive, times `Field.time`."""

    torque: float  # N m, mu sigma F_N d_R/2
    ring: float  # N m, Im(conj(ring e^{i phi}) F_C)


@static
def no_spin(con):
    """No work of the drive yet."""
    return vec.from_numbers((0.0, 0.0), con.stiffness) if is_driven(con) else ()


@static
def _weighed(weight, net, time, turn):
    """A torque, times `time`, with that of the weight."""
    if is_none(weight):
        return net
    return vec.fma(time, weight[1] * turn.cos - weight[0] * turn.sin, net)


@inlined
def spun(con, field, motion, turn, a, braked, turning):
    """(accelerations with unbalance and Omega', powers of the torque and of what friction brakes, Omega'), times field.time:
    motion = (x, v, ...), `a` without both; turning: torque of rotating damping, times field.time."""
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
    """Length of the step to try instead of an attempted one that left the interval of its torque; 0 to take it as it is."""
    return _until_knot(con, path.clock, path.step.v, path.h, tries) if is_driven(con) else 0.0


@inlined
def _until_knot(con, clock, v, h, tries):
    begin, end, line = TWO_PI * clock.speed, speed_of(con.drive, v), clock.torque
    knot = end
    if end < line.low or end > line.high:
        knot = line.low if end < line.low else line.high
    knot = max(knot, 0.0) if begin > 0.0 else knot  # a rotor that stops ends its run
    beyond = abs(end - knot)
    if tries >= MOST_TRIES or not beyond > CLOSE * con.switch_tol * con.drive.least:
        return 0.0
    # as good as straight; half of what is allowed behind it, so that the new step does not miss it by rounding
    share = (abs(knot - begin) + 0.5 * CLOSE * con.switch_tol * con.drive.least) / abs(end - begin)
    return h * min(max(share, CLOSER), 1.0 - 1e-9)


@static
def stands(con, v):
    """Whether a rotor whose speed is integrated has come to a stop."""
    return speed_of(con.drive, v) <= 0.0 if is_driven(con) else False


@unrolled
def mark_turns(con, base, row, phase, x, v):
    """Write angle (in turns, below one) and speed (Hz) of a sample in the last pair of its coordinates."""
    if not is_driven(con):
        return lambda con, base, row, phase, x, v: None
    place = type_of(con, "stiffness").width - 2

    def mark(con, base, row, phase, x, v):
        turns = phase + angle_of(con.drive, x) / TWO_PI
        vec.store_number(base, row + place, turns - float(int(turns)))
        vec.store_number(base, row + place + 1, speed_of(con.drive, v) / TWO_PI)

    return mark
