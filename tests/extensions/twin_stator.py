"""A stator model that the package does not have, added as CONTRIBUTING.md says and by nothing else: a ring whose support differs
in y and z by a share, both given as frequencies."""

from dataclasses import dataclass

import numpy as np

from rsc.scene.bodies.body_model import BodyModel
from rsc.scene.bodies.models import STATORS
from rsc.scene.keys.keys import declare
from rsc.scene.keys.readers import Number

FREQUENCY = Number("frequency", above=0.0)


@dataclass(frozen=True, kw_only=True)
class TwinStator(BodyModel):
    """[stator] model = "twin": a ring with one natural frequency in y and another in z."""

    mass: float = declare(Number("mass", above=0.0), meaning="Mass of the ring.")
    frequency_y: float = declare(FREQUENCY, meaning="Natural frequency in y.")
    frequency_z: float = declare(FREQUENCY, meaning="Natural frequency in z.")
    damping_ratio: float = declare(Number("dimensionless", low=0.0, high=1.5), 0.0, meaning="Of both, by the mean stiffness.")

    model = "twin"
    n_coordinates = 1

    def mass_matrix(self):
        """The mass."""
        return [[self.mass]]

    def stiffness_matrix(self):
        """The mean of both springs."""
        return [[0.5 * sum(self._springs())]]

    @property
    def anisotropic_stiffness(self):
        """Half of the difference of both springs: it acts on the conjugate."""
        y, z = self._springs()
        return [[0.5 * (y - z)]]

    def damping_matrix(self):
        """None beside that of the ratio."""
        return [[0.0]]

    def _springs(self):
        return [self.mass * (2.0 * np.pi * each) ** 2 for each in (self.frequency_y, self.frequency_z)]


STATORS[TwinStator.model] = TwinStator
