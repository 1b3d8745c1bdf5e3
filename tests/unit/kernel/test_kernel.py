"""The parts of the kernel: tableau, packed vectors, rotation, contact modes, and that one compilation serves."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numba.core import errors

from rsc.compiled.code_cache import cache_folder
from rsc.kernel import contact, control, losses
from rsc.kernel.clock import Segment, clock_at, turn_inside
from rsc.kernel.march import march
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import entry, inlined
from rsc.kernel.springs import Linear
from rsc.kernel.tableau import METHODS
from rsc.kernel.turn import cos_sin, cos_sin_at, turned
from rsc.scene.scene import Scene
from rsc.study.run.start import run_of
from scenes import SCENES


@entry
def _vector_operations(values, columns, out, width):
    a, n = vec.load(values, width), len(width)
    b = vec.load_at(vec.address(values), n, width)
    product = vec.times_columns(vec.address(columns), b)
    vec.store(out, vec.fma(2.0, a, b) - vec.times_i(a) * b + vec.swap(b) / a + product)
    y, z = vec.pair_sum(vec.product(a, vec.spread(1.0, a)))
    vec.store_at(vec.address(out), n, vec.fill(y, z, a))
    square = vec.larger(a * a, b * b)
    return vec.largest(square + vec.swap(square))


@pytest.mark.versions
@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 7, 13, 30])
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
    c, s = cos_sin(vec.from_numbers((0.3, phase, 1e6, 0.0), phase))
    return vec.lane(c, 1), vec.lane(s, 1), *cos_sin_at(phase)


LONG = pytest.mark.skipif(np.finfo(np.longdouble).eps == np.finfo(float).eps, reason="long double has no more digits here")


@LONG
@pytest.mark.versions
def test_rotation_is_sine_and_cosine_and_independent_of_the_other_lanes():
    phases = np.concatenate([np.linspace(-2, 2, 4001), np.random.default_rng(0).uniform(-1, 4, 4000)])
    got = np.array([_cos_sin(phase) for phase in phases])
    angle = 2 * np.longdouble("3.14159265358979323846264") * (phases - np.round(phases)).astype(np.longdouble)
    exact = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert abs(got[:, :2] - exact).max() < 3e-16
    assert np.array_equal(got[:, :2], got[:, 2:])


@entry
def _turned(cos, sin, angle):
    like = vec.from_numbers((0.0, 0.0), angle)
    c, s = turned(vec.spread(cos, like), vec.spread(sin, like), vec.spread(angle, like))
    return vec.lane(c, 0), vec.lane(s, 0)


@LONG
def test_rotation_of_a_stage_is_that_of_the_start_turned_on():
    """Exact to the last bits (two roundings of each sum and one of the sine), nothing for no angle; the same bits a quarter of a
    turn on, and mirrored."""
    two_pi, rng = 2 * np.longdouble("3.14159265358979323846264"), np.random.default_rng(1)
    for start, angle in zip(rng.uniform(-1, 1, 4000), np.append(rng.uniform(-0.25, 0.25, 3998), [0.25, -0.25]), strict=True):
        c, s = float(np.cos(two_pi * start)), float(np.sin(two_pi * start))
        at = np.arctan2(np.longdouble(s), np.longdouble(c)) + two_pi * np.longdouble(angle)
        got = _turned(c, s, angle)
        assert np.hypot(got[0] - np.cos(at), got[1] - np.sin(at)) < 5e-16
        assert _turned(c, s, 0.0) == (c, s)
        assert _turned(-s, c, angle) == (-got[1], got[0])
        assert _turned(c, -s, -angle) == (got[0], -got[1])


@entry
def _turn_after(segment, phase, tau):
    turn = turn_inside(clock_at(segment, 2.0, 0.0, phase), tau)
    return turn.cos, turn.sin


def test_rotation_inside_a_step_is_good_for_every_length_of_it():
    """Up to a quarter of a turn, which no step exceeds (`Model.h_max`)."""
    for tau in np.linspace(0.0, 0.25 / 46.0, 400):
        angle = 2 * np.pi * (0.7 + 46.0 * tau + 0.5 * 3.0 * tau**2)
        got = _turn_after(Segment(0.0, 10.0, 40.0, 3.0, (), (), ()), 0.7, tau)
        assert np.allclose(got, (np.cos(angle), np.sin(angle)), rtol=0.0, atol=2e-15)


@entry
def _mean_square(v_0, mean, v_1, slope_0, slope_1):
    return losses.between_ends((v_0, mean, v_1), slope_0, slope_1, 1.0, 0.0)


def test_work_of_dampers_between_the_ends_of_a_step_is_of_order_six():
    """The mean of v^2 over a step: exact where v is a parabola, with an error of h^6 where it is not."""
    for b, c in ((0.0, 0.0), (1.7, 0.0), (-0.4, 2.3)):  # v = 1 + b t + c t^2 over a step of length 1
        got = _mean_square(1.0, 1.0 + b / 2 + c / 3, 1.0 + b + c, b, b + 2 * c)
        assert got == pytest.approx(1.0 + b + (b**2 + 2 * c) / 3 + b * c / 2 + c**2 / 5, rel=1e-14)

    def error(h):  # v = e^t
        e = np.exp(h)
        return _mean_square(1.0, np.expm1(h) / h, e, h, h * e) - np.expm1(2 * h) / (2 * h)

    assert np.log2(error(0.4) / error(0.2)) == pytest.approx(6.0, abs=0.3)


@entry
def _factor(error2, method):
    return control.factor(error2, method)


@pytest.mark.parametrize(("method", "k"), [("rk45", 5), ("taylor8", 8)])
def test_step_factor_is_the_power_it_stands_for(method, k):
    """Within one part in a hundred of (aim/err)^(1/k) between the clips; NaN and infinity shrink it."""
    for error2 in 10.0 ** np.linspace(-9.0, 7.9, 200):
        want = np.clip(({5: 0.2, 8: 0.02}[k] / error2) ** (0.5 / k), 0.2031, 4.925)
        assert _factor(error2, METHODS[method]) == pytest.approx(want, rel=0.01)
    for error2 in (np.nan, np.inf, 1e300):
        assert _factor(error2, METHODS[method]) == 0.2
    assert _factor(0.0, METHODS[method]) > {5: 4.9, 8: 2.3}[k]


class _Con(NamedTuple):
    """What of the Constants the contact asks for."""

    gap: float
    surfaces: contact.Surfaces


CON = _Con(1.0, contact.Surfaces(Linear(100.0), 2.0, 0.2, 0.0, 1.0))


def _kin(penetration, rate, slip=0.0):
    distance = 1.0 + penetration
    place = contact.Deflection(1.0, 0.0, 1 / distance, distance, penetration, 0.0, 0.0)
    return contact.Kinematics(place, contact.DeflectionRates(rate, rate * distance, 0.0, 0.0, slip, abs(rate) + 0.5))


@pytest.mark.versions
@pytest.mark.parametrize("penetration", [-0.1, -1e-12, 1e-12, 0.01, 0.3])
@pytest.mark.parametrize("rate", [-20.0, -3.0, -0.4, -1e-9, 0.0, 1e-9, 2.0])
def test_modes_reproduce_the_pseudolinear_law(penetration, rate):
    """Equations (10), (11) written once more, against the force of the mode that the state belongs to."""
    kin = _kin(penetration, rate)
    mode = contact.classify.py_func(CON, kin)
    law = contact.law_of.py_func(CON, *mode)
    delta, delta_dot = -penetration, -rate
    want = max(0.0, 100.0 * -delta - 2.0 * max(delta_dot, 0.0)) if delta < 0 else 0.0
    assert contact.normal_force.py_func(law, kin) == pytest.approx(want, abs=1e-15)
    assert contact.exit_margin.py_func(CON, *mode, kin) >= 0.0
    for normal in range(4):
        margin = contact.exit_margin.py_func(CON, normal, contact.FORWARD, kin)
        assert contact.stays.py_func(CON, normal, contact.FORWARD, kin) == (margin >= 0.0)


def test_coulomb_friction_is_odd_and_saturates():
    con = CON._replace(surfaces=CON.surfaces._replace(radius=0.5, slip_velocity=0.1))
    for slip, sigma in [(-3.0, -1.0), (-0.1, -1.0), (-0.05, -0.5), (0.0, 0.0), (0.02, 0.2), (0.1, 1.0), (9.0, 1.0)]:
        kin = _kin(0.1, 0.0, slip)
        law = contact.law_of.py_func(con, *contact.classify.py_func(con, kin))
        assert law.mu + law.mu_slope * slip == pytest.approx(con.surfaces.friction * sigma)


def test_no_fast_math_and_no_vector_library():
    """They drop the checks for NaN, or have been miscompiled; products and sums are contracted only where the source says fma."""
    assert not any(march.targetoptions.get(name) for name in ("fastmath", "parallel"))
    for source in Path(contact.__file__).parent.rglob("*.py"):
        assert not re.search(r"fastmath\s*=|flags=", source.read_text())  # of Numba's decorators, of LLVM's instructions
    run_of(Scene.from_dict(SCENES["bouncing"])).compile()
    compiled = [file.read_bytes() for file in cache_folder(Path(contact.__file__).parent).rglob("march*.nbc")]
    assert compiled and not any(b"svml" in code for code in compiled)


@inlined
def _share(whole, parts):
    if parts == 0:
        raise ValueError("no parts")
    return whole / parts


@inlined
def _both(numbers, flag):
    return (numbers[0] + numbers[1], not flag), numbers


@entry
def _shares(whole, parts):
    return _share(whole, parts)


@entry
def _nested(a, b, flag):
    inner, numbers = _both((a, b), flag)
    (total, other), _ = _both((inner[0], numbers[1]), inner[1])
    return total, inner[1], other


def test_helpers_get_tuples_whole_and_cannot_raise():
    assert _nested(1.0, 2.0, False) == (5.0, True, False)
    with pytest.raises(errors.NumbaError, match="a helper cannot raise"):
        _shares(1.0, 2)
