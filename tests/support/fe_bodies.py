"""Finite-element bodies in real coordinates for tests of `rsc.machine`: a beam rotor and a casing of bars, SI units."""

import numpy as np
import scipy.sparse

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
YOUNG, DENSITY, OUTER = 2.1e11, 7850.0, 0.05


def beam_plane(length):
    """(mass, stiffness, mass of the rotation) of an Euler-Bernoulli element, coordinates (w, w') at both ends."""
    area, inertia = np.pi * OUTER**2 / 4.0, np.pi * OUTER**4 / 64.0
    s = np.array([1.0, length, 1.0, length])
    mass = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    stiffness = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    turning = np.array([[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]])
    scaled = np.outer(s, s)
    return (
        DENSITY * area * length / 420.0 * mass * scaled,
        YOUNG * inertia / length**3 * stiffness * scaled,
        DENSITY * inertia / (30.0 * length) * turning * scaled,
    )


def rotor(n_elements=6, total=1.0, bearing=((1e7, 1e7), (1e7, 1e7)), cross=0.0, disc=(8.0, 0.03, 0.05)):
    """Real matrices (6 coordinates a node, axial and torsional springs to ground) of a shaft with a disc in the middle.

    bearing: (kx, ky) at both ends; cross: kxy = -kyx there; disc: mass, diametral and polar inertia. Returns a dict of matrices,
    nodes and directions of the rows.
    """
    n = n_elements + 1
    size = 6 * n
    mass, damping, gyroscopic, stiffness = (np.zeros((size, size)) for _ in range(4))
    m, k, r = beam_plane(total / n_elements)
    for element in range(n_elements):
        # w = x has w' = ry, w = y has w' = -rx
        x = 6 * element + np.array([0, 4, 6, 10])
        y, sign = 6 * element + np.array([1, 3, 7, 9]), np.array([1.0, -1.0, 1.0, -1.0])
        flip = np.outer(sign, sign)
        mass[np.ix_(x, x)] += m + r
        mass[np.ix_(y, y)] += (m + r) * flip
        stiffness[np.ix_(x, x)] += k
        stiffness[np.ix_(y, y)] += k * flip
        # the polar inertia of a slender shaft is twice the diametral one
        gyroscopic[np.ix_(x, y)] += 2.0 * r * sign
        gyroscopic[np.ix_(y, x)] -= 2.0 * r * sign[:, None]
    for node in range(n):
        for k_axial, row in ((1e8, 6 * node + 2), (1e5, 6 * node + 5)):
            mass[row, row] += 1.0
            stiffness[row, row] += k_axial
    middle = 6 * (n_elements // 2)
    weight, diametral, polar = disc
    mass[[middle, middle + 1], [middle, middle + 1]] += weight
    mass[[middle + 3, middle + 4], [middle + 3, middle + 4]] += diametral
    gyroscopic[middle + 3, middle + 4] += polar
    gyroscopic[middle + 4, middle + 3] -= polar
    for (kx, ky), row in zip(bearing, (0, size - 6), strict=True):
        stiffness[row, row] += kx
        stiffness[row + 1, row + 1] += ky
        stiffness[row, row + 1] += cross
        stiffness[row + 1, row] -= cross
        damping[row, row] += 1e-5 * kx
        damping[row + 1, row + 1] += 1e-5 * ky
    matrices = {"mass": mass, "damping": damping, "gyroscopic": gyroscopic, "stiffness": stiffness}
    return matrices, np.repeat(np.arange(n), 6), np.array(DIRECTIONS * n)


def casing(soft=1.0):
    """A frame of bars with fourfold symmetry about z: a hub (node 0) hung in a ring that leans forward, on elastic feet.

    Bars run at an angle to the axis, so that x, y and z are coupled; soft: factor on one bar, which ends the symmetry.
    """
    ring = [(0.5 * np.cos(a), 0.5 * np.sin(a), 0.2) for a in np.pi / 2 * np.arange(4)]
    feet = [(0.9 * np.cos(a + 0.3), 0.9 * np.sin(a + 0.3), -0.1) for a in np.pi / 2 * np.arange(4)]
    points = np.array([(0.0, 0.0, 0.0), *ring])
    n = len(points)
    mass, stiffness = np.diag(np.repeat([3.0, *[5.0] * 4], 3)), np.zeros((3 * n, 3 * n))

    def bar(a, b, k):
        along = b - a
        along /= np.linalg.norm(along)
        return k * np.outer(along, along)

    for i in range(4):
        stretch = bar(points[0], points[1 + i], 2e7 * (soft if i == 0 else 1.0))
        beside = bar(points[1 + i], points[1 + (i + 1) % 4], 1e7)
        for (a, b), block in (((0, 1 + i), stretch), ((1 + i, 1 + (i + 1) % 4), beside)):
            for row, column, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                stiffness[3 * row : 3 * row + 3, 3 * column : 3 * column + 3] += sign * block
        place = slice(3 + 3 * i, 6 + 3 * i)
        stiffness[place, place] += bar(points[1 + i], np.array(feet[i]), 3e7) + 1e6 * np.eye(3)
    matrices = {"mass": mass, "damping": 1e-5 * stiffness, "stiffness": stiffness}
    return matrices, np.repeat(np.arange(n), 3), np.array(("x", "y", "z") * n)


def cylinder(n_axial, n_around, n_radial=3):
    """A thick cylinder as a lattice of bars, on elastic feet at both ends, its hub (the last node) hung in on both sides.

    Sparse matrices, three coordinates (x, y, z) a node, all rotations by a step around are symmetries. Steel as far as a lattice
    can be: stiffness and mass of a solid with elements of 20 mm.
    """
    grid = np.arange(n_axial * n_around * n_radial).reshape(n_axial, n_around, n_radial)
    axial, around, radial = np.unravel_index(grid.ravel(), grid.shape)
    angle, radius = 2.0 * np.pi * around / n_around, 0.3 + 0.02 * radial
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0.02 * axial])
    hub, middle = len(points), n_axial // 2
    points = np.vstack([points, [0.0, 0.0, 0.02 * middle]])
    bars = [(np.full(n_around, hub), grid[middle + side, :, 0]) for side in (-2, 2)]
    for steps in np.ndindex(2, 3, 3):
        da, dt, dr = steps[0], steps[1] - 1, steps[2] - 1
        if (da, dt, dr) <= (0, 0, 0):
            continue
        inner = slice(max(0, -dr), n_radial - max(0, dr))
        outer = slice(max(0, dr), n_radial - max(0, -dr))
        near, moved = grid[: n_axial - da, :, inner], np.roll(grid, -dt, axis=1)[da:, :, outer]
        bars.append((near.ravel(), moved.ravel()))
    a, b = (np.concatenate(ends) for ends in zip(*bars, strict=True))
    along = points[b] - points[a]
    length = np.linalg.norm(along, axis=1)
    blocks = (4e6 / length**3)[:, None, None] * along[:, :, None] * along[:, None, :]
    i, j = np.indices((3, 3))
    entries = []
    for rows, columns, sign in ((a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)):
        entries.append((3 * rows[:, None, None] + i, 3 * columns[:, None, None] + j, sign * blocks))
    rows, columns, values = (np.concatenate([part.ravel() for part in parts]) for parts in zip(*entries, strict=True))
    size = 3 * len(points)
    feet = np.zeros(size)
    feet[(3 * grid[[0, -1], :, -1].ravel()[:, None] + np.arange(3)).ravel()] = 1e8
    stiffness = scipy.sparse.coo_array((values, (rows, columns)), shape=(size, size)).tocsc()
    stiffness = (stiffness + scipy.sparse.diags_array(feet)).tocsc()
    mass = scipy.sparse.diags_array(np.full(size, 0.03)).tocsc()
    matrices = {"mass": mass, "damping": 1e-6 * stiffness, "stiffness": stiffness}
    return matrices, np.repeat(np.arange(len(points)), 3), np.array(("x", "y", "z") * len(points))
