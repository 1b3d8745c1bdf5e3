"""The unbalance in contact: the lines of a whirl against integration and the written equations; the forward rub."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rsc.analysis.paper.receptance import receptance
from rsc.analysis.paper.roots import whirl_roots
from rsc.analysis.paper.synchronous import forward_rub, synchronous_resonance, synchronous_response, unbalance_response
from rsc.analysis.paper.whirls import normal_force, whirl_shapes
from systems import TWO_PI, accelerations, changed, contact_force, expected, fixed_frame_rate, jeffcott, random_system, reference
from tiers import nightly


def whirls(system, Omega):
    Psi = whirl_roots(system, Omega)
    F_N = normal_force(system, Psi, Omega)
    return Psi[F_N > 0.0], F_N[F_N > 0.0]


def test_unbalance_response_solves_the_equation_of_motion():
    system = changed(reference("gyroscopic_disk_light"), ring_ecc=2e-5 + 1e-5j)
    speeds = np.array([0.0, 100.0, 290.0])
    rotor, E = unbalance_response(system, speeds)
    for i, Omega in enumerate(speeds):
        A = system.rotor.stiffness - Omega**2 * (system.rotor.mass - system.rotor.gyroscopic) + 1j * Omega * system.rotor.damping
        assert A @ rotor[i] == pytest.approx(system.rotor.unbalance * Omega**2, rel=1e-9, abs=1e-12)
        assert E[i] == pytest.approx(rotor[i, 0] + 2e-5 + 1e-5j)


# ---------------------------------------------------------------- synchronous part of a whirl


def test_rigid_limit_is_the_pair_of_equations_of_the_theory():
    system = changed(reference("mdof_2x2"), contact_stiffness=np.inf)
    Omega, mu, gap = TWO_PI * 17.0, system.law.friction, system.contact.gap
    Psi, F_N = whirls(system, Omega)
    consistent, printed = synchronous_response(system, Psi, F_N, Omega)
    _, E = unbalance_response(system, Omega)
    for i in range(len(Psi)):
        # in the phase where F_Psi is real
        F_Psi = np.hypot(1.0, mu) * F_N[i]
        q = gap * (1.0 - 1j * mu) / (2.0 * np.sqrt(1.0 + mu**2) * F_Psi)
        H, H_m = receptance(system, Omega, Omega), receptance(system, 2.0 * Psi[i] - Omega, Omega)
        F_Omega, G = np.linalg.solve([[H + q, -q], [-np.conj(q), np.conj(H_m) + np.conj(q)]], [E, 0.0])
        assert abs(consistent.force[i]) == pytest.approx(abs(F_Omega), rel=1e-9)
        assert abs(consistent.mirror_force[i]) == pytest.approx(abs(G), rel=1e-9)
        assert abs(printed.force[i]) == pytest.approx(abs(E / (H + 2.0 * q)), rel=1e-9)
        assert printed.mirror_force[i] == 0.0 == printed.mirror_line[i]


def test_an_elastic_contact_brings_its_flexibility_and_half_its_damping():
    system = changed(reference("mdof_2x2"), contact_stiffness=2e5)
    Omega, c = TWO_PI * 17.0, 1.0 + 1j * system.law.friction
    Psi, F_N = whirls(system, Omega)
    consistent, printed = synchronous_response(system, Psi, F_N, Omega)
    _, E = unbalance_response(system, Omega)
    H = receptance(system, Omega, Omega)
    for i in range(len(Psi)):
        wanted = E / (H + system.contact.gap / (c * F_N[i]) + 1.0 / (c * system.law.stiffness))
        assert printed.force[i] == pytest.approx(wanted, rel=1e-9)
        q = (system.contact.gap / F_N[i] + 1.0 / system.law.stiffness) / 2.0
        p = 1.0 / (2.0 * system.law.stiffness + 1j * (Omega - Psi[i]) * system.law.damping)
        H_m = np.conj(receptance(system, 2.0 * Psi[i] - Omega, Omega))
        rows = [[H + (q + p) / c, -(q - p) / np.conj(c)], [-(q - p) / c, H_m + (q + p) / np.conj(c)]]
        assert consistent.force[i] == pytest.approx(np.linalg.solve(rows, [E, 0.0])[0], rel=1e-9)


@pytest.mark.parametrize(
    ("name", "frequency", "speed", "softer"), [nightly("laval", -60.66, 50.0, 1.0), ("mdof_2x2", -38.04, 12.0, 0.03)]
)
def test_lines_are_those_of_the_integrated_motion(name, frequency, speed, softer):
    system, Omega, share = reference(name), TWO_PI * speed, 0.01
    # smooth law (no one-sided damper), small unbalance: what is left is first order
    system = changed(system, contact_damping=0.0, contact_stiffness=softer * system.law.stiffness)
    if name == "mdof_2x2":  # with more damping the transients end earlier
        system = changed(system, damping_s=4.0 * system.stator.damping, damping_r=4.0 * system.rotor.damping)
        system = changed(system, friction=4.0 * system.law.friction)
    Psi, F_N = whirls(system, Omega)
    i = np.argmin(np.abs(Psi - TWO_PI * frequency))
    consistent, printed = synchronous_response(system, Psi[i], F_N[i], Omega)
    shape = np.concatenate(whirl_shapes(system, Psi[i], F_N[i], Omega))
    duration = 2.5
    time = np.linspace(duration - 0.4, duration, 4001)
    start = np.concatenate([shape, 1j * Psi[i] * shape])
    rate = fixed_frame_rate(system, Omega, unbalance=share)
    solution = solve_ivp(rate, (0.0, duration), start, "DOP853", time, rtol=1e-9, atol=1e-13)
    frequencies = np.array([Psi[i], Omega, 2.0 * Psi[i] - Omega])
    waves = np.exp(1j * frequencies * time[:, None])
    amplitudes, *_ = np.linalg.lstsq(waves, system.rotor.contact @ solution.y[: system.n_rotor], rcond=None)
    _, line, mirror_line = np.abs(amplitudes) / share
    assert consistent.line == pytest.approx(line, rel=1e-4)
    assert consistent.mirror_line == pytest.approx(mirror_line, rel=1e-3)
    # the form printed in the paper is not of first order
    assert printed.line != pytest.approx(line, rel=0.03)


@pytest.mark.parametrize("b_star", [0.0, 300.0])
def test_lines_of_the_force_follow_from_those_of_the_distance(b_star):
    # of the one-sided damper small motions see the half
    system, Omega, share = changed(reference("mdof_2x2"), contact_damping=2.0 * b_star), TWO_PI * 17.0, 1e-6
    Psi, F_N = whirls(system, Omega)
    part, _ = synchronous_response(system, Psi, F_N, Omega)
    _, E = unbalance_response(system, Omega)
    beat = np.exp(2j * np.pi * np.arange(64) / 64)
    for i in range(len(Psi)):
        line = E - receptance(system, Omega, Omega) * part.force[i]
        mirror_line = -receptance(system, 2.0 * Psi[i] - Omega, Omega) * part.mirror_force[i]
        # d = (d_0 + y) e^{i Psi t} of the contact law at 64 instants of the beat
        d = system.contact.gap + F_N[i] / system.law.stiffness + share * (line * beat + mirror_line / beat)
        y_dot = share * 1j * (Omega - Psi[i]) * (line * beat - mirror_line / beat)
        force = [contact_force(system, *pair, b_star) for pair in zip(d, y_dot + 1j * Psi[i] * d, strict=True)]
        size = abs(part.force[i])
        assert np.mean(force / beat) / share == pytest.approx(part.force[i], abs=1e-4 * size)
        assert np.mean(force * beat) / share == pytest.approx(part.mirror_force[i], abs=1e-4 * size)


def test_ring_eccentricity_and_unbalance_add_in_the_ring():
    system, Omega = reference("laval"), TWO_PI * 50.0
    Psi, F_N = whirls(system, Omega)
    rotor, E = unbalance_response(system, Omega)
    # a ring that undoes the response without contact leaves no synchronous force and the free unbalance line
    still = changed(system, ring_ecc=-complex(E))
    for part in synchronous_response(still, Psi, F_N, Omega):
        assert np.abs(part.force) == pytest.approx(0.0 * F_N, abs=1e-10 * F_N.max())
        assert part.line == pytest.approx(np.full(len(Psi), abs(rotor[0])), rel=1e-9)


def test_envelope_is_the_range_over_the_beat():
    system, Omega = reference("mdof_2x2"), TWO_PI * 23.0
    Psi, F_N = whirls(system, Omega)
    beat = np.exp(1j * np.linspace(0.0, TWO_PI, 200_001))
    for part in synchronous_response(system, Psi, F_N, Omega):
        for i in range(len(Psi)):
            H_r = [receptance_of_rotor(system, frequency, Omega) for frequency in (Omega, 2.0 * Psi[i] - Omega)]
            whirl = whirl_shapes(system, Psi[i], F_N[i], Omega)[0] @ system.rotor.contact
            line = unbalance_response(system, Omega)[0] @ system.rotor.contact - H_r[0] * part.force[i]
            mirror_line = -H_r[1] * part.mirror_force[i]
            assert part.line[i] == pytest.approx(abs(line)) and part.mirror_line[i] == pytest.approx(abs(mirror_line))
            amplitude = np.abs(whirl + line * beat + mirror_line / beat)
            assert part.low[i] == pytest.approx(amplitude.min(), rel=1e-7, abs=1e-9 * amplitude.max())
            assert part.high[i] == pytest.approx(amplitude.max(), rel=1e-7)


def receptance_of_rotor(system, Psi, Omega):
    return receptance(changed(system, contact_s=0.0 * system.stator.contact), Psi, Omega)


def test_envelope_of_the_laval_reference():
    low, high = expected("laval")["envelope"]["rotor"]
    system, Omega = reference("laval"), TWO_PI * expected("laval")["envelope"]["speed"]
    Psi, F_N = whirls(system, Omega)
    part, printed = synchronous_response(system, Psi[1], F_N[1], Omega)
    # simulated with the one-sided damper; the theory is first order in the unbalance
    assert [part.low / system.contact.gap, part.high / system.contact.gap] == pytest.approx([low, high], rel=2e-3)
    assert printed.high / system.contact.gap > high + 0.03


# ---------------------------------------------------------------- forward rub


def random_rubs(n_wanted):
    rng, found = np.random.default_rng(3), 0
    while found < n_wanted:
        system = random_system(rng, most=4)
        system = changed(system, gap=3e-5, ring_ecc=1e-5j)
        Omega = TWO_PI * rng.uniform(2.0, 100.0)
        for motion in forward_rub(system, Omega):
            found += 1
            yield system, Omega, motion


def test_forward_rub_fulfils_the_nonlinear_equations():
    for system, Omega, motion in random_rubs(40):
        rotor, stator = motion.rotor_shape, motion.stator_shape
        d = system.rotor.contact @ rotor - system.stator.contact @ stator + system.contact.ring
        assert abs(d) == pytest.approx(motion.distance, rel=1e-9) and abs(d) > system.contact.gap
        assert np.angle(d * np.exp(-1j * motion.contact_angle)) == pytest.approx(0.0, abs=1e-7)
        assert motion.amplitude == pytest.approx(abs(system.rotor.contact @ rotor))
        # the ring's part of d enters the force law as a shift of the contacting coordinate
        shifted = rotor + system.contact.ring * system.rotor.contact
        state = np.concatenate([shifted, stator, 1j * Omega * shifted, 1j * Omega * stator])
        inertia = system.rotor.mass - system.rotor.gyroscopic
        A_ring = system.rotor.stiffness - Omega**2 * inertia + 1j * Omega * system.rotor.damping
        moved = np.linalg.solve(system.rotor.mass, A_ring @ (system.contact.ring * system.rotor.contact))
        found = accelerations(system, state, Omega, b_star=0.0, unbalance=1.0)
        found[: system.n_rotor] += moved
        wanted = -(Omega**2) * np.concatenate([shifted, stator])
        # the acceleration is a small difference of the forces of springs and contact
        size = system.law.stiffness * abs(d) / min(np.diag(system.rotor.mass).min(), 0.1)
        assert np.abs(found - wanted).max() < 1e-9 * size
        force = (1.0 + 1j * system.law.friction) * motion.normal_force
        assert abs(force) == pytest.approx(motion.force, rel=1e-12)
        assert motion.normal_force == pytest.approx(system.law.stiffness * (abs(d) - system.contact.gap), rel=1e-5)


def test_a_rotor_below_the_gap_does_not_rub():
    assert forward_rub(reference("gyroscopic_disk_very_light"), TWO_PI * 5.0) == []
    assert np.isnan(synchronous_resonance(reference("gyroscopic_disk_very_light"), (1.0, 10.0)))


def test_forward_rub_in_a_rigid_wall_stays_at_the_gap():
    system, Omega = jeffcott(damping=2.0), 200.0  # at the resonance of the free rotor
    (motion,) = forward_rub(system, Omega)
    assert motion.amplitude == pytest.approx(system.contact.gap, rel=1e-12)
    # power of the unbalance = friction + damping
    fed = (system.rotor.unbalance[0] * Omega**2 * np.conj(1j * Omega * motion.rotor_shape[0])).real
    taken = system.law.friction * motion.normal_force * system.contact.gap * Omega + 2.0 * (Omega * system.contact.gap) ** 2
    assert fed == pytest.approx(taken, rel=1e-9)


@pytest.mark.parametrize("name", ["gyroscopic_disk_light", "gyroscopic_disk_very_light"])
def test_synchronous_resonance_in_contact(name):
    table = expected(name)["synchronous_resonance"]
    found = synchronous_resonance(reference(name), (TWO_PI * 20.0, TWO_PI * 80.0)) / TWO_PI
    assert found == pytest.approx(table["frequency"], abs=0.01)
    assert found == pytest.approx(table["published"], abs=0.15)  # read off the paper's figure


def test_synchronous_resonance_is_the_largest_forward_rub():
    system = reference("gyroscopic_disk_light")
    speeds = TWO_PI * np.linspace(30.0, 60.0, 601)
    largest = [max((motion.amplitude for motion in forward_rub(system, Omega)), default=0.0) for Omega in speeds]
    found = synchronous_resonance(system, (speeds[0], speeds[-1]))
    assert found == pytest.approx(speeds[np.argmax(largest)], abs=TWO_PI * 0.05)
