"""`rsc import`: store a finite-element model next to a new scene."""

import math
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rsc.errors import DataError, SceneError, one_line
from rsc.files.mark import TOML, ZIP
from rsc.files.output import OutputFile, put_all, target
from rsc.machine.imports.bearings import Bearing, with_bearings
from rsc.machine.imports.gaps import RadialGap
from rsc.machine.imports.rational import SupportStates, joined_states
from rsc.machine.imports.store import stored
from rsc.machine.model.contact import Place, body_of, total_mass
from rsc.machine.model.model import FiniteElementModel
from rsc.machine.model.modes import ModelMode, slowest_modes
from rsc.machine.reduction.body import static_solver
from rsc.scene.files.toml_text import toml_value
from rsc.scene.scene import Scene, load_scene
from rsc.system.body import Body

# of the scene to begin with: share of the rotor's mass in the stator, and its natural frequency over the rotor's
STATOR_MASS, STATOR_FREQUENCY = 0.3, 1.5
STIFFER = 100.0  # times the static stiffness of the rotor at the contact: that of the contact
# of the rotor's mass on the bearings that the scene adds: Hz, and damping ratio
BEARING_FREQUENCY, BEARING_DAMPING = 50.0, 0.1
MODES, UNDAMPED, ALIKE = 4, 1e-9, 1e-6  # modes that are told; growth rate over frequency, and difference, that are rounding
_ROTOR = """\
# Written by `rsc import`. The rotor is the imported one; what is marked with (guess) is not, and yours to change.
title = {title}

[rotor]
model = "machine"
file = {file}               # matrices of {n} complex coordinates, from {source}
sha256 = "{digest}"
{place}{bearings}unbalance = [[{unbalance}, "G 6.3"]]   # (guess) node and amount: "20 g*mm", or a balance grade of the rotor
{notes}{states}
[reduction]
tolerance = 1e-4               # relative error of what the contact point sees

[stator]
model = "laval"                # (guess) or "machine", with the file of `rsc import fe --stator`
mass = {stator_mass:.4g}
frequency = {stator_frequency:.4g}
damping_ratio = 0.05

{contacts}{watched}
[drive]
speed = ["0 rpm", "{top:.0f} rpm"]   # (guess)
duration = 20.0                # s

[start]
rest = true                    # does the rotor get into a whirl? whirl = "backward": does it stay on a predicted one?
"""
_PLACE = "contact = {contact}            # node, number or name, or [node, node, share of the way]\n"
_CONTACT = """\
{head}{diameter}gap = {gap}
friction = {friction}
stiffness = {stiffness}
damping_ratio = 0.05           # (guess)
"""
Fitted = tuple[str, SupportStates]
_DENSITY, _DIAMETER = 7850.0, 0.05  # kg/m^3 of steel, and m of a rotor whose length is unknown
_STATOR = """\
[stator]
model = "machine"
file = {file}
sha256 = "{digest}"
contact = {contact}
"""


def import_model(
    model: FiniteElementModel,
    output: str | os.PathLike[str],
    contact: Place,
    unbalance: int | str | None = None,
    bearings: Sequence[int | str | Fitted] = (),
    gaps: Sequence[RadialGap] = (),
    watched: Sequence[RadialGap] = (),
    overwrite: bool = False,
) -> str:
    """Write a model and a scene that refers to it.

    Parameters
    ----------
    model : FiniteElementModel
    output : path
        A scene (.toml) to begin with, whose model stands beside it under the same name as .npz; or the .npz alone.
    contact : Place
        Where it touches.
    unbalance : int or str, optional
        Node of the unbalance; default: the first node of the contact.
    bearings : sequence of int or str, or of (node, SupportStates)
        Nodes of bearings that the scene adds: their coefficients are guesses, or fitted where they depend on the frequency of the
        vibration.
    gaps : sequence of RadialGap
        Of each NLRGAP (`rsc.machine.imports.gaps`) clearance, friction, stiffness and radius of a contact, instead of guesses.
    watched : sequence of RadialGap
        Other gaps: they become clearances of the scene, against the ground.
    overwrite : bool
        Also in the place of files that rsc did not write, or that were changed since.

    Returns
    -------
    str
        What was written, in lines for people: for an .npz alone the table of a scene that uses it.

    Raises
    ------
    DataError
        A place that the model does not have, or a file that cannot be written, or that is there and was not written by rsc or
        changed since; nothing is left behind.
    SceneError
        The scene cannot be right: the model cannot be reduced, for example.
    """
    output = Path(output)
    fitted = [one for one in bearings if isinstance(one, tuple)]
    coefficients = _bearings(model, [one for one in bearings if not isinstance(one, tuple)])
    whole = with_bearings(model, [*coefficients, *(_beside(node, fit) for node, fit in fitted)])
    body, notes = body_of(whole, [contact]), (*model.notes, *(_told_of(node, fit) for node, fit in fitted))
    for gap in gaps:
        whole.row_at(gap.inner)
    modes = _slowest_of(whole)
    if modes and all(_undamped(mode) for mode in modes):
        advice = "these motions do not decay without contact; add damping to bearings or matrices"
        notes += (f"nothing damps {_these(modes)}: {advice}.",)
    if output.suffix not in (".toml", ".npz"):
        raise DataError(one_line(output), "must be a scene (.toml), or the file of a model (.npz)")
    if fitted and output.suffix == ".npz":
        raise DataError(one_line(output), "must be a scene (.toml), which has the fitted supports")
    file = target(output.with_suffix(".npz"), ZIP, overwrite)
    if output.suffix == ".toml":
        target(output, TOML, overwrite)
    if model.knots is not None:
        low, high = model.knots.speed[[0, -1]] / (2.0 * np.pi)
        notes += (f"coefficients follow the rotor speed from {low:g} to {high:g} Hz and are constant beyond.",)
    elif whole.rotating_damping is None and not whole.gyroscopic.diagonal().any():
        notes += ("nothing depends on the rotor speed.",)
    written, digest = stored(model, file)
    told = "".join(f"\n{one_line(note)}" for note in notes)
    words = {"file": toml_value(file.name), "digest": digest, "contact": _toml(contact)}
    words |= {"bearings": _bearing_lines(coefficients, fitted), "states": _states_table(fitted)}
    if output.suffix == ".npz":
        put_all([written], overwrite)
        return f"written: {file}{told}\n{_slowest(modes, whole)}\n\n" + _STATOR.format(**words)
    first = contact if isinstance(contact, (int, str)) else contact[0]
    told_there = "".join(f"# {one_line(note)}\n" for note in notes)
    words |= _guesses(model, body, first, unbalance) | {"notes": told_there, "watched": _clearances(watched)}
    words["contacts"] = _contacts(model, body, first, gaps)
    words["place"] = _PLACE.format(**words) if len(gaps) < 2 else ""
    scene = OutputFile(output, _ROTOR.format(**words).encode(), TOML)
    tried(scene, [written])
    put_all([written, scene], overwrite)
    return f"written: {output}, {file}{told}\n{_slowest(modes, whole)}"


def tried(scene: OutputFile, beside: Sequence[OutputFile]) -> Scene:
    """The scene as it will load; SceneError where it cannot be right, before it and its files are put in their places."""
    with tempfile.TemporaryDirectory() as folder:
        for output in (*beside, scene):
            Path(folder, output.path.name).write_bytes(output.format.marked(output.content))
        try:
            return load_scene(Path(folder, scene.path.name))
        except SceneError as error:
            raise SceneError(one_line(scene.path), error.key, error.value, error.wanted, error.hint) from None


def _slowest_of(model: FiniteElementModel) -> list[ModelMode]:
    """The slowest modes of a machine as it was read, of those that differ in their sense alone one."""
    modes: list[ModelMode] = []
    for mode in slowest_modes(model, model.slowest_speed, 2 * MODES):
        if not any(_twins(mode, other) for other in modes):
            modes.append(mode)
    return modes[:MODES]


def _twins(one: ModelMode, other: ModelMode) -> bool:
    """Whether two modes turn the two ways at one frequency and die away alike."""
    size = abs(complex(one.growth_rate, 2.0 * math.pi * one.frequency))
    away = abs(abs(one.frequency) - abs(other.frequency)) * 2.0 * math.pi + abs(one.growth_rate - other.growth_rate)
    return one.frequency * other.frequency < 0.0 and away <= ALIKE * size


def _slowest(modes: Sequence[ModelMode], model: FiniteElementModel) -> str:
    """The slowest modes of the machine in words."""
    frequencies = [mode.frequency if model.slowest_speed else abs(mode.frequency) for mode in modes]
    told = ", ".join(f"{one:.4g} Hz ({_decrement(mode)})" for one, mode in zip(frequencies, modes, strict=True))
    return f"lowest modes at {model.slowest_speed:g} Hz of the full model: {told}; more by `rsc modes`"


def _these(modes: Sequence[ModelMode]) -> str:
    return "the lowest mode" if len(modes) == 1 else f"the {len(modes)} lowest modes"


def _undamped(mode: ModelMode) -> bool:
    return abs(mode.growth_rate) <= UNDAMPED * abs(mode.frequency)


def _decrement(mode: ModelMode) -> str:
    if _undamped(mode):
        return "undamped"
    return "does not oscillate" if math.isinf(mode.decrement) else f"decrement {mode.decrement:.3g}"


def _bearings(model: FiniteElementModel, nodes: Sequence[int | str]) -> list[Bearing]:
    """Guesses of bearings at nodes: the whole mass on all of them has a frequency and a damping ratio."""
    if not nodes:
        return []
    each, omega = total_mass(model) / len(nodes), 2.0 * np.pi * BEARING_FREQUENCY
    stiffness, damping = (float(f"{value:.3g}") for value in (each * omega**2, 2.0 * BEARING_DAMPING * each * omega))
    return [Bearing(node, (stiffness, 0.0, 0.0, stiffness), (damping, 0.0, 0.0, damping)) for node in nodes]


def _beside(node: str, fit: SupportStates) -> Bearing:
    """What a fitted support is without its states."""
    return Bearing(node, (fit.stiffness, 0.0, 0.0, fit.stiffness), (fit.damping, 0.0, 0.0, fit.damping))


def _bearing_lines(bearings: Sequence[Bearing], fitted: Sequence[Fitted]) -> str:
    if not bearings and not fitted:
        return ""
    items = [f"[{_toml(one.node)}, {one.stiffness[0]:g}, {one.damping[0]:g}]" for one in bearings]
    items += [f"[{_toml(node)}, {fit.stiffness!r}, {fit.damping!r}]" for node, fit in fitted]
    guessed = "(guess) " if bearings else ""
    beside = "; those that are fitted have their states below" if fitted else "; each also [yy, yz, zy, zz]"
    return f"bearings = [{', '.join(items)}]   # {guessed}node, N/m, N s/m{beside}\n"


def _told_of(node: str, fit: SupportStates) -> str:
    """A fitted support in words."""
    over = f"coefficients over the vibration frequency from {fit.low:g} to {fit.high:g} Hz"
    told = f"node {node}: {over} fitted by {len(fit.matrix)} first-order states, error {fit.error:.1e}"
    if fit.driving is not None:
        told += f"; it feeds energy into a vibration at {fit.driving:.3g} Hz, which the table does not"
    return f"{told}."


def _states_table(fitted: Sequence[Fitted]) -> str:
    """The table of the first-order states of fitted supports."""
    with_states = [(node, fit) for node, fit in fitted if len(fit.matrix)]
    if not with_states:
        return ""
    table = joined_states(with_states)
    places = f"[{', '.join(_toml(place) for place in table['sensors'])}]"
    lines = [f"{name} = {places}" for name in ("sensors", "actuators")]
    lines += [f"{name} = {table[name].tolist()}" for name in ("matrix", "displacement", "velocity", "force")]
    return "\n[rotor.states]                 # fitted to coefficients over the vibration frequency\n" + "\n".join(lines) + "\n"


def _clearances(gaps: Sequence[RadialGap]) -> str:
    """Tables of the clearances that gaps are watched as."""
    tables = []
    for gap, name in zip(gaps, _names(gaps), strict=True):
        head = f"\n[[clearance]]                  # of the NLRGAP at node {gap.inner}: watched, without a force\n"
        tables.append(f'{head}name = "{name}"\nrotor_node = {gap.inner}\ngap = {gap.gap!r}\n')
    return "".join(tables)


def _names(gaps: Sequence[RadialGap]) -> list[str]:
    """Names of gaps by their nodes; two at one node of the shaft are distinguished by their outer nodes."""
    inner = [gap.inner for gap in gaps]
    return [f"node_{gap.inner}" + (f"_{gap.outer}" if inner.count(gap.inner) > 1 else "") for gap in gaps]


def _contacts(model: FiniteElementModel, body: Body, first: Any, gaps: Sequence[RadialGap]) -> str:
    """The table of the contact: of a gap, of each of several, or guessed."""
    static, guess = _compliance(body), "        # (guess)"
    hard = f"{STIFFER:g} times the static stiffness of the rotor there"
    numbers = {"gap": f'"0.2 mm"{guess}', "friction": f"0.15{guess}", "stiffness": f"{STIFFER / static:.4g}{guess} N/m: {hard}"}
    if not gaps:
        return _CONTACT.format(head="[contact]\n", diameter=_diameter(model, first, None), **numbers)
    tables = []
    for gap, name in zip(gaps, _names(gaps), strict=True):
        numbers = {key: f"{getattr(gap, key)!r}        # of the NLRGAP at node {gap.inner}" for key in numbers}
        head = f'[[contact]]\nname = "{name}"\nrotor_node = {gap.inner}\n' if len(gaps) > 1 else "[contact]\n"
        tables.append(_CONTACT.format(head=head, diameter=_diameter(model, gap.inner, gap), **numbers))
    return "\n".join(tables)


def _diameter(model: FiniteElementModel, node: Any, gap: RadialGap | None) -> str:
    """The line of the diameter at a contact, of the gap or of the model, or guessed."""
    diameter = (2.0 * gap.radius if gap is not None else 0.0) or (model.diameter_at(node) if model.diameter else None)
    if diameter:
        return f"diameter = {diameter:.6g}\n"
    length = max(model.position.values(), default=0.0) - min(model.position.values(), default=0.0)
    if length > 0.0:
        size, source = float(np.sqrt(4.0 * total_mass(model) / (np.pi * _DENSITY * length))), "a steel bar of its mass and length"
    else:
        size, source = _DIAMETER, "the file has no lengths"
    return f"diameter = {size:.3g}               # (guess) m, of the rotor at the contact: {source}\n"


def _compliance(body: Body) -> float:
    """Static deflection at the contact under a force there, m/N."""
    return float(body.contact @ static_solver(body)(body.contact[:, None])[:, 0])


def guesses(model: FiniteElementModel, body: Body) -> dict[str, float]:
    """A stator, a contact stiffness in N/m and a largest speed in rpm of the order of magnitude of the rotor."""
    mass, static = total_mass(model), _compliance(body)
    frequency = np.sqrt(1.0 / (static * mass)) / (2.0 * np.pi)  # of the whole mass on the compliance at the contact
    return {
        "stator_mass": STATOR_MASS * mass,
        "stator_frequency": STATOR_FREQUENCY * frequency,
        "contact_stiffness": STIFFER / static,
        "top": 60.0 * 2.0 * frequency,
    }


def _guesses(model: FiniteElementModel, body: Body, first: Any, unbalance: int | str | None) -> dict[str, Any]:
    """The tables of a new scene other than rotor and contact."""
    return guesses(model, body) | {
        "title": toml_value(one_line(Path(model.source).stem)[:80]),
        "source": one_line(model.source)[:100],
        "n": model.n,
        "unbalance": _toml(first if unbalance is None else unbalance),
    }


def _toml(place: Place) -> str:
    """A place as a value in a scene."""
    if isinstance(place, (int, str)):
        return toml_value(place) if isinstance(place, str) and not place.lstrip("-").isdigit() else f"{place}"
    return "[" + ", ".join(_toml(item) if isinstance(item, (int, str)) else f"{item:g}" for item in place) + "]"
