"""The unbalance response beside the numbers by which acceptance tests of turbomachines judge it.

Amplification factor, separation margin, vibration limit and scale factor as API RP 684 (2nd edition, SP6.8.2) has them, on the
response of the model without contact. It is no test by that standard: whether the unbalance lies where it excites a mode most,
and whether model and machine agree, is for the user to see to.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, nan, sqrt
from math import tau as TWO_PI
from typing import Any, Protocol

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.alone.free_vibration import vibrations_of
from rsc.analysis.alone.modes import critical_speeds
from rsc.analysis.paper.anisotropy import unbalance_ellipse
from rsc.analysis.paper.synchronous import free_motion
from rsc.arguments import SCENE, takes
from rsc.errors import SceneError
from rsc.files.tables import Table
from rsc.presented import Brief
from rsc.system.assemble import SceneLike, assemble
from rsc.system.system import System

VIBRATION = 25.4e-6  # m peak to peak, at most, and at 12000 rpm
AT = 200.0  # Hz
DAMPED = 2.5  # amplification factor below which a peak needs no margin
SCALES = (0.5, 6.0)  # least and largest scale factor
CLEARANCE = 0.75  # of a diametral clearance that the scaled response may take
_BEYOND = 1.5  # times the trip speed, up to which peaks are looked for
_GRID, _NEAR = 1001, 10.0 * np.arange(-20, 21) / 20.0
COLUMNS = ("peak in Hz", "amplitude in um peak to peak", "amplification factor", "margin in %", "margin needed in %", "kept")

Response = Callable[[NDArray[np.float64]], NDArray[np.float64]]


class Limited(SceneLike, Protocol):
    """A scene that may have [limits]."""

    @property
    def source(self) -> str: ...

    @property
    def limits(self) -> Any: ...


@dataclass(frozen=True)
class Peak:
    """A peak of the unbalance response at the probe.

    speed : Hz; amplitude : m peak to peak
    amplification : N_c/(N_2 - N_1) with the speeds at which the response is 1/sqrt(2) of the peak; from one of them and the peak
        where the response has only that, NaN where it has none
    margin : distance from the operating speeds over the end that is nearer, 0 between them
    needed : min(0.16, 0.17 a) below them and min(0.26, 0.10 + 0.17 a) above with a = 1 - 1/(amplification - 1.5), 0 where the
        amplification is below 2.5; infinite between them
    """

    speed: float
    amplitude: float
    amplification: float
    margin: float
    needed: float

    @property
    def kept(self) -> bool:
        """Whether the margin is kept; not where the amplification is not known."""
        return self.margin >= self.needed


@dataclass(frozen=True)
class Passage:
    """The scaled response at a clearance up to the trip speed, where it is largest: share of the diametral clearance; Hz."""

    name: str
    share: float
    speed: float

    @property
    def kept(self) -> bool:
        """Whether it takes 75 % at most."""
        return self.share <= CLEARANCE


@dataclass(frozen=True, repr=False)
class Acceptance(Brief):
    """The unbalance response of a scene beside its `[limits]`.

    operating : lowest and highest operating speed, Hz; trip : Hz; probe : name of the place
    peaks : tuple of Peak up to 1.5 times the trip speed
    vibration : m peak to peak, largest at the probe over the operating speeds; at : Hz; allowed : m peak to peak,
        25.4 um min(1, sqrt(12000 rpm/N)) with the maximum continuous speed N
    scale : allowed/vibration, from 0.5 to 6, by which the response at the clearances is multiplied
    passages : tuple of Passage, the contact and the clearances, that which is taken furthest first
    """

    operating: tuple[float, float]
    trip: float
    probe: str
    peaks: tuple[Peak, ...]
    vibration: float
    at: float
    allowed: float
    scale: float
    passages: tuple[Passage, ...]

    def table(self) -> Table:
        """A `rsc.files.tables.Table` with a row for each peak."""
        return Table(COLUMNS, [
            (p.speed, 1e6 * p.amplitude, p.amplification, 100.0 * p.margin, 100.0 * p.needed, p.kept) for p in self.peaks
        ])  # fmt: skip

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


@takes(scene=SCENE)
def limits(scene: Limited) -> Acceptance:
    """Amplification, separation margins, vibration and scaled clearances of the unbalance response without contact.

    Parameters
    ----------
    scene : rsc.Scene, with a table [limits]

    Returns
    -------
    Acceptance

    Raises
    ------
    SceneError
        The scene has no [limits], or no unbalance that moves the probe.

    Examples
    --------
    >>> speeds = {"limits.maximum_continuous": "6000 rpm", "limits.trip": "6600 rpm"}
    >>> scene = rsc.load_scene("disk.toml").with_values(speeds)
    >>> for peak in rsc.limits(scene).peaks:
    ...     print(f"{peak.speed:.1f} Hz, amplification {peak.amplification:.0f}")
    40.2 Hz, amplification 98
    """
    if scene.limits is None:
        raise SceneError(scene.source, "limits", None, "given as a table [limits]", "it has the operating speeds")
    made = acceptance_of(scene)
    if made is None:
        wanted = "a rotor whose unbalance moves the probe"
        raise SceneError(scene.source, "limits.probe", scene.limits.probe, wanted, "without a response there is nothing to judge")
    return made


def acceptance_of(scene: Limited, system: System | None = None) -> Acceptance | None:
    """`limits` of a scene, whose System may be given; None without [limits], or where the
    unbalance does not move the probe."""
    if scene.limits is None:
        return None
    system = (assemble(scene) if system is None else system).at_start
    low, high, trip = scene.limits.speeds
    contacts = system.contacts if len(system.contacts) > 1 else (system.contact,)
    # the stator rests, since nothing touches it
    places = {contact.name or "the contact": (contact.rotor, contact.gap) for contact in contacts}
    places |= {place.name: (place.rotor, place.gap) for place in system.clearances}
    probe = scene.limits.probe or next(iter(places))
    grid = _speeds(system, _BEYOND * trip, (low, high, trip))
    response = _response(system, places[probe][0])
    values = response(grid)
    if not values.any():
        return None
    peaks = tuple(_judged(peak, (low, high)) for peak in _peaks(response, grid, values))
    grid = np.union1d(grid, [peak.speed for peak in peaks])
    inside = grid[(grid >= low) & (grid <= high)]
    vibration, at = _largest(response, inside)
    allowed = VIBRATION * min(1.0, sqrt(AT / high))
    scale = float(np.clip(allowed / (2.0 * vibration), *SCALES)) if vibration else SCALES[1]
    passages = []
    for name, (row, gap) in places.items():
        largest, speed = _largest(_response(system, row), grid[grid <= trip])
        passages.append(Passage(name, scale * largest / gap, speed))
    passages.sort(key=lambda passage: -passage.share)
    return Acceptance((low, high), trip, probe, peaks, 2.0 * vibration, at, allowed, scale, tuple(passages))


def _response(system: System, row: NDArray[np.float64]) -> Response:
    """Function of speeds in Hz that gives the largest deflection in m at a row of the rotor, that of the ellipse's major axis."""

    def alike(speeds: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.abs(free_motion(system, TWO_PI * speeds) @ row)

    def ellipse(speeds: NDArray[np.float64]) -> NDArray[np.float64]:
        lines = [unbalance_ellipse(system, TWO_PI * speed) for speed in speeds]
        return np.array([abs(forward @ row) + abs(backward @ row) for forward, backward in lines])

    return alike if system.isotropic else ellipse


def _speeds(system: System, highest: float, ends: tuple[float, ...]) -> NDArray[np.float64]:
    """Speeds in Hz of which every peak has several: dense about the critical speeds, by the damping there."""
    parts = [np.linspace(0.0, highest, _GRID), np.array(ends)]
    for critical in critical_speeds(system, 0.0, highest):
        nearest = min(vibrations_of(system.rotor, critical), key=lambda each: abs(abs(each.frequency) - critical))
        width = max(abs(nearest.growth_rate) / TWO_PI, 1e-6 * critical)
        parts.append(critical + width * (_NEAR + 0.013))  # never on an undamped pole
    grid = np.unique(np.concatenate(parts))
    return grid[(grid >= 0.0) & (grid <= highest)]


def _peaks(response: Response, grid: NDArray[np.float64], values: NDArray[np.float64]) -> list[tuple[float, float, float]]:
    """(speed in Hz, amplitude in m peak to peak, amplification factor) of every peak inside the grid."""
    peaks = []
    tops = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1
    for i in tops.tolist():
        bounds = float(grid[i - 1]), float(grid[i + 1])
        best = scipy.optimize.minimize_scalar(
            lambda speed: -response(np.array([speed]))[0], bounds=bounds, method="bounded", options={"xatol": 1e-9 * bounds[1]}
        )
        peaks.append((float(best.x), -2.0 * float(best.fun), _amplification(response, grid, values, i, float(best.x), -best.fun)))
    return peaks


def _amplification(
    response: Response, grid: NDArray[np.float64], values: NDArray[np.float64], i: int, speed: float, peak: float
) -> float:
    """N_c/(N_2 - N_1) of the peak next to place i of the grid."""
    level = peak / sqrt(2.0)
    distances = []
    for step in (-1, 1):
        k = i
        while 0 <= k + step < len(grid) and values[k] > level and (k == i or values[k + step] <= values[k]):
            k += step
        if values[k] <= level:
            end = scipy.optimize.brentq(lambda at: response(np.array([at]))[0] - level, speed, float(grid[k]), xtol=1e-12 * speed)
            distances.append(abs(end - speed))
    width = sum(distances) * (2.0 / len(distances)) if distances else nan
    return speed / width if width else inf


def _judged(peak: tuple[float, float, float], operating: tuple[float, float]) -> Peak:
    """The Peak with its margins."""
    speed, _, amplification = peak
    low, high = operating
    below, above = speed < low, speed > high
    margin = (low - speed) / low if below else (speed - high) / high if above else 0.0
    if amplification < DAMPED:
        return Peak(*peak, margin, 0.0)
    if not (below or above):
        return Peak(*peak, margin, inf)
    share = 0.17 * (1.0 - 1.0 / (amplification - 1.5))
    return Peak(*peak, margin, min(0.16, share) if below else min(0.26, 0.10 + share))


def _largest(response: Response, grid: NDArray[np.float64]) -> tuple[float, float]:
    """The largest amplitude in m over speeds of a grid, and its speed in Hz."""
    values = response(grid)
    i = int(np.argmax(values))
    return float(values[i]), float(grid[i])
