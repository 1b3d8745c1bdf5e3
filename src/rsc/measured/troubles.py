"""Checks of measured signals, reported as warnings."""

import numpy as np
from numpy.typing import NDArray

_CLIPPED = 10, 5.0  # samples at an extreme, and how many times as many as at the value next to it
EXCHANGED = "the line at the rotor speed turns backward: are the probes exchanged, or is the sense of rotation the other one?"
_BACKWARD = 1.5  # of the forward line at the rotor speed, from which its backward one is told
_STEADY = 0.5  # least part of the line that goes on from block to block in the frame of the shaft
_SEEN = 0.01  # of the root mean square of the deflection, from which there is a line at all
_BLOCK_TURNS = 20.0
LEAST_IN_BLOCK = 40  # samples


def clipped(name: str, signal: NDArray[np.float64]) -> list[str]:
    """A line for a signal whose extremes are flat.

    At the top of an oscillation that is only rounded the largest value occurs little more often than the one below it; at a stop
    it occurs many times as often.
    """
    told = []
    known = signal[np.isfinite(signal)]
    for word, values in (("above", known), ("below", -known)):
        if not values.size or values.min() == values.max():
            continue
        top = values.max()
        at_top, beside = np.count_nonzero(values == top), np.count_nonzero(values == values[values < top].max())
        if at_top >= max(_CLIPPED[0], _CLIPPED[1] * beside):
            share = 100.0 * at_top / len(signal)
            told.append(f"{name} is clipped {word}, in {share:.2g} % of the samples: amplitudes are too small")
    return told


def turned_backwards(deflection: NDArray[np.complex128], turns: NDArray[np.float64]) -> list[str]:
    """A line where the motion at the rotor speed turns against the shaft: nothing but exchanged probes or a wrong sense does that
    over a whole run (unequal supports do it between two of their critical speeds)."""
    known = np.isfinite(deflection)
    if not known.any():
        return []
    blocks = (turns[known] - turns[known].min()) / _BLOCK_TURNS
    block, weight = blocks.astype(int), 1.0 - np.cos(2.0 * np.pi * blocks)  # Hann's, so that whirls beside the line do not count
    turn, r = np.exp(-2j * np.pi * turns[known]), deflection[known]
    lines = [_means(r * each, block, weight) for each in (turn, turn.conj())]
    forward, backward = (np.median(np.abs(line)) for line in lines)
    if backward <= max(_BACKWARD * forward, _SEEN * float(np.sqrt(np.mean(np.abs(r) ** 2)))):
        return []
    steps = lines[1][1:] * lines[1][:-1].conj()
    if steps.sum().real < _STEADY * np.abs(steps).sum():  # a backward whirl that is beside the rotor speed for a while
        return []
    return [EXCHANGED]


def _means(values: NDArray[np.complex128], block: NDArray[np.intp], weight: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Weighted means of the values in each block that has more than a few."""
    whole = np.bincount(block) >= LEAST_IN_BLOCK
    sums = np.bincount(block, weight * values.real) + 1j * np.bincount(block, weight * values.imag)
    return np.asarray((sums / np.maximum(np.bincount(block, weight), 1e-9))[whole])
