"""A casing of revolution as finite elements, whose motion with one wave around the circumference is what a rotor feels.

A flanged cylinder on a foundation, meshed in its meridian plane by bilinear elements with u_r, u_z and u_t at every node. In the
first harmonic u_r = a cos(theta), u_z = b cos(theta), u_t = c sin(theta) for motion in y, and a quarter further for motion in z:
both together are one complex amplitude each, so `casing` gives complex coordinates with real symmetric matrices.
"""

import numpy as np
import scipy.sparse

YOUNG, POISSON, DENSITY = 210e9, 0.3, 7850.0
RADIUS, WALL, LENGTH = 0.3, 0.02, 1.2  # m
FOUNDATION, RAYLEIGH = 4e8, (8.0, 2e-6)  # N/m at the flange; 1/s, s
_GAUSS = 1.0 / np.sqrt(3.0)


def _element(r, size):
    """Mass and stiffness (12, 12) of a rectangle (in r, in z) around the radius r; per node u_r, u_z, u_t, harmonic 1."""
    lame = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    shear = YOUNG / (2.0 * (1.0 + POISSON))
    law = np.diag([2.0 * shear] * 3 + [shear] * 3)
    law[:3, :3] += lame
    mass, stiffness = np.zeros((12, 12)), np.zeros((12, 12))
    for a in (-_GAUSS, _GAUSS):
        for b in (-_GAUSS, _GAUSS):
            signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
            shape = 0.25 * (1 + signs[:, 0] * a) * (1 + signs[:, 1] * b)
            by_r = 0.5 * signs[:, 0] * (1 + signs[:, 1] * b) / size[0]
            by_z = 0.5 * signs[:, 1] * (1 + signs[:, 0] * a) / size[1]
            place = r + 0.5 * a * size[0]
            strain = np.zeros((6, 12))
            strain[0, 0::3] = by_r  # rr
            strain[1, 1::3] = by_z  # zz
            strain[2, 0::3], strain[2, 2::3] = shape / place, shape / place  # tt = u_r/r + (1/r) d u_t/d theta
            strain[3, 0::3], strain[3, 1::3] = by_z, by_r  # rz
            strain[4, 0::3], strain[4, 2::3] = -shape / place, by_r - shape / place  # rt
            strain[5, 1::3], strain[5, 2::3] = -shape / place, by_z  # zt
            moved = np.zeros((3, 12))
            for i in range(3):
                moved[i, i::3] = shape
            weight = 0.25 * size[0] * size[1] * np.pi * place  # the mean of cos^2 around the circumference
            mass += weight * DENSITY * moved.T @ moved
            stiffness += weight * strain.T @ law @ strain
    return mass, stiffness


def casing(n_wall=40, n_length=416):
    """(mass, damping, stiffness) sparse and the contact row, 3 (n_wall + 1) (n_length + 1) complex coordinates."""
    across = n_wall + 1
    size = (WALL / n_wall, LENGTH / n_length)
    row, column, values = [], [], []
    first = across * np.arange(n_length)
    for i in range(n_wall):
        parts = _element(RADIUS + (i + 0.5) * size[0], size)
        nodes = first[:, None] + i + np.array([0, 1, across + 1, across])
        places = (3 * nodes[:, :, None] + np.arange(3)).reshape(n_length, 12)
        row.append(np.repeat(places, 12, axis=1).ravel())
        column.append(np.tile(places, (1, 12)).ravel())
        values.append([np.tile(part.ravel(), n_length) for part in parts])
    row, column = np.concatenate(row), np.concatenate(column)
    n = 3 * across * (n_length + 1)
    mass, stiffness = (
        scipy.sparse.csc_array((np.concatenate([value[k] for value in values]), (row, column)), shape=(n, n)) for k in (0, 1)
    )
    flange = np.zeros(n)
    flange[: 3 * across] = FOUNDATION / across  # all of the first cross-section
    stiffness = scipy.sparse.csc_array(stiffness + scipy.sparse.diags_array(flange))
    damping = RAYLEIGH[0] * mass + RAYLEIGH[1] * stiffness
    contact = np.zeros(n)
    node = across * (2 * n_length // 3)  # on the inner surface; its circle moves as a whole by (u_r - u_t)/2
    contact[3 * node], contact[3 * node + 2] = 0.5, -0.5
    return mass, damping, stiffness, contact
