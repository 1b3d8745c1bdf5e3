"""Five rotors that others published, and what they printed of them, beside `rsc modes`.

    python bench/published_rotors.py            prints the table
    python bench/published_rotors.py --write    writes it to bench/results/published_rotors.md

Beam elements with consistent mass, rotary inertia, gyroscopics and shear (Timoshenko) in one plane, which is all that complex
coordinates need; nothing but the model's file comes from here.

N&M: H. D. Nelson, J. M. McVaugh, The dynamics of rotor-bearing systems using finite elements, J. Eng. Ind. 98 (1976) 593: whirls
    in rpm that have the frequency of the rotation, or four times it, isotropic undamped bearings. Geometry and printed figures as
    the verification case VM247 of Ansys keeps them (github.com/ansys/pymapdl, ansys/mapdl/core/examples/verif/vm247.dat).
L&F: M. Lalanne, G. Ferraris, Rotordynamics Prediction in Engineering, 2nd ed., Wiley 1998, section 3: a shaft with three discs on
    two unequal damped bearings at 25,000 rpm, Hz. No public source was found beside which these figures could be read again.
F: M. I. Friswell et al., Dynamics of Rotating Machines, Cambridge 2010, examples 5.9.1, 5.9.2 and 5.9.9, which are examples of
    ROSS (its tests/test_examples.py keeps the printed figures), rad/s.
"""

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rsc.machine.imports.bearings import Bearing, with_bearings
from rsc.machine.model.model import DISPLACEMENT, TILT, Model
from rsc.machine.model.modes import slowest_modes

RESULT = Path(__file__).parent / "results" / "published_rotors.md"
RPM, RAD = 1.0 / 60.0, 1.0 / (2.0 * np.pi)


class Material(NamedTuple):
    """Pa, Pa (infinite: no shear), kg/m^3."""

    young: float
    shear: float
    density: float


class Published(NamedTuple):
    """A rotor with what was printed: (rotor speed in Hz, frequency in Hz, how it was printed)."""

    name: str
    model: Model
    printed: list


def element(length, inner, outer, material):
    """Mass, stiffness and gyroscopic matrix of a beam element in one plane, coordinates (deflection, slope) at both ends.

    The deflection w(s) is a cubic; its shear angle, -phi length^2/12 times the third derivative of w, is constant, and a
    cross-section has the slope of w less that. Four Gauss points integrate the polynomials exactly.
    """
    area, inertia = np.pi / 4.0 * (outer**2 - inner**2), np.pi / 64.0 * (outer**4 - inner**4)
    share = inner / outer
    nu = 0.5 * material.young / material.shear - 1.0 if np.isfinite(material.shear) else 0.0
    kappa = 6.0 * (1.0 + nu) * (1.0 + share**2) ** 2 / ((7.0 + 6.0 * nu) * (1.0 + share**2) ** 2 + (20.0 + 12.0 * nu) * share**2)
    phi = 12.0 * material.young * inertia / (kappa * material.shear * area * length**2)
    mass, stiffness, turning = (np.zeros((4, 4)) for _ in range(3))
    points, weights = np.polynomial.legendre.leggauss(4)
    sheared = np.array([0.0, 0.0, 0.0, -0.5 * phi * length**2])

    def of_powers(s):
        """Rows of deflection, slope of the cross-section and its change, for the coefficients of 1, s, s^2, s^3."""
        return np.array([[1.0, s, s**2, s**3], [0.0, 1.0, 2.0 * s, 3.0 * s**2] - sheared, [0.0, 0.0, 2.0, 6.0 * s]])

    shapes = np.linalg.inv(np.vstack([of_powers(0.0)[:2], of_powers(length)[:2]]))  # coefficients of every end coordinate
    angle = sheared @ shapes
    for point, weight in zip(points, weights, strict=True):
        ds = 0.5 * length * weight
        w, psi, bend = of_powers(0.5 * length * (1.0 + point)) @ shapes
        mass += ds * material.density * (area * np.outer(w, w) + inertia * np.outer(psi, psi))
        turning += ds * material.density * 2.0 * inertia * np.outer(psi, psi)
        stiffness += ds * material.young * inertia * np.outer(bend, bend)
        if phi > 0.0:
            stiffness += ds * kappa * material.shear * area * np.outer(angle, angle)
    return mass, stiffness, turning


def shaft(places, inner, outer, material, discs, bearings, source):
    """Model of a shaft: places of its nodes in m, diameters of the elements, discs (node, mass, diametral, polar inertia)."""
    n = len(places)
    mass, stiffness, turning = (np.zeros((2 * n, 2 * n)) for _ in range(3))
    for i, parts in enumerate(zip(np.diff(places), inner, outer, strict=True)):
        rows = slice(2 * i, 2 * i + 4)
        for whole, part in zip((mass, stiffness, turning), element(*parts, material), strict=True):
            whole[rows, rows] += part
    for node, weight, diametral, polar in discs:
        mass[2 * node, 2 * node] += weight
        mass[2 * node + 1, 2 * node + 1] += diametral
        turning[2 * node + 1, 2 * node + 1] += polar
    bare = Model(
        source=source, node=np.repeat(np.arange(n), 2), kind=np.array([DISPLACEMENT, TILT] * n), mass=mass, damping=0.0 * mass,
        gyroscopic=turning, stiffness=stiffness, position=dict(enumerate(map(float, places))), free=True,
    )  # fmt: skip
    return with_bearings(bare, bearings)


def disc(node, inner, outer, width, density):
    """(node, mass, diametral, polar inertia) of a solid disc on a shaft."""
    weight = density * np.pi / 4.0 * width * (outer**2 - inner**2)
    polar = weight / 8.0 * (outer**2 + inner**2)
    return node, weight, 0.5 * polar + weight * width**2 / 12.0, polar


def alike(node, stiffness, damping=0.0):
    """A bearing that is the same in every direction."""
    return Bearing(node, (stiffness, 0.0, 0.0, stiffness), (damping, 0.0, 0.0, damping))


def nelson_mcvaugh():
    """18 elements, a disc, two isotropic bearings without damping; shear is left out, as there.

    Lengths and diameters are known to 0.1 mm. Who repeats the paper's table gives its end as 35.5 (VM247) or 35.81 cm; with the
    latter the second pair lies 1.5 % lower.
    """
    places = 0.01 * np.array([0.0, 1.27, 5.08, 7.62, 8.89, 10.16, 10.67, 11.43, 12.70, 13.46, 16.51, 19.05, 22.86, 26.67, 28.70,
                              30.48, 31.50, 34.54, 35.50])  # fmt: skip
    outer = 0.02 * np.array([0.51, 1.02, 0.76, 2.03, 2.03, 3.30, 3.30, 2.54, 2.54, 1.27, 1.27, 1.52, 1.52, 1.27, 1.27, 3.81, 2.03,
                             2.03])  # fmt: skip
    inner = np.zeros(18)
    inner[[6, 7, 17]] = 0.02 * np.array([1.52, 1.78, 1.52])
    material = Material(2.078e11, np.inf, 7806.0)
    bearings = [alike(10, 4.378e7), alike(14, 4.378e7)]
    model = shaft(places, inner, outer, material, [(4, 1.401, 0.00136, 0.002)], bearings, "Nelson and McVaugh 1976")
    rpm = {1: (-15470.0, 17159.0, -46612.0, 49983.0, -64752.0, 96457.0),
           4: (-16060.0, 16481.0, -47957.0, 48800.0, -72737.0, 80649.0)}  # fmt: skip
    rows = [(abs(whirl) / ratio * RPM, whirl * RPM, f"{abs(whirl):.0f} rpm") for ratio in rpm for whirl in rpm[ratio]]
    return Published("N&M", model, rows)


def lalanne_ferraris():
    """13 elements of 0.1 m, three discs, bearings that differ in their directions and have damping."""
    material, nodes = Material(2e11, 2e11 / 2.6, 7800.0), 0.1 * np.arange(14)
    discs = [disc(2, 0.1, 0.24, 0.05, 7800.0), disc(5, 0.1, 0.4, 0.05, 7800.0), disc(10, 0.1, 0.4, 0.06, 7800.0)]
    bearings = [Bearing(node, (5e7, 0.0, 0.0, 7e7), (5e2, 0.0, 0.0, 7e2)) for node in (0, 13)]
    model = shaft(nodes, np.zeros(13), np.full(13, 0.1), material, discs, bearings, "Lalanne and Ferraris 1998")
    frequencies = (55.408, 67.209, 157.90, 193.71, 249.90, 407.62, 446.62, 715.03, 622.65, 1093.0)
    return Published("L&F", model, [(25000.0 * RPM, value, f"{value:.5g} Hz") for value in frequencies])


def friswell(name, discs, bearings, printed):
    """A shaft of 1.5 m and 50 mm, six elements."""
    material = Material(211e9, 81.2e9, 7810.0)
    discs = [disc(node, 0.05, outer, 0.07, 7810.0) for node, outer in discs]
    model = shaft(np.linspace(0.0, 1.5, 7), np.zeros(6), np.full(6, 0.05), material, discs, bearings, name)
    rows = [(rpm * RPM, value * RAD, f"{value:.5g} rad/s") for rpm, values in printed.items() for value in values]
    return Published(name, model, rows)


def rotors():
    """All five."""
    two_discs = [(2, 0.28), (4, 0.35)]
    unequal = [Bearing(node, (1e6, 0.0, 0.0, 8e5)) for node in (0, 6)]
    return [
        nelson_mcvaugh(),
        lalanne_ferraris(),
        friswell("F 5.9.1", two_discs, [alike(0, 1e6), alike(6, 1e6)],
                 {0: (86.66, 274.31, 716.78), 4000: (85.39, 87.80, 251.78, 294.71, 600.18)}),
        friswell("F 5.9.2", two_discs, unequal,
                 {0: (82.65, 86.66, 254.52, 274.31, 679.49), 4000: (82.33, 86.86, 239.64, 287.25, 583.49)}),
        friswell("F 5.9.9", [(6, 0.35)], [alike(0, 1e7), alike(4, 1e7)],
                 {0: (90.14, 630.73, 830.43), 4000: (76.19, 103.91, 565.99, 634.23, 647.75, 1174.2)}),
    ]  # fmt: skip


def compared(rotor):
    """[rotor speed in Hz, as printed, printed frequency and the nearest of `rsc modes` in Hz], signs left out."""
    rows = []
    for speed, printed, words in rotor.printed:
        own = [mode.frequency for mode in slowest_modes(rotor.model, speed, 24)]
        nearest = min(own, key=lambda frequency: abs(abs(frequency) - abs(printed)))
        rows.append((speed, words, abs(printed), nearest))
    return rows


def table():
    """The table as Markdown."""
    lines = ["| rotor | rotor speed Hz | printed | Hz | `rsc modes` Hz | difference |", "|---|---|---|---|---|---|"]
    for rotor in rotors():
        for speed, words, printed, own in compared(rotor):
            percent = 100.0 * (abs(own) / printed - 1.0)
            lines.append(f"| {rotor.name} | {speed:.5g} | {words} | {printed:.6g} | {abs(own):.6g} | {percent:+.3f} % |")
    return "\n".join(lines)


def largest(rotor):
    """Largest relative difference between `rsc modes` and print."""
    return max(abs(abs(own) / printed - 1.0) for _, _, printed, own in compared(rotor))


def main(write):
    """Print the table, or write it."""
    text = f"# Five published rotors beside `rsc modes`\n\nWritten by `python bench/published_rotors.py --write`.\n\n{table()}\n"
    if write:
        RESULT.write_text(text)
    else:
        print(text)


if __name__ == "__main__":
    main("--write" in sys.argv[1:])
