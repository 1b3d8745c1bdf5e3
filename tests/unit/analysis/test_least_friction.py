"""The least friction of a whirl against dense scans and closed forms."""

import numpy as np
import pytest

from rsc.analysis.events import FOLD, SLIDING
from rsc.analysis.least_friction import mu_min
from rsc.analysis.whirls import receptance, receptance_rotor
from rsc.system.assemble import assemble
from systems import TWO_PI, reference_scene


@pytest.mark.parametrize("name", ["laval", "mdof_2x2", "gyroscopic_transition", "chain_10"])
def test_least_friction_is_that_of_a_dense_scan(name):
    scene = reference_scene(name)
    least = mu_min(scene, 50.0)
    system, Psi = assemble(scene), -TWO_PI * np.linspace(1.0, 1000.0, 50_001)
    H, H_r = receptance(system, Psi, TWO_PI * 50.0), receptance_rotor(system, Psi, TWO_PI * 50.0)
    allowed = (H.real < 0.0) & (np.abs(H_r) >= np.abs(H)) & (H.imag > 0.0)
    scanned = (-H.imag / H.real)[allowed].min()
    # a scan cannot undercut the minimum
    assert scanned * (1.0 - 1e-4) < least.value <= scanned
    assert least.cause == FOLD


def test_no_damping_needs_no_friction_and_a_rigid_wall_neither():
    scene = reference_scene("laval")
    undamped = scene.with_values({"rotor.damping": 0.0, "stator.damping": 0.0})
    assert mu_min(undamped).value == 0.0
    content = scene.to_dict()
    wall = type(scene).from_dict({**content, "stator": {"model": "rigid"}, "start": {"rest": True}})
    # -b/(mu m): the less friction, the faster the whirl
    assert (mu_min(wall).value, mu_min(wall).frequency) == (0.0, -np.inf)


@pytest.mark.parametrize("diameter", [0.01, 0.1])
def test_least_friction_in_a_rigid_wall_is_that_of_rolling(diameter):
    content = reference_scene("laval").to_dict()
    contact = {**content["contact"], "diameter": diameter, "slip_velocity": 1e-3}
    change = {"stator": {"model": "rigid"}, "start": {"rest": True}, "contact": contact}
    scene = type(reference_scene("laval")).from_dict({**content, **change})
    least, system = mu_min(scene, 50.0), assemble(scene)
    # r = s e^{i psi}: m psi'' + b psi' + mu (m psi'^2 - k) = 0 at psi' = -Omega d_R/(2 s)
    rolling = -TWO_PI * 50.0 * diameter / (2.0 * system.gap)
    m, b, k = (matrix[0, 0] for matrix in (system.mass_r, system.damping_r, system.stiffness_r))
    assert least.value == pytest.approx(-b * rolling / (m * rolling**2 - k), rel=1e-9)
    assert least.frequency == pytest.approx(rolling / TWO_PI, rel=1e-9) and least.cause == SLIDING
    # a light stator gives a fold long before
    with_stator = reference_scene("laval").with_values({"contact.diameter": diameter, "contact.slip_velocity": 1e-3})
    assert mu_min(with_stator, 50.0) == mu_min(reference_scene("laval"), 50.0)
