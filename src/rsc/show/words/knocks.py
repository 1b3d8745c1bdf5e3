"""The smallest knocks of all directions as text."""

import math

from rsc.errors import one_line
from rsc.show.words.table import table
from rsc.show.words.wording import frequency_text


def knocks_text(knocks, title=""):
    """The smallest knock that starts a whirl, and a row for each direction; `knocks` as `rsc.study.motions.knock.Knocks`."""
    at = f"; knocks at {knocks.contact}" if knocks.contact else ""
    lines = [one_line(title), "", f"{frequency_text(knocks.speed, 'g')}; without a knock: {knocks.undisturbed}{at}"]
    weakest = knocks.weakest
    if weakest is None:
        lines.append(f"no knock up to {knocks.largest:.4g} N s starts a whirl ({knocks.runs} runs)")
    elif knocks.impulse[weakest] > 0.0:
        share = 100.0 * (1.0 - knocks.below[weakest] / knocks.impulse[weakest])
        lines.append(
            f"smallest knock that starts a whirl: {knocks.impulse[weakest]:.4g} N s at {knocks.direction[weakest]:g} degrees"
            f"{_from_heavy_spot(knocks.ahead[weakest])}, {knocks.velocity[weakest]:.4g} m/s at the contact "
            f"({share:.1g} % less starts none; {knocks.runs} runs)"
        )
        lines += ["", _directions(knocks)]
    if knocks.unsettled:
        lines.append(f"remark: {knocks.unsettled} of {knocks.runs} runs had not settled, and count as ones without a whirl")
    if knocks.interrupted:
        lines.append("remark: interrupted; larger knocks, or smaller steps between them, were not tried")
    return "\n".join(lines)


def _from_heavy_spot(ahead):
    """Where the rotor is hit, which a balancer can find again: by the mark alone where the heavy spot is not known."""
    return " from y" if math.isnan(ahead) else f" from y, {ahead:.0f} degrees ahead of the heavy spot"


def _directions(knocks):
    header = ("direction deg", "ahead of heavy spot deg", "N s", "m/s", "ends at Hz", "in")
    columns = knocks.direction, knocks.ahead, knocks.impulse, knocks.velocity, knocks.frequency, knocks.motion, knocks.at
    rows = []
    for direction, ahead, impulse, velocity, frequency, motion, at in zip(*columns, strict=True):
        angles = f"{direction:g}", "-" if math.isnan(ahead) else f"{ahead:.0f}"
        if motion:
            rows.append((*angles, f"{impulse:.4g}", f"{velocity:.4g}", f"{frequency:.2f}", f"{motion} at {at}" if at else motion))
        else:
            rows.append((*angles, f"> {knocks.largest:.4g}", "-", "-", "no whirl"))
    return table(header, rows)
