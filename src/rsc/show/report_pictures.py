"""Pictures of a report as figures and files."""

from pathlib import Path

import numpy as np

from rsc.errors import one_line
from rsc.files.output import put
from rsc.show import paths, pictures, plots
from rsc.show.abscissa import Abscissa
from rsc.show.moments import moments
from rsc.show.units import largest_finite, unit_for

FRAMES = 60  # of an animation
MOST_TURNS = 400  # windows whose positions once a revolution are drawn
STRIPS = ("share", "force", "slip", "power")


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
    title, along, strips = one_line(report.result.scene.title), Abscissa(report), pictures.strips(report, Abscissa(report))
    figures = {
        "campbell": campbell(report, title),
        "waterfall": plots.stacked([pictures.waterfall(report, along)], title),
        "amplitude": amplitude([report], title),
        "orbit": plots.side_by_side(paths.moments(report, moments(report)), title),
        "contact": plots.stacked([strips[name] for name in STRIPS if name in strips], title, 0.6),
        "once_a_turn": plots.stacked([paths.once_a_turn(report, along, MOST_TURNS)], title),
    }
    if (centre := paths.centre_line(report)) is not None:
        figures["centre_line"] = plots.side_by_side([("mean position of the windows", centre)], title)
    if report.stator_fall is not None and np.any(report.stator_fall.amplitude > 0.0):
        figures["campbell_stator"] = campbell(report, f"{title}: motion of the stator", report.stator_fall)
    files = {name: Path(folder) / f"{name}.png" for name in figures}
    for name, figure in figures.items():
        plots.save(figure, files[name])
    return list(files.values())


def campbell(report, title, fall=None):
    """Figures 3 and 5 of the paper: spectra over rotor speed with natural frequencies and predicted whirls.

    `fall` : spectra.Waterfall, or None for the rotor's
    """
    return plots.stacked([pictures.campbell(report, Abscissa(report), fall)], title)


def amplitude(reports, title):
    """Figures 4 and 6: envelopes of one or more runs of a scene with the predicted amplitudes of the first."""
    return plots.stacked([pictures.amplitude(reports[0], Abscissa(reports[0]), reports[1:])], title)


def animation(report, path):
    """Write the paths of windows all along a run, one after the other, as a GIF."""
    windows = np.unique(np.linspace(0, len(report.fall.speed) - 1, FRAMES).round().astype(int))
    largest = max(largest_finite(np.abs(report.orbits.rotor)), report.result.scene.contact.gap)
    frames = (paths.orbit(report, window) for window in windows.tolist())
    put(path, plots.film(frames, one_line(report.result.scene.title), 1.05 * largest * unit_for(largest, "m")[0]), b"GIF8")
    return path
