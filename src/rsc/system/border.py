"""Where a motion leaves what the model, and any machine, can bear: the one place of these limits (docs/users/motions.md).

They are generous on purpose. A motion inside them may well destroy a machine; one beyond them needs no further argument.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np

from rsc.system.system import System, SystemContact

DEEPEST = 1.0  # penetration over the gap: a deeper contact is no elastic spring between surfaces that just touch
WIDEST = 1.0  # |r| over the radius of the shaft at the contact: the shaft would leave its own hole
FASTEST_SURFACE = 500.0  # m/s, which steel does not stand
# W/kg of the mass that an impact at the contact moves, which melts steel within a second: 500 J/(kg K) times 1500 K
HOTTEST = 7.5e5


@dataclass(frozen=True)
class Border:
    """How far a motion is towards each limit; NaN where it cannot be known.

    penetration : float, largest F_N/k_C over the gap, of several contacts the largest; depth : float m, the same as a length
    orbit : float, largest |r| over the radius of the shaft at the contact; NaN without a diameter
    surface : float m/s, fastest point of the shaft's surface, Omega d_R/2 + |Psi| |r|
    heating : float W/kg, power of friction over the mass that an impact at the contact moves; NaN without a diameter
    """

    penetration: float
    depth: float
    orbit: float
    surface: float
    heating: float

    @property
    def passed(self) -> tuple[str, ...]:
        """Names of the limits that the motion is beyond."""
        limits = {"penetration": DEEPEST, "orbit": WIDEST, "surface": FASTEST_SURFACE, "heating": HOTTEST}
        return tuple(name for name, limit in limits.items() if getattr(self, name) > limit)


def border_of(
    system: System, speed: float, forces: Sequence[float], amplitude: float, frequency: float, power: float = math.nan
) -> Border:
    """The Border of a motion.

    Parameters
    ----------
    system : System
    speed : float Hz, of the rotor
    forces : sequence of float N, the largest normal force at each contact
    amplitude : float m, largest |r|
    frequency : float Hz, at which the motion turns; NaN counts as none
    power : float W, that friction takes from the drive
    """
    pairs = [(force / contact.law.stiffness, contact.gap) for force, contact in zip(forces, system.contacts, strict=True)]
    depth, gap = max(pairs, key=lambda pair: pair[0] / pair[1])
    radii = [0.5 * contact.law.diameter for contact in system.contacts if contact.law.diameter is not None]
    radius = min(radii, default=math.nan)
    orbiting = 0.0 if math.isnan(frequency) else TWO_PI * abs(frequency) * amplitude
    return Border(
        penetration=depth / gap,
        depth=depth,
        orbit=amplitude / radius,
        surface=TWO_PI * abs(speed) * max(radii, default=0.0) + orbiting,
        heating=abs(power) / max(mass_at(system, contact) for contact in system.contacts),
    )


def mass_at(system: System, contact: SystemContact) -> float:
    """The mass in kg that an impact at a contact moves at once, 1/(l^T M^-1 l)."""
    return 1.0 / float(contact.rotor @ np.linalg.solve(system.rotor.mass, contact.rotor))
