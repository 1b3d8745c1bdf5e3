"""Limits of the analysis in closed form: a Laval rotor in a stator of one mass or a rigid wall (docs/maintainers/analysis.md)."""

import numpy as np
import pytest

from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.roots import whirl_roots
from rsc.analysis.paper.stability import whirl_growth
from rsc.analysis.paper.whirls import normal_force, whirl_shapes
from systems import TWO_PI, changed, jeffcott, make_system, quantity, reference

MASS, STIFFNESS, DAMPING = (2.0, 0.7), (8e4, 3e5), (25.0, 60.0)  # of rotor and stator
GAP, OMEGA = 1e-3, 300.0


def laval(friction, share=1.0, contact_stiffness=1e7):
    """The 1 + 1 system with this share of its damping."""
    bodies = [[np.full((1, 1), part[i]) for part in (MASS, np.multiply(share, DAMPING), STIFFNESS)] for i in (0, 1)]
    return make_system((*bodies[0], np.zeros((1, 1))), bodies[1], (0, 0, friction, contact_stiffness))


def polynomial(friction):
    """Coefficients, falling, of mu [a (A^2 + B^2) + A (a^2 + b^2)] - [b (A^2 + B^2) + B (a^2 + b^2)]: sixth degree."""
    a, big_a = (np.poly1d([-MASS[i], 0.0, STIFFNESS[i]]) for i in (0, 1))
    b, big_b = (np.poly1d([DAMPING[i], 0.0]) for i in (0, 1))
    rotor, stator = a * a + b * b, big_a * big_a + big_b * big_b
    return friction * (a * stator + big_a * rotor) - (b * stator + big_b * rotor)


@pytest.mark.parametrize("friction", [0.02, 0.1, 0.2, 0.5, 2.0])
def test_roots_are_those_of_a_polynomial(friction):
    wanted = polynomial(friction).roots
    wanted = np.sort(wanted.real[np.abs(wanted.imag) < 1e-9 * np.abs(wanted)])
    assert whirl_roots(laval(friction), OMEGA) == pytest.approx(wanted, rel=1e-10)


def test_least_friction_leaves_a_forward_root_and_one_at_infinity():
    (b, b_s), (k, k_s), (m, m_s) = DAMPING, STIFFNESS, MASS
    for friction in (1e-2, 1e-3, 1e-4):
        system = laval(friction)
        far, near = whirl_roots(system, OMEGA)
        both = m * m_s * (m + m_s)
        assert near == pytest.approx(friction * k * k_s * (k + k_s) / (b * k_s**2 + b_s * k**2), rel=300.0 * friction**2)
        assert far == pytest.approx(-(b * m_s**2 + b_s * m**2) / (friction * both), rel=10.0 * friction)
        # the one at infinity is a whirl of the free masses within the gap; the other pulls
        forces = normal_force(system, np.array([far, near]), OMEGA, rigid=True)
        assert forces[0] == pytest.approx(GAP * far**2 * m * m_s / (m + m_s), rel=10.0 * friction) and forces[1] < 0.0
        rotor, _ = whirl_shapes(system, far, forces[0], OMEGA)
        assert abs(rotor[0]) == pytest.approx(GAP * m_s / (m + m_s), rel=10.0 * friction)
        assert normal_force(system, far, OMEGA) < 0.0  # an elastic contact of any stiffness cannot hold it in the end


def test_little_damping_leads_to_the_natural_frequencies_by_known_first_orders():
    friction = 0.3
    (b, b_s), (k, k_s), (m, m_s) = DAMPING, STIFFNESS, MASS
    places = [-np.sqrt(k / m), -np.sqrt((k + k_s) / (m + m_s)), -np.sqrt(k_s / m_s)]
    orders = [-b / (2.0 * friction * m), (b + b_s) / (2.0 * friction * (m + m_s)), -b_s / (2.0 * friction * m_s)]
    for share in (1e-3, 1e-4):
        roots = whirl_roots(laval(friction, share), OMEGA)
        for place, order in zip(places, orders, strict=True):
            root = roots[np.argmin(np.abs(roots - place))]
            assert (root - place) / share == pytest.approx(order, rel=5.0 * share)
            force = normal_force(laval(friction, share), root, OMEGA, rigid=True)
            if place == places[1]:  # the coupled one: the force grows as 1 / damping
                square = (k_s - m_s * place**2) ** 2
                wanted = GAP * square / (share * (b + b_s) * -place * (friction + 1.0 / friction))
            else:
                wanted = GAP * share * (b if place == places[0] else b_s) * -place / friction
            assert force == pytest.approx(wanted, rel=20.0 * share)


def test_a_stiffer_contact_tends_to_the_rigid_one_with_its_compliance():
    for friction in (0.2, 0.5):
        Psi = whirl_roots(laval(friction), OMEGA)
        rigid = normal_force(laval(friction), Psi, OMEGA, rigid=True)
        for stiffness in (1e6, 1e8, 1e10):
            force = normal_force(laval(friction, contact_stiffness=stiffness), Psi, OMEGA)
            assert 1.0 / force == pytest.approx(1.0 / rigid - 1.0 / (stiffness * GAP), rel=1e-9)


def test_dry_whirl_on_a_rigid_wall_grows_at_the_rate_of_its_one_coordinate():
    # on the wall r = s e^{i psi}: m psi'' + b psi' + mu (m psi'^2 - k) = 0 at any gap
    mass, damping, stiffness, friction = 1.5, 20.0, 6e4, 0.25
    root = np.sqrt(damping**2 + 4.0 * friction**2 * mass * stiffness)
    errors = []
    for contact in (1e9, 1e10, 1e11):
        system = changed(jeffcott(mass, damping, stiffness, friction), contact_stiffness=contact)
        Psi = whirl_roots(system, OMEGA)[0]
        assert Psi == pytest.approx(-(damping + root) / (2.0 * friction * mass), rel=1e-12)
        growth = whirl_growth(system, Psi, normal_force(system, Psi, OMEGA), OMEGA)
        assert growth.frequency == 0.0
        errors.append(abs(growth.rate / (root / mass) - 1.0))
    assert errors[0] < 5e-4
    assert errors[1] / errors[0] == pytest.approx(0.1, rel=0.05)
    assert errors[2] < 0.2 * errors[1]


@pytest.mark.parametrize("name", ["laval", "gyroscopic_transition"])
def test_lengths_scale_with_the_gap(name):
    system, factor = reference(name), 3.0
    lengths = {key: factor * quantity(system, key) for key in ("gap", "unbalance", "unbalance_euler", "ring_ecc")}
    for speed in (30.0, 70.0):
        small, large = predict_system(system, speed), predict_system(changed(system, **lengths), speed)
        assert len(small) == len(large) > 0
        for one, other in zip(small, large, strict=True):
            assert other.frequency == one.frequency
            assert other.growth_rate == pytest.approx(one.growth_rate, rel=1e-6, abs=1e-6)
            parts, others = (
                [w.rotor_amplitude, w.stator_amplitude, w.normal_force, *w.synchronous.consistent.envelope] for w in (one, other)
            )
            assert others == pytest.approx(factor * np.array(parts), rel=1e-9)
            # without the unbalance: only the gap
            bare = changed(system, gap=factor * system.contact.gap)
            again = min(predict_system(bare, speed), key=lambda w: abs(w.frequency - one.frequency))
            assert again.frequency == one.frequency
            assert again.rotor_amplitude == pytest.approx(factor * one.rotor_amplitude, rel=1e-12)
    # a division and a product by 2 pi may each round
    assert abs(whirl_roots(system, TWO_PI * 70.0) / (TWO_PI * small[0].frequency) - 1.0).min() < 1e-15
