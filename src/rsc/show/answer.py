"""The engineer's answer: does it whirl, where, how large, with which force, what ends it, what could it jump to."""

import textwrap

import numpy as np

from rsc.measure.verdict import ELLIPSE, OF_STATOR, RUB
from rsc.measure.windows import FORWARD
from rsc.measure.words import NO_WHIRL, TOLERANCES, percent
from rsc.show.units import unit_for

COLUMNS = 100
MOST_CHANGES = 3
# a line near no predicted whirl with less contact than this share of the time is a free vibration after a touch
TOUCHES = 0.05


def answer(report):
    """(topic, text) lines of a Report, at most a dozen."""
    lines = [("whirl", _whirl(report)), *_size(report), ("force", _force(report))]
    lines += [("change", text) for text in _changes(report)]
    lines += [("at the end", _end(report)), ("also possible", _others(report)), ("check", report.verdict)]
    return [(topic, text) for topic, text in lines if text]


def answer_text(report):
    """The answer as text of at most 100 columns."""
    lines = answer(report)
    width = max(len(topic) for topic, _ in lines) + 2
    folded = []
    for topic, text in lines:
        head = f"{topic}:".ljust(width)
        folded += textwrap.wrap(text, COLUMNS, initial_indent=head, subsequent_indent=" " * width, break_long_words=False)
    return "\n".join(folded)


def length(metres):
    """A length in its unit."""
    return _amount(metres, "m")


def _amount(value, base):
    """A value in SI in the unit in which it reads well."""
    factor, unit = unit_for(abs(value), base)
    return f"{factor * value:.3g} {unit.replace('µ', 'u')}"


def speed_range(speeds):
    """Text of rotor speeds in Hz and rpm."""
    low, high = float(np.min(speeds)), float(np.max(speeds))
    if f"{low:.1f}" == f"{high:.1f}":
        return f"{low:.1f} Hz ({60.0 * low:.0f} rpm)"
    return f"{low:.1f} to {high:.1f} Hz ({60.0 * low:.0f} to {60.0 * high:.0f} rpm)"


def windows_of(report):
    """The rows (frequency, amplitude, synchronous line) of every window."""
    count = len(TOLERANCES)
    return [report.rows[i : i + count] for i in range(0, len(report.rows), count)]


def whirling(report):
    """The rows (frequency, amplitude, synchronous line) of the windows in backward whirl.

    A backward line beside a larger forward motion, one that rubs or bounces, is none; nor is the backward half of an ellipse, nor
    the free vibration that a touch leaves.
    """
    return [window for window in windows_of(report) if _whirls(*window)]


def _whirls(frequency, amplitude, synchronous):
    """Whether the rows of a window show a backward whirl."""
    if frequency.verdict == NO_WHIRL or synchronous.simulated > FORWARD * amplitude.simulated:
        return False
    return bool(frequency.branch) or not (frequency.note.startswith(ELLIPSE) or frequency.contact < TOUCHES)


def _whirl(report):
    windows = whirling(report)
    if not windows:
        return "no backward whirl" + _beside(report) + _contact(report)
    kind = "that rolls " if any(frequency.branch == "roll" for frequency, *_ in windows) else ""
    seconds = f"{windows[0][0].time:.3g} to {windows[-1][0].time:.3g} s"
    when = f", {seconds}" if np.ptp(report.fall.speed) == 0.0 else ""
    return f"backward whirl {kind}at rotor speeds of {speed_range([frequency.speed for frequency, *_ in windows])}{when}"


def _beside(report):
    """Backward lines that are no whirl."""
    sizes = [amplitude.simulated for frequency, amplitude, _ in windows_of(report) if frequency.verdict != NO_WHIRL]
    gaps = max(sizes, default=0.0) / report.result.scene.contact.gap
    return f"; backward lines up to {gaps:.2f} gaps beside the forward motion" if sizes else ""


def _contact(report):
    """Where a run without whirl touches."""
    touching = report.strip.share > 0.0
    if not touching.any():
        return "; no contact"
    share = percent(float(np.mean(report.strip.share)))
    rub = ", forward rub" if any(synchronous.by == RUB for *_, synchronous in windows_of(report)) else ""
    return f"; contact {share} of the time, at {speed_range(report.fall.speed[touching])}{rub}"


def _size(report):
    windows, gap = whirling(report), report.result.scene.contact.gap
    if not windows:
        largest = float(np.nanmax(report.envelope.maximum))
        return [("amplitude", f"up to {largest / gap:.2f} gaps ({length(largest)})")]
    lines = np.array([frequency.simulated for frequency, *_ in windows])
    top = max(windows, key=lambda window: window[1].simulated)[1]
    low, high = f"{lines.min():.1f}", f"{lines.max():.1f}"
    band = low if low == high else f"{low} to {high}"
    size = f"{top.simulated / gap:.2f} gaps ({length(top.simulated)}) at {top.speed:.1f} Hz"
    size += f", {OF_STATOR}" if OF_STATOR in top.note else ""
    return [("frequency", f"{band} Hz (negative: against the rotation)"), ("amplitude", f"up to {size}")]


def _force(report):
    if not report.normal_force > 0.0:
        return ""
    power, place = report.strip.friction_power, int(np.argmax(np.abs(report.strip.friction_power)))
    words = "friction feeds the motion with" if power[place] > 0.0 else "friction brakes the motion with"
    if report.strip.slip_velocity is not None:
        words = "heat by friction"
    heat = f"{words} up to {_amount(abs(power[place]), 'W')}, at {report.fall.speed[place]:.1f} Hz"
    return f"up to {_amount(report.normal_force, 'N')} normal; {heat}"


def _changes(report):
    """Changes of the whirls that the answer tells: a line that is none of a whirl may pass a predicted one."""
    whirls, texts = {frequency.branch for frequency, *_ in whirling(report) if frequency.branch}, []
    changes = [change for change in report.transitions if whirls & {change.before, change.after}]
    for change in changes[:MOST_CHANGES]:
        before, after = (f"whirl {label}" if label else "no whirl" for label in (change.before, change.after))
        end = f"predicted to end at {change.predicted:.1f} Hz" if change.predicted == change.predicted else ""
        jump = change.predicted_jump
        left = f"left at {jump:.1f} Hz in a run like this" if jump == jump else ""
        why = " and ".join(part for part in (end, left) if part)
        texts.append(f"{before} to {after} at {change.taken_over:.1f} Hz" + (f" ({why})" if why else ""))
    more = len(changes) - MOST_CHANGES
    return [*texts, f"and {more} more (--verbose)"] if more > 0 else texts


def _end(report):
    """What the run ends in, and how far that whirl is predicted to go."""
    last = windows_of(report)[-1]
    label = last[0].branch
    branch = next((b for b in report.branches if b.label == label), None)
    if branch is None or not _whirls(*last):
        return ""
    return f"whirl {label} at {report.fall.speed[-1]:.1f} Hz, predicted to be {_stable(branch, report.natural['coupled'][0])}"


def _stable(branch, speeds):
    """Over which of the speeds of a run a whirl is stable."""
    stable = branch.speed[branch.stable]
    if not stable.size:
        return "unstable" if (branch.growth_rate >= 0.0).any() else "no circle: nothing is claimed of its stability"
    low, high = stable.min(), stable.max()
    if low > speeds.min() and high < speeds.max():
        return f"stable from {low:.1f} to {high:.1f} Hz"
    if low > speeds.min():
        return f"stable above {low:.1f} Hz"
    return f"stable below {high:.1f} Hz" if high < speeds.max() else "stable at all speeds of the run"


def _others(report):
    """Other stable motions at the last speed, to which a knock could bring it."""
    last, gap = len(report.fall.speed) - 1, report.result.scene.contact.gap
    speed, own = float(report.fall.speed[last]), report.rows[-len(TOLERANCES)].branch
    motions = []
    for branch in report.branches:
        whirl = branch.at(speed) if branch.label != own else None
        if whirl is not None and whirl.stable:
            amplitude = f"{whirl.rotor_amplitude / gap:.2f} gaps, {_amount(whirl.normal_force, 'N')}"
            motions.append(f"whirl {branch.label} ({whirl.frequency:.1f} Hz, {amplitude})")
    if report.strip.share[last] > 0.0 and report.alone[last] < gap:
        motions.append(f"no contact ({report.alone[last] / gap:.2f} gaps)")
    return f"at {speed:.1f} Hz, after a knock: " + " or ".join(motions) if motions else ""
