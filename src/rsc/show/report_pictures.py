"""Pictures of a report: its arrays handed to `rsc.show.plots`, one function for each picture."""

from pathlib import Path

import numpy as np

from rsc.errors import one_line
from rsc.files.output import put
from rsc.measure.windows import ROLL
from rsc.measure.words import SYNCHRONOUS
from rsc.show import plots
from rsc.show.abscissa import Abscissa
from rsc.show.moments import distances_once_a_turn, filtered, is_deflected, marks_of, moments, place_of, seen_lines
from rsc.show.orbits import FRAMES, animate_orbit, plot_orbits
from rsc.show.stability import stability

MOST_TURNS = 400  # windows whose positions once a revolution are drawn


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
        "orbit": orbit(report, title),
        "contact": contact(report, title),
        "once_a_turn": once_a_turn(report, title),
    }
    if is_deflected(report):
        figures["centre_line"] = plots.plot_centre_line(report.centre, gap=report.result.scene.contact.gap, title=title)
    if report.stator_fall is not None and np.any(report.stator_fall.amplitude > 0.0):
        figures["campbell_stator"] = campbell(report, f"{title}: motion of the stator", report.stator_fall)
    paths = []
    for name, figure in figures.items():
        paths.append(Path(folder) / f"{name}.png")
        plots.save(figure, paths[-1])
    return paths


def campbell(report, title, fall=None):
    """Figures 3 and 5 of the paper: spectra over rotor speed with natural frequencies and predicted whirls.

    `fall` : spectra.Waterfall, or None for the rotor's
    """
    whirls = [(b.speed, b.frequency, stability(b)) for b in report.branches]
    rolls = [row.predicted if row.branch == ROLL else np.nan for row in report.rows if row.quantity == "whirl frequency"]
    return plots.plot_campbell(
        fall or report.fall, title=title, natural=report.natural, whirls=whirls, rolls=rolls, f_range=_band(report)
    )


def amplitude(reports, title):
    """Figures 4 and 6: envelopes of one or more runs of a scene with the predicted amplitudes of the first."""
    first = reports[0]
    followed = {row.branch for report in reports for row in report.rows}
    predicted = [
        (b.speed, b.amplitude, stability(b), b.envelope(0), b.envelope(1))
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


def orbit(report, title):
    """Paths at the moments of a run that matter."""
    panels = [_panel(report, moment.window, moment.text) for moment in moments(report)]
    return plot_orbits(panels, gap=report.result.scene.contact.gap, title=title)


def animation(report, path):
    """Write the paths of windows all along a run, one after the other, as a GIF."""
    windows = np.unique(np.linspace(0, len(report.fall.speed) - 1, FRAMES).round().astype(int))
    panels = [_panel(report, window, "") for window in windows.tolist()]
    title = one_line(report.result.scene.title)
    put(path, animate_orbit(panels, gap=report.result.scene.contact.gap, title=title), b"GIF8")
    return path


def _panel(report, window, text):
    """Caption, path of rotor and stator, marks, force and filtered paths of a window."""
    orbits = report.orbits
    caption = ", ".join(part for part in (text, place_of(report, window)) if part)
    path = orbits.rotor[window], orbits.stator[window], marks_of(report, window), orbits.normal_force[window]
    return caption, *path, filtered(report, window)


def contact(report, title):
    """The rub strip: contact share, normal force, slip and friction power over the run."""
    strip, along = report.strip, Abscissa(report)
    return plots.plot_contact(
        along.of(strip),
        strip.share,
        strip.normal_force,
        strip.slip_velocity,
        strip.friction_power,
        title=title,
        x_label=along.title,
    )


def once_a_turn(report, title):
    """Distance at each revolution of the shaft over the run."""
    along, (windows, distances) = Abscissa(report), distances_once_a_turn(report, MOST_TURNS)
    gap = report.result.scene.contact.gap
    return plots.plot_once_a_turn(along.of_windows[windows], distances, gap=gap, title=title, x_label=along.title)


def _direction(result):
    first, last = result.scene.drive.speed[0], result.scene.drive.speed[-1]
    if first == last:
        return f"run at {first:g} Hz"
    return f"run-{'up' if last > first else 'down'} {first:g} to {last:g} Hz"


def _band(report):
    """Frequencies worth drawing: the simulated lines, the stable whirls and +-1X."""
    top = float(np.abs(report.fall.speed).max())
    lines = [np.abs(seen_lines(report))]
    lines += [np.abs(b.frequency[b.stable]) for b in report.branches if b.stable.any()]
    low = max(float(np.nanmax(line)) if not np.isnan(line).all() else 0.0 for line in lines)
    reach = 1.15 * max(top, low)
    return (-reach, reach)
