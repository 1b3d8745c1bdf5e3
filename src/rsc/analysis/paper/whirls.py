"""Backward whirl in closed form: whirl roots, forces, deflection shapes, side conditions (14)-(28).

A steady whirl turns at Psi with the contact angle held at 0 in its own frame, so that d = l_R r_R - l_S r_S is
real and positive. The constant load of a scene is not part of this theory. Omega and Psi are rad/s throughout.
"""

from dataclasses import dataclass

import numpy as np

from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import along, pushed, receptance
from rsc.analysis.paper.roots import MET, entry_at, roots_by_place, whirl_condition
from rsc.system.system import FloatOrArray, System

DOMINANCE = 3.0  # |F_Psi| / |F_Omega| from which the asynchronous force dominates
MOST_MIRROR = 0.1  # |a_-| / |a| up to which a whirl counts as a circle where directions differ
# side conditions without which a whirl is not claimed to be stable, whatever its growth rate
CIRCULAR, WITHIN = "nearly_circular", "within_clearances"


@dataclass(frozen=True, eq=False)
class Condition:
    """One side condition at each root: its margin (larger is safer, see `side_conditions`) and whether it holds."""

    margin: np.ndarray
    holds: np.ndarray


def normal_force(system: System, Psi: FloatOrArray, Omega: FloatOrArray, rigid=False):
    """Normal force of a whirl, F_N = -s / (Re[(1 + i mu) H(Psi)] + 1/k_C) (27).

    Parameters
    ----------
    system : System
    Psi : array_like of float, rad/s
        Roots of the whirl condition.
    Omega : float, rad/s
    rigid : bool
        True for the paper's rigid contact, k_C = infinity.

    Returns
    -------
    ndarray of float, shape of Psi, N
        Not positive: no steady whirl at this root.
    """
    law = law_of(system)
    return law.normal_force((law.turn * receptance(system, Psi, Omega)).real, rigid)


def steady_whirls(system: System, Omega: FloatOrArray):
    """Psi (rad/s) and F_N (N) of every whirl at a rotor speed in rad/s: the roots with positive normal force, rising."""
    return whirls_by_place(system, Omega)[1:]


def whirls_by_place(system: System, Omega: FloatOrArray):
    """(places, Psi, F_N) of every whirl of a stack of systems (`system.stacked`) at their rotor speeds, by place and rising."""
    place, Psi = roots_by_place(system, Omega, only_met=True)
    F_N = normal_force(system.at(place), Psi, entry_at(Omega, place))
    exists = F_N > 0.0
    return place[exists], Psi[exists], F_N[exists]


def whirl_shapes(system: System, Psi: FloatOrArray, F_N: FloatOrArray, Omega: FloatOrArray):
    """Deflections of a whirl in the frame turning with Psi, contact angle 0 (19), (20).

    r_R = -A_R^-1 l_R (1 + i mu) F_N,  r_S = A_S^-1 l_S (1 + i mu) F_N,  l_R^T r_R - l_S^T r_S = s + F_N / k_C.

    Parameters
    ----------
    system : System
    Psi, F_N : array_like of float, one shape, rad/s and N
        A root and its normal force.
    Omega : float, rad/s

    Returns
    -------
    rotor, stator : ndarray of complex, shape of Psi followed by (N,) and (M,), m (tilts: rad)
    """
    return pushed(system, Psi, Omega, law_of(system).turn * np.asarray(F_N))


def side_conditions(
    system: System, Psi: FloatOrArray, F_N: FloatOrArray, Omega: FloatOrArray, F_Omega, mirror_share=None, deflected=None
):
    """Judge whirl roots by the paper's side conditions.

    Parameters
    ----------
    system : System
        Or a stack with one system for each root.
    Psi, F_N : array_like of float, one shape, rad/s and N
        Roots and their normal forces.
    Omega : float, rad/s, or one each
    F_Omega : array_like of complex, shape of Psi, N
        Synchronous contact force (`rsc.analysis.paper.synchronous.synchronous_response`).
    mirror_share : array_like of float, shape of Psi, optional
        Where directions differ (`rsc.analysis.paper.anisotropy.mirror_line`).
    deflected : (n, k) float, optional
        Deflection over gap at every clearance that is watched (`rsc.analysis.paper.watched`).

    Returns
    -------
    dict of str to Condition, with the margins

        psi_real                      |Psi d arg(cH)/dPsi|: 0 at the fold where the root stops being real
        normal_force_positive         F_N in N, holds above 0
        asynchronous_force_dominates  |F_Psi| / |F_Omega|, holds above 3
        rotor_amplitude_exceeds_gap   |r_R| / s - 1 at the contact coordinate, holds above 0
        sliding                       (Omega d_R/2 + Psi |d| - slip velocity) / |Omega d_R/2|, holds above 0;
                                      infinite without a contact diameter
        contact_stiff_enough          k_C s / F_N(rigid) - 1, holds above 0
        nearly_circular               0.1 less the mirror share, holds from 0; only where a mirror share is given
        within_clearances             1 less the largest deflection over gap, holds above 0; only with clearances
    """
    Psi, F_N = np.asarray(Psi, dtype=float), np.asarray(F_N, dtype=float)
    law = law_of(system)
    sine, slope = whirl_condition(system.at_speed(Omega).joined().with_states(), law.friction, Omega, Psi)
    rotor, _ = whirl_shapes(system, Psi, F_N, Omega)
    F_rigid = normal_force(system, Psi, Omega, rigid=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        stiff = np.where(F_rigid > 0.0, law.stiff_enough(F_rigid), -np.inf)
        dominance = law.oblique * np.abs(F_N) / np.abs(F_Omega)
    amplitude = np.abs(along(rotor, system.rotor.contact)) / law.gap - 1.0
    sliding = sliding_margin(law, Psi, law.distance(F_N), Omega)
    conditions = {
        "psi_real": Condition(np.abs(Psi * slope), np.abs(sine) < MET),
        "normal_force_positive": Condition(F_N, F_N > 0.0),
        "asynchronous_force_dominates": Condition(dominance, dominance > DOMINANCE),
        "rotor_amplitude_exceeds_gap": Condition(amplitude, amplitude > 0.0),
        "sliding": Condition(sliding, sliding > 0.0),
        "contact_stiff_enough": Condition(stiff, stiff > 0.0),
    }
    if mirror_share is not None:
        circular = MOST_MIRROR - np.asarray(mirror_share)
        conditions[CIRCULAR] = Condition(circular, circular >= 0.0)
    if deflected is not None:
        free = 1.0 - deflected.max(axis=-1)
        conditions[WITHIN] = Condition(free, free > 0.0)
    return conditions


def sliding_margin(law, Psi: FloatOrArray, distance, Omega: FloatOrArray):
    """Margin of (12) as `side_conditions` tells it, given |d| in m, with a race that turns as friction turns it at last."""
    if law.diameter is None:
        return np.full(np.shape(Psi), np.inf)
    surface = law.surface(Omega)
    slip = law.slip(Psi, Omega, distance) - law.carried(distance) - (0.0 if law.slip_velocity is None else law.slip_velocity)
    with np.errstate(divide="ignore", invalid="ignore"):
        margin = np.where(surface != 0.0, slip / np.abs(surface), np.copysign(np.inf, slip))
    return np.where(np.isnan(law.diameter), np.inf, margin)
