"""Files of measured runs with none, one, 64 and more, very many rows, columns, probes: read, or refused in one line."""

import numpy as np
import pytest
import scipy.io

import rsc
from probes import pulses_of, turns_of, volts, written
from rsc.errors import RscError

SIZES = (0, 1, 2, 63, 64, 65, 10_000)
RATE, ANGLES = 2000.0, np.deg2rad((45.0, 135.0))


def run_of(n):
    """(time, motion, pulses) of n samples of a shaft at 50 Hz."""
    time = np.arange(n) / RATE
    turns = turns_of(time, (50.0, 50.0)) if n > 1 else 50.0 * time
    return time, 1e-4 * np.exp(2j * np.pi * turns), pulses_of(turns) if n > 1 else np.zeros(n)


def read_or_refused(path):
    """The run, or None where it is refused in one line."""
    try:
        return rsc.read_measured(path)
    except RscError as refusal:
        assert "\n" not in str(refusal) and len(str(refusal)) < 500
        return None


@pytest.mark.parametrize("size", SIZES)
def test_rows_of_a_file(size, tmp_path):
    run = read_or_refused(written(tmp_path, *run_of(size)))
    assert (run is not None) == (size == 10_000)  # two turns and more are wanted
    if run is not None:
        assert abs(np.median(run.speed) - 50.0) < 0.01


@pytest.mark.parametrize("size", SIZES)
def test_columns_that_nobody_names(size, tmp_path):
    time, motion, pulses = run_of(2000 if size < 10_000 else 400)
    path = written(tmp_path, time, motion, pulses)
    head, *rows = (tmp_path / "run.csv").read_text().splitlines()
    more = "".join(f",c{i}" for i in range(size))
    (tmp_path / "run.csv").write_text("\n".join([head + more, *(row + ",1" * size for row in rows), ""]))
    if size == 10_000:
        with pytest.raises(RscError, match="leave out columns that are not needed"):
            rsc.read_measured(path)
        return
    run = read_or_refused(path)
    assert run is not None and abs(np.median(run.speed) - 50.0) < 0.01


@pytest.mark.parametrize("size", SIZES)
def test_arrays_of_archives_and_mat_files(size, tmp_path):
    time, motion, pulses = run_of(2000)
    path = written(tmp_path, time, motion, pulses)
    x, y = volts(motion, ANGLES)
    columns = {"t": time, "X": x, "Y": y, "KPH": pulses} | {f"c{i}": np.zeros(3) for i in range(size)}
    np.savez(tmp_path / "run.npz", **columns)
    scipy.io.savemat(tmp_path / "run.mat", columns)
    for name in ("run.npz", "run.mat"):
        path.write_text(path.read_text().replace("run.csv", name).replace("run.npz", name))
        run = read_or_refused(path)
        assert run is not None or size == 10_000  # more arrays than a file may have are refused
        assert run is None or abs(np.median(run.speed) - 50.0) < 0.01


@pytest.mark.parametrize("size", SIZES)
def test_probes_of_the_table(size, tmp_path):
    path = written(tmp_path, *run_of(2000))
    head = path.read_text().partition("[[measured.probe]]")[0]
    probe = '[[measured.probe]]\ncolumn = "{}"\nangle = {}\nsensitivity = 7870.0\n'
    path.write_text(head + "".join(probe.format("XY"[i % 2], 45 + 90 * (i % 2)) for i in range(size)))
    assert (read_or_refused(path) is not None) == (size == 2)


@pytest.mark.parametrize("size", SIZES)
def test_teeth_of_the_wheel(size, tmp_path):
    time = np.arange(0.0, 1.0, 1.0 / 40e3)
    turns = turns_of(time, (50.0, 50.0))
    motion = 1e-4 * np.exp(2j * np.pi * turns)
    pulses = pulses_of(turns, max(min(size, 65), 1), share=0.4)
    run = read_or_refused(written(tmp_path, time, motion, pulses, more=f"events_per_turn = {size}"))
    assert (run is not None) == (0 < size < 10_000)
    assert run is None or abs(np.median(run.speed) - 50.0) < 0.05
