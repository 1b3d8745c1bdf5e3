"""Whirls at several contacts as a table for people."""

from rsc.show.words.held import loads_text
from rsc.show.words.table import exact, table
from rsc.show.words.text import claim
from rsc.show.words.wording import frequency_text, not_valid, sentence_in_units


def several_text(whirls, speed, remarks=(), loads=()):
    """Table of the whirls of a scene with several contacts at one rotor speed in Hz (`rsc.SeveralWhirls`), remarks on them in
    words, and what each takes from a drive with a torque (`rsc.system.held`)."""
    header = ("speed Hz", "whirl Hz", "growth 1/s", "stable", "not valid", "pressed: |d|/gap, F_N, phase; others: |d|/gap")
    rows = [
        (
            exact(f"{whirl.speed:.4g}", whirl.speed),
            exact(f"{whirl.frequency:.4f}", whirl.frequency),
            f"{whirl.growth_rate:+.4g}",
            claim(whirl),
            not_valid(whirl),
            "; ".join(_at(name, whirl.contacts[name]) for name in sorted(whirl.contacts, key=lambda n: n not in whirl.pressed)),
        )
        for whirl in whirls
    ]
    pairs = zip(whirls, loads, strict=False)
    taken = [f"whirl {frequency_text(w.frequency, '.4f')} {loads_text(own)}" for w, own in pairs if own]
    none = f"no whirl is predicted at {frequency_text(speed, '.4g')}"
    return "\n".join([table(header, rows) if rows else none, *taken, *map(sentence_in_units, remarks)])


def _at(name, contact):
    """One contact in a whirl."""
    if not contact.pressed:
        return f"({name} {contact.over_gap:.4f})"
    return f"{name} {contact.over_gap:.4f}, {contact.normal_force:.5g} N, {round(contact.phase, 1) + 0.0:.1f} deg"  # no -0.0
