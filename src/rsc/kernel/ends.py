"""Whether a run ends: before a step that may not be attempted, or after one that diverged, stopped or showed stiffness."""

from rsc.kernel.drive import stands
from rsc.kernel.model import BUFFER_FULL, DIVERGED, NON_FINITE, RUNNING, STEP_COLLAPSED, STOPPED, TOO_MANY_STEPS, TOO_STIFF
from rsc.kernel.progress import NEAR
from rsc.kernel.questions import is_one
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import static
from rsc.kernel.step import size_square
from rsc.kernel.switches import EPS
from rsc.kernel.tally import end_window

# stiffness is judged every WINDOW steps: at least MANY of them near the stability limit, though the motion would allow LOSS times
# longer ones; detected at most WINDOW + MANY steps after onset
WINDOW, MANY, LOSS = 512, 256, 10.0


@inlined
def stop_before(start, h, finite, left):
    """Return code if no further step may be attempted, else -1; left = (steps, attempts, output rows) still available."""
    if not h >= max(10.0 * EPS * start.clock.hi, 1e-290):  # written such that NaN ends the run, too
        return STEP_COLLAPSED if finite else NON_FINITE
    steps, attempts, rows_left = left
    if steps <= 0:
        return TOO_MANY_STEPS
    if attempts <= 0:
        return RUNNING
    return BUFFER_FULL if rows_left < 0.0 else -1


@inlined
def _is_stiff(con, tally, near_limit, start):
    """Whether most steps of the window just ended are near the stability limit and much shorter than the motion needs."""
    if tally.limited < MANY:
        return False
    # a fast motion alone is not stiff: it is if steps are this short although the actual motion would allow longer ones
    rate2 = size_square(start.v) / size_square(start.x)  # squared rate of the whole motion, 1/s^2; NaN at rest
    needed = LOSS / NEAR * near_limit
    return con.h_max >= needed and con.resolved_angle * con.resolved_angle >= needed * needed * rate2


@static
def _pressed_most(each):
    """The largest normal state among the contacts."""
    if is_one(each):
        return each[0].normal
    return max(each[0].normal, _pressed_most(each[1:]))


@inlined
def judge(con, tally, contacts, start, end):
    """(tally, return code if the run ends after an accepted step, else -1); end: end time of the run, s."""
    code = -1 if size_square(start.x) <= con.divergence2 else DIVERGED
    if code < 0 and stands(con, start.v):
        code = STOPPED
    if tally.steps % WINDOW != 0:
        return tally, code
    stiff = tally.stiff
    if code < 0 and stiff == 0 and _is_stiff(con, tally, contacts.near_limit, start):
        stiff = 1 + _pressed_most(contacts.each)
        # with steps at the stability limit the run cannot reach its end
        if tally.steps + (end - start.clock.hi) * NEAR / contacts.near_limit > con.max_steps:
            code = TOO_STIFF
    return end_window(tally, stiff), code
