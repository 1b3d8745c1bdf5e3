"""Reports of rotors whose supports differ in x and y: judged by the elliptic whirl, and the difference is told."""

import numpy as np
import pytest

import rsc
from systems import reference_scene


def held(share):
    """The Laval reference without unbalance, its shaft softer in x and stiffer in y by a share."""
    scene = reference_scene("laval").with_values({"drive.speed": [50.0, 60.0], "drive.duration": 6.0, "rotor.eccentricity": 0.0})
    stiffness = scene.rotor.mass * (2.0 * np.pi * scene.rotor.frequency) ** 2
    mean = [-share * stiffness, 0.0, 0.0, share * stiffness]
    return scene.with_values({"rotor.supports": [[0, mean]]})


def test_a_whirl_in_supports_that_differ_agrees_with_the_elliptic_prediction():
    report = rsc.check(held(0.03))
    rows = [row for row in report.rows if row.quantity != "synchronous line"]
    assert {row.by for row in rows} == {"elliptic"} and {row.verdict for row in rows} == {"agrees"}
    mean = next(branch for branch in report.branches if branch.label == rows[0].branch)
    sizes = [row for row in rows if row.quantity == "whirl amplitude"]
    # the ellipse's larger line is not that of the isotropic mean
    assert abs(sizes[-1].predicted / mean.at(60.0).rotor_amplitude - 1.0) > 2.0 * abs(sizes[-1].difference)
    assert any("elliptical, its counter-rotating component has" in warning for warning in report.remarks)


def test_without_contact_the_line_at_the_rotor_speed_is_that_of_the_ellipse():
    scene = reference_scene("laval").with_values({"drive.speed": 20.0, "drive.duration": 4.0, "contact.gap": 5e-3})
    stiffness = scene.rotor.mass * (2.0 * np.pi * scene.rotor.frequency) ** 2
    scene = rsc.Scene.from_dict(scene.to_dict() | {"start": {"rest": True}})
    scene = scene.with_values({"rotor.supports": [[0, [-0.2 * stiffness, 0.0, 0.0, 0.2 * stiffness]]]})
    rows = [row for row in rsc.check(scene).rows if row.quantity == "synchronous line"]
    assert rows[-1].by == "without contact" and rows[-1].simulated == pytest.approx(rows[-1].predicted, rel=1e-3)
    circle = abs(scene.rotor.eccentricity.amount / ((30.0 / 20.0) ** 2 - 1.0))
    assert abs(rows[-1].predicted / circle - 1.0) > 0.02
