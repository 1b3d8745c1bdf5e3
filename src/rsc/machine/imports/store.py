"""A `FiniteElementModel` in an .npz file next to a scene; the program that the model came from is not needed to read it."""

import hashlib
import io
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse

from rsc.errors import DataError, one_line
from rsc.files.content import content_of
from rsc.files.mark import ZIP
from rsc.files.memory import Memory
from rsc.files.output import OutputFile, put_all
from rsc.machine.formats.entries import MOST_BYTES
from rsc.machine.formats.npz import arrays_of
from rsc.machine.model.following import MOST_KNOTS
from rsc.machine.model.model import DISPLACEMENT, DOUBLE, OTHER, TILT, FiniteElementModel
from rsc.system.knots import ANISOTROPIC, FOLLOWING, Knots

FORMATS = ("rsc model 1", "rsc model 2")  # the second: with coefficients that follow the rotor speed, which older versions refuse
_REAL = ("mass", "damping", "gyroscopic", "stiffness", "skew_damping", "skew_stiffness", "rotating_damping")
_COMPLEX = ("anisotropic_mass", "anisotropic_damping", "anisotropic_stiffness")
_TABLES = ("names", "position", "diameter")


def save_model(model: FiniteElementModel, path: str | os.PathLike[str]) -> str:
    """Write a model; returns the SHA-256 of the file as text. DataError when it cannot be written."""
    output, digest = stored(model, path)
    put_all([output])
    return digest


def stored(model: FiniteElementModel, path: str | os.PathLike[str]) -> tuple[OutputFile, str]:
    """(file of a model, to be written by `rsc.files.output.put_all`, SHA-256 of that file as text)."""
    follows = model.knots is not None or model.rotating_damping is not None
    about = {"format": FORMATS[follows], "source": model.source, "kind": model.kind.tolist(), "notes": model.notes}
    about |= {"speed": model.speed, "rounding": model.rounding, "free": model.free}
    about |= {name: list(getattr(model, name).items()) for name in _TABLES}
    arrays: dict[str, Any] = {"about": np.frombuffer(json.dumps(about).encode(), dtype=np.uint8), "node": model.node}
    for name in (*_REAL, *_COMPLEX):
        arrays |= _stored(name, getattr(model, name))
    if model.knots is not None:
        arrays["knots"] = model.knots.speed
        for name, part in model.knots.parts.items():  # those of all knots, one below the other
            arrays |= _stored(f"knots.{name}", scipy.sparse.vstack(part) if model.is_sparse else part.reshape(-1, model.n))
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    output = OutputFile(Path(path), buffer.getvalue(), ZIP)
    return output, hashlib.sha256(ZIP.marked(output.content)).hexdigest()


def _stored(name: str, matrix: Any) -> dict[str, Any]:
    if matrix is None:
        return {}
    if np.iscomplexobj(matrix):
        return _stored(f"{name}.real", matrix.real) | _stored(f"{name}.imag", matrix.imag)
    if not scipy.sparse.issparse(matrix):
        return {name: matrix}
    matrix = matrix.tocsc()
    return {f"{name}.{part}": getattr(matrix, part) for part in ("data", "indices", "indptr")}


def load_model(path: str | os.PathLike[str]) -> tuple[FiniteElementModel, str]:
    """Read a model that `save_model` wrote; returns it with the SHA-256 of the file.

    Raises
    ------
    DataError
        No such file, or not of this kind.
    """
    name = one_line(path)
    content = content_of(path, MOST_BYTES)
    try:
        arrays = arrays_of(content, Memory(MOST_BYTES))
        about = json.loads(arrays["about"].tobytes().decode())
        if about["format"] not in FORMATS:
            raise ValueError("another format")
        n = len(arrays["node"])
        if arrays["node"].shape != (n,) or len(about["kind"]) != n or not set(about["kind"]) <= {DISPLACEMENT, TILT, OTHER}:
            raise ValueError("its parts do not fit")
        matrices = {name: _read(arrays, name, n) for name in _REAL}
        matrices |= {name: _read_complex(arrays, name, n) for name in _COMPLEX}
        model = FiniteElementModel(
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
            knots=_read_knots(arrays, n),
            **matrices,
        )
        if any(matrices[key] is None for key in _REAL[:4]):
            raise ValueError("its parts do not fit")
    except Exception as error:  # a damaged or forged archive fails in any way
        raise DataError(name, f"no model written by `rsc import` ({type(error).__name__})") from None
    return model, hashlib.sha256(content).hexdigest()


def _read_knots(arrays: dict[str, Any], n: int) -> Knots | None:
    if "knots" not in arrays:
        return None
    speed = arrays["knots"].astype(float)
    if speed.ndim != 1 or not 2 <= len(speed) <= MOST_KNOTS or not np.isfinite(speed).all() or not (np.diff(speed) > 0.0).all():
        raise ValueError("knots")
    parts: dict[str, Any] = {}
    for name in FOLLOWING:
        read = _read_complex if name in ANISOTROPIC else _read
        whole = read(arrays, f"knots.{name}", n, len(speed))
        if scipy.sparse.issparse(whole):
            parts[name] = [whole[i * n : (i + 1) * n].tocsc() for i in range(len(speed))]
        elif whole is not None:
            parts[name] = whole.reshape(-1, n, n)
    return Knots(speed, parts)


def _read_complex(arrays: dict[str, Any], name: str, n: int, count: int = 1) -> Any:
    real, imag = (_read(arrays, f"{name}.{part}", n, count) for part in ("real", "imag"))
    return None if real is None or imag is None else real + 1j * imag


def _read(arrays: dict[str, Any], name: str, n: int, count: int = 1) -> Any:
    """A matrix, or so many one below the other; None where there is none."""
    if name in arrays:
        matrix = arrays[name].astype(float)
        if matrix.shape != (count * n, n) or not np.isfinite(matrix).all():
            raise ValueError(name)
        return matrix
    parts = tuple(arrays.get(f"{name}.{part}") for part in ("data", "indices", "indptr"))
    if any(part is None for part in parts):
        return None
    matrix = scipy.sparse.csc_array(parts, shape=(count * n, n))
    matrix.check_format(full_check=True)
    if not np.isfinite(matrix.data).all():
        raise ValueError(name)
    return matrix
