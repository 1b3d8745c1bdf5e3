"""Accelerations of all coordinates in a state, and powers for the energy ledger."""

from typing import NamedTuple

from rsc.kernel.contact_forces import pushed_by_all, with_pushes
from rsc.kernel.drive import no_spin, spun
from rsc.kernel.questions import (
    by_component,
    damping_follows,
    follows,
    has_no_sums,
    has_states,
    is_coupled,
    is_driven,
    is_none,
    rotates,
)
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import static
from rsc.kernel.states import controlled, fed_by_control, with_control


class Powers(NamedTuple):
    """Powers at one instant, or their sums, i.e. energies. Per lane and unit modal mass; of `drive` only its `vec.product`, since
    all modes it acts on (rotor, or both bodies with skew or anisotropic springs) have the same mass."""

    damping: object  # v * (-C v), m^2/s^3, with full matrices, else () (losses.py)
    drive: object  # product of v and (unbalance + load + skew and anisotropic springs)
    contact: tuple  # W, dissipated by the damper of each contact
    friction: tuple  # W, fed into the lateral motion by friction of each contact
    ring: tuple  # W, fed by the rotating eccentric ring of each contact
    rotating: object  # fed by the drive through rotating damping, per unit mass, m^2/s^3; () without it
    following: object  # fed by a speed-dependent stiffness, same units; () without it
    spin: object  # pair (drive torque, braking friction torque), W; () if the speed is prescribed
    control: object  # W, fed by first-order states; () without them


@static
def zero_of_each(contacts):
    """A zero for each contact."""
    return () if is_none(contacts) else (0.0,) + zero_of_each(contacts[1:])


@static
def no_powers(con):
    """Powers all zero, the start of a summation."""
    rotating = 0.0 if rotates(con) else ()
    following = 0.0 if follows(con) else ()
    control = 0.0 if has_states(con) else ()
    none = zero_of_each(con.contacts)
    return Powers((), (), none, none, none, rotating, following, no_spin(con), control)


class Field(NamedTuple):
    """Data for the accelerations in one contact state, times `time` (the step length in the stages, 1 at the end of a step)."""

    time: float  # s
    stiffness: object
    damping: object
    laws: tuple  # a `StateLaw` for each contact
    following: tuple  # addresses of the speed-dependent matrices, see `clock.Segment`
    torque: tuple  # `clock.Clock`
    states: tuple  # `clock.Segment`


@inlined
def field_itself(con, laws, clock):
    """The Field with time = 1, for accelerations and powers themselves."""
    return Field(1.0, con.stiffness, con.damping, laws, clock.following, clock.torque, clock.states)


@inlined
def _unbalance_and_load(con, turn):
    return vec.fma(turn.real, con.unbalance, vec.fma(turn.imag, con.i_unbalance, con.load))


@inlined
def _linear(field, x, imposed, v):
    return vec.fma(field.damping, v, vec.fma(field.stiffness, x, imposed))


@static
def _fed_by_speed(con, field, turn, product):
    """Power fed by speed-dependent springs, times field.time; with an integrated speed per Omega', which is not yet known."""
    if is_driven(con):
        return -0.5 * product
    return -0.5 * field.time * turn.omega_dot * product


@static
def _sprung(con, field, x, imposed, turn):
    """(imposed force plus that of skew, anisotropic and speed-dependent springs, with whose work it is booked; power fed by a
    speed-dependent stiffness, 1/2 Omega' x^H K_b x times field.time, () without one)."""
    if follows(con):
        by_speed = vec.times_components(field.following[1], x)
        force = vec.fma(turn.omega, by_speed, vec.times_components(field.following[0], x))
        y, z = vec.pair_sum(vec.product(x, by_speed))  # negative, like all stiffness in the kernel
        return vec.fma(field.time, force, imposed), _fed_by_speed(con, field, turn, y + z)
    if by_component(con):
        return vec.fma(field.time, vec.times_components(con.columns[2], x), imposed), ()
    return imposed, ()


@static
def _damped(con, field, v, turn, a, damping):
    """(accelerations, damping force), times field.time, including the full damping matrix."""
    if damping_follows(field):
        by_speed = vec.times_components(field.following[3], v)
        others = vec.fma(turn.omega, by_speed, vec.times_components(field.following[2], v))
        return vec.fma(field.time, others, a), vec.fma(field.time, others, damping)
    # the address of an absent matrix is the constant 0, so that the compiler removes its branch
    if con.columns[0] != 0:
        others = vec.times_components(con.columns[0], v) if by_component(con) else vec.times_columns(con.columns[0], v)
        a, damping = vec.fma(field.time, others, a), vec.fma(field.time, others, damping)
    return a, damping


class Turned(NamedTuple):
    """Force of rotating damping, times field.time, and the velocity that it acts on, split into `slide`, relative to the rotor,
    and `carried`, with the rotor."""

    force: object
    slide: object
    carried: object


@static
def _turned(con, field, motion, turn):
    """The Turned of a state; () without rotating damping."""
    if not rotates(con):
        return ()
    carried = turn.omega * vec.times_i(motion[0])
    slide = motion[1] - carried
    return Turned(-field.time * vec.times_columns(con.rotating[0], slide), slide, carried)


@static
def _added(turned, a):
    """Add the force of a Turned to accelerations."""
    return a if is_none(turned) else a + turned.force


@static
def _lost(turned, weight, damping):
    """Add the power dissipated by rotating damping, on the motion relative to the rotor, to that of the dampers."""
    return damping if is_none(turned) else vec.fma(weight * turned.slide, turned.force, damping)


@static
def _fed(turned, weight, rotating):
    """Add the power that the drive feeds through rotating damping."""
    if is_none(turned):
        return rotating
    y, z = vec.pair_sum(vec.product(turned.carried, turned.force))
    return vec.fma(weight, y + z, rotating)


@inlined
def _parts_coupled(con, field, motion, turn, pushes):
    """With full matrices: (accelerations, imposed force, damping force, Turned, power fed by speed-dependent springs,
    StateForces), times field.time."""
    x, v, _ = motion
    imposed, following = _sprung(con, field, x, field.time * imposed_at(con, turn), turn)
    a, damping = _damped(con, field, v, turn, _linear(field, x, imposed, v), field.damping * v)
    if con.columns[1] != 0:
        a = vec.fma(field.time * turn.omega, vec.times_i(vec.times_columns(con.columns[1], v)), a)
    turned, control = _turned(con, field, motion, turn), controlled(con, field, x, v)
    a = with_control(control, _added(turned, a))
    return with_pushes(a, pushes, con.contacts), imposed, damping, turned, following, control


@static
def with_share(part, power, total):
    """total + part * power; () if the scene lacks the feature."""
    return total if is_none(total) else vec.fma(part, power, total)


@static
def _followed(con, weight, following, total):
    """Add the power fed by speed-dependent springs; with an integrated speed left as it is until Omega' is known."""
    return following if is_driven(con) else with_share(weight, following, total)


@static
def _uncoupled(con, field, motion, turn, pushes, weight, work):
    """`_accelerated` for uncoupled coordinates; without the Euler term, which occurs only with gyroscopics."""
    x, v, _ = motion
    imposed = field.time * _unbalance_and_load(con, turn)
    a = with_pushes(_linear(field, x, imposed, v), pushes, con.contacts)
    if has_no_sums(work):
        return a, (), vec.product(v, imposed), (), (), ()
    if weight == 0.0:
        return a, (), work.drive, (), (), ()
    return a, (), vec.fma(weight, vec.product(v, imposed), work.drive), (), (), ()


@static
def _coupled(con, field, motion, turn, pushes, weight, work):
    """`_accelerated` with full matrices."""
    v = motion[1]
    a, imposed, damping, turned, following, control = _parts_coupled(con, field, motion, turn, pushes)
    if has_no_sums(work):
        damped, driven = _lost(turned, 1.0, v * damping), vec.product(v, imposed)
        return a, damped, driven, _fed(turned, 1.0, work.rotating), following, fed_by_control(control, 1.0, work.control)
    if weight == 0.0:
        return a, work.damping, work.drive, work.rotating, work.following, work.control
    fed = fed_by_control(control, weight, work.control)
    damped = _lost(turned, weight, vec.fma(weight * v, damping, work.damping))
    driven = vec.fma(weight, vec.product(v, imposed), work.drive)
    followed = _followed(con, weight, following, work.following)
    return a, damped, driven, _fed(turned, weight, work.rotating), followed, fed


@static
def _accelerated(con, field, motion, turn, pushes, weight, work):
    """(field.time * x'', vectors of `work` with weight * field.time * powers added); `pushes` from the contacts. If `work` has no
    sums, the powers of this state alone."""
    if is_coupled(con):
        return _coupled(con, field, motion, turn, pushes, weight, work)
    return _uncoupled(con, field, motion, turn, pushes, weight, work)


@inlined
def imposed_at(con, turn):
    """Unbalance with its run-up term, and the constant load, per unit mass."""
    f = _unbalance_and_load(con, turn)
    if con.has_euler:
        f = vec.fma(turn.omega_dot * turn.sin, con.euler, vec.fma(-turn.omega_dot * turn.cos, con.i_euler, f))
    return f


@static
def forces_beside(con, field, x, v, turn, imposed):
    """(all that acts but the coordinates' own springs and dampers, what of it is no damper, what is booked as put in), per mass,
    where `imposed_at` is known."""
    if not is_coupled(con):
        return imposed, imposed, imposed
    put_in, _ = _sprung(con, field, x, imposed, turn)
    held = put_in
    if con.columns[1] != 0:
        held = vec.fma(turn.omega, vec.times_i(vec.times_columns(con.columns[1], v)), held)
    force, _ = _damped(con, field, v, turn, held, held)
    return force, held, put_in


@static
def _turning(con, field, motion, turn):
    """Torque of rotating damping on a drive, N m times field.time: Im(r^H D_i (r' - i Omega r))."""
    if not rotates(con):
        return 0.0
    y, z = vec.pair_sum(vec.product(vec.times_i(motion[0]), _turned(con, field, motion, turn).force))
    return -con.drive.mass * (y + z)


@static
def _spun(con, field, motion, turn, parts, weight, work):
    """(accelerations including the drive's part, `work.spin` with weight times its powers, `work.following`); parts =
    (accelerations, Braked, power fed by speed-dependent springs)."""
    a, braked, following = parts
    if not is_driven(con):
        return a, (), following
    a, powers, rate = spun(con, field, motion, turn, a, braked, _turning(con, field, motion, turn))
    if weight == 0.0:
        return a, work.spin, work.following
    return a, vec.fma(weight, powers, work.spin), _times_rate(following, weight * rate, work.following)


@static
def _times_rate(following, rate, total):
    """total + rate * following; () without speed-dependent springs."""
    return () if is_none(following) else vec.fma(rate, following, total)


@inlined
def accelerations(con, field, state, turn, places, weight, work):
    """(field.time * x'', `work` with weight * field.time * powers added) in a state (x, v, `rows_times` of v), within one
    contact state."""
    sums = work.contact, work.friction, work.ring
    pushes, lost, fed, ring, braked = pushed_by_all(con.contacts, field.laws, places, state[1], state[2], turn, weight, sums)
    a, damped, driven, rotating, following, control = _accelerated(con, field, state, turn, pushes, weight, work)
    a, spin, following = _spun(con, field, state, turn, (a, braked, following), weight, work)
    return a, Powers(damped, driven, lost, fed, ring, rotating, following, spin, control)
