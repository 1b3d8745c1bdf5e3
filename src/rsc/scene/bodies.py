"""The models of [rotor] and [stator]: their keys, defaults and refusals, as frozen dataclasses.

Every model has `model`, `n_coordinates`, `tilts` (indices of coordinates that are angles) and `mass_at(i)`.
What the scene says is kept (a frequency stays a frequency, a damping ratio a ratio), so that a sweep over the
mass does what its user meant; `rsc.system.assemble` turns it into matrices.
"""

from dataclasses import dataclass

from rsc.scene.keys import (
    MAX_COORDINATES,
    NO_ECCENTRICITY,
    Flag,
    Integer,
    Later,
    Listed,
    Number,
    PairReader,
    Polar,
    PolarReader,
    Sequence,
    declare,
    per_coordinate,
)
from rsc.scene.matrix_files import MatrixReader, is_definite, refuse_asymmetric

MASS = Number("mass", above=0.0)
STIFFNESS = Number("stiffness", low=0.0)
RATIO = Number("dimensionless", high=1.5, hint="a percentage? 5 % is 0.05")
RAYLEIGH = Later("two numbers [alpha in 1/s, beta in s]", (Listed((Number("rate"), Number("time"))),))
ECCENTRICITIES = Sequence(PolarReader("length"))
PER_COORDINATE = Later("a list with one number or [amount, angle in degrees] per coordinate", (ECCENTRICITIES,))
ONE_OR_PER_MASS = Later("a number for all masses, or " + PER_COORDINATE.wanted, (Number("length"), ECCENTRICITIES))
LOAD = Later("a list with one pair [f_y, f_z] in N per coordinate", (Sequence(PairReader("force")),))
COEFFICIENTS = Sequence(Number("stiffness"))
SUPPORTS = Later(
    "a list of [coordinate, [k_xx, k_xy, k_yx, k_yy] in N/m] or [coordinate, stiffness, [c_xx, c_xy, c_yx, c_yy] in N s/m]",
    (
        Sequence(Listed((Integer(0, MAX_COORDINATES), COEFFICIENTS))),
        Sequence(Listed((Integer(0, MAX_COORDINATES), COEFFICIENTS, Sequence(Number("damping"))))),
    ),
)
SUPPORTS_MEANING = "Bearings and seals that differ in x and y or are cross-coupled, besides the other stiffness and damping."
RAYLEIGH_MEANING = "Damping alpha M + beta K from the matrices of mass and stiffness."
ECCENTRICITY_MEANING = "Distance of the centre of mass from the shaft, and its angle ahead of the y axis."
RATIO_MEANING = "Damping ratio of every mode of this body alone, at standstill."


@dataclass(frozen=True, kw_only=True)
class _Loaded:
    """Keys that every rotor has: constant load and the leave for negative damping."""

    gravity: float | None = declare(
        Number("acceleration", low=0.0, high=1e6, hint="it acts along -z"),
        None,
        meaning="Acceleration of gravity along -z; every mass gets its weight as constant load.",
    )
    load: tuple | None = declare(LOAD, None, meaning="Constant force on every coordinate (N m on a tilt).")
    allow_negative_damping: bool = declare(
        Flag(), False, meaning="Allows damping that feeds energy in, which is refused otherwise."
    )


_LOAD_GROUP = ((("gravity", "load"), ("gravity", 0.0)),)


@dataclass(frozen=True, kw_only=True)
class _Laval:
    """One mass on an isotropic spring and dashpot."""

    mass: float = declare(MASS, meaning="Mass that moves.")
    frequency: float | None = declare(
        Number("frequency", above=0.0), None, meaning="Natural frequency without damping; it stands for the stiffness."
    )
    stiffness: float | None = declare(STIFFNESS, None, meaning="Stiffness of the spring, the same in every direction.")
    damping_ratio: float | None = declare(RATIO, None, meaning="Damping as a share of the critical damping.")
    damping: float | None = declare(Number("damping"), None, meaning="Damping constant of the dashpot.")
    supports: tuple = declare(SUPPORTS, (), meaning=SUPPORTS_MEANING)

    one_of = ((("frequency", "stiffness"), None), (("damping_ratio", "damping"), ("damping", 0.0)))
    model = "laval"
    n_coordinates = 1
    tilts = ()

    def mass_at(self, i: int) -> float:
        """Mass in kg on the diagonal at coordinate i."""
        return self.mass


@dataclass(frozen=True, kw_only=True)
class _Chain:
    """Masses in a row between two walls, with springs (and dashpots) wall-1, 1-2, ..., N-wall."""

    masses: tuple = declare(Sequence(MASS), meaning="Masses in their order, one coordinate each.")
    stiffnesses: tuple = declare(
        Sequence(STIFFNESS), meaning="Springs wall-1, 1-2, ..., N-wall, one more than masses; 0 for a free end."
    )
    damping_ratio: float | None = declare(RATIO, None, meaning=RATIO_MEANING)
    dampings: tuple | None = declare(Sequence(Number("damping")), None, meaning="Dashpots beside the springs, in their order.")
    rayleigh: tuple | None = declare(RAYLEIGH, None, meaning=RAYLEIGH_MEANING)
    supports: tuple = declare(SUPPORTS, (), meaning=SUPPORTS_MEANING)

    one_of = ((("damping_ratio", "dampings", "rayleigh"), ("dampings", ())),)
    model = "chain"
    tilts = ()

    @property
    def n_coordinates(self) -> int:
        """Number of masses."""
        return len(self.masses)

    def mass_at(self, i: int) -> float:
        """Mass in kg on the diagonal at coordinate i."""
        return self.masses[i]

    @staticmethod
    def resolve(values, table):
        """Check list lengths; dampings default to zeros."""
        count = len(values["masses"])
        if not 0 < count <= MAX_COORDINATES:
            table.refuse("masses", values["masses"], f"a list of 1 to {MAX_COORDINATES} masses")
        if values["dampings"] == () and "dampings" not in table.values:
            values["dampings"] = (0.0,) * (count + 1)
        for key in ("stiffnesses", "dampings"):
            if values[key] is not None and len(values[key]) != count + 1:
                hint = "wall-1, 1-2, ..., N-wall; 0 for a free end"
                table.refuse(key, values[key], f"a list of {count + 1} numbers for {count} masses", hint)


@dataclass(frozen=True, kw_only=True)
class _Matrices:
    """Any mass, damping and stiffness matrices."""

    mass: tuple = declare(MatrixReader(), meaning="Mass matrix, symmetric and positive definite.")
    stiffness: tuple = declare(
        MatrixReader(), meaning="Stiffness matrix, symmetric and positive semidefinite (of a stator: definite)."
    )
    damping: tuple | None = declare(MatrixReader(), None, meaning="Damping matrix, symmetric and positive semidefinite.")
    damping_ratio: float | None = declare(RATIO, None, meaning=RATIO_MEANING)
    rayleigh: tuple | None = declare(RAYLEIGH, None, meaning=RAYLEIGH_MEANING)
    skew_stiffness: tuple | None = declare(
        MatrixReader(), None, meaning="Cross-coupled stiffness S, symmetric, k_yx = -k_xy = S: K + i S in y + i z."
    )
    skew_damping: tuple | None = declare(MatrixReader(), None, meaning="Cross-coupled damping Q, symmetric: B + i Q.")
    supports: tuple = declare(SUPPORTS, (), meaning=SUPPORTS_MEANING)

    one_of = ((("damping", "damping_ratio", "rayleigh"), ("damping", ())),)
    model = "matrices"
    tilts = ()

    @property
    def n_coordinates(self) -> int:
        """Number of rows."""
        return len(self.mass)

    def mass_at(self, i: int) -> float:
        """Entry in kg (kg m^2 for a tilt) on the diagonal at coordinate i."""
        return self.mass[i][i]

    @staticmethod
    def resolve(values, table):
        """Check sizes, symmetry and definiteness; damping and gyroscopic default to zeros."""
        count = len(values["mass"])
        for key in ("damping", "gyroscopic"):
            if values.get(key) == () and key not in table.values:
                values[key] = ((0.0,) * count,) * count
        for key in ("mass", "stiffness", "damping", "gyroscopic", "skew_stiffness", "skew_damping"):
            if values.get(key) is not None:
                refuse_asymmetric(table, key, values[key], count)
        if not is_definite(values["mass"], strictly=True):
            table.refuse("mass", values["mass"], "positive definite")
        _refuse_indefinite_stiffness(values, table)


@dataclass(frozen=True, kw_only=True)
class LavalRotor(_Loaded, _Laval):
    """[rotor] model = "laval": a disk in the middle of a massless shaft."""

    eccentricity: Polar = declare(PolarReader("length"), NO_ECCENTRICITY, meaning=ECCENTRICITY_MEANING)  # noqa: RUF009 (it is a field)

    one_of = _Laval.one_of + _LOAD_GROUP


def _tilting_matrix(kind):
    """Reader of a 2 x 2 matrix over displacement and tilt, each entry in its own unit."""
    own, cross, tilt = (Number(f"{prefix}{kind}") for prefix in ("", "cross ", "tilt "))
    return MatrixReader(((own, cross), (cross, tilt)))


@dataclass(frozen=True, kw_only=True)
class DiskRotor(_Loaded):
    """[rotor] model = "disk": displacement (coordinate 0) and tilt (1) of one disk with gyroscopics."""

    mass: float = declare(MASS, meaning="Mass of the disk.")
    diametral_inertia: float = declare(Number("inertia", above=0.0), meaning="Moment of inertia about a diameter.")
    polar_inertia: float = declare(
        Number("inertia", low=0.0), meaning="Moment of inertia about the axis, at most twice the diametral one."
    )
    stiffness: tuple = declare(
        _tilting_matrix("stiffness"), meaning="Stiffness of displacement and tilt, symmetric: N/m, N/rad; N/rad, N m/rad."
    )
    damping: tuple | None = declare(
        _tilting_matrix("damping"),
        None,
        meaning="Damping of displacement and tilt, symmetric: N s/m, N s/rad; N s/rad, N m s/rad.",
    )
    damping_ratio: float | None = declare(RATIO, None, meaning=RATIO_MEANING)
    supports: tuple = declare(SUPPORTS, (), meaning=SUPPORTS_MEANING)
    eccentricity: Polar = declare(PolarReader("length"), NO_ECCENTRICITY, meaning=ECCENTRICITY_MEANING)  # noqa: RUF009 (it is a field)
    angular_eccentricity: Polar = declare(  # noqa: RUF009 (it is a field)
        PolarReader("angle"), NO_ECCENTRICITY, meaning="Angle between the disk's own axis and the shaft's."
    )

    one_of = ((("damping", "damping_ratio"), ("damping", ((0.0, 0.0), (0.0, 0.0)))), *_LOAD_GROUP)
    model = "disk"
    n_coordinates = 2
    tilts = (1,)

    def mass_at(self, i: int) -> float:
        """Mass in kg (coordinate 0) or diametral inertia in kg m^2 (coordinate 1)."""
        return (self.mass, self.diametral_inertia)[i]

    @staticmethod
    def resolve(values, table):
        """Check the inertias, stiffness and damping of a disk."""
        if values["polar_inertia"] > 2.0 * values["diametral_inertia"] * (1.0 + 1e-9):
            wanted = "at most 2 diametral_inertia, the value of a thin disk"
            table.refuse("polar_inertia", values["polar_inertia"], wanted)
        for key in ("stiffness", "damping"):
            if values[key] is not None:
                refuse_asymmetric(table, key, values[key])
        _refuse_indefinite_stiffness(values, table)


@dataclass(frozen=True, kw_only=True)
class ChainRotor(_Loaded, _Chain):
    """[rotor] model = "chain": disks in a row."""

    eccentricity: tuple = declare(
        ONE_OR_PER_MASS, 0.0, meaning="Distance of the centre of mass from the shaft, one for all masses or one each."
    )

    one_of = _Chain.one_of + _LOAD_GROUP

    @staticmethod
    def resolve(values, table):
        """Check the lists of a chain; one eccentricity may stand for all masses."""
        _Chain.resolve(values, table)
        raw = values["eccentricity"]
        if isinstance(raw, (int, float, str)):
            raw = [raw] * len(values["masses"])
        readers = [PolarReader("length")] * len(values["masses"])
        values["eccentricity"] = per_coordinate(table, "eccentricity", raw, readers)


@dataclass(frozen=True, kw_only=True)
class MatricesRotor(_Loaded, _Matrices):
    """[rotor] model = "matrices": any symmetric rotor, gyroscopic real symmetric with G_1 = -i gyroscopic."""

    gyroscopic: tuple = declare(
        MatrixReader(), (), meaning="Gyroscopic matrix, real symmetric: polar inertias in kg m^2 on tilt coordinates."
    )
    tilt_coordinates: tuple | None = declare(
        Sequence(Integer(0, MAX_COORDINATES)),
        None,
        meaning="Numbers of the coordinates that are angles, counted from 0; needed where a gyroscopic one has an eccentricity.",
    )
    eccentricity: tuple = declare(
        PER_COORDINATE, None, meaning="Distance of the centre of mass from the shaft at every coordinate (rad on a tilt)."
    )

    one_of = _Matrices.one_of + _LOAD_GROUP

    @property
    def tilts(self):
        """Indices of the coordinates that are angles: free fall does not accelerate them."""
        return self.tilt_coordinates or ()

    @staticmethod
    def resolve(values, table):
        """Check the matrices; read the eccentricity of every coordinate, in m or (tilts) rad."""
        _Matrices.resolve(values, table)
        count, tilts = len(values["mass"]), values["tilt_coordinates"] or ()
        if len(set(tilts)) != len(tilts) or any(i >= count for i in tilts):
            table.refuse("tilt_coordinates", tilts, f"different whole numbers from 0 to {count - 1}")
        if values["eccentricity"] is None:
            values["eccentricity"] = (NO_ECCENTRICITY,) * count
        else:
            readers = [PolarReader("angle" if i in tilts else "length") for i in range(count)]
            values["eccentricity"] = per_coordinate(table, "eccentricity", values["eccentricity"], readers)
        _refuse_unknown_tilts(values, table)


def _refuse_unknown_tilts(values, table):
    """The unbalance of a gyroscopic coordinate is (M - G) eps on a tilt and M eps on a displacement."""
    if values["tilt_coordinates"] is not None:
        return
    for i, eccentricity in enumerate(values["eccentricity"]):
        if complex(eccentricity) and any(row[i] for row in values["gyroscopic"]):
            hint = f"is coordinate {i}, which is gyroscopic and eccentric, a tilt? [{i}] if it is, [] if none is"
            table.refuse("tilt_coordinates", None, "given", hint)


@dataclass(frozen=True, kw_only=True)
class RigidStator:
    """[stator] model = "rigid": a wall that does not move."""

    model = "rigid"
    n_coordinates = 0
    tilts = ()


@dataclass(frozen=True, kw_only=True)
class LavalStator(_Laval):
    """[stator] model = "laval": one elastically held ring."""

    @staticmethod
    def resolve(values, table):
        """The ring must be held."""
        if values["stiffness"] == 0.0:
            table.refuse("stiffness", 0.0, "> 0 N/m", "the stator must be held")


@dataclass(frozen=True, kw_only=True)
class ChainStator(_Chain):
    """[stator] model = "chain": masses in a row."""

    @staticmethod
    def resolve(values, table):
        """Check the lists of a chain; each mass must hang on a wall."""
        _Chain.resolve(values, table)
        springs = values["stiffnesses"]
        breaks = [i for i, spring in enumerate(springs) if spring == 0.0]
        # between two breaks lies a piece that hangs on neither wall
        if len(breaks) > 1:
            table.refuse("stiffnesses", springs, "with at most one 0", "the stator must be held")


@dataclass(frozen=True, kw_only=True)
class MatricesStator(_Matrices):
    """[stator] model = "matrices": any symmetric stator."""

    @staticmethod
    def resolve(values, table):
        """Check the matrices; no motion of the stator may be free of force."""
        _Matrices.resolve(values, table)
        if not is_definite(values["stiffness"], strictly=True):
            table.refuse("stiffness", values["stiffness"], "positive definite", "the stator must be held")


def _refuse_indefinite_stiffness(values, table):
    if not is_definite(values["stiffness"], strictly=False):
        hint = "some displacement would push itself further away"
        table.refuse("stiffness", values["stiffness"], "positive semidefinite", hint)
