"""The least friction with which a backward whirl exists."""

from dataclasses import replace

import numpy as np

from rsc.analysis.events import AMPLITUDE, SLIDING, Event
from rsc.analysis.rootlines import FOLD, contact_receptance, phase_slopes
from rsc.analysis.whirls import normal_force, receptance, receptance_rotor, whirl_roots
from rsc.system.assemble import SceneLike, assemble

TWO_PI = 2.0 * np.pi
NO_LEAST = "any friction"  # there is no fold, the least friction is 0
_FRICTIONS = np.logspace(-6.0, 3.0, 46)
_ROUNDING = 1e-12  # |r_R| = s exactly for a rigid stator
_ROLLS = 1e-6  # of its frequency: slip of a whirl that is located at the end of sliding


def mu_min(scene: SceneLike, speed: float | None = None) -> Event | None:
    """Find the smallest friction with which a backward whirl with |r_R| >= s exists, sliding or rolling, for rigid contact.

    The frequency of a whirl passes every mu = -Im H / Re H between two zeros of Re H; the least of them is a fold of
    two roots, Im(H'/H) = 0. (An elastic contact adds whirls near its own resonance, at once beyond all bounds and then
    smaller than the gap; `continuation` over the friction shows them.) With a contact diameter no whirl turns faster than
    rolling, -Omega d_R/(2 s) (13), which needs the friction -Im H / Re H there.

    A rotor in a rigid wall has no fold. The frequency at which a given friction holds a steady whirl runs to minus infinity as
    the friction goes to 0, as -b/(mu m) does for a Laval rotor: only rolling bounds it.

    Parameters
    ----------
    scene : Scene
        Its own friction and contact stiffness do not matter.
    speed : float, optional, Hz
        Default: the first speed of the scene's drive.

    Returns
    -------
    Event or None
        `value` is the friction, `cause` `FOLD`, or what comes first: `AMPLITUDE` where |r_R| = s, `SLIDING` where it rolls.
        Values below 1e-6 are given as 0 with the cause `NO_LEAST` and the frequency at 1e-6 (no damping, a free motion of the
        rotor), or minus infinity (a rigid wall, no contact diameter); None if no friction up to 1000 gives a whirl.
    """
    system = assemble(scene)
    Omega = TWO_PI * (scene.drive.speed[0] if speed is None else float(speed))
    if Omega < 0.0:
        event = _least(system.mirrored(), -Omega)
        return event and replace(event, frequency=-event.frequency)
    return _least(system, Omega)


def _least(system, Omega):
    """`mu_min` of a System whose rotor turns forward or stands."""
    first = next((i for i, mu in enumerate(_FRICTIONS) if len(_backward(system, mu, Omega))), None)
    if first is None:
        return None
    high = float(_FRICTIONS[first])
    if first == 0:
        losses = system.damping_r.any() or system.skew_stiffness_r is not None
        endless = system.n_stator == 0 and system.diameter is None and losses
        return Event(NO_LEAST, 0.0, -np.inf if endless else float(_backward(system, high, Omega)[-1]) / TWO_PI)
    low = float(_FRICTIONS[first - 1])
    for relative in (1e-3, 1e-12):
        while high - low > relative * high:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if len(_backward(system, middle, Omega)) else (middle, high)
        fold = _least_friction(system, Omega, _backward(system, high, Omega).mean())
        if fold is not None and abs(fold.value - high) <= 2.0 * relative * high:
            return fold
    Psi = float(_backward(system, high, Omega)[0])
    return Event(SLIDING if _slip(system, Psi, Omega) < _ROLLS * abs(Psi) else AMPLITUDE, high, Psi / TWO_PI, "above")


def _backward(system, friction, Omega):
    """Roots of the backward whirls with F_N > 0 and |r_R| >= s, no faster than rolling, at another friction and rigid contact."""
    system = replace(system, friction=float(friction))
    Psi = whirl_roots(system, Omega)
    Psi = Psi[(Psi < 0.0) & (normal_force(system, Psi, Omega, rigid=True) > 0.0) & (_slip(system, Psi, Omega) >= 0.0)]
    ratio = np.abs(receptance_rotor(system, Psi, Omega)) / np.abs(receptance(system, Psi, Omega))
    return Psi[ratio >= 1.0 - _ROUNDING]


def _slip(system, Psi, Omega):
    """By how much a whirl in rigid contact turns slower than it would roll (13), in rad/s; infinite without a diameter."""
    return np.inf if system.diameter is None else Psi + 0.5 * Omega * system.diameter / system.gap


def _least_friction(system, Omega, Psi):
    """The fold next to a frequency: the minimum of mu = -Im H / Re H; None if there is none with F_N > 0."""
    system = replace(system, friction=0.0)
    for _ in range(60):
        slope, bend = (float(part[0]) for part in phase_slopes(system, Omega, np.array([Psi])))
        step = slope / bend
        Psi -= np.clip(step, -0.02 * abs(Psi), 0.02 * abs(Psi))
        if abs(step) <= 1e-13 * abs(Psi):
            H = contact_receptance(system, Omega, np.array([Psi]))[0][0]
            return Event(FOLD, float(-H.imag / H.real), float(Psi) / TWO_PI)
    return None
