"""The fastest modes of a reduced body as a compliance in series with the contact."""

from dataclasses import replace

import numpy as np
import pytest

from machines import random_machine
from rsc.errors import ReductionError
from rsc.machine.body import Body
from rsc.machine.reduction import reduce
from rsc.machine.series import in_series

BAND, SPEEDS = (-300.0, 300.0), (0.0, 200.0)


def three_masses():
    """A mass of 1 kg and two of 1 and 0.25 g on the way from it to the contact: a mode at 100 rad/s and two above 9000."""
    k, fast = 1e4, 1e5
    stiffness = np.array([[k + fast, -fast, 0.0], [-fast, 2.0 * fast, -fast], [0.0, -fast, fast]])
    damping = 10.0 * np.diag([1.0, 1e-3, 2.5e-4]) + 1e-7 * stiffness
    unbalance = np.array([[1e-4], [0.0], [0.0]])
    return Body(np.diag([1.0, 1e-3, 2.5e-4]), damping, stiffness, np.array([0.0, 0.0, 1.0]), unbalance=unbalance)


@pytest.fixture(scope="module")
def whole():
    """The three masses reduced to all three coordinates, with room below a tolerance of 5 %."""
    reduced = replace(reduce(three_masses(), BAND, SPEEDS, 1e-9), tolerance=5e-2)
    assert reduced.body.n_coordinates == 3
    return reduced


def receptance(body, Psi):
    stiffness = body.stiffness + 1j * Psi * body.damping - Psi**2 * body.mass
    return body.contact @ np.linalg.solve(stiffness, body.contact)


def test_the_compliance_is_the_static_one_of_the_modes_left_out(whole):
    """Static flexibility of the whole body less that of the first mode."""
    series = in_series(whole, 1000.0, 2e6, 0.0)
    full = three_masses()
    flexibility = full.contact @ np.linalg.solve(full.stiffness, full.contact)
    slow = series.reduced.body
    assert slow.n_coordinates == 1
    assert series.compliance == pytest.approx(flexibility - 1.0 / slow.stiffness.item(), rel=1e-9)
    assert 1.0 / series.contact_stiffness == pytest.approx(1.0 / 2e6 + series.compliance, rel=1e-12)
    assert series.reduced.highest_after < 200.0 < 2e3 < whole.highest_after


def test_receptance_with_the_softer_contact_is_that_of_before(whole):
    k, b = 2e6, 50.0
    series = in_series(whole, 1000.0, k, b)
    slow = series.reduced.body
    for Psi in np.linspace(*BAND, 41):
        before = receptance(three_masses(), Psi) + 1.0 / (k + 1j * Psi * b)
        after = receptance(slow, Psi) + 1.0 / (series.contact_stiffness + 1j * Psi * series.contact_damping)
        assert abs(after - before) <= series.reduced.error * abs(receptance(three_masses(), Psi))
        assert abs(receptance(slow, Psi) + 1.0 / k - before) > 2.0 * abs(after - before)  # which the compliance is for
    assert whole.error < series.reduced.error <= 5e-2


def test_a_rigid_contact_becomes_as_soft_as_the_modes_left_out(whole):
    series = in_series(whole, 1000.0, np.inf, 0.0)
    assert series.contact_stiffness == pytest.approx(1.0 / series.compliance) and series.contact_damping == 0.0


def test_an_error_above_the_tolerance_is_refused(whole):
    with pytest.raises(ReductionError, match=r"above the tolerance 0\.0001; cut higher"):
        in_series(replace(whole, tolerance=1e-4), 1000.0, 2e6, 0.0)
    # a strong damper of the contact is none any more in series with a spring
    with pytest.raises(ReductionError, match="above the tolerance"):
        in_series(whole, 1000.0, 2e6, 5e3)


@pytest.mark.parametrize(
    ("cut", "message"),
    [(250.0, "inside the band"), (1e6, "leaves every mode"), (np.nan, "inside the band")],
)
def test_cuts_that_cannot_be_are_refused(whole, cut, message):
    with pytest.raises(ReductionError, match=message):
        in_series(whole, cut, 2e6, 0.0)


def test_observers_and_skew_terms_come_along():
    machine = random_machine(np.random.default_rng(8), skew=True)
    reduced = replace(reduce(machine.rotor, machine.band, machine.speeds, 1e-6), tolerance=1e-2)
    series = in_series(reduced, 0.9 * reduced.highest_after, 1e8, 0.0)
    small = series.reduced.body
    assert small.n_coordinates < reduced.body.n_coordinates and small.skew_stiffness is not None
    assert np.allclose(small.observers, machine.rotor.observers @ series.reduced.basis, rtol=1e-9, atol=1e-12)
    assert {check.place for check in series.reduced.checks} == {"contact", "observer 0"}
