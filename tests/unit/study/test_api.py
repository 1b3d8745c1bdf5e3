"""The Python names that users rely on (design page), each called once on one scene."""

import subprocess
import sys

import numpy as np
import pytest

import rsc
from systems import REFERENCE


@pytest.fixture(scope="module")
def report():
    scene = rsc.load_scene(REFERENCE / "laval.toml").with_values({"drive.duration": 6.0})
    return rsc.check(scene)


def test_names_of_a_trajectory(report):
    result = report.result
    n = len(result.time)
    assert result.speed.shape == result.normal_force.shape == (n,)
    assert result.rotor.shape == result.stator.shape == (n, 1) and result.rotor.dtype == complex
    assert result.status == "finished" and min(result.steps, result.rhs_calls) > 0 and result.rejected >= 0
    assert (result.contact_onsets, result.contact_releases) == (0, 0)
    parts = ("energy_in", "friction_in", "rotor_damping", "stator_damping", "contact_damping", "change", "residual")
    assert all(np.isfinite(getattr(result.ledger, name)) for name in parts)


def test_machines_are_at_hand():
    code = "import rsc, sys; assert 'rsc.machine' not in sys.modules; print(rsc.machine.from_ross.__name__)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "from_ross\n" and "machine" in dir(rsc)


def test_names_of_spectra(report):
    result = report.result
    fall, peaks, envelope = rsc.waterfall(result), rsc.spectral_peaks(result), rsc.envelope(result)
    assert fall.amplitude.shape == (len(fall.speed), len(fall.frequency)) and fall.frequency.min() < 0.0
    assert peaks.frequency.shape == peaks.amplitude.shape and (peaks.frequency[:, 0] < 0.0).all()
    assert (envelope.minimum < envelope.maximum).all() and envelope.speed.shape == envelope.minimum.shape


def test_names_of_predictions_and_rows(report):
    scene = report.result.scene
    assert isinstance(scene, rsc.Scene)
    one, many = rsc.predict(scene, speed=50.0), rsc.predict(scene, speed=[50.0, 60.0])
    assert [w.frequency for w in many[0]] == [w.frequency for w in one] and len(many) == 2
    whirl = next(w for w in one if w.stable)
    assert isinstance(whirl, rsc.Whirl) and whirl.admissible and whirl.conditions
    assert whirl.synchronous.consistent.envelope[0] < whirl.rotor_amplitude < whirl.synchronous.consistent.envelope[1]
    assert whirl.synchronous.mirror_frequency == pytest.approx(2.0 * whirl.frequency - 50.0)
    row = report.rows[0]
    assert (row.quantity, row.verdict) == ("whirl frequency", "agrees")
    assert row.difference == pytest.approx(row.simulated / row.predicted - 1.0)
