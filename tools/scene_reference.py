"""The scene reference and the JSON Schema of scenes, written from the keys that src/rsc/scene declares.

    python tools/scene_reference.py            writes the tables of docs/users/scene.md, and docs/users/scene.schema.json
    python tools/scene_reference.py --check    says whether both are up to date (exit code 1: they are not)
"""

import argparse
import json
import sys
from dataclasses import fields
from functools import singledispatch
from itertools import combinations
from pathlib import Path

from rsc.scene.bodies.drawn import DISK, KINDS, SECTION, SLEEVE, DrawnReader
from rsc.scene.bodies.models import ROTORS, STATORS
from rsc.scene.bodies.part_list import BearingRowReader, ShaftPartReader
from rsc.scene.bodies.reduced import Reduction
from rsc.scene.bodies.shaft_keys import MaterialKeys, ShaftRotor
from rsc.scene.bodies.states import MagneticBearing, States
from rsc.scene.files.matrix_files import MatrixReader
from rsc.scene.keys.keys import OPTIONAL, REQUIRED
from rsc.scene.keys.nested import Ends, Inner, Tables
from rsc.scene.keys.readers import (
    LONGEST_NAME,
    Choice,
    Eccentricity,
    EccentricityReader,
    Flag,
    Integer,
    Keyed,
    Later,
    Listed,
    Name,
    Number,
    PairReader,
    PolarReader,
    Sequence,
    Text,
    plain,
)
from rsc.scene.reading import MAX_TITLE
from rsc.scene.tables.clearances import MAX_CLEARANCES, Clearance
from rsc.scene.tables.contacts import MAX_CONTACTS, Contact
from rsc.scene.tables.display import Display
from rsc.scene.tables.drive import Drive
from rsc.scene.tables.limits import Limits
from rsc.scene.tables.sections import Output, Solver
from rsc.scene.tables.start import Start
from rsc.units import DIMENSIONS, GRADE
from rsc.units.table import AMBIGUOUS, GROUPS, TOGETHER

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "users" / "scene.md"
MARK = "<!-- From here on written by tools/scene_reference.py. -->\n\n"
SCHEMA = ROOT / "docs" / "users" / "scene.schema.json"
BODIES = {"rotor": ROTORS, "stator": STATORS}
SECTIONS = {"contact": Contact, "drive": Drive, "start": Start, "solver": Solver, "output": Output}
SECTIONS |= {"reduction": Reduction, "clearance": Clearance, "limits": Limits, "report": Display}
INSIDE = {"states": States, "magnetic_bearings": MagneticBearing}  # tables inside a body
LISTED = ("clearance",)  # of which there may be any number
NEEDED = ["rotor", "stator", "contact", "drive"]
# a number and the name of a unit; that the unit fits the key is for rsc to check
UNIT_TEXT = r"^\s*[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?\s*(1\s*/\s*)?[A-Za-zµμ°%Ω][^\[\]{}]*$"
KEYWORDS = {">": "exclusiveMinimum", ">=": "minimum", "<": "exclusiveMaximum", "<=": "maximum"}


@singledispatch
def form(reader):
    """The JSON Schema of what a reader accepts, without the meaning of its key."""
    raise TypeError(f"no form for {reader!r}")


@form.register
def _(reader: Number):
    number = {"type": "number", **{KEYWORDS[sign]: bound for sign, bound in reader.bounds}}
    return {"anyOf": [number, {"$ref": f"#/$defs/{_identifier(reader.dimension)}"}]}


@form.register
def _(reader: Eccentricity):
    return {"anyOf": [*form(Number(reader.dimension))["anyOf"], {"type": "string", "pattern": f"^\\s*{GRADE}\\s*$"}]}


@form.register
def _(reader: Integer):
    return {"type": "integer", "minimum": reader.low, "maximum": reader.high}


@form.register
def _(reader: Flag):
    return {"type": "boolean"}


@form.register
def _(reader: Choice):
    return {"enum": list(reader.names)}


@form.register
def _(reader: Text):
    return {"type": "string", "minLength": 1, "maxLength": 500}


@form.register
def _(reader: Name):
    return {"type": "string", "pattern": f"^{reader.pattern}$"}


@form.register
def _(reader: Sequence):
    return {"type": "array", "items": form(reader.item)}


@form.register
def _(reader: Listed):
    return _places([form(item) for item in reader.items])


@form.register
def _(reader: Keyed):
    items = {name: form(item) for name, item in reader.items.items()}
    return {"type": "object", "properties": items, "required": list(items), "additionalProperties": False}


@form.register
def _(reader: Tables):
    return {"type": "array", "items": section_schema(reader.section), "minItems": reader.least}


@form.register
def _(reader: Inner):
    return section_schema(reader.section)


@form.register
def _(reader: DrawnReader):
    place, diameter = form(Number("length")), form(Number("length", low=0.0))
    return _places([form(Choice(KINDS)), {"type": "string"}, *[place] * 2, *[diameter] * 4])


@form.register
def _(reader: ShaftPartReader):
    numbers = [form(Number(dimension, low=0.0)) for dimension in ("length", "mass", "inertia", "inertia")]
    return _places([form(Choice((SECTION, SLEEVE, DISK))), {"type": "string"}, *numbers])


@form.register
def _(reader: BearingRowReader):
    eight = [form(Number(dimension)) for dimension in ("stiffness",) * 4 + ("damping",) * 4]
    return _places([{"type": "string"}, form(Number("length", low=0.0)), form(Number("frequency")), _places(eight)])


@form.register
def _(reader: Ends):
    item = form(reader.item)
    return {"anyOf": [item, _places([item] * 2)]}


@form.register
def _(reader: Later):
    return {"anyOf": [form(item) for item in reader.forms]}


@form.register
def _(reader: PolarReader):
    amount = form(reader.items[0])
    return {"anyOf": [amount, _places([amount, form(Number("angle in degrees"))])]}


@form.register
def _(reader: PairReader):
    return _places([form(Number(reader.dimension))] * 2)


@form.register
def _(reader: MatrixReader):
    if reader.entries:
        return _places([_places([form(entry) for entry in row]) for row in reader.entries])
    row = {"type": "array", "items": form(Number("dimensionless")), "minItems": 1}
    file = {"type": "string", "pattern": r"\.([nN][pP][zZ]|[mM][aA][tT]|[mM][tT][xX])$"}
    return {"anyOf": [{"type": "array", "items": row, "minItems": 1}, file]}


def _identifier(dimension):
    return dimension.replace(" ", "_")


def _places(forms):
    """A list in which every place has its own form."""
    return {"type": "array", "prefixItems": forms, "minItems": len(forms), "maxItems": len(forms)}


@singledispatch
def words(reader):
    """(kind, unit, range) of what a reader accepts, in words."""
    return reader.wanted, "", ""


@words.register
def _(reader: Number):
    unit = DIMENSIONS[reader.dimension][0]
    return "number", "" if unit == "1" else unit, " and ".join(f"{sign} {bound:g}" for sign, bound in reader.bounds)


@words.register
def _(reader: Integer):
    most = reader.high if reader.high < 1e6 else f"{reader.high:.3g}"
    return "whole number", "", f"{reader.low} to {most}"


@words.register
def _(reader: Name):
    return "name", "", f"letters, digits, `_`, at most {LONGEST_NAME}"


@words.register
def _(reader: Choice):
    return "text", "", ", ".join(f"`\"{name}\"`" for name in reader.names)


@words.register
def _(reader: Sequence):
    kind, unit, span = words(reader.item)
    return f"list, each a {kind}", unit, span


@words.register
def _(reader: Tables):
    return "list of tables, see below", "", ""


@words.register
def _(reader: Inner):
    return "table, see below", "", ""


@words.register
def _(reader: Ends):
    kind, unit, span = words(reader.item)
    return f"{kind}, or two, [left, right]", unit, span


@words.register
def _(reader: EccentricityReader):
    return "number, balance grade, or [one of them, angle in degrees]", DIMENSIONS[reader.dimension][0], ""


@words.register
def _(reader: PolarReader):
    return "number, or [amount, angle in degrees]", DIMENSIONS[reader.dimension][0], ""


def _default(section, item):
    """The default of a key in words."""
    default = item.metadata["default"]
    groups = [group for group in getattr(section, "one_of", ()) if item.name in group[0]]
    instead = [name for names, group_default in groups if group_default is None for name in names if name != item.name]
    if instead:
        return "required, or " + " and ".join(f"`{name}`" for name in instead)
    for _, group_default in groups:
        if group_default != OPTIONAL and item.name == group_default[0]:
            return _value(group_default[1])
    if default is REQUIRED:
        return "required"
    return _value(default)


def _value(value):
    """A default as TOML would write it; zeros and absent values in words."""
    value = plain(value)
    if value is None:
        return ""
    flat = json.dumps(value)
    if isinstance(value, list) and not flat.strip("[]0., "):
        return "zeros" if value else "none"
    return f"`{flat}`" if isinstance(value, (bool, str)) else f"{value:g}"


def _excludes(section, name):
    others = [other for names, _ in getattr(section, "one_of", ()) if name in names for other in names if other != name]
    return list(dict.fromkeys(others))


def table(section):
    """Markdown table of the keys of a section."""
    lines = ["| key | value | unit | range | default | meaning |", "|---|---|---|---|---|---|"]
    for item in fields(section):
        kind, unit, span = words(item.metadata["reader"])
        meaning = item.metadata["meaning"]
        others = _excludes(section, item.name)
        if others:
            meaning += " Not beside " + ", ".join(f"`{name}`" for name in others) + "."
        cells = (f"`{item.name}`", kind, unit, span, _default(section, item), meaning)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def page_text():
    """The page: what stands above the mark, written by hand, and the tables of the declared keys."""
    return PAGE.read_text(encoding="utf-8").partition(MARK)[0] + MARK + tables()


def tables():
    """The tables of the scene reference, one per table and model."""
    parts = []
    for name, models in BODIES.items():
        parts.append(f"## `[{name}]`\n\n`model` names the kind of {name}; each has keys of its own.")
        for model, section in models.items():
            title, keys = f"### `model = \"{model}\"` ({name})", fields(section)
            parts.append(f"{title}\n\n{_about(section)}" + (f"\n\n{table(section)}" if keys else " It has no other keys."))
            parts += _nested(section) if section is ShaftRotor else []
    parts += [f"### `{name}` of a body\n\n{_plain(own)}\n\n{table(own)}" for name, own in INSIDE.items()]
    for name, section in SECTIONS.items():
        absent = "" if name in NEEDED else " The whole table may be left out."
        head = f"[[{name}]]" if name in LISTED else f"[{name}]"
        parts.append(f"## `{head}`\n\n{ABOUT[name]}{absent}\n\n{table(section)}")
    units = ["| what | unit of a plain number | a text with a unit |", "|---|---|---|"]
    units += [f"| {name} | {unit} | `\"{text}\"` |" for name, (unit, text) in DIMENSIONS.items()]
    parts.append("## Units\n\nA text with a unit may stand for every number that has a unit.\n\n" + "\n".join(units))
    parts.append(f"### Names of units\n\n{ABOUT_UNITS}\n\n{names_of_units()}")
    return "\n\n".join(parts) + "\n"


def _nested(section):
    """The tables of the lists of a shaft, and of its materials."""
    parts = []
    for item in fields(section):
        readers = (item.metadata["reader"], *getattr(item.metadata["reader"], "forms", ()))
        parts += [(item.name, reader.section) for reader in readers if isinstance(reader, Tables)]
    named = [*parts, ("material", MaterialKeys)]
    return [f"#### Each of `{name}` of a shaft\n\n{own.__doc__}\n\n{table(own)}" for name, own in named]


def _plain(section):
    """The docstring of a section on one line."""
    return " ".join(section.__doc__.split())


def names_of_units():
    """Markdown table of the units that rsc reads by itself."""
    lines = ["| what | names |", "|---|---|"]
    for what, (_, named) in GROUPS.items():
        lines.append(f"| {what} | " + ", ".join(" = ".join(f"`{name}`" for name in names.split()) for names in named) + " |")
    lines.append("| written together | " + ", ".join(f"`{name}`" for name in TOGETHER) + " |")
    lines.append("| of an acceleration alone | `g` |")
    lines.append("| refused, since it can mean several things | " + ", ".join(f"`{name}`" for name in AMBIGUOUS) + " |")
    return "\n".join(lines)


ABOUT_UNITS = """Small and capital letters differ (`mN`, `MN`); `µ` may be written for `u`. Products are written `N s/m`,
`N*s/m`, `N·s/m` or `N-s/m`, powers `m^2`, `m2` or `m²`, quotients `N/m` or `N/(m/s)`; a division takes the next name only:
`N/m s` is N s/m. Other units may be spelled out, with a prefix where wanted, as pint knows them (`furlong`, `millimeter`).

Where several quantities stand in one range or list of an option, a unit that stands once holds for all: `600:6000 rpm:4`,
`0.1,0.2,0.3 mm`. Separate values, in the lists of a scene or the columns of a table, each need theirs: a plain number beside a
quantity in another unit is refused, unless it is 0."""


ABOUT = {
    "contact": "The contact of one coordinate of the rotor with one of the stator; its law: [physics](physics.md), section 2.\n"
    "Of several contacts, at most eight, each is a table `[[contact]]` with a `name` ([contacts](contacts.md)).",
    "drive": "The rotor speed over time: `speed` with `duration`, or a `schedule`.",
    "start": "The state at time 0: rest, a predicted whirl, or a state of your own.",
    "solver": "How the run is computed; which method and `rtol`: [choosing](choosing.md).",
    "output": "What is stored of the run.",
    "reduction": "How closely bodies of model `\"machine\"` are reduced; not kept in a result, whose bodies are `\"reduced\"`.",
    "clearance": f"A place that is only watched, without a force, of at most {MAX_CLEARANCES};\n"
    "what is told of it: [clearances](clearances.md).",
    "limits": "The operating speeds by which `rsc limits` and the page judge the unbalance response: [limits](limits.md).",
    "report": "In which units numbers are shown: [units](vibration.md).",
}


def _about(section):
    """What a model is: the first sentence of its docstring, after its name."""
    text = section.__doc__.rpartition("\": ")[2].partition("\n")[0]
    return text[0].upper() + text[1:]


def section_schema(section, model=None):
    """JSON Schema of one table."""
    properties, required = {}, []
    if model:
        properties["model"] = {"const": model, "description": _about(section)}
        required.append("model")
    for item in fields(section):
        meaning, default = item.metadata["meaning"], plain(item.metadata["default"])
        properties[item.name] = {"description": meaning, **form(item.metadata["reader"])}
        if item.metadata["default"] is REQUIRED:
            required.append(item.name)
        elif isinstance(default, (bool, int, float, str)):
            properties[item.name]["default"] = default
    rules = []
    for names, default in getattr(section, "one_of", ()):
        rules += [{"not": {"required": list(pair)}} for pair in combinations(names, 2)]
        if default is None:
            rules.append({"anyOf": [{"required": [name]} for name in names]})
    schema = {"type": "object", "properties": properties, "required": required, "additionalProperties": False}
    return schema | ({"allOf": rules} if rules else {})


def schema():
    """The JSON Schema (draft 2020-12) of a scene file."""
    sections = {name: {"description": ABOUT[name].partition(";")[0], **section_schema(item)} for name, item in SECTIONS.items()}
    bodies = {
        name: {
            "description": f"The {name}; `model` names its kind.",
            "required": ["model"],
            "oneOf": [section_schema(section, model) for model, section in models.items()],
        }
        for name, models in BODIES.items()
    }
    texts = {
        _identifier(name): {"type": "string", "pattern": UNIT_TEXT, "description": f"text such as \"{text}\"", "examples": [text]}
        for name, (_, text) in DIMENSIONS.items()
    }
    title = {"type": "string", "maxLength": MAX_TITLE, "description": "Title of the scene, shown in pictures."}
    for name in LISTED:
        texts[name] = sections[name]
        about, item = texts[name]["description"], {"$ref": f"#/$defs/{name}"}
        sections[name] = {"description": about, "type": "array", "items": item, "maxItems": MAX_CLEARANCES}
    texts["contact"], one = sections.pop("contact"), {"$ref": "#/$defs/contact"}
    alone = {"type": "array", "items": one, "minItems": 1, "maxItems": 1}
    several = {"type": "array", "items": {**one, "required": ["name"]}, "minItems": 2, "maxItems": MAX_CONTACTS}
    contact = {"description": texts["contact"]["description"], "anyOf": [one, alone, several]}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "rsc scene",
        "description": "A rotor, a stator, their contact and a run. Plain numbers are SI, frequencies and speeds Hz.",
        "type": "object",
        "properties": {"title": title, **bodies, "contact": contact, **sections},
        "required": NEEDED,
        "additionalProperties": False,
        "$defs": texts,
    }


def schema_text():
    """The JSON Schema as it is written."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


def page_is_current():
    """Whether the page has the tables of the declared keys."""
    return PAGE.read_text(encoding="utf-8") == page_text()


def schema_is_current():
    """Whether the file of the schema is the one of the declared keys."""
    return SCHEMA.read_text(encoding="utf-8") == schema_text()


def main():
    """Write both files, or compare them."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 where a file is not up to date")
    if parser.parse_args().check:
        old = [path.name for path, same in ((PAGE, page_is_current()), (SCHEMA, schema_is_current())) if not same]
        print("\n".join(f"not up to date: {name}; run python tools/scene_reference.py" for name in old) or "up to date")
        return int(bool(old))
    PAGE.write_text(page_text(), encoding="utf-8")
    SCHEMA.write_text(schema_text(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
