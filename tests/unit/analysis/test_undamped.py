"""Undamped rotors of finite elements: poles are no whirls, and the search for branches ends."""

import time

import numpy as np
import pytest

import rsc
from fe_bodies import rotor
from rsc.analysis.follow import patience, walk
from rsc.analysis.follow.branches import branches
from rsc.analysis.follow.lines import UNRESOLVED
from rsc.analysis.survey.remarks import scene_remarks
from rsc.analysis.survey.survey import survey
from rsc.machine.imports.build import rotor_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.imports.store import save_model
from rsc.system.assemble import assemble
from systems import reference

STATORS = {
    "rigid": "model = \"rigid\"",
    "undamped": "model = \"laval\"\nmass = 3.0\nfrequency = 90.0",
    "damped": "model = \"laval\"\nmass = 3.0\nfrequency = 90.0\ndamping_ratio = 0.05",
}
SCENE = """
[rotor]
model = "machine"
file = "rotor.npz"
contact = {contact}
unbalance = [[1, "50 g*mm"]]
[stator]
{stator}
[contact]
gap = 1e-4
friction = 0.2
stiffness = 2e7
damping_ratio = 0.05
[drive]
speed = [0.0, 300.0]
duration = 10.0
"""


def scene_of(folder, stator, contact=1, bearing=((1e7, 1e7), (1e7, 1e7))):
    matrices, nodes, directions = rotor(n_elements=4, bearing=bearing)
    del matrices["damping"]
    save_model(rotor_model(matrices, Coordinates(nodes, directions), "a shaft", units="m"), folder / "rotor.npz")
    (folder / "scene.toml").write_text(SCENE.format(stator=STATORS[stator], contact=contact))
    return rsc.load_scene(folder / "scene.toml")


@pytest.mark.parametrize("stator", STATORS)
@pytest.mark.parametrize("bearing", [((1e7, 1e7), (1e7, 1e7)), ((1.3e7, 0.7e7), (1e7, 1e7))], ids=["alike", "unequal"])
def test_the_search_for_branches_ends(stator, bearing, tmp_path):
    """It took minutes: every pole of the rotor, which moves with the speed, was followed as a root without a phase."""
    system, started = assemble(scene_of(tmp_path, stator, bearing=bearing)), time.process_time()
    found = branches(system, np.linspace(0.0, 300.0, 31))
    assert time.process_time() - started < 20.0
    if stator == "damped":
        assert any(np.ptp(branch.speed) == 300.0 for branch in found)
    else:
        assert not any(branch.stable.any() for branch in found)


def test_a_long_search_says_how_far_it_is_and_has_an_end(monkeypatch):
    system, speeds, notes = reference("gyroscopic_disk_very_light"), np.linspace(5.0, 150.0, 30), []
    monkeypatch.setattr(patience, "EVERY", 0.0)
    full = branches(system, speeds, notes.append)
    assert notes[0] == "roots of the whirl condition are looked for, 0 of 30 values done"
    assert any(text.startswith("whirls are followed from value to value, ") for text in notes)
    assert notes[-1].startswith("whirls and their events are computed")
    monkeypatch.setattr(walk, "MOST_STEPS", 0)  # no curve can be followed
    lost = branches(system, speeds)
    assert sorted(w.frequency for b in lost for w in b.whirls) == sorted(w.frequency for b in full for w in b.whirls)
    assert UNRESOLVED in {b.begin.cause for b in lost} and UNRESOLVED not in {b.begin.cause for b in full}


@pytest.mark.parametrize("stator", STATORS)
@pytest.mark.parametrize("contact", [1, 2])
def test_no_whirl_is_rounding(stator, contact, tmp_path):
    """In the middle the contact does not see the modes with a node there, whose poles had whirls of 1e-10 N."""
    scene = scene_of(tmp_path, stator, contact)
    for whirls in rsc.predict(scene, [0.0, 170.0]):
        for whirl in whirls:
            assert whirl.normal_force > 1e-3 and whirl.conditions["psi_real"] < 1e9 and "psi_real" not in whirl.violated


def test_an_undamped_machine_is_told(tmp_path):
    remarks = {stator: scene_remarks(assemble(scene_of(tmp_path, stator)), []) for stator in STATORS}
    assert "rotor has no damping: no motion without contact dies away, and its resonances are without bound" in remarks["damped"]
    assert any(text.startswith("rotor and stator have no damping") for text in remarks["undamped"])
    assert not any("no damping" in text for text in scene_remarks(assemble(rsc.Scene.from_toml(DAMPED)), []))


def test_a_motion_that_nothing_damps_is_not_called_unstable(tmp_path):
    motions = survey(scene_of(tmp_path, "damped")).attractors[0.0]
    assert [motion.growth_rate for motion in motions if motion.kind == "no contact"] == [0.0]


DAMPED = """
[rotor]
model = "laval"
mass = 2.0
frequency = 30.0
damping_ratio = 0.01
[stator]
model = "rigid"
[contact]
gap = 1e-3
friction = 0.1
stiffness = 1e7
[drive]
speed = 20.0
duration = 1.0
"""
