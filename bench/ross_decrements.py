"""Logarithmic decrements of ROSS's compressor at 9,000 rpm: what its skew (cross-coupled) seals and bearings do.

    python bench/ross_decrements.py             prints ROSS's beside those of rsc, with and without the skew terms
    python bench/ross_decrements.py --export    writes the model and ROSS's own numbers to data/reference/machines

Only --export needs ROSS (pip install "ross-rotordynamics==2.3.0" "plotly<7").
"""

import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import scipy.io

from rsc.analysis.alone.free_vibration import free_vibrations
from rsc.machine.ross import read_ross
from rsc.system.system import ANISOTROPIC, SKEW

ROOT = Path(__file__).parent.parent
MODEL = ROOT / "data" / "reference" / "machines" / "ross_compressor_9000rpm.mat"
NUMBERS = MODEL.with_name("ross_decrements.toml")
SPEED = 150.0  # Hz
PAIR = (155.0, 175.0)  # Hz, around the first backward and forward mode
sys.path[:0] = [str(ROOT / "tests" / "support")]

from ross_rotors import system_of  # noqa: E402


def export():
    """Matrices by ROSS's save_mat, packed, and the frequencies and decrements of its modal analysis in the pair."""
    import ross
    import ross.rotor_assembly as examples

    rotor, omega = examples.compressor_example(), 2.0 * np.pi * SPEED
    rotor.save_mat(MODEL, speed=omega)
    matrices = {key: value for key, value in scipy.io.loadmat(MODEL).items() if not key.startswith("__")}
    scipy.io.savemat(MODEL, matrices, do_compression=True)
    modal = rotor.run_modal(omega, num_modes=40)
    sense = {"Backward": -1.0, "Forward": 1.0}
    rows = [
        f"[{sense[str(way)] * wd / (2.0 * np.pi):.10g}, {decrement:.10g}]"
        for way, wd, decrement in zip(modal.whirl_direction(), modal.wd, modal.log_dec, strict=False)
        if str(way) in sense and PAIR[0] < wd / (2.0 * np.pi) < PAIR[1]
    ]
    head = f"# [frequency in Hz (negative: backward), logarithmic decrement] by run_modal of ROSS {ross.__version__},\n"
    head += "# written by `python bench/ross_decrements.py --export`.\n"
    NUMBERS.write_text(f"{head}speed = {SPEED}\npair = [{', '.join(rows)}]\n")


def pair(system):
    """Frequencies and decrements (2, 2) of the free vibrations in the pair."""
    found = [(v.frequency, v.decrement) for v in free_vibrations(system, SPEED) if PAIR[0] < abs(v.frequency) < PAIR[1]]
    return np.array(sorted(found))


def main():
    """Export, or print."""
    if "--export" in sys.argv:
        export()
    system = system_of(read_ross(MODEL, SPEED))
    mean = replace(system, **dict.fromkeys(ANISOTROPIC))
    plain = replace(mean, **dict.fromkeys(SKEW))
    print("ROSS itself                ", tomllib.loads(NUMBERS.read_text())["pair"])
    for name, made in (("rsc, all terms", system), ("rsc, isotropic and skew", mean), ("rsc, without the skew terms", plain)):
        print(f"{name:27s}", pair(made).round(4).tolist())


if __name__ == "__main__":
    main()
