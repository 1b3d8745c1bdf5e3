"""Pictures of a report as figures and files."""

from pathlib import Path

import numpy as np

from rsc.errors import one_line
from rsc.files.mark import GIF
from rsc.files.output import OutputFile, put_all
from rsc.show.pictures import paths, pictures, plots
from rsc.show.pictures.abscissa import Abscissa
from rsc.show.pictures.album import PICTURES, described
from rsc.show.pictures.moments import moments
from rsc.show.words.units import largest_finite, unit_for

ORBIT, ANIMATION = "orbit.png", "orbit.gif"
FRAMES = 60  # of an animation
MANY = 0.6  # height of each of several pictures of a file


def draw(report, folder):
    """Write every picture of one report into a folder that exists; returns the list of the files written."""
    files = picture_files(report, folder)
    put_all(files)
    return [file.path for file in files]


def names(animated=False):
    """Names of all files that the pictures of a report may have."""
    drawn = dict.fromkeys(f"{entry.file}.png" for entry in PICTURES.values() if entry.file)
    return [*drawn, ORBIT, *([ANIMATION] if animated else [])]


def picture_files(report, folder):
    """The files of every picture of one report, to be written by `rsc.files.output.put_all`.

    Parameters
    ----------
    report : rsc.study.report.check.Report
    folder : Path

    Returns
    -------
    list of rsc.files.output.OutputFile
    """
    title, drawn = one_line(report.result.scene.title), described(report, Abscissa(report), on_page=False)
    figures = {f"{file}.png": _figure(file, drawn, title) for file in dict.fromkeys(PICTURES[name].file for name in drawn)}
    figures[ORBIT] = plots.side_by_side(paths.moments(report, moments(report)), title)
    return [plots.picture_file(figure, Path(folder) / name) for name, figure in figures.items()]


def _figure(file, drawn, title):
    """The figure of a file: paths side by side, other pictures above each other."""
    own = {name: picture for name, picture in drawn.items() if PICTURES[name].file == file}
    if all(picture["layout"].get("equal") for picture in own.values()):
        return plots.side_by_side([(PICTURES[name].title, picture) for name, picture in own.items()], title)
    titles = [title, *(PICTURES[name].title for name in own if PICTURES[name].title)]
    return plots.stacked(list(own.values()), ": ".join(titles), MANY if len(own) > 1 else 1.0)


def campbell(report, title, fall=None):
    """Figures 3 and 5 of the paper: spectra over rotor speed with natural frequencies and predicted whirls.

    `fall` : spectra.Waterfall, or None for the rotor's
    """
    return plots.stacked([pictures.campbell(report, Abscissa(report), fall)], title)


def amplitude(reports, title):
    """Figures 4 and 6: envelopes of one or more runs of a scene with the predicted amplitudes of the first."""
    return plots.stacked([pictures.amplitude(reports[0], Abscissa(reports[0]), reports[1:])], title)


def animation(report, path):
    """The GIF of `frames` as a file to be written."""
    return OutputFile(Path(path), plots.film(*frames(report)), GIF)


def frames(report):
    """Paths in windows all along a run, the title of the run, and how far their axes reach."""
    windows = np.unique(np.linspace(0, len(report.fall.speed) - 1, FRAMES).round().astype(int))
    largest = max(largest_finite(np.abs(report.orbits.rotor)), report.contact.gap)
    reach = 1.05 * largest * unit_for(largest, "m")[0]
    return [paths.orbit(report, window) for window in windows.tolist()], one_line(report.result.scene.title), reach
