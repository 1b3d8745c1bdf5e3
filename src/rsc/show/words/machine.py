"""The rotor of a scene in numbers, as its drawing and data sheets have them: what a model is checked by first."""

import numpy as np

from rsc.scene.bodies.drawn import BEARING, CONTACT, DISK, SECTION, SLEEVE
from rsc.show.words.table import exact
from rsc.show.words.units import column
from rsc.show.words.wording import speed_text

MM = 1e3
GAINS = "k_s N/m", "K_p N/m", "K_i N/(m s)", "K_d N s/m", "amplifier Hz"
COEFFICIENTS = [f"{letter}_{pair} {unit}" for letter, unit in (("k", "N/m"), ("c", "N s/m")) for pair in ("yy", "yz", "zy", "zz")]


def machine_lines(scene, criticals=None):
    """(topic, text) of a rotor given by its stations: length, mass, centre of gravity, critical speeds; [] of another.

    criticals : list of (speed in Hz, logarithmic decrement), or None
    """
    parts = getattr(scene.rotor, "parts", None)
    if not parts:
        return []
    mass = sum(part.mass for part in parts)
    centre = sum(part.mass * part.place for part in parts) / mass if mass else 0.0
    ends = [part.end for part in scene.rotor.drawn if part.kind == SECTION]
    lines = [
        ("rotor", f"length {_length(max(ends))}, mass {_amount(mass, 'kg')}, polar moment of inertia "
                  f"{_amount(sum(part.polar_inertia for part in parts), 'kg m^2')}"),
        ("centre of gravity", f"{_length(centre)} from the left end"),
    ]  # fmt: skip
    if criticals is not None:
        told = "; ".join(f"{speed_text(speed)}, logarithmic decrement {decrement:.3g}" for speed, decrement in criticals)
        top = speed_text(float(np.max(np.abs(scene.drive.speed))))
        lines.append(("critical speeds", f"{told or 'none'}; searched up to {top}"))
    return lines


def machine_tables(scene):
    """[(title, header, rows of texts)] of the sections, disks, bearings and contacts of such a rotor."""
    drawn = [part for part in scene.rotor.drawn if part.kind in (SECTION, SLEEVE)]
    listed = [part for part in scene.rotor.parts if part.kind in (SECTION, SLEEVE)]
    sections = [
        (str(i), part.name or "-", _mm(part.start), _mm(part.end), _ends(part.left, part.right),
         _ends(part.left_bore, part.right_bore), f"{one.mass:.4g}", part.kind)
        for i, (part, one) in enumerate(zip(drawn, listed, strict=True), 1)
    ]  # fmt: skip
    disks = [part for part in scene.rotor.parts if part.kind == DISK]
    disks = [(part.name or "-", _mm(part.place), *(f"{value:.4g}" for value in part[3:]), "") for part in disks]
    bearings = [
        (one.name or "-", _mm(one.place), exact(f"{one.speed:.4g}", one.speed) if one.speed else "all",
         *(f"{value:.4g}" for value in one.coefficients), "")
        for one in scene.rotor.bearing_rows or ()
    ]  # fmt: skip
    places = [part.start for part in scene.rotor.drawn if part.kind == CONTACT]
    contacts = [
        (contact.name or CONTACT, _mm(places[contact.rotor_coordinates[0]]), _mm(contact.diameter or np.nan), _mm(contact.gap),
         f"{contact.friction:.3g}", f"{contact.stiffness:.4g}", "")
        for contact in scene.contacts if contact.rotor_coordinates[0] < len(places)
    ]  # fmt: skip
    tables = [
        ("Sections", ("section", "name", "from mm", "to mm", "diameter mm", "bore mm", "mass kg", "kind"), sections),
        ("Disks", ("disk", "at mm", "mass kg", "polar inertia kg m^2", "diametral inertia kg m^2", ""), disks),
        ("Bearings", (BEARING, "at mm", "speed Hz", *COEFFICIENTS, ""), bearings),
        ("Magnetic bearings", ("magnetic bearing", "at mm", *GAINS, ""), _magnetic(scene.rotor)),
        ("Contacts", ("contact", "at mm", "shaft diameter mm", "radial gap mm", "friction", "stiffness N/m", ""), contacts),
    ]
    return [(title, header, rows) for title, header, rows in tables if rows]


def _magnetic(rotor):
    """Rows of the magnetic bearings, in the rotor's order; they are drawn after the bearings with coefficients."""
    controlled = [one[-1] for one in rotor.magnetic_bearings or ()]
    drawn = [part for part in rotor.drawn if part.kind == BEARING]
    return [
        (part.name or "-", _mm(part.start), f"{one.negative_stiffness:.4g}", f"{one.proportional:.4g}", f"{one.integral:.4g}",
         f"{one.derivative:.4g}", f"{one.amplifier:.4g}", "")
        for part, one in zip(drawn[len(drawn) - len(controlled) :], controlled, strict=True)
    ]  # fmt: skip


def _mm(metres):
    return exact(f"{MM * metres:.5g}", MM * metres) if np.isfinite(metres) else "-"


def _ends(left, right):
    """A diameter in m at both ends of a section, in mm."""
    if left == right:
        return _mm(left) if left else "-"
    return exact(f"{MM * left:.5g} .. {MM * right:.5g}", MM * left, MM * right)


def _length(metres):
    factor, unit = column("mm")
    return f"{factor * MM * metres:.4g} {unit}"


def _amount(value, base):
    factor, unit = column(base)
    return f"{factor * value:.4g} {unit}"
