"""The whirls of a pressed set as they are told: deflections, margins, what they touch, growth and unbalance."""

from math import tau as TWO_PI
from typing import NamedTuple

import numpy as np

from rsc.analysis.paper.predict import Synchronous, SynchronousForm
from rsc.analysis.paper.whirls import DOMINANCE, WITHIN, sliding_margin
from rsc.analysis.several.growth import growths
from rsc.analysis.several.unbalance import largest, unbalance_lines
from rsc.analysis.several.whirl import AtContact, SeveralWhirl

_NONE = SynchronousForm(np.nan, np.nan, np.nan, np.nan, (np.nan, np.nan))  # the paper prints nothing of several contacts
_ABOVE = {"asynchronous_force_dominates": DOMINANCE}  # margins hold above 0 but for this


class _Place(NamedTuple):
    """Where nothing is pressed, a contact or a clearance: name, gap in m, row (N + M,) of both bodies, eccentric ring in m."""

    name: str
    gap: float
    row: np.ndarray
    ring: complex


def described(system, pressed_set, speed):
    """The `SeveralWhirl` of each whirl of a `WhirlsOfSet`, a list; speed in Hz."""
    own, whirls = pressed_set.own, pressed_set.whirls
    lines = unbalance_lines(system, own, whirls)
    moved = own.shapes(whirls), *lines[:2]
    places = _places(system, pressed_set.contacts)
    shares = np.array([largest(moved[0] @ p.row, moved[1] @ p.row + p.ring, moved[2] @ p.row)[1] / p.gap for p in places])
    shares = shares.reshape(len(places), len(whirls.Psi)).T
    rotor = [part[:, : system.n_rotor] @ own.rows[:, : system.n_rotor].T for part in moved]
    margins = _margins(own, whirls, rotor[0], lines[2], shares)
    forms = _forms(rotor, lines[2:], np.argmax(whirls.N, axis=1))
    told = []
    for i, growth in enumerate(growths(system, own, whirls)):
        conditions = {name: float(margin[i]) for name, margin in margins.items()}
        violated = tuple(name for name, margin in conditions.items() if not margin > _ABOVE.get(name, 0.0))
        hardest, frequency = int(np.argmax(whirls.N[i])), float(whirls.Psi[i]) / TWO_PI
        shape, order = moved[0][i], np.argsort(-shares[i], kind="stable")
        told.append(
            SeveralWhirl(
                speed=speed,
                frequency=frequency,
                rotor_amplitude=float(abs(rotor[0][i, hardest])),
                stator_amplitude=float(abs(own.rows[hardest, system.n_rotor :] @ shape[system.n_rotor :])),
                normal_force=float(whirls.N[i, hardest]),
                rotor_shape=shape[: system.n_rotor],
                stator_shape=shape[system.n_rotor :],
                growth_rate=growth.rate,
                growth_frequency=growth.frequency / TWO_PI,
                stable=growth.rate < 0.0 and WITHIN not in violated,
                admissible=not violated,
                conditions=conditions,
                violated=violated,
                synchronous=Synchronous(2.0 * frequency - speed, forms[i], _NONE),
                clearances={place.name: float(share) for place, share in zip(places, shares[i], strict=True)},
                touches=tuple(places[k].name for k in order if shares[i, k] >= 1.0),
                contacts=_at_contacts(system, pressed_set.contacts, whirls.N[i], shape),
            )
        )
    return told


def _places(system, contacts):
    """The `_Place` of each contact that is not pressed, and of each clearance."""
    others = [contact for j, contact in enumerate(system.contacts) if j not in contacts]
    return [
        _Place(place.name, place.gap, np.concatenate([place.rotor, -place.stator]), getattr(place, "ring", 0j))
        for place in (*others, *system.clearances)
    ]


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


def _forms(rotor, forces, hardest):
    """The `SynchronousForm` of each whirl at the contact that is pressed hardest; rotor: its whirl and lines there."""
    low, high = largest(*rotor)
    return [
        SynchronousForm(
            force=float(abs(forces[0][i, j])),
            mirror_force=float(abs(forces[1][i, j])),
            amplitude=float(abs(rotor[1][i, j])),
            mirror_amplitude=float(abs(rotor[2][i, j])),
            envelope=(float(low[i, j]), float(high[i, j])),
        )
        for i, j in enumerate(hardest)
    ]


def _at_contacts(system, pressed, forces, shape):
    """The `AtContact` of every contact, by name, given the forces (n,) of the pressed ones."""
    told, force_of = {}, dict(zip(pressed, forces.tolist(), strict=True))
    for j, contact in enumerate(system.contacts):
        d = complex(shape @ np.concatenate([contact.rotor, -contact.stator]))
        told[contact.name] = AtContact(force_of.get(j, 0.0), abs(d), abs(d) / contact.gap, float(np.degrees(np.angle(d))))
    return told
