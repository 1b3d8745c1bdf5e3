"""The motion of a run-up without contact against Duhamel's integral and the steady response."""

import numpy as np

from closed_forms import RunUp
from rsc.analysis.alone.run_up import run_up_response
from rsc.analysis.paper.synchronous import unbalance_response
from rsc.scene.scene import Scene
from rsc.system.assemble import assemble
from systems import TWO_PI, reference_scene

ECC = 1e-5


def laval(speed, duration):
    """Laval rotor of 1 kg and 30 Hz, damping ratio 0.01."""
    rotor = {"model": "laval", "mass": 1.0, "frequency": 30.0, "damping_ratio": 0.01, "eccentricity": ECC}
    contact = {"gap": 1.0, "friction": 0.1, "stiffness": 1e6, "damping": 0.0}
    drive = {"speed": speed, "duration": duration}
    scene = {"rotor": rotor, "stator": {"model": "rigid"}, "contact": contact, "drive": drive}
    return assemble(Scene.from_dict(scene))


def error(step):
    """Largest error in eccentricities from 14 to 18 s of a run-up from 5 to 100 Hz in 60 s; its resonance is at 16.5 s."""
    form, time = RunUp(30.0, 0.01, (5.0, 100.0), 60.0), np.arange(10.0, 18.0 + 0.5 * step, step)
    motion = run_up_response(laval([5.0, 100.0], 60.0), time) / ECC
    turned = motion * np.exp(1j * TWO_PI * (5.0 * time + 0.5 * 95.0 / 60.0 * time**2))
    places = [int(np.argmin(abs(time - t))) for t in np.arange(14.0, 18.0, 0.25)]
    return max(abs(turned[k] - form.at(float(time[k]))) for k in places)


def test_a_resonance_is_passed_as_duhamels_integral_says():
    """39 eccentricities at most. What is left is the step's, in which the speed is taken as constant."""
    coarse, fine = error(0.01), error(0.005)
    assert coarse < 2e-3 and fine < 0.1 * coarse


def test_at_constant_speed_the_motion_is_the_steady_one():
    """Of a gyroscopic rotor as of every other, for any length of step."""
    system = assemble(reference_scene("gyroscopic_transition").with_values({"drive.speed": 60.0}))
    motion = run_up_response(system, np.linspace(0.0, 5.0, 101))
    steady = unbalance_response(system, TWO_PI * 60.0)[0] @ system.rotor.contact
    assert np.abs(motion / steady - 1.0).max() < 1e-10
