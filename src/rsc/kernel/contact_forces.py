"""All contacts of a state: their kinematics, the forces that they push with, and the powers of these."""

from rsc.kernel import springs
from rsc.kernel.contact import Kinematics, StateLaw, direction, kinematics, motion, no_place, place_anyhow
from rsc.kernel.drive import Braked
from rsc.kernel.questions import is_driven, is_none, is_one
from rsc.kernel.race import surface_of, torque_of, with_race
from rsc.kernel.simd import vec
from rsc.kernel.simd.hints import branched
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import static


@static
def over_time(laws, time):
    """The laws with forces multiplied by a time."""
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


@static
def with_pushes(a, pushes, contacts):
    """Add the forces of all contacts to accelerations."""
    if is_none(contacts):
        return a
    push = pushes[0]
    a = vec.fma(push[0], contacts[0].force_row * vec.fill(push[1], push[2], a), a)
    a = with_race(contacts[0], push[3], a)
    return with_pushes(a, pushes[1:], contacts[1:])


@static
def places_at(contacts, laws, d, turn):
    """Places of the closed contacts, from the `vec.product` of their rows and x.

    Separate from the accelerations, since x of a stage is known one stage before v: root and division start that much earlier.
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
    rates = motion(contacts[0], vec.pair_sum(d_dot[0]), surface_of(contacts[0], v), places[0], turn)
    return (Kinematics(places[0], rates),) + motions(contacts[1:], v, d_dot[1:], places[1:], turn)


@static
def _braked(contact, place, mu, per_length, pushed):
    """Braking torques on a drive of a contact with F_N/|d| = per_length and F_C = per_length pushed, times field.time."""
    if not is_driven(contact):
        return Braked(0.0, 0.0)
    ring = place.ring_y * pushed[1] - place.ring_z * pushed[0] if contact.has_ring else 0.0
    return Braked(mu * per_length * place.distance * contact.surfaces.radius, per_length * ring)


@inlined
def _pushed_by(contact, law, place, v, d_dot, turn, weight, sums):
    """((F_N/|d|, g, `torque_of` a race) with F_C = g F_N/|d|, sums (lost, fed, ring) with weight * powers added, Braked) for one
    contact, times field.time."""
    (lost, fed, ring), counts = sums, weight != 0.0  # known at compile time
    push, braked = (0.0, 0.0, 0.0, torque_of(contact, 0.0)), Braked(0.0, 0.0)
    if law.spring.k > 0.0:
        rates = motion(contact, vec.pair_sum(d_dot), surface_of(contact, v), place, turn)
        # F_N/|d| = F/|d| + b (d . d')/|d|^2, only the second term waits for the product d . d'
        per_length = springs.share(law.spring, place, contact.gap)
        if law.b > 0.0:
            # only here does the force depend on the velocity: a branch spares the processor the wait in the undamped state
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
        # F_C = (1 + i mu) d F_N/|d| is multiplied out later, on packed vectors
        push = per_length, g_y, g_z, torque_of(contact, mu * per_length * place.distance)
    return push, (lost, fed, ring), braked


@static
def pushed_by_all(contacts, laws, places, v, d_dot, turn, weight, sums):
    """(pushes, lost, fed, ring, Braked) of all contacts, see `_pushed_by`; sums = (lost, fed, ring), tuples."""
    if is_none(contacts):
        return (), (), (), (), Braked(0.0, 0.0)
    first = sums[0][0], sums[1][0], sums[2][0]
    push, (lost, fed, ring), braked = _pushed_by(contacts[0], laws[0], places[0], v, d_dot[0], turn, weight, first)
    remaining = sums[0][1:], sums[1][1:], sums[2][1:]
    others = pushed_by_all(contacts[1:], laws[1:], places[1:], v, d_dot[1:], turn, weight, remaining)
    both = braked if is_one(contacts) else Braked(braked.torque + others[4].torque, braked.ring + others[4].ring)
    return (push,) + others[0], (lost,) + others[1], (fed,) + others[2], (ring,) + others[3], both
