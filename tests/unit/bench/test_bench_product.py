"""Scenes over the product of terms are scenes, and kinds of lines are found in sentences."""

import re
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[3] / "bench"))
from answers_product import KINDS, OUTCOMES, TERMS, kinds_said, product_scene


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
    lines += [("also possible", "no contact (leaves it at 20.00 Hz after 1 s, stops after 3 s)")]
    said = {"rolling", "kinds at several contacts", "drive takes", "heat and races", "also possible", "drive: leaves it"}
    assert kinds_said(lines) == said | {"drive: stops"}
    assert set(OUTCOMES) <= {name.partition(": ")[2] for name in KINDS} and all(re.compile(own) for _, own in KINDS.values())
