"""The benchmark's methods agree with its reference on short pieces of the problems; absent peers are skipped with the reason."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[3] / "bench"))

import c_code
from peers.common import Absent
from peers.cvode_peer import Cvode
from peers.cyrk_peer import CyRK
from peers.exudyn_peer import Exudyn
from peers.fixed_step import Fixed
from peers.heyoka_peer import Heyoka
from peers.numbalsoda_peer import Numbalsoda
from peers.own import Naive, PlainC, Rsc
from peers.scipy_peers import Scipy
from problems import RATE, displacements, problem
from reference import gbs_run, reference_run

# the piece of P1c ends in its first dozens of onsets; errors in gaps at tolerance 1e-8, or 64 steps between output times
PIECE = 0.02
METHODS = {
    "rsc": (Rsc, (), 1e-8, 1e-5),
    "plain C": (PlainC, (), 1e-8, 1e-5),
    "naive": (Naive, (), 1e-8, 1e-2),  # ignores the switches
    "scipy DOP853": (Scipy, ("DOP853",), 1e-8, 1e-2),
    "CyRK Vern7": (CyRK, ("Vern7",), 1e-8, 1e-2),
    "numbalsoda DOP853": (Numbalsoda, ("DOP853",), 1e-8, 1e-2),
    "numbalsoda LSODA": (Numbalsoda, ("LSODA",), 1e-8, 1e-2),
    "CVODE Adams": (Cvode, ("Adams",), 1e-8, 1e-2),
    "heyoka": (Heyoka, (), 1e-8, 1e-8),
    "Exudyn": (Exudyn, (), 64, 1e-2),
    "RK4": (Fixed, ("RK4",), 64, 1e-2),
    "Newmark": (Fixed, ("Newmark",), 64, 1e-1),
}


@pytest.fixture(scope="module")
def piece():
    """A short piece of P1c and its reference displacements."""
    case = problem("P1c", PIECE)
    return case, reference_run(case, RATE, 16)[0]


def displacement_error(motion, case, rows):
    return abs(motion - displacements(rows, case)).max() / case.matrices.gap


@pytest.mark.parametrize("name", METHODS)
def test_method_agrees_with_reference(piece, name):
    case, rows = piece
    make, arguments, setting, allowed = METHODS[name]
    try:
        outcome = make(case, *arguments)(setting, 60.0)
    except Absent as cause:
        pytest.skip(str(cause))
    assert outcome.cause == ""
    assert outcome.calls > 100
    assert displacement_error(outcome.motion, case, rows) < allowed


def test_references_of_two_families_agree(piece):
    case, rows = piece
    try:
        extrapolated, switches = gbs_run(case, RATE, 8, 6)
    except c_code.NoCompiler as cause:
        pytest.skip(str(cause))
    assert switches > 20
    assert displacement_error(displacements(extrapolated, case), case, rows) < 1e-10


def test_c_yardstick_takes_the_kernels_steps(piece):
    case, _ = piece
    try:
        plain = PlainC(case)
    except Absent as cause:
        pytest.skip(str(cause))
    ours = Rsc(case)
    plain(1e-8)
    ours(1e-8)
    assert plain.counts["steps"] == pytest.approx(ours.counts["steps"], rel=2e-3)
    assert plain.counts["rejected"] == pytest.approx(ours.counts["rejected"], abs=5)
