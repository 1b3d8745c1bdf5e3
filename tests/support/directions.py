"""Systems with skew and anisotropic stiffness and damping, which no scene can ask for yet: `assemble` is changed for a test."""

import sys

import numpy as np

from rsc.system.assemble import assemble
from systems import ANISOTROPIC, SKEW, changed, quantity


def assembled(monkeypatch, change):
    """Let every scene have the System that `change` makes of its own; returns scene -> that System."""

    def changed_system(scene):
        return change(assemble(scene))

    for name in ("rsc.study.run.start", "rsc.simulation.run"):
        monkeypatch.setattr(sys.modules[name], "assemble", changed_system)
    return changed_system


def directed(system, seed=1, skew=0.02, anisotropic=0.3):
    """All eight matrices, symmetric and full, random, of these shares of stiffness and damping in any direction and shape."""
    rng, more = np.random.default_rng(seed), {}
    for name in (*SKEW, *ANISOTROPIC):
        kind, of = name.split("_", 1)
        root = np.linalg.cholesky(quantity(system, of))
        mixed = rng.normal(size=root.shape) + 1j * rng.normal(size=root.shape)
        mixed, share = (mixed.real, skew) if kind == "skew" else (mixed, anisotropic)
        largest = np.linalg.norm(mixed + mixed.T, 2) if len(root) else 1.0
        more[name] = share / largest * root @ (mixed + mixed.T) @ root.T
    return changed(system, **more)


def of_bearing(system, stiffness, damping):
    """Of a rotor of one coordinate, from an engineer's matrices (2, 2) [[yy, yz], [zy, zz]], symmetric or not."""
    more = {}
    for name, ((yy, yz), (zy, zz)) in (("stiffness_r", stiffness), ("damping_r", damping)):
        more[name] = np.array([[0.5 * (yy + zz)]])
        more[f"skew_{name}"] = np.array([[0.5 * (zy - yz)]])
        more[f"anisotropic_{name}"] = np.array([[0.5 * (yy - zz) + 0.5j * (yz + zy)]])
    return changed(system, **more)
