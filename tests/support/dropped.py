"""A rotor of two planes that a failure of its magnetic bearings drops into two auxiliary bearings."""

import numpy as np

from rsc.scene.scene import Scene

MASS, TRANSVERSE, POLAR, PLANES, GAP = 20.0, 0.80, 0.05, (-0.25, 0.22), 2.5e-4  # kg, kg m^2, m
RACE = {"race_inertia": 2e-4, "race_drag": 2e-5}


def dropped(friction=0.15, race=None, angle=0.0, gravity=9.81, eccentricity=2e-6, duration=0.1, **tables):
    """The free rotor at 200 Hz, which falls from the bearing centre with its heavy spot at an angle in degrees."""
    tilt = np.array([[1.0, PLANES[0]], [1.0, PLANES[1]]])  # deflections at the planes by displacement and tilt of the centre
    back = np.linalg.inv(tilt)
    contact = {"gap": GAP, "friction": friction, "stiffness": 1e8, "damping": 2e3, "diameter": 0.05, "slip_velocity": 0.02}
    contact |= race or {}
    rotor = {
        "model": "matrices", "mass": (back.T @ np.diag([MASS, TRANSVERSE]) @ back).tolist(),
        "gyroscopic": (back.T @ np.diag([0.0, POLAR]) @ back).tolist(),
        "stiffness": [[0.0, 0.0]] * 2, "damping": [[0.0, 0.0]] * 2,
        "gravity": gravity, "eccentricity": [[eccentricity, angle]] * 2, "tilt_coordinates": [],
    }  # fmt: skip
    housings = {name: (np.eye(2) * value).tolist() for name, value in (("mass", 1.2), ("stiffness", 2e7), ("damping", 3e3))}
    ends = enumerate(("drive_end", "free_end"))
    contacts = [contact | {"name": name, "rotor_coordinate": i, "stator_coordinate": i} for i, name in ends]
    return Scene.from_dict({
        "title": "rotor dropped on two auxiliary bearings", "rotor": rotor, "stator": {"model": "matrices", **housings},
        "contact": contacts, "drive": {"speed": 200.0, "duration": duration}, "start": {"centre": True},
        "output": {"rate": 20000.0}, **tables,
    })  # fmt: skip
