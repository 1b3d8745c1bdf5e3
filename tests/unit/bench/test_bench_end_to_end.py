"""Judge of bench/end_to_end.py: its engine has the equations of the slow twin, its lines are right, it finds wrong rows."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[3] / "bench"))
import end_to_end
import naive
import rsc
from end_to_end_engine import constants, integrate, line_near, lines, rate, synchronous_line
from end_to_end_scenes import ROTORS, STATORS, scene_text
from rsc.measure.verdict import ALONE
from rsc.measure.words import AGREES, NO_WHIRL
from rsc.study.start import initial_state
from rsc.system.assemble import assemble
from scenes import changed

RATE, LENGTH, GAP = 2000.0, 400, 1e-3
TIME = np.arange(LENGTH) / RATE


def circle(frequency, size=GAP, phase=0.3):
    return size * np.exp(1j * (2.0 * np.pi * frequency * TIME + phase))


def test_the_scenes_are_complete_and_of_every_kind():
    texts = [scene_text(5, number) for number in range(60)]
    scenes = [rsc.Scene.from_toml(text) for text, _ in texts]
    assert {scene.rotor.model for scene in scenes} == set(ROTORS)
    assert {scene.stator.model for scene in scenes} == set(STATORS)
    assert {scene.contact.diameter is None for scene in scenes} == {True, False}
    assert {scene.start.kind for scene in scenes} == {"rest", "whirl", "state"}
    assert scene_text(5, 7) == texts[7]


def test_the_engine_has_the_equations_of_the_slow_twin():
    dice, touched = np.random.default_rng(3), 0
    for number in range(25):
        system = assemble(rsc.Scene.from_toml(scene_text(5, number)[0]))
        c, matrices = constants(system)
        n = matrices.shape[2]
        c[:2] = system.schedule_speed[0], np.diff(system.schedule_speed)[0] / np.diff(system.schedule_time)[0]
        state = dice.normal(size=(2, 2 * n)) * system.gap * np.repeat([1.0, 100.0], n)
        y, t = state[0] + 1j * state[1], 0.1 * system.schedule_time[1]
        expected = naive.rhs(system)(t, y)
        found = rate(y.view(float).copy(), t, c, matrices).view(complex)
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12 * abs(expected).max())
        touched += abs(system.contact_r @ y[: system.n_rotor]) > system.gap
    assert touched > 5


def test_the_engine_follows_the_slow_twin_over_a_corner_of_the_schedule():
    scene = rsc.Scene.from_dict(
        changed(drive={"speed": None, "duration": None, "schedule": [[0.0, 50.0], [0.05, 55.0], [0.1, 55.0]]})
    )
    system, times = assemble(scene), np.linspace(0.0, 0.1, 201)
    start = initial_state(scene, system)
    rotor, stator = integrate(system, start, times)
    expected_r, expected_s = naive.integrate(system, start, times)
    assert np.abs(rotor - expected_r).max() < 1e-5 * system.gap > np.abs(stator - expected_s).max()


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


def rows(verdict, frequency=-40.0, amplitude=2.0 * GAP, synchronous=0.1 * GAP, **others):
    names = ("whirl frequency", "whirl amplitude", "synchronous line")
    values = (frequency, amplitude, synchronous)
    fixed = {"speed": 50.0, "contact": 1.0, "verdict": verdict, "branch": "A", "by": "balance", "note": ""} | others
    return [SimpleNamespace(quantity=q, predicted=v, simulated=v, **fixed) for q, v in zip(names, values, strict=True)]


def found(verdict, motion, **predicted):
    pieces = {"rotor": motion, "distance": motion, "stator": 0.0 * motion}
    turning = (2.0 * np.pi * 50.0 * TIME, 0.0)
    return [kind for kind, _ in end_to_end.judged(rows(verdict, **predicted), pieces, turning, RATE, GAP)]


def test_wrong_agreement_is_found_and_right_agreement_is_not():
    motion = circle(-40.0, 2.0 * GAP) + circle(50.0, 0.1 * GAP)
    assert found(AGREES, motion) == []
    assert found(AGREES, motion, frequency=-40.9) == ["agrees in frequency, wrongly"]
    assert found(AGREES, motion, frequency=-250.0)[0] == "agrees in frequency, wrongly"
    assert found(AGREES, motion, amplitude=2.1 * GAP) == ["agrees in amplitude, wrongly"]
    for by in ("balance", ALONE):  # without contact it is read in another way
        assert found(AGREES, motion, by=by) == []
        assert found(AGREES, motion, by=by, synchronous=0.15 * GAP) == ["agrees in the synchronous line, wrongly"]


def test_an_overlooked_whirl_is_found_in_contact_only():
    (kind,) = found(NO_WHIRL, circle(-40.0, 2.0 * GAP))
    assert kind == "a backward line called no whirl, rotor, in permanent contact"
    assert found(NO_WHIRL, circle(40.0, 2.0 * GAP)) == []
    assert found(NO_WHIRL, circle(-40.0, 0.5 * GAP)) == []
    assert found(NO_WHIRL, circle(-40.0, 2.0 * GAP), contact=0.0) == ["contact that rsc has not"]
