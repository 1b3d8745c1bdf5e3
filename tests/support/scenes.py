"""Small scenes that between them reach every branch of the equations of motion; each is a dict for Scene.from_dict."""

import copy

LAVAL = {
    "title": "Laval rotor in a light stator",
    "rotor": {"model": "laval", "mass": 1.0, "frequency": 30.0, "damping_ratio": 0.02, "eccentricity": 5e-5},
    "stator": {"model": "laval", "mass": 0.25, "frequency": 150.0, "damping_ratio": 0.1},
    "contact": {"gap": 1e-3, "friction": 0.2, "stiffness": 3.553e6, "damping_ratio": 0.05},
    "drive": {"speed": [50.0, 60.0], "duration": 0.4},
    "start": {"rotor": [[2.55e-3, 0.0]], "rotor_velocity": [[0.0, -0.972]],
              "stator": [[1.5e-3, 0.0]], "stator_velocity": [[0.0, -0.57]], "allow_penetration": True},
}  # fmt: skip


def changed(scene=LAVAL, **tables):
    """A deep copy of a scene dict with keys of its tables replaced (None removes a key, a dict with `model` the table)."""
    new = copy.deepcopy(scene)
    for name, keys in tables.items():
        if name in ("title", "clearance") or "model" in keys or name == "start":
            new[name] = keys
            continue
        new.setdefault(name, {})
        for key, value in keys.items():
            if value is None:
                new[name].pop(key, None)
            else:
                new[name][key] = value
    return new


_OFFSET = {"rotor": [[0.6e-3, 0.2e-3]], "rotor_velocity": [[0.3, 0.2]]}
_DISK = {
    "model": "disk", "mass": 1.0, "diametral_inertia": 0.01, "polar_inertia": 0.016,
    "stiffness": [[69408.0, -3160.6], [-3160.6, 1308.89]], "damping": [[2.6, 0.0], [0.0, 0.036]],
    "eccentricity": [5e-5, 30.0], "angular_eccentricity": [1e-3, 200.0],
}  # fmt: skip
_CHAIN = {"model": "chain", "masses": [1.0, 2.0, 1.5], "stiffnesses": [3e4, 2e4, 4e4, 1e4], "damping_ratio": 0.02,
          "eccentricity": [5e-5, 1e-5, 2e-5]}  # fmt: skip
_CHAIN_STATOR = {"model": "chain", "masses": [0.5, 0.4], "stiffnesses": [6e5, 4e5, 0.0], "dampings": [30.0, 10.0, 0.0]}

SCENES = {
    "whirl, unbalance, run-up": LAVAL,
    "bouncing": changed(start=_OFFSET, rotor={"eccentricity": 6e-4}),
    "rigid wall": changed(stator={"model": "rigid"}, start=_OFFSET, contact={"friction": 0.05}),
    "Coulomb friction that reverses": changed(
        start={**_OFFSET, "rotor_velocity": [[0.3, -0.3]]}, drive={"speed": 4.0},
        contact={"diameter": 0.02, "slip_velocity": 0.05, "friction": 0.3},
    ),
    "eccentric ring": changed(start=_OFFSET, contact={"ring_eccentricity": [2e-4, 70.0]}),
    "no contact damper": changed(start=_OFFSET, contact={"damping_ratio": None, "damping": 0.0}),
    "gravity, run-down": changed(
        rotor={"gravity": 9.81, "eccentricity": 4e-4}, start={"rest": True}, drive={"speed": [45.0, 30.0], "duration": 0.4}
    ),
    "gyroscopic disk": changed(
        rotor=_DISK,
        start={"rotor": [[0.6e-3, 0.0], [0.0, 2e-3]], "rotor_velocity": [[0.0, -0.4], [0.3, 0.0]]},
    ),
    "chains": changed(
        rotor=_CHAIN, stator=_CHAIN_STATOR, contact={"rotor_coordinate": 1, "stator_coordinate": 1},
        start={"rotor": [[1e-4, 0.0], [9e-4, 0.0], [0.0, 1e-4]],
               "rotor_velocity": [[0.0, -0.4], [0.3, -0.3], [0.0, 0.0]]},
    ),
}  # fmt: skip

# two contacts with different places, gaps and laws
TWO = {
    "title": "two contacts",
    "rotor": {"model": "chain", "masses": [3.0, 2.0, 1.5], "stiffnesses": [4e5, 5e5, 6e5, 3e5], "damping_ratio": 0.02,
              "eccentricity": 2e-5},
    "stator": {"model": "chain", "masses": [2.0, 3.0], "stiffnesses": [3e6, 1e6, 3e6], "damping_ratio": 0.05},
    "contact": [
        {"name": "seal", "gap": 1e-4, "stiffness": 1e8, "damping_ratio": 0.1, "friction": 0.1},
        {"name": "ring", "rotor_coordinate": 2, "stator_coordinate": 1, "gap": 1.5e-4, "stiffness": 5e7, "damping_ratio": 0.1,
         "friction": 0.15},
    ],
    "drive": {"speed": [10.0, 120.0], "duration": 2.0},
}  # fmt: skip
PUSHED = changed(TWO, drive={"speed": [70.0, 70.0], "duration": 0.1}, start={"rotor_velocity": [[0.3, 0.0]] * 3})

# what later formats of scenes and results hold: a drive with torque that trips, clearances, limits
DRIVEN = changed(
    contact={"diameter": 0.05, "slip_velocity": 0.02},
    drive={"speed": 50.0, "duration": 0.3, "inertia": 0.05, "torque": [[0.0, 2.0], [50.0, 1.0], [60.0, 0.0]], "trip": 0.15,
           "coast": [[0.0, -1.0], [80.0, -3.0]]},
    clearance=[{"name": "seal", "rotor_coordinate": 0, "gap": 1.2e-3}, {"name": "oil", "rotor_coordinate": 0, "gap": 2e-3}],
    limits={"maximum_continuous": 55.0, "minimum": 45.0, "trip": 60.0, "probe": "seal"},
)  # fmt: skip
