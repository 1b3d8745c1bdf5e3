"""Lines of an answer on what else can last, judged by runs of the second engine at that speed."""

import math
import re

import numpy as np

from answers_labels import BACKWARD
from answers_motions import Claim, claim_of, reached, starts_of, told
from answers_witness import KINDS, NUM
from rsc.show.words.answer import answer


def of_possible(text, witness):
    """Motions that are said to last: the second engine must reach them."""
    match = re.match(rf"at {NUM} Hz: (.*)$", text)
    listed = match and next(
        (one for one in witness.report.motions if abs(one.speed - float(match[1])) < 1e-3 * abs(one.speed)), None
    )
    if not listed:
        yield "unreadable, or no such list"
        return
    at = witness.at(listed.speed)
    for said in re.split(r" or (?=\w[\w ,]* \()", match[2]):
        motion = _listed(said, listed)
        if motion is None:
            yield f"unreadable, or in no list: {said!r}"
            continue
        end, others = reached(at, claim_of(motion), starts_of(at, listed, motion))
        if end is None and not others:
            yield "skipped"  # nothing says where it could be started
        elif end is None:
            yield f"{said!r} is not reached; starts on and beside it end in {told(others, at)}"


def _listed(said, listed):
    """The motion of a list that a text names."""
    match = re.match(rf"({'|'.join(KINDS)}) \((?:turning at )?(?:{NUM} Hz, )?(?:\|r\| {NUM} gaps)?", said)
    if match is None:
        return None
    same = [motion for motion in listed.motions if motion.motion == match[1]]
    if match[3]:
        same = [motion for motion in same if abs(motion.amplitude_max / listed.gap - float(match[3])) < 0.006]
    if match[2]:
        same = [motion for motion in same if abs(motion.frequency / float(match[2]) - 1.0) < 2e-3]
    return same[0] if same else None


def of_not_reached(text, witness):
    """Whirls that are predicted to be stable and were not reached: started on, the second engine must leave them."""
    match = re.match(rf"at {NUM} Hz predicted to be stable, but no run ended there: (.*)$", text)
    if match is None:
        yield "unreadable"
        return
    at = witness.at(float(match[1]))
    for label, frequency, gaps in re.findall(rf"(?:whirl )?(\w+) \({NUM} Hz, {NUM} gaps\)", match[2]):
        size = float(gaps) * at.machine.gap
        claim = Claim(BACKWARD | {"forward whirl"}, float(frequency), size, 0.0, True)
        for start in at.circle(float(frequency), size):
            end = at.end(start)
            if (
                end.kinds & claim.kinds
                and end.steady
                and abs(end.turning / claim.turning - 1.0) < 0.01
                and abs(end.size / size - 1.0) < 0.1
            ):
                yield f"whirl {label} lasts: {told([end], at)}"
                break


def of_coverage(text, witness):
    """The bound of each list: the binomial share with which as few impacts as were seen to settle elsewhere have 5 %."""
    for part in text.split("; "):
        counts = r"(all|none of|\d+ of) (\d+) impacts touched(?:, (\d+) of them had not settled)?"
        match = re.match(rf"at {NUM} Hz {counts}(.*)$", part)
        if match is None:
            yield f"unreadable: {part!r}"
            continue
        speed, unsettled = float(match[1]), int(match[4] or 0)
        touched = int(match[3]) if match[2] == "all" else 0 if match[2] == "none of" else int(match[2].split()[0])
        if min(abs(speed - listed.speed) for listed in witness.report.motions) > 1e-3 * speed:
            yield "speed of no list"
        share = re.search(rf"fewer than {NUM} % of the impacts that touch$", match[5])
        bound = _share(touched, unsettled)
        if (share is None and bound < 1.0) or (share and not 0.0 <= float(share[1]) - 100.0 * bound < 0.11):
            yield f"the bound is {100.0 * bound:.4g} %"


def _share(starts, unsettled):
    """The share of a motion with which at most so many of some impacts end in it once in twenty times."""
    low, high = 0.0, 1.0
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        few = sum(math.comb(starts, k) * middle**k * (1.0 - middle) ** (starts - k) for k in range(unsettled + 1))
        low, high = (middle, high) if few > 0.05 else (low, middle)
    return high


def of_verdict(text, witness):
    """The severity against the kinds of the windows, and the smallest impact: the second engine must find a whirl after it."""
    report, verdict = witness.report, witness.report.verdict
    match = re.search(r"Severity: ([\w ]+) \(", text)
    if match is None or match[1] != str(verdict.severity):
        yield "no severity, or another one"
    if text.startswith("No contact") and "force" in dict(answer(report)):
        yield "no contact, and a force"
    backward = any(str(kind) in BACKWARD for kind in report.features.kind)
    if backward and verdict.severity not in ("whirl", "destructive"):
        yield "the run is in backward whirl"
    impact = verdict.impact
    if impact and impact.hits and impact.motion in BACKWARD and match and match[1] in ("safe", "at risk", "rub", "unknown"):
        yield "impacts start a backward whirl"


def of_mu_min(text, witness):
    """The least friction with a whirl: at its frequency the receptances of the second engine ask for that friction."""
    match = re.match(rf"at {NUM} Hz .* is {NUM} \({NUM} Hz\)(?: within a depth of one gap)?(?:; .*)?$", text)
    if match is None or witness.machine.unequal:
        yield "skipped"
        return
    speed, friction, frequency = (float(value) for value in match.groups())
    m, w, omega = witness.at(speed).machine, 2.0 * np.pi * frequency, 2.0 * np.pi * speed

    def asked(w):
        dynamic = m.stiffness - np.eye(len(m.row)) * w**2 + 1j * w * (m.damping - 1j * omega * m.gyroscopic)
        H = m.row @ np.linalg.solve(dynamic, m.push.astype(complex))
        traction = -H.imag / H.real
        # friction pulls the other way on a whirl that rolls, where the surfaces hardly slide
        distance = m.gap / (1.0 - 1.0 / (m.k * abs(H) * np.hypot(1.0, traction)))
        rolls = m.radius > 0.0 and abs(omega * m.radius + w * distance) < 0.01 * abs(omega * m.radius) + m.slip
        return abs(traction) if rolls else traction

    half = np.pi * 10.0 ** -len(match[3].partition(".")[2])  # of the last digit that is told of the frequency, rad/s
    sides = [asked(w + off) for off in (-half, 0.0, half)]
    if not 0.99 * min(sides) <= friction <= 1.01 * max(sides):
        yield f"second engine: {sides[1]:.4g}"
