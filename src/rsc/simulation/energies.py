"""Energies of a run: what its bodies and springs hold, and the ledger of what was put in and taken out."""

import numpy as np

from rsc.kernel import model as kernel
from rsc.kernel import springs
from rsc.results.summary import Ledger
from rsc.simulation import driven
from rsc.simulation.stiffness import spring_matrix


@np.errstate(over="ignore", invalid="ignore")
def ledger_of(packed, work, n_rotor, energy_start):
    """The Ledger of a run from its Work; n_rotor: coordinates of the rotor; energy_start: `energy` of the start, J."""
    model, n = packed.model, 2 * n_rotor
    damped = -model.weight * work.ledger_damping
    energies = kernel.E_CONTACT, kernel.E_FRICTION, kernel.E_DRIVE
    lost, fed, ring = (kernel.of_contacts(work.real, i).tolist() for i in energies)
    energy_in = float((model.weight * work.ledger_input).sum() + sum(ring))
    turned, followed = (float(model.weight[0] * work.real[i]) for i in (kernel.E_ROTATING, kernel.E_FOLLOWING))
    energy_in += spring_energy(model, work) - followed  # booked as input but stored; only the work of skew springs is input
    friction, contact = sum(fed), sum(lost)
    change = energy(packed, work) - energy_start
    rotor, stator = float(damped[:n].sum()), float(damped[n:].sum())
    driven_in = 0.0
    if model.drive:  # the work of ring, rotating damping and friction (its heat too) comes from the rotation
        driven_in, braked = (float(work.real[i]) for i in (kernel.E_TORQUE, kernel.E_BRAKED))
        energy_in, turned, friction = energy_in - sum(ring), 0.0, friction - braked
    control = float(work.real[kernel.E_CONTROL])
    fed_in = energy_in + turned + followed + driven_in + control + friction
    residual = fed_in - rotor - stator - contact - change
    return Ledger(energy_in, friction, rotor, stator, contact, change, residual, turned, followed, driven_in, control)


@np.errstate(over="ignore", invalid="ignore")  # a run with status non_finite has infinite energies
def energy(packed, work):
    """Kinetic and elastic energy of rotor, stator and contact spring, J."""
    m = packed.model
    lateral = 0.5 * float((m.weight * (work.v**2 - m.stiffness * work.x**2)).sum())
    turns = work.real[kernel.PHASE]
    turning = driven.energy(m, work.v, turns) if m.drive else 0.0
    return float(lateral + turning + spring_energy(m, work) + sum(_pressed(data, work.x, turns) for data in m.contacts))


def _pressed(contact, x, turns):
    """Elastic energy of a contact spring, J."""
    ring = complex(*contact.ring) * np.exp(2j * np.pi * turns) if contact.ring else 0j
    d = (contact.contact_row * x).view(complex).sum() + ring
    d = d - complex(*contact.offset) if contact.offset else d
    return springs.power(contact.surfaces.spring, max(abs(d) - contact.gap, 0.0), 0.0)


def spring_energy(model, work):
    """Elastic energy in J of anisotropic and speed-dependent springs, in addition to that of `Model.stiffness`; skew ones store
    none: Re(conj(r) i S r) = 0."""
    interval = 0
    if model.drive:
        speed = driven.speed_of(model, work.v) / (2.0 * np.pi)
        interval = driven.interval_at(model, 2.0 * np.pi * speed) if len(model.following_stiffness) else 0
    else:
        speed = np.interp(work.real[kernel.T_HI], model.corner_time, model.corner_speed)
        interval = int(model.corner_interval[work.count[kernel.SEGMENT]]) if len(model.following_stiffness) else 0
    matrix = spring_matrix(model, interval, speed)
    return 0.0 if matrix is None else -0.5 * float((model.weight * work.x) @ matrix @ work.x)
