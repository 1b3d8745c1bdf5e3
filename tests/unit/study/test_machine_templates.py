"""Machines of `rsc new`: they load as they are, say where their numbers come from, and are stable without contact."""

import re

import pytest

import rsc
from rsc.analysis.alone.modes import modes
from rsc.cli import main
from rsc.scene.files.templates import ABOUT, MACHINES, template

KEYS = r"title|model|rate|start|rest|whirl"


@pytest.mark.parametrize("machine", MACHINES)
def test_a_machine_loads_and_its_rotor_is_stable(machine):
    scene = rsc.Scene.from_toml(template(machine))
    assert scene.rotor.model == "reduced" and scene.start.kind == "rest"
    assert all(mode.growth_rate < 0.0 for mode in modes(scene, max(scene.drive.speed)).rotor)
    assert all(contact.diameter > 0.0 for contact in scene.contacts)
    assert rsc.Scene.from_toml(scene.to_toml()) == scene


@pytest.mark.parametrize("machine", MACHINES)
def test_every_number_has_a_source_or_is_a_guess(machine):
    """On its line, on the head of its list, or on the comment line above."""
    told = False
    for line in template(machine).splitlines():
        told = told if line.startswith("  ") and told else False
        told = told or any(word in line for word in ("(guess)", "ISO ", "EN ", "poles at"))
        number = re.search(r"= .*\d", line.partition("#")[0]) or re.search(r"^  \{", line)
        exempt = re.match(rf"{KEYS}|duration|gravity|at =|speed = \[|\[|#", line)
        assert not number or told or exempt, line


def test_new_lists_all(capsys):
    assert main(["new"]) == 0
    told = capsys.readouterr().out
    assert all(f"rsc new {name} " in told for name in ABOUT) and len(told.splitlines()) == len(ABOUT)


def test_new_writes_a_file_and_replaces_none_that_was_edited(tmp_path, capsys):
    path = tmp_path / "rig.toml"
    assert main(["new", "rig", "--start", "whirl", "-o", str(path)]) == 0
    assert path.read_text(encoding="utf-8").startswith(template("rig", "whirl"))
    assert "whirl = \"backward\"" in template("rig", "whirl")
    assert main(["new", "fan", "-o", str(path)]) == 0 and path.read_text(encoding="utf-8").startswith(template("fan", None))
    path.write_text(path.read_text().replace("title = ", "title = # mine\n", 1))
    mine = path.read_text()
    assert main(["new", "fan", "-o", str(path)]) == 4
    assert path.read_text() == mine and "did not write that file" in capsys.readouterr().err
