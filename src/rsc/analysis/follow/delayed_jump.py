"""Where a run-up leaves a whirl that has become unstable: the delay of the jump (docs/maintainers/analysis.md).

A disturbance of a whirl shrinks or grows with the growth rate of the whirl at the speed of the moment,

    d ln(level) / dt = growth rate(speed(t)),   level >= floor,

so the jump comes after the crossing: the decay before it must be made up by growth after it.
"""

import math
from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np

from rsc.analysis.follow.events import CREEPING, OSCILLATORY
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import pushed
from rsc.analysis.paper.small_motions import small_motion
from rsc.analysis.paper.states import states_of
from rsc.analysis.paper.synchronous import synchronous_response, unbalance_response
from rsc.presented import Brief
from rsc.system.system import FloatOrArray, System

# a disturbance this far below the whirl begins to show in a spectrum of 60 dB
SEEN = 1e-3
# samples of the run on which the growth rate is integrated
SAMPLES = 4001
# steps of an integration scheme per period of the contact resonance
STEPS_PER_PERIOD = 10.0


@dataclass(frozen=True, repr=False)
class Delay(Brief):
    """The predicted end of a whirl along a run.

    crossing : float Hz, rotor speed where the whirl loses stability on the way, the limit of an infinitely slow run
        with any disturbance that does not vanish; NaN if it does not
    first_seen, jump : float Hz, where the disturbance has grown to 1e-3 and to all of the whirl's amplitude; the end of
        the branch if that comes first, NaN if the run ends before
    undisturbed : float Hz, the same without a floor and with a start level of 1: the integral of the growth rate from the
        start of the run is zero; the limit of an infinitely slow run without any noise
    start_level, floor : float, disturbances at the start and at all times, over the whirl's amplitude
    level_at_crossing : float, disturbance at the crossing over the whirl's amplitude
    source : str, "start" or "floor": where the disturbance that grows comes from
    towards : float Hz, frequency of the growing line at the crossing
    """

    crossing: float
    first_seen: float
    jump: float
    undisturbed: float
    start_level: float
    floor: float
    level_at_crossing: float
    source: str
    towards: float


def delayed_jump(system: System, branch, start_level=None, floor=None):
    """Predict where a run along the system's speed schedule leaves a whirl.

    Parameters
    ----------
    system : System
        Its schedule is the run; it may only rise or only fall up to the jump.
    branch : Branch
        Over the rotor speed, from the start of the run.
    start_level : float, optional
        Disturbance at the start over the whirl's amplitude. Default: that of a start on the whirl without unbalance,
        `starting_level`. Anything else, a start from rest for example, is better stated as 1.
    floor : float, optional
        Disturbance that is always present. Default: rounding, `rounding_floor`; a measured machine has much more.

    Returns
    -------
    Delay

    Raises
    ------
    ValueError
        The branch does not exist at the start of the run.
    """
    time, speed = way_of(system)
    order = np.argsort(branch.speed)
    known, growth_rate = branch.speed[order], branch.growth_rate[order]
    low, high = sorted((branch.begin.value, branch.end.value))
    slack = 1e-9 * max(abs(low), abs(high))
    if not low - slack <= speed[0] <= high + slack:
        raise ValueError(f"the whirl does not exist at {speed[0]:g} Hz, the start of the run")
    inside = (speed >= low - slack) & (speed <= high + slack)
    last = len(speed) if inside.all() else int(np.argmin(inside))
    time, speed = time[:last], speed[:last]
    growth = np.interp(speed, known, growth_rate)
    crossing = _crossing(branch, speed)
    if start_level is None:
        start_level = starting_level(system, branch, speed[0])
    if floor is None:
        floor = rounding_floor(system, time, growth)
    level, source = _levels(time, growth, math.log(start_level), math.log(floor))
    free, _ = _levels(time, growth, 0.0, -math.inf)
    end = math.nan if inside.all() else float(speed[-1])
    after = speed >= crossing if speed[-1] > speed[0] else speed <= crossing
    if not after.any():
        return Delay(crossing, end, end, end, start_level, floor, math.nan, "start", math.nan)
    at = int(np.argmax(after))
    thresholds = ((level, SEEN), (level, 1.0), (free, 1.0))
    first_seen, jump, undisturbed = (_first(speed, values - math.log(limit), at, end) for values, limit in thresholds)
    towards = _growing_line(system, branch, crossing)
    cause = "floor" if source[at] else "start"
    level_at_crossing = float(np.exp(level[at]))
    return Delay(crossing, first_seen, jump, undisturbed, start_level, floor, level_at_crossing, cause, towards)


def way_of(system: System):
    """Times in s and speeds in Hz along the schedule, (SAMPLES,) each, up to where the speed turns back."""
    time = np.linspace(system.schedule_time[0], system.schedule_time[-1], SAMPLES)
    speed = np.asarray(system.speed_at(time)) / TWO_PI
    change = np.diff(speed)
    way = np.sign(change[np.flatnonzero(change)[0]]) if change.any() else 1.0
    back = np.flatnonzero(way * change < 0.0)
    last = back[0] + 1 if len(back) else SAMPLES
    return time[:last], speed[:last]


def _crossing(branch, speed):
    """The first speed of the run at which the whirl turns unstable; NaN if it does not."""
    rising = speed[-1] >= speed[0]
    if np.interp(speed[0], np.sort(branch.speed), branch.growth_rate[np.argsort(branch.speed)]) > 0.0:
        return float(speed[0])
    holds = "below" if rising else "above"
    met = [e.value for e in branch.events if e.cause in (CREEPING, OSCILLATORY) and e.holds == holds]
    met = [value for value in met if min(speed[0], speed[-1]) <= value <= max(speed[0], speed[-1])]
    return float((min if rising else max)(met, default=math.nan))


def _levels(time, growth, start, floor):
    """ln(level) along the run, (n,), and whether the floor has set it, (n,)."""
    gained = np.concatenate([[0.0], np.cumsum(0.5 * (growth[1:] + growth[:-1]) * np.diff(time))])
    undisturbed = start + gained
    # the floor at its best moment: the largest of floor + gained(t) - gained(t') over the moments t' before t
    raised = floor + gained - np.minimum.accumulate(gained)
    return np.maximum(undisturbed, raised), raised > undisturbed


def _first(speed, excess, begin, end):
    """Speed at which a quantity rises through zero after a sample, else `end`."""
    above = np.flatnonzero(excess[begin:] >= 0.0)
    if len(above) == 0:
        return end
    k = begin + above[0]
    if k == 0 or excess[k - 1] >= 0.0:
        return float(speed[k])
    share = -excess[k - 1] / (excess[k] - excess[k - 1])
    return float(speed[k - 1] + share * (speed[k] - speed[k - 1]))


def rounding_floor(system: System, time, growth):
    """Disturbance that rounding keeps up in a double-precision simulation, over the whirl's amplitude.

    Each step of the simulation rounds by u = 2^-53; at a slow crossing the steps count that lie within
    sqrt(pi / (d growth rate / dt)), added like a random walk.

    Parameters
    ----------
    system : System
    time, growth : (n,) s and 1/s, the growth rate along the run

    Returns
    -------
    float
    """
    slope = float(np.abs(np.gradient(growth, time)).max()) if np.ptp(growth) > 0.0 else 0.0
    memory = min(math.sqrt(math.pi / slope), time[-1] - time[0]) if slope > 0.0 else time[-1] - time[0]
    compliance = system.rotor.contact @ np.linalg.solve(system.rotor.mass, system.rotor.contact)
    if system.n_stator:
        compliance += system.stator.contact @ np.linalg.solve(system.stator.mass, system.stator.contact)
    steps = memory * STEPS_PER_PERIOD * float(law_of(system).resonance(compliance)) / TWO_PI
    return 2.0**-53 * math.sqrt(max(steps, 1.0))


def starting_level(system: System, branch, speed):
    """Disturbance of a run that starts on the whirl without its unbalance, over the whirl's amplitude.

    The start misses the lines of the unbalance; their part in the small motion that grows (or decays slowest) remains.

    Parameters
    ----------
    system : System
    branch : Branch
    speed : float, Hz
        Of the start; the branch's whirl next to it is taken.

    Returns
    -------
    float
        At least 2^-53.
    """
    whirl = branch.at(speed)
    Omega, Psi = TWO_PI * whirl.speed, TWO_PI * whirl.frequency
    lines = _unbalance_lines(system, Psi, whirl.normal_force, Omega)
    motion = small_motion(system, Psi, whirl.normal_force, Omega)
    turning = 1j * (Omega - Psi) * np.array([1.0, -1.0])
    z = ()
    if system.n_states:
        bodies = system.at_speed(Omega).joined()
        z = -sum(states_of(bodies, w, line) for w, line in zip((Omega, 2.0 * Psi - Omega), lines, strict=True))
    part = motion.part_of(-lines.sum(axis=0), -(turning @ lines), z)
    return max(abs(part) * float(motion.sizes(system).max()) / whirl.rotor_amplitude, 2.0**-53)


def _unbalance_lines(system: System, Psi: FloatOrArray, F_N: FloatOrArray, Omega: FloatOrArray):
    """Lines that the unbalance adds to a whirl at Omega and at 2 Psi - Omega, (2, N + M) complex, consistent first order."""
    part, _ = synchronous_response(system, np.array([Psi]), np.array([F_N]), Omega)
    unbalanced, _ = unbalance_response(system, Omega)
    lines = []
    for w, force, free in ((Omega, part.force[0], unbalanced), (2.0 * Psi - Omega, part.mirror_force[0], 0.0)):
        rotor, stator = pushed(system, w, Omega, force)
        lines.append(np.concatenate([free + rotor, stator]))
    return np.array(lines)


def _growing_line(system: System, branch, speed):
    """Frequency in Hz of the larger line of the growing motion."""
    whirl = branch.at(speed)
    Psi = TWO_PI * whirl.frequency
    return float(small_motion(system, Psi, whirl.normal_force, TWO_PI * whirl.speed).larger_line(system, Psi)) / TWO_PI
