"""Bodies of finite-element models: [rotor] and [stator] with model "machine" in a scene file, "reduced" once the scene is read.

A "machine" names a file that `rsc import` wrote and what happens at its nodes. Reading the scene reduces it (machines.py) to the
few coordinates of a "reduced" body, of which the first is the displacement at the contact; of several contacts the first ones are
those at each. That is what a result keeps: it needs the file no more.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from rsc.scene.bodies.body_model import LOAD, MASS, BodyModel, RotorModel
from rsc.scene.files.matrix_files import MatrixReader, is_definite, refuse_asymmetric
from rsc.scene.keys import mirror
from rsc.scene.keys.keys import Flag, Integer, Keyed, Later, Listed, Number, PairReader, Sequence, Text, declare
from rsc.system.knots import ANISOTROPIC, FOLLOWING

NODE = Integer(-(10**9), 10**9)
BETWEEN = Listed((NODE, NODE, Number("dimensionless")))
PLACE = Later("a node (number or name), or [node, node, share of the way]", (NODE, Text(), BETWEEN))
AGAINST = Keyed(dict.fromkeys(("node", "against"), PLACE))
ROTOR_PLACE = Later("a node, [node, node, share of the way], or {node = ..., against = ...}", (*PLACE.forms, AGAINST))
AMOUNT = Number("unbalance")
UNBALANCES = Later(
    "a list of [node, amount in kg m or a grade such as \"G 6.3\"] or [node, amount, angle in degrees]",
    (Sequence(Listed((NODE, AMOUNT))), Sequence(Listed((NODE, AMOUNT, Number("angle in degrees"))))),
)
LOADS = Later("a list of [node, [f_y, f_z] in N]", (Sequence(Listed((NODE, PairReader("force")))),))


COEFFICIENTS = Sequence(Number("stiffness")), Sequence(Number("damping"))
BEARINGS = Later(
    "a list of [node, stiffness in N/m] or [node, stiffness, damping in N s/m], each one number or [xx, xy, yx, yy]",
    tuple(
        Sequence(Listed((node, *forms)))
        for node in (NODE, Text())
        for stiffness in (Number("stiffness"), COEFFICIENTS[0])
        for forms in ((stiffness,), (stiffness, Number("damping")), (stiffness, COEFFICIENTS[1]))
    ),
)

COMPLEX_MATRIX = Sequence(Sequence(PairReader("dimensionless")))
KNOTS, COMPLEX_KNOTS = Sequence(MatrixReader()), Sequence(COMPLEX_MATRIX)
MORE = "At each of the knots, what is added to the"


@dataclass(frozen=True, kw_only=True)
class _Machine:
    """A body in a file of `rsc import`."""

    file: str = declare(Text(), meaning="File that `rsc import` wrote, beside the scene.")
    sha256: str | None = declare(Text(), None, meaning="SHA-256 of that file: another one is refused.")
    contact: object = declare(PLACE, None, meaning="Node at the contact, by number or name, or a place between two nodes.")
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
        meaning="Node at the contact, by number or name, or a place between two; {node = 12, against = 57}: two that touch.",
    )
    bearings: object = declare(BEARINGS, (), meaning="Bearings and seals from nodes to the ground, besides those in the file.")
    unbalance: object = declare(UNBALANCES, (), meaning="Unbalances at nodes, with their angles ahead of the y axis.")
    load: object = declare(LOADS, (), meaning="Constant forces at nodes.")
    gravity: float | None = declare(
        Number("acceleration", low=0.0, high=1e6), None, meaning="Acceleration of gravity along -z; every mass gets its weight."
    )


@dataclass(frozen=True, kw_only=True)
class MachineStator(_Machine):
    """[stator] model = "machine": a casing from a finite-element program."""


@dataclass(frozen=True, kw_only=True)
class Reduction:
    """[reduction]: how closely bodies of finite-element models are reduced."""

    tolerance: float = declare(
        Number("dimensionless", low=1e-10, high=0.1),
        1e-4,
        meaning="Relative error of the receptance at the contact over the band, and of the unbalance response over the speeds.",
    )
    band: object = declare(
        Later("[lowest, highest] frequency in Hz", (Listed((Number("frequency"), Number("frequency"))),)),
        None,
        meaning="Frequencies of whirls; by default -12 to 6 times the highest speed, at least -500 to 250 Hz.",
    )


@dataclass(frozen=True, kw_only=True)
class _Reduced(BodyModel):
    """A reduced body: coordinates of one mass, the first the displacement at the contact; of several contacts the first ones,
    which have a mass matrix of their own."""

    mass: float = declare(MASS, meaning="Effective mass at the contact, that of every coordinate.")
    contact_masses: tuple | None = declare(
        MatrixReader(), None, meaning="Mass matrix of the coordinates at several contacts, the first ones."
    )
    stiffness: tuple = declare(MatrixReader(), meaning="Stiffness matrix, symmetric and positive definite.")
    damping: tuple = declare(MatrixReader(), meaning="Damping matrix, symmetric.")
    skew_stiffness: tuple | None = declare(
        MatrixReader(), None, meaning="Cross-coupled stiffness S, symmetric: K + i S.", mirror=mirror.negative
    )
    skew_damping: tuple | None = declare(
        MatrixReader(), None, meaning="Cross-coupled damping Q, symmetric: B + i Q.", mirror=mirror.negative
    )
    anisotropic_stiffness: tuple | None = declare(
        COMPLEX_MATRIX, None, meaning="Stiffness E that acts on the conjugate, complex symmetric, entries [real, imaginary]."
    )
    anisotropic_damping: tuple | None = declare(COMPLEX_MATRIX, None, meaning="Damping C that acts on the conjugate.")
    observers: tuple = declare(Sequence(Text()), (), meaning="Names of the observed nodes.")
    observer_rows: tuple = declare(
        Sequence(Sequence(Number("dimensionless"))), (), meaning="Displacement of every observed node, as a row."
    )
    observer_errors: tuple = declare(
        Sequence(Number("dimensionless", low=0.0)), (), meaning="Error reached at every observed node, of its largest response."
    )
    origin: str = declare(Text(), meaning="What was reduced.")
    coordinates_before: int = declare(Integer(1, 10**9), meaning="Complex coordinates of the full body.")
    tolerance: float = declare(Number("dimensionless", above=0.0), meaning="Tolerance asked for.")
    error: float = declare(Number("dimensionless", low=0.0), meaning="Error reached at the contact.")
    directions_error: float | None = declare(
        Number("dimensionless", low=0.0), None, meaning="The same with directions as they differ, of lines at plus and minus Psi."
    )
    band: tuple = declare(
        Sequence(Number("frequency")), meaning="Frequencies of whirls that it holds for.", mirror=mirror.turned
    )
    speeds: tuple = declare(Sequence(Number("frequency")), meaning="Rotor speeds that it holds for.", mirror=mirror.turned)
    coefficients_at: float | None = declare(
        Number("frequency"),
        None,
        meaning="Rotor speed at which coefficients of bearings and seals were taken.",
        mirror=mirror.negative,
    )
    highest_before: float = declare(Number("frequency", above=0.0), meaning="Highest natural frequency of the full body.")
    highest_after: float = declare(Number("frequency", above=0.0), meaning="Highest natural frequency left.")

    model = "reduced"

    @property
    def n_coordinates(self) -> int:
        """Number of coordinates."""
        return len(self.stiffness)

    def mass_matrix(self):
        """One mass for all coordinates, but for those at several contacts."""
        matrix, c = self.mass * np.eye(self.n_coordinates), self.n_touching
        if c > 1:
            matrix[:c, :c] = self.contact_masses
        return matrix

    @property
    def n_touching(self) -> int:
        """Number of coordinates that are displacements at contacts."""
        return 1 if self.contact_masses is None else len(self.contact_masses)

    def mass_at(self, i):
        """Effective mass at contact i in kg, which that at another contact does not change; elsewhere that of a coordinate."""
        if i >= self.n_touching or self.contact_masses is None:
            return self.mass
        return float(1.0 / np.linalg.inv(np.array(self.contact_masses))[i, i])

    def stiffness_matrix(self):
        """As stored."""
        return self.stiffness

    def damping_matrix(self):
        """As stored."""
        return self.damping

    @staticmethod
    def resolve(values, table):
        """Check the matrices; no motion may be free of force."""
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
        if not is_definite(values["stiffness"], strictly=True):
            table.refuse("stiffness", values["stiffness"], "positive definite")
        for key in ("band", "speeds"):
            if len(values[key]) != 2 or not values[key][0] <= values[key][1]:
                table.refuse(key, values[key], "[lowest, highest]")
        rows = values["observer_rows"]
        if len(rows) != len(values["observers"]) or any(len(row) != count for row in rows):
            table.refuse("observer_rows", rows, f"a row of {count} numbers for each of the observers")


@dataclass(frozen=True, kw_only=True)
class ReducedRotor(_Reduced, RotorModel):
    """[rotor] model = "reduced": what becomes of a "machine" when its scene is read."""

    gyroscopic: tuple | None = declare(MatrixReader(), None, meaning="Gyroscopic matrix G, symmetric.")
    rotating_damping: tuple | None = declare(
        MatrixReader(), None, meaning="Damping of what turns with the rotor, D_i (r' - i Omega r), symmetric."
    )
    knot_speeds: tuple | None = declare(
        Sequence(Number("frequency")),
        None,
        meaning="Rotor speeds at which the matrices of `..._knots` are added, linear in between, constant beyond.",
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
    unbalance: tuple = declare(Sequence(PairReader("unbalance")), meaning="Unbalance of every coordinate, multiplied by Omega^2.")
    load: tuple = declare(LOAD, meaning="Constant force on every coordinate.")
    allow_negative_damping: bool = declare(Flag(), False, meaning="Allows damping that feeds energy in.")

    def knots(self):
        """As stored."""
        if self.knot_speeds is None:
            return None
        parts = {name: getattr(self, f"{name}_knots") for name in FOLLOWING}
        return self.knot_speeds, {name: part for name, part in parts.items() if part is not None}

    @staticmethod
    def resolve(values, table):
        """Check the matrices, those of the knots too, and the unbalance."""
        _Reduced.resolve(values, table)
        count = len(values["stiffness"])
        if values["rotating_damping"] is not None:
            refuse_asymmetric(table, "rotating_damping", values["rotating_damping"], count)
        _refuse_other_knots(values, table, count)
        if len(values["unbalance"]) != count:
            table.refuse("unbalance", values["unbalance"], f"a list of {count} pairs")


def _refuse_other_knots(values, table, count):
    """Rotor speeds that rise, symmetric matrices for each of them, and a stiffness that holds the body at all of them."""
    speeds = values["knot_speeds"]
    if speeds is not None and (len(speeds) < 2 or any(not b > a for a, b in itertools.pairwise(speeds))):
        table.refuse("knot_speeds", list(speeds), "two or more rotor speeds, in order")
    for name in FOLLOWING:
        key = f"{name}_knots"
        if values[key] is None:
            continue
        if speeds is None or len(values[key]) != len(speeds):
            table.refuse(key, None, f"a matrix for each of the {len(speeds or ())} knot_speeds")
        for i, matrix in enumerate(values[key]):
            if len(matrix) != count or any(len(row) != count for row in matrix):
                table.refuse(f"{key}[{i}]", None, f"a {count} x {count} matrix")
            if name not in ANISOTROPIC:
                refuse_asymmetric(table, f"{key}[{i}]", matrix, count)
    for i, more in enumerate(values["stiffness_knots"] or ()):
        if not is_definite(np.add(values["stiffness"], more), strictly=True):
            table.refuse(f"stiffness_knots[{i}]", None, "such that the stiffness at every knot is positive definite")


@dataclass(frozen=True, kw_only=True)
class ReducedStator(_Reduced):
    """[stator] model = "reduced": what becomes of a "machine" when its scene is read."""
