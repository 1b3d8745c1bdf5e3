"""Many coordinates, with full matrices, in registers of every size: the motion against a slow twin, and exactness."""

import sys

import numpy as np
import pytest

from directions import assembled, directed
from naive import integrate
from rsc.kernel.tableau import METHODS
from rsc.scene.scene import Scene
from rsc.study.run.simulate import simulate
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from sliding import error_of_sliding
from tiers import nightly

N_ROTOR, N_STATOR = 20, 3  # 46 numbers: five registers of eight, one of four, one of two
run_module = sys.modules["rsc.simulation.run"]


def chain(n, frequency):
    """Stiffness matrix of a chain of n masses of 1 kg fixed at both ends, first frequency in Hz."""
    k = (2.0 * np.pi * frequency / (2.0 * np.sin(0.5 * np.pi / (n + 1)))) ** 2
    return k * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))


def tables(method, rtol=1e-6):
    """A rotor that is thrown at the stator, with an unbalance that follows a run-up, and matrices that no modes make diagonal."""
    rng = np.random.default_rng(3)
    mixed = rng.normal(size=(N_ROTOR, N_ROTOR))
    bump = np.sin(np.pi * np.arange(1, N_ROTOR + 1) / (N_ROTOR + 1))
    return {
        "rotor": {
            "model": "matrices", "mass": np.eye(N_ROTOR).tolist(), "stiffness": chain(N_ROTOR, 30.0).tolist(),
            "damping": (5.0 * np.eye(N_ROTOR) + 0.2 * mixed @ mixed.T).tolist(),
            "gyroscopic": np.diag(rng.uniform(0.0, 0.4, N_ROTOR)).tolist(), "eccentricity": (3e-4 * bump).tolist(),
            "tilt_coordinates": [],
        },
        "stator": {"model": "matrices", "mass": np.eye(N_STATOR).tolist(), "stiffness": chain(N_STATOR, 150.0).tolist(),
                   "damping": (20.0 * np.eye(N_STATOR)).tolist()},
        "contact": {"rotor_coordinate": N_ROTOR // 2, "stator_coordinate": 1, "gap": 1e-3, "friction": 0.2, "stiffness": 3e6,
                    "damping_ratio": 0.05, "diameter": 0.02, "slip_velocity": 0.05},
        "drive": {"speed": [25.0, 35.0], "duration": 0.05},
        "start": {"rotor": [[0.0, 0.0]] * N_ROTOR, "rotor_velocity": [[0.4 * b, -0.1 * b] for b in bump]},
        "solver": {"rtol": rtol, "method": method},
        "output": {"rate": 4000},
    }  # fmt: skip


def mirrored(scene):
    """z -> -z, the shaft turning the other way."""
    start = {name: [[y, -z] for y, z in rows] for name, rows in scene["start"].items()}
    return scene | {"start": start, "drive": scene["drive"] | {"speed": [-25.0, -35.0]}}


@pytest.fixture(scope="module")
def twin():
    scene = Scene.from_dict(tables("rk45"))
    system = assemble(scene)
    return integrate(system, initial_state(scene, system), np.arange(201) / 4000, rtol=1e-8)


@pytest.mark.parametrize("method", ["taylor8", nightly("rk45")])
def test_motion_equals_the_slow_twin(method, twin):
    result = simulate(Scene.from_dict(tables(method, 1e-9)))
    assert result.contact_onsets >= 2 and result.contact_releases >= 2
    assert abs(result.rotor - twin[0]).max() < 1e-5 * 1e-3
    assert abs(result.stator - twin[1]).max() < 1e-5 * 1e-3
    assert abs(result.ledger.residual) < 20 * 1e-9 * result.ledger.turnover


@pytest.mark.parametrize("method", ["taylor8", nightly("rk45")])
def test_runs_are_exact(method, monkeypatch):
    """No bit changes with the mirror, the output rate or the size of the chunks."""
    scene = tables(method)
    result, mirror = simulate(Scene.from_dict(scene)), simulate(Scene.from_dict(mirrored(scene)))
    assert result.summary.switches >= 8
    assert np.array_equal(mirror.rotor, result.rotor.conj())
    assert np.array_equal(mirror.normal_force, result.normal_force)
    sparse = simulate(Scene.from_dict(scene | {"output": {"rate": 500}}))
    assert np.array_equal(sparse.rotor, result.rotor[::8])
    monkeypatch.setattr(run_module, "CHUNK_STEPS", 7)
    chunked = simulate(Scene.from_dict(scene))
    assert np.array_equal(chunked.rotor, result.rotor)
    assert chunked.summary == result.summary


@pytest.mark.parametrize("method", ["taylor8", nightly("rk45")])
def test_velocities_slide_as_the_run_says(method):
    scene = tables(method)
    plain = simulate(Scene.from_dict(scene))
    result = simulate(Scene.from_dict(scene | {"output": {"rate": 4000, "velocities": True}}))
    assert error_of_sliding(result) < 1e-12
    assert np.array_equal(result.rotor, plain.rotor) and result.summary == plain.summary


@pytest.mark.nightly
def test_the_code_for_full_matrices_changes_no_bit():
    """Of a scene without such, beside a gyroscopic matrix too small to change a bit."""
    scene = tables("rk45")
    plain = {name: value for name, value in scene["rotor"].items() if name != "gyroscopic"}
    plain["damping"] = (5.0 * np.eye(N_ROTOR)).tolist()
    tiny = plain | {"gyroscopic": (1e-30 * np.eye(N_ROTOR)).tolist()}
    one, several = (simulate(Scene.from_dict(scene | {"rotor": rotor})) for rotor in (plain, tiny))
    assert one.contact_onsets >= 2
    assert np.array_equal(one.rotor, several.rotor) and np.array_equal(one.stator, several.stator)
    # the dampers' part is from the powers of the stages with full matrices, of diagonals from the step's ends: 0.12 rtol apart
    apart = 0.5e-6 * one.ledger.turnover
    for name, energy in vars(one.ledger).items():
        limits = {"abs": apart} if "damping" in name or name == "residual" else {"rel": 1e-12}
        assert energy == pytest.approx(getattr(several.ledger, name), **limits)
    assert one.ledger.rotor_damping != several.ledger.rotor_damping


@pytest.mark.nightly
@pytest.mark.parametrize("method", METHODS)
def test_motion_with_skew_and_anisotropic_matrices_equals_the_slow_twin(method, monkeypatch):
    system_of, scene = assembled(monkeypatch, directed), Scene.from_dict(tables(method, 1e-9))
    result = simulate(scene)
    rotor, stator = integrate(system_of(scene), initial_state(scene, system_of(scene)), result.time, rtol=1e-9)
    assert result.contact_onsets >= 2 and result.contact_releases >= 2
    assert abs(result.rotor - rotor).max() < 1e-5 * 1e-3
    assert abs(result.stator - stator).max() < 1e-5 * 1e-3
    assert abs(result.ledger.residual) < 20 * 1e-9 * result.ledger.turnover
