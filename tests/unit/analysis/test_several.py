"""Whirls at several contacts: the scan against many starts, one contact, equal contacts, growth, a dropped rotor, and words."""

import json
from dataclasses import replace

import numpy as np
import pytest

import rsc
from rsc import cli
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.several.condition import Whirling, pressed, settled
from rsc.analysis.several.pairs import pair_candidates
from rsc.analysis.several.predict import predict_several
from rsc.analysis.several.starts import ranges, secant_candidates
from rsc.errors import SolverError
from scenes import TWO
from several_systems import dense, left_over, random_several, with_contacts
from systems import TWO_PI

PLANES = np.linalg.inv([[1.0, -0.25], [1.0, 0.22]])  # displacement and tilt of a rigid rotor from its two planes


def forces_of(whirl):
    return np.array([[own.normal_force, np.radians(own.phase)] for own in whirl.contacts.values()]).T


def missed(system, Omega, contacts):
    """Whirls that Newton's method finds from a grid of secant stiffnesses and the scan does not, and how many it finds."""
    own = pressed(system, Omega, contacts)
    bounds = ranges(own, False)
    scanned, wanted = (settled(own, start(own, bounds), bounds) for start in (pair_candidates, secant_candidates))
    lost = []
    for Psi, N in zip(wanted.Psi, wanted.N, strict=True):
        alike = (np.abs(scanned.Psi / Psi - 1.0) < 1e-6) & (np.abs(scanned.N / N - 1.0).max(axis=1) < 1e-3)
        lost += [] if alike.any() else [Psi / TWO_PI]
    return lost, len(wanted.Psi)


def test_the_scan_misses_no_whirl_that_many_starts_find():
    found = 0
    for seed in (3, 10, 25, 53, *range(100, 116)):  # of the first four some lie beside the end of a branch, or in a pair
        rng = np.random.default_rng(seed)
        system = random_several(rng)
        lost, n = missed(system, TWO_PI * 10.0 ** rng.uniform(0.5, 2.3), (0, 1))
        assert not lost, seed
        found += n
    assert found > 60


@pytest.mark.parametrize("n", [2, 3])
def test_every_whirl_meets_the_equations_of_motion_by_dense_matrices(n):
    told = 0
    for seed in range(3):
        system = random_several(np.random.default_rng(seed), n)
        for whirl in predict_several(system, 30.0):
            x, error = left_over(system, TWO_PI * whirl.frequency, TWO_PI * 30.0, *forces_of(whirl))
            assert error < 1e-7
            assert np.allclose(x, [*whirl.rotor_shape, *whirl.stator_shape], rtol=1e-6, atol=1e-9 * np.abs(x).max())
            told += len(whirl.pressed) == n
    assert told > 10


def test_one_contact_through_the_same_equations_has_the_roots_of_the_pencil():
    for seed in range(5):
        system = random_several(np.random.default_rng(seed))
        for j in (0, 1):
            own = pressed(system, TWO_PI * 30.0, (j,))
            bounds = ranges(own, False)
            one = system.at_contact(system.contacts[j].name)
            wanted = [whirl for whirl in predict_system(one, 30.0) if whirl.frequency < 0.0]
            Psi, N = TWO_PI * np.array([w.frequency for w in wanted]), np.array([[w.normal_force] for w in wanted])
            starts = secant_candidates(own, bounds), Whirling(Psi * (1.0 + 1e-5), 1.1 * N, 0.0 * N)
            found = settled(own, Whirling(*map(np.concatenate, zip(*starts, strict=True))), bounds)
            assert found.Psi / TWO_PI == pytest.approx([whirl.frequency for whirl in wanted], rel=1e-9)
            assert found.N[:, 0] == pytest.approx([whirl.normal_force for whirl in wanted], rel=1e-6)


def test_sets_of_one_contact_are_told_as_of_the_scene_with_that_contact():
    system = random_several(np.random.default_rng(5))
    for j, name in enumerate(("c0", "c1")):
        found = [whirl for whirl in predict_several(system, 30.0) if whirl.pressed == (name,)]
        for own, wanted in zip(found, predict_system(system.at_contact(system.contacts[j].name), 30.0), strict=True):
            assert own.growth_rate == pytest.approx(wanted.growth_rate, rel=1e-7, abs=1e-6)
            for value in ("rotor_amplitude", "stator_amplitude", "normal_force"):
                assert getattr(own, value) == pytest.approx(getattr(wanted, value), rel=1e-8)
            lines, known = own.synchronous.consistent, wanted.synchronous.consistent
            for value in ("force", "mirror_force", "amplitude", "mirror_amplitude", "envelope"):
                assert getattr(lines, value) == pytest.approx(getattr(known, value), rel=1e-6)
            conditions = {name: margin for name, margin in own.conditions.items() if name != "within_clearances"}
            assert conditions == pytest.approx({name: wanted.conditions[name] for name in conditions}, rel=1e-6)
            assert list(own.clearances) == [("c1", "c0")[j]]
            assert own.touches == tuple(place for place, size in own.clearances.items() if size >= 1.0)


def test_two_equal_contacts_at_one_place_are_one_of_double_stiffness():
    system = random_several(np.random.default_rng(2))
    first = system.contacts[0]
    law = replace(first.law, stiffness=2.0 * first.law.stiffness, damping=2.0 * first.law.damping)
    double = with_contacts(system, [replace(first, law=law)])
    twice = with_contacts(system, [first, replace(first, name="again")])
    both = [whirl for whirl in predict_several(twice, 30.0) if len(whirl.pressed) == 2]
    wanted = predict_system(double, 30.0)
    assert len(both) == len(wanted) > 1
    for own, known in zip(both, wanted, strict=True):
        assert own.frequency == pytest.approx(known.frequency, rel=1e-9)
        assert 2.0 * own.normal_force == pytest.approx(known.normal_force, rel=1e-6)
        assert own.growth_rate == pytest.approx(known.growth_rate, rel=1e-6, abs=1e-5)
    assert all(not whirl.stable for whirl in predict_several(twice, 30.0) if len(whirl.pressed) == 1)  # it touches the other


def rate_in_turning_frame(system, Psi, Omega, state):
    """Rate of [Re, Im] of (x, x') in the frame turning with Psi, every contact pressed, by its law of section 2; b* = b_C/2."""
    n = system.n_rotor + system.n_stator
    x, v = np.split(state[: 2 * n] + 1j * state[2 * n :], 2)
    A, rows = dense(system, Psi, Omega)
    mass, damping = np.zeros((n, n)), np.zeros((n, n), complex)
    r, s = slice(0, system.n_rotor), slice(system.n_rotor, n)
    mass[r, r], mass[s, s] = system.rotor.mass, system.stator.mass
    damping[r, r], damping[s, s] = system.rotor.damping - 1j * Omega * system.rotor.gyroscopic, system.stator.damping
    load = -A @ x - (damping + 2j * Psi * mass) @ v
    for contact, row in zip(system.contacts, rows, strict=True):
        d, d_dot = row @ x, row @ v
        rate = (d_dot * d.conjugate()).real / abs(d)
        normal = contact.law.stiffness * (abs(d) - contact.gap) + 0.5 * contact.law.damping * rate
        load = load - row * (1.0 + 1j * contact.law.friction) * normal * d / abs(d)
    change = np.concatenate([v, np.linalg.solve(mass, load)])
    return np.concatenate([change.real, change.imag])


@pytest.mark.parametrize("n", [2, 3])
def test_growth_is_that_of_the_nonlinear_equations_by_differences(n):
    system, checked = random_several(np.random.default_rng(2), n), 0
    for whirl in (whirl for whirl in predict_several(system, 30.0) if len(whirl.pressed) == n):
        Psi, shape = TWO_PI * whirl.frequency, np.concatenate([whirl.rotor_shape, whirl.stator_shape])
        at = np.concatenate([shape.real, 0.0 * shape.real, shape.imag, 0.0 * shape.real])
        least = min(own.normal_force / contact.law.stiffness
                    for own, contact in zip(whirl.contacts.values(), system.contacts, strict=True))  # fmt: skip
        columns = []
        for i in range(len(at)):
            move = np.zeros(len(at))
            move[i] = 1e-4 * least * (1.0 if i % (2 * len(shape)) < len(shape) else abs(Psi))
            ends = (rate_in_turning_frame(system, Psi, TWO_PI * 30.0, at + sign * move) for sign in (1.0, -1.0))
            columns.append(np.subtract(*ends) / (2.0 * move[i]))
        wanted = np.linalg.eigvals(np.array(columns).T)
        wanted = np.delete(wanted, np.argmin(np.abs(wanted)))  # the free phase
        assert whirl.growth_rate == pytest.approx(wanted.real.max(), rel=1e-4, abs=1e-5 * np.abs(wanted).max())
        checked += 1
    assert checked > 1


def dropped(**second):
    """A rigid rotor without bearings on its two auxiliary bearings, in a little air."""
    mass = PLANES.T @ np.diag([20.0, 0.80]) @ PLANES
    ring = {"gap": 2.5e-4, "stiffness": 1e8, "damping": 2e3, "friction": 0.3, "diameter": 0.05, "slip_velocity": 0.02}
    none = [[0.0, 0.0], [0.0, 0.0]]
    return rsc.Scene.from_dict({
        "rotor": {"model": "matrices", "mass": mass.tolist(), "stiffness": none, "rayleigh": [0.1, 0.0],
                  "gyroscopic": (PLANES.T @ np.diag([0.0, 0.05]) @ PLANES).tolist()},
        "stator": {"model": "matrices", "mass": [[1.2, 0.0], [0.0, 1.2]], "stiffness": [[2e7, 0.0], [0.0, 2e7]],
                   "damping": [[3e3, 0.0], [0.0, 3e3]]},
        "contact": [{"name": "near", **ring},
                    {"name": "far", **ring, "rotor_coordinate": 1, "stator_coordinate": 1, **second}],
        "drive": {"speed": 200.0, "duration": 1.0},
    })  # fmt: skip


def test_whirl_of_a_dropped_rotor_at_both_bearings():
    """The numbers of a program of its own."""
    whirl = min((w for w in rsc.predict(dropped()) if len(w.pressed) == 2), key=lambda w: abs(w.frequency + 173.7))
    near, far = whirl.contacts["near"], whirl.contacts["far"]
    assert whirl.frequency == pytest.approx(-173.699, abs=1e-3)
    assert [near.normal_force, far.normal_force] == pytest.approx([8878.6, 11958.8], abs=0.1)
    assert [near.over_gap, far.over_gap] == pytest.approx([1.355, 1.478], abs=1e-3)
    assert whirl.stable and whirl.admissible and whirl.pressed == ("near", "far")


def test_a_rotor_that_turns_backwards_is_the_mirror_image():
    forward, backward = rsc.predict(rsc.Scene.from_dict(TWO), 20.0), rsc.predict(rsc.Scene.from_dict(TWO), -20.0)
    assert [w.frequency for w in backward] == [-w.frequency for w in forward[::-1]]
    assert backward[0].contacts["ring"].phase == pytest.approx(-forward[-1].contacts["ring"].phase)


def test_table_json_and_text(tmp_path, capsys):
    scene = tmp_path / "two.toml"
    scene.write_text(rsc.Scene.from_dict(TWO).to_toml())
    whirls = rsc.predict(rsc.load_scene(scene), [10.0, 120.0])
    table = whirls[0].table()
    assert "seal: normal force in N" in table.columns and len(table.rows) == len(whirls[0])
    assert cli.main(["predict", str(scene), "--json"]) == 0  # at the corners of the schedule
    plain = json.loads(capsys.readouterr().out)
    assert [[w["frequency"] for w in at] for at in plain] == [[w.frequency for w in at] for at in whirls]
    assert plain[0][0]["contacts"]["seal"]["normal_force"] == whirls[0][0].contacts["seal"].normal_force
    assert cli.main(["predict", str(scene), "--speed", "10"]) == 0
    text = capsys.readouterr().out
    assert all(f"{whirl.frequency:.4f}" in text for whirl in whirls[0]) and "seal 1.0343, 343.31 N, 0.0 deg" in text
    for more in (["-o", str(tmp_path / "map.png")], ["--speed", "10", "--sensitivity"]):
        assert cli.main(["predict", str(scene), *more]) == 0
    assert (tmp_path / "map.png").exists() and "stator.masses[0]" in capsys.readouterr().out


def test_what_is_not_predicted_is_one_line():
    with pytest.raises(SolverError, match=r"contact\.far\.offset"):
        rsc.predict(dropped(offset=[1e-5, 0.0]))


def test_three_contacts_say_that_completeness_is_not_shown(tmp_path, capsys):
    third = {"name": "third", "rotor_coordinate": 1, "gap": 2e-4, "stiffness": 5e7, "damping_ratio": 0.1, "friction": 0.2}
    scene = tmp_path / "three.toml"
    scene.write_text(rsc.Scene.from_dict({**TWO, "contact": [*TWO["contact"], third]}).to_toml())
    assert cli.main(["predict", str(scene), "--speed", "20"]) == 0
    assert "none is missing is not shown" in capsys.readouterr().out
