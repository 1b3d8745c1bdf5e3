"""The sliding of the contact as the velocities in a result tell it, beside the one that every result stores."""

import numpy as np


def error_of_sliding(result):
    """Largest difference of the two over the largest sliding; a sample has both from one state, so that it is rounding.

    Tangential velocity Im(d' conj d)/|d| of the deflection d with the ring's centre; none where d has no direction. Of a result
    of one speed or of a speed that changes linearly.
    """
    contact, time, speed = result.scene.contact, result.time, result.speed
    i, k = contact.rotor_coordinate, contact.stator_coordinate
    ring = complex(contact.ring_eccentricity) * np.exp(1j * np.pi * time * (speed[0] + speed))
    d, d_dot = result.rotor[:, i] + ring, result.rotor_velocity[:, i] + 2j * np.pi * speed * ring
    if result.stator.shape[1]:
        d, d_dot = d - result.stator[:, k], d_dot - result.stator_velocity[:, k]
    moved = abs(d) > 1e-6 * contact.gap
    told = np.imag(d_dot[moved] * np.conj(d[moved])) / abs(d[moved])
    stored = result.tangential_velocity
    return float(abs(told - stored[moved]).max() / abs(stored).max())
