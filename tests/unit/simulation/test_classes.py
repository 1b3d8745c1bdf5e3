"""Scenes of reduced bodies: their coordinates are filled up to a class, which changes nothing but what must be compiled."""

import numpy as np
import pytest
from numba import typeof

import rsc
from rsc.results.summary import Status
from rsc.simulation.lines import filled, size_of_class
from rsc.simulation.pack import pack
from rsc.simulation.run import Run
from rsc.simulation.shot import packed_for_shots
from rsc.study.run.start import initial_state, run_of
from rsc.system.assemble import assemble
from sliding import error_of_sliding
from tiers import nightly

N = 6  # coordinates of the rotor below; with the stator's one there are 7, which are filled up to 8


def matrix(rng, n, size):
    part = rng.normal(size=(n, n))
    return size * (part @ part.T / n + np.eye(n))


def scene(n, directions=False):
    """A rotor of n coordinates with full matrices and a stator, in and out of contact."""
    rng = np.random.default_rng(n)
    sizes = {"stiffness": 1e6, "damping": 50.0, "gyroscopic": 0.02}
    rotor = {name: matrix(rng, n, size).tolist() for name, size in sizes.items()}
    rotor |= {"model": "reduced", "mass": 10.0, "origin": "a test", "coordinates_before": 30, "tolerance": 1e-4, "error": 0.0}
    rotor |= {"band": [-500.0, 500.0], "speeds": [0.0, 100.0], "highest_before": 1e3, "highest_after": 1e3}
    rotor |= {"unbalance": [[2e-3, 0.0]] + (n - 1) * [[0.0, 0.0]], "load": n * [[0.0, 0.0]]}
    if directions:
        for name, size in (("anisotropic_stiffness", 1e5), ("anisotropic_damping", 5.0)):
            rotor[name] = [[[x, 0.5 * x] for x in row] for row in matrix(rng, n, size).tolist()]
    return rsc.Scene.from_dict(
        {
            "rotor": rotor,
            "stator": {"model": "laval", "mass": 3.0, "frequency": 60.0, "damping_ratio": 0.05},
            "contact": {"gap": 1e-4, "friction": 0.1, "stiffness": 1e7, "damping_ratio": 0.05},
            "drive": {"speed": 45.0, "duration": 0.3},
            "start": {"rest": True},
        }
    )


def motion_of(run):
    """Rotor and stator of a run."""
    blocks = [block for block, _ in run.chunks()]
    return [np.concatenate([block[name] for block in blocks]) for name in ("rotor", "stator")]


@pytest.mark.parametrize(
    ("n", "size"), [(1, 1), (3, 3), (4, 4), (5, 6), (6, 6), (7, 8), (8, 8), (9, 12), (12, 12), (13, 16), (29, 32)]
)
def test_sizes_of_classes(n, size):
    assert size_of_class(n) == size


def test_numbers_of_one_class_share_what_is_compiled():
    assert {run_of(scene(n)).packed.width for n in (8, 9, 10, 11)} == {24 * (0.0,)}


@pytest.mark.parametrize("n", [2, 8])
def test_lists_of_motions_use_the_kernel_of_the_run(n):
    """Else `rsc check` of a machine would compile two."""
    run, shots = run_of(scene(n)).packed, packed_for_shots(assemble(scene(n)), scene(n), 0.1)
    assert (typeof(run.model), typeof(run.width), run.method) == (typeof(shots.model), typeof(shots.width), shots.method)


@pytest.mark.parametrize("directions", [nightly(False), True])
def test_coordinates_at_rest_change_no_motion(directions):
    case = scene(N, directions)
    run, system = run_of(case), assemble(case)
    plain = Run(case, system, pack(system, case.solver, case.output.rate), initial_state(case, system))
    assert (run.work.x.size, plain.work.x.size) == (16, 14)
    for ours, theirs in zip(motion_of(run), motion_of(plain), strict=True):
        assert ours.shape == theirs.shape
        assert np.abs(ours - theirs).max() < 1e-6 * np.abs(theirs).max()
    a, b = (each.summary(Status.FINISHED) for each in (run, plain))
    assert a.contact_releases > 2 and a.steps == b.steps
    assert a.ledger.stator_damping == pytest.approx(b.ledger.stator_damping, rel=1e-6)


def test_what_fills_a_class_stays_at_rest():
    run = run_of(scene(N, True))
    motion_of(run)
    assert run.work.x[:14].all() and not run.work.x[14:].any() and not run.work.v[14:].any()


def test_a_checkpoint_has_the_coordinates_of_the_scene_and_goes_on_with_the_same_bits(monkeypatch):
    monkeypatch.setattr("rsc.simulation.run.CHUNK_STEPS", 100)
    case = scene(N, True)
    run = run_of(case)
    chunks = run.chunks()
    next(chunks), next(chunks)
    checkpoint = run.checkpoint()
    assert run.time > 0.0 and all(checkpoint[name].size == 14 for name in ("x", "v", "ledger_damping", "ledger_input"))
    both = chunks, Run.resumed(case, checkpoint).chunks()
    rest, again = (np.concatenate([block["rotor"] for block, _ in each]) for each in both)
    assert len(rest) > 100 and np.array_equal(rest, again)


@pytest.mark.parametrize("directions", [nightly(False), True])
def test_velocities_of_a_class_are_those_of_the_scene(directions):
    result = rsc.simulate(scene(N, directions).with_values({"output.velocities": True}))
    assert result.rotor_velocity.shape == (len(result.time), N) and result.stator_velocity.shape == (len(result.time), 1)
    assert error_of_sliding(result) < 1e-12


def test_a_full_class_is_left_alone():
    model = run_of(scene(N - 1)).packed.model
    assert filled(model) is model and model.stiffness.size == 12
