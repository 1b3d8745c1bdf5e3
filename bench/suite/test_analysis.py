"""Spectra, whirl roots and branches: what an analysis of a run costs; no assertion on times."""

from pathlib import Path

import numpy as np
import pytest
from test_kernel import SIZES, chain

import rsc
from rsc.analysis.algebra.eigenvalues import eigenvalues
from rsc.analysis.follow.branches import branches
from rsc.analysis.paper.roots import whirl_roots
from rsc.measure import spectra
from rsc.system.assemble import assemble

DATA = Path(__file__).resolve().parents[2] / "data" / "reference"


@pytest.mark.parametrize("seconds", [30, 300])
def test_waterfall(benchmark, seconds):
    """Waterfall of a run-up sampled at 2 kHz: two-sided FFT of every window."""
    time = np.arange(2000 * seconds) / 2000.0
    speed = 20.0 + 80.0 * time / seconds
    motion = np.exp(-2j * np.pi * 60.0 * time) + 0.1 * np.exp(2j * np.pi * (20.0 * time + 40.0 * time**2 / seconds))
    fall = benchmark(lambda: spectra.waterfall(time, motion, speed, window=1.0))
    assert abs(spectra.spectral_peaks(fall, side="negative", count=1).frequency[0, 0] + 60.0) < 0.1


@pytest.mark.parametrize(("n_rotor", "n_stator"), SIZES)
def test_whirl_roots(benchmark, n_rotor, n_stator):
    """All whirl roots at one speed by the pencil."""
    system = assemble(chain(n_rotor, n_stator))
    roots = benchmark(lambda: whirl_roots(system, 2.0 * np.pi * 40.0))
    assert len(roots) > 0


@pytest.mark.parametrize("solver", [eigenvalues, np.linalg.eigvals])
@pytest.mark.parametrize("n", [40, 76, 166, 250, 500])
def test_eigenvalues(benchmark, n, solver):
    """A chain of n/2 masses in mixed coordinates, by our own iteration and by NumPy; set OPENBLAS_NUM_THREADS=1."""
    rng, half = np.random.default_rng(0), n // 2
    stiffness = 2.0 * np.eye(half) - np.eye(half, k=1) - np.eye(half, k=-1)
    mixed = np.linalg.qr(rng.normal(size=(n, n)))[0]
    state = np.block([[np.zeros((half, half)), np.eye(half)], [-stiffness, -0.01 * stiffness]])
    assert len(benchmark(lambda: solver(mixed.T @ state @ mixed))) == n


@pytest.mark.parametrize(("n_rotor", "n_stator"), SIZES)
def test_predict(benchmark, n_rotor, n_stator):
    """Whirls with forces, shapes and stability at one speed."""
    scene = chain(n_rotor, n_stator)
    assert isinstance(benchmark(lambda: rsc.predict(scene, speed=40.0)), list)


@pytest.mark.parametrize("name", ["mdof_2x2", "gyroscopic_transition"])
def test_branches(benchmark, name):
    """Branches with their events over 200 speeds; the second scene is gyroscopic and loses stability on the way."""
    system = assemble(rsc.load_scene(DATA / f"{name}.toml"))
    found = benchmark(lambda: branches(system, np.linspace(20.0, 100.0, 200)))
    assert any(branch.stable.any() for branch in found)
