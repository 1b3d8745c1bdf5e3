"""The undamped critical speed map against closed forms, and against `rsc modes` at the stiffness of the machine."""

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.machine.shaft.criticals import undamped_criticals
from rsc.machine.shaft.parts import Disk, Material, Section, Shaft, Support
from rsc.scene.files.templates import template
from shaft_scenes import text

STEEL, MASSLESS = Material(7850.0, 210e9, 0.3), Material(0.0, 210e9, 0.3)
BOTH = (0, 1)


def bearing(place, k_xx=1e7, k_yy=None):
    return Support(place, np.zeros(1), np.array([[k_xx, 0.0, 0.0, k_xx if k_yy is None else k_yy, 0.0, 0.0, 0.0, 0.0]]))


def cylinder(length, diameter, material=STEEL):
    return Section(length, (diameter, diameter), (0.0, 0.0), material)


def criticals(shaft, stiffness, varied=BOTH, most=3, elements=40):
    return undamped_criticals(shaft, np.linspace(0.0, shaft.length, elements + 1), np.array(stiffness), varied, most)


def test_a_laval_rotor_on_springs_has_its_closed_form_at_every_stiffness():
    """Shaft 48 E I / L^3 and both bearings in series under the mass."""
    supports, disks = (bearing(0.0), bearing(0.5)), (Disk(0.25, 10.0, 0.05, 0.03),)
    shaft = Shaft((cylinder(0.5, 0.02, MASSLESS),), disks=disks, supports=supports, shear=False)
    stiffness = np.geomspace(1e2, 1e12, 11)
    bend = 48.0 * 210e9 * np.pi / 64.0 * 0.02**4 / 0.5**3
    wanted = np.sqrt(1.0 / (1.0 / bend + 0.5 / stiffness) / 10.0) / (2.0 * np.pi)
    found = criticals(shaft, stiffness)
    assert found[:, 0] == pytest.approx(wanted, rel=1e-6)
    assert np.isnan(found[:, 1:]).all()  # the disk's polar moment exceeds its diametral one: no conical critical speed


def test_soft_bearings_carry_a_rigid_rotor():
    """Bounce 2 k / m, and forward conical 2 k a^2 / (I_d - I_p)."""
    shaft = Shaft((cylinder(1.0, 0.1),), supports=(bearing(0.2), bearing(0.8)))
    mass, radius = shaft.mass, 0.05
    tilting = mass * (1.0 / 12.0 + radius**2 / 4.0) - mass * radius**2 / 2.0
    wanted = np.sqrt(np.array([2e3 / mass, 2e3 * 0.3**2 / tilting])) / (2.0 * np.pi)
    assert criticals(shaft, [1e3])[0, :2] == pytest.approx(np.sort(wanted), rel=1e-5)


def test_stiff_bearings_pin_a_beam():
    """sin(n pi s) turning as fast as it whirls: Omega^2 (A - I k^2) = E/rho I k^4, without shear."""
    shaft = Shaft((cylinder(1.0, 0.08),), supports=(bearing(0.0), bearing(1.0)), shear=False)
    k, area, inertia = np.pi * np.arange(1, 4), np.pi * 0.04**2, np.pi / 4.0 * 0.04**4
    wanted = np.sqrt(STEEL.young / STEEL.density * inertia * k**4 / (area - inertia * k**2)) / (2.0 * np.pi)
    assert criticals(shaft, [1e15])[0] == pytest.approx(wanted, rel=1e-5)


def test_a_bearing_that_is_not_varied_keeps_its_mean_stiffness():
    shaft = Shaft((cylinder(1.0, 0.08),), supports=(bearing(0.0, 1e7), bearing(1.0, 4e7, 2e7)))
    equal = Shaft((cylinder(1.0, 0.08),), supports=(bearing(0.0, 1e7), bearing(1.0, 3e7)))
    assert criticals(shaft, [5e6], varied=(0,)) == pytest.approx(criticals(equal, [5e6], varied=(0,)), rel=1e-12)
    assert (criticals(shaft, [5e6], varied=(0,)) > criticals(shaft, [5e6])).any()


def test_at_the_stiffness_of_the_machine_they_are_its_critical_speeds():
    """Both bearings of the scene have 5e7 N/m; without damping its Campbell diagram meets 1X there."""
    undamped = text().replace(', damping = "1e4 N s/m"', "").replace('"3000 rpm"', '"400 Hz"')
    scene = rsc.Scene.from_toml(undamped.replace("[-100.0, 100.0]", "[-600.0, 600.0]"))
    speeds = rsc.critical_map(scene, [5e7]).speed[0]
    below = speeds[speeds < 400.0]
    assert len(below) and rsc.modes(scene, [0.0, 400.0]).criticals == pytest.approx(below, rel=1e-4)


def test_the_map_knows_what_the_bearings_are(tmp_path):
    (tmp_path / "b.csv").write_text("speed [rpm], k_xx [N/mm], k_yy [N/mm]\n1000,5e4,3e4\n4000,3e4,1e4\n")
    bearings = '[{name = "fixed", at = 0.02, stiffness = 5e7}, {at = 0.48, table = "b.csv"}]'
    (tmp_path / "scene.toml").write_text(text(bearings=bearings))
    made = rsc.critical_map(rsc.load_scene(tmp_path / "scene.toml"))
    fixed, following = made.bearings
    assert fixed.name == "fixed" and fixed.stiffness.tolist() == [5e7]
    assert following.name == "bearing at 0.48 m" and following.stiffness == pytest.approx([4e7, 2e7])
    assert following.speed == pytest.approx([1000.0 / 60.0, 4000.0 / 60.0])
    assert made.stiffness[[0, -1]] == pytest.approx([2e5, 5e9]) and len(made.table().rows) == 61
    axes = made.plot()
    assert axes.get_xscale() == axes.get_yscale() == "log"
    names = {line.get_label(): line for line in axes.get_lines()}
    assert set(names["fixed, as it is"].get_xdata()) == {5e7} and 2e7 in names["bearing at 0.48 m, as it is"].get_xdata()


REFUSED = [
    (["--stiffness", "0:1e9:5"], "two stiffnesses > 0"),
    (["--stiffness", "1e9:1e6:5"], "two stiffnesses > 0"),
    (["--stiffness", "1:2"], "FROM:TO:NUMBER"),
    (["--stiffness", "1e6 mm:1e9 mm:5"], "FROM:TO:NUMBER"),
    (["--stiffness", "--bearings", "drive ende"], "drive end"),
    (["--bearings", "drive end"], "requires --stiffness"),
    (["--stiffness", "--speed", "20"], "cannot be combined"),
]


@pytest.mark.parametrize("options, message", REFUSED)
def test_what_the_command_refuses(options, message, tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(text())
    assert main(["modes", str(tmp_path / "scene.toml"), *options]) == 2
    told = capsys.readouterr().err
    assert message in told and told.count("\n") == 1


def test_the_command_prints_and_draws_the_map(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.write_text(text())
    for name in ("map.png", "map.csv"):
        command = ["modes", str(path), "--stiffness", "1:1000 MN/m:4", "--bearings", "drive end", "-o", str(tmp_path / name)]
        assert main(command) == 0 and (tmp_path / name).stat().st_size > 100
    told = capsys.readouterr().out
    assert "1e+06" in told and "1e+09" in told
    assert "of drive end: 50 MN/m" in told and "of bearing at 0.48 m: 50 MN/m, not varied" in told
    (tmp_path / "laval.toml").write_text(template("laval"))
    assert main(["modes", str(tmp_path / "laval.toml"), "--stiffness"]) == 2
    assert 'must be model "shaft" of a scene file' in capsys.readouterr().err
