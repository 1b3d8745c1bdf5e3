"""The spectra and envelopes of a run: what spectra.py does, applied to the contacting rotor coordinate of a Trajectory."""

from rsc import spectra


def waterfall(result, window=None, f_max=None):
    """Two-sided amplitude spectra of the contacting rotor coordinate over the run.

    Parameters
    ----------
    result : Trajectory
    window : float, s, optional; chosen from the run-up rate by default so that a line stays within one bin.
    f_max : float, Hz, optional; keep only |frequency| <= f_max.

    Returns
    -------
    spectra.Waterfall
    """
    return spectra.waterfall(result.time, result.contact_rotor(), result.speed, window=window, f_max=f_max)


def spectral_peaks(result, side="negative", count=3, window=None):
    """The strongest lines of each window on one side, interpolated between bins; see `spectra.spectral_peaks`."""
    return spectra.spectral_peaks(waterfall(result, window=window), side=side, count=count)


def envelope(result, window=None):
    """Smallest and largest |r| at the contacting rotor coordinate per window; see `spectra.envelope`."""
    if window is None:
        window = default_window(result)
    return spectra.envelope(result.time, result.contact_rotor(), result.speed, window)


def default_window(result):
    """Window length in s that a run's spectra use unless told otherwise."""
    drive = result.scene.drive
    corners = list(zip(drive.time, drive.speed, strict=True))
    rates = [abs((f1 - f0) / (t1 - t0)) for (t0, f0), (t1, f1) in zip(corners, corners[1:], strict=False)]
    time = result.time
    return spectra.window_duration(max(rates), float(time[-1] - time[0]), result.scene.output.rate)
