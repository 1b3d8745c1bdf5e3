"""One run as sixty and more programs write it: texts, WAV, UFF-58, TDMS, LVM, MAT, HDF5 and NumPy, each with a table beside it.

The run: a backward whirl of 300 um at -67.9 Hz and 40 um at the rotor speed, 30 degrees ahead of the mark, while the shaft goes
from 40 to 45 Hz in 2 s; probes in directions 45 and 135 degrees.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

RATE, SECONDS, WHIRL = 4000.0, 2.0, -67.9
TIME = np.arange(int(RATE * SECONDS)) / RATE
DIALECTS = {}


def turns(t):
    return 40.0 * t + 1.25 * t**2


def probe(angle, t=TIME):
    """um of a probe that looks in a direction in degrees."""
    r = 300.0 * np.exp(2j * np.pi * WHIRL * t) + 40.0 * np.exp(2j * np.pi * turns(t) + 1j * np.pi / 6)
    return (r * np.exp(-1j * np.deg2rad(angle))).real


def pulses(t=TIME):
    """V of a Keyphasor in direction y, whose edges fall between samples."""
    phase, step = (turns(t) + 0.5) % 1.0 - 0.5, np.gradient(turns(t))
    return -10.0 * np.clip(np.minimum(phase, 0.05 - phase) / step + 0.5, 0.0, 1.0)


def signals():
    return {"X": probe(45), "Y": probe(135), "KPH": pulses()}


@dataclass(frozen=True)
class Table:
    """What the table says: names of the columns, lines of [measured], and of each probe."""

    names: tuple[str, str, str] = ("X", "Y", "KPH")
    more: str = ""
    unit: str = 'unit = "1 um"'
    shaft: str = "keyphasor"

    def text(self, file):
        probes = "".join(
            f'[[measured.probe]]\ncolumn = "{name}"\nangle = "{angle} deg"\n{self.unit}\n'
            for name, angle in zip(self.names[:2], (45, 135), strict=True)
        )
        return f'[measured]\nfile = "{file}"\n{self.shaft} = "{self.names[2]}"\n{self.more}\n{probes}'


@dataclass(frozen=True)
class Dialect:
    """A writer (path) -> None, the name of its file, its table, a word of the refusal (else it is read), a word of a warning."""

    write: Any
    file: str
    table: Table
    refused: str = ""
    told: str = ""


def dialect(name, file, table=None, refused="", told=""):
    """Registers a writer."""

    def register(write):
        DIALECTS[name] = Dialect(write, file, table or Table(), refused, told)
        return write

    return register


def written(folder, name):
    """The table of a dialect, written in a folder with its file; returns its path."""
    one = DIALECTS[name]
    one.write(Path(folder, one.file))
    path = Path(folder, "run.toml")
    path.write_text(one.table.text(one.file), encoding="utf-8")
    return path


def problem_of(run):
    """What is wrong with a run that was read, "" of the one above."""
    known = np.isfinite(run.deflection)
    t, r = run.time[known], run.deflection[known]
    line, whirl = (np.mean(r * np.exp(-2j * np.pi * turn)) for turn in (run.turns[known], WHIRL * t))
    seen = {
        "speed at the start": (run.speed[0], 40.0, 0.3), "speed at the end": (run.speed[-1], 45.0, 0.3),
        "duration": (run.time[-1], SECONDS, 0.1), "whirl": (1e6 * abs(whirl), 300.0, 9.0), "line": (1e6 * abs(line), 40.0, 4.0),
        "phase": (np.degrees(np.angle(line)), 30.0, 6.0),
    }  # fmt: skip
    return "; ".join(
        f"{name} {value:.4g} for {wanted:g}" for name, (value, wanted, limit) in seen.items() if not abs(value - wanted) < limit
    )


def by(**keys):
    """Lines of [measured]."""
    return "\n".join(
        f"{key} = {value if isinstance(value, int | float) else chr(34) + value + chr(34)}" for key, value in keys.items()
    )
