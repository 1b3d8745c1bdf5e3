"""The answer: motion, vibration, force, changes, end of the run, and other motions that last.

What a window is, is asked of `rsc.measure.kinds` alone; what else can last, of the simulated list of motions. Nothing is decided
here: these are words.
"""

import math
import textwrap

import numpy as np

from rsc.analysis.follow.least_friction import MOST
from rsc.measure.catalogue import WHIRLING
from rsc.measure.kinds import BACKWARD, Kind
from rsc.measure.several import together
from rsc.measure.severity import is_line, others_of, rate_of
from rsc.measure.stretches import at_contacts
from rsc.show.words.at_contacts import contact_lines, named_places
from rsc.show.words.clearances import touching, watched_text
from rsc.show.words.compared import compared_answer
from rsc.show.words.held import outcomes_text
from rsc.show.words.limits import limits_summary
from rsc.show.words.reasons import percent
from rsc.show.words.verdict import coverage_text, size_text, verdict_text
from rsc.show.words.vibration import approach_text, vibration_text
from rsc.show.words.wording import (
    amount,
    frequencies_text,
    frequency_text,
    interval,
    moment,
    motion_name,
    rates_text,
    where,
    whirl_name,
)

COLUMNS = 100
MOST_CHANGES = 3
RELIABLE = 0.2  # share by which the friction is below the least one that something lasts with: less is within what is known of it
OTHERS = (Kind.FORWARD_RUB, Kind.PARTIAL_RUB, Kind.RESTING, Kind.TRANSIENT)


def answer(report):
    """(topic, text) lines of a Report, about a dozen."""
    if report.stretches is None:
        return compared_answer(report)
    lines = [("verdict", verdict_text(report.verdict))] if report.verdict else []
    lines += [("whirl", _whirl(report)), ("frequency", _frequency(report))]
    if report.lead:
        lines += contact_lines(report, lambda time: moment(report, time))
    else:
        lines += [("vibration", vibration_text(report, _whirl_line(report))), ("closest approach", approach_text(report))]
        lines += [("force", _force(report))]
    lines += [("drive", _drive(report))]
    lines += [("clearances", watched_text(report.result.scene, report.stretches))]
    lines += [("limits", limits_summary(report.limits) if report.limits else "")]
    lines += [("change", text) for text in _changes(report)]
    lines += [("at the end", _end(report)), *_others(report)]
    lines += [("mu_min", least_friction(listed)) for listed in report.motions[:1]] + [("check", report.agreement)]
    return [(topic, text) for topic, text in lines if text]


def answer_text(report):
    """The answer as text of at most 100 columns."""
    lines = answer(report)
    width = max(len(topic) for topic, _ in lines) + 2
    folded = []
    for topic, text in lines:
        head = f"{topic}:".ljust(width)
        folded += textwrap.wrap(text, COLUMNS, initial_indent=head, subsequent_indent=" " * width, break_long_words=False)
    return "\n".join(folded)


def places_of(report, kinds):
    """Numbers of the windows whose motion is one of some kinds."""
    return np.flatnonzero(np.isin(report.features.kind, [str(kind) for kind in kinds]))


def whirling(report):
    """Numbers of the windows in backward whirl."""
    return places_of(report, BACKWARD)


def _whirl(report):
    """Every kind of motion that the run shows, whirls first."""
    told = []
    for kind in WHIRLING:
        places = places_of(report, [kind])
        if len(places):
            told += [f"{name} at a rotor speed of {where(report, own)}" for name, own in _named(report, kind, places)]
    unknown = places_of(report, [Kind.NOT_RESOLVED])
    if not set(whirling(report)):
        told.append("no backward whirl" if not len(unknown) else "no backward whirl is seen where the motion is resolved")
    for kind in OTHERS:
        places = places_of(report, [kind])
        if len(places):
            told += [f"{name} at {where(report, own)}" for name, own in _named(report, kind, places)]
    if Kind.ROLLING in report.features.kind and any(contact.race_inertia is not None for contact in report.result.scene.contacts):
        told.append("it rolls since the race turns along, which is its purpose")
    if len(unknown):
        told.append(f"not resolved at {where(report, unknown)}: {report.features.why[unknown[0]]}")
    if not any(own.contact_time.any() for own in at_contacts(report.result)):
        told.append("no contact")
    return "; ".join(told)


def _named(report, kind, places):
    """[(name, places)] of the windows of one kind; with several contacts, separate entries for different contacts."""
    return named_places(report, places) if report.lead else [(kind, places)]


def _frequency(report):
    """The rates at which whirls turn, with a line's digits where samples show one."""
    texts = []
    for name, kinds in (("", BACKWARD), ("forward whirl ", [Kind.FORWARD_WHIRL])):
        places = places_of(report, kinds)
        if len(places):
            values = np.array([rate_of(report.features, i) for i in places])
            low, high = float(values.min()), float(values.max())
            texts.append(name + rates_text(low, high, explained=not (name or texts)))
    return "; ".join(texts)


def _whirl_line(report):
    """The largest line of the whirls, m; NaN if the largest line does not belong to the whirl."""
    features = report.features
    lines = [i for i in whirling(report) if np.isfinite(features.amplitude[i])]
    largest = max(lines, key=lambda i: features.amplitude[i], default=None)
    return features.amplitude[largest] if largest is not None and is_line(features, largest) else math.nan


def _force(report):
    """The largest force and power of friction: heat, or without a diameter the power input into the motion."""
    stretches, whole = report.stretches, report.stretches.whole()
    if not whole.force_max > 0.0:
        return ""
    text = f"up to {amount(whole.force_max, 'N')} normal at {moment(report, whole.force_max_at)}"
    heats = report.contact.diameter is not None
    work = _heat(stretches) if heats else stretches.friction_work
    power, when = _largest_power(report, work)
    if power == 0.0:
        return text
    words = "friction heat" if heats else f"power {'input by' if power > 0.0 else 'lost to'} friction"
    return f"{text}; {words} up to {amount(abs(power), 'W')}, {when}"


def _heat(stretches):
    """Heat of friction in each stretch (n,), J: work taken from the drive minus work on a race and on the motion."""
    return stretches.drive_work - stretches.race_work - stretches.friction_work


def _largest_power(report, work):
    """(the largest mean over a stretch in W, in words when) of the works (n,) of all stretches in J."""
    stretches = report.stretches
    power = work / (stretches.end - stretches.begin)
    place = int(np.argmax(np.abs(power)))
    return float(power[place]), interval(report, stretches.begin[place], stretches.end[place])


def _drive(report):
    """Torque and power that friction at the contact takes from the drive, or gives it where the surfaces slide the other way, and
    its energy beside the rotor's own."""
    scene, each = report.result.scene, at_contacts(report.result)
    if any(contact.diameter is None for contact in scene.contacts) or not any(own.friction_impulse.any() for own in each):
        return ""
    pairs = zip(scene.contacts, each, strict=True)
    torques = sum(0.5 * contact.diameter * own.friction_impulse / (own.end - own.begin) for contact, own in pairs)
    torque, work = np.abs(torques).max(), sum(own.drive_work for own in each)
    power, when = _largest_power(report, work)
    energy = float(work.sum())
    words = "rub torque on the shaft" if power >= 0.0 else "the rub drives the shaft with"
    text = f"{words} up to {amount(torque, 'N m')}, power up to {amount(abs(power), 'W')}"
    other = "" if energy * power >= 0.0 else " taken from the shaft" if energy > 0.0 else " given to the shaft"
    text += f", {when}; {amount(abs(energy), 'J')}{other} over the run"
    if any(contact.race_inertia is not None for contact in scene.contacts):
        heat, raced = (float(sum(values.sum() for values in parts)) for parts in zip(*map(_shared, each), strict=True))
        text += f" (heat {amount(heat, 'J')}, inner races {amount(raced, 'J')})"
    inertia = getattr(scene.rotor, "polar_inertia", None)
    fastest = 2.0 * np.pi * float(np.max(np.abs(scene.drive.speed)))
    kinetic = 0.5 * inertia * fastest**2 if isinstance(inertia, float) else 0.0
    return text + (f", {energy / kinetic:.2g} times the rotor's kinetic energy" if energy > kinetic > 0.0 else "")


def _shared(stretches):
    """(heat, work on a race) of each stretch, J."""
    return _heat(stretches), stretches.race_work


def _changes(report):
    """Changes between whirls for the answer: lines that do not belong to a whirl are excluded."""
    windows = report.windows
    whirls, texts = {windows[i].branch for i in whirling(report) if windows[i].branch}, []
    changes = [change for change in report.transitions if whirls & {change.before, change.after}]
    for change in changes[:MOST_CHANGES]:
        before, after = map(whirl_name, (change.before, change.after))
        end = f"predicted to end at {frequency_text(change.predicted, '.1f')}" if change.predicted == change.predicted else ""
        jump = change.predicted_jump
        left = f"left at {frequency_text(jump, '.1f')} in a run like this" if jump == jump else ""
        why = " and ".join(part for part in (end, left) if part)
        texts.append(f"{before} to {after} at {frequency_text(change.taken_over, '.1f')}" + (f" ({why})" if why else ""))
    more = len(changes) - MOST_CHANGES
    return [*texts, f"and {more} more (--verbose)"] if more > 0 else texts


def _end(report):
    """What the run ends in, and how far a predicted whirl that it follows goes."""
    last = len(report.features.kind) - 1
    kind, speed = report.features.kind[last], report.speeds[last]
    name = report.features.names[last] if report.lead else kind
    text = f"{name}, at a rotor speed of {frequency_text(speed)}" if report.lead else f"{kind} at {frequency_text(speed)}"
    branch = next((b for b in report.branches if b.label == report.windows[last].branch), None)
    if branch is None or kind not in BACKWARD:
        return text
    whirl = branch.at(speed)
    if whirl is not None and whirl.touches:
        return f"{text}, whirl {branch.label}, which {touching(whirl.touches)}"
    return f"{text}, whirl {branch.label}, predicted to be {_stable(branch, report.natural['coupled'][0])}"


def _stable(branch, speeds):
    """Over which of the speeds of a run a whirl is stable."""
    stable = branch.speed[branch.stable]
    if not stable.size:
        if any(branch.touches):
            return "stable nowhere without touching a clearance"
        return "unstable" if (branch.growth_rate >= 0.0).any() else "not circular: stability not assessed"
    low, high = stable.min(), stable.max()
    if low > speeds.min() and high < speeds.max():
        return f"stable from {frequencies_text(low, high, '.1f')}"
    if low > speeds.min():
        return f"stable above {frequency_text(low, '.1f')}"
    return f"stable below {frequency_text(high, '.1f')}" if high < speeds.max() else "stable at all speeds of the run"


def _of_run(report, speed):
    """Label of the whirl that the run itself follows in the window nearest to a speed in Hz, "" for none."""
    return report.windows[int(np.argmin(abs(report.fall.speed - speed)))].branch if report.windows else ""


def _others(report):
    """Motions that last after an impact, predicted motions not reached, and the coverage, for each list."""
    lines = []
    for listed in report.motions:
        others = others_of(listed, report.features, report.speeds.tolist())
        at = f"at {frequency_text(listed.speed)}"
        if others:
            lines.append(("after an impact", f"{at}: {' or '.join(_motion(motion, listed) for motion in others)}"))
        predicted = [
            f"whirl at {together(one.pressed)} ({frequency_text(one.frequency)}, {amount(one.normal_force, 'N')})"
            if one.forces
            else f"{whirl_name(one.label)} ({frequency_text(one.frequency)}, {one.amplitude / listed.gap:.2f} gaps)"
            for one in listed.not_reached
            if one.stable and one.label not in ("forward rub", _of_run(report, listed.speed))
        ]
        if predicted:
            lines.append(("not reached", f"{at} predicted to be stable, but no run ended there: {', '.join(predicted)}"))
    coverage = report.verdict.coverage if report.verdict else ()
    return lines + ([("coverage", coverage_text(coverage))] if coverage else [])


def least_friction(listed):
    """The least friction with which something backward lasts or runs away at the speed of a list."""
    at = f"at {frequency_text(listed.speed)}"
    if listed.largest_at:
        return f"{at} the least friction with which a whirl lasts is not known: that is computed for one contact only yet"
    whirl = _whirls_from(listed)
    if not listed.mu_min < listed.mu_whirl and not (listed.mu_min >= 0.0 and math.isnan(listed.mu_whirl)):
        return f"{at} {whirl}{_margin(listed)}{_not_counted(listed)}"
    return (
        f"{at} a large enough motion runs away, as contact.diameter is not given, with a friction of {listed.mu_min:.3g} or more "
        f"({frequency_text(listed.mu_min_frequency)}); {whirl} within a depth of one gap{_margin(listed)}{_not_counted(listed)}"
    )


def _margin(listed):
    """How far the friction of the scene is below the least one: known to a fifth at best, it must be far below."""
    if not listed.friction < listed.mu_min:
        return ""
    share = 1.0 - listed.friction / listed.mu_min
    small = ": do not rely on so small a margin" if share < RELIABLE else ""
    return f"; the scene's {listed.friction:.3g} is {percent(share)} below{small}"


def _not_counted(listed):
    """Predicted backward whirls that do not count in the least friction, where the friction of the scene is below that."""
    below = not listed.friction >= listed.mu_min
    names = [
        f"{whirl_name(one.label)} ({frequency_text(one.frequency)})"
        for one in listed.not_reached
        if below and not one.possible and one.frequency * listed.speed < 0.0
    ]
    verb = "would have to slide backwards and does" if len(names) == 1 else "would have to slide backwards and do"
    return f"; {' and '.join(names)} {verb} not count" if names else ""


def _whirls_from(listed):
    """From which friction on a whirl is predicted."""
    if math.isnan(listed.mu_whirl):
        return f"no backward whirl is predicted with any friction up to {MOST:g}"
    if not listed.mu_whirl:
        return "a backward whirl is possible at any friction, because a mode has no damping"
    whirl = f"{listed.mu_whirl:.3g} ({frequency_text(listed.mu_whirl_frequency)})"
    return f"the least friction with which a backward whirl is predicted is {whirl}"


def _motion(motion, listed):
    """A motion of a list in words."""
    started = f", {listed.hits(motion) or 'none'} of {listed.starts} impacts" if listed.starts else ""
    started += f"; {outcomes_text(motion.held)}" if motion.held else ""
    if not motion.bounded:
        return f"{motion.motion} (it still grew at 20 gaps{started})"
    if motion.contacts:
        return _several(motion, started)
    gaps = f"|r| {motion.amplitude_max / listed.gap:.2f} gaps"
    if motion.motion == Kind.NO_CONTACT:
        return f"{motion.motion} ({gaps}{started})"
    rate = "" if math.isnan(motion.frequency) else f"{frequency_text(motion.frequency)}, "
    touches = f", {touching(motion.touches)}" if motion.touches else ""
    return f"{motion.motion} ({rate}{gaps}, {size_text(motion)}{touches}{started})"


def _several(motion, started):
    """A motion at several contacts in words."""
    rate = "" if math.isnan(motion.frequency) else f"{frequency_text(motion.frequency)}, "
    at = {name: f"{name} {own.over_gap:.2f} gaps" for name, own in motion.contacts.items()}
    touched = [f"{at[name]}, {amount(motion.contacts[name].force_max, 'N')}" for name in motion.touched]
    touches = f", {touching(motion.touches)}" if motion.touches else ""
    return f"{motion_name(motion)} ({rate}{'; '.join(touched or at.values())}{touches}{started})"
