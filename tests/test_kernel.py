"""The parts of the kernel: tableau, packed vectors, rotation, contact modes, and that one compilation serves."""

from pathlib import Path

import numpy as np
import pytest

from rsc.kernel import contact, control, dopri5, vec
from rsc.kernel.jit import cache_folder, entry, fingerprint
from rsc.kernel.turn import cos_sin, turn_at

A = np.zeros((7, 7))
A[1, :1] = dopri5.A21
A[2, :2] = dopri5.A31, dopri5.A32
A[3, :3] = dopri5.A41, dopri5.A42, dopri5.A43
A[4, :4] = dopri5.A51, dopri5.A52, dopri5.A53, dopri5.A54
A[5, :5] = dopri5.A61, dopri5.A62, dopri5.A63, dopri5.A64, dopri5.A65
B = np.array([dopri5.B1, 0.0, dopri5.B3, dopri5.B4, dopri5.B5, dopri5.B6, 0.0])
A[6] = B
C = np.array([0.0, dopri5.C2, dopri5.C3, dopri5.C4, dopri5.C5, 1.0, 1.0])
E = np.array([dopri5.E1, 0.0, dopri5.E3, dopri5.E4, dopri5.E5, dopri5.E6, dopri5.E7])
D = np.array([dopri5.D1, 0.0, dopri5.D3, dopri5.D4, dopri5.D5, dopri5.D6, dopri5.D7])


def trees(order):
    """(weights of the stages, gamma) of the rooted trees up to `order`, built from B-series products."""
    one = np.ones(7)
    found = {1: [(one, 1)]}
    for n in range(2, order + 1):
        found[n] = []
        for parts in partitions(n - 1):
            found[n] += grafts(parts, found, n)
    return found


def partitions(n, largest=None):
    largest = largest or n
    if n == 0:
        return [()]
    return [(k, *rest) for k in range(min(n, largest), 0, -1) for rest in partitions(n - k, k)]


def grafts(parts, found, n):
    """All trees of n nodes whose root carries subtrees of the given sizes (with repetitions, harmless here)."""
    products = [(np.ones(7), 1)]
    for size in parts:
        products = [(p * (A @ w), g * gw) for p, g in products for w, gw in found[size]]
    return [(p, n * g) for p, g in products]


def test_tableau_meets_every_order_condition_up_to_five():
    np.testing.assert_allclose(A.sum(axis=1), C, atol=1e-15)
    for conditions in trees(5).values():
        for weights, gamma in conditions:
            assert B @ weights == pytest.approx(1 / gamma, abs=1e-14)


def test_embedded_weights_are_of_order_four_and_not_five():
    defects = {n: max(abs(E @ w) for w, _ in found) for n, found in trees(5).items()}
    assert max(defects[n] for n in range(1, 5)) < 1e-14
    assert defects[5] > 1e-5


def test_interpolant_is_of_order_four_everywhere():
    """Quadrature of the interpolant's weights b_i(theta) against theta^n/gamma for every tree of order <= 4."""
    for theta in (0.13, 0.5, 0.77):
        rest = 1 - theta
        bend = np.eye(7)[0] - B
        twist = 2 * B - np.eye(7)[6] - np.eye(7)[0]
        b = theta * (B + rest * (bend + theta * (twist + rest * D)))
        for n, conditions in trees(4).items():
            for weights, gamma in conditions:
                assert b @ weights == pytest.approx(theta**n / gamma, abs=2e-14)


@entry
def _vector_operations(values, columns, out, lanes):
    n = len(lanes)
    a = vec.load(values, lanes)
    b = vec.load_at(vec.address(values), n, lanes)
    product = vec.times_columns(vec.address(columns), b)
    vec.store(out, vec.fma(2.0, a, b) - vec.times_i(a) * b + vec.swap(b) / a + product)
    y, z = vec.pair_sum(a)
    vec.store_at(vec.address(out), n, vec.fill(y, z, a))
    square = vec.larger(a * a, b * b)
    return vec.largest(square + vec.swap(square))


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 7, 13])
def test_packed_vectors_do_complex_arithmetic(n):
    rng = np.random.default_rng(n)
    matrix = rng.normal(size=(n, n))
    values, out = rng.normal(size=4 * n), np.zeros(4 * n)
    largest = _vector_operations(values, np.repeat(matrix.T, 2, axis=1).copy(), out, (0.0,) * (2 * n))
    a, b = values.view(complex)[:n], values.view(complex)[n:]
    product = (1j * a).view(float) * b.view(float)
    ratio = (b.imag + 1j * b.real).view(float) / a.view(float)
    want = (2 * a + b).view(float) - product + ratio + (matrix @ b).view(float)
    np.testing.assert_allclose(out[: 2 * n], want, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(out[2 * n :].view(complex), a.sum(), rtol=1e-13)
    square = np.maximum(values[: 2 * n] ** 2, values[2 * n :] ** 2)
    assert largest == (square[::2] + square[1::2]).max()


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("place", range(28))
def test_largest_never_hides_a_nan(place, sign):
    values = np.arange(28.0)
    values[place] = np.copysign(np.nan, sign)
    assert np.isnan(_vector_operations(values, np.zeros((7, 14)), np.zeros(28), (0.0,) * 14))


@entry
def _cos_sin(phase):
    c, s = cos_sin(vec.from_numbers((0.3, phase, 1e6, 0.0)))
    turn = turn_at(phase, 0.0, 0.0)
    return vec.lane(c, 1), vec.lane(s, 1), turn.cos, turn.sin


def test_rotation_is_sine_and_cosine_and_independent_of_the_other_lanes():
    phases = np.concatenate([np.linspace(-2, 2, 4001), np.random.default_rng(0).uniform(-1, 4, 4000)])
    got = np.array([_cos_sin(phase) for phase in phases])
    angle = 2 * np.longdouble("3.14159265358979323846264") * (phases - np.round(phases)).astype(np.longdouble)
    exact = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert abs(got[:, :2] - exact).max() < 3e-16
    assert np.array_equal(got[:, :2], got[:, 2:])


@pytest.mark.parametrize("log_before", [-26.0, -5.0, 0.0])
def test_step_factor_is_the_power_it_stands_for(log_before):
    """Within one part in a hundred of 0.9 err^-0.17 err_before^0.04 between the clips; NaN and infinity shrink the step."""
    for error2 in 10.0 ** np.linspace(-9.0, 7.9, 200):
        got, log_now = control.factor(error2, log_before)
        want = 0.9 * error2**-0.085 * 2.0 ** (0.02 * log_before)
        assert got == pytest.approx(np.clip(want, 0.2031, 4.925), rel=0.01)
        assert log_now == pytest.approx(max(np.log2(error2), -26.0), abs=0.09)
    for error2 in (np.nan, np.inf, 1e300):
        assert control.factor(error2, log_before)[0] == 0.2
    assert control.factor(0.0, log_before)[0] > 4.9


class _Con:
    """Constants of the contact for calls with the compiler off."""

    gap, friction, k_c, b_c, radius, slip_velocity = 1.0, 0.2, 100.0, 2.0, 0.0, 1.0


def _kin(penetration, rate, slip=0.0):
    distance = 1.0 + penetration
    place = contact.Place(1.0, 0.0, 1 / distance, distance, penetration, 0.0, 0.0)
    return contact.Kinematics(place, contact.Motion(rate, 0.0, slip, abs(rate) + 0.5))


@pytest.mark.parametrize("penetration", [-0.1, -1e-12, 1e-12, 0.01, 0.3])
@pytest.mark.parametrize("rate", [-20.0, -3.0, -0.4, -1e-9, 0.0, 1e-9, 2.0])
def test_modes_reproduce_the_pseudolinear_law(penetration, rate):
    """Equations (10), (11) written once more, against the force of the mode that the state belongs to."""
    kin = _kin(penetration, rate)
    mode = contact.classify.py_func(_Con, kin)
    law = contact.law_of.py_func(_Con, *mode)
    delta, delta_dot = -penetration, -rate
    want = max(0.0, _Con.k_c * -delta - _Con.b_c * max(delta_dot, 0.0)) if delta < 0 else 0.0
    assert contact.normal_force.py_func(law, kin) == pytest.approx(want, abs=1e-15)
    assert contact.exit_margin.py_func(_Con, *mode, kin) >= 0.0
    for normal in range(4):
        margin = contact.exit_margin.py_func(_Con, normal, contact.FORWARD, kin)
        assert contact.stays.py_func(_Con, normal, contact.FORWARD, kin) == (margin >= 0.0)


def test_coulomb_friction_is_odd_and_saturates():
    con = type("Con", (_Con,), {"radius": 0.5, "slip_velocity": 0.1})
    for slip, sigma in [(-3.0, -1.0), (-0.1, -1.0), (-0.05, -0.5), (0.0, 0.0), (0.02, 0.2), (0.1, 1.0), (9.0, 1.0)]:
        kin = _kin(0.1, 0.0, slip)
        law = contact.law_of.py_func(con, *contact.classify.py_func(con, kin))
        assert law.mu + law.mu_slope * slip == pytest.approx(con.friction * sigma)


def test_editing_any_kernel_source_names_another_cache_folder(tmp_path):
    kernel = Path(contact.__file__).parent
    for source in kernel.glob("*.py"):
        (tmp_path / source.name).write_bytes(source.read_bytes())
    before = fingerprint(tmp_path)
    assert before == fingerprint(kernel) == cache_folder().name
    (tmp_path / "contact.py").write_text("# edited\n" + (tmp_path / "contact.py").read_text())
    assert fingerprint(tmp_path) != before
