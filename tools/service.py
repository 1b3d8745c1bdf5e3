"""Service in miniature: three users with mixed commands on one machine, with kills, signals, full disks and lost permissions.

    python tools/service.py --seconds 7200 --write        two hours
    python tools/service.py --seconds 900                 a quarter of an hour, nothing kept

Every user has a folder, on a small disk of its own where this process may mount one, and a common folder in which all write the
same result. What a command writes or prints is compared, bit for bit, with what it was in the beginning without disturbance. In
the end every run that was killed is resumed, and folders must hold what they should and nothing else. Exit code 1 where anything
was lost, wrong, left behind, a traceback, a signal of its own or a hang.
"""

import argparse
import collections
import contextlib
import ctypes
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from pages import TABLES, write_page

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests" / "support")]
DISK = "48m"
HANG = 300.0  # s
SCENES_OF_A_USER = {"bouncing": "bouncing", "wall": "rigid wall", "chains": "chains"}  # file -> scene of tests/support/scenes.py
ARRAYS = ("time", "rotor", "normal_force", "friction_force")
CALM, FAULTS = 0.5, ("kill -9", "SIGTERM", "SIGINT", "full disk", "lost permission")
_DROP, _OVERRIDE = 24, (1, 2)  # prctl(PR_CAPBSET_DROP), the capabilities by which root may write anywhere

# name -> (arguments, what it needs or None); {s} is a scene
COMMANDS = {
    "run": ("run {s}.toml", None),
    "run --resume": ("run {s}.toml --resume", "{s}.h5"),
    "run, one file for all": ("run {s}.toml -o ../common/shared.h5", None),
    "check": ("check {s}.toml", None),
    "predict": ("predict {s}.toml --json", None),
    "predict --speed": ("predict {s}.toml --speed 20 50 --json", None),
    "info": ("info {s}.h5", "{s}.h5"),
    "verify": ("verify {s}.h5", "{s}.h5"),
    "plot": ("plot {s}.h5 -o pictures", "{s}.h5"),
    "sweep": ("sweep {s}.toml --vary contact.friction=0.05:0.3:40 --compute predict -o {s}-sweep", None),
    "sweep --resume": ("sweep {s}.toml --vary contact.friction=0.05:0.3:40 --compute predict -o {s}-sweep --resume", "{s}-sweep"),
    "new": ("new laval", None),
    "run of a wrong scene": ("run wrong.toml", None),
}


class Tally:
    """What became of the commands, by name."""

    def __init__(self):
        self.lock, self.ends, self.faults, self.seconds = threading.Lock(), {}, {}, {}
        self.failures, self.peak = [], {}

    def add(self, name, fault, code, usage):
        with self.lock:
            self.ends.setdefault(name, collections.Counter())[code] += 1
            self.faults.setdefault(name, collections.Counter())[fault] += 1
            self.seconds.setdefault(name, []).append(usage.ru_utime + usage.ru_stime)
            self.peak[name] = max(self.peak.get(name, 0), usage.ru_maxrss * 1024)

    def fail(self, *words):
        with self.lock:
            self.failures.append(" ".join(str(word) for word in words))
            print("FAILED:", self.failures[-1], file=sys.stderr, flush=True)


def bound_by_permissions():
    """In a child: root, too, may write only where the permissions say so."""
    library = ctypes.CDLL(None)
    for capability in _OVERRIDE:
        library.prctl(_DROP, capability, 0, 0, 0)


class User(threading.Thread):
    """One user: a folder, dice of its own, commands one after the other until closing time."""

    def __init__(self, number, place, wanted, tally, until):
        super().__init__()
        self.folder, self.dice = place / f"user{number}", random.Random(number)
        self.wanted, self.tally, self.until = wanted, tally, until
        self.environment = os.environ | {"PYTHONPATH": str(ROOT / "src"), "TMPDIR": str(place / f"tmp{number}")}

    def run(self):
        while time.monotonic() < self.until:
            name = self.dice.choice(list(COMMANDS))
            scene = self.dice.choice(list(SCENES_OF_A_USER))
            fault = None if self.dice.random() < CALM else self.dice.choice(FAULTS)
            try:
                self.command(name, scene, fault)
            except Exception as error:
                self.tally.fail(self.folder.name, name, scene, fault, repr(error))
        for scene in SCENES_OF_A_USER:
            self.command("run --resume" if self.holds(f"{scene}.h5") else "run", scene, None)

    def holds(self, file):
        """Whether a result or what a kill left of it is there."""
        return any((self.folder / f"{file}{ending}").exists() for ending in ("", ".part", ".left"))

    def command(self, name, scene, fault):
        """Run a command under a fault and look at what it did."""
        words, needs = COMMANDS[name]
        there = needs is None or self.holds(needs.format(s=scene))
        command = [sys.executable, "-m", "rsc", *words.format(s=scene).split(" ")]
        with self.disturbed(fault), tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as errors:
            child = subprocess.Popen(
                command, cwd=self.folder, env=self.environment, stdout=out, stderr=errors, preexec_fn=bound_by_permissions
            )
            code, usage = self.ended(child, fault)
            printed, told = (_text(stream) for stream in (out, errors))
        self.tally.add(name, fault or "none", code, usage)
        problem = self.problem(name, scene, fault, code, there, printed, told)
        if problem:
            self.tally.fail(self.folder.name, name, scene, fault, code, problem, told[-600:])

    def ended(self, child, fault):
        """(exit code, resources) of a child, which is sent the signal of a fault at a random moment."""
        number = {"kill -9": signal.SIGKILL, "SIGTERM": signal.SIGTERM, "SIGINT": signal.SIGINT}.get(fault)
        send = time.monotonic() + (self.dice.uniform(1.0, 12.0) if number else HANG)
        while True:
            pid, status, usage = os.wait4(child.pid, os.WNOHANG)
            if pid:
                child.returncode = os.waitstatus_to_exitcode(status)
                return child.returncode, usage
            if time.monotonic() > send:
                os.kill(child.pid, number or signal.SIGKILL)
                if number is None:
                    self.tally.fail(self.folder.name, child.args, "hung")
                send = time.monotonic() + HANG
                number = None
            time.sleep(0.02)

    @contextlib.contextmanager
    def disturbed(self, fault):
        """The user's folder while a fault lasts."""
        filler = self.folder / "filler"
        if fault == "full disk" and os.path.ismount(self.folder):
            left = self.dice.choice((0, 20_000, 300_000, 3_000_000))
            free = os.statvfs(self.folder)
            with contextlib.suppress(OSError), open(filler, "wb") as file:
                os.posix_fallocate(file.fileno(), 0, max(free.f_bavail * free.f_frsize - left, 4096))
        if fault == "lost permission":
            self.folder.chmod(0o555)
        try:
            yield
        finally:
            self.folder.chmod(0o755)
            filler.unlink(missing_ok=True)

    def problem(self, name, scene, fault, code, there, printed, told):
        """What is wrong with a command that has ended, "" when nothing is."""
        if "Traceback" in told or "Traceback" in printed:
            return "a traceback"
        killed = {"kill -9": (-9,), "SIGTERM": (130, -15), "SIGINT": (130,)}.get(fault, ())
        refused = (4,) if fault in ("full disk", "lost permission") or not there or "for all" in name else ()
        usual = (2,) if "wrong" in name else (0,)
        left = (2, 4) if "--resume" in name or name in ("sweep", "info", "verify", "plot") else ()  # by an earlier fault
        if code not in (*killed, *refused, *usual, *left):
            return "another exit code than it should have"
        if code in (2, 4) and not told.strip().splitlines()[-1:][0].startswith("error: "):
            return "no reason"
        if code == 0:
            return self.wrong(name, scene, printed)
        return ""

    def wrong(self, name, scene, printed):
        """What is other than it was without disturbance, "" when nothing is."""
        file = {"run": f"{scene}.h5", "run --resume": f"{scene}.h5", "check": f"out/{scene}/result.h5"}.get(name)
        if file is not None:
            return "" if _same(arrays_of(self.folder / file), self.wanted[scene]) else "other samples"
        if name.startswith("sweep"):
            found = frequencies_of(self.folder / f"{scene}-sweep")
            return "" if _same(found, self.wanted["swept", scene]) else "other predictions"
        if name == "verify":
            return "" if "the same bits" in printed else "not verified"
        known = self.wanted.get((name, scene))
        return "" if known is None or known == printed else "other output"


def _text(stream):
    stream.seek(0)
    return stream.read()


def _same(found, wanted):
    import numpy as np

    return found.keys() == wanted.keys() and all(np.array_equal(found[n], wanted[n], equal_nan=True) for n in wanted)


def arrays_of(path):
    """name -> array of a result."""
    import rsc

    result = rsc.load(path)
    return {name: getattr(result, name) for name in ARRAYS}


def frequencies_of(folder):
    """name -> array of the dataset of a sweep."""
    import h5py

    with h5py.File(folder / "sweep.nc", "r", locking=False) as file:
        return {name: file[name][()] for name in ("frequency", "rotor_amplitude") if name in file}


def opened(place, number):
    """The folder of a user with its scenes, on a disk of its own where one can be mounted."""
    import rsc
    from scenes import SCENES, changed

    folder = place / f"user{number}"
    folder.mkdir()
    (place / f"tmp{number}").mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK}", "rsc-service", folder], check=False, capture_output=True)
    for scene in SCENES_OF_A_USER:
        content = changed(SCENES[SCENES_OF_A_USER[scene]], drive={"duration": 8.0}, contact={"friction": 0.1})
        (folder / f"{scene}.toml").write_text(rsc.Scene.from_dict(content).to_toml())
    (folder / "wrong.toml").write_text((folder / "chains.toml").read_text().replace("gap = ", "gap = -"))
    return folder


def undisturbed(place, tally):
    """(name, scene) -> what commands print and files hold when nothing disturbs them."""
    import rsc

    wanted = {}
    folder = opened(place, 0)
    first = User(0, place, wanted, tally, 0.0)
    for scene in SCENES_OF_A_USER:
        for name in ("sweep", "predict", "predict --speed"):
            command = [sys.executable, "-m", "rsc", *COMMANDS[name][0].format(s=scene).split(" ")]
            done = subprocess.run(command, cwd=folder, env=first.environment, capture_output=True, text=True, check=True)
            wanted[name, scene] = done.stdout
        result = rsc.simulate(rsc.load_scene(folder / f"{scene}.toml"))
        wanted[scene] = {name: getattr(result, name) for name in ARRAYS}
        wanted["swept", scene] = frequencies_of(folder / f"{scene}-sweep")
    return wanted


def left_behind(place):
    """Files that should not be there when everything is over."""
    allowed = {"wrong.toml", "out", "pictures", *(f"{s}{end}" for s in SCENES_OF_A_USER for end in (".toml", ".h5", "-sweep"))}
    strays = [path for folder in place.glob("user*") for path in folder.iterdir() if path.name not in allowed]
    strays += [path for path in place.rglob("*") if path.name.startswith(".rsc-")]
    return strays + [path for folder in place.glob("tmp*") for path in folder.iterdir()]


def table(tally, seconds, users, mounted):
    """Markdown: what became of the commands."""
    faults = ("none", *FAULTS)
    ends = sorted({code for counter in tally.ends.values() for code in counter}, key=lambda code: (code < 0, abs(code)))
    names = [f"exit {code}" if code >= 0 else f"signal {-code}" for code in ends]
    head = ["command", "number", *faults, *names, "processor s", "MB"]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for name in COMMANDS:
        if name not in tally.ends:
            continue
        times = sorted(tally.seconds[name])
        cells = [name, sum(tally.ends[name].values()), *(tally.faults[name][fault] or "" for fault in faults)]
        cells += [tally.ends[name][code] or "" for code in ends]
        cells += [f"{times[len(times) // 2]:.1f}", f"{tally.peak[name] / 1e6:.0f}"]
        lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
    total = sum(sum(counter.values()) for counter in tally.ends.values())
    disk = f"each on a disk of {DISK[:-1]} MB" if mounted else "without disks of their own, so that none was full"
    summary = f"{total} commands of {users} users, {disk}, in {seconds:.0f} s. Processor time: the median; memory: the largest."
    whole = "Nothing lost, nothing wrong, nothing left behind, no hang, no traceback."
    problems = [f"- {text[:300]}" for text in tally.failures] or [whole]
    return "\n".join([summary, "", *lines, "", *problems])


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=7200.0)
    parser.add_argument("--users", type=int, default=3)
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in the background of a shell, and so would children
    tally, began = Tally(), time.monotonic()
    with tempfile.TemporaryDirectory(prefix="rsc-service-") as temporary:
        place = Path(temporary)
        try:
            (place / "common").mkdir()
            wanted = undisturbed(place, tally)
            folders = [opened(place, number) for number in range(1, options.users + 1)]
            users = [User(number + 1, place, wanted, tally, began + options.seconds) for number in range(options.users)]
            mounted = all(os.path.ismount(folder) for folder in folders)
            for user in users:
                user.start()
            for user in users:
                user.join()
            for path in left_behind(place):
                tally.fail("left behind:", path.relative_to(place))
        finally:
            for folder in place.glob("user*"):
                if os.path.ismount(folder):
                    subprocess.run(["umount", folder], check=False)
    text = table(tally, time.monotonic() - began, options.users, mounted)
    print(text)
    if options.write:
        command = f"python tools/service.py --seconds {options.seconds:.0f} --write"
        write_page(TABLES / "service.md", "Service in miniature", command, text)
    return 1 if tally.failures else 0


if __name__ == "__main__":
    sys.exit(main())
