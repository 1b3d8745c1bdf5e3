"""Whirls at several contacts of rotors with first-order states: equations of motion, a light mass in their place, and runs."""

from dataclasses import replace

import numpy as np
import pytest

import rsc
from dropped import dropped
from rsc.analysis.several.condition import pressed, settled
from rsc.analysis.several.pairs import pair_candidates
from rsc.analysis.several.predict import predict_several
from rsc.analysis.several.starts import ranges, secant_candidates
from rsc.scene.scene import Scene
from several_systems import dense, random_several
from systems import TWO_PI
from tiers import first

LIGHT = 1e-7  # of a mass that stands for none


def with_element(system, k=3e5, rate=400.0):
    """The rotor's last coordinate on a spring in series with a dashpot, as a state: z' = -rate z + x', force -k z."""
    n = system.n_rotor
    row = np.eye(n)[[-1]]
    states = {"state_matrix": np.array([[-rate]]), "state_displacement": 0.0 * row, "state_velocity": row,
              "state_force": -k * row.T, "state_stiffness": np.zeros((n, n))}  # fmt: skip
    return replace(system, rotor=replace(system.rotor, **states))


def with_mass(system, k=3e5, rate=400.0):
    """The same element with a mass between spring and dashpot, next to none."""
    body, n = system.rotor, system.n_rotor
    matrices = {name: np.pad(getattr(body, name), (0, 1)) for name in ("mass", "damping", "stiffness", "gyroscopic")}
    matrices["mass"][n, n] = LIGHT
    matrices["stiffness"][np.ix_([n - 1, n], [n - 1, n])] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    matrices["damping"][n, n] += k / rate
    vectors = {name: np.append(getattr(body, name), 0.0) for name in ("contact", "unbalance", "unbalance_euler", "load")}
    contacts = tuple(replace(contact, rotor=np.append(contact.rotor, 0.0)) for contact in system.contacts)
    rotor = replace(body, **matrices, **vectors, observers=np.zeros((0, n + 1)))
    return replace(system, rotor=rotor, contacts=contacts)


def forces_of(whirl):
    return np.array([[own.normal_force, np.radians(own.phase)] for own in whirl.contacts.values()]).T


@pytest.mark.parametrize("n", first([2, 3]))
def test_whirls_are_those_with_a_light_mass_in_the_place_of_the_states(n):
    """Frequencies, forces, phases, growth and lines of the unbalance, by programs that know nothing of states."""
    compared = 0
    for seed in range(6 if n == 2 else 2):
        system = random_several(np.random.default_rng(seed), n)
        system = replace(system, rotor=replace(system.rotor, unbalance=1e-6 * np.arange(1.0, system.n_rotor + 1.0) + 0j))
        whirls, wanted = (predict_several(add(system), 30.0) for add in (with_element, with_mass))
        highest = max((abs(whirl.frequency) for whirl in whirls), default=0.0)
        wanted = [whirl for whirl in wanted if abs(whirl.frequency) < 1.01 * highest]
        if n == 2:
            assert len(whirls) == len(wanted)
        for whirl in whirls:
            near = [one for one in wanted if one.pressed == whirl.pressed]
            other = min(near, key=lambda one: abs(one.frequency - whirl.frequency))
            assert whirl.frequency == pytest.approx(other.frequency, rel=1e-7)
            np.testing.assert_allclose(forces_of(whirl), forces_of(other), rtol=1e-5, atol=1e-6)
            assert whirl.growth_rate == pytest.approx(other.growth_rate, rel=1e-5, abs=1e-5 * TWO_PI * abs(whirl.frequency))
            form, same = whirl.synchronous.consistent, other.synchronous.consistent
            assert form.amplitude == pytest.approx(same.amplitude, rel=1e-4) and form.force == pytest.approx(same.force, rel=1e-4)
            compared += len(whirl.pressed) > 1
    assert compared >= 3


def test_whirls_meet_the_equations_of_motion_by_dense_matrices():
    """With D(Psi) of the element written out: k i Psi / (i Psi + rate)."""
    told = 0
    for seed in range(3):
        system = with_element(random_several(np.random.default_rng(seed)))
        for whirl in predict_several(system, 30.0):
            Psi, n = TWO_PI * whirl.frequency, system.n_rotor
            A, rows = dense(system, Psi, TWO_PI * 30.0)
            A[n - 1, n - 1] += 3e5 * 1j * Psi / (1j * Psi + 400.0)
            forces, angles = forces_of(whirl)
            laws = [contact.law for contact in system.contacts]
            pushes = [(1.0 + 1j * law.friction) * N * np.exp(1j * a) for law, N, a in zip(laws, forces, angles, strict=True)]
            x = np.linalg.solve(A, -np.array(pushes) @ rows)
            np.testing.assert_allclose([*whirl.rotor_shape, *whirl.stator_shape], x, rtol=1e-6, atol=1e-9 * abs(x).max())
            for contact, N, angle, d in zip(system.contacts, forces, angles, rows @ x, strict=True):
                if N > 0.0:
                    assert d == pytest.approx((contact.gap + N / contact.law.stiffness) * np.exp(1j * angle), rel=1e-7)
            told += len(whirl.pressed) == 2
    assert told >= 3


def test_the_scan_misses_no_whirl_that_many_starts_find():
    compared = 0
    for seed in range(100, 112):
        rng = np.random.default_rng(seed)
        system = with_element(random_several(rng))
        own = pressed(system, TWO_PI * 10.0 ** rng.uniform(0.5, 2.3), (0, 1))
        bounds = ranges(own, system.driven)
        scanned, wanted = (settled(own, start(own, bounds), bounds) for start in (pair_candidates, secant_candidates))
        for Psi, N in zip(wanted.Psi, wanted.N, strict=True):
            alike = (np.abs(scanned.Psi / Psi - 1.0) < 1e-6) & (np.abs(scanned.N / N - 1.0).max(axis=1) < 1e-3)
            assert alike.any(), seed
            compared += 1
    assert compared > 20


K, RATE, SPEED = 2e7, 1000.0, 200.0  # of the ring under each housing, a spring and a dashpot in series


def on_rings(**tables):
    """A rotor without weight above two auxiliary bearings whose housings stand on elastomer rings."""
    content = dropped(friction=0.15, gravity=0.0, duration=0.3, **tables).to_dict()
    both = {name: (np.eye(2) * value).tolist() for name, value in (("mass", 1.2), ("stiffness", 8e6), ("damping", 300.0))}
    rings = {"matrix": (-RATE * np.eye(2)).tolist(), "velocity": np.eye(2).tolist(), "force": (-K * np.eye(2)).tolist()}
    content["stator"] = {"model": "matrices", **both, "states": rings}
    for contact in content["contact"]:
        contact["stiffness"] = 2e7
    return content


def run_beside(content, whirl, near=1.0):
    """A run that starts on a whirl, the deflections of the rotor changed by factors, without an unbalance."""
    turn = TWO_PI * 1j * whirl.frequency
    pairs = {"rotor": whirl.rotor_shape * near, "rotor_velocity": turn * whirl.rotor_shape,
             "stator": whirl.stator_shape, "stator_velocity": turn * whirl.stator_shape,
             "stator_states": turn * whirl.stator_shape / (turn + RATE)}  # fmt: skip
    start = {name: np.column_stack([r.real, r.imag]).tolist() for name, r in pairs.items()}
    content = {**content, "start": {**start, "allow_penetration": True}}
    content["rotor"]["eccentricity"] = [0.0, 0.0]
    return rsc.simulate(Scene.from_dict(content))


def pair_whirl(content):
    (whirl,) = [one for one in rsc.predict(Scene.from_dict(content), SPEED) if one.stable and len(one.pressed) == 2]
    return whirl


def test_a_run_stays_on_a_whirl_at_both_contacts():
    whirl = pair_whirl(on_rings())
    result = run_beside(on_rings(), whirl)
    forces = [own.normal_force for own in whirl.contacts.values()]
    np.testing.assert_allclose(result.normal_force, np.broadcast_to(forces, result.normal_force.shape), rtol=1e-4)
    angle = np.unwrap(np.angle(result.rotor[:, 0]))
    assert (angle[-1] - angle[0]) / TWO_PI / result.time[-1] == pytest.approx(whirl.frequency, rel=1e-6)


def test_small_motions_about_such_a_whirl_die_away_at_the_predicted_rate():
    """The slowest of all of them is left after a while; without contact dampers, which act one way."""
    content = on_rings(output={"rate": 20000.0}, solver={"rtol": 1e-11})
    for contact in content["contact"]:
        contact["damping"] = 0.0
    whirl = pair_whirl(content)
    result = run_beside(content, whirl, 1.0 + 1e-4 * np.array([1.0, -1.0]))
    away = np.abs(result.normal_force[:, 0] - whirl.contacts["drive_end"].normal_force)
    blocks = away[: 20 * (len(away) // 20)].reshape(20, -1).max(axis=1)
    first, last = 3, 12
    rate = np.log(blocks[last] / blocks[first]) / (0.3 / 20 * (last - first))
    assert rate == pytest.approx(whirl.growth_rate, rel=0.03)
