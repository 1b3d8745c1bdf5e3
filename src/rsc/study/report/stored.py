"""The analysis of a run, stored in report.json next to its result, so that plots and pages need no new analysis."""

import json
import os
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.limits import acceptance_of
from rsc.files.mark import JSON
from rsc.files.output import OutputFile, put_all
from rsc.measure.catalogue import AssumedRoll, LastingMotion, Motions, Predicted, SmallestImpact
from rsc.measure.changes import Transition
from rsc.measure.course import windows_of
from rsc.measure.final import MotionAtContact
from rsc.measure.kinds import Kind
from rsc.measure.reasons import Code, Reason
from rsc.measure.resonances import Resonance
from rsc.measure.verdict import Row, Window
from rsc.measure.windows import Best
from rsc.measure.words import TOLERANCES, VERDICTS
from rsc.results.trajectory import Trajectory
from rsc.show.words.plain import report_plain
from rsc.show.words.reasons import note, note_of_change
from rsc.study.report.report import Report, course_of, measured, sag_of
from rsc.system.assemble import assemble
from rsc.system.border import Border
from rsc.system.held import OUTCOMES, Held

FORMAT = "rsc-report-7"
NAME = "report.json"
LARGEST = 64 * 2**20  # bytes
AT_CONTACTS = ("normal_force", "over_gap", "phase")
COLUMNS = ("speed", "frequency", "amplitude", "normal_force", "growth_rate")


@dataclass(frozen=True)
class StoredEvent:
    """The end of a branch or a place on it, as `rsc.analysis.follow.events.Event`."""

    cause: str
    value: float
    frequency: float
    holds: str


@dataclass(frozen=True)
class StoredWhirl:
    """What tables say of a whirl at one speed: frequency Hz, rotor_amplitude m, normal_force N; names of what it touches."""

    frequency: float
    rotor_amplitude: float
    normal_force: float
    stable: bool
    touches: tuple[str, ...]


@dataclass(frozen=True)
class StoredBranch:
    """A `rsc.analysis.follow.branch.Branch` without its whirls; arrays (n,)."""

    label: str
    speed: NDArray[np.float64]
    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    normal_force: NDArray[np.float64]
    growth_rate: NDArray[np.float64]
    stable: NDArray[np.bool_]
    touches: tuple[tuple[str, ...], ...]
    pressed: tuple[str, ...]
    at_contacts: dict[str, dict[str, NDArray[np.float64]]]
    extremes: NDArray[np.float64]
    begin: StoredEvent
    end: StoredEvent
    events: tuple[StoredEvent, ...]

    def envelope(self, i: int) -> NDArray[np.float64]:
        """(n,) m: smallest (i = 0) or largest (i = 1) |r| with the unbalance."""
        return self.extremes[i]

    def at(self, value: float) -> StoredWhirl | None:
        """The whirl at the speed next to `value`, or None outside the branch."""
        step = np.ptp(self.speed) / max(len(self.speed) - 1, 1)
        if not self.speed.min() - step <= value <= self.speed.max() + step:
            return None
        i = int(np.argmin(np.abs(self.speed - value)))
        frequency, amplitude, force = (float(values[i]) for values in (self.frequency, self.amplitude, self.normal_force))
        return StoredWhirl(frequency, amplitude, force, bool(self.stable[i]), self.touches[i])


def write_stored(report: Report, path: str | os.PathLike[str]) -> None:
    """Write report.json; DataError when it cannot be written."""
    put_all([stored(report, path)])


def stored(report: Report, path: str | os.PathLike[str]) -> OutputFile:
    """The file report.json of a report, to be written by `rsc.files.output.put_all`."""
    content = {"made_by": _made_by(), "result": report.result.digest} | report_plain(report)
    return OutputFile(Path(path), json.dumps(content).encode(), JSON)


def report_of(result: Trajectory, path: str | os.PathLike[str]) -> Report:
    """The Report of the result in the file `path`: its analysis from the report.json beside it, or made anew where there is none
    of this result and this version, or where it is damaged."""
    try:
        stored = _read(Path(path).with_name(NAME), result.digest)
        if stored is not None:
            return _report(result, stored)
    except Exception:  # whatever it is, it is no report of this version; a result that cannot be read raises again below
        pass
    from rsc.study.report.check import report

    return report(result)


def _made_by() -> str:
    try:
        return f"{FORMAT} of rsc {version('rotor-stator-contact')}"
    except PackageNotFoundError:
        return FORMAT


def _read(path: Path, digest: str) -> dict[str, Any] | None:
    """The content of a report.json if it is of the result with this digest and of this version."""
    if not path.is_file() or path.stat().st_size > LARGEST:
        return None
    content = json.loads(path.read_text(encoding="utf-8"))
    return content if content["made_by"] == _made_by() and content["result"] == digest != "" else None


def _report(result: Trajectory, stored: dict[str, Any]) -> Report:
    """The Report with a stored analysis; the samples are measured again."""
    system = assemble(result.scene)
    seen = course_of(result, windows_of(result, _number(stored["window"])), system)
    windows = _windows([_record(Row, row, reasons=_reasons(row)) for row in stored["rows"]], len(seen.fall.speed))
    alone, rub = _array(stored["alone"]), (_array(stored["rub"][0]), _array(stored["rub"][1]))
    best = Best(**{field.name: _array(stored["best"][field.name]) for field in fields(Best)})
    _alike((len(windows),), alone, *rub, *vars(best).values())
    natural = {name: (_array(speed), _array(frequency)) for name, (speed, frequency) in stored["natural"].items()}
    if set(natural) != {"coupled", "uncoupled"}:
        raise ValueError("natural frequencies that no analysis has")
    for speed, frequency in natural.values():
        _alike((*speed.shape, frequency.shape[1]), frequency)
    return Report(
        result=result,
        **measured(seen),
        alone=alone,
        best=best,
        branches=cast(Any, [_branch(branch) for branch in stored["branches"]]),
        natural=natural,
        windows=windows,
        transitions=[_changed(change) for change in stored["transitions"]],
        rub=rub,
        resonances=[_record(Resonance, peak) for peak in stored["resonances"]],
        resonance=_number(stored["resonance"]),
        limits=acceptance_of(result.scene),
        sag=sag_of(system, seen.lead),
        motions=[_listed(listed) for listed in stored["motions"]],
        warnings=[_text(text) for text in stored["warnings"]],
        remarks=[_text(text) for text in stored["remarks"]],
        agreement=_text(stored["agreement"]),
        border=stored["border"] and _record(Border, stored["border"]),
    )


def _windows(rows: list[Row], n_windows: int) -> list[Window]:
    """The windows of a list of rows, three a window in the order of `TOLERANCES`."""
    if [row.quantity for row in rows] != [*TOLERANCES] * n_windows:
        raise ValueError("rows of other windows")
    if not {row.verdict for row in rows} <= set(VERDICTS):
        raise ValueError("a verdict that is none")
    for row in rows:
        note(row)  # raises where a reason has not what its words need
    return [Window(*own) for own in zip(*[iter(rows)] * 3, strict=True)]


def _changed(stored: dict[str, Any]) -> Transition:
    change: Transition = _record(Transition, stored, reasons=_reasons(stored))
    note_of_change(change)  # raises where its reason has not what its words need
    return change


def _reasons(stored: dict[str, Any]) -> tuple[Reason, ...]:
    """The reasons of a row or of a change."""

    def reason(code: str, names: list[str], numbers: list[float | None]) -> Reason:
        return Reason(Code(code), tuple(map(_text, names)), tuple(map(_number, numbers)))

    return tuple(reason(**each) for each in stored["reasons"])


def _alike(shape: tuple[int, ...], *arrays: NDArray[Any]) -> None:
    """ValueError for an array of another shape."""
    if any(values.shape != shape for values in arrays):
        raise ValueError("arrays of other shapes")


def _branch(stored: dict[str, Any]) -> StoredBranch:
    begin, *events, end = (_record(StoredEvent, event) for event in stored["events"])
    names = {"amplitude": "rotor_amplitude"}
    columns: dict[str, Any] = {name: _array(stored[names.get(name, name)]) for name in COLUMNS}
    stable, extremes = np.array(stored["stable"], dtype=bool), _array(stored["envelope"])
    _alike((stable.size,), stable, *columns.values(), *extremes)
    touches = tuple(tuple(map(_text, names)) for names in stored["touches"])
    if len(touches) != stable.size:
        raise ValueError("arrays of other shapes")
    places: dict[str, Any] = {"begin": begin, "end": end, "events": tuple(events)}
    contacts = stored["at_contacts"].items()
    at_contacts = {_text(contact): {name: _array(own[name]) for name in AT_CONTACTS} for contact, own in contacts}
    _alike((stable.size,), *(values for own in at_contacts.values() for values in own.values()))
    pressed = tuple(map(_text, stored["pressed"]))
    if not set(pressed) <= set(at_contacts):
        raise ValueError("contacts that are pressed and nowhere")
    named: dict[str, Any] = {"label": _text(stored["label"]), "pressed": pressed, "at_contacts": at_contacts}
    return StoredBranch(**named, **columns, stable=stable, touches=touches, extremes=extremes, **places)


def _record(kind: Any, stored: dict[str, Any], **more: Any) -> Any:
    """A dataclass of texts, flags and numbers, except for fields in `more`; None encodes NaN or infinity. What an older version
    did not store is at its default."""
    readers: dict[Any, Callable[[Any], Any]] = {"str": _text, str: _text, "bool": _flag, bool: _flag, "int": _count, int: _count}
    wanted = (field for field in fields(kind) if field.name in stored or field.default is MISSING)
    values = {field.name: field for field in wanted if field.name not in more}
    return kind(**{name: readers.get(field.type, _number)(stored[name]) for name, field in values.items()}, **more)


def _text(value: Any) -> str:
    """A line of text in which neither a terminal finds commands nor a picture mathematics."""
    if not isinstance(value, str) or not value.isprintable() or "$" in value:
        raise ValueError("a text that no analysis writes")
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError("a flag that is none")
    return value


def _count(value: Any) -> int:
    if not isinstance(value, int) or abs(value) >= 2**63:
        raise ValueError("a count that is none")
    return value


def _listed(stored: dict[str, Any]) -> Motions:
    """A list of motions that last."""
    pairs = [(motion, motion["predicted"]) for motion in stored["motions"]]
    impulse, ended = _array(stored["impulse"]).reshape(-1, 2), np.array(stored["ended"], dtype=int)
    touched = np.array([_flag(one) for one in stored["touched"]], dtype=bool)
    _alike((len(impulse),), ended, touched)
    if not {motion["motion"] for motion, _ in pairs} <= set(Kind) or not np.isin(ended, range(-1, len(pairs))).all():
        raise ValueError("motions that no analysis lists")
    return _record(
        Motions,
        stored,
        motions=[
            _record(
                LastingMotion,
                motion,
                predicted=one and _predicted(one),
                clearances=_numbers(motion["clearances"]),
                contacts={_text(name): _record(MotionAtContact, at) for name, at in motion["contacts"].items()},
                border=_record(Border, motion["border"]),
                held=tuple(map(_held, motion["held"])),
            )
            for motion, one in pairs
        ],
        **{name: [_predicted(one) for one in stored[name]] for name in ("not_reached", "leaving")},
        impulse=impulse,
        ended=ended,
        touched=touched,
        largest_at=_numbers(stored["largest_at"]),
        smallest=_smallest(stored["smallest"], len(pairs)),
        assumed=tuple(map(_assumed, stored["assumed"])),
    )


def _smallest(stored: dict[str, Any] | None, n_motions: int) -> SmallestImpact | None:
    one: SmallestImpact | None = _record(SmallestImpact, stored) if stored else None
    if one is not None and not 0 <= one.motion < n_motions:
        raise ValueError("a motion that is not in the list")
    return one


def _assumed(stored: dict[str, Any]) -> AssumedRoll:
    roll, border = stored["roll"] and _predicted(stored["roll"]), stored["border"] and _record(Border, stored["border"])
    one: AssumedRoll = _record(AssumedRoll, stored, roll=roll, border=border)
    return one


def _predicted(stored: dict[str, Any]) -> Predicted:
    touches, forces = tuple(map(_text, stored["touches"])), _numbers(stored["forces"])
    one: Predicted = _record(Predicted, stored, touches=touches, forces=forces)
    return one


def _held(stored: dict[str, Any]) -> Held:
    one: Held = _record(Held, stored)
    if one.outcome not in OUTCOMES or not {one.motion, one.passed} <= {*Kind, ""}:
        raise ValueError("a word that no analysis writes")
    return one


def _numbers(stored: dict[str, Any]) -> dict[str, float]:
    return {_text(name): _number(value) for name, value in stored.items()}


def _number(value: Any) -> float:
    return float(_array(value))


def _array(values: Any) -> NDArray[np.float64]:
    """Numbers; null stands for one that is none or beyond all bounds, so that no other is."""
    array = np.array(values, dtype=float)  # None becomes NaN
    if np.isinf(array).any():
        raise ValueError("a number that is infinite")
    return array
