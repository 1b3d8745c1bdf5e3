"""Values of a scene that a fit may change: their ranges, and the coordinates in which they are changed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rsc.errors import SceneError, SolverError, one_line, shown
from rsc.scene.keys.readers import plain
from rsc.scene.names import leading
from rsc.scene.scene import Scene
from rsc.scene.values import Value, physical_values, value_of
from rsc.units import QuantityError, quantity
from rsc.units.together import refuse_mixed, spread

FACTOR = 4.0  # by which a value may be changed up and down where no range is given
MOST_FREE = 12
_HINT = "for example contact.friction=0.1:0.4"


@dataclass(frozen=True)
class Free:
    """One value that is free, in SI as the scene has it.

    name, unit : str; guess : float, of the scene, inside the range or next to it; low, high : float, its range
    logarithmic : bool, whether its coordinate is its logarithm; else it is the value over its range
    """

    name: str
    unit: str
    guess: float
    low: float
    high: float

    @property
    def logarithmic(self) -> bool:
        """Whether its coordinate is its logarithm, as that of every value above 0."""
        return self.low > 0.0

    def coordinate(self, value: float) -> float:
        """The coordinate of a value: differences are relative changes, or for values of both signs parts of the range."""
        return float(np.log(value)) if self.logarithmic else value / (self.high - self.low)

    def value(self, coordinate: float) -> float:
        """The value at a coordinate, never outside the range."""
        value = float(np.exp(coordinate)) if self.logarithmic else coordinate * (self.high - self.low)
        return min(max(value, self.low), self.high)


def free_values(scene: Scene, names: Sequence[str], priors: Mapping[str, Any]) -> list[Free]:
    """The free values of a scene.

    Parameters
    ----------
    scene : Scene
    names : sequence of str
    priors : mapping
        Name -> (low, high), or a text "LOW:HIGH" with units; by default a quarter of what the scene has to four times of it.

    Raises
    ------
    SceneError
        A name that the scene does not have, a word, a range that no scene may have or that is none.
    SolverError
        No name, too many, one twice, or a range of a value that is not free.
    """
    if not names or len(names) > MOST_FREE:
        raise SolverError(f"fit: {len(names)} free values: must be 1 to {MOST_FREE}, {_HINT.split('=')[0]}")
    if len(set(names)) < len(names):
        raise SolverError(f"fit: {one_line(', '.join(names))}: must be named once")
    for name in priors:
        if name not in names:
            raise SolverError(f"fit: prior of {one_line(name)}: must be of a value that is free ({one_line(', '.join(names))})")
    return [_free(scene, name, priors.get(name)) for name in names]


def _free(scene: Scene, name: str, prior: Any) -> Free:
    value = value_of(scene, name)
    if not value.dimension:
        raise SceneError(scene.source, name, None, "a number with a dimension", "a word or a count cannot be fitted")
    if not value.physical:
        raise SceneError(scene.source, name, None, "a value of rotor, stator or contact", "no measurement determines it")
    guess = _guess(scene, value)
    if prior is not None:
        low, high = _range(scene, value, prior)
    elif guess:
        low, high = sorted((guess / FACTOR, guess * FACTOR))
        low, high = _allowed(value, low, guess), _allowed(value, high, guess)
    else:
        raise SceneError(scene.source, name, guess, "given a range, since it is zero or missing", f"a prior, {_HINT}")
    return Free(name, value.unit, float(np.clip(guess if guess is not None else 0.5 * (low + high), low, high)), low, high)


def _guess(scene: Scene, value: Value) -> float | None:
    """The value in the scene, also if given by another key; None if there is none."""
    known = physical_values(scene)
    if value.name in known:
        return known[value.name]
    if value.polar:
        return float(getattr(leading(scene, value.table, value.key), value.polar))
    content = scene.tables.get(value.table, {}).get(value.key)
    if content is None:
        content = plain(getattr(getattr(scene, value.table, None), value.key, None))
    if content is None and not value.places:
        content = _of_one_mass(getattr(scene, value.table, None), value.key)
    for place in value.places:
        content = content[place] if isinstance(content, list) and place < len(content) else None
    return float(content) if isinstance(content, (int, float)) and not isinstance(content, bool) else None


def _of_one_mass(body: Any, key: str) -> float | None:
    """What a body of one coordinate has under a key whose place another key took: a stiffness where it tells a frequency."""
    if getattr(body, "n_coordinates", 0) != 1:
        return None
    stiffness, mass = (float(np.real(matrix()[0][0])) for matrix in (body.stiffness_matrix, body.mass_matrix))
    return {"stiffness": stiffness, "frequency": float(np.sqrt(stiffness / mass)) / (2.0 * np.pi)}.get(key)


def _allowed(value: Value, bound: float, guess: float) -> float:
    """The bound, limited to the range allowed in a scene."""
    inside, outside = guess, bound
    if _may_be(value, bound):
        return bound
    for _ in range(40):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if _may_be(value, middle) else (inside, middle)
    return inside


def _may_be(value: Value, number: float) -> bool:
    try:
        value.read(number)
    except SceneError:
        return False
    return True


def _range(scene: Scene, value: Value, prior: Any) -> tuple[float, float]:
    wanted = f"a range that rises, {_HINT}"
    try:
        parts = spread(prior.split(":"), ends=True) if isinstance(prior, str) else list(prior)
        refuse_mixed(parts, value.dimension)
        numbers = [quantity(_number(part), value.dimension) for part in parts]
    except QuantityError as error:
        raise SceneError(scene.source, value.name, shown(prior), error.wanted, error.hint) from None
    except TypeError:
        raise SceneError(scene.source, value.name, shown(prior), wanted) from None
    if len(numbers) != 2 or not np.isfinite(numbers).all() or not numbers[0] < numbers[1]:
        raise SceneError(scene.source, value.name, shown(prior), wanted)
    for number in numbers:
        value.read(number, scene.source)
    return numbers[0], numbers[1]


def _number(part: Any) -> Any:
    try:
        return float(part)
    except ValueError:
        return part
