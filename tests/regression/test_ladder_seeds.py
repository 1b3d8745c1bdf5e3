"""What the closed forms of the ladder do not see: tests for seeded bugs (tools/seeded_bugs.toml) that survived the others."""

import math
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest

import rsc
from rsc.analysis.paper.roots import whirl_roots
from rsc.kernel.clock import Clock, Segment, ahead
from rsc.kernel.simd.jit import entry
from rsc.measure.course import course, windows_of
from rsc.measure.features import contact_strip, waterfall
from scenes import SCENES, changed
from systems import make_system


@entry
def _many_steps(segment, clock, h, count):
    for _ in range(count):
        clock = ahead(segment, clock, h)
    return clock


def test_clock_of_a_long_run_does_not_drift():
    """Ten million steps of 1e-5 s from 500 s on: the time is their exact sum to 1e-17 s, the rotation stays within one turn and
    has the phase of the exact product to 1e-9 turns (each step rounds it by 1e-16)."""
    count, h, speed = 10_000_000, 1e-5, 97.3
    segment = Segment(0.0, 1e4, speed, 0.0, (), (), ())
    clock = _many_steps(segment, Clock(500.0, 0.0, 0.25, speed, 0.0, 0.0, 1.0, (), (), ()), h, count)
    exact = Fraction(500) + count * Fraction(h)
    assert abs(Fraction(clock.hi) + Fraction(clock.lo) - exact) < Fraction(1, 10**17)
    turns = Fraction(1, 4) + count * Fraction(h) * Fraction(speed)
    assert 0.0 <= clock.phase < 1.0
    assert abs(clock.phase - float(turns - math.floor(turns))) < 1e-9


def test_slip_in_the_contact_strip_is_that_of_the_surface():
    """v_rel = Omega d_R/2 + Im(d' conj d)/|d|: on a whirl with Coulomb friction, by differences of the stored deflections."""
    diameter = 0.02
    coulomb = {"diameter": diameter, "slip_velocity": 0.01}
    tables = changed(SCENES["whirl, unbalance, run-up"], contact=coulomb, output={"rate": 16384.0})
    result = rsc.simulate(rsc.Scene.from_dict(tables))
    fall = waterfall(result, window=0.05)
    features = course(result, windows_of(result, 0.05), False).features
    strip = contact_strip(result, fall, features)
    d = result.contact_rotor() - result.contact_stator()
    tangential = np.gradient(np.unwrap(np.angle(d)), result.time) * np.abs(d)
    slip = 2 * np.pi * result.speed * diameter / 2 + tangential
    half = 0.5 * fall.window
    for i, centre in enumerate(fall.time):
        inside = (result.time >= centre - half) & (result.time < centre + half)
        assert abs(strip.slip_velocity[i] / slip[inside].mean() - 1.0) < 1e-3


def test_stored_normal_force_is_the_law_of_the_stored_motion():
    """F_N = max(0, k p + b min(p', 0)) with p' by differences of finely sampled deflections; pressing, separating and clipped."""
    tables = changed(SCENES["bouncing"], contact={"damping_ratio": 0.3}, output={"rate": 262_144.0}, drive={"duration": 0.05})
    result = rsc.simulate(rsc.Scene.from_dict(tables))
    contact = result.scene.contact
    p = np.abs(result.contact_rotor() - result.contact_stator()) - contact.gap
    damper = contact.damping * np.minimum(np.gradient(p, result.time), 0.0)
    force = np.where(p > 0, np.maximum(contact.stiffness * p + damper, 0.0), 0.0)
    undamped = np.abs(contact.stiffness * np.maximum(p, 0.0) - force).max()
    assert result.contact_onsets >= 2 and undamped > 0.05 * force.max()
    # at a kink of p' the difference is one-sided: those few samples differ more
    assert np.quantile(np.abs(result.normal_force - force), 0.999) < 1e-3 * force.max()


def test_coulomb_friction_reverses_where_a_scene_is_named_after_it():
    """Sliding forward, creeping and sliding backward all occur in contact, and mu sigma is that of the slip."""
    tables = changed(SCENES["Coulomb friction that reverses"], output={"rate": 8192.0})
    result = rsc.simulate(rsc.Scene.from_dict(tables))
    contact, pressed = result.scene.contact, result.normal_force > 0.0
    sigma = result.friction_force[pressed] / result.normal_force[pressed] / contact.friction
    slip = np.pi * result.speed[pressed] * contact.diameter + result.tangential_velocity[pressed]
    assert np.abs(sigma - np.clip(slip / contact.slip_velocity, -1.0, 1.0)).max() < 1e-6
    assert min((sigma == 1.0).sum(), (sigma == -1.0).sum(), (np.abs(sigma) < 0.9).sum()) >= 5


@pytest.mark.parametrize("light", [1e-8, 1e-10])
def test_whirl_roots_are_exact_beside_a_mode_a_million_times_faster(light):
    """Im[(1 + i mu) H] = 0 in 40 digits; the eigenvalue alone is some 40 roundings off, polishing makes it exact."""
    k_link, k_end, k_r, k_s, mu = 5e6, 3e6, (60.0 * math.pi) ** 2, 222066.0, 0.2
    rotor = (np.diag([1.0, light]), np.diag([8.0, 0.5]), np.array([[k_r + k_link, -k_link], [-k_link, k_link + k_end]]))
    stator = tuple(np.array([[value]]) for value in (0.25, 47.0, k_s))
    system = make_system((*rotor, np.zeros((2, 2))), stator, (0, 0, mu, 3.5e6))

    def condition(psi):
        end = k_link + k_end - psi**2 * light + 0.5j * psi
        link = mp.mpf(float(system.rotor.stiffness[0, 0])) - psi**2 + 8j * psi - mp.mpf(k_link) ** 2 / end
        return mp.im((1 + 1j * mp.mpf(mu)) * (1 / link + 1 / (k_s - psi**2 / 4 + 47j * psi)))

    roots = whirl_roots(system, 300.0)
    assert len(roots) == 2
    for root in roots:
        with mp.workdps(40):
            start = (mp.mpf(root) * (1 - mp.mpf(10) ** -7), mp.mpf(root) * (1 + mp.mpf(10) ** -7))
            exact = mp.findroot(condition, start, solver="secant", tol=1e-60, verify=False)
            assert abs(exact / root - 1) < 1e-15
