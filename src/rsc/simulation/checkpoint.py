"""Check that a checkpoint is a possible state of a run of this scene: the compiled kernel trusts every number it gets.

Counters are used as memory offsets without a check, and a wrong step length makes the kernel ask for memory without end. A state
from a file is therefore checked against the scene, in the units and with the comparisons of the kernel itself.
"""

import numpy as np

from rsc.errors import SolverError
from rsc.kernel import facts
from rsc.kernel import model as kernel
from rsc.kernel.contact import BACKWARD, CLIPPED, FORWARD
from rsc.kernel.flight import DOUBTFUL
from rsc.simulation.tolerances import first_step

LARGEST_COUNT = 2**62
RUNNING = (kernel.RUNNING, kernel.BUFFER_FULL)
_SINGLE = {"energy_start": float, "code": np.int64, "rows": np.int64}


def work_of(checkpoint, scene, packed):
    """The Work of a checkpoint, in new arrays.

    Parameters
    ----------
    checkpoint : dict
        name -> array as returned by `rsc.simulation.run.Run.checkpoint`.
    scene : Scene
    packed : Packed

    Raises
    ------
    SolverError
        It is from another version, or not a possible state of a run of this scene.
    """
    n = len(packed.model.contacts)
    kept = packed.kept(packed.model.stiffness).size
    expected = {name: ((kept,), float) for name in kernel.WORK_VECTORS}
    expected |= {"real": ((kernel.n_real(n),), float), "count": ((kernel.n_count(n),), np.int64), "sliding": ((5,), float)}
    expected |= {"stretch": ((n * (facts.N_STRETCH + facts.N_WATCHED * len(scene.clearances)),), float)}
    expected |= {name: ((1,), kind) for name, kind in _SINGLE.items()}
    actual = {name: (np.shape(values), np.asarray(values).dtype) for name, values in checkpoint.items()}
    if actual != expected:
        raise SolverError("the checkpoint was written by a version with a different state; only that version can continue it")
    vectors = {name: packed.restored(checkpoint[name]) for name in kernel.WORK_VECTORS}
    work = kernel.Work(**vectors, **{name: np.array(checkpoint[name]) for name in ("real", "count", "stretch")})
    problem = _problem(work, checkpoint, scene, packed)
    if problem:
        raise SolverError(f"the checkpoint is not a possible state of a run of this scene: {problem}")
    return work


def _problem(work, checkpoint, scene, packed):
    """Why the numbers of a checkpoint are impossible; "" if they are possible."""
    code, count, real = int(checkpoint["code"][0]), work.count, work.real
    if not kernel.RUNNING <= code <= (kernel.STOPPED if packed.model.drive else kernel.TOO_STIFF):
        return f"its return code is {code}"
    if not _sliding_is_possible(checkpoint["sliding"]):
        return "its record of sliding is impossible"
    normal, friction = (kernel.of_contacts(count, i) for i in (kernel.NORMAL, kernel.FRICTION))
    signed = {*kernel.places_of(count, kernel.NORMAL), *kernel.places_of(count, kernel.FRICTION)}
    if any(not 0 <= number <= LARGEST_COUNT for i, number in enumerate(count) if i not in signed):
        return "a count is negative or too large"
    if count[kernel.STEPS] > packed.model.max_steps or count[kernel.LIMITED] > count[kernel.STEPS]:
        return "it has taken more steps than allowed"
    least, states = (normal.min(), friction.min()), (normal.max(), friction.max(), count[kernel.STIFF])
    inside = least[0] >= -1 and states[0] <= CLIPPED and least[1] >= BACKWARD and states[1] <= FORWARD
    if not (inside and states[2] <= 1 + CLIPPED and _flight_is_possible(real[kernel.FLIGHT], packed.model.flight)):
        return "its state of contact or flight does not exist"
    if count[kernel.SAMPLES] != checkpoint["rows"][0]:
        return "its number of samples is not that of the file"
    stretches = work.stretch.reshape(len(packed.model.contacts), -1)
    if not all(_stretch_is_possible(stretch, packed.model, real[kernel.T_HI]) for stretch in stretches):
        return "its stretch of the run does not contain its time"
    if not _time_is_possible(work, scene, packed, code):
        return "its times contradict each other"
    if code in RUNNING:  # a run that ended is not continued, and may have ended because of a non-finite number
        if not all(np.isfinite(values).all() for values in (*work[:5], checkpoint["energy_start"])):
            return "a number is not finite"
        if not 0.0 < real[kernel.H] <= max(packed.model.h_max, first_step(packed)):
            return f"its next step is {real[kernel.H]:.3g} s"
    return ""


def _flight_is_possible(state, flight):
    """Whether a flight can be where Work.real says; the kernel takes it for a place among the weights."""
    return state in range(int(DOUBTFUL), flight.count + 1) if flight else state == 0.0


def _sliding_is_possible(state):
    """Whether an array is a possible state of a `rsc.simulation.sliding.SlidingWatch`."""
    return 0.0 <= state[0] < np.inf and state[1] >= 0.0 and bool(np.isfinite(state[2:]).all())


def _stretch_is_possible(stretch, model, time):
    """Whether the number of finished stretches, which the kernel uses as a memory offset, agrees with the time."""
    finished, begin, end, until = stretch[[facts.FINISHED, facts.BEGIN + facts.TIME, facts.END + facts.TIME, facts.UNTIL]]
    if not (0.0 <= finished <= round(model.corner_time[-1] / model.stretch) and finished == int(finished)):
        return False
    return until == (finished + 1.0) * model.stretch and finished * model.stretch <= begin <= end == time and time < until


def _time_is_possible(work, scene, packed, code):
    """Whether the time is in its schedule segment, just after the last sample, and at the end if the run finished."""
    real, count, corners = work.real, work.count, packed.model.corner_time
    hi, lo, phase, segment, samples = *real[:3], int(count[kernel.SEGMENT]), int(count[kernel.SAMPLES])
    if not (segment <= len(corners) - 2 and abs(lo) <= np.spacing(max(hi, 0.0)) and abs(phase) <= 1.0):
        return False
    if not (corners[segment] <= hi <= corners[segment + 1] and _times_of_contact_are_possible(real, hi)):
        return False
    if (code == kernel.FINISHED) != (hi == scene.drive.duration):
        return False
    if samples == 0:
        return hi == lo == 0.0
    rate = packed.model.sample_rate
    return ((samples - 1) / rate - hi) - lo <= 0.0 < (samples / rate - hi) - lo


def _times_of_contact_are_possible(real, time):
    times = kernel.of_contacts(real, kernel.CONTACT_TIME)
    return bool(times.min() >= 0.0 and times.max() <= time * (1.0 + 1e-6))
