"""A look at one lane's attempted step that is not plain, with the code of a single run and what all lanes' attempt has left.

The attempt lies in a room of its own: vectors x, v, a, then the slopes of v and of a; its kinematics lie with the numbers of
the lanes. A look searches for a switch: it ends with a shorter length for the lane's next attempt or with a step to be taken.
"""

from typing import NamedTuple

from rsc.kernel.clock import ahead
from rsc.kernel.lanes.layout import (
    ATTEMPT,
    H_SEARCH,
    H_TRIED,
    SLOPES,
    TRIES,
    VERDICT,
    View,
    constants_in,
    here_in,
    kinematics_in,
    number,
    put_here,
    put_number,
    put_vector,
    vectors,
)
from rsc.kernel.march import Here, State, check_switch, enter
from rsc.kernel.simd.jit import compiled, inlined, unrolled
from rsc.kernel.step import Step
from rsc.kernel.switches import Path, slope_of_rate
from rsc.kernel.tableau import table_of
from rsc.kernel.tally import count_switch

# verdicts: try again with H_SEARCH; take the step; take it, and the contact enters another mode
AGAIN, STAYS, LEAVES = 0.0, 1.0, 2.0


class Look(NamedTuple):
    """Where the case in one lane lies, and what is known of all."""

    room: int  # address of the lane's column of the room
    attempts: int  # and of the room of attempts
    width: int
    flags: object
    sizes: object


@unrolled
def _slopes(view, k, stages):
    """The slopes of a Step."""
    of_end = (0.0,)
    if table_of(stages):
        return lambda view, k, stages: vectors(view, k, stages + of_end)
    return lambda view, k, stages: vectors(view, k, stages + of_end + stages + of_end)


@inlined
def put_attempt(view, there, new, step, h):
    """Leave an attempt of all lanes in the room of attempts, to be looked at."""
    put_number(view, H_TRIED, h)
    put_number(view, ATTEMPT, new.kin)
    put_vector(there, 0, (new.x, new.v, new.a))
    put_vector(there, SLOPES, step.slopes)


@inlined
def _attempt_in(con, column, attempts, here, stages):
    """(State at the end, Step) of a lane's attempt."""
    now, h = here.now, number(column, H_TRIED)
    x, v, a = vectors(attempts, 0, (0.0,) * 3)
    kin = kinematics_in(column, ATTEMPT)
    # no powers and no work: what looks does not book
    step = Step(now.x, now.v, x, v, a, now.powers, kin, _slopes(attempts, SLOPES, stages), now.powers)
    clock = ahead(here.segment, now.clock, h)
    return State(x, v, a, now.powers, clock, kin, slope_of_rate(con, here.mode.law, kin, a, clock)), step


@compiled
def look(at):
    """Search a lane's attempt for a switch as `march.walk` does, and put down the verdict."""
    lanes, _, _, stages = at.sizes
    column, attempts = View(at.room, at.width, lanes, lanes, (), ()), View(at.attempts, at.width, lanes, lanes, (), ())
    con, here = constants_in(column, at.flags), here_in(column, at.flags)
    new, step = _attempt_in(con, column, attempts, here, stages)
    path = Path(step, here.now.clock, number(column, H_TRIED))
    tries = int(number(column, TRIES))
    inside, h_search = check_switch(con, here.mode, path, here.now, new, tries, stages)
    put_number(column, H_SEARCH, h_search)
    if h_search > 0.0:
        put_number(column, TRIES, tries + 1)
        put_number(column, VERDICT, AGAIN)
    else:
        put_number(column, VERDICT, STAYS if inside else LEAVES)


@compiled
def change_mode(at):
    """Let the contact of a lane enter the mode of the state that its step beyond a switch has led to."""
    column = View(at.room, at.width, at.sizes[0], at.sizes[0], (), ())
    con, here = constants_in(column, at.flags), here_in(column, at.flags)
    now, mode = enter(con, here.segment, here.now, here.mode)
    tally = count_switch(here.tally, False, here.mode.normal, mode.normal)
    put_here(column, Here(now, mode, here.h, tally, here.segment, here.i_segment, here.sample, here.finite))
