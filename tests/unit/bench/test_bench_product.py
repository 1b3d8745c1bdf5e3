"""Scenes over the product of terms are scenes, and kinds of lines are found in sentences."""

import re
import sys
from pathlib import Path

import pytest

import rsc

sys.path.append(str(Path(__file__).parents[3] / "bench"))
from answers_product import KINDS, OUTCOMES, Table, kinds_said, sayings
from product_lines import judged
from product_scenes import TERMS, product_scene
from product_witness import ProductWitness
from tiers import first


def test_every_combination_of_terms_is_drawn_and_is_a_scene():
    drawn = [product_scene(1, number) for number in range(3 * 2 ** len(TERMS))]
    assert len({(len(scene.contacts), frozenset(terms)) for scene, terms in drawn}) == len(drawn)
    for scene, terms in drawn:
        assert (scene.drive.inertia is not None) == ("torque" in terms)
        assert any(contact.race_inertia is not None for contact in scene.contacts) == ("race" in terms)
    assert product_scene(1, 5)[0] == product_scene(1, 5)[0] != product_scene(2, 5)[0]


def test_kinds_of_lines_are_found():
    lines = [("whirl", "backward whirl, rolling at seal and bush")]
    lines += [("drive", "rub torque on the shaft up to 5 N m (heat 1 J, inner races 2 J)")]
    lines += [("held", "no contact: the rotor leaves it at 20.00 Hz after 1 s, stops after 3 s")]
    said = {"run: rolling", "run: kinds at several contacts", "drive takes", "drive: heat and races", "drive: leaves it"}
    assert kinds_said(lines) == said | {"drive: stops"}
    assert {f"drive: {name}" for name in OUTCOMES} <= set(KINDS) and all(re.compile(own) for _, own in KINDS.values())


@pytest.mark.parametrize("number", first([0, 12]))
def test_no_line_of_a_scene_is_false(number):
    scene, terms = product_scene(1, number)
    told = list(sayings(scene, terms))
    table = Table()
    assert len(told) > 12 and table.add(told, terms) == []
    assert table.said["frequency"] + table.said["run: no backward whirl"] and not table.false


def test_false_lines_are_found():
    """Of a run with another friction than the judge is told of."""
    scene, _ = product_scene(1, 6)
    report = rsc.check(scene)
    rougher = scene.with_values({"contact.friction": 1.5 * scene.contact.friction})
    problems = {topic: own for topic, _, own in judged(report, ProductWitness(report, rougher)) if any(own)}
    assert {"force", "drive"} <= set(problems)
