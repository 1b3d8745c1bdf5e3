"""`Report`: a run, its predictions and their comparison, for tables, plots and pages."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.at_rest import static_deflection
from rsc.analysis.alone.free_vibration import free_vibrations
from rsc.analysis.alone.limits import Acceptance
from rsc.analysis.alone.modes import Modes, critical_speeds, modes
from rsc.errors import one_line
from rsc.files.tables import Table, html
from rsc.measure import envelopes, spectra
from rsc.measure.catalogue import Motions
from rsc.measure.changes import Transition
from rsc.measure.course import Course, Orbits, Windows, course
from rsc.measure.features import ContactStrip
from rsc.measure.resonances import Resonance
from rsc.measure.several import ContactCourse, hardest, of_several
from rsc.measure.severity import Verdict, run_facts, verdict_of
from rsc.measure.stretches import Stretches, at_contacts
from rsc.measure.verdict import Row, Window
from rsc.measure.windows import Best, Features
from rsc.presented import Brief
from rsc.results.at_contact import at_contact
from rsc.results.trajectory import Trajectory
from rsc.scene.tables.contacts import Contact
from rsc.show.words.answer import answer
from rsc.show.words.reasons import note
from rsc.system.assemble import assemble
from rsc.system.border import Border, border_of
from rsc.system.system import System

if TYPE_CHECKING:
    from rsc.analysis.follow.branch import Branch
    from rsc.study.report.nearest import Nearest


# what a Report takes as it is from the course of its run
MEASURED = (
    "fall", "stator_fall", "envelope", "strip", "orbits", "order", "centre", "stretches", "features", "lead", "contacts",
)  # fmt: skip


def course_of(result: Trajectory, windows: Windows, system: System) -> Course:
    """The course of a run of a system in windows; of several contacts at the one that is pressed hardest."""
    several = len(system.contacts) > 1
    lead = hardest(result) if several else 0
    own = at_contact(result, lead) if several else result  # a measured run is no Trajectory
    seen = course(own, windows, bool(system.rotor.load.any()), not system.isotropic, system.driven)
    return of_several(result, windows, seen, lead, system.driven) if several else seen


def sag_of(system: System, lead: str) -> float:
    """Static deflection of the rotor in m by its constant load without contact, at one of several contacts or at the only one, in
    the bearings it has at the start; not finite where nothing holds it."""
    one = (system.at_contact(lead) if lead else system).at_start
    with np.errstate(invalid="ignore"):
        return float(abs(static_deflection(one.at_first_speed) @ one.rotor.contact)) if one.rotor.load.any() else 0.0


def border_of_run(result: Trajectory, system: System, features: Features) -> Border | None:
    """The Border of a whole simulated run."""
    each = at_contacts(result)
    if not len(each[0]):
        return None
    wholes = [own.whole() for own in each]
    work = np.sum([own.drive_work for own in each], axis=0)
    power = float(np.abs(work / (each[0].end - each[0].begin)).max())
    known = all(contact.diameter is not None for contact in result.scene.contacts)
    return border_of(
        system,
        float(np.abs(result.scene.drive.speed).max()),
        [whole.force_max for whole in wholes],
        max(whole.rotor_max for whole in wholes),
        float(np.abs(features.turning).max(initial=0.0)),
        power if known else float("nan"),
        result.scene.rotor.total_mass,
    )


def window_speeds(fall: spectra.Waterfall, schedule: Any) -> NDArray[np.float64]:
    """Rotor speeds (n_w,) in Hz for which the windows of a run stand: those of their middles; of the first and the last one those
    at which the run begins and ends. schedule : the drive of a scene."""
    half, speeds = 0.5 * fall.window, np.array(fall.speed, float)
    if len(set(schedule.speed)) > 1:
        end = fall.time[-1] + half
        end = schedule.time[-1] if schedule.time[-1] - end < fall.window else end
        speeds[[0, -1]] = np.interp([max(fall.time[0] - half, schedule.time[0]), end], schedule.time, schedule.speed)
    return speeds


def measured(seen: Course) -> dict[str, Any]:
    """The fields of a Report that are those of the course of its run."""
    return {name: getattr(seen, name) for name in MEASURED}


@dataclass(frozen=True, repr=False)
class Report(Brief):
    """Simulation or measurement, prediction and their comparison.

    result : Trajectory, or a measured.run.MeasuredRun in its place: then strip, stretches and stator_fall are None
    envelope : envelopes.Envelope; strip : features.ContactStrip; orbits : course.Orbits
    fall : spectra.Waterfall; of a long run with the largest of neighbouring bins, for pictures
    stator_fall : spectra.Waterfall of the stator, or None for a rigid one
    order : (n_w,) complex m, the line at the rotor speed in the frame of the shaft; centre : (n_w,) complex m, mean positions
    alone : (n_w,) m, predicted line at the rotor speed without contact
    stretches : stretches.Stretches, what the steps of the run tell of it
    features : windows.Features, one entry a window; best : windows.Best, the predictions it is compared with
    branches : list of branches.Branch, the predicted backward whirls over the run's speeds (without their whirls,
        `rsc.study.report.stored.StoredBranch`, where the analysis is that of a report.json)
    natural : dict, "coupled" and "uncoupled" -> (speed (n,), frequency (n, k)) Hz, signed
    windows : list of verdict.Window; rows : their list of verdict.Row, three a window; transitions : list of changes.Transition
    rub : (speed (n,) Hz, amplitude (n,) m) of the forward rub, NaN where it does not exist
    resonances : list of resonances.Resonance, where the unbalance line is largest on each whirl of the run
    resonance : float Hz, speed at which the forward rub is largest, in closed form (NaN where it does not exist)
    warnings : list of str; remarks : list of str, on supports whose directions differ and on bodies that were reduced
    motions : list of catalogue.Motions, what can last at the end of the run and where its motion changed
    agreement : str, one sentence on how well simulation and prediction agree
    border : system.border.Border of the whole run, or None of a measured one
    limits : analysis.alone.limits.Acceptance of a scene with [limits], or None
    nearest : tuple of study.nearest.Nearest, the roots next to a measured whirl
    sag : float m, static deflection of the rotor at the contact by its constant load; infinite where no spring holds it
    lead : str, of several contacts the name of the one at which all this is told that is of one; "" with one. There branches are
        analysis.follow.branch.SetBranch, those of every pressed set
    contacts : dict, name -> measure.several.ContactCourse, what the windows are at each of several contacts
    """

    result: Trajectory = field(repr=False)
    fall: spectra.Waterfall = field(repr=False)
    stator_fall: spectra.Waterfall | None = field(repr=False)
    envelope: envelopes.Envelope = field(repr=False)
    strip: ContactStrip | None = field(repr=False)
    orbits: Orbits = field(repr=False)
    order: NDArray[np.complex128] = field(repr=False)
    centre: NDArray[np.complex128] = field(repr=False)
    alone: NDArray[np.float64] = field(repr=False)
    stretches: Stretches | None = field(repr=False)
    features: Features = field(repr=False)
    best: Best = field(repr=False)
    branches: "list[Branch]" = field(repr=False)
    natural: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = field(repr=False)
    windows: list[Window] = field(repr=False)
    transitions: list[Transition]
    rub: tuple[NDArray[np.float64], NDArray[np.float64]] = field(repr=False)
    resonances: list[Resonance]
    resonance: float
    warnings: list[str]
    remarks: list[str]
    motions: list[Motions]
    agreement: str
    border: Border | None = None
    limits: Acceptance | None = None
    nearest: "tuple[Nearest, ...]" = ()
    sag: float = 0.0
    lead: str = ""
    contacts: dict[str, ContactCourse] = field(default_factory=dict, repr=False)

    @property
    def contact(self) -> Contact:
        """The contact to which results of a single contact refer."""
        contacts = self.result.scene.contacts
        return next((contact for contact in contacts if contact.name == self.lead), contacts[0])

    @cached_property
    def speeds(self) -> NDArray[np.float64]:
        """Rotor speeds (n_w,) in Hz for which the windows stand, `window_speeds`."""
        return self.fall.speed if self.stretches is None else window_speeds(self.fall, self.result.scene.drive)

    @property
    def at_contact(self) -> Trajectory:
        """The run as it is seen there."""
        contacts = self.result.scene.contacts
        return at_contact(self.result, contacts.index(self.contact)) if self.lead else self.result

    @cached_property
    def verdict(self) -> Verdict | None:
        """Verdict: the motion of the run, the effect of an impact, and the severity; None for a measured run."""
        if self.stretches is None or self.border is None:
            return None
        each = at_contacts(self.result)
        touched = any(own.contact_time.any() for own in each)
        force = max(own.whole().force_max for own in each)
        races = any(contact.race_inertia is not None for contact in self.result.scene.contacts)
        run = run_facts(self.features, self.speeds.tolist(), touched, force, self.border, races)
        return verdict_of(run, self.features, self.speeds.tolist(), self.motions)

    @cached_property
    def modes(self) -> Modes:
        """Modes: those of the machine at the highest speed of the run."""
        return modes(self.result.scene, max(self.result.scene.drive.speed, key=abs))

    @cached_property
    def criticals(self) -> list[tuple[float, float]]:
        """Critical speeds in Hz up to the highest speed of the run, without contact, with their logarithmic decrements."""
        system = assemble(self.result.scene).at_start
        speeds = critical_speeds(system, 0.0, float(np.max(np.abs(self.result.scene.drive.speed))))
        nearest = [min(free_vibrations(system, at), key=lambda each: abs(abs(each.frequency) - at)) for at in speeds]
        return [(at, each.decrement) for at, each in zip(speeds, nearest, strict=True)]

    @property
    def word(self) -> str:
        """ "simulated" or "measured"."""
        return "measured" if self.stretches is None else "simulated"

    @property
    def rows(self) -> list[Row]:
        """Every comparison, three a window: of frequency and amplitude of the whirl and of the synchronous line."""
        return [row for window in self.windows for row in window]

    def table(self) -> Table:
        """A `rsc.files.tables.Table`, a row for each window and quantity, for pandas (`to_dataframe`) and CSV (`to_csv`)."""
        names = [each.name for each in fields(Row) if each.name != "reasons"]
        return Table((*names, "note"), [[*(getattr(row, name) for name in names), note(row)] for row in self.rows])

    def plot(self, picture: str = "campbell", ax: Any = None, others: "Sequence[Report]" = (), **style: Any) -> Any:
        """Draw one picture of the page.

        picture : name of `rsc.show.pictures.album.PICTURES` ("campbell", "waterfall", "amplitude", "force", "energy", ...), or
            "orbit" for the path at the last of the page's moments

        ax : matplotlib axes, by default those of a new figure; style : properties of lines of matplotlib
        others : Reports of other runs, whose amplitudes stand beside its own in the picture "amplitude"

        Returns the axes; SceneError for another name, or a picture in which this run has nothing to show.
        """
        from rsc.show.pictures import of_results

        return of_results.report(self, picture, ax, others, style)

    def animate(self) -> Any:
        """The orbit in windows all along the run, one after the other, as an animation of matplotlib that plays in a notebook.

        Returns a `matplotlib.animation.FuncAnimation`; its `save` writes films in the formats that matplotlib knows.
        """
        from rsc.show.pictures import plots, report_pictures

        return plots.Film(*report_pictures.frames(self))

    def save_html(self, path: str | os.PathLike[str], overwrite: bool = False, others: "Sequence[Report]" = ()) -> None:
        """Write the page that `rsc check` writes, report.html; DataError when the file cannot be written.

        others : Reports of other runs, whose amplitudes are drawn beside its own (run-up and run-down show the hysteresis)
        overwrite : bool, also in the place of a file that rsc did not write, or that was changed since
        """
        from rsc.files.output import put_all
        from rsc.show.page import page_file

        put_all([page_file(self, path, others)], overwrite)

    def _repr_html_(self) -> str:
        return html((one_line(self.result.scene.title) or "report", ""), answer(self))
