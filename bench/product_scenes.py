"""Random scenes over the product of terms: a function of seed and number alone."""

import random

import numpy as np

import rsc

TERMS = ("race", "torque", "knots", "rotating damping", "unequal supports")


def product_scene(seed, number):
    """(scene, its terms) of a number: terms go through all combinations before the dice. "weak impacts": its lists are made with
    impacts of at most half of what just touches."""
    dice, count = random.Random(f"product {seed}/{number}"), 1 + number % 3
    terms = {term for i, term in enumerate(TERMS) if (number // 3) >> i & 1}
    mass, gap = _log(dice, 2.0, 10.0), _log(dice, 1e-4, 4e-4)
    stiffness = mass * (2.0 * np.pi * _log(dice, 20.0, 45.0)) ** 2
    rotor = _rotor(dice, terms, (count, mass, stiffness), gap)
    stator = {"model": "laval", "mass": 0.7 * mass, "frequency": _log(dice, 80.0, 160.0), "damping_ratio": 0.06}
    speed = _log(dice, 20.0, 70.0)
    contacts = [_contact(dice, i, stiffness, (gap, speed)) for i in range(count)]
    if "race" in terms:
        contacts[0] |= {"race_inertia": 1e-4, "race_drag": 1e-5}
    drive = _drive(dice, terms, mass, speed)
    angle, size = dice.uniform(0.0, 2.0 * np.pi), gap * 2.0 * np.pi * speed * 2.0 * (dice.random() < 0.8)
    moving, bodies = [[size * np.cos(angle), size * np.sin(angle)]], {"rotor": rotor, "stator": stator}
    if dice.random() < 0.2:
        terms, bodies = terms | {"one body"}, {"rotor": _one_body(rotor, stator)}
        for contact in contacts:
            contact["rotor_coordinate"] = [contact["rotor_coordinate"], count]
            del contact["stator_coordinate"]
    if not terms & {"race", "torque"} and dice.random() < 0.3:
        terms = terms | {"one-sided"}
        contacts = [{key: value for key, value in own.items() if key not in ("diameter", "slip_velocity")} for own in contacts]
    start = still = _start(moving, count, "stator" in bodies)
    if count == 1 and not terms & {"torque", "one body"} and dice.random() < 0.6:
        terms, start = terms | {"measured"}, {"whirl": "backward"} if dice.random() < 0.7 else still
    title = f"product {seed}/{number}: {count} contacts, {', '.join(sorted(terms)) or 'no more'}"
    tables = {"title": title, **bodies, "contact": contacts if count > 1 else contacts[0], "drive": drive, "start": start}
    scene = rsc.Scene.from_dict({**tables, "output": {"rate": 4000.0}})
    if start is not still and not any(own.stable and own.frequency < 0.0 for own in rsc.predict(scene, speed)):
        scene = rsc.Scene.from_dict({**tables, "start": still, "output": {"rate": 4000.0}})
    if dice.random() < 0.15:
        terms = terms | {"weak impacts"}
    return scene, terms


def _log(dice, low, high):
    return float(np.exp(dice.uniform(np.log(low), np.log(high))))


def _rotor(dice, terms, chain, gap):
    """The table [rotor] of a chain = (count, mass, stiffness)."""
    count, mass, stiffness = chain
    damping, support = 0.04 * np.sqrt(mass * stiffness), 0.15 * stiffness
    rotor = {
        "model": "chain", "masses": [mass * dice.uniform(0.8, 1.5) for _ in range(count)],
        "stiffnesses": [stiffness * dice.uniform(0.5, 1.5) for _ in range(count + 1)], "dampings": [damping] * (count + 1),
        "eccentricity": [gap * _log(dice, 0.02, 0.4)] + [0.0] * (count - 1),
    }  # fmt: skip
    if "rotating damping" in terms:
        rotor["rotating_damping"] = [0.1 * damping] * (count + 1)
    if "unequal supports" in terms:
        rotor["supports"] = [[0, [support, 0.0, 0.0, 0.5 * support], [0.0, 0.0, 0.0, 0.0]]]
    if "knots" in terms:
        laws = [[hz, [rise * support, 0.0, 0.0, rise * support], [1.0, 0.0, 0.0, 1.0]] for hz, rise in ((10.0, 0.5), (80.0, 1.5))]
        rotor["supports_by_speed"] = [[0, laws]]
    return rotor


def _contact(dice, i, stiffness, sizes):
    """The table of contact number i; sizes: (gap, rotor speed)."""
    (gap, speed), diameter = sizes, _log(dice, 0.02, 0.08)
    return {
        "name": ("seal", "bush", "ring")[i], "rotor_coordinate": i, "stator_coordinate": 0, "gap": gap * dice.uniform(0.8, 1.3),
        "friction": _log(dice, 0.05, 0.35), "stiffness": stiffness * _log(dice, 20.0, 100.0), "damping_ratio": 0.1,
        "diameter": diameter, "slip_velocity": 0.05 * np.pi * speed * diameter,
    }  # fmt: skip


def _drive(dice, terms, mass, speed):
    """The table [drive]."""
    drive = {"speed": speed, "duration": 1.0}
    if "torque" not in terms:
        return drive
    inertia = 1e-3 * mass
    strong = inertia * 2.0 * np.pi * speed / _log(dice, 0.3, 3.0)
    drive |= {"inertia": inertia, "torque": [[0.0, strong], [speed, 0.2 * strong], [1.2 * speed, -0.3 * strong]]}
    return drive | ({"trip": 0.7, "coast": [[0.0, -0.05 * strong]]} if dice.random() < 0.4 else {})


def _start(moving, count, stator):
    """The table [start] of a rotor whose first mass moves; of one body the last is the casing."""
    still = [[0.0, 0.0]]
    start = {"rotor": still * (count + (not stator)), "rotor_velocity": moving + still * (count - 1 + (not stator))}
    return start | ({"stator": still, "stator_velocity": still} if stator else {})


def _one_body(rotor, stator):
    """The table [rotor] of a chain and its casing as one body."""
    n = len(rotor["masses"])
    made = {key: np.zeros((n + 1, n + 1)) for key in ("mass", "stiffness", "damping")}
    made["mass"][:n, :n] = np.diag(rotor["masses"])
    made["stiffness"][:n, :n], made["damping"][:n, :n] = _chained(rotor["stiffnesses"]), _chained(rotor["dampings"])
    turns = 2.0 * np.pi * stator["frequency"]
    own = stator["mass"], stator["mass"] * turns**2, 2.0 * stator["damping_ratio"] * stator["mass"] * turns
    for key, value in zip(made, own, strict=True):
        made[key][n, n] = value
    if "rotating_damping" in rotor:
        made["rotating_damping"] = np.zeros((n + 1, n + 1))
        made["rotating_damping"][:n, :n] = _chained(rotor["rotating_damping"])
    kept = {key: rotor[key] for key in ("supports", "supports_by_speed") if key in rotor}
    table = {"model": "matrices", "tilt_coordinates": [], "eccentricity": [*rotor["eccentricity"], 0.0]}
    return table | {key: matrix.tolist() for key, matrix in made.items()} | kept


def _chained(values):
    """The matrix of springs (n + 1,) before, between and behind n masses."""
    values = np.asarray(values)
    return np.diag(values[:-1] + values[1:]) - np.diag(values[1:-1], 1) - np.diag(values[1:-1], -1)
