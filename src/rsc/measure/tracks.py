"""Backward lines of a run joined over its windows: `track_lines(result)`."""

import numpy as np

from rsc.arguments import REAL, RUN, optional, takes
from rsc.measure.features import RunLike, waterfall
from rsc.measure.spectra import Line, Peaks, spectral_peaks
from rsc.presented import BriefList

# strongest lines of a window that are looked at
LINES = 2
# a line belongs to a track within as many bins of where it was last: two closer lines are one peak of a Hann window
REACH = 2.0
# windows for which a line may be absent without ending its track
ABSENT = 1


@takes(result=RUN, window=optional(REAL))
def track_lines(result: RunLike, window: float | None = None) -> BriefList[Line]:
    """Follow the strongest and the second backward line of every window through a run.

    A line goes on in the next window where it lies within two bins of where it was; which of the two is stronger may change. It
    may be absent from one window. A line of a single window is no track.

    Parameters
    ----------
    result : Trajectory
    window : float, s, optional
        Default: chosen from the run-up rate so that a line stays within one bin.

    Returns
    -------
    list of rsc.measure.spectra.Line
        Speed, time, frequency (Hz, negative) and amplitude (m, of the contacting rotor coordinate), (n_w,) each, NaN in the
        windows without the line. By the window where they begin, of the same one the stronger first.

    Raises
    ------
    DataError
        A window that does not fit the run; says why.

    Examples
    --------
    >>> lines = rsc.track_lines(rsc.simulate(rsc.load_scene("laval.toml")))
    >>> print(f"{lines[0].frequency[0]:.1f} Hz")
    -60.7 Hz
    """
    fall = waterfall(result, window=window)
    peaks, reach = spectral_peaks(fall, side="negative", count=LINES), REACH / fall.window
    tracks: list[list[tuple[int, int]]] = []  # (window, place among the peaks) of every line
    for i, frequencies in enumerate(peaks.frequency):
        alive = [track for track in tracks if track[-1][0] >= i - 1 - ABSENT]
        places = np.flatnonzero(np.isfinite(frequencies)).tolist()
        distances = [(abs(frequencies[k] - peaks.frequency[track[-1]]), j, k) for j, track in enumerate(alive) for k in places]
        for distance, j, k in sorted(distances):
            if distance <= reach and k in places and alive[j][-1][0] < i:
                alive[j].append((i, k))
                places.remove(k)
        tracks += [[(i, k)] for k in places]
    return BriefList(_line(peaks, track) for track in tracks if len(track) > 1)


def _line(peaks: Peaks, track: list[tuple[int, int]]) -> Line:
    """The Line through the peaks of a track."""
    places = tuple(np.array(track).T)
    frequency, amplitude = np.full((2, len(peaks.time)), np.nan)
    frequency[places[0]], amplitude[places[0]] = peaks.frequency[places], peaks.amplitude[places]
    return Line(peaks.speed, peaks.time, frequency, amplitude)
