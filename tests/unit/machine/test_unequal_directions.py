"""Machines whose directions differ: the reduced rotor vibrates as the full one, which the mean of the directions does not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from threadpoolctl import threadpool_limits

from rsc.analysis.free_vibration import free_vibrations
from rsc.machine.contact import along_directions, body_of
from rsc.machine.ross import read_ross
from rsc.machine.store import save_model
from rsc.scene.scene import Scene
from rsc.system.assemble import assemble

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists())
FOLDER = ROOT / "data" / "reference" / "machines"


@pytest.fixture(autouse=True)
def one_thread():
    """Threads of the linear algebra cost more than they give here."""
    with threadpool_limits(1):
        yield


def scene_of(folder, model, node, speed, band, tolerance):
    """A scene of a model; stator and contact do not matter here."""
    save_model(model, folder / "model.npz")
    return Scene.from_dict(
        {
            "rotor": {"model": "machine", "file": str(folder / "model.npz"), "contact": node, "unbalance": [[node, 1e-4]]},
            "reduction": {"tolerance": tolerance, "band": band},
            "stator": {"model": "rigid"},
            "contact": {"gap": 1e-4, "friction": 0.1, "stiffness": 1e7},
            "drive": {"speed": [0.0, speed], "duration": 1.0},
        }
    )


def full_eigenvalues(model, speed, low, high):
    """Eigenvalues of all coordinates with damped frequencies from low to high, Hz, of weak damping; by frequency."""
    mass, damping, stiffness = model.with_conjugate(speed)
    n = len(mass)
    lower = -scipy.linalg.solve(mass, np.hstack([stiffness, damping]))
    values = scipy.linalg.eigvals(np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower]))
    chosen = (values.imag > 2.0 * np.pi * low) & (values.imag < 2.0 * np.pi * high) & (values.real > -0.5 * values.imag)
    return values[chosen][np.argsort(values[chosen].imag)]


def reduced_eigenvalues(scene, speed, low, high):
    """The same of the reduced rotor, frequencies without their sense."""
    found = [v for v in free_vibrations(assemble(scene), speed) if low < abs(v.frequency) < high]
    values = np.array([v.growth_rate + 2j * np.pi * abs(v.frequency) for v in found])
    return values[np.argsort(values.imag)]


@pytest.mark.parametrize(
    ("skew", "backward", "forward"), [(True, 1.77, 0.73), (False, 1.21, 1.28)], ids=["as it is", "without cross-coupling"]
)
def test_decrements_of_the_compressor(tmp_path, skew, backward, forward):
    """Logarithmic decrements of the first bending mode of ROSS's compressor at 9,000 rpm, full and reduced."""
    model = read_ross(FOLDER / "ross_compressor.mat", 150.0)
    if not skew:  # k_xy and k_yx of all bearings and seals are zero
        symmetric = {name: getattr(model, name).real + 0j for name in ("anisotropic_stiffness", "anisotropic_damping")}
        model = replace(model, skew_stiffness=None, skew_damping=None, **symmetric)
    scene = scene_of(tmp_path, model, 27, 150.0, ["-500 Hz", "250 Hz"], 1e-3)
    assert scene.rotor.n_coordinates <= 12
    for values in (full_eigenvalues(model, 150.0, 100.0, 220.0), reduced_eigenvalues(scene, 150.0, 100.0, 220.0)):
        decrements = -2.0 * np.pi * values.real / values.imag
        assert decrements == pytest.approx([backward, forward], abs=0.01)  # the backward one has the lower frequency
    senses = [v.frequency > 0.0 for v in free_vibrations(assemble(scene), 150.0) if 100.0 < abs(v.frequency) < 220.0]
    assert senses == [False, True]


def test_a_bearing_stiff_in_one_direction_only(tmp_path):
    """ROSS's rub rotor: one of its bearings is 115 times as stiff in y as in x, and no mean of both moves like it."""
    model = read_ross(FOLDER / "ross_rub_rotor.mat", 20.0)
    scene = scene_of(tmp_path, model, 12, 20.0, ["-500 Hz", "250 Hz"], 1e-3)
    full = full_eigenvalues(model, 20.0, 20.0, 150.0)
    assert len(full) == 4 and scene.rotor.n_coordinates <= 12
    assert reduced_eigenvalues(scene, 20.0, 20.0, 150.0) == pytest.approx(full, rel=1e-4)


def test_directions_that_are_reduced_for():
    """x, y and the diagonals of oblique axes; nothing where all directions are alike."""
    model = read_ross(FOLDER / "ross_rub_rotor.mat", 20.0)
    body = body_of(model, 12)
    stiff = [part.stiffness[2 * 31, 2 * 31] - part.stiffness[2 * 30, 2 * 30] for part in along_directions(model, body)]
    assert len(stiff) == 2 and stiff[1] - stiff[0] == pytest.approx(9.5e5 - 1.09e8)
    oblique = replace(model, anisotropic_stiffness=model.anisotropic_stiffness * np.exp(0.3j))
    assert len(along_directions(oblique, body_of(oblique, 12))) == 4
    assert along_directions(replace(model, anisotropic_stiffness=None, anisotropic_damping=None), body) == []
