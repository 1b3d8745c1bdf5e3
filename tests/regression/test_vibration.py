"""Vibration, sag, closest approach and the kind of a free vibration: of machines that once were told wrongly, and siblings."""

import re

import numpy as np
import pytest

import rsc
from rsc.measure.kinds import BACKWARD, Kind
from rsc.show.words.answer import answer
from rsc.study.report.check import report as report_of
from tiers import first

SIBLINGS = first(range(6), 2)  # the first is the machine itself
GRAVITY = 9.81


def vary(seed, count, wide=0.2):
    return (np.random.default_rng(seed).uniform(1.0 - wide, 1.0 + wide, count) if seed else np.ones(count)).tolist()


def extent(motion):
    return float(max(np.ptp(motion.real), np.ptp(motion.imag)))


def number(pattern, text):
    return float(re.search(pattern, text)[1])


def generator(seed):
    """A generator's rotor that hangs by half of its clearance and runs through its critical speed without contact."""
    a = vary(seed, 5)
    return {
        "rotor": {"model": "laval", "mass": 8000.0, "frequency": 1150.0 / 60.0 * a[0] ** 0.25, "damping_ratio": 0.03 * a[1],
                  "eccentricity": 7.96e-6 * a[2], "gravity": GRAVITY},
        "stator": {"model": "laval", "mass": 1500.0, "frequency": 11.0 * a[3], "damping_ratio": 0.02},
        "contact": {"gap": 1.3e-3 * a[4] ** 0.25, "friction": 0.18, "stiffness": 2e8, "damping_ratio": 0.05, "diameter": 0.45},
        "drive": {"speed": [5.0, 50.0], "duration": 15.0},
        "output": {"rate": 1000.0},
    }  # fmt: skip


@pytest.mark.parametrize("seed", SIBLINGS)
def test_vibration_is_no_sag(seed):
    scene = rsc.Scene.from_dict(generator(seed))
    report = report_of(rsc.simulate(scene), lists=False)
    told, rotor = dict(answer(report)), report.result.contact_rotor()
    sag = GRAVITY / (2.0 * np.pi * scene.rotor.frequency) ** 2
    assert number(r"static sag ([\d.]+) um", told["vibration"]) == pytest.approx(1e6 * sag, rel=5e-3)
    assert number(r"up to ([\d.]+) um pk-pk", told["vibration"]) == pytest.approx(1e6 * extent(rotor), rel=0.05)
    left = scene.contact.gap - np.abs(rotor).max()
    assert number(r"^([\d.]+) um", told["closest approach"]) == pytest.approx(1e6 * left, rel=0.01)
    assert number(r"\(([\d.]+) %\)", told["closest approach"]) == pytest.approx(100.0 * left / scene.contact.gap, rel=0.06)
    # what moves sets the scale of the pictures, and not what hangs
    fall = report.fall
    strongest = np.abs(fall.frequency[np.unravel_index(np.argmax(fall.amplitude), fall.amplitude.shape)[1]])
    assert strongest > 0.5 * scene.rotor.frequency and fall.amplitude.max() < 0.5 * sag


@pytest.mark.parametrize("seed", SIBLINGS)
def test_the_list_of_motions_tells_vibration_without_the_sag(seed):
    a = vary(seed, 3)
    content = generator(seed) | {"drive": {"speed": 45.0 * a[0] ** 0.5, "duration": 1.0}}
    scene = rsc.Scene.from_dict(content)
    speed, own = scene.drive.speed[0], scene.rotor.frequency
    listed = rsc.motions(scene, speed, 1, largest=1.0)
    (free,) = [motion for motion in listed.motions if motion.motion == Kind.NO_CONTACT]
    ratio = speed / own
    line = abs(complex(scene.rotor.eccentricity)) * ratio**2 / abs(1.0 - ratio**2 + 2j * scene.rotor.damping_ratio * ratio)
    assert free.peak_to_peak == pytest.approx(2.0 * line, rel=0.05)
    assert free.amplitude_max > 5.0 * free.peak_to_peak  # which is mostly sag


def touches_once(seed):
    """A free vibration, backward by its start, that touches for two milliseconds."""
    a = vary(seed, 4, 0.03)
    a[3] += 0.05 * bool(seed)  # so that each touches
    return {
        "rotor": {
            "model": "chain", "masses": [8.309, 7.715], "stiffnesses": [357800.0 * a[0], 178000.0, 236400.0],
            "damping_ratio": 0.01554, "eccentricity": [[1.139e-05, -7.288], [9.962e-06, 63.36]],
        },
        "stator": {"model": "laval", "mass": 13.75, "frequency": 139.0 * a[1], "damping_ratio": 0.1422},
        "contact": {
            "gap": 0.0001819, "friction": 0.2381 * a[2], "stiffness": 12390000.0, "damping_ratio": 0.02,
            "ring_eccentricity": [3.196e-06, 5.582], "rotor_coordinate": 1,
        },
        "drive": {"speed": 16.2, "duration": 1.0},
        "start": {
            "rotor": [[8.178e-05, -3.852e-06], [0.0001636, -7.705e-06]],
            "rotor_velocity": [[-0.0009293, -0.01973 * a[3]], [-0.001859, -0.03945 * a[3]]],
        },
        "output": {"rate": 2000.0, "velocities": True},
    }  # fmt: skip


@pytest.mark.parametrize("seed", SIBLINGS)
def test_a_free_vibration_that_touches_once_is_no_whirl(seed):
    report = report_of(rsc.simulate(rsc.Scene.from_dict(touches_once(seed))), lists=False)
    told, whole = dict(answer(report)), report.stretches.whole()
    assert whole.onsets >= 1.0 and not np.isin(report.features.kind, [str(kind) for kind in BACKWARD]).any()
    assert told["whirl"].startswith("no backward whirl; transient contact")
    # the largest force has the time of a touch, and not the middle of its stretch
    fine = rsc.simulate(report.result.scene.with_values({"output.rate": 100_000.0}))
    time = number(r"normal at ([\d.]+) s", told["force"])
    assert time == pytest.approx(float(fine.time[np.argmax(fine.normal_force)]), abs=1e-4)
