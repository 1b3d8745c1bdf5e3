"""How fine a shaft is divided: until its lowest modes no more change."""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg

from rsc.errors import DataError
from rsc.machine.model.model import FiniteElementModel
from rsc.machine.shaft.assembly import MOST_NODES, model_of
from rsc.machine.shaft.parts import Section, Shaft

CHANGE = 1e-4  # of a natural frequency when every element is halved: fine enough
LEAST_MODES = 4  # that are looked at, whatever the band
_SHARE, _SHORTER = 0.25, 0.7  # of a wavelength: the longest element to begin with; how much shorter it becomes each time


class Divided(NamedTuple):
    """model; change: the largest relative one of its `modes` lowest natural frequencies, undamped and at rest, when every element
    is halved; nodes: their places in m."""

    model: FiniteElementModel
    nodes: tuple[float, ...]
    change: float
    modes: int

    @property
    def words(self) -> str:
        """What was done, for people."""
        return (
            f"{len(self.nodes) - 1} elements, {self.model.n} coordinates: with twice as many elements its {self.modes} lowest "
            f"natural frequencies change by at most {self.change:.1e}"
        )


def divided(shaft: Shaft, top: float, source: str, elements: int | None = None) -> Divided:
    """The model of a shaft whose elements are so short that halving all of them changes no natural frequency up to `top`, nor the
    lowest four, by more than `CHANGE`: the same share of a wavelength everywhere.

    Parameters
    ----------
    shaft : Shaft
    top : float
        Highest frequency of the band, Hz.
    source : str
        For messages.
    elements : int, optional
        So many between two stations each instead; the change is told all the same.

    Raises
    ------
    DataError
        Bearings that do not hold it, or more than `MOST_NODES` nodes.
    """
    waves = [piece.length / _wavelength(piece, top) for a, b in pairwise(shaft.stations) for piece in shaft.pieces(a, b)[:1]]
    share, before = _SHARE, None
    while True:
        numbers = [elements or max(1, int(np.ceil(wave / share))) for wave in waves]
        if numbers != before:
            nodes, finer = (_nodes(shaft, [times * number for number in numbers], source) for times in (1, 2))
            model = model_of(shaft, nodes, source)
            change, modes = _change(model, model_of(shaft, finer, source), top)
            if change <= CHANGE or elements is not None:
                return Divided(model, tuple(nodes), change, modes)
        share, before = _SHORTER * share, numbers


def _wavelength(piece: Section, top: float) -> float:
    """Of bending at a frequency in Hz, m; infinite without mass."""
    if not piece.material.density:
        return np.inf
    radius = 0.25 * np.hypot(max(piece.outer), min(piece.inner))  # of gyration
    return float(2.0 * np.pi * np.sqrt(radius / (2.0 * np.pi * top)) * (piece.material.young / piece.material.density) ** 0.25)


def _nodes(shaft: Shaft, numbers: list[int], source: str) -> list[float]:
    """Places of the nodes with so many elements between the stations."""
    if sum(numbers) >= MOST_NODES:
        raise DataError(source, f"needs more than {MOST_NODES} nodes for its band: narrow it, or give elements")
    pairs = zip(pairwise(shaft.stations), numbers, strict=True)
    return [float(place) for (a, b), number in pairs for place in np.linspace(a, b, number + 1)[:-1]] + [shaft.stations[-1]]


def _change(model: FiniteElementModel, fine: FiniteElementModel, top: float) -> tuple[float, int]:
    """Largest relative change of the natural frequencies up to `top` in Hz, at least `LEAST_MODES`, and how many they are."""
    own, other = (natural_frequencies(each) for each in (model, fine))
    count = min(max(LEAST_MODES, int(np.sum(other <= top))), len(own), len(other))
    return float(np.max(np.abs(other[:count] / own[:count] - 1.0), initial=0.0)), count


def natural_frequencies(model: FiniteElementModel) -> Any:
    """Undamped natural frequencies at rest in Hz, rising, with the mean stiffness of both directions."""
    compliance = scipy.linalg.eigh(model.mass, model.stiffness, eigvals_only=True)[::-1]
    return 1.0 / (2.0 * np.pi * np.sqrt(compliance[compliance > 1e-14 * compliance[0]]))
