"""Compiled code is unpickled and executed: only from folders that nobody but the user may write, else it is kept in memory."""

import contextlib
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from rsc.compiled import code_cache, paths
from rsc.compiled.code_cache import cache_folder
from rsc.operating_system import UnsafeFolder, own_folder
from rsc.operating_system import posix as module

STRANGER = 54_321  # a user without a name
PROGRAM = """
import sys
from pathlib import Path

from rsc.compiled.code_cache import cache_folder
from rsc.kernel.simd import jit


@jit.entry
def twice(x):
    return 2.0 * x


value = {"1.5": 1.5, "2j": 2j}[sys.argv[1]]
assert twice(value) == 2.0 * value
print(sum(twice.stats.cache_hits.values()), cache_folder(Path(jit.__file__).parents[1]))
"""


class Planted:
    """What a stranger would have executed."""

    def __reduce__(self):
        return os.mkdir, ("executed",)


@pytest.fixture
def place(tmp_path):
    """A folder whose way down others may go, unlike pytest's own, with the program, a cache and a folder to run in."""
    for name in ("cache", "work", "temporary"):
        (tmp_path / name).mkdir()
    (tmp_path / "uses.py").write_text(PROGRAM)
    return tmp_path


def begun(place, value="1.5", user=None, program=sys.executable, **environment):
    """The program started with its caches in place/cache."""
    settings = {name: text for name, text in os.environ.items() if name not in ("HOME", "XDG_CACHE_HOME")}
    settings |= {"PYTHONPATH": os.pathsep.join(sys.path), "TMPDIR": str(place / "temporary")} | environment
    command = [program, str(place / "uses.py"), value]
    more = {} if user is None else {"user": user, "group": user, "extra_groups": []}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(command, env=settings, cwd=place / "work", **pipes, **more)


def ended(process):
    """(cache hits, folder of the kept code, standard error) of a program that did what it should."""
    output, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    hits, where = output.split()
    return int(hits), None if where == "None" else Path(where), errors


def used(place, value="1.5"):
    return ended(begun(place, value, XDG_CACHE_HOME=str(place / "cache")))


def plant(folder):
    """Put what a stranger wants executed in the place of every index below a folder."""
    for index in folder.rglob("*.nbi"):
        index.write_bytes(pickle.dumps(Planted()))


def refused(place, reason, errors):
    assert not (place / "work" / "executed").exists()
    assert errors.count("compiled code is not kept on disk") == 1 and reason in errors


def test_what_a_stranger_planted_is_executed_where_it_may_be(place):
    """The plant works: in the user's own folder it is the user's."""
    where = used(place)[1]
    plant(where)
    used(place)
    assert (place / "work" / "executed").exists()


@pytest.mark.nightly
def test_a_folder_of_the_system_for_all_is_not_believed(place):
    """A user without a cache folder got one named after the user in the temporary folder, whoever had made it."""
    where = used(place)[1]
    shutil.copytree(where, place / "temporary" / f"rsc-{os.geteuid()}" / where.name)
    plant(place / "temporary")
    shutil.rmtree(place / "cache")
    (place / "cache").touch()
    hits, where, errors = used(place)
    assert (hits, where) == (0, None)
    refused(place, "cache cannot be used (Not a directory)", errors)


def writable_base(cache, own):
    cache.chmod(0o777)


def writable_folder(cache, own):
    (cache / "rsc").chmod(0o775)


def link_to_rsc(cache, own):
    (cache / "rsc").rename(cache / "elsewhere")
    (cache / "rsc").symlink_to("elsewhere")


def link_to_own(cache, own):
    own.rename(cache / "elsewhere")
    own.symlink_to(cache / "elsewhere")


def of_another_user(cache, own):
    os.chown(own, STRANGER, STRANGER)


def above_of_another_user(cache, own):
    os.chown(cache, STRANGER, STRANGER)


UNSAFE = {
    writable_base: "cache may be written by others",
    writable_folder: "cache/rsc may be written by others",
    link_to_rsc: "cache/rsc is a link",
    link_to_own: "is a link",
    of_another_user: "belongs to another user",
    above_of_another_user: "cache belongs to another user",
}


REPEATED = (writable_folder, link_to_rsc, link_to_own, above_of_another_user)


@pytest.mark.parametrize("change", [pytest.param(each, marks=[pytest.mark.nightly] * (each in REPEATED)) for each in UNSAFE])
def test_code_in_a_folder_that_others_may_write_is_not_executed(place, change):
    if "another_user" in change.__name__ and os.geteuid() != 0:
        pytest.skip("only root can give a folder to another user")
    where = used(place)[1]
    plant(where)
    change(place / "cache", where)
    hits, where, errors = used(place)
    assert (hits, where) == (0, None)
    refused(place, UNSAFE[change], errors)


def test_folders_that_others_can_only_read_are_used(place):
    """Earlier versions made them so."""
    where = used(place)[1]
    where.chmod(0o755)
    where.parent.chmod(0o755)
    assert used(place)[:2] == (1, where)


def test_folders_are_made_for_the_user_alone(place):
    before = os.umask(0)
    try:
        where = used(place)[1]
    finally:
        os.umask(before)
    assert where.stat().st_mode & 0o777 == where.parent.stat().st_mode & 0o777 == 0o700


@pytest.mark.nightly
def test_a_link_above_the_users_folders_is_followed(place):
    """Home folders are often links to another disk."""
    (place / "home").symlink_to("cache")
    _, where, errors = ended(begun(place, XDG_CACHE_HOME=str(place / "home")))
    assert where.is_relative_to(place / "cache") and not errors


@pytest.mark.nightly
def test_in_a_folder_where_all_may_write_but_not_rename_the_users_own_is_safe(place):
    """As in /tmp."""
    (place / "cache").chmod(0o1777)
    assert used(place)[1].is_relative_to(place / "cache")


def test_code_without_optimisation_is_not_kept_and_that_is_said(monkeypatch):
    """Numba puts addresses into it."""
    monkeypatch.setattr("numba.config.OPT", 0)
    code_cache._say_once.cache_clear()
    with pytest.warns(UserWarning, match="not kept on disk, and every start compiles anew: NUMBA_OPT=0 is set; unset it"):
        assert cache_folder(Path(code_cache.__file__)) is None
    assert not code_cache.keeps_code() and paths.fast_path.__wrapped__() is None
    code_cache._say_once.cache_clear()


def test_a_relative_cache_folder_is_ignored(place):
    where = ended(begun(place, XDG_CACHE_HOME="caches", HOME=str(place)))[1]
    assert where.is_relative_to(place / ".cache") and not list((place / "work").iterdir())


def interpreter_for(user):
    """An interpreter of this version with which another user can import the packages, or None."""
    name = f"python{sys.version_info.major}.{sys.version_info.minor}"
    environment = {"PYTHONPATH": os.pathsep.join(sys.path), "PATH": os.environ["PATH"]}
    for program in (sys.executable, shutil.which(name, path="/usr/bin:/usr/local/bin")):
        with contextlib.suppress(OSError, TypeError):  # not to be executed; None
            command = [program, "-c", "import h5py, numba, scipy"]
            options = {"env": environment, "user": user, "group": user, "extra_groups": [], "capture_output": True}
            if not subprocess.run(command, check=False, **options).returncode:
                return program
    return None


OTHER_HOMES = [pytest.param(home, marks=pytest.mark.nightly) for home in ("", "/nowhere", "work")]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can act as another user")
@pytest.mark.parametrize("home", [None, "closed", *OTHER_HOMES])
def test_a_user_without_a_name_or_a_home_to_write_in_can_work(home):
    """No HOME, an empty one, one that does not exist, one that cannot be written, one whose caches nobody else may look at."""
    program = interpreter_for(STRANGER)
    if program is None:
        pytest.skip("another user cannot read this interpreter")
    with tempfile.TemporaryDirectory() as folder:  # pytest's own is closed for other users
        place = Path(folder)
        place.chmod(0o755)
        for name in ("work", "temporary", "closed"):
            (place / name).mkdir()
        (place / "closed/.cache").mkdir(0o700)
        (place / "temporary").chmod(0o1777)
        (place / "uses.py").write_text(PROGRAM)
        environment = {} if home is None else {"HOME": str(place / home) if home in ("work", "closed") else home}
        hits, where, errors = ended(begun(place, user=STRANGER, program=program, **environment))
        assert (hits, where) == (0, None) and errors.count("compiled code is not kept on disk") == 1
        assert not list((place / "temporary").iterdir())


@pytest.mark.nightly
@pytest.mark.parametrize("many", [2, 5])
def test_processes_begin_at_once_with_an_empty_cache(place, many):
    values = many * ["1.5", "2j"]
    processes = [begun(place, value, XDG_CACHE_HOME=str(place / "cache")) for value in values]
    assert not any(ended(process)[2] for process in processes)
    for value in ("1.5", "2j"):  # what one of them did not keep for the others' sake is kept now
        used(place, value)
        assert used(place, value)[0] == 1


def test_code_under_the_name_of_another_is_not_taken_for_it(place):
    """Two processes that begin at once may number their code alike: then the index of one names what the other wrote."""
    where = used(place)[1]
    (code,) = where.rglob("*.nbc")
    content = code.read_bytes()
    shutil.rmtree(place / "cache")
    (place / "cache").mkdir()
    assert used(place, "2j")[0] == 0
    code.write_bytes(content)
    assert used(place, "2j")[0] == 0 and used(place, "2j")[0] == 1


def test_a_disk_that_is_full_when_code_is_kept_ends_nothing(place):
    (place / "uses.py").write_text(
        PROGRAM.replace(
            "value =",
            "def full(self, key, data):\n    raise OSError(28, 'No space left on device')\n\n\n"
            "from rsc.compiled.fast import ready_code\nready_code.IndexDataCacheFile.save = full\nvalue =",
        )
    )
    hits, _, errors = used(place)
    assert hits == 0 and errors.count("cannot be kept") == errors.count("No space left on device") == 1


def test_a_folder_made_meanwhile_by_another_process_is_taken(tmp_path, monkeypatch):
    made = os.mkdir

    def quicker(name, mode, dir_fd):
        made(name, mode, dir_fd=dir_fd)
        raise FileExistsError(17, "File exists")

    monkeypatch.setattr(module.os, "mkdir", quicker)
    assert own_folder(tmp_path, "a", "b") == tmp_path / "a" / "b"


def test_a_folder_that_cannot_be_made_is_told(tmp_path):
    (tmp_path / "a").touch()
    with pytest.raises(UnsafeFolder, match=r"a cannot be used \(Not a directory\)"):
        own_folder(tmp_path, "a", "b")
