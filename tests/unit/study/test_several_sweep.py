"""Sweeps of a machine with several contacts: rows of every contact, sets, a store that is resumed, maps, and what is refused."""

import numpy as np
import pytest

import rsc
from dropped import dropped
from rsc.cli import main
from rsc.results.labelled import Labelled
from rsc.results.sweep_store import SweepStore
from rsc.show.sweeps.pictures import pictures
from rsc.show.sweeps.words import extremes, set_words
from rsc.study.sweep import plan
from rsc.study.sweep.dataset import load_dataset
from rsc.study.sweep.sweep import computed
from two_seals import pump

SHORT = pump(seal={"gap": 4e-5}, **{"drive.duration": 0.2})
VARY = {"contact.seal.friction": [0.1, 0.2], "contact.bush.gap": ["0.01 mm", "0.15 mm", "0.4 mm"]}


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """The folder of a sweep from the command line, with a kind added to what was there."""
    folder = tmp_path_factory.mktemp("several")
    (folder / "pump.toml").write_text(SHORT.to_toml())
    words = ["--vary", "contact.seal.friction=0.1,0.2", "--vary", "contact.bush.gap=0.01 mm,0.15 mm,0.4 mm"]
    arguments = ["sweep", str(folder / "pump.toml"), *words, "-o", str(folder / "store")]
    assert main([*arguments, "--compute", "predict"]) == 0
    assert main([*arguments, "--compute", "predict,run", "--resume"]) == 0
    return folder / "store"


@pytest.fixture(scope="module")
def swept(store):
    return load_dataset(store / "sweep.nc")


def test_every_case_tells_what_it_tells_alone(swept):
    assert (swept["status"] == "finished").all()
    for i, friction in enumerate(swept["contact.seal.friction"]):
        for k, gap in enumerate(swept["contact.bush.gap"]):
            scene = SHORT.with_values({"contact.seal.friction": float(friction), "contact.bush.gap": float(gap)})
            whirls, result = rsc.predict(scene), rsc.simulate(scene)
            for name in ("frequency", "normal_force", "rotor_amplitude", "growth_rate", "stable", "admissible"):
                assert swept[name][i, k, : len(whirls)].tolist() == [getattr(whirl, name) for whirl in whirls]
            sets = {("seal",): 1, ("bush",): 2, ("seal", "bush"): 3}
            assert swept["pressed"][i, k, : len(whirls)].tolist() == [sets[whirl.pressed] for whirl in whirls]
            assert (swept["pressed"][i, k, len(whirls) :] == -1).all()
            wholes = [result.stretches(name).whole() for name in ("seal", "bush")]
            assert swept["largest_force"][i, k] == max(whole.force_max for whole in wholes)
            touched = [whole.force_max for whole in wholes]
            assert swept["largest_contact"][i, k] == (np.argmax(touched) if any(touched) else -1)
            assert swept["largest_amplitude"][i, k] == max(whole.rotor_max for whole in wholes)
            over = wholes[0].deflection_max / 4e-5, wholes[1].deflection_max / gap
            assert swept["largest_over_gap"][i, k] == pytest.approx(max(over), rel=1e-12)


def test_both_contacts_are_among_the_largest_and_sets_differ(swept):
    """Else a row that looked at the first contact alone would pass."""
    assert set(swept["largest_contact"].ravel().tolist()) == {0, 1}
    assert len(set(swept["pressed"].ravel().tolist())) == 4


def test_a_whirl_that_lasts_is_the_predicted_one_at_both_contacts():
    started = pump(**{"drive.duration": 0.6, "start.allow_penetration": True})
    (whirl,) = [whirl for whirl in rsc.predict(started) if whirl.stable]
    turn = 2j * np.pi * whirl.frequency
    parts = {"rotor": whirl.rotor_shape, "stator": whirl.stator_shape}
    state = {f"start.{name}": [[z.real, z.imag] for z in shape.tolist()] for name, shape in parts.items()}
    state |= {f"start.{name}_velocity": [[z.real, z.imag] for z in (turn * shape).tolist()] for name, shape in parts.items()}
    data = rsc.sweep(started.with_values(state), {"contact.seal.stiffness": [1e7]}, "predict,run", threads=1)
    assert (data.touched.item(), data.whirl_pressed.item(), data.danger.item()) == (3, 3, 3)
    assert data.touched.attrs["flags"] == "1 seal; 2 bush"
    assert data.whirl_frequency.item() == whirl.frequency
    assert data.turning_frequency.item() == pytest.approx(whirl.frequency, rel=3e-4)
    assert data.motion.item() == "backward whirl, sliding"


def test_maps_and_words_name_the_contacts(swept):
    drawn = pictures(swept)
    assert {"danger", "motion", "touched", "amplitude", "force"} <= set(drawn)
    words = [text.get_text() for text in drawn["touched"].legends[0].get_texts()]
    assert words and all(word.partition(" (")[0] in ("none", "seal", "bush", "seal and bush") for word in words)
    where = {text: at for text, _, at in extremes(swept)}["largest normal force of a run"]
    assert where.endswith((", at seal", ", at bush"))
    assert "contact.bush.gap = " in where


def test_sets_that_a_stranger_wrote_are_no_words_of_contacts(swept):
    dims, values, about = swept.variables["touched"]
    forged = np.full(values.shape, -7)
    forged.flat[:3] = 1 << 40, 0, 3
    data = Labelled(swept.dims, swept.coordinates, {"touched": (dims, forged, about)}, swept.attributes)
    classes, words = set_words(data, "touched")
    assert [words[i] for i in classes.ravel()[:3]] == ["none", "none", "seal and bush"]
    assert (classes.ravel()[3:] == -1).all()


def test_a_store_of_another_scene_and_a_part_with_too_many_whirls_are_refused(store):
    with pytest.raises(rsc.SceneError, match=r"contact\.bush\.friction = 0\.3: must be 0\.2, as in the run to be resumed"):
        rsc.sweep(SHORT.with_values({"contact.bush.friction": 0.3}), VARY, "predict", path=store, resume=True)
    made = SweepStore(store).plan()
    part, label = plan.part_of(made, ("predict", 0)), ("predict", 0)
    rows = plan.read_rows(SweepStore(store), part, label[1])
    assert plan.most_whirls(made.scene, made.source) == 4 * 3 * 5
    wide = {name: np.repeat(values, 40, axis=1) if values.ndim > 1 else values for name, values in rows.items()}
    path = store / "parts" / f"{plan.name_of(part, 0)}.h5"
    before = path.read_bytes()
    try:
        for forged, message in ((wide, "whirls of a case"), ({n: v for n, v in rows.items() if n != "pressed"}, "pressed")):
            SweepStore(store).write(plan.name_of(part, 0), forged, plan.origin_of(part))
            with pytest.raises(rsc.DataError, match=message):
                plan.read_rows(SweepStore(store), part, 0)
    finally:
        path.write_bytes(before)


@pytest.mark.parametrize("kind", ["mu_min", "jump", "run,mu_min"])
def test_what_is_of_one_contact_is_refused_before_it_begins(kind, tmp_path):
    with pytest.raises(rsc.SolverError, match=r"the scene has 2 contacts: must be one or more of predict, run, motions, check"):
        rsc.sweep(SHORT, VARY, kind, path=tmp_path / "store")
    assert not (tmp_path / "store").exists()


def test_a_contact_that_is_not_there_is_refused_in_one_line():
    for key in ("contact.friction", "contact.seel.friction"):
        with pytest.raises(rsc.SceneError, match=r"must be a key of contact.seal or contact.bush"):
            rsc.sweep(SHORT, {key: [0.1, 0.2]})


def test_a_drop_is_swept_over_the_angle_of_release_and_the_friction_of_both_contacts(tmp_path):
    scene = dropped(duration=0.3, output={"rate": 2000.0})
    vary = {"rotor.eccentricity.angle": [0.0, 45.0, 105.0, 180.0], "contact.*.friction": [0.2, 0.4]}
    data = rsc.sweep(scene, vary, "run", threads=1, path=tmp_path / "drop")
    assert dict(data.sizes) == {"rotor.eccentricity.angle": 4, "contact.*.friction": 2}
    assert data["rotor.eccentricity.angle"].attrs["units"] == "deg"
    for i, angle in enumerate(vary["rotor.eccentricity.angle"]):
        for k, friction in enumerate(vary["contact.*.friction"]):
            alone = rsc.simulate(dropped(friction, angle=angle, duration=0.3, output={"rate": 2000.0}))
            wholes = [alone.stretches(name).whole() for name in ("drive_end", "free_end")]
            assert data.largest_force[i, k] == max(whole.force_max for whole in wholes)
            assert (data.steps[i, k], data.contact_time[i, k]) == (alone.steps, alone.summary.contact_time)
    assert len(set(data.largest_force.values.ravel().tolist())) == 8
    whirls = data.motion.str.contains("backward whirl").values
    assert not whirls[:, 0].any() and 0 < whirls[:, 1].sum() < 4
    (tmp_path / "drop.toml").write_text(scene.to_toml())
    words = ["--vary", "rotor.eccentricity.angle=0,45,105,180", "--vary", "contact.*.friction=0.2,0.4", "--compute", "run"]
    assert main(["sweep", str(tmp_path / "drop.toml"), *words, "-o", str(tmp_path / "drop"), "--resume"]) == 0
    stored = load_dataset(tmp_path / "drop" / "sweep.nc")
    assert np.array_equal(stored["largest_force"], data.largest_force) and stored["contact.*.friction"].tolist() == [0.2, 0.4]
    other = scene.with_values({"contact.drive_end.friction": 0.1, "contact.free_end.friction": 0.3})  # varied, hence no matter
    again = rsc.sweep(other, vary, "run", threads=1, path=tmp_path / "drop", resume=True)
    assert np.array_equal(again.largest_force, data.largest_force)


def test_a_picture_over_every_contact_has_a_name_that_a_file_may_have():
    side_by_side = rsc.cases(SHORT, {"contact.*.friction": [0.1, 0.2]}, zipped=True)
    assert set(pictures(computed(plan.make_plan(SHORT, side_by_side, "run"), None, threads=1))) == {"over_contact.all.friction"}
