"""Whirl roots, forces, shapes and side conditions: laws of (19)-(27), closed forms and the reference numbers."""


import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import (
    coupled_frequencies,
    natural_frequencies,
    receptance,
    receptance_rotor,
    receptance_stator,
    uncoupled_frequencies,
)
from rsc.analysis.paper.roots import whirl_roots
from rsc.analysis.paper.stability import whirl_eigenvalues
from rsc.analysis.paper.synchronous import synchronous_response
from rsc.analysis.paper.whirls import normal_force, side_conditions, steady_whirls, whirl_shapes, whirls_by_place
from rsc.system.system import stacked
from systems import TWO_PI, beside_scan, changed, expected, jeffcott, make_system, quantity, random_system, reference, scan_grid

GYROSCOPIC = "gyroscopic_disk_very_light"


def stator_frequencies(system):
    """Signed undamped natural frequencies of the stator alone, (2 M,) rad/s."""
    return natural_frequencies(system.stator.mass, system.stator.stiffness, np.zeros_like(system.stator.mass), 0.0)


def plain_receptances(system, Psi, Omega):
    """(25), (26) as they are written, for one Psi."""
    G_R = -1j * Omega * system.rotor.gyroscopic
    A_R = system.rotor.stiffness - Psi**2 * system.rotor.mass + 1j * Psi * (system.rotor.damping + G_R)
    A_S = system.stator.stiffness - Psi**2 * system.stator.mass + 1j * Psi * system.stator.damping
    H_R = system.rotor.contact @ np.linalg.inv(A_R) @ system.rotor.contact
    return H_R, system.stator.contact @ np.linalg.inv(A_S) @ system.stator.contact


def residual(system, Psi, Omega):
    cH = (1.0 + 1j * system.law.friction) * sum(plain_receptances(system, Psi, Omega))
    return abs(cH.imag) / abs(cH)


def whirls(system, Omega):
    Psi = whirl_roots(system, Omega)
    F_N = normal_force(system, Psi, Omega)
    return Psi[F_N > 0.0], F_N[F_N > 0.0]


def scaled(system, factor_r, factor_s):
    """The same system with coordinate i of the rotor (stator) measured in units of 1 / factor."""
    values = {}
    for kind, factor in (("r", factor_r), ("s", factor_s)):
        for name in ("mass", "damping", "stiffness", "gyroscopic"):
            values[f"{name}_{kind}"] = quantity(system, f"{name}_{kind}") / np.outer(factor, factor)
    return changed(system, **values)


# ---------------------------------------------------------------- receptances and natural frequencies


def test_receptances_are_those_of_the_written_equations():
    system, Omega = reference(GYROSCOPIC), 300.0
    Psi = np.array([[-500.0, -3.0, 0.0], [40.0, 310.0, 2e4]])
    H_R, H_S = receptance_rotor(system, Psi, Omega), receptance_stator(system, Psi)
    assert H_R.shape == H_S.shape == Psi.shape
    for index in np.ndindex(Psi.shape):
        wanted = plain_receptances(system, Psi[index], Omega)
        assert [H_R[index], H_S[index]] == pytest.approx(wanted, rel=1e-12)
    assert receptance(system, Psi, Omega) == pytest.approx(H_R + H_S, rel=1e-15)


def test_a_rigid_stator_has_no_receptance():
    assert receptance_stator(jeffcott(), np.array([-3.0, 5.0])).tolist() == [0.0, 0.0]


def test_receptance_is_infinite_at_a_pole():
    system = jeffcott(damping=0.0)
    # normal_force needs an infinity, not a number that is none
    assert (receptance_rotor(system, [-200.0, 100.0], 0.0) == np.inf).tolist() == [True, False]
    assert normal_force(system, -200.0, 0.0) == 0.0


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6), st.floats(-3e3, 3e3), st.floats(-500.0, 500.0))
def test_conjugate_receptance_is_that_of_the_mirrored_motion(seed, Psi, Omega):
    system = random_system(np.random.default_rng(seed))
    H = receptance(system, Psi, Omega)
    assert receptance(system, -Psi, -Omega) == pytest.approx(H.conj(), rel=1e-9, abs=1e-9 * abs(H))


@pytest.mark.parametrize("name", ["gyroscopic_disk_light", GYROSCOPIC])
def test_natural_frequencies_of_the_gyroscopic_disk(name):
    table, system = expected(name)["frequencies"], reference(name)
    Omega = TWO_PI * table["speed"]
    # three decimals are printed
    assert uncoupled_frequencies(system, Omega) / TWO_PI == pytest.approx(table["uncoupled"], abs=1e-3)
    assert coupled_frequencies(system, Omega) / TWO_PI == pytest.approx(table["coupled"], abs=1e-3)


def test_natural_frequencies_of_the_2x2_scene():
    table, system = expected("mdof_2x2")["frequencies"], reference("mdof_2x2")
    for found, wanted in (
        (uncoupled_frequencies(system, 0.0), table["rotor"]),
        (stator_frequencies(system), table["stator"]),
        (coupled_frequencies(system, 0.0), table["coupled"]),
    ):
        n = len(found) // 2
        assert found[:n] == pytest.approx(-found[:n-1:-1], rel=1e-9)
        # eight decimals are printed, of matrices with eight digits
        assert found[n:][: len(wanted)] / TWO_PI == pytest.approx(wanted, rel=2e-8)


def test_coupled_frequencies_are_zeros_of_the_undamped_receptance():
    system = reference(GYROSCOPIC)
    system = changed(system, damping_r=0.0 * system.rotor.damping, damping_s=0.0 * system.stator.damping)
    at = coupled_frequencies(system, 250.0)
    assert len(at) == 4
    assert np.all(np.abs(receptance(system, at, 250.0)) < 1e-9 * np.abs(receptance(system, 1.01 * at, 250.0)))


def test_natural_frequencies_of_one_mass_in_a_rigid_wall():
    system = jeffcott()
    assert uncoupled_frequencies(system, 1.0) == pytest.approx([-200.0, 200.0])
    assert len(stator_frequencies(system)) == len(coupled_frequencies(system, 1.0)) == 0


# ---------------------------------------------------------------- whirl roots


# with seed 21 the plain receptances of one system of 4000 are themselves wrong by 1.6e-10, at a root that is right to 8e-12
@pytest.mark.parametrize(("seed", "n_systems"), [(20, 250), pytest.param(20, 1000, marks=pytest.mark.nightly)])
def test_no_root_is_missed_or_invented(seed, n_systems):
    rng = np.random.default_rng(seed)
    grid = scan_grid()
    n_found = 0
    for _ in range(n_systems):
        system, Omega = random_system(rng), TWO_PI * rng.uniform(0.0, 100.0)
        roots = whirl_roots(system, Omega)
        assert np.all(np.diff(roots) > 0.0)
        assert max((residual(system, Psi, Omega) for Psi in roots), default=0.0) < 1e-10
        lost, odd, _ = beside_scan(system, Omega, roots, grid)
        assert len(lost) == len(odd) == 0
        n_found += len(roots)
    assert n_found > 4 * n_systems


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.0, 500.0))
def test_mirrored_friction_and_speed_mirror_the_roots(seed, Omega):
    system = random_system(np.random.default_rng(seed))
    mirrored = changed(system, friction=-system.law.friction)
    roots = whirl_roots(system, Omega)
    assert -whirl_roots(mirrored, -Omega)[::-1] == pytest.approx(roots, rel=1e-9)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_units_of_the_coordinates_do_not_matter(seed):
    rng = np.random.default_rng(seed)
    system = random_system(rng, most=4)
    factor_r, factor_s = (10.0 ** rng.uniform(-4.0, 4.0, n) for n in (system.n_rotor, system.n_stator))
    factor_r[0] = 1.0
    factor_s[system.stator.contact == 1.0] = 1.0
    roots = whirl_roots(system, 200.0)
    assert whirl_roots(scaled(system, factor_r, factor_s), 200.0) == pytest.approx(roots, rel=1e-9)


def test_laval_rotor_in_a_rigid_wall_has_a_closed_form():
    mass, damping, stiffness, mu = 2.0, 30.0, 5e4, 0.2
    system = jeffcott(mass, damping, stiffness, mu)
    root = np.sqrt(damping**2 + 4.0 * mu**2 * mass * stiffness)
    wanted = np.array([-damping - root, -damping + root]) / (2.0 * mu * mass)  # mu (k - Psi^2 m) = Psi b
    Psi = whirl_roots(system, 100.0)
    assert Psi == pytest.approx(wanted, rel=1e-12)
    assert normal_force(system, Psi, 100.0) == pytest.approx(-system.contact.gap * damping * wanted / mu, rel=1e-10)


def test_roots_do_not_depend_on_contact_stiffness_damping_or_gap():
    system, Omega = reference("mdof_2x2"), 60.0
    other = changed(system, contact_stiffness=5e4, contact_damping=0.0, gap=0.3)
    Psi = whirl_roots(system, Omega)
    assert whirl_roots(other, Omega).tolist() == Psi.tolist()
    assert np.all(np.abs(normal_force(other, Psi, Omega) / normal_force(system, Psi, Omega) - 300.0) > 1.0)


def test_without_friction_nothing_feeds_a_whirl():
    for name in ("laval", "mdof_2x2", GYROSCOPIC):
        assert len(whirl_roots(changed(reference(name), friction=0.0), 250.0)) == 0


def test_without_friction_and_damping_every_frequency_is_a_root_and_none_is_given():
    assert len(whirl_roots(jeffcott(damping=0.0, friction=0.0), 100.0)) == 0


def test_the_plain_eigenvalue_problem_has_the_roots_of_the_pencil(monkeypatch):
    rng = np.random.default_rng(4)
    systems = [random_system(rng) for _ in range(40)]
    plain = [whirl_roots(system, 200.0) for system in systems]
    monkeypatch.setattr("rsc.analysis.paper.roots._ELIMINATED", 0.0)
    for system, roots in zip(systems, plain, strict=True):
        assert whirl_roots(system, 200.0) == pytest.approx(roots, rel=1e-9)


@pytest.mark.parametrize("friction", [1e-9, 1e-6, 1e-3])
def test_little_friction_has_one_small_and_one_large_root(friction):
    # one mass in a rigid wall: mu (k - Psi^2 m) = Psi b
    system = jeffcott(mass=1.0, damping=20.0, stiffness=4e4, friction=friction)
    double = 20.0 + np.sqrt(20.0**2 + 4.0 * friction**2 * 4e4)
    wanted = [-double / (2.0 * friction), 2.0 * friction * 4e4 / double]
    # the phase of cH is as small as mu, and rounding takes 1e-13 of it
    assert whirl_roots(system, 100.0) == pytest.approx(wanted, rel=1e-12 + 1e-15 / friction, abs=0.0)


def without_damping(system, share=0.0):
    return changed(system, damping_r=share * system.rotor.damping, damping_s=share * system.stator.damping)


def test_systems_in_a_stack_have_the_bits_they_have_alone():
    """With none, little and much friction and damping: no roots, the pencil with infinite ones, roots at poles."""
    systems, draw = [], np.random.default_rng(11)
    for friction in (0.0, 1e-12, 1e-9, 0.05, 0.3, 2.0):
        for share in (0.0, 1e-10, 1.0):
            system = without_damping(reference(GYROSCOPIC), share)
            systems.append(changed(system, friction=friction, stiffness_r=draw.uniform(0.8, 1.2) * system.rotor.stiffness))
    Omega = draw.uniform(50.0, 400.0, len(systems))
    stack = stacked(systems)
    place, Psi, F_N = whirls_by_place(stack, Omega)
    assert np.all(np.diff(place) >= 0) and len(set(np.bincount(place, minlength=len(systems)))) > 2
    eigenvalues = whirl_eigenvalues(stack.at(place), Psi, F_N, Omega[place])
    shapes = np.hstack(whirl_shapes(stack.at(place), Psi, F_N, Omega[place]))
    for i, system in enumerate(systems):
        alone = steady_whirls(system, Omega[i])
        assert [part.tobytes() for part in alone] == [part[place == i].tobytes() for part in (Psi, F_N)]
        assert np.array_equal(whirl_eigenvalues(system, *alone, Omega[i]), eigenvalues[place == i])
        assert np.array_equal(np.hstack(whirl_shapes(system, *alone, Omega[i])), shapes[place == i])


def stack_of_every_difference():
    """Systems that differ in unbalance, load, ring and diameter (two without), the last at rest and free; and their speeds."""
    base, systems = reference(GYROSCOPIC), []
    for i in range(6):
        made = changed(
            base, unbalance=(0.2 + i) * base.rotor.unbalance, unbalance_euler=(0.2 + i) * base.rotor.unbalance_euler,
            load=np.full(2, 1j * i),
            ring_ecc=1e-5j * i, diameter=None if i < 2 else 0.02 * i, slip_velocity=None if i < 2 else 1e-3 * i,
            schedule_time=np.arange(2.0 + i), schedule_speed=np.arange(2.0 + i),
        )  # fmt: skip
        systems.append(made)
    systems[-1] = changed(systems[-1], stiffness_r=np.zeros((2, 2)), damping_r=np.zeros((2, 2)))
    return systems, np.array([100.0, 150.0, 200.0, 250.0, 300.0, 0.0])


def test_a_stack_keeps_unbalance_load_ring_and_diameter_of_each_system():
    systems, Omega = stack_of_every_difference()
    stack = stacked(systems)
    place, Psi, F_N = whirls_by_place(stack, Omega)
    assert set(place) == set(range(6))
    own = stack.at(place)
    parts = synchronous_response(own, Psi, F_N, Omega[place])
    conditions = side_conditions(own, Psi, F_N, Omega[place], parts[0].force)
    for i, system in enumerate(systems):
        alone = synchronous_response(system, Psi[place == i], F_N[place == i], Omega[i])
        for one, part in zip(alone, parts, strict=True):
            for name in ("force", "mirror_force", "line", "mirror_line", "low", "high"):
                assert np.array_equal(getattr(one, name), getattr(part, name)[place == i]), (i, name)
        judged = side_conditions(system, Psi[place == i], F_N[place == i], Omega[i], alone[0].force)
        for name, condition in judged.items():
            assert np.array_equal(condition.margin, conditions[name].margin[place == i]), (i, name)
            assert np.array_equal(condition.holds, conditions[name].holds[place == i]), (i, name)
        assert np.array_equal(stack.rotor.load[i], system.rotor.load) and stack.contact.ring[i] == system.contact.ring
    with pytest.raises(ValueError, match="empty"):
        stack.speed_at(0.0)


def test_a_stack_keeps_what_only_some_systems_have():
    plain = reference(GYROSCOPIC)
    skew = changed(plain, skew_stiffness_r=np.array([[1.0, 2.0], [2.0, 3.0]]), anisotropic_damping_s=np.array([[4j]]))
    for systems in ([plain, skew], [skew, plain]):
        stack = stacked(systems)
        assert stack.rotor.skew_damping is None and stack.at(np.array([1, 1])).rotor.skew_damping is None
        for i in (0, 1):
            place = stack.at(np.array([i, i]))
            for name in ("skew_stiffness_r", "anisotropic_damping_s"):
                own = quantity(systems[i], name)
                assert np.array_equal(quantity(place, name)[1], 0.0 * quantity(skew, name) if own is None else own)


@pytest.mark.parametrize("share", [0.0, 1e-12, 1e-8])
@pytest.mark.parametrize("name", ["laval", "mdof_2x2", GYROSCOPIC])
def test_undamped_roots_are_the_uncoupled_and_the_coupled_frequencies(name, share):
    system, Omega = reference(name), 250.0
    undamped = without_damping(system)
    parts = uncoupled_frequencies(undamped, Omega), stator_frequencies(undamped), coupled_frequencies(undamped, Omega)
    wanted = np.sort(np.concatenate(parts))
    for friction in (0.01, 0.3, 2.0):
        roots = whirl_roots(changed(without_damping(system, share), friction=friction), Omega)
        # some lie at infinity without damping and very far away with little
        roots = roots[np.abs(roots) < 1e3 * np.abs(wanted).max()]
        assert roots == pytest.approx(wanted, rel=max(1e-9, 100.0 * share))


def test_rotor_with_a_free_mode():
    # a chain of two masses free at both ends: H has a pole at 0, which is not a whirl
    stiffness = np.array([[1e4, -1e4], [-1e4, 1e4]])
    rotor = (np.eye(2), 1e-4 * stiffness, stiffness, np.zeros((2, 2)))
    stator = (np.eye(1), 10.0 * np.eye(1), 9e4 * np.eye(1))
    system = make_system(rotor, stator, (0, 0, 0.2, 1e7))
    roots = whirl_roots(system, 100.0)
    assert len(roots) > 0 and np.all(roots != 0.0)
    assert max(residual(system, Psi, 100.0) for Psi in roots) < 1e-10


def test_two_roots_just_before_they_fold_away_and_none_after():
    system, Omega = reference("laval"), TWO_PI * 50.0

    def friction_at(Psi):  # for which Psi is a root
        H = sum(plain_receptances(system, Psi, Omega))
        return -H.imag / H.real

    fold = minimize_scalar(friction_at, bounds=(-350.0, -220.0), method="bounded", options={"xatol": 1e-6}).fun

    def pair(share):
        roots = whirl_roots(changed(system, friction=fold * (1.0 + share)), Omega)
        return roots[(roots > -75.0 * TWO_PI) & (roots < -30.0 * TWO_PI)]

    # the pair stays a pair until it cannot be told apart, and leaves no ghost
    assert [len(pair(share)) for share in (1e-6, 1e-8, 1e-10, 1e-12)] == [2, 2, 2, 2]
    assert [len(pair(-share)) for share in (1e-6, 1e-8, 1e-10, 1e-12)] == [0, 0, 0, 0]
    gap = [np.ptp(pair(share)) for share in (1e-10, 1e-8, 1e-6)]
    assert gap[1:] == pytest.approx([10.0 * gap[0], 100.0 * gap[0]], rel=0.02)  # square root law


# ---------------------------------------------------------------- forces and shapes


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.0, 500.0))
def test_laws_of_a_steady_whirl(seed, Omega):
    system = random_system(np.random.default_rng(seed))
    Psi, F_N = whirls(system, Omega)
    rotor, stator = whirl_shapes(system, Psi, F_N, Omega)
    distance = rotor @ system.rotor.contact - stator @ system.stator.contact
    # the contact angle is 0: d is real, and the penetration is that of the contact spring
    assert np.abs(distance - law_of(system).distance(F_N)) == pytest.approx(0.0 * F_N, abs=1e-8 * system.contact.gap)
    assert np.all(distance.real > system.contact.gap)
    for i in range(len(Psi)):
        force = (1.0 + 1j * system.law.friction) * F_N[i]
        A_R = system.rotor.stiffness - Psi[i] ** 2 * system.rotor.mass
        A_R = A_R + 1j * Psi[i] * (system.rotor.damping - 1j * Omega * system.rotor.gyroscopic)
        A_S = system.stator.stiffness - Psi[i] ** 2 * system.stator.mass + 1j * Psi[i] * system.stator.damping
        assert np.abs(A_R @ rotor[i] + system.rotor.contact * force).max() < 1e-8 * np.abs(A_R).max() * abs(rotor[i]).max()
        if system.n_stator:
            size = np.abs(A_S).max() * abs(stator[i]).max()
            assert np.abs(A_S @ stator[i] - system.stator.contact * force).max() < 1e-8 * size
        # energy: friction feeds what the dampers of rotor and stator take
        fed = system.law.friction * F_N[i] * distance[i].real * abs(Psi[i])
        parts = (rotor[i], system.rotor.damping), (stator[i], system.stator.damping)
        taken = Psi[i] ** 2 * sum((x.conj() @ damping @ x).real for x, damping in parts)
        assert Psi[i] < 0.0
        assert fed == pytest.approx(taken, rel=1e-7)


def test_rigid_force_is_the_limit_of_a_stiff_contact():
    system, Omega = reference("laval"), 300.0
    Psi, _ = whirls(system, Omega)
    rigid = normal_force(system, Psi, Omega, rigid=True)
    assert normal_force(changed(system, contact_stiffness=1e14), Psi, Omega) == pytest.approx(rigid, rel=1e-7)
    assert normal_force(system, Psi, Omega) != pytest.approx(rigid, rel=1e-3)


def test_one_root_needs_no_array():
    system, Omega = reference("mdof_2x2"), 60.0
    Psi, F_N = whirls(system, Omega)
    rotor, stator = whirl_shapes(system, Psi, F_N, Omega)
    one_rotor, one_stator = whirl_shapes(system, Psi[1], F_N[1], Omega)
    assert one_rotor == pytest.approx(rotor[1]) and one_stator == pytest.approx(stator[1])
    assert float(normal_force(system, Psi[1], Omega)) == pytest.approx(F_N[1])


# ---------------------------------------------------------------- side conditions


def test_margins_of_the_side_conditions():
    system, Omega = reference("laval"), TWO_PI * 50.0
    Psi, F_N = whirls(system, Omega)
    conditions = side_conditions(system, Psi, F_N, Omega, 0.1 * F_N)
    rotor, _ = whirl_shapes(system, Psi, F_N, Omega)
    rigid = normal_force(system, Psi, Omega, rigid=True)
    margins = {
        "normal_force_positive": F_N,
        "asynchronous_force_dominates": 10.0 * np.hypot(1.0, system.law.friction) * np.ones(3),
        "rotor_amplitude_exceeds_gap": np.abs(rotor[:, 0]) / system.contact.gap - 1.0,
        "sliding": np.full(3, np.inf),
        "contact_stiff_enough": system.law.stiffness * system.contact.gap / rigid - 1.0,
    }
    for name, margin in margins.items():
        assert conditions[name].margin == pytest.approx(margin, rel=1e-9)
    slope = []  # of the phase of cH
    for one in Psi:
        H = receptance(system, one * np.array([1.0 - 1e-6, 1.0 + 1e-6]), Omega)
        slope.append(abs(np.angle(H[1] / H[0])) / 2e-6)
    assert conditions["psi_real"].margin == pytest.approx(slope, rel=1e-6)
    holds = {name: condition.holds.tolist() for name, condition in conditions.items()}
    assert holds.pop("rotor_amplitude_exceeds_gap") == [False, True, True]
    assert all(all(values) for values in holds.values())


def test_side_conditions_that_fail_say_so():
    system, Omega = reference("laval"), TWO_PI * 50.0
    Psi, F_N = (item[1] for item in whirls(system, Omega))
    weak = side_conditions(system, Psi, F_N, Omega, 0.5 * F_N)["asynchronous_force_dominates"]
    assert weak.margin == pytest.approx(2.0 * np.hypot(1.0, system.law.friction)) and not weak.holds
    assert not side_conditions(system, 1.001 * Psi, F_N, Omega, 1.0)["psi_real"].holds
    forward = whirl_roots(system, Omega)[-1]
    assert forward > 0.0
    pulling = side_conditions(system, forward, normal_force(system, forward, Omega), Omega, 1.0)
    assert not pulling["normal_force_positive"].holds
    soft = changed(system, contact_stiffness=1e4)
    F_soft = normal_force(soft, Psi, Omega)
    conditions = side_conditions(soft, Psi, F_soft, Omega, 1.0)
    # below F_N(rigid) / s no spring force holds the whirl
    assert not conditions["contact_stiff_enough"].holds and F_soft < 0.0
    assert normal_force(system, Psi, Omega, rigid=True) / system.contact.gap > 1e4


def test_sliding_ends_where_the_surfaces_roll():
    plain, Omega = reference("laval"), TWO_PI * 50.0
    Psi, F_N = (item[1] for item in whirls(plain, Omega))
    distance = float(law_of(plain).distance(F_N))
    rolling = -2.0 * Psi * distance / Omega  # diameter with Omega d_R / 2 + Psi |d| = 0
    for diameter, slip_velocity, holds in ((1.1 * rolling, 0.0, True), (0.9 * rolling, 0.0, False)):
        system = changed(plain, diameter=diameter, slip_velocity=slip_velocity)
        sliding = side_conditions(system, Psi, F_N, Omega, 1.0)["sliding"]
        assert sliding.margin == pytest.approx(1.0 - rolling / diameter)
        assert sliding.holds == holds
    # within the slip velocity of the regularised law the friction is not yet full
    slow = changed(plain, diameter=1.1 * rolling, slip_velocity=0.06 * Omega * rolling)
    assert not side_conditions(slow, Psi, F_N, Omega, 1.0)["sliding"].holds
    still = changed(plain, diameter=rolling, slip_velocity=1e-3)
    assert side_conditions(still, Psi, F_N, 0.0, 1.0)["sliding"].margin == -np.inf


# ---------------------------------------------------------------- reference numbers


def check_rows(name, rows, rigid_amplitude):
    system = reference(name)
    for speed, frequency, amplitude in rows:
        if np.isnan(frequency):
            continue
        Omega = TWO_PI * speed
        Psi, _ = whirls(system, Omega)
        i = np.argmin(np.abs(Psi / TWO_PI - frequency))
        # frequencies are printed to 0.0001 Hz (0.001 where fewer digits are), amplitudes to 0.001 or 0.0001
        assert Psi[i] / TWO_PI == pytest.approx(frequency, abs=1e-4 if abs(frequency) < 300.0 else 5e-3)
        force = normal_force(system, Psi[i], Omega, rigid=rigid_amplitude)
        rotor, _ = whirl_shapes(system, Psi[i], force, Omega)
        assert abs(rotor @ system.rotor.contact) / system.contact.gap == pytest.approx(amplitude, abs=6e-4)


def both_whirls(name):
    table = expected(name)["whirl"]["table"]
    return [(row[0], row[i], row[i + 1]) for row in table for i in (1, 4)]


@pytest.mark.parametrize("name", ["gyroscopic_disk_light", GYROSCOPIC])
def test_gyroscopic_disk_table(name):
    # the amplitudes of this table are those of the rigid contact: 0.3 % smaller than the scene's
    check_rows(name, both_whirls(name), rigid_amplitude=True)


def test_gyroscopic_transition_table():
    check_rows("gyroscopic_transition", both_whirls("gyroscopic_transition"), rigid_amplitude=False)


@pytest.mark.parametrize("name", ["mdof_2x2", "laval"])
@pytest.mark.parametrize("speed", [5.0, 50.0])
def test_whirls_without_gyroscopics(name, speed):
    check_rows(name, [(speed, *row[:2]) for row in expected(name)["whirl"]["table"]], rigid_amplitude=False)


def test_the_2x2_scene_has_exactly_the_five_whirls():
    Psi, _ = whirls(reference("mdof_2x2"), 60.0)
    assert len(Psi) == len(expected("mdof_2x2")["whirl"]["table"]) == 5
