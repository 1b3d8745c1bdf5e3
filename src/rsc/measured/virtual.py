"""A simulated run as measured by two probes and a Keyphasor, written as measured files."""

import io
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rsc.arguments import FLAG, LINE, PATH, REAL, RESULT, WHOLE, takes
from rsc.errors import SceneError, one_line, shown
from rsc.files.mark import CSV, TOML
from rsc.files.output import OutputFile, put_all, target
from rsc.measure.features import RunLike
from rsc.measure.features import turned as turned_at
from rsc.scene.files.toml_text import toml_value

ANGLES, SENSITIVITY, REST = (45.0, 135.0), 7870.0, -9.0  # degrees, V/m, V
NOTCH, WIDEST, DEPTH = 0.05, 0.4, -10.0  # of a turn, V
SEEN = 3.0  # samples in a notch at least, so that none is missed
HARMONICS = (1, 2, 3)  # of the shaft, of which its runout consists
_HEAD = "t;X;Y;KPH"


def targets(path: str | os.PathLike[str], overwrite: bool = False) -> tuple[Path, Path]:
    """The files of the table and of the data, if both may be written.

    Raises
    ------
    SceneError
        A name that does not end in .toml.
    DataError
        One of them cannot be written, or was not written by rsc.
    """
    table = Path(path)
    if table.suffix != ".toml":
        raise SceneError("write_measured", "path", one_line(path), "the name of a .toml file")
    return target(table, TOML, overwrite), target(table.with_suffix(".csv"), CSV, overwrite)


@takes(result=RESULT, path=PATH, angles=LINE, noise=REAL, runout=REAL, seed=WHOLE, overwrite=FLAG)
def write_measured(
    result: RunLike,
    path: str | os.PathLike[str],
    angles: tuple[float, float] = ANGLES,
    noise: float = 0.0,
    runout: float = 0.0,
    seed: int = 0,
    overwrite: bool = False,
) -> Path:
    """Write a run as if it had been measured: a table for `read_measured` and, beside it, the data as CSV.

    Parameters
    ----------
    result : Trajectory
    path : str or path
        Of the table, ending in .toml; the data get its name with .csv.
    angles : two floats, degrees
        Directions of the probes from y towards z; 7.87 V/mm, 9 V below zero where the rotor is in the middle.
    noise, runout : float, m
        Standard deviation of white noise of each probe; size of a runout of three harmonics of the shaft.
    seed : int
        Of both.
    overwrite : bool
        Also in the place of files that rsc did not write, or that were changed since.

    Returns
    -------
    Path of the table. The Keyphasor stands in direction y: the mark is where the angles of unbalances are counted from.

    Raises
    ------
    SceneError
        A name that does not end in .toml, other than two angles, or noise, runout or seed out of range.
    DataError
        A file that cannot be written, or that rsc did not write; then both stay as they are.

    Examples
    --------
    >>> result = rsc.simulate(rsc.load_scene("laval.toml"))
    >>> rsc.write_measured(result, "bench.toml", noise=1e-6)
    PosixPath('bench.toml')
    """
    path, beside = targets(path, overwrite)
    if np.shape(angles) != (2,) or not (np.abs(angles) <= 720.0).all():
        raise SceneError("write_measured", "angles", shown(angles), "two angles in degrees from -720 to 720")
    if seed < 0:
        raise SceneError("write_measured", "seed", seed, "a whole number >= 0")
    for name, value in (("noise", noise), ("runout", runout)):
        if not 0.0 <= value <= 1.0:
            raise SceneError("write_measured", name, value, "a length from 0 to 1 m")
    rng, time = np.random.default_rng(seed), np.asarray(result.time)
    turned = turned_at(result, time)
    shapes = rng.normal(size=(len(HARMONICS), 2)) @ [1.0, 1.0j]
    shapes *= runout / max(float(np.abs(shapes).sum()), 1e-300)
    shaft = sum(shape * np.exp(2j * np.pi * k * turned) for k, shape in zip(HARMONICS, shapes, strict=True))
    seen = result.contact_rotor() + shaft
    directions = np.exp(1j * np.deg2rad(np.array(angles, dtype=float)))
    lengths = [(seen * direction.conjugate()).real + noise * rng.normal(size=len(time)) for direction in directions]
    data = np.column_stack([time, *(REST + SENSITIVITY * length for length in lengths), _pulses(turned)])
    text = io.StringIO()
    np.savetxt(text, data, fmt="%.9g", delimiter=";", header=_HEAD, comments="")
    table = _table(beside.name, angles, turned[-1] < 0.0)
    put_all([OutputFile(beside, text.getvalue().encode(), CSV), OutputFile(path, table.encode(), TOML)], overwrite)
    return path


def _pulses(turned: NDArray[np.float64]) -> NDArray[np.float64]:
    """Volts of a notch that begins at every whole turn, wide enough for the samples; its edges fall between them."""
    turned = np.abs(turned)
    phase, step = (turned + 0.5) % 1.0 - 0.5, np.gradient(turned)
    width = min(max(NOTCH, SEEN * float(step.max())), WIDEST)
    return np.asarray(DEPTH * np.clip(np.minimum(phase, width - phase) / np.maximum(step, 1e-12) + 0.5, 0.0, 1.0))


def _table(file: str, angles: tuple[float, float], backward: bool) -> str:
    lines = ["# Written by rsc: a simulated run as two probes and a Keyphasor would have seen it.", "[measured]"]
    lines += [f"file = {toml_value(file)}", 'time = "t"', 'keyphasor = "KPH"   # in direction y']
    lines += [f'sense = "{"z to y" if backward else "y to z"}"']
    for name, angle in zip("XY", map(float, angles), strict=True):
        lines += ["", "[[measured.probe]]", f'column = "{name}"', f"angle = {angle!r}   # degrees from y towards z"]
        lines += ['sensitivity = "7.87 V/mm"']
    return "\n".join(lines) + "\n"
