"""How hard an impact it takes: the smallest impulse, over its directions, after which a machine whirls."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from rsc.arguments import FUNCTION, IMPULSE, SCENE, SPEED, TEXT, WHOLE, optional, takes
from rsc.errors import SceneError, SolverError
from rsc.files.tables import Table
from rsc.measure.catalogue import WHIRLING
from rsc.measure.final import described
from rsc.measure.several import together
from rsc.presented import Brief
from rsc.scene.scene import Scene
from rsc.study.motions.motions import refuse_threads
from rsc.study.motions.random_impacts import read_largest
from rsc.study.motions.search import Search
from rsc.study.motions.settle import End
from rsc.study.run.start import initial_state
from rsc.system.system import System

DIRECTIONS = 24
SIZES = np.geomspace(0.01, 1.0, 25)  # of the first look, over the largest
HALVINGS = 6  # of the gap between two sizes of the first look, a fifth: then 0.3 %
MOST_DIRECTIONS = 10_000


@dataclass(frozen=True, eq=False, repr=False)
class SmallestImpulses(Brief):
    """The smallest impulse that starts a whirl, for every direction; a notebook shows it as a table.

    speed : float Hz; undisturbed : str, how the machine ends without an impact
    direction : (n,) degrees, of the impulse, from y towards z; the rotor's mark is at 0
    heavy_spot : float degrees, at the impact, of the sum of the unbalances of all planes; NaN where that is zero, and for a
        reduced rotor, whose coordinates are not those of its planes
    impulse : (n,) N s, smallest that was found to start a whirl; NaN where none up to `largest` does
    below : (n,) N s, the next smaller one that was tried and starts none
    velocity : (n,) m/s, change of the rotor's velocity at the contact by `impulse`; of a shaft that of the piece that is hit
    rotor_velocity : (n,) m/s, at which the whole rotor has as much momentum; NaN where its model does not tell its mass
    motion : (n,) str, what it starts, one of `rsc.measure.catalogue.WHIRLING`; "" where there is none
    at : (n,) str, names of those of several contacts at which it is that; "" with one
    frequency : (n,) Hz, at which that turns
    largest : float N s, largest that was tried; runs : int, of all; unsettled : int, of those in which nothing settled
    interrupted : bool, whether it was stopped before all was tried
    contact : str, name of the one of several contacts that is hit; "" with one
    """

    speed: float
    undisturbed: str
    direction: NDArray[np.float64]
    heavy_spot: float
    impulse: NDArray[np.float64]
    below: NDArray[np.float64]
    velocity: NDArray[np.float64]
    motion: NDArray[np.str_]
    frequency: NDArray[np.float64]
    largest: float
    runs: int
    unsettled: int
    interrupted: bool
    contact: str = ""
    at: NDArray[np.str_] = field(default_factory=lambda: np.zeros(0, dtype=str))
    rotor_velocity: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    @property
    def weakest(self) -> int | None:
        """Number of the direction with the smallest impulse; None where no impact starts a whirl."""
        return None if np.isnan(self.impulse).all() else int(np.nanargmin(self.impulse))

    @property
    def ahead(self) -> NDArray[np.float64]:
        """(n,) degrees by which the directions are ahead of the heavy spot, in the sense of rotation."""
        return (self.direction - self.heavy_spot) * (-1.0 if self.speed < 0.0 else 1.0) % 360.0

    def table(self) -> Table:
        """A `rsc.files.tables.Table` with a row for each direction, for pandas (`to_dataframe`) and CSV (`to_csv`)."""
        columns = (
            self.direction, self.ahead, self.impulse, self.below, self.velocity, self.rotor_velocity, self.frequency, self.motion
        )  # fmt: skip
        return Table(_COLUMNS, list(zip(*(column.tolist() for column in columns), strict=True)))

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


_COLUMNS = (
    "direction in degrees", "ahead of the heavy spot in degrees", "impulse in N s", "none starts at N s",
    "velocity at the contact in m/s", "velocity of the whole rotor in m/s", "frequency in Hz", "motion",
)  # fmt: skip


@takes(scene=SCENE, speed=optional(SPEED), directions=WHOLE, largest=optional(IMPULSE), contact=optional(TEXT),
       threads=optional(WHOLE), note=FUNCTION)
def smallest_impulse(
    scene: Scene,
    speed: float | str | None = None,
    directions: int = DIRECTIONS,
    largest: float | str | None = None,
    *,
    contact: str | None = None,
    threads: int | None = None,
    note: Callable[[int, int], object] = lambda ended, of: None,
) -> SmallestImpulses:
    """Find the smallest impulse that starts a whirl of a machine that turns without contact.

    In the steady motion without contact (`start.running`) the rotor gets an impulse at its contact coordinate (`start.impulse`),
    and the run goes on until its motion has settled. The interval between the first of 25 sizes that starts a whirl and the one
    before it is halved down to 0.3 %. Attractors may be interwoven: smaller impulses between two sizes that were tried are not
    excluded.

    Parameters
    ----------
    scene : Scene
    speed : float or str, Hz, optional
        Also with its unit: "3000 rpm". By default the scene's, which must be constant.
    directions : int
        Evenly spaced over the full turn.
    largest : float or str, N s, optional
        Largest impulse, also with its unit: "10 N s".
        Default: ten times the impulse by which a rotor in the centre of the gap just touches, or less as in `rsc.motions`.
    contact : str, optional
        Name of the contact whose rotor coordinate is hit; by default the first.
    threads : int, optional
        As in `rsc.simulate_many`.
    note : callable, called with the number of runs that have ended, and how many there are so far

    Returns
    -------
    SmallestImpulses

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C; its attribute `result` is the SmallestImpulses found until then.
    SceneError
        The speed changes, or the running rotor would touch the stator.
    SolverError
        No direction, an impact that is no positive number, or no contact of that name.

    Examples
    --------
    >>> scene = rsc.load_scene("laval.toml").with_values({"drive.speed": 20.0})
    >>> found = rsc.smallest_impulse(scene, directions=4)
    >>> print(f"{found.impulse.min():.2f} N s, then {found.motion[0]}")
    0.54 N s, then backward whirl, sliding
    """
    if speed is not None:
        scene = scene.steady(float(speed))  # each run goes on until it has settled
    _refuse(scene, directions)
    refuse_threads(threads)
    size = read_largest(largest)
    place = _place(scene, contact)
    if scene.drive.speed[0] < 0.0:
        mirror = smallest_impulse(scene.mirrored(), None, directions, size, contact=contact, threads=threads, note=note)
        direction, heavy_spot = (180.0 - mirror.direction) % 360.0, (180.0 - mirror.heavy_spot) % 360.0
        return replace(mirror, speed=-mirror.speed, direction=direction, heavy_spot=heavy_spot, frequency=-mirror.frequency)
    search = Search(scene, scene.drive.speed[0], size, threads, note)
    initial_state(search.scene.with_values({"start.running": True}), search.system)  # refused where it would touch
    tried = _Tried(search, directions, place)
    tried.look()
    tried.halve()
    result = tried.result()
    if result.interrupted:
        error = KeyboardInterrupt("interrupted: the impacts found until then are kept")
        error.result = result  # type: ignore[attr-defined]
        raise error
    return result


class _Tried:
    """Results of impacts in all directions at a contact, given by its number."""

    def __init__(self, search: Search, directions: int, place: int) -> None:
        self._search, self._place = search, place
        self.angles = 360.0 * np.arange(directions) / directions
        self.turns = np.exp(1j * np.deg2rad(self.angles))
        self.below, self.impulse = np.zeros(directions), np.full(directions, np.nan)
        self.ends: list[End | None] = [None] * directions
        self.unsettled = 0
        (self.undisturbed,) = self._after([0j])

    def _after(self, impulses: Sequence[complex] | NDArray[np.complex128]) -> list[End]:
        ends = self._search.after(np.asarray(impulses, dtype=complex), [self._place] * len(impulses))
        self.unsettled += sum(not end.settled for end in ends)
        return ends

    def look(self) -> None:
        """Try every size, from the smallest on, in the directions in which none has started a whirl yet."""
        largest = self._search.largest[self._place]
        if self.undisturbed.motion.kind in WHIRLING:
            self.impulse[:], self.ends = 0.0, [self.undisturbed] * len(self.ends)
            return
        for size in largest * SIZES:
            waiting = np.flatnonzero(np.isnan(self.impulse))
            self._take(waiting, size * self.turns[waiting], np.full(len(waiting), size))

    def halve(self) -> None:
        """Bisect between the smallest impulse that starts a whirl and the next smaller one."""
        between = np.flatnonzero(self.impulse > 0.0)  # NaN is not
        for _ in range(HALVINGS if between.size else 0):
            middle = 0.5 * (self.below + self.impulse)[between]
            self._take(between, middle * self.turns[between], middle)

    def _take(self, places: NDArray[np.intp], impulses: NDArray[np.complex128], sizes: NDArray[np.float64]) -> None:
        if self._search.settling.interrupted or not len(places):
            return
        for k, size, end in zip(places.tolist(), sizes.tolist(), self._after(impulses), strict=False):
            if end.settled and end.motion.kind in WHIRLING:
                self.impulse[k], self.ends[k] = size, end
            else:
                self.below[k] = size

    def result(self) -> SmallestImpulses:
        """The result."""
        search = self._search
        contact = search.system.contacts[self._place]
        per_impulse = float(search.changes[self._place] @ contact.rotor)
        return SmallestImpulses(
            speed=search.speed,
            undisturbed=str(self.undisturbed.motion.kind),
            direction=self.angles,
            heavy_spot=_heavy_spot(search.scene, search.system),
            impulse=self.impulse,
            below=self.below,
            velocity=self.impulse * per_impulse,
            rotor_velocity=self.impulse / search.scene.rotor.total_mass,
            motion=np.array(["" if end is None else str(end.motion.kind) for end in self.ends]),
            frequency=np.array([np.nan if end is None else end.motion.frequency for end in self.ends]),
            largest=search.largest[self._place],
            runs=search.settling.runs,
            unsettled=self.unsettled,
            interrupted=search.settling.interrupted,
            contact=contact.name if len(search.changes) > 1 else "",
            at=np.array(["" if end is None else _names(described(end.motion, search.scene).pressed) for end in self.ends]),
        )


def _names(pressed: Sequence[str]) -> str:
    return together(pressed) if pressed else ""


def _heavy_spot(scene: Scene, system: System) -> float:
    """Angle of the sum of all unbalances in degrees, while the rotor's mark is at 0."""
    planes = np.delete(system.rotor.unbalance, list(scene.rotor.tilts))
    total = planes.sum()
    if scene.rotor.model == "reduced" or abs(total) <= 1e-9 * np.abs(planes).sum():
        return float("nan")
    return float(np.angle(total, deg=True)) % 360.0


def _place(scene: Scene, contact: str | None) -> int:
    """The number of the contact of this name, of the first without one."""
    names = [one.name for one in scene.contacts]
    if contact is not None and contact not in names:
        wanted = "one of " + ", ".join(filter(None, names)) if any(names) else "left out"
        raise SceneError(scene.source, "contact", contact, wanted)
    return 0 if contact is None else names.index(contact)


def _refuse(scene: Scene, directions: int) -> None:
    if len(set(scene.drive.speed)) > 1:
        hint = "scene.steady(60.0), on the command line --speed"
        raise SceneError(scene.source, "drive.speed", list(scene.drive.speed), "constant", hint)
    if not 1 <= directions <= MOST_DIRECTIONS:
        raise SolverError(f"directions = {directions!r}: must be a whole number from 1 to {MOST_DIRECTIONS}")
