"""Results of a sweep in a few lines: ends of the cases with reasons, danger classes, extremes and their places."""

import re
from collections import Counter

import numpy as np

from rsc.measure.several import together
from rsc.results.labelled import as_str
from rsc.show.words.units import column, unit_for
from rsc.show.words.wording import frequency_text

MOST_REASONS = 5
WHIRL = "whirl"  # the dimension of the whirls of a case
# variable -> what its largest value is
EXTREMES = {
    "largest_amplitude": "largest amplitude of a run",
    "largest_force": "largest normal force of a run",
    "whirl_amplitude": "largest amplitude of a predicted backward whirl",
    "whirl_force": "largest normal force of a predicted backward whirl",
}


def ends(data):
    """One line on how the cases of a sweep (`rsc.results.labelled.Labelled`) ended."""
    status = _status(data)
    return f"{status.total()} cases: " + ", ".join(f"{count} {word}" for word, count in status.most_common())


def _status(data):
    """Status -> number of its cases."""
    words, counts = np.unique(data.variables["status"][1], return_counts=True)
    return Counter(dict(zip(as_str(words).tolist(), counts.tolist(), strict=True)))


def dangers(data):
    """One line with the number of cases in each danger class; "" if not computed."""
    return _counted("backward whirl", _classes(data, "danger", "not predicted"))


def severities(data):
    """One line with the number of cases of each severity; "" if neither runs nor lists of motions were computed."""
    return _counted("severity", _classes(data, "severity", "not computed"))


def _counted(name, counts):
    told = ", ".join(f"{text} in {count} cases" for text, count in counts.items())
    return f"{name}: {told}" if counts else ""


def _classes(data, name, absent):
    """Class of a variable in words -> number of its cases; empty where that was not computed."""
    if name not in data:
        return {}
    counts, words = Counter(data[name].ravel().tolist()), dict(enumerate(flag_words(data, name))) | {-1: absent}
    return {text: counts[i] for i, text in words.items() if counts[i]}


def plain(data):
    """The same as values for JSON: ends of the cases, danger classes, and reasons of unfinished cases."""
    return {
        "cases": int(data["status"].size), "dims": {name: int(length) for name, length in data.dims.items() if name != WHIRL},
        "status": _status(data), "danger": _classes(data, "danger", "not predicted"),
        "severity": _classes(data, "severity", "not computed"), "reasons": reasons(data),
    }  # fmt: skip


def danger_words(data):
    """The words of the classes of danger, from none to worst."""
    return flag_words(data, "danger")


def flag_words(data, name):
    """The words of the flags of a variable, in their order; of a set of several contacts their names."""
    flags = data.variables[name][2].get("flags", "")
    return [flag.strip().partition(" ")[2] for flag in flags.split(";")] if flags else []


def set_words(data, name):
    """The sets of several contacts that a variable tells: (classes, its entries as numbers of the words, -1 where there is none;
    words). Of one contact there are no words."""
    names = flag_words(data, name)
    numbers, classes = np.unique(data[name], return_inverse=True)
    if not names or not len(numbers):
        return np.full(data[name].shape, -1), []
    words = [together([own for i, own in enumerate(names) if number >> i & 1] or ["none"]) for number in numbers.tolist()]
    absent = int((numbers < 0).sum())
    return np.where(data[name] < 0, -1, classes.reshape(data[name].shape) - absent), words[absent:]


def reasons(data):
    """Reasons of unfinished cases, one line each; reasons that differ only in numbers are listed once."""
    alike = {}
    for reason in as_str(data.variables["reason"][1][data["status"] != "finished"]).tolist():
        if reason:
            alike.setdefault(re.sub(r"-?[\da-f]{16,}|-?\d[\d.e+-]*|\(.*\)", "#", reason), []).append(reason)
    ordered = sorted(alike.values(), key=len, reverse=True)
    lines = [f"{len(same)} x such as {same[0]}" if len(same) > 1 else same[0] for same in ordered[:MOST_REASONS]]
    if len(ordered) > MOST_REASONS:
        lines.append(f"and {len(ordered) - MOST_REASONS} other reasons, in `reason` of the dataset")
    return lines


def extremes(data):
    """(quantity, value with unit, where) of the largest amplitudes and forces."""
    rows = []
    for name, text in EXTREMES.items():
        if name not in data or not np.isfinite(data[name]).any():
            continue
        place = np.unravel_index(np.nanargmax(data[name]), data[name].shape)
        value = float(data[name][place])
        factor, unit = unit_for(value, data.variables[name][2]["units"])
        at = flag_words(data, "largest_contact") if name == "largest_force" else []
        number = int(data["largest_contact"][place]) if at else -1
        where = _where(data, data.variables[name][0], place) + (f", at {at[number]}" if 0 <= number < len(at) else "")
        rows.append((text, f"{factor * value:.4g} {unit}", where))
    return rows


def _where(data, dims, place):
    """The values of the keys at a place of the grid."""
    at = dict(zip(dims, place, strict=True))
    return ", ".join(
        f"{key} = {_with_unit(values[at[axes[0]]], about.get('units', '1'))}"
        for key, (axes, values, about) in data.coordinates.items()
        if axes[0] in at and len(values) > 1
    )


def _with_unit(value, unit):
    """A value of a key; frequencies in the unit that is shown."""
    if unit == "Hz" and column(unit)[1] != unit:
        return frequency_text(float(value))
    return _shown(value) + ("" if unit == "1" else f" {unit}")


def _shown(value):
    return f"{value:.6g}" if isinstance(value, (float, np.floating)) else str(value)
