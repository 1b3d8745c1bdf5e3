"""Scenes that cannot be right: each is refused by one line that names file, key and what is allowed.

Numbers in the ids are the rows of the project's list of bad inputs (group A: numbers, group B: file form).
"""

import copy
import math
import os
import tomllib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rsc.errors import SceneError
from rsc.scene.files.templates import template
from rsc.scene.reading import all_keys
from rsc.scene.scene import Scene, load_scene
from system_words import MISSING

LAVAL = {
    "title": "base",
    "rotor": {"model": "laval", "mass": 1.0, "stiffness": 3.5e4, "damping_ratio": 0.02, "eccentricity": 5e-5},
    "stator": {"model": "laval", "mass": 0.25, "frequency": 150.0, "damping": 3.0},
    "contact": {"gap": 1e-3, "friction": 0.2, "stiffness": 3.55e6, "damping": 80.0},
    "drive": {"speed": [20.0, 100.0], "duration": 30.0},
}
DISK = {
    **LAVAL,
    "rotor": {
        "model": "disk",
        "mass": 1.0,
        "diametral_inertia": 0.01,
        "polar_inertia": 0.016,
        "stiffness": [[7e4, -3200.0], [-3200.0, 1300.0]],
        "damping": [[2.0, 0.0], [0.0, 0.1]],
    },
}
CHAIN = {
    **LAVAL,
    "rotor": {"model": "chain", "masses": [1.0, 2.0], "stiffnesses": [1e4, 1e4, 0.0], "dampings": [1.0, 1.0, 0.0]},
    "stator": {"model": "chain", "masses": [0.5, 0.5], "stiffnesses": [1e5, 1e5, 0.0]},
}
MATRICES = {
    **LAVAL,
    "rotor": {"model": "matrices", "mass": [[1.0, 0.0], [0.0, 2.0]], "stiffness": [[2e4, -1e4], [-1e4, 1e4]]},
    "stator": {"model": "matrices", "mass": [[1.0]], "stiffness": [[1e5]]},
}
GONE = object()


def changed(base, changes):
    """A deep copy of a scene with dotted keys set, or removed where the value is GONE."""
    content = copy.deepcopy(base)
    for dotted, value in changes.items():
        table, _, key = dotted.partition(".")
        place, key = (content.setdefault(table, {}), key) if key else (content, table)
        if value is GONE:
            del place[key]
        else:
            place[key] = value
    return content


# id, scene, changes, key that the message names ("" for the one that was changed), part of the message
BAD = [
    ("A1 mass zero", LAVAL, {"rotor.mass": 0}, "", "> 0 kg"),
    ("A2 mass negative", LAVAL, {"rotor.mass": -1.0}, "", "> 0 kg"),
    ("A3 mass nan", LAVAL, {"rotor.mass": math.nan}, "", "finite"),
    ("A4 mass inf", LAVAL, {"rotor.mass": math.inf}, "", "finite"),
    ("A5 mass subnormal", LAVAL, {"rotor.mass": 1e-320}, "", "magnitude"),
    ("A6 stiffness negative", LAVAL, {"rotor.stiffness": -1.0}, "", ">= 0 N/m"),
    ("A6 frequency zero", LAVAL, {"stator.frequency": 0.0}, "", "> 0 Hz"),
    ("A6 chain stiffness", CHAIN, {"rotor.stiffnesses": [1e4, -1.0, 0.0]}, "rotor.stiffnesses[1]", ">= 0 N/m"),
    ("A6 disk not semidefinite", DISK, {"rotor.stiffness": [[1.0, 2.0], [2.0, 1.0]]}, "", "semidefinite"),
    ("A6 matrix not semidefinite", MATRICES, {"rotor.stiffness": [[1.0, 2.0], [2.0, 1.0]]}, "", "semidefinite"),
    ("A6 matrix negative diagonal", MATRICES, {"rotor.stiffness": [[-1.0, 0.0], [0.0, 1.0]]}, "", "semidefinite"),
    ("A6 matrix zero diagonal", MATRICES, {"rotor.stiffness": [[0.0, 1.0], [1.0, 1.0]]}, "", "semidefinite"),
    ("A7 damping negative", LAVAL, {"stator.damping": -1.0}, "", ">= 0"),
    ("A7 ratio negative", LAVAL, {"rotor.damping_ratio": -0.01}, "", "allow_negative_damping"),
    ("A7 stator cannot allow", LAVAL, {"stator.allow_negative_damping": True}, "", "belongs to [rotor]"),
    ("A7 chain damping negative", CHAIN, {"rotor.dampings": [1.0, -1.0, 0.0]}, "", "allow_negative_damping"),
    ("A7 disk damping indefinite", DISK, {"rotor.damping": [[1.0, 2.0], [2.0, 1.0]]}, "", "allow_negative_damping"),
    ("A7 matrix damping", MATRICES, {"stator.damping": [[-1.0]]}, "", "positive semidefinite"),
    ("A7 rayleigh negative", MATRICES, {"rotor.rayleigh": [0.0, -1e-5]}, "", "allow_negative_damping"),
    ("A8 gap negative", LAVAL, {"contact.gap": -1e-3}, "", "> 0 m"),
    ("A9 gap zero", LAVAL, {"contact.gap": 0.0}, "", "contact direction is undefined at zero gap"),
    ("A10 contact stiffness zero", LAVAL, {"contact.stiffness": 0}, "", "> 0 N/m"),
    ("A11 contact stiffness 1e30", LAVAL, {"contact.stiffness": 1e30}, "", "contact period exceeds 1e-12 s"),
    ("A12 contact damping negative", LAVAL, {"contact.damping": -1.0}, "", ">= 0"),
    (
        "A12 contact ratio negative",
        LAVAL,
        {"contact.damping": GONE, "contact.damping_ratio": -0.1},
        "contact.damping_ratio",
        ">= 0",
    ),
    ("A13 friction negative", LAVAL, {"contact.friction": -0.1}, "", ">= 0 and <= 5"),
    ("A13 friction 6", LAVAL, {"contact.friction": 6}, "", ">= 0 and <= 5"),
    ("A14 eccentricity nan", LAVAL, {"rotor.eccentricity": math.nan}, "", "finite"),
    ("A14 eccentricity angle nan", LAVAL, {"rotor.eccentricity": [1e-5, math.nan]}, "rotor.eccentricity[1]", "finite"),
    ("A14 eccentricity list", LAVAL, {"rotor.eccentricity": [1e-5, 0.0, 0.0]}, "", "[amount, angle in degrees]"),
    ("A14 eccentricity count", CHAIN, {"rotor.eccentricity": [1e-5] * 3}, "", "list of 2, one entry per coordinate"),
    ("A14 eccentricity of matrices", MATRICES, {"rotor.eccentricity": 1e-5}, "", "list of 2"),
    ("A15 duration zero", LAVAL, {"drive.duration": 0.0}, "", "> 0"),
    ("A15 duration negative", LAVAL, {"drive.duration": -1}, "", "> 0"),
    ("A16 duration 1e12", LAVAL, {"drive.duration": 1e12}, "", "<= 1e+08 s"),
    ("A16 clock too coarse", LAVAL, {"drive.duration": 9e7, "contact.stiffness": 1e18}, "drive.duration", "resolves"),
    ("A17 rtol zero", LAVAL, {"solver.rtol": 0}, "", ">= 1e-13 and <= 0.1"),
    ("A17 rtol small", LAVAL, {"solver.rtol": 1e-14}, "", ">= 1e-13 and <= 0.1"),
    ("A17 rtol large", LAVAL, {"solver.rtol": 0.2}, "", ">= 1e-13 and <= 0.1"),
    ("A17 steps", LAVAL, {"solver.max_steps": 0}, "", "a whole number from 1"),
    ("A17 steps fraction", LAVAL, {"solver.max_steps": 1.5}, "", "a whole number from 1"),
    ("A17 divergence", LAVAL, {"solver.divergence": 1.0}, "", "> 1"),
    ("A17 method", LAVAL, {"solver.method": "rk54"}, "", 'did you mean "rk45"'),
    ("A17 method that is gone", LAVAL, {"solver.method": "verner76"}, "", 'it no longer exists; use "taylor8"'),
    ("A17 method number", LAVAL, {"solver.method": 45}, "", "rk45"),
    ("A20 rate zero", LAVAL, {"output.rate": 0}, "", "> 0 Hz"),
    ("A20 rate negative", LAVAL, {"output.rate": -10}, "", "> 0 Hz"),
    ("velocities no flag", LAVAL, {"output.velocities": 1}, "", "true or false"),
    ("A20 rate below four per turn", LAVAL, {"output.rate": 399.0}, "", ">= 400 Hz"),
    ("A22 equal times", LAVAL, {"drive": {"schedule": [[0, 1], [1, 2], [1, 3]]}}, "drive.schedule[2][0]", "later than"),
    ("A23 falling times", LAVAL, {"drive": {"schedule": [[0, 1], [2, 2], [1, 3]]}}, "drive.schedule[2][0]", "increase"),
    ("A23 first time", LAVAL, {"drive": {"schedule": [[1, 1], [2, 2]]}}, "drive.schedule[0][0]", "time 0"),
    ("A23 one corner", LAVAL, {"drive": {"schedule": [[0, 1]]}}, "drive.schedule", "at least two"),
    ("A23 corner of three", LAVAL, {"drive": {"schedule": [[0, 1, 2], [1, 2]]}}, "drive.schedule[0]", "[time in s"),
    ("A24 speed nan", LAVAL, {"drive": {"schedule": [[0, 1], [1, math.nan]]}}, "drive.schedule[1][1]", "finite"),
    ("A24 speed nan", LAVAL, {"drive.speed": [1.0, math.nan]}, "drive.speed[1]", "finite"),
    ("A24 three speeds", LAVAL, {"drive.speed": [1.0, 2.0, 3.0]}, "", "[first, last]"),
    ("A25 diameter zero", LAVAL, {"contact.diameter": 0.0}, "", "> 0 m"),
    ("A25 slip without diameter", LAVAL, {"contact.slip_velocity": 1e-3}, "", "contact.diameter"),
    (
        "A25 standstill has no slip scale",
        LAVAL,
        {"contact.diameter": 0.1, "drive.speed": 0.0},
        "contact.slip_velocity",
        "stands still",
    ),
    ("A26 comma", LAVAL, {"contact.gap": "1,5e-3"}, "", "comma"),
    ("A26 hexadecimal", LAVAL, {"contact.gap": "0x10"}, "", "a number in m"),
    ("A26 true as number", LAVAL, {"contact.gap": True}, "", "a number in m"),
    ("A26 number as text", LAVAL, {"contact.gap": "1e-3"}, "", "without quotes"),
    ("A26 wrong unit", LAVAL, {"contact.gap": "1 kg"}, "", "another kind of unit"),
    ("A26 tab in a unit", LAVAL, {"contact.gap": "1 m\tg"}, "", '"m\\tg" is another kind of unit'),
    ("A26 unknown unit", LAVAL, {"drive.duration": "3 fortnits"}, "", 'unknown unit "fortnits"'),
    ("A26 number as flag", LAVAL, {"rotor.allow_negative_damping": 1}, "", "true or false"),
    ("A26 true as count", LAVAL, {"solver.max_steps": True}, "", "whole number"),
    ("A26 list as number", LAVAL, {"rotor.mass": [1.0]}, "", "a number in kg"),
    ("A26 table as number", LAVAL, {"rotor.mass": {}}, "", "a number in kg"),
    ("A26 number as list", CHAIN, {"rotor.masses": 1.0}, "", "a list"),
    ("A26 text as matrix entry", MATRICES, {"stator.stiffness": [["1 kN/m"]]}, "stator.stiffness[0][0]", "number"),
    ("A27 huge integer", LAVAL, {"rotor.mass": 10**400}, "", "too large"),
    ("A27 endless integer", LAVAL, {"rotor.mass": 10**5000}, "", "too large"),
    ("A27 endless count", LAVAL, {"solver.max_steps": 10**5000}, "", "whole number"),
    ("A28 state too long", LAVAL, {"start.rotor": [[0, 0], [0, 0]]}, "", "list of 1, one entry per coordinate"),
    ("A28 state not pairs", LAVAL, {"start.rotor": [0.0]}, "start.rotor[0]", "pair [y, z]"),
    ("A28 state of a wall", LAVAL, {"stator": {"model": "rigid"}, "start.stator": [[0, 0]]}, "start.stator", "rigid"),
    ("A28 load too long", CHAIN, {"rotor.load": [[0, 1]]}, "", "list of 2"),
    ("A29 start inside the wall", LAVAL, {"start.rotor": [[1.2e-3, 0.0]]}, "", "allow_penetration"),
    ("A29 ring inside the wall", LAVAL, {"contact.ring_eccentricity": 1.2e-3}, "start.rotor", "allow_penetration"),
    ("A30 not square", MATRICES, {"rotor.mass": [[1.0, 0.0]]}, "", "square"),
    ("A30 ragged", MATRICES, {"rotor.mass": [[1.0, 0.0], [0.0]]}, "", "square"),
    ("A30 flat", MATRICES, {"rotor.mass": [1.0, 0.0]}, "", "square"),
    ("A30 empty", MATRICES, {"rotor.mass": []}, "", "square"),
    ("A30 other size", MATRICES, {"rotor.stiffness": [[1.0]]}, "", "2 x 2"),
    ("A30 disk 3 x 3", DISK, {"rotor.stiffness": np.eye(3).tolist()}, "", "2 x 2"),
    ("A30 not symmetric", MATRICES, {"rotor.stiffness": [[1.0, 0.1], [0.2, 1.0]]}, "", "[0][1] and [1][0] differ"),
    ("A30 gyroscopic not symmetric", MATRICES, {"rotor.gyroscopic": [[0.0, 1.0], [-1.0, 0.0]]}, "", "symmetric"),
    ("A30 disk not symmetric", DISK, {"rotor.stiffness": [[9.0, 0.1], [0.2, 1.0]]}, "", "symmetric"),
    ("A30 singular mass", MATRICES, {"rotor.mass": [[1.0, 1.0], [1.0, 1.0]]}, "", "positive definite"),
    ("A30 massless coordinate", MATRICES, {"rotor.mass": [[1.0, 0.0], [0.0, 0.0]]}, "", "positive definite"),
    ("A30 indefinite mass", MATRICES, {"rotor.mass": [[1.0, 2.0], [2.0, 1.0]]}, "", "positive definite"),
    ("A30 loose stator", MATRICES, {"stator.stiffness": [[0.0]]}, "", "the stator must be supported"),
    ("A30 loose mass", LAVAL, {"stator": {"model": "laval", "mass": 1, "stiffness": 0}}, "stator.stiffness", "supported"),
    ("A30 loose chain stator", CHAIN, {"stator.stiffnesses": [0.0, 1e5, 0.0]}, "", "the stator must be supported"),
    (
        "A30 broken chain stator",
        CHAIN,
        {"stator.masses": [1, 1, 1], "stator.stiffnesses": [1, 0, 0, 1]},
        "stator.stiffnesses",
        "supported",
    ),
    ("A30 springs of a chain", CHAIN, {"rotor.stiffnesses": [1e4, 1e4]}, "", "a list of 3 numbers for 2 masses"),
    ("A30 dashpots of a chain", CHAIN, {"rotor.dampings": [1.0]}, "", "a list of 3 numbers for 2 masses"),
    ("A30 no masses", CHAIN, {"rotor.masses": []}, "", "1 to 1000 masses"),
    ("A30 too many masses", CHAIN, {"rotor.masses": [1.0] * 1002}, "", "at most"),
    ("A30 polar inertia", DISK, {"rotor.polar_inertia": 0.03}, "", "thin disk"),
    ("A31 rotor coordinate", CHAIN, {"contact.rotor_coordinate": 2}, "", "from 0 to 1"),
    ("A31 stator coordinate", LAVAL, {"contact.stator_coordinate": 1}, "", "from 0 to 0"),
    ("A31 negative coordinate", CHAIN, {"contact.rotor_coordinate": -1}, "", "from 0"),
    ("A31 contact at a tilt", DISK, {"contact.rotor_coordinate": 1}, "", "is a tilt"),
    ("A31 tilt that is not there", MATRICES, {"rotor.tilt_coordinates": [2]}, "", "from 0 to 1"),
    ("A31 same tilt twice", MATRICES, {"rotor.tilt_coordinates": [1, 1]}, "", "different"),
    ("A32 percentage", LAVAL, {"rotor.damping_ratio": 5}, "", "5 % is 0.05"),
    ("A32 percentage", LAVAL, {"contact.damping": GONE, "contact.damping_ratio": 5.0}, "contact.damping_ratio", "0.05"),
    ("B42 unknown key", LAVAL, {"contact.stifness": 1.0}, "", 'did you mean "stiffness"'),
    ("B42 unknown table", LAVAL, {"contract": {}}, "", 'did you mean "contact"'),
    ("B42 model of a table without", LAVAL, {"contact.model": "laval"}, "", "a key of [contact]"),
    ("B42 unknown model", LAVAL, {"rotor.model": "lavall"}, "", 'did you mean "laval"'),
    ("B42 rigid rotor", LAVAL, {"rotor.model": "rigid"}, "", '"laval", "disk", "chain", "matrices"'),
    ("B42 key of another model", LAVAL, {"rotor.masses": [1.0]}, "", 'did you mean "mass"? As it is, a key of model chain'),
    ("B42 key with a line break", LAVAL, {"contact.a\nb": 1}, "contact.a\\nb", "a key of [contact]"),
    ("B43 missing key", LAVAL, {"rotor.mass": GONE}, "", "(missing)"),
    ("B43 missing one of two", LAVAL, {"rotor.stiffness": GONE}, "rotor.frequency", "stiffness"),
    ("B43 missing model", LAVAL, {"rotor.model": GONE}, "", "(missing)"),
    ("B43 missing table", LAVAL, {"stator": GONE}, "", "rigid"),
    ("B43 missing speed", LAVAL, {"drive.speed": GONE}, "", "schedule"),
    ("B43 missing duration", LAVAL, {"drive.duration": GONE}, "", "schedule"),
    ("B44 wrong table", LAVAL, {"rotor.gap": 1e-3}, "", "it belongs to [contact]"),
    ("B44 no table", LAVAL, {"gap": 1e-3}, "", "it belongs to [contact]"),
    ("B44 value for a table", LAVAL, {"contact": 1e-3}, "", "a table [contact]"),
    ("both of two", LAVAL, {"rotor.frequency": 30.0}, "rotor.stiffness", "left out when frequency is given"),
    ("both of two", LAVAL, {"rotor.damping": 1.0}, "", "left out when damping_ratio is given"),
    ("both of two", LAVAL, {"rotor.gravity": 9.81, "rotor.load": [[0, 1]]}, "rotor.load", "exclude"),
    ("both of two", LAVAL, {"drive.schedule": [[0, 1], [1, 2]]}, "drive.schedule", "left out when speed is given"),
    ("both of two", LAVAL, {"start": {"rest": True, "whirl": "backward"}}, "start.whirl", "left out when rest"),
    ("both of two", LAVAL, {"start": {"whirl": 3, "stator": [[0, 0]]}}, "start.stator", "left out when whirl"),
    ("renamed", LAVAL, {"start": {"rest": True, "knock": [1.0, 0.0]}}, "start.knock", "it is called impulse"),
    ("rest is no answer", LAVAL, {"start.rest": False}, "", "true or left out"),
    ("unknown whirl", LAVAL, {"start.whirl": "forward"}, "", '"backward" or a frequency'),
    ("gravity negative", LAVAL, {"rotor.gravity": -9.81}, "", "along -z"),
    ("title number", LAVAL, {"title": 5}, "", "a text"),
    ("title long", LAVAL, {"title": "x" * 1001}, "", "1000 characters"),
    ("title broken", LAVAL, {"title": "\ud800"}, "", "a text"),
]


def refusal(action):
    """The SceneError of an action; its message is one line, and printable."""
    with pytest.raises(SceneError) as caught:
        action()
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    assert len(message) < 1000
    assert "must be" in message
    return caught.value, message


def test_the_unchanged_scenes_are_good():
    for base in (LAVAL, DISK, CHAIN, MATRICES):
        Scene.from_dict(base)


@pytest.mark.parametrize(("base", "changes", "key", "part"), [row[1:] for row in BAD], ids=[row[0] for row in BAD])
def test_a_bad_scene_is_refused_in_one_line(base, changes, key, part):
    error, message = refusal(lambda: Scene.from_dict(changed(base, changes), source="bad.toml"))
    key = key or next(iter(changes))
    assert error.file == "bad.toml"
    assert error.key == key
    assert message.startswith(f"bad.toml: {key} = ")
    assert part in message


GOOD = [
    ("negative damping that is meant", LAVAL, {"rotor.damping_ratio": -0.01, "rotor.allow_negative_damping": True}),
    ("negative speed", LAVAL, {"drive.speed": [-50.0, 50.0]}),
    ("standstill", LAVAL, {"drive.speed": 0}),
    ("friction 5", LAVAL, {"contact.friction": 5}),
    ("no friction", LAVAL, {"contact.friction": 0}),
    ("free rotor", LAVAL, {"rotor.stiffness": 0.0}),
    ("light touch at the start", LAVAL, {"start.rotor": [[1.1e-3, 0.0]]}),
    ("penetration that is meant", LAVAL, {"start.rotor": [[2e-3, 0.0]], "start.allow_penetration": True}),
    ("large count as float", LAVAL, {"solver.max_steps": 1e9}),
    ("thin disk", DISK, {"rotor.polar_inertia": 0.02}),
    ("rounding asymmetry", MATRICES, {"rotor.stiffness": [[2e4, -1e4], [-1e4 * (1 + 1e-12), 1e4]]}),
    ("free matrices", MATRICES, {"rotor.stiffness": [[1e4, -1e4], [-1e4, 1e4]]}),
    ("chain stator held at one end", CHAIN, {"stator.stiffnesses": [0.0, 1e5, 1e5]}),
    ("numpy values", MATRICES, {"rotor.mass": np.eye(2), "contact.gap": np.float32(0.5)}),
    ("numpy integers", CHAIN, {"rotor.masses": np.array([1, 2]), "solver.max_steps": np.int64(5)}),
]


@pytest.mark.parametrize(("base", "changes"), [row[1:] for row in GOOD], ids=[row[0] for row in GOOD])
def test_what_is_unusual_but_right_is_accepted(base, changes):
    scene = Scene.from_dict(changed(base, changes))
    assert Scene.from_dict(scene.to_dict()) == scene


@pytest.mark.parametrize("content", [None, 5, [], "x", [("rotor", {})]])
def test_what_is_no_mapping_is_refused(content):
    refusal(lambda: Scene.from_dict(content))


def test_values_that_cannot_be_printed_do_not_break_the_message():
    deep = []
    for _ in range(100_000):
        deep = [deep]
    for key in ("rotor.mass", "rotor.unknown", "drive.speed", "start.rotor", "title", "unknown"):
        refusal(lambda key=key: Scene.from_dict(changed(LAVAL, {key: deep})))
    while deep:  # taking it apart level by level keeps the interpreter's own recursion out of it
        deep = deep[0]


GOOD_TEXT = template("laval")
FILES = [
    ("B36 empty", b"", "the file is empty"),
    ("B36 blank", b"\xef\xbb\xbf \r\n\n", "the file is empty"),
    ("B36 only a comment", b"# nothing\n", "[rotor]"),
    ("B37 too large", b"#" * 1_000_001, "at most 1 MB"),
    ("B38 not UTF-8", GOOD_TEXT.encode() + b"# gr\xf6\xdfe\n", "UTF-8"),
    ("B38 UTF-16 cut off", GOOD_TEXT.encode("utf-16")[:301], "UTF-8"),
    ("B40 syntax error", b"title = 'x'\n[rotor\nmass = 1\n", "line 2, column 7 = '[rotor'"),
    ("B40 no value", b"[rotor]\nmass =\n", "line 2, column 7 = 'mass ='"),
    ("B40 bare text", b"[rotor]\nmass = abc\n", "line 2, column 8"),
    ("B40 binary", bytes(range(1, 32)) * 10, "valid TOML"),
    ("B40 path with backslashes", b'[rotor]\nmatrices = "C:\\models\\k.mtx"\n', "write paths with / or in single quotes"),
    ("B40 open string", b'title = "abc\n', "line 1"),
    ("B40 open list", b"a = [1,\n2,\n", "valid TOML"),
    ("B41 duplicate key", b"[rotor]\nmass = 1\nmass = 2\n", "line 3, column 9 = 'mass = 2': must be valid TOML"),
    ("B41 duplicate table", b"[rotor]\n[stator]\n[rotor]\n", "given twice"),
    ("B46 nested lists", b"a = " + b"[" * 10_000 + b"]" * 10_000, "nested too deep"),
    ("B46 nested tables", b"x = " + b"{a = " * 10_000, "nested too deep"),
    ("B46 dotted keys", b"a." * 10_000 + b"b = 1", "nested too deep"),
    ("B46 dotted table", b"[" + b"a." * 400_000 + b"b]", "nested too deep"),
    ("A27 5000 digits", b"[rotor]\nmass = " + b"1" * 5000, "digits"),
    ("B47 nan", GOOD_TEXT.replace("mass = 1.0", "mass = nan").encode(), "rotor.mass = nan"),
    ("B47 inf", GOOD_TEXT.replace("mass = 1.0", "mass = -inf").encode(), "rotor.mass = -inf"),
    ("A26 date", GOOD_TEXT.replace("mass = 1.0", "mass = 2024-01-01").encode(), "rotor.mass"),
]


@pytest.mark.parametrize(("content", "part"), [row[1:] for row in FILES], ids=[row[0] for row in FILES])
def test_a_bad_file_is_refused_in_one_line(tmp_path, content, part):
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    error, message = refusal(lambda: load_scene(path))
    assert error.file == str(path)
    assert message.startswith(f"{path}: ")
    assert part in message


def test_duplicate_key_says_so(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text("[rotor]\nmass = 1\nmass = 2\n")
    assert "given twice" in refusal(lambda: load_scene(path))[1]


def test_missing_file_folder_and_odd_names_are_refused(tmp_path):
    assert MISSING in refusal(lambda: load_scene(tmp_path / "missing.toml"))[1]
    assert "directory" in refusal(lambda: load_scene(tmp_path))[1]
    assert "null" in refusal(lambda: load_scene("a\0b.toml"))[1]
    refusal(lambda: load_scene(tmp_path / "a\nb.toml"))
    refusal(lambda: load_scene(tmp_path / ("x" * 300)))
    refusal(lambda: load_scene(""))


@pytest.mark.posix
def test_an_endless_file_is_refused():
    assert "at most 1 MB" in refusal(lambda: load_scene("/dev/zero"))[1]


def test_a_file_without_read_right_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "secret.toml"
    path.write_text(GOOD_TEXT)
    path.chmod(0)
    if os.access(path, os.R_OK):  # the administrator may read anything

        def denied(*args, **kwargs):
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr("builtins.open", denied)
    assert "permission denied" in refusal(lambda: load_scene(path))[1]


def test_refusing_leaves_files_alone(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text("x = 1\n")
    refusal(lambda: load_scene(path))
    assert [item.name for item in tmp_path.iterdir()] == ["bad.toml"]
    assert path.read_text() == "x = 1\n"


ANYTHING = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["1 mm", "5 kg", "3000 rpm", "file.npz", "backward", "rk45", 10**400]),
    st.lists(st.floats(-2.0, 2.0), max_size=4),
    st.lists(st.lists(st.floats(-2.0, 2.0), max_size=3), max_size=3),
    st.dictionaries(st.text(max_size=3), st.floats(), max_size=2),
)


@settings(max_examples=300, deadline=None)
@given(base=st.sampled_from([LAVAL, DISK, CHAIN, MATRICES]), key=st.sampled_from(all_keys()), value=ANYTHING)
def test_any_value_for_any_key_is_accepted_or_refused_in_one_line(base, key, value):
    try:
        scene = Scene.from_dict(changed(base, {key: value}), source="bad.toml")
    except SceneError as error:
        assert str(error).startswith("bad.toml: ")
        assert len(str(error).splitlines()) == 1
    else:
        assert Scene.from_dict(tomllib.loads(scene.to_toml())) == scene


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    position=st.integers(0, len(GOOD_TEXT) - 1),
    length=st.integers(0, 40),
    insert=st.one_of(st.binary(max_size=5), st.sampled_from([b"[", b"[[", b"= 1e999", b'"', b"\n[rotor]\n", b"{a="])),
)
def test_any_damage_to_a_file_is_accepted_or_refused_in_one_line(tmp_path, position, length, insert):
    path = tmp_path / "damaged.toml"
    path.write_bytes(GOOD_TEXT[:position].encode() + insert + GOOD_TEXT[position + length :].encode())
    try:
        load_scene(path)
    except SceneError as error:
        assert len(str(error).splitlines()) == 1
