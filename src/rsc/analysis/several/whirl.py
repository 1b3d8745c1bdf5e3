"""What is told of a whirl at several contacts."""

from dataclasses import dataclass, field, replace
from typing import Any

from rsc.analysis.paper.predict import Whirl, Whirls
from rsc.files.tables import Table


@dataclass(frozen=True)
class AtContact:
    """One of several contacts in a whirl, without unbalance.

    normal_force : float N, 0 where it is not pressed
    deflection : float m, |d|; over_gap : float, the same over its gap
    phase : float deg, of its deflection, from -180 to 180 ahead of that of the first pressed contact
    """

    normal_force: float
    deflection: float
    over_gap: float
    phase: float

    @property
    def pressed(self) -> bool:
        """Whether it is one of the pressed set."""
        return self.normal_force > 0.0


@dataclass(frozen=True, eq=False, repr=False)
class SeveralWhirl(Whirl):
    """One steady whirl of a scene with several contacts at one rotor speed. What is of one contact in a `Whirl` is here:

    rotor_amplitude, stator_amplitude, normal_force, synchronous : at the contact that is pressed hardest; nothing as printed
    rotor_shape, stator_shape : with the first pressed contact at angle 0
    conditions : the least margins of all pressed contacts, and of what is not pressed
    touches : names of contacts that are not pressed and of clearances whose gap it reaches
    contacts : dict, name -> AtContact, all contacts of the scene
    """

    contacts: dict[str, AtContact] = field(default_factory=dict)

    @property
    def pressed(self) -> tuple[str, ...]:
        """Names of the pressed set."""
        return tuple(name for name, contact in self.contacts.items() if contact.pressed)

    def mirrored(self) -> "SeveralWhirl":
        """The whirl of the mirrored scene (`rsc.Scene.mirrored`)."""
        contacts = {name: replace(contact, phase=-contact.phase) for name, contact in self.contacts.items()}
        own = super().mirrored()
        assert isinstance(own, SeveralWhirl)
        return replace(own, contacts=contacts)


class SeveralWhirls(Whirls):
    """The whirls of a scene with several contacts at one rotor speed, each a `SeveralWhirl`."""

    def table(self) -> Table:
        """A `rsc.files.tables.Table` with a row for each whirl and three columns for each contact."""
        names = list(self[0].contacts) if self else []  # type: ignore[attr-defined]
        head = ["rotor speed in Hz", "frequency in Hz", "pressed", "growth rate in 1/s", "stable", "touches", "not valid"]
        each = [f"{name}: {what}" for name in names for what in ("normal force in N", "deflection in gaps", "phase in deg")]
        return Table((*head, *each), [_row(whirl) for whirl in self])  # type: ignore[arg-type]


def _row(whirl: SeveralWhirl) -> list[Any]:
    at = [value for own in whirl.contacts.values() for value in (own.normal_force, own.over_gap, own.phase)]
    words = (", ".join(own) for own in (whirl.touches, whirl.violated))
    return [whirl.speed, whirl.frequency, ", ".join(whirl.pressed), whirl.growth_rate, whirl.stable, *words, *at]
