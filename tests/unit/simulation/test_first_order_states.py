"""First-order states in runs: numbers of two other programs, the slow twin, the ledger, orders, files, and what is refused."""

import numpy as np
import pytest

import rsc
from naive import integrate
from rsc.errors import SceneError
from rsc.kernel.tableau import METHODS
from rsc.scene.scene import Scene
from rsc.study.run.start import initial_state
from rsc.study.run.verify import verify
from rsc.system.assemble import assemble
from scenes import SCENES, changed
from tiers import nightly
from two_seals import pump

CONTROLLER = {"negative_stiffness": 5e4, "proportional": 3e5, "integral": 1e6, "derivative": 200.0, "derivative_filter": 1e4,
              "amplifier": "500 Hz"}  # fmt: skip
LEVITATED = {
    "rotor": {"model": "laval", "mass": 5.0, "stiffness": 0.0, "eccentricity": 15e-6, "magnetic_bearings": [[0, CONTROLLER]]},
    "stator": {"model": "laval", "mass": 1.5, "frequency": 180.0, "damping_ratio": 0.1},
    "contact": {"gap": 0.25e-3, "stiffness": 2e7, "friction": 0.15, "diameter": 0.06, "slip_velocity": 0.02},
    "drive": {"schedule": [[0.0, 20.0], [1.0, 80.0]]},
    "start": {"rotor": [[1e-4, 2e-4]], "rotor_velocity": [[0.25, -0.1]]},
}
# of two other programs, one in complex and one in real coordinates, equal to 1e-8 gaps: at 0.25, 0.5, 0.75 and 1 s
RUN_UP = [0.22863240 - 1.60488030j, -0.94918611 + 1.34946382j, 1.47639977 - 0.68747671j, 1.34068948 - 0.14282974j]
# a sensor that is not where its actuator is, an elastomer (Maxwell element) that holds the stator, a start away from zero
MAXWELL = {"matrix": [[-300.0]], "velocity": [[1.0, 0.0]], "force": [[-2e5], [0.0]]}
APART = {
    "matrix": [[-500.0, 0.0], [400.0, -900.0]], "displacement": [[2.0, 0.0, -1.0], [0.0, 0.0, 0.0]],
    "force": [[0.0, 0.0], [-1e6, 3e5], [0.0, 2e5]],
}  # fmt: skip
CHAINS = changed(
    SCENES["chains"], rotor={"states": APART}, stator={"states": MAXWELL},
    start={**SCENES["chains"]["start"], "rotor_states": [[1e-7, 0.0], [0.0, 2e-7]], "stator_states": [[0.0, 1e-5]]},
)  # fmt: skip
BODIES = {
    "levitated": changed(LEVITATED, drive={"schedule": [[0.0, 20.0], [0.2, 35.0]]}, output={"rate": 2000.0}),
    "chains": CHAINS,
    "with skew springs": changed(CHAINS, rotor={"supports": [[1, [2e3, -4e3, 4e3, 5e3]]]}),
}


@pytest.mark.parametrize("method", METHODS)
def test_run_up_in_a_magnetic_bearing_has_the_numbers_of_two_other_programs(method):
    result = rsc.simulate(Scene.from_dict(changed(LEVITATED, solver={"rtol": 1e-9, "method": method})))
    assert abs(result.rotor[[500, 1000, 1500, 2000], 0] / 0.25e-3 - RUN_UP).max() < 5e-8
    ledger = result.ledger
    assert ledger.control_in < -1.0 and abs(ledger.residual) < 1e-9 * ledger.turnover


# with skew springs the chains have all terms that they have without
@pytest.mark.parametrize("name", ["levitated", nightly("chains"), nightly("with skew springs")])
def test_motion_and_states_equal_those_of_the_slow_twin(name):
    scene = Scene.from_dict(BODIES[name])
    system = assemble(scene)
    times = np.arange(int(scene.drive.duration * scene.output.rate) + 1) / scene.output.rate
    rotor, stator = integrate(system, initial_state(scene, system), times, rtol=1e-8)
    for method in METHODS:
        result = rsc.simulate(scene.with_values({"solver.method": method, "solver.rtol": 1e-9}))
        assert result.normal_force.max() > 0.0
        assert abs(result.rotor - rotor).max() < 1e-5 * system.contact.gap
        assert abs(result.stator - stator).max(initial=0.0) < 1e-5 * system.contact.gap
        assert abs(result.ledger.residual) < 1e-6 * result.ledger.turnover


@pytest.mark.nightly  # compiles the two largest kinds of kernels of all tests
def test_states_beside_other_contacts_a_race_and_an_integrated_speed():
    """The motion by both methods, which share no code of a step, and the ledger."""
    sealed = {
        **pump(seal={"slip_velocity": 0.02, "race_inertia": 1e-3}, bush={"slip_velocity": 0.05}).to_dict(),
        "drive": {"inertia": 0.3, "torque": [[0.0, 4.0], [60.0, 1.0]], "speed": 40.0, "duration": 0.2},
        "start": {"rotor": [[0.0, 0.0]] * 3, "rotor_velocity": [[0.4, 0.0], [0.4, 0.1], [0.3, 0.0]]},
    }
    sealed["rotor"]["magnetic_bearings"] = [[1, {"proportional": 2e5, "derivative": 100.0, "derivative_filter": 5e3,
                                                 "amplifier": 300.0}]]  # fmt: skip
    scenes = [Scene.from_dict(changed(sealed, solver={"method": method, "rtol": 1e-10})) for method in METHODS]
    one, other = map(rsc.simulate, scenes)
    assert one.normal_force.max(axis=0).min() > 0.0 and one.rotor_states.shape[1] == 2
    assert abs(one.rotor - other.rotor).max() < 1e-5 * scenes[0].contacts[0].gap
    for result in (one, other):
        assert abs(result.ledger.residual) < 1e-6 * result.ledger.turnover and result.ledger.control_in != 0.0


@pytest.mark.parametrize(("method", "order"), [nightly("rk45", 5.0), ("taylor8", 8.0)])
def test_order_without_contact(method, order):
    """States slow enough that the error, and not their stability, holds the steps."""
    soft = {"matrix": [[-60.0, 0.0], [300.0, -90.0]], "displacement": [[60.0], [0.0]], "velocity": [[0.0], [20.0]],
            "force": [[0.0, -2e4]]}  # fmt: skip
    free = {
        **LEVITATED,
        "rotor": {"model": "laval", "mass": 5.0, "frequency": 20.0, "states": soft},
        "contact": {**LEVITATED["contact"], "gap": 1.0}, "drive": {"speed": 1.0, "duration": 0.5},
        "start": {"rotor": [[0.1, 0.2]], "rotor_velocity": [[1.0, -0.1]], "rotor_states": [[0.3, 0.0], [0.0, 0.1]]},
    }  # fmt: skip
    scene = Scene.from_dict(free)
    body = assemble(scene).rotor
    n = np.block(
        [
            [np.zeros((1, 1)), np.eye(1), np.zeros((1, 2))],
            [-body.stiffness / 5.0, -body.damping / 5.0, body.state_force / 5.0],
            [body.state_displacement, body.state_velocity, body.state_matrix],
        ]
    )
    values, vectors = np.linalg.eig(n)
    first = np.linalg.solve(vectors, [0.1 + 0.2j, 1.0 - 0.1j, 0.3, 0.1j])
    steps, errors = [], []
    for rtol in np.geomspace(1e-9, 1e-12, 7) if method == "rk45" else np.geomspace(1e-8, 1e-12, 9):
        result = rsc.simulate(scene.with_values({"solver.method": method, "solver.rtol": float(rtol)}))
        exact = (vectors @ (first[:, None] * np.exp(values[:, None] * result.time))).T
        got = np.column_stack([result.rotor, result.rotor_states])
        steps.append(result.steps)
        errors.append(abs(got - exact[:, [0, 2, 3]]).max())
    slope = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=1.0), (steps, errors)


def test_scene_and_result_are_read_back(tmp_path):
    scene = Scene.from_dict(CHAINS)
    assert Scene.from_toml(scene.to_toml()) == scene and Scene.from_dict(scene.to_dict()) == scene
    result = rsc.simulate(scene, path=tmp_path / "run.h5")
    loaded = rsc.load(tmp_path / "run.h5")
    assert loaded.scene == scene and loaded.ledger == result.ledger and loaded.ledger.control_in != 0.0
    assert loaded.rotor_states.shape == (result.n_time, 2) and np.array_equal(loaded.stator_states, result.stator_states)
    assert loaded.rotor_states[0].tolist() == [1e-7, 2e-7j] and loaded.stator_states[0, 0] == 1e-5j
    assert verify(tmp_path / "run.h5").same


def test_values_of_states_have_names():
    scene = Scene.from_dict(LEVITATED)
    other = scene.with_values({"rotor.magnetic_bearings[0].proportional": "0.4 MN/m"})
    assert other.rotor.magnetic_bearings[0][1].proportional == 4e5 and other.source.endswith("0.4 MN/m")
    chains = Scene.from_dict(CHAINS)
    assert chains.with_values({"stator.states.matrix": [[-200.0]]}).stator.states.matrix == ((-200.0,),)
    with pytest.raises(SceneError, match=r"states\.matrx"):
        chains.with_values({"stator.states.matrx": [[-200.0]]})


def test_states_of_the_mirror_image():
    scene = Scene.from_dict(changed(BODIES["levitated"], rotor={"eccentricity": [15e-6, 40.0]}))
    result, mirrored = rsc.simulate(scene), rsc.simulate(scene.mirrored())
    assert np.array_equal(mirrored.rotor_states, -result.rotor_states.conj())


@pytest.mark.parametrize(
    ("rotor", "words"),
    [
        ({"states": {"matrix": [[-1.0]], "displacement": [[1.0, 0.0]], "force": [[1.0]]}}, "states.displacement"),
        ({"states": {"matrix": [[-1.0, 0.0]], "displacement": [[1.0]], "force": [[1.0]]}}, "a 1 x 1 matrix"),
        ({"states": {"matrix": [[float("nan")]], "displacement": [[1.0]], "force": [[1.0]]}}, "states.matrix[0][0]"),
        ({"states": {"matrix": [[-1.0]], "force": [[1.0]]}}, "nothing drives the states"),
        ({"states": {"matrix": [], "displacement": [], "force": [[]]}}, "1 to 100 rows"),
        ({"states": {"matrix": [[-1.0]], "displacement": [[1.0]]}}, "rotor.states.force"),
        ({"states": 3.0}, "a table {matrix, displacement, velocity, force}"),
        ({"magnetic_bearings": [[1, CONTROLLER]]}, "a whole number from 0 to 0"),
        ({"magnetic_bearings": [[0, {**CONTROLLER, "derivative_filter": None}]]}, "derivative_filter"),
        ({"magnetic_bearings": [[0, {**CONTROLLER, "amplifier": 0.0}]]}, "magnetic_bearings[0].amplifier"),
        ({"magnetic_bearings": [[0, {**CONTROLLER, "gain": 0.0}]]}, "magnetic_bearings[0].gain"),
        ({"magnetic_bearings": [[0, {"amplifier": 500.0}]]}, "magnetic_bearings[0].proportional"),
        ({"supports_by_speed": [[0, [[0.0, [1e5, 0, 0, 1e5]], [50.0, [2e5, 0, 0, 2e5]]]]]}, "without first-order states"),
    ],
)
def test_impossible_states_are_refused_in_one_line(rotor, words):
    content = changed(LEVITATED, rotor=rotor)
    for bearing in content["rotor"].get("magnetic_bearings", []):
        bearing[1] = {key: value for key, value in bearing[1].items() if value is not None}
    with pytest.raises(SceneError) as error:
        Scene.from_dict(content)
    assert words in str(error.value) and "\n" not in str(error.value)


def test_states_of_a_start_need_states():
    with pytest.raises(SceneError, match="rotor_states"):
        Scene.from_dict(changed(LEVITATED, start={**LEVITATED["start"], "rotor_states": [[0.0, 0.0]]}))
    with pytest.raises(SceneError, match="left out"):
        Scene.from_dict(changed(LEVITATED, start={**LEVITATED["start"], "stator_states": [[0.0, 0.0]]}))


