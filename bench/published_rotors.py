"""Rotors that others published, and the frequencies and damping that they printed, beside `rsc modes`.

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
VM254: the rotor of N&M on bearings with cross-coupled stiffness, whirls in rpm at 100,000 rpm, as the verification case VM254 of
    Ansys keeps them (vm254.dat beside vm247.dat).
SDLL124, SDLL125, SDLL128: test cases of code_aster (github.com/ralic/Code_Aster, astest/sdll124a.comm and so on, with meshes),
    Hz and damping ratios. SDLL124 is the rotor of L&F as the case has it; it and SDLL125 have the figures of another source
    (VALE_REFE), SDLL128 those of code_aster itself (VALE_CALC) with coefficients half-way between those of 5,000 and 6,500 rpm.
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
    """A rotor with what was printed: (rotor speed in Hz, frequency in Hz, how it was printed, damping ratio or NaN)."""

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


def nelson_mcvaugh_shaft(bearing, source):
    """Model of 18 elements, a disc, two bearings without damping; shear is left out, as there.

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
    bearings = [Bearing(node, bearing, (0.0, 0.0, 0.0, 0.0)) for node in (10, 14)]
    return shaft(places, inner, outer, material, [(4, 1.401, 0.00136, 0.002)], bearings, source)


def nelson_mcvaugh():
    """Isotropic bearings: whirls that turn at the rotor speed or four times as fast."""
    model = nelson_mcvaugh_shaft((4.378e7, 0.0, 0.0, 4.378e7), "Nelson and McVaugh 1976")
    rpm = {1: (-15470.0, 17159.0, -46612.0, 49983.0, -64752.0, 96457.0),
           4: (-16060.0, 16481.0, -47957.0, 48800.0, -72737.0, 80649.0)}  # fmt: skip
    rows = [(abs(whirl) / ratio * RPM, whirl * RPM, f"{abs(whirl):.0f} rpm", np.nan) for ratio in rpm for whirl in rpm[ratio]]
    return Published("N&M", model, rows)


def lalanne_ferraris():
    """13 elements of 0.1 m, three discs, bearings that differ in their directions and have damping."""
    material, nodes = Material(2e11, 2e11 / 2.6, 7800.0), 0.1 * np.arange(14)
    discs = [disc(2, 0.1, 0.24, 0.05, 7800.0), disc(5, 0.1, 0.4, 0.05, 7800.0), disc(10, 0.1, 0.4, 0.06, 7800.0)]
    bearings = [Bearing(node, (5e7, 0.0, 0.0, 7e7), (5e2, 0.0, 0.0, 7e2)) for node in (0, 13)]
    model = shaft(nodes, np.zeros(13), np.full(13, 0.1), material, discs, bearings, "Lalanne and Ferraris 1998")
    frequencies = (55.408, 67.209, 157.90, 193.71, 249.90, 407.62, 446.62, 715.03, 622.65, 1093.0)
    return Published("L&F", model, [(25000.0 * RPM, value, f"{value:.5g} Hz", np.nan) for value in frequencies])


def vm254():
    """The same shaft on bearings whose directions are coupled."""
    model = nelson_mcvaugh_shaft((3.503e7, -8.756e6, -8.756e6, 3.503e7), "VM254")
    return Published("VM254", model, [(1e5 * RPM, rpm * RPM, f"{rpm:.0f} rpm", np.nan) for rpm in (10747, 19665, 39077, 47549)])


def aster(name, model, printed):
    """A case of code_aster: rpm -> pairs of frequency in Hz and damping ratio."""
    return Published(name, model, [(rpm * RPM, f, f"{f:.6g} Hz", ratio) for rpm, pairs in printed.items() for f, ratio in pairs])


STEEL = Material(2e11, 2e11 / 2.6, 7800.0)


def sdll124():
    """The shaft of L&F with discs as the case has them."""
    discs = [(2, 14.58013, 0.06463858, 0.1232021), (5, 45.94579, 0.4977461, 0.9763481), (10, 55.13495, 0.6023493, 1.171618)]
    bearings = [Bearing(node, (7e7, 0.0, 0.0, 5e7), (7e2, 0.0, 0.0, 5e2)) for node in (0, 13)]
    model = shaft(0.1 * np.arange(14), np.zeros(13), np.full(13, 0.1), STEEL, discs, bearings, "SDLL124")
    return aster("SDLL124", model, {
        0: ((60.6148, 5.0328e-4), (63.026, 3.9882e-4), (169.49, 3.1232e-3), (185.563, 2.8533e-3)),
        30000: ((54.112, 2.6624e-4), (68.122, 6.5256e-4), (154.65, 3.0442e-3), (196.0, 2.7612e-3)),
    })  # fmt: skip


def sdll125():
    """A hollow shaft with two overhung discs; bearings with cross-coupling, unstable at 60,000 rpm."""
    places = [0.0, 0.0175, 0.035, 0.045, 0.07, 0.1025, 0.135, 0.1675, 0.2, 0.225, 0.25, 0.275, 0.3]
    outer = np.array([0.04, 0.04, 0.07, *[0.04] * 7, 0.07, 0.07])
    inner = np.array([0.0, 0.0, 0.01, *[0.01] * 7, 0.01, 0.01])
    bearings = [Bearing(4, (1e8, -6e7, -1e7, 8e7), (1.2e4, -3e3, -3e3, 8e3)),
                Bearing(8, (7e7, -4e7, -2e6, 5e7), (8e3, -1.5e3, -1.5e3, 6e3))]  # fmt: skip
    discs = [(0, 3.5, 3.5e-3, 7e-3), (12, 3.0, 3e-3, 6e-3)]
    return aster("SDLL125", shaft(np.array(places), inner, outer, STEEL, discs, bearings, "SDLL125"), {
        0: ((216.21, 0.047697), (263.521, 0.078851), (383.21, 0.050144), (439.64, 0.060227)),
        60000: ((185.37, -0.051713), (296.02, 0.15571), (324.72, 1.5749e-3), (472.54, 0.15968)),
    })  # fmt: skip


def sdll128():
    """A stepped shaft with three discs, the coefficients of its bearings as they are at 5,750 rpm."""
    places = np.array([0, 20, 55, 90, 115, 140, 170, *range(200, 601, 50), 630, 670, 710, 750, 775, 800], dtype=float)
    outer = np.array([*[0.16] * 6, *[0.09] * 9, *[0.06] * 6])
    inner = np.array([*[0.12] * 5, *[0.0] * 16])
    first = Bearing(7, (9.5e7, 1.2e5, -1.2e5, 4.5e8), (1.4e5, -100.0, 100.0, 3.9e5))
    second = Bearing(16, (6.5e7, 1.05e5, -1.05e5, 1.45e8), (1.1e5, -100.0, 100.0, 1.7e5))
    discs = [(1, 20.0, 0.2, 0.4), (3, 17.0, 0.17, 0.34), (19, 10.0, 0.015, 0.03)]
    return aster("SDLL128", shaft(1e-3 * places, inner, outer, STEEL, discs, [first, second], "SDLL128"), {
        5750: ((137.2238, 0.525418), (219.8956, 0.141407), (319.1617, 0.196733), (380.5201, 0.192999), (414.7641, 0.651724),
               (1489.107, 0.151458), (1548.636, 0.122607), (1865.908, 0.383738)),
    })  # fmt: skip


def friswell(name, discs, bearings, printed):
    """A shaft of 1.5 m and 50 mm, six elements."""
    material = Material(211e9, 81.2e9, 7810.0)
    discs = [disc(node, 0.05, outer, 0.07, 7810.0) for node, outer in discs]
    model = shaft(np.linspace(0.0, 1.5, 7), np.zeros(6), np.full(6, 0.05), material, discs, bearings, name)
    rows = [(rpm * RPM, value * RAD, f"{value:.5g} rad/s", np.nan) for rpm, values in printed.items() for value in values]
    return Published(name, model, rows)


def rotors():
    """All of them."""
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
        vm254(), sdll124(), sdll125(), sdll128(),
    ]  # fmt: skip


def compared(rotor):
    """[rotor speed in Hz, as printed, printed frequency and that of `rsc modes` in Hz, the same of the damping ratios], the modes
    by the distance of their eigenvalues, or frequencies where no damping was printed; signs of frequencies left out."""
    rows = []
    for speed, printed, words, ratio in rotor.printed:
        own = [(abs(mode.frequency), ratio_of(mode)) for mode in slowest_modes(rotor.model, speed, 40)]
        wanted = abs(printed), ratio

        def away(mode, wanted=wanted):
            return abs(mode[0] - wanted[0]) + (0.0 if np.isnan(wanted[1]) else abs(mode[1] - wanted[1]) * wanted[0])

        rows.append((speed, words, *(part for pair in zip(wanted, min(own, key=away), strict=True) for part in pair)))
    return rows


def ratio_of(mode):
    """Damping ratio, -growth/|lambda|."""
    size = abs(complex(mode.growth_rate, 2.0 * np.pi * mode.frequency))
    return -mode.growth_rate / size if size else 0.0


def table():
    """The table as Markdown."""
    head = "| rotor | rotor speed Hz | printed | Hz | `rsc modes` Hz | difference | printed damping ratio | `rsc modes` |"
    lines = [head, "|---|---|---|---|---|---|---|---|"]
    for rotor in rotors():
        for speed, words, printed, own, ratio, damped in compared(rotor):
            percent = 100.0 * (own / printed - 1.0)
            damping = "- | -" if np.isnan(ratio) else f"{ratio:.5g} | {damped:.5g}"
            lines.append(f"| {rotor.name} | {speed:.5g} | {words} | {printed:.6g} | {own:.6g} | {percent:+.3f} % | {damping} |")
    return "\n".join(lines)


def largest(rotor):
    """Largest relative difference of frequencies, and largest difference of damping ratios, between `rsc modes` and print."""
    rows = compared(rotor)
    ratios = [abs(damped - ratio) for *_, ratio, damped in rows if not np.isnan(ratio)]
    return max(abs(own / printed - 1.0) for _, _, printed, own, *_ in rows), max(ratios, default=0.0)


def main(write):
    """Print the table, or write it."""
    text = f"# Published rotors beside `rsc modes`\n\nWritten by `python bench/published_rotors.py --write`.\n\n{table()}\n"
    if write:
        RESULT.write_text(text)
    else:
        print(text)


if __name__ == "__main__":
    main("--write" in sys.argv[1:])
