"""A run as it is seen at one of its contacts: forces and facts of that contact alone, and a scene without the others."""

from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.measure.stretches import side_by_side
from rsc.results.result_format import OF_CONTACT
from rsc.results.trajectory import Trajectory


def at_contact(result: Trajectory, i: int) -> Trajectory:
    """A run with several contacts as it is seen at that of number i, for whoever treats one; of one contact the run itself."""
    contacts = result.scene.contacts
    if len(contacts) == 1:
        return result
    source: Any = _AtContact(result.source, i, len(contacts))
    return Trajectory(replace(result.scene, contacts=(contacts[i],)), result.summary, source)


class _AtContact:
    """What a run is read from, of one of n contacts."""

    def __init__(self, source: Any, i: int, n: int) -> None:
        self._source, self._i, self._n = source, i, n

    def _own(self, values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {name: array[:, self._i] if name in OF_CONTACT else array for name, array in values.items()}

    def series(self, name: str) -> NDArray[np.float64]:
        """One array over time."""
        return self._own({name: self._source.series(name)})[name]

    def motion(self, name: str, column: int | None = None) -> NDArray[np.complex128]:
        """Complex displacements or velocities, all or one column."""
        return np.asarray(self._source.motion(name, column))

    def at_contact(self, columns: Mapping[str, int], rows: tuple[int, int]) -> dict[str, np.ndarray]:
        """Every array over time, and of `rotor` and `stator` one coordinate each, in some rows."""
        return self._own(self._source.at_contact(columns, rows))

    def block(self) -> Mapping[str, np.ndarray]:
        """All samples as one block."""
        return self._own(self._source.block())

    def facts(self) -> NDArray[np.float64]:
        """Facts of the stretches of the run at the contact."""
        return side_by_side(self._source.facts(), self._n)[self._i].rows

    def n_time(self) -> int:
        """Number of samples."""
        return int(self._source.n_time())

    def digest(self) -> str:
        """That of the whole run."""
        return str(self._source.digest())

    def kept_open(self) -> AbstractContextManager[None]:
        """As of the whole run."""
        kept: AbstractContextManager[None] = self._source.kept_open()
        return kept
