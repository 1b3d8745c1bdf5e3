"""Every format gives back the matrix that a plain writer wrote; damaged, lying and foreign files are refused in one line."""

import contextlib
import os
import random
import re
import time
import tracemalloc
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.sparse

from matrix_writers import LABELLED, WRITERS, labels, market_sparse
from rsc.errors import DataError
from rsc.machine import formats
from rsc.machine.formats import read_matrices

ROOT = Path(__file__).parents[3]


def stiffness(size=14):
    """A symmetric matrix with empty places, of many magnitudes."""
    dice = np.random.default_rng(3)
    half = np.where(
        dice.random((size, size)) < 0.3, dice.normal(size=(size, size)) * 10.0 ** dice.integers(-3, 9, (size, size)), 0.0
    )
    return half + half.T + np.diag(1e9 + dice.random(size))


def dense(matrix):
    return matrix.toarray() if scipy.sparse.issparse(matrix) else matrix


def refusal(path):
    with pytest.raises(DataError) as caught:
        read_matrices(path)
    message = str(caught.value)
    assert str(path) in message and "\n" not in message
    return message


@pytest.mark.parametrize("kind", WRITERS)
def test_gives_back_what_was_written(kind, tmp_path):
    name, write, key, is_sparse, error = WRITERS[kind]
    write(tmp_path / name, stiffness())
    found = read_matrices(tmp_path / name)
    assert scipy.sparse.issparse(found.matrices[key]) == is_sparse
    assert dense(found.matrices[key]) == pytest.approx(stiffness(), rel=error, abs=0.0)
    assert found.matrices[key].dtype == np.float64
    assert (key in found.labels) == (kind in LABELLED)
    if kind in LABELLED:
        assert np.array_equal(found.labels[key], labels(14))


def test_every_format_has_a_writer_and_stands_in_the_documents(tmp_path):
    """So it runs through all tests here and through the damaged files of matrix_fuzz.py."""
    seen = set()
    for name, write, *_ in WRITERS.values():
        write(tmp_path / name, stiffness())
        seen.add(formats.reader_of((tmp_path / name).read_bytes()).name)
    assert seen == {reader.name for reader in formats.READERS}
    page = " ".join((ROOT / "docs/users/machines.md").read_text(encoding="utf-8").split())
    named = re.search(r"The format is detected from the content: (.*?) output\.", page)[1]
    words = {"MAT-file": "MAT", "OUTPUT4 as text": "OP4", "Abaqus or CalculiX output": "CalculiX"}
    assert [name for name in seen if words.get(name, name) not in named] == []


@pytest.mark.parametrize("kind", [kind for kind in WRITERS if "MAT" not in kind.split("-")[0] and "npz" not in kind])
def test_line_ends_of_windows_do_not_matter(kind, tmp_path):
    name, write, key, *_ = WRITERS[kind]
    write(tmp_path / name, stiffness())
    before = read_matrices(tmp_path / name)
    for path in tmp_path.iterdir():
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    after = read_matrices(tmp_path / name)
    assert np.array_equal(dense(after.matrices[key]), dense(before.matrices[key])) and after.labels.keys() == before.labels.keys()


def test_what_is_no_real_matrix_is_left_out_and_axes_of_level_73_are_reversed(tmp_path):
    name, write, *_ = WRITERS["MAT-file of level 7.3, struct"]
    write(tmp_path / name, stiffness())
    found = read_matrices(tmp_path / name).matrices
    assert set(found) == {"model.K", "dense"}
    assert np.array_equal(found["dense"], np.tril(stiffness()))


def test_entries_at_one_place_add_up(tmp_path):
    (tmp_path / "a.mtx").write_text("%%MatrixMarket matrix coordinate real general\n2 2 3\n1 1 1.5\n1 1 2.0\n2 2 1\n")
    assert dense(read_matrices(tmp_path / "a.mtx").matrices["a"]).tolist() == [[3.5, 0.0], [0.0, 1.0]]


def test_skew_symmetric_matrices_have_both_signs(tmp_path):
    (tmp_path / "g.mtx").write_text("%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n2 1 3.0\n")
    (tmp_path / "h.mtx").write_text("%%MatrixMarket matrix array real skew-symmetric\n3 3\n1\n2\n3\n")
    assert dense(read_matrices(tmp_path / "g.mtx").matrices["g"]).tolist() == [[0.0, -3.0], [3.0, 0.0]]
    assert read_matrices(tmp_path / "h.mtx").matrices["h"].tolist() == [[0, -1, -2], [1, 0, -3], [2, 3, 0]]


def test_scipy_writes_what_is_read(tmp_path):
    scipy.io.mmwrite(tmp_path / "a.mtx", scipy.sparse.csc_array(stiffness()), precision=17)
    scipy.io.hb_write(tmp_path / "b.rua", scipy.sparse.csc_array(stiffness()))
    assert np.array_equal(dense(read_matrices(tmp_path / "a.mtx").matrices["a"]), stiffness())
    assert np.array_equal(dense(read_matrices(tmp_path / "b.rua").matrices["b"]), stiffness())


def test_an_unsymmetric_matrix_of_abaqus_stays_so(tmp_path):
    (tmp_path / "a.mtx").write_text("*MATRIX INPUT, NAME=K, TYPE=UNSYMMETRIC\n1, 1, 1, 1, 2.0\n1, 2, 1, 1, 3.0\n1,2,1,2,5.\n")
    assert dense(read_matrices(tmp_path / "a.mtx").matrices["a"]).tolist() == [[2.0, 0.0], [3.0, 5.0]]


def test_strings_of_single_precision_take_one_word_a_number(tmp_path):
    """OUTPUT4, real single (type 1): a string of two numbers has L + 1 = 3; a complex matrix before it is stepped over."""
    complex_one = (
        "       1       1       6       3C       1P,2E16.9\n       1       1       2\n 1.0E+00         2.0E+00        \n"
    )
    ends = "       2       1       1\n 1.0E+00\n"
    real = "       2       2       2       1K       1P,5E16.9\n       1       0       3\n          196609\n"
    real += f"{4.5:16.9E}{-1.0:16.9E}\n       3       1       1\n 1.0E+00\n"
    (tmp_path / "a.op4").write_text(complex_one + ends + real)
    found = read_matrices(tmp_path / "a.op4").matrices
    assert list(found) == ["K"] and dense(found["K"]).tolist() == [[4.5, 0.0], [-1.0, 0.0]]


LIES = {
    "sparse": ("%%MatrixMarket matrix coordinate real general\n1000000 1000000 1000000000\n1 1 1\n", "declares"),
    "dense": ("%%MatrixMarket matrix array real general\n100000 100000\n1\n", "too short"),
    "huge": ("%%MatrixMarket matrix coordinate real general\n10000000 10000000 1\n1 1 1\n", "2000000 coordinates"),
    "outside": ("%%MatrixMarket matrix coordinate real general\n2 2 1\n3 1 1\n", "a row is not an integer from 1 to 2"),
    "nan": ("%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1 nan\n", "nan"),
    "complex": ("%%MatrixMarket matrix coordinate complex general\n2 2 1\n1 1 1 1\n", "not real"),
    "both sides": ("%%MatrixMarket matrix coordinate real symmetric\n2 2 2\n1 2 1\n2 1 1\n", "both sides"),
    "words": ("%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1 one\n", "other than a number"),
    "OUTPUT4": ("       2       2       6       2K       1P,3E24.16\n       1       1999999999\n 1.0\n", "cut off"),
    "Harwell-Boeing": (
        f"{'x':80}\n   3   1   1   1   0\nRSA           999999 999999 999999999 0\n(1I9)  (1I9)  (1E9.1)\n1\n1\n1\n",
        "too short",
    ),
    "far node": ("1,1,1,1,1.\n1e30,1,1,1,1.\n", "a node is not an integer"),
    "row far away": ("9000000 9000000 1.0\n", "from 1 to 2000000"),
    "Lagrange": ("-1,1,1,1,1.\n", "Lagrange"),
    "four numbers": ("1 2 3 4", "unknown format"),
    "nothing": ("", "unknown format"),
    "prose": ("Dear reader,\n", "unknown format"),
}


@pytest.mark.parametrize("kind", LIES)
def test_a_lie_is_refused_before_memory_is_taken(kind, tmp_path):
    text, reason = LIES[kind]
    (tmp_path / "a.mtx").write_text(text)
    tracemalloc.start()
    message = refusal(tmp_path / "a.mtx")
    assert reason in message and tracemalloc.get_traced_memory()[1] < 20_000_000
    tracemalloc.stop()


MARKET, STRINGS = b"%%MatrixMarket matrix coordinate real general\n", b"       2       2       2       1K       1P,5E16.9\n"
HARWELL = f"{'x':80}\n   3   1   1   1   0\nRSA           3 3 3 0\n".encode()
# beginning, what fills the file, and end
FILLED = {
    "Harwell-Boeing, spaces in its formats": (HARWELL + b"(", b" ", b"\n1\n"),
    "Harwell-Boeing, digits in its formats": (HARWELL + b"(", b"1", b"\n1\n"),
    "Harwell-Boeing, blank lines": (HARWELL + b"(1000I1)  (1000I1)  (1000E1.1)\n1 4 4 4\n", b"\n", b""),
    "Matrix Market, comments": (MARKET, b"%\n", b"2 2 1\n1 1 1\n"),
    "Matrix Market, entries on one line": (MARKET + b"2 2 1\n", b"1 1 1 ", b""),
    "Abaqus, keywords": (b"1,1,1,1,1\n", b"*\n", b""),
    "Abaqus, TYPE": (b"*", b"TYPE = ", b"\n1 1 1\n"),
    "Abaqus, labels": (b"", b"1,1,1,1,1\n", b""),
    "DMIG, other lines": (b"DMIG,K,0,6,2,0,,,2\n", b"x\n", b""),
    "DMIG, commas": (b"DMIG,K,0,6,2,0,,,2\nDMIG,K,1,1,,1,1,1.\n", b",", b""),
    "DMIG, entries": (b"DMIG,K,0,6,2,0,,,2\nDMIG,K,1,1,,1,1,1.\n", b",1,1,1\n", b""),
    "OUTPUT4, short strings": (STRINGS + b"       1       099999999\n", b"131073\n1.\n", b""),
    "OUTPUT4, digits in its header": (b"", b"1", b""),
    "spaces": (b"", b" ", b""),
}


def fill(path, kind, size):
    begin, middle, end = FILLED[kind]
    path.write_bytes(begin + middle * (size // len(middle)) + end)


def seconds_to_read(path):
    """The least of three: a collection of what earlier tests left counts as time of this process too."""
    taken = []
    for _ in range(3):
        started = time.process_time()
        with contextlib.suppress(DataError):
            read_matrices(path)
        taken.append(time.process_time() - started)
    return min(taken)


@pytest.mark.parametrize("kind", FILLED)
def test_time_grows_with_the_size_of_a_file(kind, tmp_path):
    seconds = []
    for size in (50_000, 400_000):
        fill(tmp_path / "a.mtx", kind, size)
        seconds.append(seconds_to_read(tmp_path / "a.mtx"))
    assert seconds[1] < 20.0 * seconds[0] + 0.5  # eight times the size; the square would be 64 times


@pytest.mark.parametrize("kind", ["Matrix Market, comments", "Abaqus, keywords", "Harwell-Boeing, blank lines"])
def test_short_lines_take_no_multiple_of_their_bytes(kind, tmp_path):
    fill(tmp_path / "a.mtx", kind, 4_000_000)
    tracemalloc.start()
    try:
        with contextlib.suppress(DataError):
            read_matrices(tmp_path / "a.mtx")
        assert tracemalloc.get_traced_memory()[1] < 80_000_000
    finally:
        tracemalloc.stop()


def test_many_matrices_of_a_small_file_are_refused(tmp_path):
    one = " 2000000 2000000       2       1K{:<7d}1P,5E16.9\n       1       1       1\n 1.0E+00\n"
    one += " 2000001       1       1\n 1.0E+00\n"
    (tmp_path / "a.op4").write_text("".join(map(one.format, range(200))))
    assert "too much memory" in refusal(tmp_path / "a.op4")
    with h5py.File(tmp_path / "a.mat", "w") as file:
        for name in map(str, range(20)):
            file[name] = file["/"]  # a group that holds itself
    assert "too many arrays" in refusal(tmp_path / "a.mat")


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("bytes_each", [4, 8])
def test_binary_output4_is_told_as_such(order, bytes_each, tmp_path):
    mark = np.array([6 * bytes_each], order + "i4").tobytes()
    (tmp_path / "a.op4").write_bytes(mark + np.array([9, 9, 6, 2, 0, 0], f"{order}i{bytes_each}").tobytes() + mark + bytes(200))
    assert "OUTPUT4 in binary form; write it as text" in refusal(tmp_path / "a.op4")


def test_an_array_without_numbers_or_of_another_shape_is_no_matrix(tmp_path):
    for values in (np.array(["a", "b"]), np.ones((2, 2), complex), np.ones(4), np.float64(1.0)):
        np.save(tmp_path / "a.npy", values)
        assert "no real matrix" in refusal(tmp_path / "a.npy")


@pytest.mark.parametrize("header", ["{" + "(" * 300, "{'descr': '<f8', 'fortran_order': False, 'shape': (True, 1), }", "\0"])
def test_a_header_that_is_none_or_cut_is_told(header, tmp_path):
    content = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode() + bytes(72)
    for part in (content, content[: 9 + len(header) // 2]):
        (tmp_path / "a.npy").write_bytes(part)
        assert "no readable header" in refusal(tmp_path / "a.npy")


@pytest.mark.skipif(not os.path.exists("/proc/self/mem"), reason="needs a file that cannot be read where it begins")
def test_an_error_of_the_disk_is_told():
    assert "input/output error" in refusal(Path("/proc/self/mem"))


@pytest.mark.parametrize("how", [{}, {"chunks": (100, 100), "compression": "gzip"}, {"compression": "lzf"}, {"scaleoffset": 3}])
def test_an_array_that_was_never_written_or_is_packed_otherwise_is_refused(how, tmp_path):
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file.create_dataset("K", (2000, 2000), "f8", **how)
    assert "an array is" in refusal(tmp_path / "a.mat")
    with h5py.File(tmp_path / "b.mat", "w") as file:
        file.create_dataset("K", data=np.zeros((2000, 2000)), compression="gzip", compression_opts=9, shuffle=True)
    assert not dense(read_matrices(tmp_path / "b.mat").matrices["K"]).any()


def test_binary_files_that_announce_too_much_are_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        header = (
            b"\x93NUMPY\x01\x00\x76\x00"
            + b"{'descr': '<f8', 'fortran_order': False, 'shape': (100000, 100000), }".ljust(117)
            + b"\n"
        )
        archive.writestr("K.npy", header + b"\0" * 800)
    assert "takes 80000000000 bytes but the file has" in refusal(tmp_path / "a.npz")
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file.create_dataset("K", (100000, 100000), "f8", chunks=(100, 100))
        file["outside"] = h5py.ExternalLink("/etc/passwd", "x")
    assert "numbers" in refusal(tmp_path / "a.mat")
    np.savez(tmp_path / "b.npz", K=np.array([{1: 2}], dtype=object))
    assert "no real matrix" in refusal(tmp_path / "b.npz")


def test_only_regular_files_are_read(tmp_path):
    os.mkfifo(tmp_path / "pipe.mtx")
    assert "not a regular file" in refusal(tmp_path / "pipe.mtx")
    assert "no such file" in refusal(tmp_path / "absent.mtx")


def test_directions_of_calculix_must_fit(tmp_path):
    name, write, *_ = WRITERS["CalculiX"]
    write(tmp_path / name, stiffness())
    (tmp_path / "job.dof").write_text("1.1\n1.2\n")
    assert "14 rows but job.dof has 2" in refusal(tmp_path / name)


def damaged(content, dice):
    """Content with bytes changed, a piece cut out, or its end cut off."""
    content, place = bytearray(content), dice.randrange(len(content))
    kind = dice.randrange(4)
    if kind == 0:
        for _ in range(dice.randint(1, 4)):
            content[dice.randrange(len(content))] = dice.choice(b"0123456789-+.eED \n,*%" + bytes([dice.randrange(256)]))
    elif kind == 1:
        content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
    elif kind == 2:
        del content[place : place + dice.randint(1, 30)]
    else:
        del content[place:]
    return bytes(content)


@pytest.mark.parametrize("kind", WRITERS)
def test_damage_is_refused_or_harmless(kind, tmp_path):
    """A damaged file is read or refused in one line, in an instant, and never with an entry that is no number."""
    name, write, *_ = WRITERS[kind]
    write(tmp_path / name, stiffness(8))
    content, dice, started = (tmp_path / name).read_bytes(), random.Random(kind), time.perf_counter()
    for _ in range(150):
        (tmp_path / name).write_bytes(damaged(content, dice))
        try:
            found = read_matrices(tmp_path / name).matrices
        except DataError as error:
            assert "\n" not in str(error)
            continue
        for matrix in found.values():
            assert np.all(np.isfinite(matrix.data if scipy.sparse.issparse(matrix) else matrix))
    assert time.perf_counter() - started < 20.0


def test_a_matrix_of_a_hundred_thousand_coordinates_stays_sparse(tmp_path):
    n = 100_000
    ones = np.ones(n)
    matrix = scipy.sparse.diags_array([-ones[1:], 2.0 * ones], offsets=[-1, 0]).tocoo()
    lines = np.column_stack([matrix.row + 1, matrix.col + 1, matrix.data])
    with open(tmp_path / "K.mtx", "w") as file:
        file.write(f"%%MatrixMarket matrix coordinate real symmetric\n{n} {n} {len(lines)}\n")
        np.savetxt(file, lines, fmt="%d %d %.17g")
    found = read_matrices(tmp_path / "K.mtx").matrices["K"]
    assert found.shape == (n, n) and found.nnz == 3 * n - 2 and abs(found - found.T).max() == 0.0


def test_the_suffix_does_not_matter(tmp_path):
    market_sparse(tmp_path / "K.txt", stiffness())
    assert np.array_equal(dense(read_matrices(tmp_path / "K.txt").matrices["K"]), stiffness())
