"""[limits]: operating speeds of a machine, and where its vibration is measured."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rsc.scene.keys.keys import RawTable, declare, read_table
from rsc.scene.keys.readers import Name, Number, plain_section
from rsc.scene.tables.clearances import Clearance

KEY = "limits"
_SPEED = Number("frequency", above=0.0, high=1e6)


@dataclass(frozen=True, kw_only=True)
class Limits:
    """[limits]: criteria by which `rsc limits` judges the unbalance response."""

    maximum_continuous: float = declare(_SPEED, meaning="Maximum continuous speed.")
    minimum: float = declare(_SPEED, None, meaning="Lowest operating speed; by default the maximum continuous speed.")
    trip: float = declare(_SPEED, None, meaning="Trip speed; by default the maximum continuous speed.")
    probe: str | None = declare(
        Name(), None, meaning="The `[[clearance]]` at which a probe measures the rotor; default: the contact."
    )

    @property
    def speeds(self) -> tuple[float, float, float]:
        """Lowest operating, maximum continuous and trip speed, Hz."""
        highest = self.maximum_continuous
        return highest if self.minimum is None else self.minimum, highest, highest if self.trip is None else self.trip

    def to_dict(self) -> dict[str, Any]:
        """Plain content of the table."""
        content: dict[str, Any] = plain_section(self)
        return content


def read_limits(table: RawTable, elsewhere: Callable[[str], str], clearances: Sequence[Clearance]) -> Limits:
    """Read [limits] and check the order of the speeds and the name of the probe."""
    limits: Limits = read_table(Limits, table, elsewhere).made(Limits)
    lowest, highest, trip = limits.speeds
    if lowest > highest:
        table.refuse("minimum", lowest, f"<= maximum_continuous = {highest:g} Hz")
    if trip < highest:
        table.refuse("trip", trip, f">= maximum_continuous = {highest:g} Hz")
    names = [place.name for place in clearances]
    if limits.probe is not None and limits.probe not in names:
        wanted = "one of " + ", ".join(names) if names else "left out"
        table.refuse("probe", limits.probe, wanted, "" if names else "it must name a [[clearance]], and there is none")
    return limits
