"""Places that are only watched: how far predicted motions deflect at the clearances of a system, |l_Rj^T r_R - l_Sj^T r_S|."""

import numpy as np
import scipy

from rsc.analysis.paper.anisotropy import unbalance_ellipse
from rsc.analysis.paper.receptance import along, in_both_directions, pushed
from rsc.analysis.paper.synchronous import envelope_of, unbalance_response
from rsc.analysis.paper.whirls import whirl_shapes
from rsc.system.system import FloatOrArray, System


def whirl_deflections(system: System, Psi: FloatOrArray, F_N: FloatOrArray, Omega: FloatOrArray, forces):
    """Largest deflection of whirls with their unbalance at each clearance, to first order in it as `synchronous_response`.

    Parameters
    ----------
    system : System
        Or a stack with one system for each root.
    Psi, F_N : (n,) float, rad/s and N
    Omega : float, rad/s, or one each
    forces : (F_Omega, F_m), (n,) complex N each, of the synchronous and the mirror line

    Returns
    -------
    (n, k) float, m, over the beat; without the unbalance it is |H_jc c F_N|, H_jc the receptance from contact to clearance
    """
    Psi, F_N = np.asarray(Psi, dtype=float), np.asarray(F_N, dtype=float)
    Omega = np.broadcast_to(Omega, Psi.shape)
    whirl = whirl_shapes(system, Psi, F_N, Omega)
    with np.errstate(invalid="ignore"):
        line, mirror_line = (pushed(system, w, Omega, F) for w, F in zip((Omega, 2.0 * Psi - Omega), forces, strict=True))
    line = line[0] + unbalance_response(system, Omega)[0], line[1]
    largest = []
    for place in system.clearances:
        parts = [along(rotor, place.rotor) - along(stator, place.stator) for rotor, stator in (whirl, line, mirror_line)]
        with np.errstate(invalid="ignore"):
            high = envelope_of(*parts)[1]
        largest.append(np.where(np.isfinite(high), high, np.abs(parts[0])))  # at rest, free motions: a pole of the lines
    return np.array(largest).reshape(len(system.clearances), *Psi.shape).T


def shape_deflections(system: System, rotor, stator):
    """Deflections (k,) m at the clearances of a motion with the shapes rotor (N,) and stator (M,), such as a forward rub."""
    return np.array([abs(rotor @ place.rotor - stator @ place.stator) for place in system.clearances])


def free_deflections(system: System, Omega: FloatOrArray):
    """Largest deflection (k,) m at each clearance of the motion by unbalance and load without contact at a speed in rad/s."""
    if system.isotropic:
        turning = [unbalance_response(system, np.asarray(Omega, dtype=float))[0]]
    else:
        turning = [*unbalance_ellipse(system, Omega)]
    lines = (*turning, static_deflection(system, Omega))
    return np.array([sum(abs(part @ place.rotor) for part in lines) for place in system.clearances])


def static_deflection(system: System, Omega: FloatOrArray):
    """Deflection (N,) complex m of the rotor by its constant load, K r + i S r + E conj(r) = f_0; the least one where nothing
    holds a motion."""
    body = system.rotor.at_speed(Omega)
    if not body.load.any():
        return np.zeros(body.n_coordinates, dtype=complex)
    whole, p = body.with_states(), body.n_states
    load, across = np.pad(body.load, (0, p)), body.anisotropic_stiffness
    matrix = in_both_directions(whole.static, across if across is None else np.pad(across, (0, p)))
    y, z = np.split(scipy.linalg.lstsq(matrix, np.concatenate([load.real, load.imag]))[0], 2)
    return (y + 1j * z)[: body.n_coordinates]


def shares(system: System, deflections):
    """Deflections (..., k) at the clearances over their gaps."""
    return deflections / np.stack([np.asarray(place.gap, dtype=float) for place in system.clearances], axis=-1)


def touched(system: System, over_gap):
    """Names of the clearances whose share (k,) of the gap is one or more, that which is passed furthest first."""
    order = np.argsort(-np.asarray(over_gap), kind="stable")
    return tuple(system.clearances[i].name for i in order if over_gap[i] >= 1.0)
