"""Coefficients that follow the speed: numbers of other programs, closed forms, a slow twin, prediction against simulation."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rsc
from naive import integrate
from rsc.analysis.alone.free_vibration import threshold_speed
from rsc.analysis.balance.balance import balance
from rsc.analysis.follow.branches import branches
from rsc.analysis.follow.one_whirl import follow
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.predict_many import predict_many
from rsc.analysis.paper.receptance import coupled_frequencies, uncoupled_frequencies
from rsc.analysis.paper.stability import whirl_growth
from rsc.analysis.survey.remarks import scene_remarks
from rsc.kernel.tableau import METHODS
from rsc.scene.values import physical_values, with_entries
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from scenes import LAVAL, SCENES, changed
from systems import TWO_PI
from tiers import alternating, nightly
from whirl_motions import distance_between, numerical_eigenvalues


def knot(speed, k, s, b):
    """A knot alike in all directions: stiffness, cross-coupled stiffness S and damping."""
    return [speed, [k, -s, s, k], [b, 0.0, 0.0, b]]


SUPPORT = [0, [knot(20.0, 0.0, 0.0, 0.0), knot(45.0, 8e3, -300.0, 5.0), knot(80.0, 2e4, -900.0, 2.0)]]
# 1 kg, 30 Hz, run up over the knots
ROTOR = changed(
    LAVAL,
    rotor={"supports_by_speed": [SUPPORT]},
    contact={"stiffness": 3.5e6, "damping_ratio": None, "diameter": 0.04, "slip_velocity": 0.02},
    drive={"speed": [20.0, 80.0], "duration": 2.0},
    output={"rate": 500.0},
    start={"rotor": [[0.5e-3, 0.9e-3]], "rotor_velocity": [[0.1, 0.0]], "stator": [[0.0, 0.0]], "stator_velocity": [[0.0, 0.0]]},
)
WITHOUT_DIAMETER = changed(ROTOR, contact={"diameter": None, "slip_velocity": None})
# everything at once: directions that differ, cross-coupled damping, knots of two places beside each other, rotating damping
UNEQUAL = [
    [0, [[48.0, [4e3, 1e3, -2e3, -2e3], [2.0, 0.5, 0.1, 1.0]], [53.0, [9e3, -1e3, 1e3, 3e3], [0.0, 3.0, -1.0, 4.0]]]],
    [0, [[51.0, [1e3, 0.0, 0.0, 0.0]], [58.0, [-2e3, 0.0, 300.0, 0.0]]]],
]
_DISK = changed(SCENES["gyroscopic disk"], rotor={"supports_by_speed": UNEQUAL, "rotating_damping": [[0.9, 0.02], [0.02, 0.003]]})
_MATRICES = {
    "model": "matrices", "mass": [[1.0, 0.0], [0.0, 0.01]], "stiffness": [[69408.0, -3160.6], [-3160.6, 1308.89]],
    "damping": [[2.6, 0.1], [0.1, 0.036]], "gyroscopic": [[0.0, 0.0], [0.0, 0.016]], "tilt_coordinates": [1],
    "eccentricity": [[5e-5, 30.0], [1e-3, 200.0]], "supports": [[0, [4e3, 1e3, -2e3, -2e3], [2.0, 0.5, 0.1, 1.0]]],
    "supports_by_speed": UNEQUAL,
}  # fmt: skip
BODIES = {
    "laval": changed(ROTOR, drive={"speed": [40.0, 75.0], "duration": 0.4}),
    "up and down": changed(ROTOR, drive={"speed": None, "duration": None, "schedule": [[0.0, 60.0], [0.2, 30.0], [0.4, 90.0]]}),
    "disk": _DISK,
    "chain": changed(
        SCENES["chains"],
        rotor={"supports_by_speed": [[2, SUPPORT[1]], [1, [knot(50.0, 2e3, 0.0, 1.0), knot(56.0, 9e3, 400.0, 0.0)]]]},
        drive={"duration": 0.15},
    ),
    "matrices": changed(SCENES["gyroscopic disk"], rotor=_MATRICES, contact={"diameter": 0.04, "slip_velocity": 0.02}),
    "rigid wall": changed(
        SCENES["rigid wall"],
        rotor={"supports_by_speed": [[0, [knot(52.0, 1e3, 9.0, 0.0), knot(57.0, 5e3, -99.0, 0.0)]]]},
    ),
}


def scene_of(tables, method="auto", rtol=1e-9):
    return rsc.Scene.from_dict({**tables, "solver": {"rtol": rtol, "method": method}})


REPEATED = ("disk", "chain", "matrices", "rigid wall")  # half a minute each
OTHERS = [name for name in BODIES if name not in REPEATED]


REPETITIONS = [nightly(*pair) for pair in itertools.product(REPEATED, METHODS)]


@pytest.mark.parametrize(("name", "method"), REPETITIONS + alternating(OTHERS, METHODS))
def test_motion_in_contact_is_that_of_the_slow_twin(name, method):
    scene = scene_of(BODIES[name], method)
    system = assemble(scene)
    result = rsc.simulate(scene)
    assert result.summary.contact_time > 0.0 and result.ledger.followed_in != 0.0
    rotor, _ = integrate(system, initial_state(scene, system), result.time)
    assert abs(result.rotor - rotor).max() < 1e-5 * scene.contact.gap
    assert abs(result.ledger.residual) < 1e-7 * result.ledger.turnover


@pytest.mark.parametrize("method", METHODS)
def test_a_run_up_over_three_knots(method):
    """20 to 80 Hz in 2 s, of another program, whose own error is 7e-9 gaps."""
    result = rsc.simulate(scene_of(ROTOR, method, 1e-10))
    places = [-0.58111451 + 0.30314933j, -0.05695308 - 0.02227179j, -0.00368691 + 0.07522116j, -0.06458330 - 0.00171269j]
    assert abs(result.rotor[[250, 500, 750, 1000], 0] / 1e-3 - places).max() < 1.5e-8
    assert abs(result.ledger.residual) < 1e-6 * result.ledger.turnover


@pytest.mark.parametrize(
    ("speed", "frequency", "force"),
    [(20.0, -62.525884, 342.5632), (35.0, -62.156139, 289.7066), (65.0, -63.068705, 256.1488)],
)
def test_whirls_of_another_program(speed, frequency, force):
    whirls = rsc.predict(scene_of(changed(ROTOR, contact={"friction": 0.25})), speed)
    large = max((whirl for whirl in whirls if whirl.frequency > -100.0), key=lambda whirl: whirl.normal_force)
    assert large.frequency == pytest.approx(frequency, abs=6e-7) and large.normal_force == pytest.approx(force, abs=6e-5)


def roots_of_plain_numbers(tables, speed):
    """Backward roots of Im (1 + i mu) H = 0 of a Laval rotor in a one-mass stator: the polynomial of physics, each coefficient by
    interpolation; nothing of rsc."""
    knots = tables["rotor"]["supports_by_speed"][0][1]
    at = [row[0] for row in knots]
    k_more, s, b_more = (
        np.interp(speed, at, column)
        for column in ([row[1][0] for row in knots], [row[1][2] for row in knots], [row[2][0] for row in knots])
    )
    m, m_s, mu = 1.0, 0.25, tables["contact"]["friction"]
    w, w_s = TWO_PI * 30.0, TWO_PI * 150.0
    k, b, k_s, b_s = m * w**2 + k_more, 2 * 0.02 * m * w + b_more, m_s * w_s**2, 2 * 0.1 * m_s * w_s
    P = np.polynomial.Polynomial
    a, beta, A, B = P([k, 0, -m]), P([s, b]), P([k_s, 0, -m_s]), P([0, b_s])
    # (a - i beta)/(a^2 + beta^2) + ...: Im of (1 + i mu) times it
    condition = mu * (a * (A * A + B * B) + A * (a * a + beta * beta)) - beta * (A * A + B * B) - B * (a * a + beta * beta)
    roots = condition.roots()
    return np.sort(roots[(abs(roots.imag) < 1e-9 * abs(roots)) & (roots.real < 0.0)].real) / TWO_PI


@pytest.mark.parametrize("speed", [5.0, 20.0, 31.3, 45.0, 63.0, 80.0, 120.0])
def test_roots_are_those_of_a_polynomial(speed):
    tables = changed(WITHOUT_DIAMETER, contact={"friction": 0.25})
    expected = roots_of_plain_numbers(tables, speed)
    found = np.sort([whirl.frequency for whirl in rsc.predict(scene_of(tables), speed)])
    assert len(found) >= 2
    assert all(min(abs(expected - one)) < 1e-6 for one in found)


@pytest.mark.parametrize("method", ["taylor8", nightly("rk45")])
def test_a_rotor_that_turns_backwards_is_the_mirror_image(method):
    for name in ("up and down", "matrices"):
        scene = scene_of(BODIES[name], method)
        forward, backward = rsc.simulate(scene), rsc.simulate(scene.mirrored())
        assert np.array_equal(forward.rotor, -backward.rotor.conj())
        assert forward.ledger.followed_in == backward.ledger.followed_in
    whirls, mirrored = rsc.predict(scene, 50.0), rsc.predict(scene.mirrored(), -50.0)
    assert [w.frequency for w in mirrored[::-1]] == [-w.frequency for w in whirls] and whirls
    assert scene.mirrored().mirrored().to_dict() == scene.to_dict()


@pytest.mark.parametrize(("method", "order"), [nightly("rk45", 5.0), ("taylor8", 8.0)])
def test_error_falls_with_the_order_of_the_method_over_the_knots(method, order):
    tables = changed(ROTOR, stator={"model": "rigid"}, contact={"gap": 0.02}, drive={"speed": [15.0, 95.0], "duration": 0.5},
                     start={"rotor": [[1e-3, 0.0]], "rotor_velocity": [[0.0, 0.19]]})  # fmt: skip
    exact, rows = rsc.simulate(scene_of(tables, "taylor8", 1e-13)), []
    assert not exact.summary.contact_time
    for rtol in (1e-7, 1e-8, 1e-9, 1e-10):
        result = rsc.simulate(scene_of(tables, method, rtol))
        rows.append((np.log(result.steps), np.log(abs(result.rotor - exact.rotor).max())))
    assert order - 0.5 < -np.polyfit(*np.transpose(rows), 1)[0] < order + 1.0


@pytest.mark.parametrize("method", ["taylor8", nightly("rk45")])
def test_the_ledger_of_springs_that_follow_the_speed(method):
    """What they feed is 1/2 int Omega' Re(r^H K_b r + r^H E_b conj(r)) dt, what the unbalance does is Re int v^H F dt: of an
    integration without contact of y and z, which adds up both."""
    own = [0, [[25.0, [3e3, 500.0, -900.0, -1e3], [3.0, 0.0, 0.0, 1.0]], [55.0, [9e3, 800.0, 900.0, 4e3], [1.0, 2.0, -2.0, 5.0]]]]
    tables = changed(ROTOR, rotor={"supports_by_speed": [own], "eccentricity": [5e-5, 40.0]}, stator={"model": "rigid"},
                     contact={"gap": 0.02}, drive={"speed": [20.0, 60.0], "duration": 0.5},
                     start={"rotor": [[1e-3, -2e-3]], "rotor_velocity": [[0.1, 0.2]]})  # fmt: skip
    ledger = rsc.simulate(scene_of(tables, method, 1e-11)).ledger
    w, rate = TWO_PI * 30.0, TWO_PI * 80.0
    speeds = TWO_PI * np.array([25.0, 55.0])
    stiffness, damping = (np.array([row[part] for row in own[1]]) for part in (1, 2))

    def f(t, state):
        y, z, u, v, *_ = state
        Omega, phi = TWO_PI * 20.0 + rate * t, TWO_PI * 20.0 * t + 0.5 * rate * t * t
        K = np.array([np.interp(Omega, speeds, column) for column in stiffness.T]).reshape(2, 2)
        C = np.array([np.interp(Omega, speeds, column) for column in damping.T]).reshape(2, 2)
        inside = speeds[0] < Omega < speeds[1]
        K_b = np.diff(stiffness, axis=0).reshape(2, 2) / np.diff(speeds) * inside
        moved, moving = np.array([y, z]), np.array([u, v])
        force = 5e-5 * (Omega**2 - 1j * rate) * np.exp(1j * (phi + np.deg2rad(40.0)))
        force = np.array([force.real, force.imag])
        skew = 0.5 * (K - K.T)
        a = force - w * w * moved - 2 * 0.02 * w * moving - K @ moved - C @ moving
        fed = 0.5 * rate * moved @ K_b @ moved
        lost = 2 * 0.02 * w * moving @ moving + moving @ C @ moving
        return np.array([u, v, *a, fed, moving @ (force - skew @ moved), lost])

    at = [0.0, *((speeds / TWO_PI - 20.0) / 80.0), 0.5]
    state = np.array([1e-3, -2e-3, 0.1, 0.2, 0.0, 0.0, 0.0])
    for begin, end in itertools.pairwise(at):
        state = solve_ivp(f, (begin, end), state, "DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
    size = 1e-6 * ledger.turnover
    assert ledger.followed_in == pytest.approx(state[4], abs=size) and abs(ledger.followed_in) > 1e-3 * ledger.turnover
    assert ledger.energy_in == pytest.approx(state[5], abs=size)
    assert ledger.rotor_damping == pytest.approx(state[6], abs=size)
    assert abs(ledger.residual) < 1e-7 * ledger.turnover


@pytest.mark.parametrize("speed", [25.0, 45.0, 75.0])
@pytest.mark.parametrize("name", ["laval", nightly("disk")])
def test_predicted_whirls_are_simulated(name, speed):
    """Frequency, force and amplitude of a stable whirl, at a knot as well."""
    tables = changed(BODIES[name], drive={"speed": speed, "duration": 0.6}, start={"whirl": "backward"})
    rotor = tables["rotor"]
    rotor |= {key: 0.0 for key in rotor if "ecc" in key}
    if name == "disk":
        rotor["supports_by_speed"] = [SUPPORT]
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


@pytest.mark.parametrize("name", ["laval", "chain"])
def test_stability_is_that_of_the_equations_linearised_by_differences(name):
    system = assemble(scene_of(changed(BODIES[name], contact={"friction": 0.35, "diameter": None, "slip_velocity": None})))
    for whirl in predict_system(system, 54.0):
        at = TWO_PI * whirl.frequency, whirl.normal_force, TWO_PI * 54.0
        found, _ = numerical_eigenvalues(system.at_speed(at[2]), *at, 0.0)
        assert distance_between(whirl_growth(system, *at, b_star=0.0).eigenvalues, found) < 1e-5


def test_branches_and_stacks_are_the_whirls_at_every_speed():
    scene, speeds = scene_of(changed(WITHOUT_DIAMETER, contact={"friction": 0.25})), np.linspace(10.0, 90.0, 17)
    system = assemble(scene)
    found = branches(system, speeds)
    assert found
    for branch in found:
        for speed, frequency in zip(branch.speed, branch.frequency, strict=True):
            known = [w.frequency for w in predict_system(system, speed)]
            assert min(abs(frequency - one) for one in known) < 1e-8
    large = next(branch for branch in found if abs(branch.frequency[0] + 62.5) < 0.5)
    alone = follow(system, float(large.frequency[0]), speeds)
    assert alone.frequency == pytest.approx(large.frequency, abs=1e-8) and np.ptp(large.frequency[4:]) > 1e-2
    assert np.ptp(large.frequency[:3]) < 1e-9  # constant below the first knot
    knots = [[0, [knot(5.0, 1e3, 0.0, 0.0), knot(60.0, 0.0, 100.0, 1.0)]]], None
    others = [scene_of(changed(WITHOUT_DIAMETER, rotor={"supports_by_speed": own}, contact={"friction": 0.25})) for own in knots]
    many = predict_many([scene, *others], speeds)
    for i, one in enumerate((scene, *others)):
        for j, speed in enumerate(speeds):
            known, own = many.frequency[i, j], rsc.predict(one, float(speed))
            assert known[np.isfinite(known)] == pytest.approx([w.frequency for w in own], rel=1e-9)


def test_what_is_derived_of_a_system_at_a_speed_is_that_of_a_constant_one():
    """Balance, modes and natural frequencies of coefficients that follow are those of a scene whose supports have them always."""
    k, s, b = 8e3 + 12e3 * 20.0 / 35.0, -300.0 - 600.0 * 20.0 / 35.0, 5.0 - 3.0 * 20.0 / 35.0
    constant = changed(WITHOUT_DIAMETER, rotor={"supports_by_speed": None, "supports": [[0, *knot(0.0, k, s, b)[1:]]]})
    one, other = (scene_of(changed(tables, contact={"friction": 0.16})) for tables in (WITHOUT_DIAMETER, constant))
    own, fixed = assemble(one), assemble(other)
    for a, c in zip(rsc.modes(one, 65.0).coupled, rsc.modes(other, 65.0).coupled, strict=True):
        assert (a.frequency, a.growth_rate) == pytest.approx((c.frequency, c.growth_rate), rel=1e-10)
        assert (a.undamped, a.share) == pytest.approx((c.undamped, c.share), rel=1e-10)
    speeds = TWO_PI * np.array([30.0, 65.0])
    for frequencies in (coupled_frequencies, uncoupled_frequencies):
        assert frequencies(own, speeds)[1] == pytest.approx(frequencies(fixed, speeds[1]), rel=1e-12)
        assert frequencies(own, speeds).shape == frequencies(fixed, speeds).shape
    whirl = next(w for w in predict_system(own, 65.0) if w.stable)
    balanced = [balance(system, whirl.frequency, 65.0).frequency for system in (own, fixed)]
    assert balanced[0] == pytest.approx(balanced[1], rel=1e-9)
    table = rsc.modes(one, [20.0, 65.0])
    assert table[0].rotor[0].frequency != pytest.approx(table[1].rotor[0].frequency, rel=1e-2)


def test_remarks_tell_the_range_and_the_threshold():
    """m L^2 + b L + k(Omega) + i S(Omega) = 0 has a growing root where |S| > b sqrt(k/m), to first order."""
    tables = changed(ROTOR, rotor={"supports_by_speed": [[0, [knot(0.0, 0.0, 0.0, 0.0), knot(100.0, 0.0, -3e3, 0.0)]]]})
    system = assemble(scene_of(tables))
    b, k = 2 * 0.02 * TWO_PI * 30.0, (TWO_PI * 30.0) ** 2
    speed = threshold_speed(system) / TWO_PI
    assert speed == pytest.approx(b * np.sqrt(k) / 3e3 * 100.0, rel=1e-9)
    text = "; ".join(scene_remarks(system, []))
    assert f"coefficients that follow the speed make the rotor unstable without contact above {speed:.6g} Hz" in text
    assert "constant beyond" not in text
    beyond = "; ".join(scene_remarks(assemble(scene_of(changed(ROTOR, drive={"speed": [10.0, 80.0]}))), []))
    assert "coefficients follow the rotor speed from 20 to 80 Hz and are constant beyond: the run turns at 10 to 80 Hz" in beyond
    pushing = [[0, [knot(0.0, -5e4, 0.0, 0.0), knot(30.0, 0.0, 0.0, 0.0)]]]
    pushed = changed(ROTOR, rotor={"supports_by_speed": pushing}, drive={"speed": [0.0, 50.0]})
    told = "; ".join(scene_remarks(assemble(scene_of(pushed)), []))
    assert "the rotor is unstable without contact at a rotor speed of 0 Hz: it is pushed away at" in told


def test_results_keep_the_knots_and_what_they_fed(tmp_path):
    scene = scene_of(changed(BODIES["laval"], rotor={"supports_by_speed": UNEQUAL}))
    path = tmp_path / "run.h5"
    result = rsc.simulate(scene, path=path)
    loaded = rsc.load(path)
    assert loaded.ledger == result.ledger and result.ledger.followed_in != 0.0
    assert loaded.scene.to_dict() == scene.to_dict()


def test_a_number_of_a_knot_is_swept_by_its_name_and_has_a_sensitivity():
    scene = scene_of(changed(WITHOUT_DIAMETER, contact={"friction": 0.25}))
    name = "rotor.supports_by_speed[0][1][1][1][0]"  # k_xx at 45 Hz
    softer = with_entries(scene, {name: 7e3, "rotor.supports_by_speed[0][1][1][1][3]": 7e3})
    assert softer.rotor.supports_by_speed[0][1][1][1] == (7e3, 300.0, -300.0, 7e3)
    shifts = [rsc.predict(softer, f)[1].frequency - rsc.predict(scene, f)[1].frequency for f in (20.0, 40.0, 80.0)]
    assert [abs(shift) > 1e-6 for shift in shifts] == [False, True, False]
    assert {name, "rotor.supports_by_speed[0][1][2][2][3]", "rotor.supports_by_speed[0][1][0][0]"} <= set(physical_values(scene))


@pytest.mark.parametrize(
    ("supports", "key"),
    [
        ([[1, SUPPORT[1]]], r"supports_by_speed\[0\]\[0\]"),
        ([[0, SUPPORT[1][:1]]], r"supports_by_speed\[0\]\[1\].* two knots"),
        ([[0, SUPPORT[1][::-1]]], r"supports_by_speed\[0\]\[1\]\[1\]\[0\].*in order"),
        ([[0, [SUPPORT[1][0], SUPPORT[1][0]]]], r"supports_by_speed\[0\]\[1\]\[1\]\[0\]"),
        ([[0, [[20.0, [1.0, 2.0], [0.0] * 4], SUPPORT[1][1]]]], r"supports_by_speed\[0\]\[1\]\[0\]\[1\]"),
        ([[0, [[20.0], SUPPORT[1][1]]]], r"supports_by_speed\[0\]\[1\]\[0\]"),
        ([[0, [["20 kg", [0.0] * 4], SUPPORT[1][1]]]], r"supports_by_speed\[0\]\[1\]\[0\]\[0\]"),
        ([[0, [[20.0, [float("nan")] * 4], SUPPORT[1][1]]]], r"supports_by_speed\[0\]\[1\]\[0\]\[1\]\[0\]"),
        ([[0, 5.0]], r"supports_by_speed\[0\]\[1\]"),
        ([0], r"supports_by_speed\[0\]"),
        (5.0, "supports_by_speed"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(supports, key):
    with pytest.raises(rsc.SceneError, match=key) as refused:
        scene_of(changed(ROTOR, rotor={"supports_by_speed": supports}))
    assert "\n" not in str(refused.value)


def test_a_tilt_a_stator_and_a_reduced_key_are_refused():
    for tables in (
        changed(SCENES["gyroscopic disk"], rotor={"supports_by_speed": [[1, SUPPORT[1]]]}),
        changed(ROTOR, stator={"supports_by_speed": [SUPPORT]}),
    ):
        with pytest.raises(rsc.SceneError, match="supports_by_speed"):
            scene_of(tables)
