"""A look at one lane's attempted step that is not plain, with the code of a single run and what all lanes' attempt has left.

The attempt lies in a layout of its own: vectors x, v, a, then the slopes of v and of a; its kinematics lie with the numbers of
the lanes. A look searches for a switch: it ends with a shorter length for the lane's next attempt or with a step to be taken.
"""

from typing import NamedTuple

from rsc.kernel.clock import ahead
from rsc.kernel.lanes import layout as rows
from rsc.kernel.lanes.layout import View, number, put_number, put_vector, vectors
from rsc.kernel.march import Progress, State, check_switch, enter
from rsc.kernel.simd.jit import compiled, inlined, unrolled
from rsc.kernel.step import Step
from rsc.kernel.switches import Path, slope_of_rate
from rsc.kernel.tableau import table_of
from rsc.kernel.tally import count_switch

# verdicts: try again with H_SEARCH; take the step; take it, and the contact enters another state
AGAIN, STAYS, LEAVES = 0.0, 1.0, 2.0


class Look(NamedTuple):
    """Where the case in one lane lies, and what is known of all."""

    layout: int  # address of the lane's column of the layout
    attempts: int  # and of the layout of attempts
    n_lanes: int
    flags: object
    sizes: object


@unrolled
def _slopes(view, k, method):
    """The slopes of a Step."""
    of_end = (0.0,)
    if table_of(method):
        return lambda view, k, method: vectors(view, k, method + of_end)
    return lambda view, k, method: vectors(view, k, method + of_end + method + of_end)


@inlined
def put_attempt(view, attempted, new, step, h):
    """Leave an attempt of all lanes in the layout of attempts, to be looked at."""
    put_number(view, rows.H_TRIED, h)
    put_number(view, rows.ATTEMPT, new.kin)
    put_vector(attempted, 0, (new.x, new.v, new.a))
    put_vector(attempted, rows.SLOPES, step.slopes)


@inlined
def _attempt_in(con, column, attempts, progress, method):
    """(State at the end, Step) of a lane's attempt."""
    start, h = progress.start, number(column, rows.H_TRIED)
    x, v, a = vectors(attempts, 0, (0.0,) * 3)
    kin = rows.kinematics_in(column, rows.ATTEMPT)
    # no powers and no work: what looks does not book
    step = Step(start.x, start.v, x, v, a, start.powers, kin, _slopes(attempts, rows.SLOPES, method), start.powers)
    clock = ahead(progress.segment, start.clock, h)
    return State(x, v, a, start.powers, clock, kin, slope_of_rate(con, progress.contact.law, kin, a, clock)), step


@compiled
def look(at):
    """Search a lane's attempt for a switch as `march.walk` does, and put down the verdict."""
    width, _, _, method = at.sizes
    column, attempts = View(at.layout, at.n_lanes, width, width, (), ()), View(at.attempts, at.n_lanes, width, width, (), ())
    con, progress = rows.constants_in(column, at.flags), rows.progress_in(column, at.flags)
    new, step = _attempt_in(con, column, attempts, progress, method)
    path = Path(step, progress.start.clock, number(column, rows.H_TRIED))
    tries = int(number(column, rows.TRIES))
    inside, h_search = check_switch(con, progress.contact, path, progress.start, new, tries, method)
    put_number(column, rows.H_SEARCH, h_search)
    if h_search > 0.0:
        put_number(column, rows.TRIES, tries + 1)
        put_number(column, rows.VERDICT, AGAIN)
    else:
        put_number(column, rows.VERDICT, STAYS if inside else LEAVES)


@compiled
def change_contact(at):
    """Let the contact of a lane enter the state that its step beyond a switch has led to."""
    column = View(at.layout, at.n_lanes, at.sizes[0], at.sizes[0], (), ())
    con, progress = rows.constants_in(column, at.flags), rows.progress_in(column, at.flags)
    start, contact = enter(con, progress.segment, progress.start, progress.contact)
    tally = count_switch(progress.tally, False, progress.contact.normal, contact.normal)
    after = start, contact, progress.h, tally, progress.segment, progress.i_segment, progress.sample, progress.finite
    rows.put_progress(column, Progress(*after))
