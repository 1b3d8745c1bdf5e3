"""Compiled code is read as it is; F12: its folder cannot be used, or what it holds is damaged."""

import os
import subprocess
import sys
from pathlib import Path

USES = """
import gc
import sys
from pathlib import Path

from rsc.compiled.code_cache import cache_folder
from rsc import kernel
from rsc.kernel.simd.jit import entry


@entry
def twice(x):
    return 2.0 * x


usual = gc.get_threshold()
print(twice(1.5), sum(twice.stats.cache_hits.values()), cache_folder(Path(kernel.__file__).parent))
assert gc.get_threshold() == usual
if "compile more" in sys.argv:
    assert "numba.np.linalg" not in sys.modules  # of what Numba loads to compile
    assert twice(2j) == 4j
"""


def used(folder, cache, temporary, *arguments):
    """(value, cache hits, folder) of a small function compiled as the kernel is."""
    (folder / "uses.py").write_text(USES)
    more = {"XDG_CACHE_HOME": str(cache), "TMPDIR": str(temporary), "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, str(folder / "uses.py"), *arguments]
    done = subprocess.run(command, env=os.environ | more, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    value, hits, where = done.stdout.split()
    return float(value), int(hits), Path(where)


def test_what_is_compiled_is_found_again_also_in_the_folder_that_replaces_one_that_cannot_be_used(tmp_path):
    (tmp_path / "a file").touch()  # no folder can be made in it, whoever asks; a user's read-only one answers the same
    (tmp_path / "t").mkdir()
    value, hits, where = used(tmp_path, tmp_path / "a file", tmp_path / "t")
    assert (value, hits) == (3.0, 0) and where.is_relative_to(tmp_path / "t")
    assert used(tmp_path, tmp_path / "a file", tmp_path / "t") == (3.0, 1, where)


def test_what_is_compiled_is_read_without_what_only_compiling_needs(tmp_path):
    used(tmp_path, tmp_path / "cache", tmp_path)
    assert used(tmp_path, tmp_path / "cache", tmp_path, "compile more")[:2] == (3.0, 1)


def test_a_start_loads_no_library_that_only_an_analysis_or_a_picture_needs():
    late = {"scipy.linalg", "scipy.optimize", "scipy.fft", "matplotlib", "threadpoolctl"}
    program = f"import sys, rsc; print(*{late!r} & set(sys.modules))"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    loaded = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True).stdout
    assert loaded.split() == []


DAMAGES = {
    "index cut off": (".nbi", lambda content: content[:20]),
    "index empty": (".nbi", lambda content: b""),
    "code cut off": (".nbc", lambda content: content[:3000]),
    "code of noise": (".nbc", lambda content: bytes(range(256)) * 30),
    "zeros inside the code": (".nbc", lambda content: content[:4000] + bytes(400) + content[4400:]),
}


def test_a_damaged_cache_is_compiled_anew(tmp_path):
    _, _, where = used(tmp_path, tmp_path / "cache", tmp_path)
    for suffix, damage in DAMAGES.values():
        file = next(where.rglob("*" + suffix))
        file.write_bytes(damage(file.read_bytes()))
        assert used(tmp_path, tmp_path / "cache", tmp_path) == (3.0, 0, where)
    assert used(tmp_path, tmp_path / "cache", tmp_path) == (3.0, 1, where)


def test_compiled_code_reaches_its_constants_and_functions_by_their_distance(tmp_path):
    (tmp_path / "uses.py").write_text(USES + "(result,) = twice.overloads.values()\nprint(result.library.get_asm_str())\n")
    more = {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, str(tmp_path / "uses.py")]
    done = subprocess.run(command, env=os.environ | more, capture_output=True, text=True, check=True, timeout=60)
    assert "(%rip)" in done.stdout and "movabs" not in done.stdout
