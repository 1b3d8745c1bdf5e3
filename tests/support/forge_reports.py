"""Forged report.json: the analysis beside a result changed at random, but of this result and this version by its own words.

A case is a number, from which its changes follow, as in forge.py. Whatever it holds, reading ends with it or with an analysis
made anew, and what is read can be told and drawn.
"""

import copy
import json
import random
import warnings
from pathlib import Path

import rsc
import rsc.study.report.check
from forge import COUNTS, NUMBERS
from forge import TEXTS as FORGED_TEXTS
from fuzz_cases import case, damaged
from rsc.measure.kinds import Kind
from rsc.measure.reasons import Code
from rsc.measure.words import TOLERANCES, VERDICTS
from rsc.show.page import page
from rsc.show.pictures import report_pictures
from rsc.show.words.text import report_text
from rsc.study.report.stored import NAME, report_of, write_stored
from scenes import LAVAL, changed

LIMIT = 10.0  # s of processor time, of one case
EVERY = 20  # of so many cases the pictures of one are drawn on paper as well
TEXTS = (*FORGED_TEXTS, "$x^2$", "$\\frac{1}{0}$", "<script>alert(1)</script>", "</script>", "{x}", "%s", "roll", "seal", "nan")
WORDS = (*Kind, *Code, *VERDICTS, *TOLERANCES)
PLAIN = (None, True, False, [], {}, [[]], [None], "", -1, 10**30, 10**400, [[1.0, 2.0], [3.0]], {"a": 1}, [1, "x"])
WHIRLING = changed(
    LAVAL, drive={"speed": 30.0, "duration": 2.0, "inertia": 0.05, "torque": [[0.0, 7.0], [60.0, 6.0], [80.0, 0.0]]},
    contact={"diameter": 0.05}, start={"whirl": "backward"},
    clearance=[{"name": "seal", "rotor_coordinate": 0, "gap": 1.2e-3}, {"name": "oil", "rotor_coordinate": 0, "gap": 3e-3}],
    limits={"maximum_continuous": 50.0, "minimum": 45.0, "trip": 60.0, "probe": "seal"},
)  # fmt: skip
# what this run has none of
CHANGE = {
    "before": "A", "after": "B", "taken_over": 45.0, "first_seen": 44.0, "predicted": 44.5, "predicted_jump": 45.1, "folds": 3.0,
    "verdict": "agrees", "reasons": [{"code": "sets in", "names": [], "numbers": []}],
}  # fmt: skip
PEAK = {
    "branch": "A", "speed": 45.0, "height": 1e-4, "predicted_speed": 45.1, "predicted_height": 1.01e-4, "first_order_speed": 45.2,
    "first_order_height": 1.02e-4,
}  # fmt: skip


def original(folder):
    """(result file, its Report, content of its report.json) to begin with."""
    path = Path(folder, "result.h5")
    rsc.simulate(rsc.Scene.from_dict(WHIRLING), path=path)
    whole = rsc.study.report.check.report(rsc.load(path))
    write_stored(whole, path.with_name(NAME))
    content = json.loads(path.with_name(NAME).read_text())
    content |= {"transitions": [CHANGE], "resonances": [PEAK]}
    path.with_name(NAME).write_text(json.dumps(content))
    if report_of(whole.result, path).transitions[0].before != "A":
        raise AssertionError("the report.json to begin with is not read")
    return path, whole, content


def forged(content, dice):
    """The bytes of a forged report.json."""
    content = copy.deepcopy(content)
    for _ in range(dice.choice((1, 1, 1, 2, 3))):
        dice.choice(CHANGES)(content, dice)
    text = json.dumps(content)
    kind = dice.randrange(20)
    if kind == 0:
        return damaged(text.encode(), dice)
    if kind == 1:
        return dice.choice((b"", b"[]", b"null", b"[" * 10**5, b'{"a":' * 10**5, b"\xff\xfe", text.encode("utf-16")))
    if kind == 2:
        key = dice.choice(sorted(content))
        return (text[:-1] + f', {json.dumps(key)}: {json.dumps(dice.choice(PLAIN))}}}').encode()
    return text.encode("utf-8", "surrogatepass")


def _place(content, dice, wanted=lambda item: True):
    """(holder, key) of something in a tree, each branching chosen with the same chance; what holds `wanted`, if that is met."""
    for _ in range(20):
        holder, key = content, dice.choice(sorted(content))
        while isinstance(holder[key], dict | list) and holder[key] and dice.random() < 0.85:
            holder = holder[key]
            key = dice.choice(sorted(holder)) if isinstance(holder, dict) else dice.randrange(len(holder))
        if wanted(holder[key]):
            break
    return holder, key


def value(content, dice):
    """Something else in the place of anything."""
    holder, key = _place(content, dice)
    holder[key] = dice.choice((*PLAIN, *NUMBERS, *COUNTS, dice.choice(TEXTS), dice.choice(WORDS)))


def word(content, dice):
    """Another word in the place of a text."""
    holder, key = _place(content, dice, lambda item: isinstance(item, str))
    holder[key] = dice.choice((dice.choice(TEXTS), dice.choice(WORDS), "unheard of"))


def number(content, dice):
    """Another number, or all of a list."""
    holder, key = _place(content, dice, lambda item: isinstance(item, float))
    scaled = 3.0 * holder[key] if _is_number(holder[key]) else 0.0
    numbers = dice.sample(NUMBERS, 3) if dice.random() < 0.5 else [scaled]
    if isinstance(holder, list) and dice.random() < 0.5:
        holder[:] = [dice.choice(numbers) for _ in holder]
    else:
        holder[key] = dice.choice(numbers)


def _is_number(item):
    return isinstance(item, int | float) and abs(item) < 1e300


def length(content, dice):
    """A list that is longer, shorter, deeper, turned round or empty."""
    holder, key = _place(content, dice, lambda item: isinstance(item, list) and item)
    if isinstance(items := holder[key], list) and items:
        holder[key] = dice.choice((items[:-1], items[1:], items * 2, items * 50, items[::-1], [items], items[:1], [], items[0]))


def key(content, dice):
    """A key that is gone, another one, or one more."""
    holder, name = _place(content, dice)
    if isinstance(holder, dict):
        kept = holder.pop(name)
        if dice.random() < 0.5:
            holder[dice.choice(("x", *TEXTS[:8]))] = kept


def reason(content, dice):
    """A reason with names and numbers that it has not."""
    rows = content.get(dice.choice(("rows", "transitions")))
    row = dice.choice(rows) if rows and isinstance(rows, list) else None
    if isinstance(row, dict):
        names, numbers = ([dice.choice(kind) for _ in range(dice.randrange(3))] for kind in ((*TEXTS, *WORDS), (*NUMBERS, None)))
        row["reasons"] = [{"code": dice.choice([*Code, "unheard of"]), "names": names, "numbers": numbers}]


CHANGES = (value, value, word, word, word, number, number, length, length, key, reason, reason)


def one_report(number, folder, path, whole, content):
    """Read a forged report.json, tell it, and draw it; returns what became of it, in a word."""
    dice = random.Random(number)
    path.with_name(NAME).write_bytes(forged(content, dice))
    found = report_of(whole.result, path)
    if found is whole:
        return "made anew"
    text, drawn = report_text(found, True), page(found)
    if "<script>alert" in drawn:
        raise AssertionError("a text of the file is markup in the page")
    if not text.replace("\n", "").isprintable():
        raise AssertionError("a text of the file is no printable line")
    if number % EVERY == 0:
        report_pictures.draw(found, folder)
    return "used"


def reports(numbers, folder):
    """(case, outcome, seconds) of forged reports; an analysis that is made anew is the one of before."""
    path, whole, content = original(folder)
    anew, rsc.study.report.check.report = rsc.study.report.check.report, lambda result: whole
    try:
        warnings.simplefilter("ignore", RuntimeWarning)  # of 1e308 gaps no picture is right, and numpy says so
        for number in numbers:
            yield case(number, one_report, folder, path, whole, content, limit=LIMIT)
    finally:
        rsc.study.report.check.report = anew
