"""The start of a run: the scene's wish resolved to displacements and velocities, on a whirl with the help of the analysis."""

from collections.abc import Sequence
from dataclasses import replace
from math import tau as TWO_PI
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.at_rest import at_rest, states_at_rest, static_deflection, static_states
from rsc.analysis.paper.anisotropy import unbalance_ellipse
from rsc.analysis.paper.receptance import along
from rsc.analysis.paper.stability import whirl_eigenvalues
from rsc.analysis.paper.states import states_of
from rsc.analysis.paper.whirls import whirl_shapes, whirls_by_place
from rsc.errors import SceneError
from rsc.scene.scene import Scene
from rsc.simulation.pack import pack_all
from rsc.simulation.run import InitialState, Run
from rsc.system.assemble import assemble
from rsc.system.system import System, stacked

Result = TypeVar("Result")
FEW_STEPS = 10**9  # of some minutes, the default of solver.max_steps
UNSTABLE = -1.0  # in place of the amplitude of a whirl that is not stable


def run_of(scene: Scene) -> Run:
    """The Run of a scene from its start.

    Raises
    ------
    SceneError
        The scene asks to start on a whirl that does not exist, or its run cannot reach its end.
    """
    return runs_of([scene])[0]


def runs_of(scenes: Sequence[Scene]) -> list[Run]:
    """Runs from their starts of scenes with the same numbers of coordinates, each with the bits of `run_of(scene)`; the
    costly parts go over all at once."""
    return [_wanted(run) for run in runs_or_errors(scenes)]


def runs_or_errors(scenes: Sequence[Scene]) -> list[Run | SceneError]:
    """`runs_of` scenes; in the place of a Run the error of a scene whose start does not exist or whose run cannot end."""
    systems = [assemble(scene) for scene in scenes]
    starts = _states_or_errors(scenes, systems)
    possible = [i for i, start in enumerate(starts) if not isinstance(start, SceneError)]
    packed = iter(pack_all([systems[i] for i in possible], [scenes[i] for i in possible]) if possible else [])
    return [
        start if isinstance(start, SceneError) else _able_to_end(Run(scene, system, next(packed), start))
        for scene, system, start in zip(scenes, systems, starts, strict=True)
    ]


def _able_to_end(run: Run) -> Run | SceneError:
    """The run, or a SceneError in its place where it cannot reach its end. One that is to stop after few steps is made."""
    scene, longest = run.scene, run.packed.longest_step
    if scene.solver.max_steps < FEW_STEPS or run.least_steps <= scene.solver.max_steps:
        return run
    wanted = f"at least {run.least_steps:.2g}, as many as the run takes in steps of no more than {longest:.2g} s"
    hint = f"a quarter of a period of {0.25 / longest:.3g} Hz: look for a stiffness, mass or speed far out of scale"
    return SceneError(scene.source, "solver.max_steps", scene.solver.max_steps, wanted, hint)


def _wanted(result: Result | SceneError) -> Result:
    """What was asked for, unless it is an error, which is raised."""
    if isinstance(result, SceneError):
        raise result
    return result


def initial_state(scene: Scene, system: System) -> InitialState:
    """Resolve `[start]`: rest in equilibrium or at the centre, a state, the steady motion without contact or a predicted
    whirl without unbalance (both at the first speed), and an impact on top of it.

    Raises
    ------
    SceneError
        The scene asks for a whirl and none is predicted, or for a running rotor that would touch the stator.
    """
    return initial_states([scene], [system])[0]


def initial_states(scenes: Sequence[Scene], systems: Sequence[System]) -> list[InitialState]:
    """`initial_state` of scenes with the same numbers of coordinates, with the same bits."""
    return [_wanted(state) for state in _states_or_errors(scenes, systems)]


def _states_or_errors(scenes: Sequence[Scene], systems: Sequence[System]) -> list[InitialState | SceneError]:
    """`initial_state` of scenes with the same numbers of coordinates, with the same bits, or the error that it raises."""
    systems = [system.at_start for system in systems]
    states = [_single_state(*parts) for parts in zip(scenes, systems, strict=True)]
    whirling = [i for i, state in enumerate(states) if state is None]
    starts = iter(_on_whirls([scenes[i] for i in whirling], [systems[i] for i in whirling]) if whirling else [])
    known = [next(starts) if state is None else state for state in states]
    return [_hit(*parts) for parts in zip(known, scenes, systems, strict=True)]


def _hit(state: InitialState | SceneError, scene: Scene, system: System) -> InitialState | SceneError:
    """A state after the impact of the scene: an impulse J on the contact coordinate changes velocities by M_R^-1 l_R J."""
    if isinstance(state, SceneError) or not scene.start.impulse:
        return state
    change = np.linalg.solve(system.rotor.mass, system.rotor.contact) * scene.start.impulse
    return replace(state, rotor_velocity=state.rotor_velocity + change)


def _single_state(scene: Scene, system: System) -> InitialState | SceneError | None:
    """A start at rest, at the centre, in an explicit state or on the steady motion without contact, None for one on a whirl."""
    start = scene.start
    if start.kind == "whirl":
        return None
    if start.kind == "running":
        return _running(scene, system)
    if start.kind == "state":
        parts = (start.rotor, start.rotor_velocity, start.stator, start.stator_velocity)
        state = InitialState(*(np.array(part, dtype=complex) for part in parts))
        return replace(state, states=np.array(start.rotor_states + start.stator_states, dtype=complex))
    still = np.zeros(system.n_rotor, complex), np.zeros(system.n_stator, complex)
    if start.kind == "centre":
        return InitialState(still[0], *still, still[1])
    if len(scene.contacts) > 1:
        return _free_at_rest(scene, system, still)
    place = at_rest(system.at_first_speed)
    if place is None:
        hint = "nothing holds it; start.centre = true lets it fall"
        return SceneError(scene.source, "start.rest", True, "possible: the rotor and its load in equilibrium", hint)
    return InitialState(place[0], still[0], place[1], still[1], states=states_at_rest(system.at_first_speed))


def _free_at_rest(
    scene: Scene, system: System, still: tuple[NDArray[np.complex128], NDArray[np.complex128]]
) -> InitialState | SceneError:
    """The equilibrium with the load inside several gaps, its error where there is none."""
    rotor = static_deflection(system.at_first_speed)
    for contact in system.contacts:
        with np.errstate(invalid="ignore"):  # where nothing holds it
            d = rotor @ contact.rotor + contact.ring - contact.offset
        if not abs(d) <= contact.gap:
            hint = f"the rotor would lie in {contact.name}; start.centre = true lets it fall there"
            return SceneError(scene.source, "start.rest", True, "an equilibrium without contact, of several contacts", hint)
    return InitialState(rotor, still[0], still[1], still[1], states=static_states(system.at_first_speed))


def _running(scene: Scene, system: System) -> InitialState | SceneError:
    """The steady motion by unbalance and load without contact at the first speed, at the angle 0 of the rotor; its error where
    the contact ring might reach the stator."""
    speed = scene.drive.speed[0]
    Omega = TWO_PI * speed
    static, (forward, backward) = static_deflection(system.at_first_speed), unbalance_ellipse(system, Omega)
    if not np.isfinite(static).all():
        hint = "nothing holds the rotor against its load"
        return SceneError(scene.source, "start.running", True, f"a motion without contact at {speed:g} Hz", hint)
    for contact in system.contacts:
        mean, turning, mirror = (along(part, contact.rotor) for part in (static, forward, backward))
        reach = abs(mean - contact.offset) + abs(turning + contact.ring) + abs(mirror)
        if not reach <= contact.gap:
            hint = f"it may reach {reach:.4g} m and the gap {contact.name and f'of {contact.name} '}is {contact.gap:.4g} m"
            return SceneError(scene.source, "start.running", True, f"a motion without contact at {speed:g} Hz", hint)
    still = np.zeros(system.n_stator, complex)
    state = InitialState(static + forward + backward, 1j * Omega * (forward - backward), still, still)
    if not system.n_states:
        return state
    bodies = system.at_first_speed.joined()
    turning = [states_of(bodies, w, np.append(line, still)) for w, line in ((Omega, forward), (-Omega, backward))]
    return replace(state, states=static_states(system.at_first_speed) + sum(turning))


def _on_whirls(scenes: Sequence[Scene], systems: Sequence[System]) -> list[InitialState | SceneError]:
    """Starts on the whirls that scenes ask for, or the error where there is no such whirl; of rotors that turn backwards in the
    mirror image."""
    Omega = TWO_PI * np.array([scene.drive.speed[0] for scene in scenes])
    mirrors = Omega < 0.0
    own = [system.at_first_speed for system in systems]
    system = stacked([one.mirrored() if mirror else one for one, mirror in zip(own, mirrors, strict=True)])
    Omega, sense = abs(Omega), np.where(mirrors, -1.0, 1.0)
    place, Psi, F_N = whirls_by_place(system, Omega)
    backward = np.array([scene.start.whirl == "backward" for scene in scenes])
    allowed = (Psi < 0.0) | ~backward[place]
    place, Psi, F_N = place[allowed], Psi[allowed], F_N[allowed]
    whirls = system.at(place), Psi, F_N, Omega[place]
    rotor, stator = whirl_shapes(*whirls)
    amplitude = abs(along(rotor, whirls[0].rotor.contact))
    if backward.any():
        amplitude[whirl_eigenvalues(*whirls).real.max(axis=-1) >= 0.0] = UNSTABLE
    ends = np.searchsorted(place, np.arange(len(scenes) + 1)).tolist()
    outcomes: list[int | SceneError] = []
    signed = sense[place] * Psi
    for scene, low, high in zip(scenes, ends[:-1], ends[1:], strict=True):
        try:
            outcomes.append(low + _chosen(scene, signed[low:high], amplitude[low:high]))
        except SceneError as error:
            outcomes.append(error)
    chosen = [i for i in outcomes if not isinstance(i, SceneError)]
    rotor, stator, turn = rotor[chosen], stator[chosen], 1j * Psi[chosen, None]
    moving = [rotor, turn * rotor, stator, turn * stator]
    if system.n_states:
        shapes = np.concatenate([rotor, stator], axis=1)
        moving += [np.zeros((len(chosen), 1)), states_of(system.at(place[chosen]).joined(), Psi[chosen], shapes)]
    parts = (np.where(mirrors[place[chosen], None], -part.conj(), part) for part in moving)
    states = (InitialState(*state) for state in zip(*parts, strict=True))
    return [i if isinstance(i, SceneError) else next(states) for i in outcomes]


def _chosen(scene: Scene, Psi: NDArray[np.float64], amplitude: NDArray[np.float64]) -> int:
    """Number of the stable backward whirl of largest amplitude, or of the whirl next to a frequency in Hz."""
    whirl: Any = scene.start.whirl
    speed = scene.drive.speed[0]
    if whirl == "backward":
        if amplitude.max(initial=UNSTABLE) > UNSTABLE:
            return int(amplitude.argmax())
        predicted = ", ".join(f"{frequency:.4g} Hz (unstable)" for frequency in Psi / TWO_PI)
        hint = f"predicted there: {predicted}; whirl = FREQUENCY starts on one" if predicted else "none is predicted there"
        raise SceneError(scene.source, "start.whirl", whirl, f"a stable backward whirl at {speed:g} Hz", hint)
    if not len(Psi):
        raise SceneError(scene.source, "start.whirl", whirl, f"a whirl that exists at {speed:g} Hz", "none is predicted")
    return int(np.argmin(abs(Psi / TWO_PI - whirl)))
