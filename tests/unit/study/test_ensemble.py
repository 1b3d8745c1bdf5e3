"""Many runs at once: the same bits as alone, refusals, and a case that fails among others that do not."""

import numpy as np
import pytest

import rsc
from rsc.results import budget
from rsc.scene.scene import Scene
from rsc.study.run import ensemble
from scenes import LAVAL, SCENES, changed
from systems import REFERENCE

SERIES = ("time", "speed", "rotor", "stator", "normal_force", "friction_force", "tangential_velocity")
ONE_AND_ONE = [name for name in SCENES if name not in ("rigid wall", "gyroscopic disk", "chains")]


def varied():
    """Forty scenes of one shape: whirling and bouncing, with and without ring, damper and reversal, of different lengths."""
    draw = np.random.default_rng(4)
    scenes = [Scene.from_dict(SCENES[name]) for name in ONE_AND_ONE]
    for i in range(40 - len(scenes)):
        base = SCENES["bouncing" if i % 2 else "whirl, unbalance, run-up"]
        factor = dict(zip("mfgk", draw.uniform(0.8, 1.25, 4), strict=True))
        values = {
            "rotor.mass": factor["m"],
            "contact.friction": 0.15 * factor["f"],
            "contact.gap": 1e-3 * factor["g"],
            "contact.stiffness": 3.5e6 * factor["k"],
            "drive.duration": (0.05, 0.2, 0.4)[i % 3],
            "solver.rtol": (1e-4, 1e-6, 1e-8)[i % 3],
            "output.rate": (2000, 3000)[i % 2],
        }
        scenes.append(Scene.from_dict({**base, "start": {**base["start"], "allow_penetration": True}}).with_values(values))
    return scenes


def assert_same(result, alone):
    for name in SERIES:
        # the bytes: NaN and the sign of zero count
        assert getattr(result, name).tobytes() == getattr(alone, name).tobytes(), name
    assert repr(result.summary) == repr(alone.summary)  # every digit, and NaN equals NaN


@pytest.fixture(scope="module")
def alone():
    return [rsc.simulate(scene) for scene in varied()]


@pytest.mark.parametrize("threads", [1, 2, 4, None])
def test_every_case_has_the_bits_it_has_alone(alone, threads):
    assert sum(result.summary.switches > 10 for result in alone) > 10
    assert sum(result.contact_onsets > 3 for result in alone) > 10
    results = rsc.simulate_many(varied(), threads=threads)
    assert len(results) == len(alone)
    for result, one in zip(results, alone, strict=True):
        assert_same(result, one)


def test_contacts_inside_long_steps_are_the_same():
    """Bouncing at a coarse tolerance: contacts that begin and end inside one step."""
    values = {"drive.duration": 3.0, "drive.speed": [30.0, 51.0], "solver.rtol": 1e-3}
    base = rsc.load_scene(REFERENCE / "bouncing.toml").with_values(values)
    scenes = [base.with_values({"contact.gap": gap}) for gap in np.linspace(0.7e-3, 1.1e-3, 16)]
    for result, scene in zip(rsc.simulate_many(scenes, threads=1), scenes, strict=True):
        assert_same(result, rsc.simulate(scene))


def test_both_methods_go_together():
    methods = ("rk45", "taylor8")
    scenes = [scene.with_values({"solver.method": methods[i % 2]}) for i, scene in enumerate(varied())]
    for result, scene in zip(rsc.simulate_many(scenes, threads=2), scenes, strict=True):
        assert_same(result, rsc.simulate(scene))


def test_the_series_has_the_bits_it_has_alone():
    scenes = [scene.with_values({"solver.method": "taylor8"}) for scene in varied()]
    for result, scene in zip(rsc.simulate_many(scenes, threads=1), scenes, strict=True):
        assert_same(result, rsc.simulate(scene))


@pytest.mark.parametrize("method", ["rk45", "taylor8"])
def test_stiff_cases_and_lost_sliding_are_told_as_alone(method):
    """Stiff runs that finish and that cannot, and one-sided friction that no diameter gives."""
    solver, whirl = {"method": method, "rtol": 1e-6}, {"whirl": -60.0}
    damper = {"damping_ratio": None, "damping": 1e5}
    cases = {
        "finished": changed(start=whirl, solver=solver, contact={"stiffness": 3.5e10}),
        "stiff": changed(start=whirl, solver={**solver, "max_steps": 1_000_000}, contact=damper, drive={"duration": 1000.0}),
        "out of assumptions": changed(SCENES["bouncing"], drive={"speed": 0.0}, solver=solver),
    }
    wanted = [*cases] * 6
    scenes = [Scene.from_dict(cases[name]) for name in wanted]
    results = rsc.simulate_many(scenes, threads=1)
    assert [result.status for result in results] == wanted
    assert ["limits the step" in result.summary.advice for result in results] == [True, True, False] * 6
    for result, scene in zip(results, scenes, strict=True):
        assert_same(result, rsc.simulate(scene))


@pytest.mark.parametrize(
    ("start", "method"), [("rest", "rk45"), ("moving", "rk45"), ("moving", "taylor8")]
)
def test_modes_and_matrices_go_together(start, method):
    """Two rotor coordinates at a rigid wall: modes, disks with gyroscopics and rotors with a discrete damper."""
    wall = {"stator": {"model": "rigid"}, "contact": {"friction": 0.05}, "solver": {"method": method}}
    disk = changed(SCENES["gyroscopic disk"], **wall)
    chain = {"model": "chain", "masses": [1.0, 2.0], "stiffnesses": [3e4, 2e4, 4e4], "damping_ratio": 0.02, "eccentricity": 4e-4}
    chain = changed(rotor=chain, start=disk["start"], **wall)
    damped = {
        "model": "matrices",
        "mass": [[1.0, 0.0], [0.0, 2.0]],
        "stiffness": [[5e4, -2e4], [-2e4, 6e4]],
        "damping": [[20.0, 0.0], [0.0, 3.0]],
        "eccentricity": [4e-4, 4e-4],
    }
    scenes = [disk, chain, changed(chain, rotor=damped)] if method == "rk45" else 3 * [disk]  # each kind is compiled
    scenes = [{**scene, "start": {"rest": True} if start == "rest" else scene["start"]} for scene in scenes]
    gaps = np.linspace(0.8e-3, 1e-3, 27)
    scenes = [Scene.from_dict(changed(scenes[i % 3], contact={"gap": gap})) for i, gap in enumerate(gaps)]
    for result, scene in zip(rsc.simulate_many(scenes, threads=1), scenes, strict=True):
        assert_same(result, rsc.simulate(scene))
    assert sum(rsc.simulate(scene).summary.switches > 3 for scene in scenes) > 20 or start == "rest"


@pytest.mark.parametrize("threads", [2, 8])
def test_a_case_that_fails_leaves_the_others_alone(threads):
    diverging = changed(start={**LAVAL["start"], "rotor": [[5.0, 0.0]]}, solver={"divergence": 1000.0})
    stopped = changed(solver={"max_steps": 50})
    scenes = [Scene.from_dict(scene) for scene in (LAVAL, diverging, stopped, SCENES["bouncing"])] * 5
    results = rsc.simulate_many(scenes, threads=threads)
    assert [result.status for result in results[:4]] == ["finished", "diverged", "too many steps", "finished"]
    for result, scene in zip(results, scenes, strict=True):
        assert_same(result, rsc.simulate(scene))


@pytest.mark.parametrize("threads", [2, 16])
def test_an_impossible_scene_keeps_its_place_when_asked(threads):
    lost = Scene.from_dict(changed(start={"whirl": "backward"}, contact={"friction": 0.001}))
    other = Scene.from_dict(SCENES["rigid wall"])
    scenes = [lost, *[Scene.from_dict(LAVAL)] * 9, other, lost, *[Scene.from_dict(SCENES["bouncing"])] * 7]
    results = rsc.simulate_many(scenes, threads=threads, on_error="keep")
    assert [i for i, result in enumerate(results) if result.status == "impossible"] == [0, 10, 11]
    assert "a stable backward whirl at 50 Hz" in results[0].reason and "with 0 coordinates" in results[10].reason
    assert results[11].scene is lost and all(result.scene is scene for result, scene in zip(results, scenes, strict=True))
    for i in (1, 18):
        assert_same(results[i], rsc.simulate(scenes[i]))
    with pytest.raises(rsc.SceneError, match="with 0 coordinates"):
        rsc.simulate_many(scenes, threads=threads)
    with pytest.raises(rsc.SceneError, match="a stable backward whirl"):
        rsc.simulate_many(scenes[:10], threads=threads)
    assert [result.status for result in rsc.simulate_many([lost, lost], on_error="keep")] == ["impossible"] * 2
    with pytest.raises(rsc.SolverError, match="on_error = 'skip'"):
        rsc.simulate_many([lost], on_error="skip")


def test_what_is_no_ensemble_is_refused():
    scene = Scene.from_dict(LAVAL)
    with pytest.raises(rsc.SolverError, match="at least one scene"):
        rsc.simulate_many([])
    for threads in (0, -1, 1.5, True):
        with pytest.raises(rsc.RscError, match=f"threads = {threads!r}: must be a whole number"):
            rsc.simulate_many([scene], threads=threads)
    for name, wanted in (("rigid wall", r"stator = 'scene 2 with 0 .*\(1\)"), ("chains", r"rotor = 'scene 2 with 3 .*\(1\)")):
        with pytest.raises(rsc.SceneError, match=wanted) as refusal:
            rsc.simulate_many([scene, Scene.from_dict(SCENES[name])])
        assert "\n" not in str(refusal.value)


def test_samples_beyond_the_memory_are_refused(monkeypatch):
    scene = Scene.from_dict(LAVAL)
    monkeypatch.setattr("rsc.results.budget.free_memory", lambda: int((budget.KERNEL_BYTES + 400_000) / budget.LARGEST_SHARE))
    rsc.simulate_many([scene])
    with pytest.raises(rsc.SolverError, match=r"runs of 20 scenes need .* at a time"):
        rsc.simulate_many([scene] * 20)


@pytest.mark.parametrize(("count", "threads", "most"), [(1, 2, 1), (5, 2, 2), (30, 1, 30), (40, 2, 10), (1000, 2, 32)])
def test_every_thread_has_something_to_do(count, threads, most):
    """Every scene once and in order, and no part so large that another thread would stand idle, least of all at the end."""
    parts = ensemble.parts_of(list(range(count)), threads)
    assert [i for part in parts for i in part] == list(range(count))
    sizes = [len(part) for part in parts]
    assert len(parts) >= min(count, threads) and max(sizes) == most
    assert threads == 1 or max(sizes[-threads:]) == 1


def test_a_start_that_does_not_exist_ends_the_ensemble():
    scene = Scene.from_dict(changed(start={"whirl": "backward"}))
    scenes = [scene, scene.with_values({"contact.friction": 0.0}).with_values({"output.rate": 1000.0})]
    with pytest.raises(rsc.SceneError, match=r"^<scene> with contact\.friction = 0\.0, output\.rate = 1000\.0: start\.whirl"):
        rsc.simulate_many(scenes, threads=2)
