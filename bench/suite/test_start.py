"""First call (fresh kernel cache: the kernel is compiled) and warm start of a new process, to the end of a short run.

No assertion on times. Beside the warm start stands that of a Numba function of one line: what Numba's import and its reading of
any compiled code take.

    pytest bench/suite/test_start.py --benchmark-only

`extra_info` of each benchmark holds `processor_s`, the least processor time of a round: wall time depends on who else computes.
"""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# how long a process takes to end is not how long it takes to start
AT_ONCE = "import os; os._exit(0)"
RUN = """
from rsc.study.run.start import run_of
import rsc
scene = rsc.load_scene("data/reference/laval.toml").with_values({"drive.duration": 0.1})
assert rsc.simulate(scene).status == "finished"
""" + AT_ONCE

ONE_LINE = """
import numpy
from one_line import total
assert total(numpy.ones(3)) == 3.0
""" + AT_ONCE
FUNCTION = """
import numba
@numba.njit(cache=True)
def total(x):
    return x.sum()
"""
COMPILE = """
import rsc
from rsc.study.run.start import run_of
run_of(rsc.Scene.from_dict({scene})).compile()
"""


def chain(n_rotor, method):
    """Tables of a scene: a chain of disks that begins at rest in a chain of three stator masses."""
    return {
        "rotor": {"model": "chain", "masses": [1.0] * n_rotor, "stiffnesses": [1e6] * (n_rotor + 1), "damping_ratio": 0.02},
        "stator": {"model": "chain", "masses": [0.25] * 3, "stiffnesses": [1e6] * 3 + [0.0], "damping_ratio": 0.1},
        "contact": {"gap": 1e-3, "friction": 0.3, "stiffness": 3.55e6, "damping_ratio": 0.05},
        "drive": {"speed": [20.0, 60.0], "duration": 10.0},
        "start": {"rest": True},
        "solver": {"method": method},
    }


def process(cache, spent, program=RUN):
    """A new interpreter that runs a program with its kernel cache in a folder; appends its processor time in s to `spent`."""
    environment = os.environ | {"XDG_CACHE_HOME": str(cache), "PYTHONPATH": str(ROOT / "src")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # sources are read once, as anywhere
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=environment, check=True, timeout=600)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def measured(benchmark, rounds, *arguments):
    """Time `process` and note its processor time."""
    spent = []
    benchmark.pedantic(process, args=(arguments[0], spent, *arguments[1:]), rounds=rounds)
    benchmark.extra_info["processor_s"] = min(spent)


def test_first_call(benchmark, tmp_path):
    """Import, compile, run: what the first user of a machine waits."""
    measured(benchmark, 1, tmp_path / "cache")


def test_warm_start(benchmark, tmp_path):
    """Import, load the compiled kernel, run."""
    process(tmp_path / "cache", [])
    measured(benchmark, 3, tmp_path / "cache")


def test_warm_start_of_numba(benchmark, tmp_path):
    """Import Numba, load one compiled line, run."""
    (tmp_path / "one_line.py").write_text(FUNCTION)
    program = f"import sys; sys.path.insert(0, {str(tmp_path)!r})" + ONE_LINE
    process(tmp_path, [], program)
    measured(benchmark, 3, tmp_path, program)


@pytest.mark.parametrize(
    ("n_rotor", "method"),
    [(10, "rk45"), (23, "rk45"), (23, "taylor8"), (97, "rk45"), (97, "taylor8")],
)
def test_compile(benchmark, tmp_path, n_rotor, method):
    """Import and compile for 13, 26 and 100 complex coordinates."""
    measured(benchmark, 1, tmp_path / "cache", COMPILE.format(scene=chain(n_rotor, method)))
