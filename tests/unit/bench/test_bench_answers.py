"""Judge of bench/answers.py: its engine has the equations of the slow twin, its labels are those of the definitions, it finds
false lines, and of some scenes it finds none."""

import re
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[3] / "bench"))
import answers
import answers_lines
import answers_motions
import answers_possible
import naive
import rsc
from answers_engine import Drive, State, accelerations, at_speed, integrate, machine_of
from answers_labels import Signals, kinds
from answers_motions import AtSpeed
from answers_scenes import KINDS, ROTORS, STATORS, scene_text
from answers_spectra import judged, line_near, lines, synchronous_line
from rsc.measure.verdict import ALONE, Row, Window
from rsc.measure.words import AGREES
from rsc.show.words.answer import answer
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from scenes import changed

RATE, LENGTH, GAP = 2000.0, 400, 1e-3
TIME = np.arange(LENGTH) / RATE
SOME = (1, 9, 21, 111)  # scenes judged here: diverging, impacts and a fast whirl


def circle(frequency, size=GAP, phase=0.3):
    return size * np.exp(1j * (2.0 * np.pi * frequency * TIME + phase))


def test_the_scenes_are_complete_and_of_every_kind():
    texts = [scene_text(5, number) for number in range(36)]
    scenes = [rsc.Scene.from_toml(text) for text, _ in texts]
    assert {scene.rotor.model for scene in scenes} == {*ROTORS, "reduced"}
    assert {scene.stator.model for scene in scenes} == {*STATORS, "reduced"}
    assert {scene.contact.diameter is None for scene in scenes} == {True, False}
    assert {scene.start.kind for scene in scenes} == {"rest", "whirl", "state", "running"}
    assert {words.split(":")[0].split(" of ")[0] for _, words in texts} == set(KINDS)
    assert scene_text(5, 7) == texts[7]


def test_the_engine_has_the_equations_of_the_slow_twin():
    dice, touched = np.random.default_rng(3), 0
    for number in range(36):
        system = assemble(rsc.Scene.from_toml(scene_text(5, number)[0]))
        machine, drive = machine_of(system), Drive.of(system.schedule_time, system.schedule_speed)
        n = len(machine.row)
        parts = dice.normal(size=(2, n, 2)) @ [1.0, 1j] * system.contact.gap * np.array([[1.0], [100.0]])
        t, found = 0.1 * system.schedule_time[1], np.empty(n, complex)
        accelerations(machine, drive, t, parts[0], parts[1], found)
        expected = naive.rhs(system)(t, parts.ravel())[n:]
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * abs(expected).max())
        touched += abs(machine.row @ parts[0]) > system.contact.gap
    assert touched > 5


def test_the_engine_follows_the_slow_twin_over_a_corner_of_the_schedule():
    scene = rsc.Scene.from_dict(
        changed(drive={"speed": None, "duration": None, "schedule": [[0.0, 50.0], [0.05, 55.0], [0.1, 55.0]]})
    )
    system = assemble(scene)
    start = initial_state(scene, system)
    run = integrate(machine_of(system), Drive.of(system.schedule_time, system.schedule_speed), State.of(start), 0.1)
    expected_r, expected_s = naive.integrate(system, start, run.time)
    assert np.abs(run.rotor - expected_r @ system.rotor.contact).max() < 1e-5 * system.contact.gap
    assert np.abs(run.stator - expected_s @ system.stator.contact).max() < 1e-5 * system.contact.gap


def test_the_steady_motion_without_contact_goes_on_as_it_is():
    for number in (0, 8, 20):  # directions alike, and not
        scene = rsc.Scene.from_toml(scene_text(5, number)[0])
        at = AtSpeed(assemble(scene), abs(scene.drive.speed[0]))
        free = at.running()
        if free is None:
            continue
        period = 1.0 / at.speed
        run = integrate(at.machine, at_speed(at.omega, period), free, period)
        assert np.abs(run.state.x - free.x).max() < 1e-6 * np.abs(free.x).max()


def motion(d, contact=True, speed=50.0, rolls=False, fed=1.0, driven=False, near=False):
    """Signals of a deflection d (n,), in contact where told."""
    signals = object.__new__(Signals)
    signals.time, signals.gap, signals.diverged, signals.driven, signals.d = TIME, GAP, False, driven, d
    signals.touch = np.broadcast_to(contact, d.shape) & True
    signals.rolls, signals.near, signals.fed = signals.touch & rolls, signals.touch & near, fed * signals.touch
    signals.turn, signals.shaft = np.unwrap(np.angle(d)) / (2.0 * np.pi), speed * TIME
    return signals


BLINKS = np.arange(LENGTH) % 10 < 4


@pytest.mark.parametrize(
    ("signals", "kind"),
    [
        (motion(circle(-80.0, 1.1 * GAP)), "backward whirl, sliding"),
        (motion(circle(-80.0, 1.1 * GAP), rolls=True), "backward whirl, rolling"),
        (motion(circle(-80.0, 1.1 * GAP), BLINKS), "bouncing backward whirl"),
        (motion(circle(-80.0, 1.1 * GAP), BLINKS, fed=-1.0), "partial rub"),
        (motion(circle(50.0, 1.1 * GAP)), "forward rub"),
        (motion(circle(70.0, 1.1 * GAP)), "forward whirl"),
        (motion(circle(50.0, 1.1 * GAP), BLINKS), "partial rub"),
        (motion(circle(70.0, 1.1 * GAP), ~BLINKS), "partial rub"),
        (motion(circle(70.0, 1.1 * GAP), ~BLINKS, driven=True), "forward whirl"),
        (motion(1.1 * GAP + circle(-80.0, 0.1 * GAP)), "resting on the stator"),
        (motion(1.2 * GAP * np.cos(400.0 * TIME) + 1e-6j * GAP, BLINKS), "partial rub"),
        (motion(circle(50.0, 0.5 * GAP), False), "no contact"),
        (motion(circle(-2.0, 1.1 * GAP), speed=3.0), "not resolved"),
    ],
)
def test_a_label_is_that_of_the_definition(signals, kind):
    assert kinds(signals, TIME[0], TIME[-1]) == {kind}


def test_near_a_limit_both_kinds_are_allowed():
    contact = np.arange(LENGTH) >= 0.012 * LENGTH
    assert kinds(motion(circle(-80.0, 1.1 * GAP), contact), TIME[0], TIME[-1]) == {
        "backward whirl, sliding",
        "bouncing backward whirl",
    }
    slips = motion(circle(-80.0, 1.1 * GAP), near=True)  # by as much as the limit between sliding and rolling
    assert kinds(slips, TIME[0], TIME[-1]) == {"backward whirl, sliding", "backward whirl, rolling"}


def test_lines_are_read_and_side_lobes_are_not():
    frequency, amplitude = lines(circle(-33.3) + circle(61.7, 0.1 * GAP), RATE)
    assert frequency == pytest.approx([-33.3, 61.7], abs=0.02)
    assert amplitude == pytest.approx([GAP, 0.1 * GAP], rel=2e-2)


@pytest.mark.parametrize("moves", [0.0, 3.0])
def test_a_line_at_rest_or_moving_is_read_in_the_middle(moves):
    middle = TIME - 0.5 * LENGTH / RATE
    piece = circle(-80.0) * np.exp(1j * np.pi * moves * (middle * RATE / LENGTH) ** 2)
    frequency, least, largest = line_near(piece, RATE, -81.0, moves)
    assert frequency == pytest.approx(-80.0, abs=0.02)
    assert least == pytest.approx(GAP, rel=2e-3) == largest


def test_the_synchronous_line_is_read_beside_a_whirl_unless_too_close():
    phi = 2.0 * np.pi * 50.0 * TIME
    value, blur = synchronous_line(circle(50.0, 0.1 * GAP) + circle(-30.0), phi)
    assert abs(value - 0.1 * GAP) < blur + 1e-9 and blur < 0.01 * GAP
    assert synchronous_line(circle(50.0, 0.1 * GAP) + circle(57.0, 0.1 * GAP), phi)[1] == np.inf


@pytest.mark.parametrize("seed", range(6))
def test_a_motion_that_changes_inside_the_window_makes_its_small_lines_doubtful(seed):
    dice, phi = np.random.default_rng(seed), 2.0 * np.pi * 50.0 * TIME
    begins = int(dice.integers(3, 40))  # sample with which the whirl has begun
    piece = circle(-dice.uniform(80.0, 300.0), dice.uniform(5.0, 50.0) * GAP) * (np.arange(LENGTH) >= begins)
    value, doubt = synchronous_line(piece + circle(50.0, 0.1 * GAP), phi)
    assert abs(value - 0.1 * GAP) < 2.0 * doubt
    assert synchronous_line(circle(50.0, 0.1 * GAP), phi)[1] < 1e-6 * GAP


@pytest.mark.parametrize("seed", range(6))
def test_the_whirl_s_own_line_is_that_of_the_deflection_and_not_of_a_free_vibration(seed):
    dice = np.random.default_rng(seed)
    size, f = dice.uniform(0.1, 0.5), -dice.uniform(60.0, 200.0)
    rotor = circle(f, size * GAP) + circle(0.3 * f, 2.0 * size * GAP) * np.exp(-3.0 * TIME)
    signals = motion(rotor + circle(f, 4.0 * GAP))
    signals.rotor = rotor
    report = SimpleNamespace(features=SimpleNamespace(kind=["backward whirl, rolling"]))

    def number(said, value, relative, absolute):
        return "" if abs(value(signals) - said) <= relative * said + absolute else "false"

    machine = SimpleNamespace(gap=GAP)
    witness = SimpleNamespace(report=report, signals=[signals], machine=machine, span=lambda i: (0.0, TIME[-1]), number=number)
    assert answers_lines._own_line(size * GAP, witness) == ""
    assert answers_lines._own_line(2.0 * size * GAP, witness) and answers_lines._own_line(0.7 * size * GAP, witness)


def rows(verdict, frequency=-40.0, amplitude=2.0 * GAP, synchronous=0.1 * GAP, **others):
    names = ("whirl frequency", "whirl amplitude", "synchronous line")
    values = (frequency, amplitude, synchronous)
    fixed = {"speed": 50.0, "time": 1.0, "contact": 1.0, "difference": 0.0, "verdict": verdict, "branch": "A"}
    fixed |= {"by": "balance"} | others
    return Window(*(Row(q, predicted=v, simulated=v, **fixed) for q, v in zip(names, values, strict=True)))


def found(verdict, motion, **predicted):
    pieces = {"rotor": motion, "distance": motion, "stator": 0.0 * motion}
    turning = (2.0 * np.pi * 50.0 * TIME, 0.0)
    return [kind for kind, _ in judged(rows(verdict, **predicted), pieces, turning, RATE, GAP)]


def test_wrong_agreement_is_found_and_right_agreement_is_not():
    motion = circle(-40.0, 2.0 * GAP) + circle(50.0, 0.1 * GAP)
    assert found(AGREES, motion) == []
    assert found(AGREES, motion, frequency=-40.9) == ["agrees in frequency, wrongly"]
    assert found(AGREES, motion, frequency=-250.0)[0] == "agrees in frequency, wrongly"
    assert found(AGREES, motion, amplitude=2.1 * GAP) == ["agrees in amplitude, wrongly"]
    for by in ("balance", ALONE):  # without contact it is read in another way
        assert found(AGREES, motion, by=by) == []
        assert found(AGREES, motion, by=by, synchronous=0.15 * GAP) == ["agrees in the synchronous line, wrongly"]


@pytest.fixture(scope="module")
def report():
    """A run that an impact brings to whirl backward: `near a whirl` of the tutorial's pump."""
    return rsc.check(rsc.Scene.from_dict(changed(start={"whirl": "backward"}, drive={"speed": [50.0, 55.0], "duration": 1.0})))


def wrong(report, topic, old, new):
    """Findings in a line of an answer in which something was exchanged."""
    text = dict(answer(report))[topic]
    assert re.search(old, text), text
    return [problem for problem in answers_lines.JUDGES[topic](re.sub(old, new, text), answers_lines.Witness(report)) if problem]


def test_no_line_of_an_answer_is_false(report):
    count, found = answers_lines.findings(report)
    assert count.total() > 6 and found == [] == answers.rows_of(report)


def test_false_lines_are_found(report):
    assert wrong(report, "whirl", "sliding", "rolling")
    assert wrong(report, "frequency", r"-(\d)\d", r"-\g<1>0")
    assert wrong(report, "vibration", r"up to \d", "up to 7")
    assert wrong(report, "vibration", r"orbit up to \d", "orbit up to 7")
    assert wrong(report, "closest approach", r"up to \d", "up to 7") and wrong(report, "closest approach", r"[\d.]+ %", "77 %")
    assert wrong(report, "force", "up to ", "up to 3")
    assert wrong(report, "at the end", "backward whirl, sliding", "partial rub")
    assert wrong(report, "check", "of ", "of 9")


def test_a_possible_motion_that_does_not_last_is_found(report):
    listed = report.motions[0]
    for said in [text for topic, text in answer(report) if topic == "after an impact"]:
        assert not [problem for problem in answers_possible.of_possible(said, answers_lines.Witness(report)) if problem]
    whirl = next(motion for motion in listed.motions if "backward" in motion.motion)
    at = AtSpeed(assemble(report.result.scene), listed.speed)
    claim = answers_motions.claim_of(whirl)
    starts = list(answers_motions.starts_of(at, listed, whirl))
    assert answers_motions.reached(at, claim, starts)[0] is not None
    assert answers_motions.reached(at, claim._replace(turning=0.9 * claim.turning), starts[-2:])[0] is None


@pytest.mark.parametrize("number", SOME)
def test_some_scenes_of_the_bench_have_no_false_line(number):
    case = answers.case_of(1, number, answers.judge_answer, False)
    assert case.lines.total() > 3, case.end
    assert [one for one in case.findings if not one.skipped] == []
