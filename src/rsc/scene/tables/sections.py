"""The tables [solver] and [output] of a scene."""

from dataclasses import dataclass
from typing import Any

from rsc.scene.keys.keys import RawTable, declare, read_table
from rsc.scene.keys.readers import Choice, Flag, Integer, Number, plain_section

METHODS = ("rk45", "taylor8", "auto")
# methods in older results, whose scenes must remain readable, and their replacements
RETIRED_METHODS = {"verner76": "taylor8"}


@dataclass(frozen=True, kw_only=True)
class Solver:
    """[solver]: method, relative tolerance, step limit and amplitude in gaps that counts as divergence."""

    method: str = declare(Choice(METHODS), METHODS[0], meaning="Integration method; \"auto\" is \"taylor8\".")
    rtol: float = declare(
        Number("dimensionless", low=1e-13, high=1e-1), 1e-6, meaning="Tolerance of the error of a step, relative to the gap."
    )
    max_steps: int = declare(Integer(1, 2**62), 10**9, meaning="Largest number of steps of a run.")
    divergence: float = declare(
        Number("dimensionless", above=1.0), 1e6, meaning="Amplitude in gaps at which a run stops as diverged."
    )


@dataclass(frozen=True, kw_only=True)
class Output:
    """[output]: sampling rate of the stored run, and whether velocities are stored."""

    rate: float = declare(
        Number("frequency", above=0.0),
        None,
        meaning="Samples stored per second, at least four per turn; default: 2000, or four per turn if that is more.",
    )
    velocities: bool = declare(
        Flag(), False, meaning="Also store the velocities of rotor and stator, which makes a result up to twice as large."
    )

    def to_dict(self) -> dict[str, Any]:
        """Plain content of the table; velocities = false is omitted, so that older versions can read such scenes."""
        content = plain_section(self)
        return content if self.velocities else {"rate": content["rate"]}


def read_output(table: RawTable, elsewhere: Any, drive: Any) -> Output:
    """Read [output]; the default rate is 2000 Hz, or four samples per turn if that is more."""
    values = read_table(Output, table, elsewhere)
    least = 4.0 * drive.fastest
    if values["rate"] is None:
        values["rate"] = max(2000.0, least)
    if values["rate"] < least:
        table.refuse("rate", values["rate"], f">= {least:g} Hz", "four samples per turn at the highest speed")
    return values.made(Output)


def read_solver(table: RawTable, elsewhere: Any) -> Solver:
    """Read [solver]."""
    method = table.values.get("method")
    if isinstance(method, str) and method in RETIRED_METHODS:
        table.refuse("method", method, Choice(METHODS).wanted, f"it no longer exists; use \"{RETIRED_METHODS[method]}\"")
    return read_table(Solver, table, elsewhere).made(Solver)
