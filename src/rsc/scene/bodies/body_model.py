"""What every model of [rotor] or [stator] is: the functions that it answers, and the keys that several models share."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from rsc.scene.bodies import by_speed
from rsc.scene.keys import mirror
from rsc.scene.keys.keys import (
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
    declare,
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
    "a list of [coordinate, [k_xx, k_xy, k_yx, k_yy] in N/m] or [coordinate, stiffness, [c_xx, c_xy, c_yx, c_yy] in N s/m]",
    (
        Sequence(Listed((Integer(0, MAX_COORDINATES), COEFFICIENTS))),
        Sequence(Listed((Integer(0, MAX_COORDINATES), COEFFICIENTS, Sequence(Number("damping"))))),
    ),
)
SUPPORTS_MEANING = "Bearings and seals that differ in x and y or are cross-coupled, besides the other stiffness and damping."
RAYLEIGH_MEANING = "Damping alpha M + beta K from the matrices of mass and stiffness."
ECCENTRICITY_MEANING = "Distance of the centre of mass from the shaft, and its angle ahead of the y axis."
ROTATING = "Damping of what turns with the rotor, D_i (r' - i Omega r): material and joints of the"
RATIO_MEANING = "Damping ratio of every mode of this body alone, at standstill."


class BodyModel(ABC):
    """A model of [rotor] or [stator], as a frozen dataclass whose keys are made by `declare`.

    To add one: the class with a name `model`, `n_coordinates` and these functions, and its entry in `ROTORS` or `STATORS` of
    `rsc.scene.bodies.models`; the scene reference, values by name, sweeps, mirror images, simulation and prediction follow.
    A key with one of the names below means the same in every model. Matrices are (n, n) in SI, symmetric.
    """

    model: str
    one_of: tuple = ()  # groups of keys that exclude each other, `rsc.scene.keys.keys.read_table`

    # what a model without such a key has
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

    @property
    @abstractmethod
    def n_coordinates(self) -> int:
        """Number of complex coordinates."""

    @property
    def tilts(self) -> tuple:
        """Numbers of the coordinates that are angles."""
        return ()

    @staticmethod  # noqa: B027 (a model may have nothing to check)
    def resolve(values, table):
        """Check the values of the keys, which the class is then made of, or change them; refuses with `table.refuse`."""

    @abstractmethod
    def mass_matrix(self):
        """M, positive definite."""

    @abstractmethod
    def stiffness_matrix(self):
        """K without supports."""

    @abstractmethod
    def damping_matrix(self):
        """B without supports, where neither damping_ratio nor rayleigh is given."""

    def gyroscopic_matrix(self):
        """G, polar inertias on tilts; None: no gyroscopics."""
        return self.gyroscopic

    def rotating_damping_matrix(self):
        """D_i, of what turns with the rotor, positive semidefinite; None: there is none."""
        return self.rotating_damping

    def knots(self):
        """What the matrices have besides at some rotor speeds, linear in between: (speeds in Hz, {name: (k, n, n)}) with the
        names of `rsc.system.knots.FOLLOWING`; None: nothing but `supports_by_speed` follows the speed."""
        return None

    def mass_at(self, i):
        """Mass in kg (kg m^2 for a tilt) on the diagonal at coordinate i."""
        return float(np.asarray(self.mass_matrix())[i, i])


class RotorModel(BodyModel):
    """A model of [rotor]: what a stator has, and its unbalance and load."""

    eccentricity: Any  # a complex one for each coordinate, m (tilts rad), or whatever `eccentricities` makes them of
    unbalance: Any = None  # (n,) complex kg m, where it is known instead of eccentricities
    load: Any = None  # (n,) complex N (N m on a tilt), constant; None: the weight
    gravity: Any = 0.0  # m/s^2 along -z

    def eccentricities(self):
        """(n,) complex, m (tilts rad): distance of the centre of mass from the shaft; unbalance and Euler term follow."""
        return np.array([complex(item) for item in self.eccentricity])


@dataclass(frozen=True, kw_only=True)
class LoadedRotor(RotorModel):
    """Keys that every rotor of a scene file has: constant load and the leave for negative damping."""

    gravity: float | None = declare(
        Number("acceleration", low=0.0, high=1e6, hint="it acts along -z"),
        None,
        meaning="Acceleration of gravity along -z; every mass gets its weight as constant load.",
    )
    load: tuple | None = declare(LOAD, None, meaning="Constant force on every coordinate (N m on a tilt).")
    allow_negative_damping: bool = declare(
        Flag(), False, meaning="Allows damping that feeds energy in, which is refused otherwise."
    )
    supports_by_speed: tuple | None = declare(
        by_speed.SUPPORTS_BY_SPEED, None, meaning=by_speed.MEANING, mirror=mirror.by_speed
    )


LOAD_GROUP = ((("gravity", "load"), ("gravity", 0.0)),)
