"""The smallest impulses of all directions as text."""

import math

from rsc.errors import one_line
from rsc.show.words.table import table
from rsc.show.words.wording import frequency_text


def impulses_text(found, title=""):
    """The smallest impulse that starts a whirl, and a row for each direction; found: a `SmallestImpulses`."""
    at = f"; impacts at {found.contact}" if found.contact else ""
    lines = [one_line(title), "", f"{frequency_text(found.speed, 'g')}; without an impact: {found.undisturbed}{at}"]
    weakest = found.weakest
    if weakest is None:
        lines.append(f"no impact up to {found.largest:.4g} N s starts a whirl ({found.runs} runs)")
    elif found.impulse[weakest] > 0.0:
        share = 100.0 * (1.0 - found.below[weakest] / found.impulse[weakest])
        lines.append(
            f"smallest impulse that starts a whirl: {found.impulse[weakest]:.4g} N s at {found.direction[weakest]:g} degrees"
            f"{_from_heavy_spot(found.ahead[weakest])}, {found.velocity[weakest]:.4g} m/s at the contact "
            f"({share:.1g} % less starts none; {found.runs} runs)"
        )
        lines += ["", _directions(found)]
    if found.unsettled:
        lines.append(f"remark: {found.unsettled} of {found.runs} runs had not settled, and count as ones without a whirl")
    if found.interrupted:
        lines.append("remark: interrupted; larger found, or smaller steps between them, were not tried")
    return "\n".join(lines)


def _from_heavy_spot(ahead):
    """Where the rotor is hit, which a balancer can find again: by the mark alone where the heavy spot is not known."""
    return " from y" if math.isnan(ahead) else f" from y, {ahead:.0f} degrees ahead of the heavy spot"


def _directions(found):
    header = ("direction deg", "ahead of heavy spot deg", "N s", "m/s", "ends at Hz", "in")
    columns = found.direction, found.ahead, found.impulse, found.velocity, found.frequency, found.motion, found.at
    rows = []
    for direction, ahead, impulse, velocity, frequency, motion, at in zip(*columns, strict=True):
        angles = f"{direction:g}", "-" if math.isnan(ahead) else f"{ahead:.0f}"
        if motion:
            rows.append((*angles, f"{impulse:.4g}", f"{velocity:.4g}", f"{frequency:.2f}", f"{motion} at {at}" if at else motion))
        else:
            rows.append((*angles, f"> {found.largest:.4g}", "-", "-", "no whirl"))
    return table(header, rows)
