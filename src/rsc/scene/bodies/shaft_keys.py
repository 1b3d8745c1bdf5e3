"""The keys of a shaft that is given by its stations: [rotor] or [stator] with model "shaft"."""

from dataclasses import dataclass

from rsc.machine.shaft.parts import Material
from rsc.scene.bodies.body_model import RAYLEIGH
from rsc.scene.bodies.reduced import COEFFICIENTS
from rsc.scene.keys.keys import (
    OPTIONAL,
    Choice,
    Flag,
    Integer,
    Keyed,
    Later,
    Number,
    PairReader,
    Sequence,
    Text,
    declare,
)
from rsc.scene.keys.nested import Ends, Tables

LENGTH, DIAMETER = Number("length", above=0.0), Number("length", low=0.0)
FROM_LEFT, FROM_RIGHT = (Keyed({"section": Text(), end: Number("length")}) for end in ("left", "right"))
PLACE = Later(
    "a place: a length from the left end, the name of a disk or bearing, or {section = NAME, left = ...} or {..., right = ...}",
    (Number("length", low=0.0), Text(), FROM_LEFT, FROM_RIGHT),
)
# EN 1993-1-1 (density: EN 1991-1-1), EN 1999-1-1, and the usual figures of Ti-6Al-4V
MATERIALS = {
    "steel": Material(7850.0, 210e9, 0.3),
    "aluminium": Material(2700.0, 70e9, 0.3),
    "titanium": Material(4430.0, 114e9, 0.34),
}
_NAMED = Choice(tuple(MATERIALS))
_GIVEN = Keyed({"density": Number("density"), "youngs_modulus": Number("modulus"), "poisson": Number("dimensionless")})
MATERIAL = Later(
    f"{_NAMED.wanted}, or {{density = \"7850 kg/m^3\", youngs_modulus = \"210 GPa\", poisson = 0.3}}", (_NAMED, _GIVEN)
)
_FOUR_STIFFNESSES, _FOUR_DAMPINGS = COEFFICIENTS
STIFFNESS = Later("a number in N/m, or [xx, xy, yx, yy]", (Number("stiffness"), _FOUR_STIFFNESSES))
DAMPING = Later("a number in N s/m, or [xx, xy, yx, yy]", (Number("damping"), _FOUR_DAMPINGS))


@dataclass(frozen=True, kw_only=True)
class MaterialKeys:
    """A material of your own."""

    density: float = declare(Number("density", low=0.0), meaning="Density; 0 of a massless piece.")
    youngs_modulus: float = declare(Number("modulus", above=0.0), meaning="Young's modulus.")
    poisson: float = declare(Number("dimensionless", above=-1.0, high=0.5), 0.3, meaning="Poisson's ratio.")


@dataclass(frozen=True, kw_only=True)
class SectionKeys:
    """A piece of shaft."""

    name: str | None = declare(Text(), None, meaning="Its name, by which places are given from either end of it.")
    length: float = declare(LENGTH, meaning="Length.")
    diameter: tuple = declare(Ends(LENGTH), meaning="Outer diameter; of a cone [left, right].")
    bore: tuple = declare(Ends(DIAMETER), (0.0, 0.0), meaning="Inner diameter, by default 0; of a conical bore [left, right].")
    material: object = declare(MATERIAL, None, meaning="Its material where it is another than that of the shaft.")


@dataclass(frozen=True, kw_only=True)
class SleeveKeys:
    """A sleeve on the shaft, which bends with it and adds to its stiffness."""

    at: object = declare(PLACE, meaning="Place of its left end.")
    length: float = declare(LENGTH, meaning="Length.")
    diameter: tuple = declare(Ends(LENGTH), meaning="Outer diameter; of a cone [left, right].")
    bore: tuple = declare(Ends(DIAMETER), None, meaning="Inner diameter, by default that of the shaft at its left end.")
    material: object = declare(MATERIAL, None, meaning="Its material where it is another than that of the shaft.")


@dataclass(frozen=True, kw_only=True)
class DiskKeys:
    """A rigid disk: with its mass and inertias, or with its shape."""

    name: str | None = declare(Text(), None, meaning="Its name, which stands for its place.")
    at: object = declare(PLACE, meaning="Place of its centre of mass.")
    mass: float | None = declare(Number("mass", above=0.0), None, meaning="Mass.")
    polar_inertia: float | None = declare(Number("inertia", low=0.0), None, meaning="Moment of inertia about the axis.")
    diametral_inertia: float | None = declare(Number("inertia", low=0.0), None, meaning="Moment of inertia about a diameter.")
    diameter: float | None = declare(LENGTH, None, meaning="Outer diameter.")
    width: float | None = declare(LENGTH, None, meaning="Width.")
    bore: float | None = declare(DIAMETER, None, meaning="Diameter of its bore, by default that of the shaft there.")
    material: object = declare(MATERIAL, None, meaning="Its material where it is another than that of the shaft.")


@dataclass(frozen=True, kw_only=True)
class BearingKeys:
    """A bearing or seal between shaft and ground."""

    name: str | None = declare(Text(), None, meaning="Its name, which stands for its place.")
    at: object = declare(PLACE, meaning="Place of its middle.")
    stiffness: object = declare(STIFFNESS, None, meaning="Stiffness, the same in every direction or [xx, xy, yx, yy].")
    damping: object = declare(DAMPING, None, meaning="Damping, the same in every direction or [xx, xy, yx, yy].")
    table: str | None = declare(
        Text(), None, meaning="CSV file of coefficients over the rotor speed, with units in its first line; beside the scene."
    )
    tilt_stiffness: float = declare(Number("tilt stiffness", low=0.0), 0.0, meaning="Stiffness against tilting.")
    tilt_damping: float = declare(Number("tilt damping", low=0.0), 0.0, meaning="Damping of tilting.")

    one_of = ((("stiffness", "table"), OPTIONAL), (("damping", "table"), OPTIONAL))


@dataclass(frozen=True, kw_only=True)
class UnbalanceKeys:
    """An unbalance in a plane."""

    at: object = declare(PLACE, meaning="Place of its plane.")
    amount: object = declare(
        Later("an amount in kg m, or a grade such as \"G 6.3\"", (Number("unbalance"), Text())),
        meaning="Amount, or a balance grade of the whole rotor, which is shared where two planes have it.",
    )
    angle: float = declare(Number("angle in degrees", low=-1e6, high=1e6), 0.0, meaning="Angle ahead of the rotor's y axis.")


@dataclass(frozen=True, kw_only=True)
class LoadKeys:
    """A constant force."""

    at: object = declare(PLACE, meaning="Place where it acts.")
    force: complex = declare(PairReader("force"), meaning="Its components [f_y, f_z].")


@dataclass(frozen=True, kw_only=True)
class _Shaft:
    """A shaft by its stations."""

    sections: tuple = declare(Tables(SectionKeys, 1), meaning="Its sections from the left end on.")
    material: object = declare(MATERIAL, "steel", meaning="Material of sections and disks that name none.")
    sleeves: tuple = declare(Tables(SleeveKeys), (), meaning="Sleeves on the sections, which add to their stiffness.")
    disks: tuple = declare(Tables(DiskKeys), (), meaning="Disks, impellers, couplings: what turns and is rigid.")
    bearings: tuple = declare(Tables(BearingKeys, 1), meaning="Bearings, seals and other springs to the ground.")
    elements: int | None = declare(
        Integer(1, 1000),
        None,
        meaning="Elements between two stations each; by default so many that halving them changes the lowest modes by < 1e-4.",
    )
    shear: bool = declare(Flag(), True, meaning="Whether shear deforms the shaft (Timoshenko); false for comparisons.")
    rayleigh: object = declare(
        RAYLEIGH, None, meaning="Damping alpha M + beta K from mass and stiffness of the shaft without its disks; does not turn."
    )
    observers: object = declare(
        Later("a list of places", (Sequence(PLACE.forms[0]), Sequence(Text()))),
        (),
        meaning="Places whose displacements can be recovered from a result.",
    )

    model = "shaft"
    n_coordinates = 0
    tilts = ()


@dataclass(frozen=True, kw_only=True)
class ShaftRotor(_Shaft):
    """[rotor] model = "shaft": a shaft by its stations, sections, disks and bearings, as they stand in its drawing."""

    shaft_damping: float | None = declare(
        Number("time", low=0.0),
        None,
        meaning="Internal damping, which turns with the shaft: this time multiplied by its stiffness, 2 zeta / omega.",
    )
    unbalance: object = declare(
        Later(
            "a list of tables {at, amount, angle}, or a grade such as \"G 6.3\" for the whole rotor",
            (Text(), Tables(UnbalanceKeys)),
        ),
        (),
        meaning="Unbalances; of a grade every disk has the share of the mass nearer to it than to the others, all at angle 0.",
    )
    load: tuple = declare(Tables(LoadKeys), (), meaning="Constant forces.")
    gravity: float | None = declare(
        Number("acceleration", low=0.0, high=1e6), None, meaning="Acceleration of gravity along -z; every mass gets its weight."
    )


@dataclass(frozen=True, kw_only=True)
class ShaftStator(_Shaft):
    """[stator] model = "shaft": a column or casing by its sections, which does not turn; its bearings are what holds it."""
