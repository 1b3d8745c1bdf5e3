"""Several contacts simulated: against a program of its own, against one contact of twice the stiffness, far ones, files."""

import copy

import numpy as np
import pytest

import rsc
from rsc.errors import DataError, RscError, SceneError, SolverError
from rsc.scene.scene import Scene
from rsc.study.run.simulate import simulate
from scenes import LAVAL, TWO, changed
from tiers import nightly
from two_contacts import pushed, two
from witness import motion_of

METHODS = ("rk45", "taylor8")


@pytest.mark.parametrize("method", METHODS)
def test_the_motion_is_that_of_a_program_of_its_own(method):
    """Two contacts with offset, ring, damper, friction that follows the slip at one of them, and gravity."""
    scene = two(
        {"offset": [2e-5, -1e-5], "diameter": 0.05, "slip_velocity": 0.05}, {"ring_eccentricity": [1e-5, 40.0]},
        rotor={"gravity": 9.81}, output={"rate": 2000.0}, **pushed(duration=0.05),
    )  # fmt: skip
    result = simulate(scene.with_values({"solver.rtol": 1e-12, "solver.method": method}))
    rotor, stator, _ = motion_of(scene, result.time)
    assert result.summary.contact_onsets >= 4 and (result.normal_force.max(axis=0) > 10.0).all()
    assert np.abs(result.rotor - rotor).max() < 1e-8 * 1e-4
    assert np.abs(result.stator - stator).max() < 1e-8 * 1e-4


@pytest.mark.parametrize("method", [nightly("rk45"), "taylor8"])
def test_two_equal_contacts_at_one_place_are_one_of_twice_the_stiffness(method):
    own = {"gap": 1e-3, "friction": 0.2, "stiffness": 1.7e6, "damping": 300.0, "diameter": 0.04, "slip_velocity": 0.02}
    solver = {"rtol": 1e-11, "method": method}
    pair = Scene.from_dict({**changed(LAVAL, solver=solver), "contact": [{**own, "name": "a"}, {**own, "name": "b"}]})
    twice = Scene.from_dict({**changed(LAVAL, solver=solver), "contact": own | {"stiffness": 3.4e6, "damping": 600.0}})
    both, one = simulate(pair), simulate(twice)
    assert np.abs(both.rotor - one.rotor).max() < 1e-6 * 1e-3
    assert both.normal_force.shape == (both.n_time, 2)
    np.testing.assert_allclose(both.normal_force.sum(axis=1), one.normal_force, atol=1e-4 * one.normal_force.max())
    np.testing.assert_array_equal(both.normal_force[:, 0], both.normal_force[:, 1])
    for name in ("a", "b"):
        facts, whole = both.stretches(name).whole(), one.stretches().whole()
        assert facts.force_max == pytest.approx(0.5 * whole.force_max, rel=1e-4)
        assert (facts.turns, facts.contact_time) == pytest.approx((whole.turns, whole.contact_time), rel=1e-4)
        assert facts.friction_work == pytest.approx(0.5 * whole.friction_work, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_contact_far_away_changes_no_bit_of_motion_or_steps(method):
    """taylor8 has code of its own for several contacts, so there it is a matter of rounding."""
    far = {"name": "far", "rotor_coordinate": 0, "gap": 1.0, "stiffness": 1e3, "friction": 0.3}
    own = {"name": "near", **changed(LAVAL)["contact"]}
    scenes = [Scene.from_dict({**changed(LAVAL, solver={"method": method}), "contact": contact}) for contact in (own, [own, far])]
    one, several = map(simulate, scenes)
    if method == "rk45":
        np.testing.assert_array_equal(several.rotor, one.rotor)
        np.testing.assert_array_equal(several.stretches("near").rows, one.stretches().rows)
        assert several.steps == one.steps
    assert np.abs(several.rotor - one.rotor).max() < 1e-5 * 1e-3
    assert several.stretches("far").whole().contact_time == 0.0
    assert several.normal_force[:, 1].max() == 0.0


@pytest.mark.parametrize("method", ["rk45", nightly("taylor8")])
def test_the_ledger_closes(method):
    result = simulate(two({"diameter": 0.05}, {"ring_eccentricity": [2e-5, 10.0]}, solver={"method": method}, **pushed()))
    assert abs(result.ledger.residual) < 2e-4 * result.ledger.turnover
    assert result.ledger.friction_in == pytest.approx(
        sum(result.stretches(name).whole().friction_work for name in ("seal", "ring")), rel=1e-9
    )


def test_three_contacts_and_both_methods_agree():
    """A third contact on the shaft's middle; the finer run is the witness of both."""
    middle = {"name": "middle", "rotor_coordinate": 1, "stator_coordinate": 0, "gap": 1.2e-4, "stiffness": 4e7, "friction": 0.05}
    content = {**copy.deepcopy(TWO), **pushed(duration=0.05)}
    content["contact"].append(middle)
    runs = [simulate(Scene.from_dict({**content, "solver": {"method": m, "rtol": 1e-11}})) for m in METHODS]
    assert (runs[0].normal_force.max(axis=0) > 1.0).all()
    assert np.abs(runs[0].rotor - runs[1].rotor).max() < 1e-6 * 1e-4


def test_a_run_of_several_goes_through_a_file_and_goes_on_bit_for_bit(tmp_path):
    scene, path = two(output={"rate": 3000.0}, **pushed(duration=0.2)), tmp_path / "run.h5"
    whole = simulate(scene, path=path)
    memory = simulate(scene)
    read = rsc.load(path)
    for name in ("rotor", "stator", "normal_force", "friction_force", "tangential_velocity"):
        np.testing.assert_array_equal(getattr(read, name), getattr(memory, name))
    for name in (None, "seal", "ring"):
        np.testing.assert_array_equal(read.stretches(name).rows, memory.stretches(name).rows)
    assert read.summary == whole.summary
    columns = read.table().columns
    assert "normal force of ring in N" in columns and len(columns) == len(set(columns))
    with pytest.raises(SceneError, match="one of seal, ring"):
        read.stretches("bearing")
    from rsc.results.result_file import ResultFile
    from rsc.simulation.run import Run

    source = ResultFile(path)
    middle = source.checkpoint_at(len(source.checkpoint_rows()) // 2)
    run = Run.resumed(read.scene, middle)
    for _block, status in run.chunks():
        last = status
    assert str(last) == "finished"
    np.testing.assert_array_equal(run.work.x, Run.resumed(read.scene, source.checkpoint()[0]).work.x)


def test_what_treats_one_contact_says_so():
    scene = two(**pushed())
    with pytest.raises(SolverError, match=r"2 contacts \(seal, ring\) but this takes one; rsc run simulates"):
        rsc.force_ratios(scene, 70.0)


def test_values_by_name_reach_the_simulation():
    slow, fast = (simulate(two(**pushed(duration=0.05)).with_values({"contact.ring.friction": mu})) for mu in (0.0, 0.4))
    assert slow.friction_force[:, 1].max() == 0.0 < fast.friction_force[:, 1].max()


def test_a_start_at_rest_lies_in_no_gap():
    heavy = two(rotor={"gravity": 9810.0}, start={"rest": True})
    with pytest.raises(RscError, match="the rotor would lie in"):
        simulate(heavy)
    light = two(rotor={"gravity": 9.81, "eccentricity": 0.0}, start={"rest": True}, drive={"speed": 10.0, "duration": 0.1})
    resting = simulate(light)
    assert np.abs(resting.rotor - resting.rotor[0]).max() < 1e-9


def test_a_forged_number_of_contacts_is_refused(tmp_path):
    import h5py

    path = tmp_path / "run.h5"
    simulate(two(**pushed(duration=0.02)), path=path)
    with h5py.File(path, "r+") as file:
        forces = file["normal_force"][...]
        del file["normal_force"]
        file.create_dataset("normal_force", data=forces[:, :1], chunks=True, maxshape=(None, 1), fletcher32=True)
    with pytest.raises(DataError):
        _ = rsc.load(path).normal_force
