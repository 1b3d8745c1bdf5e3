"""When a run has settled, and which motions a start on them keeps and a disturbance ends."""

from dataclasses import replace

import numpy as np
import pytest

import rsc
from rsc.measure.kinds import Kind, Motion
from rsc.measure.stretches import COLUMNS, Facts
from rsc.study.motions.settle import STRETCHES, _Course, _is_steady

GAP = 1e-3
BLOCK = Facts(begin=0.0, **(dict.fromkeys(COLUMNS, 0.0) | {"end": 1.0, "turns": -40.0, "contact_time": 1.0, "rotor_max": GAP}))


def blocks(*sizes, kind=Kind.SLIDING):
    """Blocks of a motion with its largest |r| in gaps."""
    return [Motion(kind, "", -40.0, replace(BLOCK, rotor_max=size * GAP, deflection_max=size * GAP)) for size in sizes]


@pytest.mark.parametrize(
    ("sizes", "steady"),
    [
        ((1.2, 1.2), False),
        ((1.2, 1.2, 1.2), True),
        ((1.2, 1.205, 1.202), True),
        ((1.2, 1.2, 1.22), False),
        ((1.1, 1.195, 1.2, 1.2), True),
        ((1.2, 1.2, 1.2, 1.3), False),
    ],
)
def test_a_motion_is_steady_after_three_blocks_that_are_alike(sizes, steady):
    assert _is_steady(blocks(*sizes), [GAP]) == steady


def test_a_motion_without_contact_is_steady_once_it_only_decays():
    assert _is_steady(blocks(0.9, 0.5, 0.3, kind=Kind.NO_CONTACT), [GAP])
    assert not _is_steady(blocks(0.3, 0.5, 0.9, kind=Kind.NO_CONTACT), [GAP])
    assert not _is_steady([*blocks(1.2), *blocks(0.9, 0.9, kind=Kind.NO_CONTACT)], [GAP])


@pytest.mark.parametrize("seed", range(5))
def test_a_restless_motion_is_told_without_the_way_there(seed):
    """Twelve blocks, in the first of which the rotor still swings from its impact."""
    rng, rows = np.random.default_rng(seed), np.zeros((12 * STRETCHES, len(COLUMNS)))
    sizes = GAP * np.where(np.arange(len(rows)) < STRETCHES, 3.0, rng.uniform(1.1, 1.6, len(rows)))
    column = {name: rows[:, i] for i, name in enumerate(COLUMNS)}
    column["end"][:] = np.arange(len(rows)) + 1.0
    column["turns"][:], column["contact_time"][:], column["onsets"][:] = rng.uniform(-1.0, 3.0, len(rows)), 0.4, 2.0
    column["rotor_max"][:] = column["deflection_max"][:] = sizes
    course = _Course([GAP], 2.0)
    course.see(rows)
    motion, settled = course.ending(diverged=False, complete=True)
    assert settled and not course.steady and motion.kind == Kind.PARTIAL_RUB
    assert motion.facts.rotor_max == sizes[6 * STRETCHES :].max()


def test_a_whirl_that_only_a_start_on_itself_keeps_does_not_last():
    """The pump of the tutorial without unbalance: on the whirl of -69.4 Hz small motions grow with 11/s, from rounding."""
    scene = rsc.Scene.from_dict(
        {
            "rotor": {"model": "laval", "mass": 12.0, "frequency": 2600 / 60, "damping_ratio": 0.02},
            "stator": {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1},
            "contact": {"gap": 2.5e-4, "friction": 0.23, "stiffness": 5e7, "damping_ratio": 0.05, "diameter": 0.08},
            "drive": {"speed": 50.0, "duration": 1.0},
        }
    )
    (whirl,) = [whirl for whirl in rsc.predict(scene) if -70.0 < whirl.frequency < -60.0]
    assert whirl.growth_rate == pytest.approx(11.3, abs=0.1)
    listed = rsc.motions(scene, starts=0)
    assert [motion.motion for motion in listed.motions if motion.motion != Kind.NO_CONTACT] == [Kind.ROLLING, Kind.BOUNCING]
    assert all(np.isnan(motion.frequency) or abs(motion.frequency / whirl.frequency - 1.0) > 0.02 for motion in listed.motions)


@pytest.mark.parametrize(
    ("rolls", "kind", "away"),
    [(False, Kind.SLIDING, True), (True, Kind.SLIDING, False), (True, Kind.BOUNCING, False), (True, Kind.FORWARD_WHIRL, True),
     (True, Kind.PARTIAL_RUB, True)],
)  # fmt: skip
def test_a_backward_whirl_between_surfaces_with_a_diameter_does_not_run_away(rolls, kind, away):
    """However far it grows, its surfaces come to roll; without a diameter, or forward, nothing stops it."""
    course = _Course([GAP], 50.0, rolls=rolls)
    course.blocks = blocks(*(21.0 * 1.1**i for i in range(6)), kind=kind)
    assert course.runs_away == away
    course.blocks = blocks(*(3.0 * 1.1**i for i in range(6)), kind=kind)
    assert not course.runs_away
