"""Every declared key is consumed: it stands in a form, its class has it, and something beyond the scene reads it."""

import ast
import re
import tomllib
from dataclasses import dataclass, fields
from pathlib import Path

import pytest

import rsc
from rsc.errors import SceneError
from rsc.scene.bodies import models, shaft_keys, shafts
from rsc.scene.bodies.reduced import Reduction
from rsc.scene.keys.forms import Form, declared_in, exclusive
from rsc.scene.keys.keys import RawTable, declare, known_keys, read_table
from rsc.scene.keys.readers import Number
from rsc.scene.reading import SECTIONS
from rsc.scene.scene import Scene
from rsc.scene.tables.drive import Drive
from rsc.scene.tables.start import Start
from rsc.system.knots import FOLLOWING
from scenes import DRIVEN, LAVAL, changed
from shaft_scenes import text

SOURCES = Path(rsc.__file__).parent


def with_key(section, **attributes):
    """A class of keys like another one, with one more key `swing`."""
    more = {"swing": declare(Number("frequency"), None, meaning="Nothing yet.")}
    made = type(section.__name__, (section,), {"__annotations__": dict.fromkeys(more, object), **more, **attributes})
    return dataclass(frozen=True, kw_only=True)(made)


@pytest.mark.parametrize("section", [Drive, Start])
def test_a_declared_key_without_a_form_is_refused_when_its_class_is_made(section):
    with pytest.raises(TypeError, match=rf"{section.__name__}\.swing: a key must be declared and belong to a form"):
        declared_in(with_key(section))


@pytest.mark.parametrize("section", [Drive, Start])
def test_a_form_whose_key_is_not_declared_is_refused_when_the_class_is_made(section):
    forms = (*section.forms, Form(("swing",)))
    with pytest.raises(TypeError, match=r"swing: a key must be declared"):
        declared_in(type(section.__name__, (section,), {"forms": forms}))


def test_a_new_form_is_whole_and_alone(monkeypatch):
    """Half of it alone, another form beside it, and values by name: all follow from the table of forms."""
    forms = (*Drive.forms, Form(("swing", "duration")))
    swinging = declared_in(with_key(Drive, forms=forms, one_of=exclusive(forms)))
    monkeypatch.setattr("rsc.scene.tables.drive.Drive", swinging)
    monkeypatch.setitem(SECTIONS, "drive", swinging)
    for keys, message in (
        ({"swing": 3.0}, r"drive\.duration = \(missing\)"),
        ({"swing": 3.0, "duration": 1.0, "schedule": [[0, 1], [1, 2]]}, r"must be left out when duration is given"),
        ({"swing": 3.0, "duration": 1.0, "speed": 1.0}, r"drive\.swing = 3\.0: must be left out when speed is given"),
    ):
        with pytest.raises(SceneError, match=message):
            Scene.from_dict({**LAVAL, "drive": keys})
    with pytest.raises(KeyError, match="swing"):  # no reader makes a drive of this form
        Scene.from_dict({**LAVAL, "drive": {"swing": 3.0, "duration": 1.0}})


def test_a_key_that_a_reader_leaves_is_a_fault_that_names_it():
    values = read_table(with_key(Reduction), RawTable("a.toml", "reduction", {"swing": 3.0, "tolerance": 1e-3}))
    assert values["tolerance"] == 1e-3
    with pytest.raises(AssertionError, match=r"\[reduction\] swing is declared, but nothing uses it"):
        values.refuse_untaken()
    assert values["swing"] == 3.0
    values.refuse_untaken()


NESTED = {"sections[0]": "sections", "sleeves[0]": "sleeves", "disks[0]": "disks", "bearings[1]": "bearings", "load[0]": "load"}


@pytest.mark.parametrize("place", [*NESTED, "unbalance[0]", "material", ""])
def test_a_key_that_the_reader_of_a_shaft_leaves_is_a_fault_at_every_level(place, monkeypatch):
    scene, swing = tomllib.loads(text()), {"swing": 3.0}
    rotor = scene["rotor"]
    rotor |= {"material": {"density": 7850.0, "youngs_modulus": 2.1e11}, "load": [{"at": "0.5 m", "force": [1.0, 0.0]}]}
    rotor |= {"sleeves": [{"at": "0.2 m", "length": "0.1 m", "diameter": "70 mm"}]}
    rotor |= {"unbalance": [{"at": "0.5 m", "amount": "10 g mm"}]}
    Scene.from_dict(scene)
    if place in NESTED:
        key, _, number = place[:-1].partition("[")
        reader = next(item for item in fields(shaft_keys.ShaftRotor) if item.name == key).metadata["reader"]
        monkeypatch.setitem(vars(reader), "section", with_key(reader.section))
        rotor[key][int(number)] |= swing
    elif place == "":
        monkeypatch.setattr(shafts, "ShaftRotor", with_key(shaft_keys.ShaftRotor))
        rotor |= swing
    else:
        name = {"material": "MaterialKeys", "unbalance[0]": "UnbalanceKeys"}[place]
        monkeypatch.setattr(shafts, name, with_key(getattr(shaft_keys, name)))
        (rotor["material"] if place == "material" else rotor["unbalance"][0]).update(swing)
    where = re.escape(f"rotor.{place}" if place else "rotor")
    with pytest.raises(AssertionError, match=rf"\[{where}\] swing is declared, but nothing uses it"):
        Scene.from_dict(scene)


@pytest.mark.parametrize(("key", "value"), [("bore", "20 mm"), ("material", "steel")])
def test_a_key_of_a_shape_beside_the_masses_of_a_disk_is_refused(key, value):
    scene = tomllib.loads(text())
    scene["rotor"]["disks"] = [{"at": "0.5 m", "mass": 5.0, "polar_inertia": 0.02, "diametral_inertia": 0.01, key: value}]
    with pytest.raises(SceneError, match=rf"rotor\.disks, disk 1, {key} = .*left out where mass and inertias are given"):
        Scene.from_dict(scene)


def test_values_by_name_leave_a_form_for_another():
    driven = Scene.from_dict(DRIVEN)
    assert driven.with_values({"drive.schedule": [[0, 1], [1, 2], [2, 5]]}).drive.speed == (1.0, 2.0, 5.0)
    with pytest.raises(SceneError, match=r"drive\.speed = \(missing\): must be given, or instead of it schedule"):
        Scene.from_dict({**DRIVEN, "drive": {"schedule": [[0, 1], [1, 2], [2, 5]]}}).with_values({"drive.inertia": 0.1})
    moved = Scene.from_dict(LAVAL).with_values({"start.whirl": -60.0})
    assert (moved.start.kind, moved.with_values({"start.centre": True}).start.kind) == ("whirl", "centre")


@pytest.mark.parametrize(
    ("keys", "missing"),
    [
        ({"inertia": 0.1, "speed": 10.0, "duration": 1.0}, "torque"),
        ({"torque": [[0.0, 1.0], [50.0, 0.0]], "speed": 10.0, "duration": 1.0}, "inertia"),
        ({"trip": 0.5, "speed": 10.0, "duration": 1.0}, "inertia"),
        ({"coast": [[0.0, -1.0]], "speed": 10.0, "duration": 1.0}, "inertia"),
        ({"speed": 10.0}, "duration"),
    ],
)
def test_half_of_a_form_is_refused(keys, missing):
    with pytest.raises(SceneError, match=rf"drive\.{missing} = \(missing\)"):
        Scene.from_dict({**changed(contact={"diameter": 0.05}), "drive": keys})


def loaded_names():
    """Names of all attributes that src/rsc reads, and of its texts, which `getattr` may be given."""
    names = set()
    for path in SOURCES.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load):
                names.add(node.attr)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and re.fullmatch(r"\w+", node.value):
                names.add(node.value)
    return names


def test_every_declared_key_is_read_somewhere():
    """A key that is only declared, read and stored has no effect, which nobody would notice."""
    sections = [*SECTIONS.values(), *models.ROTORS.values(), *models.STATORS.values()]
    declared = {f"{section.__name__}.{item.name}": item.name for section in sections for item in fields(section)}
    names = loaded_names() | {f"{name}_{end}" for name in FOLLOWING for end in ("knots", "until")}  # these are put together
    assert not {where for where, name in declared.items() if name not in names}
    assert "swing" not in names


def test_each_class_of_keys_is_one_table():
    """No class stands for a table twice: all that is declared is a field of what a scene holds."""
    scene = Scene.from_dict(DRIVEN)
    for name, section in (("drive", Drive), ("start", Start)):
        assert type(getattr(scene, name)) is section
        assert set(known_keys(section)) == {item.name for item in fields(section)}
