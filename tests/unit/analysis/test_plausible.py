"""Scenes whose numbers do not fit each other are told so, and those of the templates and the reference set are not."""

import numpy as np
import pytest

import rsc
from rsc.analysis.survey.plausible import plausibility_remarks, speed_remarks
from rsc.analysis.survey.remarks import scene_remarks
from rsc.cli import main
from rsc.scene.files.templates import template
from rsc.system.assemble import assemble
from systems import REFERENCE, reference_scene

MACHINE = {
    "rotor": {"model": "laval", "mass": 10.0, "frequency": 30.0, "damping_ratio": 0.02, "eccentricity": 1e-5},
    "stator": {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1},
    "contact": {"gap": 5e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05, "diameter": 0.1},
    "drive": {"speed": [20.0, 50.0], "duration": 0.5},
}
STIFFNESS = 10.0 * (2.0 * np.pi * 30.0) ** 2  # of the rotor, 355 N/mm


def machine(**values):
    return rsc.Scene.from_dict(MACHINE).with_values({key.replace("__", "."): value for key, value in values.items()})


@pytest.mark.parametrize("model", ["laval", "disk", "chain", "matrices"])
def test_templates_have_nothing_to_remark(model):
    assert plausibility_remarks(assemble(rsc.Scene.from_toml(template(model)))) == []


@pytest.mark.parametrize("name", sorted(path.stem for path in REFERENCE.glob("*.toml") if "." not in path.stem))
def test_the_reference_scenes_have_nothing_to_remark(name):
    assert plausibility_remarks(assemble(reference_scene(name))) == []


@pytest.mark.parametrize(
    ("right", "wrong", "told"),
    [
        ({"contact__diameter": 1.1e-3}, {"contact__diameter": 0.9e-3}, "the gap of 0.5 mm is larger than the contact's"),
        ({"contact__diameter": 3.18}, {"contact__diameter": 3.19}, "the surface at the contact moves at up to 501 m/s"),
        ({"contact__stiffness": 1.01 * STIFFNESS}, {"contact__stiffness": 0.99 * STIFFNESS}, "the contact (0.352 kN/mm) is"),
        ({"rotor__eccentricity": 4.9e-4}, {"rotor__eccentricity": [5.1e-4, 30.0]}, "the centre of mass lies 0.51 mm, 1.02 gaps,"),
        ({"rotor__load": [[0.0, -177.0]]}, {"rotor__load": [[178.0, 0.0]]}, "the load bends the rotor by 0.501 mm, 1.00 gaps,"),
        ({"contact__ring_eccentricity": 3.9e-4}, {"contact__ring_eccentricity": 4.1e-4}, "the contact ring is eccentric by 0.41"),
    ],
)
def test_what_does_not_fit_is_told_and_what_just_fits_is_not(right, wrong, told):
    assert plausibility_remarks(assemble(machine(**right))) == []
    (remark,) = plausibility_remarks(assemble(machine(**wrong)))
    assert remark.startswith(told)
    assert remark in scene_remarks(assemble(machine(**wrong)), [])


def test_a_rotor_without_stiffness_is_not_compared_with_its_contact():
    assert plausibility_remarks(assemble(machine(rotor__stiffness=0.0, rotor__gravity=9.81))) == []


def test_negative_damping_that_makes_the_free_rotor_unstable_is_told():
    """e^{-b t / 2m} with b < 0; damping of another coordinate does not hide it."""
    allowed = machine(rotor__damping=-40.0, rotor__allow_negative_damping=True)
    told = [text for text in scene_remarks(assemble(allowed), []) if "negative damping" in text]
    assert told == ["negative damping makes the rotor unstable without contact at a rotor speed of 20 Hz: it grows at 2 1/s"]
    assert not any("negative" in text for text in scene_remarks(assemble(machine()), []))


def test_a_speed_far_beyond_the_run_is_told(tmp_path, capsys):
    system = assemble(machine())
    assert speed_remarks(system, 2500.0) == [] and speed_remarks(system, 0.0) == []
    assert speed_remarks(system, 3000.0) == ["a rotor speed of 3000 Hz is 60 times the fastest of the run, 50 Hz: is it in Hz?"]
    path = tmp_path / "pump.toml"
    path.write_text(machine(contact__stiffness=1e5).to_toml())
    assert main(["predict", str(path), "--speed", "3000"]) == 0
    told = capsys.readouterr().out
    assert "60 times the fastest of the run" in told and "is softer than the rotor" in told


def test_check_notes_what_does_not_fit():
    report = rsc.check(machine(contact__ring_eccentricity=4.5e-4))
    assert any(text.startswith("the contact ring is eccentric") for text in report.warnings)
