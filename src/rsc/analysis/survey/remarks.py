"""Remarks on a prediction in words: scenes without a whirl or with free motions, unstable whirls and where they lead, undecided
stability, whirls that roll."""

import math
from math import tau as TWO_PI

import numpy as np

from rsc.analysis.alone.free_vibration import free_growth, free_vibrations, threshold_speed
from rsc.analysis.balance.elliptic_whirl import elliptic_whirl
from rsc.analysis.balance.problem import LEAST_TOLD, NotBalanced
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.receptance import free_motions, in_both_directions
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.paper.small_motions import damper_limits, departure, undecided
from rsc.analysis.paper.whirls import MOST_MIRROR
from rsc.analysis.several.search import COMPLETE, MOST
from rsc.analysis.survey.plausible import negative_damping, plausibility_remarks
from rsc.system.system import System

_ROUNDING = 1e-12  # of a speed
MOST_APART = 0.3  # of the mean compliance, up to which whirls of the mean are those of the machine
_SINGULAR = 1e12  # condition of a stiffness that holds nothing
_STILL = 1e-6  # of its growth rate: a frequency below is none
_NEAR = 0.05  # of a stable whirl's frequency: a growing line so close is taken for the way to it


def scene_remarks(system: System, whirls):
    """Plain statements about a System, given all whirls that are predicted for it; a list of str."""
    remarks = []
    if system.law.friction == 0.0:
        remarks.append("no friction: no backward whirl")
    remarks += body_remarks(system, whirls) + plausibility_remarks(system)
    rigid = system.n_stator == 0 and not system.contact.in_rotor
    if rigid and whirls and not any(whirl.decays for whirl in whirls):
        remarks.append("no stator moves: under constant friction no backward whirl of this scene is stable")
    return remarks


def body_remarks(system: System, whirls):
    """Plain statements about the bodies of a System, whatever its contacts, given its whirls; a list of str."""
    n_free, remarks = free_motions(system.at_first_speed), direction_remarks(system.at_first_speed)
    if n_free:
        remarks.append(f"free motions of the rotor (singular stiffness): {n_free}; without contact nothing brings it back")
    if system.switched:
        times = ", ".join(f"{one.time:g} s" for one in system.switched)
        remarks.append(f"bearings are switched off at {times}: predictions are those for the machine without them")
    remarks += _undamped(system.at_first_speed) + (_free_instability(system, whirls) or negative_damping(system))
    return remarks + _threshold_remark(system) + knot_remarks(system)


def direction_remarks(system: System):
    """Remark on supports so much stiffer in one direction than in the other that whirls of their mean may miss the machine's;
    a list of str."""
    share = max((directions_differ(*side) for side in _sides(system)), default=0.0)
    if not share > MOST_APART:
        return []
    differs = f"the compliance at the contact differs by {100.0 * share:.0f} % between directions"
    simulated = "those that live by the difference are found by simulation only (rsc motions)"
    return [f"{differs}: whirls are predicted from the mean of the directions; {simulated}"]


def _sides(system: System):
    """(body, its row of a contact) of both bodies at every contact."""
    for contact in system.contacts:
        yield system.rotor, contact.rotor
        yield system.stator, contact.stator


def directions_differ(body, row):
    """How far the static compliances of a body at a row (n,) differ between the directions in which they are largest and least,
    as a share of their mean; 0 of a body that is alike in all directions or that nothing holds."""
    E = body.anisotropic_stiffness
    if E is None or not E.any() or not row.any():
        return 0.0
    stiffness = in_both_directions(body.stiffness, E)  # of K r + E conj(r) = f
    if np.linalg.cond(stiffness) > _SINGULAR:
        return 0.0
    both = np.kron(np.eye(2), row)
    least, most = np.linalg.eigvalsh(both @ np.linalg.solve(stiffness, both.T))
    return float((most - least) / (0.5 * abs(most + least)))


def set_remarks(system: System):
    """Remarks on what is not predicted, or not shown, of whirls at several contacts of a System; a list of str."""
    n = len(system.contacts)
    remarks = ["forward rubs, whirls that roll and delayed jumps are predicted for one contact only (rsc motions simulates them)"]
    if n <= COMPLETE:
        return remarks
    most = f"; sets of more than {MOST} are not looked at" if n > MOST else ""
    shown = f"whirls at {COMPLETE + 1} contacts or more are what Newton's method found; that none is missing is not shown{most}"
    return [*remarks, shown]


def _undamped(system: System):
    """Remark on bodies without any damping."""
    bodies = [("rotor", system.rotor)] + ([("stator", system.stator)] if system.n_stator else [])
    names = " and ".join(name for name, body in bodies if not (body.damping.any() or body.n_states))
    if not names:
        return []
    has, its = ("have", "their") if " and " in names else ("has", "its")
    return [f"{names} {has} no damping: no motion without contact dies away, and {its} resonances are without bound"]


def _free_instability(system: System, whirls):
    """Remark on a rotor that its supports drive without contact: at the corners of the schedule, at the knots of its coefficients
    in between, and at the speeds of whirls."""
    knots, schedule = system.knot_speed, system.schedule_speed
    feeds = system.skew or len(knots) or system.rotor.n_states
    if system.isotropic and not feeds:  # damping and gyroscopics alone let every vibration die away
        return []
    passed = knots[(knots > schedule.min()) & (knots < schedule.max())] if len(knots) else knots
    speeds = [whirl.speed for whirl in whirls]
    for speed in sorted({*(schedule / TWO_PI), *(passed / TWO_PI), *(f(speeds) for f in (min, max) if speeds)}):
        fastest = max(free_vibrations(system, speed), key=lambda vibration: vibration.growth_rate)
        if free_growth(system, TWO_PI * speed) > 0.0 and fastest.growth_rate > 0.0:
            where = f"at a rotor speed of {speed:g} Hz"
            motion = f"it vibrates at {fastest.frequency:.4f} Hz, logarithmic decrement {fastest.decrement:.4g}"
            if TWO_PI * abs(fastest.frequency) < _STILL * fastest.growth_rate:
                motion = f"it is pushed away at {fastest.growth_rate:.4g} 1/s"
            return [f"the rotor is unstable without contact {where}: {motion}"]
    return []


def _threshold_remark(system: System):
    """Remark on the speed above which what follows the speed makes the rotor unstable without contact."""
    if not system.follows:
        return []
    causes = (("rotating damping", system.rotor.rotating_damping), ("coefficients that follow the speed", system.rotor.knots))
    cause = " and ".join(name for name, part in causes if part is not None)
    one = cause == "rotating damping"
    speed = threshold_speed(system) / TWO_PI
    if math.isinf(speed):
        return [f"{cause}: at no speed {'does it' if one else 'do they'} make the rotor unstable without contact"]
    if speed == 0.0:
        return []  # unstable for another reason, which is told
    return [f"{cause} {'makes' if one else 'make'} the rotor unstable without contact above {speed:.6g} Hz"]


def knot_remarks(system: System):
    """Remark on a run that leaves the speeds between which coefficients of its rotor follow the speed; a list of str."""
    if not len(system.knot_speed):
        return []
    low, high = system.knot_speed[[0, -1]] / TWO_PI
    first, last = system.schedule_speed.min() / TWO_PI, system.schedule_speed.max() / TWO_PI
    near = _ROUNDING * max(abs(low), abs(high))
    if low - near <= first and last <= high + near:
        return []
    run = f"the run turns at {first:g} to {last:g} Hz" if first < last else f"the run turns at {first:g} Hz"
    return [f"coefficients follow the rotor speed from {low:g} to {high:g} Hz and are constant beyond: {run}"]


def whirl_remarks(system: System, whirls):
    """Remarks on the unstable whirls at one speed and on those whose stability the contact damper leaves open; a list of str."""
    remarks = []
    for whirl in whirls:
        name = f"whirl {whirl.frequency:.4f} Hz"
        if whirl.mirror is not None:
            remarks.append(f"{name}: {_mirror_text(system, whirl)}")
        if not whirl.growth_rate < 0.0:
            remarks.append(f"{name} is unstable, {departure_text(departure(system, whirl, whirls))}")
        limits = damper_limits(system, TWO_PI * whirl.frequency, whirl.normal_force, TWO_PI * whirl.speed)
        if not limits.signs_agree:
            rates = f"{limits.off.rate:+.4g} 1/s with the contact damper off, {limits.on.rate:+.4g} on"
            remarks.append(f"{name}: linear stability is undecided, growth {rates}")
    return remarks


def mirror_remarks(whirls):
    """A remark on each whirl at several contacts that decays, where directions differ; a list of str."""
    told = [whirl for whirl in whirls if whirl.mirror is not None and whirl.growth_rate < 0.0]
    return [f"whirl {whirl.frequency:.4f} Hz: {_share_text(whirl)}" for whirl in told]


def _share_text(whirl):
    """How far a whirl is from a circle."""
    mirror = whirl.mirror
    text = f"elliptical, counter-rotating component at {mirror.frequency:.4f} Hz of {_percent(mirror.share)} of the whirl"
    return f"{text}: not circular, stability not assessed" if "nearly_circular" in whirl.violated else text


def _mirror_text(system: System, whirl):
    """What supports whose directions differ make of a whirl of their isotropic mean."""
    text, gap = _share_text(whirl), system.contact.gap
    try:
        exact = elliptic_whirl(system, whirl.frequency, whirl.speed)
    except NotBalanced as problem:
        return f"{text}; of the exact whirl nothing is known: {problem}"
    low, high = (size / gap for size in exact.envelope)
    return f"{text}; exactly {exact.frequency:.4f} Hz, |r|/gap {exact.amplitude / gap:.4f}, from {low:.4f} to {high:.4f}"


def _percent(share):
    return f"{100.0 * share:.1f} %" if share >= LEAST_TOLD else "less than 0.1 %"


def rolling_remarks(system: System, speed):
    """Remarks on the whirls that roll at a rotor speed in Hz; a list of str."""
    return [
        f"rolling at {roll.Psi / TWO_PI:.4f} Hz, |r|/gap {roll.rotor_amplitude / system.contact.gap:.4f}, "
        f"F_N {roll.normal_force:.4g} N, "
        f"friction {roll.traction:.3g} F_N of at most {system.law.friction:g} F_N, growth {roll.growth_rate:+.4g} 1/s"
        for roll in rolling_whirls(system, TWO_PI * speed)
    ]


def departure_text(departure):
    """A `rsc.analysis.paper.small_motions.Departure` in words."""
    known = not math.isnan(departure.towards)
    if departure.kind == "creeping":
        to = f"leaves towards {departure.towards:.4f} Hz" if known else "runs away from it (no other whirl is its partner)"
        return f"without oscillation (real eigenvalue): pushed outwards it {to}, inwards it loses contact"
    to = "no stable whirl near"
    if known and abs(departure.line - departure.towards) < _NEAR * abs(departure.towards):
        to = f"leaves towards {departure.towards:.4f} Hz"
    return f"flutter (Hopf) at {departure.line:.4f} Hz, {to}"


def branch_remarks(system: System, branches):
    """Remarks on the unstable stretches of branches over the rotor speed that exceed the gap; a list of str."""
    remarks = []
    for branch in branches:
        if branch.amplitude.max() <= system.contact.gap:
            continue
        for i in _unstable(branch):
            whirl = branch.whirls[i]
            whirls = predict_system(system, whirl.speed)
            text = departure_text(departure(system, whirl, whirls))
            remarks.append(f"whirl {branch.label} at {whirl.speed:g} Hz ({whirl.frequency:.4f} Hz) is unstable, {text}")
    return remarks + [_mirror_of(branch) for branch in branches if branch.whirls[0].mirror] + damper_warnings(system, branches)


def _mirror_of(branch):
    """Remark on the mirror line of a branch where directions differ."""
    shares = np.array([whirl.mirror.share for whirl in branch.whirls])
    text = f"whirl {branch.label}: elliptical, counter-rotating component of up to {_percent(shares.max())} of the whirl"
    pieces = np.split(branch.speed, np.flatnonzero(np.diff(shares > MOST_MIRROR)) + 1)
    pieces = pieces[0 if shares[0] > MOST_MIRROR else 1 :: 2]
    where = " and ".join(_span(piece.min(), piece.max()) for piece in pieces)
    return f"{text}; not circular {where}: stability not assessed there" if where else text


def rub_remarks(rubs):
    """Remarks on forward rubs over the rotor speed that are no circles because directions differ; a list of str."""
    remarks = []
    for rub_range in rubs:
        stretches = rub_range.stretches(rub_range.mirror > MOST_MIRROR)
        if stretches:
            text = f"forward rub: elliptical, counter-rotating component of up to {_percent(rub_range.mirror.max())} of it"
            where = " and ".join(_span(*stretch) for stretch in stretches)
            remarks.append(f"{text}; not circular {where}: stability not assessed there")
    return remarks


def damper_warnings(system: System, branches):
    """Remarks on the speeds where the one-sided limits of the contact damper disagree on stability; a list of str."""
    return [
        f"whirl {branch.label}: linear stability is undecided {_span(low, high)}: the contact damper off or on"
        for branch in branches
        if branch.amplitude.max() > system.contact.gap
        for low, high in undecided(system, branch)
    ]


def _span(low, high):
    return f"at {low:.6g} Hz" if low == high else f"between {low:.6g} and {high:.6g} Hz"


def _unstable(branch):
    """One index for each unstable stretch of a branch: next to where it turns unstable, else in its middle."""
    stable, n = branch.growth_rate < 0.0, len(branch.whirls)
    edges = np.flatnonzero(np.diff(stable)) + 1
    for first, end in zip([0, *edges], [*edges, n], strict=True):
        if not stable[first]:
            yield first if first > 0 else end - 1 if end < n else n // 2
