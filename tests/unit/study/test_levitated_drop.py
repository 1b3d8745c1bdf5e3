"""A machine that its magnetic bearings drop, reduced in the closed loop, against all its coordinates by NumPy and SciPy alone."""

import numpy as np
import pytest
from test_levitated_machine import GAP, KEYS, OTHER, PLACES, levitated, row

import rsc
from levitated_machine import Drop, FullLoop
from rsc.scene.scene import Scene
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble

AMOUNT, CATCHERS, SPEED, FAILURES, DURATION = 2e-4, (0.15, 0.75), 60.0, (0.008, 0.012), 0.05
LAW = {"gap": GAP, "friction": 0.15, "stiffness": 1e7, "damping": 500.0, "diameter": 0.06, "slip_velocity": 0.05}
HELD = {"mass": 1.2, "stiffness": 2e7, "damping": 3e3}


def dropped(tolerance):
    """The front bearing fails first; two auxiliary bearings catch the shaft, at places without sensor or magnet."""
    content = levitated(
        rotor={"rayleigh": [20.0, 2e-6]},  # little, or the full machine is stiff
        drive={"speed": SPEED, "duration": DURATION}, start={"running": True}, solver={"rtol": 1e-9},
        output={"rate": 50000.0}, reduction={"band": [-900.0, 900.0], "tolerance": tolerance},
    )  # fmt: skip
    for one, off in zip(content["rotor"]["magnetic_bearings"], FAILURES, strict=True):
        one["off"] = off
    content["stator"] = {"model": "matrices", **{name: (np.eye(2) * value).tolist() for name, value in HELD.items()}}
    content["contact"] = [{"name": f"catcher_{i}", "at": at, "stator_coordinate": i, **LAW} for i, at in enumerate(CATCHERS)]
    return Scene.from_dict(content)


def full_drop(model):
    """The machine of `dropped` in all its coordinates; its weight and unbalance are written out."""
    bearings = [(row(model, at), row(model, sensor), keys) for (at, sensor), keys in zip(PLACES, (KEYS, OTHER), strict=True)]
    imposed = AMOUNT * row(model, 0.5), -9.81j * model.mass @ sum(row(model, at) for at in model.position.values())
    loops = [FullLoop(model, bearings, SPEED, failed) for failed in ((), (0,), (0, 1))]
    return Drop(loops, (*FAILURES, DURATION), imposed, np.array([row(model, at) for at in CATCHERS]), LAW, HELD)


def closed_at(times, apart):
    """Times at which a contact closes, between samples."""
    depth = np.abs(apart) - GAP
    before = np.flatnonzero((depth[:-1] < 0.0) & (depth[1:] >= 0.0))
    return times[before] - depth[before] * (times[before + 1] - times[before]) / (depth[before + 1] - depth[before])


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-6])
def test_the_run_starts_in_the_levitated_motion_of_the_full_machine(tolerance):
    """With the unbalance turning, the weight carried by the integrators: from 15, 18 and 22 of 34 coordinates."""
    scene = dropped(tolerance)
    state, reduction = initial_state(scene, assemble(scene)), scene.reductions[0]
    drop = full_drop(reduction.model)
    n, full = drop.n, drop.start
    for own, exact, unit in ((state.rotor, full[:n], 1.0), (state.rotor_velocity, full[n : 2 * n], drop.Omega)):
        np.testing.assert_allclose(drop.rows @ reduction.recover(own), drop.rows @ exact, atol=tolerance * 0.1 * GAP * unit)
    for i in range(2):  # each state beside its own size
        states = slice(3 * i, 3 * i + 3)
        np.testing.assert_allclose(state.states[states], full[2 * n :][states], rtol=10.0 * tolerance)


@pytest.mark.nightly
def test_the_drop_is_that_of_all_coordinates():
    """DOP853 from the levitated motion over two failures, the fall and six impacts; no two motions have parted by then."""
    loose, close = (dropped(tolerance) for tolerance in (1e-3, 1e-5))
    results = [rsc.simulate(scene) for scene in (loose, close)]
    times = results[0].time
    apart, closed = full_drop(close.reductions[0].model).motion(times)
    assert [len(own) for own in closed] == [4, 2] and max(FAILURES) < closed[0][0]
    for result, scene in zip(results, (loose, close), strict=True):
        own = result.rotor[:, :2] - result.stator
        away = np.abs(own - apart) / GAP
        assert 0.0 < away[times < FAILURES[0]].max() < 0.1 * scene.rotor.tolerance
        assert away.max() < 1e-4  # a failure is a jump of force, which bends the shaft beyond the band of the reduction as well
        for i in range(2):
            np.testing.assert_allclose(closed_at(times, own[:, i]), closed[i], atol=2e-4 * 1e-3)
            assert result.normal_force[:, i].max() > 300.0
