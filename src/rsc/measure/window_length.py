"""Windows of a signal that is sampled evenly: how long they may be, where they begin, and what a line that moves in one loses."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rsc.errors import DataError

# A line swept by a Hz/s during a window of T s stays within one bin, and loses 0.7 % of its amplitude at
# most, for a T^2 = 1.
SWEEP_LIMIT = 1.0
# Windows a run is cut into at least, before overlap, so that a result at constant speed still shows a course
# in time.
MIN_WINDOWS = 8
# Samples of a window at most: a finer spectrum would show nothing more of a motion, and take memory.
MAX_SAMPLES = 2**17
# An FFT likes numbers of samples without larger prime factors.
MOST_FACTOR = 11
# Below this a Hann main lobe (four bins) is a large part of the band and a spectrum says nothing.
MIN_SAMPLES = 16


def window_duration(run_up_rate: float, duration: float, sample_rate: float) -> float:
    """Length of a spectral window that does not smear a line swept by the run-up.

    Rule: T = 1 / sqrt(|run_up_rate|), so that |run_up_rate| T^2 <= 1, but at most an eighth of the run (this
    alone decides at constant speed), at most 131072 samples, and at least 16 (or the whole run, if shorter); then shortened to
    the next number of samples that an FFT likes. Only the floor of 16 samples can push |run_up_rate| T^2
    above 1: `sweep_loss` gives its price.

    Parameters
    ----------
    run_up_rate : float, Hz/s, of either sign; 0 at constant speed
    duration : float, s, length of the run
    sample_rate : float, Hz

    Returns
    -------
    float, s, a whole number of sample intervals

    Raises
    ------
    DataError
        If a value is not finite, or duration or sample_rate is not positive.
    """
    values = (run_up_rate, duration, sample_rate)
    if not all(math.isfinite(value) for value in values) or duration <= 0 or sample_rate <= 0:
        raise DataError("<signal>", f"no window for run-up rate, duration and sample rate {values}")
    longest = duration / MIN_WINDOWS
    rate = abs(run_up_rate)
    if rate * longest**2 > SWEEP_LIMIT:
        longest = math.sqrt(SWEEP_LIMIT / rate)
    available = round(duration * sample_rate) + 1
    # a millionth more, so that rounding in a measured rate or duration does not cost the best length
    n_samples = max(min(int(longest * sample_rate * (1 + 1e-6)), MAX_SAMPLES), min(MIN_SAMPLES, available), 1)
    while _largest_factor(n_samples) > MOST_FACTOR:
        n_samples -= 1
    return n_samples / sample_rate


def _largest_factor(number: int) -> int:
    """Largest prime factor of a number up to `MOST_FACTOR`, or the remaining cofactor."""
    largest = 1
    for factor in (2, 3, 5, 7, MOST_FACTOR):
        while number % factor == 0:
            number, largest = number // factor, factor
    return max(number, largest)


def sweep_loss(run_up_rate: float, window: float) -> float:
    """Part of a synchronous line's amplitude lost because the line moves during a Hann window.

    The line sweeps by run_up_rate * window during the window; the loss 1 - |int w e^{i pi a t^2} dt| / int w
    dt at the centre of the swept line depends on q = |a| T^2 only: 0.7 % at 1, 2 % at 1.7, 24 % at 6.6, 61 %
    at 26. Lines read by `spectral_peaks` and `line_at` lose less, for their three bins gather part of the
    spread amplitude.

    Parameters
    ----------
    run_up_rate : float, Hz/s
    window : float, s

    Returns
    -------
    float in [0, 1)
    """
    q = abs(run_up_rate) * window**2
    if q > 1e4:  # stationary phase: within 1e-4 of the integral, which would need ever more points
        return 1 - 2 / math.sqrt(q)
    u = np.linspace(-0.5, 0.5, 401 + 32 * math.ceil(q))
    response = (1 + np.cos(2 * np.pi * u)) * np.exp(1j * np.pi * q * u**2)
    # the window and its slope vanish at both ends, so that the plain sum is a trapezoidal rule of high order
    return max(0.0, 1 - abs(response.sum()) / (u.size - 1))


def window_samples(window: float, sample_rate: float, n_time: int) -> int:
    """Samples of a window in s; DataError for fewer than 8 or a window longer than the run."""
    return samples_of_window(window, sample_rate, n_time, 8)


def window_starts(n_samples: int, n_time: int, overlap: float = 0.5, most: int | None = None) -> NDArray[np.intp]:
    """(n_w,) numbers of the first samples of windows that overlap; where there were more than `most` they stand further apart."""
    hop = max(1, round(n_samples * (1 - overlap)))
    if most is not None:
        hop = max(hop, -(-(n_time - n_samples) // most))
    return np.arange(0, n_time - n_samples + 1, hop)


def checked_signal(
    time: ArrayLike, signal: ArrayLike, speed: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.complex128], NDArray[np.float64], float]:
    """Arrays as the functions need them, and the sample rate; arrays that do not fit or are not uniform are refused."""
    time, signal, speed = np.asarray(time, float), np.asarray(signal), np.asarray(speed, float)
    if time.ndim != 1 or signal.shape != time.shape or speed.shape != time.shape or time.size < 2:
        shapes = f"{time.shape}, {signal.shape}, {speed.shape}"
        raise DataError("<signal>", f"time, signal, speed must be (n,) with n >= 2, not {shapes}")
    step = (time[-1] - time[0]) / (time.size - 1)
    if not step > 0 or not np.isfinite(step):
        raise DataError("<signal>", f"time runs from {time[0]} to {time[-1]} s and must increase")
    stray = np.abs(time - (time[0] + step * np.arange(time.size)))
    if not stray.max() <= 1e-3 * step:  # written so that a NaN is refused as well
        i_bad = int(np.argmax(stray))
        raise DataError("<signal>", f"sample {i_bad} at {time[i_bad]} s is not uniform in time")
    return time, signal, speed, float(1 / step)


def samples_of_window(window: float, sample_rate: float, n_time: int, n_least: int) -> int:
    """Window length in samples; refuses one that does not fit the run."""
    window = float(window)
    if not math.isfinite(window * sample_rate) or round(window * sample_rate) < n_least:
        raise DataError("<signal>", f"window {window} s must hold {n_least} samples or more, and no more than the run")
    n_samples = round(window * sample_rate)
    if n_samples > n_time:
        run = n_time / sample_rate
        raise DataError("<signal>", f"window {window:.6g} s is longer than the run, {run:.6g} s")
    return n_samples
