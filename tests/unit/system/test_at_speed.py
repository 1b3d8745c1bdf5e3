"""A body at a rotor speed: the one door to coefficients that follow the speed."""

from dataclasses import replace

import numpy as np
import pytest

from rsc.system.body import Body
from rsc.system.system import stacked
from systems import reference

SPEEDS = np.array([-40.0, 0.0, 130.0])  # rad/s


def symmetric(rng, n):
    matrix = rng.normal(size=(n, n))
    return matrix + matrix.T


def full(rng, n=3, **without):
    """A body with every matrix there is."""
    names = ("stiffness", "damping", "gyroscopic", "skew_stiffness", "skew_damping", "rotating_damping")
    return Body(mass=np.eye(n), contact=np.eye(n)[0], **{name: symmetric(rng, n) for name in names} | without)


def test_constant_coefficients_are_the_same_body_at_every_speed():
    body = full(np.random.default_rng(1), rotating_damping=None)
    assert body.at_speed(70.0) is body and body.at_speed(SPEEDS) is body


def test_rotating_damping_is_damping_and_skew_stiffness_at_a_speed():
    rng = np.random.default_rng(2)
    for without in ({}, {"skew_stiffness": None}):
        body = full(rng, **without)
        for Omega in SPEEDS:
            own = body.at_speed(Omega)
            assert not own.follows
            for Psi in (-55.0, 0.0, 90.0):
                whole = body.dynamic_stiffness(Psi, Omega)
                assert own.dynamic_stiffness(Psi, Omega) == pytest.approx(whole, rel=1e-13)
                assert own.static + Psi * own.by_frequency(Omega) - Psi**2 * body.mass == pytest.approx(whole, rel=1e-12)


def test_what_turns_with_the_rotor_takes_nothing_from_a_motion_at_its_speed():
    """A whirl at Psi = Omega does not deform the shaft in the frame of the rotor."""
    body = full(np.random.default_rng(3))
    without = replace(body, rotating_damping=None)
    assert body.dynamic_stiffness(130.0, 130.0) == pytest.approx(without.dynamic_stiffness(130.0, 130.0), rel=1e-14)


def test_several_speeds_make_a_stack():
    body = full(np.random.default_rng(4))
    many = body.at_speed(SPEEDS)
    for i, Omega in enumerate(SPEEDS):
        for name, part in body.at_speed(Omega).terms.items():
            assert np.array_equal(getattr(many.at(i), name), part)


def test_systems_at_several_speeds_are_their_stack():
    system = reference("laval")
    assert system.at_speed(SPEEDS) is system
    system = replace(system, rotor=replace(system.rotor, rotating_damping=np.array([[3.0]])))
    many, each = system.at_speed(SPEEDS), stacked([system.at_speed(Omega) for Omega in SPEEDS])
    assert np.array_equal(many.joined().damping, each.joined().damping)
    assert np.array_equal(many.rotor.skew_stiffness, each.rotor.skew_stiffness)
    assert np.array_equal(many.law.friction, each.law.friction) and many.law.friction.shape == SPEEDS.shape
    # a stack has one speed each
    both = stacked([system, system]).at_speed(SPEEDS[:2])
    assert np.array_equal(both.rotor.skew_stiffness, each.at(np.arange(2)).rotor.skew_stiffness)


def test_forgetting_the_door_is_an_error():
    body = full(np.random.default_rng(5))
    for ask in (lambda: body.static, lambda: body.turning(1.0), lambda: body.by_frequency(1.0)):
        with pytest.raises(ValueError, match="at_speed"):
            ask()


def test_the_mirror_image_at_the_opposite_speed():
    body = full(np.random.default_rng(6))
    mirrored = body.mirror().dynamic_stiffness(-55.0, -130.0)
    assert mirrored == pytest.approx(body.dynamic_stiffness(55.0, 130.0).conj(), rel=1e-13)
