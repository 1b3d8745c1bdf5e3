"""What the printed tables say: the energy ledger, and pairs of whirls."""

import math
from dataclasses import replace

import numpy as np
import pytest

from reports import short_report
from rsc.analysis.follow.delayed_jump import Delay
from rsc.analysis.survey.survey import Survey
from rsc.results.summary import Ledger, Status, Summary
from rsc.scene.scene import Scene
from rsc.show.pictures.moments import moments
from rsc.show.words.text import run_text, survey_text
from scenes import LAVAL


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


@pytest.mark.parametrize(
    ("first_seen", "jump", "towards", "text"),
    [
        (40.0, 41.0, -61.0, "at this run-up rate the new line (-61.00 Hz) is first seen at 40.0 Hz and takes over at 41.0 Hz"),
        (40.0, math.nan, -61.0, "is first seen at 40.0 Hz, and the run ends before it takes over"),
        (math.nan, math.nan, -61.0, "this run ends before the new line (-61.00 Hz) is seen"),
        (math.nan, math.nan, math.nan, "this run ends before a new line is seen"),
    ],
)
def test_a_run_that_ends_before_a_whirl_is_lost_has_no_numbers_of_it(first_seen, jump, towards, text):
    level = math.nan if math.isnan(towards) else 4.4e-6
    delay = Delay(38.7, first_seen, jump, 45.0, 1e-6, 1e-15, level, "start", towards)
    told = survey_text(Survey(Scene.from_dict(LAVAL), np.array([30.0, 40.0]), [], [], [], {}, {"B": delay}, []))
    assert text in told and "nan" not in told


def test_a_moment_of_a_rolling_whirl_is_called_so():
    report = short_report()
    rolling = [replace(window, frequency=replace(window.frequency, branch="roll")) for window in report.windows]
    texts = {moment.text for moment in moments(replace(report, windows=rolling))}
    assert "rolling" in texts and "whirl roll" not in texts
