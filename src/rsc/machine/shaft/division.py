"""Discretisation of a shaft: refined until its lowest natural frequencies converge."""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg

from rsc.errors import DataError
from rsc.machine.model.model import FiniteElementModel
from rsc.machine.reduction.shift import LEAST, SHIFTED
from rsc.machine.shaft.assembly import MOST_NODES, model_of
from rsc.machine.shaft.parts import Section, Shaft

CHANGE = 1e-4  # allowed relative change of a natural frequency when every element is halved
LEAST_MODES = 4  # modes compared at least, whatever the band
# longest element at first, as a fraction of the wavelength; factor by which it is shortened each time
_SHARE, _SHORTER = 0.25, 0.7


class TooManyNodes(DataError):
    """A shaft that needs more than `MOST_NODES` nodes for its band."""


class Divided(NamedTuple):
    """model; nodes: their positions in m; change: largest relative change of its `modes` lowest natural frequencies, undamped
    and at rest, when every element is halved."""

    model: FiniteElementModel
    nodes: tuple[float, ...]
    change: float
    modes: int

    @property
    def words(self) -> str:
        """Description of the discretisation for users."""
        return (
            f"{len(self.nodes) - 1} elements, {self.model.n} coordinates: with twice as many elements its {self.modes} lowest "
            f"natural frequencies change by at most {self.change:.1e}"
        )


def divided(shaft: Shaft, top: float, source: str, elements: int | None = None) -> Divided:
    """The model of a shaft with elements so short that halving them changes no natural frequency up to `top`, nor the lowest
    four, by more than `CHANGE`; elements have the same length relative to the wavelength everywhere.

    Parameters
    ----------
    shaft : Shaft
    top : float
        Highest frequency of the band, Hz.
    source : str
        For messages.
    elements : int, optional
        Fixed number of elements between neighbouring stations instead; the change is still reported.

    Raises
    ------
    TooManyNodes
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
    """Wavelength of bending at a frequency in Hz, m; infinite without mass."""
    if not piece.material.density:
        return np.inf
    radius = 0.25 * np.hypot(max(piece.outer), min(piece.inner))  # radius of gyration
    return float(2.0 * np.pi * np.sqrt(radius / (2.0 * np.pi * top)) * (piece.material.young / piece.material.density) ** 0.25)


def _nodes(shaft: Shaft, numbers: list[int], source: str) -> list[float]:
    """Positions of the nodes for given numbers of elements between stations."""
    if sum(numbers) >= MOST_NODES:
        raise TooManyNodes(source, f"needs more than {MOST_NODES} nodes for its band")
    pairs = zip(pairwise(shaft.stations), numbers, strict=True)
    return [float(place) for (a, b), number in pairs for place in np.linspace(a, b, number + 1)[:-1]] + [shaft.stations[-1]]


def _change(model: FiniteElementModel, fine: FiniteElementModel, top: float) -> tuple[float, int]:
    """Largest relative change of the natural frequencies up to `top` in Hz, at least `LEAST_MODES`, and their number."""
    coarse, other = (natural_frequencies(each, top) for each in (model, fine))
    count = min(max(LEAST_MODES, int(np.sum(other <= top))), len(coarse), len(other))
    return float(np.max(np.abs(other[:count] / coarse[:count] - 1.0), initial=0.0)), count


def natural_frequencies(model: FiniteElementModel, top: float = 0.0) -> Any:
    """Undamped natural frequencies at rest in Hz, increasing, with the mean stiffness of both directions; of a free model those
    that are not far below `top` in Hz."""
    shift = (SHIFTED * 2.0 * np.pi * top) ** 2 if model.free else 0.0
    stiffness = model.stiffness + shift * model.mass if shift else model.stiffness
    compliance = scipy.linalg.eigh(model.mass, stiffness, eigvals_only=True)[::-1]
    if not shift:
        return 1.0 / (2.0 * np.pi * np.sqrt(compliance[compliance > 1e-14 * compliance[0]]))
    squares = 1.0 / compliance[compliance > 1e-14 * compliance[0]] - shift
    return np.sqrt(squares[squares > (LEAST * 2.0 * np.pi * top) ** 2]) / (2.0 * np.pi)
