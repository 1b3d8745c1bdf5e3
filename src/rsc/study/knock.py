"""How hard a knock it takes: the smallest impulse, over its directions, after which a machine whirls."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.receptance import coupled_frequencies, uncoupled_frequencies
from rsc.arguments import REAL, SCENE, WHOLE, optional, takes
from rsc.errors import SceneError, SolverError
from rsc.measure.final import ROLLS, RUNS_AWAY, WHIRL, final_motions
from rsc.results.summary import Status
from rsc.scene.scene import Scene
from rsc.study.ensemble import simulate_many
from rsc.system.assemble import assemble
from rsc.system.system import System

DIRECTIONS = 24
SIZES = np.concatenate([[0.0], np.geomspace(0.01, 1.0, 25)])  # of the first look, over the largest
HALVINGS = 6  # of the gap between two sizes of the first look, a fifth: then 0.3 %
SMALLEST, LARGEST = 1e-12, 1e12  # N s, that may be tried
_FAST = 10.0  # largest knock: the contact point then is so much faster than on a free vibration as large as the gap
MOST_DIRECTIONS = 10_000


@dataclass(frozen=True, eq=False)
class Knocks:
    """The smallest knock that starts a whirl, for every direction.

    speed : float Hz; duration : float s, of every run; undisturbed : str, how the run ends without a knock
    direction : (n,) degrees, of the impulse, from y towards z; the rotor's mark is at 0
    impulse : (n,) N s, smallest that was found to start a whirl; NaN where none up to `largest` does
    below : (n,) N s, the next smaller one that was tried and starts none
    velocity : (n,) m/s, change of the rotor's velocity at the contact by `impulse`
    motion : (n,) str, how the run ends: "backward whirl", "rolling" or "runs away"; "" where there is none
    frequency : (n,) Hz, of its strongest backward line
    largest : float N s, largest that was tried; runs : int, of all
    sliding_lost : int, runs in which sliding was lost under one-sided friction: `contact.diameter` tells then what happens
    """

    speed: float
    duration: float
    undisturbed: str
    direction: NDArray[np.float64]
    impulse: NDArray[np.float64]
    below: NDArray[np.float64]
    velocity: NDArray[np.float64]
    motion: NDArray[np.str_]
    frequency: NDArray[np.float64]
    largest: float
    runs: int
    sliding_lost: int

    @property
    def weakest(self) -> int | None:
        """Number of the direction with the smallest impulse; None where no knock starts a whirl."""
        return None if np.isnan(self.impulse).all() else int(np.nanargmin(self.impulse))


@takes(scene=SCENE, directions=WHOLE, largest=optional(REAL), threads=optional(WHOLE))
def smallest_knock(
    scene: Scene, directions: int = DIRECTIONS, largest: float | None = None, *, threads: int | None = None
) -> Knocks:
    """Find the smallest knock that starts a whirl of a machine that turns without contact.

    In the steady motion without contact (`start.running`) the rotor gets an impulse at its contact coordinate (`start.knock`),
    and the run of the scene shows what becomes of it. The interval between the first of 25 sizes that starts a whirl and the
    one before it is halved down to 0.3 %. Attractors may be interwoven: smaller knocks between two sizes that were tried are
    not excluded.

    Parameters
    ----------
    scene : Scene
        At constant speed; its duration must leave the motion time to settle.
    directions : int
        Evenly spaced over the full turn.
    largest : float, N s, optional
        Largest knock; by default one by which the contact point gets ten times as fast as on the rotor's slowest free vibration
        with the gap as its amplitude (where nothing holds the rotor: on its slowest one that is joined to the stator at the
        contact, or else at the rotor speed).
    threads : int, optional
        As in `rsc.simulate_many`.

    Returns
    -------
    Knocks

    Raises
    ------
    SceneError
        The speed changes, or the running rotor would touch the stator.
    SolverError
        No direction, or a knock that is no positive number.
    """
    _refuse(scene, directions, largest)
    if scene.drive.speed[0] < 0.0:
        mirror = smallest_knock(scene.mirrored(), directions, largest, threads=threads)
        direction, frequency = -mirror.direction % 360.0, -mirror.frequency
        return replace(mirror, speed=-mirror.speed, direction=direction, frequency=frequency)
    knocked = _Knocked(scene.with_values({"start.running": True}), threads)
    if largest is None:
        largest = _FAST * knocked.slowest * scene.contact.gap / knocked.velocity_per_impulse
    angles = 360.0 * np.arange(directions) / directions
    turns, sizes = np.exp(1j * np.deg2rad(angles)), largest * SIZES
    undisturbed = knocked.ends([0j])[0]
    looked = knocked.ends(np.outer(turns, sizes[1:]).ravel())
    below, impulse, ends = np.zeros(directions), np.full(directions, np.nan), [undisturbed] * directions
    for k in range(directions):
        look = looked[k * (len(sizes) - 1) : (k + 1) * (len(sizes) - 1)]
        first = next((i for i, end in enumerate(look, 1) if end.whirls), None)
        if undisturbed.whirls:
            impulse[k] = 0.0
        elif first is None:
            below[k] = largest
        else:
            below[k], impulse[k], ends[k] = sizes[first - 1], sizes[first], look[first - 1]
    between = np.flatnonzero(impulse > 0.0)  # NaN is not
    for _ in range(HALVINGS if between.size else 0):
        middle = 0.5 * (below + impulse)
        for k, end in zip(between.tolist(), knocked.ends((middle * turns)[between]), strict=True):
            if end.whirls:
                impulse[k], ends[k] = middle[k], end
            else:
                below[k] = middle[k]
    return Knocks(
        speed=scene.drive.speed[0],
        duration=scene.drive.duration,
        undisturbed=undisturbed.motion,
        direction=angles,
        impulse=impulse,
        below=below,
        velocity=impulse * knocked.velocity_per_impulse,
        motion=np.array([end.motion if end.whirls else "" for end in ends]),
        frequency=np.array([end.frequency for end in ends]),
        largest=largest,
        runs=knocked.runs,
        sliding_lost=knocked.sliding_lost,
    )


class _End(NamedTuple):
    """How a run ends: a word, and the frequency of a whirl in Hz."""

    motion: str
    frequency: float

    @property
    def whirls(self) -> bool:
        return self.motion in (WHIRL, ROLLS, RUNS_AWAY)


class _Knocked:
    """The machine that is knocked, and how many of its runs there were."""

    def __init__(self, scene: Scene, threads: int | None) -> None:
        system = assemble(scene)
        self._scene, self._threads = scene, threads
        self.velocity_per_impulse = float(system.contact_r @ np.linalg.solve(system.mass_r, system.contact_r))
        self.slowest = _slowest(system)
        self.runs = self.sliding_lost = 0

    def ends(self, impulses: Sequence[complex] | NDArray[np.complex128]) -> list[_End]:
        """How the runs after some knocks (n,) in N s end."""
        scenes = [self._scene.with_values({"start.knock": [z.real, z.imag]}) for z in np.asarray(impulses).tolist()]
        results = simulate_many(scenes, threads=self._threads)
        self.runs += len(results)
        self.sliding_lost += sum(result.status == Status.OUT_OF_ASSUMPTIONS for result in results)
        return [_End(end.motion, end.backward_frequency) for end in final_motions(results)]


def _slowest(system: System) -> float:
    """Frequency in rad/s of the rotor's slowest free vibration; where nothing holds it, that with the stator at the contact, and
    in a rigid wall the rotor speed."""
    for frequencies in (uncoupled_frequencies(system, 0.0), coupled_frequencies(system, 0.0)):
        size = np.abs(frequencies)
        vibrating = size[size > 1e-6 * size.max(initial=0.0)]  # a free motion's zero is rounding
        if vibrating.size:
            return float(vibrating.min())
    return float(np.abs(system.schedule_speed).max())


def _refuse(scene: Scene, directions: int, largest: float | None) -> None:
    if len(set(scene.drive.speed)) > 1:
        hint = "scene.with_values({\"drive.speed\": 60.0, \"drive.duration\": 2.0}), on the command line --speed and --duration"
        raise SceneError(scene.source, "drive.speed", list(scene.drive.speed), "constant", hint)
    if not 1 <= directions <= MOST_DIRECTIONS:
        raise SolverError(f"directions = {directions!r}: must be a whole number from 1 to {MOST_DIRECTIONS}")
    if largest is not None and not SMALLEST <= largest <= LARGEST:
        raise SolverError(f"largest = {largest!r}: must be an impulse from {SMALLEST:g} to {LARGEST:g} N s")
