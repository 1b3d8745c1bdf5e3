"""The start of a run: the scene's wish resolved to displacements and velocities."""

from dataclasses import dataclass

import numpy as np

from rsc.errors import SceneError
from rsc.predict import predict

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
        whirl = _chosen_whirl(scene)
        turn = 2j * np.pi * whirl.frequency
        return InitialState(whirl.rotor_shape, turn * whirl.rotor_shape, whirl.stator_shape, turn * whirl.stator_shape)
    if start.kind == "state":
        parts = (start.rotor, start.rotor_velocity, start.stator, start.stator_velocity)
        return InitialState(*(np.array(part, dtype=complex) for part in parts))
    rotor, stator = np.zeros(system.n_rotor, complex), np.zeros(system.n_stator, complex)
    return InitialState(rotor, rotor, stator, stator)


def _chosen_whirl(scene):
    """The stable backward whirl of largest amplitude, or the whirl next to a frequency in Hz."""
    wish, speed = scene.start.whirl, scene.drive.speed[0]
    whirls = predict(scene, speed=speed)
    if wish == "backward":
        candidates = [w for w in whirls if w.frequency < 0.0 and w.stable]
        if candidates:
            return max(candidates, key=lambda w: w.rotor_amplitude)
        found = ", ".join(f"{w.frequency:.4g} Hz (unstable)" for w in whirls if w.frequency < 0.0)
        hint = f"predicted there: {found}; whirl = FREQUENCY starts on one" if found else "none is predicted there"
        raise SceneError(scene.source, "start.whirl", wish, f"a stable backward whirl at {speed:g} Hz", hint)
    if not whirls:
        raise SceneError(scene.source, "start.whirl", wish, f"a whirl that exists at {speed:g} Hz", "none is predicted")
    return min(whirls, key=lambda w: abs(w.frequency - wish))
