"""The law of the contact, and what every prediction asks of it (docs/users/physics.md, section 2).

    F_C = (1 + i mu sigma) F_N e^{i gamma},   F_N = k_C p + b_C min(p', 0) where pressed,   p = |d| - s,

with the direction e^{i gamma} of d and the sign sigma of the slip, 1 where friction slides forward. The closed forms below rest
on F_N being linear in p. A constant of the contact that this law does not know is refused, since a prediction without it would be
wrong: whoever adds one says here what becomes of each form, or leaves it to the simulation.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from rsc.errors import SceneError
from rsc.system.system import ContactLaw, FloatOrArray, System

# by name, so that a constant which is added to a scene's law is refused until it is treated here
_TREATED = ("stiffness", "damping", "friction", "diameter", "slip_velocity", "race_inertia", "race_drag")
_HINT = "rsc run simulates it"


@dataclass(frozen=True, eq=False)
class SteadyLaw(ContactLaw):
    """The constants of a contact, floats, or (n,) of a stack of systems, with its gap: what follows from them for steady motions.

    Infinite stiffness: rigid; no diameter (None, in a stack NaN): friction slides forward always.
    """

    gap: Any = 0.0  # m, s

    @property
    def turn(self):
        """1 + i mu: the contact force over its normal part, along d, where friction slides forward."""
        return self.turned(1.0)

    def turned(self, sigma):
        """1 + i mu sigma, as `turn` where friction has the sign, or the part of its limit, sigma."""
        return 1.0 + 1j * self.friction * sigma

    @property
    def oblique(self):
        """|1 + i mu|: the size of the contact force over that of its normal part."""
        return np.hypot(1.0, self.friction)

    def normal_force(self, real, rigid=False):
        """F_N in N of a steady motion whose contact moves by -real F_N along d (27); rigid: with k_C infinite.

        real : Re[(1 + i mu) H], m/N; not positive F_N: no such motion
        """
        with np.errstate(divide="ignore"):
            return -self.gap / (real if rigid else real + 1.0 / self.stiffness)

    def held(self, real):
        """k_C s/F_N of `normal_force`, -k_C real - 1: positive where F_N is, and it passes zero where F_N is unbounded."""
        return -self.stiffness * real - 1.0

    def stiff_enough(self, F_rigid):
        """k_C s/F_N - 1 of the normal force with rigid contact: above 0 the contact is stiff enough for the whirl."""
        return self.stiffness * self.gap / F_rigid - 1.0

    def distance(self, F_N: FloatOrArray):
        """|d| = s + F_N/k_C in m of a steady motion."""
        return self.gap + np.asarray(F_N) / self.stiffness

    def within_its_gap(self, F_N: FloatOrArray):
        """Whether a force presses the contact in by less than the gap."""
        return self.stiffness * self.gap > F_N

    def slopes(self, F_N: FloatOrArray):
        """Radial and tangential stiffness in N/m of the normal force about a steady motion: k_C, and F_N/|d| by its direction.

        Raises ValueError for rigid contact, about which nothing moves.
        """
        self._refuse_rigid()
        return self.stiffness, F_N / self.distance(F_N)

    def _refuse_rigid(self):
        if not np.isfinite(self.stiffness).all():
            raise ValueError("what moves about a steady motion needs a finite contact stiffness")

    def damper(self, share):
        """N s/m, a share of b_C: small motions see between none and all of the one-sided damper."""
        return share * self.damping

    def resonance(self, compliance):
        """Frequency in rad/s at which the pressed contact vibrates with masses of the compliance l^T M^-1 l, 1/kg."""
        return np.sqrt(self.stiffness * compliance)

    @property
    def mean_damping(self):
        """N s/m, b_C/2: the mean of the one-sided damper over a small oscillation about a steady motion."""
        return self.damper(0.5)

    def dynamic_stiffness(self, w):
        """k_C + i w b_C/2 in N/m of small radial motions at the frequency w in the turning frame, with the `mean_damping`."""
        return self.stiffness + 1j * w * self.mean_damping

    def against_force(self, H):
        """c = (1 - i mu)/|1 + i mu|, the direction of d against that of the force, and H + c/(k_C |1 + i mu|), the receptance in
        m/N with the elastic contact in it."""
        c = (1.0 - 1j * self.friction) / self.oblique
        return c, H + c / (self.stiffness * self.oblique)

    def normal(self, distance, rate):
        """F_N in N as if pressed, and its derivatives by |d| and by its rate; ValueError as `slopes`.

        distance, rate : (n,) m and m/s, of |d|
        """
        self._refuse_rigid()
        damping = np.where(rate < 0.0, self.damping, 0.0)
        return self.stiffness * (distance - self.gap) + damping * rate, self.stiffness, damping

    def secant(self, distance):
        """F_N/|d| in N/m at rest, 0 without contact."""
        return self.stiffness * np.maximum(1.0 - self.gap / distance, 0.0)

    def surface(self, Omega):
        """Speed in m/s of the rotor's surface at the contact, Omega d_R/2; needs a diameter."""
        return 0.5 * Omega * self.diameter

    def slip(self, Psi: FloatOrArray, Omega: FloatOrArray, distance):
        """Velocity in m/s with which the rotor's surface slides in a motion that turns at Psi with |d| (12); needs a diameter."""
        return self.surface(Omega) + Psi * distance

    @property
    def surface_turns(self):
        """Whether the stator's surface is a race, of a stack that of one of them: what sticks to it does not roll."""
        return self.race_inertia is not None and bool(np.isfinite(self.race_inertia).any())

    def carried(self, distance):
        """Speed in m/s of the surface of a race that friction of a steady motion with |d| turns: mu F_N R^2/drag with its radius
        R = d_R/2 + gap, infinite without drag; 0 without a race."""
        if not self.surface_turns:
            return np.zeros(np.shape(distance))
        radius = 0.5 * self.diameter + self.gap
        torque = self.friction * self.normal(np.asarray(distance), 0.0)[0] * radius
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(torque > 0.0, radius * torque / np.float64(self.race_drag), 0.0)

    def slip_of(self, traction):
        """Slip in m/s that belongs to a friction force below its limit, traction F_N."""
        return self.slip_velocity * traction / self.friction

    def creep(self, F_N):
        """By how much friction grows with the slip below its limit, N s/m."""
        return F_N * self.friction / self.slip_velocity

    def sign(self, slip):
        """sigma and its derivative by the slip in m/s."""
        ratio = slip / self.slip_velocity
        return np.clip(ratio, -1.0, 1.0), np.where(np.abs(ratio) < 1.0, 1.0 / self.slip_velocity, 0.0)


def law_of(system: System):
    """The `SteadyLaw` of the only contact of a System or of a stack; raises as `law_at`, SolverError of several."""
    return law_at(system.contact)


def law_at(contact):
    """The `SteadyLaw` of a contact.

    Raises
    ------
    SceneError
        A constant of the contact that no prediction treats.
    """
    law = contact.law
    for name, value in vars(law).items():
        if name not in _TREATED and np.any(value):
            value = np.ravel(value)[np.flatnonzero(value)[0]].item()  # of a stack the first
            raise SceneError("<scene>", f"contact.{name}", value, "0 for a prediction, whose contact has no such term", _HINT)
    return SteadyLaw(**{name: getattr(law, name) for name in _TREATED}, gap=contact.gap)
