"""Accumulation over a run: energy ledger, counters, samples."""

from typing import NamedTuple

from rsc.kernel import springs
from rsc.kernel.clock import contact_turn
from rsc.kernel.contact import CLIPPED, OPEN, normal_force
from rsc.kernel.contact_forces import kinematics_at
from rsc.kernel.dense import dense_of, interpolate
from rsc.kernel.drive import mark_turns
from rsc.kernel.model import (
    CONTACT_TIME,
    COUNT_OF_CONTACT,
    E_BRAKED,
    E_CONTACT,
    E_CONTROL,
    E_DRIVE,
    E_FOLLOWING,
    E_FRICTION,
    E_ROTATING,
    E_TORQUE,
    LIMITED,
    N_COUNT,
    N_REAL,
    ONSETS,
    REAL_OF_CONTACT,
    REJECTED,
    RELEASES,
    RHS_CALLS,
    STEPS,
    STIFF,
    SWITCHES,
)
from rsc.kernel.questions import follows, has_states, is_driven, is_none, is_one, rotates
from rsc.kernel.race import mark_races
from rsc.kernel.rhs import Powers
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import static
from rsc.kernel.states import as_sampled

PER_REAL, PER_COUNT = len(REAL_OF_CONTACT), len(COUNT_OF_CONTACT)


class Tally(NamedTuple):
    """Sums over the accepted steps."""

    work: object  # Powers integrated, `contact` including what clipping the force dissipates
    contact_times: tuple  # s, of each contact
    steps: int
    rejected: int
    switches: int
    onsets: tuple  # of each contact
    releases: tuple
    limited: int  # steps near the stability limit since stiffness was last judged
    stiff: int  # 1 + normal state in which the run was found stiff, 0 if not


@static
def _load_rotating(con, real):
    """Work through rotating damping so far; () without it."""
    return real[E_ROTATING] if rotates(con) else ()


@static
def _load_following(con, real):
    """Work of speed-dependent coefficients so far; () without them."""
    return real[E_FOLLOWING] if follows(con) else ()


@static
def _load_control(con, real):
    """Work of first-order states so far; () without them."""
    return real[E_CONTROL] if has_states(con) else ()


@static
def _put_back(real, i, energy):
    """Store one energy in Work.real; nothing for ()."""
    if is_none(energy):
        return
    real[i] = energy


@static
def _load_spin(con, real):
    """Work of the drive torque and of the braking torque so far; () if the speed is prescribed."""
    if not is_driven(con):
        return ()
    return vec.from_numbers((real[E_TORQUE], real[E_BRAKED]), con.stiffness)


@static
def _put_spin_back(real, energies):
    """Store the works of `_load_spin` in Work.real."""
    if is_none(energies):
        return
    real[E_TORQUE], real[E_BRAKED] = vec.lane(energies, 0), vec.lane(energies, 1)


@static
def _stored(contacts, numbers, first, behind, size):
    """One entry of every contact from Work.real or Work.count: that of the first contact is at index `first`, those of the others
    start at `behind`, spaced by `size`."""
    if is_none(contacts):
        return ()
    return (numbers[first],) + _stored(contacts[1:], numbers, behind, behind + size, size)


@static
def _store(values, numbers, first, behind, size):
    """Store one entry of every contact, see `_stored`."""
    if is_none(values):
        return
    numbers[first] = values[0]
    _store(values[1:], numbers, behind, behind + size, size)


@inlined
def load_tally(con, work, width):
    """The Tally of a run so far."""
    real, count, each = work.real, work.count, con.contacts
    damping, drive = vec.load(work.ledger_damping, width), vec.load_product(work.ledger_input, width)
    rotating, following = _load_rotating(con, real), _load_following(con, real)
    lost, fed = _stored(each, real, E_CONTACT, N_REAL + 1, PER_REAL), _stored(each, real, E_FRICTION, N_REAL + 2, PER_REAL)
    ring = _stored(each, real, E_DRIVE, N_REAL + 3, PER_REAL)
    return Tally(
        Powers(damping, drive, lost, fed, ring, rotating, following, _load_spin(con, real), _load_control(con, real)),
        _stored(each, real, CONTACT_TIME, N_REAL, PER_REAL),
        count[STEPS],
        count[REJECTED],
        count[SWITCHES],
        _stored(each, count, ONSETS, N_COUNT + 2, PER_COUNT),
        _stored(each, count, RELEASES, N_COUNT + 3, PER_COUNT),
        count[LIMITED],
        count[STIFF],
    )


@inlined
def store_tally(work, tally, calls):
    """Store the sums; steps made `calls` calls of the right-hand side, and each switch one more."""
    real, count, before = work.real, work.count, tally.work
    count[RHS_CALLS] += calls + tally.switches - count[SWITCHES]
    vec.store(work.ledger_damping, before.damping)
    vec.store(work.ledger_input, before.drive)
    _store(before.contact, real, E_CONTACT, N_REAL + 1, PER_REAL)
    _store(before.friction, real, E_FRICTION, N_REAL + 2, PER_REAL)
    _store(before.ring, real, E_DRIVE, N_REAL + 3, PER_REAL)
    _put_back(real, E_ROTATING, before.rotating)
    _put_back(real, E_FOLLOWING, before.following)
    _put_back(real, E_CONTROL, before.control)
    _put_spin_back(real, before.spin)
    _store(tally.contact_times, real, CONTACT_TIME, N_REAL, PER_REAL)
    count[STEPS], count[REJECTED], count[SWITCHES] = tally.steps, tally.rejected, tally.switches
    _store(tally.onsets, count, ONSETS, N_COUNT + 2, PER_COUNT)
    _store(tally.releases, count, RELEASES, N_COUNT + 3, PER_COUNT)
    count[LIMITED], count[STIFF] = tally.limited, tally.stiff


@static
def _losses(contacts, each, lost, kins, kins_new):
    """Energy dissipated by each contact, including spring energy that is released without force while clipped."""
    if is_none(contacts):
        return ()
    total = lost[0]
    if each[0].normal == CLIPPED:
        p_0, p_1 = kins[0].place.penetration, max(kins_new[0].place.penetration, 0.0)
        total += springs.power(contacts[0].surfaces.spring, p_0, p_1)
    return (total,) + _losses(contacts[1:], each[1:], lost[1:], kins[1:], kins_new[1:])


@static
def _times(each, times, h):
    """Contact times after a step."""
    if is_none(each):
        return ()
    return (times[0] + h if each[0].normal != OPEN else times[0],) + _times(each[1:], times[1:], h)


@inlined
def book(con, tally, work, contacts, kins, h):
    """The sums after an accepted step: work done up to its end, and contact times; kins = kinematics of the contacts at its start
    and end."""
    lost = _losses(con.contacts, contacts.each, work.contact, kins[0], kins[1])
    times = _times(contacts.each, tally.contact_times, h)
    limited = tally.limited + 1 if h > contacts.near_limit else tally.limited
    counts = (tally.steps + 1, tally.rejected, tally.switches, tally.onsets, tally.releases, limited, tally.stiff)
    w = work
    sums = Powers(w.damping, w.drive, lost, w.friction, w.ring, w.rotating, w.following, w.spin, w.control)
    return Tally(sums, times, *counts)


@inlined
def book_flight(tally, damping, drive):
    """The sums after a block of flight, in which the dampers took and the drive gave these; stability does not hold it, so that a
    look for stiffness begins anew."""
    t, w = tally, tally.work
    damping, drive = w.damping + damping, w.drive + drive
    sums = Powers(damping, drive, w.contact, w.friction, w.ring, w.rotating, w.following, w.spin, w.control)
    return Tally(sums, t.contact_times, t.steps + 1, t.rejected, t.switches, t.onsets, t.releases, 0, t.stiff)


@inlined
def end_window(tally, stiff):
    """The Tally after stiffness was judged."""
    t = tally
    counts = (t.steps, t.rejected, t.switches, t.onsets, t.releases, 0, stiff)
    return Tally(t.work, t.contact_times, *counts)


@inlined
def count_rejected(tally):
    """The Tally after one more rejected attempt."""
    t = tally
    counts = (t.steps, t.rejected + 1, t.switches, t.onsets, t.releases, t.limited, t.stiff)
    return Tally(t.work, t.contact_times, *counts)


@static
def _begun(each, new, counts):
    """Counts of contact onsets, plus those between two contact states."""
    if is_none(each):
        return ()
    more = 1 if each[0].normal == OPEN and new[0].normal != OPEN else 0
    return (counts[0] + more,) + _begun(each[1:], new[1:], counts[1:])


@inlined
def count_switch(tally, inside, each, new):
    """Count a switch, unless the step ended inside its state (at a corner of the schedule), with onsets and releases; each, new:
    the Contact of each contact before and after it."""
    t, switches = tally, tally.switches + (0 if inside else 1)
    onsets, releases = _begun(each, new, t.onsets), _begun(new, each, t.releases)
    return Tally(t.work, t.contact_times, t.steps, t.rejected, switches, onsets, releases, t.limited, t.stiff)


class SampleRows(NamedTuple):
    """Destination of samples, one row each: x, v if it is saved, and for every contact normal force, friction force, tangential
    velocity."""

    base: int  # address of the first row
    columns: int  # numbers in a row
    velocities: int  # offset of v in a row, 0 if velocities are not saved
    forces: int  # offset of the contact forces in a row
    first: int  # number of the first sample
    rows: int  # samples that fit


@static
def _save_forces(contacts, laws, base, at, state, turn):
    """Write normal force, friction force and tangential velocity of every contact in a state (x, v)."""
    if is_none(contacts):
        return
    law, kin = laws[0], kinematics_at(contacts[0], state[0], state[1], turn)
    force = normal_force(law, kin)
    force = force if force > 0.0 else 0.0  # not max(): without contact, 0 times a negative penetration is -0.0
    vec.store_number(base, at, force)
    vec.store_number(base, at + 1, force * (law.mu + law.mu_slope * kin.motion.slip))
    vec.store_number(base, at + 2, kin.motion.tangential)
    _save_forces(contacts[1:], laws[1:], base, at + 3, state, turn)


@static
def turn_for_all(contacts, clock, tau, state):
    """The Turn a time tau later as far as any contact needs it; one with an eccentric ring needs most."""
    if is_one(contacts):
        return contact_turn(contacts[0], clock, tau, state)
    if contacts[0].has_ring:
        return contact_turn(contacts[0], clock, tau, state)
    return turn_for_all(contacts[1:], clock, tau, state)


@inlined
def save_sample(con, laws, where, sample, clock, state, turn):
    """Write a state (x, v) as sample number `sample` into an SampleRows; clock: at the begin of its step."""
    row = (sample - where.first) * where.columns
    vec.store_at(where.base, row, as_sampled(con, state[0], state[1]))
    mark_turns(con, where.base, row, clock.phase, state[0], state[1])
    mark_races(con.contacts, where.base, row, state[1])
    if where.velocities > 0:
        vec.store_at(where.base, row + where.velocities, state[1])
    _save_forces(con.contacts, laws, where.base, row + where.forces, state, turn)


@inlined
def save_samples(con, laws, where, sample, path, end, method):
    """Write all samples inside a step, from number `sample` on, to an SampleRows; returns the number of the next one."""
    start, h = path.clock, path.h
    dense = dense_of(path, method)
    time = sample / con.sample_rate
    while (time - end.hi) - end.lo <= 0.0:
        theta = min(max(((time - start.hi) - start.lo) / h, 0.0), 1.0)
        x, v = interpolate(dense, theta)
        turn = turn_for_all(con.contacts, start, theta * h, (x, v))
        save_sample(con, laws, where, sample, start, (x, v), turn)
        sample += 1
        time = sample / con.sample_rate
    return sample
