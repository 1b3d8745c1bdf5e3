"""Scenes of audit.py, without end and with a fixed seed."""

from pathlib import Path

import numpy as np

from rsc import Scene, load_scene

ROOT = Path(__file__).resolve().parents[1]
SEED = 20260104


def scenes(seed=SEED):
    """In turn a variant of the bouncing rotor along a ramp of the speed from rest, one that grazes at a constant speed, and a
    scene with all that a scene can have."""
    base, rng = load_scene(ROOT / "data" / "reference" / "bouncing.toml"), np.random.default_rng(seed)
    while True:
        ratio, speed = rng.uniform(0.005, 0.05), rng.uniform(15.0, 100.0, 2)
        values = {
            "rotor.damping_ratio": ratio,
            "stator.mass": 10.0 ** rng.uniform(-1.3, 0.3),
            "stator.frequency": rng.uniform(40.0, 200.0),
            "contact.friction": rng.uniform(0.0, 0.15),
            "contact.stiffness": 10.0 ** rng.uniform(6.0, 8.0),
            "contact.damping_ratio": rng.uniform(0.0, 0.2),
            "drive.duration": 20.0,
        }
        ramp = {"rotor.gravity": rng.uniform(0.0, 20.0), "rotor.eccentricity": 10.0 ** rng.uniform(-4.0, -3.0)}
        yield base.with_values(values | ramp | {"drive.speed": speed.tolist()})
        yield base.with_values(values | _grazing(base, ratio, speed[0], rng.uniform(0.1, 0.6), 10.0 ** rng.uniform(-9.0, -2.0)))
        yield Scene.from_dict(mixed(rng))


def _grazing(base, ratio, speed, share, depth):
    """Values of a start on the elliptic orbit, lowered by a share of the gap, that goes beyond the gap by a depth in gaps."""
    omega, Omega, gap = 2.0 * np.pi * base.rotor.frequency, 2.0 * np.pi * speed, base.contact.gap
    gain = Omega**2 / (omega**2 - Omega**2 + 2j * ratio * omega * Omega)
    radius = gap * (1.0 + depth - share)
    begin, rate = radius * gain / abs(gain) - 1j * share * gap, 1j * Omega * radius * gain / abs(gain)
    return {
        "rotor.gravity": share * gap * omega**2,
        "rotor.eccentricity": radius / abs(gain),
        "drive.speed": [speed, speed],
        "start.rotor": [[begin.real, begin.imag]],
        "start.rotor_velocity": [[rate.real, rate.imag]],
        "start.allow_penetration": True,
    }


def mixed(rng):
    """A random disk in a ring, thrown at it: supports that are skew and unequal, load, ring eccentricity, a broken schedule of
    the speed, friction that follows the slip, a contact with or without a damper, 1e5 to 1e8 N/m; each there or not."""
    gap, stiffness, speed = 1e-3, 10.0 ** rng.uniform(3.9, 5.0), rng.uniform(20.0, 120.0)
    rotor = {
        "model": "disk",
        "mass": rng.uniform(0.5, 2.0),
        "diametral_inertia": 0.02,
        "polar_inertia": rng.uniform(0.0, 0.03),
        "stiffness": [[stiffness, -0.2 * stiffness], [-0.2 * stiffness, 0.3 * stiffness]],
        "damping": [[rng.uniform(1.0, 30.0), 0.0], [0.0, rng.uniform(0.05, 1.5)]],
        "eccentricity": [10.0 ** rng.uniform(-5.0, -3.3), rng.uniform(-180.0, 180.0)],
        "load": (rng.normal(size=(2, 2)) * [[10.0], [1.0]]).tolist(),
        "allow_negative_damping": True,
    }
    if rng.uniform() < 0.5:
        unequal, skew = rng.uniform(-0.3, 0.3) * stiffness, rng.uniform(-0.02, 0.02) * stiffness
        spring = [unequal + 0.3 * stiffness, skew, -skew, 0.3 * stiffness]
        rotor["supports"] = [[0, spring, [rng.uniform(1.0, 9.0), 0.0, 0.0, rng.uniform(1.0, 9.0)]]]
    contact = {"gap": gap, "friction": rng.uniform(0.0, 0.3), "stiffness": 10.0 ** rng.uniform(5.0, 8.0)}
    contact["damping_ratio"] = rng.uniform(0.0, 0.5) if rng.uniform() < 0.8 else 0.0
    if rng.uniform() < 0.5:
        contact |= {"diameter": 10.0 ** rng.uniform(-3.5, -1.0), "slip_velocity": 10.0 ** rng.uniform(-3.0, -1.0)}
    if rng.uniform() < 0.3:
        contact["ring_eccentricity"] = [gap * rng.uniform(0.0, 0.3), rng.uniform(-180.0, 180.0)]
    stator = {"model": "laval", "mass": rng.uniform(0.1, 1.0), "frequency": rng.uniform(40.0, 300.0), "damping_ratio": 0.07}
    drive = {"schedule": [[time, speed * rng.uniform(0.5, 1.2)] for time in (0.0, 0.7, 4.0)]}
    start = {"rotor_velocity": (rng.normal(size=(2, 2)) * [[0.3], [1.0]]).tolist()}
    return {"title": "", "rotor": rotor, "stator": stator, "contact": contact, "drive": drive, "start": start}
