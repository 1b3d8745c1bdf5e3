"""Scenes fitted to runs whose truth is known: what is found, what is not told, what is refused and what is warned of."""

import json
import signal
from functools import cache

import numpy as np
import pytest

import rsc
import rsc.study.fit.fit
import rsc.study.fit.search
from rsc.cli import main
from rsc.measured.virtual import write_measured
from rsc.study.fit.free import free_values
from systems import REFERENCE

PUMP = {
    "title": "pump",
    "rotor": {"model": "laval", "mass": 12.0, "frequency": 43.3, "damping_ratio": 0.02, "eccentricity": 2e-5},
    "stator": {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1},
    "contact": {"gap": 2.5e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05},
    "drive": {"speed": [40.0, 60.0], "duration": 8.0},
    "start": {"whirl": "backward"},
    "output": {"rate": 5000.0},
}
BALANCED = PUMP | {"rotor": PUMP["rotor"] | {"eccentricity": 0.0}, "drive": {"speed": [40.0, 44.0], "duration": 4.0}}
# a stator of two masses, which no single one can be exactly
CHAIN = PUMP | {
    "stator": {"model": "chain", "masses": [3.0, 6.0], "stiffnesses": [0.0, 3.2e6, 2e8], "dampings": [0.0, 600.0, 5e3]},
    "contact": PUMP["contact"] | {"stator_coordinate": 0},
}  # fmt: skip
FREE = ("contact.friction", "contact.gap", "contact.stiffness", "stator.stiffness")
FOUND = "contact.friction,contact.gap,stator.frequency"  # that are enough for a fit from `GUESS`
TRUTH = (0.2, 2.5e-4, 5e7, 3.0 * (2.0 * np.pi * 160.0) ** 2)
GUESS = {"contact.friction": 0.24, "contact.gap": 2.1e-4, "contact.stiffness": 4e7, "stator.frequency": 140.0}


@cache
def run_of(name):
    return rsc.simulate(rsc.Scene.from_dict({"pump": PUMP, "balanced": BALANCED, "chain": CHAIN}[name]))


@pytest.fixture
def measured(tmp_path):
    def seen(name="pump", noise=2e-6):
        return rsc.read_measured(write_measured(run_of(name), tmp_path / f"{name}.toml", noise=noise))

    return seen


def guess(content=PUMP):
    return rsc.Scene.from_dict(content).with_values(GUESS)


def test_values_are_found_from_a_wrong_guess(measured):
    fit = rsc.fit(guess(), measured(), FREE)
    assert fit.converged and fit.runs < 100 and fit.misfit < 1.2 and not fit.warnings
    friction, gap, stiffness, stator = fit.values
    for value, truth, allowed in ((friction, TRUTH[0], 0.015), (gap, TRUTH[1], 0.03), (stator, TRUTH[3], 0.006)):
        assert abs(value.value / truth - 1.0) < allowed and value.told and value.low < value.value < value.high
    for value, truth in zip(fit.values, TRUTH, strict=True):  # no value further off than four deviations
        side = value.high if truth > value.value else value.low
        assert abs(np.log(truth / value.value)) < 4.0 * abs(np.log(side / value.value))
    assert np.log(stiffness.high / stiffness.low) > 2.0 * 0.08
    assert fit.scene.contact.friction == friction.value and fit.scene.contact.gap == gap.value
    assert fit.scene.drive == guess().drive and fit.scene.start == guess().start
    assert set(fit.use) == {"fitted", "held back"} and (fit.use == "held back").sum() == len(fit.use) // 3


@pytest.mark.nightly
def test_without_a_keyphasor_the_direction_of_the_unbalance_is_not_fitted(tmp_path):
    """The logger was started 400 samples later than the shaft, and has a speed only."""
    run = run_of("pump")
    r, time, speed = run.contact_rotor()[400:], run.time[400:] - run.time[400], run.speed[400:]
    np.savez(tmp_path / "run.npz", t=time, X=r.real, Y=r.imag, n=60.0 * speed)
    table = '[measured]\nfile = "run.npz"\ntime = "t"\nspeed = "n"\nspeed_unit = "1 rpm"\n'
    for column, angle in (("X", 0.0), ("Y", 90.0)):
        table += f'[[measured.probe]]\ncolumn = "{column}"\nangle = {angle}\nunit = 1.0\n'
    (tmp_path / "run.toml").write_text(table)
    measured = rsc.read_measured(tmp_path / "run.toml")
    fit = rsc.fit(guess(), measured, FREE)
    assert measured.jitter is None and fit.converged and fit.misfit < 0.1
    assert fit.warnings == ("no Keyphasor: phases at the rotor speed are counted from the first sample, and no fit takes them",)
    np.testing.assert_allclose([value.value for value in fit.values], TRUTH, rtol=2e-3)


@pytest.mark.nightly
def test_of_a_wheel_without_a_mark_the_size_of_the_unbalance_is_fitted(tmp_path):
    """Eight teeth, begun between two of them: the line at the rotor speed has a size and no direction."""
    run = run_of("pump")
    r, time, turns = run.contact_rotor()[400:], run.time[400:] - run.time[400], (40.0 * run.time + 1.25 * run.time**2)[400:]
    noise = 1e-6 * np.random.default_rng(3).normal(size=(2, len(time)))
    np.savez(tmp_path / "run.npz", t=time, X=r.real + noise[0], Y=r.imag + noise[1], K=np.sin(2.0 * np.pi * (8.0 * turns + 0.4)))
    table = '[measured]\nfile = "run.npz"\ntime = "t"\nkeyphasor = "K"\nevents_per_turn = 8\n'
    for column, angle in (("X", 0.0), ("Y", 90.0)):
        table += f'[[measured.probe]]\ncolumn = "{column}"\nangle = {angle}\nunit = 1.0\n'
    (tmp_path / "run.toml").write_text(table)
    measured = rsc.read_measured(tmp_path / "run.toml")
    assert not measured.marked and measured.jitter is not None
    fit = rsc.fit(guess().with_values({"rotor.eccentricity": 1.2e-5}), measured, (*FREE, "rotor.eccentricity"))
    assert fit.converged and fit.misfit < 1.2
    np.testing.assert_allclose([value.value for value in fit.values[:2]], TRUTH[:2], rtol=0.03)
    assert abs(fit.values[-1].value / 2e-5 - 1.0) < 0.05 and fit.values[-1].told
    assert len(fit.warnings) == 1 and "is the mark" in fit.warnings[0]


@pytest.mark.nightly
def test_one_whirl_of_a_balanced_rotor_tells_two_directions(measured):
    fit = rsc.fit(guess(BALANCED), measured("balanced"), FREE)
    assert [direction.told for direction in fit.directions] == [True, True, False, False]
    assert not any(value.told for value in fit.values if value.name != "stator.stiffness")
    assert all(abs(sum(share**2 for share in direction.parts.values()) - 1.0) < 1e-9 for direction in fit.directions)
    assert "contact.stiffness" in fit.directions[-1].words or "contact.stiffness" in fit.directions[-2].words
    # every scene of the directions that are not told explains the run: the frequency is that of the truth all the same
    found = min(rsc.predict(fit.scene, 42.0), key=lambda whirl: abs(whirl.frequency + 67.9))
    truth = min(rsc.predict(rsc.Scene.from_dict(BALANCED), 42.0), key=lambda whirl: abs(whirl.frequency + 67.9))
    assert abs(found.frequency / truth.frequency - 1.0) < 1e-4


def test_a_model_that_cannot_be_right_is_refused_before_any_simulation(measured):
    notes = []
    with pytest.raises(rsc.SolverError, match=r"no scene with contact\.friction from 0\.01 to 0\.05, .* has the measured whirl"):
        rsc.fit(guess(), measured(), FREE, priors={"contact.friction": "0.01:0.05"}, note=notes.append)
    assert not any("round" in note for note in notes)


@pytest.mark.nightly
def test_what_a_scene_cannot_explain_is_warned_of(measured):
    fit = rsc.fit(guess(), measured("chain", noise=0.5e-6), FREE)
    # a misfit of 1.6; of a scene that explains the run it is below 1
    assert fit.missed[fit.use == "held back"].any() and fit.misfit > 1.3
    assert any("missed by more than three standard deviations" in line for line in fit.warnings)
    friction, gap, *_ = fit.values
    # the single mass that comes nearest to the two has 5.04 % more friction
    assert abs(friction.value / 0.2 - 1.0) < 0.055 and abs(gap.value / 2.5e-4 - 1.0) < 0.05


@pytest.mark.nightly
def test_windows_in_which_a_run_jumps_from_whirl_to_whirl_do_not_lead_the_fit(tmp_path):
    scene = rsc.load_scene(REFERENCE / "gyroscopic_figure3_right.toml").with_values({"drive.duration": 100.0})
    seen = rsc.read_measured(write_measured(rsc.simulate(scene), tmp_path / "jump.toml", noise=2e-6))
    wrong = {"contact.friction": 0.32, "contact.gap": 1.15e-3, "stator.stiffness": 55e3}
    fit = rsc.fit(scene.with_values(wrong), seen, tuple(wrong))
    assert fit.converged and fit.misfit < 1.2 and seen.warnings == ()
    for value, truth in zip(fit.values, (0.286, 1e-3, 62790.0), strict=True):
        assert abs(value.value / truth - 1.0) < 1e-3
    left = fit.speed[fit.use == "left out"]  # whirl A ends near 70 Hz, and B is reached behind it
    assert left.size and 60.0 < left.min() < 71.0 < left.max() < 90.0


def test_the_number_of_threads_changes_no_bit(measured):
    one, three = (rsc.fit(rsc.Scene.from_dict(PUMP), measured(), FREE[:2], threads=threads) for threads in (1, 3))
    assert one.values == three.values and one.residual.tobytes() == three.residual.tobytes()


def test_a_run_without_a_whirl_is_refused(tmp_path):
    scene = rsc.Scene.from_dict(PUMP | {"start": {"running": True}, "drive": {"speed": [20.0, 25.0], "duration": 3.0}})
    seen = rsc.read_measured(write_measured(rsc.simulate(scene), tmp_path / "quiet.toml"))
    with pytest.raises(rsc.DataError, match="shows a backward whirl that lasts in 0 windows"):
        rsc.fit(scene, seen, "contact.gap")


@pytest.mark.parametrize(
    ("free", "priors", "told"),
    [
        ("contact.fricton", {}, "did you mean \"contact.friction\""),
        ([], {}, "0 free values: must be 1 to 12"),
        (["contact.gap", "contact.gap"], {}, "must be named once"),
        ("solver.method", {}, "a word or a count cannot be fitted"),
        ("rotor.gravity", {}, "given a range, since it is zero or missing"),
        ("contact.gap", {"contact.friction": "0.1:0.2"}, "must be of a value that is free"),
        ("contact.gap", {"contact.gap": "0.3 mm:0.2 mm"}, "a range that rises"),
        ("contact.gap", {"contact.gap": "0.3 mm"}, "a range that rises"),
        ("contact.gap", {"contact.gap": "0.1 s:0.2 s"}, "contact.gap = '0.1 s:0.2 s'"),
        ("contact.gap", {"contact.gap": 3.0}, "a range that rises"),
        ("contact.gap", {"contact.gap": (-1e-4, 1e-4)}, "a number > 0"),
    ],
)
def test_bad_values_and_ranges_are_refused_in_one_line(free, priors, told, measured):
    with pytest.raises(rsc.RscError) as error:
        rsc.fit(guess(), measured(), free, priors=priors)
    assert told in str(error.value) and "\n" not in str(error.value)


def test_default_ranges_end_where_a_scene_may_not_go():
    scene = rsc.Scene.from_dict(PUMP)
    values = {one.name: one for one in free_values(scene, ["contact.friction", "stator.stiffness", "stator.damping_ratio"], {})}
    assert values["contact.friction"].low == 0.05 and values["contact.friction"].high == 0.8
    assert values["stator.stiffness"].guess == pytest.approx(TRUTH[3], rel=1e-12)
    gap = free_values(scene, ["contact.gap"], {"contact.gap": "0.1 mm:0.4 mm"})[0]
    assert (gap.low, gap.high) == pytest.approx((1e-4, 4e-4)) and gap.value(gap.coordinate(2e-4)) == pytest.approx(2e-4)


def test_an_angle_of_the_unbalance_is_free_from_that_of_the_scene():
    scene = rsc.Scene.from_dict(PUMP).with_values({"rotor.eccentricity.angle": 40.0})
    (angle,) = free_values(scene, ["rotor.eccentricity.angle"], {"rotor.eccentricity.angle": "-180:180"})
    assert (angle.guess, angle.low, angle.high, angle.unit) == (40.0, -180.0, 180.0, "deg")


@pytest.fixture
def files(measured, tmp_path, monkeypatch):
    """A folder with a measured run, `pump.toml`, and a scene, `guess.toml`."""
    monkeypatch.chdir(tmp_path)
    measured()
    (tmp_path / "guess.toml").write_text(guess().to_toml())
    return tmp_path


def test_a_rotor_that_turns_backwards_is_fitted_in_its_own_directions(tmp_path):
    """Values, ranges and the scene are those of the rotor as it turns, not of its mirror image, in which y has the other sign."""
    found = {}
    for sense, angle in ((1.0, 40.0), (-1.0, 140.0)):
        content = BALANCED | {"rotor": PUMP["rotor"] | {"eccentricity": [2e-5, angle]}}
        scene = rsc.Scene.from_dict(content | {"drive": {"speed": [sense * 40.0, sense * 44.0], "duration": 3.0}})
        measured = rsc.read_measured(write_measured(rsc.simulate(scene), tmp_path / "run.toml"))
        wrong = scene.with_values({"rotor.eccentricity.amount": 1.5e-5, "contact.friction": 0.24})
        found[sense] = rsc.fit(wrong, measured, ("rotor.eccentricity.amount", "contact.friction"),
                               {"rotor.eccentricity.amount": (1e-5, 4e-5)})  # fmt: skip
    fit = found[-1.0]
    assert fit.scene.drive.speed == (-40.0, -44.0) and fit.scene.rotor.eccentricity.angle == 140.0
    assert fit.values[0].value == pytest.approx(2e-5, rel=0.02) and fit.values[1].value == pytest.approx(0.2, rel=0.02)
    assert [one.value for one in fit.values] == pytest.approx([one.value for one in found[1.0].values], rel=1e-3)


def test_the_command_prints_values_and_writes_the_scene(files, capsys):
    arguments = ["fit", "guess.toml", "pump.toml", "--free", "contact.friction, contact.gap,stator.frequency", "-o", "new.toml"]
    assert main([*arguments, "--prior", "contact.gap=0.1 mm : 0.4 mm"]) == 0
    text = capsys.readouterr().out
    row = next(line for line in text.splitlines() if line.strip().startswith("contact.friction"))
    assert row.split()[1] == "0.24" and abs(float(row.split()[2]) - 0.2) < 0.003 and "written: new.toml" in text
    scene = rsc.load_scene("new.toml")
    assert abs(scene.contact.friction - 0.2) < 0.003 and scene.drive == guess().drive
    before = (files / "new.toml").read_bytes()
    assert main([*arguments, "--json"]) == 0  # over its own file
    content = json.loads(capsys.readouterr().out)
    assert content["converged"] and content["scene"]["contact"]["gap"] == pytest.approx(2.5e-4, rel=0.02)
    assert len(content["windows"]["use"]) == len(content["windows"]["residual"])
    assert before.startswith(b"# rsc fit: of")


def test_the_command_refuses_in_one_line(files, capsys):
    (files / "mine.toml").write_text("mine = 1\n")
    for more, code, told in (
        (["--free", "contact.fricton"], 2, "did you mean"),
        (["--free", "contact.gap", "--prior", "contact.gap=3"], 2, "a range that rises"),
        (["--free", "contact.friction", "--prior", "contact.friction=0.01:0.03"], 2, "no scene with contact.friction"),
        (["--free", "contact.gap", "-o", "mine.toml"], 4, "mine.toml"),
    ):
        assert main(["fit", "pump.toml", "guess.toml", *more]) == code, more
        lines = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("rsc: ")]
        assert len(lines) == 1 and told in lines[0]
    assert (files / "mine.toml").read_text() == "mine = 1\n" and not (files / "new.toml").exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP])
def test_an_interrupted_fit_tells_and_keeps_the_best_values(files, monkeypatch, capsys, number):
    added = rsc.study.fit.fit.added_about
    rounds = iter(range(100))

    def interrupted(*arguments):
        if next(rounds) == 1:
            signal.raise_signal(number)
            signal.raise_signal(number) if number == signal.SIGHUP else None  # it comes twice
        return added(*arguments)

    monkeypatch.setattr("rsc.study.fit.fit.added_about", interrupted)
    assert main(["fit", "pump.toml", "guess.toml", "--free", FOUND, "-o", "new.toml"]) == 130
    text = capsys.readouterr().out
    assert "warning: interrupted: the best values until then" in text and "not converged" in text and "written: new.toml" in text
    row = next(line for line in text.splitlines() if line.strip().startswith("contact.friction"))
    assert float(row.split()[2]) == pytest.approx(rsc.load_scene("new.toml").contact.friction, rel=0.01)


@pytest.mark.parametrize(("function", "call", "found"), [("least", 0, True), ("robust", 0, False), ("fitted", 0, True)])
def test_a_fit_may_be_interrupted_anywhere(measured, monkeypatch, function, call, found):
    """Before the first values nothing was found; behind the last step only the intervals are missing."""
    module = rsc.study.fit.fit if function == "fitted" else rsc.study.fit.search
    original, calls = getattr(module, function), iter(range(100))

    def stopping(*arguments):
        if next(calls) == call:
            raise KeyboardInterrupt
        return original(*arguments)

    monkeypatch.setattr(module, function, stopping)
    with pytest.raises(KeyboardInterrupt) as stop:
        rsc.fit(guess(), measured(), FOUND.split(","))
    assert hasattr(stop.value, "result") == found
    if found:
        fit = stop.value.result
        assert not fit.converged and fit.warnings[0].startswith("interrupted") and 0.05 < fit.scene.contact.friction < 1.0


def test_a_fit_that_has_not_converged_says_so_and_ends_with_its_code(files, monkeypatch, capsys):
    monkeypatch.setattr("rsc.study.fit.fit.ROUNDS", 1)
    assert main(["fit", "pump.toml", "guess.toml", "--free", FOUND]) == 3
    assert "not converged" in capsys.readouterr().out
