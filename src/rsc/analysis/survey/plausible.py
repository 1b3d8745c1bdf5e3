"""Remarks on scenes that can hardly be right: each names what does not fit and by how much."""

from math import tau as TWO_PI

import numpy as np

from rsc.analysis.alone.at_rest import static_deflection
from rsc.analysis.alone.free_vibration import free_growth
from rsc.analysis.paper.law import law_of
from rsc.system.system import System

FASTEST_SURFACE = 500.0  # m/s, which steel does not stand
_NEAR = 0.8  # of the gap: from here on a contact ring leaves next to none of it
_FAR = 50.0  # times the fastest speed of a run


def plausibility_remarks(system: System):
    """Remarks on the numbers of a System, as it is at the first speed of its run, that do not fit each other; a list of str."""
    system = system.at_first_speed
    return _surface(system) + _stiffnesses(system) + _sizes(system)


def speed_remarks(system: System, speed):
    """Remark on a rotor speed in Hz far beyond those of the scene's run; a list of str."""
    fastest = float(np.abs(system.schedule_speed).max()) / TWO_PI
    if not 0.0 < _FAR * fastest < abs(speed):
        return []
    times = f"{abs(speed) / fastest:.0f} times the fastest of the run, {fastest:g} Hz"
    return [f"a rotor speed of {speed:g} Hz is {times}: is it in Hz?"]


def _surface(system: System):
    if system.law.diameter is None:
        return []
    radius, remarks = 0.5 * system.law.diameter, []
    gap = system.contact.gap
    if gap > radius:
        remarks.append(f"the gap of {_mm(gap)} is larger than the contact's radius of {_mm(radius)}: see contact.diameter")
    surface = radius * float(np.abs(system.schedule_speed).max())
    if surface > FASTEST_SURFACE:
        wanted = f"no rotor stands {FASTEST_SURFACE:g} m/s: see contact.diameter and drive.speed"
        remarks.append(f"the surface at the contact moves at up to {surface:.0f} m/s, {wanted}")
    return remarks


def _stiffnesses(system: System):
    """Remark on a contact that is softer than the rotor at it: most of the deflection then lies in the contact."""
    push = system.rotor.contact
    if system.n_states:  # a controller is no spring
        return []
    deflection = np.linalg.lstsq(system.rotor.stiffness, push, rcond=1e-13)[0]
    if np.abs(system.rotor.stiffness @ deflection - push).max() > 1e-6:  # nothing holds it there
        return []
    rotor = 1.0 / float(push @ deflection)
    contact = law_of(system).stiffness
    if contact >= rotor:
        return []
    soft, stiff = (f"{1e-6 * stiffness:.3g} kN/mm" for stiffness in (contact, rotor))
    return [f"the contact ({soft}) is softer than the rotor at it ({stiff}): see contact.stiffness"]


def _sizes(system: System):
    """Remarks on lengths that leave nothing of the gap."""
    gap, remarks = system.contact.gap, []
    eccentricity = abs(np.linalg.solve(system.rotor.mass, system.rotor.unbalance_euler) @ system.rotor.contact)
    if eccentricity > gap:
        remarks.append(f"the centre of mass lies {_gaps(eccentricity, gap)} beside the shaft: at speed it turns only in contact")
    deflection = static_deflection(system)
    sag = abs(deflection @ system.rotor.contact) if np.isfinite(deflection).all() else 0.0  # a free motion is told as one
    if sag > gap:
        remarks.append(f"the load bends the rotor by {_gaps(sag, gap)} at the contact: at rest it lies on the stator")
    ring = abs(system.contact.ring)
    if ring > _NEAR * gap:
        size = _gaps(ring, gap)[:-1]
        remarks.append(f"the contact ring is eccentric by {size}: it touches with next to no motion of the shaft")
    return remarks


def negative_damping(system: System):
    """Remark on damping that was allowed to feed energy in and makes the rotor unstable without contact; a list of str."""
    if np.linalg.eigvalsh(system.at_first_speed.rotor.damping).min() >= -1e-12 * np.abs(system.rotor.damping).max():
        return []
    for Omega in np.unique(system.schedule_speed[[0, -1]]):
        growth = free_growth(system, Omega)
        if growth > 0.0:
            where = f"at a rotor speed of {Omega / TWO_PI:g} Hz"
            return [f"negative damping makes the rotor unstable without contact {where}: it grows at {growth:.3g} 1/s"]
    return []


def _mm(metres):
    return f"{1e3 * metres:.3g} mm"


def _gaps(size, gap):
    return f"{_mm(size)}, {size / gap:.2f} gaps,"
