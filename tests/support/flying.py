"""Rotors with a mode so fast that they fly between contacts."""

import numpy as np

from rsc.simulation import pack
from scenes import changed

FREQUENCIES = (25.0, 180.0, 3000.0)  # Hz
_TURN = np.linalg.qr(np.array([[1.0, 0.3, 0.05], [-0.3, 1.0, 0.2], [0.1, -0.2, 1.0]]))[0]
_TURN = _TURN * np.sign(_TURN.diagonal())


def matrices(ratio=0.004, coupled=2.0):
    """Mass, stiffness and damping: modes of a damping ratio, and a damper between the coordinates."""
    omega = 2.0 * np.pi * np.array(FREQUENCIES)
    stiffness, damping = (_TURN @ np.diag(values) @ _TURN.T for values in (omega**2, 2.0 * ratio * omega))
    damping = damping + coupled * np.array([[2.0, -1.0, 0.5], [-1.0, 2.0, 1.0], [0.5, 1.0, 1.5]])
    return {name: (0.5 * (part + part.T)).tolist() for name, part in (("stiffness", stiffness), ("damping", damping))}


FLYING = {
    "title": "a rotor with a mode at 3 kHz that runs up into its stator",
    "rotor": {
        "model": "matrices", "mass": np.eye(3).tolist(), **matrices(), "tilt_coordinates": [], "eccentricity": [3e-5, 1e-5, 0.0],
        "gyroscopic": [[0.0, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.5]],
    },
    "stator": {"model": "rigid"},
    "contact": {"gap": 2e-4, "friction": 0.05, "stiffness": 1e6, "damping": 50.0},
    "drive": {"speed": [15.0, 28.0], "duration": 1.0},
    "start": {"rotor": [[0.0, 1e-5], [0.0, 0.0], [1e-6, 0.0]]},
    "output": {"rate": 2000.0},
    "solver": {"method": "taylor8", "rtol": 1e-7},
}  # fmt: skip

KINDS = {
    "full matrices": FLYING,
    "no coupling": changed(
        FLYING, rotor={"gyroscopic": None, **matrices(coupled=0.0)}, start={"rotor": [[0.0, 1e-5], [0.0, 0.0], [0.0, 0.0]]}
    ),
    "springs by component": changed(
        FLYING,
        rotor={"skew_stiffness": [[200.0, 50.0, 0.0], [50.0, -300.0, 0.0], [0.0, 0.0, 0.0]]},
    ),
    "ring, stator, load": changed(
        FLYING, rotor={"gravity": 0.2}, contact={"ring_eccentricity": [2e-5, 70.0], "diameter": 0.02, "slip_velocity": 0.05},
        stator={"model": "laval", "mass": 0.5, "frequency": 400.0, "damping_ratio": 0.05},
    ),
}  # fmt: skip


class grounded:
    """Where no scene flies: `with grounded(): ...`."""

    def __enter__(self):
        self.kept = pack.with_flight
        pack.with_flight = lambda model: (model, "")

    def __exit__(self, *_):
        pack.with_flight = self.kept
