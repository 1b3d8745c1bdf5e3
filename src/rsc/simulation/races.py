"""Inner races for the kernel (`rsc.kernel.race`): one coordinate each, after those of the bodies."""

import numpy as np

from rsc.kernel.race import SIZE, RaceData
from rsc.simulation.lines import widened


def with_races(model, system):
    """The model with a coordinate for the race of every contact that has one."""
    places = places_of(system, model.stiffness.size)
    if not any(places):
        return model
    wide = widened(model, model.stiffness.size // 2 + sum(place > 0 for place in places))
    damping, scale_x, scale_v = wide.damping.copy(), wide.scale_x.copy(), wide.scale_v.copy()
    contacts = []
    for contact, source, place in zip(wide.contacts, system.contacts, places, strict=True):
        if place:
            row = np.zeros(damping.size)
            row[place] = 1.0 / SIZE
            radius = contact.surfaces.radius + contact.gap
            per_mass = SIZE**2 * radius**2 / source.law.race_inertia
            contact = contact._replace(race=RaceData(row, per_mass, radius, place))
            damping[place : place + 2] = -source.law.race_drag / source.law.race_inertia
            scale_x[place : place + 2] *= SIZE**2
            scale_v[place : place + 2] *= SIZE**2
        contacts.append(contact)
    return wide._replace(damping=damping, scale_x=scale_x, scale_v=scale_v, contacts=tuple(contacts))


def places_of(system, size):
    """For each contact the index of its race coordinate in a state vector, after `size` numbers of the bodies; 0 without a
    race."""
    places = []
    for contact in system.contacts:
        has = contact.law.race_inertia is not None
        places.append(size if has else 0)
        size += 2 * has
    return places


def begin(model, v, speeds):
    """Write surface velocities (n_contacts,) in m/s into the initial velocities of a run."""
    for contact, speed in zip(model.contacts, speeds, strict=True):
        if contact.race:
            v[contact.race.place] = SIZE * speed


def speeds_of(model, v):
    """Surface velocities (n_contacts,) in m/s from the kernel's velocities; None without a race."""
    if not any(contact.race for contact in model.contacts):
        return None
    return np.array([v[contact.race.place] / SIZE if contact.race else 0.0 for contact in model.contacts])
