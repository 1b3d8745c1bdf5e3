"""A contact law from outside: right with rk45, told in one line by whoever does not know it."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hardening import hardened

import naive
from directions import assembled
from rsc.analysis.paper.law import law_at
from rsc.analysis.paper.predict import predict_system
from rsc.errors import SceneError, SolverError
from rsc.scene.scene import Scene
from rsc.study.run.ensemble import simulate_many
from rsc.study.run.simulate import simulate
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from rsc.system.border import border_of
from rsc.system.system import ContactLaw, stacked
from scenes import SCENES, changed
from tiers import nightly

H, FOLDERS = 4.0, [str(Path(__file__).parent), str(Path(__file__).parents[1] / "support")]
NAMES = ("whirl, unbalance, run-up", "bouncing", "no contact damper", "Coulomb friction that reverses")
# code of a law that is no part of the package is kept in a folder of its own
WORKER = """
import json, sys
sys.path[:0] = json.loads(sys.argv[1])
import rsc, rsc.simulation.run, rsc.study.run.start
from hardening import hardened
from rsc.system.assemble import assemble

rsc.study.run.start.assemble = rsc.simulation.run.assemble = lambda scene: hardened(assemble(scene), float(sys.argv[2]))
rows = []
for tables in json.load(sys.stdin):
    run = rsc.simulate(rsc.Scene.from_dict(tables))
    rows.append({"time": run.time.tolist(), "rotor": [run.rotor.real.tolist(), run.rotor.imag.tolist()],
                 "residual": run.ledger.residual, "turnover": run.ledger.turnover, "onsets": run.contact_onsets})
print(json.dumps(rows))
"""


def tables_of(name):
    """A short run at a tight tolerance."""
    return changed(SCENES[name], drive={"duration": 0.06}, output={"rate": 2000.0}, solver={"rtol": 1e-11})


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("code")
    found = subprocess.run(
        [sys.executable, "-c", WORKER, json.dumps(FOLDERS), str(H)], input=json.dumps([tables_of(name) for name in NAMES]),
        env={**os.environ, "XDG_CACHE_HOME": str(folder)}, capture_output=True, text=True,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    return dict(zip(NAMES, json.loads(found.stdout), strict=True))


def force(system, r, r_dot, s, s_dot, t):
    """(F_C, F_N): the law written once more, for the slow twin."""
    ring = system.contact.ring * np.exp(1j * naive.phase(system, t))
    d = system.rotor.contact @ r - system.stator.contact @ s + ring
    d_dot = system.rotor.contact @ r_dot - system.stator.contact @ s_dot + 1j * system.speed_at(t) * ring
    p, rate = abs(d) - system.contact.gap, (d_dot * d.conjugate()).real / abs(d)
    if p <= 0.0:
        return 0j, 0.0
    law, sigma = system.law, 1.0
    normal = max(0.0, law.stiffness * p * (1.0 + H * p / system.contact.gap) + law.damping * min(rate, 0.0))
    if law.diameter is not None:
        slip = 0.5 * system.speed_at(t) * law.diameter + (d_dot * d.conjugate()).imag / abs(d)
        sigma = np.clip(slip / law.slip_velocity, -1.0, 1.0)
    return (1.0 + 1j * law.friction * sigma) * normal * d / abs(d), normal


@pytest.mark.parametrize("name", [NAMES[0], NAMES[2], nightly(NAMES[1]), nightly(NAMES[3])])
def test_the_motion_is_that_of_an_independent_integration(name, runs, monkeypatch):
    scene, found = Scene.from_dict(tables_of(name)), runs[name]
    system = assemble(scene)
    start, times = initial_state(scene, system), np.array(found["time"])
    linear = naive.integrate(system, start, times)[0]
    monkeypatch.setattr(naive, "contact_force", force)
    wanted = naive.integrate.__wrapped__(system, start, times)[0]  # by another law: not the answer that is kept
    rotor = np.array(found["rotor"][0]) + 1j * np.array(found["rotor"][1])
    assert abs(rotor - wanted).max() < 1e-6 * system.contact.gap
    assert abs(linear - wanted).max() > 1e-3 * system.contact.gap
    assert abs(found["residual"]) < 1e-6 * found["turnover"]


def test_the_series_refuses_in_one_line(monkeypatch):
    assembled(monkeypatch, lambda system: hardened(system, H))
    scenes = [Scene.from_dict(tables_of(name)).with_values({"solver.method": "taylor8"}) for name in NAMES[:2]]
    for ask in (lambda: simulate(scenes[0]), lambda: simulate_many(scenes, threads=1)):
        with pytest.raises(SolverError, match='contact law Hardening has no series; use rk45') as refused:
            ask()
        assert "\n" not in str(refused.value)


def test_the_prediction_refuses_in_one_line():
    system = hardened(assemble(Scene.from_dict(tables_of(NAMES[0]))), H)
    with pytest.raises(SceneError) as refused:
        predict_system(system, 50.0)
    assert refused.value.key == "contact.hardening" and "\n" not in str(refused.value)
    with pytest.raises(SceneError, match=r"contact\.hardening = 4\.0: must be 0 for a prediction"):
        law_at(stacked([system, system]).contact)


def test_the_depth_is_not_known_unless_the_law_says_it():
    """A sweep of runs judges how deep they press without a prediction, which would refuse: F/k is wrong of another spring."""
    linear = assemble(Scene.from_dict(tables_of(NAMES[0])))
    borders = [border_of(system, 50.0, [1e3], 1e-3, -60.0) for system in (linear, hardened(linear, H))]
    assert borders[0].depth == 1e3 / linear.law.stiffness and np.isnan(borders[1].depth) and np.isnan(borders[1].penetration)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_laws_of_different_classes_are_not_stacked(order):
    linear = assemble(Scene.from_dict(tables_of(NAMES[0])))
    systems = linear, hardened(linear, H)
    with pytest.raises(SolverError, match=r"different kinds \(ContactLaw, Hardening\)"):
        stacked([systems[i] for i in order])


def test_a_law_without_a_spring_is_refused_in_one_line(monkeypatch):
    @dataclass(frozen=True, eq=False)
    class Unknown(ContactLaw):
        pass

    law = {"law": None}

    def change(system):
        law["law"] = Unknown(**vars(system.law))
        return replace(system, contacts=(replace(system.contact, law=law["law"]),))

    assembled(monkeypatch, change)
    with pytest.raises(SolverError, match="no spring for the contact law Unknown"):
        simulate(Scene.from_dict(tables_of(NAMES[0])))
