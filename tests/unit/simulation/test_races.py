"""Inner races that friction turns: against a program of their own, files, what refuses them, and a rotor that is dropped."""

import numpy as np
import pytest

import rsc
from dropped import RACE, dropped
from rsc.cli import main
from rsc.errors import SceneError
from rsc.results.result_file import ResultFile
from rsc.simulation.run import Run
from rsc.study.run.simulate import simulate
from scenes import LAVAL, changed
from tiers import nightly
from two_contacts import pushed, two
from witness import motion_of

METHODS = ("rk45", "taylor8")
TURNING = {"diameter": 0.05, "slip_velocity": 0.05, "race_inertia": 2e-6, "race_drag": 1e-5}


def racing(duration=0.05, **tables):
    """Two contacts, a race at one of them, which friction turns and drag brakes."""
    return two(TURNING, {"diameter": 0.04, "slip_velocity": 0.1}, **tables, **pushed(duration=duration))


@pytest.mark.parametrize("method", ["rk45", nightly("taylor8")])
def test_the_motion_and_the_races_are_those_of_a_program_of_their_own(method):
    scene = racing(rotor={"gravity": 9.81}, output={"rate": 2000.0})
    result = simulate(scene.with_values({"solver.rtol": 1e-12, "solver.method": method}))
    rotor, stator, races = motion_of(scene, result.time)
    gap = min(contact.gap for contact in scene.contacts)
    assert abs(result.rotor - rotor).max() < 1e-8 * gap and abs(result.stator - stator).max() < 1e-8 * gap
    assert result.race_speed.shape == (result.n_time, 2) and not result.race_speed[:, 1].any()
    np.testing.assert_allclose(result.race_speed[:, 0], races[:, 0] / (2.0 * np.pi), rtol=1e-7, atol=1e-7)
    assert result.race_speed[-1, 0] > 20.0
    assert abs(result.summary.ledger.residual) < 1e-9 * result.summary.ledger.turnover


@pytest.mark.parametrize("method", METHODS)
def test_the_order_of_the_method_is_kept(method):
    """Steps of a smooth contact that slides on a race: ten times the tolerance is about ten times the error."""
    errors = []
    exact = simulate(racing(duration=0.01, solver={"rtol": 1e-12}))
    for rtol in (1e-5, 1e-7, 1e-9):
        result = simulate(racing(duration=0.01, solver={"rtol": rtol, "method": method}))
        errors.append(abs(result.race_speed[:, 0] - exact.race_speed[:, 0]).max())
    assert errors[1] < 0.1 * errors[0] and errors[2] < 0.1 * errors[1]


def test_a_race_too_heavy_to_turn_changes_nothing():
    still = simulate(two({key: TURNING[key] for key in ("diameter", "slip_velocity")}, **pushed()))
    heavy = simulate(two(TURNING | {"race_inertia": 1e12}, **pushed()))
    assert 0.0 < heavy.race_speed.max() < 1e-9
    np.testing.assert_allclose(heavy.rotor, still.rotor, rtol=0, atol=1e-8 * still.scene.contacts[0].gap)


def test_a_race_spins_up_in_the_time_of_its_inertia_and_stays_below_the_rotor():
    """A rotor that lies in a race: J omega' = mu F_N R with R = d_R/2 + gap, then no slip is left but that which the drag asks
    for: both surfaces run at the same speed, the larger one turns slower."""
    scene = rsc.Scene.from_dict(changed(
        LAVAL, rotor={"gravity": 9.81, "frequency": None, "stiffness": 0.0, "damping_ratio": None, "eccentricity": 0.0},
        contact={"diameter": 0.05, "slip_velocity": 0.01, "race_inertia": 2e-4, "race_drag": 2e-6, "friction": 0.1,
                 "damping_ratio": 0.3},
        start={"centre": True}, drive={"speed": 50.0, "duration": 4.0},
    ))  # fmt: skip
    result = simulate(scene)
    sliding = (result.time > 0.5) & (result.race_speed < 45.0)
    rise = np.polyfit(result.time[sliding], result.race_speed[sliding], 1)[0]
    weight, radius = 9.81 / np.sqrt(1.0 + 0.1**2), 0.025 + scene.contact.gap  # of 1 kg, on a wall that friction climbs
    assert rise == pytest.approx(0.1 * weight * radius / 2e-4 / (2.0 * np.pi), rel=0.05)
    drag = 2e-6 * 2.0 * np.pi * 50.0  # N m
    slip = 0.01 * drag / (0.1 * 9.81 * radius)
    expected = (2.0 * np.pi * 50.0 * 0.025 - slip) / (2.0 * np.pi * radius)
    last = result.race_speed[result.time > 3.5].mean()  # the rotor still swings a little
    assert last == pytest.approx(expected, abs=1e-3) and expected < 49.0


@pytest.mark.parametrize("method", METHODS)
def test_what_friction_takes_from_the_drive_is_heat_and_what_turns_the_race(method):
    """And what feeds the lateral motion; each by samples: the torque acts at d_R/2 of the shaft, at d_R/2 + gap of the race."""
    scene = racing(0.1, output={"rate": 200000.0}, solver={"method": method, "rtol": 1e-10})
    result, seal = simulate(scene), scene.contacts[0]
    facts, friction = result.stretches("seal").whole(), result.friction_force[:, 0]
    race = 2.0 * np.pi * result.race_speed[:, 0]
    slip = np.pi * result.speed * seal.diameter + result.tangential_velocity[:, 0] - race * (0.5 * seal.diameter + seal.gap)

    def total(power):
        return float(np.trapezoid(power, result.time))

    assert facts.drive_work == pytest.approx(total(np.pi * result.speed * seal.diameter * friction), rel=1e-3)
    kinetic = 0.5 * seal.race_inertia * race[-1] ** 2
    assert facts.race_work == pytest.approx(kinetic + total(seal.race_drag * race**2), rel=3e-3)
    heat = facts.drive_work - facts.race_work - facts.friction_work
    assert heat == pytest.approx(total(friction * slip), rel=1e-3) and facts.race_work > 0.05 * heat > 0.0


@pytest.mark.parametrize("method", METHODS)
def test_a_run_with_races_goes_through_a_file_and_goes_on_bit_for_bit(method, tmp_path):
    scene, path = racing(0.2, output={"rate": 3000.0}, solver={"method": method}), tmp_path / "run.h5"
    whole, memory = simulate(scene, path=path), simulate(scene)
    read = rsc.load(path)
    np.testing.assert_array_equal(read.race_speed, memory.race_speed)
    assert read.summary == whole.summary and "race speed of seal in Hz" in read.table().columns
    assert read.to_xarray()["race_speed"].dims == ("time", "contact")
    source = ResultFile(path)
    run = Run.resumed(read.scene, source.checkpoint_at(len(source.checkpoint_rows()) // 2))
    for _block, status in run.chunks():
        last = status
    assert str(last) == "finished"
    np.testing.assert_array_equal(run.work.v, Run.resumed(read.scene, source.checkpoint()[0]).work.v)
    assert main(["verify", str(path)]) == 0


def test_many_runs_have_the_bits_of_one():
    scenes = [racing(0.05).with_values({"contact.seal.race_drag": drag}) for drag in (1e-5, 2e-5)]
    for result, scene in zip(rsc.simulate_many(scenes), scenes, strict=True):
        np.testing.assert_array_equal(result.race_speed, simulate(scene).race_speed)


@pytest.mark.parametrize(
    ("seal", "message"),
    [
        ({"race_inertia": 1e-4}, "friction drives it only with contact.diameter"),
        ({"race_drag": 1e-4}, r"needs contact\.race_inertia"),
        (TURNING | {"race_inertia": 0.0}, "race_inertia = 0.0: must be"),
        (TURNING | {"race_drag": -1.0}, "race_drag = -1.0: must be"),
    ],
)
def test_a_race_that_cannot_be_is_refused(seal, message):
    with pytest.raises(SceneError, match=message):
        two(seal, **pushed())


def test_what_has_no_race_says_so():
    with pytest.raises(SceneError, match="no race turns in this run"):
        _ = simulate(two(**pushed(duration=0.01))).race_speed


def test_a_race_that_drag_does_not_hold_lets_no_whirl_slide():
    """The side condition knows the speed to which friction would turn the race at last."""
    fixed, held, free = (rsc.predict(dropped(0.3, race)) for race in (None, RACE | {"race_drag": 1e3}, RACE))
    for one, other, third in zip(fixed, held, free, strict=True):
        assert one.frequency == other.frequency == third.frequency
        assert one.conditions["sliding"] > 0.5 and other.conditions["sliding"] > 0.5 > 0.0 > third.conditions["sliding"]


def test_a_dropped_rotor_lies_down_at_little_friction():
    """First touch and peaks are those of an independent program."""
    result = simulate(dropped(0.15, duration=0.5))
    force = result.normal_force
    assert result.time[(force > 0.0).any(axis=1)][0] == pytest.approx(7.4e-3, abs=5e-5)
    assert force[result.time < 0.02].max(axis=0) == pytest.approx([871.0, 927.0], rel=2e-3)
    last = result.time > 0.4
    assert result.rotor[last].imag.max() < 0.0


def test_a_dropped_rotor_whirls_at_much_friction_unless_its_races_turn():
    """The whirl is the predicted one of both planes, which the independent program has at -173.699 Hz and 0.1 % less force.

    Why it differs is not known; prediction and simulation here agree with each other more closely than with it.
    """
    (whirl,) = [one for one in rsc.predict(dropped(0.3, gravity=0.0, eccentricity=0.0)) if one.stable and len(one.pressed) == 2]
    assert whirl.frequency == pytest.approx(-173.699, abs=0.025)
    forces = [own.normal_force for own in whirl.contacts.values()]
    assert forces == pytest.approx([8878.6, 11958.8], rel=1.1e-3)
    assert [own.over_gap for own in whirl.contacts.values()] == pytest.approx([1.355, 1.478], abs=1e-3)
    fixed, turning = (simulate(dropped(0.3, race, duration=2.0)) for race in (None, RACE))
    d = fixed.rotor[:, 0] - fixed.stator[:, 0]
    turned = np.unwrap(np.angle(d[fixed.time > 1.0]))  # a second of it; the unbalance turns on it
    assert (turned[-1] - turned[0]) / (2.0 * np.pi) == pytest.approx(whirl.frequency, abs=0.02)
    assert fixed.normal_force[fixed.time > 1.5].mean(axis=0) == pytest.approx(forces, rel=1e-3)
    last = turning.time > 1.0
    assert turning.rotor[last].imag.max() < 0.0 and turning.race_speed[last].min() > 195.0
