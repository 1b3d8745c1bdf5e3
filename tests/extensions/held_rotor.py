"""A rotor model that the package does not have, added as CONTRIBUTING.md says and by nothing else: a rigid rotor on two springs.

Coordinates are the displacement of its centre of mass (0) and its tilt (1). A spring at the distance a along the shaft moves by
r + a phi, so that K = sum k [[1, a], [a, a^2]]; the same holds of the dashpots. The contact is at the centre of mass.
"""

from dataclasses import dataclass

import numpy as np

from rsc.scene.bodies.body_model import LOAD_GROUP, LoadedRotor
from rsc.scene.bodies.models import ROTORS
from rsc.scene.keys.keys import declare
from rsc.scene.keys.readers import NO_ECCENTRICITY, Number, Polar, PolarReader, Sequence

PAIR = Sequence(Number("length"))


@dataclass(frozen=True, kw_only=True)
class HeldRotor(LoadedRotor):
    """[rotor] model = "held": a rigid rotor on two springs."""

    mass: float = declare(Number("mass", above=0.0), meaning="Mass of the rotor.")
    diametral_inertia: float = declare(Number("inertia", above=0.0), meaning="Moment of inertia about a diameter.")
    polar_inertia: float = declare(Number("inertia", low=0.0), meaning="Moment of inertia about the axis.")
    places: tuple = declare(PAIR, meaning="Where along the shaft the two springs are, from the centre of mass.")
    stiffnesses: tuple = declare(Sequence(Number("stiffness", above=0.0)), meaning="Of the two springs.")
    dampings: tuple = declare(Sequence(Number("damping", low=0.0)), (0.0, 0.0), meaning="Of the dashpots beside them.")
    eccentricity: Polar = declare(  # noqa: RUF009 (it is a field)
        PolarReader("length"), NO_ECCENTRICITY, meaning="Distance of the centre of mass from the shaft."
    )

    one_of = LOAD_GROUP
    model = "held"
    n_coordinates = 2
    tilts = (1,)

    @staticmethod
    def resolve(values, table):
        """Two springs at different places hold the rotor."""
        for key in ("places", "stiffnesses", "dampings"):
            if len(values[key]) != 2:
                table.refuse(key, values[key], "a list of two numbers, one for each spring")
        if values["places"][0] == values["places"][1]:
            table.refuse("places", values["places"], "two different places", "at one place they do not hold the tilt")

    def mass_matrix(self):
        """Mass and diametral inertia."""
        return np.diag([self.mass, self.diametral_inertia])

    def stiffness_matrix(self):
        """The springs."""
        return self._at_places(self.stiffnesses)

    def damping_matrix(self):
        """The dashpots."""
        return self._at_places(self.dampings)

    def gyroscopic_matrix(self):
        """The polar inertia on the tilt."""
        return np.diag([0.0, self.polar_inertia])

    def eccentricities(self):
        """Of the centre of mass only."""
        return np.array([complex(self.eccentricity), 0j])

    def _at_places(self, constants):
        return sum(each * np.array([[1.0, place], [place, place**2]]) for place, each in zip(self.places, constants, strict=True))


ROTORS[HeldRotor.model] = HeldRotor
