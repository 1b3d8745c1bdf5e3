"""What `rsc predict` prints can be had in Python, value by value."""

import json

import pytest

import rsc
from rsc.cli import main
from rsc.show.words.plain import plain, survey_plain, whirls_plain
from rsc.study.prediction.predictions import predictions, surveyed
from systems import REFERENCE, reference_scene

SCENE = str(REFERENCE / "gyroscopic_figure3_right.toml")


def printed(capsys, *words):
    assert main(["predict", SCENE, "--json", *words]) == 0
    return json.loads(capsys.readouterr().out)


def test_predictions_at_speeds_are_those_of_the_command(capsys):
    told = predictions(reference_scene("gyroscopic_figure3_right"), [43.0, 80.0])
    assert [whirls_plain(at.whirls, at.ratios) for at in told] == printed(capsys, "--speed", "43", "80")
    assert main(["predict", SCENE, "--speed", "43", "80"]) == 0
    lines = capsys.readouterr().out.splitlines()
    remarks = [remark for at in told for remark in at.remarks]
    assert remarks and all(remark in lines for remark in remarks)


def test_sensitivities_come_with_them(capsys):
    (told,) = predictions(reference_scene("gyroscopic_figure3_right"), [43.0], sensitive=True)
    assert plain(told.sensitivity) == printed(capsys, "--speed", "43", "--sensitivity")[0]["sensitivity"]


def test_a_rotor_that_turns_backwards_is_told_in_the_mirror_image(capsys):
    scene, notes = reference_scene("gyroscopic_figure3_right"), []
    (backwards,), (forward,) = predictions(scene.mirrored(), [-43.0], note=notes.append), predictions(scene, [43.0])
    assert [w.frequency for w in backwards.whirls] == pytest.approx([w.frequency for w in forward.whirls], rel=1e-12)
    assert len(notes) == 1 and "mirror image" in notes[0]
    with pytest.raises(rsc.SceneError, match="at least 0 Hz"):
        predictions(scene, [-43.0, 43.0])


def test_the_survey_is_that_of_the_command(capsys):
    assert json.loads(json.dumps(survey_plain(surveyed(reference_scene("gyroscopic_figure3_right"))))) == printed(capsys)
