"""Random complete scenes of twelve kinds as TOML text: all rotor and stator models, both friction laws, every way to start.

A scene is a function of seed and number alone; its kind is the number modulo twelve. Frequencies, masses and contact are drawn so
that a contact vibrates some hundred to some thousand times a second, which both engines resolve in a second or less.
"""

import json
import random
import sys
from pathlib import Path

import numpy as np

import rsc
from rsc.machine.reduction.reduction import reduce

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))
from machines import random_machine

ROTORS, STATORS = ("laval", "disk", "chain", "matrices"), ("rigid", "laval", "chain", "matrices")
STARTS = ("rest", "backward", "backward", "backward", "whirl", "impact", "impact", "near a whirl")
DRIVES = ("constant", "run-up", "run-up", "run-down", "hold")
KINDS = (
    "short", "diverging", "bouncing", "rolling", "stator-dominated", "two whirls", "run-down", "weight", "unequal supports",
    "impact", "reduced machine", "fast whirl",
)  # fmt: skip
REDUCED_SIZES = (8, 2), (9, 3)  # coordinates of rotor and stator; few, since each is a kernel of its own
DRAWS = 60  # at most, until a scene that is to start on a whirl has one
TWO_PI = 2.0 * np.pi


def kind_of(number):
    """The kind of a scene."""
    return KINDS[number % len(KINDS)]


def scene_text(seed, number, constant=False):
    """(TOML text, what it is in words) of one scene; constant: at constant speed."""
    kind, dice = kind_of(number), random.Random(f"{seed}/{number}")
    if kind == "reduced machine":
        return _reduced(dice, seed, number, constant)
    for _ in range(DRAWS):
        text, words = _drawn(dice, kind, f"answers {seed}/{number}", constant)
        if _possible(text):
            break
    return text, words


def _possible(text):
    """Whether the whirl that a scene starts on exists, or the motion without contact."""
    try:
        scene = rsc.Scene.from_toml(text)
        if scene.start.kind == "whirl":
            backward = [whirl for whirl in rsc.predict(scene, scene.drive.speed[0]) if whirl.frequency < 0.0]
            return any(whirl.stable for whirl in backward) if scene.start.whirl == "backward" else bool(backward)
        return scene.start.kind != "running" or _runs_free(scene)
    except rsc.RscError:
        return False


def _runs_free(scene):
    short = scene.with_values({"drive.speed": scene.drive.speed[0], "drive.duration": 1e-3})
    try:
        rsc.simulate(short)
    except rsc.RscError:
        return False
    return True


def _drawn(dice, kind, title, constant):
    drive = "constant" if constant else {"run-down": "run-down", "impact": "constant"}.get(kind) or dice.choice(DRIVES)
    gap = _log(dice, 2e-4, 2e-3)
    faster = _log(dice, 8.0, 25.0) if kind == "fast whirl" else 1.0
    rotor, i_r, frequency, mass = _rotor(dice, _rotor_model(dice, kind), faster)
    stator, i_s = _stator(dice, _stator_model(dice, kind), mass, kind, faster)
    n = _coordinates(rotor)
    ecc = gap * (dice.uniform(0.3, 0.95) if kind == "bouncing" else _log(dice, 0.005, 0.3))
    rotor["eccentricity"] = ecc if rotor["model"] in ("laval", "disk") else [ecc if i == i_r else 0.0 for i in range(n)]
    if kind == "weight":
        rotor["gravity"] = 9.81 * dice.uniform(0.05, 1.0) * faster
    if kind == "unequal supports":
        rotor["supports"] = [_support(dice, i_r, mass, frequency)]
    contact = {
        "rotor_coordinate": i_r, "stator_coordinate": i_s, "gap": gap, "friction": _friction(dice, kind),
        "stiffness": mass * (TWO_PI * frequency) ** 2 * _log(dice, 20.0, 400.0),
        "damping_ratio": dice.choice((0.0, 0.02, 0.1, 0.3)),
    }  # fmt: skip
    speeds, duration = _drive(dice, drive, kind, frequency)
    _slipping(dice, kind, contact, speeds)
    if rotor["model"] == "laval" and dice.random() < 0.3:
        contact["ring_eccentricity"] = [gap * dice.uniform(0.01, 0.2), dice.uniform(0.0, 360.0)]
    start = _start_kind(dice, kind)
    tables = {
        "rotor": rotor, "stator": stator, "contact": contact, "drive": _drive_table(drive, speeds, duration),
        "start": _start(dice, start, (n, i_r), gap, (mass, frequency)),
    }  # fmt: skip
    law = "two-sided" if "diameter" in contact else "one-sided"
    words = f"{kind}: {rotor['model']} in {stator['model']}, {law}, {drive}, {start}"
    return toml(f"{title}: {words}", tables), words


def _rotor_model(dice, kind):
    return dice.choice(("disk", "chain", "matrices") if kind == "two whirls" else ROTORS)


def _stator_model(dice, kind):
    return dice.choice(STATORS[1:] if kind == "stator-dominated" else STATORS)


def _start_kind(dice, kind):
    if kind in ("bouncing", "impact"):
        return "rest" if kind == "bouncing" else "impact on the running rotor"
    if kind in ("diverging", "rolling", "fast whirl"):
        return dice.choice(("near a whirl", "impact", "whirl"))
    return dice.choice(STARTS)


def _friction(dice, kind):
    if kind in ("diverging", "rolling"):
        return dice.uniform(0.3, 1.0)
    return _log(dice, 0.03, 0.5)


def _slipping(dice, kind, contact, speeds):
    """A diameter, with which friction follows the slip; one with which the rotor may roll where it is to."""
    if kind == "diverging" or (kind != "rolling" and dice.random() < 0.5):
        return
    ratio = _log(dice, 1.0, 6.0) if kind == "rolling" else _log(dice, 1.0, 300.0)
    contact["diameter"] = 2.0 * contact["gap"] * ratio
    contact["slip_velocity"] = np.pi * max(map(abs, speeds)) * contact["diameter"] * _log(dice, 0.01, 0.2)


def _support(dice, coordinate, mass, frequency):
    """A support that differs in y and z: stiffness of some tenths of the rotor's, and a little damping."""
    stiffness, damping = mass * (TWO_PI * frequency) ** 2 * _log(dice, 0.05, 0.5), mass * TWO_PI * frequency * 0.02
    cross = stiffness * dice.uniform(-0.02, 0.02)
    return [coordinate, [stiffness, cross, cross, stiffness * dice.uniform(0.1, 1.0)], [damping, 0.0, 0.0, damping]]


def _reduced(dice, seed, number, constant):
    """A machine of finite elements as `rsc import` and the reading of its scene leave it."""
    rng, sizes = np.random.default_rng([seed, number]), None
    while sizes not in REDUCED_SIZES:
        machine = random_machine(rng, least=5, most=8)
        top = machine.speeds[1] * dice.uniform(0.6, 1.0)
        machine = machine._replace(band=(2.0 * machine.band[0], 2.0 * machine.band[1]), speeds=(0.0, top))
        rotor, stator = (reduce(body, machine.band, machine.speeds, 1e-2).body for body in machine[:2])
        sizes = rotor.n_coordinates, stator.n_coordinates
    compliance = sum(float(np.linalg.solve(body.stiffness, body.contact) @ body.contact) for body in (rotor, stator))
    stiffness = _log(dice, 5.0, 40.0) / compliance
    spinning = rotor.stiffness - (rotor.mass - rotor.gyroscopic) * top**2 + 1j * top * rotor.damping
    size = abs(rotor.contact @ np.linalg.solve(spinning, rotor.unbalance.sum(axis=1) * top**2))
    gap, speed = size * _log(dice, 0.7, 10.0), top / TWO_PI
    rotor, stator = (_reduced_table(body, machine, i == 0) for i, body in enumerate((rotor, stator)))
    contact = {
        "gap": gap, "friction": _log(dice, 0.03, 0.5), "stiffness": stiffness, "damping_ratio": dice.choice((0.0, 0.1)),
        "diameter": 2.0 * gap * _log(dice, 30.0, 300.0),
    }  # fmt: skip
    contact["slip_velocity"] = 0.05 * 0.5 * top * contact["diameter"]
    kind = dice.choice(("impact", "rest"))
    impact = rotor["mass"] * gap * top * _log(dice, 0.5, 10.0)
    start = {"rest": True} if kind == "rest" else {"rest": True, "impulse": [impact * np.cos(number), impact * np.sin(number)]}
    slow = 1.0 if constant or dice.random() < 0.5 else dice.uniform(0.4, 0.9)
    drive = {"speed": speed if slow == 1.0 else [slow * speed, speed], "duration": dice.uniform(60.0, 150.0) / speed}
    tables = {"rotor": rotor, "stator": stator, "contact": contact, "drive": drive, "start": start}
    words = f"reduced machine of {sizes[0]} + {sizes[1]} coordinates, {'constant' if slow == 1.0 else 'run-up'}, {kind}"
    return toml(f"answers {seed}/{number}: {words}", tables), words


def _reduced_table(body, machine, rotor):
    """[rotor] or [stator] of a body in contact coordinates."""
    matrices = {name: getattr(body, name) for name in ("stiffness", "damping", "skew_stiffness", "skew_damping")}
    matrices |= {"gyroscopic": body.gyroscopic} if rotor else {}
    content = {"model": "reduced", **{name: matrix.tolist() for name, matrix in matrices.items() if matrix is not None}}
    band, speeds = ([float(omega) / TWO_PI for omega in pair] for pair in (machine.band, machine.speeds))
    content |= {"mass": float(body.mass[0, 0]), "origin": "random", "coordinates_before": 1, "tolerance": 1e-2, "error": 0.0}
    content |= {"band": band, "speeds": speeds, "highest_before": 1.0, "highest_after": 1.0}
    if rotor:
        pairs = ([[float(v.real), float(v.imag)] for v in vector] for vector in (body.unbalance.sum(axis=1), 0.0 * body.load))
        content |= dict(zip(("unbalance", "load"), pairs, strict=True))
    return content


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


def _rotor(dice, model, faster):
    """(table without eccentricity, contacting coordinate, lowest natural frequency about in Hz, mass at the contact)."""
    mass, frequency, ratio = _log(dice, 0.3, 10.0), faster * _log(dice, 8.0, 60.0), _log(dice, 0.003, 0.08)
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
    n = 2 if model == "chain" else 3  # few sizes: each is a kernel of its own
    if model == "chain":
        masses = [mass * dice.uniform(0.5, 2.0) for _ in range(n)]
        springs = [stiffness * dice.uniform(0.5, 3.0) for _ in range(n + 1)]
        i = dice.randrange(n)
        return {"model": model, "masses": masses, "stiffnesses": springs, "damping_ratio": ratio}, i, frequency, masses[i]
    matrices, masses = _matrices(dice, n, mass, frequency)
    polar = [0.0] + [masses[i] * dice.uniform(0.0, 1.5) for i in range(1, n)]
    matrices |= {"gyroscopic": np.diag(polar).tolist(), "tilt_coordinates": list(range(1, n)), "damping_ratio": ratio}
    return {"model": model, **matrices}, 0, frequency, mass


def _stator(dice, model, mass, kind, faster):
    """(table, contacting coordinate)."""
    if model == "rigid":
        return {"model": model}, 0
    low, high, heaviest = (10.0, 40.0, 0.3) if kind == "stator-dominated" else (30.0, 200.0, 2.0)
    mass, frequency, ratio = mass * _log(dice, 0.05, heaviest), faster * _log(dice, low, high), _log(dice, 0.01, 0.3)
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
    turns = _log(dice, 1.0, 12.0) if kind == "short" else dice.uniform(30.0, 120.0)
    duration = turns / frequency
    speed = frequency * (dice.uniform(0.8, 1.6) if kind == "bouncing" else _log(dice, 0.2, 3.0))
    if drive == "constant":
        return [speed], duration
    other = speed + frequency * dice.uniform(0.05, 0.8)
    return ([other, speed] if drive == "run-down" else [speed, other]), duration


def _drive_table(drive, speeds, duration):
    if drive == "hold":
        corners = [[0.0, speeds[0]], [0.4 * duration, speeds[1]], [duration, speeds[1]]]
        return {"schedule": corners}
    return {"speed": speeds if len(speeds) > 1 else speeds[0], "duration": duration}


def _start(dice, start, place, gap, rotor):
    """The table [start]; an impact is a velocity at the contact or an impulse, "near a whirl" a backward circle of guessed
    frequency and size; rotor: (mass, frequency)."""
    (n, i_r), (mass, frequency) = place, rotor
    size, faster, angle = gap * _log(dice, 0.2, 5.0), dice.uniform(1.0, 2.5), dice.uniform(0.0, TWO_PI)
    if start == "rest":
        return {"rest": True}
    if start == "backward":
        return {"whirl": "backward"}
    if start == "whirl":
        return {"whirl": -frequency * 2.0 * faster}
    along = np.array([np.cos(angle), np.sin(angle)])
    if start == "impact on the running rotor":
        return {"running": True, "impulse": (2.0 * size * TWO_PI * mass * frequency * along).tolist()}
    turn = TWO_PI * frequency * faster
    if start == "impact":
        return {"rotor_velocity": [(size * turn * along).tolist() if i == i_r else [0.0, 0.0] for i in range(n)]}
    size = min(size, 1.09 * gap)
    place = [[size, 0.0] if i == i_r else [0.0, 0.0] for i in range(n)]
    velocity = [[0.0, -size * turn] if i == i_r else [0.0, 0.0] for i in range(n)]
    return {"rotor": place, "rotor_velocity": velocity}
