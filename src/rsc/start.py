"""The start of a run: the scene's wish resolved to displacements and velocities."""

from dataclasses import dataclass

import numpy as np

from rsc.analytic import steady_whirls, whirl_shapes
from rsc.errors import SceneError
from rsc.stability import whirl_growths

TWO_PI = 2.0 * np.pi


@dataclass(frozen=True)
class InitialState:
    """Complex displacements (m) and velocities (m/s) of rotor (N,) and stator (M,) at t = 0."""

    rotor: np.ndarray
    rotor_velocity: np.ndarray
    stator: np.ndarray
    stator_velocity: np.ndarray


def initial_state(scene, system):
    """Resolve `[start]`: rest, an explicit state, or a predicted whirl without unbalance at the first speed.

    Raises
    ------
    SceneError
        The scene asks for a whirl and none is predicted.
    """
    start = scene.start
    if start.kind == "whirl":
        Omega = TWO_PI * float(scene.drive.speed[0])
        Psi, F_N = _chosen_whirl(scene, system, Omega)
        rotor, stator = whirl_shapes(system, Psi, F_N, Omega)
        return InitialState(rotor, 1j * Psi * rotor, stator, 1j * Psi * stator)
    if start.kind == "state":
        parts = (start.rotor, start.rotor_velocity, start.stator, start.stator_velocity)
        return InitialState(*(np.array(part, dtype=complex) for part in parts))
    rotor, stator = np.zeros(system.n_rotor, complex), np.zeros(system.n_stator, complex)
    return InitialState(rotor, rotor, stator, stator)


def _chosen_whirl(scene, system, Omega):
    """(Psi, F_N) of the stable backward whirl of largest amplitude, or of the whirl next to a frequency in Hz."""
    wish, speed = scene.start.whirl, scene.drive.speed[0]
    Psi, F_N = steady_whirls(system, Omega)
    if wish == "backward":
        Psi, F_N = Psi[Psi < 0.0], F_N[Psi < 0.0]
        growths = whirl_growths(system, Psi, F_N, Omega) if len(Psi) else []
        stable = np.array([growth.rate < 0.0 for growth in growths])
        if stable.any():
            amplitude = abs(whirl_shapes(system, Psi, F_N, Omega)[0] @ system.contact_r)
            best = np.argmax(np.where(stable, amplitude, -1.0))
            return Psi[best], F_N[best]
        found = ", ".join(f"{frequency:.4g} Hz (unstable)" for frequency in Psi / TWO_PI)
        hint = f"predicted there: {found}; whirl = FREQUENCY starts on one" if found else "none is predicted there"
        raise SceneError(scene.source, "start.whirl", wish, f"a stable backward whirl at {speed:g} Hz", hint)
    if not len(Psi):
        raise SceneError(scene.source, "start.whirl", wish, f"a whirl that exists at {speed:g} Hz", "none is predicted")
    nearest = np.argmin(abs(Psi / TWO_PI - wish))
    return Psi[nearest], F_N[nearest]
