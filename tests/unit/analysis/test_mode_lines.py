"""Modes followed over the rotor speed: uncoupled disks, written in coordinates that mix them."""

from types import SimpleNamespace

import numpy as np
import pytest

import rsc
from rsc.analysis.alone.free_vibration import vibrations_of
from rsc.analysis.alone.mode_lines import followed
from rsc.analysis.alone.modes import critical_speeds, modes_at
from rsc.show.pictures.modes import campbell
from rsc.system.body import Body
from scenes import LAVAL, changed
from systems import TWO_PI, random_system
from systems import changed as with_values

SPEEDS = np.linspace(0.0, 60.0, 5)
# m, c, k_y, k_z, g: a disk that precesses fast, one on unequal supports, one that is overdamped until it turns fast
DISKS = [(1.0, 3.0, 4e4, 4e4, 1.6), (2.0, 8.0, 9e4, 2.4e5, 0.9), (1.5, 620.0, 6e4, 6.2e4, 3.0)]


def rates(disk, speed):
    """Eigenvalues with a frequency > 0 of m y'' + c y' + Omega g z' + k_y y = 0, m z'' + c z' - Omega g y' + k_z z = 0."""
    m, c, k_y, k_z, g = disk
    turning = np.polymul([g * TWO_PI * speed, 0.0], [g * TWO_PI * speed, 0.0])
    roots = np.roots(np.polyadd(np.polymul([m, c, k_y], [m, c, k_z]), turning))
    return sorted(roots[roots.imag > 1e-3], key=lambda root: root.imag)


def mixed(rng):
    """Matrices of uncoupled disks, in coordinates that mix them."""
    m, c, k_y, k_z, g = map(np.diag, np.array(DISKS).T)
    mix = rng.standard_normal((3, 3)) + 2.0 * np.eye(3)
    parts = {"mass": m, "damping": c, "stiffness": 0.5 * (k_y + k_z), "anisotropic_stiffness": 0.5 * (k_y - k_z), "gyroscopic": g}
    return Body(**{name: mix.T @ part @ mix for name, part in parts.items()}, contact=rng.standard_normal(3))


@pytest.mark.parametrize("seed", range(4))
def test_lines_cross_others_and_keep_their_closed_form(seed):
    body = mixed(np.random.default_rng(seed))

    def at(speed):
        return sorted(vibrations_of(body, speed), key=lambda each: abs(complex(each.growth_rate, TWO_PI * each.frequency)))

    found = [at(speed) for speed in SPEEDS]
    lines = [
        [np.nan if i is None else abs(own[i].frequency) for own, i in zip(found, line, strict=True)]
        for line in followed(SPEEDS.tolist(), at, body.mass)
    ]
    wanted = []
    for disk in DISKS:
        own = [[root.imag / TWO_PI for root in rates(disk, speed)] for speed in SPEEDS]
        wanted += [[values[i] if i < len(values) else np.nan for values in own] for i in range(2)]
    assert sum(np.isnan(line).any() for line in wanted) == 2  # the overdamped disk
    assert len({tuple(np.argsort(column)) for column in np.array(wanted[:4]).T}) > 1  # and the others change places
    for line in wanted:
        assert any(np.allclose(line, own, rtol=1e-7, equal_nan=True) for own in lines), line
    assert len(lines) == len(wanted)


def test_between_distant_speeds_the_way_is_followed():
    """Supports whose stiff direction turns by 90 degrees: the softer mode stays the softer one, and ends as the stiffer began."""
    one = np.ones((1, 1))

    def at(speed):
        turned = 1e4 * np.exp(1j * np.pi * speed / 60.0) * one
        body = Body(mass=one, damping=2.0 * one, stiffness=4e4 * one, anisotropic_stiffness=turned, gyroscopic=0.0 * one,
                    contact=np.ones(1))  # fmt: skip
        return sorted(vibrations_of(body, speed), key=lambda each: each.frequency)

    assert followed([0.0, 60.0], at, one) == ((0, 0), (1, 1))


def test_at_standstill_straight_modes_are_positive_and_circular_ones_come_in_pairs():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        system = random_system(rng, least_stator=1)
        circular = np.sort([mode.frequency for mode in modes_at(system, 0.0).rotor])
        np.testing.assert_allclose(circular, -circular[::-1], rtol=1e-9, atol=1e-9)
        unequal = with_values(system, anisotropic_stiffness_r=0.1 * system.rotor.stiffness)  # no y moves a z
        modes = [mode for mode in modes_at(unequal, 0.0).rotor if mode.frequency]
        assert {mode.sense for mode in modes} == {"straight"} and all(mode.frequency > 0.0 for mode in modes)


def test_a_mode_that_begins_to_oscillate_is_no_critical_speed():
    m, c, k_y, k_z, g = slow = 1.5, 1500.0, 5e4, 7e4, 1.2
    one = np.ones((1, 1))
    body = Body(mass=m * one, damping=c * one, stiffness=0.5 * (k_y + k_z) * one, anisotropic_stiffness=0.5 * (k_y - k_z) * one,
                gyroscopic=g * one, contact=np.ones(1))  # fmt: skip
    assert [len(rates(slow, speed)) for speed in (0.0, 300.0)] == [0, 2]
    assert all(root.imag < TWO_PI * speed for speed in range(1, 300) for root in rates(slow, speed))
    assert not critical_speeds(SimpleNamespace(rotor=body, isotropic=False), 0.0, 300.0)


def test_a_picture_has_every_line_in_the_colours_of_its_senses():
    unequal = changed(LAVAL, rotor={"supports": [[0, [4e4, 0.0, 0.0, 1e3], [2.0, 0.0, 0.0, 2.0]]]})
    over = rsc.modes(rsc.Scene.from_dict(unequal), SPEEDS)
    drawn = campbell(over)[0]
    own = [trace for trace in drawn["data"] if trace["name"] == "straight mode"]
    for trace, line in zip(own, over.lines, strict=True):
        modes = [each.rotor[i] for each, i in zip(over, line, strict=True)]
        np.testing.assert_allclose(trace["y"], [abs(mode.frequency) for mode in modes], rtol=1e-4)
    assert drawn["layout"]["yaxis"]["range"][0] == 0.0
