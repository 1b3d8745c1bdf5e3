"""The pictures of a report along its run: how each is described, and where page and files have it."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from rsc.show.pictures import paths, pictures
from rsc.show.pictures.drawing import drawing
from rsc.show.pictures.shapes import SHAPES, oscillating, shape
from rsc.show.pictures.traces import in_units

# sections of the page that have pictures
SECTIONS = ("Machine", "Frequencies", "Amplitude", "Force and friction", "Unbalance response", "Energy")


class Entry(NamedTuple):
    """A picture of a report.

    To add one: a function that describes it in lines, dots, heat maps and axes of `rsc.show.pictures.traces`, and an entry in
    `PICTURES`; page, paper and PNG draw the description, or refuse a kind of trace that they do not know.
    """

    describe: Callable  # (report, along) -> the description, None where there is nothing to show
    caption: str = ""  # {word}: simulated or measured; {mean}: largest distance of a window's mean position, in its unit
    section: str = ""  # of the page, one of `SECTIONS`; "": not on the page
    file: str = ""  # name of a PNG, which pictures of one name share; "": none
    title: str = ""  # of the PNG, beside that of the scene
    compares: bool = False  # whether it is described with the reports of other runs as well


def _machine(report, along):
    return drawing(report.result.scene)


def _shape(report, along, i):
    """The shape of mode i of the rotor at the highest speed of the run; None where the rotor was not given by its stations."""
    if not getattr(report.result.scene.rotor, "nodes", None):
        return None
    numbers = oscillating(report.modes)
    return shape(report.modes, numbers[i]) if i < len(numbers) else None


PICTURES = {
    "machine": Entry(
        _machine,
        "The rotor by its stations, to scale along the axis and across it, each with a scale of its own. Bearings stand on the "
        "ground; contacts and clearances are drawn at a distance that can be seen, their radial gaps stand beside them.",
        "Machine",
        "machine",
    ),
    **{
        f"mode_{i + 1}": Entry(partial(_shape, i=i), "", "Machine", "mode_shapes", "mode shapes" if i == 0 else "")
        for i in range(SHAPES)
    },
    "campbell": Entry(
        pictures.campbell,
        "Campbell diagram. Shade: {word} amplitude without the mean of every window, which lies up to {mean} from the bearing "
        "centre. Vermilion: predicted whirls, dashed where unstable, "
        "dotted where they are not circular and their stability is not assessed. Grey: multiples of the rotor speed. Green and "
        "purple: natural frequencies of rotor and stator joined, and of the rotor alone.",
        "Frequencies",
        "campbell",
    ),
    "campbell_stator": Entry(pictures.campbell_of_stator, file="campbell_stator", title="motion of the stator"),
    "waterfall": Entry(pictures.waterfall, file="waterfall"),
    "amplitude": Entry(
        pictures.amplitude,
        "Largest and smallest distance at the contact in every window, the predicted whirls with their unbalance "
        "response, and the line at the rotor speed (1X).",
        "Amplitude",
        "amplitude",
        compares=True,
    ),
    "whirl_line": Entry(
        pictures.whirl_line,
        "Line at the whirl frequency, {word} and predicted in the windows on a whirl, at the body that moves more.",
        "Amplitude",
    ),
    "force": Entry(
        pictures.force,
        "Normal force of the contact: mean and largest in every window, and that of the predicted whirls.",
        "Force and friction",
        "contact",
    ),
    "power": Entry(pictures.power, "Power of friction.", "Force and friction", "contact"),
    "share": Entry(
        pictures.share,
        "Share of the time in contact: 100 % is a whirl or a full rub, less is bouncing.",
        "Force and friction",
        "contact",
    ),
    "slip": Entry(pictures.slip, "Slip velocity of the surfaces.", "Force and friction", "contact"),
    "bode_amplitude": Entry(
        pictures.bode_amplitude,
        "Bode: forward line at the rotor speed, amplitude.",
        "Unbalance response",
    ),
    "bode_phase": Entry(
        pictures.bode_phase,
        "Bode: forward line at the rotor speed, phase lag relative to the mark on the shaft.",
        "Unbalance response",
    ),
    "polar": Entry(
        pictures.polar,
        "Polar: forward line at the rotor speed in the frame of the shaft.",
        "Unbalance response",
    ),
    "centre": Entry(
        paths.centre_line,
        "Shaft centre line: mean position of the rotor in every window, from the ring; dashed: the gap.",
        "Unbalance response",
        "centre_line",
        "mean position of the windows",
    ),
    "turns": Entry(
        paths.once_a_turn,
        "Distance at each revolution of the shaft: one line of dots is a motion that the rotation repeats, a band or "
        "several lines one that it does not, as a whirl; dash-dotted: the gap.",
        "Unbalance response",
        "once_a_turn",
    ),
    "energy": Entry(
        pictures.energy,
        "Energy of the whole run: put in by unbalance and load and by friction; lost to damping in rotor, stator and "
        "contact, or stored.",
        "Energy",
    ),
}


def described(report, along, others=(), on_page=True):
    """name -> description of the pictures of the page, or of the files, that there is something to show in."""
    made = {}
    for name, entry in PICTURES.items():
        if entry.section not in ("", *SECTIONS):
            raise ValueError(f"picture {name}: the page has no section {entry.section!r}, only {', '.join(SECTIONS)}")
        if entry.section if on_page else entry.file:
            made[name] = entry.describe(report, along, others) if entry.compares else entry.describe(report, along)
    return {name: in_units(picture) for name, picture in made.items() if picture is not None}
