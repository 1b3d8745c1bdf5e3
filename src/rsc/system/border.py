"""Limits beyond which neither the model nor any machine holds (docs/users/motions.md).

They are deliberately generous, but for the yield force that a scene gives: a motion inside them may still destroy a machine, one
beyond them certainly does.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np

from rsc.system.system import System, SystemContact

DEEPEST = 1.0  # penetration over clearance; deeper contacts are not elastic
YIELDING = 1.0  # normal force over the yield force that the scene gives
WIDEST = 1.0  # |r| over the shaft radius at the contact: the shaft axis would leave the bore
FASTEST_SURFACE = 500.0  # m/s, beyond the strength of steel
# W/kg, friction power per mass of the rotor: melts steel within 1 s, 500 J/(kg K) times 1500 K
HOTTEST = 7.5e5


@dataclass(frozen=True)
class Border:
    """Values of a motion to compare with the limits; NaN if unknown.

    penetration : float, largest F_N/k_C over the clearance, over all contacts; depth : float, the same in m
    orbit : float, largest |r| over the shaft radius at the contact; NaN without a diameter
    surface : float m/s, largest velocity of the shaft surface, Omega d_R/2 + |Psi| |r|
    heating : float W/kg, friction power over the mass of the rotor, or where that is unknown the effective mass at the contact;
        NaN if the power is unknown
    yielding : float, largest normal force over the yield force of its contact; NaN if the scene gives none
    """

    penetration: float
    depth: float
    orbit: float
    surface: float
    heating: float
    yielding: float = math.nan

    @property
    def passed(self) -> tuple[str, ...]:
        """Names of the limits that the motion exceeds."""
        limits = {"penetration": DEEPEST, "orbit": WIDEST, "surface": FASTEST_SURFACE, "heating": HOTTEST, "yielding": YIELDING}
        return tuple(name for name, limit in limits.items() if getattr(self, name) > limit)


def border_of(
    system: System, speed: float, forces: Sequence[float], amplitude: float, frequency: float, power: float = math.nan,
    mass: float = math.nan,
) -> Border:
    """The Border of a motion.

    Parameters
    ----------
    system : System
    speed : float Hz, of the rotor
    forces : sequence of float N, largest normal force at each contact
    amplitude : float m, largest |r|
    frequency : float Hz, whirl frequency; NaN counts as 0
    power : float W, friction power taken from the drive
    mass : float kg, of the rotor; NaN where its model does not tell it
    """
    pairs = [(contact.law.depth(force), contact.gap) for force, contact in zip(forces, system.contacts, strict=True)]
    depth, gap = max(pairs, key=lambda pair: pair[0] / pair[1])
    radii = [0.5 * contact.law.diameter for contact in system.contacts if contact.law.diameter is not None]
    radius = min(radii, default=math.nan)
    orbiting = 0.0 if math.isnan(frequency) else TWO_PI * abs(frequency) * amplitude
    known = [(force, own.yield_force) for force, own in zip(forces, system.contacts, strict=True)]
    return Border(
        penetration=depth / gap,
        depth=depth,
        orbit=amplitude / radius,
        surface=TWO_PI * abs(speed) * max(radii, default=0.0) + orbiting,
        heating=abs(power) / (max(mass_at(system, contact) for contact in system.contacts) if math.isnan(mass) else mass),
        yielding=max((force / limit for force, limit in known if limit is not None), default=math.nan),
    )


def mass_at(system: System, contact: SystemContact) -> float:
    """Effective mass in kg at a contact, 1/(l^T M^-1 l)."""
    return 1.0 / float(contact.rotor @ np.linalg.solve(system.rotor.mass, contact.rotor))
