"""Results of a report for each of several contacts: lines of the answer, table cells, plain numbers."""

import numpy as np

from rsc.measure.stretches import at_contacts
from rsc.show.words.reasons import percent
from rsc.show.words.vibration import left_text
from rsc.show.words.wording import amount, interval, length, vibration

MOST_NAMES = 3  # of motions of one kind that differ in their contacts


def contact_lines(report, moment):
    """(name, text) of every contact of a report, in the order of the scene: vibration of the rotor there, closest approach,
    force; moment: what a time of the run is in words."""
    lines = []
    for contact, own in zip(report.result.scene.contacts, at_contacts(report.result), strict=True):
        whole, i = own.whole(), int(np.argmax(np.nan_to_num(report.contacts[contact.name].peak_to_peak)))
        middle, half = report.features.time[i], 0.5 * report.features.window
        part = own.between(middle - half, middle + half)
        text = f"vibration up to {vibration(part.peak_to_peak)} {interval(report, part.begin, part.end)}; "
        if whole.contact_time == 0.0:
            lines.append((contact.name, f"{text}never touched, {left_text(whole.deflection_max, contact.gap)} left"))
            continue
        depth = max(whole.deflection_max - contact.gap, 0.0)
        force = f"{amount(whole.force_max, 'N')} normal at {moment(whole.force_max_at)}"
        text += f"penetration up to {length(depth)}, {percent(depth / contact.gap)} of the clearance; up to {force}"
        lines.append((contact.name, f"{text}; in contact for {_percent(whole.share)} of the run"))
    return lines


def _percent(share):
    """A share that is all or nothing only where it is."""
    return f"{100.0 * share:.3g} %" if share in (0.0, 1.0) else f"{min(max(100.0 * share, 0.1), 99.9):.1f} %"


def named_places(report, places):
    """[(name, places)] of windows of one kind: what the motion is at several contacts, and where it is that. The three that most
    windows have come first, then the others together."""
    names = np.array(report.features.names)[places]
    told, counts = np.unique(names, return_counts=True)
    order = [str(name) for name in told[np.argsort(-counts, kind="stable")]]
    groups = [(name, places[names == name]) for name in order[:MOST_NAMES]]
    others = places[np.isin(names, order[MOST_NAMES:])]
    return groups + ([(f"{report.features.kind[places[0]]} at other contacts", others)] if len(others) else [])


def branch_cells(branch):
    """The cells of one predicted whirl, one for each contact: deflection over the gap, and normal force where it is pressed."""
    cells = []
    for name, own in branch.at_contacts.items():
        force = f", {_span(own['normal_force'])} N" if name in branch.pressed else ""
        cells.append(_span(own["over_gap"]) + force)
    return cells


def _span(values):
    first, last = (f"{value:.0f}" if 1e4 <= abs(value) < 1e9 else f"{value:.4g}" for value in (values[0], values[-1]))
    return first if first == last else f"{first} .. {last}"


def contacts_plain(report):
    """What a run was at each of several contacts, over all of it and in its windows, as plain numbers; [] with one."""
    rows = []
    for contact, own in zip(report.result.scene.contacts, at_contacts(report.result) if report.contacts else (), strict=False):
        whole = own.whole()
        values = {"name": contact.name, "gap": contact.gap, "over_gap": whole.deflection_max / contact.gap, "share": whole.share}
        values |= {"force_mean": whole.mean_force, "force_max": whole.force_max, "onsets": whole.onsets}
        columns = {name: np.asarray(column).tolist() for name, column in vars(report.contacts[contact.name]).items()}
        rows.append(values | {"windows": columns})
    return rows
