"""[drive]: the rotor speed over time, prescribed or driven by a torque."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rsc.scene.keys import mirror
from rsc.scene.keys.forms import Form, declared_in, exclusive, form_of
from rsc.scene.keys.keys import RawTable, Values, declare, known_keys, read_table
from rsc.scene.keys.readers import Later, Listed, Number, as_list, plain_section
from rsc.scene.keys.readers import Sequence as ListOf
from rsc.scene.tables import torques

MAX_DURATION = 1e8  # s
FREQUENCY = Number("frequency", low=-1e6, high=1e6)
_TIME = Number("time", low=0.0, high=MAX_DURATION)

PRESCRIBED = Form(("speed", "duration"))
SCHEDULE = Form(("schedule",))
DRIVEN = Form(("speed", "duration", "inertia", "torque"))
TRIPPED = Form((*DRIVEN.needed, "trip"), ("coast",))


@declared_in
@dataclass(frozen=True, kw_only=True)
class Drive:
    """[drive]: rotor speed over time, linear between corners; with an inertia only the initial speed, which is then integrated.

    speed : tuple of float, Hz, at the corners, at least two; duration : float, s, time of the last corner
    schedule : None, or with more than two corners (time in s, speed in Hz) of each
    inertia : None or float, kg m^2; torque, coast : None or knots (speed in Hz, torque in N m), coast from time trip (s) on
    """

    speed: tuple[float, ...] = declare(
        Later("a speed in Hz, or [first, last]", (FREQUENCY, Listed((FREQUENCY, FREQUENCY)))),
        None,
        meaning="Rotor speed: constant, or [first, last] for a linear change.",
        mirror=mirror.negative,
    )
    duration: float = declare(Number("time", above=0.0, high=MAX_DURATION), None, meaning="Length of the run.")
    schedule: tuple[tuple[float, float], ...] | None = declare(
        Later("a list of [time in s, speed in Hz]", (ListOf(Listed((_TIME, FREQUENCY))),)),
        None,
        meaning="Corners of the rotor speed over time, from time 0, linear in between.",
        mirror=mirror.schedule,
    )
    inertia: float | None = declare(
        Number("inertia", above=0.0),
        None,
        meaning="Polar inertia of all rotating parts; makes the drive torque-limited, with the speed integrated.",
    )
    torque: tuple[tuple[float, float], ...] | None = declare(torques.TORQUE, None, meaning=torques.MEANING)
    trip: float | None = declare(_TIME, None, meaning="Time at which the motor trips; from then on the torque is `coast`.")
    coast: tuple[tuple[float, float], ...] | None = declare(
        torques.TORQUE, None, meaning="Torque after the trip, like `torque`; default: none."
    )

    forms = (PRESCRIBED, SCHEDULE, DRIVEN, TRIPPED)
    one_of = exclusive(forms)
    called = tuple((word, 'speed = ["0 rpm", "9000 rpm"]') for word in ("start", "end", "from", "to", "start_speed", "end_speed"))

    @classmethod
    def along(cls, time: Sequence[float], speed: Sequence[float]) -> "Drive":
        """A prescribed speed in Hz at corners in s, the first at 0."""
        schedule = tuple(zip(time, speed, strict=True)) if len(time) > 2 or time[0] else None
        declared: Any = cls
        values: dict[str, Any] = dict.fromkeys(known_keys(declared))
        return cls(**values | {"speed": tuple(speed), "duration": time[-1], "schedule": schedule})

    @property
    def time(self) -> tuple[float, ...]:
        """Times of the corners, s."""
        return (0.0, self.duration) if self.schedule is None else tuple(time for time, _ in self.schedule)

    @property
    def fastest(self) -> float:
        """Largest |speed| in Hz; for a torque-limited drive an estimate that the run hardly exceeds."""
        largest = max(abs(speed) for speed in self.speed)
        return largest if self.inertia is None else torques.fastest(self)

    @property
    def curves(self) -> tuple[torques.Knots, ...]:
        """Knots of torque over speed (Hz, N m) of a torque-limited drive: from the start, and after a trip; () if prescribed.

        What is computed of a torque takes it from here.
        """
        return tuple(knots for knots in (self.torque, self.coast) if knots is not None)

    @property
    def covered(self) -> tuple[float, float]:
        """Lowest and highest speed in Hz for which a reduced model must be valid, including standstill."""
        return min(0.0, *self.speed), max(0.0, *self.speed, 0.0 if self.inertia is None else self.fastest)

    def to_dict(self) -> dict[str, Any]:
        """Plain content of the table."""
        content: dict[str, Any] = plain_section(self)
        if self.schedule is not None:  # speed and duration follow from it
            del content["speed"], content["duration"]
        elif self.inertia is not None:
            content["speed"] = self.speed[0]
        return content


def read_drive(table: RawTable, elsewhere: Callable[[str], str]) -> Drive:
    """Read [drive] in one of its forms."""
    values = read_table(Drive, table, elsewhere)
    _READERS[form_of(Drive.forms, table, values)](table, values)
    drive: Drive = values.made(Drive)
    return drive


def _read_prescribed(table: RawTable, values: Values) -> None:
    """Read one speed, or the first and last one."""
    raw = values["speed"]
    parts = as_list(raw)
    if parts is None:
        values["speed"] = (FREQUENCY.read(table, "speed", raw),) * 2
        return
    if len(parts) != 2:
        table.refuse("speed", raw, "a speed in Hz, or [first, last]")
    values["speed"] = tuple(FREQUENCY.read(table, f"speed[{i}]", part) for i, part in enumerate(parts))


def _read_schedule(table: RawTable, values: Values) -> None:
    """Read the corners; two of them are stored as speed and duration."""
    corners = _corners(table, values["schedule"])
    values["schedule"] = corners if len(corners) > 2 else None
    values["speed"], values["duration"] = tuple(speed for _, speed in corners), corners[-1][0]


def _corners(table: RawTable, raw: Any) -> tuple[tuple[float, float], ...]:
    corners = as_list(raw)
    if corners is None or len(corners) < 2:
        table.refuse("schedule", raw, "a list of at least two [time in s, speed in Hz]")
    read: list[tuple[float, float]] = []
    for i, corner in enumerate(corners or ()):
        parts = as_list(corner)
        if parts is None or len(parts) != 2:
            table.refuse(f"schedule[{i}]", corner, "[time in s, speed in Hz]")
        time, speed = (reader.read(table, f"schedule[{i}][{k}]", parts[k]) for k, reader in enumerate((_TIME, FREQUENCY)))
        if i == 0 and time != 0.0:
            table.refuse("schedule[0][0]", time, "0 s", "the run starts at time 0")
        if i > 0 and not time > read[-1][0]:
            table.refuse(f"schedule[{i}][0]", time, f"later than {read[-1][0]:g} s", "times must increase")
        read.append((time, speed))
    return tuple(read)


def _read_driven(table: RawTable, values: Values) -> None:
    torques.read(table, values, FREQUENCY)


# function that reads the values for each form of a drive
_READERS = {PRESCRIBED: _read_prescribed, SCHEDULE: _read_schedule, DRIVEN: _read_driven, TRIPPED: _read_driven}
