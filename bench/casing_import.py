"""What reading a casing of 100,000 coordinates costs: its files, its checks, and both directions at the contact.

    python bench/casing_import.py            prints the table, some minutes
    python bench/casing_import.py --write    keeps it in bench/results

Thick cylinders of bars with coupled axial motion, mass and stiffness as sparse .npz and Matrix Market files. Each size runs in a
process of its own; memory is its largest resident size, times are processor times.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import scipy.io
import scipy.sparse

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT / "tools")]

from fe_bodies import cylinder  # noqa: E402
from pages import RESULTS, write_page  # noqa: E402
from rsc.machine.formats import read_matrices  # noqa: E402
from rsc.machine.importing import import_fe  # noqa: E402

SIZES = ((20, 32), (40, 48), (100, 112))  # nodes along and around
BAND = 500.0  # Hz


def row(n_axial, n_around):
    """One line of the table."""
    matrices, nodes, directions = cylinder(n_axial, n_around)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for role in ("mass", "stiffness"):
            scipy.sparse.save_npz(folder / f"{role}.npz", matrices[role])
        scipy.io.mmwrite(folder / "stiffness.mtx", matrices["stiffness"], symmetry="symmetric")
        table = "".join(f"{node},{direction}\n" for node, direction in zip(nodes, directions, strict=True))
        (folder / "table.csv").write_text("node,direction\n" + table)
        started = time.process_time()
        text = read_matrices(folder / "stiffness.mtx").matrices["stiffness"]
        reading = time.process_time() - started
        assert abs(text - matrices["stiffness"]).max() <= 1e-9 * abs(text).max()
        started = time.process_time()
        options = {"coordinates": folder / "table.csv", "stator": True, "contact": int(nodes[-1]), "band": BAND}
        model = import_fe(folder / "mass.npz", folder / "stiffness.npz", **options)
        importing = time.process_time() - started
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return f"| {model.n} | {matrices['stiffness'].nnz / 1e6:.1f} | {reading:.1f} | {importing:.0f} | {memory:.1f} |"


def main():
    """Print or keep the table; with two numbers, one line of it."""
    if len(sys.argv) == 3:
        print(row(int(sys.argv[1]), int(sys.argv[2])))
        return
    lines = [
        "| coordinates | entries of K, millions | its Matrix Market file read, s | import, s | memory, GB |",
        "|---|---|---|---|---|",
    ]
    for size in SIZES:
        command = [sys.executable, __file__, *map(str, size)]
        lines.append(subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip())
    print("\n".join(lines))
    if "--write" in sys.argv:
        title, command = "Importing a casing", "python bench/casing_import.py --write"
        write_page(RESULTS / "casing_import.md", title, command, "\n".join(lines))


if __name__ == "__main__":
    main()
