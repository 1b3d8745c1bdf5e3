"""The short bearing of docs/users/journal.md: its coefficients are derivatives of the film's force by Reynolds' equation."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import root

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "users" / "journal.md").read_text(encoding="utf-8")
LOAD, LENGTH, DIAMETER, CLEARANCE, VISCOSITY = 60.0, 0.02, 0.04, 1e-4, 0.02
ANGLE = np.linspace(0.0, 2.0 * np.pi, 40_001)[:-1]


def short_bearing():
    """The function of the page."""
    names = {}
    exec(next(block for block in re.findall(r"```python\n(.*?)^```$", PAGE, re.M | re.S) if "def short_bearing" in block), names)
    return names["short_bearing"]


def film_force(state, Omega):
    """[F_y, F_z] on a journal with [y, z, y', z'] of m and m/s: of the short film's pressure, integrated along the axis, what is
    positive. Its height is c - y cos a - z sin a, and the pressure -eta L^3/h^3 (Omega/2 dh/da + dh/dt)."""
    y, z, v, w = state
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    height = CLEARANCE - y * c - z * s
    squeezed = 0.5 * Omega * (y * s - z * c) - v * c - w * s
    pressure = np.maximum(-VISCOSITY * LENGTH**3 / height**3 * squeezed, 0.0)
    return -np.array([(pressure * c).mean(), (pressure * s).mean()]) * np.pi * DIAMETER


@pytest.mark.parametrize("speed", [8.0, 25.0, 80.0])
def test_coefficients_are_derivatives_of_the_films_force(speed):
    Omega = 2.0 * np.pi * speed
    found = root(lambda place: (film_force([*CLEARANCE * place, 0.0, 0.0], Omega) - [0.0, LOAD]) / LOAD, [0.3, -0.4], tol=1e-10)
    rest = np.array([*CLEARANCE * found.x, 0.0, 0.0])
    assert abs(film_force(rest, Omega) - [0.0, LOAD]).max() < 1e-7 * LOAD and rest[0] > 0.0 > rest[1]
    steps = np.array([1e-4 * CLEARANCE] * 2 + [1e-4 * CLEARANCE * Omega] * 2)
    slopes = np.array([
        (film_force(rest + step, Omega) - film_force(rest - step, Omega)) / (2.0 * step.sum()) for step in np.diag(steps)
    ])  # fmt: skip
    stiffness, damping = short_bearing()(speed)
    assert -slopes[:2].T.ravel() == pytest.approx(stiffness, rel=1e-4)
    assert -slopes[2:].T.ravel() == pytest.approx(damping, rel=1e-4)
