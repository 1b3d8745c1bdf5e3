"""Random siblings of machines that answers were once wrong about."""

import numpy as np
import pytest

import rsc
from rsc.scene.values import physical_values, with_entries

FIXED = ("drive", "start", "limits", "solver", "output")  # tables whose values stay


def seeds(always=2, count=6):
    """Numbers of siblings, 0 for the machine itself; those from `always` on are left to `make nightly`."""
    return [number if number < always else pytest.param(number, marks=pytest.mark.nightly) for number in range(count)]


def sibling(tables, seed, spread=0.1):
    """The scene of some tables with every number of rotor, stator and contact up to a tenth larger or smaller; 0: as it is."""
    scene, dice = rsc.Scene.from_dict(tables), np.random.default_rng(seed)
    if not seed:
        return scene
    known = {name: value for name, value in physical_values(scene).items() if value and name.partition(".")[0] not in FIXED}
    return with_entries(scene, {name: float(value * dice.uniform(1.0 - spread, 1.0 + spread)) for name, value in known.items()})
