"""The tables [solver] and [output] of a scene."""

from dataclasses import dataclass

from rsc.scene.keys.keys import Choice, Flag, Integer, Number, declare, plain_section, read_table

METHODS = ("rk45", "taylor8", "auto")
# of older results, whose scenes must still be read, and what to use instead
RETIRED_METHODS = {"verner76": "taylor8"}


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


def read_output(table, elsewhere, drive):
    """Read [output]; the default rate is 2000 Hz, or four samples per turn where that is more."""
    values = read_table(Output, table, elsewhere)
    least = 4.0 * drive.fastest
    if values["rate"] is None:
        values["rate"] = max(2000.0, least)
    if values["rate"] < least:
        table.refuse("rate", values["rate"], f">= {least:g} Hz", "four samples per turn at the highest speed")
    return values.made(Output)


def read_solver(table, elsewhere):
    """Read [solver]."""
    method = table.values.get("method")
    if isinstance(method, str) and method in RETIRED_METHODS:
        table.refuse("method", method, Choice(METHODS).wanted, f"it is gone; use \"{RETIRED_METHODS[method]}\"")
    return read_table(Solver, table, elsewhere).made(Solver)
