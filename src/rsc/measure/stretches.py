"""Statistics of the stretches of a run, accumulated in the integration steps, independent of the output rate."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

# name -> (unit, meaning); d is the deflection of the contact: rotor less stator at the contact, with the ring's eccentricity
COLUMNS = {
    "end": ("s", "time at which the stretch ends, which is where the next begins"),
    "turns": ("1", "turns of d about the centre of the gap, negative backward"),
    "pressed_turns": ("1", "turns of d while the contact is pressed"),
    "contact_time": ("s", "time in contact"),
    "rolling_time": ("s", "time in contact with less slip than full friction needs"),
    "onsets": ("1", "times that contact began"),
    "friction_work": ("J", "work of friction on the lateral motion"),
    "rotor_max": ("m", "largest |r| of the rotor at the contact"),
    "rotor_min": ("m", "smallest |r| of the rotor at the contact, at the ends of steps"),
    "stator_max": ("m", "largest |r| of the stator at the contact, at the ends of steps"),
    "deflection_max": ("m", "largest |d|"),
    "force_max": ("N", "largest normal force"),
    "arc_y": ("m s", "integral of d over the time in contact, y"),
    "arc_z": ("m s", "integral of d over the time in contact, z"),
    "normal_impulse": ("N s", "integral of the normal force"),
    "friction_impulse": ("N s", "integral of the friction force, positive against the spin"),
    "drive_work": ("J", "work that friction takes from the drive; 0 without a contact diameter"),
    "race_work": ("J", "part of that work that accelerates an inner race or is lost to its drag"),
    "rotor_max_at": ("s", "when the largest |r| is reached"),
    "deflection_max_at": ("s", "when the largest |d| is reached"),
    "force_max_at": ("s", "when the largest normal force is reached"),
    "y_min": ("m", "least y of the rotor at the contact"),
    "y_max": ("m", "largest y of the rotor at the contact"),
    "z_min": ("m", "least z of the rotor at the contact"),
    "z_max": ("m", "largest z of the rotor at the contact"),
}
EXTENTS = ("y_min", "y_max", "z_min", "z_max")
# and of each clearance, of its deflection
OF_CLEARANCE = {
    "deflection": ("m", "largest size"),
    "passed": ("s", "when the run first passed its gap, infinite before"),
} | {name: ("m", COLUMNS[name][1].partition(" of")[0]) for name in EXTENTS}
_SUMS = (
    "turns", "pressed_turns", "contact_time", "rolling_time", "onsets", "friction_work", "arc_y", "arc_z", "normal_impulse",
    "friction_impulse", "drive_work", "race_work",
)  # fmt: skip
_ALL = 1.0 - 1e-9  # share of the time in contact from which it is all but for rounding
_TIMED = ("rotor_max", "deflection_max", "force_max")  # those whose time is kept as well
_LARGEST = (*_TIMED, "stator_max", "y_max", "z_max")
_LEAST = ("rotor_min", "y_min", "z_min")


@dataclass(frozen=True)
class Facts:
    """What a motion does from one time to another; the quantities of `COLUMNS`, begin, s, and of each place that is only watched
    clearances, its largest deflection in m, and clearance_extents, least and largest y and z of that in m."""

    begin: float
    end: float
    turns: float
    pressed_turns: float
    contact_time: float
    rolling_time: float
    onsets: float
    friction_work: float
    rotor_max: float
    rotor_min: float
    stator_max: float
    deflection_max: float
    force_max: float
    arc_y: float
    arc_z: float
    normal_impulse: float
    friction_impulse: float
    drive_work: float
    race_work: float
    rotor_max_at: float
    deflection_max_at: float
    force_max_at: float
    y_min: float
    y_max: float
    z_min: float
    z_max: float
    clearances: tuple[float, ...] = ()
    clearance_extents: tuple[tuple[float, float, float, float], ...] = ()

    @property
    def peak_to_peak(self) -> float:
        """Vibration of the rotor at the contact, m: the larger of its extents in y and in z."""
        return max(self.y_max - self.y_min, self.z_max - self.z_min)

    @property
    def clearances_peak_to_peak(self) -> tuple[float, ...]:
        """The same of the deflection at each clearance."""
        return tuple(max(y_max - y_min, z_max - z_min) for y_min, y_max, z_min, z_max in self.clearance_extents)

    @property
    def duration(self) -> float:
        """s."""
        return self.end - self.begin

    @property
    def share(self) -> float:
        """Share of the time in contact, 0 to 1."""
        share = self.contact_time / self.duration if self.duration > 0.0 else 0.0
        return share if share < _ALL else 1.0

    @property
    def turning(self) -> float:
        """Mean rate at which d turns, Hz, negative backward."""
        return self.turns / self.duration if self.duration > 0.0 else 0.0

    @property
    def rolling_share(self) -> float:
        """Share of the time in contact that rolls."""
        return self.rolling_time / self.contact_time if self.contact_time > 0.0 else 0.0

    @property
    def mean_force(self) -> float:
        """Normal force, mean over all the time, N."""
        return self.normal_impulse / self.duration if self.duration > 0.0 else 0.0

    @property
    def mean_friction(self) -> float:
        """Friction force, mean over all the time, N, positive against the spin."""
        return self.friction_impulse / self.duration if self.duration > 0.0 else 0.0

    @property
    def mean_power(self) -> float:
        """Power that friction takes from the drive, mean over all the time, W."""
        return self.drive_work / self.duration if self.duration > 0.0 else 0.0


class Stretches:
    """The facts of all stretches of a run, at one contact.

    Parameters
    ----------
    rows : (n, len(COLUMNS) + len(OF_CLEARANCE) k) float
        In the order of `COLUMNS`; each name is an attribute (n,) as well, and `begin` (s). Then those of `OF_CLEARANCE` of each
        of k clearances: `deflections` (n, k), m, `passed` (n, k), s, and `deflection_extents` (n, k, 4), m.
    """

    def __init__(self, rows: NDArray[np.float64]) -> None:
        self.rows = rows
        self._column = dict(zip(COLUMNS, rows.T[: len(COLUMNS)], strict=True))
        count = (rows.shape[1] - len(COLUMNS)) // len(OF_CLEARANCE)
        watched = rows[:, len(COLUMNS) :].reshape(len(rows), count, len(OF_CLEARANCE))
        self.deflections, self.passed, self.deflection_extents = watched[..., 0], watched[..., 1], watched[..., 2:]
        self._column["begin"] = np.concatenate([[0.0], rows[:-1, 0]])[: len(rows)]

    def __len__(self) -> int:
        return len(self.rows)

    def __getattr__(self, name: str) -> NDArray[np.float64]:
        try:
            return self.__dict__["_column"][name]
        except KeyError:
            raise AttributeError(name) from None

    def between(self, begin: float, end: float) -> Facts:
        """Facts of the stretches that lie in a time, s: those whose middle does, or the one that holds its middle."""
        return self.of(*self.places(begin, end))

    def places(self, begin: float, end: float) -> tuple[int, int]:
        """Numbers of the first and last (exclusive) of these stretches."""
        first, last = np.searchsorted(0.5 * (self.begin + self.end), [begin, end], side="left").tolist()
        if last <= first:
            first = min(int(np.searchsorted(self.end, 0.5 * (begin + end))), len(self.rows) - 1)
            last = first + 1
        return first, last

    @classmethod
    def joined(cls, parts: Sequence[Facts]) -> Facts:
        """The Facts of consecutive ones together."""
        values = {name: math.fsum(getattr(part, name) for part in parts) for name in _SUMS}
        values |= {name: max(getattr(part, name) for part in parts) for name in _LARGEST}
        values |= {name: min(getattr(part, name) for part in parts) for name in _LEAST}
        for name in _TIMED:
            values[f"{name}_at"] = getattr(max(parts, key=lambda part: getattr(part, name)), f"{name}_at")
        clearances = tuple(map(max, zip(*(part.clearances for part in parts), strict=True)))
        extents = _extents(np.array([part.clearance_extents for part in parts]))
        return Facts(begin=parts[0].begin, end=parts[-1].end, **values, clearances=clearances, clearance_extents=extents)

    def of(self, first: int, last: int) -> Facts:
        """Facts of the stretches from number first to last (exclusive)."""
        part = {name: self._column[name][first:last] for name in COLUMNS}
        values = {name: float(part[name].sum()) for name in _SUMS}
        values |= {name: float(part[name].max()) for name in _LARGEST}
        values |= {name: float(part[name].min()) for name in _LEAST}
        values |= {f"{name}_at": float(part[f"{name}_at"][np.argmax(part[name])]) for name in _TIMED}
        begin, end = float(self.begin[first]), float(part["end"][-1])
        clearances = tuple(self.deflections[first:last].max(axis=0).tolist())
        extents = _extents(self.deflection_extents[first:last])
        return Facts(begin=begin, end=end, **values, clearances=clearances, clearance_extents=extents)

    def whole(self) -> Facts:
        """Facts of the whole run."""
        return self.of(0, len(self.rows))

    def tail(self, duration: float) -> Facts:
        """Facts of the last stretches, which take at least `duration` s if the run does."""
        end = float(self.end[-1])
        first = int(np.searchsorted(self.begin, end - duration * (1.0 + 1e-9), side="right")) - 1
        return self.of(max(first, 0), len(self.rows))


def _extents(each: NDArray[np.float64]) -> tuple[tuple[float, float, float, float], ...]:
    """Least and largest y and z at k clearances over stretches, of those of each (n, k, 4)."""
    least, largest = each.min(axis=0), each.max(axis=0)
    return tuple((low[0], high[1], low[2], high[3]) for low, high in zip(least.tolist(), largest.tolist(), strict=True))


def side_by_side(rows: NDArray[np.float64], n_contacts: int) -> list[Stretches]:
    """The Stretches at each of some contacts, whose facts stand side by side in rows (n, n_contacts width)."""
    width = rows.shape[1] // n_contacts
    return [Stretches(rows[:, i * width : (i + 1) * width]) for i in range(n_contacts)]


class StretchedRun(Protocol):
    """A run that has stretches, as `rsc.Trajectory`."""

    @property
    def scene(self) -> Any: ...

    def stretches(self, contact: str | None = None) -> Stretches: ...


def at_contacts(run: StretchedRun) -> list[Stretches]:
    """The Stretches of a run at every contact of its scene."""
    contacts = run.scene.contacts
    return [run.stretches()] if len(contacts) == 1 else [run.stretches(contact.name) for contact in contacts]


