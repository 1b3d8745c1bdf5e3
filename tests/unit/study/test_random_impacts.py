"""How hard random impacts are: closed forms of the largest one, and that it does not depend on how finely a shaft is divided."""

import math

import numpy as np
import pytest

import rsc
from rsc.scene.files.templates import template
from rsc.study.motions.random_impacts import FAST, LEAST, SHOCK, ImpactSizes
from rsc.study.motions.settle import Settling
from scenes import LAVAL, SCENES

MASS, FREQUENCY = 2.0, 40.0


def sizes(scene, largest=None):
    return ImpactSizes(Settling(scene, 50.0), largest)


def laval(gap):
    rotor = {"model": "laval", "mass": MASS, "frequency": FREQUENCY, "damping_ratio": 0.0}
    return rsc.Scene.from_dict({**LAVAL, "rotor": rotor, "contact": LAVAL["contact"] | {"gap": gap}, "start": {"rest": True}})


@pytest.mark.parametrize("over_shock", [0.01, 0.09, 0.2, 0.45, 0.6, 5.0])
def test_the_largest_is_ten_times_what_touches_within_what_machines_meet(over_shock):
    """J = m omega s just touches; the whole rotor at 3 m/s has m SHOCK; twice what touches is tried in any case."""
    gap = over_shock * SHOCK / (2.0 * math.pi * FREQUENCY)
    touching = MASS * 2.0 * math.pi * FREQUENCY * gap
    wanted = min(FAST * touching, max(SHOCK * MASS, LEAST * touching))
    own = sizes(laval(gap))
    assert own.largest == pytest.approx([wanted], rel=1e-4)
    impulses, places = own.random(200, np.random.default_rng(1))
    assert set(places) == {0} and touching <= abs(impulses).min() * (1.0 + 1e-4) and abs(impulses).max() <= wanted
    assert abs(impulses).max() > 0.95 * wanted and abs(impulses).min() < touching + 0.05 * (wanted - touching)


def test_where_the_mass_is_not_known_it_is_ten_times_what_touches():
    rotor = {"model": "matrices", "mass": [[MASS]], "stiffness": [[MASS * (2.0 * math.pi * FREQUENCY) ** 2]], "damping": [[0.0]],
             "eccentricity": [0.0], "tilt_coordinates": []}  # fmt: skip
    gap = 2.0 * SHOCK / (2.0 * math.pi * FREQUENCY)
    contact = LAVAL["contact"] | {"gap": gap, "rotor_coordinate": 0}
    scene = rsc.Scene.from_dict({**LAVAL, "rotor": rotor, "contact": contact, "start": {"rest": True}})
    assert math.isnan(scene.rotor.total_mass)
    assert sizes(scene).largest == pytest.approx([FAST * MASS * 2.0 * SHOCK], rel=1e-4)
    assert sizes(scene, 7.0).largest == [7.0]


@pytest.mark.parametrize("name", ["gyroscopic disk", "chains", "bouncing"])
def test_total_masses_of_models_that_tell_them(name):
    rotor = rsc.Scene.from_dict(SCENES[name]).rotor
    table = SCENES[name]["rotor"]
    assert rotor.total_mass == pytest.approx(sum(table["masses"]) if "masses" in table else table["mass"])


def test_the_mass_of_a_shaft_is_that_of_its_parts_and_not_of_the_piece_that_is_hit():
    scene = rsc.Scene.from_toml(template("pump"))
    steel = 7850.0 * math.pi / 4.0 * (0.110 * 0.042**2 + 0.260 * 0.055**2 + 0.120 * 0.048**2 + 0.070 * 0.038**2)
    coupling = 7850.0 * math.pi / 4.0 * 0.060 * (0.130**2 - 0.042**2)
    assert scene.rotor.total_mass == pytest.approx(steel + coupling + 9.5, rel=0.01)
    assert scene.rotor.mass < 0.1 * scene.rotor.total_mass  # 95 % of the answer at the contact is a local mode at 14 kHz
