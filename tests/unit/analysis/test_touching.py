"""The impulse that just touches, by closed forms and beside runs of the simulation."""

from dataclasses import replace

import numpy as np
import pytest

import rsc
from rsc.analysis.alone.touching import touching_impulses
from rsc.measure.stretches import side_by_side
from rsc.simulation.run import InitialState
from rsc.simulation.shot import Shot, packed_for_shots
from rsc.system.assemble import assemble
from scenes import SCENES, changed
from tiers import nightly
from two_seals import pump

ANGLES = np.deg2rad([0.0, 70.0, 135.0])
DIFFERING = {
    "model": "chain", "masses": [1.0, 2.0, 1.5], "stiffnesses": [3e4, 2e4, 4e4, 1e4], "damping_ratio": 0.02, "gravity": 9.81,
    "supports": [[0, [1e4, 0.0, 0.0, 6e4], [8.0, 0.0, 0.0, 30.0]]],
}  # fmt: skip


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.3])
def test_of_a_laval_rotor_it_is_that_of_a_damped_oscillator(ratio):
    scene = rsc.Scene.from_dict(changed(rotor={"damping_ratio": ratio}))
    omega, gap = 2.0 * np.pi * 30.0, scene.contact.gap
    times = np.linspace(0.0, 0.25 / 30.0, 100_000)
    damped = omega * np.sqrt(1.0 - ratio**2)
    largest = (np.exp(-ratio * omega * times) * np.sin(damped * times)).max() / damped
    own = touching_impulses(assemble(scene), 2.0 * np.pi * 50.0, 0, 0.25 / 30.0, ANGLES)
    assert own == pytest.approx(np.full((3, 1), gap / largest), rel=1e-5)


def test_of_a_rotor_that_nothing_holds_it_is_that_of_a_drift():
    scene = rsc.Scene.from_dict(changed(rotor={"model": "laval", "mass": 2.0, "stiffness": 0.0, "damping": 10.0}))
    own = touching_impulses(assemble(scene), 300.0, 0, 0.01, ANGLES[:1])
    assert own[0, 0] == pytest.approx(scene.contact.gap * 10.0 / (1.0 - np.exp(-10.0 / 2.0 * 0.01)), rel=1e-9)


@pytest.mark.parametrize(
    "scene",
    [rsc.Scene.from_dict(SCENES["gyroscopic disk"]), rsc.Scene.from_dict(SCENES["chains"]), pump(),
     nightly(rsc.Scene.from_dict(changed(SCENES["chains"], rotor=DIFFERING)))],
    ids=["disk", "chain", "two contacts", "supports"],
)  # fmt: skip
def test_a_little_more_touches_and_a_little_less_does_not(scene):
    speed, rise = 40.0, 0.01
    system = assemble(scene.steady(speed, rise))
    quiet = replace(system.rotor, unbalance=0.0 * system.rotor.unbalance, unbalance_euler=0.0 * system.rotor.unbalance_euler,
                    load=0.0 * system.rotor.load)  # fmt: skip
    contacts = tuple(replace(contact, ring=0j, offset=0j) for contact in system.contacts)
    packed = packed_for_shots(replace(system, rotor=quiet, contacts=contacts), scene, rise)
    for place, contact in enumerate(contacts):
        sizes = touching_impulses(system, 2.0 * np.pi * speed, place, rise, ANGLES).min(axis=1)
        change = np.linalg.solve(system.rotor.mass, contact.rotor)
        for size, angle in zip(sizes.tolist(), ANGLES.tolist(), strict=True):
            for share, touches in ((0.999, False), (1.001, True)):
                still, stator = np.zeros(system.n_rotor, complex), np.zeros(system.n_stator, complex)
                shot = Shot(packed, InitialState(still, share * size * np.exp(1j * angle) * change, stator, stator))
                while shot.advance(2_000):
                    pass
                each = side_by_side(shot.facts(), len(contacts))
                assert any(own.contact_time.any() for own in each) == touches

