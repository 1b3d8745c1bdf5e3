"""What the printed tables say: the energy ledger, and pairs of whirls."""

import pytest

from rsc.results.summary import Ledger, Status, Summary
from rsc.show.text import run_text


def summary_with(contact, residual, rtol=1e-6):
    """A Summary of a run whose contact dissipated an energy, with a turnover of 20 J."""
    ledger = Ledger(0.0, 10.0, 4.0, 6.0, contact, -residual - contact, residual)
    return Summary(Status.FINISHED, "", 1.0, rtol, 10, 0, 60, 0, 0, 0, 1.0, 0.0, 0.0, ledger, "")


@pytest.mark.parametrize(
    ("contact", "residual", "text"),
    [
        (1.2e-7, 1e-6, "contact 1.2e-07; "),
        (0.0, 1e-6, "contact 0; "),
        # by integration error, although larger than the residual: below ten times rtol of the turnover
        (-2.16e-6, 1.9e-6, "contact 0 (to 2e-06); "),
        (-3e-3, 5e-3, "contact 0 (to 0.003); "),
        # what no error of the integration explains is shown
        (-3e-3, 1e-6, "contact -0.003; "),
    ],
)
def test_no_dissipation_is_negative_within_the_ledgers_accuracy(contact, residual, text):
    assert text in run_text(summary_with(contact, residual))


def test_a_tighter_tolerance_explains_less():
    assert "contact -2e-06; " in run_text(summary_with(-2e-6, 1e-9, rtol=1e-10))
