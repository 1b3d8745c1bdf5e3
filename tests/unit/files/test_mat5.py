"""Damaged MAT-files: never a crash, never more memory than the file's caps, never another matrix than a fresh reader gives."""

import random
import struct
import time
import tracemalloc
import zlib

import numpy as np
import pytest
import scipy.io
import scipy.sparse

from rsc.files.mat5 import MatError, read_mat5

MASS = np.diag([1.0, 2.0, 3.5])
STIFFNESS = np.array([[2.5e4, -1e4, 0.0], [-1e4, 1e4, -7.0], [0.0, -7.0, 3.0]])
CONTENT = {
    "mass": MASS,
    "stiffness": scipy.sparse.csc_array(STIFFNESS),
    "whole": np.arange(6, dtype=np.int16).reshape(2, 3),
    "single": np.float32([[0.5, 0.25]]),
    "text": "abc",
    "cells": np.array([[1, "x"]], dtype=object),
    "complex": 1j * np.eye(2),
    "yes": np.array([[True]]),
    "model": {"K": scipy.sparse.csc_array(STIFFNESS), "inner": {"M": MASS}, "note": "abc"},
}


def dense(matrix):
    return matrix.toarray() if scipy.sparse.issparse(matrix) else matrix


def written(folder, content, **options):
    scipy.io.savemat(folder / "x.mat", content, **options)
    return (folder / "x.mat").read_bytes()


@pytest.mark.parametrize("compressed", [False, True])
def test_reads_what_scipy_writes(tmp_path, compressed):
    found = read_mat5(written(tmp_path, CONTENT, do_compression=compressed))
    assert set(found) == set(CONTENT)
    for name in ("mass", "stiffness", "whole", "single"):
        wanted = CONTENT[name].toarray() if name == "stiffness" else CONTENT[name]
        shape, read = found[name]
        assert shape == wanted.shape and np.array_equal(dense(read()), wanted)
        assert scipy.sparse.issparse(read()) == (name == "stiffness")
    assert all(found[name][0] is None for name in ("text", "cells", "complex", "yes", "model"))


@pytest.mark.parametrize("compressed", [False, True])
def test_reads_the_fields_of_a_struct(tmp_path, compressed):
    fields = read_mat5(written(tmp_path, CONTENT, do_compression=compressed))["model"][1]()
    assert np.array_equal(dense(fields["K"][1]()), STIFFNESS) and fields["K"][0] == (3, 3)
    assert fields["inner"][0] is None and np.array_equal(fields["inner"][1]()["M"][1](), MASS)
    with pytest.raises(MatError, match="no real matrix"):
        fields["note"][1]()


def test_an_array_of_structs_is_refused(tmp_path):
    array = np.array([[(MASS,), (MASS,)]], dtype=[("M", object)])
    with pytest.raises(MatError, match="array of structs"):
        read_mat5(written(tmp_path, {"model": array}))["model"][1]()


def test_byte_order_is_read_from_the_file(tmp_path):
    """A big-endian file, written by hand."""
    flags = struct.pack(">IIII", 6, 8, 6, 0)
    name = struct.pack(">II", 1, 4) + b"mass" + b"\0" * 4
    body = flags + struct.pack(">IIii", 5, 8, 1, 2) + name + struct.pack(">IIdd", 9, 16, 0.1, 0.2)
    content = b" " * 124 + b"\x01\x00MI" + struct.pack(">II", 14, len(body)) + body
    assert read_mat5(content)["mass"][1]().tolist() == [[0.1, 0.2]]


def test_other_levels_are_refused(tmp_path):
    with pytest.raises(MatError, match="level 5"):
        read_mat5(written(tmp_path, {"mass": MASS}, format="4"))
    with pytest.raises(MatError, match="level 5"):
        read_mat5(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + b"\x89HDF\r\n\x1a\n" + b"\0" * 600)


def test_a_bomb_is_not_unpacked():
    body = struct.pack("<IIIIIIiiII", 6, 8, 6, 0, 5, 8, 1000, 1000, 1, 4) + b"mass" + b"\0" * 4 + struct.pack("<II", 9, 8_000_000)
    packed = zlib.compress(struct.pack("<II", 14, 2**31) + body + b"\0" * 100_000_000)
    content = b" " * 124 + b"\x00\x01IM" + struct.pack("<II", 15, len(packed)) + packed
    tracemalloc.start()
    shape, read = read_mat5(content)["mass"]
    assert shape == (1000, 1000)
    with pytest.raises(MatError, match="larger than 32 MB"):
        read()
    assert tracemalloc.get_traced_memory()[1] < 10_000_000
    tracemalloc.stop()


def test_all_variables_that_are_read_share_one_cap(tmp_path):
    content = written(tmp_path, {name: {"x": np.zeros((500, 500))} for name in "abc"}, do_compression=True)
    variables = read_mat5(content, 5 * 2**20)  # of 2 MB each
    assert [list(variables[name][1]()) for name in "ab"] == [["x"], ["x"]]
    with pytest.raises(MatError, match="larger than 1 MB, what is left"):
        variables["c"][1]()


def damaged(content, dice):
    """Content with one to four bits flipped, a run of bytes overwritten, a piece cut out, or its end cut off."""
    content, place = bytearray(content), dice.randrange(len(content))
    kind = dice.randrange(4)
    if kind == 0:
        for _ in range(dice.randint(1, 4)):
            content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
    elif kind == 1:
        for i in range(place, min(place + dice.randint(1, 8), len(content))):
            content[i] = dice.choice((0, 255, dice.randrange(256)))
    elif kind == 2:
        del content[place : place + dice.randint(1, 9)]
    else:
        del content[place:]
    return bytes(content)


@pytest.mark.parametrize("compressed", [False, True])
def test_damage_is_refused_or_harmless(tmp_path, compressed):
    """Whatever a damaged file holds is read or refused, in an instant; where it is compressed a checksum covers every value."""
    content, dice = written(tmp_path, CONTENT, do_compression=compressed), random.Random(5)
    started, refused = time.perf_counter(), 0
    for _ in range(2000):
        try:
            for name, (shape, read) in read_mat5(damaged(content, dice)).items():
                if name == "model":
                    for _, of_field in read().values():
                        of_field()
                if shape is None or max(shape) > 1000:
                    continue
                matrix = dense(read())
                assert matrix.shape == shape
                if compressed and name == "mass":
                    assert np.array_equal(matrix, MASS)
        except MatError:
            refused += 1
    assert refused > 500 and time.perf_counter() - started < 10.0
