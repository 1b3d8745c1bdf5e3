"""Verification ladder with contact, V4 V5 V6 V7 V10 V13: kinks, whirl, forward rub, energy, reversal, limits.

Every oracle is a closed form or an exact piecewise solution that shares nothing with the kernel. Errors are in gaps.
"""

import itertools

import mpmath as mp
import numpy as np
import pytest

import rsc
from figures import met, slope
from piecewise_line import Line
from rsc.analysis.paper.synchronous import forward_rub
from rsc.system.assemble import assemble
from scenes import LAVAL, SCENES, changed
from systems import accelerations

GAP = 1e-3


def run(tables, rtol, rate=None):
    solver = {**tables.get("solver", {}), "rtol": rtol}
    output = tables.get("output", {}) if rate is None else {"rate": rate}
    return rsc.simulate(rsc.Scene.from_dict({**tables, "solver": solver, "output": output}))


def pair(value):
    return [[complex(value).real, complex(value).imag]]


# ---- V4

ROTOR, STATOR = (1.0, 8.0, 35531.0), (0.25, 47.0, 222066.0)
LINES = {
    "elastic, flexible": (STATOR, 0.0, 0.0),
    "damper, flexible": (STATOR, 90.0, 0.0),
    "elastic, rigid": (None, 0.0, 0.0),
    "damper and load, rigid": (None, 120.0, 20.0),
}


def body(values, **more):
    return {"model": "laval", "mass": values[0], "damping": values[1], "stiffness": values[2], **more}


@pytest.mark.parametrize("name", LINES)
def test_v4_kinks_on_one_line(name):
    """60 ms between the walls with 18 to 40 switches. An error of the speed lasts until the end, so that errors grow with the
    distance travelled: 5 rtol per gap travelled is allowed (12 to 22 gaps here; the first goal, 25 rtol, held on one scene that
    loses energy)."""
    stator, damper, load = LINES[name]
    line = Line(ROTOR, stator, (GAP, 3.553e6, damper), load)
    times = np.arange(241) / 4000.0
    start = [0.0, 0.5] if stator is None else [0.0, 0.0, 0.5, 0.0]
    exact, switches = line.march(start, times)
    assert len(switches) >= 16
    travelled = np.abs(np.diff(exact[:, 0])).sum() / GAP
    tables = {
        "rotor": body(ROTOR, load=[[load, 0.0]]),
        "stator": {"model": "rigid"} if stator is None else body(stator),
        "contact": {"gap": GAP, "friction": 0.0, "stiffness": 3.553e6, "damping": damper},
        "drive": {"speed": 0.0, "duration": 0.06},
        "start": {"rotor_velocity": [[0.5, 0.0]]},
        "solver": {"max_steps": 50_000},
    }
    tolerances, errors = 10.0 ** -np.arange(5.0, 12.1), []
    for rtol in tolerances:
        result = run(tables, rtol, 4000.0)
        assert result.status == "finished" and result.summary.switches == len(switches)
        errors.append(np.abs(result.rotor[:, 0] - exact[:, 0]).max() / GAP)
    assert not result.rotor.imag.any()
    times_rtol = (np.array(errors) / tolerances).max()
    met("V4", f"{name}: {len(switches)} switches, error / rtol", times_rtol, 5.0 * travelled)
    met("V4", f"{name}: |slope of error over rtol - 1|", abs(slope(tolerances, errors) - 1.0), 0.1)


def test_v4_oracle_keeps_energy_and_continuity():
    """The exact solution itself: without dampers the energy at all samples is that of the start."""
    line = Line((1.0, 0.0, 35531.0), (0.25, 0.0, 222066.0), (GAP, 3.553e6, 0.0))
    states, switches = line.march([0.0, 0.0, 0.5, 0.0], np.arange(201) / 4000.0)
    x_r, x_s, v_r, v_s = states.T
    pressed = np.maximum(np.abs(x_r - x_s) - GAP, 0.0)
    energy = 0.5 * (v_r**2 + 0.25 * v_s**2 + 35531.0 * x_r**2 + 222066.0 * x_s**2 + 3.553e6 * pressed**2)
    assert len(switches) >= 16 and (pressed > 0.0).any()
    assert energy == pytest.approx(0.125, rel=1e-13)


# ---- V5

WHIRLING = changed(rotor={"eccentricity": 0.0}, contact={"damping_ratio": None, "damping": 0.0})


def whirls():
    """(Psi in rad/s, rotor, stator, F_N) of every dry whirl of the Laval pair, by rising Psi: Im[(1 + i mu)(H_R + H_S)] = 0."""
    mu, k_c = LAVAL["contact"]["friction"], LAVAL["contact"]["stiffness"]
    parts = [(LAVAL[n]["mass"], 2 * np.pi * LAVAL[n]["frequency"], LAVAL[n]["damping_ratio"]) for n in ("rotor", "stator")]

    def receptances(psi):
        return [1 / (m * (w * w - psi * psi + 2j * z * w * psi)) for m, w, z in parts]

    def condition(psi):
        return mp.im((1 + 1j * mu) * sum(receptances(psi)))

    grid, found = np.linspace(-1500.0, -1.0, 4000), []
    values = [float(condition(p)) for p in grid]
    for low, high, a, b in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True):
        if a * b < 0.0:
            psi = mp.findroot(condition, (low, high), solver="anderson", tol=1e-30)
            h_r, h_s = receptances(psi)
            force = -GAP / (mp.re((1 + 1j * mu) * (h_r + h_s)) + 1 / mp.mpf(k_c))
            if force > 0:
                contact = (1 + 1j * mu) * force
                found.append((float(psi), complex(-h_r * contact), complex(h_s * contact), float(force)))
    return found


def started(state, duration):
    """The scene without unbalance from (r_R, r_S, v_R, v_S)."""
    names = ("rotor", "stator", "rotor_velocity", "stator_velocity")
    start = {name: pair(value) for name, value in zip(names, state, strict=True)}
    return changed(WHIRLING, start={**start, "allow_penetration": True}, drive={"speed": 50.0, "duration": duration})


def rates_and_shapes(psi, rotor, stator):
    """Eigenvalues and -vectors of small motions in the frame turning with psi: Jacobian of physics.md (2)-(11) by differences."""
    system = assemble(rsc.Scene.from_dict(started((rotor, stator, 1j * psi * rotor, 1j * psi * stator), 1.0)))
    still = np.array([rotor, stator, 1j * psi * rotor, 1j * psi * stator])
    size = np.repeat([GAP, GAP * abs(psi)], 2)

    def rate(parts):
        u = (parts[:4] + 1j * parts[4:]) * size + still
        moved = np.concatenate([u[2:], accelerations(system, u, 2 * np.pi * 50.0)]) - 1j * psi * u
        return np.concatenate([(moved / size).real, (moved / size).imag])

    assert np.abs(rate(np.zeros(8))).max() < 1e-9 * abs(psi)  # the closed form is an equilibrium
    jacobian = np.array([(rate(1e-6 * e) - rate(-1e-6 * e)) / 2e-6 for e in np.eye(8)]).T
    values, vectors = np.linalg.eig(jacobian)
    return values, vectors, size


def test_v5_stable_whirl_is_an_exact_relative_equilibrium():
    found = whirls()
    assert len(found) == 3
    psi, rotor, stator, force = found[1]  # between the uncoupled and the coupled frequency, at -60.66 Hz
    turns = 10_000
    for rtol in (1e-4, 1e-7, 1e-10):
        tables = started((rotor, stator, 1j * psi * rotor, 1j * psi * stator), turns * 2 * np.pi / abs(psi))
        result = run(tables, rtol)
        orbit = result.contact_rotor()
        radius = np.abs(np.abs(orbit) / abs(rotor) - 1.0).max()
        drift = np.abs(np.unwrap(np.angle(orbit * np.exp(-1j * psi * result.time) / rotor))).max() / turns
        met("V5", f"stable, rtol {rtol:.0e}: radius error / rtol over {turns} turns", radius / rtol, 1.0)
        met("V5", f"stable, rtol {rtol:.0e}: phase drift / rtol, rad a turn", drift / rtol, 1.0)
        assert result.normal_force == pytest.approx(force, rel=max(100 * rtol, 1e-11))


def test_v5_unstable_whirl_is_left_at_the_predicted_rate():
    """The whirl next to the uncoupled frequency, disturbed by 1e-7 gaps along its growing eigenvector."""
    psi, rotor, stator, _ = whirls()[-1]
    values, vectors, size = rates_and_shapes(psi, rotor, stator)
    i = int(np.argmax(values.real))
    growth, shape = values[i].real, vectors[:, i].real
    assert growth > 1.0 and values[i].imag == 0.0
    predictions = rsc.predict(rsc.Scene.from_dict(started((0, 0, 0, 0), 1.0)))
    prediction = min(predictions, key=lambda w: abs(2 * np.pi * w.frequency - psi))
    assert prediction.growth_rate == pytest.approx(growth, rel=1e-6)
    kick = 1e-7 * (shape[:4] + 1j * shape[4:]) / np.abs(shape).max() * size
    state = np.array([rotor, stator, 1j * psi * rotor, 1j * psi * stator]) + kick
    result = run(started(state, 8.0 / growth), 1e-12, 20_000.0)
    left = np.abs(result.contact_rotor() * np.exp(-1j * psi * result.time) - rotor)
    late = result.time > 3.0 / growth
    measured = np.polyfit(result.time[late], np.log(left[late]), 1)[0]
    met("V5", "unstable: |growth rate / eigenvalue - 1|", abs(measured / growth - 1.0), 2e-3)


# ---- V6


def test_v6_forward_rub_is_held_and_equals_the_quadratic():
    """|E| = |s + F_N/k_C + (1 + i mu) H F_N| from d = E - H F_C and F_C = (1 + i mu) F_N d/|d|; 200 turns from a start on it.

    Of the two motions at 40 Hz (2.86 and 60.9 N) the smaller is unstable."""
    tables = changed(WHIRLING, rotor={"eccentricity": 4e-4}, contact={"friction": 0.05})
    omega, mu, k_c = 2 * np.pi * 40.0, 0.05, 3.553e6
    h_r, h_s = (
        1 / (m * (w * w - omega**2 + 2j * z * w * omega)) for m, w, z in ((1.0, 60 * np.pi, 0.02), (0.25, 300 * np.pi, 0.1))
    )
    response = h_r * 4e-4 * omega**2

    def defect(force):
        return abs(GAP + force / k_c + (1 + 1j * mu) * (h_r + h_s) * force) - abs(response)

    force = float(mp.findroot(defect, (10.0, 2e3), solver="anderson", tol=1e-13))
    distance = GAP + force / k_c
    d = response / (1 + (1 + 1j * mu) * (h_r + h_s) * force / distance)
    contact = (1 + 1j * mu) * force * d / distance
    rotor, stator = response - h_r * contact, h_s * contact
    closed = forward_rub(assemble(rsc.Scene.from_dict(tables)), omega)
    assert min(abs(rub.normal_force / force - 1.0) for rub in closed) < 1e-9
    start = {"rotor": pair(rotor), "rotor_velocity": pair(1j * omega * rotor), "stator": pair(stator),
             "stator_velocity": pair(1j * omega * stator), "allow_penetration": True}  # fmt: skip
    tables = changed(tables, start=start, drive={"speed": 40.0, "duration": 5.0})
    for rtol in (1e-5, 1e-8):
        result = run(tables, rtol)
        lines = result.contact_rotor() * np.exp(-1j * omega * result.time)
        met("V6", f"rtol {rtol:.0e}: amplitude and phase error / (rtol gap)", np.abs(lines - rotor).max() / GAP / rtol, 20.0)
        assert result.normal_force == pytest.approx(force, rel=1e3 * rtol)


# ---- V7


@pytest.mark.parametrize("name", ["whirl, unbalance, run-up", "bouncing", "Coulomb friction that reverses", "gyroscopic disk"])
def test_v7_energy_ledger_closes_at_every_tolerance(name):
    for rtol in 10.0 ** -np.arange(3.0, 12.0, 2.0):
        result = run(SCENES[name], rtol)
        ledger = result.ledger
        assert ledger.turnover > 1e-3
        # as in V10 an impact may cost three rtol of the energy; in a few impacts nothing else happens
        limit = max(20.0, 3.0 * result.contact_onsets)
        met("V7", f"{name}: largest residual / (rtol turnover)", abs(ledger.residual) / ledger.turnover / rtol, limit)


# ---- V10


def test_v10_reversal_over_a_hundred_impacts():
    """Undamped, mu = 0: the motion run backward is the motion with the velocities reversed (a scene has no negative time). In a
    rigid round wall angular momentum keeps it regular. The final velocity is free flight from the last two samples.

    An impact leaves an error of the speed of about rtol, of one sign for all, and every later gap travelled adds it to the place:
    the error allowed is 1.5 rtol per impact and gap travelled. The first goal, 50 rtol, would need an error per impact of
    rtol/500."""
    omega = 2 * np.pi * 30.0
    tables = changed(
        SCENES["rigid wall"],
        rotor={"eccentricity": 0.0, "damping_ratio": 0.0},
        contact={"friction": 0.0, "damping_ratio": None, "damping": 0.0},
    )
    r_0, v_0 = 0.6e-3 + 0.2e-3j, 0.3 + 0.2j
    duration, rate = 0.75, 2048.0
    for rtol in (1e-7, 1e-10):
        there = _bounce(tables, r_0, v_0, duration, rtol, rate)
        assert there.contact_onsets >= 100 and not there.normal_force[-3:].any()
        r_1, h = there.rotor[-1, 0], 1.0 / rate
        v_1 = (r_1 * np.cos(omega * h) - there.rotor[-2, 0]) * omega / np.sin(omega * h)
        back = _bounce(tables, r_1, -v_1, duration, rtol, rate)
        assert back.contact_onsets == there.contact_onsets
        error = np.abs(back.rotor[::-1, 0] - there.rotor[:, 0]).max()
        travelled = np.abs(np.diff(there.rotor[:, 0])).sum() / GAP
        limit = 1.5 * there.contact_onsets * travelled
        met("V10", f"rtol {rtol:.0e}: way back after {there.contact_onsets} impacts, / (rtol gap)", error / GAP / rtol, limit)
    energy = abs(v_1) ** 2 + omega**2 * abs(r_1) ** 2
    # three rtol an impact: what a contact does to the speed is judged against rtol gap omega, as every error of a speed
    drift = energy / (abs(v_0) ** 2 + omega**2 * abs(r_0) ** 2) - 1.0
    met("V10", "energy drift / rtol", abs(drift) / rtol, 3.0 * there.contact_onsets)


def _bounce(tables, r, v, duration, rtol, rate):
    start = {"rotor": pair(r), "rotor_velocity": pair(v), "allow_penetration": True}
    return run(changed(tables, start=start, drive={"speed": 0.0, "duration": duration}), rtol, rate)


# ---- V13


def hard_wall(stiffness, ratio, duration, frequency=30.0, rtol=1e-11):
    """One mass on a spring between rigid walls, thrown along y; ratio of the contact damper to critical."""
    damping = 2.0 * ratio * np.sqrt(stiffness)
    tables = {
        "rotor": {"model": "laval", "mass": 1.0, "frequency": frequency},
        "stator": {"model": "rigid"},
        "contact": {"gap": GAP, "friction": 0.0, "stiffness": stiffness, "damping": damping},
        "drive": {"speed": 0.0, "duration": duration},
        "start": {"rotor_velocity": [[0.5, 0.0]]},
    }
    return run(tables, rtol, 8192.0)


def billiard(times, restitution):
    """Exact impact law between walls at +-gap, oscillator in between, from the middle with 0.5 m/s."""
    omega = 2 * np.pi * 30.0
    rows, t_0, x_0, v_0 = [], 0.0, 0.0, 0.5
    for _ in itertools.count():
        amplitude, phase = np.hypot(x_0, v_0 / omega), np.arctan2(x_0, v_0 / omega)
        side = np.sign(v_0)
        # x = amplitude sin(omega t + phase) meets side * gap while moving towards it
        goal = np.arcsin(np.clip(GAP / amplitude, -1.0, 1.0))
        hit = t_0 + (((goal - phase) if side > 0 else (goal - phase + np.pi)) % (2 * np.pi)) / omega
        inside = times[(times >= t_0) & (times < hit)]
        rows.append(amplitude * np.sin(omega * (inside - t_0) + phase))
        if hit > times[-1]:
            return np.concatenate(rows)
        speed = amplitude * omega * np.cos(omega * (hit - t_0) + phase)
        t_0, x_0, v_0 = hit, side * GAP, -restitution * speed


def test_v13_stiff_contact_tends_to_the_impact_law():
    """Elastic: the time spent in contact, pi/omega_C an impact, is all the difference: order k_C^(-1/2)."""
    stiffness, errors = np.array([1e8, 1e9, 1e10, 1e11, 1e12]), []
    for k_c in stiffness:
        result = hard_wall(k_c, 0.0, 0.0078125 * 2)
        errors.append(np.abs(result.rotor[:-1, 0].real - billiard(result.time, 1.0)[: len(result.time) - 1]).max() / GAP)
    met("V13", "|order in k_C of the approach to the impact law + 1/2|", abs(slope(stiffness, errors) + 0.5), 0.02)
    delay = np.pi / np.sqrt(1e12) * 0.5 / GAP  # in gaps, an impact; there are four
    met("V13", "distance from the impact law at 1e12 N/m / (4 contact times x speed)", errors[-1] / (4.0 * delay), 1.01)


@pytest.mark.parametrize("ratio", [0.05, 0.3, 0.7])
def test_v13_restitution_of_the_one_sided_damper(ratio):
    """Pressing is a quarter of an undamped swing; separating ends where k p + b p' = 0, that is p'' = 0. So the restitution is
    exp(-D acos(D)/sqrt(1 - D^2)).

    The place is good to rtol gaps, so the speed out of a contact of frequency omega_C to rtol gap omega_C, a share 2e-8 here."""
    expected = np.exp(-ratio * np.arccos(ratio) / np.sqrt(1.0 - ratio**2))
    result = hard_wall(1e12, ratio, 0.00390625, frequency=0.01)  # practically a free mass: speeds are differences
    assert result.contact_onsets == result.contact_releases == 1
    y = result.rotor[:, 0].real
    restitution = (y[-2] - y[-1]) / (y[1] - y[0])
    met("V13", f"damper ratio {ratio}: |restitution / closed form - 1|", abs(restitution / expected - 1.0), 4e-8)


def test_v13_small_friction_tends_to_none():
    """mu -> 0: what friction adds is proportional to mu."""
    plain = run(changed(SCENES["rigid wall"], contact={"friction": 0.0}, drive={"duration": 0.1}), 1e-12)
    sizes, friction = [], np.array([1e-4, 1e-5, 1e-6, 1e-7])
    for mu in friction:
        result = run(changed(SCENES["rigid wall"], contact={"friction": float(mu)}, drive={"duration": 0.1}), 1e-12)
        sizes.append(np.abs(result.rotor - plain.rotor).max())
    met("V13", "|order in mu of what friction adds - 1|", abs(slope(friction, sizes) - 1.0), 0.02)
