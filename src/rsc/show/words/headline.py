"""A run in one sentence: how well simulation and prediction agree."""

from rsc.measure.words import (
    AGREES,
    AMPLITUDE,
    DIFFERS,
    FREQUENCY,
    NO_WHIRL,
    NOT_RESOLVED,
    SYNCHRONOUS,
    TOLERANCES,
    VERDICTS,
)
from rsc.show.words.reasons import percent

PLURALS = {FREQUENCY: "frequencies", AMPLITUDE: "amplitudes", SYNCHRONOUS: "windows"}


def summary(windows, transitions, status, witness="simulation"):
    """One sentence on how well simulation, or a measurement, and prediction agree over the run, in windows and quantities."""
    counts = _counted(windows)
    if status == "out of assumptions":
        return f"the run left the one-sided friction law's assumption of sliding forward (12): {counts}"
    if status != "finished":
        return f"the run stopped early ({status}): {counts}"
    if any(change.verdict == DIFFERS for change in transitions):
        return f"{witness} and prediction disagree on a change of whirl: {counts}"
    return counts


def _counted(windows):
    """Number of windows that agree in each quantity, and the verdicts of the others."""
    verdicts = [window.frequency.verdict for window in windows]
    backward = [window for window in windows if window.frequency.verdict not in (NO_WHIRL, NOT_RESOLVED)]
    own = {
        FREQUENCY: [window.frequency.verdict for window in backward],
        AMPLITUDE: [window.amplitude.verdict for window in backward],
    }
    off = [window.synchronous for window in windows if window.frequency.verdict == NO_WHIRL and window.synchronous.by]
    parts = []
    if backward:
        frequencies, amplitudes = (f"within {percent(TOLERANCES[q])}" for q in own)
        counts = [values.count(AGREES) for values in own.values()]
        first = f"{counts[0]} of {_windows(len(backward))} with a backward line"
        parts.append(f"frequency agrees {frequencies} in {first}, amplitude {amplitudes} in {counts[1]}{_others(own)}")
    if off:
        lines = [row.verdict for row in off]
        agree = f"{lines.count(AGREES)} of {_windows(len(lines))}"
        within = percent(TOLERANCES[SYNCHRONOUS])
        text = f"1X amplitude agrees within {within} in {agree} without backward whirl"
        parts.append(text + _others({SYNCHRONOUS: lines}))
    if NOT_RESOLVED in verdicts:
        parts.append(f"{verdicts.count(NOT_RESOLVED)} of {_windows(len(verdicts))} cannot be compared (not resolved)")
    return "; ".join(parts) or "no window to compare"


def _windows(count):
    return f"{count} window{'s' if count != 1 else ''}"


def _others(own):
    """The verdicts that do not agree, counted."""
    parts = []
    for quantity, verdicts in own.items():
        counted = [f"{verdicts.count(v)} {v}" for v in VERDICTS if v != AGREES and v in verdicts]
        parts += [f"other {PLURALS[quantity]}: {', '.join(counted)}"] if counted else []
    return "".join(f"; {part}" for part in parts)
