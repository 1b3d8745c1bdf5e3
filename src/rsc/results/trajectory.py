"""`Trajectory`, the result of a run: uniformly sampled motion, how it ended, and where its samples are."""

from dataclasses import dataclass, field

import numpy as np

from rsc.results.result_file import ResultFile, ResultWriter, read_summary
from rsc.results.result_format import DISPLACEMENTS, SERIES
from rsc.results.summary import Summary
from rsc.scene.scene import Scene


@dataclass(frozen=True)
class Trajectory:
    """A run: uniformly sampled motion, status, counters and energy ledger. Arrays are read when first asked for."""

    scene: Scene
    summary: Summary
    source: object = field(repr=False)  # MemoryBlocks or ResultFile

    time = property(lambda self: self.source.series("time"), doc="(n_time,) s")
    speed = property(lambda self: self.source.series("speed"), doc="(n_time,) Hz, rotor speed")
    rotor = property(lambda self: self.source.displacement("rotor"), doc="(n_time, n_rotor) complex m")
    stator = property(lambda self: self.source.displacement("stator"), doc="(n_time, n_stator) complex m")
    normal_force = property(lambda self: self.source.series("normal_force"), doc="(n_time,) N")
    friction_force = property(lambda self: self.source.series("friction_force"), doc="(n_time,) N, mu sigma F_N")
    tangential_velocity = property(
        lambda self: self.source.series("tangential_velocity"),
        doc="(n_time,) m/s, Im(d' conj d)/|d|; the slip velocity is this plus Omega d_R/2",
    )
    status = property(lambda self: self.summary.status)
    steps = property(lambda self: self.summary.steps)
    rejected = property(lambda self: self.summary.rejected)
    rhs_calls = property(lambda self: self.summary.rhs_calls)
    contact_onsets = property(lambda self: self.summary.contact_onsets)
    contact_releases = property(lambda self: self.summary.contact_releases)
    ledger = property(lambda self: self.summary.ledger)

    def contact_rotor(self):
        """(n_time,) complex m: rotor displacement at the contacting coordinate, without reading the others."""
        return self.source.displacement("rotor", self.scene.contact.rotor_coordinate)

    def contact_stator(self):
        """(n_time,) complex m: stator displacement at the contact; zeros for a rigid stator."""
        if self.scene.stator.model == "rigid":
            return np.zeros(self.time.shape, dtype=complex)
        return self.source.displacement("stator", self.scene.contact.stator_coordinate)

    def save(self, path):
        """Write the run to one HDF5 file; DataError when that is impossible."""
        with ResultWriter(path, self.scene, self.summary.versions) as writer:
            writer.append(self.source.block())
            writer.finish(self.summary)

    def to_xarray(self):
        """The run as an xarray.Dataset with units (needs xarray)."""
        import xarray

        dims = {"rotor": "rotor_coordinate", "stator": "stator_coordinate"}
        values = {n: ("time", getattr(self, n), {"units": u, "long_name": d}) for n, (u, d) in SERIES.items()}
        for name, text in DISPLACEMENTS.items():
            values[name] = (("time", dims[name]), getattr(self, name), {"units": "m", "long_name": text})
        return xarray.Dataset(values, {"time": ("time", self.time, {"units": "s"})}, {"title": self.scene.title})


class MemoryBlocks:
    """The samples of a run kept in memory, block by block."""

    def __init__(self):
        self._blocks = []

    def append(self, block, checkpoint=None):
        """Add a block: name -> array, displacements complex; a run in memory needs no checkpoint."""
        self._blocks.append(block)

    def block(self):
        """All samples as one block."""
        if len(self._blocks) != 1:
            names = self._blocks[0]
            self._blocks = [{name: np.concatenate([b[name] for b in self._blocks]) for name in names}]
        return self._blocks[0]

    def series(self, name):
        """One array over time."""
        return self.block()[name]

    def displacement(self, name, column=None):
        """Complex displacements, all or one column."""
        values = self.block()[name]
        return values if column is None else values[:, column]


def load(path):
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
    """
    summary = read_summary(path)
    source = ResultFile(path)
    return Trajectory(source.scene(), summary, source)
