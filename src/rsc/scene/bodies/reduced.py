"""Bodies of finite-element models: [rotor] and [stator] with model "machine" in a scene file, "reduced" once the scene is read.

A "machine" refers to a file written by `rsc import` and has unbalances, loads and bearings at its nodes. Reading the scene
reduces it (machines.py) to the few coordinates of a "reduced" body; the first is the displacement at the contact, with several
contacts the first ones are those at each contact. A result contains the reduced body and no longer needs the file.
"""

import itertools
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rsc.scene.bodies.body_model import LOAD, MASS, BodyModel, RotorModel
from rsc.scene.bodies.controls import BEARINGS_MEANING, MACHINE_BEARINGS, STATES_MEANING
from rsc.scene.bodies.controls import STATES as PLACED
from rsc.scene.bodies.drawn import DrawnReader
from rsc.scene.bodies.off import OFF
from rsc.scene.bodies.part_list import BearingRowReader, ShaftPartReader, mirrored_rows
from rsc.scene.bodies.states import HasStates, MagneticBearing
from rsc.scene.files.matrix_files import MatrixReader, is_definite, refuse_asymmetric
from rsc.scene.keys import mirror
from rsc.scene.keys.keys import RawTable, declare
from rsc.scene.keys.nested import Inner
from rsc.scene.keys.readers import Flag, Integer, Keyed, Later, Listed, Number, PairReader, Sequence, Text
from rsc.system.knots import ANISOTROPIC, FOLLOWING

NODE = Integer(-(10**9), 10**9)
BETWEEN = Listed((NODE, NODE, Number("dimensionless")))
PLACE = Later("a node (number or name), or [node, node, fraction of the distance]", (NODE, Text(), BETWEEN))
AGAINST = Keyed(dict.fromkeys(("node", "against"), PLACE))
ROTOR_PLACE = Later("a node, [node, node, fraction of the distance], or {node = ..., against = ...}", (*PLACE.forms, AGAINST))
AMOUNT = Number("unbalance")
UNBALANCES = Later(
    "a list of [node, amount in kg m or a grade such as \"G 6.3\" or \"G 6.3 at 3000 rpm\"] or [node, amount, angle in degrees]",
    (Sequence(Listed((NODE, AMOUNT))), Sequence(Listed((NODE, AMOUNT, Number("angle in degrees"))))),
)
LOADS = Later("a list of [node, [f_y, f_z] in N]", (Sequence(Listed((NODE, PairReader("force")))),))

COEFFICIENTS = Sequence(Number("stiffness")), Sequence(Number("damping"))
_SWITCHED = {"node": NODE, "stiffness": COEFFICIENTS[0], "damping": COEFFICIENTS[1], "off": OFF}
BEARINGS = Later(
    "a list of [node, stiffness in N/m], [node, stiffness, damping in N s/m] or {node, stiffness, damping, off = time in s}, "
    "stiffness and damping one number or [yy, yz, zy, zz]",
    (
        Sequence(Keyed(_SWITCHED)),
        *(
        Sequence(Listed((node, *forms)))
        for node in (NODE, Text())
        for stiffness in (Number("stiffness"), COEFFICIENTS[0])
        for forms in ((stiffness,), (stiffness, Number("damping")), (stiffness, COEFFICIENTS[1]))
        ),
    ),
)

COMPLEX_MATRIX = Sequence(Sequence(PairReader("dimensionless")))
KNOTS, COMPLEX_KNOTS = Sequence(MatrixReader()), Sequence(COMPLEX_MATRIX)
_ROW = Sequence(Number("dimensionless"))
REDUCED_BEARINGS = Later(
    "a list of [row of the actuator, row of the sensor, {...}]", (Sequence(Listed((_ROW, _ROW, Inner(MagneticBearing)))),)
)
MORE = "Additions at the knots to the"
UNTIL = "Additions until each of the off_times to the"


@dataclass(frozen=True, kw_only=True)
class _Machine:
    """A body in a file of `rsc import`."""

    file: str = declare(Text(), meaning="File written by `rsc import`, relative to the folder of the scene.")
    sha256: str | None = declare(Text(), None, meaning="SHA-256 of the file; a different file is refused.")
    contact: object = declare(PLACE, None, meaning="Node at the contact, by number or name, or a position between two nodes.")
    observers: object = declare(
        Later("a list of nodes", (Sequence(NODE),)), (), meaning="Nodes whose displacements can be recovered from a result."
    )

    model = "machine"
    n_coordinates = 0
    tilts = ()


@dataclass(frozen=True, kw_only=True)
class MachineRotor(_Machine):
    """[rotor] model = "machine": a rotor with its bearings from a finite-element program."""

    contact: object = declare(
        ROTOR_PLACE,
        None,
        meaning="Node at the contact, by number or name, or a position between two; {node = 12, against = 57}: two in contact.",
    )
    bearings: object = declare(BEARINGS, (), meaning="Bearings and seals from nodes to ground, in addition to those in the file.")
    magnetic_bearings: object = declare(
        MACHINE_BEARINGS, None, meaning=f"{BEARINGS_MEANING}, as [node, table of numbers]; `sensor`: another node (below)."
    )
    states: object = declare(PLACED, None, meaning=STATES_MEANING)
    unbalance: object = declare(UNBALANCES, (), meaning="Unbalances at nodes, with angles ahead of the y axis.")
    load: object = declare(LOADS, (), meaning="Constant forces at nodes.")
    gravity: float | None = declare(
        Number("acceleration", low=0.0, high=1e6),
        None,
        meaning="Acceleration of gravity along -z; the weight of every mass acts as constant load.",
    )


@dataclass(frozen=True, kw_only=True)
class MachineStator(_Machine):
    """[stator] model = "machine": a casing from a finite-element program."""


@dataclass(frozen=True, kw_only=True)
class Reduction:
    """[reduction]: accuracy and band of the reduction of finite-element models."""

    tolerance: float = declare(
        Number("dimensionless", low=1e-10, high=0.1),
        1e-4,
        meaning="Relative error of the receptance at the contact over the band, and of the unbalance response over the speeds.",
    )
    band: object = declare(
        Later("[lowest, highest] frequency in Hz", (Listed((Number("frequency"), Number("frequency"))),)),
        None,
        meaning="Range of whirl frequencies; default: -12 to 6 times the highest speed, at least -500 to 250 Hz.",
    )


@dataclass(frozen=True, kw_only=True)
class _Reduced(BodyModel):
    """A reduced body: coordinates of equal mass, the first being the displacement at the contact; with several contacts the first
    ones, which have a separate mass matrix."""

    mass: float = declare(MASS, meaning="Effective mass at the contact, equal for all coordinates.")
    contact_masses: tuple | None = declare(
        MatrixReader(), None, meaning="Mass matrix of the first coordinates with several contacts."
    )
    stiffness: tuple = declare(
        MatrixReader(), meaning="Stiffness matrix, symmetric and positive definite; of a free rotor semidefinite."
    )
    damping: tuple = declare(MatrixReader(), meaning="Damping matrix, symmetric.")
    skew_stiffness: tuple | None = declare(
        MatrixReader(), None, meaning="Cross-coupled stiffness S, symmetric: K + i S.", mirror=mirror.negative
    )
    skew_damping: tuple | None = declare(
        MatrixReader(), None, meaning="Cross-coupled damping Q, symmetric: B + i Q.", mirror=mirror.negative
    )
    anisotropic_stiffness: tuple | None = declare(
        COMPLEX_MATRIX,
        None,
        meaning="Stiffness E that acts on the conjugate, complex symmetric, entries [real, imaginary].",
        mirror=mirror.conjugates,
    )
    anisotropic_damping: tuple | None = declare(
        COMPLEX_MATRIX, None, meaning="Damping C that acts on the conjugate.", mirror=mirror.conjugates
    )
    observers: tuple = declare(Sequence(Text()), (), meaning="Names of the observed nodes.")
    observer_rows: tuple = declare(
        Sequence(Sequence(Number("dimensionless"))), (), meaning="Rows that give the displacement of every observed node."
    )
    observer_errors: tuple = declare(
        Sequence(Number("dimensionless", low=0.0)), (), meaning="Error at every observed node, relative to its largest response."
    )
    origin: str = declare(Text(), meaning="Origin of the reduced body.")
    coordinates_before: int = declare(Integer(1, 10**9), meaning="Complex coordinates of the full body.")
    tolerance: float = declare(Number("dimensionless", above=0.0), meaning="Requested tolerance.")
    error: float = declare(Number("dimensionless", low=0.0), meaning="Error achieved at the contact.")
    directions_error: float | None = declare(
        Number("dimensionless", low=0.0), None, meaning="The same with anisotropic supports, for lines at Psi and -Psi."
    )
    band: tuple = declare(
        Sequence(Number("frequency")), meaning="Range of whirl frequencies for which it is valid.", mirror=mirror.turned
    )
    speeds: tuple = declare(Sequence(Number("frequency")), meaning="Rotor speeds for which it is valid.", mirror=mirror.turned)
    coefficients_at: float | None = declare(
        Number("frequency"),
        None,
        meaning="Rotor speed at which coefficients of bearings and seals were evaluated.",
        mirror=mirror.negative,
    )
    highest_before: float = declare(Number("frequency", above=0.0), meaning="Highest natural frequency of the full body.")
    highest_after: float = declare(Number("frequency", above=0.0), meaning="Highest natural frequency of the reduced body.")

    model = "reduced"

    @property
    def n_coordinates(self) -> int:
        """Number of coordinates."""
        return len(self.stiffness)

    def mass_matrix(self) -> Any:
        """The same mass on the diagonal for all coordinates, except those of several contacts."""
        matrix, c = self.mass * np.eye(self.n_coordinates), self.n_touching
        if c > 1:
            matrix[:c, :c] = self.contact_masses
        return matrix

    @property
    def n_touching(self) -> int:
        """Number of coordinates that are displacements at contacts."""
        return 1 if self.contact_masses is None else len(self.contact_masses)

    def mass_at(self, i: int) -> float:
        """Effective mass at contact i in kg, with other contacts free; for other coordinates their mass."""
        if i >= self.n_touching or self.contact_masses is None:
            return self.mass
        return float(1.0 / np.linalg.inv(np.array(self.contact_masses))[i, i])

    def stiffness_matrix(self) -> Any:
        """As stored."""
        return self.stiffness

    def damping_matrix(self) -> Any:
        """As stored."""
        return self.damping

    @staticmethod
    def resolve(values: Any, table: RawTable) -> None:
        """Check the matrices; there must be no rigid-body motion."""
        _check(values, table, free=False)


def _check(values: Any, table: RawTable, free: bool) -> None:
    """Check the matrices of a reduced body; free: whether there may be rigid-body motions."""
    count = len(values["stiffness"])
    for key in ("stiffness", "damping", "skew_stiffness", "skew_damping", "gyroscopic"):
        if values.get(key) is not None:
            refuse_asymmetric(table, key, values[key], count)
    for key in ("anisotropic_stiffness", "anisotropic_damping"):
        matrix = values[key]
        if matrix is not None and (len(matrix) != count or any(len(row) != count for row in matrix)):
            table.refuse(key, matrix, f"a {count} x {count} matrix of pairs")
    masses = values["contact_masses"]
    if masses is not None:
        refuse_asymmetric(table, "contact_masses", masses, len(masses))
        if not 1 < len(masses) <= count or not is_definite(masses, strictly=True):
            table.refuse("contact_masses", masses, f"positive definite, of 2 to {count} coordinates")
    if not is_definite(values["stiffness"], strictly=not free):
        table.refuse("stiffness", values["stiffness"], f"positive {'semi' if free else ''}definite")
    for key in ("band", "speeds"):
        if len(values[key]) != 2 or not values[key][0] <= values[key][1]:
            table.refuse(key, values[key], "[lowest, highest]")
    rows = values["observer_rows"]
    if len(rows) != len(values["observers"]) or any(len(row) != count for row in rows):
        table.refuse("observer_rows", rows, f"a row of {count} numbers for each of the observers")


@dataclass(frozen=True, kw_only=True)
class ReducedRotor(HasStates, _Reduced, RotorModel):
    """[rotor] model = "reduced": result of reading a "machine"."""

    magnetic_bearings: tuple | None = declare(
        REDUCED_BEARINGS, None, meaning=f"{BEARINGS_MEANING}, as [row of the actuator, row of the sensor, table of numbers]."
    )
    gyroscopic: tuple | None = declare(MatrixReader(), None, meaning="Gyroscopic matrix G, symmetric.")
    rotating_damping: tuple | None = declare(
        MatrixReader(), None, meaning="Rotating damping D_i (r' - i Omega r), symmetric."
    )
    knot_speeds: tuple | None = declare(
        Sequence(Number("frequency")),
        None,
        meaning="Rotor speeds of the matrices `..._knots`, linear in between, constant beyond.",
        mirror=mirror.turned,
    )
    stiffness_knots: tuple | None = declare(KNOTS, None, meaning=f"{MORE} stiffness.", mirror=mirror.reversed_order)
    damping_knots: tuple | None = declare(KNOTS, None, meaning=f"{MORE} damping.", mirror=mirror.reversed_order)
    skew_stiffness_knots: tuple | None = declare(
        KNOTS, None, meaning=f"{MORE} cross-coupled stiffness.", mirror=mirror.turned
    )
    skew_damping_knots: tuple | None = declare(KNOTS, None, meaning=f"{MORE} cross-coupled damping.", mirror=mirror.turned)
    anisotropic_stiffness_knots: tuple | None = declare(
        COMPLEX_KNOTS, None, meaning=f"{MORE} stiffness that acts on the conjugate.", mirror=mirror.reversed_conjugates
    )
    anisotropic_damping_knots: tuple | None = declare(
        COMPLEX_KNOTS, None, meaning=f"{MORE} damping that acts on the conjugate.", mirror=mirror.reversed_conjugates
    )
    off_times: tuple | None = declare(
        Sequence(OFF), None, meaning="Times at which bearings are switched off; the matrices `..._until` are theirs."
    )
    stiffness_until: tuple | None = declare(KNOTS, None, meaning=f"{UNTIL} stiffness.")
    damping_until: tuple | None = declare(KNOTS, None, meaning=f"{UNTIL} damping.")
    skew_stiffness_until: tuple | None = declare(
        KNOTS, None, meaning=f"{UNTIL} cross-coupled stiffness.", mirror=mirror.negative
    )
    skew_damping_until: tuple | None = declare(KNOTS, None, meaning=f"{UNTIL} cross-coupled damping.", mirror=mirror.negative)
    anisotropic_stiffness_until: tuple | None = declare(
        COMPLEX_KNOTS, None, meaning=f"{UNTIL} stiffness that acts on the conjugate.", mirror=mirror.each_conjugates
    )
    anisotropic_damping_until: tuple | None = declare(
        COMPLEX_KNOTS, None, meaning=f"{UNTIL} damping that acts on the conjugate.", mirror=mirror.each_conjugates
    )
    unbalance: tuple = declare(Sequence(PairReader("unbalance")), meaning="Unbalance of every coordinate, multiplied by Omega^2.")
    load: tuple = declare(LOAD, meaning="Constant force on every coordinate.")
    allow_negative_damping: bool = declare(Flag(), False, meaning="Allow negative damping.")
    drawn: tuple | None = declare(Sequence(DrawnReader()), None, meaning="Parts of a shaft, for its drawing.")
    nodes: tuple | None = declare(Sequence(Number("length", low=0.0)), None, meaning="Positions of the nodes of a shaft.")
    node_rows: tuple | None = declare(
        Sequence(Sequence(Number("dimensionless"))), None, meaning="Rows that give the displacement of every one of `nodes`."
    )
    parts: tuple | None = declare(Sequence(ShaftPartReader()), None, meaning="Masses and moments of inertia of a shaft.")
    bearing_rows: tuple | None = declare(
        Sequence(BearingRowReader()), None, meaning="Coefficients of the bearings of a shaft.", mirror=mirrored_rows
    )

    @property
    def total_mass(self) -> float:
        """Mass of a shaft with its disks in kg; NaN of a machine given by matrices."""
        return sum(part.mass for part in self.parts) if self.parts else math.nan

    @property
    def at_end(self) -> "ReducedRotor":
        """The rotor without the bearings that are switched off."""
        without: dict[str, Any] = {f"{name}_until": None for name in FOLLOWING}
        return replace(super().at_end, off_times=None, **without)

    def knots(self) -> Any:
        """As stored."""
        if self.knot_speeds is None:
            return None
        parts = {name: getattr(self, f"{name}_knots") for name in FOLLOWING}
        return self.knot_speeds, {name: part for name, part in parts.items() if part is not None}

    @staticmethod
    def resolve(values: Any, table: RawTable) -> None:
        """Check the matrices, including those of the knots, and the unbalance."""
        _check(values, table, free=True)
        count = len(values["stiffness"])
        if values["rotating_damping"] is not None:
            refuse_asymmetric(table, "rotating_damping", values["rotating_damping"], count)
        _refuse_other_knots(values, table, count)
        _refuse_other_times(values, table, count)
        _refuse_other_nodes(values, table, count)
        if len(values["unbalance"]) != count:
            table.refuse("unbalance", values["unbalance"], f"a list of {count} pairs")


def _refuse_other_nodes(values: Any, table: RawTable, count: int) -> None:
    """Check that nodes have increasing positions and a row for each."""
    nodes, rows = values["nodes"] or (), values["node_rows"] or ()
    if any(not b > a for a, b in itertools.pairwise(nodes)):
        table.refuse("nodes", list(nodes), "increasing positions")
    if len(rows) != len(nodes) or any(len(row) != count for row in rows):
        table.refuse("node_rows", None, f"a row of {count} numbers for each of the {len(nodes)} nodes")


def _refuse_other_knots(values: Any, table: RawTable, count: int) -> None:
    """Check that knots have increasing speeds, a symmetric matrix for each, and a positive definite stiffness."""
    speeds = values["knot_speeds"]
    if speeds is not None and (len(speeds) < 2 or any(not b > a for a, b in itertools.pairwise(speeds))):
        table.refuse("knot_speeds", list(speeds), "two or more increasing rotor speeds")
    _refuse_other_matrices(values, table, count, ("knots", "knot_speeds", speeds))
    for i, more in enumerate(values["stiffness_knots"] or ()):
        if not is_definite(np.add(values["stiffness"], more), strictly=False):
            table.refuse(f"stiffness_knots[{i}]", None, "such that the stiffness at every knot is positive semidefinite")


def _refuse_other_times(values: Any, table: RawTable, count: int) -> None:
    """Check that times of switching off increase, and that each has its matrices."""
    times = values["off_times"]
    if times is not None and (not times or any(not b > a for a, b in itertools.pairwise(times))):
        table.refuse("off_times", list(times), "increasing times")
    _refuse_other_matrices(values, table, count, ("until", "off_times", times))


def _refuse_other_matrices(values: Any, table: RawTable, count: int, along: tuple[str, str, Any]) -> None:
    """Check the matrices along speeds or times; along: end of their keys, key of the speeds or times, these or None."""
    end, places, required = along
    for name in FOLLOWING:
        key = f"{name}_{end}"
        if values[key] is None:
            continue
        if required is None or len(values[key]) != len(required):
            table.refuse(key, None, f"a matrix for each of the {len(required or ())} {places}")
        for i, matrix in enumerate(values[key]):
            if len(matrix) != count or any(len(row) != count for row in matrix):
                table.refuse(f"{key}[{i}]", None, f"a {count} x {count} matrix")
            if name not in ANISOTROPIC:
                refuse_asymmetric(table, f"{key}[{i}]", matrix, count)


@dataclass(frozen=True, kw_only=True)
class ReducedStator(_Reduced):
    """[stator] model = "reduced": result of reading a "machine"."""
