"""Shafts and machines in magnetic bearings: the closed loop of all their coordinates by a program of its own, and limits."""

import numpy as np
import pytest

import rsc
from levitated_machine import FullLoop
from rsc.analysis.alone.free_vibration import free_vibrations
from rsc.analysis.alone.modes import controlled_frequencies
from rsc.analysis.paper.receptance import receptance_rotor, receptance_stator
from rsc.errors import SceneError
from rsc.machine.imports.store import save_model
from rsc.scene.scene import Scene
from rsc.show.words.machine import machine_tables
from rsc.study.motions.settle import Settling
from rsc.study.prediction.predictions import predictions
from rsc.study.run.levitation import levitation_remarks
from rsc.system.assemble import assemble
from scenes import changed

TWO_PI = 2.0 * np.pi
KEYS = {"negative_stiffness": 4e5, "proportional": 2e6, "integral": 1e7, "derivative": 1.2e3, "derivative_filter": 2e4,
        "amplifier": 1500.0}  # fmt: skip
OTHER = {**KEYS, "proportional": 2.5e6, "derivative": 1.5e3}
PLACES = ((0.1, 0.05), (0.8, 0.85))  # m, of actuator and sensor of each bearing: a sensor is not where its actuator is
SPEED, GAP = 40.0, 2.5e-4


def levitated(**tables):
    """A shaft with an overhung disk in two magnetic bearings, and an auxiliary bearing beside the first one."""
    content = {
        "rotor": {
            "model": "shaft", "elements": 2, "sections": [{"length": 0.9, "diameter": 0.05}], "rayleigh": [0.0, 2e-5],
            "disks": [{"at": 0.5, "diameter": 0.3, "width": 0.03}, {"at": 0.9, "diameter": 0.2, "width": 0.02}],
            "magnetic_bearings": [
                {"name": name, "at": at, "sensor_at": sensor, **keys}
                for name, (at, sensor), keys in zip(("front", "rear"), PLACES, (KEYS, OTHER), strict=True)
            ],
            "unbalance": [{"at": 0.5, "amount": 2e-4}], "observers": [0.5], "gravity": 9.81,
        },
        "stator": {"model": "laval", "mass": 4.0, "frequency": 130.0, "damping_ratio": 0.1},
        "contact": {"at": 0.2, "gap": GAP, "stiffness": 5e7, "friction": 0.1},
        "drive": {"speed": SPEED, "duration": 0.05}, "start": {"rest": True}, "output": {"rate": 20000.0},
        "reduction": {"band": [-600.0, 600.0]},
    }  # fmt: skip
    return changed(content, **tables)


@pytest.fixture(scope="module")
def scene():
    return Scene.from_dict(levitated())


def row(model, place):
    """The row of the displacement at a position in m."""
    return model.row_at(min(model.position, key=lambda node: abs(model.position[node] - place)))


def full_loop(scene, speed=SPEED):
    model = scene.reductions[0].model
    bearings = [(row(model, at), row(model, sensor), keys) for (at, sensor), keys in zip(PLACES, (KEYS, OTHER), strict=True)]
    return FullLoop(model, bearings, speed)


def test_modes_are_those_of_the_full_closed_loop(scene):
    for speed in (0.0, SPEED):
        values = full_loop(scene, speed).eigenvalues()
        inside = values[np.abs(values) < TWO_PI * 450.0]
        vibrations = free_vibrations(assemble(scene), speed)
        own = np.array([each.growth_rate + 2j * np.pi * each.frequency for each in vibrations])
        assert len(inside) >= 8 and len(inside) == np.count_nonzero(np.abs(own) < TWO_PI * 450.0)
        for value in inside:
            assert abs(own - value).min() < 2.0 * scene.rotor.error * abs(value)


def test_the_stated_error_is_that_of_the_closed_loop(scene):
    system, loop = assemble(scene), full_loop(scene)
    Psi = TWO_PI * np.random.default_rng(5).uniform(-600.0, 600.0, 300)
    exact = loop.receptance(row(scene.reductions[0].model, 0.2), Psi)
    error = np.abs(receptance_rotor(system, Psi, loop.Omega) - exact)
    assert error.max() > 0.0
    assert (error / np.abs(exact)).max() < scene.rotor.error <= 1e-4
    stiffer = {f"rotor.magnetic_bearings[{i}].{key}": 2.0 * keys[key] for i, keys in enumerate((KEYS, OTHER))
               for key in ("proportional", "derivative")}  # fmt: skip
    changed_one = assemble(scene.with_values(stiffer))
    assert not np.allclose(receptance_rotor(changed_one, Psi, loop.Omega), exact, rtol=0.1)


def test_the_page_lists_the_magnetic_bearings_by_their_gains(scene):
    tables = {title: rows for title, _, rows in machine_tables(scene)}
    assert tables["Magnetic bearings"] == [
        ("front", "100", "4e+05", "2e+06", "1e+07", "1200", "1500", ""),
        ("rear", "800", "4e+05", "2.5e+06", "1e+07", "1500", "1500", "")
    ]  # fmt: skip
    with_table = levitated(rotor={"bearings": [{"at": 0.2, "stiffness": 1e6, "damping": 0.0, "off": 0.01}]})
    assert [title for title, _, _ in machine_tables(Scene.from_dict(with_table))][2:4] == ["Bearings", "Magnetic bearings"]


def test_whirls_are_those_of_a_scan_of_the_full_closed_loop(scene):
    system, loop, mu, k = assemble(scene), full_loop(scene), 0.1, 5e7
    at = row(scene.reductions[0].model, 0.2)

    def value(Psi):
        return (1.0 + 1j * mu) * (loop.receptance(at, Psi) + receptance_stator(system, np.atleast_1d(Psi)))

    grid = -TWO_PI * np.linspace(1.0, 600.0, 2500)
    values = value(grid)
    found = []
    for i in np.flatnonzero(values.imag[:-1] * values.imag[1:] < 0.0):
        low, high = grid[i], grid[i + 1]
        for _ in range(40):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if value(middle)[0].imag * value(low)[0].imag > 0.0 else (low, middle)
        force = -GAP / (value(low)[0].real + 1.0 / k)
        if force > 0.0 and abs(value(low)[0]) < 1e3 * np.abs(values).max():
            found.append((low / TWO_PI, force))
    whirls = [whirl for whirl in rsc.predict(scene) if -600.0 < whirl.frequency < 0.0]
    assert len(whirls) == len(found) >= 2
    for whirl, (frequency, force) in zip(sorted(whirls, key=lambda one: -one.frequency), found, strict=True):
        assert whirl.frequency == pytest.approx(frequency, rel=10.0 * scene.rotor.error)
        assert whirl.normal_force == pytest.approx(force, rel=1e-3)


def test_the_shift_of_a_whirl_is_told_for_the_closed_loop(scene):
    (told,) = predictions(scene, [SPEED])
    shifts = [line for line in told.remarks if "of the full model lies" in line]
    assert len(shifts) == sum(whirl.stable for whirl in told.whirls)
    assert all(abs(float(line.split("lies ")[1].split()[0])) < 1e-2 for line in shifts)


LIGHT = 10.0 * 0.25 * np.pi * 0.02**2 * 0.04  # kg of the short shaft, by which its disk is lighter
LIMIT = {
    "rotor": {
        "model": "shaft", "elements": 1, "unbalance": [], "rayleigh": [0.0, 1e-6],
        "sections": [{"length": 0.02, "diameter": 0.02, "material": {"density": 10.0, "youngs_modulus": 2.1e11}}] * 2,
        "disks": [{"at": 0.02, "mass": 5.0 - LIGHT, "polar_inertia": 1e-9, "diametral_inertia": 1.0}],
        "bearings": [{"at": 0.02, "stiffness": 0.0, "tilt_stiffness": 1e5, "tilt_damping": 10.0}],
    },
    "stator": {"model": "laval", "mass": 1.5, "frequency": 180.0, "damping_ratio": 0.1},
    "contact": {"at": 0.02, "gap": 0.25e-3, "stiffness": 2e7, "friction": 0.15},
    "drive": {"speed": 20.0, "duration": 0.3},
}  # fmt: skip
POINT = {"negative_stiffness": 5e4, "proportional": 3e5, "integral": 1e6, "derivative": 200.0, "derivative_filter": 1e4,
         "amplifier": 500.0}  # fmt: skip


def test_a_rigid_shaft_is_the_point_mass_of_two_other_programs():
    """Numbers of test_first_order_whirls."""
    whirls = rsc.predict(Scene.from_dict(changed(LIMIT, rotor={"magnetic_bearings": [{"at": 0.02, **POINT}]})))
    numbers = [(-306.0437, 894.5, 227.65), (-65.760132, 238.0309, -0.722), (-50.1344, 70.4, 13.56)]
    for whirl, (frequency, force, rate) in zip(whirls, numbers, strict=True):
        assert whirl.frequency == pytest.approx(frequency, rel=1e-6)
        assert whirl.normal_force == pytest.approx(force, rel=1e-3)
        assert whirl.growth_rate == pytest.approx(rate, rel=1e-3)
    light = {**POINT, "negative_stiffness": 2e4, "proportional": 9e4, "integral": 9e5}
    disks = [{**LIMIT["rotor"]["disks"][0], "mass": 1.0 - LIGHT}]
    rotor = {"magnetic_bearings": [{"at": 0.02, **light}], "disks": disks}
    vibrations = free_vibrations(assemble(Scene.from_dict(changed(LIMIT, rotor=rotor))), 20.0)
    slow = [each for each in vibrations if abs(each.frequency) < 1e3 and each.growth_rate > -1e5]
    wanted = [(-40.9215, -85.297), (40.9215, -85.297), (0.0, -10089.68), (0.0, -2868.005), (0.0, -13.315)]
    assert len(slow) == len(wanted)
    for frequency, rate in wanted:
        off = min(abs(complex(each.growth_rate - rate, TWO_PI * (each.frequency - frequency))) for each in slow)
        assert off < 1e-5 * abs(complex(rate, TWO_PI * frequency)) + 1e-3


def test_a_machine_from_a_file_and_matrices_of_states_are_the_same_rotor(scene, tmp_path):
    model, content = scene.reductions[0].model, levitated()
    save_model(model, tmp_path / "shaft.npz")
    nodes = {place: next(node for node in model.position if abs(model.position[node] - place) < 1e-9)
             for place in (0.05, 0.1, 0.2, 0.5, 0.8, 0.85)}  # fmt: skip
    bearings = [[nodes[at], {"sensor": nodes[sensor], **keys}] for (at, sensor), keys in zip(PLACES, (KEYS, OTHER), strict=True)]
    file = {"model": "machine", "file": str(tmp_path / "shaft.npz"), "contact": nodes[0.2]}
    rest = {"unbalance": [[nodes[0.5], 2e-4]], "gravity": 9.81, "observers": [nodes[0.5]]}
    contact = {key: value for key, value in content["contact"].items() if key != "at"}
    machine = Scene.from_dict({**content, "rotor": {**file, **rest, "magnetic_bearings": bearings}, "contact": contact})
    assert [mode.frequency for mode in rsc.modes(machine).rotor] == pytest.approx(
        [mode.frequency for mode in rsc.modes(scene).rotor], rel=1e-6, abs=1e-6
    )
    corner, lag = KEYS["derivative_filter"], TWO_PI * KEYS["amplifier"]
    by_a = -KEYS["derivative"] * corner
    states = {  # the second bearing without its negative stiffness, written out
        "matrix": [[-corner, 0.0, 0.0], [0.0, 0.0, 0.0], [lag * by_a, lag * KEYS["integral"], -lag]],
        "sensors": [0.85], "displacement": [[corner], [1.0], [lag * (KEYS["proportional"] - by_a)]],
        "actuators": [0.8], "force": [[0.0, 0.0, -1.0]],
    }  # fmt: skip
    last = {"at": 0.8, "sensor_at": 0.85, **KEYS, "negative_stiffness": 0.0}
    first = content["rotor"]["magnetic_bearings"][0]
    pair = [{"magnetic_bearings": [last, first]}, {"magnetic_bearings": [first], "states": states}]
    both = [Scene.from_dict(changed(content, rotor=rotor)) for rotor in pair]
    assert both[0].rotor.stiffness == both[1].rotor.stiffness
    np.testing.assert_allclose(*[assemble(one).rotor.state_displacement for one in both], rtol=1e-12)
    np.testing.assert_allclose(*[assemble(one).rotor.state_force for one in both], rtol=1e-12)


def test_a_machine_whose_bearings_fail():
    """Its modes are those with all bearings, its whirls those of the machine without the failed one."""
    content = levitated(rotor={"bearings": [{"at": 0.1, "stiffness": 2e6, "damping": 500.0, "off": 0.01}]})
    content["rotor"]["magnetic_bearings"][1]["off"] = 0.03
    scene = Scene.from_dict(content)
    assert scene.rotor.switched_at == (0.01, 0.03) and scene.rotor.off_times == (0.01,)
    system = assemble(scene)
    assert [one.time for one in system.switched] == [0.01, 0.03] and system.n_states == 3
    held, without = levitated(), levitated()
    held["rotor"]["bearings"] = [{**content["rotor"]["bearings"][0]}]
    held["rotor"]["bearings"][0].pop("off")
    without["rotor"]["magnetic_bearings"].pop(1)
    for other, own in ((held, rsc.modes(scene)), (without, rsc.modes(scene.steady(SPEED)))):
        modes = [mode for mode in rsc.modes(Scene.from_dict(other)).rotor if abs(mode.frequency) < 300.0]
        known = np.array([mode.growth_rate + 2j * np.pi * mode.frequency for mode in own.rotor])
        for mode in modes:
            value = mode.growth_rate + 2j * np.pi * mode.frequency
            assert abs(known - value).min() < 1e-3 * max(abs(value), 10.0)
    assert [one.frequency for one in rsc.predict(scene)] == [one.frequency for one in rsc.predict(scene.steady(SPEED))]
    assert Scene.from_toml(scene.to_toml()) == scene and scene.mirrored().mirrored() == scene
    later = scene.with_values({"rotor.magnetic_bearings[1].off": "20 ms"})
    assert later.rotor.switched_at == (0.01, 0.02)


def test_a_rotor_that_is_not_held_is_told_before_the_run(scene):
    assert levitation_remarks(scene) == []
    weak = Scene.from_dict(levitated(rotor={"rayleigh": [0.0, 0.0]}))
    (remark,) = levitation_remarks(weak)
    fastest = max(full_loop(weak).eigenvalues(), key=lambda value: value.real)
    assert remark.startswith("the rotor is not stable in its magnetic bearings at a rotor speed of 40 Hz: +")
    assert f"{fastest.real:+.4g} 1/s at {fastest.imag / TWO_PI:.4f} Hz" in remark


SEAL = """speed [rpm], k_xx [MN/m], k_xy [MN/m], k_yx [MN/m], k_yy [MN/m], c_xx [kN s/m], c_yy [kN s/m]
1000, 0.1, 0.05, -0.05, 0.1, 0.5, 0.5
4000, 0.2, 0.10, -0.10, 0.2, 0.4, 0.4
"""


def test_a_seal_that_follows_the_speed_acts_beside_magnetic_bearings(tmp_path):
    """Alone it does not hold the rotor."""
    (tmp_path / "seal.csv").write_text(SEAL)
    drive = {"speed": None, "duration": None, "schedule": [[0.0, 20.0], [0.05, 60.0]]}
    rotor = {"bearings": [{"at": 0.1, "table": str(tmp_path / "seal.csv")}]}
    scene = Scene.from_dict(levitated(rotor=rotor, drive=drive))
    for speed in (20.0, 37.0, 60.0):
        vibrations = free_vibrations(assemble(scene), speed)
        own = np.array([each.growth_rate + 2j * np.pi * each.frequency for each in vibrations])
        values = full_loop(scene, speed).eigenvalues()
        inside = values[np.abs(values) < TWO_PI * 450.0]
        assert len(inside) >= 8 and max(abs(own - value).min() / abs(value) for value in inside) < 2.0 * scene.rotor.error
    backwards = rsc.modes(Scene.from_dict(levitated(drive={"speed": -SPEED}))).rotor
    forwards = rsc.modes(Scene.from_dict(levitated())).rotor
    assert sorted(-mode.frequency for mode in backwards) == pytest.approx(sorted(mode.frequency for mode in forwards), rel=1e-6)


FRONT = {"at": 0.1, **KEYS}
BAD = {
    "sensor outside": ([FRONT, {**FRONT, "sensor_at": 1.0}], r"bearing 2, sensor_at = 1\.0: must be on the shaft, 0 to 900 mm"),
    "outside": ([{**FRONT, "at": -0.1}], r"bearing 1, at = -0\.1: must be on the shaft"),
    "no place": ([dict(KEYS)], r"bearing 1, at = \(missing\)"),
    "negative gain": ([{**FRONT, "proportional": -1.0}], r"proportional = -1\.0: must be a number >= 0 N/m \(positive"),
    "negative derivative": ([{**FRONT, "derivative": -1.0}], r"derivative = -1\.0: must be a number >= 0 N s/m"),
    "no filter": ([{**KEYS, "at": 0.1, "derivative_filter": 0.0}], r"derivative_filter = 0\.0: must be a number > 0 1/s"),
    "off before the start": ([{**FRONT, "off": 0.0}], r"bearing 1, off = 0\.0: must be a number > 0 s"),
    "off after the end": ([{**FRONT, "off": 0.05}], r"bearing 1, off = 0\.05: must be before the end of the run at 0\.05 s"),
    "same name": ([{**FRONT, "name": "a"}, {**FRONT, "name": "a"}], r"bearing 2 \(a\), name = 'a': must be a name that no other"),
    "as for masses": ([[0, KEYS]], r"magnetic_bearings\[0\] = .*must be a table \{"),
    "none": ([], r"bearings = \(missing\): must be bearings that support the rotor \(bearings are missing"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bearings_that_cannot_be_are_refused_in_one_line(name):
    bearings, words = BAD[name]
    with pytest.raises(SceneError, match=words) as error:
        Scene.from_dict(levitated(rotor={"magnetic_bearings": bearings}))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("states", "words"),
    [
        ({"force": [[-1.0]]}, r"states\.force = .*must be a 2 x 1 matrix .*1 sensors, 2 actuators"),
        ({"sensors": []}, r"states\.sensors = \[\]: must be a list of one or more places"),
        ({"sensors": [1.2]}, r"states\.sensors\[0\] = 1\.2: must be on the shaft"),
        ({"displacement": None}, r"states\.displacement = \(missing\): must be given, or states\.velocity"),
        ({"gain": 1.0}, r"states\.gain = 1\.0: must be a key of"),
    ],
)
def test_states_that_cannot_be_are_refused_in_one_line(states, words):
    given = {"matrix": [[-300.0]], "sensors": [0.1], "displacement": [[1.0]], "actuators": [0.1, 0.2], "force": [[-2e5], [0.0]]}
    given = {key: value for key, value in {**given, **states}.items() if value is not None}
    with pytest.raises(SceneError, match=words) as error:
        Scene.from_dict(levitated(rotor={"states": given}))
    assert "\n" not in str(error.value)


def test_nodes_that_a_machine_does_not_have_are_refused(scene, tmp_path):
    save_model(scene.reductions[0].model, tmp_path / "shaft.npz")
    contact = {key: value for key, value in levitated()["contact"].items() if key != "at"}
    for item, words in (
        ([999, KEYS], r"magnetic_bearings\[0\]\[0\] = 999: must be a place of the model"),
        ([1, {**KEYS, "sensor": "nowhere"}], r"magnetic_bearings\[0\]\.sensor = 'nowhere': must be a place of the model"),
        ([1, 2.0], r"magnetic_bearings\[0\]\[1\] = 2\.0: must be a table \{"),
        ([1], r"magnetic_bearings\[0\] = \[1\]: must be \[node, \{"),
    ):
        rotor = {"model": "machine", "file": str(tmp_path / "shaft.npz"), "contact": 2, "magnetic_bearings": [item]}
        with pytest.raises(SceneError, match=words):
            Scene.from_dict({**levitated(), "rotor": rotor, "contact": contact})


def test_natural_frequencies_over_the_speed_are_those_of_the_closed_loop(scene):
    """As a Campbell diagram of a run shows them."""
    system, speeds = assemble(scene), np.array([0.0, 20.0, SPEED])
    alone = controlled_frequencies(system, speeds, joined=False)
    for speed, own in zip(speeds, alone, strict=True):
        values = full_loop(scene, speed).eigenvalues()
        slow = values[(np.abs(values) < TWO_PI * 450.0) & (np.abs(values.imag) > 1.0)].imag / TWO_PI
        assert len(slow) >= 6 and abs(own - slow[:, None]).min(axis=1).max() < 1e-3
    joined = controlled_frequencies(system, speeds, joined=True)
    assert joined.shape[0] == 3 and abs(np.sort(joined[0]) + np.sort(-joined[0])[::-1]).max() < 1e-6
    coupled = [mode.frequency for mode in rsc.modes(scene, SPEED).coupled if abs(mode.frequency) > 1.0]
    assert abs(joined[2] - np.array(coupled)[:, None]).min(axis=1).max() < 1e-6


@pytest.mark.nightly
def test_a_run_is_that_of_the_full_machine():
    """Into contact and in it: DOP853 on all coordinates, from the reduced rotor's start."""
    damped = {"rayleigh": [20.0, 2e-6], "unbalance": [{"at": 0.5, "amount": 8e-3}]}  # little, or the full machine is stiff
    contact = {"stiffness": 1e6, "diameter": 0.06, "slip_velocity": 0.05}
    tables = {"solver": {"rtol": 1e-9}, "output": {"velocities": True}, "reduction": {"band": [-900.0, 900.0]}}
    scene = Scene.from_dict(levitated(rotor=damped, contact=contact, drive={"duration": 0.06}, **tables))
    result, reduction = rsc.simulate(scene), scene.reductions[0]
    at = row(reduction.model, 0.2)
    omega = TWO_PI * 130.0
    stator = {"mass": 4.0, "spring": 4.0 * omega**2, "damper": 2.0 * 0.1 * 4.0 * omega}
    start = [
        reduction.recover(result.rotor[0]), reduction.recover(result.rotor_velocity[0]), result.rotor_states[0],
        result.stator[0], result.stator_velocity[0],
    ]  # fmt: skip
    own = full_loop(scene).motion(
        (reduction.full.unbalance[:, 0], reduction.full.load), {**contact, **stator, "gap": GAP, "friction": 0.1, "row": at},
        result.time, np.concatenate(start),
    )  # fmt: skip
    assert result.normal_force.max() > 100.0 and np.abs(result.rotor[:, 0]).max() > 2.0 * GAP
    assert np.abs(own @ at - result.rotor[:, 0]).max() < scene.rotor.tolerance * GAP


def test_motions_of_a_controller_that_hardly_oscillate_are_not_followed(scene):
    """A list's runs last some periods of the slowest free vibration: of the shaft in its bearings, not of an integrator."""
    oscillating = [mode.frequency for mode in free_vibrations(assemble(scene), SPEED) if abs(mode.frequency) > 20.0]
    assert min(mode.frequency for mode in free_vibrations(assemble(scene), SPEED) if mode.frequency > 0.0) < 1.0
    assert Settling(scene, SPEED).slowest == pytest.approx(min(map(abs, oscillating)))
