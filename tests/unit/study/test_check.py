"""Reports of runs that ended early: status and advice come through, however few samples there are."""

import re

import numpy as np
import pytest

import rsc
from rsc.analysis.follow.forward_rub import rub_growth
from rsc.analysis.paper.synchronous import forward_rub
from rsc.show.pictures.abscissa import Abscissa
from rsc.show.pictures.album import described
from rsc.show.words.answer import answer
from rsc.study.report.check import report as report_of
from rsc.system.assemble import assemble
from systems import reference_scene

DIVERGING = {
    "rotor": {"model": "laval", "mass": 1.0, "frequency": 30.0, "damping_ratio": 0.02, "eccentricity": 5e-5},
    "stator": {"model": "rigid"},
    "contact": {"gap": 1e-3, "friction": 0.6, "stiffness": 3.55e6, "damping_ratio": 0.05},
    "drive": {"speed": [20.0, 40.0], "duration": 20.0},
    "start": {"rotor": [[1e-3, 0.0]], "rotor_velocity": [[0.0, -0.3]]},
}

# a generator rotor in an oil seal ring on a soft end shield
GENERATOR = {
    "rotor": {"model": "laval", "mass": 8000.0, "frequency": 1150 / 60, "damping_ratio": 0.03, "eccentricity": "G 2.5"},
    "stator": {"model": "laval", "mass": 1500.0, "frequency": 11.0, "damping_ratio": 0.02},
    "contact": {"gap": 1.2e-3, "friction": 0.18, "stiffness": 2e8, "damping_ratio": 0.05, "diameter": 0.45},
    "drive": {"speed": 49.5, "duration": 2.0},
}


def diverging(rate):
    return rsc.Scene.from_dict(DIVERGING | {"output": {"rate": rate}})


@pytest.mark.parametrize("rate", [250.0, 300.0])
def test_a_run_of_a_single_window_has_a_report(rate):
    report = rsc.check(diverging(rate))
    assert len(report.fall.speed) == 1
    assert report.agreement.startswith("the run stopped early (diverged)")
    assert "the motion diverged" in report.warnings[0]


@pytest.mark.parametrize("rate", [160.0, 200.0])
def test_too_few_samples_for_a_spectrum_hide_neither_status_nor_advice(rate):
    with pytest.raises(rsc.DataError, match=r"diverged after .*the motion diverged.*raise output\.rate above 258 Hz"):
        rsc.check(diverging(rate))


def test_a_contact_that_is_pressed_in_by_more_than_the_gap_is_told():
    """A linear contact holds any force."""
    whirl = {"start": {"whirl": -12.9}, "drive": {"speed": 20.0, "duration": 1.0}}
    for stiffness, soft in ((1.8e6, False), (6e4, True)):
        scene = rsc.Scene.from_dict(reference_scene("mdof_2x2").to_dict() | whirl).with_values({"contact.stiffness": stiffness})
        report = rsc.check(scene)
        assert report.stretches.whole().force_max > 1.0
        assert any("penetrated by up to" in line for line in report.warnings) == soft


def test_windows_grow_until_they_hold_three_periods_of_a_slow_whirl():
    content = reference_scene("mdof_2x2").to_dict() | {"start": {"whirl": -12.9}}
    report = rsc.check(rsc.Scene.from_dict(content | {"drive": {"speed": 20.0, "duration": 1.0}}))
    slowest = min(abs(branch.frequency[0]) for branch in report.branches if branch.stable.any())
    assert 1.0 / 8.0 < 3.0 / slowest < report.fall.window < 3.5 / slowest
    assert {row.verdict for row in report.rows if row.quantity == "whirl frequency"} == {"agrees"}
    rows = rsc.check(rsc.Scene.from_dict(content | {"drive": {"speed": 20.0, "duration": 0.4}})).rows
    assert {row.verdict for row in rows if row.quantity == "whirl frequency"} == {"not resolved"}


def test_a_motion_far_smaller_than_the_gap_is_told_to_be_coarsely_resolved():
    """The tolerance is relative to the gap: one of 1 m leaves an orbit of micrometres wrong by a tenth."""
    content = reference_scene("gyroscopic_disk_light").to_dict() | {"start": {"rest": True}}
    content["drive"] = {"speed": 30.0, "duration": 1.0}
    told = []
    for gap, coarse in ((5e-4, False), (1.0, True)):
        scene = rsc.Scene.from_dict(content).with_values({"contact.gap": gap})
        notes = []
        warnings = rsc.check(scene, note=notes.append).warnings
        assert any("solver.rtol, or contact.gap" in line for line in warnings) == coarse
        assert any("solver.rtol, or contact.gap" in line for line in notes) == coarse
        told.append(warnings)
    assert told[0] == []


def test_of_two_forward_rubs_a_run_is_compared_with_the_stable_one():
    """Above its resonance the rotor moves less than the stator, 0.08 gaps; the saddle, 0.7 gaps large, presses less."""
    scene = rsc.Scene.from_dict({
        "rotor": {"model": "disk", "mass": 1.7, "diametral_inertia": 0.0014, "polar_inertia": 0.00156,
                  "stiffness": [[204e3, 449.0], [449.0, 288.0]], "damping_ratio": 0.022, "eccentricity": 1.18e-4},
        "stator": {"model": "laval", "mass": 0.95, "frequency": 50.4, "damping_ratio": 0.02},
        "contact": {"gap": 0.263e-3, "friction": 0.05, "stiffness": 2.7e7, "damping_ratio": 0.1, "diameter": 0.0193},
        "drive": {"speed": [147.5, 110.0], "duration": 3.0},
        "start": {"rest": True},
    })  # fmt: skip
    system, Omega = assemble(scene), 2.0 * np.pi * 130.0
    saddle, stable = forward_rub(system, Omega)
    assert rub_growth(system, stable, Omega).rate < 0.0 < rub_growth(system, saddle, Omega).rate
    assert stable.amplitude < 0.1 * system.contact.gap < 0.5 * system.contact.gap < saddle.amplitude
    report = rsc.check(scene)
    rubs = [row for row in report.rows if row.by == "forward rub"][5:]
    assert len(rubs) > 5 and {row.verdict for row in rubs} == {"agrees"}
    assert np.nanmax(report.rub[1]) < 0.1 * system.contact.gap


def test_a_whirl_faster_than_rolling_gives_the_drive_its_energy():
    """Where Psi |d| is beyond Omega d_R/2 the surfaces slide the other way, and friction pushes the shaft until it rolls."""
    pump = {
        "rotor": {"model": "laval", "mass": 12.0, "frequency": 2600 / 60, "damping_ratio": 0.02, "eccentricity": 2e-5},
        "stator": {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1},
        "contact": {"gap": 2.5e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05, "diameter": 3e-4},
        "drive": {"speed": 50.0, "duration": 0.03}, "start": {"whirl": -67.93},
    }  # fmt: skip
    result = rsc.simulate(rsc.Scene.from_dict(pump))
    work = result.stretches().drive_work.sum()
    (line,) = [text for name, text in answer(report_of(result, lists=False)) if name == "drive"]
    assert work < 0.0 and line.startswith("the rub drives the shaft with up to ") and "-" not in line
    told = re.search(r"; ([\d.]+) mJ over the run", line)
    assert float(told[1]) == pytest.approx(-1e3 * work, rel=0.01)


def test_a_letter_is_one_whirl_in_branches_and_lists_and_a_run_without_contact_has_no_empty_pictures():
    """Branches are called by their stability and range, whirls at one speed by their frequency."""
    report = rsc.check(rsc.Scene.from_dict(GENERATOR))
    (listed,) = report.motions
    known = {branch.label: branch.at(listed.speed).frequency for branch in report.branches}
    told = {one.label: one.frequency for one in listed.not_reached if one.label in known}
    assert len(told) > 1 and told == pytest.approx({label: known[label] for label in told}, rel=1e-2)
    assert list(known) != [label for label, _ in sorted(known.items(), key=lambda item: item[1])]  # not by frequency
    pictures = described(report, Abscissa(report))
    assert "amplitude" in pictures and not {"power", "share", "slip"} & set(pictures)
