"""Remarks on reduced bodies: error, range of validity, and shift of each predicted whirl in the full model."""

from collections.abc import Iterable
from math import tau as TWO_PI
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.modes import Modes
from rsc.analysis.several.condition import Whirling, pressed, shifted
from rsc.analysis.several.whirl import SeveralWhirl
from rsc.machine.model.modes import slowest_modes
from rsc.machine.reduction.shifts import receptance_error
from rsc.measure.several import together
from rsc.scene.bodies.reduced import ReducedRotor, ReducedStator
from rsc.scene.bodies.shafts import SHAFT
from rsc.scene.scene import Scene
from rsc.study.run.levitation import hidden_growth
from rsc.system.assemble import assemble

_MORE_MODES = 4  # of the full machine than of the reduced one, which may lack those that its contact does not see


def reduction_remarks(scene: Scene, whirls: Iterable[Any] = ()) -> list[str]:
    """Remarks on the reduced bodies of a scene, one line each; none where nothing was reduced.

    Parameters
    ----------
    scene : Scene
    whirls : iterable of rsc.Whirl
        Predicted ones. The shift of each from that of the full model, to first order, is told where the scene was read from its
        file: a result does not keep the full model.
    """
    bodies = _reduced_bodies(scene)
    remarks = [_remark(name, body) for name, body in bodies] + _shaft_remarks(bodies)
    remarks += _clearance_remarks(scene) + _weight_remarks(scene)
    if not bodies:
        return []
    remarks += hidden_growth(scene)
    low, high = bodies[0][1].band
    for whirl in whirls:
        if not low <= whirl.frequency <= high:
            remarks.append(f"whirl {whirl.frequency:.4g} Hz lies outside the band of the reduction, {low:g} to {high:g} Hz")
        elif len(scene.reductions) == len(bodies):
            remarks += _shift_remark(scene, whirl)
    return remarks


def mode_remarks(scene: Scene, modes: Modes, shown: int) -> list[str]:
    """How far modes of the reduced bodies lie from those of the machines as they were read, one line for each body; none where a
    scene does not come from its file.

    Parameters
    ----------
    scene : Scene
    modes : Modes, of this scene
    shown : int
        How many of each body's slowest modes are looked at, those within the band of the reduction.
    """
    bodies, remarks = _reduced_bodies(scene), []
    for (name, body), reduced in zip(bodies, scene.reductions, strict=False):
        if len(bodies) == len(scene.reductions):
            own = [mode for mode in modes.parts[name][:shown] if body.band[0] <= mode.frequency <= body.band[1]]
            remarks += _mode_remark(name, own, reduced, modes.speed)
    return remarks


def _mode_remark(name: str, own: list[Any], reduced: Any, speed: float) -> list[str]:
    """The largest distance of an eigenvalue from the nearest one of the full machine, in both parts."""
    if not own:
        return []
    sense = -1.0 if reduced.speeds[0] < 0.0 else 1.0  # of a scene that was mirrored, because its rotor turns backwards
    full = slowest_modes(reduced.model, sense * speed, 2 * len(own) + _MORE_MODES, reduced.states)
    known = np.array([mode.growth_rate + TWO_PI * 1j * sense * mode.frequency for mode in full])
    values = np.array([mode.growth_rate + TWO_PI * 1j * mode.frequency for mode in own])
    if not reduced.model.isotropic:  # an ellipse has both senses, of which which is larger may differ between two places
        known, values = (part.real + 1j * np.abs(part.imag) for part in (known, values))
    nearest = known[np.abs(values[:, None] - known).argmin(axis=1)]
    i = int(np.abs(values - nearest).argmax())
    off = values[i] - nearest[i]
    return [
        f"the {len(own)} modes of the {name} above that lie in the band of its reduction are those of the machine as it was read "
        f"but for at most {abs(off.imag) / TWO_PI:.1e} Hz and {abs(off.real):.1e} 1/s (the one at {own[i].frequency:.5g} Hz)"
    ]


def _shaft_remarks(bodies: list[tuple[str, Any]]) -> list[str]:
    """How fine the shafts are divided that were given by their stations."""
    origins = [body.origin.partition(", contact at")[0] for _, body in bodies]
    return [origin for origin in origins if origin.startswith(SHAFT)]


def _clearance_remarks(scene: Scene) -> list[str]:
    """How closely the reduced bodies move at the nodes of clearances."""
    remarks = []
    for name, body in _reduced_bodies(scene):
        for place in scene.clearances:
            node = getattr(place, f"{name}_node")
            if node is not None and body.observer_errors:
                error = body.observer_errors[body.observers.index(node)]
                remarks.append(f"clearance {place.name}: its node {node} of the reduced {name} has an error of {error:.1e}")
    return remarks


def _weight_remarks(scene: Scene) -> list[str]:
    """What a drive that gives way does not feel of a reduced rotor."""
    if getattr(scene.drive, "inertia", None) is None or not isinstance(scene.rotor, ReducedRotor):
        return []
    if not np.any(np.asarray(scene.rotor.load, dtype=complex)):
        return []
    return [
        "loads of the reduced rotor, its weight too, act at the shaft's centre: the drive does not feel the lever of the weight, "
        "which is the unbalance"
    ]


def _reduced_bodies(scene: Scene) -> list[tuple[str, Any]]:
    both: dict[str, Any] = {"rotor": scene.rotor, "stator": scene.stator}
    return [(name, body) for name, body in both.items() if isinstance(body, (ReducedRotor, ReducedStator))]


def coefficient_remarks(scene: Scene) -> list[str]:
    """A remark on each body whose bearings and seals keep the coefficients of one rotor speed."""
    return [_coefficients_remark(name, body, scene) for name, body in _reduced_bodies(scene) if body.coefficients_at is not None]


def _remark(name: str, body: Any) -> str:
    directions = "" if body.directions_error is None else f", {body.directions_error:.1e} with its directions as they differ"
    return (
        f"the {name} is reduced from {body.coordinates_before} to {body.n_coordinates} coordinates: error at the contact "
        f"{body.error:.1e}{directions} (tolerance {body.tolerance:g}) from {body.band[0]:g} to {body.band[1]:g} Hz and rotor "
        f"speeds of {body.speeds[0]:g} to {body.speeds[1]:g} Hz; highest frequency {_hertz(body.highest_before)}, now "
        f"{_hertz(body.highest_after)}"
    )


def _coefficients_remark(name: str, body: Any, scene: Scene) -> str:
    low, high = min(scene.drive.speed), max(scene.drive.speed)
    return (
        f"coefficients of bearings and seals of the {name} are those at {body.coefficients_at:g} Hz, the run turns at {low:g} to "
        f"{high:g} Hz: import the model also at both ends and compare, because the coefficients are constant"
    )


def _hertz(frequency: float) -> str:
    return f"{frequency / 1e3:.3g} kHz" if frequency >= 1e3 else f"{frequency:.3g} Hz"


def _shift_remark(scene: Scene, whirl: Any) -> list[str]:
    """How far the whirl of the full model lies from the predicted one, to first order in the errors of the receptances."""
    Psi, Omega = TWO_PI * whirl.frequency, TWO_PI * whirl.speed
    names = whirl.pressed if isinstance(whirl, SeveralWhirl) else ()
    numbers = [i for i, contact in enumerate(scene.contacts) if not names or contact.name in names]
    forces = [whirl.contacts[name].normal_force for name in names] or [whirl.normal_force]
    phases = np.deg2rad([whirl.contacts[name].phase for name in names] or [0.0])
    own = Whirling(np.array([Psi]), np.array([forces]), np.array([phases]))
    shift = shifted(pressed(assemble(scene), Omega, numbers), _errors(scene, numbers, Psi, Omega)[None], own)[0] / TWO_PI
    at = f" at {together(names)}" if names else ""
    who = f"the whirl at {whirl.frequency:.4f} Hz{at} (rotor at {whirl.speed:.4g} Hz)"
    return [f"{who} of the full model lies {shift:+.1e} Hz off"]


def _errors(scene: Scene, numbers: list[int], Psi: float, Omega: float) -> NDArray[np.complex128]:
    """Errors of the receptances between contacts of these numbers, m/N, of both bodies as far as they were reduced."""
    errors = np.zeros((len(numbers), len(numbers)), dtype=complex)
    for (name, _), reduced in zip(_reduced_bodies(scene), scene.reductions, strict=True):
        places = [_place(scene.contacts[i], name) for i in numbers]
        errors += receptance_error(reduced, Psi, Omega)[0][np.ix_(places, places)]
    return errors


def _place(contact: Any, name: str) -> int:
    """The coordinate of the rotor or of the stator at a contact."""
    return int(contact.rotor_coordinates[0] if name == "rotor" else contact.stator_coordinate)
