"""The scene reference and its JSON Schema: up to date, and of one mind with the reader of scenes."""

import sys
import tomllib
from dataclasses import fields
from pathlib import Path

import jsonschema
import pytest

from rsc import Scene, SceneError, load_scene
from rsc.scene.files.templates import MODELS, template
from rsc.scene.reading import all_keys

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists())
sys.path.append(str(ROOT / "tools"))

import scene_reference  # noqa: E402

SCENES = [path for path in sorted((ROOT / "data" / "reference").glob("*.toml")) if ".expected" not in path.name]
SCHEMA = scene_reference.schema()
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)

# what people write by mistake: a template with some keys changed (None: left out)
WRONG = {
    "unknown key": ("laval", {"contact.frictoin": 0.2}),
    "unknown table": ("laval", {"solvers": {"rtol": 1e-6}}),
    "unknown model": ("laval", {"rotor.model": "jeffcott"}),
    "key of another model": ("laval", {"rotor.masses": [1.0]}),
    "no rotor": ("laval", {"rotor": None}),
    "no gap": ("laval", {"contact.gap": None}),
    "no mass": ("chain", {"rotor.masses": None}),
    "negative gap": ("laval", {"contact.gap": -1e-3}),
    "zero mass": ("laval", {"rotor.mass": 0}),
    "friction in percent": ("laval", {"contact.friction": 20}),
    "ratio in percent": ("laval", {"rotor.damping_ratio": 2}),
    "frequency and stiffness": ("laval", {"rotor.stiffness": 1e5}),
    "neither frequency nor stiffness": ("laval", {"rotor.frequency": None}),
    "speed and schedule": ("laval", {"drive.schedule": [[0, 20], [30, 100]]}),
    "speed without duration": ("laval", {"drive.duration": None}),
    "three speeds": ("laval", {"drive.speed": [10, 20, 30]}),
    "corner of three": ("laval", {"drive": {"schedule": [[0, 20, 1], [30, 100]]}}),
    "number as text without unit": ("laval", {"contact.gap": "0.001"}),
    "comma": ("laval", {"contact.gap": "0,2 mm"}),
    "method": ("laval", {"solver.method": "rk4"}),
    "rtol of one": ("laval", {"solver.rtol": 1}),
    "steps by half": ("laval", {"solver.max_steps": 1.5}),
    "whirl": ("laval", {"start.whirl": "forward"}),
    "two starts": ("laval", {"start.rest": True}),
    "matrix of one row": ("disk", {"rotor.stiffness": [[1e5, 0.0]]}),
    "matrix file of another kind": ("matrices", {"rotor.mass": "mass.csv"}),
    "flag as number": ("laval", {"rotor.allow_negative_damping": 1}),
    "eccentricity of three": ("laval", {"rotor.eccentricity": [1e-5, 0, 0]}),
    "title as number": ("laval", {"title": 5}),
}


def changed(model, values):
    """Content of a template with some keys changed."""
    content = tomllib.loads(template(model))
    for dotted, value in values.items():
        *tables, key = dotted.split(".")
        place = content[tables[0]] if tables else content
        if value is None:
            del place[key]
        else:
            place[key] = value
    return content


def faults(content):
    """Messages of the schema about a scene."""
    return [error.message for error in VALIDATOR.iter_errors(content)]


def test_page_and_schema_are_up_to_date():
    """After a change of the declared keys: python tools/scene_reference.py."""
    assert scene_reference.page_is_current()
    assert scene_reference.schema_is_current()


def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_reference_scenes_fit(path):
    assert not faults(tomllib.loads(path.read_text(encoding="utf-8")))
    assert not faults(load_scene(path).to_dict())  # written out with every default


@pytest.mark.parametrize("model", MODELS)
def test_templates_fit(model):
    assert not faults(tomllib.loads(template(model)))
    assert not faults(Scene.from_toml(template(model)).to_dict())


@pytest.mark.parametrize("name", WRONG)
def test_wrong_scenes_are_refused_by_schema_and_reader(name):
    content = changed(*WRONG[name])
    assert faults(content)
    with pytest.raises(SceneError):
        Scene.from_dict(content)


def test_schema_and_page_have_every_key():
    page = scene_reference.PAGE.read_text(encoding="utf-8")
    for dotted in all_keys():
        table, _, key = dotted.rpartition(".")
        parts = SCHEMA["$defs"][table] if table in SCHEMA["$defs"] else SCHEMA["properties"][table] if table else SCHEMA
        properties = [part["properties"] for part in parts.get("oneOf", [parts])]
        assert any(key in own for own in properties), dotted
        assert f"`{key}`" in page, dotted


def test_every_key_says_what_it_means_in_one_sentence():
    sections = [*scene_reference.ROTORS.values(), *scene_reference.STATORS.values(), *scene_reference.SECTIONS.values()]
    meanings = [item.metadata["meaning"] for section in sections for item in fields(section)]
    assert len(meanings) > 50
    assert all(meaning.endswith(".") and len(meaning) > 15 and ". " not in meaning for meaning in meanings)
