"""The state of a run between two steps, how it is read from `Work` and stored there, and how it goes on after a switch."""

from typing import NamedTuple

from rsc.kernel.clock import clock_in, corners_of, segment_of, settled, turn_of
from rsc.kernel.contact import CLOSING, OPENING, classify, law_of
from rsc.kernel.contact_forces import contact_kinematics, rows_times
from rsc.kernel.model import COUNT_OF_CONTACT, N_COUNT, NORMAL, PHASE, SEGMENT, T_HI, T_LO, H
from rsc.kernel.questions import is_none
from rsc.kernel.rhs import accelerations, field_itself, no_powers
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import static
from rsc.kernel.switches import slope_of_rate

# share of the stability limit above which steps count as near it, where steps limited by stability usually are
NEAR = 0.4


class State(NamedTuple):
    """A point where a step starts or ends."""

    x: object
    v: object
    a: object
    powers: object
    clock: object
    kins: tuple  # Kinematics of each contact
    rate_slopes: tuple  # p'' of each, see `switches.slope_of_rate`


class ContactState(NamedTuple):
    """State of a contact and its force law."""

    normal: int
    friction: int
    law: object


class Contacts(NamedTuple):
    """The state of all contacts."""

    each: tuple  # `ContactState` of each contact
    near_limit: float  # s, steps longer than this count as near the stability limit


class Progress(NamedTuple):
    """State of a run between two steps."""

    start: State
    contacts: Contacts
    h: float  # s, length of the next step
    tally: object
    segment: object
    i_segment: int
    sample: int  # number of the next sample
    finite: bool  # whether the last attempt was finite
    flight: object  # Work.real[FLIGHT], () if the scene has no exact flight


@static
def laws_of(each):
    """The laws of all contacts."""
    return () if is_none(each) else (each[0].law,) + laws_of(each[1:])


@static
def _contacts_in(contacts, states):
    """The ContactState of each contact for given (normal, friction) states."""
    if is_none(contacts):
        return ()
    normal, friction = states[0]
    return (ContactState(normal, friction, law_of(contacts[0], normal, friction)),) + _contacts_in(contacts[1:], states[1:])


@static
def _anywhere(each, normal):
    """Whether any contact is in this normal state."""
    if is_none(each):
        return False
    return each[0].normal == normal or _anywhere(each[1:], normal)


@inlined
def contacts_of(con, states):
    """The Contacts for given (normal, friction) states."""
    each = _contacts_in(con.contacts, states)
    stable = con.stable_open
    if _anywhere(each, OPENING):
        stable = con.stable_opening
    elif _anywhere(each, CLOSING):
        stable = con.stable_closing
    return Contacts(each, NEAR * stable)


@static
def _classified(contacts, kins):
    """(normal, friction) state of every contact."""
    if is_none(contacts):
        return ()
    return (classify(contacts[0], kins[0]),) + _classified(contacts[1:], kins[1:])


@static
def rate_slopes(contacts, laws, kins, a, clock):
    """`slope_of_rate` of every contact."""
    if is_none(contacts):
        return ()
    slope = slope_of_rate(contacts[0], laws[0], kins[0], a, clock)
    return (slope,) + rate_slopes(contacts[1:], laws[1:], kins[1:], a, clock)


@static
def _places_in(kins):
    return () if is_none(kins) else (kins[0].place,) + _places_in(kins[1:])


@inlined
def state_at(con, laws, segment, x, v, clock):
    """The State from which a step can start, with accelerations and contact kinematics."""
    turn = turn_of(clock)
    kins, d_dot = contact_kinematics(con.contacts, x, v, turn), rows_times(con.contacts, v)
    field = field_itself(con, laws, clock)
    a, powers = accelerations(con, field, (x, v, d_dot), turn, _places_in(kins), 1.0, no_powers(con))
    clock = settled(con, segment, clock, a)
    return State(x, v, a, powers, clock, kins, rate_slopes(con.contacts, laws, kins, a, clock))


@inlined
def enter(con, segment, start):
    """(State, Contacts) after a switch or a corner of the schedule, where the right-hand side has a kink and nothing can be
    reused."""
    contacts = contacts_of(con, _classified(con.contacts, start.kins))
    clock = clock_in(con, segment, start.clock.hi, start.clock.lo, start.clock.phase, start.v)
    return state_at(con, laws_of(contacts.each), segment, start.x, start.v, clock), contacts


@static
def _stored_states(contacts, count, at):
    """(normal, friction) of every contact from Work.count; those of the first one are stored at index `at`."""
    if is_none(contacts):
        return ()
    following = _behind(at)
    return ((count[at], count[at + 1]),) + _stored_states(contacts[1:], count, following)


@inlined
def _behind(at):
    """Index in Work.count of the states of the next contact."""
    return N_COUNT if at == NORMAL else at + len(COUNT_OF_CONTACT)


@static
def _store_states(each, count, at):
    if is_none(each):
        return
    count[at], count[at + 1] = each[0].normal, each[0].friction
    _store_states(each[1:], count, _behind(at))


@inlined
def resume(model, con, work, width):
    """(State, Contacts) where the last call ended; at the start of a run (normal state -1) the motion determines the states."""
    real, count = work.real, work.count
    x, v = vec.load(work.x, width), vec.load(work.v, width)
    segment = segment_of(corners_of(model), count[SEGMENT])
    clock = clock_in(con, segment, real[T_HI], real[T_LO], real[PHASE], v)
    if count[NORMAL] < 0:
        states = _classified(con.contacts, contact_kinematics(con.contacts, x, v, turn_of(clock)))
        _store_states(_contacts_in(con.contacts, states), count, NORMAL)
    contacts = contacts_of(con, _stored_states(con.contacts, count, NORMAL))
    return state_at(con, laws_of(contacts.each), segment, x, v, clock), contacts


@inlined
def put_away(work, start, contacts, h):
    vec.store(work.x, start.x)
    vec.store(work.v, start.v)
    real = work.real
    real[T_HI], real[T_LO], real[PHASE], real[H] = start.clock.hi, start.clock.lo, start.clock.phase, h
    _store_states(contacts.each, work.count, NORMAL)
