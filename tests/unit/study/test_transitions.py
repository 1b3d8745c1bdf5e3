"""The changes of whirl of a run and the tracks of its lines: those of its report and of the prediction."""

import numpy as np
import pytest

import rsc
from rsc.study.report.check import report
from systems import reference_scene

RUN_DOWN = {"drive.duration": 8.0, "drive.speed": [60.0, 10.0], "start.whirl": -48.8}


@pytest.fixture(scope="module")
def run():
    """A short run-down on a whirl that ends in a fold at 21 Hz."""
    return rsc.simulate(reference_scene("gyroscopic_disk_very_light_rundown").with_values(RUN_DOWN))


def test_the_changes_of_a_run_are_those_of_its_report(run):
    changes = rsc.transitions(run)
    assert [(change.before, change.after) for change in changes] == [("B", "A")]
    assert changes == report(run).transitions


def test_a_run_without_a_spectrum_is_refused():
    scene = reference_scene("laval").with_values({"drive.duration": 0.01, "output.rate": 500.0})
    with pytest.raises(rsc.DataError, match="leaves 6 samples, a spectrum needs 9"):
        rsc.transitions(rsc.simulate(scene))


def test_the_lines_of_both_whirls_are_tracked_through_the_change(run):
    (change,) = rsc.transitions(run)
    tracks = rsc.track_lines(run)
    old = tracks[0]
    new = max(tracks[1:], key=lambda track: np.nanmax(track.amplitude))
    # before the run-down meets the loss of stability at 31.7 Hz; at 6 Hz/s the whirl lags a little
    early = old.speed > 45.0
    whirls = [min(rsc.predict(run.scene, speed), key=lambda w: abs(w.frequency + 49.0)) for speed in old.speed[early]]
    assert old.frequency[early] == pytest.approx([w.frequency for w in whirls], rel=5e-3)
    # it is there before it takes over, and the stronger one from then on
    after = new.speed <= change.taken_over
    assert np.isfinite(new.frequency[after]).all() and (new.amplitude[after] > np.nan_to_num(old.amplitude[after])).all()
    assert np.isfinite(new.amplitude[~after]).any()
