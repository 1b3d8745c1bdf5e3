"""Whether a contact may begin during a block of flight.

Between two units the deflection is the cubic through both ends, which lies within its Bezier polygon, and what modes that ring
faster may add to it.
"""

import math
from typing import NamedTuple

from rsc.kernel.block import state_behind
from rsc.kernel.contact_forces import contact_kinematics
from rsc.kernel.questions import is_none
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import static
from rsc.kernel.tally import turn_for_all


class Reach(NamedTuple):
    """How far the deflection of a contact reaches near the end of a unit, squares in m^2."""

    behind: float  # there, and on the way to the next
    before: float  # there, and on the way from the last
    hidden: float  # what modes may add that ring faster


@static
def reaches(con, contacts, i, x, v, kins):
    """The Reach of every contact from number i on."""
    if is_none(contacts):
        return ()
    third = 1.0 / (3.0 * con.flight.unit_rate)
    square = kins[0].place.distance * kins[0].place.distance
    sideways, along = third * kins[0].motion.speed, 2.0 * third * kins[0].motion.along
    # corners of the cubic's Bezier polygon, which holds it
    beside = square + sideways * sideways
    at = con.flight.hidden
    hidden = vec.product(vec.row_at(at, 2 * i, x) * x, x) + vec.product(vec.row_at(at, 2 * i + 1, x) * v, v)
    y, z = vec.pair_sum(hidden)
    reach = Reach(max(square, beside + along), max(square, beside - along), y + z)
    return (reach,) + reaches(con, contacts[1:], i + 1, x, v, kins[1:])


@static
def are_clear(con, i, begin, end):
    """Whether nothing can touch between two targets, by their Reach, of the contacts from number i on."""
    if is_none(begin):
        return True
    room = vec.number_at(con.flight.clear, i) - math.sqrt(max(begin[0].hidden, end[0].hidden))
    far = max(begin[0].behind, end[0].before)
    return room > 0.0 and far <= room * room and are_clear(con, i + 1, begin[1:], end[1:])


@inlined
def units_clear(con, first, begin, clock, force, units, reach):
    """(units of a block until a contact may begin, (x, v) at the end of those that were looked at); first: row of the first unit;
    reach: at its begin."""
    x_end, v_end = begin
    clear = 0
    while clear < units:
        x_end, v_end = state_behind(con, first, clear, begin, force)
        tau = (clear + 1.0) / con.flight.unit_rate
        kins = contact_kinematics(con.contacts, x_end, v_end, turn_for_all(con.contacts, clock, tau, (x_end, v_end)))
        reach_end = reaches(con, con.contacts, 0, x_end, v_end, kins)
        if not are_clear(con, 0, reach, reach_end):
            break
        reach = reach_end
        clear += 1
    return clear, (x_end, v_end)
