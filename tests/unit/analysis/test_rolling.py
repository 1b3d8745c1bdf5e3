"""Whirls that roll: the equations they come from, a closed form, and the simulator."""


import numpy as np
import pytest

import rsc
import systems
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import receptance
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.paper.whirls import normal_force, whirl_shapes
from rsc.cli import main
from rsc.system.assemble import assemble
from scenes import LAVAL, SCENES, changed
from systems import TWO_PI

SPEED = 30.0
ROLLING = changed(
    rotor={"eccentricity": 0.0},
    contact={"diameter": 4e-3, "friction": 0.15},
    drive={"speed": SPEED, "duration": 1.0},
    solver={"rtol": 1e-8},
)


def system_of(content):
    return assemble(rsc.Scene.from_dict(content))


def shapes_of(system, roll, Omega):
    """Rotor and stator of a Roll by the functions for whirls that slide, with the traction in the place of mu."""
    return whirl_shapes(system.with_friction(roll.traction), roll.Psi, roll.normal_force, Omega)


@pytest.mark.parametrize("content", [ROLLING, changed(SCENES["gyroscopic disk"], contact={"diameter": 4e-3})])
@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_every_equation_holds(content, speed):
    system, Omega = system_of(content), TWO_PI * speed
    rolls = rolling_whirls(system, Omega)
    assert rolls
    for roll in rolls:
        assert roll.Psi * speed < 0.0 < roll.normal_force and abs(roll.traction) <= system.law.friction
        H = complex(receptance(system, roll.Psi, Omega))
        assert abs(((1.0 + 1j * roll.traction) * H).imag) < 1e-12 * abs(H)
        with_traction = system.with_friction(roll.traction)
        assert normal_force(with_traction, roll.Psi, Omega) == pytest.approx(roll.normal_force, rel=1e-9)
        distance = law_of(system).distance(roll.normal_force)
        slip = 0.5 * Omega * system.law.diameter + roll.Psi * distance
        creep = system.law.slip_velocity * roll.traction / system.law.friction
        assert slip == pytest.approx(creep, abs=1e-9 * abs(Omega) * system.law.diameter)
        rotor, stator = shapes_of(system, roll, Omega)
        assert rotor @ system.rotor.contact - stator @ system.stator.contact == pytest.approx(distance, rel=1e-9)
        assert abs(rotor @ system.rotor.contact) == pytest.approx(roll.rotor_amplitude, rel=1e-12)


def test_a_hard_contact_without_creep_rolls_at_the_surface_speed_over_the_gap():
    hard = systems.changed(system_of(ROLLING), contact_stiffness=1e14, slip_velocity=1e-12)
    for diameter in (2.5e-3, 3e-3):  # -37.5 and -45 Hz, between the whirls that slide at -34.6 and -57.8 Hz
        system = systems.changed(hard, diameter=diameter)
        (roll,) = rolling_whirls(system, TWO_PI * SPEED)
        assert roll.Psi == pytest.approx(-0.5 * TWO_PI * SPEED * diameter / system.contact.gap, rel=1e-6)


@pytest.mark.parametrize("values", [{"diameter": None}, {"friction": 0.0}])
def test_without_a_diameter_or_friction_nothing_rolls(values):
    system = system_of(ROLLING)
    assert rolling_whirls(systems.changed(system, **values), TWO_PI * SPEED) == [] == rolling_whirls(system, 0.0)
    assert len(rolling_whirls(system, TWO_PI * SPEED)) == 1


def started(content, speed):
    """The scene started on its only whirl that rolls, and that Roll."""
    system, Omega = system_of(content), TWO_PI * speed
    (roll,) = rolling_whirls(system, Omega)
    start = {"allow_penetration": True}
    for name, shape in zip(("rotor", "stator"), shapes_of(system, roll, Omega), strict=True):
        for key, values in ((name, shape), (f"{name}_velocity", 1j * roll.Psi * shape)):
            start[key] = [[value.real, value.imag] for value in values.tolist()]
    return rsc.Scene.from_dict(changed(content, start=start)), roll


def test_the_simulator_rolls_as_predicted():
    scene, roll = started(ROLLING, SPEED)
    result = rsc.simulate(scene)
    late = result.time > 0.5
    r, time = result.rotor[late, 0], result.time[late]
    angle = np.unwrap(np.angle(r))
    assert (angle[-1] - angle[0]) / (time[-1] - time[0]) == pytest.approx(roll.Psi, rel=1e-6)
    assert np.abs(r) == pytest.approx(roll.rotor_amplitude, rel=1e-5)
    assert result.normal_force[late] == pytest.approx(roll.normal_force, rel=1e-5)
    assert result.friction_force[late] / result.normal_force[late] == pytest.approx(roll.traction, rel=1e-4)


def test_a_run_up_rolls_while_friction_is_enough_and_then_slides():
    content = changed(
        ROLLING, rotor={"eccentricity": 1e-5}, solver={"rtol": 1e-6}, drive={"speed": [SPEED - 2.0, SPEED + 4.0], "duration": 6.0}
    )
    scene, _ = started(content, SPEED - 2.0)
    system, report = assemble(scene), rsc.check(scene)
    rows = [row for row in report.rows if row.quantity == "whirl frequency"]
    assert {row.verdict for row in report.rows if row.quantity != "synchronous line"} == {"agrees"}
    rolls = [row.branch == "roll" for row in rows]
    last = rolls.index(False)
    assert 3 < last < len(rows) - 3 and rolls == [i < last for i in range(len(rows))]
    assert {row.branch for row in rows[last:]} == {"A"}
    # the window in which it begins to slide may be on either side
    assert rolling_whirls(system, TWO_PI * rows[last - 2].speed) != []
    assert rolling_whirls(system, TWO_PI * rows[last + 1].speed) == []
    assert report.features.rolling[: last - 1].min() == pytest.approx(1.0) and report.features.rolling[last + 1 :].max() == 0.0
    assert report.agreement.startswith("frequency agrees within 0.5 % in 15 of 15 windows with") and report.transitions == []


def test_the_command_tells_what_rolls(capsys, tmp_path):
    path = tmp_path / "scene.toml"
    scene = rsc.Scene.from_dict(changed(ROLLING, start={"rest": True}))
    path.write_text(scene.to_toml())
    assert main(["predict", str(path), "--speed", f"{SPEED:g}"]) == 0
    (roll,) = rolling_whirls(assemble(scene), TWO_PI * SPEED)
    assert f"rolling at {roll.Psi / TWO_PI:.4f} Hz" in capsys.readouterr().out
    path.write_text(rsc.Scene.from_dict(changed(LAVAL, start={"rest": True})).to_toml())
    assert main(["predict", str(path), "--speed", f"{SPEED:g}"]) == 0
    assert "rolling" not in capsys.readouterr().out
