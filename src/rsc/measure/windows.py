"""What is known of the windows of a run before they are judged: features, predictions, and the whirl that a window follows."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rsc.measure.kinds import BACKWARD, Kind, ProbeKind

# a line further from every predicted frequency belongs to none
NEAR = 0.1
# in the place of a branch's label
ROLL = "roll"
# share of the time in contact from which on a whirl that rolls is looked for
ROLLS_PARTLY = 0.1
# fewer periods of a line than this in a window do not resolve it
LEAST_PERIODS = 3.0


class BranchLike(Protocol):
    """The parts of a `rsc.analysis.follow.branch.Branch` that a run is compared with; its whirls as in `rsc.Whirl`."""

    @property
    def label(self) -> str: ...

    @property
    def pressed(self) -> tuple[str, ...]: ...

    @property
    def lost(self) -> tuple[float, ...]: ...

    @property
    def speed(self) -> NDArray[np.float64]: ...

    @property
    def growth_rate(self) -> NDArray[np.float64]: ...

    def at(self, value: float) -> Any: ...


@dataclass(frozen=True)
class Features:
    """Quantities measured in the windows of a run; arrays (n_w,) unless said otherwise, NaN where absent.

    A line is looked for in the motions of rotor and stator at the contact and in the relative one, which is what the contact
    sees, and is that of the motion in which the strongest backward line is largest.

    window : float s, their length; rate : float Hz, samples a second
    kind : (n_w,) str, `rsc.measure.kinds.Kind` or, of a measured run, `ProbeKind`, and why, (n_w,) str, why it is not resolved;
    turning Hz, mean rate at which the contact deflection turns; share (contact, 0 to 1); rolling, share of the time in contact
    with less slip than full friction needs; largest m, |r| of the rotor; peak_to_peak m, the larger of its extents in y and z;
    stator_largest m; force and force_max N, mean and largest normal force: all from the steps of the simulation. Of a measured
    run share is 0 where the shaft stays within the gap and is in no whirl, else NaN; rolling is 0, and force, force_max and
    stator_largest are NaN
    speed Hz, time s, frequency Hz and size m of the strongest backward line, other_frequency and
    other_size (n_w, 2) of the next two, amplitude and stator_amplitude m of rotor and stator at the strongest line's frequency,
    synchronous m (the rotor's line at the rotor speed): all from samples
    Of several contacts (`rsc.measure.several`): names, what each window is and at which contacts; sets, the pressed set of each,
    empty where it is not of one kind at all contacts that touch. Both are empty with one.
    """

    window: float
    rate: float
    speed: NDArray[np.float64]
    time: NDArray[np.float64]
    share: NDArray[np.float64]
    frequency: NDArray[np.float64]
    size: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    stator_amplitude: NDArray[np.float64]
    other_frequency: NDArray[np.float64]
    other_size: NDArray[np.float64]
    synchronous: NDArray[np.float64]
    kind: NDArray[np.str_]
    why: NDArray[np.str_]
    turning: NDArray[np.float64]
    rolling: NDArray[np.float64]
    largest: NDArray[np.float64]
    peak_to_peak: NDArray[np.float64]
    stator_largest: NDArray[np.float64]
    force: NDArray[np.float64]
    force_max: NDArray[np.float64]
    names: tuple[str, ...] = ()
    sets: tuple[tuple[str, ...], ...] = ()

    def on_whirl(self, i: int) -> bool:
        """Whether window i is in backward whirl."""
        return self.kind[i] in (*BACKWARD, ProbeKind.WHIRL)

    def too_fast(self, i: int) -> bool:
        """Whether the contact deflection of window i turns faster than the samples show; its line may then be anywhere."""
        return bool(abs(self.turning[i]) > 0.5 * self.rate)


@dataclass(frozen=True)
class Best:
    """The best prediction for the whirl that each window follows, (n_w,) each, NaN where there is none but the first order.

    With the whole unbalance by harmonic balance, and with the lag behind a moving whirl.

    frequency Hz; amplitude, stator_amplitude m, of rotor and stator at the contact; synchronous m, the rotor's line at its speed
    reached : share of the unbalance up to which a steady whirl exists where that is below 1
    growth_rate : 1/s, of small disturbances of the whirl with its unbalance, where it loses contact during the beat
    lag : relative difference of the amplitude from that of the steady whirl, part of `amplitude`
    """

    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    stator_amplitude: NDArray[np.float64]
    synchronous: NDArray[np.float64]
    reached: NDArray[np.float64]
    growth_rate: NDArray[np.float64]
    lag: NDArray[np.float64]


@dataclass(frozen=True)
class Steady:
    """Predicted synchronous motions without a whirl, m at the contact, (n_w,) each: without contact, in permanent contact
    (forward rub; NaN where it does not exist), and without contact as a changing speed leaves it (NaN where the first tells as
    much). growth_rate : 1/s, of small motions about the one that a window has, NaN where it has neither."""

    alone: NDArray[np.float64]
    rub: NDArray[np.float64]
    moving: NDArray[np.float64]
    growth_rate: NDArray[np.float64]


@dataclass(frozen=True)
class Rolls:
    """The whirl predicted to roll next to the line of each window, (n_w,) each, NaN where there is none: frequency in Hz, |r| of
    rotor and stator at the contact in m, the rotor's line at its speed in m, growth rate in 1/s, and the share of a line's
    amplitude that is lost where it moves during the window."""

    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    stator_amplitude: NDArray[np.float64]
    synchronous: NDArray[np.float64]
    growth_rate: NDArray[np.float64]
    loss: NDArray[np.float64]


@dataclass(frozen=True)
class Followed:
    """A predicted whirl that a window follows: its branch, and the whirl (`rsc.Whirl`) at the window's speed."""

    branch: BranchLike
    whirl: Any


def branches_of(features: Features, branches: Sequence[BranchLike], i: int) -> list[BranchLike]:
    """The branches whose pressed set is that of window i; all with one contact."""
    if not features.sets:
        return list(branches)
    slides = features.kind[i] != Kind.ROLLING
    return [branch for branch in branches if slides and branch.pressed == features.sets[i]]


def nearest(branches: Sequence[BranchLike], speed: float, frequency: float) -> Followed | None:
    """The branch whose whirl at this speed is next to a frequency; None where none is near."""
    known = [Followed(b, b.at(speed)) for b in branches]
    known = [pair for pair in known if pair.whirl is not None]
    if not known or math.isnan(frequency):
        return None
    pair = min(known, key=lambda pair: abs(pair.whirl.frequency - frequency))
    return pair if abs(frequency / pair.whirl.frequency - 1.0) <= NEAR else None


def followed(features: Features, branches: Sequence[BranchLike], rolls: Rolls | None = None) -> list[Followed | None]:
    """The predicted whirl that each window follows by sliding; None where it follows none."""
    pairs: list[Followed | None] = []
    for i, (speed, line) in enumerate(zip(features.speed, features.frequency, strict=True)):
        rolls_there = features.kind[i] == Kind.ROLLING and rolls is not None and not math.isnan(rolls.frequency[i])
        off = rolls_there or features.too_fast(i) or not features.on_whirl(i)
        pairs.append(None if off else nearest(branches_of(features, branches, i), speed, line))
    return pairs


def same_branch(pairs: Sequence[Followed | None], i: int, k: int) -> bool:
    """Whether windows i and k follow one branch; False where there is no window k."""
    if not 0 <= k < len(pairs):
        return False
    a, b = pairs[i], pairs[k]
    return a is not None and b is not None and a.branch is b.branch
