"""The motions that the analysis predicts at a speed, as starts of simulations."""

import itertools
import math
import string
from collections.abc import Iterator
from dataclasses import replace
from math import tau as TWO_PI
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.balance.balance import balance
from rsc.analysis.balance.floquet import balance_growth
from rsc.analysis.balance.problem import NotBalanced
from rsc.analysis.follow.forward_rub import rub_growth
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.paper.states import states_of
from rsc.analysis.paper.synchronous import forward_rub, free_motion
from rsc.analysis.paper.watched import shape_deflections, shares, touched
from rsc.analysis.paper.whirls import whirl_shapes
from rsc.analysis.several.predict import predict_several
from rsc.measure.catalogue import Predicted
from rsc.simulation.run import InitialState
from rsc.system.system import System


class _Candidate(NamedTuple):
    """A prediction, and the state in which a run begins on it (at the shaft's angle 0)."""

    predicted: Predicted
    state: InitialState


def candidates(system: System, speed: float) -> list[_Candidate]:
    """What the analysis predicts at a speed, but for the motion without contact, which is hit."""
    Omega = TWO_PI * speed
    free = free_motion(system, Omega)
    candidates = []
    for rub in forward_rub(system, Omega):
        predicted = Predicted(
            "forward rub", speed, rub.amplitude, rub.normal_force, rub_growth(system, rub, Omega).rate, math.nan, True,
            _touched(system, rub.rotor_shape, rub.stator_shape),
        )  # fmt: skip
        candidates.append(_Candidate(predicted, _turning(system, rub.rotor_shape, rub.stator_shape, Omega)))
    letters = _letters()
    for whirl in predict_system(system, speed):
        predicted = Predicted(
            next(letters),
            whirl.frequency,
            whirl.rotor_amplitude,
            whirl.normal_force,
            whirl.growth_rate,
            _with_unbalance(system, whirl),
            "sliding" not in whirl.violated,
            whirl.touches,
        )
        state = _turning(system, whirl.rotor_shape, whirl.stator_shape, TWO_PI * whirl.frequency)
        candidates.append(_Candidate(predicted, _with_free(state, free, Omega)))
    for roll in rolling_whirls(system, Omega):
        sticking = system.with_friction(roll.traction)
        rotor, stator = whirl_shapes(sticking, np.array([roll.Psi]), np.array([roll.normal_force]), Omega)
        predicted = Predicted(
            "roll", roll.Psi / TWO_PI, roll.rotor_amplitude, roll.normal_force, roll.growth_rate, math.nan, True,
            _touched(system, rotor[0], stator[0]),
        )  # fmt: skip
        candidates.append(_Candidate(predicted, _with_free(_turning(system, rotor[0], stator[0], roll.Psi), free, Omega)))
    return candidates


def _letters() -> Iterator[str]:
    """The labels of whirls by rising frequency."""
    return itertools.chain(string.ascii_uppercase, (f"A{letter}" for letter in string.ascii_uppercase), itertools.repeat("?"))


def several_candidates(system: System, speed: float) -> list[_Candidate]:
    """The whirls at every pressed set of several contacts; neither forward rubs nor whirls that roll are predicted there."""
    Omega, candidates = TWO_PI * speed, []
    free = free_motion(system, Omega)
    for label, whirl in zip(_letters(), predict_several(system, speed), strict=False):
        forces = {name: at.normal_force for name, at in whirl.contacts.items()}
        predicted = Predicted(
            label, whirl.frequency, whirl.rotor_amplitude, whirl.normal_force, whirl.growth_rate, math.nan,
            "sliding" not in whirl.violated, whirl.touches, forces,
        )  # fmt: skip
        state = _turning(system, whirl.rotor_shape, whirl.stator_shape, TWO_PI * whirl.frequency)
        candidates.append(_Candidate(predicted, _with_free(state, free, Omega)))
    return candidates


def _touched(system: System, rotor: NDArray[np.complex128], stator: NDArray[np.complex128]) -> tuple[str, ...]:
    """The clearances that a motion with these shapes touches."""
    names: tuple[str, ...] = ()
    if system.clearances:
        names = touched(system, shares(system, shape_deflections(system, rotor, stator)))
    return names


def _with_unbalance(system: System, whirl: Any) -> float:
    """Growth rate of small motions about a whirl with its unbalance, 1/s; NaN where that is not known."""
    if not system.isotropic or system.rotor.load.any():
        return math.nan
    try:
        return float(balance_growth(system, balance(system, whirl.frequency, whirl.speed)).rate)
    except NotBalanced:
        return math.nan


def _turning(
    system: System, rotor: NDArray[np.complex128], stator: NDArray[np.complex128], Psi: float
) -> InitialState:
    """The state of a motion with these shapes that turns at Psi in rad/s."""
    states = states_of(system.joined(), Psi, np.concatenate([rotor, stator])) if system.n_states else None
    return InitialState(rotor, 1j * Psi * rotor, stator, 1j * Psi * stator, states=states)


def _with_free(state: InitialState, free: NDArray[np.complex128], Omega: float) -> InitialState:
    """A state with the motion that unbalance makes without contact added: its distance turns, and the contact only feels half."""
    return replace(state, rotor_velocity=state.rotor_velocity + 1j * Omega * free) if len(free) else state
