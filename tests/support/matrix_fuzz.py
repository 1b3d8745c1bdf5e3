"""Damaged and lying matrix files, numbered like those of fuzz_cases.py: read or refused in one line, soon, in bounded memory."""

import io
import random
import re
import resource
import zipfile
import zlib
from pathlib import Path

import numpy as np
import scipy.io
import scipy.sparse

import fuzz_cases as fuzz
from matrix_writers import WRITERS
from rsc.errors import DataError
from rsc.machine.formats import read_matrices

MOST_FILE, MOST = 2**26, 2**26  # as for a scene
MOST_GROWTH = 400e6  # bytes that one case may take
TOKENS = (
    b"nan", b"inf", b"-inf", b"1e400", b"1e308", b"-1", b"0", b"2147483648", b"99999999999999999999", b"0x10", b"1.5", b"1D5",
    b"", b"1 2", b"\n", b"%", b"symmetric", b"skew-symmetric", b"array", b"integer", b"1000000", b"2000001", b"1e-320", b"\x00",
)  # fmt: skip
PLAIN = ("K.mat", lambda path, matrix: scipy.io.savemat(path, {"K": matrix}), "K", False, 0)
KINDS = {**WRITERS, "MAT-file of level 5, plain": PLAIN}
SHAPES = (b"(10000000, 10000000)", b"(-1, 9)", b"(0, 0)", b"(9,)", b"(3, 3, 9)", b"()", b"(1e3, 9)", b"(9, 9, 9, 9, 9)")


def originals(folder):
    """name of a format -> (file name, whole content)."""
    dice = np.random.default_rng(5)
    half = np.where(dice.random((9, 9)) < 0.4, dice.normal(size=(9, 9)), 0.0)
    contents = {}
    for kind, (name, write, *_) in KINDS.items():
        write(Path(folder, name), half + half.T + 9.0 * np.eye(9))
        contents[kind] = name, Path(folder, name).read_bytes()
    Path(folder, "job.dof").unlink()
    return contents


def damaged(content, dice):
    """Damage to the bytes, to a number or word of a text, or inside of what is packed, packed anew with its sums."""
    if content.startswith(b"PK") and dice.random() < 0.6:
        return _inside_zip(content, dice)
    if content[126:128] == b"IM" and b"MATLAB 5.0" in content[:20] and dice.random() < 0.5:
        return _inside_mat(content, dice)
    words = list(re.finditer(rb"[^\s,]+", content)) if content.isascii() else []
    if words and dice.random() < 0.6:
        for _ in range(dice.randint(1, 3)):
            word = words[min(int(dice.expovariate(1.0) * 0.2 * len(words)), len(words) - 1)]  # mostly in the head
            content = content[: word.start()] + dice.choice(TOKENS) + content[word.end() :]
        return content
    return fuzz.damaged(content, dice)


def _inside_zip(content, dice):
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as archive, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as copy:
        names = archive.namelist()
        for name in names:
            member = archive.read(name)
            if dice.random() < 1.5 / len(names):
                member = _with_shape(member, dice) if dice.random() < 0.3 else fuzz.damaged(member, dice)
            copy.writestr(name, member)
    return out.getvalue()


def _with_shape(member, dice):
    shape = dice.choice(SHAPES)
    old = re.search(rb"\([\d, ]*\)", member)
    return member if old is None else (member[: old.start()] + shape.ljust(len(old[0])) + member[old.end() :])


def _inside_mat(content, dice):
    """A variable of a MAT-file unpacked, damaged and packed again."""
    place, kind, length = 128, *np.frombuffer(content, "<u4", 2, 128)
    body = content[place + 8 : place + 8 + int(length)]
    if kind != 15:
        return content[: place + 8] + fuzz.damaged(body, dice) + content[place + 8 + len(body) :]
    packed = zlib.compress(fuzz.damaged(zlib.decompress(body), dice))
    head = np.array([15, len(packed)], "<u4").tobytes()
    return content[:place] + head + packed + content[place + 8 + len(body) :]


def one_file(number, folder, contents):
    """Read the damaged file `number`; returns what became of it, in a word."""
    dice = random.Random(number)
    kind = sorted(contents)[number % len(contents)]
    name, whole = contents[kind]
    path = Path(folder, name)
    path.write_bytes(damaged(whole, dice))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    outcome = f"{kind}: {_read(path)}"
    if 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) > MOST_GROWTH:
        raise AssertionError("too much memory was taken")
    return outcome


def _read(path):
    try:
        matrices = read_matrices(path, MOST_FILE, MOST).matrices
    except DataError as error:
        fuzz.one_line(error)
        return "refused"
    for matrix in matrices.values():
        if not np.all(np.isfinite(matrix.data if scipy.sparse.issparse(matrix) else matrix)):
            raise AssertionError("an entry is not finite")
    return "read"


def files(numbers, folder):
    """(case, outcome, seconds) of damaged matrix files."""
    contents = originals(folder)
    for number in numbers:
        yield fuzz.case(number, one_file, folder, contents)
