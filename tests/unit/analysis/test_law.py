"""The law of the contact: its closed forms against each other and against differences, and a law that no prediction treats."""

from dataclasses import make_dataclass, replace

import numpy as np
import pytest

import rsc.errors
from rsc.analysis.alone.at_rest import at_rest
from rsc.analysis.balance.balance import balance
from rsc.analysis.follow.branches import branches
from rsc.analysis.paper.law import SteadyLaw, law_of
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.paper.synchronous import forward_rub
from rsc.system import system as system_law
from rsc.system.system import stacked
from systems import TWO_PI, changed, reference

LAW = SteadyLaw(gap=2e-3, friction=0.3, stiffness=4e5, damping=60.0, diameter=0.1, slip_velocity=0.02)
WITH_FORCE = {
    "whirls": lambda system: predict_system(system, 50.0),
    "branches": lambda system: branches(system, [40.0, 50.0]),
    "forward rub": lambda system: forward_rub(system, TWO_PI * 50.0),
    "rolling": lambda system: rolling_whirls(system, TWO_PI * 50.0),
    "balance": lambda system: balance(system, -60.0, 50.0),
    "at rest": lambda system: at_rest(changed(system, load=np.array([1e4 + 0j]))),
}


def hardening(system, value):
    """A System whose contact has one more constant, as a law F = k p (1 + h p/gap) would bring it."""
    kind = make_dataclass("Hardening", [("hardening", float)], bases=(system_law.ContactLaw,), frozen=True, kw_only=True)
    law = kind(**vars(system.law), hardening=value)
    return replace(system, contacts=(replace(system.contact, law=law),))


@pytest.mark.parametrize("prediction", WITH_FORCE.values(), ids=WITH_FORCE)
def test_a_law_that_no_prediction_treats_is_refused_in_one_line(prediction):
    laval = reference("laval")
    prediction(hardening(laval, 0.0))  # the same law
    with pytest.raises(rsc.errors.SceneError) as refused:
        prediction(hardening(laval, 0.5))
    assert refused.value.key == "contact.hardening" and "\n" not in str(refused.value)


def test_slopes_are_those_of_the_force():
    """By differences of the contact force in the plane, about a steady motion at d = |d| + 0i."""
    distance, step = 2.3e-3, 1e-9
    F_N = LAW.normal(distance, 0.0)[0]
    assert LAW.distance(F_N) == pytest.approx(distance, rel=1e-15)

    def force(d, rate=0.0):
        return LAW.normal(abs(d), rate)[0] * d / abs(d)

    by_y, by_z = ((force(distance + move) - force(distance - move)) / (2.0 * step) for move in (step, 1j * step))
    radial, tangential = LAW.slopes(F_N)
    assert by_y == pytest.approx(radial, rel=1e-6) and by_z == pytest.approx(1j * tangential, rel=1e-6)
    assert LAW.secant(distance) == pytest.approx(F_N / distance, rel=1e-12) and LAW.secant(0.9 * LAW.gap) == 0.0


def test_the_damper_acts_while_the_surfaces_separate():
    towards, away = (LAW.normal(np.array([2.3e-3]), np.array([rate])) for rate in (0.1, -0.1))
    assert towards[0] - away[0] == pytest.approx(0.1 * LAW.damping) and towards[2] == 0.0 and away[2] == LAW.damping
    assert LAW.dynamic_stiffness(50.0) == LAW.stiffness + 50j * LAW.mean_damping  # on for half of a small oscillation


def test_the_force_that_a_receptance_gives_presses_the_contact_in_by_its_depth():
    real = np.array([-2e-5, -3e-6, -2.4e-6])
    F_N = LAW.normal_force(real)
    assert -real * F_N == pytest.approx(LAW.distance(F_N), rel=1e-12)
    assert np.array_equal(LAW.held(real) > 0.0, F_N > 0.0)
    assert LAW.stiff_enough(LAW.normal_force(real, rigid=True)) == pytest.approx(LAW.held(real), rel=1e-12)


def test_friction_below_its_limit_follows_the_slip():
    sigma, slope = LAW.sign(np.array([-1.0, 0.005, 1.0]))
    assert sigma == pytest.approx([-1.0, 0.25, 1.0]) and slope == pytest.approx([0.0, 50.0, 0.0])
    assert LAW.slip_of(0.25 * LAW.friction) == pytest.approx(0.005)
    assert LAW.creep(80.0) == pytest.approx(80.0 * LAW.friction * slope[1])


def test_the_force_leads_or_lags_the_contact_by_the_angle_of_friction():
    c, _ = LAW.against_force(0.0)
    assert c * LAW.turn == pytest.approx(LAW.oblique) and LAW.turned(-1.0) == pytest.approx(np.conj(LAW.turn))


def test_a_stack_has_the_laws_of_its_systems():
    systems = [reference("laval"), changed(reference("laval"), friction=0.4, contact_stiffness=3e5)]
    assert law_of(stacked(systems)).turn.tolist() == [law_of(system).turn for system in systems]
