"""The tables and texts of the page. Whatever comes from a scene or a file is escaped here."""

import hashlib
from html import escape

import numpy as np

from rsc.measure import window_length
from rsc.measure.stretches import at_contacts
from rsc.measure.words import TOLERANCES
from rsc.show.words.answer import least_friction
from rsc.show.words.limits import SOURCE, limits_cells, limits_lines
from rsc.show.words.machine import machine_lines, machine_tables
from rsc.show.words.motions import claim, motions_cells, only_predicted, rolling_lines
from rsc.show.words.reasons import note_of_change
from rsc.show.words.table import in_units
from rsc.show.words.text import LEDGER, at_lead, branches_cells, run_text, window_cells
from rsc.show.words.wording import frequency_text, length, sentence_in_units, speed_text

HASHED = 64
# what stands in the columns of tables
WHIRLS = (
    '<p class="soft">From the beginning of a branch to its end: whirl, its frequency, negative against the rotation; |r|/gap, '
    "radius of the rotor's orbit at the contact over the clearance; growth, rate of a small disturbance, negative where the "
    "whirl is stable.</p>"
)
WINDOWS = (
    '<p class="soft">Sections of the run, {word} ({short}) and predicted (pred). Lengths over the gap{at}: |r|, radius of the '
    "rotor's orbit at the contact; 1X, its line at the rotor speed. Whirl: frequency, negative against the rotation; - where "
    "there is none.</p>"
)


def table(header, rows, kind=""):
    """An HTML table; rows hold texts."""
    header, rows = in_units(header, rows)
    head = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<div class="scroll"><table class="{kind}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def answers(lines):
    """A list of (topic, text)."""
    return "<dl>" + "".join(f"<dt>{escape(topic)}</dt><dd>{escape(text)}</dd>" for topic, text in lines) + "</dl>"


def machine(report):
    """The rotor in numbers, "" of one that was not given by its stations."""
    scene = report.result.scene
    if not getattr(scene.rotor, "parts", None):
        return ""
    tables = [f"<h3>{title}</h3>{table(header, rows)}" for title, header, rows in machine_tables(scene)]
    return answers(machine_lines(scene, report.criticals)) + "".join(tables)


def whirls(report):
    """Where each predicted whirl begins and ends, and where the run changes from one to another."""
    header, rows = branches_cells(report.branches, report.contact)
    none = "<p>No whirl that slides is predicted over the speeds of the run.</p>"
    parts = [table(header, rows, "wrap") + WHIRLS if rows else none]
    parts += [f"<p>{escape(text)}</p>" for text in rolling_lines(report.motions)]
    for change in report.transitions:
        names = f"{change.before or 'no whirl'} to {change.after or 'no whirl'}"
        text = f"Change {names} at {frequency_text(change.taken_over, '.1f')}: {change.verdict}. {note_of_change(change)}."
        parts.append(f"<p>{escape(text)}</p>")
    return "".join(parts)


def motions(report):
    """The motions that last at the end of the run and where its motion changed."""
    parts = []
    for listed in report.motions:
        parts.append(f"<h3>{escape(speed_text(listed.speed))}</h3>")
        header, rows = motions_cells(listed)
        parts.append(table(header, rows, "wrap") if rows else "<p>No start settled in a motion that lasts.</p>")
        told = [*only_predicted(listed), claim(listed), least_friction(listed)]
        parts.append("<ul>" + "".join(f"<li>{escape(text)}</li>" for text in told) + "</ul>")
    return "".join(parts)


def limits(report):
    """The unbalance response compared with [limits] of the scene; empty without them."""
    if report.limits is None:
        return ""
    header, rows = limits_cells(report.limits)
    peaks = table(header, rows) if rows else "<p>The unbalance response has no peak.</p>"
    told = answers([*limits_lines(report.limits), ("note", SOURCE)])
    return f"<h3>Limits at {escape(report.limits.probe)}</h3>{peaks}{told}"


def windows(report, most=60):
    """Simulated or measured values compared with predicted ones, by window."""
    header, rows = window_cells(report, most)
    about = WINDOWS.format(at=escape(at_lead(report)), word=report.word, short=header[2].split()[1])
    return f"{about}{table(header, rows, 'wrap')}"


def assumptions(report):
    """What simulation and prediction take for granted, and how large the error can be here."""
    summary, fall = report.result.summary, report.fall
    rate = float(np.abs(np.diff(fall.speed) / np.diff(fall.time)).max(initial=0.0))
    rows = [
        *(_of_simulation(report) if summary else [("runout", _runout(report), "taken off with measured.slow_roll")]),
        (
            "1X lowered as the speed changes within a window",
            f"{100.0 * window_length.sweep_loss(rate, fall.window):.2g} % of its amplitude",
            f"windows of {fall.window:.3g} s at {rate:.3g} Hz/s",
        ),
    ]
    lag = report.best.lag[np.isfinite(report.best.lag)]
    if lag.size:
        largest = float(np.abs(lag).max())
        rows.append(("amplitude lag of the whirl", f"up to {100.0 * largest:.2g} %", "computed, part of the prediction"))
    reached = report.best.reached[np.isfinite(report.best.reached)]
    if reached.size:
        rows.append(("windows without a steady whirl", f"{(reached < 1.0).sum()}", "the unbalance ends it (harmonic balance)"))
    if summary and summary.least_diameter:
        text = f"contact.diameter > {length(summary.least_diameter)}"
        rows.append(("surfaces slide forward (12)", text, "a smaller journal would roll: give contact.diameter"))
    rows += [(f"agreement in the {name}", f"within {100.0 * tolerance:g} %", "") for name, tolerance in TOLERANCES.items()]
    notes = "".join(f"<li>{escape(sentence_in_units(note))}</li>" for note in report.remarks)
    return table(("assumption", "size in this run", ""), rows) + (f"<ul>{notes}</ul>" if notes else "")


def _of_simulation(report):
    """Table rows on the accuracy of a simulation."""
    summary, contacts = report.result.summary, report.result.scene.contacts
    gap = min(contact.gap for contact in contacts)
    pairs = zip(contacts, at_contacts(report.result), strict=True)
    share, of = max((own.whole().force_max / contact.stiffness / contact.gap, contact.gap) for contact, own in pairs)
    pressed_in = f"{100.0 * share:.2g} % of the gap ({length(share * of)})"
    ledger = summary.ledger
    lost = abs(ledger.residual) / ledger.turnover if ledger.turnover > 0.0 else 0.0
    return [
        ("error of a step", f"{summary.rtol:.2g} of the gap ({length(summary.rtol * gap)})", "chosen by solver.rtol"),
        ("energy that is not accounted for", f"{lost:.1e} of the turnover", f"expected below {LEDGER * summary.rtol:.0e}"),
        ("penetration of the contact", pressed_in, "a real one holds little"),
    ]


def _runout(report):
    """Size of the line at the rotor speed that was taken off a measured run."""
    runout = report.result.runout
    return f"1X of {length(abs(runout[len(runout) // 2 + 1]))}" if runout.any() else "none"


def origin(report):
    """Scene, versions and hashes."""
    toml = report.result.scene.to_toml()
    digest = hashlib.sha256(toml.encode()).hexdigest()
    summary = report.result.summary
    made = f"Made with {escape(summary.versions)}" if summary else f"Measured: {escape(report.result.source)}"
    return (
        f"<p>{made}. SHA-256 of the scene: <code>{digest[:HASHED]}</code></p>"
        f"{f'<pre>{escape(run_text(summary))}</pre>' if summary else ''}<h3>Scene, with every default</h3>"
        f'<pre class="long">{escape(toml)}</pre>'
    )
