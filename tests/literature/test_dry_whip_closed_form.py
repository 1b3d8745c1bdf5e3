"""Dry friction backward whirl of a Jeffcott rotor in a massless elastic stator, in closed form (Black 1968; Jiang 2007).

With the stator's stiffness k_b in the contact, m w^2 - k = F_N/|r| and c w = mu F_N/|r| for r = |r| e^{-i w t}:

    m w^2 = k + c w/mu,    |r| = k_b s/(k_b - c w/mu),    F_N = k_b (|r| - s)

and the whirl exists while c w/mu < k_b, that is for mu > c/k_b sqrt((k + k_b)/m).
"""

import numpy as np
import pytest

import rsc
from rsc.analysis.follow.least_friction import least_frictions

# mass kg, stiffness N/m, damping N s/m, friction, stiffness of the stator N/m, gap m
ROTORS = [(1.0, 1e5, 20.0, 0.2, 4e5, 1e-3), (30.0, 2e6, 3e3, 0.3, 1e7, 2e-4), (0.5, 4e4, 5.0, 0.15, 2e5, 5e-4)]


def scene_of(mass, stiffness, damping, friction, stator, gap):
    return rsc.Scene.from_dict(
        {
            "title": "Jeffcott rotor in a massless elastic stator",
            "rotor": {"model": "laval", "mass": mass, "stiffness": stiffness, "damping": damping, "eccentricity": 0.0},
            "stator": {"model": "rigid"},
            "contact": {"gap": gap, "stiffness": stator, "damping": 0.0, "friction": friction},
            "drive": {"speed": 50.0, "duration": 1.0},
        }
    )


@pytest.mark.parametrize("rotor", ROTORS)
def test_frequency_amplitude_and_force(rotor):
    mass, stiffness, damping, friction, stator, gap = rotor
    brake = damping / friction
    w = (brake + np.sqrt(brake**2 + 4.0 * mass * stiffness)) / (2.0 * mass)
    amplitude = stator * gap / (stator - brake * w)
    (whirl,) = rsc.predict(scene_of(*rotor), 50.0)
    assert whirl.frequency == pytest.approx(-w / (2.0 * np.pi), rel=1e-12)
    assert whirl.rotor_amplitude == pytest.approx(amplitude, rel=1e-12)
    assert whirl.normal_force == pytest.approx(stator * (amplitude - gap), rel=1e-11)


@pytest.mark.parametrize("rotor", ROTORS)
def test_the_friction_below_which_there_is_none(rotor):
    mass, stiffness, damping, _, stator, _ = rotor
    least = damping / stator * np.sqrt((stiffness + stator) / mass)
    _, whirl = least_frictions(scene_of(*rotor), 50.0)
    for friction, whirls in ((0.999 * least, 0), (1.001 * least, 1)):
        assert len(rsc.predict(scene_of(*rotor).with_values({"contact.friction": friction}), 50.0)) == whirls
    assert whirl.value >= least
    (escape, _) = least_frictions(scene_of(*rotor), 50.0)
    assert escape.value == pytest.approx(least, rel=1e-8)
