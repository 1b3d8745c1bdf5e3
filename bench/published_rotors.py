"""Rotors that others published, and the frequencies and damping that they printed, beside `rsc modes`.

    python bench/published_rotors.py            prints the table
    python bench/published_rotors.py --write    writes it to bench/results/published_rotors.md

Each is typed as stations of a shaft (`rsc.machine.shaft`) with one element between two of them, as its authors had.

N&M: H. D. Nelson, J. M. McVaugh, The dynamics of rotor-bearing systems using finite elements, J. Eng. Ind. 98 (1976) 593: whirls
    in rpm that have the frequency of the rotation, or four times it, isotropic undamped bearings. Geometry and printed figures as
    the verification case VM247 of Ansys keeps them (github.com/ansys/pymapdl, ansys/mapdl/core/examples/verif/vm247.dat).
L&F: M. Lalanne, G. Ferraris, Rotordynamics Prediction in Engineering, 2nd ed., Wiley 1998, section 3: a shaft with three discs on
    two unequal damped bearings at 25,000 rpm, Hz. No public source was found beside which these figures could be read again.
F: M. I. Friswell et al., Dynamics of Rotating Machines, Cambridge 2010, examples 5.9.1, 5.9.2 and 5.9.9, which are examples of
    ROSS (its tests/test_examples.py keeps the printed figures), rad/s.
VM254: the rotor of N&M on bearings with cross-coupled stiffness, whirls in rpm at 100,000 rpm, as the verification case VM254 of
    Ansys keeps them (vm254.dat beside vm247.dat).
VM261: E. S. Zorzi, H. D. Nelson, Finite element simulation of rotor-bearing systems with internal damping, J. Eng. Power 99
    (1977) 71: forward critical speeds in rpm of a shaft whose damping turns with it, as the verification case of Ansys keeps them
    (src/ansys/mapdl/core/examples/verif/vm261.dat). Two decrements that the case reads from a figure are left out.
SDLL124, SDLL125, SDLL128, SDLL129: test cases of code_aster (github.com/ralic/Code_Aster, astest/sdll124a.comm and so on, with
    meshes), Hz and damping ratios. SDLL124 is the rotor of L&F as the case has it; it and SDLL125 have the figures of another
    source (VALE_REFE), SDLL128 those of code_aster itself (VALE_CALC) with coefficients half-way between those of 5,000 and 6,500
    rpm; SDLL129 is the same rotor at 0 and 20,000 rpm, again with those of another source.
"""

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rsc.machine.model.model import FiniteElementModel
from rsc.machine.model.modes import slowest_modes
from rsc.machine.shaft.assembly import model_of
from rsc.machine.shaft.parts import Disk, Material, Section, Shaft, Support, disk_inertias

RESULT = Path(__file__).parent / "results" / "published_rotors.md"
RPM, RAD = 1.0 / 60.0, 1.0 / (2.0 * np.pi)


class Published(NamedTuple):
    """A rotor with what was printed: (rotor speed in Hz, frequency in Hz, how it was printed, damping ratio or NaN)."""

    name: str
    model: FiniteElementModel
    printed: list


def typed(places, inner, outer, material, disks, supports, source, shear=True):
    """Model of a shaft by its stations, one element between two of them: places in m, diameters of the sections, disks (node,
    mass, polar, diametral inertia), supports (node, stiffness, damping), each in x and y, or xx, xy, yx and yy."""
    parts = zip(np.diff(places), inner, outer, strict=True)
    shaft = Shaft(
        tuple(Section(length, (wide, wide), (bore, bore), material) for length, bore, wide in parts),
        disks=tuple(Disk(places[node], *own) for node, *own in disks),
        supports=tuple(_support(places[node], *own) for node, *own in supports),
        shear=shear,
    )
    return model_of(shaft, shaft.stations, source)


def _support(place, stiffness, damping=(0.0, 0.0)):
    coefficients = [part for own in (stiffness, damping) for part in (own if len(own) == 4 else (own[0], 0.0, 0.0, own[1]))]
    return Support(place, np.zeros(1), np.array([coefficients]))


def disk(node, inner, outer, width, density):
    """(node, mass, polar, diametral inertia) of a solid disk on a shaft."""
    return node, *disk_inertias(outer, inner, width, density)


def nelson_mcvaugh_shaft(stiffness, source):
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
    supports = [(node, stiffness) for node in (10, 14)]
    steel = Material(7806.0, 2.078e11, 0.3)
    return typed(places, inner, outer, steel, [(4, 1.401, 0.002, 0.00136)], supports, source, shear=False)


def nelson_mcvaugh():
    """Isotropic bearings: whirls that turn at the rotor speed or four times as fast."""
    model = nelson_mcvaugh_shaft((4.378e7, 4.378e7), "Nelson and McVaugh 1976")
    rpm = {1: (-15470.0, 17159.0, -46612.0, 49983.0, -64752.0, 96457.0),
           4: (-16060.0, 16481.0, -47957.0, 48800.0, -72737.0, 80649.0)}  # fmt: skip
    rows = [(abs(whirl) / ratio * RPM, whirl * RPM, f"{abs(whirl):.0f} rpm", np.nan) for ratio in rpm for whirl in rpm[ratio]]
    return Published("N&M", model, rows)


def lalanne_ferraris():
    """13 elements of 0.1 m, three discs, bearings that differ in their directions and have damping."""
    material, nodes = Material(7800.0, 2e11, 0.3), 0.1 * np.arange(14)
    disks = [disk(2, 0.1, 0.24, 0.05, 7800.0), disk(5, 0.1, 0.4, 0.05, 7800.0), disk(10, 0.1, 0.4, 0.06, 7800.0)]
    supports = [(node, (5e7, 7e7), (5e2, 7e2)) for node in (0, 13)]
    model = typed(nodes, np.zeros(13), np.full(13, 0.1), material, disks, supports, "Lalanne and Ferraris 1998")
    frequencies = (55.408, 67.209, 157.90, 193.71, 249.90, 407.62, 446.62, 715.03, 622.65, 1093.0)
    return Published("L&F", model, [(25000.0 * RPM, value, f"{value:.5g} Hz", np.nan) for value in frequencies])


def vm254():
    """The same shaft on bearings whose directions are coupled."""
    model = nelson_mcvaugh_shaft((3.503e7, -8.756e6, -8.756e6, 3.503e7), "VM254")
    return Published("VM254", model, [(1e5 * RPM, rpm * RPM, f"{rpm:.0f} rpm", np.nan) for rpm in (10747, 19665, 39077, 47549)])


def aster(name, model, printed):
    """A case of code_aster: rpm -> pairs of frequency in Hz and damping ratio."""
    return Published(name, model, [(rpm * RPM, f, f"{f:.6g} Hz", ratio) for rpm, pairs in printed.items() for f, ratio in pairs])


STEEL = Material(7800.0, 2e11, 0.3)


def sdll124():
    """The shaft of L&F with discs as the case has them."""
    disks = [(2, 14.58013, 0.1232021, 0.06463858), (5, 45.94579, 0.9763481, 0.4977461), (10, 55.13495, 1.171618, 0.6023493)]
    supports = [(node, (7e7, 5e7), (7e2, 5e2)) for node in (0, 13)]
    model = typed(0.1 * np.arange(14), np.zeros(13), np.full(13, 0.1), STEEL, disks, supports, "SDLL124")
    return aster("SDLL124", model, {
        0: ((60.6148, 5.0328e-4), (63.026, 3.9882e-4), (169.49, 3.1232e-3), (185.563, 2.8533e-3)),
        30000: ((54.112, 2.6624e-4), (68.122, 6.5256e-4), (154.65, 3.0442e-3), (196.0, 2.7612e-3)),
    })  # fmt: skip


def sdll125():
    """A hollow shaft with two overhung discs; bearings with cross-coupling, unstable at 60,000 rpm."""
    places = [0.0, 0.0175, 0.035, 0.045, 0.07, 0.1025, 0.135, 0.1675, 0.2, 0.225, 0.25, 0.275, 0.3]
    outer = np.array([0.04, 0.04, 0.07, *[0.04] * 7, 0.07, 0.07])
    inner = np.array([0.0, 0.0, 0.01, *[0.01] * 7, 0.01, 0.01])
    supports = [(4, (1e8, -6e7, -1e7, 8e7), (1.2e4, -3e3, -3e3, 8e3)),
                (8, (7e7, -4e7, -2e6, 5e7), (8e3, -1.5e3, -1.5e3, 6e3))]  # fmt: skip
    disks = [(0, 3.5, 7e-3, 3.5e-3), (12, 3.0, 6e-3, 3e-3)]
    return aster("SDLL125", typed(np.array(places), inner, outer, STEEL, disks, supports, "SDLL125"), {
        0: ((216.21, 0.047697), (263.521, 0.078851), (383.21, 0.050144), (439.64, 0.060227)),
        60000: ((185.37, -0.051713), (296.02, 0.15571), (324.72, 1.5749e-3), (472.54, 0.15968)),
    })  # fmt: skip


def stepped(name, first, second):
    """The stepped shaft with three discs of SDLL128 and SDLL129 on its two bearings."""
    places = np.array([0, 20, 55, 90, 115, 140, 170, *range(200, 601, 50), 630, 670, 710, 750, 775, 800], dtype=float)
    outer = np.array([*[0.16] * 6, *[0.09] * 9, *[0.06] * 6])
    inner = np.array([*[0.12] * 5, *[0.0] * 16])
    disks = [(1, 20.0, 0.4, 0.2), (3, 17.0, 0.34, 0.17), (19, 10.0, 0.03, 0.015)]
    return typed(1e-3 * places, inner, outer, STEEL, disks, [(7, *first), (16, *second)], name)


def sdll128():
    """The coefficients of the bearings as they are at 5,750 rpm."""
    first = (9.5e7, 1.2e5, -1.2e5, 4.5e8), (1.4e5, -100.0, 100.0, 3.9e5)
    second = (6.5e7, 1.05e5, -1.05e5, 1.45e8), (1.1e5, -100.0, 100.0, 1.7e5)
    return aster("SDLL128", stepped("SDLL128", first, second), {
        5750: ((137.2238, 0.525418), (219.8956, 0.141407), (319.1617, 0.196733), (380.5201, 0.192999), (414.7641, 0.651724),
               (1489.107, 0.151458), (1548.636, 0.122607), (1865.908, 0.383738)),
    })  # fmt: skip


def sdll129():
    """The coefficients up to 5,000 rpm and from 14,000 rpm on."""
    slow = stepped("SDLL129", ((9e7, 9e4, -9e4, 5e8), (1.5e5, -100.0, 100.0, 4.5e5)),
                   ((6e7, 8e4, -8e4, 1.5e8), (1.2e5, -100.0, 100.0, 1.9e5)))  # fmt: skip
    fast = stepped("SDLL129", ((1.2e8, 7e5, -7e5, 3e8), (7e4, -400.0, 300.0, 1.5e5)),
                   ((1e8, 6e5, -6e5, 1.4e8), (6e4, -300.0, 300.0, 8e4)))  # fmt: skip
    at_rest = ((130.695, 0.637866), (227.925, 0.0958757), (313.311, 0.227364), (381.529, 0.652812), (390.802, 0.177361),
               (1448.01, 0.142312), (1554.84, 0.107354), (2050.12, 0.308294))  # fmt: skip
    turning = ((123.683, 0.124817), (200.581, 0.217961), (286.743, 0.181652), (308.624, 0.432727), (370.338, 0.254912),
               (409.861, 0.558764), (813.124, 0.47323), (997.312, 0.493828))  # fmt: skip
    return [aster("SDLL129, at rest", slow, {0: at_rest}), aster("SDLL129, turning", fast, {20000: turning})]


def vm261():
    """A shaft without shear, its damping 0.2 ms times its stiffness, on two springs."""
    section = Section(1.27 / 5, (0.1016, 0.1016), (0.0, 0.0), Material(7800.0, 2.1e11, 0.3))
    supports = tuple(_support(place, (1.75e7, 1.75e7)) for place in (0.0, 1.27))
    shaft = Shaft((section,) * 5, supports=supports, rotating_damping=2e-4, shear=False)
    return Published("VM261", model_of(shaft, shaft.stations, "VM261"),
                     [(rpm * RPM, rpm * RPM, f"{rpm:.0f} rpm", np.nan) for rpm in (4950, 10500)])  # fmt: skip


def friswell(name, disks, supports, printed):
    """A shaft of 1.5 m and 50 mm, six elements."""
    material = Material(7810.0, 211e9, 0.5 * 211e9 / 81.2e9 - 1.0)
    disks = [disk(node, 0.05, outer, 0.07, 7810.0) for node, outer in disks]
    model = typed(np.linspace(0.0, 1.5, 7), np.zeros(6), np.full(6, 0.05), material, disks, supports, name)
    rows = [(rpm * RPM, value * RAD, f"{value:.5g} rad/s", np.nan) for rpm, values in printed.items() for value in values]
    return Published(name, model, rows)


def rotors():
    """All of them."""
    two_disks = [(2, 0.28), (4, 0.35)]
    unequal = [(node, (1e6, 8e5)) for node in (0, 6)]
    return [
        nelson_mcvaugh(),
        lalanne_ferraris(),
        friswell("F 5.9.1", two_disks, [(node, (1e6, 1e6)) for node in (0, 6)],
                 {0: (86.66, 274.31, 716.78), 4000: (85.39, 87.80, 251.78, 294.71, 600.18)}),
        friswell("F 5.9.2", two_disks, unequal,
                 {0: (82.65, 86.66, 254.52, 274.31, 679.49), 4000: (82.33, 86.86, 239.64, 287.25, 583.49)}),
        friswell("F 5.9.9", [(6, 0.35)], [(node, (1e7, 1e7)) for node in (0, 4)],
                 {0: (90.14, 630.73, 830.43), 4000: (76.19, 103.91, 565.99, 634.23, 647.75, 1174.2)}),
        vm254(), vm261(), sdll124(), sdll125(), sdll128(), *sdll129(),
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
