"""Lists of `rsc.motions` against random impacts of the second engine."""

import warnings
from collections import Counter

import numpy as np

import rsc
from answers_limits import judging
from answers_motions import AtSpeed, base_of, claim_of, reached, same, starts_of, told
from answers_witness import Finding
from rsc.system.assemble import assemble

STARTS = 64
MISSING = "lasts, not listed", "lasts restlessly, not listed"  # of a motion that is steady, and of one that is not


def judged_list(scene, starts=STARTS):
    """("listed", Counter, findings) of the list of a scene at its first speed; the Counter has the motions of the list by kind,
    and as MISSING those that last after impacts of the second engine."""
    listed, count = rsc.motions(scene), Counter()
    judging()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the judge
        at = AtSpeed(assemble(scene), listed.speed)
        found = [Finding(*one) for one in (*_lasting(at, listed), *_missing(at, listed, starts, count))]
    return "listed", Counter(motion.motion for motion in listed.motions) + count, found


def _lasting(at, listed):
    """(topic, detail) of motions of a list that the second engine does not reach, from impacts that do or from themselves."""
    for motion in listed.motions:
        end, others = reached(at, claim_of(motion), starts_of(at, listed, motion))
        if end is None:
            size = motion.amplitude_max / listed.gap
            said = f"{motion.motion} ({motion.frequency:.5g} Hz, {size:.4g} gaps, {motion.force_max:.4g} N"
            yield "listed, does not last", f"{said}, share {motion.share:.3g}): starts beside it end in {told(others, at)}"


def _missing(at, listed, starts, count):
    """(topic, detail) of lasting motions that impacts of the second engine end in and that are not in a list; count: a Counter to
    which all of them that last are added."""
    dice = np.random.default_rng(7)
    sizes = listed.largest * dice.uniform(size=starts) * np.exp(2j * np.pi * dice.uniform(size=starts))
    base, claims, seen = base_of(at), [claim_of(motion) for motion in listed.motions], []
    left, reached_claims = [], set()
    for impulse in sizes.tolist():
        end = at.end(at.hit(base, impulse))
        listed_as = _place(claims, end, at)
        if listed_as is None and end.kinds and _place([*seen, *left], end, at) is None:
            beside = at.lasts(end, dice)
            if beside is None:
                left.append(end)
                continue
            listed_as = _place(claims, beside, at)
            if listed_as is None:
                seen.append(end)
                topic = MISSING[not end.steady]
                count[topic] += 1
                yield topic, f"after {abs(impulse):.4g} N s at {np.angle(impulse, deg=True):.0f} degrees: {told([end], at)}"
        if listed_as is not None and listed_as not in reached_claims:
            reached_claims.add(listed_as)
            count[MISSING[not claims[listed_as].steady]] += 1


def _place(motions, end, at):
    """Number of the first of some motions (Claim or End) that an end is; None for none."""
    return next((i for i, one in enumerate(motions) if one.kinds & end.kinds and same(one, end, at.machine.gap)), None)
