"""First call (fresh kernel cache: the kernel is compiled) and warm start of a new process; no assertion on times."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
RUN = """
import rsc
scene = rsc.load_scene("data/reference/laval.toml").with_values({"drive.duration": 0.1})
assert rsc.simulate(scene).status == "finished"
"""


def process(cache):
    """A new interpreter that simulates 0.1 s with its kernel cache in a folder."""
    environment = os.environ | {"XDG_CACHE_HOME": str(cache), "PYTHONPATH": str(ROOT / "src")}
    subprocess.run([sys.executable, "-c", RUN], cwd=ROOT, env=environment, check=True, timeout=300)


def test_first_call(benchmark, tmp_path):
    """Import, compile, run: what the first user of a machine waits."""
    benchmark.pedantic(process, args=(tmp_path / "cache",), rounds=1)


def test_warm_start(benchmark, tmp_path):
    """Import, load the compiled kernel, run."""
    process(tmp_path / "cache")
    benchmark.pedantic(process, args=(tmp_path / "cache",), rounds=3)
