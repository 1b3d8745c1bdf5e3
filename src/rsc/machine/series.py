"""The fastest modes of a reduced body as a static compliance in series with the contact stiffness.

What a mode far above all motions adds to the receptance is its static flexibility. Without the mode the contact is softer by as
much: 1/k_C' = 1/k_C + compliance, and the highest frequency, which sets the step of a run, falls.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from rsc.errors import ReductionError
from rsc.machine.body import highest_frequency, projected, solutions, static_solver
from rsc.machine.greedy import SAFETY
from rsc.machine.points import Scale, points
from rsc.machine.reduction import OFFSETS, Reduced, checks_at, contact_coordinates, turned


@dataclass(frozen=True, eq=False)
class Series:
    """A reduced body without its fastest modes, and the contact that stands for them.

    What `Reduced.recover` gives lacks the static deflection of the modes left out, their compliance times the contact force.
    """

    reduced: Reduced
    compliance: float  # m/N
    contact_stiffness: float  # N/m, k_C'
    contact_damping: float  # N s/m, b_C' = b_C (k_C'/k_C)^2


def in_series(reduced: Reduced, cut: float, contact_stiffness: float, contact_damping: float) -> Series:
    """Leave out the undamped modes of a reduced body above a frequency.

    Parameters
    ----------
    reduced : Reduced
    cut : float, rad/s
        Modes above it, at standstill, become static; at least as high as the band and the speeds.
    contact_stiffness, contact_damping : float, N/m and N s/m
        k_C (may be infinite) and b_C of the contact so far. In series with a compliance the damper is one only while b_C Psi is
        small against k_C; the difference counts as an error of the receptance.

    Returns
    -------
    Series
        The errors of its `reduced` include those that this body had before.

    Raises
    ------
    ReductionError
        A cut inside the band, nothing above or below it, or an error above the tolerance.
    """
    fastest = max(map(abs, (*reduced.band, *reduced.speeds)))
    if not cut >= fastest:
        raise ReductionError(f"cut = {cut:.4g} rad/s lies inside the band or the speeds, which reach to {fastest:.4g} rad/s")
    square, modes = scipy.linalg.eigh(reduced.body.stiffness, reduced.body.mass)
    fast = square > cut**2
    if not fast.any() or fast.all():
        raise ReductionError(f"cut = {cut:.4g} rad/s leaves {'no mode' if fast.all() else 'every mode'} of the reduced body")
    at_contact = modes.T @ reduced.body.contact
    compliance = float(np.sum(at_contact[fast] ** 2 / square[fast]))
    slow = projected(reduced.body, modes[:, ~fast])
    turn, mass = contact_coordinates(slow)
    body = turned(slow, turn, mass)
    softer = 1.0 / (1.0 / contact_stiffness + compliance)
    damper = contact_damping * (softer / contact_stiffness) ** 2

    def change(Psi):
        """Of the contact's own compliance, beside that of the modes."""
        rigid = np.isinf(contact_stiffness)
        before = np.zeros(Psi.shape) if rigid else 1.0 / (contact_stiffness + 1j * Psi * contact_damping)
        return 1.0 / (softer + 1j * Psi * damper) - before

    checks = _checks(reduced, body, change)
    error = max(check.error for check in checks if check.place == "contact")
    if error > reduced.tolerance:
        raise ReductionError(
            f"cut = {cut:.4g} rad/s leaves an error of {error:.2g} above the tolerance {reduced.tolerance:.3g}; cut higher"
        )
    smaller = replace(
        reduced,
        body=body,
        basis=reduced.basis @ modes[:, ~fast] @ turn,
        checks=checks,
        error=error,
        highest_after=highest_frequency(body),
    )
    return Series(smaller, compliance, softer, damper)


def _checks(reduced, body, change):
    """Errors of the body with fewer modes: those it had before and those against it."""
    full = reduced.body
    places = points(full, full, reduced.band, reduced.speeds, OFFSETS[0])
    places.solve(full, np.arange(len(places.Psi)))
    values = solutions(body, places.Psi, places.Omega, body.inputs[:, places.column]) @ body.outputs.T
    values[:, 0] += np.where(places.column == 0, change(places.Psi), 0.0)
    static = static_solver(full)
    scale = Scale(full, static(full.inputs), static(full.outputs.T)).of(places, places.exact)
    before = {(check.response, check.place): check for check in reduced.checks}
    checks = [
        (check, before.get((check.response, check.place)))
        for check in checks_at(full, places, SAFETY * np.abs(values - places.exact) / scale, estimated=False)
    ]
    return tuple(replace(check, error=check.error + old.error, estimated=old.estimated) for check, old in checks if old)
