"""Reduction of a body: the error stated against full solutions at points of its own, structure, recovery, and what is refused."""

from dataclasses import fields, replace
from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
import scipy.sparse

from fe_bodies import rotor
from machines import beam, random_machine, shaft
from rsc.errors import ReductionError
from rsc.machine.imports.build import rotor_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.model.contact import Unbalance, body_of
from rsc.machine.reduction.body import FEW, MOST, checked, product, solutions
from rsc.machine.reduction.points import critical_speeds, natural_frequencies
from rsc.machine.reduction.reduction import reduce
from rsc.machine.reduction.shifts import receptance_error
from rsc.system.body import STATES, Body
from rsc.system.knots import ANISOTROPIC
from tiers import nightly

MATRICES = ("mass", "damping", "stiffness", "gyroscopic", "skew_stiffness", "skew_damping")


@pytest.fixture(scope="module", params=[False, True], ids=["symmetric", "skew"])
def machine(request):
    return random_machine(np.random.default_rng(5), skew=request.param)


def stiffness_at(body, Psi, Omega):
    """A(Psi, Omega) written out once more, of the complex equations of motion with r = x e^{i Psi t}."""
    zero = 0.0 * body.stiffness
    S, Q, G = (zero if m is None else m for m in (body.skew_stiffness, body.skew_damping, body.gyroscopic))
    rate = 1j * Psi
    return rate**2 * body.mass + rate * (body.damping + 1j * Q - 1j * Omega * G) + body.stiffness + 1j * S


def response(body, Psi, Omega, force):
    return np.linalg.solve(stiffness_at(body, Psi, Omega), force)


def errors_of_receptance(machine, reduced, places):
    """|H - H_r| / |H| at frequencies and speeds."""
    body = machine.rotor
    full = np.array([body.contact @ response(body, *place, body.contact) for place in places])
    small = np.array([response(reduced.body, *place, np.eye(reduced.body.n_coordinates)[0])[0] for place in places])
    return np.abs(full - small) / np.abs(full)


def places_of(machine, n=300):
    rng = np.random.default_rng(1)
    return np.column_stack([rng.uniform(*machine.band, n), rng.uniform(*machine.speeds, n)])


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
def test_the_receptance_is_within_the_tolerance_at_other_points(machine, tolerance):
    reduced = reduce(machine.rotor, machine.band, machine.speeds, tolerance)
    places = places_of(machine)
    errors = errors_of_receptance(machine, reduced, places)
    sizes = np.array([abs(machine.rotor.contact @ response(machine.rotor, *place, machine.rotor.contact)) for place in places])
    clear = sizes > 0.1 * np.median(sizes)  # off the antiresonances, to which the scale of errors does not follow
    assert errors[clear].max() <= reduced.error <= tolerance
    assert reduced.body.n_coordinates < 0.5 * reduced.full.n_coordinates


@pytest.mark.parametrize(("seed", "speed"), [(77, 0.013), (66, 0.967)])
def test_narrow_antiresonances_are_within_what_is_stated(seed, speed):
    """Two rotors whose error once was three times that stated, in a dip of the receptance between two points of the check."""
    machine = random_machine(np.random.default_rng(seed))
    body, Omega = machine.rotor, speed * machine.speeds[1]
    reduced = reduce(body, machine.band, machine.speeds, 1e-2 if seed == 77 else 1e-6)
    Psi = np.linspace(*machine.band, 4000)
    full, small = (
        solutions(part, Psi, np.full(Psi.shape, Omega), np.repeat(part.inputs[:, :1], Psi.size, axis=1)) @ part.contact
        for part in (body, reduced.body)
    )
    assert np.max(np.abs(full - small) / np.abs(full)) <= reduced.error


def test_a_coarse_reduction_is_not_better_than_it_says(machine):
    """The stated error is no bound from far above: within a factor of a hundred it is there."""
    reduced = reduce(machine.rotor, machine.band, machine.speeds, 1e-2)
    checks = [check for check in reduced.checks if (check.response, check.place) == ("receptance", "contact")]
    place = [(checks[0].Psi, checks[0].Omega)]
    assert 0.01 * checks[0].error < errors_of_receptance(machine, reduced, place)[0]


def test_the_unbalance_response_and_the_load_are_within_the_tolerance(machine):
    reduced = reduce(machine.rotor, machine.band, machine.speeds, 1e-4)
    rotor, small = machine.rotor, reduced.body
    for Omega in np.linspace(*machine.speeds, 60)[1:]:
        full = rotor.contact @ response(rotor, Omega, Omega, rotor.unbalance[:, 0])
        assert abs(full - response(small, Omega, Omega, small.unbalance[:, 0])[0]) <= 1e-4 * abs(full)
    sag = rotor.contact @ response(rotor, 0.0, 0.0, rotor.load)
    assert abs(sag - response(small, 0.0, 0.0, small.load)[0]) <= 1e-4 * abs(sag)


def test_matrices_stay_symmetric_and_definite_and_the_contact_is_the_first_coordinate(machine):
    reduced = reduce(machine.rotor, machine.band, machine.speeds, 1e-4)
    body, r = reduced.body, reduced.body.n_coordinates
    for name in MATRICES:
        full, small = getattr(machine.rotor, name), getattr(body, name)
        assert (full is None) == (small is None)
        if full is not None:
            assert small.dtype == float and (small == small.T).all()
            # the congruence itself, to the rounding of a stiffness that spans many decades
            scale = np.abs(reduced.basis).T @ np.abs(full) @ np.abs(reduced.basis)
            assert (np.abs(small - reduced.basis.T @ full @ reduced.basis) <= 1e-9 * scale).all()
    assert np.linalg.eigvalsh(body.stiffness).min() > 0.0
    assert (body.mass == body.mass[0, 0] * np.eye(r)).all() and (body.contact == np.eye(r)[0]).all()
    held = body.stiffness[1:, 1:]
    assert np.abs(held - np.diag(held.diagonal())).max() < 1e-9 * held.max()
    assert np.linalg.cond(reduced.basis.T @ machine.rotor.mass @ reduced.basis) < 1.0 + 1e-6


def test_displacements_everywhere_are_recovered(machine):
    """The error away from the contact is about the root of that at it; at observers it is held to that."""
    reduced = reduce(machine.rotor, machine.band, machine.speeds, 1e-8)
    for Omega in np.linspace(*machine.speeds, 7)[1:]:
        full = response(machine.rotor, Omega, Omega, machine.rotor.unbalance[:, 0])
        small = response(reduced.body, Omega, Omega, reduced.body.unbalance[:, 0])
        recovered = reduced.recover(small)
        deflections = np.abs(full[::2]).max()
        assert np.abs(recovered - full)[::2].max() < 1e-3 * deflections
        assert np.allclose(reduced.body.observers @ small, machine.rotor.observers @ recovered, rtol=1e-6)
        assert abs(machine.rotor.observers @ (recovered - full)) < 1e-4 * deflections


def test_a_tolerance_holds_observers_to_its_root(machine):
    """The check of observers is part of the tolerance: without it their error would be larger."""
    reduced = reduce(machine.rotor, machine.band, machine.speeds, 1e-6)
    errors = [check.error for check in reduced.checks if check.place == "observer 0"]
    assert len(errors) == 3 and max(errors) <= 1e-3


def test_whirls_move_by_the_shift_that_is_stated(machine):
    friction, Omega = 0.25, machine.speeds[1]
    bodies = [reduce(body, machine.band, machine.speeds, 1e-3) for body in (machine.rotor, machine.stator)]

    def condition(Psi, parts):
        return sum((1.0 + 1j * friction) * part.contact @ response(part, Psi, Omega, part.contact) for part in parts).imag

    full, small = [reduced.full for reduced in bodies], [reduced.body for reduced in bodies]
    grid = np.linspace(machine.band[0], -1.0, 2000)
    values = np.array([condition(Psi, small) for Psi in grid])
    roots = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    assert len(roots) > 1
    for i in roots:
        root = scipy.optimize.brentq(condition, grid[i], grid[i + 1], args=(small,), xtol=1e-12)
        errors, slopes = np.sum([receptance_error(reduced, root, Omega) for reduced in bodies], axis=0)[:, 0, 0]
        stated = -((1.0 + 1j * friction) * errors).imag / ((1.0 + 1j * friction) * slopes).imag
        true = scipy.optimize.newton(condition, root, x1=root + stated, args=(full,), tol=1e-10)
        assert true - root == pytest.approx(stated, rel=0.05, abs=1e-9 * abs(root))


def test_the_slope_of_the_receptance_is_that_of_differences(machine):
    reduced = reduce(machine.rotor, machine.band, machine.speeds, 1e-2)
    Psi, Omega = 0.37 * machine.band[0], machine.speeds[1]
    h = 1e-5 * abs(Psi)
    around = [machine.rotor.contact @ response(machine.rotor, Psi + d, Omega, machine.rotor.contact) for d in (-h, h)]
    assert receptance_error(reduced, Psi, Omega)[1] == pytest.approx((around[1] - around[0]) / (2.0 * h), rel=1e-5)


def as_sparse(body):
    return replace(body, **{name: scipy.sparse.csr_array(matrix) for name, matrix in body.terms.items()})


def test_a_small_sparse_body_gives_the_same_as_a_dense_one(machine):
    reduced, other = (reduce(body, machine.band, machine.speeds) for body in (machine.rotor, as_sparse(machine.rotor)))
    assert (reduced.body.stiffness == other.body.stiffness).all() and reduced.checks == other.checks


@pytest.mark.parametrize("skew", [nightly(False), True])
def test_a_large_sparse_body_is_within_the_tolerance(skew):
    """More coordinates than are solved at every point: estimates and a few full solutions."""
    rng = np.random.default_rng(3)
    body = shaft(rng, FEW // 2 + 20, skew)
    natural = natural_frequencies(body, 0.0)
    first, fourth = natural[natural > 0.0][[0, 3]]
    band, speeds = (-1.2 * fourth, 0.7 * fourth), (0.0, 1.5 * first)
    reduced = reduce(as_sparse(body), band, speeds, 1e-4)
    assert all(check.estimated for check in reduced.checks) and reduced.body.n_coordinates < 25
    places = np.column_stack([rng.uniform(*band, 60), rng.uniform(*speeds, 60)])
    for Psi, Omega in places:
        full = body.contact @ response(body, Psi, Omega, body.contact)
        small = response(reduced.body, Psi, Omega, reduced.body.contact)[0]
        assert abs(full - small) < 1e-4 * abs(full)
    highest = np.abs(natural).max()
    assert reduced.highest_before == pytest.approx(highest, rel=0.01) and reduced.highest_after < 0.1 * highest


def test_sparse_solutions_are_those_of_dense_matrices():
    body = shaft(np.random.default_rng(4), 20, True)
    sparse = replace(body, **{name: scipy.sparse.csc_array(matrix) for name, matrix in body.terms.items()})
    Psi, Omega = np.array([-50.0, 300.0]), np.array([20.0, 300.0])
    columns = np.column_stack([body.contact, body.unbalance[:, 0]])
    dense = np.array([response(body, Psi[i], Omega[i], columns[:, i]) for i in range(2)])
    for other in (body, sparse):
        assert np.allclose(solutions(other, Psi, Omega, columns), dense, rtol=1e-7, atol=0.0)


def test_a_body_without_damping_can_be_reduced(machine):
    undamped = replace(machine.stator, damping=0.0 * machine.stator.damping)
    reduced = reduce(undamped, machine.band, machine.speeds)
    assert reduced.error <= 1e-4 and not reduced.body.damping.any()


def test_a_body_of_one_coordinate_stays_as_it_is():
    one = np.ones((1, 1))
    reduced = reduce(Body(2.0 * one, 3.0 * one, 500.0 * one, np.ones(1)), (-40.0, 40.0), (0.0, 10.0), 1e-9)
    assert [reduced.body.mass.item(), reduced.body.damping.item(), reduced.body.stiffness.item()] == pytest.approx(
        [2.0, 3.0, 500.0]
    )


def two_masses(**changes):
    """Two equal masses between springs."""
    stiffness = np.array([[3e4, -1e4], [-1e4, 2e4]])
    body = Body(np.eye(2), 1e-3 * stiffness, stiffness, np.array([1.0, 0.0]))
    return replace(body, **changes)


def huge():
    diagonal = scipy.sparse.eye_array(10_000_000, format="csc")
    return Body(diagonal, diagonal, diagonal, np.ones(10_000_000))


REFUSED = {
    "buckled": (lambda: two_masses(stiffness=np.array([[1e4, 2e4], [2e4, 1e4]])), "not positive definite"),
    "NaN": (lambda: two_masses(damping=np.full((2, 2), np.nan)), "damping has an entry that is not a finite number"),
    "NaN in an unbalance": (lambda: two_masses(unbalance=np.array([[np.nan], [0.0]])), "unbalance has an entry"),
    "asymmetric": (lambda: two_masses(mass=np.array([[1.0, 0.1], [0.0, 1.0]])), "mass is not symmetric"),
    "complex": (lambda: two_masses(stiffness=1e4 * np.eye(2) * (1.0 + 0.1j)), "stiffness is complex"),
    "another size": (lambda: two_masses(damping=np.eye(3)), "damping has shape"),
    "a contact row of another size": (lambda: two_masses(contact=np.ones(3)), "contact has shape"),
    "no contact": (lambda: two_masses(contact=np.zeros(2)), "contact is zero"),
    "no mass": (lambda: two_masses(mass=np.zeros((2, 2))), "mass has a negative diagonal entry, or only zeros"),
    "a negative mass": (lambda: two_masses(mass=np.diag([1.0, -1.0])), "mass has a negative diagonal entry"),
    "an indefinite mass": (lambda: two_masses(mass=np.array([[1.0, 2.0], [2.0, 1.0]])), "mass matrix is not positive definite"),
    "ten million coordinates": (huge, "10000000 complex coordinates are too many"),
}


@pytest.mark.parametrize(("body", "message"), REFUSED.values(), ids=REFUSED)
def test_bodies_are_refused_in_one_line(body, message):
    with pytest.raises(ReductionError, match=message) as told:
        reduce(body(), (-100.0, 100.0), (0.0, 50.0))
    assert "\n" not in str(told.value) and MOST < 10_000_000


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_a_shaft_without_bearings_keeps_its_free_motions(seed, sparse):
    """Rounding leaves its two free motions a tiny stiffness, of either sign."""
    rng, n = np.random.default_rng(seed), 80 if not sparse else FEW // 2 + 10
    stiffness, mass = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n))
    for i in range(n - 1):
        rows = slice(2 * i, 2 * i + 4)
        for whole, part in zip((stiffness, mass), beam(rng.uniform(0.5, 1.5) / n, 0.05)[:2], strict=True):
            whole[rows, rows] += part
    contact = np.eye(2 * n)[10]
    free, hinged = Body(mass, 10.0 * mass, stiffness, contact), stiffness.copy()
    hinged[0, 0] += 1e8
    for body, count in ((free, 2), (replace(free, stiffness=hinged), 1)):
        result = reduce(as_sparse(body) if sparse else body, (-3000.0, 3000.0), (0.0, 50.0))
        squares = scipy.linalg.eigvalsh(result.body.stiffness, result.body.mass)
        assert np.count_nonzero(np.abs(squares) < 4.0) == count and result.error <= 1e-4
    hinged[-2, -2] += 1e3
    assert reduce(replace(free, stiffness=hinged), (-100.0, 100.0), (0.0, 50.0)).error <= 1e-4


def test_products_keep_the_small_forces_of_smooth_deflections():
    """Where the machine has extended precision; an alternating sum of eleven large numbers, as exact fractions."""
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("long double is double")
    rng = np.random.default_rng(2)
    row, x = 1e12 * rng.normal(size=11), 1.0 + 1e-9 * rng.normal(size=11)
    row[-1] = -row[:-1].sum()
    exact = float(sum(Fraction(a) * Fraction(b) for a, b in zip(row, x, strict=True)))
    for matrix in (row[None, :], scipy.sparse.csc_array(row[None, :])):
        assert product(matrix, x)[0] == pytest.approx(exact, rel=1e-9)
    assert abs(row @ x - exact) > 1e-9 * abs(exact)


def test_a_tolerance_that_rounding_forbids_is_refused():
    """Of a finely divided shaft without damping full solutions themselves have fewer than ten digits near a resonance."""
    body = shaft(np.random.default_rng(0), 120, False)
    body = replace(body, damping=0.0 * body.damping)
    natural = natural_frequencies(body, 0.0)
    reach = natural[natural > 0.0][2]
    with pytest.raises(ReductionError, match=r"tolerance = 1e-10 cannot be met: \d+ coordinates leave a relative error of"):
        reduce(body, (-reach, reach), (0.0, 0.0), 1e-10)


@pytest.mark.parametrize("tolerance", [0.0, 1e-11, 0.5, np.nan])
def test_tolerances_out_of_range_are_refused(tolerance):
    with pytest.raises(ReductionError, match=r"must be 1e-10 to 0\.1"):
        reduce(two_masses(), (-100.0, 100.0), (0.0, 50.0), tolerance)


@pytest.mark.parametrize(("band", "speeds"), [((1.0, 1.0), (0.0, 1.0)), ((0.0, np.inf), (0.0, 1.0)), ((0.0, 1.0), (2.0, 1.0))])
def test_ranges_without_width_or_end_are_refused(band, speeds):
    with pytest.raises(ReductionError, match=r"(band|speeds) = .* must be two finite numbers"):
        reduce(two_masses(), band, speeds)


def test_every_matrix_of_a_body_is_reduced():
    """A matrix field that the reduction does not know would be lost without a word."""
    kept, one = {"contact", "unbalance", "load", "observers"}, np.ones((2, 2))
    kept |= {"rotating_damping", "knots", *STATES}  # test_following, test_levitated_machine
    refused = dict.fromkeys((*ANISOTROPIC, "unbalance_euler"), one)
    assert set(MATRICES) | kept | set(refused) == {field.name for field in fields(Body)}
    for name, part in refused.items():
        with pytest.raises(ReductionError, match="must not be part of a body to be reduced"):
            checked(replace(two_masses(), **{name: part}))


@pytest.mark.parametrize("beside", [1.0, 1.0 + 1e-15, 1.0 + 1e-11, 1.0 - 1e-8, 1.0 + 1e-6, 1.0 + 5e-4])
def test_an_undamped_body_is_reduced_wherever_its_poles_lie_among_the_points(beside):
    """The ends of band and speeds are points; on a critical speed H is infinite, and 1/H is what is compared."""
    body = undamped_shaft()
    speeds = np.sort(critical_speeds(body))
    counts = []
    for critical in (speeds[0], speeds[1]):
        for band in ((-9500.0, 9500.0), (-critical * beside, critical * beside)):
            reduced = reduce(body, band, (0.0, critical * beside), 1e-4)
            counts.append(reduced.body.n_coordinates)
            assert reduced.error <= 1e-4
            places = [(Psi, Omega) for Psi in np.linspace(*band, 40) for Omega in (0.0, 0.5 * critical)]
            small = np.array([response(reduced.body, *place, np.eye(reduced.body.n_coordinates)[0])[0] for place in places])
            full = np.array([body.contact @ response(body, *place, body.contact) for place in places])
            assert np.abs(1.0 / full - 1.0 / small).max() < 1e-2 * np.abs(1.0 / full).max()
            assert np.median(np.abs(full - small) / np.abs(full)) < 1e-4
    assert max(counts) <= 14


def undamped_shaft():
    matrices, nodes, directions = rotor(n_elements=12)
    del matrices["damping"]
    model = rotor_model(matrices, Coordinates(nodes, directions), "a shaft", units="m")
    return body_of(model, [4], [Unbalance(4, 1e-4)])
