"""The forward rub: its range against the quadratic, its stability against the simulator, and what attracts at a speed."""

import numpy as np
import pytest
import scipy.linalg

import rsc
from rsc.analysis.follow.forward_rub import FOLD, OSCILLATORY, TOUCH, attractors, rub_growth, rub_ranges
from rsc.analysis.paper.stability import state_matrices
from rsc.analysis.paper.synchronous import forward_rub, unbalance_response
from systems import TWO_PI, changed, expected, reference, reference_scene


def simulated(scene, system, speed, duration, off=0.0):
    """A run at constant speed from the largest forward rub, its first coordinate moved by a share of the gap."""
    rub = forward_rub(system, TWO_PI * speed)[-1]
    parts = []
    for shape in (rub.rotor_shape, rub.stator_shape):
        moved = shape + 0.0
        parts.append([[float(z.real), float(z.imag)] for z in moved])
        parts.append([[float(z.real), float(z.imag)] for z in 1j * TWO_PI * speed * moved])
    parts[0][0][0] += off * system.contact.gap
    keys = ("rotor", "rotor_velocity", "stator", "stator_velocity")
    start = {**dict(zip(keys, parts, strict=True)), "allow_penetration": True}
    content = {**scene.to_dict(), "start": start, "drive": {"speed": speed, "duration": duration}}
    content["solver"]["rtol"] = 1e-9
    return rub, rsc.simulate(rsc.Scene.from_dict(content))


@pytest.fixture(scope="module")
def bouncing():
    scene = reference_scene("bouncing").with_values({"contact.damping": 0.0})
    return scene, changed(reference("bouncing"), contact_damping=0.0)


@pytest.mark.parametrize("speed", [40.0, 44.5])
def test_small_motions_of_the_simulated_rub_are_those_of_the_eigenvalues(bouncing, speed):
    scene, system = bouncing
    off = 2e-4 * system.contact.gap
    rub, result = simulated(scene, system, speed, 0.3, off=2e-4)
    Omega = TWO_PI * speed
    growth = rub_growth(system, rub, Omega)
    # the contact lies at angle 0 in the equations; the fixed velocity is kept: x' = -i Omega x in the turning frame
    contact = np.exp(1j * rub.contact_angle)
    x, x_dot = np.array([off, 0.0]) / contact, np.array([-1j * Omega * off, 0.0]) / contact
    state = np.concatenate([x.real, x.imag, x_dot.real, x_dot.imag])
    matrix = state_matrices(system, np.array([Omega]), np.array([rub.normal_force]), Omega, 0.0)[0]
    turning = result.contact_rotor() * np.exp(-1j * Omega * result.time) - rub.rotor_shape[0]
    for i in range(20, 200, 20):
        wanted = scipy.linalg.expm(matrix * result.time[i]) @ state
        assert turning[i] == pytest.approx((wanted[0] + 1j * wanted[2]) * contact, abs=0.02 * np.abs(turning[i - 20 : i]).max())
    assert (growth.rate < 0.0) == (speed == 40.0)
    # the deviation has grown or decayed with the rate
    assert growth.rate == pytest.approx(np.linalg.eigvals(matrix).real.max(), rel=1e-9)


def test_a_rub_is_an_equilibrium_of_the_simulator(bouncing):
    scene, system = bouncing
    rub, result = simulated(scene, system, 40.0, 0.5)
    assert np.abs(result.contact_rotor()).min() == pytest.approx(rub.amplitude, rel=1e-7)
    assert np.abs(result.contact_rotor()).max() == pytest.approx(rub.amplitude, rel=1e-7)


@pytest.mark.parametrize("name", ["gyroscopic_disk_light", "laval", "mdof_2x2", "gyroscopic_transition"])
def test_ranges_are_where_the_quadratic_has_solutions(name):
    system = reference(name)
    coarse = rub_ranges(system, np.linspace(5.0, 60.0, 56))
    for speed in np.linspace(5.3, 59.7, 777):
        ranges = [r for r in coarse if r.begin.speed < speed < r.end.speed]
        assert len(ranges) == len(forward_rub(system, TWO_PI * speed)), speed
    assert {r.solution for r in coarse} == {0, 1}
    for r in coarse:
        for place in (r.begin, r.end):
            if place.cause == TOUCH:
                assert abs(unbalance_response(system, TWO_PI * place.speed)[1]) == pytest.approx(system.contact.gap, rel=1e-9)
            if place.cause == FOLD:
                low, high = (forward_rub(system, TWO_PI * place.speed * (1.0 + off)) for off in (-1e-9, 1e-9))
                assert len(low) + len(high) == 2
                pair = max(low, high, key=len)
                assert pair[0].force == pytest.approx(pair[1].force, rel=1e-2)


def test_the_smaller_rub_is_unstable_and_the_pair_merges_at_rate_zero():
    system = reference("gyroscopic_disk_light")
    large, small = rub_ranges(system, np.linspace(20.0, 150.0, 131))
    assert large.end == small.end and large.end.cause == FOLD
    assert large.stable.all() and not small.stable.any()
    # the larger one is on its resonance just below its fold
    assert large.speed[np.argmax(large.amplitude)] == pytest.approx(
        expected("gyroscopic_disk_light")["synchronous_resonance"]["frequency"], abs=1.0
    )
    near = large.end.speed * (1.0 - 1e-9)
    rates = [rub_growth(system, rub, TWO_PI * near).rate for rub in forward_rub(system, TWO_PI * near)]
    assert abs(rates[0]) < 0.1 * abs(small.growth_rate).max()


def test_stability_of_the_rub_is_lost_where_its_rate_changes_sign():
    system = reference("bouncing")
    ranges = rub_ranges(system, np.linspace(15.0, 60.0, 91))
    [event] = [e for r in ranges for e in r.events]
    assert event.cause == OSCILLATORY and event.holds == "below"
    rates = []
    for off in (-1e-6, 1e-6):
        Omega = TWO_PI * event.speed * (1.0 + off)
        rates.append(rub_growth(system, forward_rub(system, Omega)[-1], Omega).rate)
    assert rates[0] < 0.0 < rates[1]
    # the same whatever the grid
    fine = [e for r in rub_ranges(system, np.linspace(15.0, 60.0, 333)) for e in r.events]
    assert fine[0].speed == pytest.approx(event.speed, rel=1e-9)


def test_a_stretch_narrower_than_the_grid_is_told_and_kept_in_the_points():
    """The rub of the grid's last speed alone is unstable; the points beside the event show it to pictures."""
    system = reference("bouncing")
    (found,) = rub_ranges(system, np.linspace(15.0, 60.0, 11))
    (event,) = found.events
    assert found.stretches(found.stable) == [(found.begin.speed, event.speed)]
    assert found.stretches(~found.stable) == [(event.speed, found.end.speed)]
    (change,) = np.flatnonzero(np.diff(found.stable))
    assert np.diff(found.speed)[change] == pytest.approx(2e-6 * event.speed, rel=1e-3)


def test_a_narrow_range_between_two_speeds_is_found():
    system = reference("laval")
    ranges = rub_ranges(system, [20.0, 25.0, 30.2, 35.0, 40.0])
    assert [r.begin.cause for r in ranges] == [TOUCH, TOUCH]
    assert ranges[0].begin.speed == pytest.approx(29.571211, rel=1e-6)


def test_attractors_are_what_the_simulator_ends_on():
    scene, system = reference_scene("gyroscopic_disk_light"), reference("gyroscopic_disk_light")
    found = attractors(system, 42.0)
    stable = {a.kind: a for a in found if a.stable}
    assert [a.kind for a in found if a.stable] == ["forward rub", "backward whirl", "backward whirl"]
    content = {**scene.to_dict(), "start": {"rest": True}, "drive": {"speed": 42.0, "duration": 12.0}}
    result = rsc.simulate(rsc.Scene.from_dict(content))
    tail = np.abs(result.contact_rotor()[-500:])
    assert tail == pytest.approx(stable["forward rub"].amplitude, rel=1e-4)


def test_no_contact_is_an_attractor_while_the_response_is_inside_the_gap():
    system = reference("laval")
    inside, outside = attractors(system, 50.0), attractors(system, 30.0)
    assert inside[0].kind == "no contact" and inside[0].stable
    # free decay of the rotor, the slower body: damping ratio times frequency
    assert inside[0].growth_rate == pytest.approx(-0.02 * TWO_PI * 30.0, rel=1e-9)
    assert outside[0].kind == "forward rub"


def test_rigid_contact_is_refused():
    system = changed(reference("laval"), contact_stiffness=np.inf)
    rub = forward_rub(system, TWO_PI * 30.0)[0]
    with pytest.raises(ValueError, match="finite contact stiffness"):
        rub_growth(system, rub, TWO_PI * 30.0)
