"""The least friction with which a backward whirl exists."""

from dataclasses import replace
from math import tau as TWO_PI

import numpy as np

from rsc.analysis.follow.escape import least_escape
from rsc.analysis.follow.events import AMPLITUDE, Event
from rsc.analysis.follow.lines import FOLD
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import contact_receptance, coupled_frequencies, phase_slopes, receptance_rotor
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.paper.roots import whirl_roots
from rsc.analysis.paper.whirls import normal_force
from rsc.system.assemble import SceneLike, assemble
from rsc.system.system import FloatOrArray, System

ROLLS, LIMIT = "it rolls (13)", "end of the band or of the contact's depth"
NO_LEAST = "any friction"  # there is no fold, the least friction is 0
MOST = 5.0  # friction of a scene at most
_FRICTIONS = np.geomspace(1e-6, MOST, 61)
_ROUNDING = 1e-12  # |r_R| = s exactly for a rigid stator
_AT_LIMIT = 1e-6  # share by which a whirl that is located at the end of a condition misses it


def mu_min(scene: SceneLike, speed: float | None = None) -> Event | None:
    """Find the smallest friction with which a backward motion can last or run away: a whirl that slides with |r_R| >= s, stable
    or not (round an unstable one a bouncing one may last), one that rolls, or, without a contact diameter, one that grows without
    bound.

    The frequency of a whirl fixes its friction, mu = -Im H/Re H, and force F_N = -s/(|H|^2/Re H + 1/k_C). The least friction is
    that of a fold of two roots, Im(H'/H) = 0, of a whirl that just exceeds the gap, or of one that rolls, where the scene has a
    contact diameter: Psi = -Omega d_R/(2 |d|), (13) with |d| = s + F_N/k_C, needs the traction mu. Without a diameter nothing
    bounds whirls near the resonance of the contact itself, at any depth: only those count that press it in by less than s, and
    beside them the friction from which on a large enough motion runs away (`rsc.analysis.follow.escape`).
    Whirls outside the band of a reduced machine do not count.

    A rotor in a rigid wall has no fold: the smaller the friction, the faster its whirl, -b/(mu m) of a Laval rotor, until it
    rolls or comes near the resonance of the contact.

    Parameters
    ----------
    scene : Scene
        Its own friction does not matter.
    speed : float, optional, Hz
        Default: the first speed of the scene's drive.

    Returns
    -------
    Event or None
        `value` is the friction, `cause` `FOLD`, or what comes first: `AMPLITUDE` where |r_R| = s, `ROLLS` where it rolls, `LIMIT`
        at the end of the band or of the depth, `ESCAPES` where motions run away. Without damping, and below 1e-6 (a free motion
        of the rotor), it is 0 with the cause `NO_LEAST`, and the frequency the coupled one next to 0 or that at 1e-6. None if no
        friction up to `MOST`, that of a scene at most, gives a whirl.
    """
    return least_frictions(scene, speed)[0]


def least_frictions(scene: SceneLike, speed: float | None = None) -> tuple[Event | None, Event | None]:
    """(`mu_min` of a scene at a speed, the same of the whirls that slide or roll alone), which differ where motions run away."""
    system = assemble(scene)
    Omega = TWO_PI * (scene.drive.speed[0] if speed is None else float(speed))
    if Omega < 0.0:
        events = _both(system.mirrored(), -Omega, tuple(-end for end in band_of(scene)[::-1]))
        return tuple(event and replace(event, frequency=-event.frequency) for event in events)
    return _both(system, Omega, band_of(scene))


def _both(system: System, Omega: float, band):
    """`least_frictions` of a System whose rotor turns forward or stands; band in rad/s."""
    system = system.at_speed(Omega)
    lasts = _least(system, Omega, band)
    known = filter(None, (lasts, least_escape(system, Omega, band)))
    return min(known, key=lambda event: event.value, default=None), lasts


def band_of(scene):
    """Lowest and highest frequency, rad/s, of whirls that the bodies of a scene hold for."""
    bands = [getattr(body, "band", (-np.inf, np.inf)) for body in (scene.rotor, scene.stator)]
    return tuple(TWO_PI * choose(ends) for choose, ends in zip((max, min), zip(*bands, strict=True), strict=True))


def _least(system: System, Omega: float, band):
    """The least friction of the whirls that last, of a System at the speed Omega; band in rad/s."""
    damped = any(body.damping.any() or body.n_states for body in system.bodies)
    if not (damped or system.skew):  # nothing takes what friction feeds
        frequencies = coupled_frequencies(system, Omega) / TWO_PI
        return Event(NO_LEAST, 0.0, float(frequencies[frequencies < 0.0].max(initial=-np.inf)))
    rolls = [roll for roll in rolling_whirls(system.with_friction(MOST), Omega) if _counts(system, roll, band)]
    least = min(rolls, key=lambda roll: abs(roll.traction), default=None)
    rolling = least and Event(ROLLS, abs(least.traction), least.Psi / TWO_PI)
    sliding = _least_sliding(system, Omega, band)
    return min(filter(None, (sliding, rolling)), key=lambda event: event.value, default=None)


def _counts(system: System, roll, band):
    """Whether a whirl that rolls is backward, inside the band, and either stable or larger than the gap."""
    is_large = roll.rotor_amplitude >= (1.0 - _ROUNDING) * system.contact.gap
    return band[0] <= roll.Psi <= min(band[1], 0.0) and (is_large or roll.stable)


def _least_sliding(system: System, Omega: float, band):
    """The least friction of the whirls that slide, or None; where they begin to roll is told by rolling."""
    first = next((i for i, mu in enumerate(_FRICTIONS) if len(_backward(system, mu, Omega, band))), None)
    if first is None:
        return None
    high = float(_FRICTIONS[first])
    if first == 0:
        return Event(NO_LEAST, 0.0, float(_backward(system, high, Omega, band)[-1]) / TWO_PI)
    low = float(_FRICTIONS[first - 1])
    for relative in (1e-3, 1e-12):
        while high - low > relative * high:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if len(_backward(system, middle, Omega, band)) else (middle, high)
        fold = _fold(system, Omega, _backward(system, high, Omega, band).mean())
        is_near = fold is not None and abs(fold.value - high) <= 2.0 * relative * high
        if is_near and _lasts(system.with_friction(fold.value), np.array([TWO_PI * fold.frequency]), Omega, band)[0]:
            return fold
    Psi = _backward(system, high, Omega, band)[:1]
    _, amplitude, slip = _motion(system.with_friction(high), Psi, Omega)
    gap = system.contact.gap
    cause = ROLLS if slip[0] < _AT_LIMIT * abs(Psi[0]) * gap else LIMIT
    return Event(AMPLITUDE if amplitude[0] < (1.0 + _AT_LIMIT) * gap else cause, high, float(Psi[0]) / TWO_PI, "above")


def _backward(system: System, friction, Omega: float, band):
    """Roots of the backward whirls with F_N > 0 and |r_R| >= s, no faster than rolling, at another friction."""
    system = system.with_friction(float(friction))
    Psi = whirl_roots(system, Omega)
    return Psi[_lasts(system, Psi, Omega, band)]


def _lasts(system: System, Psi: FloatOrArray, Omega: float, band):
    """Which roots are whirls that may last."""
    F_N, amplitude, slip = _motion(system, Psi, Omega)
    lasts = (Psi < 0.0) & (Psi >= band[0]) & (Psi <= band[1])
    lasts &= (F_N > 0.0) & (amplitude >= (1.0 - _ROUNDING) * system.contact.gap) & (slip >= 0.0)
    law = law_of(system)
    return lasts if law.diameter is not None else lasts & law.within_its_gap(F_N)


def _motion(system: System, Psi: FloatOrArray, Omega: float):
    """(F_N in N, |r_R| in m, slip in m/s: infinite without a diameter) of whirls."""
    law, F_N = law_of(system), normal_force(system, Psi, Omega)
    with np.errstate(invalid="ignore"):  # at a pole of an undamped body there is no force
        amplitude = np.abs(receptance_rotor(system, Psi, Omega)) * law.oblique * np.abs(F_N)
    if law.diameter is None:
        return F_N, amplitude, np.full(np.shape(Psi), np.inf)
    distance = law.distance(F_N)
    return F_N, amplitude, law.slip(Psi, Omega, distance) - law.carried(distance)


def _fold(system: System, Omega: float, Psi: float):
    """The fold next to a frequency: the minimum of mu = -Im H / Re H; None if there is none with F_N > 0."""
    system = system.with_friction(0.0)
    for _ in range(60):
        slope, bend = (float(part[0]) for part in phase_slopes(system, Omega, np.array([Psi])))
        step = slope / bend
        Psi -= np.clip(step, -0.02 * abs(Psi), 0.02 * abs(Psi))
        if abs(step) <= 1e-13 * abs(Psi):
            H = contact_receptance(system, Omega, np.array([Psi]))[0][0]
            return Event(FOLD, float(-H.imag / H.real), float(Psi) / TWO_PI)
    return None
