"""The hard dozen as data: twelve scenes where methods fail, each in one to four settings."""

import copy
from typing import NamedTuple

import numpy as np

GAP, K_R, OMEGA_R = 1e-3, (2.0 * np.pi * 30.0) ** 2, 2.0 * np.pi * 30.0
# Laval rotor of 1 kg, 30 Hz, in a ring of 0.25 kg, 150 Hz: the yardstick problem P1
BASE = {
    "rotor": {"model": "laval", "mass": 1.0, "frequency": 30.0, "damping_ratio": 0.02, "eccentricity": 5e-5},
    "stator": {"model": "laval", "mass": 0.25, "stiffness": 2.2207e5, "damping": 47.124},
    "contact": {"gap": GAP, "friction": 0.2, "stiffness": 100.0 * K_R, "damping": 84.3},
    "drive": {"speed": [20.0, 20.27], "duration": 0.1},
    "start": {"whirl": "backward"},
    "solver": {"rtol": 1e-6},
    "output": {"rate": 2000.0},
}
RIGID = {"model": "rigid"}
# a rotor on its way around the ring, backwards, that meets it at a small angle
ON_ITS_WAY = {"rotor": [[1e-3, 0.0]], "rotor_velocity": [[0.1, -0.4]]}


class Setting(NamedTuple):
    """One setting of a scene: what to run and which oracle judges it."""

    scene: str  # "S1"
    label: str
    tables: dict
    oracle: str  # a function of oracles.ORACLES
    h: float = 2e-5  # s, step of the fixed-step methods
    zero_gap: bool = False  # the gap is set to 0 behind the back of the scene reader, for the methods that allow it
    options: dict = {}  # noqa: RUF012 - of the oracle, never changed


SCENES = {
    "S1": "impacts on a rigid wall",
    "S2": "sustained rub",
    "S3": "contact damper",
    "S4": "light stator",
    "S5": "high modes in the model",
    "S6": "no gap, preload",
    "S7": "grazing",
    "S8": "rolling and sticking",
    "S9": "undamped impacts, energy",
    "S10": "speed through zero, stop",
    "S11": "600 s through resonance",
    "S12": "fast run-up; chaos",
}


def tables(*, start=None, stator=None, **changes):
    """BASE with dotted keys changed (contact__stiffness = 1.0); None removes a key; start and stator replace their tables."""
    content = copy.deepcopy(BASE)
    if start is not None:
        content["start"] = start
    if stator is not None:
        content["stator"] = stator
    for dotted, value in changes.items():
        name, key = dotted.split("__")
        if value is None:
            del content[name][key]
        else:
            content[name][key] = value
    return content


def _line(k_c, velocity, **changes):
    """Motion on one line between two rigid walls, without friction."""
    return tables(
        stator=RIGID,
        start={"rotor_velocity": [[velocity, 0.0]]},
        rotor__eccentricity=0.0,
        contact__friction=0.0,
        contact__stiffness=k_c,
        **{"drive__speed": 0.0, **changes},
    )


def beam(n, power=2.0):
    """Rotor with n modes of 30 Hz (2 i - 1)^power at n stations from midspan on; power 2: those of a slender pinned beam."""
    i = np.arange(n)
    shapes = np.sqrt(2.0 / n) * np.cos((i[:, None] + 0.5) * (i + 0.5) * np.pi / n)
    stiffness = shapes @ np.diag((OMEGA_R * (2.0 * i + 1.0) ** power) ** 2 / n) @ shapes.T
    return {
        "model": "matrices",
        "mass": (np.eye(n) / n).tolist(),
        "stiffness": (0.5 * (stiffness + stiffness.T)).tolist(),
        "damping_ratio": 0.01,
        "eccentricity": [5e-5] * n,
    }, shapes[:, 0] / shapes[0, 0]


def _beam(n, power):
    rotor, shape = beam(n, power)
    start = {"rotor": [[1e-3 * s, 0.0] for s in shape], "rotor_velocity": [[0.1 * s, -0.4 * s] for s in shape]}
    return tables(start=start, drive__duration=0.1 if n < 50 else 0.02) | {"rotor": rotor}


def _s1():
    for ratio in (20.0, 2e3, 2e5, 2e6):
        k_c = ratio * K_R
        content = _line(k_c, 0.6, contact__damping=0.1 * np.sqrt(k_c), drive__duration=0.05, output__rate=10_000.0)
        yield Setting("S1", f"k_C/k_R = {ratio:g}", content, "line")


def _s2_to_s5():
    for factor in (1.0, 1e2, 1e4, 1e5):
        content = tables(contact__stiffness=100.0 * factor * K_R, contact__damping=84.3 * np.sqrt(factor))
        hz = np.sqrt(100.0 * factor * K_R / 0.2) / (2.0 * np.pi)
        yield Setting("S2", f"contact mode {hz / 1e3:.3g} kHz", content, "reference", options={"fastest": 2 * np.pi * hz})
    for factor, zeta in ((1.0, 0.05), (1e2, 5.0), (1e4, 500.0)):
        content = tables(contact__damping=84.3 * factor)
        fastest = max(2.0 * 84.3 * factor / 0.2, 5e3)
        yield Setting("S3", f"damping ratio {zeta:g}", content, "reference", options={"fastest": fastest})
    for mass in (0.25, 1e-2, 1e-4, 1e-6):
        damping = 0.1 * np.sqrt(100.0 * K_R * mass)
        content = tables(start=ON_ITS_WAY, stator__mass=mass, contact__damping=damping, drive__duration=0.05)
        fastest = max(47.0 / mass, 2.0 * np.sqrt(100.0 * K_R / mass))
        yield Setting("S4", f"m_S/m_R = {mass:g}", content, "reference", options={"fastest": fastest})
    for n, power in ((6, 2.0), (21, 2.0), (100, 1.4)):
        hz = 30.0 * (2.0 * n - 1.0) ** power
        content, options = _beam(n, power), {"fastest": 2 * np.pi * hz}
        yield Setting("S5", f"{n} modes to {hz / 1e3:.2g} kHz", content, "reference", options=options)


def _s6():
    # the weight presses the rotor into a wall 0.1 mm below; without unbalance beyond 5e-5 m it stays there
    lying = {"rotor": [[0.0, -1.05e-4]]}
    content = tables(start=lying, contact__gap=1e-4, rotor__gravity=9.81, rotor__damping_ratio=0.05, contact__friction=0.1)
    yield Setting("S6", "weight keeps it on the wall", content, "extrapolated")
    tiny = {"rotor": [[0.0, 0.0]], "rotor_velocity": [[0.05, 0.02]], "allow_penetration": True}
    content = tables(start=tiny, contact__gap=1e-6, contact__friction=0.02, contact__damping=0.0,
                     drive__duration=0.02)  # fmt: skip
    yield Setting("S6", "gap 1 um, from the centre", content, "extrapolated", options={"h_max": 1e-5})
    off = {"rotor": [[2e-4, 0.0]], "rotor_velocity": [[0.0, 0.1]], "allow_penetration": True}
    content = tables(start=off, contact__gap=GAP, contact__friction=0.05, contact__damping=0.0)
    yield Setting("S6", "gap 0", content, "extrapolated", zero_gap=True)


def _s7():
    for excess in (1e-9, -1e-9):
        content = _line(100.0 * K_R, GAP * (1.0 + excess) * OMEGA_R, rotor__damping_ratio=0.0, contact__damping=0.0,
                        drive__duration=1.0)  # fmt: skip
        sign = "+" if excess > 0.0 else "-"
        yield Setting("S7", f"touch at gap x (1 {sign} 1e-9)", content, "free_line", options={"excess": excess})
    # unbalance response at 20 Hz: |r| = gap (1 + 1e-9) all the way round
    speed = 2.0 * np.pi * 20.0
    per_ecc = speed**2 / (K_R - speed**2)
    content = tables(
        stator=RIGID,
        start={"rotor": [[GAP * (1.0 + 1e-9), 0.0]], "rotor_velocity": [[0.0, speed * GAP * (1.0 + 1e-9)]]},
        rotor__eccentricity=GAP * (1.0 + 1e-9) / per_ecc, rotor__damping_ratio=0.0, contact__friction=0.0, contact__damping=0.0,
        drive__speed=20.0, drive__duration=0.5,
    )  # fmt: skip
    yield Setting("S7", "orbit at gap x (1 + 1e-9)", content, "orbit", options={"excess": 1e-9})


def _s8():
    for width in (1e-2, 1e-4, 1e-6):
        content = tables(drive__speed=20.0, drive__duration=0.03, contact__diameter=5e-3, contact__slip_velocity=width)
        yield Setting("S8", f"slip width {width:g} m/s", content, "radau" if width < 1e-3 else "extrapolated")


def _s9():
    k_c, velocity = 1e5 * K_R, 6.0
    for impacts, duration in ((1e3, 0.38), (1e5, 38.0)):
        content = _line(k_c, velocity, rotor__damping_ratio=0.0, contact__damping=0.0, drive__duration=duration,
                        output__rate=50_000.0)  # fmt: skip
        yield Setting("S9", f"{impacts:,.0f} impacts", content, "energy")


def _s10():
    for label, corners in (
        ("through zero to -20 Hz", [[0.0, 20.0], [0.1, -20.0], [0.2, -20.0]]),
        ("stop and start again", [[0.0, 20.0], [0.08, 0.0], [0.12, 0.0], [0.2, 20.0]]),
    ):
        content = tables(start=ON_ITS_WAY, drive__speed=None, drive__duration=None, drive__schedule=corners,
                         contact__diameter=0.02, contact__slip_velocity=0.05)  # fmt: skip
        yield Setting("S10", label, content, "extrapolated")


def _s11_s12():
    # little damping: the resonance takes 13 s to build up, and the closed form needs fewer digits
    free = {"stator": RIGID, "start": {"rest": True}, "contact__gap": 0.01, "rotor__damping_ratio": 0.004, "output__rate": 400.0}
    for label, speed in (("run-up 20 to 100 Hz", [20.0, 100.0]), ("coast-down 100 to 20 Hz", [100.0, 20.0])):
        content = tables(**free, drive__speed=speed, drive__duration=600.0)
        yield Setting("S11", label, content, "run_up", h=1e-4)
    # the unbalance presses the rotor against the stator while it is near 30 Hz, and keeps the phase of the motion
    content = tables(start={"rest": True}, contact__friction=0.05, drive__speed=[100.0, 20.0], drive__duration=600.0,
                     output__rate=400.0)  # fmt: skip
    options = {"fastest": 2.0 * np.pi * 671.0}
    yield Setting("S11", "coast-down with rub", content, "reference", h=1e-4, options=options)
    content = tables(**{**free, "output__rate": 2000.0}, drive__speed=[20.0, 100.0], drive__duration=0.3)
    yield Setting("S12", "run-up in 0.3 s", content, "run_up")
    yield Setting("S12", "chaotic partial rub", chaotic(2400), "statistics")


def chaotic(turns):
    """A chaotic partial rub at 60 Hz: unbalance 0.6 mm, a constant load that shifts the rotor by 0.84 gaps.

    It stays chaotic; with a load of 20 N it settles on a motion of three turns after some thousand.
    """
    return tables(
        start={"rest": True}, stator={"model": "laval", "mass": 0.25, "frequency": 120.0, "damping_ratio": 0.1},
        rotor__eccentricity=6e-4, rotor__damping_ratio=0.03, rotor__load=[[0.0, -30.0]], contact__friction=0.1,
        contact__stiffness=3.55e6, contact__damping=43.0, drive__speed=60.0, drive__duration=turns / 60.0, output__rate=1000.0,
    )  # fmt: skip


SETTINGS = [*_s1(), *_s2_to_s5(), *_s6(), *_s7(), *_s8(), *_s9(), *_s10(), *_s11_s12()]
