"""Parts of a shaft: sections from its left end, disks, bearings, and named positions. SI throughout."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SAME_PLACE = 1e-9  # relative to the length of the shaft: positions closer than this are one node


class Material(NamedTuple):
    """kg/m^3, Pa and Poisson's ratio."""

    density: float
    young: float
    poisson: float

    @property
    def shear_modulus(self) -> float:
        """E / (2 (1 + nu)), Pa."""
        return 0.5 * self.young / (1.0 + self.poisson)


@dataclass(frozen=True)
class Section:
    """A piece of shaft, a cylinder or a cone, solid or hollow."""

    length: float  # m
    outer: tuple[float, float]  # m, diameter at the left and at the right end
    inner: tuple[float, float]  # m, bore at both ends
    material: Material
    name: str = ""

    def part(self, start: float, end: float) -> "Section":
        """The piece from `start` to `end` in m from its left end."""
        shares = start / self.length, end / self.length
        outer, inner = ((left + (right - left) * shares[0], left + (right - left) * shares[1]) for left, right in self._ends)
        return replace(self, length=end - start, outer=outer, inner=inner)

    def diameter_at(self, s: float) -> float:
        """Outer diameter in m at s in m from its left end."""
        return self.outer[0] + (self.outer[1] - self.outer[0]) * s / self.length

    @property
    def mass(self) -> float:
        """Mass of the frustum minus its bore, kg."""
        squares = [left**2 + left * right + right**2 for left, right in self._ends]
        return self.material.density * np.pi / 12.0 * self.length * (squares[0] - squares[1])

    @property
    def centre(self) -> float:
        """Position of its centre of mass in m from its left end."""
        return self._moment(1, 2) / self._moment(0, 2)

    @property
    def inertias(self) -> tuple[float, float]:
        """Polar moment of inertia, and that about a diameter through the centre of mass, kg m^2."""
        density = self.material.density
        polar = density * np.pi / 32.0 * self._moment(0, 4)
        along = self._moment(2, 2) - self._moment(0, 2) * self.centre**2
        return polar, 0.5 * polar + density * np.pi / 4.0 * along

    def _moment(self, power: int, exponent: int) -> float:
        """Integral of s^power (outer diameter^exponent - bore^exponent) ds over its length, in m."""
        parts = []
        for left, right in self._ends:
            diameter = np.polynomial.Polynomial([left, (right - left) / self.length])
            integrand = np.polynomial.Polynomial.basis(power) * diameter**exponent
            parts.append(float(integrand.integ()(self.length)))
        return parts[0] - parts[1]

    @property
    def _ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        return self.outer, self.inner


@dataclass(frozen=True)
class Disk:
    """A rigid disk; its shape, if known, is used for drawings and for a contact there."""

    place: float  # m from the left end of the shaft
    mass: float  # kg
    polar_inertia: float  # kg m^2
    diametral_inertia: float
    name: str = ""
    diameter: float | None = None  # m
    width: float | None = None


def disk_inertias(diameter: float, bore: float, width: float, density: float) -> tuple[float, float, float]:
    """Mass in kg, polar and diametral moment of inertia in kg m^2 of a disk with a bore (all in m)."""
    mass = density * np.pi / 4.0 * width * (diameter**2 - bore**2)
    polar = mass / 8.0 * (diameter**2 + bore**2)
    return mass, polar, 0.5 * polar + mass * width**2 / 12.0


@dataclass(frozen=True)
class Support:
    """A bearing or seal between a place of the shaft and the ground."""

    place: float  # m
    speeds: NDArray[np.float64]  # (k,) Hz, increasing; a single one for constant coefficients
    coefficients: NDArray[np.float64]  # (k, 8): k_yy, k_yz, k_zy, k_zz in N/m, then damping in N s/m
    tilt_stiffness: float = 0.0  # N m/rad, the same in every direction
    tilt_damping: float = 0.0  # N m s/rad
    name: str = ""


class PlacedSection(NamedTuple):
    """A section between two positions in m from the left end of the shaft."""

    start: float
    end: float
    section: Section

    def part(self, start: float, end: float) -> Section | None:
        """The part of the section between two positions; None if empty."""
        start, end = max(start, self.start), min(end, self.end)
        return self.section.part(start - self.start, end - self.start) if end > start else None


@dataclass(frozen=True)
class Shaft:
    """A shaft described by its stations."""

    sections: tuple[Section, ...]
    sleeves: tuple[tuple[float, Section], ...] = ()  # (start in m, section): they bend and rotate with the sections below
    disks: tuple[Disk, ...] = ()
    supports: tuple[Support, ...] = ()
    places: dict[str, float] = field(default_factory=dict)  # m, positions of contacts, unbalances etc. by name
    rotating_damping: float = 0.0  # s: C_i = this times the stiffness of the shaft
    rayleigh: tuple[float, float] = (0.0, 0.0)  # 1/s, s: C = alpha M + beta K of the shaft, at rest
    shear: bool = True

    @property
    def ends(self) -> list[float]:
        """Positions of the ends of all sections in m, from 0 to the length."""
        return list(accumulate((section.length for section in self.sections), initial=0.0))

    @property
    def length(self) -> float:
        """Length in m."""
        return self.ends[-1]

    @property
    def placed(self) -> list[PlacedSection]:
        """Sections from left to right, then sleeves."""
        sections = [PlacedSection(a, b, section) for section, (a, b) in zip(self.sections, pairwise(self.ends), strict=True)]
        return sections + [PlacedSection(start, start + sleeve.length, sleeve) for start, sleeve in self.sleeves]

    @property
    def stations(self) -> list[float]:
        """Positions in m, increasing and unique, of all ends of sections and sleeves, disks, supports and named places."""
        ends = [place for one in self.placed for place in one[:2]]
        parts = [*(disk.place for disk in self.disks), *(one.place for one in self.supports), *self.places.values()]
        return _apart([*ends, *parts], SAME_PLACE * self.length)

    def pieces(self, start: float, end: float) -> list[Section]:
        """The pieces between two neighbouring node positions: that of the section, and those of its sleeves."""
        parts = (one.part(start, end) for one in self.placed)
        return [replace(part, length=end - start) for part in parts if part is not None and part.length > 0.5 * (end - start)]

    def diameter_at(self, place: float) -> float:
        """Outer diameter in m at a position: of a disk of known shape, else of sleeve or shaft, the larger at a shoulder."""
        near = SAME_PLACE * self.length
        disks = [disk.diameter for disk in self.disks if disk.diameter is not None and abs(disk.place - place) <= near]
        covering = [one for one in self.placed if one.start - near <= place <= one.end + near]
        return max(disks or [one.section.diameter_at(place - one.start) for one in covering])

    def least_diameter_at(self, place: float) -> float:
        """Outer diameter in m of the bare shaft at a position, the smaller at a shoulder."""
        near, ends = SAME_PLACE * self.length, self.ends
        pairs = zip(ends, self.sections, strict=False)
        return min(
            section.diameter_at(min(max(place - start, 0.0), section.length))
            for start, section in pairs if start - near <= place <= start + section.length + near
        )  # fmt: skip

    @property
    def mass(self) -> float:
        """Mass in kg, with sleeves and disks."""
        return sum(one.section.mass for one in self.placed) + sum(disk.mass for disk in self.disks)

    def masses_near(self, places: Sequence[float]) -> list[float]:
        """Mass in kg nearest to each of some increasing positions."""
        bounds = [0.0, *(0.5 * (one + other) for one, other in pairwise(places)), self.length]
        masses = []
        for i, (low, high) in enumerate(pairwise(bounds)):
            last = i == len(places) - 1
            disks = sum(disk.mass for disk in self.disks if low <= disk.place and (disk.place < high or last))
            parts = (one.part(low, high) for one in self.placed)
            masses.append(disks + sum(part.mass for part in parts if part is not None))
        return masses


def _apart(places: Sequence[float], least: float) -> list[float]:
    """Sorted positions without those closer than `least` to the previous one."""
    kept: list[float] = []
    for place in sorted(places):
        if not kept or place - kept[-1] > least:
            kept.append(place)
    return kept
