"""A motion without contact that cannot touch again, beside runs of the simulation."""

import numpy as np
import pytest

import rsc
from rsc.analysis.alone.clear import Clear
from rsc.analysis.paper.anisotropy import unbalance_ellipse
from rsc.measure.stretches import side_by_side
from rsc.simulation.run import InitialState
from rsc.simulation.shot import Shot, packed_for_shots
from rsc.system.assemble import assemble
from scenes import changed

SPEED, STRETCH, LONG = 40.0, 0.05, 5.0
UNBALANCED = {"eccentricity": 1e-4, "gravity": 9.81}


def states(scene, seed):
    """Random states about the size of the gap, of rotor and stator."""
    dice, gap = np.random.default_rng(seed), scene.contact.gap
    sizes = dice.uniform(0.0, 0.7, 4) * gap * np.array([1.0, 190.0, 0.3, 280.0])
    turn = np.exp(2j * np.pi * dice.uniform(size=4))
    return [np.array([size * one]) for size, one in zip(sizes, turn, strict=True)]


@pytest.mark.parametrize("seed", range(6))
def test_what_is_said_to_stay_clear_never_touches(seed):
    scene = rsc.Scene.from_dict(changed(rotor=UNBALANCED)).steady(SPEED, LONG)
    system = assemble(scene)
    clear, parts = Clear(system, 2.0 * np.pi * SPEED), states(scene, seed)
    packed = packed_for_shots(system, scene, STRETCH)
    shot = Shot(packed, InitialState(*parts), 0.3)
    assert clear.known
    stays = clear.stays(parts, 0.3)
    while shot.advance(2_000):
        pass
    touches = bool(side_by_side(shot.facts(), 1)[0].contact_time.any())
    assert not (stays and touches)
    if not touches:  # in the end at least the free vibrations are gone
        state = shot.state()
        assert clear.stays((state.rotor, state.rotor_velocity, state.stator, state.stator_velocity), shot.turns)


def test_the_bound_of_a_laval_rotor_without_damping_is_exact():
    scene = rsc.Scene.from_dict(changed(rotor={"damping_ratio": 0.0, "eccentricity": 1e-4}))
    system, omega = assemble(scene), 2.0 * np.pi * 30.0
    steady = float(abs(unbalance_ellipse(system, 2.0 * np.pi * SPEED)[0] @ system.rotor.contact))
    clear, still = Clear(system, 2.0 * np.pi * SPEED), np.zeros(1, complex)
    base = unbalance_ellipse(system, 2.0 * np.pi * SPEED)[0]
    for share, stays in ((0.999, True), (1.001, False)):
        size = share * (scene.contact.gap - steady)  # along a line: two circles of half of it
        parts = base + size, 2j * np.pi * SPEED * base, still, still
        assert clear.stays(parts, 0.0) == stays
        circle = base + size, 2j * np.pi * SPEED * base + 1j * omega * size, still, still
        assert clear.stays(circle, 0.0) == stays


@pytest.mark.parametrize(
    "rotor",
    [
        {"damping_ratio": None, "damping": -2.0, "allow_negative_damping": True},
        {"model": "laval", "mass": 1.0, "stiffness": 0.0, "damping": 0.0},
        {"eccentricity": 1e-2},
    ],
    ids=["grows", "nothing holds it", "touches by its unbalance"],
)
def test_where_it_cannot_be_told_nothing_is_claimed(rotor):
    scene = rsc.Scene.from_dict(changed(rotor=rotor))
    clear, still = Clear(assemble(scene), 2.0 * np.pi * 30.0), np.zeros(1, complex)
    assert not clear.known or not clear.stays((still, still + 0.01, still, still), 0.0)
