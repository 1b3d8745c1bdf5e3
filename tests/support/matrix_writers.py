"""One symmetric matrix written in every format that `rsc.machine.formats` reads, plainly and apart from the readers.

Each writer takes (path, matrix), a dense symmetric array whose row k belongs to direction k % 6 + 1 of node 10 + k // 6.
"""

import csv

import h5py
import numpy as np
import scipy.io
import scipy.sparse


def labels(size):
    """(size, 2) node and direction of every row."""
    return np.array([(10 + k // 6, k % 6 + 1) for k in range(size)])


def entries(matrix, triangle=True):
    """(row, column, value) of the entries that are not 0, column by column, of the lower triangle or all."""
    n = len(matrix)
    return [(i, j, matrix[i, j]) for j in range(n) for i in range(j if triangle else 0, n) if matrix[i, j] != 0.0]


def market_sparse(path, matrix):
    lines = [f"{i + 1} {j + 1} {value:.17e}" for i, j, value in entries(matrix)]
    head = f"%%MatrixMarket matrix coordinate real symmetric\n% made for a test\n{len(matrix)} {len(matrix)} {len(lines)}\n"
    path.write_text(head + "\n".join(lines) + "\n")


def market_dense(path, matrix):
    values = [f"{value:.17e}" for value in matrix.T.ravel()]
    path.write_text(f"%%MatrixMarket matrix array real general\n{len(matrix)} {len(matrix)}\n" + "\n".join(values) + "\n")


def harwell_boeing(path, matrix):
    """RSA with fields that touch each other."""
    found = entries(matrix)
    starts = [1 + sum(j < column for _, j, _ in found) for column in range(len(matrix) + 1)]
    blocks = [
        [f"{start:5d}" for start in starts],
        [f"{i + 1:5d}" for i, _, _ in found],
        [f"{value:24.16E}".replace("E", "D") for _, _, value in found],
    ]
    lines = [
        ["".join(block[k : k + per]) for k in range(0, len(block), per)] for block, per in zip(blocks, (16, 16, 3), strict=True)
    ]
    counts = [sum(map(len, lines)), *map(len, lines), 0]
    head = ["a matrix made for a test".ljust(72) + "KEY".ljust(8), "".join(f"{count:14d}" for count in counts)]
    head += ["RSA".ljust(14) + "".join(f"{n:14d}" for n in (len(matrix), len(matrix), len(found), 0))]
    head += ["(16I5)".ljust(16) + "(16I5)".ljust(16) + "(1P,3D24.16)".ljust(20) + " " * 20]
    path.write_text("\n".join(head + lines[0] + lines[1] + lines[2]) + "\n")


def mat_5(path, matrix):
    scipy.io.savemat(path, {"K": scipy.sparse.csc_array(matrix), "dense": matrix, "note": "abc"}, do_compression=True)


def mat_5_struct(path, matrix):
    scipy.io.savemat(path, {"model": {"K": scipy.sparse.csc_array(matrix), "note": "abc"}})


def mat_73(path, matrix):
    """As MATLAB does: its header before the HDF5 file, sparse matrices as groups, structs as groups."""
    with h5py.File(path, "w", userblock_size=512) as file:
        model = file.create_group("model")
        model.attrs["MATLAB_class"] = np.bytes_("struct")
        group, packed = model.create_group("K"), scipy.sparse.csc_array(matrix)
        group.attrs["MATLAB_sparse"] = np.uint64(len(matrix))
        group["data"], group["ir"], group["jc"] = packed.data, packed.indices.astype("u8"), packed.indptr.astype("u8")
        file["dense"] = np.tril(matrix).T  # reversed axes
        file["dense"].attrs["MATLAB_class"] = np.bytes_("double")
        file["note"] = np.array([[97], [98]], "u2")
        file["note"].attrs["MATLAB_class"] = np.bytes_("char")
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def npz_arrays(path, matrix):
    with open(path, "wb") as file:
        np.savez(file, K=matrix, names=np.array(["a", "b"]))


def npz_sparse(path, matrix):
    with open(path, "wb") as file:
        scipy.sparse.save_npz(file, scipy.sparse.csr_array(matrix))


def op4(path, matrix, form):
    """OUTPUT4 as text, double: "dense", "sparse" or "bigmat"."""
    n = len(matrix)
    lines = [f"{n:8d}{-n if form == 'bigmat' else n:8d}{6:8d}{2:8d}{'K':8s}1P,3E24.16"]

    def put(values):
        lines.extend("".join(f"{value:24.16E}" for value in values[k : k + 3]) for k in range(0, len(values), 3))

    for j in range(n):
        rows = np.flatnonzero(matrix[:, j])
        if form == "dense":
            first, last = rows[0], rows[-1]
            lines.append(f"{j + 1:8d}{first + 1:8d}{last - first + 1:8d}")
            put(matrix[first : last + 1, j])
            continue
        runs = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
        words = [2 * len(run) + (2 if form == "bigmat" else 1) for run in runs]
        lines.append(f"{j + 1:8d}{0:8d}{sum(words):8d}")
        for run in runs:
            length, row = 2 * len(run) + 1, int(run[0]) + 1
            lines.append(f"{length:8d}{row:8d}" if form == "bigmat" else f"{row + 65536 * length:16d}")
            put(matrix[run, j])
    lines += [f"{n + 1:8d}{1:8d}{1:8d}", f"{1.0:24.16E}"]
    path.write_text("\n".join(lines) + "\n")


def dmig(path, matrix, form):
    """Bulk data: "wide" (16 columns), "small" (8 columns) or "free" (commas); symmetric, lower triangle."""
    places = labels(len(matrix))
    head = {"free": "DMIG,K,0,6,2,0,,,{n}", "small": "DMIG    K       " + f"{0:8d}{6:8d}{2:8d}{0:8d}"}
    head["wide"] = head["small"]
    lines = ["$ punched", "BEGIN BULK", "GRID,10,,0.,0.,0.", head[form].format(n=len(matrix))]
    for j in range(len(matrix)):
        found = [(*places[i], value) for i, column, value in entries(matrix) if column == j]
        if form == "wide":
            lines.append(f"{'DMIG*':8s}{'K':16s}{places[j][0]:16d}{places[j][1]:16d}")
            lines += [f"{'*':8s}{g:16d}{c:16d}" + f"{value:16.9E}".replace("E", "D") for g, c, value in found]
        elif form == "small":
            for k, (g, c, value) in enumerate(found):
                short = f"{value:8.2E}".replace("E+0", "+").replace("E-0", "-").replace("E", "")  # an exponent without its letter
                start = f"{'DMIG':8s}{'K':8s}{places[j][0]:8d}{places[j][1]:8d}{'':8s}" if k == 0 else f"{'+':8s}"
                lines.append(f"{start}{g:8d}{c:8d}{short:>8s}")
        else:
            (g, c, value), *more = found
            lines.append(f"DMIG,K,{places[j][0]},{places[j][1]},,{g},{c},{value:.17E}")
            lines += [f",{g},{c},{value:.17E}" for g, c, value in more]
    path.write_text("\n".join([*lines, "ENDDATA"]) + "\n")


def abaqus_labels(path, matrix):
    """*MATRIX OUTPUT, FORMAT=MATRIX INPUT, one triangle."""
    places = labels(len(matrix))
    lines = ["** STIFFNESS MATRIX", "*MATRIX ASSEMBLE"]
    lines += [f"{places[i][0]}, {places[i][1]}, {places[j][0]}, {places[j][1]}, {value:.17e}" for i, j, value in entries(matrix)]
    path.write_text("\n".join(lines) + "\n")


def abaqus_coordinate(path, matrix):
    """*MATRIX OUTPUT, FORMAT=COORDINATE, both triangles."""
    path.write_text("\n".join(f"{i + 1} {j + 1} {value:.17e}" for i, j, value in entries(matrix, triangle=False)) + "\n")


def calculix(path, matrix):
    """.sti and .dof: row <= column, both increasing by columns."""
    upper = sorted(((j, i, value) for i, j, value in entries(matrix)), key=lambda entry: (entry[1], entry[0]))
    path.write_text("\n".join(f"{i + 1} {j + 1} {value:20.13e}" for i, j, value in upper) + "\n")
    path.with_suffix(".dof").write_text("".join(f"{node}.{direction}\n" for node, direction in labels(len(matrix))))


# name -> (file name, writer, name of the matrix in the file, whether it is read sparse, relative error of what is written)
# an NLRGAP at node 11, in small form, with its tables
DECK = """\
$ a seal
NLRGAP        21      11      40      XY       3      10       6    .025
TABLED1        3
+            0.0  2.5E+7    10.0   2.5+7    ENDT
TABLED1       10
+            0.0  2.0E-4     1.0  2.0E-4    ENDT
TABLED1        6
+            0.0     .15     1.0     .15    ENDT
"""

WRITERS = {
    "Matrix Market, coordinate": ("K.mtx", market_sparse, "K", True, 0.0),
    "Matrix Market, array": ("K.mtx", market_dense, "K", False, 0.0),
    "Harwell-Boeing": ("K.rsa", harwell_boeing, "K", True, 0.0),
    "MAT-file of level 5": ("K.mat", mat_5, "K", True, 0.0),
    "MAT-file of level 5, struct": ("K.mat", mat_5_struct, "model.K", True, 0.0),
    "MAT-file of level 7.3, struct": ("K.mat", mat_73, "model.K", True, 0.0),
    "npz": ("K.npz", npz_arrays, "K", False, 0.0),
    "npz, sparse": ("K.npz", npz_sparse, "K", True, 0.0),
    "OUTPUT4, dense": ("K.op4", lambda path, matrix: op4(path, matrix, "dense"), "K", True, 0.0),
    "OUTPUT4, sparse": ("K.op4", lambda path, matrix: op4(path, matrix, "sparse"), "K", True, 0.0),
    "OUTPUT4, BIGMAT": ("K.op4", lambda path, matrix: op4(path, matrix, "bigmat"), "K", True, 0.0),
    "DMIG, wide": ("K.pch", lambda path, matrix: dmig(path, matrix, "wide"), "K", True, 1e-9),
    "DMIG, small": ("K.pch", lambda path, matrix: dmig(path, matrix, "small"), "K", True, 5e-3),
    "DMIG, free": ("K.bdf", lambda path, matrix: dmig(path, matrix, "free"), "K", True, 0.0),
    "Abaqus, labels": ("job_STIF1.mtx", abaqus_labels, "job_STIF1", True, 0.0),
    "Abaqus, coordinate": ("job_STIF1.mtx", abaqus_coordinate, "job_STIF1", True, 0.0),
    "CalculiX": ("job.sti", calculix, "job", True, 1e-13),
}
LABELLED = ("DMIG, wide", "DMIG, small", "DMIG, free", "Abaqus, labels", "CalculiX")


def written_fe(folder, body):
    """Matrix Market files and the coordinate table of a body (matrices, nodes, directions)."""
    matrices, nodes, directions = body
    for name, matrix in matrices.items():
        scipy.io.mmwrite(folder / f"{name}.mtx", matrix)
    with open(folder / "table.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("node", "direction"))
        short = {"z": "other", "rz": "other"}
        writer.writerows((node, short.get(direction, direction)) for node, direction in zip(nodes, directions, strict=True))
    return [f"--{name}={folder / name}.mtx" for name in matrices] + ["--coordinates", str(folder / "table.csv")]
