"""The whirls of a pressed set as they are told: deflections, margins, what they touch, growth and unbalance."""

from math import tau as TWO_PI
from typing import Any, NamedTuple

import numpy as np

from rsc.analysis.paper.predict import Mirror, Synchronous, SynchronousForm
from rsc.analysis.paper.whirls import CIRCULAR, DOMINANCE, MOST_MIRROR, WITHIN, sliding_margin
from rsc.analysis.several.growth import growths
from rsc.analysis.several.unbalance import direction_lines, largest, unbalance_lines
from rsc.analysis.several.whirl import AtContact, SeveralWhirl
from rsc.system.system import System

_NONE = SynchronousForm(np.nan, np.nan, np.nan, np.nan, (np.nan, np.nan))  # the paper prints nothing of several contacts
_ABOVE = {"asynchronous_force_dominates": DOMINANCE}  # margins hold above 0 but for this


class _Place(NamedTuple):
    """Where nothing is pressed, a contact or a clearance: name, gap in m, row (N + M,) of both bodies, eccentric ring in m."""

    name: str
    gap: float
    row: np.ndarray
    ring: complex


def described(system: System, pressed_set, speed, at=None):
    """The `SeveralWhirl` of each whirl of a `WhirlsOfSet`, a list; speed in Hz. What is of one contact is told at the contact of
    number `at`, by default at the one that is pressed hardest."""
    own, whirls = pressed_set.own, pressed_set.whirls
    lines = unbalance_lines(system, own, whirls)
    moved = [part[:, : system.n_rotor + system.n_stator] for part in (own.shapes(whirls), *lines[:2])]
    places = _places(system, pressed_set.contacts)
    shares = np.array([largest(moved[0] @ p.row, moved[1] @ p.row + p.ring, moved[2] @ p.row)[1] / p.gap for p in places])
    shares = shares.reshape(len(places), len(whirls.Psi)).T
    rotor = [part[:, : system.n_rotor] @ own.rows[:, : system.n_rotor].T for part in moved]
    margins = _margins(own, whirls, rotor[0], lines[2], shares)
    pressed = np.array(pressed_set.contacts)
    shown = pressed[np.argmax(whirls.N, axis=1)] if at is None else np.full(len(whirls.Psi), at)
    forms = _forms([_everywhere(system, part) for part in moved], [_of_all(system, pressed, part) for part in lines[2:]], shown)
    normal = _of_all(system, pressed, whirls.N)
    mirrors = [None] * len(whirls.Psi)
    if not system.isotropic:
        mirrors = _mirrors(system, pressed_set, moved[0], shown)
        margins[CIRCULAR] = np.array([MOST_MIRROR - mirror.share for mirror in mirrors])
    told = []
    for i, growth in enumerate(growths(system, own, whirls)):
        conditions = {name: float(margin[i]) for name, margin in margins.items()}
        violated = tuple(name for name, margin in conditions.items() if not margin > _ABOVE.get(name, 0.0))
        frequency, place = float(whirls.Psi[i]) / TWO_PI, system.contacts[shown[i]]
        shape, order = moved[0][i], np.argsort(-shares[i], kind="stable")
        told.append(
            SeveralWhirl(
                speed=speed,
                frequency=frequency,
                rotor_amplitude=float(abs(place.rotor @ shape[: system.n_rotor])),
                stator_amplitude=float(abs(place.stator @ shape[system.n_rotor :])),
                normal_force=float(normal[i, shown[i]]),
                rotor_shape=shape[: system.n_rotor],
                stator_shape=shape[system.n_rotor :],
                growth_rate=growth.rate,
                growth_frequency=growth.frequency / TWO_PI,
                stable=growth.rate < 0.0 and not {CIRCULAR, WITHIN} & set(violated),
                admissible=not violated,
                conditions=conditions,
                violated=violated,
                synchronous=Synchronous(2.0 * frequency - speed, forms[i], _NONE),
                mirror=mirrors[i],
                clearances={place.name: float(share) for place, share in zip(places, shares[i], strict=True)},
                touches=tuple(places[k].name for k in order if shares[i, k] >= 1.0),
                contacts=_at_contacts(system, pressed_set.contacts, whirls.N[i], shape),
            )
        )
    return told


def _places(system: System, contacts):
    """The `_Place` of each contact that is not pressed, and of each clearance."""
    others = [contact for j, contact in enumerate(system.contacts) if j not in contacts]
    places: list[Any] = [*others, *system.clearances]
    return [_Place(p.name, p.gap, np.concatenate([p.rotor, -p.stator]), getattr(p, "ring", 0j)) for p in places]


def _margins(own, whirls, rotor, force, shares):
    """Least margin (m,) of each side condition over the pressed contacts, by its name as `rsc.analysis.paper.whirls` tells it."""
    distances = own.distances(whirls.N)
    with np.errstate(divide="ignore"):
        dominance = np.abs(own.turn) * whirls.N / np.abs(force)
    sliding = [sliding_margin(law, whirls.Psi, distances[:, j], own.Omega) for j, law in enumerate(own.laws)]
    margins = {
        "normal_force_positive": whirls.N,
        "asynchronous_force_dominates": dominance,
        "rotor_amplitude_exceeds_gap": np.abs(rotor) / own.gap - 1.0,
        "sliding": np.array(sliding).T,
    }
    if shares.shape[1]:
        margins[WITHIN] = 1.0 - shares
    return {name: margin.min(axis=1) for name, margin in margins.items()}


def _everywhere(system: System, shapes):
    """Displacements (m, n) of the rotor at every contact, of shapes (m, N + M)."""
    return shapes[:, : system.n_rotor] @ np.array([contact.rotor for contact in system.contacts]).T


def _of_all(system: System, pressed, values):
    """Values (m, n) at every contact, of those at the pressed ones; 0 at the others."""
    told = np.zeros((len(values), len(system.contacts)), values.dtype)
    told[:, pressed] = values
    return told


def _forms(rotor, forces, shown):
    """The `SynchronousForm` of each whirl at one of the contacts; rotor: its whirl and lines at all of them."""
    low, high = largest(*rotor)
    return [
        SynchronousForm(
            force=float(abs(forces[0][i, j])),
            mirror_force=float(abs(forces[1][i, j])),
            amplitude=float(abs(rotor[1][i, j])),
            mirror_amplitude=float(abs(rotor[2][i, j])),
            envelope=(float(low[i, j]), float(high[i, j])),
        )
        for i, j in enumerate(shown)
    ]


def _mirrors(system: System, pressed_set, shapes, shown):
    """The `Mirror` of each whirl: its share at the pressed contact where it is largest, the rest at the one that is shown."""
    lines = direction_lines(system, pressed_set.own, pressed_set.whirls)
    rotor = [_everywhere(system, part) for part in (shapes, *lines)]
    share = (np.abs(rotor[1]) / np.abs(rotor[0]))[:, list(pressed_set.contacts)].max(axis=1)
    low, high = largest(*rotor)
    return [
        Mirror(
            frequency=-float(Psi) / TWO_PI,
            share=float(share[i]),
            amplitude=float(abs(rotor[1][i, j])),
            third_amplitude=float(abs(rotor[2][i, j])),
            envelope=(float(low[i, j]), float(high[i, j])),
        )
        for i, (j, Psi) in enumerate(zip(shown, pressed_set.whirls.Psi, strict=True))
    ]


def _at_contacts(system: System, pressed, forces, shape):
    """The `AtContact` of every contact, by name, given the forces (n,) of the pressed ones."""
    told, force_of = {}, dict(zip(pressed, forces.tolist(), strict=True))
    for j, contact in enumerate(system.contacts):
        d = complex(shape @ np.concatenate([contact.rotor, -contact.stator]))
        told[contact.name] = AtContact(force_of.get(j, 0.0), abs(d), abs(d) / contact.gap, float(np.degrees(np.angle(d))))
    return told
