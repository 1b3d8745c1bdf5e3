"""The unbalance response beside [limits]: closed forms, an independent solution, what is refused, and where it is told."""

import json

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.errors import SceneError
from rsc.scene.scene import Scene
from rsc.show.words.limits import limits_summary
from rsc.study.report.stored import report_of
from scenes import LAVAL, changed

SPEEDS = {"minimum": 40.0, "maximum_continuous": 100.0, "trip": 110.0}


def laval(ratio=0.05, natural=30.0, eccentricity=5e-6, **limits):
    rotor = {"model": "laval", "mass": 1.0, "frequency": natural, "damping_ratio": ratio, "eccentricity": eccentricity}
    table = {key: value for key, value in {**SPEEDS, **limits}.items() if value is not None}
    return Scene.from_dict({**changed(LAVAL, rotor=rotor), "limits": table})


def closed_form(ratio, natural):
    """Speed, size over the eccentricity and amplification of the peak of a Laval rotor: |r| = e x/sqrt((1 - x)^2 + 4 D^2 x) with
    x = (Omega/w)^2, largest where 1/x = 1 - 2 D^2; half of its square where x^2 (1 - P) - (2 - 4 D^2) x + 1 = 0, P = 2/peak^2."""
    peak = 1.0 / (2.0 * ratio * np.sqrt(1.0 - ratio**2))
    ends = np.sqrt(np.sort(np.roots([1.0 - 2.0 / peak**2, 4.0 * ratio**2 - 2.0, 1.0])))
    speed = 1.0 / np.sqrt(1.0 - 2.0 * ratio**2)
    return natural * speed, peak, speed / (ends[1] - ends[0])


@pytest.mark.parametrize(("ratio", "natural"), [(0.05, 30.0), (0.003, 35.0), (0.1, 135.0), (0.001, 120.0)])
def test_a_laval_rotor_has_the_peak_of_its_closed_form(ratio, natural):
    speed, size, amplification = closed_form(ratio, natural)
    found = rsc.limits(laval(ratio, natural))
    (peak,) = found.peaks
    assert peak.speed == pytest.approx(speed, rel=1e-7)
    assert peak.amplitude == pytest.approx(2.0 * 5e-6 * size, rel=1e-9)
    assert peak.amplification == pytest.approx(amplification, rel=1e-6)
    share = 0.17 * (1.0 - 1.0 / (amplification - 1.5))
    below = speed < 40.0
    assert peak.margin == pytest.approx((40.0 - speed) / 40.0 if below else (speed - 100.0) / 100.0, rel=1e-6)
    assert peak.needed == pytest.approx(min(0.16, share) if below else min(0.26, 0.1 + share), rel=1e-6)
    assert peak.kept == (peak.margin >= peak.needed)


def test_vibration_and_clearances_are_scaled():
    """At 12000 rpm and below 25.4 um are allowed, above less; the contact's gap is 1 mm."""
    ratio, natural = 0.05, 30.0
    found = rsc.limits(laval(ratio, natural))
    x = (40.0 / natural) ** 2  # above the resonance the response falls
    vibration = 2.0 * 5e-6 * x / np.sqrt((1.0 - x) ** 2 + 4.0 * ratio**2 * x)
    assert (found.vibration, found.at) == (pytest.approx(vibration, rel=1e-9), 40.0)
    assert found.allowed == 25.4e-6
    assert found.scale == pytest.approx(25.4e-6 / vibration)
    (passage,) = found.passages
    assert passage.share == pytest.approx(found.scale * 0.5 * found.peaks[0].amplitude / 1e-3, rel=1e-9)
    assert passage.speed == found.peaks[0].speed
    fast = rsc.limits(laval(maximum_continuous=800.0, trip=800.0))
    assert fast.allowed == pytest.approx(25.4e-6 * np.sqrt(12000.0 / 48000.0))
    assert rsc.limits(laval(eccentricity=1e-9)).scale == 6.0
    assert rsc.limits(laval(eccentricity=1e-3)).scale == 0.5
    assert rsc.limits(laval(minimum=None, trip=None)).operating == (100.0, 100.0)


def test_inside_the_operating_speeds_no_margin_is_kept_unless_it_is_damped():
    (sharp,), (broad,) = rsc.limits(laval(natural=60.0)).peaks, rsc.limits(laval(ratio=0.3, natural=50.0)).peaks
    assert (sharp.margin, sharp.needed, sharp.kept) == (0.0, np.inf, False)
    assert broad.amplification < 2.5 and (broad.margin, broad.needed, broad.kept) == (0.0, 0.0, True)


def test_a_peak_with_one_side_is_told_from_it_and_one_without_not():
    """Far above a resonance the response of a strongly damped rotor stays above 1/sqrt(2) of its peak."""
    (peak,) = rsc.limits(laval(ratio=0.4, natural=50.0)).peaks
    x = np.roots([1.0 - 2.0 * (2.0 * 0.4 * np.sqrt(1.0 - 0.4**2)) ** 2, 4.0 * 0.4**2 - 2.0, 1.0])
    low = 50.0 * np.sqrt(x[x > 0.0].min())
    assert peak.amplification == pytest.approx(peak.speed / (2.0 * (peak.speed - low)), rel=1e-6)


def test_directions_that_differ_are_judged_by_the_major_axis():
    """Two peaks of one disk on unequal supports; witness: the real equations of y and z at 40,001 speeds."""
    mass, damping = 2.0, 20.0
    stiff = {"y": 9e4, "z": 1.6e5}
    rotor = {
        "model": "laval", "mass": mass, "stiffness": 0.5 * (stiff["y"] + stiff["z"]), "damping": damping, "eccentricity": 5e-6,
        "supports": [[0, [0.5 * (stiff["y"] - stiff["z"]), 0.0, 0.0, -0.5 * (stiff["y"] - stiff["z"])]]],
    }  # fmt: skip
    found = rsc.limits(Scene.from_dict({**changed(LAVAL, rotor=rotor), "limits": {**SPEEDS, "minimum": 90.0}}))
    Omega = 2.0 * np.pi * np.linspace(0.0, 165.0, 40001)
    force = mass * 5e-6 * Omega**2
    y, z = (force * turn / (k - mass * Omega**2 + 1j * damping * Omega) for k, turn in ((stiff["y"], 1.0), (stiff["z"], -1j)))
    size = 0.5 * (np.abs(y + 1j * z) + np.abs(y - 1j * z))  # of both circles
    tops = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])) + 1
    assert len(found.peaks) == len(tops) == 2
    for peak, i in zip(found.peaks, tops, strict=True):
        assert peak.speed == pytest.approx(Omega[i] / (2.0 * np.pi), abs=165.0 / 40000)
        assert peak.amplitude == pytest.approx(2.0 * size[i], rel=1e-5)  # the witness misses the top by part of a step


def test_a_probe_is_a_clearance_and_that_which_is_taken_furthest_leads():
    chain = {"model": "chain", "masses": [3.0, 2.0, 1.5], "stiffnesses": [4e5, 5e5, 6e5, 3e5], "damping_ratio": 0.02,
             "eccentricity": 2e-5}  # fmt: skip
    places = [{"name": "bearing", "rotor_coordinate": 2, "gap": 1e-3}, {"name": "seal", "rotor_coordinate": 1, "gap": 1e-4}]
    scene = {**changed(LAVAL, rotor=chain, start={"rest": True}), "clearance": places, "limits": {**SPEEDS, "probe": "bearing"}}
    found = rsc.limits(Scene.from_dict(scene))
    system_at_contact = rsc.limits(Scene.from_dict({**scene, "limits": SPEEDS}))
    assert found.probe == "bearing" and found.peaks[0].amplitude != system_at_contact.peaks[0].amplitude
    assert found.passages[0].name == "seal"
    assert sorted(passage.share for passage in found.passages)[::-1] == [passage.share for passage in found.passages]


@pytest.mark.parametrize(
    ("limits", "wanted"),
    [
        ({"minimum": 101.0}, "limits.minimum = 101.*<= maximum_continuous = 100 Hz"),
        ({"trip": 99.0}, "limits.trip = 99.*>= maximum_continuous = 100 Hz"),
        ({"probe": "seal"}, "limits.probe = 'seal'.*left out.*there is none"),
        ({"maximum_continuous": 0.0}, "limits.maximum_continuous = 0"),
        ({"maximum_continuous": None}, "limits.maximum_continuous"),
        ({"sped": 3.0}, "limits.sped"),
    ],
)
def test_limits_that_cannot_be_are_refused(limits, wanted):
    table = {key: value for key, value in (SPEEDS | limits).items() if value is not None}
    with pytest.raises(SceneError, match=wanted):
        Scene.from_dict({**LAVAL, "limits": table})


def test_without_limits_or_a_response_nothing_is_judged():
    with pytest.raises(SceneError, match=r"limits.*given as a table \[limits\]"):
        rsc.limits(Scene.from_dict(LAVAL))
    with pytest.raises(SceneError, match="whose unbalance moves the probe"):
        rsc.limits(laval(eccentricity=0.0))


def test_a_scene_keeps_its_limits():
    scene = laval()
    assert Scene.from_dict(scene.to_dict()) == scene == Scene.from_toml(scene.to_toml())
    assert scene.mirrored().limits == scene.limits
    assert scene.with_values({"limits.trip": "7200 rpm"}).limits.trip == 120.0


def test_the_command_and_the_page_tell_what_is_not_kept(tmp_path, capsys):
    values = {"drive.duration": 1.0, "drive.speed": [20.0, 40.0], "start.rest": True}
    scene = laval(natural=60.0, eccentricity=2e-4).with_values(values)
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    assert main(["limits", str(path)]) == 0
    told = capsys.readouterr().out
    assert "not kept" in told and "exceeded" in told and "no conformity is claimed" in told
    assert main(["limits", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["peaks"][0]["margin"] == 0.0
    assert main(["check", str(path), "--output", str(tmp_path / "out")]) == 0
    assert "not kept without contact: margin of the peak at 60" in " ".join(capsys.readouterr().out.split())
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Limits at the contact" in page
    stored = json.loads((tmp_path / "out" / "report.json").read_text())
    made = rsc.limits(scene)
    assert stored["limits"]["vibration"] == made.vibration
    (result,) = (tmp_path / "out").glob("*.h5")
    read = report_of(rsc.load(result), result)
    assert read.limits == made and "margin" in limits_summary(read.limits)
