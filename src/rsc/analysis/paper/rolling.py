"""Whirls that roll: the surfaces stick, and friction is below its limit.

Where the rotor has a diameter d_R at the contact, (12) and (13) bound the whirls that slide: at Psi = -Omega d_R/(2 |d|) nothing
is left of the slip. There the ratio of tangential and normal force, the traction tau, |tau| <= mu, takes the place of mu in the
whirl condition (24) and the force (27):

    tau = -Im H/Re H,   F_N = -s/(|H|^2/Re H + 1/k_C),   |d| = s + F_N/k_C,

and the regularised friction law, tau = mu slip/slip_velocity, determines Psi:

    Omega d_R/2 + Psi |d| = slip_velocity tau/mu.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import receptance, receptance_rotor, receptance_stator
from rsc.analysis.paper.stability import whirl_growth
from rsc.system.system import FloatOrArray, System

# whirls are looked for with |d| from s to as many gaps, between neighbours of frequencies so far apart
_MOST_GAPS, _APART = 1e3, 1.002
_TOGETHER = 1 << 20  # entries of the matrices that are made at once, 16 MB


@dataclass(frozen=True)
class Roll:
    """A whirl that rolls: Psi in rad/s, |r_R| and |r_S| at the contact in m, F_N in N, traction F_T/F_N, growth rate of
    disturbances in 1/s (`rsc.analysis.paper.stability`)."""

    Psi: float
    rotor_amplitude: float
    stator_amplitude: float
    normal_force: float
    traction: float
    growth_rate: float

    @property
    def stable(self):
        """Whether every disturbance decays."""
        return self.growth_rate < 0.0


def rolling_whirls(system: System, Omega: float, near=None):
    """Whirls that roll, by rising frequency; none without a diameter or friction, at standstill, or on a race, which turns along.

    Parameters
    ----------
    system : System
    Omega : float, rad/s
    near : tuple of two floats, optional
        Lowest and highest |Psi| in rad/s to look at: of large systems looking everywhere takes long.

    Returns
    -------
    list of Roll
        Of two whirls within 0.2 % of a frequency both may be missed.
    """
    law = law_of(system)
    if law.diameter is None or law.friction == 0.0 or Omega == 0.0 or law.surface_turns:
        return []
    surface = law.surface(Omega)
    fastest = (abs(surface) + law.slip_velocity) / law.gap
    low, high = near or (fastest / _MOST_GAPS, fastest)
    count = 2 + int(np.log(high / low) / np.log(_APART))
    grid = -np.sign(surface) * np.geomspace(high, low, count)
    parts = np.array_split(grid, 1 + count * max(system.n_rotor, system.n_stator) ** 2 // _TOGETHER)
    tau, F_N, slip_left = np.hstack([_rolling(system, part, Omega) for part in parts])
    exists = (np.abs(tau) <= law.friction) & (F_N > 0.0)
    between = exists[1:] & exists[:-1] & (np.signbit(slip_left[1:]) != np.signbit(slip_left[:-1]))
    ends = [grid[i : i + 2] for i in np.flatnonzero(between)]
    roots = [scipy.optimize.brentq(lambda Psi: float(_rolling(system, Psi, Omega)[2]), *pair) for pair in ends]
    # the sign also changes at a pole
    return [_roll(system, Psi, Omega) for Psi in sorted(roots) if abs(_rolling(system, Psi, Omega)[2]) < 1e-6 * abs(surface)]


def _rolling(system: System, Psi: FloatOrArray, Omega: FloatOrArray):
    """(tau, F_N, slip less the one that belongs to tau), shape of Psi."""
    law, H = law_of(system), receptance(system, Psi, Omega)
    with np.errstate(divide="ignore", invalid="ignore"):
        tau = -H.imag / H.real
        F_N = law.normal_force(np.abs(H) ** 2 / H.real)  # of the friction tau in the place of mu
    return tau, F_N, law.slip(Psi, Omega, law.distance(F_N)) - law.slip_of(tau)


def _roll(system: System, Psi: float, Omega: float):
    tau, F_N, _ = (float(value) for value in _rolling(system, Psi, Omega))
    force = np.hypot(1.0, tau) * F_N
    receptances = receptance_rotor(system, Psi, Omega), receptance_stator(system, Psi)
    rotor, stator = (float(abs(complex(H)) * force) for H in receptances)
    rolling_system = system.with_friction(tau)
    growth = whirl_growth(rolling_system, Psi, F_N, Omega, creep=law_of(system).creep(F_N))
    return Roll(float(Psi), rotor, stator, F_N, tau, growth.rate)
