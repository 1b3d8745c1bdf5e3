"""A drive with a torque: numbers of another program, an integration of y, z, phi and Omega, closed forms, ends and refusals."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rsc
from once import once
from rsc.errors import SceneError
from rsc.simulation.run import Run
from rsc.study.run.start import initial_state, run_of
from rsc.system.assemble import assemble
from scenes import SCENES, changed
from tiers import alternating, nightly
from two_seals import pump

TWO_PI = 2.0 * np.pi
METHODS = ("rk45", "taylor8")
# tripped at 60 Hz, in contact from the start
PUMP = {
    "rotor": {"model": "laval", "mass": 20.0, "frequency": 30.0, "damping_ratio": 0.02, "eccentricity": 1e-5},
    "stator": {"model": "laval", "mass": 40.0, "frequency": 150.0, "damping_ratio": 0.05},
    "contact": {"gap": 0.2e-3, "stiffness": 2e7, "friction": 0.1, "diameter": 0.05, "slip_velocity": 0.02},
    "drive": {"inertia": 0.15, "torque": [[0.0, -1.5], [100.0, -1.5]], "speed": 60.0, "duration": 2.0},
    "start": {"rotor": [[0.0, 0.0]], "rotor_velocity": [[0.25, 0.0]], "stator": [[0.0, 0.0]], "stator_velocity": [[0.0, 0.0]]},
    "output": {"rate": 2000.0},
}
FREE = changed(PUMP, rotor={"eccentricity": 0.0}, contact={"friction": 0.0})
WORKING = {"inertia": 0.15, "torque": [[0.0, 4.0], [30.0, 9.0], [55.0, 1.0]], "trip": 0.11, "coast": [[0.0, -1.0], [80.0, -3.0]],
           "speed": 40.0, "duration": 0.25, "schedule": None}  # fmt: skip
AT_CONTACT = {"diameter": 0.04, "slip_velocity": 0.02, "friction": 0.2, "ring_eccentricity": [4e-5, 130.0]}
FULL = [[0.9, 0.02], [0.02, 0.003]]
INCLINED = {
    "model": "matrices", "mass": [[1.0, 0.0], [0.0, 0.01]], "stiffness": [[69408.0, -3160.6], [-3160.6, 1308.89]],
    "damping": [[2.6, 0.0], [0.0, 0.036]], "gyroscopic": [[0.0, 0.0], [0.0, 0.016]], "tilt_coordinates": [1],
    "eccentricity": [[2e-4, 30.0], [0.02, 200.0]],
}  # fmt: skip
TWO_SEALS = {
    **pump(seal={"slip_velocity": 0.02, "ring_eccentricity": [3e-5, 130.0]}, bush={"slip_velocity": 0.05}).to_dict(),
    "drive": {key: value for key, value in (WORKING | {"inertia": 0.3}).items() if key != "schedule"},
    "start": {"rotor": [[0.0, 0.0]] * 3, "rotor_velocity": [[0.4, 0.0], [0.4, 0.1], [0.3, 0.0]],
              "stator": [[0.0, 0.0]] * 2, "stator_velocity": [[0.0, 0.0]] * 2},
}  # fmt: skip
# stiffness, cross-coupling and damping that follow the speed, and differ in y and z
BEARING = [[20.0, [2e5, 0.0, 0.0, 1e5], [50.0, 0.0, 0.0, 30.0]], [35.0, [5e5, -4e4, 5e4, 2e5], [90.0, 5.0, 0.0, 60.0]],
           [45.0, [9e5, -8e4, 8e4, 7e5], [40.0, 9.0, 2.0, 80.0]]]  # fmt: skip
BODIES = {
    "laval": changed(PUMP, rotor={"rotating_damping_ratio": 0.01}, contact=AT_CONTACT, drive={**WORKING, "inertia": 0.02}),
    "disk": changed(SCENES["gyroscopic disk"], rotor={"rotating_damping": FULL}, contact=AT_CONTACT, drive=WORKING),
    "inclined": changed(SCENES["gyroscopic disk"], rotor=INCLINED, contact=AT_CONTACT, drive={**WORKING, "inertia": 0.01}),
    "chains": changed(SCENES["chains"], contact=AT_CONTACT, drive=WORKING),
    "two seals": TWO_SEALS,
    # a lever in the weight
    "weight": changed(PUMP, rotor={"eccentricity": [2e-4, 40.0], "gravity": 9.81}, contact=AT_CONTACT,
                      drive={**WORKING, "inertia": 0.02}),
    "weight of a disk": changed(
        SCENES["gyroscopic disk"], rotor={**INCLINED, "eccentricity": [[5e-4, 30.0], [0.02, 200.0]], "gravity": 9.81},
        contact=AT_CONTACT, drive={**WORKING, "inertia": 0.01},
    ),
    "bearings": changed(
        PUMP, rotor={"supports_by_speed": [[0, BEARING]]}, contact=AT_CONTACT, drive={**WORKING, "inertia": 0.02}
    ),
}  # fmt: skip


def scene_of(tables, method="rk45", rtol=1e-9, **drive):
    return rsc.Scene.from_dict({**changed(tables, drive=drive), "solver": {"rtol": rtol, "method": method}})


def _supported(rotor, speed, r, r_t):
    """Force of springs and dampers on a rotor at displacements r and velocities, complex, at a speed in rad/s."""
    body = rotor.at_knots(speed) if rotor.knots is not None else rotor
    force = -body.stiffness @ r - body.damping @ r_t
    for kind, at in (("stiffness", r), ("damping", r_t)):
        for name, moved in ((f"skew_{kind}", 1j * at), (f"anisotropic_{kind}", at.conj())):
            matrix = getattr(body, name)
            force = force if matrix is None else force - matrix @ moved
    return force


@once
def program(scene, times):
    """(rotor, speed in Hz, angle in rad, work of the drive, heat of slip) by the equations of y, z, phi and Omega, real, whose
    accelerations one linear system gives."""
    system = assemble(scene)
    start = initial_state(scene, system)
    rotor, stator, n, m = system.rotor, system.stator, system.n_rotor, system.n_stator
    D = np.zeros((n, n)) if rotor.rotating_damping is None else rotor.rotating_damping
    a, b, e, f = rotor.unbalance.real, rotor.unbalance.imag, rotor.unbalance_euler.real, rotor.unbalance_euler.imag
    tables, gap = system.drive.torques, min(contact.gap for contact in system.contacts)
    matrix = np.zeros((2 * n + 1, 2 * n + 1))
    matrix[:n, :n] = matrix[n:-1, n:-1] = rotor.mass
    matrix[-1, -1] = system.drive.inertia

    def pushed(contact, parts, cos, sin, speed):
        """Force on the stator (y, z), its torque on the drive, and the heat of slip, at one contact."""
        ring, law, gap = contact.ring, contact.law, contact.gap
        y, z, s, w, y_t, z_t, s_t, w_t = parts
        ring_y, ring_z = ring.real * cos - ring.imag * sin, ring.real * sin + ring.imag * cos
        d_y = contact.rotor @ y - contact.stator @ s + ring_y
        d_z = contact.rotor @ z - contact.stator @ w + ring_z
        v_y = contact.rotor @ y_t - contact.stator @ s_t - speed * ring_z
        v_z = contact.rotor @ z_t - contact.stator @ w_t + speed * ring_y
        distance, normal = np.hypot(d_y, d_z), 0.0
        if distance > gap:
            outward = (d_y * v_y + d_z * v_z) / distance
            normal = max(law.stiffness * (distance - gap) + law.damping * min(outward, 0.0), 0.0)
        n_y, n_z = d_y / max(distance, 1e-30), d_z / max(distance, 1e-30)
        slip = 0.5 * speed * law.diameter + n_y * v_z - n_z * v_y
        rub = law.friction * min(max(slip / law.slip_velocity, -1.0), 1.0) * normal
        on_y, on_z = normal * n_y - rub * n_z, normal * n_z + rub * n_y
        return on_y, on_z, 0.5 * law.diameter * rub + ring_y * on_z - ring_z * on_y, rub * slip

    def rates(t, state, table):
        parts = np.split(state[:-4], np.cumsum([n, n, m, m, n, n, m]))
        y, z, s, w, y_t, z_t, s_t, w_t = parts
        phi, speed = state[-4:-2]
        cos, sin = np.cos(phi), np.sin(phi)
        at = [pushed(contact, parts, cos, sin, speed) for contact in system.contacts]
        e_y, e_z, a_y, a_z = e * cos - f * sin, e * sin + f * cos, a * cos - b * sin, a * sin + b * cos
        slide_y, slide_z = D @ (y_t + speed * z), D @ (z_t - speed * y)
        supported = _supported(rotor, speed, y + 1j * z, y_t + 1j * z_t)
        force_y = speed**2 * a_y - slide_y + supported.real - speed * rotor.gyroscopic @ z_t
        force_z = speed**2 * a_z - slide_z + supported.imag + speed * rotor.gyroscopic @ y_t
        on_rotor, on_stator = (
            [sum(getattr(contact, body) * own[i] for contact, own in zip(system.contacts, at, strict=True)) for i in (0, 1)]
            for body in ("rotor", "stator")
        )
        force_y, force_z = force_y + rotor.load.real - on_rotor[0], force_z + rotor.load.imag - on_rotor[1]
        torque = np.interp(speed, *table.T)
        gravity = getattr(scene.rotor, "gravity", 0.0) or 0.0
        levers = np.delete(np.arange(n), list(scene.rotor.tilts))
        net = torque - sum(own[2] for own in at) + y @ slide_z - z @ slide_y - gravity * e_y[levers].sum()
        net += speed * ((e_y - a_y) @ y_t + (e_z - a_z) @ z_t)  # of an inclined disk
        matrix[:n, -1], matrix[n:-1, -1], matrix[-1, :n], matrix[-1, n:-1] = -e_z, e_y, -e_z, e_y
        moved = np.linalg.solve(matrix, [*force_y, *force_z, net])
        parts = [y_t, z_t, s_t, w_t, moved[:n], moved[n:-1]]
        for place, moving, on in ((s, s_t, on_stator[0]), (w, w_t, on_stator[1])):
            parts.append(np.linalg.solve(stator.mass, on - stator.damping @ moving - stator.stiffness @ place))
        return np.concatenate([*parts, [speed, moved[-1], torque * speed, sum(own[3] for own in at)]])

    own = (start.rotor, start.stator, start.rotor_velocity, start.stator_velocity)
    state = np.concatenate([part for pair in own for part in (pair.real, pair.imag)])
    size = np.concatenate([1e-11 * gap * np.repeat([1e-2, 1.0], state.size // 2), [1e-10, 1e-9, 1e-8, 1e-8]])
    state = np.concatenate([state, [0.0, TWO_PI * scene.drive.speed[0], 0.0, 0.0]])
    made, first = [], 0.0
    for table, end in zip(tables, system.drive.ends, strict=True):
        inside = times[(times >= first) & (times < end)] if end < times[-1] else times[times >= first]
        solution = solve_ivp(
            rates, (first, end), state, "DOP853", np.unique([*inside, end]), rtol=1e-9, atol=size, max_step=3e-4, args=(table,)
        )  # fmt: skip
        made.append(solution.y[:, : len(inside)])
        state, first = solution.y[:, -1], end
    made = np.concatenate(made, axis=1)
    return (made[:n] + 1j * made[n : 2 * n]).T, made[-3] / TWO_PI, made[-4], state[-2], state[-1]


SLOW = ("disk", "inclined", "chains", "weight", "weight of a disk")  # a kernel for each


@pytest.mark.parametrize(("name", "method"), alternating(BODIES, METHODS, SLOW))
def test_motion_and_speed_are_those_of_y_z_phi_and_omega(name, method):
    scene = scene_of(BODIES[name], method)
    result = rsc.simulate(scene)
    rotor, speed, angle, work, heat = program(scene_of(BODIES[name]), result.time)
    assert result.summary.contact_time > 0.0 and np.ptp(result.speed) > 0.3
    assert abs(result.rotor - rotor).max() < 2e-5 * min(contact.gap for contact in scene.contacts)
    assert abs(result.speed - speed).max() < 1e-5
    assert abs(np.exp(2j * np.pi * result.angle) - np.exp(1j * angle)).max() < 1e-5
    ledger = result.ledger
    assert ledger.driven_in == pytest.approx(work, rel=1e-6, abs=1e-6 * ledger.turnover)
    assert -ledger.friction_in == pytest.approx(heat, rel=1e-6, abs=1e-6 * ledger.turnover) and heat > 0.0
    assert abs(ledger.residual) < 1e-6 * ledger.turnover


@pytest.mark.parametrize("method", METHODS)
def test_a_tripped_rotor_that_rubs(method):
    """Of another program, whose own error is 1.5e-7 Hz."""
    result = rsc.simulate(scene_of(PUMP, method, 1e-10))
    expected = [53.37033142, 44.52975626, 35.52302830, 26.46008430]
    assert abs(result.speed[[1000, 2000, 3000, 4000]] - expected).max() < 2e-7
    assert result.ledger.driven_in == pytest.approx(-835.272371, abs=5e-6)
    assert result.ledger.friction_in == pytest.approx(-7347.431227, abs=5e-6)
    assert abs(result.ledger.residual) < 1e-6 * result.ledger.turnover
    kinetic = 0.5 * 0.15 * (TWO_PI * np.array([60.0, result.speed[-1]])) ** 2
    assert result.ledger.change == pytest.approx(kinetic[1] - kinetic[0], rel=2e-3)


@pytest.mark.parametrize(("name", "method"), alternating(["laval", "inclined", "bearings"], METHODS, ["inclined", "bearings"]))
def test_a_very_heavy_rotor_is_a_prescribed_speed(name, method):
    steady, rate = {"speed": [40.0, 46.0], "duration": 0.3, "schedule": None}, 6.0 / 0.3
    without = dict.fromkeys(("inertia", "torque", "trip", "coast"))
    prescribed = scene_of(changed(BODIES[name], drive=without), method, 1e-12, **steady)
    torque = 1e12 * TWO_PI * rate
    heavy = scene_of(
        BODIES[name], method, 1e-12, inertia=1e12, torque=[[0.0, torque], [90.0, torque]], duration=0.3, trip=None, coast=None
    )
    ours, theirs = rsc.simulate(heavy), rsc.simulate(prescribed)
    assert abs(ours.rotor - theirs.rotor).max() < 1e-9 * heavy.contact.gap and theirs.summary.contact_time > 0.0
    assert abs(ours.speed - theirs.speed).max() < 1e-9


@pytest.mark.parametrize(("rtol", "method"), alternating([1e-4, 1e-6], METHODS, [1e-6]))
def test_steps_end_on_knots_of_coefficients(method, rtol):
    """The stiffness rises between two knots that are next to each other: a step over one of them would err by more."""
    knots = [[hz, [k, 0.0, 0.0, k]] for hz, k in ((34.0, 0.0), (36.0, 0.0), (36.01, 6e5), (50.0, 6e5))]
    rotor = {"supports_by_speed": [[0, knots]]}
    drive = {"duration": 2.0, "inertia": 0.04, "speed": 46.0}
    far = changed(BODIES["bearings"], rotor=rotor, contact={"gap": 5e-3, "ring_eccentricity": None}, drive=drive)
    ours, fine = (rsc.simulate(scene_of(far, method, tolerance)) for tolerance in (rtol, 1e-11))
    assert fine.summary.contact_time == 0.0 and fine.speed.min() < 34.0 < 46.0 <= fine.speed.max()
    assert abs(ours.rotor - fine.rotor).max() < 30.0 * rtol * ours.scene.contact.gap
    assert abs(ours.ledger.residual) < 10.0 * rtol * ours.ledger.turnover


def free_speed(scene, times):
    """Omega in rad/s without contact and unbalance: exact between knots, e^{b t/J}, step by step."""
    J, system = scene.drive.inertia, assemble(scene)
    tables, ends, speeds = system.drive.torques, [*system.drive.ends], []
    for t in times:
        Omega, now = TWO_PI * scene.drive.speed[0], 0.0
        for table, end in zip(tables, ends, strict=True):
            until = min(t, end)
            while until > now:
                knots, torque = table.T
                T = np.interp(Omega, knots, torque)
                i = int(np.searchsorted(knots, Omega, side="right" if T > 0.0 else "left"))
                low, high = ([-np.inf, *knots][i], [*knots, np.inf][i])
                b = 0.0 if i in (0, len(knots)) else (torque[i] - torque[i - 1]) / (knots[i] - knots[i - 1])
                target = high if T > 0.0 else low
                share = b * (target - Omega) / T if T else -1.0
                if b == 0.0:
                    needed = (target - Omega) * J / T if T else np.inf
                else:
                    needed = np.log1p(share) * J / b if share > -1.0 else np.inf
                lasts = min(needed, until - now)
                Omega = target if lasts == needed else Omega + (T * lasts / J if b == 0.0 else T / b * np.expm1(b * lasts / J))
                now += lasts
        speeds.append(Omega / TWO_PI)
    return np.array(speeds)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rtol", [1e-5, 1e-8])
def test_steps_end_on_knots_and_on_the_trip(method, rtol):
    scene = scene_of(
        FREE, method, rtol, speed=20.0, torque=[[0.0, 30.0], [25.0, 60.0], [26.0, 5.0], [40.0, 3.0], [50.0, 0.0]], duration=6.0,
        trip=2.2, coast=[[0.0, -0.5], [30.0, -9.0], [31.0, -2.0]], inertia=0.15,
    )  # fmt: skip
    result = rsc.simulate(scene)
    expected = free_speed(scene, result.time)
    assert expected[0] < 25.0 < 31.0 < expected.max() and expected[-1] < 30.0
    assert abs(result.speed / expected - 1.0).max() < 20.0 * rtol


def test_the_speed_of_a_motor_at_rest_of_its_torque_stays():
    result = rsc.simulate(scene_of(FREE, torque=[[0.0, 5.0], [60.0, 0.0], [61.0, -3.0]]))
    assert abs(result.speed - 60.0).max() < 1e-9 and result.steps < 20_000


def test_a_run_up_from_standstill():
    scene = scene_of(FREE, speed=0.0, torque=[[0.0, 2.0], [100.0, 2.0]], duration=0.5, inertia=0.1)
    result = rsc.simulate(scene)
    assert result.status == "finished"
    assert np.allclose(result.speed, result.time * 2.0 / 0.1 / TWO_PI, rtol=1e-9, atol=1e-9)
    assert scene.drive.fastest == pytest.approx(result.speed[-1])


@pytest.mark.parametrize("method", METHODS)
def test_a_rotor_that_stops_ends_its_run(method):
    scene = scene_of(PUMP, method, 1e-6, duration=9.0)
    result = rsc.simulate(scene)
    assert result.status == "stopped" and 4.0 < result.summary.end_time < 4.3
    assert "the rotor has stopped at 4.1" in result.summary.advice and "drive.torque" in result.summary.advice
    assert abs(result.speed[-1]) < 1e-2 and abs(result.ledger.residual) < 1e-6 * result.ledger.turnover


@pytest.mark.parametrize(
    ("name", "method"),
    [("pump", "rk45"), ("pump", "taylor8"), ("bearings", "taylor8"), nightly("bearings", "rk45"),
     *(nightly("disk", method) for method in METHODS)],
)  # fmt: skip
def test_an_interrupted_run_goes_on_with_the_same_bits(name, method):
    tables = PUMP if name == "pump" else BODIES[name]
    scene = scene_of(tables, method, 1e-6, duration=0.6, trip=0.2, torque=[[0.0, 3.0], [38.0, 1.5], [60.0, 1.0]])
    whole, run, cut = rsc.simulate(scene), run_of(scene), run_of(scene)
    cut._chunk_steps = lambda: 1
    assert np.array_equal(np.concatenate([block["speed"] for block, _ in cut.chunks()]), whole.speed)
    run._chunk_steps = lambda: 100
    speed = []
    for block, status in run.chunks():
        speed.append(block["speed"])
        if len(speed) == 2:
            assert status is None
            break
    later = Run.resumed(scene, run.checkpoint())
    speed += [block["speed"] for block, _ in later.chunks()]
    assert np.array_equal(np.concatenate(speed), whole.speed)


def test_result_files_hold_speed_and_angle(tmp_path):
    scene = scene_of(PUMP, rtol=1e-6, duration=0.5)
    result = rsc.simulate(scene, path=tmp_path / "a.h5")
    loaded = rsc.load(tmp_path / "a.h5")
    assert loaded.scene == scene and loaded.ledger == result.ledger and result.ledger.driven_in != 0.0
    alone = rsc.simulate(scene)
    assert np.array_equal(loaded.speed, alone.speed) and np.array_equal(loaded.angle, alone.angle)
    assert np.ptp(loaded.speed) > 1.0
    turned = np.unwrap(TWO_PI * loaded.angle) / TWO_PI
    assert turned[-1] == pytest.approx(np.trapezoid(loaded.speed, loaded.time), abs=1e-6)
    assert "angle" in loaded.to_xarray() and "angle in turns" in loaded.table().columns
    with pytest.raises(SceneError, match=r"drive\.torque"):
        _ = rsc.simulate(rsc.Scene.from_dict(changed(PUMP, drive=dict.fromkeys(("inertia", "torque")), start={}))).angle


@pytest.mark.parametrize("torque", [[[0.0, 40.0], [55.0, 25.0], [60.0, 0.0]], [[0.0, 40.0], [55.0, 25.0], [60.0, -5.0]]])
def test_the_result_of_a_motor_whose_torque_ends_is_read_again(torque, tmp_path):
    """By default the width of creeping follows from the speed at which the torque ends, which the stored scene then has."""
    drive = {"inertia": 0.15, "torque": torque, "speed": 50.0, "duration": 0.2, "trip": 0.1, "coast": [[0.0, -1.0], [60.0, -3.0]]}
    scene = rsc.Scene.from_dict({**changed(SCENES["bouncing"], contact={"diameter": 0.05}, start={"rest": True}), "drive": drive})
    assert type(scene.contact.slip_velocity) is float
    rsc.simulate(scene, path=tmp_path / "up.h5")
    assert rsc.load(tmp_path / "up.h5").scene == scene


@pytest.mark.parametrize("method", METHODS)
def test_ensembles_have_the_bits_of_single_runs(method):
    scenes = [scene_of(PUMP, method, 1e-6, duration=0.3, inertia=inertia) for inertia in (0.1, 0.15, 0.3)]
    scenes += [scene_of(BODIES["bearings"], method, 1e-6, inertia=inertia) for inertia in (0.02, 0.03)]
    for scene, result in zip(scenes, rsc.simulate_many(scenes, threads=2), strict=True):
        assert np.array_equal(result.speed, rsc.simulate(scene).speed)


def test_a_report_is_of_the_simulated_speed():
    from rsc.study.report.check import report

    result = rsc.simulate(scene_of(PUMP, rtol=1e-6, duration=3.0))
    told = report(result, lists=False)
    assert abs(told.features.speed - np.interp(told.features.time, result.time, result.speed)).max() < 0.02
    assert np.ptp(told.features.speed) > 5.0
