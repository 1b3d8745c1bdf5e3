"""Steps that end on the switches of the contact: order, error against an exact solution, and no contact missed."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import brentq

import rsc
from rsc.kernel import model as kernel
from rsc.kernel.march import march
from rsc.scene.scene import Scene
from rsc.simulation.pack import pack
from rsc.simulation.run import new_work
from rsc.simulation.stretches import room_for
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from scenes import LAVAL, changed
from systems import reference_scene

# A rotor without unbalance and friction that bounces inside a rigid ring along one line: y'' + c y' + k y = -F(|y| - gap)
LINE = changed(
    rotor={"eccentricity": 0.0, "damping_ratio": 0.0},
    stator={"model": "rigid"},
    contact={"friction": 0.0, "damping_ratio": None, "damping": 60.0, "stiffness": 7e5},
    drive={"speed": 10.0, "duration": 0.025},
    start={"rotor": [[0.2e-3, 0.0]], "rotor_velocity": [[1.5, 0.0]]},
)
LINE["output"] = {"rate": 4000}


def prepared(scene_dict, rtol, method="rk45", **model):
    """(packed, work) of a scene with numbers of its Model replaced."""
    scene = Scene.from_dict({**scene_dict, "solver": {"rtol": rtol, "method": method}})
    system = assemble(scene)
    packed = pack(system, scene.solver, scene.output.rate)
    packed = dataclasses.replace(packed, model=packed.model._replace(**model))
    work = new_work(packed, initial_state(scene, system))
    work.count[kernel.STIFF] = 1  # as if found before: the kernel returns at the end only
    return packed, work, scene


def marched(packed, work, scene):
    """Complex displacements of the rotor's first coordinate on the output grid."""
    out = np.zeros((int(scene.drive.duration * scene.output.rate) + 8, work.x.size + 3))
    code, filled = march(packed.model, work, out, room_for(packed.model), packed.width, packed.method, 10**9)
    assert code == kernel.FINISHED
    return packed.physical(out[:filled, :-3])[0][:, 0]


class Exact:
    """The motion on the line, by the eigen-solution of each piece and the roots between the pieces to the last bits."""

    def __init__(self, scene_dict, packed, times):
        model = packed.model
        rotor = scene_dict["rotor"]
        self.omega2 = (2 * np.pi * rotor["frequency"]) ** 2
        contact = model.contacts[0]
        self.gap, surfaces = contact.gap, contact.surfaces
        self.k, self.b = surfaces.spring.k / rotor["mass"], surfaces.damping / rotor["mass"]
        self.switches = 0
        y, v = scene_dict["start"]["rotor"][0][0], scene_dict["start"]["rotor_velocity"][0][0]
        self.values = self.march(y, v, times)

    def piece(self, mode, y, v):
        """t -> (y, v) inside a mode that begins with y, v."""
        side = np.sign(y)
        stiffness = self.omega2 + (self.k if mode in ("closing", "opening") else 0.0)
        rest = side * self.k * self.gap / stiffness if mode in ("closing", "opening") else 0.0
        damping = self.b if mode == "opening" else 0.0
        root = -0.5 * damping + 1j * np.sqrt(stiffness - 0.25 * damping**2)
        # y - rest = Re(c e^{root t})
        c = (y - rest) - 1j * (v - root.real * (y - rest)) / root.imag

        def at(t):
            z = c * np.exp(root * t)
            return rest + z.real, (root * z).real

        return at

    def leave(self, mode, y, v):
        """Positive inside a mode, negative beyond its end."""
        side = np.sign(y)
        if mode == "open":
            return self.gap - abs(y)
        if mode == "closing":
            return side * v
        if mode == "opening":
            return self.k * (abs(y) - self.gap) + self.b * side * v
        return abs(y) - self.gap

    def march(self, y, v, times):
        following = {"open": "closing", "closing": "opening", "opening": "clipped", "clipped": "open"}
        t, mode, values = 0.0, "open", np.zeros_like(times)
        while t <= times[-1]:
            at = self.piece(mode, y, v)
            step, tau = 1e-6, 2e-6  # begin a little inside: the mode's own border is a root as well
            while self.leave(mode, *at(tau)) >= 0.0:
                tau += step
            tau = brentq(lambda s, m=mode, f=at: self.leave(m, *f(s)), tau - step, tau, xtol=1e-18, rtol=1e-15)
            inside = (times >= t) & (times < t + tau)
            values[inside] = at(times[inside] - t)[0]
            y, v = at(tau)
            t, mode = t + tau, following[mode]
            self.switches += t <= times[-1]
        return values


@pytest.fixture(scope="module")
def exact():
    packed, _, scene = prepared(LINE, 1e-6)
    times = np.arange(int(scene.drive.duration * scene.output.rate) + 1) / scene.output.rate
    solution = Exact(LINE, packed, times)
    assert solution.switches >= 16
    return solution


def error_in_gaps(exact, *arguments, **model):
    packed, work, scene = prepared(LINE, *arguments, **model)
    motion = marched(packed, work, scene)
    assert np.all(motion.imag == 0.0)
    # the exact switches, or at most one at the very end of the run more or less
    assert abs(int(work.count[kernel.SWITCHES]) - exact.switches) <= 1
    return abs(motion.real - exact.values).max() / packed.model.contacts[0].gap


# within 0.1; the series' error still shows its next term where rounding does not rule yet
ORDERS = [("rk45", 5.0, 8e-5), ("taylor8", 8.3, 5e-4)]


@pytest.mark.parametrize(("method", "order", "longest"), ORDERS)
def test_order_over_the_switches_with_fixed_steps(exact, method, order, longest):
    """The step is h_max wherever no switch cuts it, the tolerance never: dividing it by r divides the error by r^order."""
    steps = longest / 1.6 ** np.arange(4)
    errors = [error_in_gaps(exact, 1e-1, method, h_max=h, switch_tol=2.0**-44) for h in steps]
    assert errors[0] < 1e-5 and errors[-1] > 5e-13  # below it rounding rules
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize(("method", "largest"), [("rk45", 25.0), ("taylor8", 2.0)])
def test_error_is_proportional_to_the_tolerance_over_eight_decades(exact, method, largest):
    tolerances = 10.0 ** -np.arange(4.0, 12.1, 0.5)
    errors = np.array([error_in_gaps(exact, rtol, method) for rtol in tolerances])
    assert max(errors / tolerances) <= largest
    assert np.polyfit(np.log(tolerances), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.1)


def test_a_switch_costs_about_one_repeated_step():
    packed, work, scene = prepared({**LAVAL, "output": {"rate": 1000}}, 1e-8)
    marched(packed, work, scene)
    count = work.count
    repeated = count[kernel.RHS_CALLS] // 6 - count[kernel.STEPS] - count[kernel.REJECTED]
    assert count[kernel.SWITCHES] > 150
    assert repeated < 1.5 * count[kernel.SWITCHES]


CHAOS = changed(
    rotor={"eccentricity": 6e-4, "frequency": 30.0},
    stator={"model": "laval", "mass": 0.25, "frequency": 60.0, "damping_ratio": 0.1},
    contact={"friction": 0.05, "stiffness": 1.0659e7},
    drive={"speed": [30.0, 60.0], "duration": 2.0},
    start={"rest": True},
)
CHAOS["output"] = {"rate": 200_000}


LONG_STEPS = [("rk45", 1e-4), ("rk45", 1e-6), ("taylor8", 1e-4), ("taylor8", 1e-5)]


@pytest.mark.parametrize(("method", "rtol"), LONG_STEPS)
def test_no_contact_is_missed_inside_a_step(method, rtol):
    """A chaotic rub sampled 200,000 times a second from the interpolants: where the law says open, no sample penetrates."""
    packed, work, scene = prepared(CHAOS, rtol, method)
    out = np.zeros((int(scene.drive.duration * scene.output.rate) + 8, work.x.size + 3))
    code, filled = march(packed.model, work, out, room_for(packed.model), packed.width, packed.method, 10**9)
    assert code == kernel.FINISHED
    rotor, stator = packed.physical(out[:filled, :-3])
    penetration = abs(rotor[:, 0] - stator[:, 0]) - packed.model.contacts[0].gap
    force = out[:filled, -3]
    touches = np.flatnonzero((penetration[1:-1] > 0.0) & (penetration[:-2] <= 0.0))
    assert work.count[kernel.ONSETS] > 100
    # every stretch of samples beyond the gap belongs to an onset the kernel met, but for those that part by less than the
    # tolerance (the force is clipped at zero there, so that nothing of the motion depends on it)
    between = np.minimum.reduceat(penetration, np.append(0, touches))[:-1]
    assert (between < -rtol * packed.model.contacts[0].gap).sum() <= work.count[kernel.ONSETS]
    # and a sample beyond the gap that approaches is under force, but for what a switch met late may leave
    rising = np.diff(penetration, prepend=penetration[0]) > 0.0
    missed = (penetration > 10.0 * rtol * packed.model.contacts[0].gap) & rising & (force == 0.0)
    assert not missed.any()


def test_a_rate_that_dips_below_zero_inside_a_step_is_met():
    """Damper switches that a step which presses at both ends would pass over; the error is then twice what is allowed or more."""
    scene = reference_scene("laval").with_values({"drive.speed": [59.0, 60.0], "drive.duration": 0.5})
    exact, result = (rsc.simulate(scene.with_values({"solver.method": "taylor8", "solver.rtol": rtol})) for rtol in (1e-12, 1e-8))
    assert abs(result.rotor - exact.rotor).max() < 2e-8 * scene.contact.gap


def test_a_contact_is_met_though_the_step_ends_where_its_force_is_clipped():
    """A short contact inside an open step that ends still pressed, receding too fast for any force (found by bench/audit.py)."""
    changes = {
        "rotor": {"damping_ratio": 0.0287249, "eccentricity": 1.7324224e-3, "gravity": 6.659248},
        "stator": {"mass": 0.0550589, "frequency": 94.9186, "damping_ratio": 0.1},
        "contact": {"friction": 0.148980, "stiffness": 1841820.9, "damping_ratio": 0.199403},
        "drive": {"speed": 16.958154736886808, "duration": 0.2},
        "start": {"rotor": [[8.116577e-4, -2.261588e-4]], "rotor_velocity": [[4.1273389e-3, 8.64831216e-2]]},
    }
    dotted = {f"{table}.{key}": value for table, values in changes.items() for key, value in values.items()}
    scene = reference_scene("bouncing").with_values(dotted)
    exact, result = (
        rsc.simulate(scene.with_values({"solver.method": name, "solver.rtol": rtol}))
        for name, rtol in (("taylor8", 1e-11), ("rk45", 1e-8))
    )
    assert result.contact_onsets == exact.contact_onsets == 3
    assert result.summary.contact_time == pytest.approx(exact.summary.contact_time, rel=1e-3)


@pytest.mark.parametrize("rtol", [1e-5, 1e-6])
def test_a_slow_release_is_met(rtol):
    """A forward rub that ends at millimetres per minute, below the tolerated error of the velocities: no spring that pulls."""
    scene = changed(start={"rest": True}, contact={"friction": 0.05}, drive={"speed": [31.0, 29.0], "duration": 10.0})
    scene = Scene.from_dict({**scene, "output": {"rate": 400}})
    exact = rsc.simulate(scene.with_values({"solver.method": "taylor8", "solver.rtol": 1e-9}))
    result = rsc.simulate(scene.with_values({"solver.rtol": rtol}))
    assert result.contact_onsets == result.summary.contact_releases
    assert abs(result.rotor - exact.rotor).max() < 3e-3 * scene.contact.gap
