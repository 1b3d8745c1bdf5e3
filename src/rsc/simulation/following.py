"""Speed-dependent coefficients for the kernel: between two knots K = K_a + Omega K_b, B = B_a + Omega B_b.

Knots that the schedule passes become corners of it, so that every step lies between two knots. k knots have k + 1 intervals:
before the first and after the last the coefficients are constant.

So do the times at which bearings are switched off. With s such times there are (s + 1)(k + 1) intervals: those of the knots with
all bearings, then those without the ones switched off first, and so on.
"""

from dataclasses import replace

import numpy as np

_NEAREST = 1e-12  # relative to the duration: a knot this close to a corner coincides with it


def reference(system):
    """The System with the constant matrices of its initial speed, rotating damping unchanged; its modes are those of the run."""
    return replace(system, rotor=system.rotor.at_knots(system.schedule_speed[0])) if len(system.knot_speed) else system


def changes(system):
    """Whether coefficients change during a run, with the speed or because bearings are switched off; magnetic bearings have their
    own (`rsc.simulation.states`)."""
    return len(system.knot_speed) > 0 or any(one.parts for one in system.switched)


def corners(system):
    """(times in s, speeds in rad/s, interval indices or () with constant coefficients) of a schedule, including the knots it
    passes and the times at which bearings are switched off."""
    time, speed, knots = system.schedule_time, system.schedule_speed, system.knot_speed
    offs = np.array([one.time for one in system.switched])
    if len(offs):
        own = np.union1d(time, offs)
        time, speed = own, np.interp(own, time, speed)
    if not changes(system):
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
    interval = np.where(middle < 0.0, below, above).astype(float)  # at a knot, the same in the mirror image
    interval += (len(knots) + 1) * np.searchsorted(offs, time[:-1], side="right")
    return time, speed, np.append(interval, interval[-1])


def lines_between(knots, values):
    """[a, b] of a + Omega b in each interval, (k + 1, 2, ...), from values (k, ...) at knots in rad/s."""
    at = knots.reshape(-1, *[1] * (values.ndim - 1))
    slope, none = np.diff(values, axis=0) / np.diff(at, axis=0), np.zeros_like(values[:1])
    from_both = 0.5 * ((values[:-1] - at[:-1] * slope) + (values[1:] - at[1:] * slope))  # the mirror image has the same bits
    return np.stack([np.concatenate([values[:1], from_both, values[-1:]]), np.concatenate([none, slope, none])], axis=1)


def of_bearings(system, kind, rotor):
    """The same as `additions` of the bearings that are switched off at each time, (s, N, N)."""
    none = np.zeros_like(system.rotor.mass)
    parts = [[one.parts.get(f"{word}{kind}", none) for word in ("", "skew_", "anisotropic_")] for one in system.switched]
    mean, skew, anisotropic = (
        rotor.shape.T @ np.array(matrices) @ rotor.shape / rotor.reference_mass for matrices in zip(*parts, strict=True)
    )
    return -mean - 1j * skew, -anisotropic


def additions(system, base, kind, rotor):
    """(linear, conjugate), complex (k, N, N): differences of the rotor at each knot from its `reference` body; linear r +
    conjugate conj(r) is the force per mass in modes due to the "stiffness", or due to the "damping" for r'."""
    bodies = [system.rotor.at_knots(knot) for knot in system.knot_speed]

    def beyond(name):
        reference = getattr(base, name)
        if reference is None and getattr(bodies[0], name) is None:
            return np.zeros((len(bodies), *base.mass.shape))
        matrices = np.array([getattr(body, name) - (0.0 if reference is None else reference) for body in bodies])
        return rotor.shape.T @ matrices @ rotor.shape / rotor.reference_mass

    return -beyond(kind) - 1j * beyond(f"skew_{kind}"), -beyond(f"anisotropic_{kind}")
