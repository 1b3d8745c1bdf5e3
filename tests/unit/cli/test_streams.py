"""Pipes that break, disks and terminals that take nothing, interrupts at any time: no traceback, and the files are written."""

import os
import shlex
import signal
import subprocess
import sys
import time

import pytest

from rsc.cli.streams import Plain
from scenes import SCENES, changed

SCENE = changed(SCENES["rigid wall"], title="", drive={"duration": 0.002})


def shell(command, folder, **variables):
    """(exit code, standard error, standard output) of a command of a shell in which `rsc` is this one."""
    text = f"rsc() {{ {shlex.quote(sys.executable)} -m rsc \"$@\"; }}; set -o pipefail; {command}"
    done = subprocess.run(["bash", "-c", text], cwd=folder, capture_output=True, env=os.environ | variables, timeout=60)
    assert b"Traceback" not in done.stderr + done.stdout and b"ignored" not in done.stderr
    return done.returncode, done.stderr.decode(), done.stdout.decode()


@pytest.fixture
def folder(tmp_path):
    import rsc

    (tmp_path / "short.toml").write_text(rsc.Scene.from_dict(SCENE).to_toml())
    return tmp_path


@pytest.mark.parametrize("broken", ["2>&1 | true", "2>&-", ">&-", ">&- 2>&-", "| true"])
def test_a_run_whose_reader_went_away_is_written(folder, broken):
    assert shell(f"rsc run short.toml -o run.h5 {broken}", folder)[0] == 0
    assert sorted(os.listdir(folder)) == ["run.h5", "short.toml"]
    assert (folder / "run.h5").read_bytes()[:4] == b"\x89HDF"  # and no message inside, which a closed descriptor could bring


@pytest.mark.parametrize("command", ["new laval", "--help", "run short.toml"])
def test_a_full_standard_output_is_told(folder, command):
    code, errors, _ = shell(f"rsc {command} > /dev/full", folder)
    assert code == 4 and errors.splitlines()[-1] == "error: standard output: no space left on device"


def test_little_address_space_is_refused_at_once(folder):
    code, errors, _ = shell("ulimit -v 400000; rsc predict short.toml", folder)
    assert code == 2 and "address space" in errors


@pytest.mark.parametrize("blocks", [4, 40])  # of 1 kB
def test_a_limit_on_file_sizes_is_told_as_the_system_says_it(folder, blocks):
    code, errors, _ = shell(f"ulimit -f {blocks}; rsc run short.toml -o run.h5", folder)
    assert code == 4 and errors.splitlines()[1:] == ["error: run.h5: cannot be written (file too large)"]


@pytest.mark.parametrize(
    ("variable", "code", "words"),
    [
        ("NUMBA_DISABLE_JIT=1", 2, "error: NUMBA_DISABLE_JIT is set: a simulation needs compiled code"),
        ("NUMBA_NUM_THREADS=0", 1, "error: unforeseen ValueError: Number of threads specified must be > 0. ("),
    ],
)
def test_settings_of_libraries_that_cannot_be_used_are_one_line(folder, variable, code, words):
    ended, errors, _ = shell(f"export {variable}; rsc run short.toml", folder)
    assert ended == code and errors.startswith(words) and errors.count("\n") == 1


@pytest.mark.nightly  # compiles anew; tests/unit/compiled/test_own_folder.py has the folder alone
def test_a_user_without_name_and_home_runs(folder):
    alone = ["unshare", "-U", "--map-user=4711", "env", "-u", "HOME", "-u", "XDG_CACHE_HOME", sys.executable, "-m", "rsc"]
    if subprocess.run([*alone[:3], "true"], capture_output=True).returncode:
        pytest.skip("no user namespaces here")
    done = subprocess.run([*alone, "run", "short.toml"], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and "Traceback" not in done.stderr and (folder / "short.h5").exists()


def test_an_interrupt_at_any_time_is_one_line(folder):
    began = time.monotonic()
    subprocess.run([sys.executable, "-m", "rsc", "predict", "short.toml"], cwd=folder, capture_output=True, check=True)
    lasts = time.monotonic() - began
    for share in (0.1, 0.3, 0.5, 0.7):
        command = [sys.executable, "-m", "rsc", "predict", "short.toml"]
        process = subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        time.sleep(0.03 + share * lasts)
        process.send_signal(signal.SIGINT)
        errors = process.communicate(timeout=20.0)[1]
        assert process.returncode in (0, 130) or share < 0.2  # before Python has come to the first line of rsc
        assert "ignored" not in errors and ("Traceback" not in errors or "site" in errors)  # Python itself had not yet begun


@pytest.mark.skipif(not sys.executable.isascii(), reason="Python itself does not start from such a folder without UTF-8")
@pytest.mark.parametrize(
    ("title", "printed"),
    [
        ("green \x1b[32m \u202e", "green \\x1b[32m \\u202e"),
        ("Größe", "Gr\\xf6\\xdfe"),
        ("a\nstatus: finished", "a\\nstatus: finished"),
    ],
)
def test_a_title_cannot_steer_a_terminal(folder, title, printed):
    import rsc

    (folder / "short.toml").write_text(rsc.Scene.from_dict(changed(SCENE, title=title)).to_toml())
    ascii_only = {"PYTHONIOENCODING": "ascii", "LC_ALL": "C"}
    code, errors, text = shell("rsc run short.toml -o a.h5 >/dev/null && rsc info a.h5", folder, **ascii_only)
    assert code == 0 and text.splitlines()[0] == printed and (errors + text).isascii()


def test_names_of_files_cannot_steer_a_terminal(folder):
    code, errors, _ = shell("rsc run $'no\\e[31m.toml'; rsc predict short.toml $'\\e[31m'", folder)
    assert code == 2 and "\x1b" not in errors and "\\x1b[31m.toml" in errors


def test_what_cannot_be_written_is_remembered_once_and_a_broken_pipe_is_no_failure():
    class Full:
        encoding = "utf-8"

        def __init__(self, error):
            self.error, self.calls = error, 0

        def write(self, _):
            self.calls += 1
            raise self.error

        def fileno(self):
            raise OSError

    for error in (OSError(28, "No space left on device"), BrokenPipeError(32, "Broken pipe"), ValueError("closed")):
        stream = Full(error)
        plain = Plain(stream, "\n")
        print("a", "b", file=plain)
        assert stream.calls == 1
        assert plain.failure is (error if getattr(error, "errno", 0) == 28 else None)
