"""Pictures of where the rotor was: paths at moments of a run and at the cursor, shaft centre line, distance once a revolution."""

import numpy as np

from rsc.show.pictures.moments import distances_once_a_turn, filtered, is_deflected, marks_of, place_of
from rsc.show.pictures.traces import BLUE, GREEN, GREY, PURPLE, RED, SKY, axes, dots, line, numbers, range_of
from rsc.show.words.units import column, largest_finite, unit_for

TURN = np.exp(2j * np.pi * np.arange(73) / 72)
FILTERED_COLOURS = {"filtered at 1X": PURPLE, "filtered at the whirl": SKY}
STEPS = 1000  # of a path at the cursor, of which one is half a pixel
MOST_TURNS = 240  # windows of which positions once a revolution are drawn


def centre_line(report, along):
    """Mean positions of the rotor over the run within the gap, None where it stays in the middle."""
    if not is_deflected(report):
        return None
    gap = report.contact.gap
    factor, unit = unit_for(gap, "m")
    circle, centre = factor * gap * TURN, factor * report.centre
    data = [line(circle.real, circle.imag, "gap", GREY, "dash", 1.1), line(centre.real, centre.imag, "centre", BLUE, width=1.4)]
    data.append(dots([centre[0].real], [centre[0].imag], "begin of the run", "none", GREY))
    return {"data": data, "layout": axes(f"y in {unit}", f"z in {unit}", 340, equal=True, width=360)}


def once_a_turn(report, along):
    """Distance of the rotor at every revolution of the shaft that the kept paths hold, over the run."""
    factor, unit = unit_for(max(largest_finite(np.abs(report.orbits.rotor)), report.contact.gap), "m")
    windows, distances = distances_once_a_turn(report, MOST_TURNS)
    drawn = dots(along.of_windows[windows], factor * distances, "once a revolution", BLUE, size=3)
    rim = line(range_of(along), [factor * report.contact.gap] * 2, "gap", GREY, "dashdot", 1.2)
    y = {"title": f"|r| once a revolution in {unit}", "rangemode": "tozero"}
    return {"data": [drawn, rim], "layout": axes({"title": along.title, "range": range_of(along)}, y, 260, across="x")}


def orbit(report, window):
    """The path in the middle of a window: rotor, contact, stator, gap and one mark a revolution."""
    orbits, gap = report.orbits, report.contact.gap
    factor, unit = unit_for(max(largest_finite(np.abs(orbits.rotor)), gap), "m")
    rotor, stator = factor * orbits.rotor[window], factor * orbits.stator[window]
    data = traces_of_orbit(rotor, stator, orbits.normal_force[window] > 0.0, marks_of(report, window), factor * gap)
    for name, (centre, forward, backward) in filtered(report, window).items():
        path = factor * (centre + forward * TURN + backward * TURN.conj())
        data.append(line(path.real, path.imag, name, FILTERED_COLOURS[name], "dot", 1.4))
    return {"data": data, "layout": axes(f"y in {unit}", f"z in {unit}", 340, equal=True, width=360)}


def traces_of_orbit(rotor, stator, touching, marks, gap):
    """Traces of a path; all in one unit."""
    middle = stator.mean()
    circle = middle + gap * TURN
    held = np.where(touching, rotor, np.nan + 1j * np.nan)
    data = [
        line(circle.real, circle.imag, "gap", GREY, "dash", 1.1),
        line(rotor.real, rotor.imag, "rotor", BLUE, width=1.2),
    ]
    if touching.any():
        data.append(line(held.real, held.imag, "in contact", RED, width=2.2))
    if np.abs(stator - middle).max() > 0.0:
        data.append(line(stator.real, stator.imag, "stator", GREEN, width=1.1))
    data.append(dots(rotor[marks].real, rotor[marks].imag, "once a revolution", "#ffffff", "#444444", 7))
    return data


def moments(report, chosen):
    """(caption, picture) of every moment."""
    return [(f"{moment.text}, {place_of(report, moment.window)}", orbit(report, moment.window)) for moment in chosen]


def at_cursor(report, along, most=120):
    """Values and orbits of at most `most` windows, shown by the page at its cursor."""
    n_windows = len(report.fall.speed)
    chosen = np.unique(np.linspace(0, n_windows - 1, min(n_windows, most)).round().astype(int))
    orbits, gap = report.orbits, report.contact.gap
    factor, unit = unit_for(max(largest_finite(np.abs(orbits.rotor)), gap), "m")
    motions = np.array([orbits.rotor[chosen], orbits.stator[chosen]])
    largest = np.max(np.nan_to_num(np.abs(motions), posinf=0.0), axis=(0, 2))  # of each window
    scale = np.where(largest > 0.0, largest, gap) / STEPS
    windows = [report.windows[i] for i in chosen]
    rows = [[(row.simulated, row.predicted) for row in window] for window in windows]
    (per_hertz, hertz), (per_newton, newton) = column("Hz"), column("N")
    values = (np.array(rows, float) * np.array([per_hertz, factor, factor])[:, None]).reshape(len(rows), -1).T
    places = np.round(np.nan_to_num(np.stack([motions.real, motions.imag], axis=2) / scale[:, None, None])).astype(int)
    bends = np.diff(places, n=3, prepend=np.zeros_like(places[..., :3]))  # small along smooth paths
    return {
        "place": numbers((per_hertz if along.by_speed else 1.0) * along.of_windows[chosen]),
        "speed": numbers(per_hertz * report.fall.speed[chosen]),
        "time": numbers(report.fall.time[chosen]),
        "values": [numbers(each) for each in values],
        "verdict": [window.frequency.verdict for window in windows],
        "branch": [window.branch for window in windows],
        "force": numbers(per_newton * report.features.force[chosen]),
        "share": numbers(report.features.share[chosen]),
        "paths": bends.tolist(),
        "touching": (orbits.normal_force[chosen] > 0.0).astype(int).tolist(),
        "marks": [marks_of(report, int(i)).tolist() for i in chosen],
        "scale": numbers(scale * factor),
        "gap": gap * factor,
        "reach": factor * max(largest_finite(np.abs(orbits.rotor)), gap),
        "unit": unit,
        "units": {"frequency": hertz, "force": newton},
    }
