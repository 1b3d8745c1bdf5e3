"""Mode shapes in an oblique view: the bent shaft, and the orbits of its nodes in the colour of their sense of whirl."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.mode_shapes import ModeShape
from rsc.analysis.alone.modes import Mode, Modes
from rsc.show.pictures.traces import BLUE, GREY, RED, axes, dots, line, named_once, numbers
from rsc.show.words.wording import frequency_text

MM = 1e3
SHAPES = 4  # modes whose shapes are shown: the lowest that oscillate
HEIGHT = 210
ORBITS = 12  # about so many nodes have their orbit drawn
ARC = np.linspace(0.0, 1.75 * np.pi, 41)  # an orbit begins at the node and ends before it: the gap shows the sense
FLAT = 0.035, 0.45  # of y, drawn to the right in lengths of the shaft, and up
SEEN = 1e-3  # of the largest distance: nodes that move less have no sense


def oscillating(modes: Modes) -> list[int]:
    """Numbers of the rotor's modes whose shapes are shown."""
    return [i for i, mode in enumerate(modes.rotor) if mode.frequency and i < len(modes.shapes)][:SHAPES]


def shape(modes: Modes, number: int) -> dict[str, Any]:
    """Description of the shape of one mode of the rotor; its caption names the mode.

    Lines and dots that move have `rest`, where they are without deflection, and `quarter`, where they are a quarter of a period
    later.
    """
    mode, own = modes.rotor[number], modes.shapes[number]
    places, reach = MM * own.position, MM * float(own.position.max())
    data = [line(places[[0, -1]], [0.0, 0.0], "axis", GREY, "dashdot", 1.0), *_directions(reach)]
    seen, forward = own.size > SEEN, own.is_positive == (modes.speed >= 0.0)
    step = max(1, round(len(places) / ORBITS))
    chosen = np.zeros(len(places), bool)
    chosen[int(np.argmax(own.size)) % step :: step] = True
    senses = [(forward & seen, "forward", BLUE), (~forward & seen, "backward", RED)]
    for which, name, colour in senses:
        if (which & chosen).any():
            x, y = _orbits(own, which & chosen, reach)
            data.append(line(x, y, f"orbit, {name}", colour, width=1.1))
    turned = [_view(places, own.at(phi), reach) for phi in (0.0, 0.5 * np.pi)]
    x, y = turned[0]
    data.append(_moving(line(x, y, "shaft", GREY, width=2.2), places, turned[1]))
    for which, name, colour in senses:
        if which.any():
            (x, y), quarter = ([part[which] for part in view] for view in turned)
            data.append(_moving(dots(x, y, f"node, {name}", colour, size=5), places[which], quarter))
    up = {"title": frequency_text(mode.frequency, ".4g"), "range": [-1.35, 1.35], "tickvals": [], "ticktext": []}
    along = {"title": "from the left end in mm", "range": [-0.13 * reach, 1.06 * reach]}
    return {"data": named_once(data), "layout": axes(along, up, HEIGHT), "caption": _caption(mode, modes.speed)}


def _caption(mode: Mode, speed: float) -> str:
    stable = f"logarithmic decrement {mode.decrement:.3g}" + (f", {mode.remark}" if mode.remark else "")
    at = frequency_text(speed, ".4g")
    return f"{frequency_text(abs(mode.frequency), '.4g')}, {mode.sense}, {stable}, at a rotor speed of {at}"


def _view(places: Any, r: NDArray[np.complex128], reach: float) -> Any:
    """Points of the picture: z is up, y away from the reader, drawn to the right and up."""
    return places + FLAT[0] * reach * r.real, r.imag + FLAT[1] * r.real


def _orbits(own: ModeShape, which: NDArray[np.bool_], reach: float) -> Any:
    """The orbits of some nodes, one after the other."""
    around = np.array([own.at(phi)[which] for phi in ARC]).T
    x, y = _view(MM * own.position[which, None], around, reach)
    gap = np.full((len(x), 1), np.nan)
    return np.hstack([x, gap]).ravel(), np.hstack([y, gap]).ravel()


def _directions(reach: float) -> list[dict[str, Any]]:
    """Which way y and z point, at the left end."""
    at, quiet = -0.1 * reach, {"showlegend": False, "hoverinfo": "skip"}
    x, y = _view(np.full(3, at), np.array([0.5j, 0.0, 0.6]), reach)
    lines = line(x, y + 0.6, "directions", GREY, width=1.0, **quiet)
    return [lines | {"mode": "lines+text", "text": ["z", "", "y"], "textposition": "top right"}]


def _moving(trace: dict[str, Any], places: Any, quarter: Any) -> dict[str, Any]:
    views = {"rest": (places, np.zeros(len(places))), "quarter": quarter}
    return trace | {name: {"x": numbers(x), "y": numbers(y)} for name, (x, y) in views.items()}
