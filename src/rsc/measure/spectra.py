"""Two-sided spectra of a complex orbit r = y + i z: arrays in, arrays out.

Conventions. A circle A e^{i 2 pi f t} reads A at +f and nothing at -f: forward whirl is the positive,
backward whirl the negative half, and neither is ever folded onto the other. The window is the periodic Hann
window w_n = (1 - cos(2 pi n / N)) / 2, symmetric about sample N/2, which is the instant a window's time and
speed belong to. Its response to a line x bins away from a bin is, for every N, e^{-i pi x} R_N(x) with R_N
real (`_hann_response`); because R_N is known exactly, frequency and amplitude between bins follow from three
neighbouring bins without the large-N approximation.
"""

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rsc.arguments import FALL, REAL, REALS, SIGNAL, TEXT, WHOLE, optional, takes
from rsc.errors import DataError
from rsc.measure.window_length import checked_signal, window_duration, window_samples, window_starts
from rsc.presented import Brief, drawing

Side = Literal["negative", "positive"]  # backward, forward
MOST_LINES = 1000  # of a window


@dataclass(frozen=True, eq=False, repr=False)
class Waterfall(Brief):
    """Amplitude spectra of consecutive windows.

    Attributes
    ----------
    frequency : (n_f,) float64, Hz, signed, ascending, spaced by 1 / window
    speed, time : (n_w,) float64, Hz and s, at the centre of each window
    amplitude : (n_w, n_f) float64, m (or the signal's unit); NaN in a window that holds a non-finite sample
    window : float, s, length of a window
    n_samples : int, samples in a window; equal to n_f unless the band was cut by `f_max`
    """

    frequency: NDArray[np.float64]
    speed: NDArray[np.float64]
    time: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    window: float
    n_samples: int

    def plot(self, ax: Any = None, **style: Any) -> Any:
        """Draw the amplitudes over whirl frequency and rotor speed (over time where the speed turns back).

        ax : matplotlib axes, by default those of a new figure; style : properties of lines of matplotlib. Returns the axes.
        """
        return drawing().spectra(self, ax, style)

    def plot_cascade(self, ax: Any = None, **style: Any) -> Any:
        """Draw stacked spectra, each on its place along the run; arguments and result as `plot`."""
        return drawing().cascade(self, ax, style)


@dataclass(frozen=True, eq=False, repr=False)
class Peaks(Brief):
    """The strongest lines of each window on one side, strongest first, NaN where there is none.

    Attributes
    ----------
    speed, time : (n_w,) Hz and s, at the window centre
    frequency, amplitude : (n_w, count) Hz (negative on the negative side) and m, interpolated between bins
    side : "negative" (backward) or "positive" (forward)
    """

    speed: NDArray[np.float64]
    time: NDArray[np.float64]
    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    side: Side


@dataclass(frozen=True, eq=False, repr=False)
class Line(Brief):
    """One line followed through the windows: speed, time, frequency, amplitude, each (n_w,); NaN where it is
    absent."""

    speed: NDArray[np.float64]
    time: NDArray[np.float64]
    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]


@takes(time=REALS, signal=SIGNAL, speed=REALS, window=optional(REAL), overlap=REAL, f_max=optional(REAL))
def waterfall(
    time: ArrayLike,
    signal: ArrayLike,
    speed: ArrayLike,
    window: float | None = None,
    overlap: float = 0.5,
    f_max: float | None = None,
) -> Waterfall:
    """Two-sided amplitude spectra of consecutive Hann windows.

    A trailing part of the signal shorter than one hop is not seen.

    Parameters
    ----------
    time : (n_time,) s, uniformly spaced
    signal : (n_time,) complex m
    speed : (n_time,) Hz
    window : float, s, or None: `window_duration` for the steepest part of `speed`
    overlap : float in [0, 1), share of a window that the next one repeats
    f_max : float, Hz, or None: keep |f| <= f_max only

    Returns
    -------
    Waterfall

    Raises
    ------
    DataError
        If the arrays do not fit, the samples are not uniform, or the window is longer than the run, shorter
        than 8 samples or not finite.
    """
    time, signal, speed, sample_rate = checked_signal(time, signal, speed)
    if window is None:
        steepest = float(np.max(np.abs(np.diff(speed)))) * sample_rate
        window = window_duration(steepest, (time.size - 1) / sample_rate, sample_rate)
    n_samples = window_samples(window, sample_rate, time.size)
    if not 0 <= overlap < 1:
        raise DataError("<signal>", f"overlap {overlap} must be in [0, 1)")
    starts = window_starts(n_samples, time.size, overlap)
    frequency = frequencies(n_samples, sample_rate)
    band = slice(None)
    if f_max is not None:
        inside = np.flatnonzero(np.abs(frequency) <= f_max * (1 + 1e-12))
        if inside.size < 3:
            raise DataError("<signal>", f"f_max {f_max} Hz keeps fewer than 3 bins of {1 / window:.4g} Hz")
        band = slice(inside[0], inside[-1] + 1)
    amplitude = amplitudes(signal, starts, n_samples, band)
    frequency = frequency[band]
    centre = time[starts] + n_samples / 2 / sample_rate
    speed = np.interp(centre, time, speed)
    return Waterfall(frequency, speed, centre, amplitude, n_samples / sample_rate, n_samples)


def frequencies(n_samples: int, sample_rate: float) -> NDArray[np.float64]:
    """(n_samples,) Hz, signed and ascending, of the bins of a window."""
    return np.fft.fftshift(np.fft.fftfreq(n_samples, 1 / sample_rate))


def weights(n_samples: int) -> NDArray[np.float64]:
    """(n_samples,) Hann window, scaled so that a circle of radius A reads A: its sum is 1."""
    return (1 - np.cos(2 * np.pi * np.arange(n_samples) / n_samples)) / n_samples


def amplitudes(
    signal: NDArray[np.complex128], starts: NDArray[np.intp], n_samples: int, band: slice = slice(None)
) -> NDArray[np.float64]:
    """(n_w, n_f) amplitudes of the windows of a signal, of a band of their bins; NaN where a sample is not finite."""
    window = weights(n_samples)
    amplitude = np.empty((starts.size, len(range(n_samples)[band])))
    for i_w, start in enumerate(starts):
        piece = signal[start : start + n_samples]
        if np.isfinite(piece).all():
            amplitude[i_w] = np.abs(np.fft.fftshift(np.fft.fft(piece * window))[band])
        else:
            amplitude[i_w] = np.nan
    return amplitude


def without_means(fall: Waterfall, signal: NDArray[np.complex128], starts: NDArray[np.intp]) -> Waterfall:
    """A waterfall of all its bins from which the mean of each window, weighted as the window is, is taken out.

    A constant is seen by a Hann window in three bins alone: 1 at 0 Hz and -1/2 beside it. A line within two bins of 0 Hz has a
    mean of its own and loses that as well.

    Parameters
    ----------
    fall : Waterfall
    signal : (n_time,) complex m, from which it was made; starts : (n_w,) the first sample of each window

    Returns
    -------
    Waterfall
    """
    zero, hann = fall.n_samples // 2, weights(fall.n_samples)
    turn = np.exp(2j * np.pi * np.arange(fall.n_samples) / fall.n_samples)
    lines = np.stack([hann, hann * turn.conj(), hann * turn])
    mean, above, below = np.array([lines @ signal[start : start + fall.n_samples] for start in starts.tolist()]).T
    amplitude = fall.amplitude.copy()
    known = np.isfinite(amplitude[:, zero])
    amplitude[known, zero] = 0.0
    amplitude[known, zero + 1] = np.abs(above + 0.5 * mean)[known]
    amplitude[known, zero - 1] = np.abs(below + 0.5 * mean)[known]
    return replace(fall, amplitude=amplitude)


@takes(fall=FALL, side=TEXT, count=WHOLE, floor_db=REAL, floor=REAL)
def spectral_peaks(
    fall: Waterfall, *, side: Side = "negative", count: int = 3, floor_db: float = -60.0, floor: float = 0.0
) -> Peaks:
    """The strongest lines of each window on one side of the spectrum.

    A line is a local maximum of the amplitude; its frequency and amplitude come from the three bins around it
    and the exact response of the Hann window, so that a pure tone is read to rounding wherever it lies
    between bins. A line closer than half a bin to 0 Hz cannot be told from a static deflection and belongs to
    neither side.

    Parameters
    ----------
    fall : Waterfall
    side : "negative" (backward) or "positive" (forward)
    count : int, lines per window at most
    floor_db : float, dB, lines weaker than this against the window's largest amplitude (of both sides) are
        not given
    floor : float, m, lines weaker than this are not given

    Returns
    -------
    Peaks

    Raises
    ------
    DataError
        If side or count is none of the allowed.
    """
    if side not in ("negative", "positive") or not 1 <= count <= MOST_LINES:
        raise DataError("<signal>", f"side {side!r} must be 'negative' or 'positive', count {count} from 1 to {MOST_LINES}")
    sign = -1 if side == "negative" else 1
    # a bin reads at worst 15 % less than its line; the exact level is that of the strongest line
    rough = 0.8 * np.maximum(fall.amplitude.max(axis=1, initial=0.0) * 10 ** (floor_db / 20), floor)
    window, lines, height = _lines(fall, fall.amplitude >= rough[:, None])
    strongest = np.zeros(fall.speed.size)
    np.maximum.at(strongest, window, height)
    level = np.maximum(strongest * 10 ** (floor_db / 20), floor)
    use = (sign * lines > 0) & (np.abs(lines) >= 0.5 / fall.window * (1 - 1e-9)) & (height >= level[window])
    window, lines, height = window[use], lines[use], height[use]
    order = np.lexsort((-height, window))
    window, lines, height = window[order], lines[order], height[order]
    place = np.arange(window.size) - np.searchsorted(window, window)  # among the lines of its window
    best = place < count
    frequency, amplitude = np.full((2, fall.speed.size, count), np.nan)
    frequency[window[best], place[best]] = lines[best]
    amplitude[window[best], place[best]] = height[best]
    return Peaks(fall.speed, fall.time, frequency, amplitude, side)


def line_at(fall: Waterfall, frequency: ArrayLike, reach: float | None = None) -> Line:
    """Follow one line: in each window the strongest local peak within `reach` of a given frequency.

    Strongest, not nearest, because beside a line the nearest local maximum is often noise.

    Parameters
    ----------
    fall : Waterfall
    frequency : float or (n_w,) Hz, signed; `fall.speed` for the synchronous line; NaN where nothing is
        expected
    reach : float, Hz, or None: two bins, half the main lobe of the Hann window

    Returns
    -------
    Line
        NaN where no local peak lies within reach.
    """
    target = np.broadcast_to(np.asarray(frequency, float), fall.speed.shape)
    reach = 2 / fall.window if reach is None else reach
    read = np.full((2, fall.speed.size), np.nan)
    window, lines, height = _lines(fall, np.abs(fall.frequency - target[:, None]) <= reach + 1 / fall.window)
    near = np.abs(lines - target[window]) <= reach
    window, lines, height = window[near], lines[near], height[near]
    order = np.lexsort((height, window))  # the strongest of a window is its last
    read[:, window[order]] = lines[order], height[order]
    return Line(fall.speed, fall.time, read[0], read[1])


def _lines(
    fall: Waterfall, candidate: NDArray[np.bool_]
) -> tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64]]:
    """Window, frequency (Hz) and amplitude of the local maxima of all spectra among the candidate bins (n_w, n_f)."""
    rows, n_f = fall.amplitude, fall.frequency.size
    if n_f != fall.n_samples:  # a cut band has no neighbours at its ends; the whole band is a ring
        candidate[:, [0, -1]] = False
    window, k = np.nonzero(candidate)
    left, middle, right = rows[window, k - 1], rows[window, k], rows[window, (k + 1) % n_f]
    is_peak = (middle > left) & (middle >= right)  # one of two equal neighbours only
    window, k = window[is_peak], k[is_peak]
    offset, amplitude = _between_bins(left[is_peak], middle[is_peak], right[is_peak], fall.n_samples)
    frequency = fall.frequency[k] + offset / fall.window
    band = fall.n_samples / fall.window
    frequency = np.where(frequency < -0.5 * band, frequency + band, frequency)
    return window, np.where(frequency >= 0.5 * band, frequency - band, frequency), amplitude


def _between_bins(
    left: NDArray[np.float64], middle: NDArray[np.float64], right: NDArray[np.float64], n_samples: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Offset (bins) and amplitude of the line behind a bin and its two neighbours (magnitudes).

    2 (right - left) / (left + 2 middle + right) is the offset itself for N -> infinity and differs from it by
    O(1/N^2) otherwise, so that a few fixed-point steps on the same ratio of the exact response suffice. The
    sum in the denominator acts like a squared Hann window: other lines leak into it with the fifth power of
    the distance.
    """
    weight = left + 2 * middle + right
    ratio = 2 * (right - left) / weight
    offset = ratio
    for _ in range(3):
        lower, centre, upper = (_hann_response(shift - offset, n_samples) for shift in (-1, 0, 1))
        model_weight = lower + 2 * centre + upper
        offset = offset + ratio - 2 * (upper - lower) / model_weight
    lower, centre, upper = (_hann_response(shift - offset, n_samples) for shift in (-1, 0, 1))
    return offset, weight / (lower + 2 * centre + upper)


def _hann_response(x: NDArray[np.float64], n_samples: int) -> NDArray[np.float64]:
    """R_N(x), the reading of a bin from a unit line x bins away: 1 at 0, positive for |x| < 2, exact for every N."""
    total = np.zeros(np.shape(x))
    for shift, share in ((0, 1.0), (-1, 0.5), (1, 0.5)):
        y = x + shift
        total = total + share * np.sinc(y) / np.sinc(y / n_samples) * np.cos(np.pi * y / n_samples)
    return total
