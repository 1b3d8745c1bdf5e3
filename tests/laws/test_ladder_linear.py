"""Verification ladder without contact, V1 V2 V3 V12: free decay, unbalance, run-up through resonance, output between steps.

The oracles are closed forms in arbitrary precision (`closed_forms`). Errors are in gaps, because the absolute tolerance of a run
is rtol times the gap; the gap is set to twice the largest motion, so that no contact ever happens.
"""

import mpmath as mp
import numpy as np
import pytest

import rsc
from closed_forms import RunUp, free_motion, steady_response
from figures import met, slope

MASS = np.array([[1.2, 0.1, 0.0], [0.1, 0.02, 0.0], [0.0, 0.0, 0.8]])
DAMPING = np.array([[3.0, 0.02, -0.5], [0.02, 0.03, 0.0], [-0.5, 0.0, 2.0]])
GYROSCOPIC = np.diag([0.0, 0.025, 0.0])
STIFFNESS = np.array([[6e4, -1e3, -1e4], [-1e3, 1.5e3, 0.0], [-1e4, 0.0, 4e4]])
ECC = np.array([5e-5, 2e-4j, -3e-5])
COUPLED = (MASS, DAMPING, GYROSCOPIC, STIFFNESS)


def coupled_rotor(ecc=(0.0, 0.0, 0.0)):
    """Displacement, tilt and a second displacement, all coupled, gyroscopic; no matrix diagonal."""
    return {"model": "matrices", "mass": MASS.tolist(), "damping": DAMPING.tolist(), "gyroscopic": GYROSCOPIC.tolist(),
            "stiffness": STIFFNESS.tolist(), "tilt_coordinates": [1],
            "eccentricity": [[abs(e), float(np.degrees(np.angle(e)))] for e in ecc]}  # fmt: skip


def laval(ratio, ecc=0.0):
    """Laval rotor of 1 kg and 30 Hz."""
    return {"model": "laval", "mass": 1.0, "frequency": 30.0, "damping_ratio": ratio, "eccentricity": ecc}


def free_run(rotor, gap, drive, rtol, **more):
    """A run that never touches the wall."""
    tables = {"rotor": rotor, "stator": {"model": "rigid"}, "drive": drive, "solver": {"rtol": rtol}, **more}
    tables["contact"] = {"gap": gap, "friction": 0.1, "stiffness": 1e6}
    result = rsc.simulate(rsc.Scene.from_dict(tables))
    end = result.scene.drive.duration
    assert result.status == "finished" and result.summary.end_time == end
    assert len(result.time) == int(end * result.scene.output.rate * (1 + 1e-12)) + 1  # every sample up to the last corner
    assert not result.normal_force.any()
    return result


def pairs(values):
    return [[complex(v).real, complex(v).imag] for v in values]


# ---- V1


def one(ratio):
    """M, B, G, K of the Laval rotor of `laval`."""
    return [[1.0]], [[2 * ratio * 60.0 * np.pi]], [[0.0]], [[(60.0 * np.pi) ** 2]]


# name -> rotor, its matrices, start, duration of some 100 periods, limit of the error in rtol
FREE = {
    "ratio 0.02": (laval(0.02), one(0.02), ([1e-3], [0.1j]), 3.2, 15.0),
    "ratio 0.001": (laval(0.001), one(0.001), ([1e-3], [0.1j]), 3.2, 150.0),
    "3 coordinates, gyroscopic": (coupled_rotor(), COUPLED, ([6e-4, 1e-3j, -3e-4], [0.05j, 0.2, 0.1]), 1.28, 400.0),
}


def decay_error(name, rtol):
    """Largest error against the matrix exponential, each coordinate in its own largest motion or the gap."""
    rotor, matrices, start, duration, _ = FREE[name]
    mass, damping, gyroscopic, stiffness = map(np.array, matrices)
    exact = free_motion((mass, damping, 2 * np.pi * 40.0 * gyroscopic, stiffness), start, duration / 64, 64)
    gap = 2.0 * np.abs(exact[:, 0]).max() + 1e-3
    begin = {"rotor": pairs(start[0]), "rotor_velocity": pairs(start[1])}
    drive = {"speed": 40.0, "duration": duration}
    result = free_run(rotor, gap, drive, rtol, start=begin, output={"rate": 6400.0 / duration})
    size = np.abs(exact).max(axis=0)
    is_tilt = np.arange(len(size)) == 1
    return (np.abs(result.rotor[::100] - exact) / np.where(is_tilt, size, np.maximum(size, gap))).max()


@pytest.mark.parametrize("name", FREE)
def test_v1_free_decay_is_the_matrix_exponential(name):
    """A step errs by a few hundredths of rtol in the phase and some 30 steps make a period: without damping to forget it that is
    one rtol a period. The first goal, 5 rtol per 100 periods, is nearly met where damping forgets (ratio 0.02: 9), not at 0.001.
    With three coordinates the fastest, a small tilt, is followed with the steps that suit the largest."""
    tolerances = 10.0 ** -np.arange(5.0, 12.0)
    errors = np.array([decay_error(name, rtol) for rtol in tolerances])
    met("V1", f"{name}: largest error / rtol over 100 periods", (errors / tolerances).max(), FREE[name][4])
    met("V1", f"{name}: |slope of error over rtol - 1|", abs(slope(tolerances, errors) - 1.0), 0.05)


# ---- V2


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 1.0, 1.1, 2.0, 10.0])
def test_v2_steady_unbalance_of_one_coordinate(share):
    """r = eps Om^2 / (om^2 - Om^2 + 2 i D om Om), held for 40 turns from a start on it."""
    steady_error("laval", laval(0.02, 5e-5), one(0.02),
                 [5e-5], 30.0 * share)  # fmt: skip


@pytest.mark.parametrize("speed", [5.0, 32.0, 45.0, 150.0, -45.0])
def test_v2_steady_unbalance_of_a_gyroscopic_rotor(speed):
    """Three coupled coordinates by the linear equations, U = (M - G) eps; also with the shaft turning backward."""
    steady_error("3 coordinates", coupled_rotor(ECC), COUPLED, (MASS - GYROSCOPIC) @ ECC, speed)


def steady_error(name, rotor, matrices, unbalance, speed, rtol=1e-8, turns=40):
    exact = steady_response(matrices, unbalance, speed)
    gap, turn = 2.0 * abs(exact[0]), 2j * np.pi * speed
    start = {"rotor": pairs(exact), "rotor_velocity": pairs(turn * exact)}
    drive = {"speed": speed, "duration": turns / abs(speed)}
    result = free_run(rotor, gap, drive, rtol, start=start, output={"rate": 16.0 * abs(speed)})
    late = result.time > 0.5 * result.time[-1]
    lines = result.rotor[late] * np.exp(-turn * result.time[late])[:, None]
    met("V2", f"{name}: amplitude and phase error / (rtol gap)", abs(lines - exact).max() / gap / rtol, 20.0)


# ---- V3


def run_up_error(duration, rtol, times):
    """Largest error in eccentricities at the given times of a run-up from 5 to 100 Hz, and the largest motion."""
    form, ecc = RunUp(30.0, 0.01, (5.0, 100.0), duration), 1e-5
    exact = np.array([form.at(t) for t in times])
    gap = 2.0 * abs(exact).max() * ecc
    drive = {"speed": [5.0, 100.0], "duration": duration}
    result = free_run(laval(0.01, ecc), gap, drive, rtol, output={"rate": 500.0})
    got = result.rotor[np.rint(np.array(times) * 500.0).astype(int), 0]
    return abs(got / ecc - exact).max(), abs(exact).max()


def test_v3_closed_form_equals_duhamels_integral():
    """The oracle itself: error functions against plain quadrature."""
    form = RunUp(30.0, 0.01, (5.0, 100.0), 60.0)
    for t in (0.05, 0.4):
        assert form.at(t) == pytest.approx(form.by_quadrature(t), rel=1e-14)


def test_v3_run_up_through_resonance():
    """60 s, 5 to 100 Hz; the motion is largest at 16.5 s with 39 eccentricities. The first goal, 2.2e-8 eps at rtol 1e-10, held
    for an absolute tolerance of a share of the eccentricity; here it is rtol times the gap, and the gap has to be 79
    eccentricities."""
    times = np.concatenate([np.arange(0.5, 60.1, 0.5), np.arange(15.0, 18.0, 0.02)])
    tolerances = np.array([1e-6, 1e-8, 1e-10, 1e-12])
    errors, peaks = zip(*(run_up_error(60.0, rtol, times) for rtol in tolerances), strict=True)
    assert peaks[0] == pytest.approx(39.28, abs=0.01)
    relative = np.array(errors) / (2.0 * peaks[0])
    for rtol, error in zip(tolerances, errors, strict=True):
        met("V3", f"60 s, rtol {rtol:.0e}: error / eccentricity", error, 30.0 * rtol * 2.0 * peaks[0])
    met("V3", "60 s: |slope of error over rtol - 1|", abs(slope(tolerances, relative) - 1.0), 0.05)


def test_v3_long_run_up_keeps_its_phase():
    """600 s: 31,500 turns; the error is that of the resonance, not of a clock that drifts."""
    rtol = 1e-9
    error, peak = run_up_error(600.0, rtol, [*np.arange(150.0, 170.0, 0.5), 300.0, 599.5, 600.0])
    met("V3", "600 s, rtol 1e-09: error / eccentricity", error, 50.0 * rtol * 2.0 * peak)


# ---- V12


EIGHTH_ORDER = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])  # central first differences


def test_v12_samples_between_steps_are_as_good_as_those_at_step_ends():
    """A constant speed written with a corner every 7 ms makes step ends there; between them the interpolant answers."""
    rotor, matrices, start, _, _ = FREE["3 coordinates, gyroscopic"]
    mass, damping, gyroscopic, stiffness = map(np.array, matrices)
    fine = free_motion((mass, damping, 2 * np.pi * 40.0 * gyroscopic, stiffness), start, 0.0005 / 8, 8 * 1400)
    exact, rate = fine[::8], np.correlate(fine[:, 0], EIGHTH_ORDER, "same")[::8] / (0.0005 / 8)
    swept = (exact[:, 0].conj() * rate).imag[1:-1]
    gap = 2.0 * np.abs(exact[:, 0]).max()
    begin = {"rotor": pairs(start[0]), "rotor_velocity": pairs(start[1])}
    corners = {"schedule": [[0.007 * i, 40.0] for i in range(101)]}
    for rtol in (1e-5, 1e-8):
        result = free_run(rotor, gap, corners, rtol, start=begin, output={"rate": 2000.0})
        error = np.abs(result.rotor - exact).max(axis=1)
        is_node = np.arange(len(error)) % 14 == 0
        met("V12", f"rtol {rtol:.0e}: error between steps / at steps", error[~is_node].max() / error[is_node].max(), 5.0)
        error = np.abs((result.tangential_velocity * np.abs(result.rotor[:, 0]))[1:-1] - swept)
        is_node = is_node[1:-1]
        met("V12", f"rtol {rtol:.0e}: the same of velocities", error[~is_node].max() / error[is_node].max(), 2.0)


def test_v12_spectrum_of_a_steady_run_has_one_line():
    """Rotor on its unbalance circle: everything off the line, by a Blackman-Harris window (-92 dB a lobe) squared, is error."""
    exact = steady_response(one(0.02), [5e-5], 40.0)
    turn = 2j * np.pi * 40.0
    start = {"rotor": pairs(exact), "rotor_velocity": pairs(turn * exact)}
    for rtol, floor in ((1e-6, -130.0), (1e-9, -190.0)):
        drive = {"speed": 40.0, "duration": 4.0}
        result = free_run(laval(0.02, 5e-5), 2.0 * abs(exact[0]), drive, rtol, start=start, output={"rate": 2048.0})
        signal = result.rotor[4096:8192, 0]
        shape = np.cos(np.pi * (np.arange(4096) - 2048) / 4096) ** 16
        spectrum = np.abs(np.fft.fft(signal * shape))
        line = int(np.argmax(spectrum))
        assert line == 80  # 40 Hz in windows of 2 s
        distance = np.abs((np.arange(4096) - line + 2048) % 4096 - 2048)
        level = 20.0 * np.log10(spectrum[distance > 12].max() / spectrum[line])
        met("V12", f"spectrum floor at rtol {rtol:.0e}, dB", level, floor)


def test_closed_forms_agree_with_each_other():
    """The steady response is the free motion's particular part: a residual of the equations, in 50 digits."""
    exact = steady_response(COUPLED, (MASS - GYROSCOPIC) @ ECC, 45.0)
    omega = 2 * np.pi * 45.0
    left = (STIFFNESS - omega**2 * MASS + 1j * omega * (DAMPING - 1j * omega * GYROSCOPIC)) @ exact
    assert np.abs(left / (omega**2 * (MASS - GYROSCOPIC) @ ECC) - 1.0).max() < 1e-10
    assert mp.mp.dps == 15  # no test leaves the precision changed
