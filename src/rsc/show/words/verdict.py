"""The verdict in words: one to three sentences and the severity."""

import math
from math import isnan

from rsc.measure.kinds import Kind
from rsc.measure.severity import Severity
from rsc.show.words.held import outcomes_text
from rsc.show.words.wording import amount, frequencies_text, frequency_number, frequency_text, length, speed_range

MEANINGS = {
    Severity.SAFE: "no lasting contact was found",
    Severity.UNKNOWN: "too little settled to tell",
    Severity.AT_RISK: "a motion in contact can last once something starts it; no impact that was tried did",
    Severity.RUB: "contact that wears and heats, without a whirl",
    Severity.WHIRL: "a self-excited whirl: stop the machine and remove its cause",
    Severity.DESTRUCTIVE: "no machine survives it",
}


NOT_TOUCHED = "no impact that was tried reached the gap"
ON_RACE = "a whirl on the inner race, as after a drop: let the rotor run down"
PASSING = "contact that ends by itself, without a whirl"
NOT_STARTED = "a whirl can last once something starts it"  # beside a rub


def meaning_of(verdict):
    """What the severity of a verdict means."""
    run, impact, severity = verdict.run, verdict.impact, verdict.severity
    tried = [one for one in verdict.coverage if one.impacts]
    if severity == Severity.UNKNOWN and tried and not any(one.touched for one in tried):
        return NOT_TOUCHED
    if run is None or (impact and impact.hits and impact.severity == severity):
        return MEANINGS[severity]
    if severity == Severity.WHIRL and run.on_race:
        return ON_RACE
    meaning = PASSING if severity == Severity.RUB and run.motion == Kind.TRANSIENT else MEANINGS[severity]
    waiting = verdict.not_reached or (impact and not impact.hits and impact.severity.level > Severity.RUB.level)
    return f"{meaning}; {NOT_STARTED}" if severity == Severity.RUB and waiting else meaning


def verdict_text(verdict):
    """The verdict as one text: its sentences, and the severity with its meaning."""
    return " ".join(sentences(verdict))


def sentences(verdict):
    """The sentences of a `rsc.measure.severity.Verdict`; the last one tells the severity."""
    told = [_run(verdict.run)] if verdict.run else []
    told += _impact(verdict) if verdict.coverage else ["What impacts start was not looked for."]
    return [*told, f"Severity: {verdict.severity} ({meaning_of(verdict)})."]


def _run(run):
    """What the run did."""
    if not run.touched:
        return f"No contact in this run, at {speed_range(run.speed)}."
    rate = "" if isnan(run.frequency[0]) else f" of {_frequencies(run.frequency)}"
    motion = "contact that is not resolved" if run.motion == Kind.NOT_RESOLVED else f"{run.motion}{rate}"
    motion += " on a race that turns along, which is its purpose," if run.on_race else ""
    text = f"The run shows {motion} at {speed_range(run.speed)}, up to {amount(run.force_max, 'N')}"
    return f"{text}{beyond_text(run.border, '; beyond the model: ')}."


def _frequencies(ends):
    low, high = (frequency_number(end) for end in ends)
    return frequency_text(ends[0]) if low == high else frequencies_text(*ends)


def _impact(verdict):
    """What an impact starts, and whether drive and machine hold it; without any what the search covers."""
    impact = verdict.impact
    if impact is None:
        tried = sum(one.impacts for one in verdict.coverage)
        return [f"None of {tried} impacts started {'another' if verdict.run and verdict.run.touched else 'a'} motion in contact "
                f"({coverage_text(verdict.coverage)}).", *_not_reached(verdict)]  # fmt: skip
    at = f"At {frequency_text(impact.speed)}"
    if not impact.hits:
        size = "" if impact.motion == Kind.RUNNING_AWAY else beyond_text(impact.border, ", beyond the model: ")
        goes_on = "does not stop" if impact.motion == Kind.RUNNING_AWAY else "lasts"
        text = f"{at} none of {impact.impacts} impacts started {_motion(impact)}{size}, which {goes_on} once it is started"
        return [f"{text}; {_touched(_coverage_at(verdict, impact.speed))}.", *_not_reached(verdict)]
    text = f"{at} an impact starts {_motion(impact)}: {impact.hits} of {impact.impacts} impacts did"
    return [f"{text}{_smallest(impact)}.", *_machine(impact)]


def _not_reached(verdict):
    """The whirl that is predicted to last and that no run ended in."""
    if verdict.not_reached is None:
        return []
    speed, whirl = verdict.not_reached.speed, verdict.not_reached.whirl
    sense = "backward" if whirl.frequency * speed < 0.0 else "forward"
    text = f"At {frequency_text(speed)} a {sense} whirl of {frequency_text(whirl.frequency)} is predicted"
    return [f"{text} to be stable, but no run ended in it." if whirl.stable else f"{text} that only a long run would leave."]


def _motion(impact):
    """The motion that impacts start, with its size where the model holds for it."""
    rate = "" if isnan(impact.frequency) else f" of {frequency_text(impact.frequency)}"
    if impact.motion == Kind.RUNNING_AWAY:
        return "a whirl that grows without limit in this model"
    force = "" if impact.border.passed else f", {amount(impact.force_max, 'N')}"
    return f"{impact.motion}{rate}{force}"


def _smallest(impact):
    """The smallest impact that was found."""
    one = impact.smallest
    if one is None:
        return ""
    other = "" if one.motion is None or impact.starts == impact.motion else f" (which starts {impact.starts})"
    at = f" at {one.contact}" if one.contact else ""
    size = f"{amount(one.impulse, 'N s')}{at}{hardness_text(one.rotor_velocity, one.velocity)}"
    size += f", {one.over_touching:.2g} times what just touches from the centre"
    return f"; the smallest found has {size}{other}; it is an upper bound"


def hardness_text(rotor_velocity, velocity):
    """How hard an impulse is, from m/s of the whole rotor, or where its mass is not known from m/s at the contact."""
    if isnan(rotor_velocity):
        return f" ({amount(velocity, 'm/s')} of the shaft at the contact)"
    return f" (the momentum of the whole rotor at {amount(rotor_velocity, 'm/s')})"


def _machine(impact):
    """Whether the drive holds the motion, and whether any machine would."""
    if impact.motion == Kind.RUNNING_AWAY:
        return [_assumed(impact)]
    told = [f"{beyond_text(impact.border, 'Beyond the model: ')}{_first(impact)}"] if impact.border.passed else []
    held = outcomes_text(impact.held)
    text = "; ".join([*told, held] if held else told)
    return [f"{text[0].upper()}{text[1:]}."] if text else []


def _first(impact):
    """The first touch after the smallest impact, of which the model still tells."""
    one = impact.smallest
    if one is None or not one.first_force > 0.0:
        return ""
    size = f"{amount(one.first_force, 'N')} and a penetration of {one.first_penetration:.2g} gaps"
    return f"; the first touch after the smallest impact has {size}"


def _assumed(impact):
    """What bounds a motion that runs away: a contact diameter."""
    if not impact.assumed:
        text = "It still grew at 20 gaps, where it was left"
        return f"{text}; a contact without a diameter needs one: surfaces that roll bound a whirl."
    known = [one for one in impact.assumed if one.roll]
    text = "The surfaces would come to roll on each other, for which the model needs the diameter of the shaft there "
    text += "(the paper's condition (12)): give contact.diameter"
    if not known:
        return f"{text}."
    rolls = "; with ".join(
        f"{length(one.diameter)} it rolls at {frequency_text(one.roll.frequency)}"
        + (beyond_text(one.border, ", ") if one.border.passed else f", {amount(one.roll.normal_force, 'N')}")
        for one in known
    )
    return f"{text}. With an assumed one of {rolls}."


# limits of `rsc.system.border` -> what a motion beyond them would do
BEYOND = {
    "penetration": lambda border: f"penetration of {border.penetration:.3g} gaps ({length(border.depth)})",
    "orbit": lambda border: f"orbit of {border.orbit:.3g} times the shaft's radius",
    "surface": lambda border: f"surface at {amount(border.surface, 'm/s')}",
    "heating": lambda border: f"friction heat of {amount(border.heating, 'W')} per kg of the rotor",
    "yielding": lambda border: f"normal force of {border.yielding:.3g} times the yield force of the contact",
}


def beyond_text(border, begin="beyond the model: "):
    """Which limits a motion passes, and by how much; "" for none."""
    told = ", ".join(BEYOND[name](border) for name in border.passed)
    return f"{begin}{told}" if told else ""


def size_text(motion):
    """The largest force of a motion that lasts with its penetration; where the model does not hold any more that alone."""
    return beyond_text(motion.border) or f"{amount(motion.force_max, 'N')}, penetration {motion.border.penetration:.2g} gaps"


def coverage_text(coverage):
    """What the random impacts of some lists can claim, in words."""
    return "; ".join(_covered(one) for one in coverage)


def _count(some, count):
    """How many of some impacts, in words."""
    return f"all {count}" if some == count > 0 else f"{some or 'none'} of {count}"


def _touched(one):
    """How many impacts touched, and how many of these runs had not settled, in words."""
    unsettled = f", {one.unsettled} of them had not settled" if one.unsettled else ""
    return f"{_count(one.touched, one.impacts)} impacts touched{unsettled}"


def _coverage_at(verdict, speed):
    """The coverage of the list at a speed."""
    return next(one for one in verdict.coverage if one.speed == speed)


def _covered(one):
    at = f"at {frequency_text(one.speed)}"
    if one.impacts == 0:
        return f"{at} no impacts were tried"
    text = f"{at} {_touched(one)}"
    if one.excluded == 1.0:
        return f"{text}, which excludes nothing"
    share = math.ceil(1e3 * one.excluded) / 10.0
    return (
        f"{text}: with 95 % confidence any one motion that is not listed is started by fewer than {share:.3g} % of the impacts "
        "that touch"
    )
