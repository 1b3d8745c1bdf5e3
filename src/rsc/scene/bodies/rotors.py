"""The models of [rotor]: their keys, defaults, checks and matrices, as frozen dataclasses."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from rsc.scene.bodies.body_model import (
    ECCENTRICITY_MEANING,
    LOAD_GROUP,
    MASS,
    ONE_OR_PER_MASS,
    PER_COORDINATE,
    RATIO,
    RATIO_MEANING,
    ROTATING,
    SUPPORTS,
    SUPPORTS_MEANING,
    LoadedRotor,
)
from rsc.scene.bodies.lumped import ChainBody, LavalBody, MatricesBody, links, refuse_indefinite_stiffness, refuse_other_links
from rsc.scene.bodies.states import HasStates
from rsc.scene.files.matrix_files import MatrixReader, is_definite, refuse_asymmetric
from rsc.scene.keys import mirror
from rsc.scene.keys.keys import OPTIONAL, RawTable, declare
from rsc.scene.keys.readers import (
    MAX_COORDINATES,
    NO_ECCENTRICITY,
    EccentricityReader,
    Integer,
    Number,
    Polar,
    PolarReader,
    Sequence,
    per_coordinate,
)


@dataclass(frozen=True, kw_only=True)
class LavalRotor(LoadedRotor, LavalBody):
    """[rotor] model = "laval": a disk in the middle of a massless shaft."""

    rotating_damping: float | None = declare(Number("damping", low=0.0), None, meaning=f"{ROTATING} shaft.")
    rotating_damping_ratio: float | None = declare(
        Number("dimensionless", low=0.0, high=1.5, hint="a percentage? 5 % is 0.05"),
        None,
        meaning="Ratio of rotating damping.",
    )

    eccentricity: Polar = declare(EccentricityReader(), NO_ECCENTRICITY, meaning=ECCENTRICITY_MEANING)  # noqa: RUF009 (it is a field)

    one_of = (*LavalBody.one_of, (("rotating_damping", "rotating_damping_ratio"), OPTIONAL), *LOAD_GROUP)

    def rotating_damping_matrix(self) -> Any:
        """Rotating damping, given or from the ratio."""
        if self.rotating_damping_ratio is not None:
            return [[2.0 * self.rotating_damping_ratio * math.sqrt(self.stiffness_matrix()[0][0] * self.mass)]]
        return None if self.rotating_damping is None else [[self.rotating_damping]]

    def eccentricities(self) -> Any:
        """Eccentricity of the disk."""
        return np.array([complex(self.eccentricity)])


def _tilting_matrix(kind: str) -> MatrixReader:
    """Reader of a 2 x 2 matrix for displacement and tilt, each entry in its own unit."""
    direct, cross, tilt = (Number(f"{prefix}{kind}") for prefix in ("", "cross ", "tilt "))
    return MatrixReader(((direct, cross), (cross, tilt)))


@dataclass(frozen=True, kw_only=True)
class DiskRotor(HasStates, LoadedRotor):
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
    rotating_damping: tuple | None = declare(
        _tilting_matrix("damping"), None, meaning=f"{ROTATING} shaft, on displacement and tilt, symmetric, units as for damping."
    )
    supports: tuple = declare(SUPPORTS, (), meaning=SUPPORTS_MEANING, mirror=mirror.supports)
    eccentricity: Polar = declare(EccentricityReader(), NO_ECCENTRICITY, meaning=ECCENTRICITY_MEANING)  # noqa: RUF009 (it is a field)
    angular_eccentricity: Polar = declare(  # noqa: RUF009 (it is a field)
        PolarReader("angle"), NO_ECCENTRICITY, meaning="Angle between the principal axis of the disk and the shaft axis."
    )

    one_of = ((("damping", "damping_ratio"), ("damping", ((0.0, 0.0), (0.0, 0.0)))), *LOAD_GROUP)
    model = "disk"
    n_coordinates = 2
    tilts = (1,)

    def mass_matrix(self) -> Any:
        """Mass and diametral inertia on the diagonal."""
        return np.diag([self.mass, self.diametral_inertia])

    @property
    def total_mass(self) -> float:
        """Mass of the disk in kg."""
        return self.mass

    def stiffness_matrix(self) -> Any:
        """As given."""
        return self.stiffness

    def damping_matrix(self) -> Any:
        """As given."""
        return self.damping

    def gyroscopic_matrix(self) -> Any:
        """The polar inertia on the tilt."""
        return np.diag([0.0, self.polar_inertia])

    def eccentricities(self) -> Any:
        """Eccentricities of displacement and tilt."""
        return np.array([complex(self.eccentricity), complex(self.angular_eccentricity)])

    @staticmethod
    def resolve(values: Any, table: RawTable) -> None:
        """Check the inertias, stiffness and damping of a disk."""
        if values["polar_inertia"] > 2.0 * values["diametral_inertia"] * (1.0 + 1e-9):
            wanted = "at most 2 diametral_inertia, the value for a thin disk"
            table.refuse("polar_inertia", values["polar_inertia"], wanted)
        for key in ("stiffness", "damping", "rotating_damping"):
            if values[key] is not None:
                refuse_asymmetric(table, key, values[key])
        _refuse_feeding_shaft(values, table)
        refuse_indefinite_stiffness(values, table)


@dataclass(frozen=True, kw_only=True)
class ChainRotor(LoadedRotor, ChainBody):
    """[rotor] model = "chain": disks in a row."""

    eccentricity: tuple = declare(
        ONE_OR_PER_MASS, 0.0, meaning="Eccentricity of the centre of mass, one for all masses or one each."
    )
    rotating_damping: tuple | None = declare(
        Sequence(Number("damping", low=0.0)), None, meaning=f"{ROTATING} shaft segments, in the order of its springs."
    )

    one_of = ChainBody.one_of + LOAD_GROUP

    @staticmethod
    def resolve(values: Any, table: RawTable) -> None:
        """Check the lists of a chain; a single eccentricity applies to all masses."""
        ChainBody.resolve(values, table)
        raw = values["eccentricity"]
        if isinstance(raw, (int, float, str)):
            raw = [raw] * len(values["masses"])
        readers = [EccentricityReader()] * len(values["masses"])
        values["eccentricity"] = per_coordinate(table, "eccentricity", raw, readers)
        refuse_other_links(values, table, "rotating_damping")

    def rotating_damping_matrix(self) -> Any:
        """Rotating damping of the shaft segments."""
        return None if self.rotating_damping is None else links(self.rotating_damping)


@dataclass(frozen=True, kw_only=True)
class MatricesRotor(LoadedRotor, MatricesBody):
    """[rotor] model = "matrices": any symmetric rotor, gyroscopic real symmetric with G_1 = -i gyroscopic."""

    gyroscopic: tuple = declare(
        MatrixReader(), (), meaning="Gyroscopic matrix, real symmetric: polar inertias in kg m^2 on tilt coordinates."
    )
    tilt_coordinates: tuple | None = declare(
        Sequence(Integer(0, MAX_COORDINATES)),
        None,
        meaning="Numbers of the coordinates that are angles, counted from 0; required if a gyroscopic one is eccentric.",
    )
    rotating_damping: tuple | None = declare(
        MatrixReader(), None, meaning=f"{ROTATING} shaft, symmetric and positive semidefinite."
    )
    eccentricity: tuple = declare(
        PER_COORDINATE, None, meaning="Eccentricity of the centre of mass at every coordinate (tilts: rad)."
    )

    one_of = MatricesBody.one_of + LOAD_GROUP

    @property
    def tilts(self) -> tuple:
        """Indices of the coordinates that are angles, on which gravity does not act directly."""
        return self.tilt_coordinates or ()

    @staticmethod
    def resolve(values: Any, table: RawTable) -> None:
        """Check the matrices, and read the eccentricity of every coordinate in m or (tilts) rad."""
        MatricesBody.resolve(values, table)
        count, tilts = len(values["mass"]), values["tilt_coordinates"] or ()
        if values["rotating_damping"] is not None:
            refuse_asymmetric(table, "rotating_damping", values["rotating_damping"], count)
            _refuse_feeding_shaft(values, table)
        if len(set(tilts)) != len(tilts) or any(i >= count for i in tilts):
            table.refuse("tilt_coordinates", tilts, f"different whole numbers from 0 to {count - 1}")
        if values["eccentricity"] is None:
            values["eccentricity"] = (NO_ECCENTRICITY,) * count
        else:
            readers = [PolarReader("angle") if i in tilts else EccentricityReader() for i in range(count)]
            values["eccentricity"] = per_coordinate(table, "eccentricity", values["eccentricity"], readers)
        _refuse_unknown_tilts(values, table)


def _refuse_unknown_tilts(values: Any, table: RawTable) -> None:
    """SceneError if an eccentric gyroscopic coordinate may be a tilt: its unbalance is (M - G) eps, of a displacement M eps."""
    if values["tilt_coordinates"] is not None:
        return
    for i, eccentricity in enumerate(values["eccentricity"]):
        if complex(eccentricity) and any(row[i] for row in values["gyroscopic"]):
            hint = f"is coordinate {i}, which is gyroscopic and eccentric, a tilt? [{i}] if it is, [] if none is"
            table.refuse("tilt_coordinates", None, "given", hint)


def _refuse_feeding_shaft(values: Any, table: RawTable) -> None:
    """SceneError unless rotating damping dissipates energy in the deformation of the shaft."""
    matrix = values["rotating_damping"]
    if matrix is not None and not is_definite(matrix, strictly=False):
        table.refuse("rotating_damping", matrix, "positive semidefinite")
