"""Random machines for tests and bench of the reduction: a shaft with discs, bearings and seals, and a casing of masses."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rsc.machine.reduction.directions import Unequal
from rsc.machine.reduction.points import natural_frequencies
from rsc.system.body import Body

YOUNG, POISSON, DENSITY = 210e9, 0.3, 7850.0


class Machine(NamedTuple):
    """Rotor and stator with the band of whirls and the range of speeds, rad/s."""

    rotor: Body
    stator: Body
    band: tuple
    speeds: tuple


def beam(length, diameter):
    """Stiffness, mass and gyroscopic matrix (4, 4) of a Timoshenko element; coordinates (deflection, slope) at both ends.

    The mass is the consistent one of the same element without shear, with rotary inertia.
    """
    area, inertia, h = np.pi * diameter**2 / 4.0, np.pi * diameter**4 / 64.0, length
    shear = 12.0 * YOUNG * inertia * 2.0 * (1.0 + POISSON) / (0.886 * YOUNG * area * h**2)
    turn = np.diag([1.0, h, 1.0, h])
    bending = np.array([[12, 6, -12, 6], [6, 4 + shear, -6, 2 - shear], [-12, -6, 12, -6], [6, 2 - shear, -6, 4 + shear]])
    moving = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420.0
    tilting = np.array([[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) / 30.0
    rotary = DENSITY * inertia / h * (turn @ tilting @ turn)
    stiffness = YOUNG * inertia / (1.0 + shear) / h**3 * (turn @ bending @ turn)
    return stiffness, DENSITY * area * h * (turn @ moving @ turn) + rotary, 2.0 * rotary


def shaft(rng, n_nodes, skew):
    """A stepped shaft of 2 n_nodes coordinates with discs, two bearings and, with skew terms, seals; random in all of it."""
    n, base = 2 * n_nodes, 10.0 ** rng.uniform(-1.6, -0.8)
    stiffness, mass, gyroscopic = (np.zeros((n, n)) for _ in range(3))
    lengths = rng.uniform(0.5, 1.5, n_nodes - 1) * rng.uniform(12.0, 35.0) * base / n_nodes
    for i, length in enumerate(lengths):
        rows = slice(2 * i, 2 * i + 4)
        for whole, part in zip((stiffness, mass, gyroscopic), beam(length, base * rng.uniform(0.7, 1.4)), strict=True):
            whole[rows, rows] += part
    damping = 10.0 ** rng.uniform(-1.0, 1.0) * mass + 10.0 ** rng.uniform(-6.5, -5.0) * stiffness
    for node in rng.choice(n_nodes, rng.integers(1, 5), replace=False):
        disc, radius = DENSITY * np.pi * base**3 * 10.0 ** rng.uniform(0.0, 1.3), base * rng.uniform(1.0, 4.0)
        mass[2 * node, 2 * node] += disc
        mass[2 * node + 1, 2 * node + 1] += 0.27 * disc * radius**2
        gyroscopic[2 * node + 1, 2 * node + 1] += 0.5 * disc * radius**2
    flexural = 48.0 * YOUNG * np.pi * base**4 / 64.0 / lengths.sum() ** 3
    critical = np.sqrt(flexural / mass[::2, ::2].sum())
    for node in (rng.integers(0, n_nodes // 4), rng.integers(3 * n_nodes // 4, n_nodes)):
        stiffness[2 * node, 2 * node] += flexural * 10.0 ** rng.uniform(-0.5, 2.0)
        damping[2 * node, 2 * node] += flexural / critical * 10.0 ** rng.uniform(-2.0, 0.5)
    skewed = {}
    if skew:
        skewed = {"skew_stiffness": np.zeros((n, n)), "skew_damping": np.zeros((n, n))}
        for node in rng.choice(n_nodes, 2, replace=False):
            skewed["skew_stiffness"][2 * node, 2 * node] = flexural * 10.0 ** rng.uniform(-2.0, -0.5)
            skewed["skew_damping"][2 * node, 2 * node] = flexural / critical * 10.0 ** rng.uniform(-3.0, -1.5)
    unbalance = np.zeros((n, 1), complex)
    for node in rng.choice(n_nodes, rng.integers(1, 3), replace=False):
        unbalance[2 * node] = 1e-4 * mass[2 * node, 2 * node] * np.exp(2j * np.pi * rng.uniform())
    weight = np.tile([9.81, 0.0], n_nodes) @ mass
    contact, observers = np.zeros(n), np.zeros((1, n))
    contact[2 * rng.integers(0, n_nodes)] = observers[0, 2 * rng.integers(0, n_nodes)] = 1.0
    return Body(mass, damping, stiffness, contact, gyroscopic, unbalance=unbalance, load=weight, observers=observers, **skewed)


def on_unequal_bearings(rng, rotor):
    """A rotor with two more bearings, stiffer in one direction than in the other: the mean `Body` and its `Unequal`.

    Up to 98 % of their mean stiffness and 90 % of their mean damping act on the conjugate, along y and z or, every other time,
    turned.
    """
    n, static = rotor.n_coordinates, np.linalg.inv(rotor.stiffness)
    stiffness, damping = rotor.stiffness.copy(), rotor.damping.copy()
    unequal = Unequal(np.zeros((n, n), complex), np.zeros((n, n), complex))
    for i in 2 * rng.choice(n // 2, 2, replace=False):
        k = 10.0 ** rng.uniform(-2.0, 1.5) / static[i, i]
        c, turn = k * 10.0 ** rng.uniform(-5.0, -3.5), np.exp(2j * np.pi * rng.uniform() * rng.integers(0, 2))
        stiffness[i, i] += k
        damping[i, i] += c
        unequal.stiffness[i, i], unequal.damping[i, i] = k * turn * rng.uniform(0.05, 0.98), c * turn * rng.uniform(0.0, 0.9)
    return replace(rotor, stiffness=stiffness, damping=damping), unequal


def rings(rng, n, mass, Psi):
    """A stator of n masses in a chain from the foundation to the ring that the rotor touches, with damping."""
    masses = mass * 10.0 ** rng.uniform(-1.0, 1.0, n)
    springs = mass * Psi**2 * 10.0 ** rng.uniform(-0.5, 1.5, n)
    stiffness = np.diag(springs + np.append(springs[1:], 0.0)) - np.diag(springs[1:], 1) - np.diag(springs[1:], -1)
    damping = 10.0 ** rng.uniform(-3.0, -1.5) / Psi * stiffness + 0.01 * Psi * np.diag(masses)
    return Body(np.diag(masses), damping, stiffness, np.eye(n)[n - 1])


def random_machine(rng, least=10, most=40, skew=None):
    """A `Machine` whose rotor has 2 `least` to 2 `most` complex coordinates; every other one has skew terms unless told."""
    rotor = shaft(rng, int(rng.integers(least, most + 1)), bool(rng.integers(0, 2)) if skew is None else skew)
    natural = natural_frequencies(rotor, 0.0)
    natural = natural[natural > 0.0]
    stator = rings(rng, int(rng.integers(2, 13)), 0.2 * np.trace(rotor.mass[::2, ::2]), natural[1])
    reach = natural[int(rng.integers(2, 5))]
    return Machine(rotor, stator, (-1.2 * reach, 0.7 * reach), (0.0, float(natural[0] * rng.uniform(0.8, 2.5))))
