"""rsc: rotor-stator contact, simulated and predicted."""

from rsc.check import check
from rsc.ensemble import simulate_many
from rsc.errors import DataError, RscError, SceneError, SolverError
from rsc.features import envelope, spectral_peaks, waterfall
from rsc.predict import Whirl, predict
from rsc.scene import Scene, load_scene
from rsc.simulate import simulate
from rsc.trajectory import Trajectory, load

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
