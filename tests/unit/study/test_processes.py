"""Objects and errors in copies, pickles and other processes; many threads; functions of the caller that fail; no growth."""

import copy
import gc
import multiprocessing
import os
import pickle
import re
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import rsc
from rsc import errors
from rsc.analysis.survey.survey import survey
from rsc.simulation.run import Run
from rsc.study.run.ensemble import NoRun
from scenes import SCENES, changed

SCENE = rsc.Scene.from_dict(changed(drive={"duration": 0.3}))
LONG = rsc.Scene.from_dict(changed(SCENES["bouncing"], drive={"duration": 500.0}, contact={"friction": 0.0}))
POOL = """
import multiprocessing, sys
from concurrent.futures import ProcessPoolExecutor
import rsc

def work(text):
    return rsc.simulate(rsc.Scene.from_toml(text, "scene"))

def main(method, text):
    whole = work(text)
    rsc.simulate_many([whole.scene] * 9, threads=2)  # threads that a forked process does not have
    bad = text.replace("gap = 0.001", "gap = -1")
    with multiprocessing.get_context(method).Pool(2) as pool:
        for result in pool.map(work, [text] * 3):
            assert (result.rotor == whole.rotor).all() and result.summary == whole.summary
        try:
            pool.map(work, [text, bad])
        except rsc.SceneError as error:
            assert (error.key, error.value) == ("contact.gap", -1)
    with ProcessPoolExecutor(2, multiprocessing.get_context(method)) as pool:
        try:
            list(pool.map(work, [bad, text]))
        except rsc.SceneError as error:
            print(error)

if __name__ == "__main__":
    main(sys.argv[1], open(sys.argv[2]).read())
"""


def public_objects(folder):
    """name -> an object of every kind that a caller of rsc can hold."""
    run = rsc.simulate(SCENE)
    file = folder / "run.h5"
    run.save(file)
    many = rsc.predict_many([SCENE], [50.0])
    return {
        "scene": SCENE, "run": run, "loaded": rsc.load(file), "report": rsc.check(SCENE), "whirls": rsc.predict(SCENE, 50.0),
        "arrays": many, "ratios": rsc.force_ratios(SCENE, 50.0), "fall": rsc.waterfall(run, window=0.1), "survey": survey(SCENE),
        "peaks": rsc.spectral_peaks(run, window=0.1), "envelope": rsc.envelope(run, window=0.1), "changes": rsc.transitions(run),
        "cases": rsc.cases(SCENE, {"contact.friction": [0.1, 0.2]}), "none": NoRun(SCENE, "why"),
    }  # fmt: skip


def public_errors():
    """An error of every class."""
    for kind in vars(errors).values():
        if isinstance(kind, type) and issubclass(kind, errors.RscError):
            other = ("x.h5", "is gone") if issubclass(kind, errors.DataError) else ("a reason",)
            yield kind(*("x.toml", "contact.gap", 10**400, "> 0", "a hint") if kind is errors.SceneError else other)


def alike(value, other):
    """Whether two objects hold the same, to the last array."""
    if isinstance(value, np.ndarray):
        return np.array_equal(value, other, equal_nan=value.dtype.kind in "fc")
    if isinstance(value, (list, tuple)):
        return len(value) == len(other) and all(map(alike, value, other))
    if isinstance(value, dict):
        return value.keys() == other.keys() and all(alike(value[key], other[key]) for key in value)
    if type(value).__module__.startswith("rsc.") and hasattr(value, "__dict__"):
        return type(value) is type(other) and alike(vars(value), vars(other))
    return value == other or repr(value) == repr(other)


WAYS = [copy.copy, copy.deepcopy, *(lambda value, p=p: pickle.loads(pickle.dumps(value, p)) for p in (2, 5))]


def test_every_object_survives_copies_and_pickles(tmp_path):
    for name, value in public_objects(tmp_path).items():
        for way in WAYS:
            assert alike(value, way(value)), name
    loaded = pickle.loads(pickle.dumps(rsc.load(tmp_path / "run.h5")))
    assert np.array_equal(loaded.rotor, rsc.simulate(SCENE).rotor)


def test_every_error_survives_copies_and_pickles():
    found = list(public_errors())
    assert len(found) > 5
    for error in found:
        error.result = 3  # an attribute that was given later
        error.add_note("a note")
        for way in WAYS:
            other = way(error)
            assert type(other) is type(error) and str(other) == str(error)
            assert sorted(map(repr, vars(other).items())) == sorted(map(repr, vars(error).items()))


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_pools_of_processes_give_the_same_bits_and_the_errors(method, tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE.to_toml())
    script = tmp_path / "pool.py"
    script.write_text(POOL)
    done = subprocess.run(
        [sys.executable, "-W", "ignore", script, method, tmp_path / "scene.toml"], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("scene: contact.gap = -1: must be")


class Failing:
    """A caller's own standard error or function that fails at the call with this number."""

    encoding = "utf-8"

    def __init__(self, number):
        self.left = number

    def __call__(self, text):
        self.left -= 1
        if self.left <= 0:
            raise RuntimeError("the caller's own")
        return len(text)

    write = __call__

    def flush(self):
        pass


@pytest.mark.parametrize("to_file", [True, False])
def test_a_note_that_fails_after_the_run_loses_nothing(to_file, tmp_path):
    coarse = _coarse()
    where = {"path": tmp_path / "run.h5"} if to_file else {}
    whole = rsc.simulate(coarse)
    with pytest.raises(RuntimeError, match="the caller's own") as caught:
        rsc.simulate(coarse, note=Failing(2), **where)
    assert caught.value.result.status == "finished" and np.array_equal(caught.value.result.rotor, whole.rotor)
    assert os.listdir(tmp_path) == ["run.h5"] * to_file


def _coarse():
    """A scene whose run ends with a remark: it moves by little and its tolerance is wide."""
    tables = {"start": {"rest": True}, "rotor": {"eccentricity": 1e-9}, "solver": {"rtol": 1e-4}}
    return rsc.Scene.from_dict(changed(SCENES["whirl, unbalance, run-up"], **tables))


def test_a_note_that_fails_before_the_run_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError, match="the caller's own"):
        rsc.simulate(SCENE, note=Failing(1), path=tmp_path / "run.h5")
    assert os.listdir(tmp_path) == []
    rsc.simulate(SCENE, path=tmp_path / "run.h5")  # no lock is left either


def test_compiling_is_told_while_it_lasts_and_after(monkeypatch):
    notes, compile_now = [], Run.compile

    def slow(run):
        time.sleep(0.3)
        compile_now(run)

    rsc.simulate(SCENE, note=notes.append)
    assert not any("compil" in text for text in notes)
    monkeypatch.setattr(Run, "compile", slow)
    monkeypatch.setattr("rsc.study.run.simulate.LOADED", 0.1)
    rsc.simulate(SCENE, note=notes.append)
    told = [text for text in notes if "compil" in text]
    assert len(told) == 2 and "once on this machine" in told[0] and told[1].startswith("compiled in ")


@pytest.mark.parametrize("to_file", [True, False])
def test_progress_that_fails_ends_the_run_with_its_samples(to_file, tmp_path, monkeypatch):
    where = {"path": tmp_path / "run.h5"} if to_file else {}
    monkeypatch.setattr(sys, "stderr", Failing(2))
    with pytest.raises(RuntimeError, match="the caller's own") as caught:
        rsc.simulate(LONG, progress=True, **where)
    monkeypatch.undo()
    part = caught.value.result
    assert part.status == "interrupted" and 1000 < len(part.time) < 1_000_000
    assert np.isfinite(part.rotor).all() and os.listdir(tmp_path) == ["run.h5"] * to_file
    if to_file:
        assert np.array_equal(rsc.simulate(LONG, resume=True, **where).rotor, rsc.simulate(LONG).rotor)


def test_a_run_that_will_take_long_is_told_after_its_first_second(monkeypatch):
    notes = []
    endless = LONG.with_values({"drive.duration": 1e7, "output.rate": 300.0, "solver.max_steps": 10**12})

    def stop(text):
        notes.append(text)
        if len(notes) == 2:
            raise RuntimeError("enough")

    monkeypatch.setattr("rsc.results.budget.free_memory", lambda: None)
    began = time.process_time()
    with pytest.raises(RuntimeError, match="enough") as caught:
        rsc.simulate(endless, note=stop)
    assert time.process_time() - began < 5.0 and caught.value.result.status == "interrupted"
    assert re.fullmatch(r".* s of the run took .* s: it will take another .* h; Ctrl-C keeps .*", notes[1])
    rsc.simulate(LONG, note=notes.append)  # a second or two
    assert not any("it will take another" in text for text in notes[2:])


def test_twenty_threads_at_once(tmp_path):
    """Runs, predictions, reports and files in 20 threads give what they give alone."""
    names = "bouncing", "rigid wall", "chains"
    scenes = [rsc.Scene.from_dict(changed(SCENES[name], drive={"duration": 0.2})) for name in names]
    together = threading.Barrier(20)

    def work(number):
        scene, file = scenes[number % 3], tmp_path / f"{number}.h5"
        together.wait(60.0)
        run = rsc.simulate(scene, path=file)
        whirls = rsc.predict(scene, 40.0)
        with pytest.raises(rsc.SceneError) as refused:
            rsc.Scene.from_dict({"rotor": number})
        fall = rsc.waterfall(rsc.load(file), window=0.05)
        return run.summary, run.rotor, [whirl.frequency for whirl in whirls], fall.amplitude, str(refused.value)

    with ThreadPoolExecutor(20) as pool:
        found = list(pool.map(work, range(20)))
    for number in range(3):
        alone = rsc.simulate(scenes[number])
        for summary, rotor, frequencies, amplitude, _ in found[number::3]:
            assert summary == alone.summary and np.array_equal(rotor, alone.rotor)
            assert frequencies == found[number][2] and np.array_equal(amplitude, found[number][3])


def held():
    """(memory in MB, threads, file descriptors) of this process."""
    gc.collect()
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    return int(status["VmRSS"].split()[0]) / 1000.0, int(status["Threads"]), len(os.listdir("/proc/self/fd"))


@pytest.mark.parametrize("count", [100, pytest.param(10_000, marks=pytest.mark.nightly)])
def test_many_short_runs_leave_nothing_behind(count, tmp_path):
    short = SCENE.with_values({"drive.duration": 0.01})

    def use(number):
        rsc.simulate(short.with_values({"contact.friction": 0.1 + 1e-6 * number}))
        if number % 10 == 0:
            rsc.load(rsc.simulate(short, path=tmp_path / "run.h5").source.path).rotor.sum()
            rsc.simulate_many([short] * 9, threads=2)
            rsc.predict(short, 50.0)
            with pytest.raises(rsc.SceneError):
                short.with_values({"contact.gap": -1.0})

    for number in range(100):
        use(number)
    before = held()
    for number in range(count):
        use(number)
    after = held()
    # fewer where a thread of an earlier test ended meanwhile
    assert after[1] <= before[1] and after[2] <= before[2] and after[0] < before[0] + 5.0, (before, after)
    assert os.listdir(tmp_path) == ["run.h5"]
