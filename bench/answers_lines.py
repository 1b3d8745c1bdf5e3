"""Every line of the answer of a run, read as text and judged by the second engine."""

import math
import re
from collections import Counter

import numpy as np

from answers_labels import BACKWARD
from answers_possible import of_coverage, of_mu_min, of_not_reached, of_possible, of_verdict
from answers_spectra import grows, line_near, lines
from answers_witness import KINDS, NUM, PREFIX, SAID, Finding, Witness
from rsc.show.words.answer import answer

ANY_SIZE = 9.0  # of numbers at the end of a run that diverges by a tenth in a tenth of a turn
RESOLVED = 3.0  # turns in a window from which it has lines


def findings(report):
    """(Counter of the lines judged by topic, list of Finding) of the answer of a report."""
    told = answer(report)
    found = [Finding(topic, f"{text!r} holds nan or inf") for topic, text in told if re.search(r"\b(nan|inf)\b", text)]
    witness = Witness(report)
    for topic, text in told:
        judge = JUDGES.get(topic)
        problems = [f"the judge knows no such line: {text!r}"] if judge is None else judge(text, witness)
        found += [Finding(topic, text if one == "skipped" else f"{text!r}: {one}", one == "skipped") for one in problems if one]
    return Counter(topic for topic, _ in told), [*found, *contradictions(dict(told), report)]


def contradictions(told, report):
    """Lines that say different things."""
    whirl, end = told.get("whirl", ""), told.get("at the end", "")
    if "no contact" in whirl.split("; ") and "force" in told:
        yield Finding("contradiction", "no contact, and a force")
    backward = any(kind in whirl for kind in BACKWARD)
    if "no backward whirl" in whirl and backward:
        yield Finding("contradiction", f"whirl and no whirl: {whirl!r}")
    if any(end.startswith(kind) for kind in BACKWARD) and not backward:
        yield Finding("contradiction", f"{whirl!r} and at the end {end!r}")
    if backward != bool(re.search(r"(^|; )-", told.get("frequency", ""))):
        yield Finding("contradiction", f"{whirl!r} and frequency {told.get('frequency')!r}")
    if report.result.status == "finished" and "stopped early" in told.get("check", ""):
        yield Finding("contradiction", "finished, and stopped early")


def of_whirl(text, witness):
    """The kinds of all windows, and the speeds or times that the text gives for them."""
    report, parts = witness.report, text.split("; ")
    own = [str(kind) for kind in report.features.kind]
    for kind in KINDS[1:-1]:
        pieces = [part for part in parts if re.match(rf"{kind} at ", part)]
        if bool(pieces) != (kind in own):
            yield f"windows that are {kind} are {'not ' if not pieces else ''}told"
        for piece in pieces:
            yield from _places(piece, [i for i in range(len(own)) if own[i] == kind], report)
    if ("no contact" in parts) and witness.number(0.0, lambda signals: signals.largest(signals.force), 0.0, 1e-12) not in (
        "",
        "skipped",
    ):
        yield "there is contact"
    if any(part.startswith("no backward whirl") for part in parts) and set(own) & BACKWARD:
        yield "there are windows in backward whirl"
    wrong = {}
    for i, kind in enumerate(own):
        if kind in witness.window_kinds(i, witness.signals[0]):
            continue
        every = [witness.window_kinds(i, signals) for signals in witness.every()]
        agree = all(kind not in one for one in every) and set.intersection(*every)
        beside = (k for k in (i - 1, i + 1) if 0 <= k < len(own) and witness.parted(i))
        agree = agree and not any(kind in witness.window_kinds(k, signals) for k in beside for signals in witness.every())
        right = " or ".join(sorted(every[0]))
        wrong.setdefault((kind, right) if agree else "skipped", []).append(i)
    for key, windows in wrong.items():
        if key == "skipped":
            yield key
            continue
        i = windows[0]
        begin, end = witness.span(i)
        signals = witness.signals[0]
        yield (
            f"{len(windows)} of {len(own)} windows, the first at {begin:.4g} to {end:.4g} s, called {key[0]}, are {key[1]} "
            f"(contact {signals.share(begin, end):.4f}, d turns {signals.turning(begin, end):.4g} Hz, "
            f"shaft {witness.speed(0.5 * (begin + end)):.4g} Hz)"
        )


def _places(piece, windows, report):
    """The ranges of speed or time in a text against those of the windows of its kind."""
    fall = report.fall
    if np.ptp(fall.speed) == 0.0:
        spans = re.findall(rf"{NUM} to {NUM} s", piece)
        values = [(fall.time[i] - 0.5 * fall.window, fall.time[i] + 0.5 * fall.window) for i in windows]
        size = max(fall.time[-1], 1e-12)
    else:
        spans = re.findall(rf"{NUM}(?: to {NUM})? Hz", piece)
        speeds = [report.result.speed[0], *fall.speed[1:-1], report.result.speed[-1]]
        values, size = [(speeds[i], speeds[i]) for i in windows], np.abs(fall.speed).max()
    for low, high in spans:
        for said in (float(low), float(high or low)):
            if values and min(abs(said - value) for pair in values for value in pair) > 0.01 * size:
                yield f"{said:g} is the end of no stretch of such windows"
    for hz, turns in re.findall(rf"{NUM} Hz \({NUM} rpm\)", piece):
        if abs(float(turns) / 60.0 - float(hz)) > 0.002 * abs(float(hz)):
            yield f"{hz} Hz are not {turns} rpm"


def of_frequency(text, witness):
    """Ranges of the rates at which d turns in windows that whirl."""
    for part in text.split("; "):
        match = re.match(rf"(forward whirl )?{NUM}(?: to {NUM})? Hz \({NUM}(?: to {NUM})? rpm", part)
        if match is None:
            if "negative" not in part:
                yield f"unreadable: {part!r}"
            continue
        forward, low, high, turns, _ = match.groups()
        low, high = float(low), float(high or low)
        wanted = {"forward whirl"} if forward else BACKWARD
        windows = [i for i, kind in enumerate(witness.report.features.kind) if str(kind) in wanted]
        slack = 1.2 / min(np.ptp(witness.edges[list(witness.places(i))]) for i in windows)

        def rates(signals, windows=windows):
            return [witness.rate(i, signals) for i in windows]

        yield witness.number(low, lambda signals: np.min(rates(signals)), 0.02, slack)
        yield witness.number(high, lambda signals: np.max(rates(signals)), 0.02, slack)
        if abs(float(turns) / 60.0 - low) > 0.002 * abs(low):
            yield f"{low} Hz are not {turns} rpm"


def of_vibration(text, witness):
    """Peak to peak in the windows, static sag, mean position, orbit, and the whirl's own line."""
    gap, loose = witness.machine.gap, ANY_SIZE if witness.report.result.status == "diverged" else 0.02
    first, *parts = text.split("; ")
    match = re.match(rf"up to {SAID} pk-pk (?:at {NUM} Hz \()?from {NUM} to {NUM} s\)?$", first)
    if match is None:
        yield "unreadable"
        return
    size = float(match[1]) * PREFIX[match[2]]
    yield witness.number(size, lambda signals: _most_in_windows(signals, witness), loose, 2e-3 * gap)
    for part in parts:
        sag, mean, orbit, stator = (
            re.match(pattern, part) for pattern in (
                rf"static sag {SAID}$", rf"mean position up to {SAID} from the bearing centre, (?:at|from) ",
                rf"orbit up to {NUM} gaps \({SAID}\) from the bearing centre(?:, the whirl's line up to {NUM} gaps)?$",
                rf"the stator up to {SAID} from its resting position$",
            )
        )  # fmt: skip
        if sag:
            problem = abs(float(sag[1]) * PREFIX[sag[2]] / _sag(witness) - 1.0) > 0.01
            yield f"the load deflects the rotor by {_sag(witness):.4g} m" if problem else ""
        elif mean:
            size = float(mean[1]) * PREFIX[mean[2]]
            yield witness.number(size, lambda signals: _furthest_mean(signals, witness), loose, 0.02 * gap)
        elif orbit:
            yield witness.number(float(orbit[1]) * gap, lambda signals: signals.largest(signals.rotor), loose, 0.006 * gap)
            yield _own_line(float(orbit[5]) * gap, witness) if orbit[5] else ""
        elif stator:
            size = float(stator[1]) * PREFIX[stator[2]]
            yield witness.number(size, lambda signals: signals.largest(signals.stator), loose, 0.006 * gap)
        else:
            yield f"unreadable: {part!r}"


def _most_in_windows(signals, witness):
    """The larger extent of the rotor in y and z in the window where it is largest, m; the last goes on to the end of the run."""
    spans = [witness.span(i) for i in range(len(witness.report.fall.time))]
    spans[-1] = spans[-1][0], np.inf
    pieces = [signals.rotor[signals.part(*span)] for span in spans]
    return max(max(np.ptp(piece.real), np.ptp(piece.imag)) for piece in pieces if len(piece))


def _furthest_mean(signals, witness):
    """Largest distance of the rotor's mean position in a window from the bearing centre, m."""
    pieces = [signals.rotor[signals.part(*witness.span(i))] for i in range(len(witness.report.fall.time))]
    return max(abs(piece.mean()) for piece in pieces if len(piece))


def _sag(witness):
    """Distance by which the load deflects the rotor at the contact, m."""
    machine = witness.machine
    k, e = machine.stiffness, machine.stiffness_conj  # on u and on its conjugate
    real = np.block([[k.real + e.real, e.imag - k.imag], [k.imag + e.imag, k.real - e.real]])
    y, z = np.split(np.linalg.lstsq(real, np.concatenate([machine.load.real, machine.load.imag]), rcond=None)[0], 2)
    own = slice(machine.n_rotor)
    return float(abs(machine.row[own] @ (y + 1j * z)[own]))


def of_approach(text, witness):
    """What is left of the clearance, or the penetration."""
    gap, loose = witness.machine.gap, ANY_SIZE if witness.report.result.status == "diverged" else 0.02
    free = re.match(rf"{SAID} \({NUM} %\) of the clearance of {SAID} left, at (.*)$", text)
    match = free or re.match(rf"touches; penetration up to {SAID}, {NUM} % of the clearance, at (.*)$", text)
    if match is None:
        yield "unreadable"
        return
    size, prefix, share, moment = match[1], match[2], match[4], match[match.re.groups]
    told = float(size) * PREFIX[prefix]
    if abs(told - 0.01 * float(share) * gap) > 0.006 * told + 6e-3 * gap:
        yield f"{size} {prefix}m are not {share} % of the clearance"
    said = gap - told if free else gap + told
    yield witness.number(said, lambda signals: signals.largest(signals.d), loose, 0.01 * gap)
    yield from _at_moment(moment, witness, lambda signals: np.abs(signals.d), loose)


def _own_line(said, witness):
    """The rotor's line at the rate of the strongest backward line of the deflection, in the windows that whirl: what the contact
    turns with, and not a free vibration beside it. One that grows, decays or moves in a window has no one amplitude: any between
    the height of its peak and what a line at rest with its power has."""
    windows = [i for i, kind in enumerate(witness.report.features.kind) if str(kind) in BACKWARD]

    def allowed(signals):
        sizes = [(0.0, 0.0)]
        for i in windows:
            begin, end = witness.span(i)
            own, rate = signals.part(begin, end), 1.0 / (signals.time[1] - signals.time[0])
            rotor, d = signals.rotor[own], signals.d[own]
            if len(d) < 50 or grows(rotor) or abs(signals.turning(begin, end)) * (end - begin) < RESOLVED:
                return math.nan, math.nan
            frequency, _ = lines(d - d.mean(), rate)
            whirl = frequency[frequency < 0.0]  # strongest first
            if whirl.size:
                sizes.append(line_near(rotor - rotor.mean(), rate, whirl[0], 0.0)[1:])
        return np.nanmax(sizes, axis=0)

    if any(math.isnan(size) for size in allowed(witness.signals[0])):
        return "skipped"
    problem = witness.number(said, lambda signals: float(np.clip(said, *allowed(signals))), 0.06, 0.01 * witness.machine.gap)
    return problem if problem in ("", "skipped") else f"the whirl's own line: {problem}"


def _at_moment(text, witness, values, loose):
    """Whether something is about its largest near the time and the speed of a text."""
    match = re.match(rf"(?:{NUM} Hz \()?{NUM} s\)?$", text)
    if match is None:
        yield f"unreadable moment {text!r}"
        return
    speed, time = match[1], float(match[2])
    stretch = float(np.diff(witness.edges).max()) + 0.006 * time

    def share(signals):
        own = values(signals)
        return signals.largest(own, time - stretch, time + stretch) / max(own.max(), 1e-300)

    yield witness.number(1.0, share, 2.0 * loose)
    if speed and abs(float(speed) - witness.speed(time)) > 0.01 * abs(float(speed)) + abs(
        witness.speed(time * 1.006) - witness.speed(time)
    ):
        yield f"at {time:g} s the speed is {witness.speed(time):.5g} Hz"


def of_force(text, witness):
    """The largest force, where, and the largest mean power of friction in a stretch."""
    loose = ANY_SIZE if witness.report.result.status == "diverged" else 0.04
    powers = "power input by friction|power lost to friction|friction heat"
    match = re.match(rf"up to {SAID} normal at (.*?)(?:; ({powers}) up to {SAID}, (?:at|from) (.*))?$", text)
    if match is None:
        yield "unreadable"
        return
    size, prefix, _, moment, words, power, p, _, _ = match.groups()
    yield witness.number(float(size) * PREFIX[prefix], lambda signals: signals.largest(signals.force), loose)
    yield from _at_moment(moment, witness, lambda signals: signals.force, loose)
    if words is None:
        return
    sign = -1.0 if "lost" in words else 1.0

    def largest(signals):
        values = signals.heat if "heat" in words else signals.fed
        return witness.largest_mean(values, signals)

    problem = witness.number(sign * float(power) * PREFIX[p], largest, max(loose, 0.1))
    yield f"{words}: {problem}" if problem not in ("", "skipped") else problem


def of_drive(text, witness):
    """Torque, power and energy that the contact takes from the drive."""
    loose = ANY_SIZE if witness.report.result.status == "diverged" else 0.05
    times = rf"(?:, {NUM} times the rotor's kinetic energy)?"
    way, other = "(rub torque on the shaft|the rub drives the shaft with)", "( taken from the shaft| given to the shaft)?"
    most = rf"{way} up to {SAID}, power up to {SAID}, (?:at|from) (.*?)"
    match = re.match(rf"{most}; {SAID}{other} over the run{times}$", text)
    if match is None:
        yield "unreadable"
        return
    way, torque, p, _, power, q, _, _, energy, e, _, other, times = match.groups()
    sign = 1.0 if way.startswith("rub torque") else -1.0
    power, energy = sign * float(power), (-sign if other else sign) * float(energy)

    def total(signals):
        return signals.integral(signals.given)

    def largest(signals):
        return witness.largest_mean(signals.given, signals)

    problem = witness.number(power * PREFIX[q], largest, 2.0 * loose)
    yield problem and problem if problem == "skipped" else f"power, {problem}" if problem else ""
    problem = witness.number(energy * PREFIX[e], total, loose, 1e-3 * abs(largest(witness.signals[0])) * witness.end)
    yield problem if problem in ("", "skipped") else f"energy, {problem}"
    omega = abs(power * PREFIX[q] / (float(torque) * PREFIX[p]))
    low, high = np.sort(np.abs(witness.drive.speed))[[0, -1]]
    if not 0.98 * low <= omega <= 1.02 * high:
        yield f"power over torque is {omega:.4g} rad/s, the rotor turns at {low:.4g} to {high:.4g}"
    inertia = getattr(witness.scene.rotor, "polar_inertia", None)
    if times and abs(float(times) * 0.5 * inertia * high**2 / (energy * PREFIX[e]) - 1.0) > 0.2:
        yield f"times the kinetic energy: {energy * PREFIX[e] / (0.5 * inertia * high**2):.3g}"


def of_change(text, witness):
    """A change of whirl: something backward ends, begins or turns at another rate there."""
    if re.match(r"and \d+ more", text):
        return
    match = re.match(rf"(whirl \w+|no whirl) to (whirl \w+|no whirl) at {NUM} Hz(?: \(.*\))?$", text)
    if match is None:
        yield "unreadable"
        return
    before, after, speed = match[1], match[2], float(match[3])
    fall = witness.report.fall
    near = [i for i in range(len(fall.speed)) if abs(fall.speed[i] - speed) <= 2.5 * _step(fall.speed) + 0.06]
    if not near:
        yield "the run has no such speed"
        return
    first, last = max(near[0] - 2, 0), min(near[-1] + 2, len(fall.speed) - 1)

    def change(signals):
        ones = [witness.window_kinds(i, signals) for i in range(first, last + 1)]
        backward, others = (any(one & BACKWARD for one in ones), any(one - BACKWARD for one in ones))
        rates = [witness.rate(i, signals) for i in range(first, last + 1)]
        moves = max(rates) - min(rates) > 0.02 * max(abs(rate) for rate in rates)
        return float(backward and (others or moves))

    yield witness.number(1.0, change, 0.0)
    if before == after:
        yield "changes to itself"


def _step(speeds):
    return float(np.abs(np.diff(speeds)).max(initial=0.0))


def of_end(text, witness):
    """The kind of the last window, its speed, and the rate of the whirl that it is said to follow."""
    match = re.match(rf"({'|'.join(KINDS)}) at {NUM} Hz(?:, whirl (\w+), predicted to be (.*))?$", text)
    if match is None:
        yield "unreadable"
        return
    kind, speed, label = match[1], float(match[2]), match[3]
    report = witness.report
    last = len(report.fall.time) - 1
    if kind not in witness.window_kinds(last, witness.signals[0]):
        every = [witness.window_kinds(last, signals) for signals in witness.every()]
        agree = all(kind not in one for one in every) and set.intersection(*every)
        yield f"second engine: {' or '.join(sorted(every[0]))}" if agree else "skipped"
    if abs(speed - report.result.speed[-1]) > 1e-3 * abs(speed):
        yield f"the run ends at {report.result.speed[-1]:.5g} Hz"
    if label:
        branch = next((b for b in report.branches if b.label == label), None)
        whirl = None if branch is None else branch.at(report.fall.speed[last])
        if whirl is None:
            yield f"no whirl {label} is predicted there"
        else:
            tolerance = 0.2 if kind.startswith("bouncing") else 0.05
            problem = witness.number(
                whirl.frequency, lambda signals: witness.rate(last, signals), tolerance, 1.0 / report.fall.window
            )
            yield problem and (problem if problem == "skipped" else f"whirl {label} at {whirl.frequency:.5g} Hz: {problem}")


def of_check(text, witness):
    """The counts of the check line against the rows, and how the run ended against the second engine."""
    report = witness.report
    whirl = [row for row in report.rows if row.quantity == "whirl frequency"]
    counted = re.search(r"(\d+) of (\d+) windows? with a backward line", text)
    own = [row for row in whirl if row.verdict not in ("no whirl", "not resolved")]
    unresolved = re.search(r"(\d+) of \d+ windows? cannot be compared", text)
    if int(unresolved[1] if unresolved else 0) != sum(row.verdict == "not resolved" for row in whirl):
        yield "the count of windows that are not resolved is not that of the rows"
    if counted and (int(counted[1]), int(counted[2])) != (sum(row.verdict == "agrees" for row in own), len(own)):
        yield "the counts are not those of the rows"
    if not counted and own:
        yield f"{len(own)} windows with a backward line are not told"
    diverged = report.result.status == "diverged"
    if ("diverged" in text) != diverged:
        yield f"the run {report.result.status}"
    if diverged != witness.signals[0].diverged:
        every = {signals.diverged for signals in witness.every()}
        yield "skipped" if len(every) > 1 or diverged else "the second engine does not finish"


JUDGES = {
    "whirl": of_whirl, "frequency": of_frequency, "vibration": of_vibration, "closest approach": of_approach,
    "force": of_force, "drive": of_drive, "change": of_change, "at the end": of_end, "after an impact": of_possible,
    "not reached": of_not_reached, "coverage": of_coverage, "verdict": of_verdict, "mu_min": of_mu_min, "check": of_check,
}  # fmt: skip
