"""The growing mode of a whirl, the bounds of the one-sided damper, and where an unstable whirl leads."""

import numpy as np
import pytest

import rsc
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.small_motions import damper_limits, departure, small_motion
from rsc.analysis.paper.stability import state_matrices, whirl_growth
from systems import TWO_PI, changed, reference, reference_scene


def nearest(system, frequency, speed):
    return min(predict_system(system, speed), key=lambda w: abs(w.frequency - frequency))


def arguments(whirl):
    return TWO_PI * whirl.frequency, whirl.normal_force, TWO_PI * whirl.speed


@pytest.mark.parametrize(
    ("name", "frequency", "speed"),
    [("gyroscopic_transition", -33.7, 70.0), ("mdof_2x2", -9.47, 10.0), ("laval", -60.66, 50.0)],
)
def test_mode_is_that_of_the_growth_rate_and_takes_its_part(name, frequency, speed):
    system = reference(name)
    Psi, F_N, Omega = arguments(nearest(system, frequency, speed))
    mode = small_motion(system, Psi, F_N, Omega)
    growth = whirl_growth(system, Psi, F_N, Omega)
    assert mode.eigenvalue.real == pytest.approx(growth.rate, rel=1e-6)
    assert abs(mode.eigenvalue.imag) == pytest.approx(growth.frequency, rel=1e-6, abs=1e-9)
    # the motion of the lines fulfils the small-motion equations, and its own part is its factor
    c = 0.3 - 0.2j if mode.eigenvalue.imag else 0.3
    rates = np.array([mode.eigenvalue, np.conj(mode.eigenvalue)])
    factors = np.array([c, np.conj(c)]) if mode.eigenvalue.imag else np.array([c, 0.0])
    x, x_dot, x_ddot = (((factors * rates**k) @ mode.lines) for k in range(3))
    matrix = state_matrices(system, np.array([Psi]), np.array([F_N]), Omega, 0.5 * system.law.damping)[0]
    state = np.concatenate([x.real, x.imag, x_dot.real, x_dot.imag])
    wanted = np.concatenate([x_dot.real, x_dot.imag, x_ddot.real, x_ddot.imag])
    assert matrix @ state == pytest.approx(wanted, rel=1e-6, abs=1e-8 * np.abs(wanted).max())
    assert mode.part_of(x, x_dot) == pytest.approx(c, rel=1e-6)


def test_damper_limits_disagree_only_where_the_damper_decides():
    # over the friction the laval whirl loses stability at 0.2076 for b_C / 2
    seen = set()
    for friction in (0.19, 0.2076, 0.23):
        system = changed(reference("laval"), friction=friction)
        limits = damper_limits(system, *arguments(nearest(system, -61.0, 50.0)))
        for growth, share in ((limits.off, 0.0), (limits.mean, 0.5), (limits.on, 1.0)):
            own = whirl_growth(system, *arguments(nearest(system, -61.0, 50.0)), share * system.law.damping)
            assert growth.rate == own.rate
        assert limits.off.rate > limits.mean.rate > limits.on.rate
        assert limits.signs_agree == (limits.off.rate * limits.on.rate > 0.0)
        seen.add((limits.signs_agree, limits.on.rate > 0.0))
    assert seen == {(True, False), (False, False), (True, True)}


@pytest.mark.parametrize(
    ("name", "frequency", "speed"),
    # the last one's nearest neighbour is -33.7, its partner -49.8 Hz
    [("mdof_2x2", -9.47, 10.0), ("mdof_2x2", -26.53, 10.0), ("gyroscopic_transition", -40.06, 70.0)],
)
def test_a_creeping_whirl_leaves_for_its_partner_or_loses_contact(name, frequency, speed):
    scene = reference_scene(name)
    scene = scene.with_values({"rotor.eccentricity": [0.0, 0.0] if name == "mdof_2x2" else 0.0})
    system = reference(name)
    whirl = nearest(system, frequency, speed)
    left = departure(system, whirl, predict_system(system, speed))
    assert left.kind == "creeping" and left.loses_contact
    mode = small_motion(system, *arguments(whirl))
    pressing = np.sign((mode.lines[0] @ np.concatenate([system.rotor.contact, -system.stator.contact])).real)
    ends = []
    for sign in (pressing, -pressing):
        scale = sign * 1e-3 * whirl.rotor_amplitude / abs(mode.lines[0][0])
        x = np.concatenate([whirl.rotor_shape, whirl.stator_shape]) + scale * mode.lines[0]
        x_dot = scale * mode.eigenvalue.real * mode.lines[0] + 1j * TWO_PI * whirl.frequency * x
        pairs = [[[float(z.real), float(z.imag)] for z in part] for y in (x, x_dot) for part in np.split(y, [system.n_rotor])]
        keys = ("rotor", "stator", "rotor_velocity", "stator_velocity")
        start = {**dict(zip(keys, pairs, strict=True)), "allow_penetration": True}
        content = {**scene.to_dict(), "start": start, "drive": {"speed": speed, "duration": 10.0}}
        result = rsc.simulate(rsc.Scene.from_dict(content))
        tail = result.contact_rotor()[-4000:]
        turned = np.angle(np.vdot(tail[:-1], tail[1:])) * scene.output.rate / TWO_PI
        ends.append(turned if result.normal_force[-4000:].any() else np.nan)
    assert ends[0] == pytest.approx(left.towards, abs=0.02)
    assert np.isnan(ends[1])


def test_an_oscillatory_whirl_leaves_for_the_whirl_next_to_its_line():
    system = reference("gyroscopic_transition")
    whirls = predict_system(system, 70.0)
    left = departure(system, nearest(system, -33.7, 70.0), whirls)
    assert left.kind == "oscillatory" and left.towards == pytest.approx(-49.76, abs=0.01)
    assert left.line == pytest.approx(-49.84, abs=0.01)
    assert departure(system, nearest(system, -49.76, 70.0), whirls).kind == "none"
