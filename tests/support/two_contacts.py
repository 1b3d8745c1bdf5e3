"""Runs of a machine with two contacts."""

import copy

from rsc.scene.scene import Scene
from scenes import TWO, changed


def two(seal=None, ring=None, **tables):
    """The scene with two contacts, its tables and contacts changed."""
    content = copy.deepcopy(TWO)
    for own, values in zip(content["contact"], (seal, ring), strict=True):
        own |= values or {}
    return Scene.from_dict(changed(content, **tables))


def pushed(**drive):
    """Both contacts press from the first turn on: a run at constant speed from a state with a blow."""
    velocity = [[0.05, -0.08], [0.0, -0.1], [0.06, -0.1]]
    start = {"rotor": [[0.9e-4, 0.2e-4], [0.0, 0.5e-4], [1.3e-4, 0.2e-4]], "rotor_velocity": velocity}
    return {"start": start, "drive": {"speed": [70.0, 90.0], "duration": 0.15} | drive}
