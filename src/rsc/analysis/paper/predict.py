"""Predicted whirls of a System at its only contact, frequencies in Hz; of a scene: `rsc.analysis.several.predict`."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import tau as TWO_PI
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.paper.anisotropy import MirrorLine, mirror_line
from rsc.analysis.paper.receptance import along
from rsc.analysis.paper.stability import Growth, whirl_growths
from rsc.analysis.paper.synchronous import SynchronousPart, synchronous_response
from rsc.analysis.paper.watched import shares, touched, whirl_deflections
from rsc.analysis.paper.whirls import CIRCULAR, WITHIN, side_conditions, steady_whirls, whirl_shapes
from rsc.errors import SceneError
from rsc.files.tables import Table
from rsc.presented import Brief, BriefList, drawing
from rsc.system.assemble import SceneLike
from rsc.system.blas import one_thread
from rsc.system.system import System

MOST_SPEED = 1e6  # Hz, as for the drive of a scene
_PRINTED = 1e-5  # of a speed, by which it may differ from its six printed digits


def refuse_backwards(name: str, speed: float) -> None:
    """SceneError for a speed in Hz below zero, where only what turns forward is told; name : str, of the caller."""
    if speed < 0.0:
        hint = "scene.mirrored() is the same machine turning the other way; rsc check shows it so"
        raise SceneError(name, "speed", float(speed), "at least 0 Hz", hint)


@dataclass(frozen=True)
class SynchronousForm:
    """Synchronous part of one whirl in one form of the theory; amplitudes at the contact coordinate of the rotor.

    force : float N, |F_Omega|; mirror_force : float N
    amplitude : float m, of the line at the rotor speed; mirror_amplitude : float m, of the mirror line
    envelope : (float, float) m, smallest and largest |r| over the beat of all lines
    """

    force: float
    mirror_force: float
    amplitude: float
    mirror_amplitude: float
    envelope: tuple[float, float]


@dataclass(frozen=True)
class Synchronous:
    """Effect of the unbalance on one whirl.

    mirror_frequency : float Hz, 2 frequency - speed
    consistent : SynchronousForm, consistent to first order (the one to compare with); its contact damping is b_C/2
    printed : SynchronousForm, (21) and (28) as the paper prints them, no mirror line, but for 1/k_C of the elastic contact
    """

    mirror_frequency: float
    consistent: SynchronousForm
    printed: SynchronousForm


@dataclass(frozen=True)
class Mirror:
    """What supports whose directions differ add to one whirl (`rsc.analysis.paper.anisotropy`), at the contact of the rotor.

    frequency : float Hz, minus that of the whirl
    share : float, amplitude over that of the whirl; above 0.1 the whirl is no circle, and nothing of it is claimed
    amplitude, third_amplitude : float m, of the mirror line and of the line at three times the whirl's frequency
    envelope : (float, float) m, smallest and largest |r|
    """

    frequency: float
    share: float
    amplitude: float
    third_amplitude: float
    envelope: tuple[float, float]


@dataclass(frozen=True, eq=False, repr=False)
class Whirl(Brief):
    """One steady whirl at one rotor speed; without unbalance unless said otherwise.

    speed : float Hz, rotor speed; frequency : float Hz, of the other sign: backward
    rotor_amplitude, stator_amplitude : float m, at the contacting coordinates (stator: 0 if rigid)
    normal_force : float N
    rotor_shape (N,), stator_shape (M,) : complex m (tilts: rad), with the contact at angle 0
    growth_rate : float 1/s, of the fastest growing small motion (the free phase removed)
    growth_frequency : float Hz, of that motion in the frame turning with the whirl
    stable : bool, growth_rate < 0, nearly circular and within all clearances; sliding forward is assumed
    admissible : bool, every side condition holds (`violated` is empty)
    conditions : dict, name -> margin as in `rsc.analysis.paper.whirls.side_conditions`
    violated : tuple of str, the side conditions that do not hold
    synchronous : Synchronous, effect of the unbalance
    mirror : Mirror, effect of supports whose directions differ, all else being of their isotropic mean; None where they do not
    clearances : dict, name -> largest deflection over gap, with its unbalance, at each place that is only watched
    touches : tuple of str, those of them whose gap it reaches, the one that is passed furthest first
    """

    speed: float
    frequency: float
    rotor_amplitude: float
    stator_amplitude: float
    normal_force: float
    rotor_shape: NDArray[np.complex128]
    stator_shape: NDArray[np.complex128]
    growth_rate: float
    growth_frequency: float
    stable: bool
    admissible: bool
    conditions: dict[str, float]
    violated: tuple[str, ...]
    synchronous: Synchronous
    mirror: Mirror | None = None
    clearances: dict[str, float] = field(default_factory=dict)
    touches: tuple[str, ...] = ()

    def table(self) -> Table:
        """As `Whirls.table`, of this one."""
        return Whirls([self]).table()

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()

    @property
    def decays(self) -> bool:
        """Whether small motions about it decay and it is nearly circular, whatever it touches: a run follows such a whirl."""
        return self.growth_rate < 0.0 and CIRCULAR not in self.violated

    def mirrored(self) -> "Whirl":
        """The whirl of the mirrored scene (`rsc.Scene.mirrored`)."""
        return replace(
            self,
            speed=-self.speed,
            frequency=-self.frequency,
            rotor_shape=self.rotor_shape.conj(),
            stator_shape=self.stator_shape.conj(),
            synchronous=replace(self.synchronous, mirror_frequency=-self.synchronous.mirror_frequency),
            mirror=None if self.mirror is None else replace(self.mirror, frequency=-self.mirror.frequency),
        )


class Whirls(BriefList[Whirl]):
    """The whirls at one rotor speed, a list; a notebook shows it as a table."""

    def table(self) -> Table:
        """A `rsc.files.tables.Table` with a row for each whirl, for pandas (`to_dataframe`) and CSV (`to_csv`)."""
        return Table(tuple(_COLUMNS), [[value(whirl) for value in _COLUMNS.values()] for whirl in self])

    def plot(self, ax: Any = None, **style: Any) -> Any:
        """Draw their frequencies at their rotor speed, filled where stable, open where not.

        ax : matplotlib axes, by default those of a new figure; style : properties of lines of matplotlib. Returns the axes.
        """
        speed, frequency, stable = ([getattr(whirl, name) for whirl in self] for name in ("speed", "frequency", "stable"))
        return drawing().whirls(np.array(speed), np.array(frequency), np.array(stable, dtype=bool), ax, style)

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


_COLUMNS: dict[str, Callable[[Whirl], object]] = {
    "rotor speed in Hz": lambda whirl: whirl.speed,
    "frequency in Hz": lambda whirl: whirl.frequency,
    "rotor amplitude in m": lambda whirl: whirl.rotor_amplitude,
    "stator amplitude in m": lambda whirl: whirl.stator_amplitude,
    "normal force in N": lambda whirl: whirl.normal_force,
    "growth rate in 1/s": lambda whirl: whirl.growth_rate,
    "stable": lambda whirl: whirl.stable,
    "touches": lambda whirl: ", ".join(whirl.touches),
    "line at the rotor speed in m": lambda whirl: whirl.synchronous.consistent.amplitude,
    "not valid": lambda whirl: ", ".join(whirl.violated),
}


def refuse_speeds(source: str, key: str, scene: SceneLike, speeds: NDArray[np.floating]) -> None:
    """SceneError for a speed in Hz that no drive may have, or beyond those for which the scene's rotor was reduced."""
    for value in speeds[~(np.abs(speeds) <= MOST_SPEED)][:1]:
        raise SceneError(source, key, float(value), f"a speed in Hz between {-MOST_SPEED:g} and {MOST_SPEED:g}")
    if scene.rotor.model == "reduced":
        low, high = scene.rotor.speeds
        slack = _PRINTED * max(abs(low), abs(high))
        for value in speeds[(speeds < low - slack) | (speeds > high + slack)][:1]:
            wanted = f"within {low:g} to {high:g} Hz, for which the rotor was reduced"
            raise SceneError(source, key, float(value), wanted, "read the scene file with a drive that reaches this speed")


@one_thread
def predict_system(system: System, speed_hz: float) -> list[Whirl]:
    """Predict the steady whirls of a System with one contact at one rotor speed in Hz: every root with positive normal force,
    stable or not, sorted by frequency."""
    if speed_hz < 0.0:  # a whirl against the spin has a positive frequency then
        return [whirl.mirrored() for whirl in predict_system(system.mirrored(), -speed_hz)[::-1]]
    Psi, F_N = steady_whirls(system, TWO_PI * float(speed_hz))
    return whirls_of(system, Psi, F_N, float(speed_hz))


def whirls_of(
    system: System,
    Psi: NDArray[np.float64],
    F_N: NDArray[np.float64],
    speed: float | NDArray[np.float64],
    growths: list[Growth] | None = None,
) -> list[Whirl]:
    """The Whirl that belongs to each root Psi (n,) rad/s and its normal force F_N (n,) N; speed in Hz, one or each its own.

    The system may be a stack of n. growths: those of `whirl_growths` where they are known.
    """
    if len(Psi) == 0:
        return []
    speeds, Omega = np.broadcast_to(speed, Psi.shape), TWO_PI * speed
    rotor, stator = whirl_shapes(system, Psi, F_N, Omega)
    forms = synchronous_response(system, Psi, F_N, Omega)
    lines = None if system.isotropic else mirror_line(system, Psi, F_N, Omega)
    deflected = None
    if system.clearances:
        forces = forms[0].force, forms[0].mirror_force
        deflected = shares(system, whirl_deflections(system, Psi, F_N, Omega, forces))
    share = None if lines is None else lines.share
    conditions = side_conditions(system, Psi, F_N, Omega, forms[0].force, share, deflected)
    amplitudes = [np.abs(along(*pair)) for pair in ((rotor, system.rotor.contact), (stator, system.stator.contact))]
    mirror = (2.0 * Psi - Omega) / TWO_PI
    growths = whirl_growths(system, Psi, F_N, Omega) if growths is None else growths
    whirls = []
    for i, growth in enumerate(growths):
        violated = tuple(name for name, condition in conditions.items() if not condition.holds[i])
        consistent, printed = (_form(form, i) for form in forms)
        whirls.append(
            Whirl(
                speed=float(speeds[i]),
                frequency=float(Psi[i]) / TWO_PI,
                rotor_amplitude=float(amplitudes[0][i]),
                stator_amplitude=float(amplitudes[1][i]),
                normal_force=float(F_N[i]),
                rotor_shape=rotor[i],
                stator_shape=stator[i],
                growth_rate=growth.rate,
                growth_frequency=growth.frequency / TWO_PI,
                stable=growth.rate < 0.0 and not {CIRCULAR, WITHIN} & set(violated),
                admissible=not violated,
                conditions={name: float(condition.margin[i]) for name, condition in conditions.items()},
                violated=violated,
                synchronous=Synchronous(float(mirror[i]), consistent, printed),
                mirror=None if lines is None else _mirror(lines, Psi, i),
                **_watched(system, None if deflected is None else deflected[i]),
            )
        )
    return whirls


def _watched(system: System, deflected: NDArray[np.float64] | None) -> dict[str, Any]:
    """What a Whirl tells of the clearances, of its deflections over the gap."""
    if deflected is None:
        return {}
    names = [place.name for place in system.clearances]
    return {"clearances": dict(zip(names, deflected.tolist(), strict=True)), "touches": touched(system, deflected)}


def _mirror(lines: MirrorLine, Psi: NDArray[np.float64], i: int) -> Mirror:
    return Mirror(
        frequency=-float(Psi[i]) / TWO_PI,
        share=float(lines.share[i]),
        amplitude=float(lines.line[i]),
        third_amplitude=float(lines.third[i]),
        envelope=(float(lines.low[i]), float(lines.high[i])),
    )


def _form(part: SynchronousPart, i: int) -> SynchronousForm:
    return SynchronousForm(
        force=float(abs(part.force[i])),
        mirror_force=float(abs(part.mirror_force[i])),
        amplitude=float(part.line[i]),
        mirror_amplitude=float(part.mirror_line[i]),
        envelope=(float(part.low[i]), float(part.high[i])),
    )
