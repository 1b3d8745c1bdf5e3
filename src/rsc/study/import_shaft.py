"""`rsc import ross MODEL.toml`: the model file of ROSS into a scene with a shaft by its stations; ROSS need not be installed."""

import os
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from rsc.errors import DataError, one_line
from rsc.files.mark import CSV, TOML
from rsc.files.output import OutputFile, put_all, target
from rsc.machine.model.contact import body_of
from rsc.machine.shaft.assembly import model_of
from rsc.machine.shaft.parts import Material, Section, Shaft, Support
from rsc.machine.shaft.ross_model import shaft_of
from rsc.scene.files.toml_file import tables_of, text_of
from rsc.scene.files.toml_text import toml_value
from rsc.study.import_model import guesses, tried

_UNITS = {"k": "N/m", "c": "N s/m"}
_COLUMNS = ["speed [Hz]", *(f"{letter}_{pair} [{unit}]" for letter, unit in _UNITS.items() for pair in ("yy", "yz", "zy", "zz"))]
_SCENE = """\
# Written by `rsc import`. The shaft is the imported one, a section for each element; (guess): yours to change.
title = {title}

[rotor]
model = "shaft"
elements = 1                    # between two stations each, as in {source}; without this line as many as are needed
{keys}sections = [
{sections}]
sleeves = [
{sleeves}]
disks = [
{disks}]
bearings = [
{bearings}]
unbalance = [{{at = {at}, amount = "G 6.3"}}]   # (guess)

[stator]
model = "laval"                 # (guess)
mass = {stator_mass:.4g}
frequency = {stator_frequency:.4g}
damping_ratio = 0.05

[contact]
at = {at}
gap = "0.2 mm"                  # (guess)
friction = 0.15                 # (guess)
stiffness = {contact_stiffness:.4g}            # (guess) N/m: 100 times the static stiffness of the rotor there
damping_ratio = 0.05            # (guess)

[drive]
speed = ["0 rpm", "{top:.0f} rpm"]   # (guess)
duration = 20.0                 # s

[start]
rest = true                     # does the rotor get into a whirl? whirl = "backward": does it stay on a predicted one?
"""


def import_shaft(
    path: str | os.PathLike[str], output: str | os.PathLike[str], contact: Any, overwrite: bool = False
) -> str:
    """Write a scene with a shaft by its stations, and the tables of its bearings beside it.

    Parameters
    ----------
    path : path
        Model file of ROSS, .toml.
    output : path
        The scene to begin with, .toml.
    contact : str or (str, str, float)
        Node where it touches, or a place between two.
    overwrite : bool
        Whether files that rsc did not write are replaced.

    Returns
    -------
    str
        What was written, in lines for people.

    Raises
    ------
    DataError, SceneError
        Not such a file, elements that cannot be stations, no such node, or a file that is there already.
    """
    output, source = Path(output), one_line(path)
    shaft, notes = shaft_of(tables_of(text_of(Path(path), "a model of ROSS", "rotor.save writes one"), source), source)
    if output.suffix != ".toml":
        raise DataError(one_line(output), "must be a scene (.toml)")
    place = _place(shaft, contact, source)
    shaft.places["contact"] = place
    model = model_of(shaft, shaft.stations, source)
    tables = {output.with_name(f"{output.stem}_{i}.csv"): one for i, one in enumerate(shaft.supports) if len(one.speeds) > 1}
    for file in (output, *tables):
        target(file, TOML if file == output else CSV, overwrite)
    title = toml_value(one_line(Path(path).stem)[:80])
    words = {"title": title, "source": Path(source).name, "at": f"{place:.12g}", **_stations(shaft, tables)}
    text = _SCENE.format(**words, **guesses(model, body_of(model, ["contact"])))
    scene = OutputFile(output, text.encode(), TOML)
    beside = [OutputFile(file, _csv(one).encode(), CSV) for file, one in tables.items()]
    origin: str = getattr(tried(scene, beside).rotor, "origin", "")
    put_all([*beside, scene], overwrite)
    told = [f"written: {', '.join(map(one_line, (output, *tables)))}", *notes, origin.partition(", contact at")[0]]
    return "\n".join(told)


def _place(shaft: Shaft, contact: Any, source: str) -> float:
    """Place in m of a node, or between two."""
    nodes = shaft.ends
    first, second, share = (contact, contact, 0.0) if isinstance(contact, str) else contact
    for node in (first, second):
        if not str(node).isdigit() or int(node) >= len(nodes):
            raise DataError(source, f"no node {one_line(node)[:40]} (nodes 0 to {len(nodes) - 1})")
    return nodes[int(first)] + share * (nodes[int(second)] - nodes[int(first)])


def _stations(shaft: Shaft, tables: dict[Path, Support]) -> dict[str, str]:
    """Lines of the keys of [rotor]."""
    main = max({own.material for own in shaft.sections}, key=[own.material for own in shaft.sections].count)
    files = {id(support): file.name for file, support in tables.items()}
    keys = [f"material = {_material(main)}", *([] if shaft.shear else ["shear = false"])]
    keys += [f"rayleigh = [{shaft.rayleigh[0]!r}, {shaft.rayleigh[1]!r}]"] if any(shaft.rayleigh) else []
    remarks = [f"from node {i}, {start:.4g} m" for i, (start, _) in enumerate(pairwise(shaft.ends))]
    names = _names([*(disk.name for disk in shaft.disks), *(one.name for one in shaft.supports)])
    disks = [
        f"name = {toml_value(name)}, at = {disk.place!r}, mass = {disk.mass!r}, "
        f"polar_inertia = {disk.polar_inertia!r}, diametral_inertia = {disk.diametral_inertia!r}"
        for name, disk in zip(names, shaft.disks, strict=False)
    ]
    bearings = [
        f"name = {toml_value(name)}, at = {one.place!r}, "
        + (f"table = {toml_value(files[id(one)])}" if id(one) in files else _coefficients(one))
        for name, one in zip(names[len(shaft.disks) :], shaft.supports, strict=True)
    ]
    return {
        "keys": "".join(f"{key}\n" for key in keys),
        "sections": _lines([_section(own, main) for own in shaft.sections], remarks),
        "sleeves": _lines([f"at = {start!r}, {_section(own, main)}" for start, own in shaft.sleeves]),
        "disks": _lines(disks),
        "bearings": _lines(bearings),
    }


def _names(names: list[str]) -> list[str]:
    """Names, each once."""
    return [name if names.index(name) == i else f"{name} ({i})" for i, name in enumerate(names)]


def _lines(items: list[str], remarks: list[str] | None = None) -> str:
    remarks = remarks or [""] * len(items)
    pairs = zip(items, remarks, strict=True)
    return "".join(f"  {{{item}}},{f'   # {remark}' if remark else ''}\n" for item, remark in pairs)


def _section(section: Section, main: Material) -> str:
    ends = {"diameter": section.outer, "bore": section.inner}
    told = [f"{key} = {left!r}" if left == right else f"{key} = [{left!r}, {right!r}]" for key, (left, right) in ends.items()]
    own = [] if section.material == main else [f"material = {_material(section.material)}"]
    return ", ".join([f"length = {section.length!r}", *told, *own])


def _material(material: Material) -> str:
    return f"{{density = {material.density!r}, youngs_modulus = {material.young!r}, poisson = {material.poisson!r}}}"


def _coefficients(support: Support) -> str:
    numbers = [[float(value) for value in part] for part in (support.coefficients[0, :4], support.coefficients[0, 4:])]
    return f"stiffness = {numbers[0]}, damping = {numbers[1]}"


def _csv(support: Support) -> str:
    rows = np.column_stack([support.speeds, support.coefficients]).tolist()
    return "\n".join([",".join(_COLUMNS), *(",".join(map(repr, row)) for row in rows)]) + "\n"
