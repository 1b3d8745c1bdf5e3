"""Compiled code is read as it is, or compiled by Numba alone; F12: its folder cannot be used, or what it holds is damaged."""

import ast
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from rsc import compiled
from rsc.compiled import code_cache

ROOT = Path(__file__).parents[3]

USES = """
import gc
import sys
from pathlib import Path

from rsc.compiled.code_cache import cache_folder
from rsc.kernel.simd import jit


@jit.entry
def twice(x):
    return 2.0 * x


usual = gc.get_threshold()
print(twice(1.5), sum(twice.stats.cache_hits.values()), cache_folder(Path(jit.__file__).parents[1]))
assert gc.get_threshold() == usual
if "compile more" in sys.argv:
    assert "numba.np.linalg" not in sys.modules  # of what Numba loads to compile
    assert twice(2j) == 4j
"""


def python(cache, *arguments, **more):
    """A new interpreter with its compiled code in a folder."""
    more = {"XDG_CACHE_HOME": str(cache), "PYTHONPATH": os.pathsep.join(sys.path)} | more
    command = [sys.executable, *arguments]
    return subprocess.run(command, env=os.environ | more, capture_output=True, text=True, check=False, timeout=300)


def used(folder, cache, temporary, *arguments, **more):
    """(value, cache hits, folder) of a small function compiled as the kernel is."""
    (folder / "uses.py").write_text(USES)
    done = python(cache, str(folder / "uses.py"), *arguments, TMPDIR=str(temporary), **more)
    assert done.returncode == 0, done.stderr
    value, hits, where = done.stdout.split()
    return float(value), int(hits), Path(where)


def test_what_is_compiled_is_found_again(tmp_path):
    value, hits, where = used(tmp_path, tmp_path / "cache", tmp_path)
    assert (value, hits) == (3.0, 0) and where.is_relative_to(tmp_path / "cache")
    assert used(tmp_path, tmp_path / "cache", tmp_path) == (3.0, 1, where)


def test_what_is_compiled_is_read_without_what_only_compiling_needs(tmp_path):
    used(tmp_path, tmp_path / "cache", tmp_path)
    assert used(tmp_path, tmp_path / "cache", tmp_path, "compile more")[:2] == (3.0, 1)


def loaded(cache, program, names):
    """Which of these modules a program has loaded at its end."""
    done = python(cache, "-c", f"{program}\nimport sys\nprint(*{names!r} & set(sys.modules))")
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()[-1].split()


def test_a_start_loads_no_library_that_only_an_analysis_or_a_picture_needs(tmp_path):
    late = {"scipy.linalg", "scipy.optimize", "scipy.fft", "matplotlib", "threadpoolctl"}
    loaded(tmp_path, "import rsc; rsc.simulate", late)  # Numba's compiler, for the canary, takes some of them
    assert loaded(tmp_path, "import rsc; rsc.simulate, rsc.Trajectory, rsc.simulate_many", late) == []


def test_the_simulation_loads_no_analysis(tmp_path):
    assert loaded(tmp_path, "import rsc.simulation.run", {"rsc.analysis", "rsc.simulation.run"}) == ["rsc.simulation.run"]


def test_help_is_quick(tmp_path):
    program = """
import contextlib, io, resource
from rsc.cli import main
with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()) as text:
    main(["--help"])
assert "check" in text.getvalue()
spent = resource.getrusage(resource.RUSAGE_SELF)
assert spent.ru_utime + spent.ru_stime < 0.5  # s, of which most is Python's own start; 0.7 with Numba
"""
    assert loaded(tmp_path, program, {"numba", "scipy", "rsc.analysis", "rsc.cli"}) == ["rsc.cli"]


def test_every_public_name_is_found_by_people_programs_and_type_checkers():
    import rsc

    guarded = next(node for node in ast.parse(Path(rsc.__file__).read_text()).body if isinstance(node, ast.If))
    assert {node.module: tuple(name.name for name in node.names) for node in guarded.body} == rsc._HOMES
    names = {}
    exec("from rsc import *", names)
    assert names.keys() - {"__builtins__"} == set(rsc.__all__) == {name for home in rsc._HOMES.values() for name in home}
    assert set(rsc.__all__) <= set(dir(rsc)) and all(getattr(rsc, name) is names[name] for name in rsc.__all__)
    with pytest.raises(AttributeError, match="'simulat'"):
        rsc.simulat  # noqa: B018


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
    done = python(tmp_path, str(tmp_path / "uses.py"))
    assert "(%rip)" in done.stdout and "movabs" not in done.stdout


def test_editing_any_source_of_kernel_or_compiler_names_another_cache_folder(tmp_path, monkeypatch):
    rsc = Path(code_cache.__file__).parents[1]
    for wing in ("kernel", "compiled"):
        shutil.copytree(rsc / wing, tmp_path / wing)
    before = code_cache.fingerprint(rsc / "kernel")
    monkeypatch.setattr(code_cache, "OWN_SOURCES", tmp_path / "compiled")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert code_cache.fingerprint(tmp_path / "kernel") == before == code_cache.cache_folder(rsc / "kernel").name
    found, sources = {before}, list(tmp_path.rglob("*.py"))
    for source in sources:
        source.write_text(source.read_text() + "# edited\n")
        found.add(code_cache.fingerprint(tmp_path / "kernel"))
    assert len(found) == 1 + len(sources) > 30


# what a Numba to come might do to its private parts: done as a process starts, and so in the one that tries the fast path out
CHANGES = {
    "a part is missing": "import numba; from numba.core import typed_passes; del typed_passes.NoPythonBackend",
    "a part has changed": "from numba.core import codegen; codegen.JITCodeLibrary = object",
    "other numbers": "from rsc.compiled import fast; fast.HELPER['fastmath'] = True",
    "it ends the process": "import os; from rsc.compiled import canary; canary.mismatch = lambda fast: os.abort()",
}


def changed(folder, change):
    """PYTHONPATH with which every process makes this change before anything else."""
    (folder / "sitecustomize.py").write_text(change)
    return {"PYTHONPATH": os.pathsep.join([str(folder), *sys.path])}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_where_private_parts_of_numba_have_changed_numba_alone_compiles_the_same(tmp_path, change):
    (tmp_path / "uses.py").write_text(USES + "print(twice(1.5))")
    done = python(tmp_path, "-W", "always", str(tmp_path / "uses.py"), **changed(tmp_path, change))
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[0] == "3.0" and done.stderr.count("does not support rsc's fast compilation") == 1
    assert list(tmp_path.rglob("plain/**/*.nbc"))


def test_the_command_line_says_in_one_line_that_the_fast_path_is_not_taken(tmp_path):
    program = "from rsc.cli import main; main(['run', 'none.toml'])"
    first, second = python(tmp_path, "-c", program, **changed(tmp_path, CHANGES["a part is missing"])).stderr.splitlines()
    assert first.startswith("rsc: Numba ") and second.startswith("error: none.toml")


def test_numba_alone_when_asked_for_without_a_word_and_found_again(tmp_path):
    value, hits, where = used(tmp_path, tmp_path / "cache", tmp_path, RSC_PLAIN="1")
    assert (value, hits) == (3.0, 0) and list(where.glob("plain/**/*.nbc"))
    assert used(tmp_path, tmp_path / "cache", tmp_path, RSC_PLAIN="1") == (3.0, 1, where)
    assert used(tmp_path, tmp_path / "cache", tmp_path) == (3.0, 0, where)  # the paths' code lies apart


def test_a_numba_too_old_is_told_in_one_line(tmp_path):
    program = "import numba; numba.__version__ = '0.62.1'; from rsc.cli import main; print(main(['run', 'none.toml']))"
    done = python(tmp_path, "-c", program)
    assert done.stdout == "2\n"
    assert done.stderr == "error: Numba 0.62.1 is too old for rsc: python -m pip install --upgrade 'numba>=0.63'\n"


def test_the_oldest_numba_is_the_declared_one():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    assert "numba>=" + ".".join(map(str, compiled.OLDEST_NUMBA)) in declared


PUBLIC = {"numba", "numba.types", "numba.extending", "numba.carray"}


def private_of_numba(text, wing):
    """Names of Numba's private modules that a source of a wing imports or takes from `numba`."""
    allowed = PUBLIC | ({"numba.core.cgutils"} if wing == "kernel/simd" else set())
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            inner = node.module in ("numba", "numba.core")
            found |= {f"{node.module}.{name.name}" for name in node.names} if inner else {node.module}
        elif isinstance(node, ast.Attribute) and ast.unparse(node.value) == "numba" and node.attr in ("core", "np", "cpython"):
            found.add(ast.unparse(node))
    return {name for name in found if name.split(".")[0] == "numba"} - allowed


def test_private_parts_of_numba_are_imported_on_the_fast_path_only():
    source = ROOT / "src" / "rsc"
    files = {path: path.relative_to(source).parent.as_posix() for path in source.rglob("*.py")}
    strays = {path: private_of_numba(path.read_text(), wing) for path, wing in files.items() if wing != "compiled/fast"}
    assert {path.name: names for path, names in strays.items() if names} == {}
    assert private_of_numba((source / "compiled" / "fast" / "calls.py").read_text(), "compiled/fast")


STRAYS = ("from numba.core import cgutils", "import numba.core.ir", "from numba import core", "numba.np.ufunc")


@pytest.mark.parametrize("stray", STRAYS)
def test_a_stray_import_of_a_private_part_is_found(stray):
    assert private_of_numba(stray, "kernel")
