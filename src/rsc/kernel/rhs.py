"""The accelerations of all coordinates at one state, and the powers of the energy ledger there."""

from typing import NamedTuple

from rsc.kernel import springs
from rsc.kernel.contact import Kinematics, StateLaw, direction, kinematics, motion, no_place, place_anyhow
from rsc.kernel.drive import Braked, no_spin, spun
from rsc.kernel.questions import (
    by_component,
    damping_follows,
    follows,
    has_no_sums,
    is_coupled,
    is_driven,
    is_none,
    is_one,
    rotates,
    type_of,
)
from rsc.kernel.race import surface_of, torque_of, with_race
from rsc.kernel.simd import vec
from rsc.kernel.simd.hints import branched
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.simd.static import static


class Powers(NamedTuple):
    """Powers at one instant, or sums of such: energies. Per lane and per unit modal mass, of the drive its `vec.product` only:
    what it acts on, the rotor or with skew or anisotropic springs both bodies, has vibration modes of one mass."""

    damping: object  # v * (-C v), m^2/s^3, with full matrices, else () (losses.py)
    drive: object  # product of v and (unbalance + load + skew and anisotropic springs)
    contact: tuple  # W, dissipated by the damper of each contact
    friction: tuple  # W, fed by the friction of each into the lateral motion
    ring: tuple  # W, fed by the turning ring of each
    rotating: object  # fed by the drive through rotating damping, per unit mass, m^2/s^3; of a scene without ()
    following: object  # fed by a stiffness that follows the speed, alike
    spin: object  # of a drive a pair, W: of its torque, and of friction that brakes it; () of a prescribed speed


@unrolled
def no_powers(con):
    """No powers yet."""
    rotating, following = (0.0 if has(con) else () for has in (rotates, follows))
    none = (0.0,) * len(type_of(con, "contacts"))
    return lambda con: Powers((), (), none, none, none, rotating, following, no_spin(con))


class Field(NamedTuple):
    """What the accelerations of one contact state need, multiplied by a time (the step length in the stages, 1 at their ends)."""

    time: float  # s
    stiffness: object
    damping: object
    laws: tuple  # a `StateLaw` for each contact
    following: tuple  # addresses of the matrices that follow the speed, `clock.Segment`
    torque: tuple  # `clock.Clock`


@inlined
def field_itself(con, laws, clock):
    """The field as it is, for accelerations and powers; clock: of the segment."""
    return Field(1.0, con.stiffness, con.damping, laws, clock.following, clock.torque)


@static
def over_time(laws, time):
    """The laws whose forces are impulses."""
    if is_none(laws):
        return ()
    law = laws[0]
    return (StateLaw(springs.times(law.spring, time), time * law.b, law.mu, law.mu_slope),) + over_time(laws[1:], time)


@inlined
def kinematics_at(contact, x, v, turn):
    """Kinematics of one contact in a state."""
    d, d_dot = vec.product(contact.contact_row, x), vec.product(contact.contact_row, v)
    return kinematics(contact, vec.pair_sum(d), vec.pair_sum(d_dot), surface_of(contact, v), turn)


@static
def contact_kinematics(contacts, x, v, turn):
    """Kinematics of every contact in a state."""
    if is_none(contacts):
        return ()
    return (kinematics_at(contacts[0], x, v, turn),) + contact_kinematics(contacts[1:], x, v, turn)


@static
def rows_times(contacts, x):
    """`vec.product` of every contact's row and a vector."""
    if is_none(contacts):
        return ()
    return (vec.product(contacts[0].contact_row, x),) + rows_times(contacts[1:], x)


@inlined
def _unbalance_and_load(con, turn):
    return vec.fma(turn.real, con.unbalance, vec.fma(turn.imag, con.i_unbalance, con.load))


@inlined
def _linear(field, x, imposed, v):
    return vec.fma(field.damping, v, vec.fma(field.stiffness, x, imposed))


@static
def _pushed(a, pushes, contacts):
    """Accelerations with the forces of all contacts."""
    if is_none(contacts):
        return a
    push = pushes[0]
    a = vec.fma(push[0], contacts[0].force_row * vec.fill(push[1], push[2], a), a)
    a = with_race(contacts[0], push[3], a)
    return _pushed(a, pushes[1:], contacts[1:])


@static
def _fed_by_speed(con, field, turn, product):
    """What springs feed that follow the speed, times field.time; of an integrated speed over its Omega', which is known last."""
    if is_driven(con):
        return -0.5 * product
    return -0.5 * field.time * turn.omega_dot * product


@static
def _sprung(con, field, x, imposed, turn):
    """(a force imposed with that of skew, anisotropic and following springs, whose work it is booked with; what a stiffness that
    follows the speed feeds, 1/2 Omega' x^H K_b x, times field.time, () without)."""
    if follows(con):
        by_speed = vec.times_components(field.following[1], x)
        force = vec.fma(turn.omega, by_speed, vec.times_components(field.following[0], x))
        y, z = vec.pair_sum(vec.product(x, by_speed))  # negated, as all stiffness in the kernel
        return vec.fma(field.time, force, imposed), _fed_by_speed(con, field, turn, y + z)
    if by_component(con):
        return vec.fma(field.time, vec.times_components(con.columns[2], x), imposed), ()
    return imposed, ()


@static
def _damped(con, field, v, turn, a, damping):
    """(accelerations, damping force), times field.time, with what the matrix of the damping adds."""
    if damping_follows(field):
        by_speed = vec.times_components(field.following[3], v)
        others = vec.fma(turn.omega, by_speed, vec.times_components(field.following[2], v))
        return vec.fma(field.time, others, a), vec.fma(field.time, others, damping)
    # the address of a matrix that is absent is the constant 0, and its branch is gone when compiled
    if con.columns[0] != 0:
        others = vec.times_components(con.columns[0], v) if by_component(con) else vec.times_columns(con.columns[0], v)
        a, damping = vec.fma(field.time, others, a), vec.fma(field.time, others, damping)
    return a, damping


class Turned(NamedTuple):
    """What rotating damping does, times field.time: its force on a motion whose velocity is `slide` beside the rotor and
    `carried` with it."""

    force: object
    slide: object
    carried: object


@static
def _turned(con, field, motion, turn):
    """The `Turned` of a state, () without rotating damping."""
    if not rotates(con):
        return ()
    carried = turn.omega * vec.times_i(motion[0])
    slide = motion[1] - carried
    return Turned(-field.time * vec.times_columns(con.rotating[0], slide), slide, carried)


@static
def _added(turned, a):
    """Accelerations with the force of a `Turned`."""
    return a if is_none(turned) else a + turned.force


@static
def _lost(turned, weight, damping):
    """Sum of the dampers' powers with those of a `Turned`: taken from the motion beside the rotor."""
    return damping if is_none(turned) else vec.fma(weight * turned.slide, turned.force, damping)


@static
def _fed(turned, weight, rotating):
    """Sum of what the drive feeds through a `Turned`."""
    if is_none(turned):
        return rotating
    y, z = vec.pair_sum(vec.product(turned.carried, turned.force))
    return vec.fma(weight, y + z, rotating)


@inlined
def _parts_coupled(con, field, motion, turn, pushes):
    """With full matrices: (accelerations, force imposed, damping force, `Turned`, what following springs feed), times
    field.time."""
    x, v, _ = motion
    imposed, following = _sprung(con, field, x, field.time * imposed_at(con, turn), turn)
    a, damping = _damped(con, field, v, turn, _linear(field, x, imposed, v), field.damping * v)
    if con.columns[1] != 0:
        a = vec.fma(field.time * turn.omega, vec.times_i(vec.times_columns(con.columns[1], v)), a)
    turned = _turned(con, field, motion, turn)
    return _pushed(_added(turned, a), pushes, con.contacts), imposed, damping, turned, following


@static
def with_share(part, power, total):
    """total + part * power, of what a scene does not have ()."""
    return total if is_none(total) else vec.fma(part, power, total)


@static
def _followed(con, weight, following, total):
    """Sum of what following springs feed; of an integrated speed as it is until its Omega' is known."""
    return following if is_driven(con) else with_share(weight, following, total)


@static
def _uncoupled(con, field, motion, turn, pushes, weight, work):
    """`_accelerated` where every coordinate stands by itself; no Euler term either, which only gyroscopics have."""
    x, v, _ = motion
    imposed = field.time * _unbalance_and_load(con, turn)
    a = _pushed(_linear(field, x, imposed, v), pushes, con.contacts)
    if has_no_sums(work):
        return a, (), vec.product(v, imposed), (), ()
    if weight == 0.0:
        return a, (), work.drive, (), ()
    return a, (), vec.fma(weight, vec.product(v, imposed), work.drive), (), ()


@static
def _coupled(con, field, motion, turn, pushes, weight, work):
    """`_accelerated` with full matrices."""
    v = motion[1]
    a, imposed, damping, turned, following = _parts_coupled(con, field, motion, turn, pushes)
    if has_no_sums(work):
        damped, driven = _lost(turned, 1.0, v * damping), vec.product(v, imposed)
        return a, damped, driven, _fed(turned, 1.0, work.rotating), following
    if weight == 0.0:
        return a, work.damping, work.drive, work.rotating, work.following
    damped = _lost(turned, weight, vec.fma(weight * v, damping, work.damping))
    driven = vec.fma(weight, vec.product(v, imposed), work.drive)
    return a, damped, driven, _fed(turned, weight, work.rotating), _followed(con, weight, following, work.following)


@static
def _accelerated(con, field, motion, turn, pushes, weight, work):
    """(field.time * x'', the vectors of `work` with weight * field.time * powers added), `pushes` from the contacts; where `work`
    has no sums yet the powers of this state alone."""
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
    """(accelerations with what a drive adds, `work.spin` with weight times its powers, `work.following`); parts = accelerations,
    Braked, what following springs feed."""
    a, braked, following = parts
    if not is_driven(con):
        return a, (), following
    a, powers, rate = spun(con, field, motion, turn, a, braked, _turning(con, field, motion, turn))
    if weight == 0.0:
        return a, work.spin, work.following
    return a, vec.fma(weight, powers, work.spin), _times_rate(following, weight * rate, work.following)


@static
def _times_rate(following, rate, total):
    """total + rate * following, () without springs that follow the speed."""
    return () if is_none(following) else vec.fma(rate, following, total)


@static
def places_at(contacts, laws, d, turn):
    """Places of the contacts that press, from the `vec.product` of their rows and x.

    Apart from the accelerations because x of a stage is known a stage before v: root and division are begun that much sooner.
    """
    if is_none(contacts):
        return ()
    place = direction(contacts[0], vec.pair_sum(d[0]), turn) if laws[0].spring.k > 0.0 else no_place()
    return (place,) + places_at(contacts[1:], laws[1:], d[1:], turn)


@static
def places_anyhow(contacts, d, turn):
    """Places of all contacts, from the `vec.product` of their rows and x."""
    if is_none(contacts):
        return ()
    return (place_anyhow(contacts[0], vec.pair_sum(d[0]), turn),) + places_anyhow(contacts[1:], d[1:], turn)


@static
def motions(contacts, v, d_dot, places, turn):
    """Kinematics of all contacts, from v and the `vec.product` of their rows and v."""
    if is_none(contacts):
        return ()
    own = motion(contacts[0], vec.pair_sum(d_dot[0]), surface_of(contacts[0], v), places[0], turn)
    return (Kinematics(places[0], own),) + motions(contacts[1:], v, d_dot[1:], places[1:], turn)


@static
def _braked(contact, place, mu, per_length, pushed):
    """How a contact with F_N/|d| = per_length and F_C = per_length pushed brakes a drive, times field.time."""
    if not is_driven(contact):
        return Braked(0.0, 0.0)
    ring = place.ring_y * pushed[1] - place.ring_z * pushed[0] if contact.has_ring else 0.0
    return Braked(mu * per_length * place.distance * contact.surfaces.radius, per_length * ring)


@inlined
def _pushed_by(contact, law, place, v, d_dot, turn, weight, sums):
    """((F_N/|d|, g, `torque_of` a race) with F_C = g F_N/|d|, sums (lost, fed, ring) with weight * powers added, Braked) of one
    contact, times field.time."""
    (lost, fed, ring), counts = sums, weight != 0.0  # known while compiling
    push, braked = (0.0, 0.0, 0.0, torque_of(contact, 0.0)), Braked(0.0, 0.0)
    if law.spring.k > 0.0:
        rates = motion(contact, vec.pair_sum(d_dot), surface_of(contact, v), place, turn)
        # F_N/|d| = F/|d| + b (d . d')/|d|^2, of which the second waits for the product d . d'
        per_length = springs.share(law.spring, place, contact.gap)
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
        if counts and contact.has_ring:
            torque = per_length * (g_z * place.ring_y - g_y * place.ring_z)
            ring = vec.fma(weight * turn.omega, torque, ring)
        braked = _braked(contact, place, mu, per_length, (g_y, g_z))
        # (1 + i mu) d F_N/|d|, whose product is left to the packed vectors
        push = per_length, g_y, g_z, torque_of(contact, mu * per_length * place.distance)
    return push, (lost, fed, ring), braked


@static
def _pushed_by_all(contacts, laws, places, v, d_dot, turn, weight, sums):
    """(pushes, lost, fed, ring, Braked) of all contacts, see `_pushed_by`; sums = (lost, fed, ring), tuples."""
    if is_none(contacts):
        return (), (), (), (), Braked(0.0, 0.0)
    own = sums[0][0], sums[1][0], sums[2][0]
    push, (lost, fed, ring), braked = _pushed_by(contacts[0], laws[0], places[0], v, d_dot[0], turn, weight, own)
    behind = sums[0][1:], sums[1][1:], sums[2][1:]
    others = _pushed_by_all(contacts[1:], laws[1:], places[1:], v, d_dot[1:], turn, weight, behind)
    both = braked if is_one(contacts) else Braked(braked.torque + others[4].torque, braked.ring + others[4].ring)
    return (push,) + others[0], (lost,) + others[1], (fed,) + others[2], (ring,) + others[3], both


@inlined
def accelerations(con, field, state, turn, places, weight, work):
    """(field.time * x'', `work` with weight * field.time * powers added) at a state (x, v, `rows_times` of v) inside one state of
    the contacts."""
    sums = work.contact, work.friction, work.ring
    pushes, lost, fed, ring, braked = _pushed_by_all(con.contacts, field.laws, places, state[1], state[2], turn, weight, sums)
    a, damped, driven, rotating, following = _accelerated(con, field, state, turn, pushes, weight, work)
    a, spin, following = _spun(con, field, state, turn, (a, braked, following), weight, work)
    return a, Powers(damped, driven, lost, fed, ring, rotating, following, spin)
