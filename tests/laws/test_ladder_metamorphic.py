"""Verification ladder, V8 and V9: what must not change, to the last bit or within the tolerance, in a scene written differently.

Bitwise (V8): units of length, mass and time that are powers of two, the mirror z -> -z, turns by 90 degrees
(tests/unit/simulation/test_simulate.py) and 180 degrees. What the scene format cannot express: the mirror of the one-sided
friction law (it slides forward whatever the sign of the speed, and a negative friction is refused); so the mirror is done with
Coulomb friction and without friction. Within the tolerance (V9): any turn, any factor of length, other coordinates of the same
rotor.
"""

import copy

import numpy as np
import pytest

import rsc
from figures import met
from scenes import LAVAL, SCENES, changed

GAP = 1e-3
NAMES = ["whirl, unbalance, run-up", "bouncing", "Coulomb friction that reverses", "eccentric ring", "gravity, run-down"]
# key -> exponents (length, mass, time) of its unit
UNITS = {
    "mass": (0, 1, 0), "frequency": (0, 0, -1), "stiffness": (0, 1, -2), "damping": (0, 1, -1), "eccentricity": (1, 0, 0),
    "gravity": (1, 0, -2), "gap": (1, 0, 0), "diameter": (1, 0, 0), "ring_eccentricity": (1, 0, 0), "slip_velocity": (1, 0, -1),
    "speed": (0, 0, -1), "duration": (0, 0, 1), "rotor": (1, 0, 0), "stator": (1, 0, 0), "rotor_velocity": (1, 0, -1),
    "stator_velocity": (1, 0, -1), "rate": (0, 0, -1),
}  # fmt: skip
UNITLESS = {"model", "friction", "damping_ratio", "allow_penetration", "rest", "rtol"}


def explicit(name, rtol=1e-7):
    """A scene with every default that has a unit written down."""
    tables = changed(SCENES[name], output={"rate": 4096.0}, solver={"rtol": rtol})
    if "slip_velocity" not in tables["contact"] and "diameter" in tables["contact"]:
        raise AssertionError("the slip velocity must be given")
    return tables


def simulated(tables):
    result = rsc.simulate(rsc.Scene.from_dict(tables))
    assert result.status == "finished"
    return result


def _times(value, factor):
    return [_times(v, factor) for v in value] if isinstance(value, list) else value * factor


def in_units(tables, length=1.0, mass=1.0, time=1.0):
    """The same scene with other units of length, mass and time (every number times its factor; an angle stays)."""
    new = copy.deepcopy(tables)
    for table in new.values():
        for key in table if isinstance(table, dict) else ():
            if key in UNITLESS:
                continue
            powers = UNITS[key]  # a key without an entry is a defect of this test
            factor = length ** powers[0] * mass ** powers[1] * time ** powers[2]
            if "eccentricity" in key and isinstance(table[key], list):
                table[key] = [table[key][0] * factor, table[key][1]]
            else:
                table[key] = _times(table[key], factor)
    return new


# ---- V8


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("units", [{"length": 2.0**7}, {"length": 2.0**-9}, {"mass": 2.0**5}, {"mass": 2.0**-6}, {"time": 2.0**3},
                                   {"time": 2.0**-4}, {"length": 2.0**3, "mass": 2.0**-2, "time": 2.0**-1}], ids=str)  # fmt: skip
def test_v8_units_that_are_powers_of_two_change_no_bit(name, units):
    tables = explicit(name)
    result, again = simulated(tables), simulated(in_units(tables, **units))
    length, mass, time = (units.get(key, 1.0) for key in ("length", "mass", "time"))
    assert result.summary.switches >= 8
    assert np.array_equal(again.rotor, result.rotor * length)
    assert np.array_equal(again.stator, result.stator * length)
    assert np.array_equal(again.normal_force, result.normal_force * (mass * length / time**2))
    assert np.array_equal(again.friction_force, result.friction_force * (mass * length / time**2))
    assert np.array_equal(again.tangential_velocity, result.tangential_velocity * (length / time))
    energy = mass * length**2 / time**2
    for part in ("energy_in", "friction_in", "rotor_damping", "stator_damping", "contact_damping"):
        assert getattr(again.ledger, part) == getattr(result.ledger, part) * energy
    assert (again.steps, again.rejected, again.summary.switches) == (result.steps, result.rejected, result.summary.switches)


def mirrored(tables):
    """z -> -z: every vector conjugated, the shaft turning the other way."""
    new = copy.deepcopy(tables)
    for key, value in new["start"].items():
        if isinstance(value, list):
            new["start"][key] = [[y, -z] for y, z in value]
    for table, key in (("rotor", "eccentricity"), ("contact", "ring_eccentricity")):
        if isinstance(new[table].get(key), list):
            new[table][key] = [new[table][key][0], -new[table][key][1]]
    speed = new["drive"]["speed"]
    new["drive"]["speed"] = [-s for s in speed] if isinstance(speed, list) else -speed
    return new


def coulomb(tables):
    return changed(tables, contact={"diameter": 0.02, "slip_velocity": 0.05})


@pytest.mark.parametrize(
    "tables",
    [
        explicit("Coulomb friction that reverses"),
        coulomb(explicit("whirl, unbalance, run-up")),
        coulomb(explicit("eccentric ring")),
        changed(explicit("bouncing"), contact={"friction": 0.0}),
        coulomb(explicit("gyroscopic disk")),
    ],
    ids=["Coulomb that reverses", "whirl", "eccentric ring", "no friction", "gyroscopic disk"],
)
def test_v8_the_mirror_image_is_the_mirror_image(tables):
    if tables["rotor"]["model"] == "disk":  # angles of 30 and 200 degrees are no exact mirror images
        tables = changed(tables, rotor={**tables["rotor"], "eccentricity": [5e-5, 0.0], "angular_eccentricity": [1e-3, 0.0]})
    if "ring_eccentricity" in tables["contact"]:
        tables = changed(tables, contact={"ring_eccentricity": [2e-4, 0.0]})
    result, again = simulated(tables), simulated(mirrored(tables))
    assert result.summary.switches >= 8 and np.abs(result.rotor.imag).max() > 0.1 * GAP
    assert np.array_equal(again.rotor, result.rotor.conj())
    assert np.array_equal(again.stator, result.stator.conj())
    assert np.array_equal(again.friction_force, -result.friction_force)
    assert np.array_equal(again.tangential_velocity, -result.tangential_velocity)


@pytest.mark.parametrize("name", ["Coulomb friction that reverses", "eccentric ring", "chains"])
def test_v8_half_a_turn_changes_no_bit(name):
    """Every vector times -1 (the 90 degrees of tests/unit/simulation/test_simulate.py do not reach these scenes)."""
    tables = explicit(name)
    new = copy.deepcopy(tables)
    for key, value in new["start"].items():
        if isinstance(value, list):
            new["start"][key] = [[-y, -z] for y, z in value]
    if name == "eccentric ring":
        for table, key in (("rotor", "eccentricity"), ("contact", "ring_eccentricity")):
            amount = new[table][key]
            tables[table][key] = amount if isinstance(amount, list) else [amount, 0.0]
            tables[table][key][1] = 0.0
            new[table][key] = [tables[table][key][0], 180.0]
    elif name == "chains":
        new["rotor"]["eccentricity"] = [[e, 180.0] for e in new["rotor"]["eccentricity"]]
    else:
        new["rotor"]["eccentricity"] = [new["rotor"]["eccentricity"], 180.0]
    result, again = simulated(tables), simulated(new)
    assert result.summary.switches >= 8
    assert np.array_equal(again.rotor, -result.rotor) and np.array_equal(again.stator, -result.stator)


# ---- V9

SOFT = 1e-9


def soft(what, result, other):
    """The same motion within rtol (the first goal allowed 100); both arrays complex m."""
    met("V9", f"{what}: difference / (rtol gap)", np.abs(result - other).max() / GAP / SOFT, 1.0)


def turned(tables, angle):
    """Every vector turned by an angle in degrees."""
    new, turn = copy.deepcopy(tables), np.exp(1j * np.radians(angle))
    for key, value in new["start"].items():
        if isinstance(value, list):
            new["start"][key] = [[(complex(*p) * turn).real, (complex(*p) * turn).imag] for p in value]
    new["rotor"]["eccentricity"] = [new["rotor"]["eccentricity"], angle]
    return new


@pytest.mark.parametrize("name", NAMES[:3])
def test_v9_any_turn_of_the_frame(name):
    tables = explicit(name, SOFT)
    for angle in (37.0, -118.5):
        result, again = simulated(tables), simulated(turned(tables, angle))
        soft(f"turn by {angle} degrees", again.rotor * np.exp(-1j * np.radians(angle)), result.rotor)


@pytest.mark.parametrize("name", NAMES)
def test_v9_lengths_times_three(name):
    tables = explicit(name, SOFT)
    result, again = simulated(tables), simulated(in_units(tables, length=3.0))
    soft("lengths x 3", again.rotor / 3.0, result.rotor)


def matrices(order):
    """Three coupled masses with a gyroscopic term as matrices, coordinates in a given order; the middle one touches the wall."""
    full = {
        "mass": [[1.0, 0.1, 0.0], [0.1, 2.0, 0.0], [0.0, 0.0, 1.5]],
        "damping": [[8.0, -2.0, 0.0], [-2.0, 9.0, 0.0], [0.0, 0.0, 5.0]],
        "stiffness": [[5e4, -2e4, 0.0], [-2e4, 6e4, -4e4], [0.0, -4e4, 5e4]],
        "gyroscopic": np.diag([0.3, 0.0, 0.4]).tolist(),
    }
    rotor = {name: np.array(rows)[np.ix_(order, order)].tolist() for name, rows in full.items()}
    start = {name: np.array(SCENES["chains"]["start"][name]) for name in ("rotor", "rotor_velocity")}
    return {
        **changed(SCENES["chains"], output={"rate": 4096.0}, solver={"rtol": SOFT}),
        "rotor": {"model": "matrices", **rotor, "eccentricity": list(np.array([5e-5, 1e-5, 2e-5])[order])}
        | {"tilt_coordinates": sorted(order.index(i) for i in (0, 2))},
        "contact": {**SCENES["chains"]["contact"], "rotor_coordinate": order.index(1)},
        "start": {name: values[order].tolist() for name, values in start.items()},
    }


@pytest.mark.nightly
def test_v9_order_of_the_coordinates():
    result = simulated(matrices([0, 1, 2]))
    assert result.summary.switches >= 8
    for order in ([2, 0, 1], [1, 2, 0]):
        again = simulated(matrices(order))
        soft("permuted coordinates", again.rotor, result.rotor[:, order])


def test_v9_coordinates_that_touch_nothing():
    """Two more masses of a chain, tied to the first by nothing: the motion of the first is the Laval rotor's."""
    tables = explicit("bouncing", SOFT)
    omega = 2 * np.pi * 30.0
    rotor = {
        "model": "matrices",
        "mass": np.diag([1.0, 0.5, 2.0]).tolist(),
        "stiffness": [[omega**2, 0, 0], [0, 9e4, -2e4], [0, -2e4, 5e4]],
        "damping": np.diag([2 * 0.02 * omega, 3.0, 1.0]).tolist(),
        "eccentricity": [6e-4, 1e-5, 0.0],
    }
    start = {name: [*rows, [2e-4, 0.0], [0.0, -3e-4]] for name, rows in tables["start"].items()}
    result, again = simulated(tables), simulated(changed(tables, rotor=rotor, start=start))
    assert np.abs(again.rotor[:, 1:]).max() > 0.1 * GAP
    soft("decoupled coordinates added", again.rotor[:, 0], result.rotor[:, 0])


def test_v9_a_spring_and_a_damper_split_in_two():
    """One mass between two walls, shares 0.3 and 0.7; and the stator's likewise."""
    tables = explicit("bouncing", SOFT)
    k_r, k_s = (2 * np.pi * 30.0) ** 2, 0.25 * (2 * np.pi * 150.0) ** 2
    c_r, c_s = 2 * 0.02 * np.sqrt(k_r), 2 * 0.1 * np.sqrt(k_s * 0.25)
    rotor = {"model": "chain", "masses": [1.0], "stiffnesses": [0.3 * k_r, 0.7 * k_r], "dampings": [0.3 * c_r, 0.7 * c_r],
             "eccentricity": [6e-4]}  # fmt: skip
    stator = {"model": "chain", "masses": [0.25], "stiffnesses": [0.7 * k_s, 0.3 * k_s], "dampings": [0.7 * c_s, 0.3 * c_s]}
    result, again = simulated(tables), simulated(changed(tables, rotor=rotor, stator=stator))
    soft("springs and dampers split", again.rotor, result.rotor)


def test_every_scene_used_here_is_written_out():
    """A default with a unit that the scenes leave to rsc would stay behind when the units change."""
    for name in NAMES:
        tables = explicit(name)
        assert {"gap", "stiffness", "friction"} <= set(tables["contact"])
        assert "rate" in tables["output"] and "speed" in tables["drive"]
    assert LAVAL["contact"]["damping_ratio"]  # worked out from masses and stiffness: exact for even powers of two of k m
