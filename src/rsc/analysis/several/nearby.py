"""Whirls at several contacts in a system that differs little from the one they were found in."""

from collections.abc import Sequence
from math import tau as TWO_PI

import numpy as np

from rsc.analysis.several.condition import Whirling, newton, pressed
from rsc.analysis.several.described import described
from rsc.analysis.several.search import WhirlsOfSet
from rsc.analysis.several.whirl import SeveralWhirl
from rsc.system.system import System


def hardest(whirl: SeveralWhirl) -> str:
    """Name of the contact with the largest normal force in a whirl."""
    return max(whirl.contacts, key=lambda name: whirl.contacts[name].normal_force)


def nearby(system: System, whirls: Sequence[SeveralWhirl], speed: float) -> list[SeveralWhirl | None]:
    """Continue whirls to a System with slightly different values, by Newton's method from each of them.

    Parameters
    ----------
    system : System
        With the same contacts.
    whirls : sequence of SeveralWhirl
    speed : float, Hz

    Returns
    -------
    list of SeveralWhirl or None
        What belongs to one contact is that of the contact pressed hardest in the given whirl; None where Newton's method does not
        converge.
    """
    names = [contact.name for contact in system.contacts]
    made: list[SeveralWhirl | None] = []
    for whirl in whirls:
        contacts = tuple(names.index(name) for name in whirl.pressed)
        own, at = pressed(system, TWO_PI * speed, contacts), [whirl.contacts[name] for name in whirl.pressed]
        forces, phases = np.array([[one.normal_force, np.radians(one.phase)] for one in at]).T
        start = Whirling(np.array([TWO_PI * whirl.frequency]), forces[None], (phases - phases[0])[None])
        root, met = newton(own, start)
        of_set = WhirlsOfSet(contacts, own, root)
        made.append(described(system, of_set, speed, names.index(hardest(whirl)))[0] if met[0] else None)
    return made
