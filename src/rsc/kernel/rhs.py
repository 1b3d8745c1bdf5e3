"""The accelerations of all coordinates at one state, and the powers of the energy ledger there."""

import math
from typing import NamedTuple

from rsc.kernel import vec
from rsc.kernel.contact import kinematics, normal_force
from rsc.kernel.jit import inlined

TWO_PI = 2.0 * math.pi


class Turn(NamedTuple):
    """Rotation of the shaft at one instant."""

    cos: float  # of phi
    sin: float
    omega: float  # phi', rad/s
    omega_dot: float  # phi'', rad/s^2


class Powers(NamedTuple):
    """Powers at one instant; the vectors are per lane and per unit modal mass."""

    damping: object  # v * (-C v), m^2/s^3
    drive: object  # v * (unbalance + load)
    contact: float  # W, dissipated by the contact damper and the clip
    friction: float  # W, fed by friction into the lateral motion
    ring: float  # W, fed by the turning contact ring


@inlined
def small_rotation(delta):
    """(cos, sin) of an angle: Taylor series to full precision up to 1 rad, the library beyond."""
    if abs(delta) > 1.0:
        return math.cos(delta), math.sin(delta)
    q = delta * delta
    c = 1.0 / 20922789888000.0 - q / 6402373705728000.0
    c = -1.0 / 87178291200.0 + q * c
    c = 1.0 / 479001600.0 + q * c
    c = -1.0 / 3628800.0 + q * c
    c = 1.0 / 40320.0 + q * c
    c = -1.0 / 720.0 + q * c
    c = 1.0 / 24.0 + q * c
    c = -0.5 + q * c
    s = -1.0 / 1307674368000.0 + q / 355687428096000.0
    s = 1.0 / 6227020800.0 + q * s
    s = -1.0 / 39916800.0 + q * s
    s = 1.0 / 362880.0 + q * s
    s = -1.0 / 5040.0 + q * s
    s = 1.0 / 120.0 + q * s
    s = -1.0 / 6.0 + q * s
    return 1.0 + q * c, delta + delta * (q * s)


@inlined
def turn_at(phase, speed, speed_rate):
    """Rotation at a phase in turns, speed in Hz and its rate in Hz/s, by the library's sine and cosine."""
    phi = TWO_PI * phase
    return Turn(math.cos(phi), math.sin(phi), TWO_PI * speed, TWO_PI * speed_rate)


@inlined
def turn_ahead(turn, tau):
    """Rotation a time tau after `turn`, by a small rotation instead of new library calls."""
    c, s = small_rotation((turn.omega + 0.5 * turn.omega_dot * tau) * tau)
    return Turn(
        turn.cos * c - turn.sin * s,
        turn.sin * c + turn.cos * s,
        turn.omega + turn.omega_dot * tau,
        turn.omega_dot,
    )


@inlined
def contact_kinematics(con, x, v, turn):
    """Contact kinematics of a state."""
    return kinematics(con, vec.pair_sum(con.contact_row * x), vec.pair_sum(con.contact_row * v), turn)


@inlined
def _imposed(con, turn):
    """Unbalance with its run-up term, and the constant load, per unit mass."""
    square = turn.omega * turn.omega
    real = square * turn.cos + turn.omega_dot * turn.sin
    imag = square * turn.sin - turn.omega_dot * turn.cos
    f = vec.fma(real, con.unbalance, vec.fma(imag, con.i_unbalance, con.load))
    return vec.fma(turn.omega_dot * turn.sin, con.euler, vec.fma(-turn.omega_dot * turn.cos, con.i_euler, f))


@inlined
def accelerations(con, columns, law, x, v, turn):
    """(x'', powers) at a state inside one contact mode."""
    imposed = _imposed(con, turn)
    damping = con.damping * v
    if columns[0].shape[0] > 0:
        damping = damping + vec.times_columns(columns[0], v)
    a = vec.fma(con.stiffness, x, imposed) + damping
    if columns[1].shape[0] > 0:
        a = vec.fma(turn.omega, vec.times_i(vec.times_columns(columns[1], v)), a)
    lost, fed, ring = 0.0, 0.0, 0.0
    if law.k > 0.0 or law.b > 0.0:
        kin = contact_kinematics(con, x, v, turn)
        force = normal_force(law, kin)
        mu = law.mu + law.mu_slope * kin.slip
        per_length = force * kin.inverse
        f_y = per_length * (kin.d_y - mu * kin.d_z)
        f_z = per_length * (kin.d_z + mu * kin.d_y)
        a = vec.fma(con.force_row, vec.fill(f_y, f_z, x), a)
        lost = law.b * kin.rate * kin.rate
        fed = -mu * force * kin.tangential
        ring = _ring_power(con, f_y, f_z, turn)
    return a, Powers(v * damping, v * imposed, lost, fed, ring)


@inlined
def _ring_power(con, f_y, f_z, turn):
    """Power of the drive that turns an eccentric contact ring: Re(F_C conj(i Omega ecc e^{i phi}))."""
    ring_y = turn.cos * con.ring_y - turn.sin * con.ring_z
    ring_z = turn.cos * con.ring_z + turn.sin * con.ring_y
    return turn.omega * (f_z * ring_y - f_y * ring_z)
