"""rsc: rotor-stator contact, simulated and predicted."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rsc.analysis.alone.critical_map import CriticalMap, critical_map
    from rsc.analysis.alone.limits import limits
    from rsc.analysis.alone.modes import Campbell, Mode, Modes, modes
    from rsc.analysis.follow.force_ratio import ForceRatio, force_ratios
    from rsc.analysis.follow.one_whirl import crossing, delay, fold
    from rsc.analysis.paper.predict import Whirl, Whirls
    from rsc.analysis.paper.predict_many import WhirlArrays, predict_many
    from rsc.analysis.several.predict import predict
    from rsc.analysis.several.whirl import AtContact, SeveralWhirl, SeveralWhirls
    from rsc.errors import DataError, RscError, SceneError, SolverError
    from rsc.measure.features import envelope, spectral_peaks, waterfall
    from rsc.measure.tracks import track_lines
    from rsc.measured.measured import Measured, read_measured
    from rsc.measured.virtual import write_measured
    from rsc.results.trajectory import Trajectory, load
    from rsc.scene.scene import Scene, load_scene
    from rsc.show.sweeps.plot import plot_sweep
    from rsc.study.equations.benchmark import Benchmark, benchmark
    from rsc.study.equations.equations import Equations, equations
    from rsc.study.explore.server import Explorer, explore
    from rsc.study.fit.fit import Fit, fit
    from rsc.study.motions.motions import motions
    from rsc.study.motions.remedy import remedy
    from rsc.study.motions.smallest_impulse import smallest_impulse
    from rsc.study.prediction.sensitivity import sensitivity
    from rsc.study.report.check import check
    from rsc.study.report.compare import compare
    from rsc.study.report.transitions import transitions
    from rsc.study.run.ensemble import simulate_many
    from rsc.study.run.simulate import simulate
    from rsc.study.sweep.sweep import sweep
    from rsc.study.sweep.vary import cases

__all__ = [
    "AtContact",
    "Benchmark",
    "Campbell",
    "CriticalMap",
    "DataError",
    "Equations",
    "Explorer",
    "Fit",
    "ForceRatio",
    "Measured",
    "Mode",
    "Modes",
    "RscError",
    "Scene",
    "SceneError",
    "SeveralWhirl",
    "SeveralWhirls",
    "SolverError",
    "Trajectory",
    "Whirl",
    "WhirlArrays",
    "Whirls",
    "benchmark",
    "cases",
    "check",
    "compare",
    "critical_map",
    "crossing",
    "delay",
    "envelope",
    "equations",
    "explore",
    "fit",
    "fold",
    "force_ratios",
    "limits",
    "load",
    "load_scene",
    "modes",
    "motions",
    "plot_sweep",
    "predict",
    "predict_many",
    "read_measured",
    "remedy",
    "sensitivity",
    "simulate",
    "simulate_many",
    "smallest_impulse",
    "spectral_peaks",
    "sweep",
    "track_lines",
    "transitions",
    "waterfall",
    "write_measured",
]

# the same as the imports above, which only type checkers read: a name is loaded when it is first used, since Numba and SciPy
# take longer to load than many a program that imports rsc needs
_HOMES = {
    "rsc.analysis.alone.critical_map": ("CriticalMap", "critical_map"),
    "rsc.analysis.alone.limits": ("limits",),
    "rsc.analysis.alone.modes": ("Campbell", "Mode", "Modes", "modes"),
    "rsc.analysis.follow.force_ratio": ("ForceRatio", "force_ratios"),
    "rsc.analysis.follow.one_whirl": ("crossing", "delay", "fold"),
    "rsc.analysis.paper.predict": ("Whirl", "Whirls"),
    "rsc.analysis.paper.predict_many": ("WhirlArrays", "predict_many"),
    "rsc.analysis.several.predict": ("predict",),
    "rsc.analysis.several.whirl": ("AtContact", "SeveralWhirl", "SeveralWhirls"),
    "rsc.errors": ("DataError", "RscError", "SceneError", "SolverError"),
    "rsc.measure.features": ("envelope", "spectral_peaks", "waterfall"),
    "rsc.measure.tracks": ("track_lines",),
    "rsc.measured.measured": ("Measured", "read_measured"),
    "rsc.measured.virtual": ("write_measured",),
    "rsc.results.trajectory": ("Trajectory", "load"),
    "rsc.scene.scene": ("Scene", "load_scene"),
    "rsc.show.sweeps.plot": ("plot_sweep",),
    "rsc.study.report.check": ("check",),
    "rsc.study.report.compare": ("compare",),
    "rsc.study.run.ensemble": ("simulate_many",),
    "rsc.study.equations.benchmark": ("Benchmark", "benchmark"),
    "rsc.study.equations.equations": ("Equations", "equations"),
    "rsc.study.explore.server": ("Explorer", "explore"),
    "rsc.study.fit.fit": ("Fit", "fit"),
    "rsc.study.motions.smallest_impulse": ("smallest_impulse",),
    "rsc.study.motions.motions": ("motions",),
    "rsc.study.motions.remedy": ("remedy",),
    "rsc.study.prediction.sensitivity": ("sensitivity",),
    "rsc.study.run.simulate": ("simulate",),
    "rsc.study.sweep.sweep": ("sweep",),
    "rsc.study.sweep.vary": ("cases",),
    "rsc.study.report.transitions": ("transitions",),
}


if not TYPE_CHECKING:  # else any name would do for a type checker

    def __getattr__(name):
        if name == "machine":  # a module among the public names
            return import_module("rsc.machine")
        home = next((home for home, names in _HOMES.items() if name in names), None)
        if home is None:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = globals()[name] = getattr(import_module(home), name)
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "machine"})
