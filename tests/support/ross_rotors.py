"""Finite-element rotors as a `System`, unreduced; the rub rotor of ROSS in a stator of two masses."""

import tomllib
from pathlib import Path

import numpy as np

from rsc.machine.imports.ross import read_ross
from systems import changed, make_system, quantity

DATA = Path(__file__).parents[2] / "data" / "reference"
RUB = tomllib.loads((DATA / "raw" / "ross_rub_rotor.toml").read_text())


def system_of(model, stator=None, contact=(0, 0.2, 1e6)):
    """System of a rotor's Model. stator (mass, damping, stiffness): default rigid; contact (rotor node, friction, stiffness)."""
    node, friction, stiffness = contact
    none = np.zeros((0, 0))
    rotor = [_dense(part) for part in (model.mass, model.damping, model.stiffness, model.gyroscopic)]
    row = model.row_at(node)
    stator = (none,) * 3 if stator is None else stator
    system = make_system(rotor, stator, (int(row.argmax()), 0, friction, stiffness))
    names = ("skew_stiffness", "skew_damping", "anisotropic_stiffness", "anisotropic_damping")
    return changed(system, **{f"{name}_r": _dense(getattr(model, name)) for name in names})


def _dense(matrix):
    return matrix if matrix is None else np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix)


def rub_rotor(bearings, share=0.0):
    """The rub rotor with its contact at the disc, in a stator of two masses, no contact damping.

    bearings : "as they are", "mean" of both directions, "harmonic" mean of their stiffness, or "x", the x values all round
    share : float, stiffness (1 +- share) in both directions of every bearing, of the x values
    """
    model = read_ross(DATA / "machines" / "ross_rub_rotor.mat", 20.0)
    stator = two_masses((0.13, 0.55), (2.24e5, 5.5e5), (83.0, 86.0))
    system = system_of(model, stator, (RUB["rub"]["node"], 0.17, 1.1e7))
    balanced = 0.0 * system.rotor.unbalance
    system = changed(system, gap=RUB["rub"]["gap"], unbalance=balanced, unbalance_euler=balanced)
    if bearings == "as they are":
        return system
    parts = {name: quantity(system, name).copy() for name in ("stiffness_r", "damping_r", "anisotropic_stiffness_r")}
    parts["anisotropic_stiffness_r"][...] = 0.0
    for bearing in RUB["bearing"]:
        i = int(model.row_at(bearing["node"]).argmax())
        kx, ky, cx, cy = (bearing[key] for key in ("kxx", "kyy", "cxx", "cyy"))
        k = {"mean": 0.5 * (kx + ky), "harmonic": 2.0 / (1.0 / kx + 1.0 / ky), "x": kx}[bearings]
        parts["stiffness_r"][i, i] += k - 0.5 * (kx + ky)
        parts["damping_r"][i, i] += (cx if bearings == "x" else 0.5 * (cx + cy)) - 0.5 * (cx + cy)
        parts["anisotropic_stiffness_r"][i, i] = share * k
    if not share:
        parts["anisotropic_stiffness_r"] = None
    return changed(system, **parts, anisotropic_damping_r=None)


def two_masses(masses, stiffnesses, dampings):
    """Mass, damping and stiffness of two masses in a row: the contact at the first, links 1-2 and 2-wall."""

    def chain(values):
        return np.array([[values[0], -values[0]], [-values[0], values[0] + values[1]]])

    return np.diag(masses), chain(dampings), chain(stiffnesses)
