"""Sweeps of motions that last: danger classes, maps and curves know the whole list, not its first motion alone."""

import math

import h5py
import numpy as np
import pytest

import rsc
from rsc.measure.catalogue import LastingMotion, Motions
from rsc.measure.kinds import Kind
from rsc.measure.severity import Severity
from rsc.results import labelled
from rsc.show.sweeps import pictures, words
from rsc.study.sweep import compute
from rsc.study.sweep.dataset import LASTS, load_dataset
from rsc.study.sweep.plan import make_plan
from rsc.study.sweep.rows import ADDED
from rsc.study.sweep.sweep import computed
from rsc.system.border import Border
from scenes import LAVAL, changed

SCENE = rsc.Scene.from_dict(changed(LAVAL, drive={"duration": 0.2}), "laval.toml")
FRICTIONS = {"contact.friction": [0.01, 0.02]}  # nothing is predicted with either


def motion(kind, force, frequency=-50.0):
    border = Border(0.1, 1e-4, math.nan, 3.0, math.nan)
    described = (kind, frequency, 0.0, 1e-3, 2e-3, 0.0, 0.5 * force, force, 1.0, math.nan, math.nan, {}, {})
    return LastingMotion(*described, share=0.5, modulated=False, predicted=None, smallest_impulse=math.nan, border=border)


RUB, SLIDING, ROLLING = motion(Kind.FORWARD_RUB, 900.0, 50.0), motion(Kind.SLIDING, 80.0), motion(Kind.ROLLING, 40.0, -90.0)
AWAY, NOTHING = motion(Kind.RUNNING_AWAY, 1e9), motion(Kind.NO_CONTACT, 0.0, math.nan)


@pytest.fixture
def listing(monkeypatch):
    """Lets every sweep find a given list of motions; `ended` says which of them the impacts of 1, 2, 3, ... N s start."""

    def listed(motions, ended):
        impulse = np.stack([1.0 + np.arange(len(ended)), np.zeros(len(ended))], axis=1)
        counts = len(ended), 0, 9.0, 20, impulse, np.array(ended), np.ones(len(ended), bool)
        made = Motions(50.0, 1e-3, motions, [], [], *counts, 0.1, -50.0, 0.1, -50.0, False)
        monkeypatch.setattr(compute, "list_of", lambda *_, **__: made)
        return computed(make_plan(SCENE, rsc.cases(SCENE, FRICTIONS), "predict,motions"), None, threads=1)

    return listed


@pytest.mark.parametrize(
    ("motions", "ended", "first", "whirl", "share", "impulse", "danger"),
    [
        ([RUB, SLIDING, ROLLING, NOTHING], [0, 3, 2, 1], "forward rub", "backward whirl, sliding", 0.5, 3.0, LASTS),
        ([RUB, NOTHING, SLIDING], [0, 1], "forward rub", "backward whirl, sliding", 0.0, math.nan, LASTS),
        ([RUB, NOTHING], [0, 1], "forward rub", "", math.nan, math.nan, 0),
        ([ROLLING, NOTHING], [-1, 0, 1], "backward whirl, rolling", "backward whirl, rolling", 1 / 3, 2.0, LASTS),
        ([AWAY, SLIDING], [-1, 1], "running away", "running away", 0.5, 2.0, LASTS),
    ],
)
def test_a_whirl_counts_wherever_it_is_in_the_list(listing, motions, ended, first, whirl, share, impulse, danger):
    data = listing(motions, ended)
    assert data["lasting"].tolist() == [first] * 2 and data["lasting_whirl"].tolist() == [whirl] * 2
    assert data["danger"].tolist() == [danger] * 2
    own = next((one for one in motions if one.motion == whirl), NOTHING)
    sizes = (own.frequency, own.amplitude_max, own.force_max) if whirl and own.bounded else (math.nan,) * 3
    told = [data[f"lasting_whirl_{name}"][0] for name in ("frequency", "amplitude", "force", "share", "impulse")]
    assert told == pytest.approx([*sizes, share, impulse], nan_ok=True)


@pytest.mark.parametrize(
    ("motions", "ended", "severity"),
    [([RUB, SLIDING, NOTHING], [0, 1, 2], Severity.WHIRL), ([SLIDING, NOTHING], [1] * 16, Severity.AT_RISK),
     ([NOTHING], [0] * 16, Severity.SAFE), ([NOTHING], [-1] * 16, Severity.UNKNOWN), ([RUB, NOTHING], [0, 1], Severity.RUB)],
)  # fmt: skip
def test_a_case_has_the_severity_of_its_list(listing, motions, ended, severity):
    data = listing(motions, ended)
    assert data["severity"].tolist() == data["lasting_severity"].tolist() == [severity.level] * 2
    assert words.severities(data) == f"severity: {severity} in 2 cases" and words.plain(data)["severity"] == {severity: 2}


def test_without_a_list_a_quiet_run_is_not_called_safe():
    """With a friction of 0.01 nothing is predicted, with 0.2 a stable whirl: the end of a run alone excludes nothing."""
    scene = rsc.Scene.from_dict({**LAVAL, "drive": {"speed": 50.0, "duration": 0.2}, "start": {"running": True}})
    data = computed(make_plan(scene, rsc.cases(scene, {"contact.friction": [0.01, 0.2]}), "predict,run"), None, threads=1)
    assert data["end_severity"].tolist() == [Severity.SAFE.level] * 2
    assert data["severity"].tolist() == [Severity.UNKNOWN.level, Severity.AT_RISK.level]
    hit = scene.with_values({"start.impulse": ["1 N s", "0 N s"], "contact.friction": 0.2, "drive.duration": 1.0})
    ended = computed(make_plan(hit, rsc.cases(hit, {"drive.speed": [50.0, 51.0]}), "run"), None, threads=1)
    assert ended["severity"].tolist() == ended["end_severity"].tolist() == [Severity.WHIRL.level] * 2


def test_curves_draw_a_whirl_below_the_first_motion_and_none_twice(listing):
    def force(data):
        panels = {panel.quantity: panel for panel in pictures._panels(data, "contact.friction", "line")}
        return {curve.name: curve.values.tolist() for curve in panels["normal force"].curves if "lasts" in curve.name}

    both = {"most dangerous motion that lasts": [900.0] * 2, "most dangerous whirl that lasts": [80.0] * 2}
    assert force(listing([RUB, SLIDING], [0])) == both
    assert force(listing([SLIDING, RUB], [0])) == {"most dangerous motion that lasts": [80.0] * 2}


def test_a_dataset_without_whirls_of_lists_is_read(listing, tmp_path):
    listing([RUB, SLIDING], [0]).save(tmp_path / "now.nc")
    with h5py.File(tmp_path / "now.nc", "r+") as file:
        for name in set(ADDED["rsc-sweep-dataset-2"]) & set(file):
            del file[name]
        file.attrs["format"] = np.bytes_(b"rsc-sweep-dataset-2")
    data = load_dataset(tmp_path / "now.nc")
    assert data["lasting"].tolist() == ["forward rub"] * 2 and "lasting_whirl" not in data
    assert "curves" in pictures.pictures(data)
    assert labelled.is_labelled(tmp_path / "now.nc")


def test_over_further_keys_the_smallest_impulse_is_shown(listing, monkeypatch):
    listing([SLIDING], [0, -1])  # an impact of 1 N s
    sizes = iter([3.0, 1.0, 2.0, 4.0, 2.5, 5.0, 1.5, 6.0])
    inner = compute.list_of

    def of_case(*arguments, **options):
        made = inner(*arguments, **options)
        made.impulse[0] = next(sizes), 0.0
        return made

    monkeypatch.setattr(compute, "list_of", of_case)
    keys = {"contact.gap": ["1 mm", "2 mm"], "contact.friction": [0.01, 0.02], "drive.speed": [50.0, 51.0]}
    data = computed(make_plan(SCENE, rsc.cases(SCENE, keys), "motions"), None, threads=1)
    least = np.nanmin(data["lasting_whirl_impulse"], axis=0)
    plane = pictures._plane(data, "lasting_whirl_impulse", "drive.speed", "contact.friction")
    assert plane.tolist() == least.tolist() and not (least == np.nanmax(data["lasting_whirl_impulse"], axis=0)).all()
