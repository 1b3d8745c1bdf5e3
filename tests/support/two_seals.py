"""A pump with two seals, whose stable whirl presses both."""

import copy

import rsc

PUMP = {
    "rotor": {"model": "chain", "masses": [4.0, 30.0, 8.0], "stiffnesses": [6e6, 5e6, 5e6, 6e6], "damping_ratio": 0.02,
              "eccentricity": [1e-5, 2.5e-5, 1.5e-5]},
    "stator": {"model": "chain", "masses": [15.0, 10.0], "stiffnesses": [1.5e7, 5e6, 1e7], "damping_ratio": 0.1},
    "contact": [
        {"name": "seal", "rotor_coordinate": 1, "stator_coordinate": 0, "gap": 3e-4, "friction": 0.2, "stiffness": 1e7,
         "damping_ratio": 0.05, "diameter": 0.18},
        {"name": "bush", "rotor_coordinate": 2, "stator_coordinate": 1, "gap": 1.5e-4, "friction": 0.2, "stiffness": 1e7,
         "damping_ratio": 0.05, "diameter": 0.09},
    ],
    "drive": {"speed": 50.0, "duration": 2.0},
}  # fmt: skip


def pump(seal=None, bush=None, **values):
    """The pump with two seals, its contacts and values changed."""
    content = copy.deepcopy(PUMP)
    for own, more in zip(content["contact"], (seal, bush), strict=True):
        own |= more or {}
    return rsc.Scene.from_dict(content).with_values(values)
