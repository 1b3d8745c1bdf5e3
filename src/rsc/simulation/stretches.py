"""The stretches of a run: how many there are, what the first begins with, and the kernel's sums turned into facts."""

import numpy as np

from rsc.kernel import facts as kernel
from rsc.kernel.contact import pressing
from rsc.measure.stretches import COLUMNS

# stretches of a run of any length, and steps of the longest kind that one lasts at least: two periods of the rotor or the shaft
MOST_STRETCHES, LEAST_STEPS = 4096, 8


def stretch_length(h_max, duration):
    """Length of a stretch, s: a run of `duration` s has a whole number of them."""
    return duration / max(1, min(MOST_STRETCHES, int(duration / (LEAST_STEPS * h_max))))


def room_for(model):
    """Memory for the rows of the finished stretches of a run, (n, N_ROW + N_WATCHED k) with k clearances."""
    width = kernel.N_ROW + kernel.N_WATCHED * len(model.watched_gaps)
    return np.zeros((round(model.corner_time[-1] / model.stretch) + 1, width))


def begun(model, x, v, turns=0.0):
    """The running stretch (N_STRETCH + N_WATCHED k,) of a run that begins with coordinates x (2n,) and rates v after turns of the
    shaft."""
    stretch = np.zeros(kernel.N_STRETCH)
    pairs = (model.rotor_row * x, model.rotor_row * v, model.contact_row * x, model.contact_row * v)
    r, r_dot, d, d_dot = (values.view(complex).sum() for values in pairs)
    ring = complex(*model.ring) * np.exp(2j * np.pi * turns) if model.ring else 0j
    speed = 2.0 * np.pi * model.corner_speed[0]
    stator, d, d_dot = r - d, d + ring, d_dot + 1j * speed * ring
    stretch[kernel.BEGIN + kernel.D_Y], stretch[kernel.BEGIN + kernel.D_Z] = d.real, d.imag
    stretch[kernel.END + kernel.D_Y], stretch[kernel.END + kernel.D_Z] = d.real, d.imag
    stretch[kernel.ROTOR_MOST] = stretch[kernel.ROTOR_LEAST] = abs(r) ** 2
    stretch[kernel.STATOR_MOST], stretch[kernel.DEFLECTION] = abs(stator) ** 2, abs(d)
    if abs(d) > model.gap:
        rate = (d_dot * d.conjugate()).real / abs(d)
        stretch[kernel.FORCE] = max(pressing(model, abs(d) - model.gap, min(rate, 0.0)), 0.0)
    stretch[kernel.SLOPE] = (r_dot * r.conjugate()).real
    stretch[kernel.UNTIL] = model.stretch
    return np.concatenate([stretch, _watched(model, x)])


def _watched(model, x):
    """What the running stretch begins with at its clearances, (N_WATCHED k,)."""
    deflections = np.array([abs((row * x).view(complex).sum()) for row in model.watched_rows])
    passed = np.where(deflections > np.array(model.watched_gaps), 0.0, np.inf)
    return np.column_stack([deflections**2, passed]).ravel()


def running_row(stretch):
    """The row (N_ROW + N_WATCHED k,) of a running stretch, as if it had finished."""
    return np.concatenate([stretch[: kernel.N_ROW], stretch[kernel.N_STRETCH :]])


def facts_of(rows):
    """Facts (n, len(COLUMNS) + 2 k) of the kernel's rows (n, N_ROW + N_WATCHED k), each by itself: after those that every run has
    the largest deflection in m at each clearance, and the time in s at which the run first passed its gap."""
    begin, end = rows[:, kernel.BEGIN : kernel.END].T, rows[:, kernel.END : kernel.N_ROW].T
    # + 0.0: the kernel counts -0.0 as above the axis, arctan2 does not
    angle, angle_end = (np.arctan2(marks[kernel.D_Z] + 0.0, marks[kernel.D_Y]) for marks in (begin, end))
    rise = end - begin
    with np.errstate(over="ignore"):  # a run that diverged
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
        }
    watched = rows[:, kernel.N_ROW :].copy()
    watched[:, kernel.MOST :: kernel.N_WATCHED] **= 0.5
    return np.column_stack([*(facts[name] for name in COLUMNS), watched])
