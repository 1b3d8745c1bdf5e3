"""Lists of `rsc.motions` against random knocks of the second engine."""

import warnings
from collections import Counter

import numpy as np

import rsc
from answers_motions import AtSpeed, base_of, claim_of, reached, same, starts_of, told
from answers_witness import Finding
from rsc.system.assemble import assemble

STARTS = 64


def judged_list(scene, starts=STARTS):
    """("listed", Counter of motions by kind, findings) of the list of a scene at its first speed."""
    listed = rsc.motions(scene)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the judge
        at = AtSpeed(assemble(scene), listed.speed)
        found = [Finding(*one) for one in (*_lasting(at, listed), *_missing(at, listed, starts))]
    return "listed", Counter(motion.motion for motion in listed.motions), found


def _lasting(at, listed):
    """(topic, detail) of motions of a list that the second engine does not reach, from knocks that do or from themselves."""
    for motion in listed.motions:
        end, others = reached(at, claim_of(motion), starts_of(at, listed, motion))
        if end is None:
            size = motion.amplitude_max / listed.gap
            said = f"{motion.motion} ({motion.frequency:.5g} Hz, {size:.4g} gaps, {motion.force_max:.4g} N"
            yield "listed, does not last", f"{said}, share {motion.share:.3g}): starts beside it end in {told(others, at)}"


def _missing(at, listed, starts):
    """(topic, detail) of lasting motions that knocks of the second engine end in and that are not in a list."""
    dice = np.random.default_rng(7)
    sizes = listed.largest * dice.uniform(size=starts) * np.exp(2j * np.pi * dice.uniform(size=starts))
    base, claims, seen = base_of(at), [claim_of(motion) for motion in listed.motions], []
    left = []
    for impulse in sizes.tolist():
        end = at.end(at.knocked(base, impulse))
        known = [*claims, *seen, *left]
        if not end.kinds or any(one.kinds & end.kinds and same(one, end, at.machine.gap) for one in known):
            continue
        beside = at.lasts(end, dice)
        if beside is None:
            left.append(end)
            continue
        if any(one.kinds & beside.kinds and same(one, beside, at.machine.gap) for one in claims):
            continue
        seen.append(end)
        topic = "lasts, not listed" if end.steady else "lasts restlessly, not listed"
        yield topic, f"after {abs(impulse):.4g} N s at {np.angle(impulse, deg=True):.0f} degrees: {told([end], at)}"
