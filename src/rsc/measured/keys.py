"""The TOML table `[measured]`, which describes the columns of a measured file."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rsc.errors import SceneError, nearest, one_line, shown
from rsc.scene.files.toml_file import tables_of, text_of
from rsc.scene.keys.keys import OPTIONAL, RawTable, declare, read_table
from rsc.scene.keys.readers import Choice, Integer, Number, Sequence, Text, as_list

COLUMN = "a column: its name in the head of the file, or its number from \"1\" on"
BETWEEN = 1.0  # degrees; probes whose directions differ by less cannot tell a plane motion


@dataclass(frozen=True, kw_only=True)
class Probe:
    """[[measured.probe]]: one displacement at the contact.

    column : str; angle : degrees from y towards z; sensitivity : V/m or None; unit : m of a one in the column, or None: of both
    one at most, and none where the file states a unit of length
    """

    column: str = declare(Text(), meaning=f"Its signal, {COLUMN}.")
    angle: float = declare(
        Number("angle in degrees", low=-720.0, high=720.0),
        meaning="Direction that it looks in, from y towards z; both probes as seen from the same end of the shaft.",
    )
    sensitivity: float | None = declare(Number("sensitivity"), None, meaning="Volts a metre, negative where it is turned round.")
    unit: float | None = declare(
        Number("length", above=0.0), None, meaning="Unit of the column: `\"1 um\"`; default: the unit stated in the file."
    )

    one_of = ((("sensitivity", "unit"), OPTIONAL),)  # one must be given where the file states no unit of length (scales.py)


@dataclass(frozen=True, kw_only=True)
class Channels:
    """[measured]: the file, its columns, and how the shaft turns."""

    file: str = declare(Text(), meaning="Data file, in any format of the table in docs/users/measured.md; relative to this file.")
    time: str | None = declare(Text(), None, meaning=f"Time, {COLUMN}; not where the format says when its samples were taken.")
    time_unit: float | None = declare(
        Number("time", above=0.0), None, meaning="Unit of the times: `\"1 ms\"`; default: the unit stated in the file, else 1 s."
    )
    rate: float | None = declare(Number("frequency", above=0.0), None, meaning="Samples a second, where no column has the time.")
    full_scale: float = declare(Number("voltage", above=0.0), 1.0, meaning="Volts of the largest number of a WAV file.")
    keyphasor: str | None = declare(Text(), None, meaning=f"Pulses of the shaft, {COLUMN}.")
    events_per_turn: int = declare(Integer(1, 1000), 1, meaning="Pulses in a turn.")
    keyphasor_angle: float = declare(
        Number("angle in degrees", low=-720.0, high=720.0), 0.0, meaning="Direction of the Keyphasor, from y towards z."
    )
    speed: str | None = declare(Text(), None, meaning=f"Speed of the shaft, {COLUMN}, without a Keyphasor.")
    speed_unit: float | None = declare(
        Number("frequency", above=0.0),
        None,
        meaning="Unit of the speed: `\"1 rpm\"`; default: the unit stated in the file, else 1 Hz.",
    )
    sense: str = declare(
        Choice(("y to z", "z to y")),
        "y to z",
        meaning="Direction of rotation. Motions are seen from the side where it is y to z.",
    )
    slow_roll: tuple[float, ...] | None = declare(
        Sequence(Number("frequency", low=0.0)),
        None,
        meaning="Lowest and highest speed at which only runout is seen: it is taken off, with the position there.",
    )
    probe: tuple[Probe, ...] = declare(Sequence(Text()), meaning="The two probes, one table each.")

    one_of = ((("keyphasor", "speed"), None), (("time", "rate"), OPTIONAL))


def read_channels(path: Path) -> Channels:
    """The table of a TOML file; SceneError, in one line, for anything that it cannot be."""
    file = one_line(path)
    content = tables_of(text_of(path, "a measurement", "docs/users/measured.md shows one"), file)
    for key in content:
        if key != "measured":
            raise SceneError(file, one_line(key), shown(content[key]), "the table [measured]", nearest(key, ("measured",)))
    table = RawTable(file, "measured", content.get("measured", {}), path.parent)
    if not isinstance(table.values, dict):
        raise SceneError(file, "measured", shown(table.values), "a table")
    raw = as_list(table.values.get("probe"))
    if raw is None or len(raw) != 2 or not all(isinstance(part, dict) for part in raw):
        table.refuse("probe", table.values.get("probe"), "two tables [[measured.probe]]")
    probes = [read_table(Probe, RawTable(file, f"measured.probe[{i}]", part)).made(Probe) for i, part in enumerate(raw)]
    channels = Channels(**{**read_table(Channels, _without_probes(table)), "probe": tuple(probes)})
    _refuse_contradictions(table, channels)
    return channels


def _without_probes(table: Any) -> RawTable:
    values = {**table.values, "probe": [part.get("column", "") for part in table.values["probe"]]}
    return RawTable(table.file, table.name, values, table.folder)


def _refuse_contradictions(table: Any, channels: Channels) -> None:
    first, second = channels.probe
    apart = abs((second.angle - first.angle + 90.0) % 180.0 - 90.0)  # of the lines they look along
    if apart < BETWEEN:
        table.refuse("probe[1].angle", second.angle, f"{BETWEEN:g} degree or more from the line of the first probe")
    for i, probe in enumerate(channels.probe):
        if probe.sensitivity == 0.0:
            table.refuse(f"probe[{i}].sensitivity", 0.0, "other than 0")
    if channels.slow_roll is None:
        return
    if len(channels.slow_roll) != 2 or not channels.slow_roll[0] < channels.slow_roll[1]:
        table.refuse("slow_roll", list(channels.slow_roll), "a lower and a higher speed")
    if channels.keyphasor is None:
        hint = "runout belongs to the angle of the shaft"
        table.refuse("slow_roll", list(channels.slow_roll), "left out without a Keyphasor", hint)


