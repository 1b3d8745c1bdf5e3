"""Whether a body is held is decided at the digits of its file: free shafts are told so, held ones are taken."""

import numpy as np
import pytest

from fe_bodies import OUTER, YOUNG, rotor
from matrix_writers import dmig
from rsc.errors import DataError
from rsc.machine.checks.rank import SINGLE, digits_of, lowest_motions, rounding_of
from rsc.machine.formats import read_matrices
from rsc.machine.imports.build import rotor_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.model.model import DOUBLE

FREE = ((0.0, 0.0), (0.0, 0.0))


def printed(digits):
    return np.vectorize(lambda value: float(f"{value:.{digits - 1}e}"))


ROUNDED = {
    "single": (lambda matrix: matrix.astype(np.float32).astype(float), SINGLE),
    "single, printed with ten digits": (lambda matrix: printed(10)(matrix.astype(np.float32).astype(float)), SINGLE),
    "seven digits": (printed(7), 5e-7),
    "ten digits": (printed(10), 5e-10),
    "twelve digits": (printed(12), 5e-12),
    "double": (np.array, DOUBLE),
}


def model_of(change, n_elements, **options):
    matrices, nodes, directions = rotor(n_elements=n_elements, **options)
    matrices["stiffness"], matrices["mass"] = change(matrices["stiffness"]), change(matrices["mass"])
    return rotor_model(matrices, Coordinates(nodes, directions), "test", units="m")


@pytest.mark.parametrize("kind", ROUNDED)
def test_the_digits_of_a_matrix_are_found(kind):
    change, rounding = ROUNDED[kind]
    assert rounding_of(change(rotor()[0]["stiffness"])) == pytest.approx(rounding)
    assert rounding_of(rotor()[0]["stiffness"].round(-7)) == DOUBLE  # of few digits: exact
    assert [digits_of(value) for value in (SINGLE, 5e-10, 5e-7)] == [7, 10, 7]


@pytest.mark.parametrize("kind", ROUNDED)
@pytest.mark.parametrize("n_elements", [4, 6, 7, 9, 12, 16, 23, 32, 47, 64, 100])
def test_a_shaft_without_bearings_is_refused(kind, n_elements):
    """At any mesh, where rounding makes a support of it or drives it away."""
    with pytest.raises(DataError, match=r"bearings are missing.*: [23] rigid-body or other motions have no stiffness"):
        model_of(ROUNDED[kind][0], n_elements, bearing=FREE)


@pytest.mark.parametrize("kind", ROUNDED)
def test_a_shaft_on_bearings_is_taken(kind):
    assert not model_of(ROUNDED[kind][0], 16, bearing=((1e7, 1e7), (1e7, 1e7))).free
    if kind in ("ten digits", "twelve digits", "double"):
        assert not model_of(ROUNDED[kind][0], 32, bearing=((2e5, 2e5), (2e5, 2e5))).free


@pytest.mark.parametrize("seed", range(4))
def test_shafts_of_any_mesh_and_bearing_are_told_free_or_held(seed):
    """Random shafts. Every free one is refused at any digits; held ones are taken where the digits can tell: always with 17, and
    where bearing and bending, of some n^-4 of an element's stiffness, are above the rounding. Measured against the stiffest tilt
    over its inertia a soft bearing of a fine mesh was taken for rounding."""
    rng = np.random.default_rng(seed)
    for _ in range(15):
        n, total, soft = int(rng.integers(3, 60)), 10.0 ** rng.uniform(-0.7, 0.9), 10.0 ** rng.uniform(2.0, 8.0)
        disc = tuple(10.0 ** rng.uniform((-1.0, -4.0, -4.0), (2.5, 0.0, 0.0)))
        digits = int(rng.choice([5, 10, 17]))
        with pytest.raises(DataError, match=r"no stiffness|indefinite"):
            model_of(printed(digits), n, total=total, disc=disc, bearing=FREE)
        of_an_element = np.pi * OUTER**4 / 64.0 * 12.0 * YOUNG * (n / total) ** 3
        if digits == 17 or (soft > 100.0 * n * 10.0 ** (1 - digits) * of_an_element and n**4 < 10.0 ** (digits - 1)):
            assert not model_of(printed(digits), n, total=total, disc=disc, bearing=((soft, soft),) * 2).free


def test_a_shaft_that_a_spring_drives_away_is_indefinite():
    with pytest.raises(DataError, match="the stiffness is indefinite"):
        model_of(np.array, 12, bearing=((-1e6, -1e6), (1e7, 1e7)))


def test_lowest_frequency_of_a_held_and_of_a_free_shaft():
    """Of a stiff shaft on soft springs, sqrt(2 k / m); without them that of the first bending, a free beam with its disc."""
    one = ((2e3, 2e3), (2e3, 2e3))
    held, free = (model_of(np.array, 12, bearing=bearing, total=0.3) for bearing in (one, ((1e7, 1e7), (1e7, 1e7))))
    moving = (held.kind == "displacement").astype(float)
    expected = np.sqrt(4e3 / (moving @ held.mass @ moving)) / (2.0 * np.pi)
    assert lowest_motions(held.mass, held.stiffness, "test").frequency == pytest.approx(expected, rel=1e-3)
    without = free.stiffness - 1e7 * sum(np.outer(row, row) for row in (free.row_at(0), free.row_at(12)))
    n_free, frequency = lowest_motions(free.mass, without, "test")
    square = np.linalg.eigvals(np.linalg.solve(free.mass, without)).real
    assert n_free == 2 and frequency == pytest.approx(np.sqrt(np.sort(square)[2]) / (2.0 * np.pi), rel=1e-6)


def test_a_punched_free_shaft_is_refused(tmp_path):
    matrices, nodes, directions = rotor(n_elements=11, bearing=FREE)
    for name in ("mass", "stiffness"):
        dmig(tmp_path / f"{name}.pch", matrices[name], "wide")
    read = {name: read_matrices(tmp_path / f"{name}.pch").matrices["K"] for name in ("mass", "stiffness")}
    with pytest.raises(DataError, match="2 rigid-body or other motions have no stiffness at the 10 digits of its numbers"):
        rotor_model(read, Coordinates(nodes, directions), "test", units="m")
