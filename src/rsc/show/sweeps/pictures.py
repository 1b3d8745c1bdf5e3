"""Which pictures a sweep gets: maps over two varied keys, panels over one; its arrays handed to `rsc.show.pictures.maps`."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from rsc.show.pictures.settings import default_settings

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rsc.errors import DataError, SceneError, one_line
from rsc.files.output import OutputFile
from rsc.measure.kinds import Kind
from rsc.measure.words import VERDICTS
from rsc.results.labelled import Labelled
from rsc.scene.scene import Scene
from rsc.show.pictures import maps, plots
from rsc.show.pictures.maps import Curve, Panel, Side
from rsc.show.sweeps.words import WHIRL, danger_words, flag_words, set_words
from rsc.show.words.units import shown_as_in
from rsc.show.words.wording import frequencies_text, frequency_text

LARGEST = 1e100  # number that an axis can carry: widths and squares of it are finite
SAMPLE = "sample"  # the dimension of scattered values
MOST_CURVES = 8  # over a run-up rate; more values of the other key make a map
# picture -> variable, quantity
MAPPED = {
    "amplitude_predicted": ("whirl_amplitude", "amplitude of the predicted backward whirl"),
    "force_predicted": ("whirl_force", "normal force of the predicted backward whirl"),
    "amplitude": ("largest_amplitude", "largest amplitude of the run"),
    "force": ("largest_force", "largest normal force of the run"),
    "lasting_amplitude": ("lasting_amplitude", "largest |r| of the worst motion that lasts"),
    "lasting_force": ("lasting_force", "largest normal force of the worst motion that lasts"),
    "lasting_whirl_impulse": ("lasting_whirl_impulse", "smallest random impact that starts a whirl"),
    "jump": ("jump_speed", "rotor speed at which the run leaves its whirl"),
}
# the pressed sets of several contacts, each a picture of its own name
SETS = {
    "touched": "The contacts that touch at the end of each run.",
    "whirl_pressed": "The contacts that the largest predicted backward whirl presses.",
}
# quantity, unit, variable predicted for every whirl, variable of the end of a run, what a variable of motions that last ends in
PANELS = (
    ("whirl frequency", "Hz", "frequency", "turning_frequency", "frequency"),
    ("amplitude", "m", "rotor_amplitude", "amplitude_max", "amplitude"),
    ("normal force", "N", "normal_force", "force_mean", "force"),
)
# of two backward whirls, relative difference of their frequencies from which they are not one
APART = 0.05
MOST_WHIRLS = 3
NOTHING = "a key with 2 values or more, and something computed"
RARE = 0.02  # of the samples, with fewer of which a whirl is not drawn
TOLD_APART = 0.01  # of a range of frequencies, from which both ends are told
_KINDS = [str(kind) for kind in Kind]
WORDS: dict[str, Sequence[str]] = {"motion": _KINDS, "lasting": _KINDS, "verdict": VERDICTS}
Draw = Callable[..., Figure]  # of a picture: into a new figure, or into `axes`


def picture_files(data: Labelled, folder: Path) -> list[OutputFile]:
    """The files of every picture of a sweep, to be written by `rsc.files.output.put_all`; DataError where there is nothing to
    draw."""
    figures = pictures(data)
    if not figures:
        raise DataError("<sweep>", f"nothing to draw: must have {NOTHING}")
    return [plots.picture_file(figure, folder / f"{name}.png") for name, figure in figures.items()]


@default_settings()
def pictures(data: Labelled) -> dict[str, Figure]:
    """name -> picture of all that a sweep computed.

    Raises
    ------
    DataError
        A number is so large that no axis can carry it.
    """
    refuse_undrawable(data)
    with shown_as_in(scene_of(data)):
        return {name: draw() for name, draw in drawings(data).items()}


def panels_apart(drawn: dict[str, Draw]) -> dict[str, Draw]:
    """Drawings that fill one pair of axes each: those of several quantities become one for each, under its name."""
    apart: dict[str, Draw] = {}
    for name, draw in drawn.items():
        if not isinstance(draw, partial) or draw.func is not maps.plot_panels:
            apart[name] = draw
            continue
        x, panels = draw.args
        beside = name.removeprefix("curves").removeprefix("scatter")
        for panel in panels:
            apart[f"{panel.name}_{beside}" if beside else panel.name] = partial(maps.plot_panels, x, [panel], **draw.keywords)
    return apart


def scene_of(data: Labelled) -> Scene | None:
    """The scene of a sweep before anything was varied, None where it is not known: it says in which units numbers are shown."""
    try:
        return Scene.from_stored(data.attributes["scene"], "<sweep>")
    except (KeyError, SceneError):
        return None


def drawings(data: Labelled) -> dict[str, Draw]:
    """name -> what draws it, of all that a sweep computed."""
    title = one_line(data.attributes.get("title", ""))
    long = [dim for dim, size in data.dims.items() if dim != WHIRL and size > 1]
    keys = [dim for dim in long if dim in data.coordinates]
    if len(keys) >= 2:
        y_key, x_key = sorted(keys, key=lambda key: data.dims[key])[-2:] if len(keys) > 2 else keys
        if "speed" in y_key or y_key == "drive.duration" or _one_vector(y_key, x_key):
            x_key, y_key = y_key, x_key
        return _maps(data, x_key, y_key, title, [dim for dim in long if dim not in (x_key, y_key)])
    if len(keys) == 1 and long == keys:
        panels = _panels(data, keys[0], "line")
        return {"curves": partial(maps.plot_panels, side(data, keys[0]), panels, title=title)} if panels else {}
    if len(keys) == 1 and sorted(long) == sorted([*keys, SAMPLE]) and "frequency" in data:
        return {"scatter": partial(maps.plot_panels, side(data, keys[0]), _scatter(data, keys[0]), title=title)}
    if len(long) == 1:  # samples, a table or lists side by side
        shared = [key for key, (dims, _, _) in data.coordinates.items() if dims == tuple(long)]
        drawn = {key: _panels(data, key, "dots") for key in shared}
        # of a file, whose name may not have a * everywhere
        names = {key: f"over_{key.replace('*', 'all')}" for key in shared if drawn[key]}
        return {name: partial(maps.plot_panels, side(data, key), drawn[key], title=title) for key, name in names.items()}
    return {}


def refuse_undrawable(data: Labelled) -> None:
    """Files that others made may hold any number; matplotlib's ticks and cells overflow."""
    for name, (_, values, _) in (data.coordinates | data.variables).items():
        if values.dtype.kind in "fiu" and np.any(np.abs(values[np.isfinite(values)]) > LARGEST):
            raise DataError("<sweep>", f"{name} has numbers beyond {LARGEST:g}, which cannot be drawn")


def side(data: Labelled, key: str) -> Side:
    """An axis of a map, its values rising."""
    _, values, about = data.coordinates[key]
    meaning = about.get("long_name", "").split(":")[0].split(". ")[0].rstrip(".").strip()
    ordered = np.sort(values) if values.dtype.kind in "fiu" else values
    factor, unit = maps.scaled(values, about.get("units", "")) if values.dtype.kind in "fiu" else (1.0, "")
    label = f"{meaning[:1].lower()}{meaning[1:]} ({key})" if meaning else key
    return Side(factor * ordered if factor != 1.0 else ordered, f"{label} in {unit}" if unit else label)


def _maps(data: Labelled, x_key: str, y_key: str, title: str, others: Sequence[str]) -> dict[str, Draw]:
    """The maps over two keys; over other dimensions the worst is shown, of words nothing."""
    if others:
        title = f"{title}\nthe worst over {', '.join(others)}"
    x, y = side(data, x_key), side(data, y_key)
    drawn: dict[str, Draw] = {}
    if "danger" in data:
        classes = _plane(data, "danger", x_key, y_key).astype(int)
        drawn["danger"] = partial(
            maps.plot_classes, x, y, classes, _legend(danger_words(data), maps.DANGER_COLOURS), title=title,
            marked=_without_run(data, x_key, y_key),
            lines=[] if others else _least_friction(data, x, y, x_key, y_key)
        )  # fmt: skip
    if "severity" in data:
        classes = _plane(data, "severity", x_key, y_key).astype(int)
        legend = _legend(flag_words(data, "severity"), maps.SEVERITY_COLOURS)
        drawn["severity"] = partial(maps.plot_classes, x, y, classes, legend, title=title)
    for name, words in WORDS.items():
        if name in data and not others:
            numbers = {word: i for i, word in enumerate(words)}
            codes = np.vectorize(lambda word, numbers=numbers: numbers.get(word, -1), otypes=[int])(data[name])
            if name == "motion":
                codes, words = _whirls_apart(codes, data["turning_frequency"])
            codes = _plane_of(data, codes.astype(float), name, x_key, y_key).astype(int)
            drawn[name] = partial(maps.plot_classes, x, y, codes, _legend(words), title=title)
    drawn |= {} if others else _maps_of_sets(data, x_key, y_key, title)
    for picture, (name, quantity) in MAPPED.items():
        if name not in data or np.isnan(data[name]).all():
            continue
        if name == "jump_speed" and "drive.duration" in (x_key, y_key):
            drawn[picture] = _jumps(data, x_key, y_key, title)
            continue
        unit = data.variables[name][2].get("units", "")
        values = _plane(data, name, x_key, y_key)
        drawn[picture] = partial(maps.plot_values, x, y, values, quantity=quantity, unit=unit, title=title)
    if _one_vector(x_key, y_key):
        return {name: partial(_of_equal_scales, draw) for name, draw in drawn.items()}
    return drawn


def _legend(words: Sequence[str], colours: Sequence[str] = maps.CLASS_COLOURS) -> list[tuple[str, str]]:
    return list(zip(words, colours, strict=False))


def _of_equal_scales(draw: Draw, axes: Axes | None = None) -> Figure:
    """A map whose sides have one scale."""
    figure = draw(axes=axes)
    (axes or figure.axes[0]).set_aspect("equal")
    return figure


def _maps_of_sets(data: Labelled, x_key: str, y_key: str, title: str) -> dict[str, Draw]:
    """The maps of the sets of several contacts; none of one, nor of more sets than there are colours."""
    x, y = side(data, x_key), side(data, y_key)
    drawn: dict[str, Draw] = {}
    for name in (name for name in SETS if name in data):
        classes, words = set_words(data, name)
        if 0 < len(words) <= len(maps.CLASS_COLOURS):
            codes = _plane_of(data, classes.astype(float), name, x_key, y_key).astype(int)
            drawn[name] = partial(maps.plot_classes, x, y, codes, _legend(words), title=title)
    return drawn


def _without_run(data: Labelled, x_key: str, y_key: str) -> tuple[str, NDArray[np.bool_]] | None:
    """The cells in which no run could be made, so that their class is predicted alone; None where none was asked for."""
    if "motion" not in data:
        return None
    made = _plane_of(data, (data["motion"] != "").astype(float), "motion", x_key, y_key) > 0.0
    status = sorted(set(data["status"][data["motion"] == ""].tolist()))
    return f"predicted only, its run is {' or '.join(status)}", ~made


def _one_vector(first: str, second: str) -> bool:
    """Whether two keys are the y and z of one complex number."""
    return first.endswith("[0]") and second == f"{first[:-3]}[1]"


def _whirls_apart(codes: NDArray[np.int_], frequency: NDArray[np.float64]) -> tuple[NDArray[np.int_], list[str]]:
    """Classes of motions, and their words, with backward whirls of up to three frequencies as classes of their own."""
    words, codes, whirl = list(_KINDS), codes.copy(), _KINDS.index(Kind.SLIDING)
    seen = (codes == whirl) & np.isfinite(frequency)
    values = frequency[seen]
    groups = [np.sort(values[places]) for places in _apart(values)]
    if not values.size or len(groups) > MOST_WHIRLS:
        return codes, words
    for i, group in enumerate(groups):
        code = whirl if i == 0 else len(words)
        codes[seen & (frequency >= group[0]) & (frequency <= group[-1])] = code
        wide = np.ptp(group) > TOLD_APART * abs(group[0])
        rate = frequencies_text(group[0], group[-1], ".4g") if wide else frequency_text(group[0], ".4g")
        words[code:] = [f"{Kind.SLIDING} at {rate}", *words[code + 1 :]]
    return codes, words


def _plane(data: Labelled, name: str, x_key: str, y_key: str) -> NDArray[np.float64]:
    return _plane_of(data, data[name].astype(float), name, x_key, y_key)


def _plane_of(data: Labelled, values: NDArray[np.float64], name: str, x_key: str, y_key: str) -> NDArray[np.float64]:
    """Values (n_y, n_x) in the order of rising keys; over all other dimensions the largest, of an impulse the smallest."""
    dims = data.variables[name][0]
    moved = np.moveaxis(values, (dims.index(y_key), dims.index(x_key)), (0, 1))
    worst = np.fmin if name.endswith("_impulse") else np.fmax
    plane = worst.reduce(moved.reshape(*moved.shape[:2], -1), axis=-1)
    return plane[np.ix_(_rising(data, y_key), _rising(data, x_key))]


def _rising(data: Labelled, key: str) -> NDArray[np.intp]:
    """The order in which the values of a key rise; words stay as they are."""
    values = data.coordinates[key][1]
    return np.argsort(values) if values.dtype.kind in "fiu" else np.arange(len(values))


def _least_friction(data: Labelled, x: Side, y: Side, x_key: str, y_key: str) -> list[tuple[str, NDArray, NDArray]]:
    """The least friction with which a whirl exists, as a line over a map with friction on a side."""
    if "mu_min" not in data or "contact.friction" not in (x_key, y_key):
        return []
    plane = _plane(data, "mu_min", x_key, y_key)
    on_y = y_key == "contact.friction"
    least, friction = plane.max(axis=0 if on_y else 1), (y if on_y else x).places
    least = np.where((least >= friction[0]) & (least <= friction[-1]), least, np.nan)
    if np.isnan(least).all():
        return []
    name = "least friction of any whirl in rigid contact"
    return [(name, x.places, least) if on_y else (name, least, y.places)]


def _jumps(data: Labelled, x_key: str, y_key: str, title: str) -> Draw:
    """The speed of the jump over the rate of the run-up."""
    other = y_key if x_key == "drive.duration" else x_key
    plane = _plane(data, "jump_speed", "drive.duration", other)
    speed = Scene.from_stored(data.attributes["scene"], "<sweep>").drive.speed
    rate = abs(speed[-1] - speed[0]) / np.sort(data["drive.duration"])
    x, key = Side(rate[::-1], "run-up rate in Hz/s"), side(data, other)
    if len(key.values) > MOST_CURVES:
        quantity = MAPPED["jump"][1]
        return partial(maps.plot_values, x, key, plane[:, ::-1], quantity=quantity, unit="Hz", title=title)
    curves = [Curve(f"{other} = {value:g}", values[::-1]) for value, values in zip(key.values, plane, strict=True)]
    return partial(maps.plot_panels, x, [Panel("speed of the jump", "Hz", curves)], title=title)


def _panels(data: Labelled, key: str, style: str) -> list[Panel]:
    """Quantities over a key along the only dimension; those that depend on this key alone as lines, else as dots."""
    panels = []
    for quantity, unit, predicted, simulated, lasting in PANELS:
        curves = _whirls(data, predicted, key) if predicted in data else []
        if simulated in data:
            curves.append(Curve("end of the run", _along(data, simulated, key), "dots"))
        if f"lasting_{lasting}" in data:
            curves += _lasting(data, lasting, key)
        panels += [Panel(quantity, unit, curves)] if curves else []
    if "jump_speed" in data:
        names = {"crossing_speed": "the whirl loses its stability", "jump_speed": "the run leaves it"}
        panels.append(Panel("rotor speed", "Hz", [Curve(text, _along(data, name, key), style) for name, text in names.items()]))
    if "mu_min" in data:
        panels.append(Panel("least friction", "1", [Curve("a whirl exists from here", _along(data, "mu_min", key), style)]))
    if "contact_share" in data:
        share = Curve("end of the run", _along(data, "contact_share", key), "dots")
        panels.append(Panel("time in contact", "1", [share], share=True))
    return panels


def _lasting(data: Labelled, ending: str, key: str) -> list[Curve]:
    """The most dangerous motions that last, and the most dangerous whirls where those are others."""
    worst = _along(data, f"lasting_{ending}", key)
    curves = [Curve("most dangerous motion that lasts", worst, "dots")]
    if f"lasting_whirl_{ending}" in data:
        whirl = _along(data, f"lasting_whirl_{ending}", key)
        other = np.where(whirl == worst, np.nan, whirl)
        curves += [Curve("most dangerous whirl that lasts", other, "dots")] if np.isfinite(other).any() else []
    return curves


def _scatter(data: Labelled, key: str) -> list[Panel]:
    """Stable backward whirls of scattered values over a key: the middle nine tenths of each, and how often there is one."""
    wanted = {name: (quantity, unit) for quantity, unit, name, *_ in PANELS}
    arrays = {name: _by_sample(data, name, key) for name in (*wanted, "admissible", "stable")}
    exists = arrays["admissible"].astype(bool) & arrays["stable"].astype(bool) & (arrays["frequency"] < 0.0)
    n_samples, n_places = exists.shape[:2]
    bars = {name: np.full((MOST_WHIRLS, n_places, 3), np.nan) for name in wanted}
    for i in range(n_places):
        seen = {name: arrays[name][:, i][exists[:, i]] for name in wanted}
        groups = _apart(seen["frequency"])
        for slot, group in enumerate(g for g in groups[:MOST_WHIRLS] if len(g) >= RARE * n_samples):
            for name, values in seen.items():
                bars[name][slot, i] = np.percentile(values[group], (5, 50, 95))
    text = f"stable backward whirl: 5, 50 and 95 % of {n_samples} samples"
    panels = [
        Panel(quantity, unit, [Curve(text, bar, "bars") for bar in bars[name]]) for name, (quantity, unit) in wanted.items()
    ]
    often = Curve("share of the samples with one", exists.any(axis=2).mean(axis=0))
    return [*panels, Panel("share", "1", [often], share=True)]


def _apart(frequency: NDArray[np.float64]) -> list[NDArray[np.intp]]:
    """Places of frequencies in groups that are further apart than one whirl scatters, from the lowest."""
    order = np.argsort(frequency)
    rising = frequency[order]
    return np.split(order, np.flatnonzero(np.diff(rising) > APART * np.abs(rising[:-1])) + 1)


def _by_sample(data: Labelled, name: str, key: str) -> NDArray:
    """Values (n_samples, n_places, n_whirls) in the order of the rising key."""
    dims, values, _ = data.variables[name]
    lengths = [data.dims[dim] for dim in (SAMPLE, key, WHIRL)]
    moved = np.moveaxis(values, [dims.index(SAMPLE), dims.index(key), dims.index(WHIRL)], [0, 1, 2]).reshape(lengths)
    return moved[:, _rising(data, key)]


def _whirls(data: Labelled, name: str, key: str) -> list[Curve]:
    """A quantity of all backward whirls whose side conditions hold: those that are stable, and the others."""
    shown = _along(data, "admissible", key).astype(bool) & (_along(data, "frequency", key) < 0.0)
    stable, values = _along(data, "stable", key).astype(bool), _along(data, name, key)
    return [
        Curve(f"predicted backward whirl, {word}", np.where(shown & flag, values, np.nan), word)
        for word, flag in (("stable", stable), ("unstable", ~stable))
        if values.shape[1]  # else no case has any whirl
    ]


def _along(data: Labelled, name: str, key: str) -> NDArray:
    """Values in the order of the rising key: (n,), or (n, n_whirls)."""
    dims, values, _ = data.variables[name]
    lengths = [data.dims[dim] for dim in dims if dim == WHIRL]
    return values.reshape(len(data.coordinates[key][1]), *lengths)[_rising(data, key)]
