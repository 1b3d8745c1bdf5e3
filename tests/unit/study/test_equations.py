"""`rsc.equations` against the slow twin, differences, a law of conservation and the kernel; `rsc.benchmark` with good and bad
entrants."""

import ctypes

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import naive
import rsc
from rsc.study.equations.reference import dop853, reference
from rsc.system.assemble import assemble
from scenes import DRIVEN, LAVAL, PUSHED, SCENES, changed

PLAIN = {name: tables for name, tables in SCENES.items() if "torque" not in tables["drive"]}
SHORT = {"drive": {"duration": 0.03}}


def scene_of(tables):
    return rsc.Scene.from_dict(tables)


def states_near(equations, count=6):
    """States about the start, in contact and out of it."""
    dice = np.random.default_rng(3)
    for size in np.linspace(0.1, 2.5, count):
        yield size * equations.start + 0.3 * size * equations.scale * dice.normal(size=equations.start.size)


def as_complex(y):
    """The twin's state of one of `Equations`."""
    (y_x, z_x), (y_v, z_v) = (part.reshape(2, -1) for part in np.split(y, 2))
    return np.concatenate([y_x + 1j * z_x, y_v + 1j * z_v])


@pytest.mark.parametrize("name", PLAIN)
def test_the_right_hand_side_is_that_of_the_twin(name):
    scene = scene_of(PLAIN[name])
    equations, system = rsc.equations(scene), assemble(scene)
    gap = max(contact.gap for contact in system.contacts)
    if len(system.contacts) > 1:
        pytest.skip("the twin knows one contact")
    twin, touched = naive.rhs(system), 0
    for i, y in enumerate(states_near(equations)):
        t = 0.07 * i * equations.duration
        y = y + (np.repeat([2.0 * i * gap, 0.0], [1, len(y) - 1]) if not touched else 0.0)
        ours, theirs = as_complex(equations.rhs(t, y)), twin(t, as_complex(y))
        touched += int(equations.states(t, y)[0, 0] > 0)
        assert np.abs(ours - theirs).max() < 1e-11 * np.abs(theirs).max()
    assert touched


@pytest.mark.parametrize("tables", [SCENES["Coulomb friction that reverses"], SCENES["gyroscopic disk"], PUSHED])
def test_the_jacobian_is_the_derivative(tables):
    equations, t = rsc.equations(scene_of(tables)), 0.01
    for y in states_near(equations):
        states, h = equations.states(t, y), 1e-6 * equations.scale
        sides = [[equations.rhs(t, y + sign * h * unit, states) for sign in (1, -1)] for unit in np.eye(len(y))]
        slopes = np.array([(one - other) / (2.0 * step) for (one, other), step in zip(sides, h, strict=True)]).T
        assert np.abs(equations.jacobian(t, y) - slopes).max() < 1e-6 * np.abs(slopes).max()


def test_the_compiled_one_is_the_same_and_has_an_address():
    equations = rsc.equations(scene_of(SCENES["Coulomb friction that reverses"]))
    y, out = 1.4 * equations.start, np.zeros(len(equations.start))
    expected = equations.rhs(0.01, y)
    assert np.allclose(equations.compiled(0.01, y), expected, rtol=1e-13, atol=0.0)
    call = ctypes.CFUNCTYPE(None, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p)(equations.callback.address)
    call(0.01, y.ctypes.data, out.ctypes.data)
    assert np.allclose(out, expected, rtol=1e-13, atol=0.0)


def test_energy_is_kept_without_damping_friction_and_unbalance():
    still = {"damping_ratio": 0.0, "eccentricity": 0.0}
    contact = {"damping_ratio": 0.0, "friction": 0.0}
    scene = scene_of(changed(SCENES["bouncing"], rotor=still, stator={"damping_ratio": 0.0}, contact=contact, **SHORT))
    equations, times = rsc.equations(scene), np.linspace(0.0, 0.03, 61)
    rows = dop853(equations, times, 1e-11)
    energies = np.array([equations.energy(t, y) for t, y in zip(times, rows, strict=True)])
    pressed = [equations.states(t, y)[0, 0] > 0 for t, y in zip(times, rows, strict=True)]
    assert any(pressed) and not all(pressed) and np.ptp(energies) < 1e-9 * energies[0]


@pytest.mark.parametrize("name", ["whirl, unbalance, run-up", "bouncing", "Coulomb friction that reverses"])
def test_dop853_with_events_agrees_with_the_kernel(name):
    scene = scene_of(changed(SCENES[name], solver={"rtol": 1e-11}, **SHORT))
    run, equations = rsc.simulate(scene), rsc.equations(scene)
    exact, own = reference(equations, run.time)
    assert np.abs(np.hstack([run.rotor, run.stator]) - exact).max() < 1e-8 * scene.contact.gap
    assert own < 1e-8 and run.summary.switches > 0


def test_states_end_where_their_switches_are_zero():
    equations = rsc.equations(scene_of(changed(SCENES["bouncing"], **SHORT)))
    t, y, states, seen = 0.0, equations.start, equations.states(0.0, equations.start), set()
    for _ in range(12):
        switches = equations.switches(states)
        how = {"events": switches, "args": (states,), "rtol": 1e-9, "atol": 1e-9 * equations.scale}
        found = solve_ivp(equations.rhs, (t, 0.03), y, "DOP853", **how)
        inside = [equations.states(each, row)[0, 0] for each, row in zip(found.t[1:-1], found.y.T[1:-1], strict=True)]
        assert set(inside) <= {states[0, 0]}
        if found.status == 0:
            break
        t, y = found.t[-1], found.y[:, -1]
        states = next(s.after(t, y) for s, hits in zip(switches, found.t_events, strict=True) if len(hits))
        seen.add(int(states[0, 0]))
    assert {0, 1, 2} <= seen


def test_a_run_leaves_the_place_where_a_switch_is_exactly_zero():
    """There one state ended and the next begins; an event found again at its own start would hold a run for ever."""
    equations = rsc.equations(scene_of(LAVAL))
    y = np.zeros_like(equations.start)
    y[0] = 1.1 * equations.constants.gap[0]  # pressed into the stator and at rest, from where it opens: delta' is zero
    opening = np.array([[2, 0]])
    how = {"events": equations.switches(opening), "args": (opening,), "first_step": 1e-3, "rtol": 1.0, "atol": equations.scale}
    run = solve_ivp(equations.rhs, (0.0, 0.01), y, "DOP853", **how)  # its first step holds the way out and in again
    assert run.t[-1] > 1e-4


def test_the_layout_has_names_and_units():
    equations = rsc.equations(scene_of(LAVAL))
    assert [entry.name for entry in equations.layout[:4]] == ["rotor 0 y", "stator 0 y", "rotor 0 z", "stator 0 z"]
    assert {entry.unit for entry in equations.layout} == {"m", "m/s"} and len(equations.layout) == len(equations.start) == 8
    assert equations.displacements(equations.start)[0] == 2.55e-3 and "8 state variables" in repr(equations)


def test_what_the_equations_leave_out_is_refused():
    with pytest.raises(rsc.SolverError, match="does not have a drive with a torque"):
        rsc.equations(scene_of(DRIVEN))


def test_a_benchmark_has_all_three_and_keeps_what_failed():
    scene = scene_of(changed(LAVAL, drive={"speed": 50.0, "duration": 0.01}))

    def exact(equations, times, rtol):
        return dop853(equations, times, rtol)

    def bad(equations, times, setting):
        if setting == 1:
            raise ZeroDivisionError("mine")
        return np.full((len(times), len(equations.start) + (setting == 2)), np.nan)

    made = rsc.benchmark(scene, exact, [1e-5, 1e-8])
    made = rsc.benchmark(scene, bad, [1, 2, 3], "mine", beside=made)
    errors = {(p.method, p.setting): p.error for p in made.points}
    assert made.reference_error < 1e-9 and errors["exact", 1e-8] < 1e-6 < 1e-2
    assert min(error for (method, _), error in errors.items() if method == "rsc taylor8") < 1e-8
    told = [p.cause for p in made.points if p.method == "mine"]
    assert told[0] == "ZeroDivisionError: mine" and "shape" in told[1] and "not finite" in told[2]
    at = made.seconds_at(1e-6)
    assert set(at) == {"exact", "rsc rk45", "rsc taylor8", "mine"} and at["rsc rk45"] > 0.0 and np.isnan(at["mine"])
    assert made.plot() is not None and len(made.table().rows) == len(made.points) and repr(made).count("\n") < 5
    with pytest.raises(rsc.SolverError, match="same scene"):
        rsc.benchmark(scene_of(LAVAL), exact, [1e-3], beside=made)
    with pytest.raises(rsc.SolverError, match="at least one"):
        rsc.benchmark(scene, exact, [])
