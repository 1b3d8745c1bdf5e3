"""The other tables of a scene: [contact], [drive], [start], [solver], [output]."""

import math
from dataclasses import dataclass

import numpy as np

from rsc.scene import mirror, reduced, torques
from rsc.scene.bodies import RATIO
from rsc.scene.keys import (
    MAX_COORDINATES,
    NO_ECCENTRICITY,
    OPTIONAL,
    Choice,
    Flag,
    Integer,
    Later,
    Listed,
    Name,
    Number,
    PairReader,
    Polar,
    PolarReader,
    Sequence,
    as_list,
    declare,
    per_coordinate,
    plain,
    plain_section,
    read_table,
)
from rsc.units import SMALLEST

METHODS = ("rk45", "taylor8", "auto")
# of older results, whose scenes must still be read, and what to use instead
RETIRED_METHODS = {"verner76": "taylor8"}
MAX_DURATION = 1e8  # s
MIN_CONTACT_PERIOD = 1e-12  # s
MAX_PENETRATION = 0.1  # of the gap, at the start

FREQUENCY = Number("frequency", low=-1e6, high=1e6)
_COORDINATE = Integer(0, MAX_COORDINATES)
ROTOR_PLACE = Later("a whole number, or two that touch each other", (Listed((_COORDINATE, _COORDINATE)), _COORDINATE))


@dataclass(frozen=True, kw_only=True)
class Contact:
    """[contact], or of several each [[contact]]: one rotor and one stator coordinate that may touch (physics.md (6)-(11))."""

    name: str | None = declare(Name(), None, meaning="Name of the contact, needed where there are several, each with its own.")
    rotor_coordinate: int | tuple[int, int] = declare(
        ROTOR_PLACE,
        0,
        meaning="Number of the rotor's coordinate that touches, counted from 0; two of them touch each other, without a stator.",
    )
    stator_coordinate: int = declare(
        Integer(0, MAX_COORDINATES), 0, meaning="Number of the stator's coordinate that is touched, counted from 0."
    )
    rotor_node: object = declare(
        reduced.ROTOR_PLACE, None, meaning="Of a rotor of model \"machine\" with several contacts: the node that touches."
    )
    stator_node: object = declare(reduced.PLACE, None, meaning="Of a stator of model \"machine\": the node that is touched.")
    gap: float = declare(
        Number("length", above=0.0, hint="the contact direction is undefined at zero gap"),
        None,
        meaning="Radial gap of the centred rotor.",
    )
    stator_diameter: float | None = declare(
        Number("length", above=0.0), None, meaning="Inner diameter of the stator; with `diameter` it gives the gap."
    )
    friction: float = declare(Number("dimensionless", low=0.0, high=5.0), meaning="Coefficient of friction.")
    stiffness: float = declare(Number("stiffness", above=0.0), meaning="Stiffness of the contact.")
    damping_ratio: float | None = declare(
        RATIO, None, meaning="Damping of the contact as a share of the critical damping of the two masses that touch."
    )
    damping: float = declare(  # worked out when a ratio is given
        Number("damping", low=0.0), None, meaning="Damping of the contact, which acts only while the surfaces separate."
    )
    diameter: float | None = declare(
        Number("length", above=0.0),
        None,
        meaning="Diameter of the rotor at the contact, with which friction follows the slip (without: it slides forward).",
    )
    ring_eccentricity: Polar = declare(  # noqa: RUF009 (it is a field)
        PolarReader("length"), NO_ECCENTRICITY, meaning="Distance of the contact ring's centre from the shaft, and its angle."
    )
    offset: complex = declare(
        PairReader("length"), 0j, meaning="Where the stator's centre is at rest, beside the bearing centre; less than the gap."
    )
    slip_velocity: float | None = declare(
        Number("velocity", above=0.0),
        None,
        meaning="Slip from which friction is full, needs diameter; by default 1/1000 of the fastest surface speed.",
    )

    race_inertia: float | None = declare(
        Number("inertia", above=0.0), None, meaning="Polar inertia of the inner race that turns in the stator, needs diameter."
    )
    race_drag: float | None = declare(
        Number("tilt damping", low=0.0), None, meaning="Drag torque of that race over its speed, by default none."
    )

    one_of = (
        (("damping_ratio", "damping"), ("damping", 0.0)),
        (("gap", "stator_diameter"), None),
        (("rotor_coordinate", "rotor_node"), ("rotor_coordinate", 0)),
        (("stator_coordinate", "stator_node"), ("stator_coordinate", 0)),
    )

    @property
    def rotor_coordinates(self) -> tuple[int, ...]:
        """The rotor's coordinate that touches, or the two that touch each other."""
        return self.rotor_coordinate if isinstance(self.rotor_coordinate, tuple) else (self.rotor_coordinate,)

    @property
    def in_rotor(self) -> bool:
        """Whether two places of the rotor touch each other."""
        return isinstance(self.rotor_coordinate, tuple)

    def of_rotor(self, moved):
        """What touches of the rotor's coordinates (..., n): one of them, or the first less the second."""
        first, *against = self.rotor_coordinates
        return moved[..., first] - moved[..., against[0]] if against else moved[..., first]

    def to_dict(self):
        """Plain content of the table."""
        content = plain_section(self)
        if self.stator_diameter is not None:
            del content["gap"]  # it follows from the diameters
        if self.damping_ratio is not None:
            del content["damping"]  # it follows from the ratio
        if not self.offset:
            del content["offset"]  # so that versions without this key read such scenes
        return content


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


def read_contacts(tables, elsewhere, rotor, stator, drive):
    """Read every [[contact]]; of several each has a name of its own."""
    contacts = tuple(_read_contact(table, elsewhere, rotor, stator, drive) for table in tables)
    seen = {}
    for table, contact in zip(tables, contacts, strict=True):
        if contact.name is None and len(contacts) > 1:
            table.refuse("name", None, "given: of several contacts each has a name")
        if seen.setdefault(contact.name, table) is not table:
            table.refuse("name", contact.name, "another than that of " + seen[contact.name].name)
    if stator.n_coordinates and all(contact.in_rotor for contact in contacts):
        places = list(contacts[0].rotor_coordinates)
        tables[0].refuse("rotor_coordinate", places, "one coordinate", "no stator takes part: leave [stator] out")
    return contacts


def _read_contact(table, elsewhere, rotor, stator, drive):
    """Read one contact; damping from its ratio, coordinates and time scale checked against the bodies."""
    values = read_table(Contact, table, elsewhere)
    for name in ("rotor", "stator"):  # of a machine the node has become a coordinate
        if values[f"{name}_node"] is not None:
            hint = f"the {name} comes from no finite-element model: give {name}_coordinate"
            table.refuse(f"{name}_node", values[f"{name}_node"], "left out", hint)
    if values["stator_diameter"] is not None:
        values["gap"] = _gap_of_diameters(table, values)
    mass = _contact_mass(values, table, rotor, stator)
    stiffness = values["stiffness"]
    period = 2.0 * math.pi * math.sqrt(mass / stiffness)
    if period < MIN_CONTACT_PERIOD:
        wanted = f"so small that the contact period exceeds {MIN_CONTACT_PERIOD:g} s"
        table.refuse("stiffness", stiffness, wanted, f"the reduced mass is {mass:.3g} kg")
    ratio = values["damping_ratio"]
    if ratio is not None:
        if ratio < 0.0:
            table.refuse("damping_ratio", ratio, ">= 0")
        values["damping"] = 2.0 * ratio * math.sqrt(stiffness * mass)
    if values["diameter"] is None:
        if values["slip_velocity"] is not None:
            table.refuse("slip_velocity", values["slip_velocity"], "left out", "it needs contact.diameter")
    elif values["slip_velocity"] is None:
        fastest = 2.0 * math.pi * drive.fastest
        values["slip_velocity"] = 1e-3 * fastest * values["diameter"] / 2.0
        if values["slip_velocity"] < SMALLEST:
            table.refuse("slip_velocity", None, "given when the rotor stands still", "a velocity > 0 m/s")
    _read_race(table, values)
    if abs(values["offset"]) >= values["gap"]:
        wanted = f"shorter than the gap, {values['gap']:g} m"
        table.refuse("offset", plain(values["offset"]), wanted, "the rotor would rest in the wall")
    return Contact(**values)


def _read_race(table, values):
    """A race needs a diameter, its drag a race."""
    if values["race_inertia"] is not None:
        if values["diameter"] is None:
            table.refuse("race_inertia", values["race_inertia"], "left out", "without diameter nobody knows what turns it")
        values["race_drag"] = values["race_drag"] or 0.0
    elif values["race_drag"] is not None:
        table.refuse("race_drag", values["race_drag"], "left out", "it needs contact.race_inertia")


def _gap_of_diameters(table, values):
    """Radial gap of two diameters, the stator's larger by at least a millionth."""
    inner, outer = values["diameter"], values["stator_diameter"]
    if inner is None:
        table.refuse("stator_diameter", outer, "left out", "without diameter it gives no gap")
    gap = 0.5 * (outer - inner)
    if not gap > 5e-7 * outer:
        table.refuse("stator_diameter", outer, f"larger than diameter = {inner:g} m")
    return gap


def _contact_mass(values, table, rotor, stator):
    """Reduced mass in kg of the two contacting coordinates (their diagonal entries)."""
    masses, read = [], []
    places = as_list(values["rotor_coordinate"])
    several = places is not None
    if several and len(places) != 2:
        table.refuse("rotor_coordinate", values["rotor_coordinate"], ROTOR_PLACE.wanted)
    touching = [("rotor_coordinate", i, rotor) for i in (places if several else [values["rotor_coordinate"]])]
    touched = [] if several else [("stator_coordinate", values["stator_coordinate"], stator)]
    for key, i, body in (*touching, *touched):
        i = _COORDINATE.read(table, key, i)
        read.append(i)
        most = max(body.n_coordinates, 1) if body.model != "reduced" else body.n_touching
        if i >= most:
            table.refuse(key, i, f"a whole number from 0 to {most - 1}")
        if i in body.tilts:
            table.refuse(key, i, "a displacement", f"coordinate {i} is a tilt")
        if body.n_coordinates:
            masses.append(body.mass_at(i))
    if several:
        if rotor.model == "reduced":
            wanted = "left out"
            table.refuse("rotor_coordinate", places, wanted, "of a machine rotor.contact = {node = ..., against = ...}")
        if places[0] == places[1]:
            table.refuse("rotor_coordinate", places, "two coordinates")
        values["rotor_coordinate"] = tuple(read)
    else:
        values["rotor_coordinate"], values["stator_coordinate"] = read
    return 1.0 / sum(1.0 / mass for mass in masses)


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
