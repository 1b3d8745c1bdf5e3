"""Lines joined over the windows of a run: made-up motions whose lines are known."""

from types import SimpleNamespace

import numpy as np
import pytest

from rsc.errors import DataError
from rsc.measure.tracks import track_lines

RATE, WINDOW = 500.0, 0.5
TIME = np.arange(0.0, 8.0, 1.0 / RATE)


def run_of(*lines):
    """A run at rising speed whose motion is the sum of lines (frequency Hz, amplitude m), each a number or (n_time,)."""
    motion = sum(amplitude * np.exp(2j * np.pi * np.cumsum(frequency + 0.0 * TIME) / RATE) for frequency, amplitude in lines)
    return SimpleNamespace(time=TIME, speed=20.0 + TIME, contact_rotor=lambda: motion)


def test_two_lines_keep_their_tracks_while_the_other_becomes_the_stronger():
    falling, rising = 2e-3 * np.exp(-0.5 * TIME), 1e-4 * np.exp(0.5 * TIME)
    moving = -40.0 - 0.5 * TIME
    tracks = track_lines(run_of((moving, falling), (-60.0, rising), (35.0, 5e-3)), window=WINDOW)
    assert len(tracks) == 2  # the stronger first; the forward line is none
    for track, frequency, amplitude in zip(tracks, (moving, -60.0 + 0.0 * TIME), (falling, rising), strict=True):
        assert track.frequency == pytest.approx(np.interp(track.time, TIME, frequency), abs=0.02)
        assert track.amplitude == pytest.approx(np.interp(track.time, TIME, amplitude), rel=0.02)
        assert track.speed == pytest.approx(20.0 + track.time)
    assert tracks[0].amplitude[0] > tracks[1].amplitude[0] and tracks[0].amplitude[-1] < tracks[1].amplitude[-1]


def test_a_line_that_jumps_is_two_tracks_and_one_that_pauses_is_one():
    jumping = np.where(TIME < 4.0, -40.0, -70.0)
    before, after = track_lines(run_of((jumping, 1e-3)), window=WINDOW)
    assert np.nanmean(before.frequency) == pytest.approx(-40.0, abs=0.1)
    assert np.nanmean(after.frequency) == pytest.approx(-70.0, abs=0.1)
    assert np.isfinite(before.frequency).sum() + np.isfinite(after.frequency).sum() >= len(before.time)
    assert before.time[np.isfinite(before.frequency)].max() <= 4.0 + WINDOW and np.isfinite(after.amplitude[-1])
    # one window, whose centre is a multiple of a quarter of a second, is without the line of -55 Hz
    for length, count in ((0.5, 1), (1.0, 2)):
        pausing = np.where(np.abs(TIME - 4.0) < 0.5 * length, 0.0, 1e-3)
        tracks = track_lines(run_of((-30.0, 4e-3), (-55.0, pausing)), window=WINDOW)
        near = [track for track in tracks if abs(np.nanmean(track.frequency) + 55.0) < 1.0]
        assert len(near) == count
        assert sum(np.isnan(track.frequency).sum() for track in near) > 0


def test_a_line_goes_on_where_it_is_nearest():
    """Two lines 2.5 bins apart that move by up to a bin from window to window: each comes close to where the other one was."""
    sweep = -6.0 * TIME
    falling, rising = 2e-3 * np.exp(-0.4 * TIME), 2e-4 * np.exp(0.4 * TIME)
    tracks = track_lines(run_of((-45.0 + sweep, falling), (-40.0 + sweep, rising)), window=WINDOW)
    long = [track for track in tracks if np.isfinite(track.frequency).sum() > 10]
    assert len(long) == 2
    for track, begin in zip(long, (-45.0, -40.0), strict=True):
        seen = np.isfinite(track.frequency)
        assert track.frequency[seen] == pytest.approx(begin - 6.0 * track.time[seen], abs=1.0)


def test_what_is_seen_in_one_window_only_is_no_track_and_joins_none():
    click = np.where(np.abs(TIME - 4.0) < 0.01, 0.3e-3, 0.0)
    (track,) = track_lines(run_of((-40.0, 1e-3), (-80.0, click)), window=WINDOW)
    assert np.nanmean(track.frequency) == pytest.approx(-40.0, abs=0.1)
    # a line that begins a window after another has ended is not its continuation
    silent = np.abs(TIME - 4.0) < 0.5 * WINDOW
    lines = np.where(silent, 0.0, 1e-3)
    tracks = track_lines(run_of((np.where(TIME < 4.0, -40.0, -70.0), lines), (50.0, 1e-3)), window=WINDOW)
    assert [np.nanmean(track.frequency) for track in tracks] == pytest.approx([-40.0, -70.0], abs=0.1)


@pytest.mark.parametrize(
    ("window", "reason"), [(9.0, "longer than the run"), (np.nan, "must hold 8 samples or more"), (0.001, "must hold 8 samples")]
)
def test_a_window_that_does_not_fit_is_refused(window, reason):
    with pytest.raises(DataError, match=reason):
        track_lines(run_of((-40.0, 1e-3)), window=window)
