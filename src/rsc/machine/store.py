"""A `Model` in a file beside a scene: one .npz, for which none of the programs is needed that the model came from."""

import hashlib
import io
import json
import os
from typing import Any

import numpy as np
import scipy.sparse

from rsc.errors import DataError, one_line
from rsc.files.content import content_of
from rsc.files.output import ZIP, put
from rsc.machine.formats.entries import MOST_BYTES
from rsc.machine.formats.npz import arrays_of
from rsc.machine.model import DISPLACEMENT, DOUBLE, OTHER, TILT, Model

FORMAT = "rsc model 1"
_REAL = ("mass", "damping", "gyroscopic", "stiffness", "skew_damping", "skew_stiffness")
_COMPLEX = ("anisotropic_mass", "anisotropic_damping", "anisotropic_stiffness")
_TABLES = ("names", "position", "diameter")


def save_model(model: Model, path: str | os.PathLike[str]) -> str:
    """Write a model; returns the SHA-256 of the file as text.

    Raises
    ------
    DataError
        The file cannot be written.
    """
    about = {"format": FORMAT, "source": model.source, "kind": model.kind.tolist(), "notes": model.notes, "speed": model.speed}
    about |= {"rounding": model.rounding, "free": model.free}
    about |= {name: list(getattr(model, name).items()) for name in _TABLES}
    arrays: dict[str, Any] = {"about": np.frombuffer(json.dumps(about).encode(), dtype=np.uint8), "node": model.node}
    for name in _REAL:
        arrays |= _stored(name, getattr(model, name))
    for name in _COMPLEX:
        matrix = getattr(model, name)
        arrays |= {} if matrix is None else _stored(f"{name}.real", matrix.real) | _stored(f"{name}.imag", matrix.imag)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    put(path, buffer.getvalue(), ZIP)
    return hashlib.sha256(buffer.getvalue()).hexdigest()


def _stored(name: str, matrix: Any) -> dict[str, Any]:
    if matrix is None:
        return {}
    if not scipy.sparse.issparse(matrix):
        return {name: matrix}
    matrix = matrix.tocsc()
    return {f"{name}.{part}": getattr(matrix, part) for part in ("data", "indices", "indptr")}


def load_model(path: str | os.PathLike[str]) -> tuple[Model, str]:
    """Read a model that `save_model` wrote; returns it with the SHA-256 of the file.

    Raises
    ------
    DataError
        No such file, or not of this kind.
    """
    name = one_line(path)
    content = content_of(path, MOST_BYTES)
    try:
        arrays = arrays_of(content)
        about = json.loads(arrays["about"].tobytes().decode())
        if about["format"] != FORMAT:
            raise ValueError("another format")
        n = len(arrays["node"])
        if arrays["node"].shape != (n,) or len(about["kind"]) != n or not set(about["kind"]) <= {DISPLACEMENT, TILT, OTHER}:
            raise ValueError("its parts do not fit")
        matrices = {name: _read(arrays, name, n) for name in _REAL}
        for key in _COMPLEX:
            real, imag = (_read(arrays, f"{key}.{part}", n) for part in ("real", "imag"))
            matrices[key] = None if real is None or imag is None else real + 1j * imag
        model = Model(
            source=str(about["source"]),
            node=arrays["node"].astype(np.int64),
            kind=np.array(about["kind"], dtype=str),
            rounding=float(about.get("rounding", DOUBLE)),  # files of older versions have neither
            free=bool(about.get("free", False)),
            speed=None if about["speed"] is None else float(about["speed"]),
            names={str(key): int(value) for key, value in about["names"]},
            position={int(key): float(value) for key, value in about["position"]},
            diameter={int(key): float(value) for key, value in about["diameter"]},
            notes=tuple(map(str, about["notes"])),
            **matrices,
        )
        if any(matrices[key] is None for key in _REAL[:4]):
            raise ValueError("its parts do not fit")
    except Exception as error:  # a damaged or forged archive fails in any way
        raise DataError(name, f"no model written by `rsc import` ({type(error).__name__})") from None
    return model, hashlib.sha256(content).hexdigest()


def _read(arrays: dict[str, Any], name: str, n: int) -> Any:
    if name in arrays:
        matrix = arrays[name].astype(float)
        if matrix.shape != (n, n) or not np.isfinite(matrix).all():
            raise ValueError(name)
        return matrix
    parts = tuple(arrays.get(f"{name}.{part}") for part in ("data", "indices", "indptr"))
    if any(part is None for part in parts):
        return None
    matrix = scipy.sparse.csc_array(parts, shape=(n, n))
    matrix.check_format(full_check=True)
    if not np.isfinite(matrix.data).all():
        raise ValueError(name)
    return matrix
