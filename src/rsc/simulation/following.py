"""Coefficients that follow the rotor speed as the kernel takes them: between knots K = K_a + Omega K_b, B = B_a + Omega B_b.

Knots that the schedule passes are corners of it, so that a step lies between two of them. There are k + 1 intervals for k knots:
before the first and behind the last the coefficients are constant.
"""

from dataclasses import replace

import numpy as np

_NEAREST = 1e-12  # of the run's time: a knot so close to a corner is that corner


def reference(system):
    """The System whose matrices are those of its first speed and constant, rotating damping as it is: what modes are made of."""
    return replace(system, rotor=system.rotor.at_knots(system.schedule_speed[0])) if len(system.knot_speed) else system


def corners(system):
    """Times in s, speeds in rad/s and numbers of the intervals (() without knots) of a schedule with the knots that it passes."""
    time, speed, knots = system.schedule_time, system.schedule_speed, system.knot_speed
    if not len(knots):
        return time, speed, ()
    if system.drive is not None:  # it may pass every speed up to its fastest
        time, speed = np.array([0.0, 1.0]), np.array([0.0, system.drive.fastest])
    places = [(time[0], speed[0])]
    for i in range(1, len(time)):
        rise, last = speed[i] - speed[i - 1], time[i] - time[i - 1]
        passed = knots[(knots > min(speed[i - 1], speed[i])) & (knots < max(speed[i - 1], speed[i]))]
        for knot in passed if rise > 0.0 else passed[::-1]:
            at = time[i - 1] + (knot - speed[i - 1]) / rise * last
            if min(at - places[-1][0], time[i] - at) > _NEAREST * time[-1]:
                places.append((at, knot))
        places.append((time[i], speed[i]))
    time, speed = np.array(places).T
    middle = 0.5 * (speed[1:] + speed[:-1])
    above, below = (np.searchsorted(knots, middle, side=side) for side in ("right", "left"))
    interval = np.where(middle < 0.0, below, above).astype(float)  # at a knot alike in the mirror image
    return time, speed, np.append(interval, interval[-1])


def lines_between(knots, values):
    """[a, b] of a + Omega b in every interval, (k + 1, 2, ...), from the values (k, ...) at knots in rad/s."""
    at = knots.reshape(-1, *[1] * (values.ndim - 1))
    slope, none = np.diff(values, axis=0) / np.diff(at, axis=0), np.zeros_like(values[:1])
    from_both = 0.5 * ((values[:-1] - at[:-1] * slope) + (values[1:] - at[1:] * slope))  # the mirror image has the same bits
    return np.stack([np.concatenate([values[:1], from_both, values[-1:]]), np.concatenate([none, slope, none])], axis=1)


def additions(system, base, kind, rotor):
    """(linear, conjugate) of the rotor at every knot beyond those of its `reference` body, complex (k, N, N): linear r +
    conjugate conj(r) is the force per mass in modes of the "stiffness", or of the damping for r'."""
    bodies = [system.rotor.at_knots(knot) for knot in system.knot_speed]

    def beyond(name):
        own = getattr(base, name)
        if own is None and getattr(bodies[0], name) is None:
            return np.zeros((len(bodies), *base.mass.shape))
        matrices = np.array([getattr(body, name) - (0.0 if own is None else own) for body in bodies])
        return rotor.shape.T @ matrices @ rotor.shape / rotor.reference_mass

    return -beyond(kind) - 1j * beyond(f"skew_{kind}"), -beyond(f"anisotropic_{kind}")
