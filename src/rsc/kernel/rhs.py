"""The accelerations of all coordinates at one state, and the powers of the energy ledger there."""

from typing import NamedTuple

from rsc.kernel.contact import Law, direction, kinematics, motion, no_place
from rsc.kernel.losses import by_component, is_coupled, is_none
from rsc.kernel.simd import vec
from rsc.kernel.simd.fused import SUM, fused
from rsc.kernel.simd.hints import branched
from rsc.kernel.simd.jit import inlined, unrolled


class Powers(NamedTuple):
    """Powers at one instant, or sums of such: energies. Per lane and per unit modal mass, of the drive its `vec.product` only:
    what it acts on, the rotor or with skew or anisotropic springs both bodies, has vibration modes of one mass."""

    damping: object  # v * (-C v), m^2/s^3, with full matrices, else () (losses.py)
    drive: object  # product of v and (unbalance + load + skew and anisotropic springs)
    contact: float  # W, dissipated by the contact damper
    friction: float  # W, fed by friction into the lateral motion
    ring: float  # W, fed by the turning contact ring


@inlined
def no_powers():
    """No powers yet."""
    return Powers((), (), 0.0, 0.0, 0.0)


class Field(NamedTuple):
    """What the accelerations of one contact state need, multiplied by a time (the step length in the stages, 1 at their ends)."""

    time: float  # s
    stiffness: object
    damping: object
    law: Law


@inlined
def field(con, law, time):
    """The field scaled by a time."""
    stiffness, damping = _scaled(time, con.stiffness, con.damping)
    return Field(time, stiffness, damping, over_time(law, time))


@inlined
def field_itself(con, law):
    """The field as it is, for accelerations and powers."""
    return Field(1.0, con.stiffness, con.damping, law)


@fused(2)
def _scaled(time, stiffness, damping):
    return time * stiffness, time * damping


@inlined
def over_time(law, time):
    """The law whose force is an impulse."""
    return Law(time * law.k, time * law.b, law.mu, law.mu_slope)


@inlined
def contact_kinematics(con, x, v, turn):
    """Contact kinematics of a state."""
    return kinematics(con, vec.pair_sum(vec.product(con.contact_row, x)), vec.pair_sum(vec.product(con.contact_row, v)), turn)


@fused()
def _turned(real, unbalance, imag, i_unbalance, load):
    return vec.fma(real, unbalance, vec.fma(imag, i_unbalance, load))


@fused()
def _linear(stiffness, x, imposed, damping, v):
    return vec.fma(damping, v, vec.fma(stiffness, x, imposed))


@fused(over=[0])
def _pushed(a, push, force_row):
    return vec.fma(push[0], force_row * vec.fill(push[1], push[2], a), a)


@fused(1, only=[SUM])
def _powers(v, other, imposed):
    return v * other, vec.product(v, imposed)


@fused(1, over=[3], only=[SUM])
def _added(weight, v, other, damped, imposed):
    return vec.fma(weight * v, other, damped), vec.product(v, imposed)


@fused(2)
def _parts(motion, field, forces, turn, push):
    (x, v), (time, stiffness, damping), (unbalance, i_unbalance, load, force_row) = motion, field, forces
    imposed = time * _turned(turn[0], unbalance, turn[1], i_unbalance, load)
    return _pushed(_linear(stiffness, x, imposed, damping, v), push, force_row), imposed


@fused(over=[0])
def _alone(*arguments):
    return _parts(*arguments)[0]


def _driven(motion, *arguments):
    a, imposed = _parts(motion, *arguments)
    return a, vec.product(motion[1], imposed)


# of a state, and of a stage
_alone_driven, _stage_driven = fused(1, only=[SUM])(_driven), fused(1, over=[0], only=[SUM])(_driven)


@unrolled
def _sprung(con, time, x, imposed):
    """A force imposed with that of skew and anisotropic springs, whose work it is booked with."""
    if by_component(con):
        return lambda con, time, x, imposed: vec.fma(time, vec.times_components(con.columns[2], x), imposed)
    return lambda con, time, x, imposed: imposed


@unrolled
def _times_damping(con, v):
    """The matrix of the damping times the velocities."""
    times = vec.times_components if by_component(con) else vec.times_columns
    return lambda con, v: times(con.columns[0], v)


@inlined
def _parts_coupled(con, field, motion, turn, push):
    """With full matrices: (accelerations, force imposed, damping force), times field.time."""
    x, v, _ = motion
    imposed, damping = _sprung(con, field.time, x, field.time * _imposed(con, turn)), field.damping * v
    a = _linear(field.stiffness, x, imposed, field.damping, v)
    if con.columns[0] != 0:
        others = _times_damping(con, v)
        a, damping = vec.fma(field.time, others, a), vec.fma(field.time, others, damping)
    if con.columns[1] != 0:
        a = vec.fma(field.time * turn.omega, vec.times_i(vec.times_columns(con.columns[1], v)), a)
    return _pushed(a, push, con.force_row), imposed, damping


@inlined
def _uncoupled(con, field, motion, turn, push):
    """Every coordinate by itself and no Euler term, which only gyroscopics have: one walk where vectors are in memory."""
    inner, forces = (field.time, field.stiffness, field.damping), (con.unbalance, con.i_unbalance, con.load, con.force_row)
    return (motion[0], motion[1]), inner, forces, (turn.real, turn.imag), push


def _uncoupled_with_powers(con, field, motion, turn, push, weight, work):
    a, drive = _alone_driven(*_uncoupled(con, field, motion, turn, push))
    return a, (), drive


def _uncoupled_driven(con, field, motion, turn, push, weight, work):
    arguments = _uncoupled(con, field, motion, turn, push)
    if weight == 0.0:
        return _alone(*arguments), (), work.drive
    a, drive = _stage_driven(*arguments)
    return a, (), vec.fma(weight, drive, work.drive)


def _coupled(con, field, motion, turn, push, weight, work):
    """With full matrices."""
    a, imposed, damping = _parts_coupled(con, field, motion, turn, push)
    a = vec.moved(motion[0], a)
    if weight == 0.0:
        return a, work.damping, work.drive
    damped, drive = _added(weight, motion[1], damping, work.damping, imposed)
    return a, damped, vec.fma(weight, drive, work.drive)


def _coupled_with_powers(con, field, motion, turn, push, weight, work):
    """With full matrices, where nothing has been added up yet."""
    a, imposed, damping = _parts_coupled(con, field, motion, turn, push)
    return a, *_powers(motion[1], damping, imposed)


@unrolled
def _accelerated(con, field, motion, turn, push, weight, work):
    """(field.time * x'', the vectors of `work` with weight * field.time * powers added), `push` from the contact."""
    none_yet = is_none(work[work.fields.index("drive")])
    if is_coupled(con):
        return _coupled_with_powers if none_yet else _coupled
    return _uncoupled_with_powers if none_yet else _uncoupled_driven


@inlined
def _imposed(con, turn):
    """Unbalance with its run-up term, and the constant load, per unit mass."""
    f = _turned(turn.real, con.unbalance, turn.imag, con.i_unbalance, con.load)
    if con.has_euler:
        f = vec.fma(turn.omega_dot * turn.sin, con.euler, vec.fma(-turn.omega_dot * turn.cos, con.i_euler, f))
    return f


@inlined
def place_at(con, law, d, turn):
    """Place of the contact where it presses, from the `vec.product` of contact row and x.

    Apart from the accelerations because x of a stage is known a stage before v: root and division are begun that much sooner.
    """
    if not law.k > 0.0:
        return no_place()
    return direction(con, vec.pair_sum(d), turn)


@inlined
def accelerations(con, field, state, turn, place, weight, work):
    """(field.time * x'', `work` with weight * field.time * powers added) at a state (x, v, `vec.product` of contact row and v)
    inside one contact state.

    With work, vectors that lie in memory take that of x, which a stage needs no more; `no_powers` leaves x alone.
    """
    lost, fed, ring = work.contact, work.friction, work.ring
    counts = weight != 0.0  # known while compiling
    law, push = field.law, (0.0, 0.0, 0.0)
    if law.k > 0.0:
        rates = motion(con, vec.pair_sum(state[2]), place, turn)
        # F_N/|d| = k (1 - gap/|d|) + b (d . d')/|d|^2: one product and sum after 1/|d|, and one after the product d . d'
        per_length = vec.fma(-(law.k * con.gap), place.inverse, law.k)
        if law.b > 0.0:
            # only here does the force wait for the velocity: a branch, so that the processor need not while pressing
            damper = law.b * place.inverse * place.inverse
            per_length = vec.fma(damper, rates.along, per_length)
            if counts:
                lost = vec.fma(weight, damper * rates.along * rates.along, lost)
        mu = law.mu
        if law.mu_slope > 0.0:  # never negative; one branch, where != takes two
            # a branch for the same reason
            mu = mu + branched(law.mu_slope) * rates.slip
        g_y, g_z = place.d_y - mu * place.d_z, place.d_z + mu * place.d_y
        # mu F_N v_t with F_N/|d| = per_length and v_t = Im(d' conj d)/|d|
        if counts:
            fed = vec.fma(mu * per_length, -weight * rates.cross, fed)
        if counts and con.has_ring:
            torque = per_length * (g_z * place.ring_y - g_y * place.ring_z)
            ring = vec.fma(weight * turn.omega, torque, ring)
        push = per_length, g_y, g_z
    a, damped, driven = _accelerated(con, field, state, turn, push, weight, work)
    return a, Powers(damped, driven, lost, fed, ring)
