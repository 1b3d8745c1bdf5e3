"""Forged stores and datasets of sweeps, every checksum right: plans, parts, `sweep.nc`, and what stands in the folder.

A case is a number, from which its changes follow, as in forge.py. `precious` is a file beside the store that no sweep may change.
"""

import contextlib
import hashlib
import os
import random
import shutil

import h5py
import numpy as np

import forge
from rsc.files.gate import values_of
from rsc.results.result_format import put
from rsc.results.sweep_store import FORMAT, USER_BLOCK

PRECIOUS = "precious"
TEXTS = (
    *forge.TEXTS, "$x^2$", "$\\frac{1}{0}$", "$", "\\", "{x}", "<script>", "contact.friction", "sample", "predict,run", "rsc 1",
)  # fmt: skip
KINDS = ("f4", "f2", "i8", "i4", "i1", "u8", "u1", ">f8", "S8", "S300", "?", "c16", "f8")
SHAPES = (0, 1, 2, 3, 9, 128, 10**4, 10**7, 2**30, 2**40)
HEADS = {
    "part_sizes": ("0", "-1", "1", "9", "129", "1" + "0" * 400, "1,1", "", "x", "1.5", "0x8", "8,8"),
    "kinds": ("", "run", "predict,predict", "predict,run"), "computed": ("", "run", "predict,run", "mu_min"),
    "axes": ("", ":", "contact.friction:case", "a:b:c", "contact.friction:contact.friction"),
    "key": ("", "rotor.mass", "rotor.model", "rotor.file", "contact.frictio", "drive.speed", "rotor.mass[0][0]", "title"),
    "dim": ("sample", "case", "zipped", "whirl", "rotor.mass", "contact.friction", "drive.speed", ""),
    "kind": ("run", "", "check"), "versions": ("rsc 1", ""), "cases": ("0" * 64,),
}  # fmt: skip


def forge_image(path, number):
    """Change a plan, a part or a dataset as the case says."""
    dice = random.Random(number)
    sealed = path.name != "sweep.nc"
    with h5py.File(path, "r+") as file:
        for _ in range(dice.choice((1, 1, 1, 2, 3))):
            change = dice.choice(CHANGES if sealed or dice.random() < 0.5 else VALUES)
            with contextlib.suppress(*forge.IMPOSSIBLE):
                change(file, dice)
            if change is forge.elsewhere:
                break
    if sealed:
        seal(path)


def seal(path):
    """Write the sum in front of an image anew."""
    content = path.read_bytes()
    sum_of_all = hashlib.sha256(content[USER_BLOCK:]).hexdigest()
    path.write_bytes(f"{FORMAT}\n{sum_of_all}\n".encode().ljust(USER_BLOCK, b"\0") + content[USER_BLOCK:])


def forge_folder(store, number):
    """Change what stands in a store, but no file of it."""
    dice = random.Random(number)
    for _ in range(dice.choice((1, 1, 2))):
        change = dice.choice(FOLDERS)
        with contextlib.suppress(OSError):
            change(store, dice)
        if change is link:  # a change that reads what is a pipe now would wait for ever
            break


def _put(file, name, values):
    """An array as a sweep writes it, in the place of one with the same attributes."""
    own = values_of(file[name]) if isinstance(file[name], h5py.Dataset) and file.filename.endswith("plan.h5") else {}
    del file[name]
    put(file.create_dataset(name, data=values).attrs, own)


def _any(file, dice):
    return dice.choice(sorted(file))


def kind_of_array(file, dice):
    name = _any(file, dice)
    values = file[name][...]
    values = np.zeros(values.shape) if values.dtype.kind in "SO" else np.nan_to_num(values)
    _put(file, name, values.astype(dice.choice(KINDS)))


def shape_of_array(file, dice):
    name = _any(file, dice)
    values = file[name][...]
    other = dice.choice((
        lambda v: v[: dice.randrange(len(v) + 1)], lambda v: np.concatenate([v, v[: dice.choice((1, 100))]]), lambda v: v.ravel(),
        lambda v: np.repeat(v, 2, axis=-1), lambda v: v[..., None], lambda v: v[0], lambda v: v.T, lambda v: v[..., :0],
        lambda v: np.repeat(v, 40, axis=-1), lambda v: np.concatenate([v, v]),
    ))  # fmt: skip
    _put(file, name, other(values))


def all_longer(file, dice):
    """Every array with as many cases: what contradicts nothing but the plan."""
    times = dice.choice((2, 3, 10, 100))
    for name in sorted(file):
        _put(file, name, np.concatenate([file[name][...]] * times))


def unwritten(file, dice):
    """An array that is declared and was never written."""
    name = _any(file, dice)
    kind, shape = file[name].dtype, list(file[name].shape)
    shape[dice.randrange(len(shape))] = dice.choice(SHAPES)
    own = values_of(file[name]) if file.filename.endswith("plan.h5") else {}
    del file[name]
    options = {"chunks": True} if dice.random() < 0.3 else {}
    put(file.create_dataset(name, shape, kind, **options).attrs, own)


def zeros(file, dice):
    """An axis of numbers that are there, all the same."""
    name = _any(file, dice)
    count = dice.choice((2, 100, 10**5, 10**6))
    _put(file, name, np.zeros((count, *file[name].shape[1:]), dice.choice(("f8", "i8", "i1"))))


def words(file, dice):
    """Texts in the place of texts, or of numbers."""
    name = _any(file, dice)
    values = file[name][...]
    texts = [dice.choice(TEXTS)[:3000].encode() for _ in range(values.size)]
    _put(file, name, np.array(texts, dtype=bytes).reshape(values.shape))


def head(file, dice):
    """An attribute that says what a file is."""
    places = [file, *(file[name] for name in sorted(file) if file.filename.endswith("plan.h5"))]
    item = dice.choice(places)
    name = dice.choice(sorted(item.attrs))
    put(item.attrs, {name: dice.choice(HEADS.get(name, TEXTS))})


def names(file, dice):
    """An array under another name, or one more."""
    name, other = _any(file, dice), dice.choice(("axis000", "axis001", "status", "$x$", "a\nb", "x" * 300, "whirl", "danger"))
    values = file[name][...]
    if dice.random() < 0.5:
        del file[name]
    file.create_dataset(other, data=values)


def scene(file, dice):
    if "scene" in file.attrs:
        forge.scene_text(file, dice)


def heap(file, dice):
    """A text of any length, as an attribute or as an array."""
    name = _any(file, dice)
    if dice.random() < 0.5:
        file.attrs[dice.choice(sorted(file.attrs))] = dice.choice(TEXTS)
    else:
        shape = file[name].shape
        del file[name]
        file.create_dataset(name, data=np.full(shape, "x", dtype=object), dtype=h5py.string_dtype())


def extremes(file, dice):
    """Every number of an array another one that is possible by its kind."""
    name = _any(file, dice)
    values = file[name][...]
    if values.dtype.kind == "S":
        kept = values.dtype.itemsize
        file[name][...] = np.array([dice.choice(TEXTS)[:kept].encode()[:kept] for _ in range(values.size)]).reshape(values.shape)
        return
    pool = forge.NUMBERS if values.dtype.kind == "f" else (0, 1, 2, 3, 4, -1, -2, 100, -128)
    few = dice.sample(pool, dice.choice((1, 2, 5)))
    file[name][...] = np.array([dice.choice(few) for _ in range(values.size)], values.dtype).reshape(values.shape)


CHANGES = (
    kind_of_array, shape_of_array, shape_of_array, all_longer, unwritten, unwritten, zeros, words, words, head, head, head, names,
    scene, scene, heap, forge.attribute, forge.layout, forge.elsewhere, forge.elsewhere, forge.groups, forge.numbers,
    forge.numbers, forge.order, extremes,
)  # fmt: skip
VALUES = (extremes, extremes, extremes, forge.numbers, forge.order, scene, words)  # of a dataset, so that more of them are drawn


def swapped(store, dice):
    """Parts under each other's names, with the right sums."""
    parts = sorted((store / "parts").iterdir())
    one, other = dice.sample(parts, 2)
    content = one.read_bytes()
    one.write_bytes(other.read_bytes())
    if dice.random() < 0.5:
        other.write_bytes(content)


def foreign(store, dice):
    """A part of another kind or of other versions, sealed as one of this plan."""
    path = dice.choice(sorted((store / "parts").iterdir()))
    with h5py.File(path, "r+") as file:
        word = dice.choice(("kind", "versions", "cases"))
        put(file.attrs, {word: "rsc 0"})
    seal(path)


def other_scenes(store, dice):
    """Rows of other scenes, with the origin of this part."""
    path = dice.choice(sorted((store / "parts").iterdir()))
    with h5py.File(path, "r+") as file:
        file["scene_hash"][...] = np.array([b"0" * 64] * len(file["scene_hash"]))
    seal(path)


def link(store, dice):
    """Something that is no file of its own under a name that a sweep writes."""
    digest = hashlib.sha256((store / "plan.h5").read_bytes()).hexdigest()[:12]
    parts = sorted(path.name for path in (store / "parts").iterdir())
    path = store / dice.choice(("lock", f"plan-{digest}.h5", "sweep.nc", "plan.h5", f"parts/{dice.choice(parts)}", "parts"))
    shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    precious = store.parent / PRECIOUS
    dice.choice((
        lambda: path.symlink_to(precious), lambda: os.link(precious, path), lambda: os.mkfifo(path), path.mkdir,
        lambda: path.symlink_to("/dev/zero"), lambda: path.symlink_to(path.name), lambda: path.symlink_to(store.parent / "pipe"),
    ))()  # fmt: skip


def cut(store, dice):
    """A file that ends early, is empty, or is not there."""
    path = dice.choice([store / "plan.h5", *sorted((store / "parts").iterdir())])
    size = dice.choice((0, 1, 100, USER_BLOCK, 2000))
    if dice.random() < 0.3:
        path.unlink()
    else:
        path.write_bytes(path.read_bytes()[:size])


def strangers(store, dice):
    """Files that no sweep writes."""
    names = ("x.h5", "predict-000000-0123456789abcdef.h5", "check-999999999999-0.h5", "a\nb.h5", ".rsc-0.part")
    for name in (f"parts/{name}" for name in names):
        (store / name).write_bytes(dice.choice((b"", b"x" * 1000, (store / "plan.h5").read_bytes())))


FOLDERS = (swapped, swapped, foreign, other_scenes, link, link, link, link, cut, strangers)
