"""The whirls of a list with the letters that the branches of a report have, so that one letter is one whirl on its whole page."""

import itertools
import string
from collections.abc import Sequence
from dataclasses import replace

from rsc.analysis.follow.branch import Branch
from rsc.measure.catalogue import Motions, Predicted

SAME = 0.02  # of the frequency: a list's speed may stand between two of the speeds that branches are known at


def lettered(listed: Motions, branches: Sequence[Branch]) -> Motions:
    """A list of one contact whose whirls are called as the branch that they are on; one on no branch gets a letter that no branch
    has. What has a name (rolling, forward rub) keeps it."""
    known = {branch.label: whirl.frequency for branch in branches if (whirl := branch.at(listed.speed)) is not None}
    spare = (letter for letter in _letters() if letter not in {branch.label for branch in branches})
    names: dict[str, str] = {}

    def named(one: Predicted) -> Predicted:
        if one.forces or not one.label.isupper():
            return one
        if one.label not in names:
            free = {label: abs(value / one.frequency - 1.0) for label, value in known.items() if label not in names.values()}
            nearest = min(free, key=lambda label: free[label], default="")
            names[one.label] = nearest if nearest and free[nearest] < SAME else next(spare)
        return replace(one, label=names[one.label])

    return replace(
        listed,
        motions=[replace(motion, predicted=motion.predicted and named(motion.predicted)) for motion in listed.motions],
        not_reached=[named(one) for one in listed.not_reached],
        leaving=[named(one) for one in listed.leaving],
    )


def _letters() -> itertools.chain[str]:
    """Letters in their order, then pairs of them."""
    return itertools.chain(string.ascii_uppercase, (f"A{letter}" for letter in string.ascii_uppercase), itertools.repeat("?"))
