"""What a model has next to a measured whirl: its root, stable or not, and which of its values would make it that whirl."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.paper.predict_many import predict_many
from rsc.errors import SceneError
from rsc.scene.scene import Scene
from rsc.scene.values import physical_values, value_of, with_entries

MOST_FACTOR = 4.0  # by which a value is changed, up and down
SCANNED, REFINED = 48, 8  # factors on each side, and then between the last that fails and the first that does
ALIKE = 0.02  # of the frequency: a whirl that is the measured one
MOST_VALUES = 4  # that are told, the smallest changes first; friction is always


@dataclass(frozen=True)
class Brings:
    """A change of one value that makes a whirl stable at the measured frequency: name, unit, present and needed value."""

    name: str
    unit: str
    value: float
    needed: float


@dataclass(frozen=True)
class Nearest:
    """The root of a model next to a measured whirl.

    speed, measured : Hz, of the rotor and of the whirl
    frequency : Hz, of the root, NaN where the model has none; growth_rate : 1/s; rotor_amplitude : m
    stable : whether it is; brings : tuple of Brings, friction first, then by the size of the change
    """

    speed: float
    measured: float
    frequency: float
    growth_rate: float
    rotor_amplitude: float
    stable: bool
    brings: tuple[Brings, ...] = ()

    @property
    def is_that_whirl(self) -> bool:
        """Whether it is stable and has the measured frequency."""
        return self.stable and abs(self.frequency / self.measured - 1.0) <= ALIKE


def nearest_root(scene: Scene, speed: float, measured: float) -> Nearest:
    """The root of a scene at a rotor speed in Hz next to a measured whirl frequency in Hz (negative backward)."""
    arrays = predict_many([scene], [speed], [measured])
    own = {name: getattr(arrays, name)[0, 0, 0] for name in ("frequency", "growth_rate", "rotor_amplitude", "stable")}
    return Nearest(speed, measured, **{name: value.item() for name, value in own.items()})


def with_brings(scene: Scene, root: Nearest) -> Nearest:
    """The root with the values that would make the measured whirl one of the scene's; as it is where it is that whirl."""
    return root if root.is_that_whirl else replace(root, brings=_brings(scene, root.speed, root.measured))


def _brings(scene: Scene, speed: float, measured: float) -> tuple[Brings, ...]:
    """Values each of which alone suffices, changed by at most a factor of 4."""
    possible = []
    for name, value in physical_values(scene).items():
        factor = _factor(scene, (name, value), (speed, measured))
        if factor is not None:
            possible.append((name != "contact.friction", abs(np.log(factor)), name, value, factor * value))
    told = sorted(possible)[:MOST_VALUES]
    return tuple(Brings(name, value_of(scene, name).unit, value, needed) for *_, name, value, needed in told)


def _factor(scene: Scene, entry: tuple[str, float], whirl: tuple[float, float]) -> float | None:
    """The factor next to 1 by which a value must be changed, None where none does."""
    steps = np.geomspace(1.0, MOST_FACTOR, SCANNED + 1)[1:]
    best: float | None = None
    for factors in (steps, 1.0 / steps):
        does = _does(scene, entry, whirl, factors)
        if not does.any():
            continue
        first = int(np.argmax(does))
        before = float(factors[first - 1]) if first else 1.0
        finer = np.geomspace(before, float(factors[first]), REFINED + 1)[1:]
        fine = _does(scene, entry, whirl, finer)
        factor = float(finer[np.argmax(fine)]) if fine.any() else float(factors[first])
        if best is None or abs(np.log(factor)) < abs(np.log(best)):
            best = factor
    return best


def _does(scene: Scene, entry: tuple[str, float], whirl: tuple[float, float], factors: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether each factor of a value gives a stable whirl of the measured frequency."""
    (name, value), (speed, measured) = entry, whirl
    places, scenes = [], []
    for i, factor in enumerate(factors.tolist()):
        try:
            scenes.append(with_entries(scene, {name: factor * value}))
        except SceneError:  # beyond what a scene may have
            continue
        places.append(i)
    does = np.zeros(len(factors), dtype=bool)
    if scenes:
        arrays = predict_many(scenes, [speed], [measured])
        near = np.abs(arrays.frequency[:, 0, 0] / measured - 1.0) <= ALIKE
        does[places] = near & arrays.stable[:, 0, 0]
    return does
