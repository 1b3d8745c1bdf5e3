"""Forged result files: the content changed at random, every checksum right. A case is a number, from which its changes follow.

Unlike damage (fuzz_cases.py) this is intent: h5py itself writes links, kinds, shapes and numbers that no run would write.
"""

import contextlib
import random
import re

import h5py
import numpy as np

from rsc.files.gate import values_of as attributes
from rsc.results.result_format import BLOCKS, checkpoint_checksum, checksum, digest, put, sample_arrays

NUMBERS = (0.0, -0.0, -1.0, 1.0, 0.5, 1e-320, 1e-12, 1e12, 1e30, 1e100, 1e154, 1e308, -1e308, np.nan, np.inf, -np.inf)
COUNTS = (0, 1, -1, 2, 7, 255, 4096, 2**31, 2**40, 2**62, 2**63 - 1, -(2**31), -(2**63))
TEXTS = (
    "", "x", "a\nb", "\x1b[31mred", "é", "\u202e", "finished", "diverged", "interrupted", "rsc-result-7", "a" * 70_000, "0",
    "[rotor]\nmodel = \"laval\"", "x = " + "[" * 5000, "a." * 20_000 + "b = 1", "__import__('os')",
)  # fmt: skip
SCENE_VALUES = ("0", "-1", "1e-99", "1e300", "nan", "inf", '"/dev/zero"', '"pipe"', '"other.npz"', "[1, 2]", "true", "1e10")
MOST_ROWS = 100_000
MACHINE = '[rotor]\nmodel = "machine"\nfile = "pipe"\ncontact = 1\n'


def forge(path, number):
    """Change the result file at path as the case says."""
    dice = random.Random(number)
    with h5py.File(path, "r+", libver="latest") as file:
        for _ in range(dice.choice((1, 1, 1, 2, 3))):
            change = dice.choice(CHANGES)
            with contextlib.suppress(*IMPOSSIBLE):
                change(file, dice)
            if change is elsewhere:  # whoever reads further may hang
                break
        sum_up(file)


# a second change of what a first one removed, and what HDF5 itself refuses to write
IMPOSSIBLE = (KeyError, ValueError, TypeError, OSError, RuntimeError, IndexError, AttributeError, OverflowError, MemoryError)


def sum_up(file):
    """Write all checksums anew, as far as the content still has some."""
    inner = file["checkpoint"] if isinstance(file.get("checkpoint", getlink=True), h5py.HardLink) else None
    names = [f"checkpoint/{name}" for name in inner] if isinstance(inner, h5py.Group) else []
    if any(not _is_inside(file, name) for name in (*file, *names)):
        return  # to be refused before anything is summed up; to read it would hang the forger
    with contextlib.suppress(*IMPOSSIBLE):
        marks, names = file[BLOCKS][...], sample_arrays(file)
        for i, name in enumerate(names, start=1):
            first = 0
            for row in marks[:1000]:  # a forged file may declare more than there ever were
                row[i] = checksum(file[name][first : min(int(row[0]), MOST_ROWS)])
                first = int(row[0])
        file[BLOCKS][...] = marks
    with contextlib.suppress(*IMPOSSIBLE):
        for i in range(file["checkpoint/checksum"].shape[0]):
            arrays = {name: data[i] for name, data in file["checkpoint"].items()}
            file["checkpoint/checksum"][i] = checkpoint_checksum(arrays)
    with contextlib.suppress(*IMPOSSIBLE):
        put(file.attrs, {"checksum": digest(attributes(file))})


def _is_inside(file, name):
    """Whether an item is in the file itself."""
    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        return False
    item = file[name]
    return not isinstance(item, h5py.Dataset) or not (item.external or item.is_virtual)


def _names(file):
    """All datasets of a file."""
    names = []
    file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    return names


def _any(file, dice):
    """A dataset of a file; every other time one of those that matter to the kernel."""
    names = _names(file)
    inner = [name for name in names if "/" in name]
    return dice.choice(inner if inner and dice.random() < 0.5 else names)


def attribute(file, dice):
    name = dice.choice(sorted(file.attrs))
    kind = dice.randrange(8)
    if kind == 0:
        del file.attrs[name]
    elif kind == 1:
        put(file.attrs, {name: dice.choice(TEXTS)})
    elif kind == 2:
        file.attrs[name] = dice.choice(TEXTS)  # a text of any length
    elif kind == 3:
        file.attrs[name] = np.array(dice.choice(NUMBERS)) * np.ones(dice.choice(((), (1,), (7,), (8,), (2, 2), (4000,))))
    elif kind == 4:
        file.attrs[name] = dice.choice((np.int64, np.int8, np.uint64, np.float32, np.float64))(dice.choice((0, 1, 2, 3, 100)))
    elif kind == 5:
        file.attrs["x" * dice.choice((1, 300))] = 1.0
    elif kind == 6:
        file.attrs[name] = h5py.Empty("f8")
    else:
        for i in range(dice.choice((10, 500))):
            file.attrs[f"more{i}"] = i


def summary_number(file, dice):
    name = dice.choice([n for n in sorted(file.attrs) if not isinstance(file.attrs[n], bytes)])
    value = file.attrs[name]
    if np.ndim(value):
        value = np.array(value)
        value[dice.randrange(len(value))] = dice.choice(NUMBERS)
    else:
        value = np.int64(dice.choice(COUNTS)) if isinstance(value, np.integer) else np.float64(dice.choice(NUMBERS))
    file.attrs[name] = value


def scene_text(file, dice):
    text = file.attrs["scene"].decode()
    kind = dice.randrange(5)
    if kind == 0:
        text = dice.choice(TEXTS)
    elif kind == 1:
        text = re.sub(r"\[rotor\][^[]*", MACHINE, text, count=1)
    else:
        lines = text.splitlines()
        places = [i for i, line in enumerate(lines) if "=" in line]
        for _ in range(dice.choice((1, 1, 2))):
            i = dice.choice(places)
            key = lines[i].partition("=")[0]
            if kind == 2:
                lines[i] = f"{key}= {dice.choice(SCENE_VALUES)}"
            elif kind == 3:
                lines[i] = re.sub(r"[0-9.]+(e-?[0-9]+)?", lambda m: repr(float(m[0]) * 10.0 ** dice.randint(-9, 9)), lines[i])
            else:
                lines.insert(i, dice.choice(("", lines[i], "[rotor]", "mass = \"pipe\"", "stiffness = \"/dev/zero\"", "x = 1")))
        text = "\n".join(lines)
    put(file.attrs, {"scene": text})


def _replace(file, name, values, **options):
    del file[name]
    options = {"chunks": True, "fletcher32": True} | options
    if np.ndim(values) == 0 or 0 in np.shape(values):
        options = {}
    file.create_dataset(name, data=values, **options)


def as_written(file, name, values):
    """A dataset with the layout that a run gives it."""
    del file[name]
    rows = 16 if "/" in name else 4096
    shape = values.shape[1:]
    options = {"maxshape": (None, *shape), "chunks": (rows, *shape), "fletcher32": True}
    file.create_dataset(name, values.shape, values.dtype, **options)[...] = values


def kind_of_array(file, dice):
    name = _any(file, dice)
    values = file[name][...]
    kind = dice.choice(("f4", "f2", "i8", "i4", "u8", "u1", ">f8", ">i8", "S8", "?", "c16", "f8"))
    as_written(file, name, np.nan_to_num(values).astype(kind))


def shape_of_array(file, dice):
    name = _any(file, dice)
    values = file[name][...]
    kind = dice.randrange(9)
    if kind == 0:
        values = values[: dice.randrange(len(values) + 1)]
    elif kind == 1:
        values = np.concatenate([values, values[: dice.choice((1, 100))]])
    elif kind == 2:
        values = np.repeat(values, 2, axis=-1)
    elif kind == 3 and values.ndim > 1:
        values = values[..., : dice.choice((0, 1))] if dice.random() < 0.5 else values[:, : max(values.shape[1] - 1, 0)]
    elif kind == 4:
        values = values.reshape(-1)
    elif kind == 5:
        values = values[..., None]
    elif kind == 6:
        values = values[0]
    elif kind == 7 and values.ndim > 1:
        values = np.concatenate([values, values], axis=1)
    else:
        values = values.T
    if dice.random() < 0.8:
        as_written(file, name, values)
    else:
        _replace(file, name, values)


def declared_rows(file, dice):
    names = [_any(file, dice)] if dice.random() < 0.5 else [n for n in _names(file) if ("/" in n) == (dice.random() < 0.5)]
    rows = dice.choice((0, 1, 5, 10**5, 10**9, 2**40, 2**61))
    for name in names:
        file[name].resize(rows, axis=0)


def layout(file, dice):
    name = _any(file, dice)
    values = file[name][...]
    options = dice.choice((
        {"compression": "gzip"}, {"compression": "gzip", "compression_opts": 9, "shuffle": True}, {"compression": "lzf"},
        {"shuffle": True}, {"fletcher32": False}, {"scaleoffset": 3}, {"chunks": (1,) * values.ndim},
        {"chunks": None, "fletcher32": False}, {"fillvalue": 7},
    ))  # fmt: skip
    _replace(file, name, values, **options)


def elsewhere(file, dice):
    name = _any(file, dice)
    values, kind = file[name][...], dice.randrange(8)
    group = name.rpartition("/")[0]
    if dice.random() < 0.3 and group:
        name, values = group, np.zeros((3, 3))
    del file[name]
    target = dice.choice(("pipe", "/dev/zero", "other.h5", "run.h5", "/etc/passwd"))
    if kind == 0:
        file[name] = h5py.SoftLink(dice.choice((f"/{name}", "/time", "/", "/nowhere", "..")))
    elif kind <= 2:
        file[name] = h5py.ExternalLink(target, dice.choice(("/", "/time", f"/{name}")))
    elif kind == 3:
        file.create_dataset(name, values.shape, values.dtype, external=[(target, 0, max(values.nbytes, 1))])
    elif kind == 4:
        virtual = h5py.VirtualLayout(shape=values.shape, dtype=values.dtype)
        virtual[...] = h5py.VirtualSource(target, "time", shape=values.shape)
        file.create_virtual_dataset(name, virtual)
    elif kind == 5:
        file[name] = file[dice.choice(("/", "time", "speed", "rotor", "checkpoint", "checkpoint/rows"))]
    elif kind == 6:
        file.create_group(name)
    else:
        file[name] = np.dtype("f8")


def groups(file, dice):
    place = dice.choice(("/", "checkpoint", "blocks"))
    kind = dice.randrange(4)
    if kind == 0:
        for i in range(dice.choice((1, 10, 2000))):
            file[place].create_group(f"g{i}")
    elif kind == 1:
        file[place]["again"] = file["/"]
    elif kind == 2:
        file[place].create_dataset("y" * dice.choice((1, 200)), data=np.zeros((3, 4)))
    else:
        inner = file[place]
        for _ in range(60):
            inner = inner.create_group("g")


def numbers(file, dice):
    name = _any(file, dice)
    values = file[name][...]
    flat = values.reshape(-1)
    whole = values.dtype.kind in "iu"
    for _ in range(dice.choice((1, 1, 3, 50))):
        place = slice(None) if dice.random() < 0.1 else dice.randrange(len(flat))
        flat[place] = dice.choice(COUNTS) if whole else dice.choice(NUMBERS) if dice.random() < 0.7 else flat[place] * 3.0
    file[name][...] = values


def order(file, dice):
    name = _any(file, dice)
    values = file[name][...]
    file[name][...] = values[::-1] if dice.random() < 0.5 else np.roll(values, 1, axis=0)


def state(file, dice):
    """A number of a checkpoint: counts, clock, step, contact states."""
    names = ("count", "count", "count", "real", "real", "stretch", "code", "rows", "sliding", "energy_start", "x", "v")
    name = dice.choice(names)
    data = file[f"checkpoint/{name}"]
    row = -1 if dice.random() < 0.5 else dice.randrange(len(data))
    values = data[row]
    i = dice.randrange(len(values))
    if values.dtype.kind == "i":
        values[i] = dice.choice(COUNTS) if dice.random() < 0.7 else values[i] + dice.choice((-1, 1, 10, 1000))
    else:
        values[i] = dice.choice(NUMBERS) if dice.random() < 0.6 else values[i] * dice.choice((0.5, 1.0 + 1e-12, 2.0, 1e6, -1.0))
    data[row] = values
    if name == "rows" or (name == "count" and dice.random() < 0.3):  # a forger keeps them together
        file["checkpoint/rows"][row] = file["checkpoint/count"][row][2]


def block_ends(file, dice):
    data = file[BLOCKS]
    values = data[...]
    kind = dice.randrange(4)
    if kind == 0:
        values[dice.randrange(len(values)), 0] = dice.choice(COUNTS)
    elif kind == 1:
        values[:, 0] = values[::-1, 0]
    elif kind == 2:
        values = np.delete(values, dice.randrange(len(values)), axis=0)
        data.resize(len(values), axis=0)
    else:
        values[:, 0] += dice.choice((-1, 1))
    data[...] = values


CHANGES = (
    attribute, attribute, summary_number, summary_number, scene_text, scene_text, kind_of_array, shape_of_array, shape_of_array,
    declared_rows, layout, elsewhere, elsewhere, groups, numbers, numbers, order, state, state, state, state, block_ends,
)  # fmt: skip
