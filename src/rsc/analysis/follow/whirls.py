"""The whirls of a scene over a parameter: all at some of its values, as seeds, and those at the points of a curve."""

from collections.abc import Iterator, Sequence
from math import tau as TWO_PI

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.follow.curve import Points, WhirlCurve
from rsc.analysis.follow.patience import Patience
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.predict import Whirl, whirls_of
from rsc.analysis.paper.receptance import contact_receptance
from rsc.analysis.paper.roots import roots_by_place
from rsc.analysis.paper.stability import Growth, whirl_growths
from rsc.analysis.paper.states import free_matrix
from rsc.analysis.paper.whirls import normal_force
from rsc.analysis.several.condition import Whirling
from rsc.analysis.several.described import described
from rsc.analysis.several.growth import growths
from rsc.analysis.several.search import WhirlsOfSet, whirls_of_sets
from rsc.system.body import Body
from rsc.system.system import System, stacked, together

# roots above this multiple of the highest natural frequency are not followed (without friction they go to infinity)
BEYOND = 1e3
# entries of a matrix of the systems that are solved together, so that all stay in the cache of the processor
_TOGETHER = 8192


def bound_at(curve: WhirlCurve, value: float) -> float:
    """Frequency in rad/s beyond which none is followed, at a value of the parameter."""
    system, speed = curve.at(value)
    return float(_bound(system, TWO_PI * speed))


def _bound(system: System, Omega: float | NDArray[np.float64]) -> NDArray[np.float64]:
    bodies = system.at_speed(Omega).joined()
    if bodies.n_states:
        return _bound_with_states(bodies, Omega)
    square = np.abs(np.linalg.eigvals(np.linalg.solve(bodies.mass, bodies.static))).max(axis=-1)
    turning, mass = (np.diagonal(matrix, axis1=-2, axis2=-1) for matrix in (bodies.turning(Omega), bodies.mass))
    return np.asarray(BEYOND * (np.sqrt(square) + np.abs(turning / mass).max(axis=-1)))


def _bound_with_states(bodies: Body, Omega: float | NDArray[np.float64]) -> NDArray[np.float64]:
    """`_bound` of bodies with first-order states, one or a stack."""
    stack = bodies.mass.ndim > 2
    speeds = np.broadcast_to(Omega, (len(bodies.mass),)) if stack else np.atleast_1d(Omega)
    bounds = []
    for i, speed in enumerate(speeds):
        bounds.append(BEYOND * np.abs(np.linalg.eigvals(free_matrix(bodies.at(i), speed))).max())
    return np.array(bounds) if np.ndim(Omega) or stack else np.asarray(bounds[0])


def seeds_at_one(curve: WhirlCurve, values: NDArray[np.float64], patience: Patience) -> list[Points]:
    """All backward roots of the whirl condition of one contact at some values, whatever the sign of their force, by frequency."""
    systems, speeds = curve.systems(values)
    system, Omega = together(systems), TWO_PI * speeds
    if system.rotor.mass.ndim == 2 and not system.turns:  # the same at every value
        (points,) = _roots(systems[:1], Omega[:1], values[:1])
        return [np.column_stack([points[:, :-1], np.full(len(points), value)]) for value in values]
    seeds: list[Points] = []
    many = max(1, _TOGETHER // (system.n_rotor + system.n_stator) ** 2)
    for i in range(0, len(values), many):
        patience.say(f"roots of the whirl condition are looked for, {i} of {len(values)} values done")
        block = slice(i, i + many)
        seeds += _roots(systems[block], Omega[block], values[block])
    return seeds


def _roots(systems: list[System], Omega: NDArray[np.float64], values: NDArray[np.float64]) -> list[Points]:
    stack = stacked(systems)
    place, Psi = roots_by_place(stack, Omega, only_met=True)
    followed = (Psi < 0.0) & (Psi > -np.broadcast_to(_bound(stack, Omega), Omega.shape)[place])
    place, Psi = place[followed], Psi[followed]
    system = together(systems).at(place)
    held = law_of(system).held(contact_receptance(system, Omega[place], Psi)[0].real)
    points = np.column_stack([Psi, np.arctan(held), values[place]])
    return [points[place == i] for i in range(len(values))]


def seeds_of_sets(
    system: System, speeds: NDArray[np.float64], patience: Patience
) -> dict[tuple[int, ...], list[tuple[float, Whirling]]]:
    """The whirls of every pressed set of several contacts that has some, at each of some speeds in Hz."""
    seeds: dict[tuple[int, ...], list[tuple[float, Whirling]]] = {}
    for count, speed in enumerate(speeds.tolist()):
        if count == 0 or system.turns:  # else the same at every speed
            sets = whirls_of_sets(system, TWO_PI * speed)
        for own in sets:
            seeds.setdefault(own.contacts, []).append((speed, own.whirls))
        patience.say(f"whirls of every pressed set at {count + 1} of {len(speeds)} speeds")
    return seeds


class WhirlsAtOne:
    """The whirls at the points of a curve of one contact.

    curve : WhirlCurve
    """

    def __init__(self, curve: WhirlCurve) -> None:
        self.curve = curve

    def whirls(self, points: Points) -> Sequence[Whirl]:
        """The whirls at points."""
        systems, speeds = self.curve.systems(points[:, -1])
        whirls: list[Whirl] = []
        of_each = _growths(systems, speeds, points[:, 0])
        many = max(1, _TOGETHER // (systems[0].n_rotor + systems[0].n_stator) ** 2)
        for i in range(0, len(points), many):
            block = slice(i, i + many)
            system, Psi = together(systems[block]), points[block, 0]
            F_N = normal_force(system, Psi, TWO_PI * speeds[block])
            whirls += whirls_of(system, Psi, F_N, speeds[block], of_each[block])
        return whirls

    def growth(self, point: Points) -> Growth:
        """The growth of small motions at one point."""
        return _growths(*self.curve.systems(point[-1:]), point[:1])[0]


class WhirlsOfCurve:
    """The whirls at the points of a curve of several contacts over the speed in Hz.

    curve : WhirlCurve
    at : int, number of the contact at which what is of one is told
    """

    def __init__(self, curve: WhirlCurve, at: int) -> None:
        self.curve, self.contact = curve, at

    def whirls(self, points: Points) -> Sequence[Whirl]:
        """The whirls at points."""
        return [whirl for system, own, speed in self._sets(points) for whirl in described(system, own, speed, self.contact)]

    def growth(self, point: Points) -> Growth:
        """The growth of small motions at one point."""
        ((system, own, _),) = self._sets(point[None])
        growth: Growth = growths(system, own.own, own.whirls)[0]
        return growth

    def _sets(self, points: Points) -> Iterator[tuple[System, WhirlsOfSet, float]]:
        whirls = self.curve.whirls(points)
        for i, speed in enumerate(points[:, -1].tolist()):
            one = Whirling(*(part[i : i + 1] for part in whirls))
            yield self.curve.at(speed)[0], WhirlsOfSet(self.curve.contacts, self.curve.pressed_at(speed), one), speed


def _growths(systems: list[System], speeds: NDArray[np.float64], Psi: NDArray[np.float64]) -> list[Growth]:
    """Growth rates of whirls, each computed once: without gyroscopics all speeds have the same."""
    keys = [
        (id(system), speed if system.turns else 0.0, psi)
        for system, speed, psi in zip(systems, speeds.tolist(), Psi.tolist(), strict=True)
    ]
    new = np.array(sorted({key: i for i, key in enumerate(keys)}.values()))
    system, Psi, Omega = together([systems[i] for i in new]), Psi[new], TWO_PI * speeds[new]
    rates = whirl_growths(system, Psi, normal_force(system, Psi, Omega), Omega)
    known = dict(zip((keys[i] for i in new), rates, strict=True))
    return [known[key] for key in keys]
