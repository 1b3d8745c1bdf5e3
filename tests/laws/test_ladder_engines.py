"""Verification ladder, V11: independent engines on regular rubs (see `engines`), each with its own switches."""

import numpy as np
import pytest

import rsc
from engines import by_extrapolation, by_radau
from figures import met
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from scenes import SCENES, changed

REGULAR = ["whirl, unbalance, run-up", "Coulomb friction that reverses", "eccentric ring", "rigid wall", "no contact damper"]
REGULAR += ["gyroscopic disk", "chains", "bouncing"]
# s; the engine sees a switch only at the end of a step of its own: of these two come and go within 0.05 ms
LONGEST = {"bouncing": 2e-5}


def simulated(name, duration, rtol):
    tables = changed(SCENES[name], drive={"duration": duration}, output={"rate": 400.0}, solver={"rtol": rtol})
    scene = rsc.Scene.from_dict(tables)
    system = assemble(scene)
    return rsc.simulate(scene), system, initial_state(scene, system)


SLOW = {"chains", "eccentric ring", "bouncing", "Coulomb friction that reverses"}  # a third of a minute each


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.nightly] * (name in SLOW)) for name in REGULAR])
def test_v11_extended_precision_with_located_switches(name):
    """Eight digits of the gap at rtol 1e-10, and the same number of switches of the law."""
    result, system, start = simulated(name, 0.03, 1e-10)
    rotor, stator, switches = by_extrapolation(system, start, result.time, LONGEST.get(name, 2e-4))
    assert switches >= 4
    error = max(np.abs(result.rotor - rotor).max(), np.abs(result.stator - stator).max(initial=0.0))
    met("V11", f"{name}: extrapolation in extended precision, {switches} switches, error / gap", error / system.contact.gap, 1e-8)


@pytest.mark.parametrize("name", REGULAR[:2])
def test_v11_radau_with_located_switches(name):
    """An implicit method of another family; its own error at rtol 1e-8 is the limit here."""
    result, system, start = simulated(name, 0.025, 1e-10)
    rotor, stator, switches = by_radau(system, start, result.time, rtol=1e-8)
    assert switches >= 2
    error = max(np.abs(result.rotor - rotor).max(), np.abs(result.stator - stator).max(initial=0.0))
    met("V11", f"{name}: Radau, {switches} switches, error / gap", error / system.contact.gap, 1e-6)
