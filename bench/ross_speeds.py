"""ROSS's compressor over its speed, into data/reference/machines (needs ROSS 2.3.0: pip install ross-rotordynamics==2.3.0).

    python bench/ross_speeds.py

writes what `rotor.save_mat` writes at four rotor speeds, packed, and frequency (Hz, negative: backward) and logarithmic decrement
of the first backward and forward mode by ROSS's own modal analysis at these and at two speeds between.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import ross
import scipy.io

FOLDER = Path(__file__).parents[1] / "data" / "reference" / "machines"
KNOTS, BETWEEN = (4000, 6000, 8500, 11000), (7000, 10000)  # rpm


def first_pair(rotor, rpm):
    """[frequency, decrement] of the backward and the forward mode at some 160 Hz."""
    modal = rotor.run_modal(rpm * np.pi / 30.0, num_modes=24)
    senses = modal.whirl_direction()
    own = []
    for sense, sign in (("Backward", -1.0), ("Forward", 1.0)):
        near = [i for i, f in enumerate(modal.wd / (2.0 * np.pi)) if senses[i] == sense and 150.0 < f < 180.0]
        i = min(near, key=lambda i: modal.log_dec[i])
        own.append([float(f"{sign * modal.wd[i] / (2.0 * np.pi):.10g}"), float(f"{modal.log_dec[i]:.10g}")])
    return own


def main():
    rotor = ross.compressor_example()
    with TemporaryDirectory() as folder:
        for rpm in KNOTS:
            file = Path(folder) / "compressor.mat"
            rotor.save_mat(file, rpm * np.pi / 30.0)
            content = scipy.io.loadmat(file)
            matrices = {name: content[name] for name in ("M", "K", "C", "G", "nodes")}
            scipy.io.savemat(FOLDER / f"ross_compressor_{rpm}rpm.mat", matrices, do_compression=True)
    head = "# [rpm, [backward frequency in Hz, logarithmic decrement], [forward ...]] by ROSS 2.3.0: bench/ross_speeds.py\n"
    rows = [f"    [{rpm}, {', '.join(map(str, first_pair(rotor, rpm)))}],\n" for rpm in sorted(KNOTS + BETWEEN)]
    (FOLDER / "ross_compressor_speeds.toml").write_text(head + "pairs = [\n" + "".join(rows) + "]\n")


if __name__ == "__main__":
    main()
