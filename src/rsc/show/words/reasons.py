"""The reasons of verdicts in words."""

import math

from rsc.measure.reasons import Code
from rsc.show.words.wording import frequency_text


def percent(share):
    """A share of one as a percentage with two digits, or all digits before the point of a larger one."""
    if share < 0.99:
        return f"{100 * share:.2g} %"
    return f"{100 * share:.1f} %" if share < 0.9995 else f"{100 * share:.0f} %"


# code -> words, of its names and numbers; several of the same code in a row stand behind the first words of two
WORDS = {
    Code.FEW_PERIODS: lambda count: f"{count:.1f} periods in a window",
    Code.SHORT: lambda why: why,
    Code.TOO_FAST: lambda turning, rate: f"contact turns at {frequency_text(turning, '.4g')}, beyond half of output.rate = "
    f"{rate:g} Hz",
    Code.TOO_FAR: ("too far from a steady motion: ", lambda effect, size: f"{effect} ({percent(size)})"),
    Code.STILL_RINGS: lambda rate, since: f"too far from a steady motion: decays at {rate:.2g} 1/s since {since:.4g} s",
    Code.COVERED: ("covered by ", lambda effect, size: f"{effect} ({percent(size)})"),
    Code.DECAYS: lambda unit, rate, since, remains: (
        f"decays at {rate:.2g} 1/s since {since:.4g} {unit}, up to {percent(remains)} remain"
    ),
    Code.DEPARTURE: lambda rate, grown: (
        f"covered by departure from an unstable whirl (at {rate:.2g} 1/s up to {percent(grown)})"
    ),
    Code.MUST_BE_LEFT: lambda: "near a whirl that is unstable and must have been left",
    Code.NONE_WITH_SO_MUCH: lambda cause, share: f"no steady whirl with more than {100 * share:.0f} % of the {cause}",
    Code.OF_STATOR: lambda: "of the stator",
    Code.UNSTABLE: lambda: "the whirl is unstable there",
    Code.NOT_YET_LEFT: lambda: "the whirl is unstable there and not yet left",
    Code.ROLLS: lambda: "rolls",
    Code.ROLLS_BY_NONE: lambda share: f"rolls for {100 * share:.0f} % of the time, near no whirl that is predicted to",
    Code.BY_NONE: lambda kind, share: (
        f"{kind} near no predicted one" + (f", contact for {100 * share:.0f} % of the time" if share < 1.0 else "")
    ),
    Code.OTHER_MOTION: lambda kind: kind,
}


def note(row):
    """The reason for the verdict of a row; "" if there is none."""
    parts, last = [], None
    for reason in row.reasons:
        words = WORDS[reason.code]
        head, tell = words if isinstance(words, tuple) else ("", words)
        text = tell(*reason.names, *reason.numbers)
        if head and reason.code == last:
            parts[-1] += f", {text}"
        else:
            parts.append(head + text)
        last = reason.code
    return "; ".join(parts)


def note_of_change(change):
    """Why a change of whirl has its verdict."""
    (reason,), whirl = change.reasons, f"whirl {change.before}"
    if reason.code == Code.SETS_IN:
        return "a whirl sets in"
    if reason.code == Code.ALWAYS_UNSTABLE:
        return f"{whirl} is predicted to be unstable at all speeds: a line near it belongs to a transient motion"
    if reason.code == Code.LATE:
        text = (
            f"{whirl} loses stability at {frequency_text(change.predicted, '.2f')} (predicted); "
            f"delayed jump (dynamic bifurcation) at {frequency_text(change.taken_over, '.1f')}: growth e^{change.folds:.1f} in "
            "between; a smaller disturbance, a tighter tolerance or a faster run-up delays it further"
        )
        jump = change.predicted_jump
        rounding = f"; predicted with rounding errors as the only disturbance: {frequency_text(jump, '.1f')}"
        return text if math.isnan(jump) else text + rounding
    (number,) = reason.numbers
    if reason.code == Code.ENDED_BY_UNBALANCE:
        return f"the unbalance ends {whirl}: by harmonic balance there is none with more than {100 * number:.0f} % of it"
    if reason.code == Code.UPSET_BY_UNBALANCE:
        return f"the unbalance makes {whirl} unstable (harmonic balance, growth up to {number:.2g} 1/s)"
    contact = "" if math.isnan(number) else f" (contact {100 * number:.0f} % of a window)"
    return f"{whirl} is predicted to be stable there{contact}"
