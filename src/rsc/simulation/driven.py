"""Torque-limited drives: data for the kernel, initial state, energy.

Angle and speed are the last pair of the kernel's vectors (`rsc.kernel.drive`), after the coordinates.
"""

import numpy as np

from rsc.kernel.drive import DriveData
from rsc.simulation.lines import size_of_class, widened

# m, state per rad of angle: a power of two, which loses no bits, and too small to count as a displacement anywhere
SIZE = 2.0**-40


def with_drive(model, system, fill):
    """The model with the drive of its system, padded to the size of its class (lines.py) if `fill`."""
    n = model.stiffness.size // 2
    source = system.drive
    if source is None:
        return widened(model, size_of_class(n)) if fill else model
    size = size_of_class(n + 1) if fill else n + 1
    wide = widened(model, size)
    spin = np.zeros(2 * size)
    spin[-2] = SIZE
    gap = min(contact.gap for contact in model.contacts)
    least = float(np.sqrt(model.scale_v.max())) / gap  # natural frequency of the rotor or the contact
    scale_x, scale_v = wide.scale_x.copy(), wide.scale_v.copy()
    scale_x[-2:], scale_v[-2:] = SIZE**2, (SIZE * least) ** 2
    tables = [_knots(torque) for torque in source.torques]
    euler, mass = wide.unbalance + wide.euler, float(model.weight[0])
    drive = DriveData(
        unbalance=wide.unbalance,
        euler=euler,
        spin=spin,
        tables=np.concatenate(tables),
        begins=np.cumsum([0, *map(len, tables)]).astype(float),
        knots=np.array(system.knot_speed) if len(system.knot_speed) else (),
        mass=mass,
        inertia=source.inertia - mass * float(euler @ euler),
        size=SIZE,
        least=least,
        weight=(source.weight.real, source.weight.imag) if source.weight else (),
    )
    nothing = np.zeros(2 * size)
    time = np.array([0.0, *source.ends])
    speed = np.full(len(time), source.fastest / (2.0 * np.pi))
    speed[0] = system.schedule_speed[0] / (2.0 * np.pi)
    corners = {"corner_time": time, "corner_speed": speed}
    if len(model.corner_interval):
        corners["corner_interval"] = np.zeros(len(time))  # unused: the speed determines it (`interval_at`)
    return wide._replace(unbalance=nothing, scale_x=scale_x, scale_v=scale_v, drive=drive, **corners)


def interval_at(model, Omega):
    """Index of the interval between knots of the coefficients that contains an integrated speed in rad/s."""
    return int(np.searchsorted(model.drive.knots, Omega))


def _knots(torque):
    """Knots (k, 3) of a torque curve: rad/s, N m, slope to the next knot (0 after the last)."""
    slopes = np.append(np.diff(torque[:, 1]) / np.diff(torque[:, 0]), 0.0)
    return np.column_stack([torque, slopes])


def begin(model, v):
    """Write the initial speed into the initial velocities of a run."""
    if model.drive:
        v[-2] = SIZE * 2.0 * np.pi * model.corner_speed[0]


def speed_of(model, v):
    """Rotor speed in rad/s from the kernel's velocities."""
    return v[-2] / model.drive.size


def energy(model, v, turns):
    """Energy in J besides that of the coordinates: J Omega^2/2 + Re(r'^H i Omega u) with u = U e^{i phi}, and -Re(w e^{-i phi})
    of the weight."""
    drive = model.drive
    speed, u = speed_of(model, v), drive.euler.view(complex) * np.exp(2j * np.pi * turns)
    height = 0.0
    if drive.weight:
        height = -(complex(*drive.weight) * np.exp(-2j * np.pi * turns)).real
    inertia = drive.inertia + drive.mass * float(drive.euler @ drive.euler)
    return height + 0.5 * inertia * speed**2 + drive.mass * speed * float((v.view(complex).conj() @ (1j * u)).real)
