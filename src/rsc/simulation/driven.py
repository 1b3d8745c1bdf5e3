"""A drive with a torque as the kernel takes it: its data, what a run of it begins with, its energy.

Angle and speed are the last pair of the kernel's numbers (`rsc.kernel.drive`), behind those of the coordinates.
"""

import numpy as np

from rsc.kernel.drive import DriveData
from rsc.simulation.lines import size_of_class, widened

# m, of the state for an angle of 1 rad: a power of two, so that no bit is lost, and so small that nothing takes it for a motion
SIZE = 2.0**-40


def with_drive(model, system, fill):
    """The model with as many coordinates as its class asks for (lines.py) if `fill`, and with the drive of its system."""
    n = model.stiffness.size // 2
    own = system.drive
    if own is None:
        return widened(model, size_of_class(n)) if fill else model
    size = size_of_class(n + 1) if fill else n + 1
    wide = widened(model, size)
    spin = np.zeros(2 * size)
    spin[-2] = SIZE
    gap = min(contact.gap for contact in model.contacts)
    least = float(np.sqrt(model.scale_v.max())) / gap  # the rotor's or the contact's own frequency
    scale_x, scale_v = wide.scale_x.copy(), wide.scale_v.copy()
    scale_x[-2:], scale_v[-2:] = SIZE**2, (SIZE * least) ** 2
    tables = [_knots(torque) for torque in own.torques]
    euler, mass = wide.unbalance + wide.euler, float(model.weight[0])
    drive = DriveData(
        unbalance=wide.unbalance,
        euler=euler,
        spin=spin,
        tables=np.concatenate(tables),
        begins=np.cumsum([0, *map(len, tables)]).astype(float),
        knots=np.array(system.knot_speed) if len(system.knot_speed) else (),
        mass=mass,
        inertia=own.inertia - mass * float(euler @ euler),
        size=SIZE,
        least=least,
        weight=(own.weight.real, own.weight.imag) if own.weight else (),
    )
    nothing = np.zeros(2 * size)
    time = np.array([0.0, *own.ends])
    speed = np.full(len(time), own.fastest / (2.0 * np.pi))
    speed[0] = system.schedule_speed[0] / (2.0 * np.pi)
    corners = {"corner_time": time, "corner_speed": speed}
    if len(model.corner_interval):
        corners["corner_interval"] = np.zeros(len(time))  # told by the speed itself (`interval_at`)
    return wide._replace(unbalance=nothing, scale_x=scale_x, scale_v=scale_v, drive=drive, **corners)


def interval_at(model, Omega):
    """Number of the interval between knots of the coefficients in which an integrated speed in rad/s lies."""
    return int(np.searchsorted(model.drive.knots, Omega))


def _knots(torque):
    """Knots (k, 2) of rad/s and N m with the slope up to the next one, 0 behind the last."""
    slopes = np.append(np.diff(torque[:, 1]) / np.diff(torque[:, 0]), 0.0)
    return np.column_stack([torque, slopes])


def begin(model, v):
    """Put the first speed into the velocities that a run begins with."""
    if model.drive:
        v[-2] = SIZE * 2.0 * np.pi * model.corner_speed[0]


def speed_of(model, v):
    """Rotor speed in rad/s of a kernel's velocities."""
    return v[-2] / model.drive.size


def energy(model, v, turns):
    """Energy beside that of the coordinates, J: J Omega^2/2 + Re(r'^H i Omega u), u = U e^{i phi}, and of the weight
    -Re(w e^{-i phi})."""
    own = model.drive
    speed, u = speed_of(model, v), own.euler.view(complex) * np.exp(2j * np.pi * turns)
    height = 0.0
    if own.weight:
        height = -(complex(*own.weight) * np.exp(-2j * np.pi * turns)).real
    inertia = own.inertia + own.mass * float(own.euler @ own.euler)
    return height + 0.5 * inertia * speed**2 + own.mass * speed * float((v.view(complex).conj() @ (1j * u)).real)
