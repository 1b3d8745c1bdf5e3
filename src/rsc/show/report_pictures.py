"""Pictures of a report: its arrays handed to `rsc.show.plots`, one function for each picture."""

from pathlib import Path

import numpy as np

from rsc.analysis.branches import RANGE_END
from rsc.errors import one_line
from rsc.measure.features import contact_strip, revolution_marks
from rsc.measure.windows import ROLL
from rsc.measure.words import SYNCHRONOUS
from rsc.show import plots

# length of the orbit picture in periods of the slowest visible motion
ORBIT_PERIODS = 12.0
MAPPED = ("frequency", "amplitude")  # of a branch, in the two halves of the map


def draw(report, folder):
    """Write every picture of one report into a folder.

    Parameters
    ----------
    report : rsc.study.check.Report
    folder : Path, existing

    Returns
    -------
    list of Path, the files written
    """
    title = one_line(report.result.scene.title)
    figures = {
        "campbell": campbell(report, title),
        "waterfall": plots.plot_waterfall(report.fall, title=title, f_range=_band(report)),
        "amplitude": amplitude([report], title),
        "orbit": orbit(report.result, title),
        "contact": contact(report, title),
    }
    paths = []
    for name, figure in figures.items():
        paths.append(Path(folder) / f"{name}.png")
        plots.save(figure, paths[-1])
    return paths


def campbell(report, title):
    """Figures 3 and 5 of the paper: spectra over rotor speed with natural frequencies and predicted whirls."""
    whirls = [(b.speed, b.frequency, b.stable) for b in report.branches]
    rolls = [row.predicted if row.branch == ROLL else np.nan for row in report.rows if row.quantity == "whirl frequency"]
    return plots.plot_campbell(
        report.fall, title=title, natural=report.natural, whirls=whirls, rolls=rolls, f_range=_band(report)
    )


def amplitude(reports, title):
    """Figures 4 and 6: envelopes of one or more runs of a scene with the predicted amplitudes of the first."""
    first = reports[0]
    followed = {row.branch for report in reports for row in report.rows}
    predicted = [
        (b.speed, b.amplitude, b.stable, b.envelope(0), b.envelope(1))
        for b in first.branches
        if b.label in followed or b.stable.any()
    ]
    runs = [(_direction(report.result), report.envelope) for report in reports]
    marks = {f"1X largest on {peak.branch}": peak.speed for peak in first.resonances}
    marks |= {
        f"{t.before or 'no whirl'} to {t.after or 'no whirl'}": t.taken_over for report in reports for t in report.transitions
    }
    return plots.plot_amplitude(
        runs,
        gap=first.result.scene.contact.gap,
        title=title,
        predicted=predicted,
        synchronous=first.rub,
        transition=marks,
        unbalance_line=_unbalance_line(first.rows),
    )


def _unbalance_line(rows):
    """Speeds, and the line at the rotor speed simulated and predicted, of the windows on a whirl; NaN elsewhere."""
    lines = [row for row in rows if row.quantity == SYNCHRONOUS]
    simulated, predicted = (
        np.array([getattr(row, name) if row.branch else np.nan for row in lines]) for name in ("simulated", "predicted")
    )
    return np.array([row.speed for row in lines]), simulated, predicted


def branch_map(survey):
    """Frequency and amplitude of a survey's branches over the rotor speed; far-out roots below the gap are left out."""
    gap = survey.scene.contact.gap
    shown = [b for b in survey.branches if b.amplitude.max() > gap]
    branches = [(b.label, b.values, b.frequency, b.amplitude, b.stable) for b in shown]
    marks = [
        (event.value, event.frequency, float(np.interp(event.value, b.values, b.amplitude)), event.cause)
        for b in shown
        for event in (b.begin, *b.events, b.end)
        if event.cause != RANGE_END
    ]
    rubs = [(rub.speed, rub.amplitude, rub.stable) for rub in survey.rubs]
    ratios = [_of_ratio(place, {b.label: b for b in shown}) for place in survey.ratios]
    return plots.plot_map(branches, marks, gap=gap, title=one_line(survey.scene.title), rubs=rubs, ratios=ratios)


def _of_ratio(place, by_label):
    """Speed, frequencies, amplitudes and text of a place where two whirls' normal forces pass their limit."""
    pair = [by_label[label] for label in (place.label, place.towards)]
    frequency, amplitude = ([float(np.interp(place.speed, b.values, getattr(b, name))) for b in pair] for name in MAPPED)
    return place.speed, frequency, amplitude, f"F_N of {place.label} is {place.ratio:.3f} F_N of {place.towards}"


def orbit(result, title):
    """The end of a run in the plane."""
    rate = result.scene.output.rate
    speed = max(abs(float(result.speed[-1])), 1.0)
    count = min(len(result.time), max(int(ORBIT_PERIODS / speed * rate), 200))
    rigid = result.scene.stator.model == "rigid"
    marks = revolution_marks(result)
    first = len(result.time) - count
    return plots.plot_orbit(
        result.contact_rotor()[first:],
        None if rigid else result.contact_stator()[first:],
        gap=result.scene.contact.gap,
        title=f"{title}\nthe last {count / rate:.2g} s",
        rotation_marks=marks[marks >= first] - first,
        contact_force=result.normal_force[first:],
    )


def contact(report, title):
    """The rub strip: contact share, normal force, slip and friction power over the run."""
    strip = contact_strip(report.result, report.fall)
    swept = np.ptp(strip.speed) > 0.0
    return plots.plot_contact(
        strip.speed if swept else strip.time,
        strip.share,
        strip.normal_force,
        strip.slip_velocity,
        strip.friction_power,
        title=title,
        x_label="rotor speed in Hz" if swept else "time in s",
    )


def _direction(result):
    first, last = result.scene.drive.speed[0], result.scene.drive.speed[-1]
    if first == last:
        return f"run at {first:g} Hz"
    return f"run-{'up' if last > first else 'down'} {first:g} to {last:g} Hz"


def _band(report):
    """Frequencies worth drawing: the simulated lines, the stable whirls and +-1X."""
    top = float(np.abs(report.fall.speed).max())
    lines = [np.abs(report.features.frequency)]
    lines += [np.abs(b.frequency[b.stable]) for b in report.branches if b.stable.any()]
    low = max(float(np.nanmax(line)) if not np.isnan(line).all() else 0.0 for line in lines)
    reach = 1.15 * max(top, low)
    return (-reach, reach)
