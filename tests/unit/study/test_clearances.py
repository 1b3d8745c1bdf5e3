"""Places that are only watched, from the scene to the page: what a run counts there, what predictions touch, what is refused."""

import json
import re

import h5py
import numpy as np
import pytest

import forge
import rsc
from fe_bodies import rotor
from rsc.analysis.follow.forward_rub import attractors
from rsc.analysis.paper.watched import free_deflections
from rsc.analysis.survey.survey import survey
from rsc.cli import main
from rsc.errors import DataError, SceneError
from rsc.machine.imports.build import rotor_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.imports.store import save_model
from rsc.measure.stretches import OF_CLEARANCE
from rsc.results.result_format import with_sums
from rsc.scene.scene import Scene
from rsc.show.words.clearances import watched
from rsc.show.words.text import survey_text
from rsc.study.prediction.reductions import reduction_remarks
from rsc.system.assemble import assemble
from scenes import LAVAL, SCENES, changed
from tiers import nightly

TWO_PI = 2.0 * np.pi
GROUND = {"name": "seal", "rotor_coordinate": 0, "gap": 0.45e-3}
WALL = {"name": "ring", "rotor_coordinate": 2, "stator_coordinate": 0, "gap": 5e-3}
BOTH = [GROUND, WALL]


def scene(name="chains", clearances=BOTH, **tables):
    return Scene.from_dict({**changed(SCENES[name], **tables), "clearance": clearances})


MACHINE = """
[rotor]
model = "machine"
file = "rotor.npz"
contact = 6
unbalance = [[6, "50 g*mm", 90.0]]
[stator]
model = "laval"
mass = 2.0
frequency = 60.0
damping_ratio = 0.05
[contact]
gap = 1e-3
friction = 0.2
stiffness = 2e7
damping_ratio = 0.05
[drive]
speed = 30.0
duration = 0.2
[[clearance]]
name = "seal"
rotor_node = 3
gap = 1e-4
"""


def laval(gap, speed=40.0, **tables):
    """A Laval rotor that whirls, with a clearance at its disk against the ground."""
    drive = {"speed": speed, "duration": 2.0}
    content = changed(LAVAL, drive=drive, **{"start": {"whirl": "backward"}, **tables})
    return Scene.from_dict({**content, "clearance": [{"name": "seal", "rotor_coordinate": 0, "gap": gap}]})


def at_places(own, result):
    """(n, 2) deflections of the samples at the clearances of `scene`."""
    return np.stack([result.rotor[:, 0], result.rotor[:, 2] - result.stator[:, 0]], axis=1)


CHAINS = ("chains", "chains at rest")


@pytest.mark.parametrize(("name", "method"), [(name, "taylor8") for name in CHAINS] + [nightly(name, "rk45") for name in CHAINS])
def test_a_run_keeps_what_its_samples_show(name, method):
    tables = {"start": {"rest": True}, "rotor": {"gravity": 9.81}} if name.endswith("rest") else {}
    own = scene(solver={"method": method, "rtol": 1e-8}, output={"rate": 200_000.0}, **tables)
    result = rsc.simulate(own)
    paths, rows, whole = at_places(own, result), watched(own, result.stretches()), result.stretches().whole()
    for i, (place, row, values) in enumerate(zip(own.clearances, rows, abs(paths.T), strict=True)):
        assert row["peak_to_peak"] == pytest.approx(max(np.ptp(paths[:, i].real), np.ptp(paths[:, i].imag)), rel=2e-4)
        extents = paths[:, i].real.min(), paths[:, i].real.max(), paths[:, i].imag.min(), paths[:, i].imag.max()
        assert whole.clearance_extents[i] == pytest.approx(extents, rel=2e-4, abs=2e-4 * values.max())
        assert row["largest"] == pytest.approx(values.max(), rel=2e-4)
        assert row["over_gap"] == row["largest"] / place.gap
        over = np.flatnonzero(values > place.gap)
        assert (row["passed"] is None) == (over.size == 0)
        if over.size:
            assert row["passed"] == pytest.approx(result.time[over[0]], abs=2e-5)
    if not tables:
        assert [row["passed"] is None for row in rows] == [False, True]  # so that both cases are seen


@pytest.mark.parametrize("name", ["chains", "bouncing", nightly("rigid wall")])
def test_no_bit_of_a_run_changes(name):
    alone = rsc.simulate(Scene.from_dict(SCENES[name]))
    result = rsc.simulate(scene(name, [GROUND]))
    for key in ("rotor", "stator", "normal_force"):
        assert getattr(alone, key).tobytes() == getattr(result, key).tobytes()
    columns = alone.stretches().rows.shape[1]
    assert alone.stretches().rows.tobytes() == np.ascontiguousarray(result.stretches().rows[:, :columns]).tobytes()


def test_it_survives_the_file_and_a_resumed_run(tmp_path, monkeypatch):
    own = scene(drive={"duration": 0.4}, output={"rate": 1000.0})
    whole = rsc.simulate(own, path=tmp_path / "whole.h5")
    again = rsc.load(tmp_path / "whole.h5")
    assert again.scene == own and again.stretches().rows.tobytes() == whole.stretches().rows.tobytes()
    assert whole.stretches().passed[-1, 0] < 0.4 < whole.stretches().passed[-1, 1]
    monkeypatch.setattr("rsc.simulation.run.CHUNK_STEPS", 300)
    blocks = iter(range(10))

    def stop(_):
        if next(blocks) > 1:
            raise KeyboardInterrupt

    with monkeypatch.context() as changes, pytest.raises(KeyboardInterrupt):
        changes.setattr("rsc.study.run.simulate._Pace.remark", stop)
        rsc.simulate(own, path=tmp_path / "part.h5")
    resumed = rsc.simulate(own, path=tmp_path / "part.h5", resume=True)
    assert resumed.stretches().rows.tobytes() == whole.stretches().rows.tobytes()


@pytest.mark.parametrize("column", [0, 1])
def test_a_forged_clearance_is_refused(tmp_path, column):
    own = scene(drive={"duration": 0.1})
    rsc.simulate(own, path=tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "r+", libver="latest") as file:
        facts = file["stretches/facts"]
        values = facts[()][:, :-1]  # without the sum of the row
        values[:, values.shape[1] - 2 * len(OF_CLEARANCE) + column] = -1.0
        facts[...] = with_sums(values)
        forge.sum_up(file)
    with pytest.raises(DataError, match="passage"):
        rsc.load(tmp_path / "run.h5").stretches()


def test_another_number_of_clearances_is_refused(tmp_path):
    rsc.simulate(scene(drive={"duration": 0.1}), path=tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "r+", libver="latest") as file:
        text = file.attrs["scene"]
        text = text.decode() if isinstance(text, bytes) else text
        file.attrs["scene"] = np.bytes_(text[: text.rindex("[[clearance]]")].encode())
        forge.sum_up(file)
    with pytest.raises(DataError, match="clearances"):
        rsc.load(tmp_path / "run.h5").stretches()


def test_a_scene_round_trips_and_its_gap_is_a_value():
    own = scene()
    assert [place.name for place in own.clearances] == ["seal", "ring"]
    assert Scene.from_dict(own.to_dict()) == own == Scene.from_toml(own.to_toml())
    assert own.mirrored().clearances == own.clearances
    assert own.with_values({"clearance.ring.gap": 2e-3}).clearances[1].gap == 2e-3
    assert "[[clearance]]" not in Scene.from_dict(LAVAL).to_toml()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"name": "two words"}, "clearance[0].name"),
        ({"gap": 0.0}, "clearance.seal.gap"),
        ({"rotor_coordinate": 3}, "from 0 to 2"),
        ({"rotor_coordinate": None}, "rotor_coordinate"),
        ({"rotor_node": "7"}, "rotor_coordinate"),
        ({"rotor_node": "7", "rotor_coordinate": None}, "finite-element"),
        ({"stator_coordinate": 2}, "from 0 to 1"),
        ({"name": "ring"}, "a unique name"),
        ({"gapp": 1.0}, "gap"),
    ],
)
def test_a_wrong_table_is_one_line(change, told):
    table = {key: value for key, value in (GROUND | change).items() if value is not None}
    with pytest.raises(SceneError) as refusal:
        scene(clearances=[table, WALL])
    assert told in str(refusal.value) and str(refusal.value).count("\n") == 0


@pytest.mark.parametrize("content", [7, [7], [GROUND] * 17, "seal"])
def test_what_is_no_list_of_tables_is_one_line(content):
    with pytest.raises(SceneError, match="clearance"):
        scene(clearances=content)


def test_a_tilt_and_a_stator_that_does_not_move_are_refused():
    with pytest.raises(SceneError, match="tilt"):
        scene("gyroscopic disk", [{"name": "seal", "rotor_coordinate": 1, "gap": 1e-3}])
    with pytest.raises(SceneError, match="has no coordinates"):
        scene("rigid wall", [GROUND | {"stator_coordinate": 0}])


def test_a_whirl_touches_the_places_that_its_shape_reaches():
    free = Scene.from_dict(changed(LAVAL, rotor={"eccentricity": 0.0}, drive={"speed": 40.0}))
    whirl = max(rsc.predict(free, 40.0), key=lambda own: own.stable * own.rotor_amplitude)
    assert whirl.stable and whirl.touches == () and whirl.clearances == {}
    for share, touches in ((1.01, ()), (0.99, ("seal",))):
        own = laval(share * whirl.rotor_amplitude, rotor={"eccentricity": 0.0})
        same = next(one for one in rsc.predict(own, 40.0) if one.frequency == whirl.frequency)
        assert same.clearances["seal"] == pytest.approx(1.0 / share, rel=1e-12)
        assert same.touches == touches and same.stable is (not touches) and same.decays
        assert ("within_clearances" in same.violated) is bool(touches)


def test_with_its_unbalance_a_whirl_reaches_as_far_as_its_run():
    own = laval(2e-3)
    whirl = max(rsc.predict(own, 40.0), key=lambda one: one.decays * one.rotor_amplitude)
    settled = rsc.simulate(own).stretches().between(1.5, 2.0).clearances[0] / 2e-3
    without = whirl.rotor_amplitude / 2e-3
    # what the unbalance adds, to first order in it
    assert settled - without == pytest.approx(whirl.clearances["seal"] - without, rel=0.02)
    assert settled - without > 0.01


def test_many_whirls_are_those_of_one():
    scenes = [scene(drive={"speed": 30.0}), scene(drive={"speed": 30.0}, contact={"friction": 0.3})]
    arrays = rsc.predict_many(scenes, [30.0, 45.0])
    for i, own in enumerate(scenes):
        for k, speed in enumerate((30.0, 45.0)):
            whirls = rsc.predict(own, speed)
            n = len(whirls)
            shares = [max(one.clearances.values()) for one in whirls]
            assert arrays.clearance_share[i, k, :n] == pytest.approx(shares, rel=1e-9)
            numbers = [list(one.clearances).index(max(one.clearances, key=one.clearances.get)) for one in whirls]
            assert arrays.clearance[i, k, :n].tolist() == numbers
            assert arrays.stable[i, k, :n].tolist() == [one.stable for one in whirls]
            assert arrays.conditions["within_clearances"][i, k, :n].tolist() == [not one.touches for one in whirls]
    with pytest.raises(SceneError, match="clearances of the first"):
        rsc.predict_many([scenes[0], scene(clearances=[WALL])], [30.0])


def test_rub_and_free_motion_are_checked_as_well():
    tables = {"contact": {"friction": 0.05}, "start": {"rest": True}, "rotor": {"eccentricity": 4e-4}}
    for speed, kind in ((20.0, "no contact"), (32.0, "forward rub")):
        wide, narrow = (
            [one for one in attractors(assemble(laval(gap, speed, **tables)), speed) if one.kind == kind] for gap in (1.0, 1e-5)
        )
        assert wide and len(wide) == len(narrow)
        for one, other in zip(wide, narrow, strict=True):
            assert one.touches == () and other.touches == ("seal",) and not other.stable
            assert one.amplitude == other.amplitude
        assert any(one.stable for one in wide)
        gap = 0.999 * wide[0].amplitude
        assert attractors(assemble(laval(gap, speed, **tables)), speed)[0].touches == ("seal",)
        assert attractors(assemble(laval(1.002 * gap, speed, **tables)), speed)[0].touches == ()


def test_the_free_motion_stands_on_its_weight():
    light, heavy = (assemble(laval(1e-3, rotor={"gravity": gravity})) for gravity in (0.0, 9.81))
    sag = free_deflections(heavy, TWO_PI * 40.0) - free_deflections(light, TWO_PI * 40.0)
    assert sag[0] == pytest.approx(9.81 / (TWO_PI * 30.0) ** 2, rel=1e-12)


def test_a_rub_line_says_where_it_touches():
    tables = {"contact": {"friction": 0.05}, "start": {"rest": True}, "rotor": {"eccentricity": 4e-4}}
    content = laval(1.05e-3, [25.0, 40.0], **tables)
    found = survey(content)
    rub = next(one for one in found.rubs if one.touches.any() and one.stable.any())
    place = next(event for event in rub.events if event.cause == "within the clearances")
    assert min(abs(rub.speed[rub.touches] - place.speed)) < 0.01
    text = survey_text(found)
    assert "touches a clearance" in text


def test_branches_end_their_stability_where_they_touch():
    free = laval(1.0, [20.0, 45.0])
    branch = max(survey(free).branches, key=lambda one: one.stable.sum())
    reached = sorted(whirl.clearances["seal"] for whirl in branch.whirls)
    found = survey(laval(0.5 * (reached[100] + reached[101]), [20.0, 45.0]))
    branch = max(found.branches, key=lambda one: one.decays.sum())
    assert branch.decays.sum() > branch.stable.sum() > 0
    assert "within the clearances" in {event.cause for event in branch.events}
    assert "touches seal from" in survey_text(found)


def test_a_node_of_a_machine_becomes_an_observer_of_the_reduced_rotor(tmp_path):
    matrices, nodes, directions = rotor(n_elements=12)
    table = Coordinates(nodes, directions, {}, {i: i / 12 for i in range(13)})
    model = rotor_model(matrices, table, "a shaft", units="m")
    save_model(model, tmp_path / "rotor.npz")
    (tmp_path / "scene.toml").write_text(MACHINE)
    own = rsc.load_scene(tmp_path / "scene.toml")
    assert own.rotor.observers == ("3",) and own.rotor.observer_errors[0] < 1e-2
    assert Scene.from_toml(own.to_toml()) == own
    place, system = assemble(own).clearances[0], assemble(own)
    full = model.stiffness - (TWO_PI * 30.0) ** 2 * (model.mass - model.gyroscopic) + 1j * TWO_PI * 30.0 * model.damping
    forced = model.row_at(3) @ np.linalg.solve(full, 50e-6 * 1j * model.row_at(6)) * (TWO_PI * 30.0) ** 2
    free = next(one for one in attractors(system, 30.0) if one.kind == "no contact")
    assert free_deflections(system, TWO_PI * 30.0)[0] == pytest.approx(abs(forced), rel=1e-3)
    assert free.touches == (("seal",) if abs(forced) > place.gap else ())
    assert any("clearance seal: its node 3 of the reduced rotor" in text for text in reduction_remarks(own))


def test_run_info_predict_and_check_tell_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.toml").write_text(laval(1.2e-3).to_toml())
    assert main(["run", "own.toml", "-o", "own.h5"]) == 0
    told = r"clearances: seal touched at 0 s, deflection up to 2\d\d % of the clearance, \d+ um pk-pk"
    assert re.search(told, capsys.readouterr().out)
    assert main(["info", "own.h5", "--json"]) == 0
    row = json.loads(capsys.readouterr().out)["clearances"][0]
    assert row["name"] == "seal" and row["passed"] == 0.0 and row["over_gap"] > 1.0
    assert main(["predict", "own.toml", "--speed", "40"]) == 0
    assert "touches seal" in capsys.readouterr().out
    assert main(["predict", "own.toml", "--speed", "40", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert "touches" in json.dumps(told)
    assert main(["check", "own.toml", "-o", "out"]) in (0, 1)
    out = capsys.readouterr().out
    assert "touches seal" in out and "clearances" in out
    assert json.loads((tmp_path / "out" / "report.json").read_text())["clearances"][0]["name"] == "seal"
    assert "touches seal" in (tmp_path / "out" / "report.html").read_text()


def test_a_sweep_keeps_the_largest_share_and_its_place():
    own = scene(drive={"speed": 30.0, "duration": 0.2})
    gaps = [5e-3, 1e-5]
    found = rsc.sweep(own, {"clearance.ring.gap": gaps}, compute=("predict", "run"))
    scenes = [own.with_values({"clearance.ring.gap": gap}) for gap in gaps]
    rows = [watched(one, rsc.simulate(one).stretches()) for one in scenes]
    assert found["run_clearance_share"].values.tolist() == [max(row["over_gap"] for row in case) for case in rows]
    assert found["run_clearance"].values.tolist() == [0, 1]
    times = [min(row["passed"] for row in case if row["passed"] is not None) for case in rows]
    assert found["passed_time"].values.tolist() == times
    n = len(rsc.predict(own, 30.0))
    assert (found["clearance"].values[1, :n] == 1).all() and (found["holds_within_clearances"].values[1, :n] == 0).all()
