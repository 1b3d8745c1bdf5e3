"""Random siblings of machines that answers were once wrong about."""

import numpy as np

import rsc
from rsc.scene.values import physical_values, with_entries

FIXED = ("drive", "start", "limits", "solver", "output")  # tables whose values stay


def sibling(tables, seed, spread=0.1):
    """The scene of some tables with every number of rotor, stator and contact up to a tenth larger or smaller; 0: as it is."""
    scene, dice = rsc.Scene.from_dict(tables), np.random.default_rng(seed)
    if not seed:
        return scene
    known = {name: value for name, value in physical_values(scene).items() if value and name.partition(".")[0] not in FIXED}
    return with_entries(scene, {name: float(value * dice.uniform(1.0 - spread, 1.0 + spread)) for name, value in known.items()})
