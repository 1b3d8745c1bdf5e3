"""Labelled arrays, the result of a sweep: dimensions, coordinates, variables with units; to and from a netCDF-4 file."""

import io
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, SolverError
from rsc.files import gate
from rsc.files.content import content_of, opened
from rsc.files.mark import HDF5
from rsc.files.output import put
from rsc.results.result_format import Guard
from rsc.results.result_format import put as put_attributes

if TYPE_CHECKING:
    import xarray

FORMAT, READ = "rsc-sweep-dataset-4", ("rsc-sweep-dataset-2", "rsc-sweep-dataset-3", "rsc-sweep-dataset-4")
LARGEST_FILE = 4 * 2**30  # bytes
MOST_NAMES = 1000  # of arrays: every varied key has one
_HEAD = ("title", "computed", "source", "scene", "versions", "axes")
Variable = tuple[tuple[str, ...], NDArray[Any], dict[str, str]]  # dimensions, values, attributes


@dataclass(frozen=True, eq=False)
class Labelled:
    """Arrays over named dimensions.

    dims : dict, name -> length
    coordinates, variables : dict, name -> (dimensions, values, attributes with units and long_name); flags are bool, texts str or
        bytes in UTF-8, which take a quarter of the memory
    attributes : dict of str
    """

    dims: dict[str, int]
    coordinates: dict[str, Variable]
    variables: dict[str, Variable]
    attributes: dict[str, str]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """The values of a variable or coordinate."""
        return as_str((self.variables.get(name) or self.coordinates[name])[1])

    def __contains__(self, name: str) -> bool:
        return name in self.variables or name in self.coordinates

    def to_xarray(self) -> "xarray.Dataset":
        """The same as an xarray.Dataset."""
        refuse_without_xarray()
        import xarray

        variables = {name: (dims, as_str(values), own) for name, (dims, values, own) in self.variables.items()}
        return xarray.Dataset(variables, self.coordinates, self.attributes)

    def save(self, path: str | os.PathLike[str], overwrite: bool = False) -> None:
        """Write a netCDF-4 file, whole or not at all.

        overwrite : bool, also in the place of a file that rsc did not write, or that was changed since

        Raises
        ------
        DataError
            It cannot be written, or such a file has this name.
        """
        image = io.BytesIO()
        with h5py.File(image, "w") as file:
            self._write(file)
        put(path, image.getbuffer(), HDF5, overwrite)

    def _write(self, file: h5py.File) -> None:
        numbered = (pair for pair in self.dims.items() if pair[0] not in self.coordinates)
        axes: dict[str, Variable] = {name: ((name,), np.arange(n), {}) for name, n in numbered}
        every = {**axes, **self.coordinates, **self.variables}
        for name, (_, values, own) in every.items():
            if values.dtype.kind in "US":
                encoded = values if values.dtype.kind == "S" else np.strings.encode(values, "utf-8")
                data = file.create_dataset(name, data=encoded.view(h5py.string_dtype("utf-8", encoded.itemsize)))
                own = own | {"_Encoding": "utf-8"}
            elif values.dtype.kind == "b":
                data = file.create_dataset(name, data=values.view("i1"))
                own = own | {"dtype": "bool"}  # as xarray writes flags
            else:
                data = file.create_dataset(name, data=values)
            put_attributes(data.attrs, own)
            if name in self.dims:
                data.make_scale(name)
        for name, (dims, _, _) in every.items():
            if name not in self.dims:
                for i, dim in enumerate(dims):
                    file[name].dims[i].attach_scale(file[dim])
        shared = [name for name in self.coordinates if name not in self.dims]
        head = self.attributes | {"format": FORMAT} | ({"coordinates": " ".join(shared)} if shared else {})
        put_attributes(file.attrs, head)


def of_xarray(data: "xarray.Dataset") -> Labelled:
    """The arrays of a dataset that `to_xarray` made, also after a file of it, or of a part of it."""
    def variables(own: Any) -> dict[str, Variable]:
        return {str(name): (each.dims, _plain(each.values), each.attrs) for name, each in own.items()}

    dims = {str(name): int(length) for name, length in data.sizes.items()}
    return Labelled(dims, variables(data.coords), variables(data.data_vars), dict(data.attrs))


def _plain(values: NDArray[Any]) -> NDArray[Any]:
    """Texts, which xarray reads from a file as objects, as an array of text."""
    return values.astype(str) if values.dtype.kind == "O" else values


def as_str(values: NDArray[Any]) -> NDArray[Any]:
    """Texts as str; other arrays as they are."""
    return np.strings.decode(values, "utf-8", "replace") if values.dtype.kind == "S" else values


def refuse_without_xarray() -> None:
    """SolverError where xarray is not installed."""
    try:
        import xarray  # noqa: F401
    except ImportError:
        raise SolverError("a labelled dataset needs xarray: pip install \"rotor-stator-contact[sweep]\"") from None


def is_labelled(path: str | os.PathLike[str]) -> bool:
    """Whether a file holds the labelled arrays of a sweep, of whatever version; no more of it is read than that needs, for it may
    be a long run."""
    try:
        with Guard(path, "cannot be read"), opened(path, LARGEST_FILE) as stream, h5py.File(stream, "r") as file:
            return gate.text_of(file, "format") in READ or "computed" in file.attrs
    except DataError:
        return False


def load_labelled(
    path: str | os.PathLike[str], table: Callable[[Mapping[str, str]], Mapping[str, gate.Array]]
) -> tuple[dict[str, str], dict[str, int], dict[str, NDArray[Any]]]:
    """Read labelled arrays.

    Parameters
    ----------
    path : str or path
    table : callable, what the gate lets pass of a file with this head, "format" among it

    Returns
    -------
    (dict, dict, dict)
        The head, the length of every dimension, and name -> array, texts as bytes.

    Raises
    ------
    DataError
        The file is missing, damaged, of another version or holds anything else.
    """
    problem = "cannot be read as the result of a sweep"
    content = content_of(path, LARGEST_FILE)
    with Guard(path, problem), gate.image(content) as file:
        if gate.text_of(file, "format") not in READ:
            raise DataError(path, "holds no result of a sweep of this version (`rsc sweep collect` of its store writes one)")
        known = dict.fromkeys((*_HEAD, "format", "coordinates"), ())
        head = {name: str(value) for name, value in gate.attributes(file, known, gate.LONGEST_SCENE, ("coordinates",)).items()}
        gate.refuse_unprintable("its head", *(head[name] for name in ("source", "versions", "computed", "axes")))
        wanted = table(head)
        lengths = gate.look_at(file, wanted, len(content), most=MOST_NAMES)
        return head, lengths, {name: gate.read(file, name) for name in wanted}
