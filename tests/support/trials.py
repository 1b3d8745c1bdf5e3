"""Commands on forged files of runs and sweeps, in children that may crash, hang or take memory without harm: how each case ended.

A child is a fork of the process that has imported and compiled everything. It runs cases one after the other, each command in
bounded time and memory, and tells its parent; where it dies or falls silent its case has failed, and another goes on behind it.
"""

import contextlib
import gc
import io
import json
import os
import random
import resource
import select
import shutil
import signal
import time
import traceback
from pathlib import Path

import forge
import forge_sweeps
import rsc
import rsc.cli
import rsc.simulation.run
from rsc.cli import main
from rsc.results.claims import part_of
from rsc.results.result_writer import ResultWriter
from rsc.simulation.run import versions
from rsc.study.run.simulate import simulate
from rsc.study.run.start import run_of
from scenes import DRIVEN, LAVAL, PUSHED, SCENES, TWO, changed

FORGING = 20  # s, after which forging a file is broken off
SECONDS = 2.0  # of processor time, of a command; of one that computes or draws:
LONGER = {"plot": 10.0, "sweep": 10.0, "report": 10.0}
SILENT = 120.0  # s without a word from a child, whose processor others use as well
BYTES = 300 * 2**20  # that a command may take
WORDS = {0: "done (exit 0)", 2: "refused (exit 2)", 4: "refused (exit 4)", 5: "done, cases missing or failed (exit 5)"}
TARGETS = ("plan", "part", "dataset", "folder")  # of a sweep; the fifth of every five cases is a result
# scenes that are swept, with the key of their frictions
SWEPT = {"contact.friction": LAVAL, "contact.ring.friction": TWO}
CHUNK_STEPS = 400
VELOCITIES = changed(SCENES["chains"], output={"velocities": True})
FORGED = {
    "bouncing": SCENES["bouncing"], "chains": SCENES["chains"], "velocities": VELOCITIES, "two contacts": PUSHED,
    "driven": DRIVEN,
}  # fmt: skip
KINDS = ("finished", "saved", "left by a kill")


@contextlib.contextmanager
def samples(folder, pictures=True):
    """Yield result files to begin with, (scene file, result file): of the scenes, each finished, saved from memory, and killed;
    pictures: whether any of them will be plotted.

    While they are used runs go on in small chunks, so that short ones have many blocks and checkpoints; all code is compiled.
    """
    before, rsc.simulation.run.CHUNK_STEPS = rsc.simulation.run.CHUNK_STEPS, CHUNK_STEPS
    pairs = []
    try:
        for name, tables in FORGED.items():
            scene = rsc.Scene.from_dict(tables)
            text = Path(folder, f"{name}.toml")
            text.write_text(scene.to_toml())
            files = [Path(folder, f"{name}_{i}.h5") for i in range(len(KINDS))]
            simulate(scene, path=files[0])
            simulate(scene).save(files[1])
            _kill(scene, files[2])
            pairs += [(text, file) for file in files]
        _warm(pairs, folder, pictures)
        yield pairs
    finally:
        rsc.simulation.run.CHUNK_STEPS = before


def _kill(scene, path):
    """The file of a run that was killed behind its fifth block."""
    run = run_of(scene)
    with ResultWriter(path, scene, versions()) as writer:
        writer.append(run.empty_block(), run.checkpoint())
        for i, (block, _) in enumerate(run.chunks()):
            writer.append(block, run.checkpoint())
            if i == 5:
                break
        writer._file.close()  # else HDF5 lets nobody change it, forgers neither
        shutil.copy(part_of(path), path)


def _warm(pairs, folder, pictures):
    """Compile and import all that the commands need, so that no child does it again."""
    for scene, result in pairs:
        for arguments in _commands(scene, placed(result, folder), folder, pictures):
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                main(arguments)


def placed(result, folder):
    """A copy of a result file to work on; that of a killed run has the name that it had while it went on."""
    path = Path(folder, "run.h5")
    for other in (path, part_of(path), Path(folder, "run.h5.left")):
        other.unlink(missing_ok=True)
    path = part_of(path) if result.stem.endswith(str(KINDS.index("left by a kill"))) else path
    shutil.copy(result, path)
    return path


def _commands(scene, path, folder, pictures):
    output = str(path).removesuffix(".part")
    commands = [["info", str(path)], ["verify", str(path)], ["run", str(scene), "-o", output, "--resume"]]
    if pictures:
        commands.insert(2, ["plot", str(path), "-o", str(Path(folder, "pictures"))])
    return commands


def one(number, pairs, folder, pictures):
    """Forge a file and run the commands on it: name of the command -> what became of it. Raises what a user would see raised."""
    scene, result = pairs[number // 5 % len(pairs)]
    os.chdir(folder)  # where the files that forged links name would be
    path = placed(result, folder)
    _apart(lambda: forge.forge(path, number))
    return {arguments[0]: ended(arguments) for arguments in _commands(scene, path, folder, pictures)}


def ended(arguments):
    """What became of a command, in words; AssertionError for an end that is not documented."""
    texts = io.StringIO(), io.StringIO()
    began = time.process_time()
    with contextlib.redirect_stdout(texts[0]), contextlib.redirect_stderr(texts[1]):
        code = main(arguments)
    seconds = time.process_time() - began
    errors = texts[1].getvalue()
    if code not in WORDS:
        raise AssertionError(f"{arguments[0]} ended with exit code {code}: {errors}")
    if code in (2, 4) and (errors.count("error: ") != 1 or not errors.rstrip("\n").splitlines()[-1].isprintable()):
        raise AssertionError(f"{arguments[0]} says {errors!r}")
    if seconds > LONGER.get(arguments[0], SECONDS):
        raise AssertionError(f"{arguments[0]} took {seconds:.1f} s")
    return WORDS[code]


def swept(folder):
    """[(arguments of a sweep, its whole store)] of one contact and of two; all code that sweeps need is compiled."""
    made = []
    for key, tables in SWEPT.items():
        scene, store = Path(folder, f"{key}.toml"), Path(folder, key)
        scene.write_text(rsc.Scene.from_dict(changed(tables, drive={"duration": 0.05})).to_toml())
        grid = ["--vary", f"{key}=0.05,0.1,0.2", "--vary", "drive.speed=40:60:6", "--compute", "predict,run", "--threads", "1"]
        arguments = ["sweep", str(scene), *grid]
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            main([*arguments, "-o", str(store)])
            main(["plot", str(store / "sweep.nc"), "-o", str(Path(folder, "pictures"))])
            main(["report", str(store / "sweep.nc"), "-o", str(Path(folder, "pages"))])
        made.append((arguments, store))
    return made


def one_sweep(number, sweeps, folder, pictures):
    """As `one`, of a store or a dataset; what a sweep may not change must be as it was, and its own parts must have their bits
    where they were computed again."""
    arguments, whole = sweeps[number // 5 % len(sweeps)]
    os.chdir(folder)
    store, precious, target = Path(folder, "store"), Path(folder, forge_sweeps.PRECIOUS), TARGETS[number % 5]
    shutil.rmtree(store, ignore_errors=True)
    shutil.copytree(whole, store)
    precious.write_text("kept")
    dice = random.Random(number)
    if target == "folder":
        _apart(lambda: forge_sweeps.forge_folder(store, number))
    else:
        parts = sorted((store / "parts").iterdir())
        path = {"plan": store / "plan.h5", "part": dice.choice(parts), "dataset": store / "sweep.nc"}[target]
        _apart(lambda: forge_sweeps.forge_image(path, number))
    outcomes = {}
    for name, command in _sweep_commands(arguments, store, folder, target, pictures):
        try:
            outcomes[name] = ended(command)
        except AssertionError as error:
            raise AssertionError(f"{name}: {error}") from None
    if precious.read_text() != "kept" or precious.stat().st_size != 4:
        raise AssertionError("another file was changed")
    for path in whole.glob("parts/*") if target == "folder" and outcomes["sweep --resume"].startswith("done (") else ():
        if (store / "parts" / path.name).read_bytes() != path.read_bytes():
            raise AssertionError(f"{path.name} has other bits")
    return outcomes


def _sweep_commands(arguments, store, folder, target, pictures):
    """(name, arguments) of the commands on a forged store or dataset."""
    if target == "dataset":
        commands = [("plot sweep.nc", ["plot", str(store / "sweep.nc"), "-o", str(Path(folder, "pictures"))])]
        page = ("report sweep.nc", ["report", str(store / "sweep.nc"), "-o", str(Path(folder, "pages"))])
        return [*commands, page] if pictures else commands
    name = str(store)
    return [
        ("sweep status", ["sweep", "status", name]),
        ("sweep scene", ["sweep", "scene", name, "1"]),
        ("sweep collect", ["sweep", "collect", name]),
        ("sweep run", ["sweep", "run", name, "--part", "0"]),
        ("sweep --resume", [*arguments, "-o", name, "--resume"]),
    ]


def _apart(forging):
    """Forge in a process of its own: where HDF5 refuses what a forger asks for it may be left in no good state, or never end;
    then the file stays as it is by then."""
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(FORGING)
        with contextlib.suppress(BaseException):
            forging()
        os._exit(0)
    os.waitpid(child, 0)


def trials(numbers, pairs, sweeps, folder, pictures=lambda number: False):
    """Yield (number, outcomes or None, problem) of every case: of results to begin with (`samples`) and sweeps (`swept`);
    pictures: whether a case is plotted too."""
    def tried(number):
        drawn = pictures(number)
        return one(number, pairs, folder, drawn) if number % 5 == 4 else one_sweep(number, sweeps, folder, drawn)

    numbers = list(numbers)
    while numbers:
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(reader)
            _serve(numbers, tried, writer)
        os.close(writer)
        done, begun, problem = [], None, ""
        for kind, number, content in _words(reader):
            if kind == "begin":
                begun = number
            else:
                done.append(number)
                yield number, content if kind == "end" else None, "" if kind == "end" else content
                begun = None
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)
        status = os.waitpid(child, 0)[1]
        os.close(reader)
        if begun is not None:
            signalled = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
            problem = "it hangs" if signalled == signal.SIGKILL else f"signal {signalled}" if signalled else f"status {status}"
            done.append(begun)
            yield begun, None, problem
        elif not done:
            raise RuntimeError("a child does not begin")
        numbers = [number for number in numbers if number not in set(done)]


def _words(reader):
    """What a child tells, until it ends or falls silent."""
    rest = b""
    while select.select([reader], [], [], SILENT)[0]:
        content = os.read(reader, 65536)
        if not content:
            return
        *lines, rest = (rest + content).split(b"\n")
        for line in lines:
            yield json.loads(line)


def _serve(numbers, tried, writer):
    """In a child: the cases one after the other."""
    def tell(*words):
        os.write(writer, json.dumps(words).encode() + b"\n")

    try:
        gc.freeze()
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        rsc.cli.LEAST_ADDRESS_SPACE = 0.0  # what takes most of it, the compiler, is done
        resource.setrlimit(resource.RLIMIT_AS, (size + BYTES, size + BYTES))
        for number in numbers:
            tell("begin", number, None)
            try:
                tell("end", number, tried(number))
            except BaseException:
                tell("fail", number, traceback.format_exc())
    finally:
        os._exit(0)
