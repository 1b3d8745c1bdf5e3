"""The rows of a sweep: its quantities, one array per quantity with a row per case, and how rows are joined."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rsc.files.gate import F8, I1, I8, TEXT, Array
from rsc.measure.words import VERDICTS

Rows = dict[str, NDArray]  # name -> (n_cases,) or (n_cases, n_whirls)

# statuses beside those of a run: a case whose scene cannot be right, one that raised an error, one whose worker died, one that
# was not computed
FINISHED, IMPOSSIBLE, FAILED, LOST, MISSING = "finished", "impossible", "failed", "lost", "missing"
WHIRL = "whirl"  # the dimension of whirls, by rising frequency
ROW = "case"


@dataclass(frozen=True)
class Column:
    """One quantity of a row: kind is "f" (float, NaN where absent), "i" (whole number, -1), "c" (number of a class, -1), "b"
    (flag, 0 or 1) or "S" (text)."""

    kind: str
    unit: str
    meaning: str
    per_whirl: bool = False

    @property
    def fill(self) -> float | int | bytes:
        """Value where there is none."""
        fills: dict[str, float | int | bytes] = {"f": np.nan, "i": -1, "c": -1, "b": 0, "S": b""}
        return fills[self.kind]

    @property
    def dtype(self) -> str:
        """Type of its array; of a text as long as needed."""
        return {"f": "f8", "i": "i8", "c": "i1", "b": "i1", "S": "S"}[self.kind]

    @property
    def passes(self) -> str:
        """Kind of its array at the gate."""
        return {"f": F8, "i": I8, "c": I1, "b": I1, "S": TEXT}[self.kind]


STATUS = {
    "status": Column("S", "", "how the case ended"),
    "reason": Column("S", "", "why it did not finish, or what limited its steps"),
    "scene_hash": Column("S", "", "SHA-256 of the resolved scene, as printed by `rsc verify`"),
}
_CONDITIONS = {
    "psi_real": "the whirl is not at its fold",
    "normal_force_positive": "the contact is pressed",
    "asynchronous_force_dominates": "the force of the whirl is larger than three times that of the unbalance",
    "rotor_amplitude_exceeds_gap": "the rotor's amplitude is larger than the gap",
    "sliding": "the contact slides forward",
    "contact_stiff_enough": "the contact is stiff compared with the force",
    "nearly_circular": "the whirl is nearly a circle",
    "within_clearances": "the whirl touches none of the places that are watched",
}
SETS = ("pressed", "whirl_pressed", "touched", "lasting_touched")  # columns that are sets of contacts, as `number_of_set` tells
_AS_SUM = "the sum of 2^i over their numbers i in the scene, counted from 0"
COLUMNS: dict[str, dict[str, Column]] = {
    "predict": {
        "frequency": Column("f", "Hz", "frequency of the predicted whirl, negative: backward", True),
        "pressed": Column("i", "1", f"contacts that it presses: {_AS_SUM}", True),
        "normal_force": Column("f", "N", "normal force of the predicted whirl, at the contact that is pressed hardest", True),
        "rotor_amplitude": Column("f", "m", "amplitude of the rotor at that contact", True),
        "stator_amplitude": Column("f", "m", "amplitude of the stator at that contact", True),
        "growth_rate": Column("f", "1/s", "largest growth rate of a small motion about the whirl", True),
        "growth_frequency": Column("f", "Hz", "frequency of that motion relative to the whirl", True),
        "stable": Column("b", "1", "whether every small motion decays, of a circle that touches no clearance", True),
        "clearance_share": Column("f", "1", "largest deflection over gap at the clearances that are watched", True),
        "clearance": Column("c", "1", "number of the clearance where that is, as in the scene, counted from 0", True),
        "admissible": Column("b", "1", "whether every side condition holds", True),
        **{f"holds_{name}": Column("b", "1", text, True) for name, text in _CONDITIONS.items()},
    },
    "mu_min": {
        "mu_min": Column("f", "1", "least friction with which a backward whirl can last, sliding or rolling"),
        "mu_min_frequency": Column("f", "Hz", "frequency of that whirl"),
    },
    "jump": {
        "jump_from": Column("f", "Hz", "frequency of the whirl that the run follows at its start"),
        "crossing_speed": Column("f", "Hz", "rotor speed at which that whirl loses its stability"),
        "first_seen_speed": Column("f", "Hz", "rotor speed at which the disturbance is a thousandth of the whirl"),
        "jump_speed": Column("f", "Hz", "rotor speed at which the run leaves the whirl"),
    },
    "run": {
        "motion": Column("S", "", "motion in the last part of the run, at the contact where it is most dangerous"),
        "touched": Column("i", "1", f"contacts that touch there: {_AS_SUM}"),
        "turning_frequency": Column("f", "Hz", "mean rate at which the contact deflection turns there, in a lasting sense"),
        "amplitude_min": Column("f", "m", "smallest |r| at the contact there"),
        "amplitude_max": Column("f", "m", "largest |r| at the contact there"),
        "stator_max": Column("f", "m", "largest |r| of the stator at the contact there"),
        "force_mean": Column("f", "N", "mean normal force there"),
        "force_max": Column("f", "N", "largest normal force there, at any contact"),
        "contact_share": Column("f", "1", "share of the time in contact there"),
        "torque": Column("f", "N m", "mean torque that friction takes from the drive there"),
        "power": Column("f", "W", "mean power that friction takes from the drive there"),
        "end_severity": Column("c", "", "severity of the motion in the last part of the run"),
        "largest_amplitude": Column("f", "m", "largest |r| at any contact in the whole run"),
        "largest_over_gap": Column("f", "1", "largest deflection over gap at any contact in the whole run"),
        "largest_force": Column("f", "N", "largest normal force of the whole run, at any contact"),
        "largest_contact": Column("c", "1", "number of the contact where that is, as in the scene, counted from 0; -1: none"),
        "run_clearance_share": Column("f", "1", "largest deflection over gap at clearances in the whole run"),
        "run_clearance": Column("c", "1", "number of the clearance that is passed first, or else of the one with that share"),
        "passed_time": Column("f", "s", "time at which a gap of theirs is first passed"),
        "end_time": Column("f", "s", "simulated time reached"),
        "contact_time": Column("f", "s", "time in contact of the whole run"),
        "steps": Column("i", "1", "accepted steps"),
        "energy_residual": Column("f", "1", "residual of the energy ledger over its turnover"),
    },
    "motions": {
        "lasting": Column("S", "", "most dangerous motion that lasts at the first speed"),
        "lasting_frequency": Column("f", "Hz", "mean rate at which its contact deflection turns"),
        "lasting_touched": Column("i", "1", f"contacts that it touches: {_AS_SUM}"),
        "lasting_amplitude": Column("f", "m", "its largest |r| at the contact"),
        "lasting_force": Column("f", "N", "its largest normal force, at any contact"),
        "lasting_power": Column("f", "W", "mean power that its friction takes from the drive"),
        "lasting_share": Column("f", "1", "share of the random impacts that start it"),
        "lasting_impulse": Column("f", "N s", "smallest of the random impacts that start it"),
        "lasting_clearance_share": Column("f", "1", "its largest deflection over gap at the clearances that are watched"),
        "lasting_whirl": Column("S", "", "most dangerous whirl that lasts there, or what runs away; empty: none does"),
        "lasting_whirl_frequency": Column("f", "Hz", "mean rate at which the contact deflection of that whirl turns"),
        "lasting_whirl_amplitude": Column("f", "m", "its largest |r| at the contact"),
        "lasting_whirl_force": Column("f", "N", "its largest normal force, at any contact"),
        "lasting_whirl_share": Column("f", "1", "share of the random impacts that start a whirl, whichever it is"),
        "lasting_whirl_impulse": Column("f", "N s", "smallest of the random impacts that start a whirl"),
        "lasting_severity": Column("c", "", "severity of the motions that last at this speed, as in `rsc motions`"),
        "n_motions": Column("i", "1", "motions that last"),
        "n_unsettled": Column("i", "1", "random impacts after which nothing had settled"),
    },
    "check": {
        "verdict": Column("S", "", "verdict of the comparison of simulation and prediction"),
        "windows": Column("i", "1", "comparisons made"),
        **{f"n_{word.replace(' ', '_')}": Column("i", "1", f"comparisons with the verdict: {word}") for word in VERDICTS},
        "largest_frequency_error": Column("f", "1", "largest relative difference of whirl frequencies that were compared"),
        "transition_speed": Column("f", "Hz", "rotor speed of the first change of whirl"),
        "transition_predicted": Column("f", "Hz", "rotor speed at which that change is predicted"),
    },
}
# format of a dataset that is still read -> columns that it does not have yet
_OF_3 = ["end_severity", "lasting_severity", "severity"]
ADDED = {
    "rsc-sweep-dataset-2": [*(name for name in COLUMNS["motions"] if name.startswith("lasting_whirl")), *_OF_3],
    "rsc-sweep-dataset-3": _OF_3,
}


def all_columns(kind: str) -> dict[str, Column]:
    """The columns of the computed quantities, status first."""
    return STATUS | COLUMNS[kind]


def table(kind: str, count: int | None = None) -> dict[str, Array]:
    """What the gate lets pass of the rows of some cases, or of any number."""
    rows = ROW if count is None else count
    return {name: Array(c.passes, (rows, WHIRL) if c.per_whirl else (rows,)) for name, c in all_columns(kind).items()}


def empty(kind: str, count: int, n_whirls: int = 0) -> Rows:
    """Rows in which there is nothing yet."""
    return {
        name: np.full((count, n_whirls) if column.per_whirl else count, column.fill, dtype=column.dtype)
        for name, column in all_columns(kind).items()
    }


def joined(kind: str, count: int, pieces: Sequence[tuple[Sequence[int], Mapping[str, NDArray]]]) -> Rows:
    """Rows of `count` cases from pieces, (numbers of the cases, their rows); only as many whirls and letters as there are."""
    rows: Rows = {}
    n_whirls = 0
    if "frequency" in COLUMNS[kind]:
        used = [np.isfinite(piece["frequency"]).any(axis=0) for _, piece in pieces]
        n_whirls = max((int(np.flatnonzero(column).max(initial=-1)) + 1 for column in used), default=0)
    for name, column in all_columns(kind).items():
        arrays = [piece[name] for _, piece in pieces]
        dtype = np.result_type(*arrays, "S1") if column.kind == "S" and arrays else column.dtype
        whole = np.full((count, n_whirls) if column.per_whirl else count, column.fill, dtype=dtype)
        for (places, _), array in zip(pieces, arrays, strict=True):
            if column.per_whirl:
                array = array[:, :n_whirls]
                whole[np.asarray(places, dtype=int), : array.shape[1]] = array
            else:
                whole[np.asarray(places, dtype=int)] = array
        if column.kind == "S":
            whole = whole.astype(f"S{max(int(np.strings.str_len(whole).max(initial=0)), 1)}")
        rows[name] = whole
    return rows


def number_of_set(names: Collection[str], every: Sequence[str]) -> int:
    """The number of a set of contacts among all names of a scene, in its order: 2^i for each, added."""
    return sum(1 << i for i, name in enumerate(every) if name in names)


def texts(values: Sequence[str]) -> NDArray:
    """Texts as an array of their bytes in UTF-8."""
    return np.array([value.encode() for value in values], dtype=bytes) if len(values) else np.zeros(0, dtype="S1")
