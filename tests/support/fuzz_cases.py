"""Mutated scenes and result files: whatever they hold, only documented refusals come out, and soon.

A case is a number: its mutation follows from it, so any case can be run again by itself (`tools/fuzz.py --only`).
"""

import random
import signal
import time
from pathlib import Path

import numba
import numpy as np

import rsc
from rsc.results import budget
from rsc.scene.files.templates import MODELS, template
from rsc.scene.reading import all_keys
from rsc.study.run.start import run_of
from rsc.system.assemble import assemble
from scenes import DRIVEN, PUSHED

LIMIT = 5.0  # s of processor time, of one case; what waits without end is ended by tools/fuzz.py
MEMORY = 1 << 30  # bytes, of the process
PRETENDED_FREE = 300e6  # bytes of memory that a scene finds free
ARRAYS = ("time", "speed", "rotor", "stator", "normal_force", "friction_force", "tangential_velocity")
VALUES = (
    "0", "-0.0", "-1", "1e-320", "1e-12", "1e12", "1e30", "1e308", "1e999", "nan", "-inf", "true", "[]", "{}", "[[1, 2], [3, 4]]",
    "[0.0, 1.0]", "[1e5, 1e5]", "0x10", "1_000", "1979-05-27", '"1 mm"', '"1,5 mm"', '"5 kg"', '"-3 Hz"', '"laval"', '"rigid"',
    '"matrices"', '"x.npz"', '"../../x"', '"backward"', "'''\n", '"\\u0000"', "1" * 400, "[" * 50 + "]" * 50, "= 1", "",
)  # fmt: skip


def scene_text(number):
    """A mutated scene file, bytes."""
    dice = random.Random(number)
    lines = dice.choice(_TEXTS).splitlines()
    for _ in range(dice.choice((1, 1, 1, 2, 3, 6))):
        i = dice.randrange(len(lines))
        key, equals, value = lines[i].partition("=")
        kind = dice.randrange(7)
        if kind <= 2 and equals:
            lines[i] = f"{key}= {_number(dice, value) if kind == 0 else dice.choice(VALUES)}"
        elif kind == 3:
            del lines[i]
            lines = lines or [""]
        elif kind == 4:
            lines.insert(dice.randrange(len(lines) + 1), lines[i])
        elif kind == 5:
            table, key = dice.choice(_KEYS)
            lines.insert(i, f"[{table}]" if dice.random() < 0.1 else f"{key} = {dice.choice(VALUES)}")
        else:
            lines[i] = _scrambled(dice, lines[i])
    content = "\n".join(lines).encode("utf-8", "surrogatepass")
    return damaged(content, dice) if dice.random() < 0.2 else content


# every rotor, and between them several contacts, a drive with a torque, clearances and limits
_TEXTS = [*map(template, MODELS), *(rsc.Scene.from_dict(tables).to_toml() for tables in (PUSHED, DRIVEN))]
_KEYS = [dotted.rpartition(".")[::2] for dotted in all_keys() if "." in dotted]


def _number(dice, value):
    """The value of a line with its numbers scaled by powers of ten or turned around."""
    words = value.split("#")[0].replace("[", " [ ").replace("]", " ] ").replace(",", " , ").split()
    for i, word in enumerate(words):
        try:
            number = float(word)
        except ValueError:
            continue
        if dice.random() < 0.7:
            words[i] = repr(number * dice.choice((-1.0, 0.0, 0.5, 2.0, 10.0 ** dice.randint(-12, 12))))
    return " ".join(words)


def _scrambled(dice, line):
    if not line:
        return "]"
    i = dice.randrange(len(line))
    return line[:i] + dice.choice(("", "=", "[", '"', ".", "\t", "é", "\x00", "#", "{a=")) + line[i + dice.randint(0, 2) :]


def damaged(content, dice):
    """Bytes with bits flipped, a run overwritten, a piece cut out, doubled or exchanged, or the end cut off."""
    content, kind = bytearray(content), dice.randrange(7)
    place, length = dice.randrange(len(content)), dice.choice((1, 2, 8, 64, 512, 4096))
    end = min(place + length, len(content))
    if kind <= 1:
        for _ in range(dice.randint(1, 4)):
            content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
    elif kind == 2:
        content[place:end] = bytes([dice.choice((0, 255))]) * (end - place)
    elif kind == 3:
        content[place:end] = dice.randbytes(end - place)
    elif kind == 4:
        del content[place : place + dice.randint(1, length)]
    elif kind == 5:
        other = dice.randrange(len(content))
        content[place:end] = content[other : other + end - place]
    else:
        del content[place:]
    return bytes(content)


class TooLong(BaseException):
    """A case took longer than it may."""


def _alarm(number, frame):
    raise TooLong


class Clock:
    """Times a case and stops it when it takes longer than `limit`, s of processor time; default: LIMIT."""

    def __init__(self, limit=None):
        self._limit = LIMIT if limit is None else limit

    def __enter__(self):
        self._before = signal.signal(signal.SIGPROF, _alarm)
        signal.setitimer(signal.ITIMER_PROF, self._limit)
        self._started = time.process_time()
        return self

    def __exit__(self, *error):
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, self._before)
        self.seconds = time.process_time() - self._started


def _variant(scene):
    """What decides which code the kernel needs for a scene."""
    packed = run_of(scene).packed
    return numba.typeof(packed.model), packed.width, packed.method


def one_scene(number, folder, compiled):
    """Read the mutated scene `number`, and run it for some steps when it is accepted; returns what became of it, in a word.

    compiled : variants for which the kernel is compiled; other scenes are assembled only.
    """
    path = Path(folder, "fuzz.toml")
    path.write_bytes(scene_text(number))
    try:
        scene = rsc.load_scene(path)
        if scene.to_toml() and rsc.Scene.from_toml(scene.to_toml()) != scene:
            raise AssertionError("a scene changes when it is written and read")
        assemble(scene)
        if scene.limits is not None:
            rsc.limits(scene)
        if _variant(scene) not in compiled:
            return "accepted, assembled"
        result = rsc.simulate(scene.with_values({"solver.max_steps": min(scene.solver.max_steps, 2000)}))
        if not (np.isfinite(result.rotor).all() and np.isfinite(result.stator).all()):
            raise AssertionError("a stored sample is not finite")
        return f"run: {result.status}"
    except rsc.SceneError as error:
        one_line(error)
        return "refused (exit 2)"
    except rsc.SolverError as error:
        one_line(error)
        return "too large (exit 2)"


def one_result(number, folder, content, wanted):
    """Read the result file `content` with the damage `number`; wanted: name -> array of the whole one, its summary and scene."""
    path = Path(folder, "fuzz.h5")
    path.write_bytes(damaged(content, random.Random(number)))
    try:
        result = rsc.load(path)
        found = {name: getattr(result, name) for name in wanted[0]}
    except (rsc.DataError, rsc.SceneError) as error:
        one_line(error)
        return "refused (exit 4)" if isinstance(error, rsc.DataError) else "refused (exit 2)"
    same = all(np.array_equal(found[name], wanted[0][name]) for name in found)
    if not same or result.summary != wanted[1] or result.scene != wanted[2]:
        raise AssertionError("another value was read")
    return "read, nothing lost"


def one_line(error):
    """AssertionError unless a refusal is one printable line."""
    text = str(error)
    if "\n" in text or not text.isprintable() or len(text) > 1500:
        raise AssertionError(f"a refusal is no printable line: {text!r}")


def scenes(numbers, folder):
    """(case, outcome, seconds) of mutated scenes; whatever is not documented is raised as it is, with a note of the case."""
    free = budget.free_memory
    budget.free_memory = lambda: PRETENDED_FREE
    compiled = set()
    try:
        whole = [rsc.Scene.from_toml(text) for text in _TEXTS]
        # a mutated disk may have no gyroscopics, which is another kernel: its compilation is no hang
        for scene in [*whole, whole[MODELS.index("disk")].with_values({"rotor.polar_inertia": 0.0})]:
            compiled.add(_variant(scene))
            rsc.simulate(scene.with_values({"solver.max_steps": 10}))
        for number in numbers:
            yield case(number, one_scene, folder, compiled)
    finally:
        budget.free_memory = free


def results(numbers, folder, scene):
    """(case, outcome, seconds) of damaged copies of the result of a scene."""
    path = Path(folder, "whole.h5")
    whole = rsc.simulate(scene, path=path)
    names = (*ARRAYS, "rotor_velocity", "stator_velocity") if scene.output.velocities else ARRAYS
    wanted = {name: getattr(whole, name) for name in names}, whole.summary, scene
    content = path.read_bytes()
    for number in numbers:
        yield case(number, one_result, folder, content, wanted)


def case(number, function, *arguments, limit=None):
    """(number, outcome, seconds) of one case; what it raises gets a note of its number."""
    clock = Clock(limit)
    try:
        with clock:
            outcome = function(number, *arguments)
    except BaseException as error:
        error.add_note(f"fuzz case {number}")
        raise
    return number, outcome, clock.seconds


