"""Reports, predictions and results as text and tables."""

import math

import numpy as np

from rsc.errors import one_line
from rsc.measure.several import together
from rsc.measure.words import NO_WHIRL
from rsc.show.words.answer import answer_text
from rsc.show.words.at_contacts import branch_cells
from rsc.show.words.clearances import touching, watched_text
from rsc.show.words.held import loads_text
from rsc.show.words.motions import motions_text
from rsc.show.words.reasons import note, note_of_change
from rsc.show.words.table import exact, table
from rsc.show.words.units import column, shown_as_in
from rsc.show.words.wording import cause_text, event_text, frequency_text, length, not_valid, sentence_in_units
from rsc.system.border import DEEPEST

# rows of windows that a table shows at most; --json has them all
MOST_ROWS = 24
LEDGER = 10.0  # times rtol of the turnover: what the parts of a ledger are good for (ladder V7)


def report_text(report, verbose=False):
    """The answer of a Report, and, if verbose, its tables: predicted whirls, one line a window (thinned), changes, ledger."""
    with shown_as_in(report.result.scene):
        return _report_text(report) if verbose else "\n".join([answer_text(report), *notes(report)])


def _report_text(report):
    """The same with the tables."""
    gap = report.contact.gap
    title = one_line(report.result.scene.title)
    lines = [answer_text(report), "", title, "", "predicted whirls", branches_text(report.branches, report.contact), ""]
    about = f"windows of {report.fall.window:.3g} s; lengths over the gap{at_lead(report)}"
    lines += [f"{report.word} and predicted ({about})"]
    lines += [table(*window_cells(report, MOST_ROWS)), ""]
    for change in report.transitions:
        seen = f", first seen at {frequency_text(change.first_seen, '.1f')}" if change.first_seen != change.taken_over else ""
        names = f"{change.before or 'no whirl'} to {change.after or 'no whirl'}"
        at = f"at {frequency_text(change.taken_over, '.1f')}{seen}"
        lines.append(f"change {names} {at}: {change.verdict}. {note_of_change(change)}")
    lines += [
        f"unbalance line on whirl {peak.branch}: largest at {frequency_text(peak.speed, '.1f')}, {peak.height / gap:.3f} gaps "
        f"(predicted at {frequency_text(peak.predicted_speed, '.1f')}, {peak.predicted_height / gap:.3f} gaps; to first order "
        f"at {frequency_text(peak.first_order_speed, '.1f')}, {peak.first_order_height / gap:.3f} gaps)"
        for peak in report.resonances
    ]
    if not math.isnan(report.resonance):
        lines.append(f"forward rub: largest at {frequency_text(report.resonance, '.2f')} (closed form)")
    lines += [f"\n{motions_text(listed)}" for listed in report.motions]
    lines += [run_text(report.result.summary)] if report.result.summary else []
    return "\n".join([*lines, *map(sentence_in_units, report.remarks), *notes(report)])


def notes(report):
    """The warnings of a report that are not part of its answer (which starts with those of measured signals)."""
    told = set(report.result.warnings) if report.result.summary is None else set()
    return [f"note: {sentence_in_units(warning)}" for warning in report.warnings if warning not in told]


def at_lead(report):
    """At which of several contacts tables and pictures are."""
    return f", at {report.lead}" if report.lead else ""


def window_cells(report, most):
    """Header and text rows of at most `most` windows, simulated and predicted; lengths over the gap."""
    gap = report.contact.gap
    every = max(1, math.ceil(len(report.windows) / most))
    word = {"simulated": "sim", "measured": "meas"}[report.word]
    quantities = ("whirl", " Hz"), ("|r|", ""), ("1X", "")
    columns = [(f"{name} {word}{unit}", f"{name} pred{unit}", "diff %") for name, unit in quantities]
    header = ("speed Hz", "whirl", *columns[0], *columns[1], *columns[2][:2], "")
    body = []
    for frequency, amplitude, synchronous in report.windows[::every]:
        whirls = frequency.verdict != NO_WHIRL  # without one the strongest line beside 1X is no whirl's
        body.append(
            (
                exact(f"{frequency.speed:.2f}", frequency.speed),
                frequency.branch or "-",
                exact(_number(frequency.simulated, ".3f"), frequency.simulated) if whirls else "-",
                exact(_number(frequency.predicted, ".3f"), frequency.predicted),
                _number(100 * frequency.difference, "+.2f"),
                _number(amplitude.simulated / gap, ".4f") if whirls else "-",
                _number(amplitude.predicted / gap, ".4f"),
                _number(100 * amplitude.difference, "+.2f"),
                _number(synchronous.simulated / gap, ".4f"),
                _number(synchronous.predicted / gap, ".4f"),
                _verdict(frequency, synchronous),
            )
        )
    return header, body


def _verdict(frequency, synchronous):
    """Text of a window's verdict: on its whirl, and without a whirl on its synchronous line."""
    why = note(frequency)
    if frequency.verdict == NO_WHIRL and not math.isnan(synchronous.predicted):
        words = ", ".join(word for word in (synchronous.by, note(synchronous)) if word)
        why = f"1X {synchronous.verdict}{': ' + words if words else ''}"
    return f"{frequency.verdict} ({why})" if why else frequency.verdict


def branches_text(branches, contact):
    """Table of the predicted branches: range, size, where and why they begin and end, events between."""
    header, rows = branches_cells(branches, contact)
    return table(header, rows) if rows else "none"


def branches_cells(branches, contact):
    """Header and rows of texts of the predicted branches; contact: that of the scene to which their sizes refer.

    Where a branch begins and ends its speed and frequency are located; size and growth are those of its first and last sample.
    """
    names = list(branches[0].at_contacts) if branches else []
    sizes = ["at", *(f"{name}: |d|/gap, N" for name in names)] if names else ["|r|/gap"]
    header = ("whirl", "speed Hz", "whirl Hz", *sizes, "growth 1/s", "begin and end; between")
    rows = []
    for b in branches:
        deep = [] if names else [place for place, is_deep in zip((0, -1), _too_deep(b, contact)[[0, -1]], strict=True) if is_deep]
        frequency, growth = _span(b.begin.frequency, b.end.frequency), _ends(b.growth_rate, deep)
        size = _ends(b.amplitude / contact.gap, deep)
        cells = [frequency, *([together(b.pressed), *branch_cells(b)] if names else [size]), growth]
        between = "".join(f"; {event_text(event)}" for event in b.events)
        between += "" if names else _beyond(b, contact)
        ends = f"{cause_text(b.begin.cause)} to {cause_text(b.end.cause)}{between}{_touched(b)}"
        rows.append((b.label, _span(b.begin.value, b.end.value), *cells, ends))
    return header, rows


def _too_deep(branch, contact):
    """(n,) whether a whirl of the branch penetrates deeper than the model holds for (`rsc.system.border`)."""
    return branch.normal_force > DEEPEST * contact.stiffness * contact.gap


def _ends(values, deep):
    """The first and the last value, but for those that lie beyond the model (places 0 and -1)."""
    first, last = ("beyond" if place in deep else f"{values[place]:.5g}" for place in (0, -1))
    return first if first == last else f"{first} .. {last}"


def _beyond(branch, contact):
    """Over which speeds a branch is beyond the model, "" where it is nowhere."""
    deep = _too_deep(branch, contact)
    if not deep.any():
        return ""
    if deep.all():
        return "; beyond the model: penetration deeper than the gap"
    edges = [_crossing(branch, contact, i) for i in np.flatnonzero(np.diff(deep))]
    where = " and ".join(f"{'above' if deep[i + 1] else 'below'} {frequency_text(at, '.3g')}"
                         for i, at in zip(np.flatnonzero(np.diff(deep)), edges, strict=True))  # fmt: skip
    return f"; beyond the model {where}: penetration deeper than the gap"


def _crossing(branch, contact, i):
    """Speed between samples i and i + 1 at which the penetration is the gap; its reciprocal is linear beside a pole."""
    share = DEEPEST * contact.stiffness * contact.gap / branch.normal_force[i : i + 2]
    first, last = branch.speed[i : i + 2]
    return float(first + (last - first) * (1.0 - share[0]) / (share[1] - share[0]))


def _touched(branch):
    """Which clearances a branch touches, and over which of its speeds."""
    texts = []
    for name in dict.fromkeys(name for names in branch.touches for name in names):
        speeds = branch.speed[[name in names for names in branch.touches]]
        texts.append(f"; touches {name} {'at' if len(speeds) == 1 else 'from'} {_speeds(speeds.min(), speeds.max())}")
    return "".join(texts)


def _span(a, z):
    return exact(f"{a:.5g}", a) if f"{a:.5g}" == f"{z:.5g}" else exact(f"{a:.5g} .. {z:.5g}", a, z)


def _speeds(a, z):
    """One or two rotor speeds in Hz in their unit."""
    factor, unit = column("Hz")
    return f"{_span(factor * a, factor * z)} {unit}"


def survey_text(survey):
    """Branches, forward rubs, attractors at the ends of the run, and delayed jumps."""
    gap = survey.scene.contact.gap
    own = branches_text(survey.branches, survey.scene.contact)
    lines = [one_line(survey.scene.title), "", "backward whirls over the run", own]
    for place in survey.ratios:
        lines.append(
            f"whirl {place.label} holds against {place.towards} {place.holds} {frequency_text(place.speed, '.4f')}: "
            f"there its normal force is {place.ratio:.4f} of the other's (sideband part {place.mirror_share:.2g})"
        )
    for rub in survey.rubs:
        state, ends = stable_stretches(rub), f"{cause_text(rub.begin.cause)} to {cause_text(rub.end.cause)}"
        lines.append(
            f"forward rub {_speeds(rub.begin.speed, rub.end.speed)} ({ends}), {state}, "
            f"|r|/gap up to {rub.amplitude.max() / gap:.4f}"
        )
    for label, delay in survey.delays.items():
        lines.append(f"a run on whirl {label} loses it at {_delay_text(delay)}")
    lines += [f"whirl {label} {loads_text(own)}" for label, own in survey.loads.items() if own]
    lines += map(sentence_in_units, survey.remarks)
    for speed, motions in survey.attractors.items():
        lines += ["", f"steady motions at {frequency_text(speed, 'g')}", _attractors(motions, gap)]
    return "\n".join(lines)


def _delay_text(delay):
    """Where a whirl is lost, in an infinitely slow run and in this one, which may end before."""
    line = "a new line" if math.isnan(delay.towards) else f"the new line ({frequency_text(delay.towards, '.2f')})"
    if math.isnan(delay.first_seen):
        text = f"this run ends before {line} is seen"
    elif math.isnan(delay.jump):
        first = frequency_text(delay.first_seen, ".1f")
        text = f"at this run-up rate {line} is first seen at {first}, and the run ends before it takes over"
    else:
        first, takes = frequency_text(delay.first_seen, ".1f"), frequency_text(delay.jump, ".1f")
        text = f"at this run-up rate {line} is first seen at {first} and takes over at {takes}"
    level = "" if math.isnan(delay.level_at_crossing) else f", {delay.level_at_crossing:.1e} of the whirl at the crossing"
    return f"{frequency_text(delay.crossing, '.4f')} if infinitely slow; {text} (disturbance from the {delay.source}{level})"


def _unclaimed(rate, touches=()):
    """Why a motion is not called stable: it grows, nothing brings it back, it touches a clearance, or it is no circle, for which
    alone the rate holds."""
    if touches and rate < 0.0:
        return touching(touches)
    if rate == 0.0:
        return "free or undamped: it neither dies away nor grows"
    return "unstable" if rate > 0.0 else "not circular: stability not assessed"


def stable_stretches(rub):
    """Over which speeds of its line a forward rub is stable, touches a clearance, or is no circle, of which nothing is claimed,
    in words."""
    touches = rub.touches & (rub.growth_rate < 0.0)
    unclaimed = ~rub.stable & ~touches & (rub.growth_rate < 0.0)
    if rub.stable.all():
        return "stable"
    if not (rub.stable.any() or touches.any()) and unclaimed.all() == unclaimed.any():
        return _unclaimed(rub.growth_rate.min())
    parts = []
    claims = ("stable", rub.stable), ("touches a clearance", touches), ("not circular (stability not assessed)", unclaimed)
    for words, holds in claims:
        if not holds.any():
            continue
        spans = " and ".join(_speeds(*stretch) for stretch in rub.stretches(holds))
        parts += [f"{words} {spans}"] if spans else []
    return ", ".join(parts)


def _attractors(motions, gap):
    header = ("frequency Hz", "|r|/gap", "growth 1/s", "motion")
    rows = [
        (
            exact(f"{m.frequency:.4f}", m.frequency),
            f"{m.amplitude / gap:.4f}",
            f"{m.growth_rate:+.4g}",
            f"{m.kind}, {'stable' if m.stable else _unclaimed(m.growth_rate, m.touches)}",
        )
        for m in motions
    ]
    return table(header, rows) if rows else "none"


def whirls_text(whirls, gap, remarks=(), ratios=(), loads=()):
    """Table of the predicted whirls at one speed, remarks on them in words (`rsc.analysis.survey.remarks`), the force ratios of
    their pairs (`rsc.analysis.follow.force_ratio`), and what each takes from a drive with a torque (`rsc.system.held`)."""
    sizes = "|r|/gap", "|s|/gap", "F_N N"
    header = ("speed Hz", "whirl Hz", *sizes, "growth 1/s", "stable", "1X/gap", "sideband/gap", "not valid")
    rows = [
        (
            exact(f"{w.speed:.4g}", w.speed),
            exact(f"{w.frequency:.4f}", w.frequency),
            f"{w.rotor_amplitude / gap:.4f}",
            f"{w.stator_amplitude / gap:.4f}",
            f"{w.normal_force:.4g}",
            f"{w.growth_rate:+.4g}",
            claim(w),
            f"{w.synchronous.consistent.amplitude / gap:.4f}",
            f"{w.synchronous.consistent.mirror_amplitude / gap:.4f}",
            not_valid(w),
        )
        for w in whirls
    ]
    lines = [table(header, rows) if rows else "no whirl is predicted", *map(sentence_in_units, remarks)]
    pairs = zip(whirls, loads, strict=False)
    lines += [f"whirl {frequency_text(w.frequency, '.4f')} {loads_text(own)}" for w, own in pairs if own]
    if ratios:
        lines += ["normal forces of pairs of whirls whose ratio decides stability", _ratios(ratios)]
    return "\n".join(lines)


def claim(whirl):
    """Stability of a whirl in words, or the clearance it touches."""
    if whirl.decays and whirl.touches:
        return touching(whirl.touches)
    return "yes" if whirl.stable else "no"


def _ratios(ratios):
    header = ("whirl Hz", "towards Hz", "F_N ratio", "least", "sideband part", "")
    rows = [
        (
            exact(f"{r.frequency:.4f}", r.frequency),
            exact(f"{r.towards:.4f}", r.towards),
            f"{r.ratio:.4f}",
            f"{r.least:.4f}",
            f"{r.mirror_share:.2g}",
            "unstable towards it" if r.ratio < r.least else "holds against it",
        )
        for r in ratios
    ]
    return table(header, rows)


def run_text(summary):
    """Text on how a run ended, with its counters and its energy ledger."""
    ledger, (per_joule, joule) = summary.ledger, column("J")
    share = abs(ledger.residual) / ledger.turnover if ledger.turnover > 0.0 else 0.0
    parts = (ledger.rotor_damping, ledger.stator_damping, ledger.contact_damping)
    accuracy = max(abs(ledger.residual), LEDGER * summary.rtol * ledger.turnover)
    rotor, stator, contact = (_lost(per_joule * part, per_joule * accuracy) for part in parts)
    least = summary.least_diameter

    def told(energy):
        return f"{per_joule * energy:.4g}"

    return (
        f"run {summary.status} at {summary.end_time:.6g} s: {summary.steps} steps at rtol {summary.rtol:.3g}, "
        f"{summary.rejected} rejected, "
        f"{summary.rhs_calls} right-hand sides, {summary.switches} contact switches, {summary.contact_onsets} onsets, "
        f"{summary.contact_releases} releases, {summary.contact_time:.4g} s in contact\n"
        f"energy in {joule}: in {told(ledger.energy_in)}, "
        + (f"by the drive through rotating damping {told(ledger.turned_in)}, " if ledger.turned_in else "")
        + (f"by coefficients that follow the speed {told(ledger.followed_in)}, " if ledger.followed_in else "")
        + (f"by the torque of the drive {told(ledger.driven_in)}, " if ledger.driven_in else "")
        + (f"by the control {told(ledger.control_in)}, " if ledger.control_in else "")
        + f"by friction {told(ledger.friction_in)}; "
        f"lost in rotor {rotor}, stator {stator}, contact {contact}; "
        f"change {told(ledger.change)}; residual {per_joule * ledger.residual:.2g} ({share:.1e} of the turnover)"
        + (f"\nsliding forward (12) needs contact.diameter > {length(least)}" if least else "")
    )


def result_text(result):
    """`run_text` of a Trajectory, with how far it came to the clearances that are watched."""
    text = watched_text(result.scene, result.stretches())
    return run_text(result.summary) + (f"\nclearances: {text}" if text else "")


def _lost(energy, accuracy):
    """Text of a dissipated energy. No damper gives energy back: a negative one within the ledger's accuracy is a zero known only
    to its size; a larger one is shown as it is, because then something is wrong."""
    return f"0 (to {-energy:.1g})" if -accuracy <= energy < 0.0 else f"{energy:.4g}"


def _number(value, form):
    if math.isnan(value):
        return "-"
    text = format(value, form)
    return format(0.0, form) if float(text) == 0.0 else text  # no -0.00
