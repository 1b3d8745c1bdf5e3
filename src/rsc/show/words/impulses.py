"""The smallest impulses of all directions as text."""

import math

import numpy as np

from rsc.errors import one_line
from rsc.show.words.table import exact, table
from rsc.show.words.verdict import hardness_text
from rsc.show.words.wording import frequency_text


def impulses_text(impulses, title=""):
    """The smallest impulse that starts a whirl, and a row for each direction; impulses: a `SmallestImpulses`."""
    at = f"; impacts at {impulses.contact}" if impulses.contact else ""
    lines = [one_line(title), "", f"{frequency_text(impulses.speed, 'g')}; without an impact: {impulses.undisturbed}{at}"]
    weakest = impulses.weakest
    if weakest is None:
        lines.append(f"no impact up to {impulses.largest:.4g} N s starts a whirl ({impulses.runs} runs)")
    elif impulses.impulse[weakest] > 0.0:
        share = 100.0 * (1.0 - impulses.below[weakest] / impulses.impulse[weakest])
        lines.append(
            f"smallest impulse that starts a whirl: {impulses.impulse[weakest]:.4g} N s"
            f"{hardness_text(impulses.rotor_velocity[weakest], impulses.velocity[weakest])} "
            f"at {impulses.direction[weakest]:g} degrees{_from_heavy_spot(impulses.ahead[weakest])} "
            f"({share:.1g} % less starts none; {impulses.runs} runs)"
        )
        lines += ["", _directions(impulses)]
    if impulses.unsettled:
        lines.append(f"remark: {impulses.unsettled} of {impulses.runs} runs had not settled, and count as ones without a whirl")
    if impulses.interrupted:
        lines.append("remark: interrupted; larger impulses, or smaller steps between them, were not tried")
    return "\n".join(lines)


def _from_heavy_spot(ahead):
    """Where the rotor is hit, which a balancer can find again: by the mark alone where the heavy spot is not known."""
    return " from y" if math.isnan(ahead) else f" from y, {ahead:.0f} degrees ahead of the heavy spot"


def _directions(impulses):
    whole = np.isfinite(impulses.rotor_velocity).any()
    header = ("direction deg", "ahead of heavy spot deg", "N s", f"m/s of {'rotor' if whole else 'contact'}", "ends at Hz", "in")
    names = "direction", "ahead", "impulse", "rotor_velocity" if whole else "velocity", "frequency", "motion", "at"
    columns = [getattr(impulses, name) for name in names]
    rows = []
    for direction, ahead, impulse, velocity, frequency, motion, at in zip(*columns, strict=True):
        angles = f"{direction:g}", "-" if math.isnan(ahead) else f"{ahead:.0f}"
        if motion:
            rate = exact(f"{frequency:.2f}", frequency)
            rows.append((*angles, f"{impulse:.4g}", f"{velocity:.4g}", rate, f"{motion} at {at}" if at else motion))
        else:
            rows.append((*angles, f"> {impulses.largest:.4g}", "-", "-", "no whirl"))
    return table(header, rows)
