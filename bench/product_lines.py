"""Lines of an answer over the product of terms, read as text and judged by the third engine: those of one contact as
answers_lines.py judges them, those of several at every contact."""

import re

import numpy as np
import scipy

from answers_labels import BACKWARD
from answers_lines import ANY_SIZE, JUDGES, contradictions
from answers_witness import NUM, PREFIX, SAID
from rsc.measure.several import name_of
from rsc.show.words.answer import answer
from rsc.show.words.verdict import MEANINGS, NOT_STARTED, NOT_TOUCHED, ON_RACE, PASSING

WHIRLS = BACKWARD | {"forward whirl", "running away"}
LOOSE = 0.05


def size_of(number, prefix):
    """A number with its prefix."""
    return float(number) * PREFIX[prefix]


def judged(report, witness):
    """(topic, text, [what is false, "" or "skipped"]) of every line of an answer but those on lists."""
    told, one = answer(report), len(witness.contacts) == 1
    names = [contact.name for contact in report.result.scene.contacts]
    for topic, text in told:
        if re.search(r"\b(nan|inf)\b", text):
            yield topic, text, ["nan or inf"]
        elif topic == "drive":
            yield topic, text, list(of_drive(text, witness))
        elif topic == "verdict":
            yield topic, text, list(of_verdict(text, witness))
        elif topic in LISTS:
            continue
        elif topic in names and not one:
            yield "at a contact", text, list(of_contact(text, witness.contacts[names.index(topic)], topic))
        elif not one and topic in SEVERAL:
            yield topic, text, list(SEVERAL[topic](text, witness))
        elif topic in JUDGES:
            yield topic, text, list(JUDGES[topic](text, witness.contacts[0]))
        else:
            yield topic, text, ["the judge knows no such line"]
    if one:
        for finding in contradictions(dict(told), report):
            yield finding.topic, finding.detail, [finding.detail]


LISTS = ("after an impact", "not reached")


def of_whirl(text, witness):
    """Kinds of all windows at every contact, and that the text names each of them."""
    report = witness.report
    contacts = report.result.scene.contacts
    for j, contact in enumerate(contacts):
        own = [str(kind) for kind in report.contacts[contact.name].kind]
        yield from (f"{contact.name}: {problem}" if problem != "skipped" else problem for problem in _windows(own, witness, j))
    for i, name in enumerate(report.features.names):
        kinds = {contact.name: str(report.contacts[contact.name].kind[i]) for contact in contacts}
        if name_of(kinds) != name:
            yield f"window {i} is {kinds}, called {name!r}"
    backward = any(str(kind) in BACKWARD for kind in report.features.kind)
    if any(part.startswith("no backward whirl") for part in text.split("; ")) == backward:
        yield "backward whirl and none"
    touched = any(signals.touch.any() for signals in witness.runs.of(0))
    if ("no contact" in text.split("; ")) == touched and touched:
        yield "there is contact"


def _windows(own, witness, j):
    """Problems of the kinds (n_w,) that windows have at contact j."""
    contact = witness.contacts[j]
    for i, kind in enumerate(own):
        if kind in contact.window_kinds(i, contact.signals[0]):
            continue
        every = [contact.window_kinds(i, each[j]) for each in witness.every]
        beside = [k for k in (i - 1, i + 1) if 0 <= k < len(own) and contact.parted(i)]
        near = any(kind in contact.window_kinds(k, each[j]) for k in beside for each in witness.every)
        if any(kind in one for one in every) or near or not set.intersection(*every):
            yield "skipped"
            continue
        yield f"window {i}, called {kind}, is {' or '.join(sorted(every[0]))}"


def of_frequency(text, witness):
    """Ranges of the rates at which d turns in windows with a whirl, at the contact named for each window."""
    report = witness.report
    contacts = report.result.scene.contacts
    for part in text.split("; "):
        match = re.match(rf"(forward whirl )?{NUM}(?: to {NUM})? Hz \(", part)
        if match is None:
            yield "" if "negative" in part else f"unreadable: {part!r}"
            continue
        forward, low, high = match.groups()
        wanted = {"forward whirl"} if forward else BACKWARD
        windows = [i for i, kind in enumerate(report.features.kind) if str(kind) in wanted]
        first = witness.contacts[0]
        slack = 1.2 / min(np.ptp(first.edges[list(first.places(i))]) for i in windows)
        rates = [first.rate(i, signals) for signals, contact in zip(witness.runs.of(0), contacts, strict=True) for i in windows
                 if str(report.contacts[contact.name].kind[i]) in wanted]  # fmt: skip
        for said in (float(low), float(high or low)):
            off = slack + 0.02 * abs(said)
            if not min(rates, default=0.0) - off <= said <= max(rates, default=0.0) + off:
                yield "skipped" if first.parted(windows[-1]) else f"the contacts turn at {min(rates):.5g} to {max(rates):.5g} Hz"


def of_contact(text, contact, name):
    """Vibration, closest approach, force and share of contact at one of several contacts."""
    loose = ANY_SIZE if contact.report.result.status == "diverged" else LOOSE
    gap = contact.machine.gap
    head, _, rest = text.partition("; ")
    moved = re.match(rf"vibration up to {SAID} pk-pk (?:at [^(]+ \()?from {NUM} to {NUM} s\)?$", head)
    free = re.match(rf"never touched, {SAID} \({NUM} %\) of the clearance of {SAID} left$", rest)
    pattern = (
        rf"penetration up to {SAID}, {NUM} % of the clearance; up to {SAID} normal at "
        rf"(?:{NUM} Hz \()?{NUM} s\)?; in contact for {NUM} % of the run$"
    )
    match = free or re.match(pattern, rest)
    if moved is None or match is None:
        yield "unreadable"
        return
    span = float(moved[4]), float(moved[5])
    yield contact.number(size_of(moved[1], moved[2]), lambda signals: extent(signals, span), loose, 2e-3 * gap)
    size = size_of(match[1], match[2])
    largest = gap - size if free else gap + size
    yield contact.number(largest, lambda signals: signals.largest(signals.d), 0.02, 0.006 * gap)
    if abs(size / gap - 0.01 * float(match[4])) > 0.06 * size / gap + 1e-3:  # two digits
        yield f"{size:.4g} m are not {match[4]} % of the clearance"
    if free:
        return
    yield contact.number(size_of(match[5], match[6]), lambda signals: signals.largest(signals.force), loose)
    time = float(match[9])
    width = float(np.diff(contact.edges).max()) + 0.006 * time

    def share(signals):
        return signals.largest(signals.force, time - width, time + width) / max(signals.force.max(), 1e-300)

    yield contact.number(1.0, share, 2.0 * loose)
    yield contact.number(0.01 * float(match[10]), lambda signals: signals.share(0.0, contact.end), 0.02, 2e-3)


def extent(signals, span):
    """The larger extent of the rotor in y and z between two times in s, m."""
    piece = signals.rotor[signals.part(*span)]
    return max(np.ptp(piece.real), np.ptp(piece.imag))


def of_end(text, witness):
    """The kind of the last window at every contact, and the speed at which the run ends."""
    report = witness.report
    match = re.match(rf"(.*), at a rotor speed of {NUM} Hz(?:, whirl .*)?$", text)
    if match is None or match[1] != report.features.names[-1]:
        yield "unreadable, or not the last window"
        return
    end = witness.contacts[0].speed(report.result.time[-1])
    if abs(float(match[2]) - end) > 1e-3 * float(match[2]):
        yield f"the run ends at {end:.5g} Hz"


def of_mu_min(text, witness):
    """Of several contacts it is not known."""
    yield "" if "is not known: that is computed for one contact only yet" in text else "unreadable"


SEVERAL = {"mu_min": of_mu_min, "whirl": of_whirl, "frequency": of_frequency, "at the end": of_end}


def of_drive(text, witness):
    """Torque, power and energy that friction takes from the drive at all contacts, heat and work on inner races."""
    way, other = "(rub torque on the shaft|the rub drives the shaft with)", "( taken from the shaft| given to the shaft)?"
    races = rf"(?: \(heat {SAID}, inner races (-?){SAID}\))?"
    pattern = (
        rf"{way} up to {SAID}, power up to {SAID}, (?:at|from) .*?; {SAID}{other} over the run{races}"
        rf"(?:, {NUM} times the rotor's kinetic energy)?$"
    )
    match = re.match(pattern, text)
    if match is None:
        yield "unreadable"
        return
    way, torque, p, _, power, q, _, energy, e, _, other = match.groups()[:11]
    heat, h, _, negative, raced, r = match.groups()[11:17]
    sign = 1.0 if way.startswith("rub torque") else -1.0
    wanted = {"power": sign * size_of(power, q), "energy": (-sign if other else sign) * size_of(energy, e)}
    if heat:
        wanted |= {"heat": size_of(heat, h), "races": size_of(raced, r) * (-1.0 if negative else 1.0)}
    first, seen = witness.contacts[0], []
    for each in witness.every:
        seen.append({
            "power": first.largest_mean(sum(own.given for own in each), each[0]),
            "energy": sum(own.integral(own.given) for own in each),
            "heat": sum(own.integral(own.heat) for own in each), "races": sum(own.integral(own.raced) for own in each),
            "torque": 0.0,
        })  # fmt: skip
    scale = max(abs(seen[0]["energy"]), seen[0]["heat"])
    for name, said in wanted.items():
        values = np.array([own[name] for own in seen])
        slack = LOOSE * abs(values).max() + (5e-3 * scale if name != "power" else 0.0)
        if abs(said - values[0]) <= slack:
            continue
        yield "skipped" if np.ptp(values) > slack else f"{name}: {values[0]:.4g}"
    omega, speeds = abs(size_of(power, q) / size_of(torque, p)), np.abs(first.drive.speed)
    if len(witness.contacts) == 1 and not 0.97 * speeds.min() <= omega <= 1.03 * speeds.max():
        yield f"power over torque is {omega:.4g} rad/s, the rotor turns at {speeds.min():.4g} to {speeds.max():.4g}"


def of_verdict(text, witness):
    """The severity by the definitions of docs/users/motions.md, the run's force and kind, and the counts of impacts."""
    report = witness.report
    match = re.search(r"Severity: ([\w ]+) \((.*)\)\.$", text)
    others = {"whirl": ON_RACE, "rub": PASSING, "unknown": NOT_TOUCHED}
    meaning, _, waiting = match[2].partition(f"; {NOT_STARTED}") if match else ("", "", "")
    waits = bool(match) and NOT_STARTED in match[2]
    if match is None or meaning not in (MEANINGS[match[1]], others.get(match[1])) or waiting or (waits and match[1] != "rub"):
        yield "no severity, or another meaning"
        return
    if waits and not any(_waiting(listed) for listed in report.motions):
        yield "no whirl is listed or predicted that waits"
    each = witness.runs.of(0)
    touched = any(signals.touch.any() for signals in each)
    if touched == text.startswith("No contact in this run"):
        yield "skipped" if len({any(own.touch.any() for own in one) for one in witness.every}) > 1 else f"touched: {touched}"
    if force := re.search(rf"The run shows (.*?) at .*?, up to {SAID}[.;]", text):
        contact = max(witness.contacts, key=lambda own: own.signals[0].largest(own.signals[0].force))
        yield contact.number(size_of(force[2], force[3]), lambda signals: signals.largest(signals.force), LOOSE)
    levels = ["safe", "unknown", "at risk", "rub", "whirl", "destructive"]
    kinds = {str(kind) for kind in report.features.kind}
    least = "whirl" if kinds & WHIRLS else "rub" if touched and kinds - {"not resolved"} != {"no contact"} else "safe"
    for listed in report.motions:
        for motion in listed.motions:
            if listed.hits(motion) and motion.motion != "no contact":
                passed = motion.border.passed and motion.motion != "running away"  # its numbers mean nothing
                own = "destructive" if passed else "whirl" if motion.motion in WHIRLS else "rub"
                least = max(least, own, key=levels.index)
            elif motion.motion != "no contact":
                least = max(least, "at risk", key=levels.index)
    destroyed = report.border.passed and touched
    if levels.index(match[1]) < levels.index("destructive" if destroyed else least):
        yield f"at least {'destructive' if destroyed else least}"
    if match[1] in ("whirl", "destructive") and least == "safe" and not destroyed:
        yield "nothing in run or lists is that severe"
    if least == "safe" and not destroyed and kinds == {"no contact"} and match[1] != (wanted := _of_nothing(report)):
        yield f"run and lists show nothing: that is {wanted}"
    yield from _impacts(text, report)


def _of_nothing(report):
    """The severity of a run without contact beside lists without another motion: by predictions and by the coverage, which is
    counted anew."""
    for listed in report.motions:
        if listed.leaving or any(one.stable and one.label != "forward rub" for one in listed.not_reached):
            return "at risk"
    for listed in report.motions:
        touched, unsettled = int(listed.touched.sum()), int((listed.touched & (listed.ended < 0)).sum())
        if scipy.stats.binom.cdf(unsettled, touched, 0.5) > 0.05:  # half of all may be missed
            return "unknown"
    return "safe"


def _waiting(listed):
    """Whether a list has a whirl that no impact starts, or predicts one that lasts or is left slowly."""
    own = [motion for motion in listed.motions if motion.motion in WHIRLS and not listed.hits(motion)]
    return own or listed.leaving or any(one.stable for one in listed.not_reached if one.label != "forward rub")


def _impacts(text, report):
    """Counts and numbers of the sentence on impacts against the lists, which are judged by themselves."""
    match = re.search(rf"At {NUM} Hz an impact starts (.*?): (\d+) of (\d+) impacts did(.*?)\. ", text)
    if match is None:
        return
    speed, what, hits, impacts = float(match[1]), match[2], int(match[3]), int(match[4])
    listed = min(report.motions, key=lambda one: abs(one.speed - speed))
    unbounded = "grows without limit" in what
    known = [(listed.hits(motion), listed.starts) for motion in listed.motions
             if (motion.motion in what if motion.bounded else unbounded)]  # fmt: skip
    if (hits, impacts) not in known:
        yield f"{what}: {known}"
    found = re.search(rf"the smallest found has {SAID}", match[5])
    if found and abs(size_of(found[1], found[2]) / listed.smallest.impulse - 1.0) > 0.01:
        yield f"the list has {listed.smallest.impulse:.4g} N s"
