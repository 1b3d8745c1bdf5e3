"""All motions that last at a speed, simulated from predicted motions and random impacts."""

from collections.abc import Callable

from rsc.arguments import FLAG, FUNCTION, IMPULSE, SCENE, SPEED, WHOLE, optional, takes
from rsc.errors import SolverError
from rsc.measure.catalogue import Motions
from rsc.scene.scene import Scene
from rsc.study.motions.impact import with_smallest
from rsc.study.motions.random_impacts import read_largest
from rsc.study.motions.release import with_held
from rsc.study.motions.search import Search

STARTS, MOST_STARTS = 64, 100_000


@takes(scene=SCENE, speed=optional(SPEED), starts=WHOLE, seed=WHOLE, smallest=FLAG, largest=optional(IMPULSE),
       threads=optional(WHOLE), note=FUNCTION)
def motions(
    scene: Scene,
    speed: float | str | None = None,
    starts: int = STARTS,
    *,
    seed: int = 0,
    smallest: bool = False,
    largest: float | str | None = None,
    threads: int | None = None,
    note: Callable[[int, int], object] = lambda ended, of: None,
) -> Motions:
    """List every motion of a machine that lasts at a rotor speed.

    What the analysis predicts (the motion without contact, forward rubs, whirls that slide or roll, stable or not) is simulated
    from itself, then impacts of random size and direction on the running rotor, each until it has settled. A motion lasts if it
    comes back after its velocities were changed by 3 %; its kind is that of `rsc.measure.kinds`. Several contacts are hit in
    turn, each up to a largest impulse of its own.

    Parameters
    ----------
    scene : Scene
    speed : float or str, Hz, optional
        Also with its unit: "3000 rpm".
        Default: the first speed of the scene.
    starts : int
        Random impacts in every direction alike, sizes evenly from what just touches (where that is above `largest` from 0) to
        `largest`.
    seed : int
        Of the impacts; the same seed gives the same list on any number of threads.
    smallest : bool
        Look for the smallest impulse that starts each motion as well, in eight directions; several contacts are hit one by one.
    largest : float or str, N s, optional
        Also with its unit: "10 N s".
        Default: ten times the impulse by which a rotor in the centre of the gap just touches; where the rotor's mass is known no
        more than its momentum at 3 m/s, or than twice what just touches.
    threads : int, optional
    note : callable, called with the number of runs that have ended, and how many there are so far

    Returns
    -------
    Motions

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C; its attribute `result` is the Motions found until then.
    SceneError
        A speed that no drive may have.
    SolverError
        Numbers of starts or impacts that cannot be.

    Examples
    --------
    >>> found = rsc.motions(rsc.load_scene("laval.toml"), "3000 rpm", starts=16)
    >>> for motion in found:
    ...     print(f"{motion.motion}: {motion.frequency:.1f} Hz, {motion.force_mean:.0f} N")
    backward whirl, rolling: -492.9 Hz, 3596 N
    backward whirl, sliding: -60.7 Hz, 275 N
    no contact: nan Hz, 0 N
    """
    refuse_starts(starts, seed, threads)
    size = read_largest(largest)
    value = scene.drive.speed[0] if speed is None else float(speed)
    forward = scene.steady(value)
    search = Search(forward.mirrored() if value < 0.0 else forward, abs(value), size, threads, note)
    listed = with_smallest(search, search.motions(starts, seed, smallest))
    listed = listed.mirrored() if value < 0.0 else with_held(search, listed, scene)
    if listed.interrupted:
        error = KeyboardInterrupt("interrupted: the motions found until then are kept")
        error.result = listed  # type: ignore[attr-defined]
        raise error
    return listed


def list_of(scene: Scene, speed: float, starts: int, threads: int | None = None) -> Motions:
    """`motions` without the smallest impact that starts a whirl and what a drive makes of each, for whoever makes many lists."""
    forward = scene.steady(speed)
    listed = Search(forward.mirrored() if speed < 0.0 else forward, abs(speed), threads=threads).motions(starts, 0)
    return listed.mirrored() if speed < 0.0 else listed


def refuse_starts(starts: int, seed: int, threads: int | None) -> None:
    """SolverError for numbers of starts, a seed or numbers of threads that cannot be."""
    if not 0 <= starts <= MOST_STARTS:
        raise SolverError(f"starts = {starts!r}: must be a whole number from 0 to {MOST_STARTS}")
    if seed < 0:
        raise SolverError(f"seed = {seed!r}: must be a whole number from 0")
    refuse_threads(threads)


def refuse_threads(threads: int | None) -> None:
    """SolverError for fewer threads than one."""
    if threads is not None and threads < 1:
        raise SolverError(f"threads = {threads!r}: must be a whole number from 1")
