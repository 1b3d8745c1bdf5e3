"""Base classes of the models of [rotor] and [stator]: their methods, and keys that several models share."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from rsc.scene.bodies import by_speed
from rsc.scene.bodies.states import matrices_of, numbers_of
from rsc.scene.keys import mirror
from rsc.scene.keys.keys import declare
from rsc.scene.keys.readers import (
    MAX_COORDINATES,
    Eccentricity,
    EccentricityReader,
    Flag,
    Integer,
    Later,
    Listed,
    Number,
    PairReader,
    Sequence,
)

MASS = Number("mass", above=0.0)
STIFFNESS = Number("stiffness", low=0.0)
RATIO = Number("dimensionless", high=1.5, hint="a percentage? 5 % is 0.05")
RAYLEIGH = Later("two numbers [alpha in 1/s, beta in s]", (Listed((Number("rate"), Number("time"))),))
ECCENTRICITIES = Sequence(EccentricityReader())
PER_COORDINATE = Later("a list with one number, balance grade or [amount, angle in degrees] per coordinate", (ECCENTRICITIES,))
ONE_OR_PER_MASS = Later("one for all masses, or " + PER_COORDINATE.wanted, (Eccentricity("length"), ECCENTRICITIES))
LOAD = Later("a list with one pair [f_y, f_z] in N per coordinate", (Sequence(PairReader("force")),))
COEFFICIENTS = Sequence(Number("stiffness"))
SUPPORTS = Later(
    "a list of [coordinate, [k_yy, k_yz, k_zy, k_zz] in N/m] or [coordinate, stiffness, [c_yy, c_yz, c_zy, c_zz] in N s/m]",
    (
        Sequence(Listed((Integer(0, MAX_COORDINATES), COEFFICIENTS))),
        Sequence(Listed((Integer(0, MAX_COORDINATES), COEFFICIENTS, Sequence(Number("damping"))))),
    ),
)
SUPPORTS_MEANING = "Bearings and seals, anisotropic or cross-coupled, in addition to the other stiffness and damping."
RAYLEIGH_MEANING = "Rayleigh damping alpha M + beta K."
ECCENTRICITY_MEANING = "Eccentricity of the centre of mass, and its angle ahead of the y axis."
ROTATING = "Rotating (internal) damping D_i (r' - i Omega r): material and joints of the"
RATIO_MEANING = "Damping ratio of every mode of this body without contact, at standstill."


class BodyModel(ABC):
    """A model of [rotor] or [stator], as a frozen dataclass with keys made by `declare`.

    To add a model: a class with the name `model`, `n_coordinates` and these methods, and an entry in `ROTORS` or `STATORS` of
    `rsc.scene.bodies.models`; scene reference, values by name, sweeps, mirror images, simulation and prediction then work. The
    keys below have the same meaning in every model. Matrices are (n, n) in SI, symmetric.
    """

    model: str
    one_of: tuple = ()  # groups of keys that exclude each other, `rsc.scene.keys.keys.read_table`

    # defaults for models without such a key
    damping_ratio: Any = None
    rayleigh: Any = None
    gyroscopic: Any = None
    skew_stiffness: Any = None
    skew_damping: Any = None
    anisotropic_stiffness: Any = None
    anisotropic_damping: Any = None
    rotating_damping: Any = None
    supports: tuple = ()
    supports_by_speed: Any = None
    states: Any = None
    magnetic_bearings: Any = None
    off_times: Any = None  # s, at which bearings are switched off that are part of the matrices

    @property
    @abstractmethod
    def n_coordinates(self) -> int:
        """Number of complex coordinates."""

    @property
    def tilts(self) -> tuple:
        """Numbers of the coordinates that are angles."""
        return ()

    @staticmethod  # noqa: B027 (a model may have nothing to check)
    def resolve(values: Any, table: Any) -> None:
        """Check or change the values from which the class is then made; errors by `table.refuse`."""

    @abstractmethod
    def mass_matrix(self) -> Any:
        """M, positive definite."""

    @abstractmethod
    def stiffness_matrix(self) -> Any:
        """K without supports."""

    @abstractmethod
    def damping_matrix(self) -> Any:
        """B without supports, if neither damping_ratio nor rayleigh is given."""

    def gyroscopic_matrix(self) -> Any:
        """G, polar inertias on tilts; None without gyroscopics."""
        return self.gyroscopic

    def rotating_damping_matrix(self) -> Any:
        """Rotating damping D_i, positive semidefinite; None without."""
        return self.rotating_damping

    def knots(self) -> Any:
        """Speed-dependent parts that are added to the matrices, linear in between: (speeds in Hz, {name: (k, n, n)}) with names
        of `rsc.system.knots.FOLLOWING`; None if only `supports_by_speed` depend on the speed."""
        return None

    def first_order(self, until: float = 0.0) -> Any:
        """`rsc.scene.bodies.states.StateMatrices` of the first-order states, without those of bearings that are switched off
        before a time in s; None without any."""
        return matrices_of(self, until)

    def state_numbers(self, until: float) -> Any:
        """The numbers that the states of `first_order(until)` have among all states."""
        return numbers_of(self, until)

    @property
    def at_end(self) -> Any:
        """The body without bearings that are switched off."""
        return self

    @property
    def switched_at(self) -> tuple[float, ...]:
        """Times in s at which bearings are switched off, magnetic ones included; increasing."""
        magnetic = [item[-1].off for item in self.magnetic_bearings or ()]
        return tuple(sorted({*(self.off_times or ()), *(off for off in magnetic if off is not None)}))

    @property
    def n_states(self) -> int:
        """Number p of complex first-order states."""
        own = self.first_order()
        return 0 if own is None else len(own.matrix)

    def mass_at(self, i: int) -> float:
        """Mass in kg (kg m^2 for a tilt) on the diagonal at coordinate i."""
        return float(np.asarray(self.mass_matrix())[i, i])

    @property
    def total_mass(self) -> float:
        """Mass in kg of the whole body; NaN where the model does not tell it."""
        return math.nan


class RotorModel(BodyModel):
    """A model of [rotor], with unbalance and load."""

    eccentricity: Any  # complex, one per coordinate, m (tilts rad), or any input of `eccentricities`
    unbalance: Any = None  # (n,) complex kg m, if known instead of eccentricities
    load: Any = None  # (n,) complex N (N m on a tilt), constant; None: the weight
    gravity: Any = 0.0  # m/s^2 along -z

    def eccentricities(self) -> Any:
        """(n,) complex, m (tilts rad): eccentricity of the centre of mass, which determines unbalance and Euler term."""
        return np.array([complex(item) for item in self.eccentricity])


@dataclass(frozen=True, kw_only=True)
class LoadedRotor(RotorModel):
    """Keys common to all rotors of scene files: constant load, permission for negative damping, and speed-dependent supports."""

    gravity: float | None = declare(
        Number("acceleration", low=0.0, high=1e6, hint="it acts along -z"),
        None,
        meaning="Acceleration of gravity along -z; the weight of every mass acts as constant load.",
    )
    load: tuple | None = declare(LOAD, None, meaning="Constant force on every coordinate (tilts: N m).")
    allow_negative_damping: bool = declare(
        Flag(), False, meaning="Allow negative damping, which is otherwise refused."
    )
    supports_by_speed: tuple | None = declare(
        by_speed.SUPPORTS_BY_SPEED, None, meaning=by_speed.MEANING, mirror=mirror.by_speed
    )


LOAD_GROUP = ((("gravity", "load"), ("gravity", 0.0)),)
