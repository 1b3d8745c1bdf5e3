"""Eigenvalues by our own iteration: known spectra, backward errors, numpy's beside them, refusals."""

import os
import subprocess
import sys
from unittest.mock import Mock

import numpy as np
import pytest
import scipy.linalg  # noqa: F401  loads its OpenBLAS
from threadpoolctl import threadpool_info, threadpool_limits

from rsc import cli
from rsc.analysis.algebra import eigenvalues as module
from rsc.analysis.algebra.double_shift import hessenberg_eigenvalues
from rsc.analysis.algebra.eigenvalues import eigenvalues
from rsc.analysis.balance import balance, floquet
from rsc.analysis.follow import whirls as seeds
from rsc.analysis.follow.branches import branches
from rsc.analysis.paper import roots as analytic
from rsc.analysis.paper.predict import predict_system
from rsc.cli import new
from rsc.system.blas import one_thread
from systems import make_system, random_body, reference


def with_spectrum(n, seed):
    """A real matrix with known eigenvalues, real ones and pairs, well conditioned but far from symmetric and balanced."""
    rng = np.random.default_rng(seed)
    pairs, real = rng.normal(size=(n // 4, 2)), rng.normal(size=n - 2 * (n // 4))
    blocks = np.diag(np.concatenate([np.repeat(pairs[:, 0], 2), real]))
    for k, (_, imaginary) in enumerate(pairs):
        blocks[2 * k, 2 * k + 1], blocks[2 * k + 1, 2 * k] = imaginary, -imaginary
    basis = np.linalg.qr(rng.normal(size=(n, n)))[0] @ (np.eye(n) + 0.1 * np.triu(rng.normal(size=(n, n)), 1) / np.sqrt(n))
    scale = 10.0 ** rng.uniform(-3.0, 3.0, n)
    matrix = basis @ blocks @ np.linalg.inv(basis)
    return scale[:, None] * matrix / scale, np.concatenate([pairs @ [1, 1j], pairs @ [1, -1j], real])


@pytest.mark.parametrize("n", [39, 40, 75, 166, 250, 500, 501])
def test_known_spectrum(n):
    matrix, spectrum = with_spectrum(n, n)
    found = eigenvalues(matrix)
    assert found.shape == (n,)
    assert np.abs(found[:, None] - spectrum).min(axis=0).max() < 1e-10
    assert (found.imag == 0.0).sum() == (spectrum.imag == 0.0).sum()


def test_stack_of_matrices():
    stack = np.random.default_rng(0).normal(size=(2, 3, 90, 90))
    untouched = stack.copy()
    found = eigenvalues(stack)
    assert found.shape == (2, 3, 90)
    np.testing.assert_array_equal(stack, untouched)
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(np.linalg.eigvals(stack)), atol=1e-12)


def test_isolated_eigenvalues():
    """Rows and columns that a permutation makes triangular around a block give their eigenvalues exactly."""
    rng = np.random.default_rng(1)
    matrix = np.triu(rng.normal(size=(120, 120)))
    block = slice(30, 110)
    matrix[block, block] = np.linalg.qr(rng.normal(size=(80, 80)))[0]
    outside = np.delete(np.diag(matrix), np.arange(30, 110))
    order = rng.permutation(120)
    found = eigenvalues(matrix[np.ix_(order, order)])
    assert np.isin(outside, found.real[found.imag == 0.0]).all()
    assert (np.abs(np.abs(found) - 1.0) < 1e-9).sum() == 80


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_numbers_that_are_not_finite(number):
    matrix = np.eye(100)
    matrix[3, 5] = number
    with pytest.raises(np.linalg.LinAlgError):
        eigenvalues(matrix)


def cases():
    """Matrices (n, n) on which an iteration can stall, lose accuracy or stop too early."""
    rng, n = np.random.default_rng(2), 60
    random, steps = rng.normal(size=(n, n)), np.logspace(0.0, -12.0, n)
    companion = np.eye(n, k=-1)
    companion[0] = -np.poly(np.linspace(0.5, 1.5, n))[1:]
    blocks = np.kron(np.eye(n // 2), [[0.3, 2.0], [-2.0, 0.3]])
    return {
        "ones": np.ones((n, n)),
        "round a circle": np.roll(np.eye(n), 1, axis=0),  # the usual shifts are all 0 and leave it as it is
        "signed circle": np.roll(np.eye(n), 1, axis=0) * np.where(np.arange(n) == 3, -1.0, 1.0),
        "one Jordan block": np.eye(n) + np.eye(n, k=1) + 1e-3 * np.eye(n, k=-1) * (np.arange(n) == 7),
        "equal pairs": blocks,
        "equal pairs, coupled": blocks + 1e-9 * random,
        "symmetric": random + random.T,
        "skew": random - random.T,
        "graded down": steps[:, None] * random * steps,
        "graded up": steps[::-1, None] * random * steps[::-1],
        "companion": companion,
        "two parts": np.kron(np.diag([1.0, 1e-8]), random[:30, :30]),
    }


@pytest.mark.parametrize("name", cases())
def test_backward_error(name, monkeypatch):
    """Every eigenvalue found, without numpy's help, is one of a matrix within rounding, and their sum is the trace."""
    monkeypatch.setattr(np.linalg, "eigvals", None)
    matrix = cases()[name]
    found, size = eigenvalues(matrix), np.linalg.norm(matrix, 2)
    for value in found:
        least = np.linalg.svd(matrix - value * np.eye(len(matrix)), compute_uv=False)[-1]
        assert least < 1e-13 * size
    assert abs(found.sum() - np.trace(matrix)) < 1e-12 * size * len(matrix)
    np.testing.assert_array_equal(np.sort_complex(found[found.imag > 0]), np.sort_complex(found[found.imag < 0].conj()))


def test_an_entry_below_rounding_still_counts_between_equal_entries():
    """[[1, 1], [d, 1]] has the eigenvalues 1 +- sqrt(d)."""
    below = 2e-16
    found = np.sort(hessenberg_eigenvalues(np.array([[1.0, 1.0, 0.0], [below, 1.0, 0.0], [0.0, 0.0, 5.0]])).real)
    apart = np.sqrt(below)
    np.testing.assert_allclose(found - [1.0, 1.0, 5.0], [-apart, apart, 0.0], rtol=1e-6)


@pytest.mark.parametrize("scale", [0.0, 1e-290, 1e290])
def test_numbers_whose_squares_leave_the_range(scale):
    matrix, spectrum = with_spectrum(50, 4)
    assert np.abs(eigenvalues(scale * matrix)[:, None] - scale * spectrum).min(axis=0).max() <= 1e-10 * scale


def test_zeros():
    np.testing.assert_array_equal(hessenberg_eigenvalues(np.zeros((5, 5))), np.zeros(5))


def test_two_rows_without_coupling_back():
    np.testing.assert_array_equal(hessenberg_eigenvalues(np.array([[1.0, 0.0], [1.0, 1.0]])), [1.0, 1.0])


def test_without_convergence_numpy_takes_over(monkeypatch):
    monkeypatch.setattr(module, "hessenberg_eigenvalues", lambda matrix: None)
    matrix, spectrum = with_spectrum(100, 3)
    assert np.abs(eigenvalues(matrix)[:, None] - spectrum).min(axis=0).max() < 1e-10


def test_no_convergence_is_told():
    assert hessenberg_eigenvalues(np.full((5, 5), np.nan)) is None


def threads():
    """Threads of each BLAS in this process."""
    return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]


def test_one_thread_meanwhile(monkeypatch):
    """Threads of two OpenBLAS would be in each other's way; afterwards they are as before."""
    seen, routine = [], module.hessenberg_eigenvalues
    monkeypatch.setattr(module, "hessenberg_eigenvalues", lambda matrix: seen.append(threads()) or routine(matrix))
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        eigenvalues(np.eye(100))
        assert threads() == before
    assert before and set(before) <= {1, 2} and seen == [[1] * len(before)]


def test_libraries_that_come_later_have_one_thread():
    program = """if True:
        from threadpoolctl import threadpool_info
        from rsc.system.blas import one_thread
        with one_thread:
            import scipy.linalg
            print(*(library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"))
    """
    assert set(printed(program).split()) == {"1"}


def printed(program):
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "2", "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout
    return done.stdout


def test_a_command_in_its_own_process_has_one_thread_and_loads_no_more_of_scipy_than_it_needs():
    program = """if True:
        import sys
        from rsc.cli import main, new

        def look(*_):
            loaded = "scipy.linalg" in sys.modules
            import scipy.linalg
            from threadpoolctl import threadpool_info
            print(loaded, {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"})
            return ""

        new.template = look
        main(["new", "laval"])
    """
    assert printed(program).splitlines()[0] == "False {1}"


def test_commands_have_one_thread(monkeypatch):
    seen = []
    monkeypatch.setattr(new, "template", lambda *_: seen.append(threads()) or "")
    with threadpool_limits(2, user_api="blas"):
        cli.main(["new", "laval"])
    assert seen and set(seen[0]) == {1}


def test_branches_have_one_thread(monkeypatch):
    seen, roots = [], seeds.roots_by_place
    looked = lambda *arguments, **options: seen.append(threads()) or roots(*arguments, **options)  # noqa: E731
    monkeypatch.setattr(seeds, "roots_by_place", looked)
    with threadpool_limits(2, user_api="blas"):
        branches(reference("mdof_2x2"), [50.0, 60.0])
    assert seen and all(set(counts) == {1} for counts in seen)


def with_20_coordinates():
    rng = np.random.default_rng(0)
    rotor, stator = random_body(rng, 18, 0.02), random_body(rng, 2, 0.02)
    return make_system((*rotor, np.zeros((18, 18))), stator, (0, 0, 0.3, 1e7))


class Seen(Exception):
    """Ends a call where its threads were looked at."""


CALLS = {
    "roots of 20 coordinates": (analytic, "_candidates", lambda: analytic.whirl_roots(with_20_coordinates(), 300.0)),
    "predict": (sys.modules["rsc.analysis.paper.predict"], "steady_whirls", lambda: predict_system(reference("mdof_2x2"), 50.0)),
    "balance": (balance, "_Unbalanced", lambda: balance.balance(reference("mdof_2x2"), -70.0, 50.0)),
    "its stability": (floquet, "_over_beat", lambda: floquet.balance_growth(None, Mock(speed=50.0, frequency=-70.0))),
}


@pytest.mark.parametrize("name", CALLS)
def test_the_analysis_has_one_thread(name, monkeypatch):
    module, part, call = CALLS[name]
    seen = []

    def look(*_, **__):
        seen.append(threads())
        raise Seen

    monkeypatch.setattr(module, part, look)
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        with pytest.raises(Seen):
            call()
        assert set(seen[0]) == {1} and threads() == before


def test_threads_that_overlap_restore_what_the_first_one_found():
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        one_thread.__enter__()
        one_thread.__enter__()
        one_thread.__exit__()
        assert set(threads()) == {1}
        one_thread.__exit__()
        assert threads() == before
