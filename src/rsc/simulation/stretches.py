"""Stretches of a run: their number, initial values, and the conversion of the kernel's sums to facts."""

import numpy as np

from rsc.kernel import facts as kernel
from rsc.kernel.contact import pressing
from rsc.measure.stretches import COLUMNS, EXTENTS

# largest number of stretches, and least length of one in longest steps: two periods of the rotor or the shaft
MOST_STRETCHES, LEAST_STEPS = 4096, 8


def stretch_length(h_max, duration):
    """Length of a stretch in s, an integer fraction of the duration in s."""
    return duration / max(1, min(MOST_STRETCHES, int(duration / (LEAST_STEPS * h_max))))


def room_for(model):
    """Zeros for the rows of finished stretches of a run, (contacts, n, N_ROW + N_WATCHED k) with k clearances."""
    width = kernel.N_ROW + kernel.N_WATCHED * len(model.watched_gaps)
    return np.zeros((len(model.contacts), round(model.corner_time[-1] / model.stretch) + 1, width))


def begun(model, x, v, turns=0.0):
    """Initial running stretches (contacts (N_STRETCH + N_WATCHED k),) of a run that starts with coordinates x (2n,) and rates v
    after `turns` of the shaft."""
    watched = _watched(model, x)
    return np.concatenate([part for data in model.contacts for part in (_begun(model, data, x, v, turns), watched)])


def _begun(model, contact, x, v, turns):
    """Initial values of the running stretch at a contact, (N_STRETCH,)."""
    stretch = np.zeros(kernel.N_STRETCH)
    pairs = (contact.rotor_row * x, contact.rotor_row * v, contact.contact_row * x, contact.contact_row * v)
    r, r_dot, d, d_dot = (values.view(complex).sum() for values in pairs)
    ring = complex(*contact.ring) * np.exp(2j * np.pi * turns) if contact.ring else 0j
    speed = 2.0 * np.pi * model.corner_speed[0]
    stator, d, d_dot = r - d, d + ring, d_dot + 1j * speed * ring
    d = d - complex(*contact.offset) if contact.offset else d
    stretch[kernel.BEGIN + kernel.D_Y], stretch[kernel.BEGIN + kernel.D_Z] = d.real, d.imag
    stretch[kernel.END + kernel.D_Y], stretch[kernel.END + kernel.D_Z] = d.real, d.imag
    stretch[kernel.ROTOR_MOST] = stretch[kernel.ROTOR_LEAST] = abs(r) ** 2
    stretch[kernel.STATOR_MOST], stretch[kernel.DEFLECTION] = abs(stator) ** 2, abs(d)
    if abs(d) > contact.gap:
        rate = (d_dot * d.conjugate()).real / abs(d)
        stretch[kernel.FORCE] = max(pressing(contact, abs(d) - contact.gap, min(rate, 0.0)), 0.0)
    stretch[kernel.SLOPE] = (r_dot * r.conjugate()).real
    stretch[kernel.RATE_Y], stretch[kernel.RATE_Z] = r_dot.real, r_dot.imag
    stretch[kernel.EXTENTS : kernel.EXTENTS + 4] = r.real, r.real, r.imag, r.imag
    stretch[kernel.UNTIL] = model.stretch
    return stretch


def _watched(model, x):
    """Initial values of the running stretch at the clearances, (N_WATCHED k,)."""
    d = np.array([(row * x).view(complex).sum() for row in model.watched_rows], dtype=complex)
    passed = np.where(abs(d) > np.array(model.watched_gaps), 0.0, np.inf)
    return np.column_stack([abs(d) ** 2, passed, d.real, d.real, d.imag, d.imag]).ravel()


def running_rows(model, stretch):
    """Rows (contacts, N_ROW + N_WATCHED k) of the running stretches, as if finished."""
    each = stretch.reshape(len(model.contacts), -1)
    return np.concatenate([each[:, : kernel.N_ROW], each[:, kernel.N_STRETCH :]], axis=1)


def facts_of(rows):
    """Facts (n, contacts (len(COLUMNS) + len(OF_CLEARANCE) k)) from the kernel's rows (contacts, n, N_ROW + N_WATCHED k),
    contacts side by side."""
    return np.hstack([_facts_of(of_contact) for of_contact in rows])


def _facts_of(rows):
    """Facts (n, len(COLUMNS) + len(OF_CLEARANCE) k) from the kernel's rows (n, N_ROW + N_WATCHED k) of one contact; the columns
    of each clearance come last."""
    begin, end = rows[:, kernel.BEGIN : kernel.END].T, rows[:, kernel.END : kernel.N_ROW].T
    # + 0.0: for the kernel -0.0 is above the axis, for arctan2 it is not
    angle, angle_end = (np.arctan2(marks[kernel.D_Z] + 0.0, marks[kernel.D_Y]) for marks in (begin, end))
    rise = end - begin
    with np.errstate(over="ignore"):  # for runs that diverged
        facts = {
            "end": end[kernel.TIME],
            "turns": rows[:, kernel.CROSSINGS] + (angle_end - angle) / (2.0 * np.pi),
            "pressed_turns": rows[:, kernel.PRESSED_ANGLE] / (2.0 * np.pi),
            "contact_time": rise[kernel.CONTACT_TIME],
            "rolling_time": rows[:, kernel.ROLLING],
            "onsets": rise[kernel.ONSETS],
            "friction_work": rise[kernel.FRICTION_WORK],
            "rotor_max": np.sqrt(rows[:, kernel.ROTOR_MOST]),
            "rotor_min": np.sqrt(rows[:, kernel.ROTOR_LEAST]),
            "stator_max": np.sqrt(rows[:, kernel.STATOR_MOST]),
            "deflection_max": rows[:, kernel.DEFLECTION],
            "force_max": rows[:, kernel.FORCE],
            "arc_y": rows[:, kernel.ARC_Y],
            "arc_z": rows[:, kernel.ARC_Z],
            "normal_impulse": rows[:, kernel.NORMAL],
            "friction_impulse": rows[:, kernel.TANGENTIAL],
            "drive_work": rows[:, kernel.GIVEN],
            "race_work": rows[:, kernel.RACED],
            "rotor_max_at": rows[:, kernel.ROTOR_TIME],
            "deflection_max_at": rows[:, kernel.DEFLECTION_TIME],
            "force_max_at": rows[:, kernel.FORCE_TIME],
        }
        facts |= {name: rows[:, kernel.EXTENTS + i] for i, name in enumerate(EXTENTS)}
    watched = rows[:, kernel.N_ROW :].copy()
    watched[:, kernel.MOST :: kernel.N_WATCHED] **= 0.5
    return np.column_stack([*(facts[name] for name in COLUMNS), watched])
