"""Random complete scenes as TOML text: all rotor and stator models, both friction laws, run-ups, run-downs, constant speeds and
holds, starts at rest, on whirls and with a knock, bouncing, diverging, stopping and short runs, motions far smaller than the gap.

A scene is a function of seed and number alone. Frequencies, masses and contact are drawn so that a run of some seconds takes an
engine in Python seconds: contact periods of about a millisecond and more.
"""

import json
import random

import numpy as np

import rsc

ROTORS, STATORS = ("laval", "disk", "chain", "matrices"), ("rigid", "laval", "chain", "matrices")
STARTS = ("rest", "backward", "backward", "backward", "whirl", "knock", "knock", "near a whirl")
DRIVES = ("constant", "run-up", "run-up", "run-down", "hold")
KINDS = ("plain",) * 5 + ("bounces",) * 2 + ("small", "strong", "short", "stopped", "ring", "weight")
RATE = 2000.0  # Hz
DRAWS = 60  # at most, until a scene that is to start on the stable backward whirl has one


def scene_text(seed, number):
    """(TOML text, kind in words) of one scene."""
    dice = random.Random(f"{seed}/{number}")
    start = dice.choice(STARTS)
    for _ in range(DRAWS):
        text, words = _drawn(dice, start, f"end to end {seed}/{number}")
        if 'whirl = "backward"' not in text or _has_stable_whirl(rsc.Scene.from_toml(text)):
            break
    return text, words


def _has_stable_whirl(scene):
    return any(whirl.stable and whirl.frequency < 0.0 for whirl in rsc.predict(scene, scene.drive.speed[0]))


def _drawn(dice, start, title):
    kind, drive = dice.choice(KINDS), dice.choice(DRIVES)
    gap = _log(dice, 2e-4, 2e-3)
    rotor, i_r, frequency, mass = _rotor(dice, dice.choice(ROTORS))
    stator, i_s = _stator(dice, dice.choice(STATORS), mass)
    ecc = gap * _log(dice, 0.005, 0.3) * {"small": 1e-3, "strong": 3.0}.get(kind, 1.0)
    if kind == "bounces":
        start, ecc = "rest", gap * dice.uniform(0.3, 0.95)
    n = _coordinates(rotor)
    rotor["eccentricity"] = ecc if rotor["model"] in ("laval", "disk") else [ecc if i == i_r else 0.0 for i in range(n)]
    if kind == "weight":
        rotor["gravity"] = 9.81 * dice.uniform(0.05, 1.0)
    contact = {
        "rotor_coordinate": i_r, "stator_coordinate": i_s, "gap": gap, "friction": _log(dice, 0.03, 0.5),
        "stiffness": mass * (2.0 * np.pi * frequency) ** 2 * _log(dice, 20.0, 400.0),
        "damping_ratio": dice.choice((0.0, 0.02, 0.1, 0.3)),
    }  # fmt: skip
    speeds, duration = _drive(dice, drive, kind, frequency)
    if dice.random() < 0.5:
        contact["diameter"] = 2.0 * gap * _log(dice, 1.0, 300.0)
        contact["slip_velocity"] = np.pi * max(map(abs, speeds)) * contact["diameter"] * _log(dice, 0.01, 0.2)
    if kind == "ring":
        contact["ring_eccentricity"] = [gap * dice.uniform(0.01, 0.2), dice.uniform(0.0, 360.0)]
    tables = {
        "rotor": rotor, "stator": stator, "contact": contact, "drive": _drive_table(drive, speeds, duration),
        "start": _start(dice, start, kind, (n, i_r), gap, frequency), "output": {"rate": RATE},
    }  # fmt: skip
    if kind == "stopped":
        tables["solver"] = {"max_steps": dice.choice((300, 3000, 20000))}
    law = "two-sided" if "diameter" in contact else "one-sided"
    words = f"{rotor['model']} in {stator['model']}, {law}, {drive}, {start}, {kind}"
    return toml(f"{title}: {words}", tables), words


def toml(title, tables):
    """TOML text of tables of numbers, lists and words."""
    lines = [f"title = {json.dumps(title)}"]
    for name, keys in tables.items():
        lines += ["", f"[{name}]", *(f"{key} = {json.dumps(_plain(value))}" for key, value in keys.items())]
    return "\n".join(lines) + "\n"


def _plain(value):
    return value.tolist() if hasattr(value, "tolist") else [_plain(v) for v in value] if isinstance(value, list) else value


def _log(dice, low, high):
    return float(np.exp(dice.uniform(np.log(low), np.log(high))))


def _coordinates(body):
    return {"laval": 1, "disk": 2}.get(body["model"]) or len(body.get("masses", body.get("mass")))


def _rotor(dice, model):
    """(table without eccentricity, contacting coordinate, lowest natural frequency about in Hz, mass at the contact)."""
    mass, frequency, ratio = _log(dice, 0.3, 10.0), _log(dice, 8.0, 60.0), _log(dice, 0.003, 0.08)
    stiffness = mass * (2.0 * np.pi * frequency) ** 2
    if model == "laval":
        return {"model": model, "mass": mass, "frequency": frequency, "damping_ratio": ratio}, 0, frequency, mass
    if model == "disk":
        radius = _log(dice, 0.05, 0.3)
        inertia, tilt = 0.25 * mass * radius**2, dice.uniform(0.5, 4.0)
        cross = dice.uniform(-0.5, 0.5) * radius * np.sqrt(0.25 * tilt) * stiffness
        table = {
            "model": model, "mass": mass, "diametral_inertia": inertia, "polar_inertia": inertia * dice.uniform(0.2, 2.0),
            "stiffness": [[stiffness, cross], [cross, 0.25 * tilt * stiffness * radius**2]], "damping_ratio": ratio,
        }  # fmt: skip
        return table, 0, frequency, mass
    n = dice.choice((2, 3))
    if model == "chain":
        masses = [mass * dice.uniform(0.5, 2.0) for _ in range(n)]
        springs = [stiffness * dice.uniform(0.5, 3.0) for _ in range(n + 1)]
        i = dice.randrange(n)
        return {"model": model, "masses": masses, "stiffnesses": springs, "damping_ratio": ratio}, i, frequency, masses[i]
    matrices, masses = _matrices(dice, n, mass, frequency)
    polar = [0.0] + [masses[i] * dice.uniform(0.0, 1.5) for i in range(1, n)]
    matrices |= {"gyroscopic": np.diag(polar).tolist(), "tilt_coordinates": list(range(1, n)), "damping_ratio": ratio}
    return {"model": model, **matrices}, 0, frequency, mass


def _stator(dice, model, mass):
    """(table, contacting coordinate)."""
    if model == "rigid":
        return {"model": model}, 0
    mass, frequency, ratio = mass * _log(dice, 0.05, 2.0), _log(dice, 30.0, 200.0), _log(dice, 0.01, 0.3)
    if model == "laval":
        return {"model": model, "mass": mass, "frequency": frequency, "damping_ratio": ratio}, 0
    if model == "chain":
        stiffness = mass * (2.0 * np.pi * frequency) ** 2
        springs = [stiffness * dice.uniform(0.5, 2.0), stiffness * dice.uniform(0.5, 2.0), stiffness * dice.choice((0.0, 1.0))]
        masses = [mass, mass * dice.uniform(0.5, 2.0)]
        return {"model": model, "masses": masses, "stiffnesses": springs, "damping_ratio": ratio}, dice.randrange(2)
    matrices, _ = _matrices(dice, 2, mass, frequency)
    return {"model": model, **matrices, "damping_ratio": ratio}, 0


def _matrices(dice, n, mass, frequency):
    """Diagonal mass and a full stiffness with natural frequencies of 1 to 6 times a lowest one; the masses."""
    masses = np.array([mass, *(mass * _log(dice, 0.3, 3.0) for _ in range(n - 1))])
    natural = 2.0 * np.pi * frequency * np.array([1.0, *(dice.uniform(1.2, 6.0) for _ in range(n - 1))])
    shape, _ = np.linalg.qr([[dice.gauss(0.0, 1.0) for _ in range(n)] for _ in range(n)])
    shape = np.sqrt(masses)[:, None] * shape
    stiffness = shape @ np.diag(natural**2) @ shape.T
    return {"mass": np.diag(masses).tolist(), "stiffness": (0.5 * (stiffness + stiffness.T)).tolist()}, masses


def _drive(dice, drive, kind, frequency):
    """(speeds in Hz, duration in s)."""
    duration = _log(dice, 0.03, 0.4) if kind == "short" else dice.uniform(1.0, 5.0)
    speed = frequency * (dice.uniform(0.8, 1.6) if kind == "bounces" else _log(dice, 0.2, 3.0))
    if drive == "constant":
        return [speed], duration
    other = speed + dice.uniform(0.5, 15.0) * duration
    return ([other, speed] if drive == "run-down" else [speed, other]), duration


def _drive_table(drive, speeds, duration):
    if drive == "hold":
        corners = [[0.0, speeds[0]], [0.4 * duration, speeds[1]], [duration, speeds[1]]]
        return {"schedule": corners}
    return {"speed": speeds if len(speeds) > 1 else speeds[0], "duration": duration}


def _start(dice, start, kind, place, gap, frequency):
    """The table [start]; a knock is a velocity at the contact, "near a whirl" a backward circle of guessed frequency and size."""
    if start == "rest":
        return {"rest": True}
    if start == "backward":
        return {"whirl": "backward"}
    if start == "whirl":
        return {"whirl": -frequency * _log(dice, 1.0, 5.0)}
    n, i_r = place
    size, turn = gap * _log(dice, 0.2, 5.0), 2.0 * np.pi * frequency * dice.uniform(1.0, 2.5)
    if start == "knock":
        angle = dice.uniform(0.0, 2.0 * np.pi)
        size *= 0.01 if kind == "small" else 1.0
        velocity = size * turn * np.array([np.cos(angle), np.sin(angle)])
        return {"rotor_velocity": [velocity.tolist() if i == i_r else [0.0, 0.0] for i in range(n)]}
    size = min(size, 1.09 * gap)
    place = [[size, 0.0] if i == i_r else [0.0, 0.0] for i in range(n)]
    velocity = [[0.0, -size * turn] if i == i_r else [0.0, 0.0] for i in range(n)]
    return {"rotor": place, "rotor_velocity": velocity}
