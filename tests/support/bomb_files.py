"""Small files that say or unpack to far more than they are, numbered: six formats of measured files, each refused or read within
four times the memory that is told.

The cap of `rsc.files.memory` is lowered for them, so that little memory shows what a large file would do.
"""

import io
import random
import struct
import zipfile
import zlib
from pathlib import Path

import h5py
import numpy as np

import rsc
from rsc.errors import RscError
from rsc.files import memory

CAP = 48 * 2**20  # bytes of numbers, for these files
TIMES = 4  # so many caps may be held
FORMATS = ("npz", "mat", "h5", "tdms", "wav", "csv")
_TYPES = ("|i1", "|u1", "<i2", "<f2", "<i4", "<f4", "<f8", "|b1")
_TABLE = '[measured]\nfile = "run.{kind}"\n{more}\nspeed = "{names[2]}"\n' + "".join(
    f'[[measured.probe]]\ncolumn = "{{names[{i}]}}"\nangle = {angle}\nunit = 1.0\n' for i, angle in enumerate((0.0, 90.0))
)


def npz(dice, count):
    """Arrays of zeros, some with heads that say more than the archive has."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in dice.choice((("X",), ("X", "Y"), (*(f"X{i}" for i in range(9)), "X"))):
            kind = dice.choice(_TYPES)
            shape = dice.choice(("({0},)", "({0}, 1)", "(1, {0})", "({1}, 100)", "({0}, 2)")).format(count, count // 100)
            head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}}}".encode() + b"\n"
            size = count * np.dtype(kind).itemsize if dice.random() < 0.8 else 10
            begin = b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head
            archive.writestr(f"{name}.npy", begin + bytes(min(size, 200_000_000)))
    return out.getvalue()


def mat(dice, count):
    """A packed matrix of zeros in a narrow type, as MATLAB stores whole numbers."""
    kind, width = dice.choice(((1, 1), (2, 1), (3, 2), (7, 4), (9, 8)))
    columns = dice.choice((1, 1, 2, 50))
    size = count // columns * columns * width
    body = struct.pack("<6I2i", 6, 8, 6, 0, 5, 8, count // columns, columns) + struct.pack("<2H4s", 1, 1, b"X\0\0\0")
    told = size if dice.random() < 0.8 else min(100 * size, 2**32 - 1)
    body += struct.pack("<2I", kind, told) + bytes(min(size, 200_000_000))
    packed = zlib.compress(struct.pack("<2I", 14, len(body)) + body, 9)
    return b"MATLAB 5.0".ljust(124) + b"\0\1IM" + struct.pack("<2I", 15, len(packed)) + packed


def h5(dice, count):
    """Zeros that were packed, never written, or lie in one large chunk."""
    out = io.BytesIO()
    with h5py.File(out, "w") as file:
        how = dice.choice(({}, {"compression": "gzip"}, {"compression": "lzf"}, {"compression": "gzip", "chunks": (count,)}))
        kind = dice.choice(("i1", "f4", "f8", "i2"))
        data = file.create_dataset("X", (count,), kind, **how)
        if dice.random() < 0.7 and (how or count < 200_000):
            data[:] = np.zeros(count, kind)
        else:
            data[:1] = 1
    return out.getvalue()


def tdms(dice, count):
    """A segment that says more samples than it has, or very many names."""
    path, kind = b"/'g'/'X'", dice.choice(((1, 1), (2, 2), (3, 4), (9, 4), (10, 8)))
    index = struct.pack("<IIIQ", 20, kind[0], 1, count)
    objects = 1 if dice.random() < 0.7 else min(count // 100, 20_000)
    lead = struct.pack("<I", objects)
    for i in range(objects):
        name = path if i == 0 else f"/'g'/'X{i}'".encode()
        lead += struct.pack("<I", len(name)) + name + index + struct.pack("<I", 0)
    data = bytes(min(count * kind[1], 1_500_000)) if dice.random() < 0.8 else b""
    following = len(lead) + (len(data) if dice.random() < 0.7 else count * kind[1])
    return b"TDSm" + struct.pack("<IIQQ", 0x0E, 4713, following, len(lead)) + lead + data


def wav(dice, count):
    """Eight bits a sample, or a head that says more than there is."""
    channels, width = dice.choice(((1, 1), (3, 1), (2, 2), (200, 1), (60000, 1)))
    data = bytes(min(count, 1_500_000) // (channels * width) * channels * width)
    told = len(data) if dice.random() < 0.6 else min(count * 100, 2**32 - 1)
    form = struct.pack("<HHIIHH", 1, channels, 4000, 4000 * channels * width, (channels * width) % 65536, 8 * width)
    body = b"WAVEfmt " + struct.pack("<I", 16) + form + b"data" + struct.pack("<I", told) + data
    return b"RIFF" + struct.pack("<I", min(len(body) if dice.random() < 0.8 else told, 2**32 - 1)) + body


def csv(dice, count):
    """The shortest rows, one endless row, or a head of many names."""
    rows = min(count, 400_000)
    return dice.choice((
        lambda: b"1,1,1\n" * rows, lambda: b"X,Y,N\n" + b"1;1;1\n" * rows, lambda: b"1," * (2 * rows), lambda: b"\n" * (3 * rows),
        lambda: b",".join(b"X%d" % i for i in range(rows // 10)) + b"\n" + b"1,1,1\n" * rows, lambda: b'"1","1","1"\n' * rows,
        lambda: ("1\t1\t1\n" * rows).encode("utf-16"), lambda: b"1 1 1\n" * rows + b"x",
    ))()  # fmt: skip


_MAKERS = {"npz": npz, "mat": mat, "h5": h5, "tdms": tdms, "wav": wav, "csv": csv}


def write(number, folder):
    """Write the bomb of a number and its table into a folder; returns the table's path and the size of the file."""
    dice = random.Random(number)
    kind = FORMATS[number % len(FORMATS)]
    content = _MAKERS[kind](dice, int(10 ** dice.uniform(4.0, 8.0)))
    Path(folder, f"run.{kind}").write_bytes(content)
    names = ("1", "2", "3") if kind in ("wav", "csv") and dice.random() < 0.7 else ("X", "X", "X")
    path = Path(folder, "run.toml")
    path.write_text(_TABLE.format(kind=kind, names=names, more="" if kind == "wav" else "rate = 4000.0"))
    return path, len(content)


def explode(path):
    """Read it under the lowered cap: "read", or the refusal."""
    before = memory.MOST
    memory.MOST = CAP
    try:
        rsc.read_measured(path)
        return "read"
    except RscError as error:
        return str(error)
    finally:
        memory.MOST = before
