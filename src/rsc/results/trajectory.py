"""`Trajectory`, the result of a run: uniformly sampled motion, how it ended, and where its samples are."""

import contextlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rsc.arguments import FLAG, PATH, takes
from rsc.errors import SceneError, one_line
from rsc.files.tables import Table, html
from rsc.measure.stretches import Stretches, side_by_side
from rsc.presented import drawing
from rsc.results.result_file import ResultFile
from rsc.results.result_format import AXES, MOTIONS, locked, motions_of, moving_body, series_of
from rsc.results.result_writer import ResultWriter
from rsc.results.summary import Ledger, Status, Summary
from rsc.scene.scene import Scene
from rsc.scene.tables.drive import Drive

if TYPE_CHECKING:
    import xarray


MOST_CORNERS = 2001  # of the schedule that stands for a simulated speed


@dataclass(frozen=True)
class Samples:
    """Consecutive samples of a run at its contact, arrays (n,) as those of a `Trajectory`."""

    scene: Scene
    time: NDArray[np.float64]
    speed: NDArray[np.float64]
    normal_force: NDArray[np.float64]
    friction_force: NDArray[np.float64]
    tangential_velocity: NDArray[np.float64]
    rotor: NDArray[np.complex128]
    stator: NDArray[np.complex128]
    race_speed: NDArray[np.float64] | None = None

    def contact_rotor(self) -> NDArray[np.complex128]:
        """(n,) complex m."""
        return self.rotor

    def contact_stator(self) -> NDArray[np.complex128]:
        """(n,) complex m; zeros for a rigid stator."""
        return self.stator


@dataclass(frozen=True, repr=False)
class Trajectory:
    """A run: uniformly sampled motion, status, counters and energy ledger. Arrays are read when first asked for.

    They cannot be written: what a run computed stays what `save` writes. To change one take a copy (`result.rotor.copy()`).
    """

    scene: Scene
    summary: Summary
    source: "MemoryBlocks | ResultFile" = field(repr=False)

    @property
    def time(self) -> NDArray[np.float64]:
        """(n_time,) s."""
        return self.source.series("time")

    @property
    def speed(self) -> NDArray[np.float64]:
        """(n_time,) Hz, rotor speed."""
        return self.source.series("speed")

    @property
    def angle(self) -> NDArray[np.float64]:
        """(n_time,) turns from 0 to 1, rotation angle of the rotor, in runs with drive.torque; SceneError in others."""
        if self.scene.drive.inertia is None:
            hint = "the angle of a prescribed speed is its integral"
            raise SceneError(self.scene.source, "drive.torque", None, "given", hint)
        return self.source.series("angle")

    @property
    def race_speed(self) -> NDArray[np.float64]:
        """(n_time,) Hz, speed of the inner race, in runs with contact.race_inertia; of several contacts (n_time, n_contacts), 0
        at one without a race; SceneError in others."""
        if "race_speed" not in series_of(self.scene):
            raise SceneError(self.scene.source, "contact.race_inertia", None, "given", "no race turns in this run")
        return self.source.series("race_speed")

    @property
    def scheduled(self) -> "Trajectory":
        """The run as if its speed had been prescribed: of a drive with a torque a run of a scene whose schedule stands for the
        simulated speed, in at most 2000 straight pieces, of others the run itself."""
        return self if self.scene.drive.inertia is None or self.n_time < 2 else self._with_schedule

    @cached_property
    def _with_schedule(self) -> "Trajectory":
        places = np.unique(np.linspace(0, self.n_time - 1, min(self.n_time, MOST_CORNERS)).round().astype(int))
        time, speed = self.time[places].tolist(), np.maximum(self.speed[places], 0.0).tolist()
        if self.summary.end_time > time[-1]:
            time, speed = [*time, self.summary.end_time], [*speed, speed[-1]]
        return Trajectory(replace(self.scene, drive=Drive.along(tuple(time), tuple(speed))), self.summary, self.source)

    @property
    def rotor(self) -> NDArray[np.complex128]:
        """(n_time, n_rotor) complex m."""
        return self.source.motion("rotor")

    @property
    def stator(self) -> NDArray[np.complex128]:
        """(n_time, n_stator) complex m."""
        return self.source.motion("stator")

    @property
    def rotor_velocity(self) -> NDArray[np.complex128]:
        """(n_time, n_rotor) complex m/s, in runs with `output.velocities`; SceneError in others."""
        return self._velocity("rotor_velocity")

    @property
    def stator_velocity(self) -> NDArray[np.complex128]:
        """(n_time, n_stator) complex m/s, in runs with `output.velocities`; SceneError in others."""
        return self._velocity("stator_velocity")

    @property
    def rotor_states(self) -> NDArray[np.complex128]:
        """(n_time, p) complex, first-order states of the rotor in their own units (physics.md): those of `states`, then of every
        magnetic bearing a, q and u; p = 0 without any."""
        return self.source.motion("rotor_states")

    @property
    def stator_states(self) -> NDArray[np.complex128]:
        """(n_time, p) complex, first-order states of the stator, as `rotor_states`."""
        return self.source.motion("stator_states")

    def _velocity(self, name: str) -> NDArray[np.complex128]:
        if not self.scene.output.velocities:
            raise SceneError(self.scene.source, "output.velocities", False, "true", "this run was made without velocities")
        return self.source.motion(name)

    @property
    def normal_force(self) -> NDArray[np.float64]:
        """(n_time,) N; of several contacts (n_time, n_contacts)."""
        return self.source.series("normal_force")

    @property
    def friction_force(self) -> NDArray[np.float64]:
        """(n_time,) N, mu sigma F_N; of several contacts (n_time, n_contacts)."""
        return self.source.series("friction_force")

    @property
    def tangential_velocity(self) -> NDArray[np.float64]:
        """(n_time,) m/s, Im(d' conj d)/|d|; the slip velocity is this plus Omega d_R/2."""
        return self.source.series("tangential_velocity")

    def stretches(self, contact: str | None = None) -> Stretches:
        """Facts of the motion in the stretches of the run, from its steps and not from samples: at the contact, of several at the
        one with this name (default: the first)."""
        facts, names = self.source.facts(), [one.name for one in self.scene.contacts]
        if contact is not None and contact not in names:
            wanted = "one of " + ", ".join(filter(None, names)) if any(names) else "left out"
            raise SceneError(self.scene.source, "contact", contact, wanted)
        return side_by_side(facts, len(names))[0 if contact is None else names.index(contact)]

    @property
    def status(self) -> Status:
        """How the run ended."""
        return self.summary.status

    @property
    def steps(self) -> int:
        """Accepted steps."""
        return self.summary.steps

    @property
    def rejected(self) -> int:
        """Rejected steps."""
        return self.summary.rejected

    @property
    def rhs_calls(self) -> int:
        """Evaluations of the right-hand side."""
        return self.summary.rhs_calls

    @property
    def contact_onsets(self) -> int:
        """Times that contact began."""
        return self.summary.contact_onsets

    @property
    def contact_releases(self) -> int:
        """Times that contact ended."""
        return self.summary.contact_releases

    @property
    def ledger(self) -> Ledger:
        """Energies of the run."""
        return self.summary.ledger

    def kept_open(self) -> contextlib.AbstractContextManager[None]:
        """Context in which the file of the run is opened and looked at once, and not again with every question."""
        return self.source.kept_open()

    @property
    def n_time(self) -> int:
        """Number of samples, known without reading them."""
        return self.source.n_time()

    @property
    def digest(self) -> str:
        """SHA-256 over scene, summary and versions of a result file; "" of a run in memory."""
        return self.source.digest()

    def samples(self, begin: int, end: int) -> Samples:
        """The samples from number begin to end (exclusive) at the contact; the others are not read."""
        contact = self.scene.contact
        first, *against = contact.rotor_coordinates
        columns = {"rotor": first}
        if self.scene.stator.n_coordinates:
            columns["stator"] = contact.stator_coordinate
        values = self.source.at_contact(columns, (begin, end))
        values.pop("angle", None)
        for place in against:  # of two that touch each other the first less the second
            values["rotor"] = values["rotor"] - self.source.at_contact({"rotor": place}, (begin, end))["rotor"]
        return Samples(self.scene, **{"stator": np.zeros(end - begin, dtype=complex)} | values)

    def contact_rotor(self) -> NDArray[np.complex128]:
        """(n_time,) complex m: rotor displacement at the contacting coordinate, without reading the others; where two of them
        touch each other that of the first less that of the second."""
        first, *against = (self.source.motion("rotor", place) for place in self.scene.contact.rotor_coordinates)
        return first - against[0] if against else first

    def contact_stator(self) -> NDArray[np.complex128]:
        """(n_time,) complex m: stator displacement at the contact; zeros for a rigid stator."""
        if self.scene.stator.model == "rigid":
            return np.zeros(self.time.shape, dtype=complex)
        return self.source.motion("stator", self.scene.contact.stator_coordinate)

    @takes(path=PATH, overwrite=FLAG)
    def save(self, path: str | os.PathLike[str], overwrite: bool = False) -> None:
        """Write the run to one HDF5 file; DataError when that is impossible.

        overwrite : bool, also in the place of a file that rsc did not write, or that was changed since
        """
        with ResultWriter(path, self.scene, self.summary.versions, overwrite) as writer:
            writer.append(self.source.block(), stretches=self.source.facts())
            writer.finish(self.summary)

    def table(self) -> Table:
        """The run as a `rsc.files.tables.Table`, a row for each sample, for pandas (`to_dataframe`) and CSV (`to_csv`)."""
        columns = {"time in s": self.time}
        for name, (unit, _) in series_of(self.scene).items():
            values, label = getattr(self, name), name.replace("_", " ")
            several = zip(self.scene.contacts, values.T, strict=True) if values.ndim > 1 else ()
            columns |= {f"{label} of {one.name} in {unit}": own for one, own in several} or {f"{label} in {unit}": values}
        for name in motions_of(self.scene):
            label, unit = name.replace("_", " "), MOTIONS[name][0]
            for i, motion in enumerate(getattr(self, name).T):
                columns |= {f"{label} {i} y in {unit}": motion.real, f"{label} {i} z in {unit}": motion.imag}
        return Table(tuple(columns), np.column_stack(list(columns.values())).tolist())

    def plot(self, kind: str = "orbit", ax: Any = None, time: float | Sequence[float] | None = None, **style: Any) -> Any:
        """Draw the motion at the contact.

        kind : "orbit", "envelope" (largest and smallest distance over time) or "spectrum" (two-sided, at a time)
        ax : matplotlib axes, by default those of a new figure
        time : s, middle of the window that is shown, or its (begin, end); by default the last window, of an envelope the run
        style : properties of lines of matplotlib. Returns the axes; SceneError for another kind, or a time outside the run.
        """
        return drawing().trajectory(self, kind, ax, time, style)

    def __repr__(self) -> str:
        summary, title = self.summary, one_line(self.scene.title)
        ended = f"{summary.status} at {summary.end_time:.6g} s"
        samples = f"{self.n_time} samples at {self.scene.output.rate:g} Hz"
        touched = f"{summary.contact_onsets} onsets, {summary.contact_time:.4g} s in contact"
        return f"Trajectory({title[:60]!r}, {ended}, {samples}, {touched})"

    def _repr_html_(self) -> str:
        summary = self.summary
        facts = {
            "status": f"{summary.status} at {summary.end_time:.6g} s",
            "samples": f"{self.n_time} at {self.scene.output.rate:g} Hz",
            "steps": f"{summary.steps} at rtol {summary.rtol:.2g}",
            "contact": f"{summary.contact_onsets} onsets, {summary.contact_time:.4g} s in contact",
            "energy unaccounted for": f"{summary.ledger.residual:.2g} J of {summary.ledger.turnover:.4g} J",
            "advice": summary.advice,
        }
        return html((one_line(self.scene.title) or "run", ""), [[name, text] for name, text in facts.items() if text])

    def to_xarray(self) -> "xarray.Dataset":
        """The run as an xarray.Dataset with units (needs xarray)."""
        import xarray

        series = series_of(self.scene).items()
        arrays, axes = {n: getattr(self, n) for n, _ in series}, ("time", "contact")
        values: dict[str, Any] = {n: (axes[: arrays[n].ndim], arrays[n], {"units": u, "long_name": d}) for n, (u, d) in series}
        for name in motions_of(self.scene):
            unit, text = MOTIONS[name]
            dims = "time", AXES[moving_body(name)]
            values[name] = (dims, getattr(self, name), {"units": unit, "long_name": text})
        return xarray.Dataset(values, {"time": ("time", self.time, {"units": "s"})}, {"title": self.scene.title})


class MemoryBlocks:
    """The samples of a run kept in memory, block by block."""

    def __init__(self) -> None:
        self._blocks: list[Mapping[str, np.ndarray]] = []
        self._stretches: list[NDArray[np.float64]] = []

    def append(
        self,
        block: Mapping[str, np.ndarray],
        checkpoint: Mapping[str, np.ndarray] | None = None,
        stretches: NDArray[np.float64] | None = None,
    ) -> None:
        """Add a block: name -> array, motions complex, and facts of stretches; a run in memory needs no checkpoint."""
        self._blocks.append({name: locked(values) for name, values in block.items()})
        if stretches is not None:
            self._stretches.append(stretches)

    def finish(self, stretches: NDArray[np.float64]) -> None:
        """Add the facts of the last stretches."""
        self._stretches.append(stretches)

    def facts(self) -> NDArray[np.float64]:
        """Facts of the stretches of the run, those of several contacts side by side."""
        return locked(np.concatenate(self._stretches))

    def kept_open(self) -> contextlib.AbstractContextManager[None]:
        """There is no file."""
        return contextlib.nullcontext()

    def block(self) -> Mapping[str, np.ndarray]:
        """All samples as one block."""
        if len(self._blocks) != 1:
            names = self._blocks[0]
            self._blocks = [{name: locked(np.concatenate([b[name] for b in self._blocks])) for name in names}]
        return self._blocks[0]

    def series(self, name: str) -> NDArray[np.float64]:
        """One array over time."""
        return self.block()[name]

    def digest(self) -> str:
        """No file, no digest."""
        return ""

    def n_time(self) -> int:
        """Number of samples."""
        return sum(len(block["time"]) for block in self._blocks)

    def at_contact(self, columns: Mapping[str, int], rows: tuple[int, int]) -> dict[str, np.ndarray]:
        """Every array over time, and of `rotor` and `stator` one coordinate each, in the rows first to last (exclusive)."""
        block, place = self.block(), slice(*rows)
        series = {name: values[place] for name, values in block.items() if name not in MOTIONS}
        return series | {name: block[name][place, column] for name, column in columns.items()}

    def motion(self, name: str, column: int | None = None) -> NDArray[np.complex128]:
        """Complex displacements or velocities, all or one column."""
        values = self.block()[name]
        return values if column is None else values[:, column]


@takes(path=PATH)
def load(path: str | os.PathLike[str]) -> Trajectory:
    """Read a result file.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Trajectory
        Its arrays are read from the file when first asked for.

    Raises
    ------
    DataError
        The file is missing, damaged or no result of rsc.

    Examples
    --------
    >>> result = rsc.simulate(rsc.load_scene("laval.toml"), path="laval.h5")
    >>> print(rsc.load("laval.h5").status)
    finished
    """
    source = ResultFile(path)
    with source.kept_open():
        return Trajectory(source.scene(), source.summary(), source)
