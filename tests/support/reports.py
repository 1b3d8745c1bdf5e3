"""Reports of short runs for tests of tables, pictures and pages."""

from functools import cache

import rsc
from scenes import changed

PUMP = {
    "title": "short & small",
    "rotor": {"model": "laval", "mass": 1.0, "frequency": 30.0, "damping_ratio": 0.02, "eccentricity": 5e-5},
    "stator": {"model": "laval", "mass": 0.25, "frequency": 150.0, "damping_ratio": 0.1},
    "contact": {"gap": 1e-3, "friction": 0.2, "stiffness": 3.55e6, "damping_ratio": 0.05},
    "drive": {"speed": [30.0, 60.0], "duration": 4.0},
    "start": {"whirl": "backward"},
}


def report_of_dict(scene, **tables):
    """The Report of a scene dict with keys of its tables replaced."""
    return rsc.check(rsc.Scene.from_dict(changed(scene, **tables)))


@cache
def short_report():
    """The Report of `PUMP`, made once."""
    return report_of_dict(PUMP)
