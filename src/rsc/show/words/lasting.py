"""What predictions say of one rotor speed in a sentence: which backward whirls last there."""

from rsc.measure.severity import Severity
from rsc.show.words.verdict import beyond_text
from rsc.show.words.wording import amount, frequency_text, length


def lasting_text(speed, lasting, unstable):
    """The backward whirls that last once they are started, by prediction.

    speed : Hz; lasting : (kind, frequency in Hz, |r| in m, normal force in N, rsc.system.border.Border) of each stable one
    unstable : int, how many others exist
    """
    at = f"At {frequency_text(speed)}"
    if lasting:
        what = "a backward whirl lasts" if len(lasting) == 1 else f"each of {len(lasting)} backward whirls lasts"
        told = "; ".join(_told(*each) for each in lasting)
        return f"{at} {what} once it is started, by prediction: {told}. Severity: at least {Severity.AT_RISK}."
    others = f"{unstable} exist, all unstable" if unstable else "none exists"
    return f"{at} no backward whirl lasts, by prediction: {others}. Severity: {Severity.UNKNOWN}, as nothing was simulated."


def _told(kind, frequency, amplitude, force, border):
    size = beyond_text(border) or f"{length(amplitude)} and {amount(force, 'N')}"
    return f"{kind} at {frequency_text(frequency)}, {size}"
