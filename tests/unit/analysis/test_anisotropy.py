"""Supports whose directions differ: against real matrices, the nonlinear equations instant by instant, and time integration."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ross_rotors import rub_rotor
from rsc.analysis.alone.free_vibration import free_growth, free_vibrations
from rsc.analysis.balance.elliptic_whirl import elliptic_whirl
from rsc.analysis.balance.problem import NotBalanced
from rsc.analysis.follow.branches import branches
from rsc.analysis.follow.forward_rub import attractors
from rsc.analysis.paper.anisotropy import (
    contact_motion,
    doubled_stiffness,
    largest_without_contact,
    mirror_line,
    unbalance_ellipse,
)
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.predict_many import WhirlArrays, _whirls
from rsc.analysis.paper.receptance import along, receptance, receptance_stator
from rsc.analysis.paper.small_motions import departure
from rsc.analysis.paper.whirls import MOST_MIRROR, steady_whirls, whirl_shapes
from rsc.analysis.survey.remarks import branch_remarks, direction_remarks, scene_remarks, whirl_remarks
from rsc.system.system import stacked
from systems import (
    TWO_PI,
    accelerations,
    anisotropic_part,
    changed,
    jeffcott,
    quantity,
    random_rotor,
    random_system,
    reference,
    with_anisotropy,
    with_skew,
)
from whirl_motions import distance_between

OMEGA = TWO_PI * 50.0
SEEN = -60.664  # Hz, the stable whirl of the isotropic mean


def two_springs(share, damping=0.0):
    """The Laval rotor of the reference with (1 +- share) k in its directions, and no contact damping."""
    system = changed(reference("laval"), contact_damping=0.0)
    parts = {"anisotropic_stiffness_r": share * system.rotor.stiffness + 0j}
    if damping:
        parts["anisotropic_damping_r"] = damping * system.rotor.damping + 0j
    return changed(system, **parts) if share else system


def seen(system):
    """Psi and F_N (1,) of the stable whirl of the isotropic mean."""
    Psi, F_N = steady_whirls(system, OMEGA)
    i = np.argmin(np.abs(Psi - TWO_PI * SEEN))
    return Psi[i : i + 1], F_N[i : i + 1]


def real_matrices(system, Omega):
    """M, D and K (2n, 2n) of y and z of the rotor: what acts on r and what acts on its conjugate."""
    Q, S = (0.0 if part is None else part for part in (system.rotor.skew_damping, system.rotor.skew_stiffness))
    C, E = anisotropic_part(system, "r")
    none = np.zeros_like(system.rotor.mass)

    def real(own, conjugate):
        plus, minus = own + conjugate, own - conjugate
        return np.block([[plus.real, -minus.imag], [plus.imag, minus.real]])

    damping = system.rotor.damping + 1j * (Q - Omega * system.rotor.gyroscopic)
    return real(system.rotor.mass + 0j, none), real(damping, C), real(system.rotor.stiffness + 1j * S, E)


def random_anisotropic(rng, size=0.1):
    return with_anisotropy(rng, with_skew(rng, random_system(rng, least_stator=1), driving=0.02), size)


# ---------------------------------------------------------------- without contact


def test_free_vibrations_are_those_of_the_real_matrices():
    rng = np.random.default_rng(2)
    for _ in range(10):
        system, speed = random_anisotropic(rng, 0.3), rng.uniform(0.0, 100.0)
        mass, damping, stiffness = real_matrices(system, TWO_PI * speed)
        n = len(mass)
        lower = [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]
        wanted = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], lower]))
        found = free_vibrations(system, speed)
        values = np.array([v.growth_rate + 1j * TWO_PI * v.frequency for v in found])
        both = np.concatenate([values, values.conj()])
        assert max(distance_between(both, wanted), distance_between(wanted, both)) < 1e-8
        assert len(both) - np.sum(values.imag == 0.0) == 2 * n
        assert free_growth(changed(system, mass_s=np.zeros((0, 0))), TWO_PI * speed) == pytest.approx(wanted.real.max())


def test_an_ellipse_moves_as_its_circles_say():
    """One vibration put into the equations of motion: forward and backward circle together fulfil them."""
    rng = np.random.default_rng(9)
    system = random_anisotropic(rng, 0.3)
    mass, damping, stiffness = real_matrices(system, TWO_PI * 30.0)
    for vibration in free_vibrations(system, 30.0):
        value = vibration.growth_rate + 1j * TWO_PI * vibration.frequency
        parts = (vibration.shape, value), (vibration.mirror_shape, value.conjugate())
        r, v, a = (sum(shape * s**order for shape, s in parts) for order in (0, 1, 2))
        terms = [matrix @ np.concatenate([x.real, x.imag]) for matrix, x in ((mass, a), (damping, v), (stiffness, r))]
        assert np.abs(sum(terms)).max() < 1e-9 * max(np.abs(term).max() for term in terms)
        assert np.abs(vibration.mirror_shape).max() > 0.0


def test_two_frequencies_of_unequal_springs():
    """(1 + e) k and (1 - e) k without damping: straight lines, neither forward nor backward."""
    system = changed(jeffcott(damping=0.0), anisotropic_stiffness_r=np.array([[0.2 * 4e4 + 0j]]))
    found = free_vibrations(system, 20.0)
    assert sorted(abs(v.frequency) * TWO_PI for v in found) == pytest.approx([200.0 * np.sqrt(0.8), 200.0 * np.sqrt(1.2)])
    for vibration in found:
        assert np.abs(vibration.mirror_shape) == pytest.approx(np.abs(vibration.shape), rel=1e-9)


def test_unequal_damping_can_drive():
    system = changed(jeffcott(), anisotropic_damping_r=np.array([[30.0 + 0j]]))  # 20 +- 30 N s/m
    assert free_growth(system, 0.0) == pytest.approx(5.0, rel=1e-9)
    assert "the rotor is unstable without contact" in scene_remarks(system, [])[0]


def test_unbalance_response_is_that_of_the_real_matrices():
    rng = np.random.default_rng(3)
    for _ in range(10):
        system, Omega = random_anisotropic(rng, 0.3), rng.uniform(20.0, 500.0)
        mass, damping, stiffness = real_matrices(system, Omega)
        force = system.rotor.unbalance * Omega**2
        answer = np.linalg.solve(stiffness - Omega**2 * mass + 1j * Omega * damping, np.concatenate([force, -1j * force]))
        y, z = np.split(answer, 2)  # complex amplitudes at e^{i Omega t} of real motions
        forward, backward = unbalance_ellipse(system, Omega)
        size = np.abs(answer).max()
        assert forward == pytest.approx(0.5 * (y + 1j * z), rel=1e-6, abs=1e-9 * size)
        assert backward == pytest.approx((0.5 * (y - 1j * z)).conj(), rel=1e-6, abs=1e-9 * size)


def test_contact_begins_where_the_long_axis_of_the_ellipse_meets_the_gap():
    system = changed(two_springs(0.2), friction=0.05)
    forward, backward = (complex(line[0]) for line in unbalance_ellipse(system, OMEGA))
    circle = np.exp(1j * np.linspace(0.0, TWO_PI, 100_001))
    largest = np.abs(forward * circle + backward / circle).max()
    assert abs(backward) > 0.01 * abs(forward)
    assert largest_without_contact(system, OMEGA) == pytest.approx((largest, largest), rel=1e-8)
    kinds = [[a.kind for a in attractors(changed(system, gap=largest * f), 50.0)] for f in (0.999, 1.001)]
    assert ["no contact" in kind for kind in kinds] == [False, True]
    assert attractors(changed(system, gap=1.001 * largest), 50.0)[0].amplitude == pytest.approx(largest, rel=1e-8)


# ---------------------------------------------------------------- whirls in contact


def test_without_anisotropy_both_sides_are_apart():
    system = with_skew(np.random.default_rng(1), reference("mdof_2x2"))
    w, contact = np.array([-300.0, 77.0]), system.relative
    motion = along(contact_motion(system, w, 90.0), contact)
    assert motion[0] == pytest.approx(receptance(system, w, 90.0), rel=1e-9)
    assert motion[2] == pytest.approx(receptance(system, -w, 90.0), rel=1e-9)
    assert not motion[1].any() and not motion[3].any()
    assert doubled_stiffness(system, w, 90.0).shape == (2, 8, 8)


def test_an_exact_whirl_fulfils_the_equations_at_every_instant():
    rng, n_found = np.random.default_rng(4), 0
    while n_found < 8:
        system, Omega = with_anisotropy(rng, with_skew(rng, random_rotor(rng), driving=0.02), 0.03), TWO_PI * 30.0
        system = changed(system, contact_stiffness=1e6)
        for frequency in steady_whirls(system, Omega)[0] / TWO_PI:
            try:
                whirl = elliptic_whirl(system, frequency, 30.0)
            except NotBalanced:
                continue
            if np.abs(whirl.rotor[[0, -1]]).max() > 1e-9 * whirl.amplitude or whirl.normal_force[0] <= 0.0:
                continue
            w, size = TWO_PI * whirl.lines[:, None], np.abs(whirl.normal_force[1] / system.rotor.mass[0, 0])
            for t in np.linspace(0.0, 1.0 / abs(whirl.frequency), 7):
                lines = whirl.motion * np.exp(1j * w * t)
                state = np.concatenate([lines.sum(axis=0), (1j * w * lines).sum(axis=0)])
                assert accelerations(system, state, Omega, 0.0) == pytest.approx((-(w**2) * lines).sum(axis=0), abs=1e-5 * size)
            n_found += 1


def test_the_mirror_line_is_the_exact_one_where_it_is_small():
    for share, miss in ((0.002, 2e-4), (0.02, 1e-2)):
        system = two_springs(share, damping=share)
        lines, exact = mirror_line(system, *seen(system), OMEGA), elliptic_whirl(system, SEEN, 50.0)
        assert lines.line[0] == pytest.approx(exact.mirror_amplitude, rel=miss)
        assert lines.third[0] == pytest.approx(abs(exact.rotor[len(exact.rotor) // 2 - 2]), rel=4.0 * miss)
        assert (lines.low[0], lines.high[0]) == pytest.approx(exact.envelope, rel=miss)
        # the phase as well, by the stator, which is isotropic and feels nothing but the contact
        w = -TWO_PI * exact.frequency
        force = exact.motion[len(exact.rotor) // 2, 1] / receptance_stator(system, w)
        assert lines.force[0] == pytest.approx(force, rel=2.0 * miss)
        assert lines.share[0] * seen_amplitude(system) == pytest.approx(lines.line[0], rel=1e-12)


def test_the_damper_of_the_contact_takes_part():
    """With its kink, so that more lines are needed for less accuracy."""
    system = changed(two_springs(0.05), contact_damping=300.0)
    exact = elliptic_whirl(system, SEEN, 50.0, pairs=10)
    w, size = TWO_PI * exact.lines[:, None], exact.normal_force[1] / system.rotor.mass[0, 0]
    for t in np.linspace(0.0, 1.0 / abs(exact.frequency), 9):
        lines = exact.motion * np.exp(1j * w * t)
        state = np.concatenate([lines.sum(axis=0), (1j * w * lines).sum(axis=0)])
        assert accelerations(system, state, OMEGA) == pytest.approx((-(w**2) * lines).sum(axis=0), abs=2e-3 * size)
    free = elliptic_whirl(changed(system, contact_damping=0.0), SEEN, 50.0)
    assert abs(exact.amplitude - free.amplitude) > 5e-5 * free.amplitude


def seen_amplitude(system):
    return abs(complex(whirl_shapes(system, *(part[0] for part in seen(system)), OMEGA)[0][0]))


def test_the_motion_is_that_of_a_time_integration():
    """Started on the exact whirl: a quarter of a second later it is still there, 0.2 of the beat away from the isotropic mean."""
    system, gap = two_springs(0.1), reference("laval").contact.gap
    exact = elliptic_whirl(system, SEEN, 50.0)
    w = TWO_PI * exact.lines

    def rate(time, state):
        return np.concatenate([state[2:], accelerations(system, state, OMEGA)])

    start = np.concatenate([exact.motion.sum(axis=0), 1j * w @ exact.motion])
    solved = solve_ivp(rate, (0.0, 0.25), start, "DOP853", np.linspace(0.15, 0.25, 101), rtol=1e-7, atol=1e-9 * gap)
    wanted = np.exp(1j * np.outer(solved.t, w)) @ exact.rotor
    assert np.abs(solved.y[0] - wanted).max() < 1e-3 * exact.amplitude
    assert np.array([np.abs(wanted).min(), np.abs(wanted).max()]) == pytest.approx(exact.envelope, rel=2e-3)
    assert abs(exact.frequency - SEEN) * 0.25 > 0.1  # turns


def test_too_much_anisotropy_leaves_no_whirl():
    system = two_springs(0.95)
    with pytest.raises(NotBalanced, match=r"no whirl was found with more than \d+\.\d % of what makes") as caught:
        elliptic_whirl(system, SEEN, 50.0)
    reached = caught.value.reached
    assert elliptic_whirl(two_springs(0.94 * reached), SEEN, 50.0).normal_force[0] > 0.0
    with pytest.raises(NotBalanced):
        elliptic_whirl(two_springs(0.96 * reached), SEEN, 50.0)
    with pytest.raises(NotBalanced, match="no whirl at 50 Hz"):
        elliptic_whirl(changed(system, friction=0.0), SEEN, 50.0)
    with pytest.raises(ValueError, match="finite contact stiffness"):
        elliptic_whirl(changed(system, contact_stiffness=np.inf), SEEN, 50.0)


def test_an_elliptic_whirl_is_the_one_that_grows_out_of_the_mean():
    """Another one beside it, at -47.14 Hz, was found where the steps from the mean were long."""
    mean = reference("gyroscopic_transition")
    frequency = []
    for share in (0.0, 0.04, 0.06, 0.08, 0.1):
        E, C = share * mean.rotor.stiffness + 0j, 0.5 * share * mean.rotor.damping + 0j
        system = changed(mean, anisotropic_stiffness_r=E, anisotropic_damping_r=C)
        frequency.append(elliptic_whirl(system, -49.306, 150.0).frequency)
    assert frequency[0] == pytest.approx(-49.30605, abs=1e-5)
    fit = np.polynomial.Polynomial.fit([0.0, 0.04, 0.06, 0.08], frequency[:-1], 3)
    assert frequency[-1] == pytest.approx(fit(0.1), abs=0.2) and frequency[-1] == pytest.approx(-48.684, abs=1e-3)


def test_a_whirl_that_is_no_circle_is_not_claimed():
    small, large = (predict_system(two_springs(share), 50.0)[1] for share in (0.05, 0.2))
    assert small.stable and "nearly_circular" not in small.violated and small.mirror.share < MOST_MIRROR
    assert small.conditions["nearly_circular"] == pytest.approx(MOST_MIRROR - small.mirror.share)
    assert large.growth_rate < 0.0
    assert not large.stable and not large.admissible and large.violated == ("nearly_circular",)
    assert large.mirror.frequency == -large.frequency
    assert large.mirror.share > MOST_MIRROR
    assert large.mirror.envelope[0] < large.rotor_amplitude < large.mirror.envelope[1]
    assert departure(two_springs(0.2), large, [large]).kind == "none"


@pytest.mark.parametrize(("bearings", "share"), [("as they are", 0.0), ("x", 0.1), ("x", 0.4)])
def test_bearings_of_the_rub_rotor(bearings, share):
    """As they are (one with 9.5e5 and 1.09e8 N/m) the isotropic mean says 35.24 Hz; with (1 +- 0.4) k no whirl is left."""
    system = rub_rotor(bearings, share)
    whirl = min(predict_system(system, 20.0), key=lambda w: abs(w.frequency + 34.5))
    assert whirl.growth_rate < 0.0
    assert whirl.stable == whirl.admissible == (share == 0.1)
    if share == 0.4:
        with pytest.raises(NotBalanced, match="more than 65"):
            elliptic_whirl(system, whirl.frequency, 20.0)
        return
    exact = elliptic_whirl(system, whirl.frequency, 20.0)
    found = exact.frequency, exact.amplitude / system.contact.gap, exact.mirror_amplitude / system.contact.gap
    # integrated in time, bench/results/anisotropy.md
    integrated = {"as they are": (-33.747, 1.8457, 0.3674), "x": (-33.973, 2.1844, 0.2093)}[bearings]
    assert found == pytest.approx(integrated, rel=5e-4)


def test_a_bearing_that_only_looks_stiff_from_its_mean_is_found_out():
    """k and 1000 k at one end: to first order in the anisotropy the mean hardly moves there, but one direction is soft."""
    K = 1e6 * np.array([[2.0, -2.0], [-2.0, 502.5]])
    E = 1e6 * np.array([[0.0, 0.0], [0.0, -499.5]]) + 0j
    rotor = (np.diag([2.0, 1.0]), 20.0 * np.eye(2), K, np.zeros((2, 2)))
    laval = reference("laval")
    made = changed(laval, contact_damping=0.0, contact_stiffness=1e8, anisotropic_stiffness_r=E, contact_r=np.array([1.0, 0.0]),
                   load=np.zeros(2, complex), unbalance=np.zeros(2, complex), unbalance_euler=np.zeros(2, complex),
                   **dict(zip(("mass_r", "damping_r", "stiffness_r", "gyroscopic_r"), rotor, strict=True)))  # fmt: skip
    Psi, F_N = steady_whirls(made, OMEGA)
    lines = mirror_line(made, Psi, F_N, OMEGA)
    weak = mirror_line(changed(made, anisotropic_stiffness_r=1e-3 * E), Psi, F_N, OMEGA)
    assert np.all(weak.share * 1e3 < MOST_MIRROR) and np.all(lines.share > MOST_MIRROR)


def test_stacks_have_the_mirror_lines_of_each_system():
    systems = [two_springs(share, damping=share) for share in (0.02, 0.1, 0.3)]
    stack = stacked([*systems, two_springs(0.0)])
    Psi, F_N = (np.concatenate([part] * 4) for part in seen(systems[0]))
    together = mirror_line(stack, Psi, F_N, np.full(4, OMEGA))
    for i, system in enumerate(systems):
        assert together.line[i] == mirror_line(system, *seen(system), OMEGA).line[0]
    assert together.line[3] == 0.0


def test_searches_over_many_scenes_claim_no_whirl_that_is_no_circle():
    stack = stacked([two_springs(share) for share in (0.05, 0.2)])
    _, values, conditions = _whirls(stack, np.full(2, OMEGA), np.array([SEEN]))
    assert conditions["nearly_circular"].tolist() == [True, False] and np.all(values["growth_rate"] < 0.0)
    shaped = {name: value.reshape(2, 1, 1) for name, value in values.items()}
    found = WhirlArrays(np.full((2, 1), 50.0), **shaped, conditions={name: v.reshape(2, 1, 1) for name, v in conditions.items()})
    assert found.stable.ravel().tolist() == found.admissible.ravel().tolist() == [True, False]


def test_a_pole_of_one_system_leaves_the_others_of_a_stack_alone():
    # A(100) = 4e4 - 100^2 - 100 * 300 = 0, and A(-100) is not
    free = changed(jeffcott(damping=0.0), gyroscopic_r=np.array([[-300.0]]), anisotropic_stiffness_r=np.zeros((1, 1), complex))
    held = changed(jeffcott(), anisotropic_stiffness_r=np.array([[4e3 + 0j]]))
    w, stack = np.array([100.0, 100.0]), stacked([free, held])
    motion = contact_motion(stack, w, 1.0)
    assert not np.isfinite(motion[0, 0]).any()
    assert motion[:, 1] == pytest.approx(contact_motion(held, w[1:], 1.0)[:, 0], rel=1e-12)
    share = mirror_line(stack, -w, np.ones(2), 1.0).share
    assert not share[0] <= MOST_MIRROR and np.isfinite(share[1])


def test_remarks_tell_what_the_mean_leaves_out():
    for share, wanted in ((0.05, "exactly -60.5467 Hz"), (0.2, "not circular, stability not assessed; exactly -59.06")):
        system = two_springs(share)
        whirl = predict_system(system, 50.0)[1]
        text = next(remark for remark in whirl_remarks(system, [whirl]) if "elliptical" in remark)
        assert text.startswith(f"whirl {whirl.frequency:.4f} Hz: elliptical, counter-rotating component at 60.6642 Hz of ")
        assert wanted in text
        assert not any("unstable" in remark for remark in whirl_remarks(system, [whirl]))
    told = branch_remarks(system, branches(system, np.linspace(45.0, 55.0, 3)))
    assert not any("is unstable" in remark and "(-60.66" in remark for remark in told)
    assert any(remark.endswith("not circular between 45 and 55 Hz: stability not assessed there") for remark in told)


def test_isotropic_systems_pay_nothing(monkeypatch):
    monkeypatch.setattr("rsc.analysis.paper.predict.mirror_line", None)
    monkeypatch.setattr("rsc.analysis.paper.anisotropy.doubled_stiffness", None)
    system = reference("laval")
    assert [whirl.mirror for whirl in predict_system(system, 50.0)] == [None] * 3
    assert attractors(system, 50.0)


@pytest.mark.parametrize("direction", [0.0, 45.0, 90.0])
@pytest.mark.parametrize(("size", "told"), [(0.4, "80 %"), (0.1, "")])
def test_the_first_remark_says_that_directions_differ_too_much_for_their_mean(size, told, direction):
    """A support of stiffness k (1 + size) and k (1 - size) in directions square to each other, whichever they are."""
    system = jeffcott()
    turned = size * np.exp(2j * np.radians(direction))
    system = changed(system, anisotropic_stiffness_r=turned * quantity(system, "stiffness_r"))
    remarks = direction_remarks(system)
    assert [told in remark for remark in remarks] == ([True] if told else [])
    assert scene_remarks(system, [])[: len(remarks)] == remarks
