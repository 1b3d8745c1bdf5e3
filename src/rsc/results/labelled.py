"""Labelled arrays, the result of a sweep: dimensions, coordinates, variables with units; to and from a netCDF-4 file."""

import io
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, SolverError
from rsc.files.content import opened
from rsc.files.output import HDF5, put
from rsc.results.result_format import Guard
from rsc.results.sweep_store import LARGEST_FILE

if TYPE_CHECKING:
    import xarray

FORMAT = "rsc-sweep-dataset-1"
Variable = tuple[tuple[str, ...], NDArray[Any], dict[str, str]]  # dimensions, values, attributes


@dataclass(frozen=True, eq=False)
class Labelled:
    """Arrays over named dimensions.

    dims : dict, name -> length
    coordinates, variables : dict, name -> (dimensions, values, attributes with units and long_name); texts are str, flags bool
    attributes : dict of str
    """

    dims: dict[str, int]
    coordinates: dict[str, Variable]
    variables: dict[str, Variable]
    attributes: dict[str, str]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """The values of a variable or coordinate."""
        return (self.variables.get(name) or self.coordinates[name])[1]

    def __contains__(self, name: str) -> bool:
        return name in self.variables or name in self.coordinates

    def to_xarray(self) -> "xarray.Dataset":
        """The same as an xarray.Dataset."""
        refuse_without_xarray()
        import xarray

        return xarray.Dataset(self.variables, self.coordinates, self.attributes)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a netCDF-4 file, whole or not at all.

        Raises
        ------
        DataError
            It cannot be written, or something else has this name.
        """
        image = io.BytesIO()
        with h5py.File(image, "w") as file:
            self._write(file)
        put(path, image.getvalue(), HDF5)

    def _write(self, file: h5py.File) -> None:
        text = h5py.string_dtype()
        numbered = (pair for pair in self.dims.items() if pair[0] not in self.coordinates)
        axes: dict[str, Variable] = {name: ((name,), np.arange(n), {}) for name, n in numbered}
        every = {**axes, **self.coordinates, **self.variables}
        for name, (_, values, own) in every.items():
            if values.dtype.kind == "U":
                data = file.create_dataset(name, data=values.astype(object), dtype=text)
            elif values.dtype.kind == "b":
                data = file.create_dataset(name, data=values.astype("i1"))
                data.attrs["dtype"] = "bool"  # as xarray writes flags
            else:
                data = file.create_dataset(name, data=values)
            data.attrs.update(own)
            if name in self.dims:
                data.make_scale(name)
        for name, (dims, _, _) in every.items():
            if name not in self.dims:
                for i, dim in enumerate(dims):
                    file[name].dims[i].attach_scale(file[dim])
        shared = [name for name in self.coordinates if name not in self.dims]
        file.attrs.update(self.attributes | {"format": FORMAT} | ({"coordinates": " ".join(shared)} if shared else {}))


def refuse_without_xarray() -> None:
    """SolverError where xarray is not installed."""
    try:
        import xarray  # noqa: F401
    except ImportError:
        raise SolverError("a labelled dataset needs xarray: pip install \"rsc[sweep]\"") from None


def is_labelled(path: str | os.PathLike[str]) -> bool:
    """Whether a file holds the labelled arrays of a sweep; no more of it is read than that needs, for it may be a long run."""
    try:
        with Guard(path, "cannot be read"), opened(path, LARGEST_FILE) as stream, h5py.File(stream, "r") as file:
            return str(file.attrs.get("format", "")) == FORMAT
    except DataError:
        return False


def load_labelled(path: str | os.PathLike[str]) -> Labelled:
    """Read labelled arrays.

    Raises
    ------
    DataError
        The file is missing, damaged or holds none.
    """
    with _opened(path) as file:
        if str(file.attrs.get("format", "")) != FORMAT:
            raise DataError(path, "holds no result of a sweep of this version")
        shared = str(file.attrs.get("coordinates", "")).split()
        dims = {name: int(file[name].shape[0]) for name in file if file[name].is_scale}
        coordinates: dict[str, Variable] = {}
        variables: dict[str, Variable] = {}
        for name in file:
            data = file[name]
            own = {key: str(value) for key, value in data.attrs.items() if key in ("units", "long_name", "flags")}
            values = data.asstr()[()] if h5py.check_string_dtype(data.dtype) else data[()]
            if data.attrs.get("dtype") == "bool":
                values = values.astype(bool)
            values = np.asarray(values, dtype=str) if values.dtype == object else values
            names = (name,) if name in dims else tuple(_dimension(axis) for axis in data.dims)
            if name in dims and not own:  # numbers of what has no values of its own
                continue
            (coordinates if name in dims or name in shared else variables)[name] = (names, values, own)
        attributes = {key: str(value) for key, value in file.attrs.items() if key not in ("format", "coordinates")}
    return Labelled(_ordered(dims, variables), coordinates, variables, attributes)


def _dimension(axis: Any) -> str:
    return str(axis[0].name).lstrip("/")


def _ordered(dims: Mapping[str, int], variables: Mapping[str, Variable]) -> dict[str, int]:
    """Dimensions in the order of the variable that has most."""
    longest = max((names for names, _, _ in variables.values()), key=len, default=())
    return {name: dims[name] for name in (*longest, *(name for name in dims if name not in longest))}


class _opened(Guard):
    """A netCDF-4 file open for reading, from memory; failures become a DataError."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        super().__init__(path, "cannot be read as the result of a sweep")
        self._file: h5py.File | None = None

    def __enter__(self) -> h5py.File:
        with opened(self._path, LARGEST_FILE) as stream:
            content = stream.read()
        with Guard(self._path, self._problem):
            self._file = h5py.File(io.BytesIO(content), "r")
        return self._file

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        if self._file is not None:
            self._file.close()
        super().__exit__(kind, error, trace)
