"""Shapes of the modes of a rotor along its axis: the ellipse of every node, and which way it is run through."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.free_vibration import FreeVibration
from rsc.presented import Brief

_CIRCLE = 1e-9  # of the larger circle: a smaller other one is rounding


@dataclass(frozen=True, eq=False, repr=False)
class ModeShape(Brief):
    """Motion of the nodes of a rotor in one mode, without its decay: r = positive e^{i phi} + negative e^{-i phi}, phi = 2 pi
    |frequency| t.

    position : (n,) m, from the left end of the shaft
    positive, negative : (n,) complex, the circles run through from y to z, and against it; scaled so that the largest distance of
        a node is 1, which it has at phi = 0 with y + z >= 0
    """

    position: NDArray[np.float64]
    positive: NDArray[np.complex128]
    negative: NDArray[np.complex128]

    @property
    def is_positive(self) -> NDArray[np.bool_]:
        """(n,) whether a node runs from y to z: forward if the rotor turns so."""
        return np.abs(self.positive) >= np.abs(self.negative)

    @property
    def size(self) -> NDArray[np.float64]:
        """(n,) largest distance of every node, the long half axis of its ellipse."""
        return np.abs(self.positive) + np.abs(self.negative)

    def at(self, phi: float) -> NDArray[np.complex128]:
        """(n,) r at an angle phi in rad."""
        return self.positive * np.exp(1j * phi) + self.negative * np.exp(-1j * phi)


def shape_of(vibration: FreeVibration, position: NDArray[np.float64], rows: NDArray[np.float64]) -> ModeShape:
    """The shape of a free vibration at nodes.

    position : (n,) m; rows : (n, N), displacement of every node by the N coordinates
    """
    parts = rows @ vibration.shape, rows @ vibration.mirror_shape
    positive, negative = parts if vibration.frequency >= 0.0 else parts[::-1]
    lead = int(np.argmax(np.abs(positive) + np.abs(negative)))
    one, other = complex(positive[lead]), complex(negative[lead])
    if min(abs(one), abs(other)) <= _CIRCLE * max(abs(one), abs(other)):
        phi = 0.5 * np.pi - np.angle(one) if abs(one) > abs(other) else np.angle(other) - 0.5 * np.pi
    else:
        phi = 0.5 * (np.angle(other) - np.angle(one))
    at_first = one * np.exp(1j * phi) + other * np.exp(-1j * phi)
    if at_first.real + at_first.imag < 0.0:
        phi += np.pi
    largest = (abs(one) + abs(other)) or 1.0
    return ModeShape(position, positive * np.exp(1j * phi) / largest, negative * np.exp(-1j * phi) / largest)
