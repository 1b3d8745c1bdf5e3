"""Skew (cross-coupled) stiffness and damping in the analysis, against a scan, real matrices, closed forms and integration."""

import tomllib

import numpy as np
import pytest

from ross_rotors import DATA, system_of
from rsc.analysis.alone.free_vibration import free_growth, free_vibrations
from rsc.analysis.balance.balance import balance
from rsc.analysis.balance.floquet import balance_growth
from rsc.analysis.follow.lag import lag
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.receptance import contact_receptance, receptance_rotor, receptance_stator
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.paper.roots import whirl_roots
from rsc.analysis.paper.stability import whirl_eigenvalues, whirl_growth
from rsc.analysis.paper.whirls import steady_whirls, whirl_shapes, whirls_by_place
from rsc.analysis.survey.remarks import scene_remarks
from rsc.machine.imports.ross import read_ross
from rsc.system.system import stacked
from systems import (
    ANISOTROPIC,
    SKEW,
    TWO_PI,
    beside_scan,
    changed,
    jeffcott,
    make_system,
    quantity,
    random_rotor,
    random_system,
    reference,
    scan_grid,
    scanned_condition,
    with_skew,
)
from whirl_motions import distance_between, integrated, numerical_eigenvalues


def real_matrix(direct, skew, per_speed):
    """A complex matrix direct + i (skew - per_speed) as it acts on [y, z]."""
    turning = skew - per_speed
    return np.block([[direct, -turning], [turning, direct]])


def in_real_coordinates(system, Psi, Omega, body):
    """l^T r of the force e^{i Psi t} at the contact, from the real 2n x 2n equations of y and z."""
    mass, damping, stiffness = (quantity(system, f"{name}_{body}") for name in ("mass", "damping", "stiffness"))
    Q, S, contact = (quantity(system, f"{name}_{body}") for name in ("skew_damping", "skew_stiffness", "contact"))
    G = Omega * system.rotor.gyroscopic if body == "r" else 0.0 * mass
    none = 0.0 * mass
    real = real_matrix(stiffness, S, none) - Psi**2 * real_matrix(mass, none, none) + 1j * Psi * real_matrix(damping, Q, G)
    # cos and sin of a force that turns forward with Psi: y = Re, z = Re(-i ...)
    answer = np.linalg.solve(real, np.concatenate([contact, -1j * contact]))
    n = len(mass)
    assert answer[n:] == pytest.approx(-1j * answer[:n], rel=1e-6, abs=1e-9 * np.abs(answer).max())  # it stays circular
    return contact @ answer[:n]


def test_receptance_is_that_of_the_real_matrices():
    rng = np.random.default_rng(5)
    for _ in range(20):
        system = with_skew(rng, random_system(rng, least_stator=1))
        Psi, Omega = rng.uniform(-2e3, 2e3), rng.uniform(-500.0, 500.0)
        found = receptance_rotor(system, Psi, Omega), receptance_stator(system, Psi)
        wanted = [in_real_coordinates(system, Psi, Omega, body) for body in ("r", "s")]
        assert found == pytest.approx(wanted, rel=1e-6)


def test_derivatives_of_the_receptance_are_its_differences():
    rng = np.random.default_rng(6)
    system = with_skew(rng, random_system(rng, least_stator=2))
    Psi, step = np.array([-300.0, -40.0, 55.0]), 1e-3
    _, first, second = contact_receptance(system, 90.0, Psi)
    ahead, back = (contact_receptance(system, 90.0, Psi + move)[:2] for move in (step, -step))
    assert first == pytest.approx((ahead[0] - back[0]) / (2.0 * step), rel=1e-5)
    assert second == pytest.approx((ahead[1] - back[1]) / (2.0 * step), rel=1e-5)


def test_no_root_is_missed_or_invented():
    rng, grid, n_found = np.random.default_rng(21), scan_grid(), 0
    for _ in range(80):
        system, Omega = with_skew(rng, random_system(rng)), TWO_PI * rng.uniform(0.0, 100.0)
        roots = whirl_roots(system, Omega)
        assert np.all(np.diff(roots) > 0.0)
        assert np.abs(scanned_condition(system, roots, Omega)).max(initial=0.0) < 1e-8
        lost, odd, _ = beside_scan(system, Omega, roots, grid)
        assert len(lost) == len(odd) == 0
        n_found += len(roots)
    assert n_found > 320


def test_the_pencil_has_the_same_roots(monkeypatch):
    rng = np.random.default_rng(4)
    systems = [with_skew(rng, random_system(rng)) for _ in range(40)]
    plain = [whirl_roots(system, 200.0) for system in systems]
    monkeypatch.setattr("rsc.analysis.paper.roots._ELIMINATED", 0.0)
    for system, roots in zip(systems, plain, strict=True):
        assert whirl_roots(system, 200.0) == pytest.approx(roots, rel=1e-9)


@pytest.mark.parametrize("skew", [900.0, -900.0])
def test_laval_rotor_in_a_rigid_wall_has_a_closed_form(skew):
    mass, damping, stiffness, mu, skew_damping = 2.0, 30.0, 5e4, 0.2, 12.0
    system = changed(jeffcott(mass, damping, stiffness, mu), skew_stiffness_r=np.array([[skew]]),
                     skew_damping_r=np.array([[skew_damping]]))  # fmt: skip
    # mu (k - q Psi - m Psi^2) = S + b Psi
    wanted = np.sort(np.roots([mu * mass, damping + mu * skew_damping, skew - mu * stiffness]))
    assert whirl_roots(system, 100.0) == pytest.approx(wanted, rel=1e-12)
    # without friction only the skew stiffness holds against the damper
    slipping = changed(system, friction=0.0, damping_r=np.zeros((1, 1)))
    assert len(whirl_roots(slipping, 100.0)) == 0
    assert whirl_roots(changed(system, friction=0.0), 100.0) == pytest.approx([-skew / damping], rel=1e-12)


def test_skew_stiffness_alone_makes_a_whirl():
    """No friction, no damping, S < 0 in the rotor and S > 0 in the stator: S_r (a_s^2 + S_s^2) + S_s (a_r^2 + S_r^2) = 0."""
    one, S_r, S_s = np.ones((1, 1)), -900.0, 400.0
    stiff, none = (1.0 * one, 0.0 * one, 1e4 * one), 0.0 * one
    system = make_system((*stiff, none), (0.5 * one, none, 1e4 * one), (0, 0, 0.0, 1e7))
    system = changed(system, skew_stiffness_r=S_r * one, skew_stiffness_s=S_s * one)
    a_r, a_s = np.array([-1.0, 1e4]), np.array([-0.5, 1e4])  # polynomials of Psi^2
    squares = np.roots(S_r * np.polymul(a_s, a_s) + S_s * np.polymul(a_r, a_r) + S_r * S_s * np.array([0.0, 0.0, S_r + S_s]))
    halves = np.sqrt(squares[(np.abs(squares.imag) < 1e-9) & (squares.real > 0.0)].real)
    assert len(halves) > 0
    assert whirl_roots(system, 0.0) == pytest.approx(np.sort([*-halves, *halves]), rel=1e-9)


def test_energy_of_a_steady_whirl():
    rng, seen = np.random.default_rng(8), 0
    for _ in range(60):
        system, Omega = with_skew(rng, random_system(rng)), TWO_PI * rng.uniform(0.0, 100.0)
        Psi, F_N = steady_whirls(system, Omega)
        rotor, stator = whirl_shapes(system, Psi, F_N, Omega)
        for i in range(len(Psi)):
            fed = -system.law.friction * F_N[i] * law_of(system).distance(F_N[i]) * Psi[i]
            pairs = zip((rotor[i], stator[i]), system.bodies, strict=True)
            parts = [(x, body.damping, body.skew_stiffness) for x, body in pairs]
            # the dampers take, the skew stiffness gives or takes; skew damping does no work on a circle
            taken = sum((x.conj() @ (Psi[i] ** 2 * B + Psi[i] * S) @ x).real for x, B, S in parts)
            size = sum((np.abs(x) @ np.abs(Psi[i] ** 2 * B) @ np.abs(x)) for x, B, _ in parts)
            assert fed == pytest.approx(taken, rel=1e-6, abs=1e-7 * size)
            seen += 1
    assert seen > 60


def test_eigenvalues_are_those_of_the_nonlinear_equations():
    rng, seen = np.random.default_rng(7), 0
    while seen < 20:
        system, Omega = with_skew(rng, random_system(rng, most=3, least_stator=1)), TWO_PI * 30.0
        for Psi, F_N in zip(*steady_whirls(system, Omega), strict=True):
            if F_N < 1.0:
                continue
            wanted, residual = numerical_eigenvalues(system, Psi, F_N, Omega, 5.0)
            found = whirl_growth(system, Psi, F_N, Omega, 5.0).eigenvalues
            assert residual < 1e-8
            assert distance_between(np.append(found, 0.0), wanted) < 1e-5
            assert distance_between(wanted, np.append(found, 0.0)) < 1e-5
            seen += 1


def test_whirls_that_roll():
    system = changed(skew_laval(), diameter=4e-3, slip_velocity=0.01, friction=0.3)
    (roll,), Omega = rolling_whirls(system, TWO_PI * 30.0), TWO_PI * 30.0
    b_star = 0.5 * system.law.damping
    wanted, residual = numerical_eigenvalues(system, roll.Psi, roll.normal_force, Omega, b_star, roll.traction)
    assert residual < 1e-9
    assert roll.growth_rate == pytest.approx(np.delete(wanted, np.argmin(np.abs(wanted))).real.max(), rel=1e-4)
    (plain,) = rolling_whirls(changed(system, **dict.fromkeys(SKEW)), Omega)
    assert abs(plain.traction - roll.traction) > 0.01 * plain.traction


def skew_laval():
    """The Laval rotor of the reference with a skew stiffness and skew damping of a few percent in rotor and stator."""
    system = reference("laval")
    shares = (("r", -0.03), ("s", 0.02))
    fields = {f"skew_stiffness_{body}": share * quantity(system, f"stiffness_{body}") for body, share in shares}
    fields |= {f"skew_damping_{body}": 0.5 * quantity(system, f"damping_{body}") for body in ("r", "s")}
    return changed(system, **fields)


def test_growth_rate_is_that_of_the_integrated_motion():
    system = skew_laval()
    system = changed(system, contact_damping=0.0, contact_stiffness=0.1 * system.law.stiffness)
    Psi, F_N = (part[1] for part in steady_whirls(system, TWO_PI * 50.0))
    growth = whirl_growth(system, Psi, F_N, TWO_PI * 50.0)
    assert growth.rate > 15.0 and growth.frequency > 0.0  # 9.6 1/s without skew terms
    begin, end = 0.05, 0.2
    time, deviation = integrated(system, Psi, F_N, TWO_PI * 50.0, end)
    length = np.ceil(0.02 * growth.frequency / TWO_PI) * TWO_PI / growth.frequency
    early, late = ((time >= first) & (time < first + length) for first in (begin, end - length))
    sizes = [np.std(deviation[part]) for part in (early, late)]
    assert np.log(sizes[1] / sizes[0]) / (end - length - begin) == pytest.approx(growth.rate, rel=0.02)


def test_a_whirl_with_hardly_any_unbalance_grows_as_without():
    system = changed(skew_laval(), contact_damping=0.0)
    for name in ("unbalance", "unbalance_euler"):
        system = changed(system, **{name: 1e-4 * quantity(system, name)})
    whirl = predict_system(system, 50.0)[0]
    found = balance(system, whirl.frequency, 50.0)
    assert found.frequency == pytest.approx(whirl.frequency, rel=1e-6)
    assert balance_growth(system, found).rate == pytest.approx(whirl.growth_rate, rel=1e-4)


def test_a_moving_whirl_that_has_all_time_does_not_lag():
    system, n = skew_laval(), 5
    Psi, F_N = (part[0] for part in steady_whirls(system, TWO_PI * 50.0))
    behind = lag(system, np.arange(float(n)), np.full(n, TWO_PI * 50.0), np.full(n, Psi), np.full(n, F_N))
    assert np.abs(behind.rotor).max() < 1e-9


def test_systems_in_a_stack_have_the_bits_they_have_alone():
    rng = np.random.default_rng(3)
    plain = random_rotor(rng)
    systems = [with_skew(rng, plain) for _ in range(6)]
    stack, Omega = stacked(systems), rng.uniform(50.0, 400.0, len(systems))
    place, Psi, F_N = whirls_by_place(stack, Omega)
    assert len(Psi) > 2
    eigenvalues = whirl_eigenvalues(stack.at(place), Psi, F_N, Omega[place])
    for i, system in enumerate(systems):
        alone = steady_whirls(system, Omega[i])
        assert [part.tobytes() for part in alone] == [part[place == i].tobytes() for part in (Psi, F_N)]
        assert np.array_equal(whirl_eigenvalues(system, *alone, Omega[i]), eigenvalues[place == i])


def test_a_stack_has_zeros_for_what_only_some_of_its_systems_have():
    rng = np.random.default_rng(3)
    plain = random_rotor(rng)
    skew = with_skew(rng, plain)
    assert stacked([plain, plain]).skew is False
    part = {"anisotropic_stiffness_r": 1j * plain.rotor.stiffness}
    mixed = stacked([plain, changed(skew, **part)])
    for name in (*SKEW, "anisotropic_stiffness_r"):
        assert not quantity(mixed, name)[0].any() and quantity(mixed, name)[1].any()
    assert [name for name in ANISOTROPIC if quantity(mixed, name) is not None] == [*part]
    assert mixed.at(np.array([1, 1, 0])).stator.skew_damping.shape == (3, *plain.stator.mass.shape)
    place, Psi, _ = whirls_by_place(mixed, np.array([200.0, 200.0]))
    assert Psi[place == 0] == pytest.approx(steady_whirls(plain, 200.0)[0], rel=1e-12)


# ---------------------------------------------------------------- free vibrations


def driven_laval(share):
    """Laval rotor with forward-driving skew stiffness k_s = share * b omega, where share 1 is the onset of instability."""
    system = jeffcott(mass=2.0, damping=30.0, stiffness=5e4)
    omega = np.sqrt(5e4 / 2.0)
    return changed(system, skew_stiffness_r=-np.array([[share * 30.0 * omega]])), omega


def test_a_laval_rotor_turns_unstable_where_the_skew_stiffness_is_damping_times_frequency():
    for share in (0.999, 1.001):
        system, omega = driven_laval(share)
        backward, forward = free_vibrations(system, 20.0)
        assert (forward.growth_rate > 0.0) == (share > 1.0) == (forward.decrement < 0.0)
        assert free_growth(system, 0.0) == pytest.approx(forward.growth_rate, rel=1e-12)
        assert backward.growth_rate < -10.0
        assert (TWO_PI * forward.frequency, TWO_PI * backward.frequency) == pytest.approx((omega, -omega), rel=1e-2)
    system, omega = driven_laval(1.0)
    assert free_vibrations(system, 0.0)[1].growth_rate == pytest.approx(0.0, abs=1e-9)
    assert free_vibrations(system, 0.0)[1].frequency == pytest.approx(omega / TWO_PI, rel=1e-12)


def test_free_vibrations_are_those_of_the_real_matrices():
    rng = np.random.default_rng(12)
    for _ in range(10):
        system, speed = with_skew(rng, random_system(rng)), rng.uniform(0.0, 100.0)
        n, none = system.n_rotor, 0.0 * system.rotor.mass
        inverse = np.linalg.inv(real_matrix(system.rotor.mass, none, none))
        stiffness = real_matrix(system.rotor.stiffness, system.rotor.skew_stiffness, none)
        damping = real_matrix(system.rotor.damping, system.rotor.skew_damping, TWO_PI * speed * system.rotor.gyroscopic)
        lower = [-inverse @ stiffness, -inverse @ damping]
        wanted = np.linalg.eigvals(np.block([[np.zeros((2 * n, 2 * n)), np.eye(2 * n)], lower]))
        found = free_vibrations(system, speed)
        values = np.array([v.growth_rate + 1j * TWO_PI * v.frequency for v in found])
        assert len(values) == 2 * n
        # the real system has every one of them and its conjugate
        assert distance_between(np.concatenate([values, values.conj()]), wanted) < 1e-8
        assert distance_between(wanted, np.concatenate([values, values.conj()])) < 1e-8


def test_decrements_of_a_compressor_are_those_of_ross():
    """9,000 rpm: 1.77 backward and 0.73 forward by ROSS's modal analysis; 1.21 and 1.28 without the skew terms."""
    told = tomllib.loads((DATA / "machines" / "ross_decrements.toml").read_text())
    system = system_of(read_ross(DATA / "machines" / "ross_compressor_9000rpm.mat", told["speed"]))

    def pair(system):
        found = sorted((v.frequency, v.decrement) for v in free_vibrations(system, told["speed"]))
        return [[f, decrement] for f, decrement in found if 155.0 < abs(f) < 175.0]

    assert pair(system) == [pytest.approx(row, rel=1e-6) for row in told["pair"]]
    mean = changed(system, **dict.fromkeys(ANISOTROPIC))
    assert [row[1] for row in pair(mean)] == pytest.approx([1.7733, 0.7257], abs=1e-4)
    assert [row[1] for row in pair(changed(mean, **dict.fromkeys(SKEW)))] == pytest.approx([1.2145, 1.2811], abs=1e-4)


def test_a_rotor_that_is_unstable_without_contact_is_told():
    told = [scene_remarks(driven_laval(share)[0], []) for share in (0.9, 1.2)]
    assert told[0] == []
    motion = "it vibrates at 25.1770 Hz, logarithmic decrement -0.0594"
    assert told[1] == [f"the rotor is unstable without contact at a rotor speed of 50 Hz: {motion}"]


def test_a_rotor_without_skew_terms_is_not_asked_for_its_vibrations(monkeypatch):
    monkeypatch.setattr("rsc.analysis.survey.remarks.free_vibrations", None)
    assert scene_remarks(reference("laval"), []) == []
