"""The whirls of every pressed set of a system with several contacts, at one rotor speed."""

import itertools
from typing import NamedTuple

import numpy as np

from rsc.analysis.paper.whirls import steady_whirls
from rsc.analysis.several.condition import Pressed, Whirling, pressed, settled
from rsc.analysis.several.pairs import pair_candidates
from rsc.analysis.several.starts import grazing_candidates, ranges, secant_candidates
from rsc.system.system import FloatOrArray, System

MOST = 4  # pressed contacts that are looked at together: there are 2^n sets
COMPLETE = 2  # up to which no whirl is missing


class WhirlsOfSet(NamedTuple):
    """The whirls at one pressed set: numbers of its contacts, rising, and what they obey; whether they touch others is open."""

    contacts: tuple[int, ...]
    own: Pressed
    whirls: Whirling


def whirls_of_sets(system: System, Omega: FloatOrArray):
    """Whirls of a System at a rotor speed in rad/s, a list of `WhirlsOfSet`, small sets first.

    Of one contact they are all roots of its whirl condition, of two all that the scan finds; of three and more what Newton's
    method reaches from secant stiffnesses and from whirls of one contact less: that none is missing is not shown. Sets of more
    than `MOST` are not looked at.
    """
    n = len(system.contacts)
    sets: dict[tuple[int, ...], WhirlsOfSet] = {}
    for size in range(1, min(n, MOST) + 1):
        for contacts in itertools.combinations(range(n), size):
            own = pressed(system, Omega, contacts)
            sets[contacts] = WhirlsOfSet(contacts, own, _whirls(system, own, contacts, sets))
    return [own for own in sets.values() if len(own.whirls.Psi)]


def _whirls(system: System, own, contacts, sets):
    """The `Whirling` of one set, given those of all smaller ones."""
    if own.n == 1:
        Psi, F_N = steady_whirls(system.at_contact(system.contacts[contacts[0]].name), own.Omega)
        return Whirling(Psi, F_N[:, None], np.zeros((len(Psi), 1)))
    bounds = ranges(own, system.driven)
    if own.n == 2:
        return settled(own, pair_candidates(own, bounds), bounds)
    parts = [secant_candidates(own, bounds)]
    for j in range(own.n):
        fewer = sets[contacts[:j] + contacts[j + 1 :]].whirls
        parts.append(grazing_candidates(own, j, fewer))
    return settled(own, Whirling(*(np.concatenate(each) for each in zip(*parts, strict=True))), bounds)
