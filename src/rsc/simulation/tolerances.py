"""Tolerances and step lengths of a run, from the frequencies of its machine."""

import numpy as np

from rsc.kernel import springs
from rsc.simulation.states import stiffness_at

# rad/s, from which the natural frequency of a rotor in a magnetic bearing is looked for, in this many looks
FASTEST, LOOKS = 1e4, 6


def rtol_of(system, omega, rtol, omega_contact):
    """The requested tolerance, or a tighter one that resolves the contact; omega in rad/s is the frequency of `rotor_reference`,
    omega_contact that of the closed contact.

    Velocities may have errors of rtol gap omega. With a contact frequency omega_c these are small compared with the penetration
    of a whirl, gap (omega/omega_c)^2, only if rtol << omega/omega_c: beyond, the contact chatters and its force is noise
    (maps.csv). Friction that reverses within a slip range is resolved only if rtol gap omega << slip_velocity: beyond, sticking
    is a noise of full friction forces, and a run can be off by a thousand times its tolerance (dozen.csv, S8).
    """
    rtol = min(rtol, 0.03 * omega / omega_contact)
    for contact in system.contacts:
        if contact.law.diameter is not None:
            fastest = omega
            if system.n_stator:
                c = int(contact.stator.argmax())
                fastest = max(omega, np.sqrt(abs(system.stator.stiffness[c, c]) / system.stator.mass[c, c]))
            rtol = min(rtol, 0.01 * contact.law.slip_velocity / (contact.gap * fastest))
    return float(max(rtol, 1e-13))


def switch_tol_of(rtol):
    """Allowed overshoot of a switch at the end of a step, in the error norm: a tenth of rtol at 1e-4, a hundredth at 1e-6.

    A tighter bound costs repeated steps if steps are long, hardly any if they are short. Meeting switches late gives the contact
    small impulses, always to the same side, which shows in how long a run-up stays on an unstable whirl
    (tests/literature/test_reference_runs.py).
    """
    return float(max(rtol * min(0.1, 10.0 * np.sqrt(rtol)), 2.0**-52))


def rotor_reference(system):
    """Squared natural frequency, (rad/s)^2, of the rotor's contact coordinate with all others fixed; the largest of several."""
    places = [int(contact.rotor.argmax()) for contact in system.contacts]
    return max(_squared(system.rotor, c) for c in places)


def _squared(body, c):
    """Squared natural frequency of coordinate c alone, from above with the stiffness of first-order states."""
    square = abs(body.stiffness[c, c]) / body.mass[c, c]
    if body.n_states:
        square = FASTEST**2
        for _ in range(LOOKS):
            square = abs(body.stiffness[c, c] + stiffness_at(body, np.sqrt(square))[c, c]) / body.mass[c, c]
    return square


def first_step(packed):
    """Length of the first attempted step, s: safe for the fastest mode with the stiffest contact closed."""
    m = packed.model
    contact = max(
        springs.limit(data.surfaces.spring) * float(np.abs(data.force_row[::2] * data.contact_row[::2]).sum()) for data in
        m.contacts
    )
    omega2 = float(np.abs(m.stiffness).max()) + contact
    return min(0.1 * m.rtol**0.2 / np.sqrt(omega2), m.h_max)


def quarter_period(system, omega_ref):
    """Longest step in s: a quarter turn, up to which rotations of the stages are accurate (`turn.turned`)."""
    return 0.5 * np.pi / max(omega_ref, system.fastest)
