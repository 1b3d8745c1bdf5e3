"""The cases of a sweep: which values of a scene are varied, over a grid, side by side, in samples or by a table."""

import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.arguments import FLAG, NAMED, PATH, SCENE, WHOLE, optional, takes
from rsc.errors import DataError, SceneError, SolverError, one_line, shown
from rsc.files.content import content_of
from rsc.files.csv_lines import csv_lines
from rsc.results.sweep_store import CASE, SAMPLE, ZIPPED, Axis, Cases
from rsc.scene.scene import Scene
from rsc.scene.values import Value, value_of
from rsc.units import QuantityError, quantity
from rsc.units.together import refuse_mixed, spread

MOST_CASES = 10_000_000
LARGEST_TABLE = 500_000_000  # bytes
_DISTRIBUTIONS = ("normal", "uniform")
_FORMS = "FROM:TO:NUMBER, log:FROM:TO:NUMBER, A,B,C, normal:MEAN:DEVIATION or uniform:FROM:TO"


@takes(
    scene=SCENE, vary=optional(NAMED), zipped=FLAG, random=WHOLE, sobol=WHOLE, seed=WHOLE, table=optional(PATH), most=WHOLE
)
def cases(
    scene: Scene,
    vary: Mapping[str, Any] | None = None,
    *,
    zipped: bool = False,
    random: int = 0,
    sobol: int = 0,
    seed: int = 0,
    table: str | Path | None = None,
    most: int = MOST_CASES,
) -> Cases:
    """The cases of a sweep.

    Parameters
    ----------
    scene : Scene
    vary : mapping
        Name of a value (`contact.friction`, `start.rotor[0][1]`) to its values: a sequence, or a text as on the command line,
        "0.05:0.4:36" (from, to, number), "log:1e5:1e7:20", "0.1 mm,0.2 mm", or a scatter "normal:0.2:0.02" (mean, standard
        deviation) or "uniform:0.1:0.3".
    zipped : bool
        All lists and ranges, equally long, go side by side along one dimension instead of spanning a grid.
    random, sobol : int
        Number of samples of the scattered values, drawn independently or from a scrambled Sobol sequence; they form one dimension
        beside those of the grid.
    seed : int
        Of the samples.
    table : str or Path, optional
        A CSV file whose head names values and whose rows are cases.
    most : int
        Refuse more cases.

    Returns
    -------
    Cases

    Raises
    ------
    SceneError
        A value that the scene does not have, or that no scene may have in this place.
    SolverError
        No case, too many, or options that contradict each other.
    DataError
        The table cannot be read.

    Examples
    --------
    >>> scene = rsc.load_scene("laval.toml")
    >>> grid = rsc.cases(scene, {"contact.friction": "0.1:0.3:5", "contact.gap": "0.5 mm,1 mm"})
    >>> [len(axis.values) for axis in grid.axes]
    [5, 2]
    """
    vary = dict(vary or {})
    scattered = {name: text for name, text in vary.items() if _distribution(text)}
    _refuse_contradictions(vary, scattered, random, sobol, table)
    axes = [_axis(scene, name, vary[name], ZIPPED if zipped else name) for name in vary if name not in scattered]
    if zipped and len({len(axis.values) for axis in axes}) > 1:
        lengths = ", ".join(f"{len(axis.values)} of {axis.key}" for axis in axes)
        raise SolverError(f"--zip: {lengths}: must be equally many values")
    if scattered:
        axes += _samples(scene, scattered, random or sobol, bool(sobol), seed)
    if table is not None:
        axes += _table(scene, Path(table))
    result = Cases(tuple(axes))
    if len(set(result.keys)) < len(axes):
        raise SolverError("a key stands both in the table and in --vary")
    if (count := math.prod(result.dims.values())) > most:
        raise SolverError(f"a sweep of {count} cases: must be at most {most} (--yes for more; Python: cases(most=...))")
    return result


def _refuse_contradictions(
    vary: Mapping[str, Any], scattered: Mapping[str, Any], random: int, sobol: int, table: str | Path | None
) -> None:
    if not vary and table is None:
        raise SolverError("a sweep of 0 cases: must vary something (--vary KEY=VALUES or --table FILE)")
    for name, count in (("--random", random), ("--sobol", sobol)):
        if count < 0 or count > MOST_CASES:
            raise SolverError(f"{name} {count}: must be a number of samples from 1 to {MOST_CASES}")
    if random and sobol:
        raise SolverError("--random and --sobol exclude each other: must be one of them")
    if scattered and not (random or sobol):
        name = next(iter(scattered))
        raise SolverError(f"{name} = {scattered[name]}: requires a number of samples (--random N or --sobol N)")
    if (random or sobol) and not scattered:
        raise SolverError("no random values to sample: must have one (--vary KEY=normal:MEAN:DEVIATION or uniform:FROM:TO)")


def _distribution(text: Any) -> bool:
    return isinstance(text, str) and text.partition(":")[0].strip() in _DISTRIBUTIONS


def _axis(scene: Scene, name: str, values: Any, dim: str) -> Axis:
    """The axis of a list, a range or its text; every value must be allowed in a scene."""
    value = value_of(scene, name)
    raw = _from_text(scene, value, values) if isinstance(values, str) else _listed(scene, name, values)
    read = tuple(value.read(item, scene.source) for item in raw)
    if not read:
        raise SceneError(scene.source, name, [], "at least one value", "a sweep of 0 cases")
    repeated = next((item for i, item in enumerate(read[1:], 1) if item == read[i - 1]), None)
    if repeated is not None or len(set(read)) < len(read):
        raise SceneError(scene.source, name, shown(values), "different values", "a step of 0?")
    return Axis(name, dim, read, value.unit, value.meaning)


def _listed(scene: Scene, name: str, values: Any) -> list[Any]:
    try:
        return np.asarray(values).tolist() if isinstance(values, np.ndarray) else list(values)
    except TypeError:
        raise SceneError(scene.source, name, shown(values), "a sequence of values, or a text", _FORMS) from None


def _from_text(scene: Scene, value: Value, text: str) -> Sequence[Any]:
    """The values of a text: a range, a logarithmic range, or a list."""
    parts = [part.strip() for part in text.split(":")]
    logarithmic = parts[0] == "log"
    ends = parts[1:] if logarithmic else parts
    if len(ends) == 1 and not logarithmic:
        return [_number_or_word(part) for part in _spread(scene, value, ends[0].split(","))]
    if len(ends) != 3 or not value.unit:
        raise SceneError(scene.source, value.name, text, f"of the form {_FORMS}")
    low, high = (value.read(_number_or_word(end), scene.source) for end in _spread(scene, value, ends[:2], ends=True))
    count = _count(scene, value, ends[2])
    if logarithmic and not (float(low) > 0.0 and float(high) > 0.0):
        raise SceneError(scene.source, value.name, text, "a logarithmic range between numbers > 0")
    if low == high:
        raise SceneError(scene.source, value.name, text, "a range between two different numbers", "its step is 0")
    grid = np.geomspace(float(low), float(high), count) if logarithmic else np.linspace(float(low), float(high), count)
    # 12 digits: what people would write, and so that a finer grid holds the values of a coarser one
    return [round(x) if isinstance(low, int) else float(f"{x:.12g}") for x in grid.tolist()]


def _spread(scene: Scene, value: Value, parts: Sequence[str], ends: bool = False) -> list[str]:
    """The parts of a list or range, where a unit that stands once is that of all."""
    try:
        return spread(parts, ends)
    except QuantityError as error:
        raise SceneError(scene.source, value.name, ",".join(parts), error.wanted, error.hint) from None


def _count(scene: Scene, value: Value, text: str) -> int:
    """The number of values of a range."""
    try:
        count = int(text)
    except ValueError:
        raise SceneError(scene.source, value.name, text, "a whole number of values", _FORMS) from None
    if count < 2:
        hint = "a sweep of 0 cases" if count < 1 else ""
        raise SceneError(scene.source, value.name, count, "2 values or more in a range", hint)
    if count > MOST_CASES:
        raise SolverError(f"{value.name} = {text} values: must be at most {MOST_CASES} of one key")
    return count


def _number_or_word(text: str) -> float | bool | str:
    """A number, true or false as such; anything else, a quantity with a unit or a word, as text."""
    try:
        return float(text)
    except ValueError:
        return {"true": True, "false": False}.get(text, text)


def _samples(scene: Scene, scattered: Mapping[str, str], count: int, sobol: bool, seed: int) -> list[Axis]:
    """Axes along "sample" of random values; a sample may be outside the range allowed in a scene."""
    if sobol:
        with warnings.catch_warnings():  # any number of samples is welcome, not only powers of two
            warnings.simplefilter("ignore", UserWarning)
            uniform = scipy.stats.qmc.Sobol(len(scattered), seed=seed).random(count)
    else:
        uniform = np.random.default_rng(seed).random((count, len(scattered)))
    axes = []
    for (name, text), column in zip(scattered.items(), uniform.T, strict=True):
        value, parts = value_of(scene, name), [part.strip() for part in text.split(":")]
        if len(parts) != 3 or not value.dimension:
            raise SceneError(scene.source, name, text, "of the form normal:MEAN:DEVIATION or uniform:FROM:TO")
        first, second = (_quantity(scene, value, part) for part in _spread(scene, value, parts[1:], ends=True))
        axes.append(Axis(name, SAMPLE, _drawn(scene, name, parts[0], (first, second), column), value.unit, value.meaning))
    return axes


def _drawn(scene: Scene, name: str, kind: str, bounds: tuple[float, float], uniform: NDArray[np.float64]) -> tuple[float, ...]:
    """Values of a distribution at uniform samples between 0 and 1."""
    first, second = bounds
    if kind == "normal":
        if not second > 0.0:
            raise SceneError(scene.source, name, second, "a standard deviation > 0")
        tiny = np.finfo(float).tiny
        return tuple((first + second * scipy.special.ndtri(np.clip(uniform, tiny, 1.0 - 2.0**-53))).tolist())
    if not second > first:
        raise SceneError(scene.source, name, f"{kind}:{first:g}:{second:g}", "a range that rises")
    return tuple((first + (second - first) * uniform).tolist())


def _quantity(scene: Scene, value: Value, text: str) -> float:
    """A number of a value's dimension, in SI, in any range."""
    try:
        return quantity(_number_or_word(text), value.dimension)
    except QuantityError as error:
        raise SceneError(scene.source, value.name, text, error.wanted, error.hint) from None


def _table(scene: Scene, path: Path) -> list[Axis]:
    """Axes along "case" of a CSV file."""
    text = content_of(path, LARGEST_TABLE).decode("utf-8-sig", errors="replace")
    lines = csv_lines(path, text)
    _, head = next(lines, (1, []))
    names = [name.strip() for name in head]
    if not names or len(set(names)) < len(names):
        raise DataError(path, "its first line must name different values of the scene, separated by commas")
    values = [value_of(scene, name) for name in names]
    rows: dict[tuple[Any, ...], int] = {}
    raws: list[list[str]] = []
    for number, cells in lines:
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) != len(names):
            raise DataError(path, f"line {number} has {len(cells)} cells, its first line {len(names)}")
        raws.append([cell.strip() for cell in cells])
        try:
            row = tuple(_cell(scene, value, cell) for value, cell in zip(values, raws[-1], strict=True))
        except SceneError as error:
            raise DataError(path, f"line {number}: {one_line(error.key)} = {error.value!r}: must be {error.wanted}") from None
        if rows.setdefault(row, number) != number:
            raise DataError(path, f"line {number} is the case of line {rows[row]} again: must be different cases")
    if not rows:
        raise DataError(path, "has no cases below its first line (a sweep of 0 cases)")
    for value, column in zip(values, zip(*raws, strict=True), strict=True):
        try:
            refuse_mixed(column if value.dimension else (), value.dimension)
        except QuantityError as error:
            raise DataError(path, f"column {one_line(value.name)}: must be {error.wanted} ({error.hint})") from None
    columns = zip(values, zip(*rows, strict=True), strict=True)
    return [Axis(value.name, CASE, tuple(column), value.unit, value.meaning) for value, column in columns]


def _cell(scene: Scene, value: Value, text: str) -> Any:
    return _quantity(scene, value, text) if value.dimension and not text[:1].isalpha() else value.read(_number_or_word(text))
