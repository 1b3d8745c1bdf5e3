"""The other tables of a scene: [drive], [start], [solver], [output]."""

from dataclasses import dataclass

import numpy as np

from rsc.scene.keys import mirror
from rsc.scene.keys.keys import (
    OPTIONAL,
    Choice,
    Flag,
    Integer,
    Later,
    Listed,
    Number,
    PairReader,
    Sequence,
    as_list,
    declare,
    per_coordinate,
    plain,
    plain_section,
    read_table,
)
from rsc.scene.tables import torques

METHODS = ("rk45", "taylor8", "auto")
# of older results, whose scenes must still be read, and what to use instead
RETIRED_METHODS = {"verner76": "taylor8"}
MAX_DURATION = 1e8  # s
MAX_PENETRATION = 0.1  # of the gap, at the start

FREQUENCY = Number("frequency", low=-1e6, high=1e6)


_DRIVE_GROUPS = ((("speed", "schedule"), None), (("duration", "schedule"), None))


@dataclass(frozen=True, kw_only=True)
class Drive:
    """[drive]: rotor speed over time, linear between corners.

    time : tuple of float, s, from 0, strictly increasing; speed : tuple of float, Hz.
    With an inertia the speed is that at the start, twice, and what follows is integrated:
    inertia : float, kg m^2; torque, coast : knots (speed in Hz, torque in N m), coast from the time trip, s, on.
    """

    time: tuple[float, ...]
    speed: tuple[float, ...]
    inertia: float | None = None
    torque: torques.Knots = ()
    trip: float | None = None
    coast: torques.Knots = ()

    one_of = _DRIVE_GROUPS

    @property
    def fastest(self) -> float:
        """The largest magnitude of the speed in Hz, with an inertia one that the run hardly passes."""
        largest = max(abs(speed) for speed in self.speed)
        return largest if self.inertia is None else torques.fastest(self)

    @property
    def covered(self) -> tuple[float, float]:
        """Lowest and highest speed in Hz that a reduced model has to hold for, standstill among them."""
        return min(0.0, *self.speed), max(0.0, *self.speed, 0.0 if self.inertia is None else self.fastest)

    @property
    def duration(self) -> float:
        """Length of the run in s."""
        return self.time[-1]

    def to_dict(self):
        """Plain content of the table."""
        if self.inertia is not None:
            return torques.content(self)
        if len(self.time) > 2:
            return {"schedule": [list(corner) for corner in zip(self.time, self.speed, strict=True)]}
        return {"speed": list(self.speed), "duration": self.duration}


@dataclass(frozen=True, kw_only=True)
class DriveKeys:
    speed: object = declare(
        Later("a speed in Hz, or [first, last]", (FREQUENCY, Listed((FREQUENCY, FREQUENCY)))),
        None,
        meaning="Rotor speed: constant, or changing linearly from the first to the last.",
        mirror=mirror.negative,
    )
    duration: float | None = declare(Number("time", above=0.0, high=MAX_DURATION), None, meaning="Length of the run.")
    schedule: object = declare(
        Later("a list of [time in s, speed in Hz]", (Sequence(Listed((Number("time", low=0.0, high=MAX_DURATION), FREQUENCY))),)),
        None,
        meaning="Corners of the rotor speed over time, from time 0, linear in between.",
        mirror=mirror.schedule,
    )
    inertia: float | None = declare(
        Number("inertia", above=0.0), None, meaning="Polar inertia of all that turns; with it the speed gives way."
    )
    torque: object = declare(torques.TORQUE, None, meaning=torques.MEANING)
    trip: float | None = declare(
        Number("time", low=0.0, high=MAX_DURATION), None, meaning="When the motor trips: from then on the torque is `coast`."
    )
    coast: object = declare(torques.TORQUE, None, meaning="Torque behind the trip, as `torque`; by default none.")

    one_of = _DRIVE_GROUPS


STATE_KEYS = ("rotor", "rotor_velocity", "stator", "stator_velocity")
_DISPLACEMENT = Later("a list with one pair [y, z] per coordinate", (Sequence(PairReader("length")),))
_VELOCITY = Later(_DISPLACEMENT.wanted, (Sequence(PairReader("velocity")),))
_KINDS = ("rest", "centre", "running", "whirl")
_START_GROUPS = (
    (_KINDS, OPTIONAL),
    *(((kind, key), OPTIONAL) for kind in _KINDS for key in STATE_KEYS),
)


@dataclass(frozen=True, kw_only=True)
class Start:
    """[start]: the state at time 0.

    kind : "rest" (in equilibrium), "centre" (at the bearing centre, to fall), "running" (the steady motion without contact),
        "whirl" or "state".
    whirl : None, "backward" (the stable predicted whirl with the largest amplitude) or a frequency in Hz (the
        predicted whirl next to it).
    rotor, rotor_velocity : tuples of n_rotor complex, m and m/s (tilts rad, rad/s); stator, stator_velocity
        alike; zeros unless kind is "state".
    knock : complex N s, impulse on the rotor at its contact coordinate, on top of any of these.
    """

    kind: str
    whirl: str | float | None
    rotor: tuple
    rotor_velocity: tuple
    stator: tuple
    stator_velocity: tuple
    knock: complex
    allow_penetration: bool

    one_of = _START_GROUPS

    def to_dict(self):
        """Plain content of the table."""
        if self.kind == "whirl":
            content = {"whirl": self.whirl}
        elif self.kind == "state":
            content = {name: plain(getattr(self, name)) for name in STATE_KEYS if getattr(self, name)}
        else:
            content = {self.kind: True}
        if self.knock:
            content["knock"] = plain(self.knock)
        return {**content, "allow_penetration": self.allow_penetration}


@dataclass(frozen=True, kw_only=True)
class StartKeys:
    rest: bool | None = declare(
        Flag(), None, meaning="true: everything rests in equilibrium with the load, if need be on the stator; also the default."
    )
    centre: bool | None = declare(
        Flag(), None, meaning="true: everything rests undeflected, the rotor at the bearing centre, from where it falls."
    )
    running: bool | None = declare(
        Flag(), None, meaning="true: the steady motion by unbalance and load without contact, at the first speed."
    )
    whirl: object = declare(
        Later("\"backward\" or a frequency in Hz", (Choice(("backward",)), FREQUENCY)),
        None,
        meaning="Start on a predicted whirl: the stable one of largest amplitude, or the one next to a frequency.",
        mirror=mirror.negative,
    )
    rotor: object = declare(_DISPLACEMENT, None, meaning="Displacements of the rotor at time 0, m (rad on a tilt).")
    rotor_velocity: object = declare(_VELOCITY, None, meaning="Velocities of the rotor at time 0, m/s (rad/s on a tilt).")
    stator: object = declare(_DISPLACEMENT, None, meaning="Displacements of the stator at time 0, m.")
    stator_velocity: object = declare(_VELOCITY, None, meaning="Velocities of the stator at time 0, m/s.")
    knock: object = declare(
        PairReader("impulse"), None, meaning="Knock on the rotor at time 0: impulse at its contact coordinate, besides the start."
    )
    allow_penetration: bool = declare(
        Flag(), False, meaning="Allows a start deeper in the wall than a tenth of the gap, which is refused otherwise."
    )

    one_of = _START_GROUPS


@dataclass(frozen=True, kw_only=True)
class Solver:
    """[solver]: method, relative tolerance, step limit and the amplitude in gaps that counts as diverged."""

    method: str = declare(Choice(METHODS), METHODS[0], meaning="How steps are taken; \"auto\" is \"taylor8\".")
    rtol: float = declare(
        Number("dimensionless", low=1e-13, high=1e-1), 1e-6, meaning="Tolerated error of a step, as a share of the gap."
    )
    max_steps: int = declare(Integer(1, 2**62), 10**9, meaning="Number of steps after which a run stops.")
    divergence: float = declare(
        Number("dimensionless", above=1.0), 1e6, meaning="Amplitude, in gaps, at which a run counts as diverged and stops."
    )


@dataclass(frozen=True, kw_only=True)
class Output:
    """[output]: samples per second of the stored run, and whether they have velocities."""

    rate: float = declare(
        Number("frequency", above=0.0),
        None,
        meaning="Samples stored per second, at least four per turn; by default 2000, or four per turn where that is more.",
    )
    velocities: bool = declare(
        Flag(), False, meaning="Stores the velocities of rotor and stator as well, which makes a result up to twice as large."
    )

    def to_dict(self):
        """Plain content of the table; false is left out, so that versions without this key read such scenes."""
        content = plain_section(self)
        return content if self.velocities else {"rate": content["rate"]}


def read_drive(table, elsewhere):
    """Read [drive]: a speed (one or two numbers) and a duration, or a schedule."""
    values = read_table(DriveKeys, table, elsewhere)
    if any(values[key] is not None for key in torques.KEYS):
        return Drive(**torques.read(table, values, FREQUENCY))
    if values["schedule"] is not None:
        return _read_schedule(table, values["schedule"])
    parts = as_list(values["speed"])
    if parts is None:
        speed = (FREQUENCY.read(table, "speed", values["speed"]),) * 2
    elif len(parts) == 2:
        speed = tuple(FREQUENCY.read(table, f"speed[{i}]", part) for i, part in enumerate(parts))
    else:
        table.refuse("speed", values["speed"], "a speed in Hz, or [first, last]")
    return Drive(time=(0.0, values["duration"]), speed=speed)


def _read_schedule(table, raw):
    corners = as_list(raw)
    if corners is None or len(corners) < 2:
        table.refuse("schedule", raw, "a list of at least two [time in s, speed in Hz]")
    times, speeds = [], []
    for i, corner in enumerate(corners):
        corner = as_list(corner)
        if corner is None or len(corner) != 2:
            table.refuse(f"schedule[{i}]", corners[i], "[time in s, speed in Hz]")
        times.append(Number("time", low=0.0, high=MAX_DURATION).read(table, f"schedule[{i}][0]", corner[0]))
        speeds.append(FREQUENCY.read(table, f"schedule[{i}][1]", corner[1]))
        if i == 0 and times[0] != 0.0:
            table.refuse("schedule[0][0]", times[0], "0 s", "the run starts at time 0")
        if i > 0 and not times[i] > times[i - 1]:
            wanted = f"later than {times[i - 1]:g} s"
            table.refuse(f"schedule[{i}][0]", times[i], wanted, "times must increase")
    return Drive(time=tuple(times), speed=tuple(speeds))


def read_start(table, elsewhere, rotor, stator, contacts):
    """Read [start]; an absent table is a start at rest."""
    values = read_table(StartKeys, table, elsewhere)
    for key in ("rest", "centre", "running"):
        if values[key] is False:
            table.refuse(key, False, "true or left out")
    if values["whirl"] is not None:
        values["whirl"] = _read_whirl(table, values["whirl"])
    has_state = any(values[key] is not None for key in STATE_KEYS)
    kind = next((key for key in _KINDS if values[key] is not None), "state" if has_state else "rest")
    for key in STATE_KEYS:
        body = rotor if key.startswith("rotor") else stator
        moving = key.endswith("velocity")
        units = ("angular velocity", "velocity") if moving else ("angle", "length")
        readers = [PairReader(units[0] if i in body.tilts else units[1]) for i in range(body.n_coordinates)]
        if values[key] is None:
            values[key] = (0j,) * body.n_coordinates
        elif not readers:
            table.refuse(key, values[key], "left out", "a rigid stator has no coordinates")
        else:
            values[key] = per_coordinate(table, key, values[key], readers)
    del values["rest"], values["centre"], values["running"]
    values["knock"] = values["knock"] or 0j
    start = Start(kind=kind, **values)
    if start.knock and len(contacts) > 1:
        table.refuse("knock", plain(start.knock), "left out with several contacts", "give start.rotor_velocity instead")
    for contact in contacts:
        _refuse_penetration(table, start, contact)
    return start


def _read_whirl(table, raw):
    if isinstance(raw, str) and raw.strip()[:1].isalpha():
        if raw != "backward":
            table.refuse("whirl", raw, "\"backward\" or a frequency in Hz")
        return raw
    return FREQUENCY.read(table, "whirl", raw)


def _refuse_penetration(table, start, contact):
    """A start deep in the wall is nearly always a mistake; a whirl or a running machine is predicted later."""
    if start.kind in ("whirl", "running") or start.allow_penetration:
        return
    stator = start.stator[contact.stator_coordinate] if start.stator else 0j
    ring, offset = complex(contact.ring_eccentricity), contact.offset
    distance = abs(contact.of_rotor(np.array(start.rotor)) - stator + ring - offset)
    if distance > (1.0 + MAX_PENETRATION) * contact.gap:
        wall = f"the wall of {contact.name}" if contact.name else "the wall"
        wanted = f"at most {100 * MAX_PENETRATION:g} % of the gap inside {wall}"
        hint = f"distance {distance:.3g} m, gap {contact.gap:.3g} m; allow_penetration = true if it is meant"
        table.refuse("rotor", [plain(item) for item in start.rotor], wanted, hint)


def read_output(table, elsewhere, drive):
    """Read [output]; the default rate is 2000 Hz, or four samples per turn where that is more."""
    values = read_table(Output, table, elsewhere)
    least = 4.0 * drive.fastest
    if values["rate"] is None:
        values["rate"] = max(2000.0, least)
    if values["rate"] < least:
        table.refuse("rate", values["rate"], f">= {least:g} Hz", "four samples per turn at the highest speed")
    return Output(**values)


def read_solver(table, elsewhere):
    """Read [solver]."""
    method = table.values.get("method")
    if isinstance(method, str) and method in RETIRED_METHODS:
        table.refuse("method", method, Choice(METHODS).wanted, f"it is gone; use \"{RETIRED_METHODS[method]}\"")
    return Solver(**read_table(Solver, table, elsewhere))
