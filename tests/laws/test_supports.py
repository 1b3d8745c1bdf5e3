"""Both witnesses on whirls in supports that are skew and that differ in y and z: the kernel's steady motion and the analysis."""

import tomllib

import numpy as np
import pytest

import rsc
from ross_rotors import DATA, RUB
from rsc.analysis.balance.elliptic_whirl import elliptic_whirl
from rsc.analysis.follow.forward_rub import attractors, rub_ranges
from rsc.analysis.paper.anisotropy import rub_mirror_share
from rsc.analysis.paper.synchronous import forward_rub
from rsc.analysis.survey.remarks import rub_remarks
from rsc.machine.imports.ross import read_ross
from rsc.machine.imports.store import save_model
from rsc.show.pictures.stability import stability
from rsc.show.words.answer import answer
from rsc.show.words.text import stable_stretches
from rsc.system.assemble import assemble
from systems import REFERENCE, TWO_PI, reference_scene

SPEED, STIFFNESS = 50.0, (30.0 * TWO_PI) ** 2


def scene(unequal, skew):
    """The Laval rotor of the reference without unbalance: k_yy, k_zz = k (1 +- unequal), k_zy = -k_yz = skew k."""
    support = [0, [unequal * STIFFNESS, -skew * STIFFNESS, skew * STIFFNESS, -unequal * STIFFNESS]]
    return reference_scene("laval").with_values(
        {"rotor.supports": [support], "rotor.eccentricity": 0.0, "drive.speed": [SPEED, SPEED], "drive.duration": 4.0}
    )


def measured(result):
    """Frequency in Hz and smallest and largest |r| of the last second."""
    late = result.time > result.time[-1] - 1.0
    time, r = result.time[late], result.rotor[late, 0]
    grid, window = np.linspace(-63.0, -59.0, 801), np.hanning(len(r))
    sizes = np.abs(np.exp(-1j * TWO_PI * np.outer(grid, time)) @ (r * window))
    return grid[np.argmax(sizes)], np.abs(r).min(), np.abs(r).max()


@pytest.mark.parametrize(("unequal", "skew"), [(0.05, 0.0), (0.05, 0.02), (0.0, 0.03), (0.0, -0.03)])
def test_a_simulated_whirl_is_the_predicted_one(unequal, skew):
    asked = scene(unequal, skew)
    whirl = min(rsc.predict(asked), key=lambda w: abs(w.frequency + 60.7))
    assert whirl.stable
    told = whirl.frequency, whirl.rotor_amplitude, whirl.rotor_amplitude
    if unequal:
        exact = elliptic_whirl(assemble(asked), whirl.frequency, SPEED)
        told = exact.frequency, *exact.envelope
    frequency, *envelope = measured(rsc.simulate(asked))
    assert frequency == pytest.approx(told[0], abs=0.005)
    assert envelope == pytest.approx(told[1:], rel=1e-5)


def rub_scene(unequal, speed=44.0):
    """The gyroscopic disk in its light stator with k (1 +- unequal) at the disk, from rest into a forward rub."""
    content = tomllib.loads((REFERENCE / "gyroscopic_disk_light.toml").read_text())
    k = unequal * assemble(reference_scene("gyroscopic_disk_light")).rotor.stiffness[0, 0]
    rotor = {**content["rotor"], "supports": [[0, [k, 0.0, 0.0, -k]]]}
    drive = {"speed": [speed, speed], "duration": 6.0}
    return rsc.Scene.from_dict({**content, "rotor": rotor, "drive": drive, "start": {"rest": True}})


@pytest.mark.parametrize(("unequal", "miss"), [(0.002, 2e-4), (0.02, 5e-3)])
def test_a_simulated_forward_rub_has_the_predicted_mirror_line(unequal, miss):
    asked = rub_scene(unequal)
    system, Omega = assemble(asked), TWO_PI * 44.0
    (rub,) = forward_rub(system, Omega)
    result = rsc.simulate(asked)
    late = result.time > result.time[-1] - 0.5
    lines = np.exp(1j * Omega * np.outer(result.time[late], (1, -1, 3, -3)))
    whirl, mirror = np.abs(np.linalg.lstsq(lines, result.rotor[late, 0], rcond=None)[0])[:2]
    assert rub_mirror_share(system, rub, Omega) == pytest.approx(mirror / whirl, rel=miss)


def test_a_forward_rub_that_is_no_circle_is_not_claimed():
    for unequal, claimed in ((0.02, True), (0.1, False)):
        system = assemble(rub_scene(unequal))
        (rub,) = (motion for motion in attractors(system, 44.0) if motion.kind == "forward rub")
        assert rub.growth_rate < 0.0 and rub.stable == claimed
        (over,) = rub_ranges(system, np.array([43.0, 44.0]))
        assert (over.growth_rate < 0.0).all() and (over.stable == claimed).all()
        assert over.mirror[-1] == rub_mirror_share(system, *forward_rub(system, TWO_PI * 44.0), TWO_PI * 44.0)
        told = rub_remarks([over])
        assert len(told) == (not claimed) and all("not circular between 43 and 44 Hz" in remark for remark in told)


def ross_rub(folder, speed):
    """The rub rotor of ROSS on its own bearings, of two stiffnesses each, in a stator of two masses, reduced."""
    rub, unbalance = RUB["rub"], RUB["unbalance"]
    file = folder / "rotor.npz"
    if not file.exists():
        save_model(read_ross(DATA / "machines" / "ross_rub_rotor.mat", 20.0), file)
    return rsc.Scene.from_dict(
        {
            "rotor": {
                "model": "machine",
                "file": str(file),
                "contact": rub["node"],
                "unbalance": [[unbalance["node"], 1.2 * unbalance["magnitude"]]],
            },
            "reduction": {"tolerance": 1e-3},
            "stator": {"model": "chain", "masses": [1.0, 0.3], "stiffnesses": [1e6, 1e6, 0.0], "rayleigh": [100.0, 1e-3]},
            "contact": {"stator_coordinate": 1} | {key: rub[key] for key in ("gap", "stiffness", "damping", "friction")},
            "drive": {"speed": speed, "duration": 6.0},
        }
    )


@pytest.mark.nightly
def test_what_is_claimed_of_a_forward_rub_on_unequal_bearings_is_what_runs_do(tmp_path):
    """From 81 to 110 Hz the isotropic mean is stable, but the rub no circle: neither stable nor unstable, in text and map."""
    asked = ross_rub(tmp_path, [70.0, 150.0])
    (rub,) = rub_ranges(assemble(asked), np.linspace(70.0, 150.0, 81))
    (claimed,) = rub.stretches(rub.stable)
    unclaimed = rub.stretches(~rub.stable & (rub.growth_rate < 0.0))
    assert claimed == pytest.approx((109.83, 144.74), abs=0.1)
    assert [*unclaimed[0], *unclaimed[1]] == pytest.approx([81.31, claimed[0], claimed[1], 150.0], abs=0.1)
    spans = [f"{low:.5g} .. {high:.5g} Hz" for low, high in (claimed, *unclaimed)]
    assert stable_stretches(rub) == f"stable {spans[0]}, not circular (stability not assessed) {spans[1]} and {spans[2]}"
    assert np.isnan(stability(rub)[(rub.speed > 82.0) & (rub.speed < 109.0)]).all()
    for speed, circular in ((130.0, True), (90.0, False)):
        scene_there = ross_rub(tmp_path, speed)
        (motion,) = (m for m in attractors(assemble(scene_there), speed) if m.kind == "forward rub")
        assert motion.growth_rate < 0.0 and motion.stable == circular
        distance = np.abs(rsc.simulate(scene_there).contact_rotor()[-1000:])
        if circular:
            share = rub.mirror[np.searchsorted(rub.speed, speed)]
            envelope = motion.amplitude * (1.0 - share), motion.amplitude * (1.0 + share)
            assert (distance.min(), distance.max()) == pytest.approx(envelope, rel=0.02)
        else:
            assert distance.max() > 2.0 * motion.amplitude and distance.min() < 0.7 * motion.amplitude


def test_a_rub_on_unequal_supports_is_told_as_a_rub(tmp_path):
    """At 90 Hz its ellipse has two thirds of the forward circle as backward line: no whirl, and none is looked for there."""
    report = rsc.check(ross_rub(tmp_path, 90.0))
    speed, features = report.fall.speed, report.features
    assert report.fall.amplitude[-1, np.abs(report.fall.frequency + speed[-1]).argmin()] > 3.0 * report.result.scene.contact.gap
    assert not (np.abs(features.frequency + speed) < 2.0 / report.fall.window).any()
    assert dict(answer(report))["whirl"].startswith("no backward whirl")
    assert np.isnan(report.rub[1]).all()
