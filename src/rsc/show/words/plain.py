"""Reports, predictions and results as plain structures for JSON."""

import dataclasses
import math

from rsc.show.words.answer import answer
from rsc.show.words.at_contacts import contacts_plain
from rsc.show.words.clearances import watched
from rsc.show.words.reasons import note, note_of_change
from rsc.show.words.units import SI, shown_in
from rsc.show.words.verdict import sentences


def plain(value):
    """A structure of dataclasses, arrays and numbers as JSON can hold it; NaN and infinity become null."""
    if dataclasses.is_dataclass(value):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, str):
        return str(value)
    return value


def whirls_plain(whirls, ratios, loads=()):
    """The whirls at one speed, each with its force ratios to others as `towards`, and what it takes from a drive with a
    torque as `loads`."""
    plains = [
        {**plain(whirl), "towards": [plain(ratio) for ratio in ratios if ratio.frequency == whirl.frequency]} for whirl in whirls
    ]
    return [own | ({"loads": plain(loads[i])} if loads else {}) for i, own in enumerate(plains)]


def report_plain(report):
    """A Report without its samples, in SI whatever units are shown elsewhere."""
    with shown_in(SI):
        return _report_plain(report)


def _report_plain(report):
    """The same in the units that are chosen."""
    return {
        "title": report.result.scene.title,
        "answer": [{"topic": topic, "text": text} for topic, text in answer(report)],
        "verdict": verdict_plain(report.verdict),
        "agreement": report.agreement,
        "warnings": report.warnings,
        "remarks": report.remarks,
        "resonances": plain(report.resonances),
        "resonance": plain(report.resonance),
        "transitions": [plain(change) | {"note": note_of_change(change)} for change in report.transitions],
        "rows": [plain(row) | {"note": note(row)} for row in report.rows],
        "branches": [_branch_plain(b) for b in report.branches],
        "summary": plain(report.result.summary),
        "clearances": watched(report.result.scene, report.stretches),
        "border": plain(report.border),
        "limits": plain(report.limits),
        "window": report.fall.window,
        "best": plain(report.best),
        "natural": plain(report.natural),
        "rub": plain(report.rub),
        "alone": plain(report.alone),
        "motions": plain(report.motions),
        "nearest": plain(report.nearest),
        "lead": report.lead,
        "contacts": contacts_plain(report),
    }


def verdict_plain(verdict):
    """A Verdict with its sentences for JSON; None without one."""
    if verdict is None:
        return None
    return {"severity": str(verdict.severity), "sentences": sentences(verdict), "facts": plain(verdict)}


def survey_plain(survey):
    """A Survey without the scene."""
    return {
        "title": survey.scene.title,
        "branches": [_branch_plain(b) for b in survey.branches],
        "force_ratios": plain(survey.ratios),
        "forward_rubs": plain(survey.rubs),
        "attractors": plain(survey.attractors),
        "delays": plain(survey.delays),
        "loads": plain(survey.loads),
        "remarks": survey.remarks,
    }


def _branch_plain(branch):
    return {
        "label": branch.label,
        "speed": plain(branch.speed),
        "frequency": plain(branch.frequency),
        "rotor_amplitude": plain(branch.amplitude),
        "normal_force": plain(branch.normal_force),
        "envelope": plain([branch.envelope(0), branch.envelope(1)]),
        "growth_rate": plain(branch.growth_rate),
        "stable": plain(branch.stable),
        "touches": plain(branch.touches),
        "pressed": plain(branch.pressed),
        "at_contacts": plain(branch.at_contacts),
        "stability_lost": plain(branch.lost),
        "events": plain([branch.begin, *branch.events, branch.end]),
    }
