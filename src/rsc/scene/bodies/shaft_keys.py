"""Keys of a shaft described by stations: [rotor] or [stator] with model "shaft"."""

from dataclasses import dataclass

from rsc.machine.shaft.parts import Material
from rsc.scene.bodies.body_model import RAYLEIGH
from rsc.scene.bodies.controls import BEARINGS_MEANING, STATES, STATES_MEANING
from rsc.scene.bodies.off import OFF, OFF_MEANING
from rsc.scene.bodies.reduced import COEFFICIENTS
from rsc.scene.bodies.states import MagneticBearing
from rsc.scene.keys.keys import OPTIONAL, declare
from rsc.scene.keys.nested import Ends, Tables
from rsc.scene.keys.readers import Choice, Flag, Integer, Keyed, Later, Number, PairReader, Sequence, Text

METRES = "a number without a unit is in m"
LENGTH, DIAMETER = Number("length", above=0.0, high=200.0, hint=METRES), Number("length", low=0.0, high=50.0, hint=METRES)
OUTER = Number("length", above=0.0, high=5.0, hint=METRES)
_WORDS = tuple((word, "bore") for word in ("inner_diameter", "bore_diameter", "id", "di")) + tuple(
    (word, "diameter") for word in ("outer_diameter", "od", "do", "radius")
)
FROM_LEFT, FROM_RIGHT = (Keyed({"section": Text(), end: Number("length")}) for end in ("left", "right"))
PLACE = Later(
    "a position: length from the left end, name of a disk or bearing, or {section = NAME, left = ...} or {..., right = ...}",
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
STIFFNESS = Later("a number in N/m, or [yy, yz, zy, zz]", (Number("stiffness"), _FOUR_STIFFNESSES))
DAMPING = Later("a number in N s/m, or [yy, yz, zy, zz]", (Number("damping"), _FOUR_DAMPINGS))


@dataclass(frozen=True, kw_only=True)
class MaterialKeys:
    """A user-defined material."""

    density: float = declare(Number("density", low=0.0), meaning="Density; 0 for a massless piece.")
    youngs_modulus: float = declare(Number("modulus", above=0.0), meaning="Young's modulus.")
    poisson: float = declare(Number("dimensionless", above=-1.0, high=0.5), 0.3, meaning="Poisson's ratio.")


@dataclass(frozen=True, kw_only=True)
class SectionKeys:
    """A piece of shaft."""

    name: str | None = declare(Text(), None, meaning="Name, for positions given relative to its ends.")
    length: float = declare(LENGTH, meaning="Length.")
    diameter: tuple = declare(Ends(OUTER), meaning="Outer diameter; [left, right] for a cone.")
    bore: tuple = declare(Ends(DIAMETER), (0.0, 0.0), meaning="Inner diameter, default 0; [left, right] for a conical bore.")
    material: object = declare(MATERIAL, None, meaning="Material, if different from that of the shaft.")

    called = _WORDS


@dataclass(frozen=True, kw_only=True)
class SleeveKeys:
    """A sleeve on the shaft, which bends with it and adds to its stiffness."""

    at: object = declare(PLACE, meaning="Position of its left end.")
    length: float = declare(LENGTH, meaning="Length.")
    diameter: tuple = declare(Ends(OUTER), meaning="Outer diameter; [left, right] for a cone.")
    bore: tuple = declare(Ends(DIAMETER), None, meaning="Inner diameter; default: that of the shaft at its left end.")
    material: object = declare(MATERIAL, None, meaning="Material, if different from that of the shaft.")

    called = _WORDS


@dataclass(frozen=True, kw_only=True)
class DiskKeys:
    """A rigid disk, given by mass and inertias or by its shape."""

    name: str | None = declare(Text(), None, meaning="Name, which can be used as a position.")
    at: object = declare(PLACE, meaning="Position of its centre of mass.")
    mass: float | None = declare(Number("mass", above=0.0), None, meaning="Mass.")
    polar_inertia: float | None = declare(Number("inertia", low=0.0), None, meaning="Moment of inertia about the axis.")
    diametral_inertia: float | None = declare(Number("inertia", low=0.0), None, meaning="Moment of inertia about a diameter.")
    diameter: float | None = declare(LENGTH, None, meaning="Outer diameter.")
    width: float | None = declare(LENGTH, None, meaning="Width.")
    bore: float | None = declare(DIAMETER, None, meaning="Diameter of its bore; default: that of the shaft there.")
    material: object = declare(MATERIAL, None, meaning="Material, if different from that of the shaft.")

    called = _WORDS


@dataclass(frozen=True, kw_only=True)
class BearingKeys:
    """A bearing or seal between shaft and ground."""

    name: str | None = declare(Text(), None, meaning="Name, which can be used as a position.")
    at: object = declare(PLACE, meaning="Position of its centre.")
    stiffness: object = declare(STIFFNESS, None, meaning="Stiffness, isotropic or [yy, yz, zy, zz].")
    damping: object = declare(DAMPING, None, meaning="Damping, isotropic or [yy, yz, zy, zz].")
    table: str | None = declare(
        Text(),
        None,
        meaning="CSV file of coefficients over the rotor speed, with units in its header; relative to the folder of the scene.",
    )
    tilt_stiffness: float = declare(Number("tilt stiffness", low=0.0), 0.0, meaning="Tilt stiffness.")
    tilt_damping: float = declare(Number("tilt damping", low=0.0), 0.0, meaning="Tilt damping.")
    off: float | None = declare(OFF, None, meaning=OFF_MEANING)

    one_of = ((("stiffness", "table"), OPTIONAL), (("damping", "table"), OPTIONAL))


@dataclass(frozen=True, kw_only=True)
class ShaftMagneticBearing(MagneticBearing):
    """A magnetic bearing with its controller, with its sensor at the same place or at another."""

    name: str | None = declare(Text(), None, meaning="Name, which can be used as a position.")
    at: object = declare(PLACE, meaning="Position of its actuator.")
    sensor_at: object = declare(PLACE, None, meaning="Position of its sensor, if another.")


@dataclass(frozen=True, kw_only=True)
class UnbalanceKeys:
    """An unbalance in a plane."""

    at: object = declare(PLACE, meaning="Position of its plane.")
    amount: object = declare(
        Later("an amount in kg m, or a grade such as \"G 6.3\" or \"G 6.3 at 3000 rpm\"", (Number("unbalance"), Text())),
        meaning="Amount, or a balance grade for the whole rotor, which is divided if two planes have it.",
    )
    angle: float = declare(Number("angle in degrees", low=-1e6, high=1e6), 0.0, meaning="Angle ahead of the rotor's y axis.")


@dataclass(frozen=True, kw_only=True)
class LoadKeys:
    """A constant force."""

    at: object = declare(PLACE, meaning="Position where it acts.")
    force: complex = declare(PairReader("force"), meaning="Components [f_y, f_z].")


@dataclass(frozen=True, kw_only=True)
class _Shaft:
    """A shaft described by stations."""

    sections: tuple = declare(Tables(SectionKeys, 1), meaning="Sections from the left end on.")
    material: object = declare(MATERIAL, "steel", meaning="Default material of sections and disks.")
    sleeves: tuple = declare(Tables(SleeveKeys), (), meaning="Sleeves on the sections, which add to their stiffness.")
    disks: tuple = declare(Tables(DiskKeys), (), meaning="Disks, impellers, couplings and other rigid rotating parts.")
    bearings: tuple = declare(Tables(BearingKeys), (), meaning="Bearings, seals and other springs to ground.")
    elements: int | None = declare(
        Integer(1, 1000),
        None,
        meaning="Elements between neighbouring stations; default: so many that halving them changes the lowest modes by < 1e-4.",
    )
    shear: bool = declare(Flag(), True, meaning="Whether shear deforms the shaft (Timoshenko); false for comparisons.")
    rayleigh: object = declare(
        RAYLEIGH, None, meaning="Rayleigh damping alpha M + beta K of the shaft without disks; not rotating."
    )
    observers: object = declare(
        Later("a list of positions", (Sequence(PLACE.forms[0]), Sequence(Text()))),
        (),
        meaning="Positions whose displacements can be recovered from a result.",
    )

    model = "shaft"
    n_coordinates = 0
    tilts = ()


@dataclass(frozen=True, kw_only=True)
class ShaftRotor(_Shaft):
    """[rotor] model = "shaft": a shaft described by sections, disks and bearings, as in its drawing."""

    shaft_damping: float | None = declare(
        Number("time", low=0.0),
        None,
        meaning="Internal (rotating) damping: this time constant times the stiffness of the shaft, 2 zeta / omega.",
    )
    magnetic_bearings: tuple = declare(
        Tables(ShaftMagneticBearing), (), meaning=f"{BEARINGS_MEANING}, as tables with positions (below)."
    )
    states: object = declare(STATES, None, meaning=STATES_MEANING)
    unbalance: object = declare(
        Later(
            "a list of tables {at, amount, angle}, or a grade such as \"G 6.3\" or \"G 6.3 at 3000 rpm\" for the whole rotor",
            (Text(), Tables(UnbalanceKeys)),
        ),
        (),
        meaning="Unbalances; with a grade every disk gets that of the mass nearest to it, all at angle 0.",
    )
    load: tuple = declare(Tables(LoadKeys), (), meaning="Constant forces.")
    gravity: float | None = declare(
        Number("acceleration", low=0.0, high=1e6),
        None,
        meaning="Acceleration of gravity along -z; the weight of every mass acts as constant load.",
    )


@dataclass(frozen=True, kw_only=True)
class ShaftStator(_Shaft):
    """[stator] model = "shaft": a non-rotating column or casing described by sections; its bearings are its supports."""
