"""The unbalance response compared with the limits of a scene, in words and as a table."""

import math

from rsc.errors import one_line
from rsc.show.words.table import exact, table
from rsc.show.words.wording import frequencies_text, frequency_text, hertz, rpm, vibration

HEADER = ("peak Hz", "rpm", "peak to peak", "amplification", "margin", "needed", "")
SOURCE = (
    "amplification, margins, vibration limit and scale factor as in API RP 684 (2nd edition, SP6.8.2), of the unbalance in the "
    "scene and without contact: whether it lies where it excites a mode most is not examined, and no conformity is claimed"
)


def limits_cells(acceptance):
    """Header and rows of the peaks at the probe."""
    return HEADER, [_row(peak) for peak in acceptance.peaks]


def limits_lines(acceptance):
    """(topic, text) of the limits other than peaks."""
    low, high = acceptance.operating
    speeds = frequency_text(low) if low == high else frequencies_text(low, high)
    told = f"{vibration(acceptance.vibration)} at {frequency_text(acceptance.at)}, the largest at {speeds}; allowed"
    verdict = "kept" if acceptance.vibration <= acceptance.allowed else "exceeded"
    lines = [(f"vibration at {acceptance.probe}", f"{told} {vibration(acceptance.allowed)}: {verdict}")]
    first = acceptance.passages[0]
    lines.append(("scale factor", f"{acceptance.scale:.3g}, up to the trip speed {frequency_text(acceptance.trip)}"))
    for passage in acceptance.passages:
        share = f"takes {100.0 * passage.share:.3g} % of the diametral clearance at {frequency_text(passage.speed)}, 75 % at most"
        where = ", the first to be touched" if passage is first and len(acceptance.passages) > 1 else ""
        verdict = "kept" if passage.kept else "exceeded"
        lines.append((passage.name, f"the scaled response {share}: {verdict}{where}"))
    return lines


def limits_summary(acceptance):
    """What is not kept, for the answer."""
    near = [peak for peak in acceptance.peaks if not (peak.kept or math.isnan(peak.amplification))]
    failed = [f"margin of the peak at {frequency_text(peak.speed)}" for peak in near]
    if acceptance.vibration > acceptance.allowed:
        failed.append(f"vibration at {acceptance.probe}")
    failed += [f"clearance of {passage.name}" for passage in acceptance.passages if not passage.kept]
    return "all kept without contact" if not failed else "not kept without contact: " + ", ".join(failed)


def limits_text(acceptance, title):
    """All of it for a terminal."""
    lines = [one_line(title)] if title else []
    header, rows = limits_cells(acceptance)
    lines.append("peaks of the unbalance response" + ("" if rows else ": none"))
    lines += [table(header, rows)] if rows else []
    lines += [f"{topic}: {text}" for topic, text in limits_lines(acceptance)]
    return "\n".join([*lines, f"note: {SOURCE}"])


def _row(peak):
    known = not math.isnan(peak.amplification)
    amplification = f"{peak.amplification:.3g}" if known else "unknown"
    needed = "-" if not known else "outside" if math.isinf(peak.needed) else f"{100.0 * peak.needed:.3g} %"
    margin = f"{100.0 * peak.margin:.3g} %" if peak.margin else "inside"
    verdict = "kept" if peak.kept else "not kept" if known else "-"
    speed = exact(hertz(peak.speed), peak.speed)
    return speed, rpm(peak.speed), vibration(peak.amplitude), amplification, margin, needed, verdict
