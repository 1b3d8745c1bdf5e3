"""`Trajectory`, what a run leaves behind, and its HDF5 file (netCDF-4 conventions: opens in xarray with units)."""

import enum
import os
from dataclasses import asdict, dataclass, field
from pathlib import Path

import h5py
import numpy as np

from rsc.errors import DataError
from rsc.scene import Scene

FORMAT = "rsc-result-1"
CHUNK_ROWS = 4096

# name -> (unit, description); complex displacements are stored with a last dimension (y, z)
SERIES = {
    "speed": ("Hz", "rotor speed"),
    "normal_force": ("N", "contact normal force F_N"),
    "friction_force": ("N", "contact friction force mu sigma F_N"),
    "tangential_velocity": ("m s-1", "tangential velocity of the contact deflection, without the rotor's own turning"),
}
DISPLACEMENTS = {"rotor": "rotor displacements", "stator": "stator displacements"}


class Status(enum.StrEnum):
    """How a run ended."""

    FINISHED = "finished"
    DIVERGED = "diverged"
    STEP_COLLAPSED = "step collapsed"
    NON_FINITE = "non-finite"
    TOO_MANY_STEPS = "too many steps"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class Ledger:
    """Energies of a run in J; residual = energy_in + friction_in - every dissipated part - change."""

    energy_in: float  # by unbalance, constant load and the turning contact ring
    friction_in: float  # fed by contact friction into the lateral motion (negative: taken out)
    rotor_damping: float  # dissipated
    stator_damping: float
    contact_damping: float
    change: float  # kinetic and elastic energy at the end minus at the start
    residual: float

    @property
    def turnover(self):
        """Sum of the magnitudes of all parts: the scale the residual is judged by."""
        parts = (self.energy_in, self.friction_in, self.rotor_damping, self.stator_damping, self.contact_damping)
        return sum(abs(p) for p in parts) + abs(self.change)


@dataclass(frozen=True)
class Summary:
    """How a run ended and what it took."""

    status: Status
    advice: str  # one sentence; empty for a finished run
    end_time: float  # s reached
    steps: int
    rejected: int
    rhs_calls: int
    switches: int  # contact switches that ended a step
    contact_onsets: int
    contact_releases: int
    contact_time: float  # s in contact
    ledger: Ledger
    versions: str


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
        with ResultWriter(path, self.scene) as writer:
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

    def append(self, block):
        """Add a block: name -> array, displacements complex."""
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


class ResultFile:
    """The samples of a run in its file, read when asked for."""

    def __init__(self, path):
        self.path = Path(path)

    def series(self, name):
        """One array over time."""
        with _reading(self.path) as file:
            return file[name][...]

    def displacement(self, name, column=None):
        """Complex displacements, all or one column."""
        with _reading(self.path) as file:
            if name not in file:  # a rigid stator has no coordinates to store
                return np.zeros((file["time"].shape[0], 0), dtype=complex)
            data = file[name]
            pairs = data[...] if column is None else data[:, column, :]
        return np.ascontiguousarray(pairs).view(complex)[..., 0]

    def block(self):
        """All samples as one block."""
        values = {name: self.series(name) for name in ("time", *SERIES)}
        return values | {name: self.displacement(name) for name in DISPLACEMENTS}


class ResultWriter:
    """Streams blocks into a new HDF5 file, which takes its name only when it is complete."""

    def __init__(self, path, scene):
        self.path = Path(path)
        self._part = self.path.with_name(self.path.name + ".part")
        try:
            self._file = h5py.File(self._part, "w")
        except OSError as error:
            raise DataError(path, f"cannot be written ({error.strerror or error})") from None
        self._file.attrs["format"] = FORMAT
        self._file.attrs["title"] = scene.title
        self._file.attrs["scene"] = scene.to_toml()

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if self._file:
            self._file.close()
            self._part.unlink(missing_ok=True)

    def append(self, block):
        """Append a block: name -> array, displacements complex."""
        try:
            for name, values in block.items():
                if name in DISPLACEMENTS:
                    if not values.shape[1]:
                        continue
                    values = values.view(float).reshape(*values.shape, 2)
                if name not in self._file:
                    self._create(name, values)
                data = self._file[name]
                rows = data.shape[0]
                data.resize(rows + values.shape[0], axis=0)
                data[rows:] = values
        except OSError as error:
            raise DataError(self.path, f"cannot be written ({error})") from None

    def _create(self, name, values):
        rest = values.shape[1:]
        data = self._file.create_dataset(
            name, (0, *rest), "f8", maxshape=(None, *rest), chunks=(CHUNK_ROWS, *rest), fletcher32=True
        )
        unit, text = SERIES.get(name, ("s", "time")) if name not in DISPLACEMENTS else ("m", DISPLACEMENTS[name])
        data.attrs["units"], data.attrs["long_name"] = unit, text

    def finish(self, summary):
        """Write the summary, close the file and give it its name."""
        try:
            self._dimensions()
            for key, value in asdict(summary).items():
                if key != "ledger":
                    self._file.attrs[key] = str(value) if isinstance(value, str) else value
            self._file.attrs["ledger"] = [float(v) for v in asdict(summary.ledger).values()]
            self._file.close()
            with open(self._part, "rb") as handle:
                os.fsync(handle.fileno())
            os.replace(self._part, self.path)
        except OSError as error:
            raise DataError(self.path, f"cannot be written ({error})") from None

    def _dimensions(self):
        """Name the axes as netCDF-4 readers expect."""
        file = self._file
        file["time"].make_scale("time")
        axis = file.create_dataset("axis", data=np.array(["y", "z"], dtype="S1"))
        axis.make_scale("axis")
        for name in SERIES:
            file[name].dims[0].attach_scale(file["time"])
        for name in DISPLACEMENTS:
            if name not in file:
                continue
            data = file[name]
            index = file.create_dataset(f"{name}_coordinate", data=np.arange(data.shape[1]))
            index.make_scale(f"{name}_coordinate")
            for i, scale in enumerate((file["time"], index, axis)):
                data.dims[i].attach_scale(scale)


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
    with _reading(path) as file:
        attrs = dict(file.attrs)
    if attrs.get("format") != FORMAT:
        raise DataError(path, f"is no result of this version (format {attrs.get('format')!r}, this rsc reads {FORMAT!r})")
    scene = Scene.from_dict(_toml(attrs["scene"]), source=f"{path} (stored scene)")
    plain = {k: attrs[k] for k in Summary.__dataclass_fields__ if k not in ("status", "ledger")}
    plain = {k: v.item() if isinstance(v, np.generic) else v for k, v in plain.items()}
    ledger = Ledger(*(float(v) for v in attrs["ledger"]))
    return Trajectory(scene, Summary(status=Status(attrs["status"]), ledger=ledger, **plain), ResultFile(path))


def _toml(text):
    import tomllib

    return tomllib.loads(text)


class _reading:
    """Open an HDF5 file for reading; every failure inside becomes a DataError."""

    def __init__(self, path):
        self._path = path

    def __enter__(self):
        try:
            self._file = h5py.File(self._path, "r")
        except FileNotFoundError:
            raise DataError(self._path, "does not exist") from None
        except OSError as error:
            raise DataError(self._path, f"cannot be read as HDF5 ({str(error).splitlines()[0]})") from None
        return self._file

    def __exit__(self, kind, error, trace):
        self._file.close()
        if kind is not None and issubclass(kind, (OSError, KeyError)):
            raise DataError(self._path, f"is damaged ({error})") from None
