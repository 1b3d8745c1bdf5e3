"""The smallest knocks of all directions as text."""

from rsc.errors import one_line
from rsc.show.table import table


def knocks_text(knocks, title=""):
    """The smallest knock that starts a whirl, and a row for each direction; `knocks` as `rsc.study.knock.Knocks`."""
    lines = [one_line(title), "", f"{knocks.speed:g} Hz; without a knock: {knocks.undisturbed}"]
    weakest = knocks.weakest
    if weakest is None:
        lines.append(f"no knock up to {knocks.largest:.4g} N s starts a whirl ({knocks.runs} runs)")
    elif knocks.impulse[weakest] > 0.0:
        share = 100.0 * (1.0 - knocks.below[weakest] / knocks.impulse[weakest])
        lines.append(
            f"smallest knock that starts a whirl: {knocks.impulse[weakest]:.4g} N s at {knocks.direction[weakest]:g} degrees, "
            f"{knocks.velocity[weakest]:.4g} m/s at the contact ({share:.1g} % less starts none; {knocks.runs} runs)"
        )
        lines += ["", _directions(knocks)]
    if knocks.unsettled:
        lines.append(f"remark: {knocks.unsettled} of {knocks.runs} runs had not settled, and count as ones without a whirl")
    if knocks.interrupted:
        lines.append("remark: interrupted; larger knocks, or smaller steps between them, were not tried")
    return "\n".join(lines)


def _directions(knocks):
    header = ("direction deg", "N s", "m/s", "ends at Hz", "in")
    columns = knocks.direction, knocks.impulse, knocks.velocity, knocks.frequency, knocks.motion
    rows = []
    for direction, impulse, velocity, frequency, motion in zip(*columns, strict=True):
        if motion:
            rows.append((f"{direction:g}", f"{impulse:.4g}", f"{velocity:.4g}", f"{frequency:.2f}", motion))
        else:
            rows.append((f"{direction:g}", f"> {knocks.largest:.4g}", "-", "-", "no whirl"))
    return table(header, rows)
