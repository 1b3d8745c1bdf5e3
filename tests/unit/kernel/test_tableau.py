"""The Runge-Kutta pair as data: order conditions by rooted trees, and the interpolant."""

import numpy as np
import pytest

from rsc.kernel.tableau import DORMAND_PRINCE, METHODS, positions_of, table_of


def square(table):
    """Matrix of a table with the slope at the step's end as its last stage."""
    n = len(table.nodes) + 1
    matrix = np.zeros((n, n))
    for i, row in enumerate(table.rows, start=1):
        matrix[i, : len(row)] = row
    matrix[-1, :-1] = table.weights
    return matrix


def trees(matrix, order):
    """{n: [(weights of the stages, gamma)]} of the rooted trees up to `order`, built from B-series products."""
    one = np.ones(matrix.shape[0])
    found = {1: [(one, 1)]}
    for n in range(2, order + 1):
        found[n] = [entry for parts in partitions(n - 1) for entry in grafts(matrix, parts, found, n)]
    return found


def partitions(n, largest=None):
    largest = largest or n
    if n == 0:
        return [()]
    return [(k, *rest) for k in range(min(n, largest), 0, -1) for rest in partitions(n - k, k)]


def grafts(matrix, parts, found, n):
    """All trees of n nodes whose root carries subtrees of the given sizes (with repetitions, harmless here)."""
    products = [(np.ones(matrix.shape[0]), 1)]
    for size in parts:
        products = [(p * (matrix @ w), g * gw) for p, g in products for w, gw in found[size]]
    return [(p, n * g) for p, g in products]


def test_solution_meets_every_order_condition():
    matrix = square(DORMAND_PRINCE)
    np.testing.assert_allclose(matrix[:-1].sum(axis=1), DORMAND_PRINCE.nodes, atol=3e-14)
    b = np.append(DORMAND_PRINCE.weights, 0.0)
    for n, conditions in trees(matrix, 6).items():
        defects = [abs(b @ weights - 1 / gamma) for weights, gamma in conditions]
        assert max(defects) < 3e-14 if n <= 5 else max(defects) > 1e-6


def test_embedded_solution_is_of_one_order_less():
    conditions = trees(square(DORMAND_PRINCE), 5)
    defects = {n: max(abs(np.dot(DORMAND_PRINCE.error, w)) for w, _ in found) for n, found in conditions.items()}
    assert max(defects[n] for n in range(1, 5)) < 3e-14
    assert defects[5] > 1e-5
    assert DORMAND_PRINCE.estimate_order == 5


def test_positions_are_those_of_the_velocities_put_in():
    table = DORMAND_PRINCE
    positions, matrix = positions_of(table), square(table)
    twice = matrix @ matrix
    for i, row in enumerate(positions.rows, start=1):
        np.testing.assert_allclose(row, twice[i, : i - 1], atol=3e-14)
        assert not twice[i, i - 1 :].any()
    for found, row in ((positions.error, table.error), (positions.dense, table.dense)):
        np.testing.assert_allclose(found, (row @ matrix)[:-1], atol=3e-14)
        # why neither has a term of the velocity at the start
        assert abs(sum(row)) < 1e-15
    assert any(0.0 in row for row in positions.rows), "what is nothing but for rounding is no code"


def test_every_method_is_told_by_its_number_of_stages():
    tables = {"rk45": DORMAND_PRINCE, "taylor8": None}
    assert {name: table_of(stages) for name, stages in METHODS.items()} == tables


def test_interpolant_of_dormand_prince_is_of_order_four_everywhere():
    """Quadrature of the interpolant's weights b_i(theta) against theta^n/gamma for every tree of order <= 4."""
    b, end = np.append(DORMAND_PRINCE.weights, 0.0), np.eye(7)
    for theta in (0.13, 0.5, 0.77):
        rest = 1 - theta
        bend = end[0] - b
        twist = 2 * b - end[6] - end[0]
        weights_inside = theta * (b + rest * (bend + theta * (twist + rest * np.array(DORMAND_PRINCE.dense))))
        for n, conditions in trees(square(DORMAND_PRINCE), 4).items():
            for weights, gamma in conditions:
                assert weights_inside @ weights == pytest.approx(theta**n / gamma, abs=2e-14)

