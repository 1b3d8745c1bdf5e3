"""The accelerations of all coordinates at one state, and the powers of the energy ledger there."""

from typing import NamedTuple

from rsc.kernel import vec
from rsc.kernel.cases import choose, sized, some
from rsc.kernel.contact import Kinematics, Law, direction, kinematics, motion, no_kinematics
from rsc.kernel.fused import fused
from rsc.kernel.hints import branched
from rsc.kernel.jit import inlined, unrolled


class Powers(NamedTuple):
    """Powers at one instant, or sums of such: energies. The vectors are per lane and per unit modal mass."""

    damping: object  # v * (-C v), m^2/s^3
    drive: object  # v * (unbalance + load)
    contact: float  # W, dissipated by the contact damper
    friction: float  # W, fed by friction into the lateral motion
    ring: float  # W, fed by the turning contact ring


@inlined
def no_powers(like, driven, number):
    """Zero powers with vectors and numbers like those given."""
    none = vec.spread(0.0, number)
    return Powers(vec.spread(0.0, like), vec.spread(0.0, driven), none, none, none)


class Field(NamedTuple):
    """What the accelerations of one mode need, multiplied by a time (the step length in the stages, 1 at their ends)."""

    time: float  # s
    stiffness: object
    damping: object
    law: Law


@inlined
def field(con, law, time):
    """The field scaled by a time."""
    return Field(
        time,
        time * con.stiffness,
        time * con.damping,
        Law(time * law.k, time * law.b, law.mu, law.mu_slope),
    )


@inlined
def contact_kinematics(con, x, v, turn):
    """Contact kinematics of a state."""
    return kinematics(con, vec.pair_sum(vec.product(con.contact_row, x)), vec.pair_sum(vec.product(con.contact_row, v)), turn)


@fused()
def _turned(real, unbalance, imag, i_unbalance, load):
    return vec.fma(real, unbalance, vec.fma(imag, i_unbalance, load))


@fused(2)
def _scaled(time, imposed, damping, v):
    return time * imposed, damping * v


@fused()
def _linear(stiffness, x, imposed, damping):
    return vec.fma(stiffness, x, imposed) + damping


@fused(over=[0])
def _pushed(a, per_length, force_row, g_y, g_z):
    return vec.fma(per_length, force_row * vec.fill(g_y, g_z, a), a)


@fused(2, over=[3, 5])
def _added(weight, v, damping, damped, imposed, driven):
    return vec.fma(weight, v * damping, damped), vec.fma(weight, sized(v, imposed) * imposed, driven)


@fused()
def _alone(motion, field, forces, turn):
    (x, v), (time, stiffness, damping) = motion, field
    imposed, damping = _scaled(time, _turned(turn[0], forces[0], turn[1], forces[1], forces[2]), damping, v)
    return _linear(stiffness, x, sized(imposed, x), damping)


@fused(3, over=[None, 11, 12])
def _alone_at_work(motion, field, forces, turn, work):
    (x, v), (time, stiffness, damping), (weight, damped, driven) = motion, field, work
    imposed, damping = _scaled(time, _turned(turn[0], forces[0], turn[1], forces[1], forces[2]), damping, v)
    damped, driven = _added(weight, v, damping, damped, imposed, driven)
    return _linear(stiffness, x, sized(imposed, x), damping), damped, driven


def _uncoupled(con, field, motion, turn, weight, work):
    """Every coordinate by itself and no Euler term, which only gyroscopics have: one walk where vectors are in memory."""
    inner, forces = (field.time, field.stiffness, field.damping), (con.unbalance, con.i_unbalance, con.load)
    turned = turn.real, turn.imag
    if weight == 0.0:
        return _alone(motion, inner, forces, turned), work.damping, work.drive
    return _alone_at_work(motion, inner, forces, turned, (weight, work.damping, work.drive))


def _coupled(con, field, motion, turn, weight, work):
    """With full matrices of damping or gyroscopics."""
    x, v = motion
    imposed, damping = _scaled(field.time, _imposed(con, turn), field.damping, v)
    if con.columns[0] != 0:
        damping = vec.fma(field.time, vec.times_columns(con.columns[0], v), damping)
    a = _linear(field.stiffness, x, sized(imposed, x), damping)
    if con.columns[1] != 0:
        a = vec.fma(field.time * turn.omega, vec.times_i(vec.times_columns(con.columns[1], v)), a)
    if weight == 0.0:
        return a, work.damping, work.drive
    return a, *_added(weight, v, damping, work.damping, imposed, work.drive)


@unrolled
def _without_contact(con, field, motion, turn, weight, work):
    """(field.time * x'' without contact, the vectors of `work` with weight * field.time * powers added) of motion = (x, v)."""
    return _coupled if len(con[con.fields.index("columns")]) else _uncoupled


@inlined
def _imposed(con, turn):
    """Unbalance with its run-up term, and the constant load, per unit mass."""
    f = _turned(turn.real, con.unbalance, turn.imag, con.i_unbalance, con.load)
    if con.has_euler:
        f = vec.fma(turn.omega_dot * turn.sin, con.euler, vec.fma(-turn.omega_dot * turn.cos, con.i_euler, f))
    return f


@inlined
def place_at(con, law, x, turn):
    """Place of the contact where it presses.

    Apart from the accelerations because x of a stage is known a stage before v: root and division are begun that much sooner.
    """
    none = vec.spread(0.0, law.k)
    if not some(law.k > 0.0):
        return no_kinematics(none).place
    mark = vec.mark(x)
    place = direction(con, vec.pair_sum(vec.product(con.contact_row, x)), turn)
    vec.release(x, mark)
    return place


@inlined
def accelerations(con, field, x, v, turn, place, weight, work):
    """(field.time * x'', contact kinematics where the contact presses, `work` with weight * field.time * powers added) at a state
    inside one contact mode."""
    a, damped, driven = _without_contact(con, field, (x, v), turn, weight, work)
    lost, fed, ring = work.contact, work.friction, work.ring
    counts = weight != 0.0  # known while compiling
    law = field.law
    pressed = law.k > 0.0
    if not some(pressed):
        return a, no_kinematics(vec.spread(0.0, law.k)), Powers(damped, driven, lost, fed, ring)
    rates = motion(con, vec.pair_sum(vec.product(con.contact_row, v)), place, turn)
    # F_N/|d| = k (1 - gap/|d|) + b (d . d')/|d|^2: one product and sum after 1/|d|, and one after the product d . d'
    per_length = vec.fma(-(law.k * con.gap), place.inverse, law.k)
    separating = law.b > 0.0
    if some(separating):
        # only here does the force wait for the velocity: a branch, so that the processor need not while pressing
        damper = law.b * place.inverse * place.inverse
        per_length = choose(separating, vec.fma(damper, rates.along, per_length), per_length)
        if counts:
            lost = choose(separating, vec.fma(weight * law.b, rates.rate * rates.rate, lost), lost)
    mu = law.mu
    creeping = law.mu_slope > 0.0  # never negative; one branch, where != takes two
    if some(creeping):
        # a branch for the same reason
        mu = choose(creeping, mu + branched(law.mu_slope) * rates.slip, mu)
    g_y, g_z = place.d_y - mu * place.d_z, place.d_z + mu * place.d_y
    a = choose(pressed, _pushed(a, per_length, con.force_row, g_y, g_z), a)
    # mu F_N v_t with F_N/|d| = per_length and v_t = Im(d' conj d)/|d|
    if counts:
        fed = choose(pressed, vec.fma(mu * per_length, -weight * rates.cross, fed), fed)
    if counts and con.has_ring:
        torque = per_length * (g_z * place.ring_y - g_y * place.ring_z)
        ring = choose(pressed, vec.fma(weight * turn.omega, torque, ring), ring)
    return a, Kinematics(place, rates), Powers(damped, driven, lost, fed, ring)
