"""Limits of stability against the recurrence of a step itself, and runs that they hold up: found, named, stopped in time."""

import math

import numpy as np
import pytest

from rsc.kernel import model as kernel
from rsc.kernel.tableau import METHODS, table_of
from rsc.scene.scene import Scene, load_scene
from rsc.simulation.run import Run
from rsc.simulation.stiffness import fastest, resolved_angle, stable_steps
from rsc.study.run.start import run_of
from scenes import LAVAL, SCENES, changed
from systems import REFERENCE
from tiers import alternating

WHIRL = {"whirl": -60.0}


def one_step(stages, z):
    """(value, error estimate) of one step of y' = z y from 1 with h = 1, stage by stage or term by term."""
    table, slopes = table_of(stages), []
    if table is None:
        terms = [z**k / math.factorial(k) for k in range(len(stages) + 1)]
        return sum(terms), terms[-1]
    for row in ((), *table.rows):
        slopes.append(z * (1.0 + sum(a * k for a, k in zip(row, slopes, strict=True))))
    value = 1.0 + sum(b * k for b, k in zip(table.weights, slopes, strict=True))
    return value, sum(e * k for e, k in zip(table.error, [*slopes, z * value], strict=True))


@pytest.mark.parametrize("stages", METHODS.values(), ids=METHODS)
@pytest.mark.parametrize("eigenvalue", [-3.0 + 0.0j, -20.0 + 400.0j, -5e3 + 5e3j, 1e3j])
def test_longest_stable_step_is_where_a_step_begins_to_grow(stages, eigenvalue):
    (step,) = stable_steps(np.array([eigenvalue]), stages)
    shorter = [abs(one_step(stages, share * step * eigenvalue)[0]) for share in np.linspace(0.01, 0.97, 97)]
    assert max(shorter) <= 1.001
    assert abs(one_step(stages, 1.03 * step * eigenvalue)[0]) > 1.001


def test_motions_that_stand_or_grow_limit_no_step():
    assert np.isinf(stable_steps(np.array([0.0, 3.0 + 100.0j]), METHODS["rk45"])).all()


@pytest.mark.parametrize("stages", METHODS.values(), ids=METHODS)
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9])
def test_resolved_angle_is_where_the_error_estimate_passes(stages, rtol):
    angle = resolved_angle(rtol, stages)
    assert abs(one_step(stages, 1j * angle)[1]) == pytest.approx(rtol, rel=0.1)


def test_limits_do_not_depend_on_the_sense_of_the_gyroscopics():
    """Nor on what other models are asked for at the same time."""
    model = run_of(Scene.from_dict(SCENES["gyroscopic disk"])).packed.model
    mirrored = model._replace(gyroscopic_columns=-model.gyroscopic_columns)
    plain = model._replace(gyroscopic_columns=())
    steps, eigenvalues = fastest([model, plain, mirrored], METHODS["rk45"])
    np.testing.assert_allclose(steps[0], steps[2], rtol=1e-9)
    assert steps[0, 0] < 0.999 * steps[1, 0]
    for i, alone in enumerate((model, plain, mirrored)):
        np.testing.assert_array_equal(fastest([alone], METHODS["rk45"]), (steps[i : i + 1], eigenvalues[i : i + 1]))


def ended(**tables):
    """Summary of a run, and the steps it had made when stiffness was found (None: never)."""
    run = run_of(Scene.from_dict(changed(start=WHIRL, **tables)))
    *_, (_, status) = run.chunks()
    return run.summary(status)


STIFF = {
    "k_C": ({"contact": {"stiffness": 3.5e10}}, "k_C"),
    "b_C": ({"contact": {"damping_ratio": None, "damping": 1e5}}, "b_C"),
    "light stator": ({"stator": {"model": "laval", "mass": 1e-5, "frequency": 2.4e4, "damping_ratio": 0.1}}, "k_C"),
    "mode": ({"stator": {"model": "chain", "masses": [0.25, 0.25], "stiffnesses": [2.2e5, 4e10, 0.0],
                         "dampings": [20.0, 1000.0, 0.0]}, "contact": {"stator_coordinate": 0}}, "mode 2 of the stator"),
}  # fmt: skip


@pytest.mark.parametrize(("name", "method"), alternating(STIFF, METHODS))
def test_cause_of_stiffness_is_named_and_the_run_finishes(name, method):
    tables, cause = STIFF[name]
    summary = ended(**tables, solver={"method": method, "rtol": 1e-6})
    assert summary.status == "finished"
    assert cause in summary.advice and "limits the step" in summary.advice
    assert "costs running time, not accuracy" in summary.advice
    assert ("taylor8" in summary.advice) == (method == "rk45" and name != "b_C")  # not offered where its steps are no longer
    assert ("reduced model" in summary.advice) == cause.startswith("mode")


@pytest.mark.parametrize("name", STIFF)
def test_a_run_that_cannot_reach_its_end_stops_within_a_thousand_steps_of_being_stiff(name):
    """It is stiff from its beginning on."""
    tables, cause = STIFF[name]
    summary = ended(**tables, drive={"duration": 1000.0}, solver={"max_steps": 1_000_000})
    assert summary.status == "stiff" and summary.steps <= 1000
    assert 0.0 < summary.end_time < 1.0
    assert cause in summary.advice and "max_steps" in summary.advice


def test_steps_that_a_tight_tolerance_asks_for_are_not_called_stiff():
    """The contact is far faster than the whirl, but it is error control that holds the steps, well below the limit."""
    summary = ended(contact={"stiffness": 3.5e8}, solver={"method": "rk45", "rtol": 1e-7})
    assert summary.steps > 10_000 and summary.advice == ""


def test_a_loss_of_less_than_ten_times_is_no_stiffness():
    """The series takes steps at its limit of stability here, but the motion allows only some six times longer ones."""
    scene = load_scene(REFERENCE / "mdof_2x2.toml").with_values({"solver.method": "taylor8", "drive.duration": 3.0})
    run = run_of(scene)
    *_, (_, status) = run.chunks()
    mean_step = 3.0 / run.work.count[kernel.STEPS]
    assert mean_step > 0.7 * run.packed.model.stable_closing
    assert run.summary(status).advice == ""


def test_stiffness_found_before_a_checkpoint_is_known_after_it():
    run = run_of(Scene.from_dict(changed(start=WHIRL, solver={"rtol": 1e-6}, **STIFF["k_C"][0])))
    blocks = run.chunks()
    while not run.work.count[-1]:
        next(blocks)
    again = Run.resumed(run.scene, run.checkpoint())
    *_, (_, status) = again.chunks()
    assert "k_C" in again.summary(status).advice
    assert LAVAL["contact"]["stiffness"] != again.packed.model.contacts[0].surfaces.spring.k
