"""The benchmark's methods agree with its reference on short pieces of the problems; absent peers are skipped with the reason."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[3] / "bench"))

import c_code
import driven
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
from third_engine import machine_of, rates, torque_of

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


def agrees(name, case, rows):
    """Whether a method runs here and meets a reference; skipped where it does not take part."""
    make, arguments, setting, allowed = METHODS[name]
    try:
        outcome = make(case, *arguments)(setting, 60.0)
    except Absent as cause:
        pytest.skip(str(cause))
    assert outcome.cause == ""
    assert outcome.calls > 100
    return displacement_error(outcome.motion, case, rows) < allowed


@pytest.mark.parametrize("name", METHODS)
def test_method_agrees_with_reference(piece, name):
    assert agrees(name, *piece)


@pytest.fixture(scope="module")
def pump():
    """The first dozens of switches of the pump and its reference displacements."""
    case = problem("pump", PIECE)
    return case, driven.reference_run(case, 12)[0]


def test_the_pump_of_other_programs_is_that_of_the_third_engine():
    case = problem("pump", PIECE)
    machine, shaft = machine_of(case.system), torque_of(case.system.drive.inertia, case.scene.drive.torque)
    dice, gap, half, c = np.random.default_rng(1), case.matrices.gap, case.start.size // 2, len(case.matrices.rows)
    pressed = 0
    for _ in range(200):
        y = dice.normal(size=2 * half) * np.repeat([3.0 * gap, 600.0 * gap], half)
        y[0], y[half] = 10.0 * y[0], 2.0 * np.pi * dice.uniform(20.0, 80.0) * gap
        ours, theirs = np.empty(2 * half), np.empty(2 * half + c)
        driven.right_hand_side_driven(case.matrices, 0.0, y, ours)
        rates(machine, shaft, 0.0, np.concatenate([[y[0] / gap, y[half] / gap], np.zeros(c), y[1:half], y[half + 1 :]]), theirs)
        moved, change = theirs[2 + c : 1 + c + half], theirs[1 + c + half :]
        expected = np.concatenate([[theirs[0] * gap], moved, [theirs[1] * gap], change])
        assert ours == pytest.approx(expected, rel=1e-9, abs=1e-12)
        held = np.zeros(2 * c + 2, int)
        driven.states_of(case.matrices, y, held)
        pressed += (held[:c] > 0).sum()
    assert pressed > 50


@pytest.mark.nightly
@pytest.mark.parametrize("name", METHODS)
def test_method_agrees_with_the_reference_of_the_pump(pump, name):
    assert agrees(name, *pump)


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
