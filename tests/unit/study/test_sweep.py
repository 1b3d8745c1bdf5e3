"""Sweeps: the same bits whoever computes them, nothing lost, a case that fails fails alone."""

import os
import shutil
import signal
import sys
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import rsc
from rsc.results.sweep_store import SweepStore
from rsc.study.sweep import compute, engines, plan
from rsc.study.sweep.compute import compute_part
from rsc.study.sweep.sweep import collected, computed
from scenes import LAVAL, changed

SCENE = rsc.Scene.from_dict(changed(LAVAL, drive={"duration": 0.2}), "laval.toml")
VARY = {"contact.friction": "0.05:0.3:6", "drive.speed": "30,50,70"}
BOTH = ("predict", "run")


def same(one, other):
    """Whether two datasets are the same bits."""
    names = set(one.variables)
    return names == set(other.variables) and all(one[n].values.tobytes() == other[n].values.tobytes() for n in names)


def files(folder):
    """name -> content of the parts of a store."""
    return {path.name: path.read_bytes() for path in (folder / "parts").glob("*")}


class Inline:
    """An executor that computes at once; `before` may raise, as a worker that dies; `polled` futures call nobody back."""

    def __init__(self, before=lambda part: None, polled=False):
        self.before, self.polled, self.parts = before, polled, []

    def submit(self, function, part):
        self.parts.append(part)
        future = Future()
        try:
            self.before(part)
            future.set_result(function(part))
        except Exception as error:
            future.set_exception(error)
        return _Polled(future) if self.polled else future


class _Polled:
    def __init__(self, future):
        self._future, self._looks = future, 0

    def done(self):
        self._looks += 1
        return self._looks > 1

    def result(self):
        return self._future.result()


class Backwards:
    """An executor that hands its first sixteen tasks back in the opposite order."""

    def __init__(self):
        self.waiting = []

    def submit(self, function, part):
        future = Future()
        self.waiting.append((future, function, part))
        if len(self.waiting) == 6:
            for own, call, argument in reversed(self.waiting):
                own.set_result(call(argument))
        return future


@pytest.fixture(scope="module")
def whole():
    return rsc.sweep(SCENE, VARY, BOTH, threads=1)


def test_a_sweep_tells_what_each_case_tells_alone(whole):
    assert dict(whole.sizes) == {"contact.friction": 6, "drive.speed": 3, "whirl": whole.sizes["whirl"]}
    for friction in whole["contact.friction"].values:
        for speed in whole["drive.speed"].values:
            case = whole.sel({"contact.friction": friction, "drive.speed": speed})
            scene = SCENE.with_values({"contact.friction": friction, "drive.speed": speed})
            whirls = rsc.predict(scene)
            assert np.array_equal(case.frequency.values[: len(whirls)], [whirl.frequency for whirl in whirls])
            assert np.isnan(case.frequency.values[len(whirls) :]).all()
            assert np.array_equal(case.stable.values[: len(whirls)], [whirl.stable for whirl in whirls])
            assert np.allclose(case.growth_rate.values[: len(whirls)], [whirl.growth_rate for whirl in whirls], rtol=1e-12)
            result = rsc.simulate(scene)
            assert (case.status, case.steps) == (result.status, result.steps)
            assert case.largest_force == result.stretches().whole().force_max
            assert case.largest_amplitude == result.stretches().whole().rotor_max
    assert whole.rotor_amplitude.attrs["units"] == "m" and whole["drive.speed"].attrs["units"] == "Hz"


@pytest.mark.parametrize("engine", ["2 threads", "inline", "polled", "backwards", "thread pool"])
def test_the_same_bits_whoever_computes(engine, whole):
    if engine == "2 threads":
        assert same(rsc.sweep(SCENE, VARY, BOTH, threads=2), whole)
    elif engine == "thread pool":
        with ThreadPoolExecutor(3) as pool:
            assert same(rsc.sweep(SCENE, VARY, BOTH, executor=pool), whole)
    else:
        executor = {"inline": Inline(), "polled": Inline(polled=True), "backwards": Backwards()}[engine]
        assert same(rsc.sweep(SCENE, VARY, BOTH, executor=executor), whole)


def test_how_dangerous_whirls_are():
    data = rsc.sweep(SCENE, {"contact.friction": [0.05, 0.1, 0.3]}, "predict", threads=1)
    assert data.danger.values.tolist() == [0, 1, 1]
    assert np.isnan(data.whirl_frequency.values[0]) and data.whirl_growth_rate.values[1] < 0.0 < data.whirl_growth_rate.values[2]
    at_rest = SCENE.with_values({"start.rest": True})
    for start, danger, motion in ((at_rest, 1, "no contact"), (SCENE, 3, "backward whirl, sliding")):
        one = rsc.sweep(start, {"contact.friction": [0.1]}, BOTH, threads=1)
        assert (one.danger.item(), one.motion.item()) == (danger, motion)


def test_the_size_of_a_part_changes_no_bit(whole, monkeypatch):
    monkeypatch.setattr(plan, "_part_size", lambda count, bytes_each: 5)
    assert same(rsc.sweep(SCENE, VARY, BOTH, threads=1), whole)


def test_impossible_and_failing_cases_keep_their_rows(monkeypatch):
    started = SCENE.with_values({"start.whirl": "backward"})
    vary = {"contact.friction": [0.001, 0.1], "output.rate": [2000.0, 10.0]}
    predict_many = compute.predict_many

    def breaks(scenes, speeds):
        if any(scene.contact.friction == 0.1 and scene.output.rate == 2000.0 for scene in scenes):
            raise np.linalg.LinAlgError("no convergence")
        return predict_many(scenes, speeds)

    monkeypatch.setattr(compute, "predict_many", breaks)
    data = rsc.sweep(started, vary, "predict", threads=1)
    assert data.status.values.tolist() == [["finished", "impossible"], ["failed", "impossible"]]
    assert data.reason.values[1, 0] == "LinAlgError: no convergence" and data.reason.values[0, 1].startswith("output.rate = 10.0")
    ends = rsc.sweep(started, {"contact.friction": [0.001, 0.1, 0.15]}, "run", threads=1)
    assert ends.status.values.tolist() == ["impossible", "finished", "finished"]
    assert ends.reason.values[0].startswith("start.whirl = 'backward'") and ends.motion.values[0] == ""


def test_a_store_broken_off_anywhere_ends_up_the_same(tmp_path, monkeypatch):
    undisturbed = rsc.sweep(SCENE, VARY, BOTH, path=tmp_path / "whole", threads=1)
    write, count = SweepStore.write, [0]

    def breaks(self, name, rows, origin):
        count[0] -= 1
        if count[0] < 0:
            raise KeyboardInterrupt
        write(self, name, rows, origin)

    monkeypatch.setattr(SweepStore, "write", breaks)
    for kept in (0, 1, 2):
        count[0] = kept
        with pytest.raises(KeyboardInterrupt):
            rsc.sweep(SCENE, VARY, BOTH, path=tmp_path / "broken", resume=kept > 0, threads=2)
        assert len(files(tmp_path / "broken")) == (0, 1, 3)[kept]
        if kept:
            assert (collected(SweepStore(tmp_path / "broken"))["status"] == "missing").any()
        else:
            with pytest.raises(rsc.DataError, match="holds no part of its plan yet"):
                collected(SweepStore(tmp_path / "broken"))
    monkeypatch.undo()
    assert same(rsc.sweep(SCENE, VARY, BOTH, path=tmp_path / "broken", resume=True, threads=2), undisturbed)
    assert files(tmp_path / "broken") == files(tmp_path / "whole")
    executor = Inline()
    assert same(rsc.sweep(SCENE, VARY, BOTH, path=tmp_path / "broken", resume=True, executor=executor), undisturbed)
    assert not executor.parts  # all is there


def test_another_kind_is_added_to_what_is_there_and_another_grid_is_computed(tmp_path):
    base, executor = SCENE.with_values({"drive.speed": 50.0}), Inline()
    first, second = {"contact.friction": "0.1:0.3:3"}, {"contact.friction": "0.1:0.3:5", "drive.speed": [50.0, 60.0]}
    rsc.sweep(base, first, path=tmp_path / "store", threads=1)
    both = rsc.sweep(base, first, BOTH, path=tmp_path / "store", resume=True, executor=executor)
    assert {part.kind for part in executor.parts} == {"run"}
    assert same(both, rsc.sweep(base, first, BOTH, threads=1))
    finer = rsc.sweep(base, second, BOTH, path=tmp_path / "store", resume=True, threads=1)
    assert same(finer, rsc.sweep(base, second, BOTH, threads=1))


def test_a_damaged_part_is_noticed_and_computed_again(tmp_path):
    undisturbed = rsc.sweep(SCENE, VARY, path=tmp_path / "store", threads=1)
    part = sorted((tmp_path / "store" / "parts").iterdir())[1]
    content = bytearray(part.read_bytes())
    content[len(content) // 2] ^= 1
    part.write_bytes(content)
    store, notes = SweepStore(tmp_path / "store"), []
    with pytest.raises(rsc.DataError, match="is damaged"):
        collected(store)
    mended = computed(store.plan(), store, True, threads=1, note=notes.append)
    assert same(mended.to_xarray(), undisturbed) and any("is damaged" in text and "computed again" in text for text in notes)


def test_a_store_of_something_else_is_refused_and_left_alone(tmp_path, monkeypatch):
    folder = tmp_path / "store"
    rsc.sweep(SCENE, VARY, path=folder, threads=1)
    before = files(folder)
    with pytest.raises(rsc.DataError, match="holds a sweep already: --resume"):
        rsc.sweep(SCENE, VARY, path=folder)
    with pytest.raises(rsc.SceneError, match=r"laval.toml.*: contact.gap = 0.002: must be 0.001, as in the run to be resumed"):
        rsc.sweep(SCENE.with_values({"contact.gap": 2e-3}), VARY, path=folder, resume=True)
    message = "made with .*; this is another rsc: must be the same"
    with monkeypatch.context() as patch, pytest.raises(rsc.SolverError, match=message):
        patch.setattr(plan, "own_versions", lambda: "another rsc")
        rsc.sweep(SCENE, VARY, path=folder, resume=True)
    with pytest.raises(rsc.DataError, match="holds no sweep to resume"):
        rsc.sweep(SCENE, VARY, path=tmp_path / "none", resume=True)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.tex").write_text("")
    for path in (tmp_path / "other", tmp_path / "other" / "thesis.tex"):
        with pytest.raises(rsc.DataError, match="must be a new or an empty folder"):
            rsc.sweep(SCENE, VARY, path=path)
    with SweepStore(folder).locked(), pytest.raises(rsc.DataError, match=f"another sweep .process {os.getpid()} on"):
        rsc.sweep(SCENE, VARY, path=folder, resume=True)
    assert files(folder) == before and sorted(os.listdir(tmp_path)) == ["other", "store"]
    assert os.listdir(tmp_path / "other") == ["thesis.tex"]


def test_parts_are_not_believed_by_their_names(tmp_path, whole):
    """Swapped; of other versions; of other scenes with the origin of this one: all are computed again, and none is collected."""
    rsc.sweep(SCENE, VARY, path=tmp_path / "whole", threads=1)
    expected, store = files(tmp_path / "whole"), SweepStore(tmp_path / "store")
    made = plan.make_plan(SCENE, rsc.cases(SCENE, VARY), "predict")
    one, other = (plan.part_of(made, ("predict", i)) for i in (0, 1))
    rows = [plan.read_rows(SweepStore(tmp_path / "whole"), part, i) for i, part in enumerate((one, other))]
    foreign = {name: values.copy() for name, values in rows[0].items()}
    foreign["scene_hash"][0] = b"0" * 64
    for kept in (
        (rows[1], plan.origin_of(other)), (rows[0], plan.origin_of(one) | {"versions": "rsc 0"}), (foreign, plan.origin_of(one)),
        (rows[0], plan.origin_of(one) | {"kind": "run"}),
    ):  # fmt: skip
        shutil.rmtree(store.folder, ignore_errors=True)
        shutil.copytree(tmp_path / "whole", store.folder)
        store.write(plan.name_of(one, 0), *kept)
        with pytest.raises(rsc.DataError, match=r"other cases, or by other versions|of another scene"):
            collected(store)
        notes = []
        computed(made, store, True, threads=1, note=notes.append)
        assert files(store.folder) == expected and sum("computed again" in text for text in notes) == 1


def test_a_case_that_kills_its_worker_is_named_and_costs_no_other(whole, tmp_path):
    def dies(part):
        if any(friction == 0.2 for friction, _ in part.values):
            raise RuntimeError("killed by signal 9")

    executor = Inline(dies)
    data = rsc.sweep(SCENE, VARY, "predict", path=tmp_path / "store", executor=executor)
    lost = data.status.values == "lost"
    assert np.array_equal(lost, np.broadcast_to(data["contact.friction"].values[:, None] == 0.2, lost.shape))
    assert data.reason.values[lost][0] == "its worker died (RuntimeError: killed by signal 9)"
    assert np.array_equal(data.frequency.values[~lost], whole.frequency.values[~lost], equal_nan=True)
    tries = [sum((friction, 50.0) in part.values for part in executor.parts) for friction in (0.2, 0.1)]
    assert tries[0] == 2 and tries[1] <= 2
    assert same(rsc.sweep(SCENE, VARY, "predict", path=tmp_path / "store", resume=True, threads=1), data)  # it is not tried again


def test_a_worker_that_cannot_compute_is_refused(tmp_path):
    def another(part):
        raise rsc.SolverError("a worker has another rsc")

    def without(part):
        raise ModuleNotFoundError("No module named 'rsc'")

    for before, message in ((another, "a worker has another"), (without, "a worker cannot compute .*No module named 'rsc'")):
        with pytest.raises(rsc.SolverError, match=message):
            rsc.sweep(SCENE, VARY, path=tmp_path / before.__name__, executor=Inline(before))
    part = plan.part_of(plan.make_plan(SCENE, rsc.cases(SCENE, VARY), "predict"), ("predict", 0))
    with pytest.raises(rsc.SolverError, match=r"a worker has .*, the sweep numba of old"):
        compute_part(replace(part, versions="numba of old"))


def test_an_executor_that_breaks_leaves_the_rest_to_be_resumed(whole, tmp_path):
    class Breaks(Inline):
        def submit(self, function, part):
            if len(self.parts) >= 2:
                raise RuntimeError("cannot schedule new futures after shutdown")
            return super().submit(function, part)

    data = rsc.sweep(SCENE, VARY, BOTH, path=tmp_path / "store", executor=Breaks())
    assert (data.status.values == "missing").any() and "the executor takes no work" in data.reason.values[-1, -1]
    assert len(files(tmp_path / "store")) == 2
    assert same(rsc.sweep(SCENE, VARY, BOTH, path=tmp_path / "store", resume=True, threads=1), whole)


def _suicide(part):
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_process_pool_whose_worker_dies_is_told(tmp_path):
    class Pool:
        def __init__(self, pool):
            self.pool, self.count = pool, 0

        def submit(self, function, part):
            self.count += 1
            return self.pool.submit(_suicide if self.count == 3 else function, part)

    with ProcessPoolExecutor(1) as pool:
        data = rsc.sweep(SCENE, VARY, path=tmp_path / "store", executor=Pool(pool))
    assert set(np.unique(data.status)) <= {"finished", "lost", "missing"} and (data.status != "finished").any()
    resumed = rsc.sweep(SCENE, VARY, path=tmp_path / "store", resume=True, threads=1)
    assert not (resumed.status == "missing").any()


@pytest.mark.parametrize(("arguments", "message"), [({"threads": 0}, "threads = 0"), ({"threads": 1.5}, "threads = 1.5")])
def test_arguments_that_cannot_be_meant(arguments, message):
    with pytest.raises(rsc.RscError, match=message):
        rsc.sweep(SCENE, VARY, **arguments)
    with pytest.raises(rsc.SolverError, match=r"compute = 'prdict': must be one or more of .*did you mean"):
        rsc.sweep(SCENE, VARY, "prdict")


def test_results_that_would_not_fit_are_refused_before_anything_begins(tmp_path, monkeypatch):
    from rsc.study.sweep import dataset as module

    monkeypatch.setattr(module, "free_memory", lambda: 1e4)
    with pytest.raises(rsc.SolverError, match=r"18 cases need .* and .* are free"):
        rsc.sweep(SCENE, VARY, path=tmp_path / "store")
    assert not os.listdir(tmp_path)


def test_parts_of_long_runs_are_small():
    long = SCENE.with_values({"drive.duration": 100.0, "output.rate": 1e4})
    sizes = plan.make_plan(long, rsc.cases(long, {"contact.friction": "0.1:0.2:900"}), BOTH).part_sizes
    assert sizes[0] == 120 and sizes[1] * plan.bytes_of_a_run(long, rsc.cases(long, {"contact.friction": "0.1,0.2"})) <= 256e6


def test_least_friction_jump_and_verdict():
    steady = SCENE.with_values({"drive.speed": 50.0, "drive.duration": 0.5})
    data = rsc.sweep(steady, {"contact.friction": [0.1, 0.2]}, "mu_min,check")
    assert np.ptp(data.mu_min.values) == 0.0 and 0.03 < data.mu_min.values[0] < 0.1
    assert (data.windows > 0).all() and (data.n_agrees + data.n_not_yet_steady + data.n_no_whirl > 0).all()
    run_up = SCENE.with_values({"drive.speed": [50.0, 60.0], "start.whirl": -60.0})
    jump = rsc.sweep(run_up, {"contact.friction": [0.2], "drive.duration": [10.0, 20.0]}, "jump")
    assert np.isfinite(jump.jump_from).all()
    still = rsc.sweep(SCENE.with_values({"drive.speed": 50.0}), {"contact.friction": [0.2]}, "jump")
    assert still.status.item() == "impossible"


def test_engines_close(monkeypatch):
    with pytest.raises(ZeroDivisionError), engines.own_threads(1) as pool:
        raise ZeroDivisionError
    with pytest.raises(RuntimeError):
        pool.submit(print)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(rsc.SolverError, match=r"rotor-stator-contact\[cluster\]"), engines.dask_client("tcp://x:1"):
        pass
