"""The simulator against slow twins, closed forms and its own exactness; every scene is shown to reach the branch it is for."""

import sys

import numpy as np
import pytest

from naive import integrate
from rsc.kernel.model import H
from rsc.kernel.tableau import METHODS
from rsc.results.trajectory import MemoryBlocks
from rsc.scene.scene import Scene
from rsc.simulation.tolerances import first_step
from rsc.study.run.simulate import simulate
from rsc.study.run.start import initial_state, run_of
from rsc.system.assemble import assemble
from scenes import LAVAL, SCENES, changed
from tiers import alternating

run_module = sys.modules["rsc.simulation.run"]


def run(scene_dict, rtol=1e-6, method="rk45", **more):
    solver = {"rtol": rtol, "method": method, **scene_dict.get("solver", {})}
    scene_dict = {**scene_dict, "solver": solver}
    return simulate(Scene.from_dict(scene_dict), **more)


TWINS = SCENES | {"one-sided, backwards": changed(SCENES["chains"], drive={"speed": [-50.0, -60.0]})}


@pytest.mark.parametrize("name", TWINS)
def test_motion_equals_the_slow_twin(name):
    """An independent program (physics.md written in complex numpy, DOP853) on the same scene; its own error is near 1e-7 gaps."""
    scene = Scene.from_dict(TWINS[name])
    system = assemble(scene)
    times = np.arange(int(scene.drive.duration * scene.output.rate) + 1) / scene.output.rate
    rotor, stator = integrate(system, initial_state(scene, system), times, rtol=1e-8)
    for method in METHODS:
        result = run(TWINS[name], 1e-9, method)
        assert np.array_equal(result.time, times)
        assert result.normal_force.max() > 0.0  # the scene reaches contact
        assert not np.signbit(result.normal_force).any()
        assert abs(result.rotor - rotor).max() < 1e-5 * system.contact.gap
        assert abs(result.stator - stator).max(initial=0.0) < 1e-5 * system.contact.gap


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SCENES)
def test_scenes_that_are_not_stiff_are_not_called_so(name, method):
    """Here and not in test_stiffness because these are the compiled variants of the test above."""
    scene = {**SCENES[name], "solver": {"method": method, "rtol": 1e-7}}
    run = run_of(Scene.from_dict(scene))
    *_, (_, status) = run.chunks()
    assert run.summary(status).advice == ""


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SCENES)
def test_energy_ledger_closes(name, method):
    ledger = run(SCENES[name], 1e-8, method).ledger
    assert abs(ledger.residual) < 20 * 1e-8 * ledger.turnover
    assert ledger.rotor_damping > 0.0 and ledger.contact_damping >= 0.0


def test_error_falls_with_the_tolerance():
    """Error per tolerance stays within a factor over four decades on a whirl with 200 switches of the damper."""
    exact = run(LAVAL, 1e-12).rotor
    tolerances = np.array([1e-5, 1e-6, 1e-7, 1e-8, 1e-9])
    errors = [abs(run(LAVAL, rtol).rotor - exact).max() / 1e-3 for rtol in tolerances]
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert slope == pytest.approx(1.0, abs=0.15)
    assert max(errors / tolerances) < 50


def turned(scene_dict, quarter):
    """The same scene with every vector turned by 90 degrees * quarter."""
    turn = 1j**quarter

    def pairs(rows):
        z = [complex(*row) * turn for row in rows]
        return [[v.real, v.imag] for v in z]

    start = {k: pairs(v) if isinstance(v, list) else v for k, v in scene_dict["start"].items()}
    amount = scene_dict["rotor"]["eccentricity"]
    return changed(scene_dict, start=start, rotor={"eccentricity": [amount, 90.0 * quarter]})


@pytest.mark.parametrize("name", ["whirl, unbalance, run-up", "bouncing", "rigid wall", "no contact damper"])
@pytest.mark.parametrize("quarter", [1, 2])
@pytest.mark.parametrize("method", METHODS)
def test_a_turn_of_the_frame_changes_no_bit(name, quarter, method):
    result, again = run(SCENES[name], method=method), run(turned(SCENES[name], quarter), method=method)
    assert result.contact_onsets + result.summary.switches > 10
    assert np.array_equal(again.rotor, result.rotor * 1j**quarter)
    assert np.array_equal(again.normal_force, result.normal_force)


@pytest.mark.parametrize(
    ("name", "method"), alternating(["bouncing", "gyroscopic disk", "Coulomb friction that reverses"], METHODS)
)
def test_saving_changes_no_step(name, method, monkeypatch, tmp_path):
    """The same bits for any output rate, chunk size, and whether the samples go to memory or to a file."""
    scene = {**SCENES[name], "solver": {"method": method}}
    result = run({**scene, "output": {"rate": 4000}})
    sparse = run({**scene, "output": {"rate": 500}})
    assert np.array_equal(sparse.rotor, result.rotor[::8])
    monkeypatch.setattr(run_module, "CHUNK_STEPS", 7)
    monkeypatch.setattr(run_module, "BUFFER_ROWS", 11)
    chunked = run({**scene, "output": {"rate": 4000}}, path=tmp_path / "run.h5")
    assert np.array_equal(chunked.rotor, result.rotor)
    assert np.array_equal(chunked.normal_force, result.normal_force)
    assert chunked.summary == result.summary


def test_corners_of_the_schedule_are_step_ends():
    """A pulse of the speed of 1 ms in a 20 s rest is felt: the unbalance sets the rotor in motion there and nowhere else."""
    scene = changed(
        start={"rest": True},
        drive={"speed": None, "duration": None, "schedule": [[0, 0], [12, 0], [12.0005, 100], [12.001, 0], [20, 0]]},
    )
    result = run(scene, 1e-9)
    before = result.time < 12.0
    assert np.all(result.rotor[before] == 0.0)
    rotor, _ = integrate(assemble(result.scene), initial_state(result.scene, assemble(result.scene)),
                         result.time[(result.time >= 11.99) & (result.time < 12.2)], rtol=1e-10)  # fmt: skip
    got = result.rotor[(result.time >= 11.99) & (result.time < 12.2)]
    assert abs(got).max() > 1e-9
    assert abs(got - rotor).max() < 1e-6 * abs(rotor).max()
    # a step that began with the speed or the accelerations of before a corner would be repeated until its error is lost
    assert result.summary.rejected < 10


def test_friction_that_feeds_the_motion_stops_as_diverged():
    """One-sided friction against a rigid wall pumps without bound; the run ends early and names the condition."""
    result = run(changed(SCENES["rigid wall"], contact={"friction": 0.5}, drive={"duration": 1000.0}))
    assert result.status == "diverged"
    assert result.summary.end_time < 100.0
    assert "sliding" in result.summary.advice
    assert np.isfinite(result.rotor).all()


def test_budget_of_steps_is_kept():
    result = run({**LAVAL, "solver": {"max_steps": 100}})
    assert result.status == "too many steps" and result.steps == 100
    assert "max_steps" in result.summary.advice


@pytest.mark.parametrize("field", ["stiffness", "unbalance", "force_row", "load", "damping"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_non_finite_number_ends_the_run_with_the_last_good_state(field, value):
    """NaN or infinity in any term of the accelerations: every stage of every step sees it."""
    begun = run_of(Scene.from_dict(SCENES["bouncing"]))
    work = begun.work
    before = work.x.copy()
    where = begun.packed.model.contacts[0] if field == "force_row" else begun.packed.model
    getattr(where, field)[0] = value
    work.real[H] = first_step(begun.packed)  # NaN or zero for some of the fields: the run must end all the same
    sink = MemoryBlocks()
    ends = []
    for block, status in begun.chunks():
        sink.append(block)
        ends.append(status)
    summary = begun.summary(ends[-1])
    assert summary.status in ("non-finite", "step collapsed")
    assert summary.rhs_calls < 10_000
    assert np.isfinite(work.x).all() and np.isfinite(sink.series("rotor")).all()
    if field != "force_row":  # that one is met at the first contact only
        assert np.array_equal(work.x, before)


def test_one_compiled_signature_serves_every_scene_of_a_size_method_and_kind_of_matrices_and_ring():
    from rsc.kernel.march import march

    for name in SCENES:
        run(SCENES[name])
    kinds = []
    options = ("damping_columns", "gyroscopic_columns", "stiffness_columns", "rotating_columns", "following_stiffness",
               "following_damping", "contacts", "drive", "watched_rows", "flight", "states")  # fmt: skip
    for model, _, _, _, width, method, _ in march.signatures:
        parts = [str(model.types[model.fields.index(name)]) for name in options]
        kinds.append((*parts, str(width), str(method)))
    assert len(kinds) == len(set(kinds))


@pytest.mark.parametrize("stiffness", [3.5e8, 3.5e10])
def test_a_loose_tolerance_does_not_make_a_stiff_contact_chatter(stiffness):
    """The whirl keeps contact; a tolerance of the displacements above the penetration would let go of it thousands of times."""
    scene = changed(start={"whirl": "backward"}, contact={"stiffness": stiffness}, drive={"duration": 0.1})
    result = run(scene, 1e-2)
    exact = run(scene, 1e-8)
    assert result.contact_onsets == exact.contact_onsets == 0
    assert np.median(result.normal_force) == pytest.approx(np.median(exact.normal_force), rel=0.05)


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-7])
def test_sticking_is_resolved_whatever_the_tolerance(rtol):
    """Rolling and sticking within a range of slip far below what the tolerance would let the velocities err."""
    contact = {"diameter": 5e-3, "slip_velocity": 1e-5}
    scene = changed(start={"whirl": "backward"}, contact=contact, drive={"speed": 20.0, "duration": 0.03})
    result, exact = run(scene, rtol), run(scene, 1e-10, "taylor8")
    assert abs(result.tangential_velocity + 2 * np.pi * 20.0 * 2.5e-3).min() < 1e-5  # it sticks
    assert result.summary.rtol == pytest.approx(0.01 * 1e-5 / (1e-3 * 2 * np.pi * 150.0)) or result.summary.rtol == rtol
    assert result.summary.rtol <= rtol
    assert abs(result.rotor - exact.rotor).max() < 1e-3 * rtol
    assert (abs(result.friction_force) <= 0.2 * result.normal_force * (1.0 + 1e-6)).all()


@pytest.mark.parametrize("rtol", [1e-3, 1e-9])
def test_automatic_method_is_the_fastest_one_measured(rtol):
    automatic, named = run(LAVAL, rtol, "auto"), run(LAVAL, rtol, "taylor8")
    assert np.array_equal(automatic.rotor, named.rotor) and automatic.rhs_calls == named.rhs_calls
