"""Forged and damaged measured files, numbered like those of fuzz_cases.py: CSV, .npz, WAV, UFF-58, TDMS, LVM, MAT of levels 5 and
7.3, HDF5 and the table [measured] beside them.

Reading ends with a run or one line, soon and in bounded memory; of a run spectra can be made, and some are put beside a scene.
"""

import io
import random
import resource
import warnings
from pathlib import Path

import h5py
import numpy as np
import scipy.io.wavfile

import fuzz_cases as fuzz
import matrix_fuzz
import rsc
from forge import NUMBERS
from laboratories import write_tdms, write_uff
from probes import TABLE, pulses_of, turns_of, volts
from rsc.errors import RscError
from rsc.show.page import page
from scenes import LAVAL

LIMIT = 10.0  # s of processor time, of one case
MOST_GROWTH = 400e6  # bytes that one case may take
EVERY = 25  # of so many runs one is put beside a scene
NAMES, RATE, SAMPLES = ("t", "X", "Y", "KPH"), 4000.0, 2000
KINDS = ("csv", "npz", "wav", "uff", "uffb", "tdms", "lvm", "mat", "mat73", "h5")
LINES = (
    'rate = {0}', 'time_unit = {0}', 'speed = "{0}"', 'speed_unit = {0}', 'slow_roll = [{0}, {1}]', 'events_per_turn = {0}',
    'sense = "z to y"', 'keyphasor_angle = {0}', 'full_scale = {0}', 'time = "{0}"', 'file = "{0}"',
    "[[measured.probe]]", "[measured]", "x = {0}",
)  # fmt: skip
VALUES = ("0", "1", "2", "3", "-1", "1e-9", "1e9", "1e99", "1000", "nan", "X", "KPH", "/dev/zero", "pipe", '"1 rpm"', "true")


def signals():
    """(n, 4) time, two probes and a Keyphasor of a run with a backward whirl."""
    time = np.arange(SAMPLES) / RATE
    turns = turns_of(time, (60.0, 90.0))
    motion = 1.2e-3 * np.exp(-2j * np.pi * 60.0 * time) + 1e-4 * np.exp(2j * np.pi * turns)
    return np.column_stack([time, *volts(motion, (45.0, 135.0)), pulses_of(turns)])


def content_of(kind, rows, folder):
    """The bytes of a file of a kind; some kinds are written in a folder."""
    if kind in ("uff", "uffb", "tdms"):
        rows = rows if len(rows) > 1 else np.zeros((2, len(NAMES)))  # shorter ones pyuff does not write
        path, channels = Path(folder, "written"), dict(zip(NAMES[1:], rows[:, 1:].T, strict=True))
        with np.errstate(all="ignore"):
            if kind == "tdms":
                write_tdms(path, channels, RATE, pieces=3)
            else:
                write_uff(path, channels, RATE, binary=kind == "uffb")
        return path.read_bytes()
    if kind == "csv":
        return b"t,X,Y,KPH\n" + b"".join(b",".join(b"%.9g" % value for value in row) + b"\n" for row in rows)
    if kind == "lvm":
        return lvm(rows)
    out = io.BytesIO()
    if kind in ("mat73", "h5"):
        return hdf5(rows, out, 512 if kind == "mat73" else 0)
    if kind == "mat":
        with np.errstate(all="ignore"):
            scipy.io.savemat(out, dict(zip(NAMES, rows.T, strict=True)), do_compression=True)
    elif kind == "npz":
        np.savez(out, **dict(zip(NAMES, rows.T, strict=True)))
    else:
        with np.errstate(all="ignore"):
            scipy.io.wavfile.write(out, int(RATE), rows[:, 1:].astype(np.float32))
    return out.getvalue()


def lvm(rows):
    """LabVIEW's two heads and the rows, with a column of times."""
    head = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n***End_of_Header***\t\n\t\n"
    head += "Channels\t3\nY_Unit_Label\tV\tV\tV\nX0\t0\t0\t0\nDelta_X\t1\t1\t1\n***End_of_Header***\n"
    lines = (b"\t".join(b"%.9g" % value for value in row) + b"\n" for row in rows)
    return head.encode() + b"t\tX\tY\tKPH\tComment\n" + b"".join(lines)


def hdf5(rows, out, user_block):
    """Arrays with units as texts of any length; behind a block, those of a MAT-file of level 7.3."""
    with h5py.File(out, "w", userblock_size=user_block) as file:
        for name, values in zip(NAMES, rows.T, strict=True):
            values = values[None, :] if user_block else values
            data = file.create_dataset(name, data=values, compression="gzip" if len(rows) else None)
            data.attrs["units"] = "s" if name == "t" else "V"
            data.attrs["MATLAB_class"] = np.bytes_("double")
    content = out.getvalue()
    return b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + content[128:] if user_block else content


def table_of(kind):
    """The text of the table beside it."""
    text = TABLE.format(angles=(45.0, 135.0), more="").replace("run.csv", f"run.{kind}")
    if kind not in ("wav", "uff", "uffb", "tdms"):
        return text
    text = text.replace('time = "t"\n', "")
    return text if kind != "wav" else text.replace('"X"', '"1"').replace('"Y"', '"2"').replace('"KPH"', '"3"')


def column(rows, dice):
    """A column with other numbers: some, many, or all of them; or another length of all."""
    rows, place = rows.copy(), dice.randrange(rows.shape[1])
    kind, value = dice.randrange(7), dice.choice(NUMBERS)
    if kind <= 1:
        rows[[dice.randrange(len(rows)) for _ in range(dice.choice((1, 1, 10, 500)))], place] = value
    elif kind == 2:
        with np.errstate(all="ignore"):
            rows[:, place] *= value
    elif kind == 3:
        rows[dice.randrange(len(rows)) :, place] += dice.choice((1e-9, 0.1, 10.0, 1e18, -1.0))
    elif kind == 4:
        rows = rows[dice.randrange(len(rows)) : dice.randrange(len(rows) + 1)]
    elif kind == 5:
        rows[:, place] = np.random.default_rng(dice.randrange(1000)).permutation(rows[:, place])
    else:
        rows = np.delete(rows, slice(first := dice.randrange(len(rows)), first + dice.choice((1, 100))), axis=0)
    return rows


def one_run(number, folder, rows, scene):
    """Read a forged measurement; returns what became of it, in a word."""
    dice = random.Random(number)
    kind, text = KINDS[number % len(KINDS)], table_of(KINDS[number % len(KINDS)])
    content = content_of(kind, column(rows, dice) if dice.random() < 0.7 else rows, folder)
    if dice.random() < 0.4:
        content = matrix_fuzz.damaged(content, dice)
    if dice.random() < 0.3:
        lines = text.splitlines()
        line = dice.choice(LINES).format(dice.choice(VALUES), dice.choice(VALUES))
        lines[dice.randrange(len(lines)) : dice.randrange(len(lines) + 1)] = [line]
        text = "\n".join(lines)
    Path(folder, f"run.{kind}").write_bytes(content)
    path = Path(folder, "run.toml")
    path.write_text(text)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    outcome = _read(path, scene if number % EVERY == 0 else None)
    if 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) > MOST_GROWTH:
        raise AssertionError("too much memory was taken")
    return f"{kind}: {outcome}"


def _read(path, scene):
    try:
        run = rsc.read_measured(path)
        rsc.spectral_peaks(run, "negative", count=1)
        if scene is None:
            return "read"
        page(rsc.compare(scene, run))
        return "compared"
    except RscError as error:
        fuzz.one_line(error)
        return "refused"


def measurements(numbers, folder):
    """(case, outcome, seconds) of forged measurements."""
    rows, scene = signals(), rsc.Scene.from_dict(LAVAL)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # numpy's, of numbers that no picture can show
        for number in numbers:
            yield fuzz.case(number, one_run, folder, rows, scene, limit=LIMIT)
