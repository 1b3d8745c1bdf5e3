"""Memory of a long run to a file: `rsc run` of 26 coordinates, 600 s at 2 kHz, in a process of its own.

    python bench/memory.py [--duration 600] [--write]

A chain of 23 disks rubs in a chain of three stator masses. Peak: VmHWM of the process at its end, interpreter and libraries
included; predicted: what `rsc run` prints before it starts. "compiling": its cache is empty, so the kernel is compiled first.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from rsc.scene.scene import Scene

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from pages import RESULTS, write_page  # noqa: E402

N_ROTOR, N_STATOR = 23, 3
LIMIT = 300e6  # bytes
CHILD = """
import sys
from rsc.cli import main
code = main(["run", "scene.toml", "-o", "run.h5"])
# not getrusage: its peak is inherited from the process that started this one
print("peak", next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM:")), "kB")
sys.exit(code)
"""


def scene(duration):
    """Chain of disks in a chain of masses, first frequencies 30 and 150 Hz, rubbing along a slow run-up through resonance."""
    k_r = (2.0 * np.pi * 30.0 / (2.0 * np.sin(0.5 * np.pi / (N_ROTOR + 1)))) ** 2
    k_s = 0.25 * (2.0 * np.pi * 150.0 / (2.0 * np.sin(0.5 * np.pi / (2 * N_STATOR + 1)))) ** 2
    return Scene.from_dict(
        {
            "title": f"chain of {N_ROTOR} disks in a chain of {N_STATOR} masses",
            "rotor": {
                "model": "chain",
                "masses": [1.0] * N_ROTOR,
                "stiffnesses": [k_r] * (N_ROTOR + 1),
                "damping_ratio": 0.02,
                "eccentricity": 1e-4,
            },
            "stator": {
                "model": "chain",
                "masses": [0.25] * N_STATOR,
                "stiffnesses": [k_s] * N_STATOR + [0.0],
                "damping_ratio": 0.1,
            },
            "contact": {
                "rotor_coordinate": N_ROTOR // 2,
                "stator_coordinate": N_STATOR - 1,
                "gap": 1e-3,
                "friction": 0.05,
                "stiffness": 3.55e6,
                "damping_ratio": 0.05,
            },
            "drive": {"speed": [25.0, 40.0], "duration": duration},
            "start": {"rest": True},
            "output": {"rate": 2000.0},
        }
    )


def run(folder, duration, cache):
    """(bytes predicted, bytes at the peak, bytes of the file, seconds) of `rsc run` in a process of its own."""
    (folder / "scene.toml").write_text(scene(duration).to_toml())
    environment = os.environ | {"XDG_CACHE_HOME": str(cache)}
    begun = time.monotonic()
    done = subprocess.run([sys.executable, "-c", CHILD], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    seconds, said = time.monotonic() - begun, done.stdout + done.stderr
    if done.returncode:
        raise SystemExit(said)
    predicted, unit = re.search(r"will hold ([\d.]+) (MB|GB) of memory", said).groups()
    peak = 1024 * int(re.search(r"^peak (\d+) kB", said, re.MULTILINE)[1])
    return float(predicted) * {"MB": 1e6, "GB": 1e9}[unit], peak, (folder / "run.h5").stat().st_size, seconds


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--duration", type=float, default=600.0, help="s")
    parser.add_argument("--write", action="store_true", help="keep the table in bench/results")
    options = parser.parse_args()
    lines = ["| run | samples | file, MB | predicted, MB | peak, MB (to predicted) | wall s |", "|---|---|---|---|---|---|"]
    short = min(options.duration, 6.0)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for what, duration in ((f"{short:g} s, compiling", short), (f"{options.duration:g} s", options.duration)):
            predicted, peak, file, seconds = run(folder, duration, folder / "cache")
            share = f"{100.0 * (peak / predicted - 1.0):+.0f} %"
            cells = [what, f"{round(2000 * duration) + 1:,}", f"{file / 1e6:.0f}", f"{predicted / 1e6:.0f}"]
            lines.append("| " + " | ".join([*cells, f"{peak / 1e6:.0f} ({share})", f"{seconds:.0f}"]) + " |")
    text = "\n".join(lines)
    print(text)
    if options.write:
        write_page(RESULTS / "memory.md", "Memory of a long run", "python bench/memory.py --write", text)
    return 0 if peak <= LIMIT else 1  # of the long run


if __name__ == "__main__":
    sys.exit(main())
