"""Five rotors that others published, and what they printed of them, beside `rsc modes`.

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
"""

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rsc.machine.model.model import Model
from rsc.machine.model.modes import slowest_modes
from rsc.machine.shaft.assembly import model_of
from rsc.machine.shaft.parts import Disk, Material, Section, Shaft, Support, disk_inertias

RESULT = Path(__file__).parent / "results" / "published_rotors.md"
RPM, RAD = 1.0 / 60.0, 1.0 / (2.0 * np.pi)


class Published(NamedTuple):
    """A rotor with what was printed: (rotor speed in Hz, frequency in Hz, how it was printed)."""

    name: str
    model: Model
    printed: list


def typed(places, inner, outer, material, disks, supports, source, shear=True):
    """Model of a shaft by its stations, one element between two of them: places in m, diameters of the sections, disks (node,
    mass, polar, diametral inertia), supports (node, stiffness in x and y, damping in x and y)."""
    parts = zip(np.diff(places), inner, outer, strict=True)
    shaft = Shaft(
        tuple(Section(length, (wide, wide), (bore, bore), material) for length, bore, wide in parts),
        disks=tuple(Disk(places[node], *own) for node, *own in disks),
        supports=tuple(_support(places[node], *own) for node, *own in supports),
        shear=shear,
    )
    return model_of(shaft, shaft.stations, source)


def _support(place, stiffness, damping=(0.0, 0.0)):
    coefficients = [stiffness[0], 0.0, 0.0, stiffness[1], damping[0], 0.0, 0.0, damping[1]]
    return Support(place, np.zeros(1), np.array([coefficients]))


def disk(node, inner, outer, width, density):
    """(node, mass, polar, diametral inertia) of a solid disk on a shaft."""
    return node, *disk_inertias(outer, inner, width, density)


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
    supports = [(node, (4.378e7, 4.378e7)) for node in (10, 14)]
    steel, source = Material(7806.0, 2.078e11, 0.3), "Nelson and McVaugh 1976"
    model = typed(places, inner, outer, steel, [(4, 1.401, 0.002, 0.00136)], supports, source, shear=False)
    rpm = {1: (-15470.0, 17159.0, -46612.0, 49983.0, -64752.0, 96457.0),
           4: (-16060.0, 16481.0, -47957.0, 48800.0, -72737.0, 80649.0)}  # fmt: skip
    rows = [(abs(whirl) / ratio * RPM, whirl * RPM, f"{abs(whirl):.0f} rpm") for ratio in rpm for whirl in rpm[ratio]]
    return Published("N&M", model, rows)


def lalanne_ferraris():
    """13 elements of 0.1 m, three discs, bearings that differ in their directions and have damping."""
    material, nodes = Material(7800.0, 2e11, 0.3), 0.1 * np.arange(14)
    disks = [disk(2, 0.1, 0.24, 0.05, 7800.0), disk(5, 0.1, 0.4, 0.05, 7800.0), disk(10, 0.1, 0.4, 0.06, 7800.0)]
    supports = [(node, (5e7, 7e7), (5e2, 7e2)) for node in (0, 13)]
    model = typed(nodes, np.zeros(13), np.full(13, 0.1), material, disks, supports, "Lalanne and Ferraris 1998")
    frequencies = (55.408, 67.209, 157.90, 193.71, 249.90, 407.62, 446.62, 715.03, 622.65, 1093.0)
    return Published("L&F", model, [(25000.0 * RPM, value, f"{value:.5g} Hz") for value in frequencies])


def friswell(name, disks, supports, printed):
    """A shaft of 1.5 m and 50 mm, six elements."""
    material = Material(7810.0, 211e9, 0.5 * 211e9 / 81.2e9 - 1.0)
    disks = [disk(node, 0.05, outer, 0.07, 7810.0) for node, outer in disks]
    model = typed(np.linspace(0.0, 1.5, 7), np.zeros(6), np.full(6, 0.05), material, disks, supports, name)
    rows = [(rpm * RPM, value * RAD, f"{value:.5g} rad/s") for rpm, values in printed.items() for value in values]
    return Published(name, model, rows)


def rotors():
    """All five."""
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
