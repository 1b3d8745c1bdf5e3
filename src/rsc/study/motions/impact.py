"""The smallest impact that starts a whirl, at a cost that is bounded by that of the list of motions it belongs to.

`rsc.study.motions.smallest_impulse` looks harder, in every direction and at every size; what is found here is an upper
bound of that.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rsc.measure.catalogue import WHIRLING, Motions, SmallestImpact
from rsc.measure.stretches import side_by_side
from rsc.simulation.shot import Shot, packed_for_shots
from rsc.study.motions.search import Search
from rsc.study.motions.settle import ATTEMPTS, PERIODS, same
from rsc.system.assemble import assemble

DIRECTIONS = 6  # evenly from that of the smallest random impact that starts a whirl
HALVINGS, BISECTIONS = 8, 3  # of the size, until it starts none; then of what lies between: down to a sixteenth
TOUCH = 0.02  # of the slowest period: stretches in which the first touch is looked for, over two of them


def with_smallest(search: Search, listed: Motions) -> Motions:
    """A list of motions of a search with the smallest impact that starts a whirl, where any of its own impacts does."""
    size = np.hypot(*listed.impulse.T)
    whirls = [i for i, motion in enumerate(listed.motions) if motion.motion in WHIRLING]
    started = np.flatnonzero(np.isin(listed.ended, whirls))
    if not len(started) or listed.interrupted:
        return listed
    first = int(started[np.argmin(size[started])])
    place = first % len(search.changes)
    looked = _Looked(search, complex(*listed.impulse[first]), int(listed.ended[first]), place, whirls)
    looked.halve()
    looked.bisect()
    smallest, motions = looked.smallest(), list(listed.motions)
    least = float(np.fmin(motions[smallest.motion].smallest_impulse, smallest.impulse))
    motions[smallest.motion] = replace(motions[smallest.motion], smallest_impulse=least)
    return replace(listed, motions=motions, smallest=smallest, runs=search.settling.runs)


class _Looked:
    """Impacts at one contact in some directions; the smallest so far that starts a whirl of the list."""

    def __init__(self, search: Search, impulse: complex, motion: int, place: int, whirls: list[int]) -> None:
        self._search, self._place, self._whirls = search, place, whirls
        self._turns = np.exp(2j * np.pi * np.arange(DIRECTIONS) / DIRECTIONS) * impulse / abs(impulse)
        self._known = [group[0] for group in search.groups]
        self._last_look = 2 * search.settling.looks  # no more than the list has cost
        self.impulse, self.motion, self.below = impulse, motion, 0.0

    def halve(self) -> None:
        """Halve the size until no direction starts a whirl."""
        for _ in range(HALVINGS):
            if not self._start(0.5 * abs(self.impulse)):
                break

    def bisect(self) -> None:
        """Bisect between the smallest impact that starts a whirl and the next smaller one."""
        for _ in range(BISECTIONS if self.below else 0):
            self._start(0.5 * (self.below + abs(self.impulse)))

    def _start(self, size: float) -> bool:
        """Whether an impact of a size starts a whirl in any direction; one that has not settled does not."""
        if self._search.settling.looks >= self._last_look or self._search.settling.interrupted:
            return False
        impulses = size * self._turns
        ends = self._search.after(impulses, [self._place] * len(impulses), self._known)
        for impulse, end in zip(impulses.tolist(), ends, strict=False):
            for i in self._whirls if end.settled else ():
                if same(self._known[i], end, self._search.settling.gaps):
                    self.impulse, self.motion = impulse, i
                    return True
        self.below = size
        return False

    def smallest(self) -> SmallestImpact:
        """What was found."""
        search, contact = self._search, self._search.system.contacts[self._place]
        force = first_force(search, self.impulse, self._place)
        return SmallestImpact(
            impulse=abs(self.impulse),
            direction=float(np.angle(self.impulse, deg=True)) % 360.0,
            velocity=abs(self.impulse) * float(search.changes[self._place] @ contact.rotor),
            over_touching=abs(self.impulse) / search.sizes.touching(self._place, np.angle([self.impulse]))[0],
            below=self.below,
            directions=DIRECTIONS,
            motion=self.motion,
            first_force=force,
            first_penetration=contact.law.depth(force) / contact.gap,
            rotor_velocity=abs(self.impulse) / search.scene.rotor.total_mass,
            contact=contact.name if len(search.changes) > 1 else "",
        )


def first_force(search: Search, impulse: complex, place: int) -> float:
    """Largest normal force in N at any contact of the first touch after an impact in N s at a contact; 0 without one in two
    periods of the slowest free vibration."""
    slowest = search.settling.block / PERIODS
    scene = search.scene.steady(search.speed, 2.0 * slowest)
    shot = Shot(packed_for_shots(assemble(scene), scene, TOUCH * slowest), search.hit(impulse, place), search.base_turns)
    while shot.advance(ATTEMPTS):
        pass
    return _first_touch(shot.facts(), len(search.system.contacts))


def _first_touch(rows: NDArray[np.float64], n_contacts: int) -> float:
    """The largest force in the first stretches in a row that have contact."""
    each = side_by_side(rows, n_contacts)
    touching = np.any([own.contact_time > 0.0 for own in each], axis=0)
    if not touching.any():
        return 0.0
    begin = int(np.argmax(touching))
    count = int(np.argmin(touching[begin:])) or len(touching)
    return max(float(own.force_max[begin : begin + count].max()) for own in each)
