"""[start]: the state at time 0."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rsc.scene.keys import mirror
from rsc.scene.keys.forms import Form, declared_in, exclusive, form_of
from rsc.scene.keys.keys import RawTable, Values, declare, read_table
from rsc.scene.keys.readers import Choice, Flag, Later, PairReader, as_list, per_coordinate, plain, plain_section
from rsc.scene.keys.readers import Sequence as ListOf
from rsc.scene.tables.contacts import Contact
from rsc.scene.tables.drive import FREQUENCY

MAX_PENETRATION = 0.1  # relative to the gap
STATE_KEYS = ("rotor", "rotor_velocity", "stator", "stator_velocity", "rotor_states", "stator_states")
KINDS = ("rest", "centre", "running", "whirl")
_WITH_ALL = ("impulse", "allow_penetration")
_DISPLACEMENT = Later("a list with one pair [y, z] per coordinate", (ListOf(PairReader("length")),))
_VELOCITY = Later(_DISPLACEMENT.wanted, (ListOf(PairReader("velocity")),))
_STATES = Later("a list with one pair [y, z] per first-order state", (ListOf(PairReader("dimensionless")),))


@declared_in
@dataclass(frozen=True, kw_only=True)
class Start:
    """[start]: the state at time 0.

    rest (in equilibrium), centre (at the bearing centre, from where it drops), running (steady motion without contact) : True or
        None
    whirl : None, "backward" (the stable predicted whirl with the largest amplitude) or a frequency in Hz (the closest
        predicted whirl)
    rotor, rotor_velocity : tuples of n_rotor complex, m and m/s (tilts rad, rad/s); stator, stator_velocity likewise;
        rotor_states, stator_states : complex first-order states; zeros unless a state is given
    impulse : complex N s, on the rotor at its contact coordinate, in addition to any of these
    """

    rest: bool | None = declare(
        Flag(), None, meaning="true: at rest in equilibrium with the load, if need be on the stator; this is the default."
    )
    centre: bool | None = declare(
        Flag(), None, meaning="true: at rest and undeflected, with the rotor at the bearing centre, from where it drops."
    )
    running: bool | None = declare(
        Flag(), None, meaning="true: steady motion due to unbalance and load without contact, at the initial speed."
    )
    whirl: str | float | None = declare(
        Later("\"backward\" or a frequency in Hz", (Choice(("backward",)), FREQUENCY)),
        None,
        meaning="Start on a predicted whirl: the stable one of largest amplitude, or the one closest to a frequency.",
        mirror=mirror.negative,
    )
    rotor: tuple[complex, ...] = declare(
        _DISPLACEMENT, None, meaning="Displacements of the rotor at time 0, m (tilts: rad)."
    )
    rotor_velocity: tuple[complex, ...] = declare(
        _VELOCITY, None, meaning="Velocities of the rotor at time 0, m/s (tilts: rad/s)."
    )
    stator: tuple[complex, ...] = declare(_DISPLACEMENT, None, meaning="Displacements of the stator at time 0, m.")
    stator_velocity: tuple[complex, ...] = declare(_VELOCITY, None, meaning="Velocities of the stator at time 0, m/s.")
    rotor_states: tuple[complex, ...] = declare(
        _STATES, None, meaning="First-order states of the rotor at time 0; zeros if not given."
    )
    stator_states: tuple[complex, ...] = declare(
        _STATES, None, meaning="First-order states of the stator at time 0; zeros if not given."
    )
    impulse: complex = declare(
        PairReader("impulse"), None, meaning="Impulse on the rotor at time 0: at its contact coordinate, added to the start."
    )
    allow_penetration: bool = declare(
        Flag(), False, meaning="Allow a start with a penetration of more than a tenth of the gap, which is otherwise refused."
    )

    renamed = (("knock", "impulse"),)
    forms = (*(Form((kind,), _WITH_ALL) for kind in KINDS), Form((), STATE_KEYS + _WITH_ALL))
    one_of = exclusive(forms)

    @property
    def kind(self) -> str:
        """"rest", "centre", "running", "whirl" or "state"."""
        return next((key for key in KINDS if getattr(self, key) is not None), "state")

    def on_whirl(self, frequency: float) -> "Start":
        """The start on the predicted whirl closest to a frequency in Hz, with any penetration and without an impulse."""
        return replace(
            self, rest=None, centre=None, running=None, whirl=frequency, impulse=0j, allow_penetration=True
        )

    def with_states(self, numbers: Sequence[int]) -> "Start":
        """The start of a rotor with only some of its first-order states, given by their numbers."""
        return replace(self, rotor_states=tuple(self.rotor_states[i] for i in numbers))

    def to_dict(self) -> dict[str, Any]:
        """Plain content of the table."""
        content: dict[str, Any] = plain_section(self)
        for key in STATE_KEYS:
            if self.kind != "state" or not content[key]:
                del content[key]
        if not self.impulse:
            del content["impulse"]
        return content


def read_start(table: RawTable, elsewhere: Callable[[str], str], rotor: Any, stator: Any, contacts: Sequence[Contact]) -> Start:
    """Read [start]; by default a start at rest."""
    values = read_table(Start, table, elsewhere)
    form_of(Start.forms, table, values)
    for key in ("rest", "centre", "running"):
        if values[key] is False:
            table.refuse(key, False, "true or left out")
    if all(values[key] is None for key in KINDS + STATE_KEYS):
        values["rest"] = True
    if values["whirl"] is not None:
        values["whirl"] = _read_whirl(table, values["whirl"])
    for key in STATE_KEYS:
        values[key] = _read_state(table, key, values, rotor if key.startswith("rotor") else stator)
    values["impulse"] = values["impulse"] or 0j
    start: Start = values.made(Start)
    if start.impulse and len(contacts) > 1:
        table.refuse("impulse", plain(start.impulse), "left out with several contacts", "give start.rotor_velocity instead")
    for contact in contacts:
        _refuse_penetration(table, start, contact)
    return start


def _read_state(table: RawTable, key: str, values: Values, body: Any) -> tuple[complex, ...]:
    """Displacements or velocities of a body; zeros if not given."""
    if key.endswith("states"):
        return _read_first_order(table, key, values[key], body.n_states)
    if values[key] is None:
        return (0j,) * int(body.n_coordinates)
    units = ("angular velocity", "velocity") if key.endswith("velocity") else ("angle", "length")
    readers = [PairReader(units[0] if i in body.tilts else units[1]) for i in range(body.n_coordinates)]
    if not readers:
        table.refuse(key, values[key], "left out", "a rigid stator has no coordinates")
    read: tuple[complex, ...] = per_coordinate(table, key, values[key], readers)
    return read


def _read_first_order(table: RawTable, key: str, raw: Any, count: int) -> tuple[complex, ...]:
    """First-order states of a body; zeros if not given."""
    if raw is None:
        return (0j,) * count
    parts = as_list(raw)
    if not count or parts is None or len(parts) != count:
        table.refuse(key, raw, f"a list of {count}, one pair [y, z] per first-order state" if count else "left out")
    return tuple(PairReader("dimensionless").read(table, f"{key}[{i}]", part) for i, part in enumerate(parts))


def _read_whirl(table: RawTable, raw: Any) -> str | float:
    if isinstance(raw, str) and raw.strip()[:1].isalpha():
        if raw != "backward":
            table.refuse("whirl", raw, "\"backward\" or a frequency in Hz")
        return raw
    return FREQUENCY.read(table, "whirl", raw)


def _refuse_penetration(table: RawTable, start: Start, contact: Contact) -> None:
    """SceneError for a start deep inside the wall, nearly always a mistake; whirls and steady motions are computed later."""
    if start.kind in ("whirl", "running") or start.allow_penetration:
        return
    stator = start.stator[contact.stator_coordinate] if start.stator else 0j
    ring, offset = complex(contact.ring_eccentricity), contact.offset
    distance = abs(contact.of_rotor(np.array(start.rotor)) - stator + ring - offset)
    if distance > (1.0 + MAX_PENETRATION) * contact.gap:
        wall = f"the wall of {contact.name}" if contact.name else "the wall"
        wanted = f"at most {100 * MAX_PENETRATION:g} % of the gap inside {wall}"
        hint = f"distance {distance:.3g} m, gap {contact.gap:.3g} m; set allow_penetration = true if intended"
        table.refuse("rotor", [plain(item) for item in start.rotor], wanted, hint)
