"""Whether a rotor is held by its magnetic bearings: as it was read, and as it was reduced."""

from math import tau as TWO_PI
from typing import Any

from rsc.analysis.alone.free_vibration import free_growth, free_vibrations
from rsc.machine.model.modes import growth_in_loop
from rsc.scene.scene import Scene
from rsc.system.assemble import assemble

WIDER = "widen reduction.band or lower reduction.tolerance"


def levitation_remarks(scene: Scene) -> list[str]:
    """A remark on a rotor that is not stable in its magnetic bearings, all that it starts with, at the highest speed of its run;
    none for a stable one, or one without first-order states."""
    system, speed = assemble(scene).at_start, max(scene.drive.speed, key=abs)
    if not system.rotor.n_states:
        return []
    own = max(free_vibrations(system, speed), key=lambda vibration: vibration.growth_rate)
    if free_growth(system, TWO_PI * speed) <= 0.0 or own.growth_rate <= 0.0:
        return hidden_growth(scene)
    read = _as_read(scene, speed)
    if read is None or read.growth_rate > 0.0:
        return [f"{_unstable(scene, speed)}: {_growth(read or own)}"]
    return [f"{_unstable(scene, speed)} as it was reduced, {_growth(own)}, but it is as it was read: {WIDER}"]


def hidden_growth(scene: Scene) -> list[str]:
    """A remark on a machine that was not stable in its magnetic bearings as it was read, but is as it was reduced; at the highest
    speed of its run."""
    speed = max(scene.drive.speed, key=abs)
    read = _as_read(scene, speed)
    if read is None or read.growth_rate <= 0.0 or free_growth(assemble(scene).at_start, TWO_PI * speed) > 0.0:
        return []
    return [f"{_unstable(scene, speed)}: {_growth(read)}, which its reduction does not show: {WIDER}"]


def _unstable(scene: Scene, speed: float) -> str:
    held = "magnetic bearings" if scene.rotor.magnetic_bearings else "first-order states"
    return f"the rotor is not stable in its {held} at a rotor speed of {speed:g} Hz"


def _as_read(scene: Scene, speed: float) -> Any:
    """The fastest growing mode of the full machine in its loop; None where it is not known."""
    full = next((one for one in scene.reductions if one.states is not None), None)
    if full is None:
        return None
    return growth_in_loop(full.model, -speed if full.speeds[0] < 0.0 < speed else speed, full.states)


def _growth(mode: Any) -> str:
    return f"{mode.growth_rate:+.4g} 1/s at {mode.frequency:.4f} Hz"
