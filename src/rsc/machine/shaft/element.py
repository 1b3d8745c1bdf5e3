"""Beam element of a shaft: a piece of one section, cylindrical or conical, with shear and rotary inertia.

Its four coordinates are deflection and slope of the cross-section at both ends. The shape functions are those of a massless piece
under end loads: the bending moment is a + b s and the shear force -b, the slope psi of the cross-section changes by M / (E I),
and the deflection has the slope psi - b / (kappa G A) (Timoshenko). For a cylinder they are those of H. D. Nelson, A finite
rotating shaft element using Timoshenko beam theory, J. Mech. Des. 102 (1980) 793; for a cone static deflections are exact, too.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.machine.shaft.parts import Material, Section

FloatArray = NDArray[np.float64]

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)


def _integrator() -> FloatArray:
    """(8, 8) matrix from values at the Gauss points to integrals from -1 to each point, exact up to degree 7."""
    powers = np.arange(8)
    integrals = (_POINTS[:, None] ** (powers + 1) - (-1.0) ** (powers + 1)) / (powers + 1)
    return np.asarray(integrals @ np.linalg.inv(_POINTS[:, None] ** powers))


_TO_POINTS = _integrator()


class Element(NamedTuple):
    """Matrices (4, 4) of an element in one plane: kg, N/m and kg m^2 for displacements, times powers of m for slopes."""

    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray


def shear_factor(poisson: float, hollow: FloatArray | float) -> FloatArray | float:
    """Shear factor of a circular section with a ratio `hollow` of bore to diameter.

    G. R. Cowper, The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33 (1966) 335.
    """
    ring = (1.0 + hollow**2) ** 2
    return 6.0 * (1.0 + poisson) * ring / ((7.0 + 6.0 * poisson) * ring + (20.0 + 12.0 * poisson) * hollow**2)


def section_of(outer: FloatArray, inner: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Area in m^2 and second moment of area in m^4 of annular sections."""
    return np.pi / 4.0 * (outer**2 - inner**2), np.pi / 64.0 * (outer**4 - inner**4)


def element(piece: Section, shear: bool = True) -> Element:
    """Element for a whole section.

    Parameters
    ----------
    piece : Section
    shear : bool
        False: without shear (Rayleigh beam, with rotary inertia).
    """
    half, material = 0.5 * piece.length, piece.material
    s, ds = half * (1.0 + _POINTS), half * _WEIGHTS
    share = s / piece.length
    outer, inner = (left + (right - left) * share for left, right in (piece.outer, piece.inner))
    area, inertia = section_of(outer, inner)
    # compliances relative to the mean bending compliance, so that all columns below have similar magnitude
    bending = material.young * float(inertia.mean())
    bend, slide = bending / (material.young * inertia), _shear_compliance(material, area, inner / outer, bending, shear)
    psi, w = _deflections(s, half, bend, slide)
    ends = np.array([np.zeros(4), [0.0, 1.0, 0.0, 0.0], np.zeros(4), [0.0, 1.0, ds @ bend, ds @ (s * bend)]])
    ends[0, 0] = 1.0
    slope = psi - np.outer(slide, [0.0, 0.0, 0.0, 1.0])
    ends[2] = ends[0] + ds @ slope
    shapes = np.linalg.inv(ends)  # parameters (w and psi at the left end, a, b) of each end coordinate
    w, psi = w @ shapes, psi @ shapes
    moment = np.column_stack([0.0 * s, 0.0 * s, 1.0 + 0.0 * s, s]) @ shapes
    force = shapes[3]
    stiffness = bending * (np.einsum("p,pi,pj->ij", ds * bend, moment, moment) + (ds @ slide) * np.outer(force, force))
    turning = material.density * np.einsum("p,pi,pj->ij", ds * inertia, psi, psi)
    mass = material.density * np.einsum("p,pi,pj->ij", ds * area, w, w) + turning
    return Element(*(0.5 * (matrix + matrix.T) for matrix in (mass, stiffness, 2.0 * turning)))


def _shear_compliance(
    material: Material, area: FloatArray, hollow: FloatArray, bending: float, shear: bool
) -> FloatArray:
    if not shear:
        return 0.0 * area
    return bending / (shear_factor(material.poisson, hollow) * material.shear_modulus * area)


def _deflections(s: FloatArray, half: float, bend: FloatArray, slide: FloatArray) -> tuple[FloatArray, FloatArray]:
    """psi and w at the points, (p, 4) for the parameters (w and psi at the left end, a, b)."""
    to_points, one = half * _TO_POINTS, 1.0 + 0.0 * s
    psi = np.column_stack([0.0 * s, one, to_points @ bend, to_points @ (s * bend)])
    slope = psi - np.outer(slide, [0.0, 0.0, 0.0, 1.0])
    w = to_points @ slope
    w[:, 0] = 1.0
    return psi, w
