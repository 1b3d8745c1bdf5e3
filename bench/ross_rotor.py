"""The rubbing two-disc rotor of data/reference/raw/ross_rub_rotor.toml: beam elements, 12 modes, rigid ring.

Shaft: Timoshenko beam elements with rotary inertia and gyroscopics (H. D. Nelson, J. Mech. Design 102 (1980) 793), Poisson's
ratio 0.3 (the data do not give one). Two things differ from the data. Both directions get the bearings' x values (the softer
ones), so that peers whose right-hand side has isotropic matrices take part. And with the data's unbalance a run-up stays 1 um
short of the gap, so the scene has 1.2 times as much and rubs from 19.07 s on.
"""

import tomllib
from pathlib import Path

import numpy as np
import scipy.linalg

from rsc.scene.scene import Scene

FILE = Path(__file__).parents[1] / "data" / "reference" / "raw" / "ross_rub_rotor.toml"
POISSON = 0.3
MODES = 12
DURATION = 20.0
MORE_UNBALANCE = 1.2


def element(length, data):
    """Mass, stiffness and gyroscopic matrix of one beam element in one plane, coordinates (deflection, slope) at both ends."""
    area, inertia = np.pi * data["outer_diameter"] ** 2 / 4.0, np.pi * data["outer_diameter"] ** 4 / 64.0
    young, density = data["youngs_modulus"], data["density"]
    kappa = 6.0 * (1.0 + POISSON) / (7.0 + 6.0 * POISSON)  # Cowper, full circle
    shear = 12.0 * young * inertia / (kappa * young / (2.0 * (1.0 + POISSON)) * area * length**2)
    ell, p = length, shear
    stiffness = np.array(
        [
            [12, 6 * ell, -12, 6 * ell],
            [6 * ell, (4 + p) * ell**2, -6 * ell, (2 - p) * ell**2],
            [-12, -6 * ell, 12, -6 * ell],
            [6 * ell, (2 - p) * ell**2, -6 * ell, (4 + p) * ell**2],
        ]
    )
    m1, m2 = 312 + 588 * p + 280 * p**2, (44 + 77 * p + 35 * p**2) * ell
    m3, m4 = 108 + 252 * p + 140 * p**2, -(26 + 63 * p + 35 * p**2) * ell
    m5, m6 = (8 + 14 * p + 7 * p**2) * ell**2, -(6 + 14 * p + 7 * p**2) * ell**2
    translation = np.array([[m1, m2, m3, m4], [m2, m5, -m4, m6], [m3, -m4, m1, -m2], [m4, m6, -m2, m5]])
    r1, r2 = 36.0, (3 - 15 * p) * ell
    r3, r4 = (4 + 5 * p + 10 * p**2) * ell**2, (-1 - 5 * p + 5 * p**2) * ell**2
    rotation = np.array([[r1, r2, -r1, r2], [r2, r3, -r2, r4], [-r1, -r2, r1, -r2], [r2, r4, -r2, r3]])
    rotation = density * inertia / (30.0 * ell * (1 + p) ** 2) * rotation
    mass = density * area * ell / (840.0 * (1 + p) ** 2) * translation + rotation
    # a slender shaft's polar inertia per length is twice the diametral one
    return mass, young * inertia / ((1 + p) * ell**3) * stiffness, 2.0 * rotation


def plane_matrices(data):
    """(mass, stiffness, damping, gyroscopic) of shaft and discs in one plane, without bearings; (2 nodes,) coordinates."""
    positions = np.array(data["shaft"]["node_positions_mm"]) * 1e-3
    size = 2 * positions.size
    mass, stiffness, gyroscopic = (np.zeros((size, size)) for _ in range(3))
    for i, length in enumerate(np.diff(positions)):
        rows = slice(2 * i, 2 * i + 4)
        for total, part in zip((mass, stiffness, gyroscopic), element(length, data["shaft"]), strict=True):
            total[rows, rows] += part
    damping = data["shaft"]["rayleigh_alpha"] * mass + data["shaft"]["rayleigh_beta"] * stiffness
    disc = data["disc"]
    for node in disc["nodes"]:
        mass[2 * node, 2 * node] += disc["mass"]
        mass[2 * node + 1, 2 * node + 1] += disc["diametral_inertia"]
        gyroscopic[2 * node + 1, 2 * node + 1] += disc["polar_inertia"]
    return mass, stiffness, damping, gyroscopic


def isotropic(data, modes=MODES):
    """Matrices of the rotor, x bearings all round; the first coordinate is the deflection at the rub, the others orthogonal.

    With mass-normalised modes Phi and the row phi of the rub, an orthogonal Q with first column phi/|phi| turns q into
    coordinates of equal mass 1/|phi|^2, of which the first is the deflection itself: nothing but the higher modes is left out.
    """
    mass, stiffness, damping, gyroscopic = plane_matrices(data)
    for bearing in data["bearing"]:
        i = 2 * bearing["node"]
        stiffness[i, i] += bearing["kxx"]
        damping[i, i] += bearing["cxx"]
    squares, shape = scipy.linalg.eigh(stiffness, mass, subset_by_index=[0, modes - 1])
    rub = 2 * data["rub"]["node"]
    phi = shape[rub]
    reference = 1.0 / (phi @ phi)
    turn, _ = np.linalg.qr(np.column_stack([phi, np.eye(modes)[:, : modes - 1]]))
    turn[:, 0] *= np.sign(turn[:, 0] @ phi)
    basis = np.sqrt(reference) * shape @ turn
    matrices = [basis.T @ part @ basis for part in (mass, stiffness, damping, gyroscopic)]
    matrices[0] = reference * np.eye(modes)
    force = basis[2 * data["unbalance"]["node"]] * data["unbalance"]["magnitude"] * MORE_UNBALANCE
    # the scene's eccentricity e stands for an unbalance M e, its coordinates being displacements
    eccentricity = np.linalg.solve(matrices[0], force)
    return matrices, eccentricity, np.sqrt(squares) / (2.0 * np.pi)


def ross_scene(modes=MODES):
    """The scene that rsc runs: run-up from 0 to 1200 rpm in 20 s from rest."""
    data = tomllib.loads(FILE.read_text())
    (mass, stiffness, damping, gyroscopic), eccentricity, _ = isotropic(data, modes)
    rub = data["rub"]
    return Scene.from_dict(
        {
            "title": "Two-disc finite-element rotor with rub, bearings of the x direction all round",
            "rotor": {
                "model": "matrices",
                "mass": mass.tolist(),
                "stiffness": (0.5 * (stiffness + stiffness.T)).tolist(),
                "damping": (0.5 * (damping + damping.T)).tolist(),
                "gyroscopic": (0.5 * (gyroscopic + gyroscopic.T)).tolist(),
                "tilt_coordinates": [],
                "eccentricity": eccentricity.tolist(),
            },
            "stator": {"model": "rigid"},
            "contact": {"gap": rub["gap"], "friction": rub["friction"], "stiffness": rub["stiffness"], "damping": rub["damping"]},
            "drive": {"speed": [0.0, data["unbalance"]["speed_rpm"] / 60.0], "duration": DURATION},
            "output": {"rate": 2000.0},
        }
    )
