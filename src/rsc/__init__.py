"""rsc: rotor-stator contact, simulated and predicted."""

from rsc.analysis.predict import Whirl, predict
from rsc.errors import DataError, RscError, SceneError, SolverError
from rsc.measure.features import envelope, spectral_peaks, waterfall
from rsc.results.trajectory import Trajectory, load
from rsc.scene.scene import Scene, load_scene
from rsc.study.check import check
from rsc.study.ensemble import simulate_many
from rsc.study.simulate import simulate

__all__ = [
    "DataError",
    "RscError",
    "Scene",
    "SceneError",
    "SolverError",
    "Trajectory",
    "Whirl",
    "check",
    "envelope",
    "load",
    "load_scene",
    "predict",
    "simulate",
    "simulate_many",
    "spectral_peaks",
    "waterfall",
]
