"""Commands on forged result files, in children that may crash, hang or take memory without harm: what became of each case.

A child is a fork of the process that has imported and compiled everything. It runs cases one after the other, each command in
bounded time and memory, and tells its parent; where it dies or falls silent its case has failed, and another goes on behind it.
"""

import contextlib
import gc
import io
import json
import os
import resource
import select
import shutil
import signal
import time
import traceback
from pathlib import Path

import forge
import rsc
import rsc.cli
import rsc.simulation.run
from rsc.cli import main
from rsc.results.result_file import ResultWriter, part_of
from rsc.simulation.run import versions
from rsc.study.simulate import simulate
from rsc.study.start import run_of
from scenes import SCENES, changed

SECONDS = 2.0  # of processor time, of a command
SILENT = 20.0  # s without a word from a child
BYTES = 300 * 2**20  # that a command may take
WORDS = {0: "done (exit 0)", 2: "refused (exit 2)", 4: "refused (exit 4)"}
CHUNK_STEPS = 400
VELOCITIES = changed(SCENES["chains"], output={"velocities": True})
FORGED = {"bouncing": SCENES["bouncing"], "chains": SCENES["chains"], "velocities": VELOCITIES}
KINDS = ("finished", "saved", "left by a kill")


@contextlib.contextmanager
def samples(folder):
    """Yield result files to begin with, (scene file, result file): of the scenes, each finished, saved from memory, and killed.

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
        _warm(pairs, folder)
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


def _warm(pairs, folder):
    """Compile and import all that the commands need, so that no child does it again."""
    for scene, result in pairs:
        for arguments in _commands(scene, placed(result, folder), folder, True):
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
    scene, result = pairs[number % len(pairs)]
    os.chdir(folder)  # where the files that forged links name would be
    path, outcomes = placed(result, folder), {}
    _forged(path, number)
    for arguments in _commands(scene, path, folder, pictures):
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
        if seconds > SECONDS and arguments[0] != "plot":
            raise AssertionError(f"{arguments[0]} took {seconds:.1f} s")
        outcomes[arguments[0]] = WORDS[code]
    return outcomes


def _forged(path, number):
    """Forge in a process of its own: where HDF5 refuses what a forger asks for it may be left in no good state."""
    child = os.fork()
    if child == 0:
        with contextlib.suppress(BaseException):
            forge.forge(path, number)
        os._exit(0)
    os.waitpid(child, 0)


def trials(numbers, pairs, folder, pictures=lambda number: False):
    """Yield (number, outcomes or None, problem) of every case; pictures: whether a case is plotted too."""
    numbers = list(numbers)
    while numbers:
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(reader)
            _serve(numbers, pairs, folder, pictures, writer)
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


def _serve(numbers, pairs, folder, pictures, writer):
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
                tell("end", number, one(number, pairs, folder, pictures(number)))
            except BaseException:
                tell("fail", number, traceback.format_exc())
    finally:
        os._exit(0)
