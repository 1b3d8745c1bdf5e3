"""Without what Windows lacks every command does what it does here: its exit codes, its files, the bits of its results.

Not run on Windows: tests/support/without_posix takes away what Windows lacks from programs on Linux.
"""

import argparse
import ast
import json
import os
import shlex
import signal
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import rsc
from rsc.cli import _parser
from scenes import SCENES, changed
from systems import REFERENCE
from without import COMMAND, ended, started

if sys.platform != "linux":
    pytest.skip("looks for open files in /proc", allow_module_level=True)

from rsc.operating_system import posix

ROSS = REFERENCE / "machines" / "ross_coaxrotor.mat"
SHORT = rsc.Scene.from_dict(changed(SCENES["bouncing"], rotor={"eccentricity": 2e-5}, drive={"duration": 2.0}))
WHIRL = rsc.Scene.from_dict(changed(SCENES["whirl, unbalance, run-up"], drive={"duration": 2.0}))
LONG = SHORT.with_values({"drive.duration": 100.0})
LIMITS = '[limits]\nminimum = "1800 rpm"\nmaximum_continuous = "2400 rpm"\n'
# command, and the files that it writes
EVERY = {
    "--version": (),
    "new laval": (),
    "completion bash": (),
    "run s.toml -o r.h5 --as-measured probes.toml": ("r.h5", "probes.toml", "probes.csv", ".probes.csv.rsc"),
    "info r.h5": (),
    "verify r.h5": (),
    "report r.h5": ("r.html",),
    "plot r.h5 -o pictures --animate": ("pictures",),
    "check s.toml -o checked": ("checked",),
    "predict s.toml --speed 50 --sensitivity": (),
    "modes s.toml --speeds 10:100:5 -o modes.png": ("modes.png",),
    "limits s.toml": (),
    "impact s.toml --speed 50 --directions 2": (),
    "motions s.toml --speed 50 --starts 2 -o motions.png": ("motions.png",),
    "remedy s.toml --speed 50 --starts 2": (),
    "compare s.toml probes.toml -o compared.html": ("compared.html",),
    "run w.toml -o w.h5 --as-measured whirl.toml": ("w.h5", "whirl.toml", "whirl.csv", ".whirl.csv.rsc"),
    "fit w.toml whirl.toml --free contact.friction -o fitted.toml": ("fitted.toml",),
    f"import ross {shlex.quote(str(ROSS))} -o coax.toml --contact 5": ("coax.toml", "coax.npz"),
    "sweep s.toml --vary contact.friction=0.1,0.2 --compute predict,run -o store": ("store",),
    "sweep plan s.toml --vary contact.friction=0.1,0.2 -o planned": ("planned",),
    "sweep run planned --part 0": (),
    "sweep status planned": (),
    "sweep collect planned": (),
    "sweep scene planned 1": (),
    "plot store/sweep.nc -o maps": ("maps",),
}
ALL = """
import json, shlex, sys
from rsc.cli import main

ended = []
for line in sys.argv[1:]:
    print("::", line, flush=True)
    try:
        code = main(shlex.split(line))
    except SystemExit as stop:
        code = stop.code
    ended.append(code or 0)
print("::", json.dumps(ended))
"""


@pytest.fixture
def place(tmp_path):
    """A folder whose name has blanks, umlauts and what looks like a drive, with a short scene of Windows' line ends."""
    folder = tmp_path / "D:" / "Läufer und Gehäuse (2)"
    folder.mkdir(parents=True)
    (folder / "s.toml").write_text(SHORT.to_toml() + LIMITS, newline="\r\n")
    return folder


def one_line(told):
    """The only line of standard error but notes."""
    (line,) = [line for line in told.splitlines() if not line.startswith("rsc: ")]
    assert line.startswith("error: ")
    return line


def begun(process, condition):
    """Wait until a process has come so far."""
    deadline = time.monotonic() + 120.0
    while not condition():
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.01)


def has_samples(part):
    return part.exists() and part.stat().st_size > 3e5


def test_every_command_is_tried():
    (commands,) = (each for each in _parser()._actions if isinstance(each, argparse._SubParsersAction))
    serving = {"explore"}  # until Ctrl-C: tests/unit/study/test_explore.py
    assert {line.split()[0] for line in EVERY} | serving == {"--version", *commands.choices}


def test_every_command_does_what_it_does_here(place):
    (place / "w.toml").write_text(WHIRL.to_toml(), newline="\r\n")
    _, out, told = ended([sys.executable, "-c", ALL, *EVERY], place)
    codes = json.loads(out.splitlines()[-1].removeprefix(":: "))
    assert codes == [0] * len(EVERY), told
    wanted = {"s.toml", "w.toml", *(name for names in EVERY.values() for name in names)}
    assert set(os.listdir(place)) == wanted, told
    assert "error" not in told and "Traceback" not in told
    np.testing.assert_array_equal(rsc.load(place / "r.h5").rotor, rsc.simulate(SHORT).rotor)


def test_a_run_that_goes_on_is_left_alone_and_a_killed_one_goes_on(place):
    """The lock lies on a file beside, dies with the process and goes with the run."""
    (place / "long.toml").write_text(LONG.to_toml())
    first = started([*COMMAND, "run", "long.toml", "-o", "r.h5"], place)
    begun(first, lambda: has_samples(place / "r.h5.part"))
    first.send_signal(signal.SIGSTOP)
    code, _, told = ended([*COMMAND, "run", "long.toml", "-o", "r.h5"], place)
    assert code == 4 and "is being written by another run (lock on r.h5.part)" in one_line(told)
    first.kill()
    first.communicate()
    assert {"r.h5.part", "r.h5.part.lock"} <= set(os.listdir(place))
    code, _, told = ended([*COMMAND, "run", "long.toml", "-o", "r.h5", "--resume"], place)
    assert code == 0, told
    assert sorted(os.listdir(place)) == ["long.toml", "r.h5", "s.toml"]
    np.testing.assert_array_equal(rsc.load(place / "r.h5").rotor, rsc.simulate(LONG).rotor)


def test_what_another_program_has_open_is_told_before_anything_is_computed(place):
    assert ended([*COMMAND, "run", "s.toml", "-o", "r.h5"], place)[0] == 0
    before = (place / "r.h5").read_bytes()
    with (place / "r.h5").open("rb"):
        code, _, told = ended([*COMMAND, "run", "s.toml", "-o", "r.h5"], place)
    assert code == 4 and "r.h5: cannot be written (another program has it open" in one_line(told)
    assert (place / "r.h5").read_bytes() == before and sorted(os.listdir(place)) == ["r.h5", "s.toml"]
    (place / "r.h5").chmod(0o444)
    assert os.geteuid() == 0 or "it is read-only" in ended([*COMMAND, "run", "s.toml", "-o", "r.h5"], place)[2]


OPENED = """
import rsc
scene, held = rsc.load_scene("s.toml"), []
try:
    rsc.simulate(scene, path="r.h5", note=lambda text: held.append(open("r.h5", "rb")))
except rsc.DataError as error:
    print(error)
for file in held:
    file.close()
result = rsc.simulate(scene, path="r.h5", resume=True)
print(result.status)
"""


def test_a_result_that_is_opened_during_its_run_is_told_and_nothing_is_lost(place):
    assert ended([*COMMAND, "run", "s.toml", "-o", "r.h5"], place)[0] == 0
    code, out, told = ended([sys.executable, "-c", OPENED], place)
    assert code == 0, told
    assert out.splitlines()[0].startswith("r.h5: cannot be written (another program has it open") and out.endswith("finished\n")
    np.testing.assert_array_equal(rsc.load(place / "r.h5").rotor, rsc.simulate(SHORT).rotor)


TABLE = """
import rsc
table = rsc.predict(rsc.load_scene("s.toml"), 40.0).table()
table.to_csv("t.csv")
with open("t.csv"):
    try:
        table.to_csv("t.csv")
    except rsc.DataError as error:
        print(error)
"""


def test_a_table_that_another_program_has_open_is_told(place):
    code, out, told = ended([sys.executable, "-c", TABLE], place)
    assert code == 0 and out.startswith("t.csv: cannot be written (another program has it open"), told
    assert sorted(os.listdir(place)) == [".t.csv.rsc", "s.toml", "t.csv"]


def test_a_path_that_is_too_long_is_told_in_one_line(place):
    folder = place / "/".join(["a" * 100] * 3)
    folder.mkdir(parents=True)
    (folder / "s.toml").write_text(SHORT.to_toml())
    assert rsc.load_scene(folder / "s.toml") == SHORT  # here such a path is none to speak of
    for command, expected in ((["run", folder / "s.toml"], 2), (["run", "s.toml", "-o", folder / "r.h5"], 4)):
        code, _, told = ended([*COMMAND, *command], place)
        line = one_line(told)
        assert code == expected and "characters, more than the 259 of windows where long paths" in line.lower(), line


def test_a_sweep_is_computed_by_one_process_at_a_time_and_goes_on(place):
    # so many cases that the first sweep goes on for a second and more behind its first part: of 100 a busy machine saw the end
    sweep = [*COMMAND, "sweep", "s.toml", "--vary", "contact.friction=0.1:0.3:400", "--compute", "run", "-o", "store"]
    first = started([*sweep, "--threads", "1"], place)
    begun(first, lambda: any((place / "store").glob("parts/*.h5")))
    first.send_signal(signal.SIGSTOP)
    code, _, told = ended([*sweep, "--resume"], place)
    assert code == 4 and f"is being written by another sweep (process {first.pid} on " in one_line(told)
    first.kill()
    first.communicate()
    for name, age in (("0" * 16, 7200.0), ("1" * 16, 0.0)):  # of processes that died: one long ago, one that may be at work
        private = place / "store" / "parts" / f".rsc-{name}.part"
        private.touch()
        os.utime(private, (time.time() - age,) * 2)
    code, _, told = ended([*sweep, "--resume"], place)
    assert code == 0, told
    left = [name for name in os.listdir(place / "store" / "parts") if name.startswith(".rsc-") and "0" * 16 in name]
    assert left == [] and (place / "store" / "parts" / f".rsc-{'1' * 16}.part").exists()


def test_ctrl_break_ends_a_run_as_ctrl_c(place):
    """SIGUSR1 stands for SIGBREAK, which is there on Windows alone."""
    (place / "long.toml").write_text(LONG.to_toml())
    process = started([*COMMAND, "run", "long.toml", "-o", "r.h5"], place)
    begun(process, lambda: has_samples(place / "r.h5.part"))
    process.send_signal(signal.SIGUSR1)
    out, told = process.communicate(timeout=60)
    assert process.returncode == 130 and "interrupted" in out + told
    assert sorted(os.listdir(place)) == ["long.toml", "r.h5", "s.toml"] and rsc.load(place / "r.h5").n_time > 100


NAMES = """
import os
from pathlib import Path
from rsc.operating_system import Claim, Folder, UnsafeFolder, is_own, lock, own_folder, processors, prove_writable, windows

here = Folder(".")
Path("file").write_text("x")
Path("folder").mkdir()
Path("link").symlink_to("file")
Path("to").symlink_to("folder")
for act in (lambda: here.open("link"), lambda: Folder("to"), lambda: Folder("to", within=here), lambda: Folder("file")):
    try:
        act()
    except OSError as error:
        print(error.strerror)
assert "file" in here.names() and is_own(here.status("file")) and processors() > 0
os.close(Folder("to", linked=True).open("new", os.O_WRONLY | os.O_CREAT))
one, two = (os.open("lock", os.O_RDWR | os.O_CREAT | os.O_BINARY) for _ in range(2))
print(lock(one), lock(two))
os.close(one)
print(lock(two))
Path("caches/rsc").mkdir(parents=True)
Path("caches/rsc/x").symlink_to(Path("folder").absolute())
for inside in (("rsc", "y"), ("rsc", "x")):
    try:
        print(own_folder(Path("caches").absolute(), *inside).name)
    except UnsafeFolder as error:
        print(str(error).rpartition("/")[2])
print(sorted(os.listdir("caches/rsc/y")))
"""


def test_links_locks_and_folders(place):
    code, out, told = ended([sys.executable, "-c", NAMES], place)
    assert code == 0, told
    assert out.splitlines() == [
        "Too many levels of symbolic links", *["Not a directory"] * 3, "True False", "True", "y", "x is a link", "[]"
    ]  # fmt: skip


TAKEN = """
import ctypes, os, sys
import msvcrt

try:
    import fcntl
except ModuleNotFoundError:
    print("module")
for name in ("O_NOFOLLOW", "geteuid", "pread", "fork"):
    assert not hasattr(os, name)


def refused(act, *kinds):
    try:
        act()
    except kinds as error:
        print(type(error).__name__)


file = open("held.part", "wb")
refused(lambda: os.replace("held.part", "other"), PermissionError)
refused(lambda: os.unlink("held.part"), PermissionError)
refused(lambda: os.rename("s.toml", "held.part"), PermissionError)
refused(lambda: os.open(".", os.O_RDONLY), PermissionError)
refused(lambda: os.stat("s.toml", dir_fd=3), NotImplementedError)
refused(lambda: os.kill(os.getpid(), 0), AssertionError)
refused(lambda: msvcrt.locking(file.fileno(), 2, 1), AssertionError)
refused(lambda: exec("os.open('s.toml', 0)", {"os": os, "__name__": "rsc.some"}), AssertionError)
"""


def test_line_ends_of_windows_do_not_matter(place):
    """Of a measured run with its data, and of a table of cases; of scenes and matrices: test_scene, test_formats."""
    rsc.write_measured(rsc.simulate(SHORT), place / "probes.toml", noise=1e-6)
    (place / "cases.csv").write_bytes(b"contact.friction,contact.gap\n0.1,0.2 mm\n0.2,0.3 mm\n")
    before = rsc.read_measured(place / "probes.toml"), rsc.cases(SHORT, {}, table=place / "cases.csv")
    for name in ("probes.toml", "probes.csv", "cases.csv"):
        (place / name).write_bytes((place / name).read_bytes().replace(b"\n", b"\r\n"))
    after = rsc.read_measured(place / "probes.toml"), rsc.cases(SHORT, {}, table=place / "cases.csv")
    np.testing.assert_array_equal(before[0].time, after[0].time)
    np.testing.assert_array_equal(before[0].deflection, after[0].deflection)
    assert before[0].warnings == after[0].warnings and before[1] == after[1]


def test_what_is_taken_away_is_gone(place):
    code, out, told = ended([sys.executable, "-c", TAKEN], place)
    assert code == 0, told
    assert out.split() == ["module", *["PermissionError"] * 4, "NotImplementedError", *["AssertionError"] * 3]


def test_both_halves_have_the_same_names():
    """windows.py cannot be loaded here; mypy looks at the types of both (`make lint`)."""
    names = {}
    for half in ("posix", "windows"):
        tree = ast.parse(Path(posix.__file__).with_name(f"{half}.py").read_text(encoding="utf-8"))
        functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")]
        names[half] = {node.name: [each.arg for each in node.args.args] for node in functions}
    assert names["posix"] == names["windows"]
