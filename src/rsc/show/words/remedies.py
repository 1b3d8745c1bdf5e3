"""Remedies as text: a line for each change of a value."""

import math

from rsc.errors import one_line
from rsc.measure.kinds import HARMFUL
from rsc.show.words.verdict import beyond_text
from rsc.show.words.wording import amount, frequency_text, motion_name

RUNS_AWAY = "a motion that is large enough still runs away, since friction is one-sided without a contact diameter"
DRY = 0.05  # friction of about the slipperiest surfaces without a lubricating film


def remedies_text(remedies, title=""):
    """What lasts as the machine is, what takes it away, the smallest change first, and what does not help; found as
    `rsc.study.motions.remedy.Remedies`."""
    head = [one_line(title), ""] if title else []
    harmful = ", ".join(map(_motion, remedies.harmful))
    lasts = harmful or "no backward motion lasts, no remedy needed"
    lines = [*head, f"at {frequency_text(remedies.speed)}: severity {remedies.severity}; {lasts}"]
    if remedies.harmful:
        lists = f"a list with {remedies.starts} random impacts has no backward motion that lasts"
        none = "no remedy found: one value alone is not enough"
        lines.append(f"remedies, each by itself ({lists}):" if remedies.helping else none)
    for own in remedies.helping:
        kept = ", ".join(dict.fromkeys(map(motion_name, own.remains))) or "nothing that lasts was found"
        lines.append(f"  {_changed(own)}; remains: {kept}; severity {own.severity}")
    lines += ["does not help, even changed as far as here:"] if remedies.others else []
    for own in remedies.others:
        kept = ", ".join(_motion(motion) for motion in own.remains if motion.motion in HARMFUL) or (own.remains and RUNS_AWAY)
        lines.append(f"  {_changed(own)}: {kept}" if kept else f"  {own.words}: no change of it could be simulated")
    if remedies.interrupted:
        lines.append("remark: interrupted; other values were not examined")
    return "\n".join(lines)


def _changed(own):
    """A value, its new value and the factor between them."""
    by = f"{'times' if own.factor >= 1.0 else 'divided by'} {own.size:.3g}"
    if math.isnan(own.value):
        return f"{own.words} {by}"
    film = "; requires a lubricating film" if own.name.endswith(".friction") and own.changed < DRY <= own.value else ""
    return f"{own.words} {own.value:.4g} -> {own.changed:.4g} ({by}{film})"


def _motion(motion):
    """A motion that does harm, with its rate, and its force where the model holds for it."""
    rate = "" if math.isnan(motion.frequency) else f"{frequency_text(motion.frequency)}, "
    size = "still grew at 20 gaps" if not motion.bounded else beyond_text(motion.border) or amount(motion.force_max, "N")
    return f"{motion_name(motion)} ({rate}{size})"
