"""Damping that turns with the rotor: an integration of y and z of its own, closed forms, and prediction against simulation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rsc
from once import once
from rsc.analysis.alone.free_vibration import threshold_speed
from rsc.analysis.balance.balance import balance
from rsc.analysis.balance.floquet import balance_growth
from rsc.analysis.follow.branches import branches
from rsc.analysis.follow.least_friction import least_frictions
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.predict_many import predict_many
from rsc.analysis.paper.stability import whirl_growth
from rsc.analysis.survey.remarks import scene_remarks
from rsc.kernel.tableau import METHODS
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from rsc.system.system import stacked
from scenes import LAVAL, SCENES, changed
from systems import TWO_PI
from tiers import alternating, nightly
from whirl_motions import distance_between, numerical_eigenvalues

OMEGA = TWO_PI * 30.0
# 1 kg, 30 Hz, as much external as rotating damping
SHAFT = changed(
    LAVAL,
    rotor={"damping_ratio": 0.01, "rotating_damping_ratio": 0.01},
    contact={"stiffness": 3.5e6, "friction": 0.15, "damping_ratio": None, "diameter": 0.04, "slip_velocity": 0.02},
    drive={"speed": [70.0, 90.0], "duration": 2.0},
    output={"rate": 500.0},
    start={"rotor": [[0.5e-3, 0.9e-3]], "rotor_velocity": [[0.1, 0.0]], "stator": [[0.0, 0.0]], "stator_velocity": [[0.0, 0.0]]},
)
WITHOUT_DIAMETER = changed(SHAFT, contact={"diameter": None, "slip_velocity": None})
FULL = [[0.9, 0.02], [0.02, 0.003]]
DIRECTED = {
    "model": "matrices", "mass": [[1.0, 0.0], [0.0, 0.01]], "stiffness": [[69408.0, -3160.6], [-3160.6, 1308.89]],
    "damping": [[2.6, 0.0], [0.0, 0.036]], "gyroscopic": [[0.0, 0.0], [0.0, 0.016]], "tilt_coordinates": [1],
    "eccentricity": [[5e-5, 30.0], [1e-3, 200.0]], "supports": [[0, [4e3, 1e3, -2e3, -2e3], [2.0, 0.5, 0.1, 1.0]]],
    "rotating_damping": FULL,
}  # fmt: skip
BODIES = {
    "laval": changed(SHAFT, drive={"speed": [40.0, 75.0], "duration": 0.4}),
    "disk": changed(SCENES["gyroscopic disk"], rotor={"rotating_damping": FULL}),
    "chain": changed(SCENES["chains"], rotor={"rotating_damping": [3.0, 1.5, 2.0, 0.0]}, drive={"duration": 0.15}),
    "matrices": changed(SCENES["gyroscopic disk"], rotor=DIRECTED, contact={"diameter": 0.04, "slip_velocity": 0.02}),
    "rigid wall": changed(SCENES["rigid wall"], rotor={"rotating_damping": 2.0}),
}


def scene_of(tables, method="auto", rtol=1e-9):
    return rsc.Scene.from_dict({**tables, "solver": {"rtol": rtol, "method": method}})


@once
def in_y_and_z(system, start, time):
    """Displacements of the rotor by the equations of y and z apart, real, for any speed schedule; of one-sided damping and
    Coulomb friction as the scene has them. Nothing complex but the answer."""
    rotor, stator, n, m = system.rotor, system.stator, system.n_rotor, system.n_stator
    law, gap, zero = system.law, system.contact.gap, np.zeros((system.n_rotor,) * 2)
    S, Q = (zero if part is None else part for part in (rotor.skew_stiffness, rotor.skew_damping))
    E, C = (zero if part is None else part for part in (rotor.anisotropic_stiffness, rotor.anisotropic_damping))
    D, contact, wall = rotor.rotating_damping, rotor.contact, stator.contact

    def angle(t):
        grid = np.append(system.schedule_time[system.schedule_time < t], t)
        return np.trapezoid(system.speed_at(grid), grid)

    def f(t, state):
        y, z, s, w, y_t, z_t, s_t, w_t = np.split(state, np.cumsum([n, n, m, m, n, n, m]))
        speed, phi = system.speed_at(t), angle(t)
        rate = (system.speed_at(t + 1e-7) - system.speed_at(t - 1e-7)) / 2e-7
        a, b, e = rotor.unbalance.real, rotor.unbalance.imag, rotor.unbalance_euler
        cos, sin = np.cos(phi), np.sin(phi)
        force_y = speed**2 * (a * cos - b * sin) + rate * (e.real * sin + e.imag * cos) + rotor.load.real
        force_z = speed**2 * (a * sin + b * cos) + rate * (e.imag * sin - e.real * cos) + rotor.load.imag
        # beside the shaft, which turns y towards z
        force_y = force_y - D @ (y_t + speed * z) - (rotor.damping + C.real) @ y_t + (Q - C.imag) @ z_t
        force_z = force_z - D @ (z_t - speed * y) - (rotor.damping - C.real) @ z_t - (Q + C.imag) @ y_t
        force_y = force_y - (rotor.stiffness + E.real) @ y + (S - E.imag) @ z - speed * rotor.gyroscopic @ z_t
        force_z = force_z - (rotor.stiffness - E.real) @ z - (S + E.imag) @ y + speed * rotor.gyroscopic @ y_t
        d_y, d_z = contact @ y - wall @ s, contact @ z - wall @ w
        v_y, v_z = contact @ y_t - wall @ s_t, contact @ z_t - wall @ w_t
        distance = np.hypot(d_y, d_z)
        pressed = 0.0
        if distance > gap:
            outward = (d_y * v_y + d_z * v_z) / distance
            pressed = max(law.stiffness * (distance - gap) + law.damping * min(outward, 0.0), 0.0)
        n_y, n_z, friction = d_y / max(distance, 1e-30), d_z / max(distance, 1e-30), law.friction
        if law.diameter is not None:
            slip = 0.5 * speed * law.diameter + n_y * v_z - n_z * v_y
            friction = friction * min(max(slip / law.slip_velocity, -1.0), 1.0)
        on_y, on_z = pressed * (n_y - friction * n_z), pressed * (n_z + friction * n_y)
        parts = [np.linalg.solve(rotor.mass, force - contact * on) for force, on in ((force_y, on_y), (force_z, on_z))]
        for place, moving, on in ((s, s_t, on_y), (w, w_t, on_z)):
            parts.append(np.linalg.solve(stator.mass, wall * on - stator.damping @ moving - stator.stiffness @ place) if m else s)
        return np.concatenate([y_t, z_t, s_t, w_t, *parts])

    own = (start.rotor, start.stator, start.rotor_velocity, start.stator_velocity)
    state = np.concatenate([part for pair in own for part in (pair.real, pair.imag)])
    size = 1e-11 * gap * np.repeat([1e-2, 1.0], state.size // 2)
    moved = solve_ivp(f, (time[0], time[-1]), state, "DOP853", time, rtol=1e-9, atol=size, max_step=5e-4).y
    return (moved[:n] + 1j * moved[n : 2 * n]).T


@pytest.mark.parametrize(("name", "method"), alternating(BODIES, METHODS, ["chain", "rigid wall"]))
def test_motion_in_contact_is_that_of_y_and_z(name, method):
    scene = scene_of(BODIES[name], method)
    system = assemble(scene)
    result = rsc.simulate(scene)
    motion = in_y_and_z(system, initial_state(scene, system), result.time)
    assert result.summary.contact_time > 0.0 and result.ledger.turned_in != 0.0
    assert abs(result.rotor - motion).max() < 1e-5 * scene.contact.gap
    assert abs(result.ledger.residual) < 1e-7 * result.ledger.turnover


@pytest.mark.parametrize("method", ["taylor8", nightly("rk45")])
def test_a_rotor_that_turns_backwards_is_the_mirror_image(method):
    for name in ("laval", "matrices"):
        scene = scene_of(BODIES[name], method)
        forward, backward = rsc.simulate(scene), rsc.simulate(scene.mirrored())
        assert np.array_equal(forward.rotor, -backward.rotor.conj())
        assert forward.ledger.turned_in == backward.ledger.turned_in
    whirls, mirrored = rsc.predict(scene, 50.0), rsc.predict(scene.mirrored(), -50.0)
    assert [w.frequency for w in mirrored[::-1]] == [-w.frequency for w in whirls] and whirls


@pytest.mark.parametrize("method", METHODS)
def test_a_rotor_above_its_threshold(method):
    """70 to 90 Hz in 2 s, of another program, whose own error is 2e-7 gaps."""
    result = rsc.simulate(scene_of(SHAFT, method, 1e-10))
    places = [0.32702435 + 0.29564415j, 0.48987676 + 0.60472346j, -0.81689189 - 0.62078188j, -0.90346278 + 0.48910988j]
    assert abs(result.rotor[[250, 500, 750, 1000], 0] / 1e-3 - places).max() < 2e-7
    assert abs(result.ledger.residual) < 1e-6 * result.ledger.turnover


QUIET = changed(
    SHAFT, rotor={"eccentricity": 0.0}, stator={"model": "rigid"}, contact={"gap": 0.02},
    drive={"speed": 80.0, "duration": 0.5}, start={"rotor": [[1e-3, 0.0]], "rotor_velocity": [[0.0, 0.19]]},
)  # fmt: skip


@pytest.mark.parametrize("method", ["taylor8", nightly("rk45")])
def test_the_ledger_of_a_growing_whirl(method):
    """From a start on the growing root of m L^2 + (b_e + b_i) L + k - i Omega b_i = 0 the motion is r_0 e^{L t}."""
    b, Omega = 2.0 * 0.01 * OMEGA, TWO_PI * 80.0
    root = max(np.roots([1.0, 2.0 * b, OMEGA**2 - 1j * Omega * b]), key=np.real)
    assert root.real > 0.5 and root.imag > 0.0  # forward
    velocity = 1e-3 * root
    tables = changed(QUIET, start={"rotor": [[1e-3, 0.0]], "rotor_velocity": [[velocity.real, velocity.imag]]})
    result, ledger = (run := rsc.simulate(scene_of(tables, method))), run.ledger
    assert abs(result.rotor[:, 0] - 1e-3 * np.exp(root * result.time)).max() < 50 * 1e-9 * 0.02
    squares = 1e-6 * np.expm1(2.0 * root.real * 0.5) / (2.0 * root.real)  # integral of |r|^2
    slide = root - 1j * Omega
    assert ledger.turned_in == pytest.approx(-Omega * b * slide.imag * squares, rel=1e-6)
    assert ledger.rotor_damping == pytest.approx(b * (abs(root) ** 2 + abs(slide) ** 2) * squares, rel=1e-6)
    assert ledger.energy_in == 0.0 and abs(ledger.residual) < 1e-7 * ledger.turnover


def test_nothing_is_taken_from_a_shaft_that_turns_as_it_is_bent():
    """At constant speed by its unbalance alone, without other damping: the drive gives nothing either."""
    tables = changed(QUIET, rotor={"eccentricity": 2e-5, "damping_ratio": 0.0}, drive={"speed": 20.0}, start={"running": True})
    ledger = rsc.simulate(scene_of(tables, "taylor8")).ledger
    kinetic = 0.5 * (TWO_PI * 20.0 * 1.6e-5) ** 2
    # a shaft that slid with the speed would lose four times the kinetic energy; what is left is the error of the run
    assert abs(ledger.rotor_damping) < 1e-6 * kinetic and abs(ledger.turned_in) < 1e-6 * kinetic


@pytest.mark.parametrize(("method", "order"), [("rk45", 5.0), ("taylor8", 8.0)])
def test_error_falls_with_the_order_of_the_method(method, order):
    tables = changed(QUIET, rotor={"eccentricity": 5e-5}, drive={"speed": [40.0, 90.0]})
    exact, rows = rsc.simulate(scene_of(tables, "taylor8", 1e-13)), []
    for rtol in (1e-7, 1e-8, 1e-9, 1e-10):
        result = rsc.simulate(scene_of(tables, method, rtol))
        rows.append((np.log(result.steps), np.log(abs(result.rotor - exact.rotor).max())))
    assert order - 0.5 < -np.polyfit(*np.transpose(rows), 1)[0] < order + 1.0


def test_the_threshold_of_a_laval_rotor():
    """Omega = omega_0 (1 + b_e/b_i), in the remark as well."""
    scene = scene_of(SHAFT)
    system = assemble(scene)
    assert threshold_speed(system) / TWO_PI == pytest.approx(60.0, abs=1e-9)
    assert "rotating damping makes the rotor unstable without contact above 60 Hz" in scene_remarks(system, [])
    for name, remark in (("damping_ratio", "above 30 Hz"), ("rotating_damping_ratio", "at no speed")):
        other = changed(SHAFT, rotor={name: 0.0})
        assert any(remark in text for text in scene_remarks(assemble(scene_of(other)), []))


@pytest.mark.parametrize(("speed", "friction"), [(20.0, 0.0936), (60.0, 0.1193), (100.0, 0.1436), (200.0, 0.2016)])
def test_the_least_friction_of_a_whirl_rises_with_the_speed(speed, friction):
    least, whirl = least_frictions(scene_of(WITHOUT_DIAMETER), speed)
    assert whirl.value == pytest.approx(friction, abs=5e-5)
    assert least.value <= whirl.value  # what runs away counts as well


@pytest.mark.parametrize("speed", [20.0, 45.0, 75.0])
@pytest.mark.parametrize("name", ["laval", "disk"])
def test_predicted_whirls_are_simulated(name, speed):
    """Frequency, force and amplitude of the stable whirl."""
    tables = changed(BODIES[name], drive={"speed": speed, "duration": 0.6}, start={"whirl": "backward"})
    rotor = tables["rotor"]
    rotor |= {key: 0.0 for key in rotor if "ecc" in key}
    tables = changed(tables, contact={"friction": 0.16, "diameter": None, "slip_velocity": None})
    scene = scene_of(tables, rtol=1e-10)
    result = rsc.simulate(scene)
    r = result.contact_rotor()
    turned = np.unwrap(np.angle(r))
    frequency = (turned[-1] - turned[0]) / (TWO_PI * result.time[-1])
    whirl = min(rsc.predict(scene), key=lambda one: abs(one.frequency - frequency))
    assert whirl.stable and frequency == pytest.approx(whirl.frequency, abs=1e-5)
    assert abs(r).max() == pytest.approx(whirl.rotor_amplitude, rel=1e-6) and abs(r).min() > 0.999999 * abs(r).max()
    assert result.normal_force[1:].mean() == pytest.approx(whirl.normal_force, rel=1e-5)


@pytest.mark.parametrize("name", ["laval", "disk", "chain"])
def test_stability_is_that_of_the_equations_linearised_by_differences(name):
    system = assemble(scene_of(changed(BODIES[name], contact={"friction": 0.35, "diameter": None, "slip_velocity": None})))
    for whirl in predict_system(system, 65.0):
        at = TWO_PI * whirl.frequency, whirl.normal_force, TWO_PI * 65.0
        found, _ = numerical_eigenvalues(system, *at, 0.0)
        assert distance_between(whirl_growth(system, *at, b_star=0.0).eigenvalues, found) < 1e-5


def test_a_balance_without_unbalance_is_the_whirl_and_so_is_its_growth():
    system = assemble(scene_of(changed(WITHOUT_DIAMETER, rotor={"eccentricity": 1e-12}, contact={"friction": 0.16})))
    whirl = next(w for w in predict_system(system, 65.0) if w.stable)
    found = balance(system, whirl.frequency, 65.0)
    assert found.frequency == pytest.approx(whirl.frequency, rel=1e-7)
    assert balance_growth(system, found).rate == pytest.approx(whirl.growth_rate, rel=1e-3)


def test_branches_and_stacks_are_the_whirls_at_every_speed():
    scene, speeds = scene_of(WITHOUT_DIAMETER), np.linspace(20.0, 80.0, 13)
    system = assemble(scene)
    for branch in branches(system, speeds):
        assert np.ptp(branch.frequency) > 1e-3  # they follow the speed
        for speed, frequency in zip(branch.speed, branch.frequency, strict=True):
            known = [w.frequency for w in predict_system(system, speed)]
            assert min(abs(frequency - one) for one in known) < 1e-8
    other = scene_of(changed(WITHOUT_DIAMETER, rotor={"rotating_damping_ratio": None}))
    many = predict_many([scene, other], speeds)
    for i, one in enumerate((scene, other)):
        for j, speed in enumerate(speeds):
            known, own = many.frequency[i, j], rsc.predict(one, float(speed))
            assert known[np.isfinite(known)] == pytest.approx([w.frequency for w in own], rel=1e-9)
    both = stacked([system, assemble(other)])
    assert both.follows and not assemble(other).follows


def test_results_keep_what_the_drive_gave(tmp_path):
    scene = scene_of(BODIES["laval"])
    result, path = rsc.simulate(scene), tmp_path / "run.h5"
    rsc.simulate(scene, path=path)
    assert rsc.load(path).ledger == result.ledger and result.ledger.turned_in > 0.0
    plain = tmp_path / "plain.h5"
    rsc.simulate(rsc.Scene.from_dict(SCENES["bouncing"]), path=plain)
    assert rsc.load(plain).ledger.turned_in == 0.0


@pytest.mark.parametrize(
    ("tables", "key"),
    [
        (changed(SHAFT, rotor={"rotating_damping_ratio": -0.1}), "rotor.rotating_damping_ratio"),
        (changed(SHAFT, rotor={"rotating_damping": 1.0}), "rotor.rotating_damping"),
        (changed(SHAFT, rotor={"rotating_damping_ratio": float("nan")}), "rotor.rotating_damping_ratio"),
        (changed(SHAFT, stator={"rotating_damping": 1.0}), "stator.rotating_damping"),
        (changed(SCENES["chains"], rotor={"rotating_damping": [1.0, 1.0, 1.0]}), "rotor.rotating_damping"),
        (changed(SCENES["chains"], rotor={"rotating_damping": [1.0, -1.0, 1.0, 1.0]}), r"rotor.rotating_damping\[1\]"),
        (changed(SCENES["chains"], rotor={"rotating_damping": 3.0}), "rotor.rotating_damping"),
        (changed(SCENES["gyroscopic disk"], rotor={"rotating_damping": [[1.0, 2.0], [2.0, 1.0]]}), "rotor.rotating_damping"),
        (changed(SCENES["gyroscopic disk"], rotor={"rotating_damping": [[1.0, 0.1], [0.0, 1.0]]}), "rotor.rotating_damping"),
        (changed(SCENES["gyroscopic disk"], rotor={**DIRECTED, "rotating_damping": [[1.0]]}), "rotor.rotating_damping"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(tables, key):
    with pytest.raises(rsc.SceneError, match=key) as refused:
        scene_of(tables)
    assert "\n" not in str(refused.value)
