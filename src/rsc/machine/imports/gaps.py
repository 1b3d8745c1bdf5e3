"""Reader of radial gaps (NLRGAP) of Nastran decks, as contacts.

OptiStruct and MSC Nastran, bulk data entry NLRGAP: SID, GA (inner grid point, shaft), GB (outer one, housing), PLANE, TABK, TABG,
TABU, RADIUS. The tables, TABLED1, give stiffness, clearance and friction over time, a negative TABK refers to force over
penetration. rsc needs a single number for each.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rsc.errors import DataError, one_line
from rsc.files.content import content_of
from rsc.machine.formats.bulk import cards, integer, real
from rsc.machine.formats.entries import BadMatrix

MOST_FILE_BYTES = 2**28
_MOST_FIELDS = 20_000  # in one table
_AXES = {"YZ": "x", "ZX": "y", "XZ": "y", "XY": "z", "": "z"}
_ALIKE = 1e-6  # relative difference up to which the values of a table count as constant


@dataclass(frozen=True)
class RadialGap:
    """One NLRGAP: nodes of shaft and housing, axis of the rotor; stiffness N/m, gap m, friction, radius m (0: none)."""

    inner: int
    outer: int
    axis: str
    stiffness: float
    gap: float
    friction: float
    radius: float


def read_gaps(path: str | os.PathLike[str], units: str | None = None) -> list[RadialGap]:
    """Every NLRGAP of a deck.

    Parameters
    ----------
    path : path
        Bulk data in small, large or free field format.
    units : None or "mm"
        "mm": units mm, N, t, s; otherwise SI.

    Raises
    ------
    DataError
        No such file, no NLRGAP in it, a table that is missing or varies with time, or a force not proportional to the
        penetration.
    """
    try:
        gaps, tables = [], {}
        names = (b"NLRGAP", b"TABLED1")
        for name, card in cards(content_of(path, MOST_FILE_BYTES), names, _MOST_FIELDS, "a table has too many entries"):
            if name == b"NLRGAP":
                gaps.append(card)
            else:
                tables[integer(card[0])] = card
        if not gaps:
            raise BadMatrix("it has no NLRGAP")
        return [_in_metres(_gap(card, tables), units) for card in gaps]
    except BadMatrix as error:
        raise DataError(one_line(Path(path)), one_line(error)) from None


def gaps_at(
    path: str | os.PathLike[str], node: object, axis: str, units: str | None = None
) -> tuple[list[RadialGap], list[RadialGap]]:
    """(the NLRGAP whose shaft is at a node, all others); without a node (None), all of them and an empty list.

    Raises
    ------
    DataError
        As `read_gaps`; none or several at the node, two between the same nodes, or one in another plane than that of the rotor.
    """
    gaps = read_gaps(path, units)
    chosen = [gap for gap in gaps if node is None or str(gap.inner) == str(node)]
    if len(chosen) != 1 and node is not None:
        nodes = ", ".join(dict.fromkeys(str(gap.inner) for gap in gaps[:10]))
        what = f"{len(chosen) or 'no'} NLRGAP at node {node}"
        raise DataError(one_line(Path(path)), f"it has {what}; their shafts are at {nodes}: without --contact all are contacts")
    pairs = [(gap.inner, gap.outer) for gap in gaps]
    for i, pair in enumerate(pairs):
        if pair in pairs[:i]:
            raise DataError(one_line(Path(path)), f"it has two NLRGAP between the nodes {pair[0]} and {pair[1]}")
        if (turns := gaps[i].axis) != axis:
            raise DataError(one_line(Path(path)), f"the plane of its NLRGAP is that of a rotor about {turns}, not about {axis}")
    return chosen, [gap for gap in gaps if gap not in chosen]


def _in_metres(gap: RadialGap, units: str | None) -> RadialGap:
    if units != "mm":
        return gap
    return replace(gap, stiffness=1e3 * gap.stiffness, gap=1e-3 * gap.gap, radius=1e-3 * gap.radius)


def _gap(card: list[bytes], tables: dict[int, list[bytes]]) -> RadialGap:
    plane = card[3].decode("ascii", "replace").upper()
    if plane not in _AXES:
        raise BadMatrix(f"the plane '{plane}' of an NLRGAP is not XY, YZ or ZX")
    stiffness = _table(tables, card[4])
    if integer(card[4]) < 0:
        slopes = [force / depth for depth, force in stiffness if depth]
        if any(force for depth, force in stiffness if depth <= 0.0):
            raise BadMatrix(f"the force of TABLED1 {-integer(card[4])} does not start at penetration 0")
        name = f"the force of TABLED1 {-integer(card[4])} is not proportional to the penetration"
        stiff = _constant([slope for slope in slopes if slope], name)
    else:
        stiff = _constant([value for _, value in stiffness], _over_time("stiffness", card[4]))
    clearance = _constant([value for _, value in _table(tables, card[5])], _over_time("clearance", card[5]))
    friction = _constant([value for _, value in _table(tables, card[6])], _over_time("friction", card[6]))
    radius = real(card[7])
    if not (stiff > 0.0 and clearance > 0.0 and radius >= 0.0):
        raise BadMatrix(f"the NLRGAP at node {integer(card[1])} has no positive stiffness and clearance, or a negative radius")
    # the sign of the coefficient gives the sense of rotation, which rsc takes from the speed
    return RadialGap(integer(card[1]), integer(card[2]), _AXES[plane], stiff, clearance, abs(friction), radius)


def _over_time(what: str, field: bytes) -> str:
    return f"the {what} of TABLED1 {integer(field)} varies with time"


def _constant(values: Sequence[float], otherwise: str) -> float:
    """The common value; BadMatrix with the message `otherwise` if the values differ."""
    if not values or max(values) - min(values) > _ALIKE * max(abs(value) for value in values):
        raise BadMatrix(f"{otherwise}; rsc needs a single number")
    return values[0]


def _table(tables: dict[int, list[bytes]], field: bytes) -> list[tuple[float, float]]:
    """The (x, y) pairs of a TABLED1."""
    number = abs(integer(field))
    if number not in tables:
        raise BadMatrix(f"it has no TABLED1 {number}")
    fields = tables[number]
    if any(word.upper().startswith(b"LOG") for word in fields[1:3]):
        raise BadMatrix(f"TABLED1 {number} has a logarithmic axis")
    pairs = []
    for i in range(8, len(fields) - 1, 2):
        words = {word.upper() for word in fields[i : i + 2]}
        if b"ENDT" in words:
            break
        if b"SKIP" not in words and any(fields[i : i + 2]):
            pairs.append((real(fields[i]), real(fields[i + 1])))
    return pairs
