"""Lines of the second engine's motion by a padded FFT and a parabola, and the rows of a report judged by them."""

import numpy as np

from rsc.measure import spectra
from rsc.measure.reasons import Code
from rsc.measure.verdict import ALONE
from rsc.measure.words import AGREES, TOLERANCES
from rsc.show.words.reasons import note

PADDING, MOST_LINES, NEAR_BINS = 8, 60, 2.0
OFF_LINE = 0.15  # bins: a line further from where it should be is not it alone
BAND = 3  # bins on either side of a line that belong to it
SIDE_LOBE = 10.0 ** (-31.5 / 20.0)  # of a Hann window, the first, 2.36 bins away; they fall with the third power of the distance
SLACK = 1.5  # tolerances of the comparison times this: both sides read lines from windows
BIN_ERROR = 0.05  # bins, of a line that least squares read from a window
GRAZE = 0.02  # share of a window in contact up to which the engines may differ on whether it touches at all
GROWTH = 5.0  # between quarters of a window


def lines(piece, sample_rate, chirp=0.0):
    """(frequency, amplitude) of the lines of a piece of a complex signal, strongest first; a circle of radius A reads A.

    Hann window, zeros behind, a parabola through the logarithms of three points; local maxima that may be side lobes of stronger
    lines are left out. chirp: of a line that moves, its change over the piece in bins; its frequency is that in the middle.
    """
    n = len(piece)
    window = np.hanning(n + 1)[:n]
    tau = (np.arange(n) - 0.5 * n) / n
    turned = piece * window * np.exp(-1j * np.pi * chirp * tau**2) if chirp else piece * window
    amplitude = np.abs(np.fft.fftshift(np.fft.fft(turned, PADDING * n))) / window.sum()
    frequency = np.fft.fftshift(np.fft.fftfreq(PADDING * n, 1.0 / sample_rate))
    i = 1 + np.flatnonzero((amplitude[1:-1] > amplitude[:-2]) & (amplitude[1:-1] >= amplitude[2:]))
    i = i[np.argsort(-amplitude[i])][:MOST_LINES]
    low, middle, high = (np.log(np.maximum(amplitude[i + k], 1e-300)) for k in (-1, 0, 1))
    bend = low - 2.0 * middle + high
    shift = np.where(bend < 0.0, 0.5 * (low - high) / np.where(bend < 0.0, bend, 1.0), 0.0)
    height = np.exp(middle - 0.25 * (low - high) * shift)
    place = frequency[i] + shift * (frequency[1] - frequency[0])
    real = height > 2.0 * np.tril(side_lobe(np.abs(place[:, None] - place) * n / sample_rate) * height, -1).sum(axis=1)
    return place[real], height[real]


def side_lobe(bins):
    """Height of the side lobes of a Hann window this many bins from a line, as a share of the line; within 2 bins that of the
    first."""
    return SIDE_LOBE * (2.36 / np.maximum(bins, 2.0)) ** 3


def line_near(piece, sample_rate, wanted, chirp):
    """(frequency, least and largest amplitude) of the strongest line next to a frequency; NaN where there is none.

    A line that grows, decays or moves during the window has no one amplitude: the least is the height of its peak, the largest
    what a line at rest with the power of the band around it has.
    """
    frequency, amplitude = lines(piece, sample_rate, chirp)
    near = np.flatnonzero(np.abs(frequency - wanted) <= max(NEAR_BINS * sample_rate / len(piece), 0.03 * abs(wanted)))
    if not near.size:
        return np.nan, np.nan, np.nan
    at, height = frequency[near[0]], amplitude[near[0]]
    n = len(piece)
    window = np.hanning(n + 1)[:n]
    turned = piece * window * np.exp(-2j * np.pi * at * np.arange(n) / sample_rate)
    power = np.abs(np.fft.fft(turned, PADDING * n)[np.r_[: BAND * PADDING + 1, -BAND * PADDING : 0]]) ** 2
    return at, height, max(height, np.sqrt(power.sum() / (PADDING * n * (window**2).sum())))


def synchronous_line(piece, phi):
    """(amplitude, its doubt) of the line that turns with the angle phi, (n,) rad.

    The doubt is what side lobes of other lines may add, and by how much a steeper window reads another amplitude: a motion that
    changes inside the window leaves something at every frequency. It is infinite where another line is too close to tell apart.
    """
    n = len(piece)
    window = np.hanning(n + 1)[:n]
    turned = piece * np.exp(-1j * phi)
    value, steeper = (abs((turned * own).sum()) / own.sum() for own in (window, window**2))
    frequency, amplitude = lines(turned, float(n))  # in bins, the wanted line at zero
    if not (np.abs(frequency) < OFF_LINE).any() or (np.abs(frequency[np.abs(frequency) >= OFF_LINE]) < 3.0).any():
        return value, np.inf
    others = np.abs(frequency) >= OFF_LINE
    return value, float((side_lobe(np.abs(frequency[others])) * amplitude[others]).sum()) + abs(value - steeper)


def chirps_of(windows, fall):
    """Bins by which the predicted line of each window moves during it, by the windows beside it on the same whirl."""
    whirl, moves = [window.frequency for window in windows], np.zeros(len(windows))
    for i in range(1, len(whirl) - 1):
        if whirl[i - 1].branch == whirl[i].branch == whirl[i + 1].branch != "":
            moves[i] = (whirl[i + 1].predicted - whirl[i - 1].predicted) / (fall.time[i + 1] - fall.time[i - 1]) * fall.window**2
    return moves


def judged(window, pieces, turning, rate, gap):
    """(kind, detail) of what is wrong in one window, judged by the other engine's motion; turning: (phi, chirp)."""
    phi, chirp = turning
    piece, bin_width = pieces["rotor"], rate / len(pieces["rotor"])
    whirl, size, synchronous = window
    tolerance = {name: SLACK * limit for name, limit in TOLERANCES.items()}
    if AGREES in (whirl.verdict, size.verdict):
        f, least, largest = line_near(piece, rate, whirl.predicted, chirp)
        allowed = tolerance[whirl.quantity] + BIN_ERROR * bin_width / abs(whirl.predicted)
        if whirl.verdict == AGREES and not abs(f / whirl.predicted - 1.0) <= allowed:
            yield "agrees in frequency, wrongly", told(whirl, f, bin_width)
        if size.has(Code.OF_STATOR):
            _, least, largest = line_near(pieces["stator"], rate, whirl.predicted, chirp)
        near = np.clip(size.predicted, least, largest)
        if size.verdict == AGREES and abs(near / size.predicted - 1.0) > tolerance[size.quantity]:
            yield "agrees in amplitude, wrongly", told(size, near, bin_width)
    if synchronous.verdict == AGREES and synchronous.predicted > 0.0:
        a, blur = synchronous_line(piece, phi) if synchronous.by != ALONE else (_peak(piece, rate, synchronous.speed), 0.0)
        if abs(a - synchronous.predicted) > tolerance[synchronous.quantity] * synchronous.predicted + 2.0 * blur:
            yield "agrees in the synchronous line, wrongly", told(synchronous, a, bin_width)
    touching = np.abs(pieces["distance"]) > gap
    if whirl.contact == 0.0 and touching.mean() > GRAZE:
        yield "contact that rsc has not", f"contact {100 * touching.mean():.0f} %"


def _peak(piece, rate, speed):
    """The line at the rotor speed as rsc reads it: past a resonance, where the rotor rings down, it is not of one phase."""
    fall = spectra.waterfall(np.arange(len(piece)) / rate, piece, np.full(len(piece), speed), window=len(piece) / rate)
    return float(np.nan_to_num(spectra.line_at(fall, speed).amplitude[0]))


def grows(piece):
    """Whether a motion grows or decays so much within a window that its spectrum has no lines."""
    quarters = [np.abs(part).max() for part in np.array_split(piece, 4)]
    return max(quarters) > GROWTH * min(quarters)


def told(row, value, bin_width):
    return (
        f"{row.quantity} predicted {row.predicted:.6g}, rsc {row.simulated:.6g}, other engine {value:.6g}, "
        f"bins of {bin_width:.3g} Hz, branch {row.branch!r}, {note(row)}"
    )
