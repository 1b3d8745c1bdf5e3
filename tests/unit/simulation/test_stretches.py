"""Facts of the stretches of a run, against the samples of a very fine output and against what no output may change."""

import numpy as np
import pytest

import rsc
from rsc.measure.stretches import COLUMNS, EXTENTS
from rsc.study.run.simulate import simulate
from scenes import LAVAL, SCENES, changed

FINE = 200_000.0  # samples a second


def fine(scene, **tables):
    return rsc.Scene.from_dict(changed(scene, output={"rate": FINE}, **tables))


def turned(d):
    """Turns of a path about the origin."""
    return float(np.angle(d[1:] * d[:-1].conj()).sum()) / (2.0 * np.pi)


@pytest.mark.parametrize("method", ["rk45", "taylor8"])
@pytest.mark.parametrize("name", SCENES)
def test_facts_are_those_of_the_samples(name, method):
    scene = fine(SCENES[name], solver={"method": method, "rtol": 1e-7})
    result = rsc.simulate(scene)
    whole, stretches = result.stretches().whole(), result.stretches()
    rotor, stator, force = result.contact_rotor(), result.contact_stator(), result.normal_force
    phase = 2.0 * np.pi * np.concatenate([[0.0], np.cumsum(0.5 * (result.speed[1:] + result.speed[:-1]) / FINE)])
    ring = scene.contact.ring_eccentricity
    ring = ring if isinstance(ring, complex) else complex(ring)
    d = rotor - stator + ring * np.exp(1j * phase)
    pressed = abs(d) > scene.contact.gap  # the clipped state, without a force, is contact as well
    assert whole.turns == pytest.approx(turned(d), abs=1e-3)
    both = pressed[1:] & pressed[:-1]
    angles = np.angle(d[1:] * d[:-1].conj())
    assert whole.pressed_turns == pytest.approx((angles * both).sum() / (2.0 * np.pi), rel=5e-3, abs=5e-3)
    assert whole.rotor_max == pytest.approx(abs(rotor).max(), rel=2e-3)
    extents = rotor.real.min(), rotor.real.max(), rotor.imag.min(), rotor.imag.max()
    assert [getattr(whole, name) for name in EXTENTS] == pytest.approx(extents, rel=2e-3, abs=2e-3 * scene.contact.gap)
    assert whole.peak_to_peak == pytest.approx(max(np.ptp(rotor.real), np.ptp(rotor.imag)), rel=2e-3)
    for size, time in ((abs(rotor), whole.rotor_max_at), (abs(d), whole.deflection_max_at), (force, whole.force_max_at)):
        near = size[max(round(time * FINE) - 2, 0) : round(time * FINE) + 3]  # two samples may be as large but for rounding
        assert near.max() == pytest.approx(size.max(), rel=1e-2)
    # the smallest is that of the ends of steps alone: between the least and the largest sample of its stretch
    parts = np.split(abs(rotor), np.searchsorted(np.arange(len(rotor)) / FINE, stretches.end[:-1]))
    least, largest = np.array([(part.min(), part.max()) for part in parts]).T
    assert (0.99 * least <= stretches.rotor_min).all() and (stretches.rotor_min <= 1.01 * largest).all()
    assert whole.stator_max == pytest.approx(abs(stator).max(), rel=5e-2, abs=1e-12)  # at the ends of steps alone
    assert whole.deflection_max == pytest.approx(abs(d).max(), rel=2e-3)
    assert whole.force_max == pytest.approx(force.max(), rel=1e-2, abs=1e-9)
    assert whole.contact_time == pytest.approx(result.summary.contact_time, rel=1e-9, abs=1e-12)
    assert whole.contact_time == pytest.approx(pressed.mean() * whole.duration, rel=5e-3, abs=1e-4)
    assert whole.normal_impulse == pytest.approx(force.mean() * whole.duration, rel=1e-2, abs=1e-6)
    assert whole.friction_impulse == pytest.approx(result.friction_force.mean() * whole.duration, rel=2e-2, abs=1e-4)
    arc = (d * pressed).mean() * whole.duration
    assert complex(whole.arc_y, whole.arc_z) == pytest.approx(arc, rel=2e-2, abs=2e-3 * scene.contact.gap * whole.duration)
    power = result.friction_force * np.pi * result.speed * (scene.contact.diameter or 0.0)
    assert whole.drive_work == pytest.approx(power.mean() * whole.duration, rel=2e-2, abs=1e-4)
    assert whole.friction_work == pytest.approx(result.ledger.friction_in, rel=1e-12, abs=1e-15)
    assert whole.onsets == result.contact_onsets
    assert stretches.end[-1] == scene.drive.duration and (np.diff(stretches.end) > 0.0).all()
    if scene.contact.diameter is not None:
        slip = result.tangential_velocity + np.pi * result.speed * scene.contact.diameter
        creeping = pressed & (abs(slip) < scene.contact.slip_velocity)
        assert whole.rolling_time == pytest.approx(creeping.mean() * whole.duration, rel=2e-2, abs=1e-3)


@pytest.mark.parametrize("name", ["bouncing", "eccentric ring", "chains"])
def test_no_rate_of_output_changes_a_fact(name):
    slow, fast = (rsc.simulate(rsc.Scene.from_dict(changed(SCENES[name], output={"rate": rate}))) for rate in (500.0, 20_000.0))
    assert slow.stretches().rows.tobytes() == fast.stretches().rows.tobytes()


def test_a_peak_between_two_steps_is_found():
    """A rotor on a straight line, in steps of up to a quarter of its period."""
    amplitude = 0.7e-3
    start = {"rotor": [[0.0, 0.0]], "rotor_velocity": [[2.0 * np.pi * 30.0 * amplitude, 0.0]]}
    tables = {"rotor": {"eccentricity": 0.0, "damping_ratio": 0.0}, "drive": {"speed": 1.0, "duration": 0.3}, "start": start}
    scene = rsc.Scene.from_dict(changed(LAVAL, solver={"method": "taylor8", "rtol": 1e-4}, **tables))
    whole = rsc.simulate(scene).stretches().whole()
    assert whole.rotor_max == pytest.approx(amplitude, rel=2e-3) == whole.deflection_max
    assert whole.peak_to_peak == pytest.approx(2.0 * amplitude, rel=2e-3)
    assert whole.contact_time == 0.0


def test_the_largest_force_is_that_of_the_spring_at_its_deepest():
    """A head-on bounce on a rigid wall without losses: k p^2/2 = m v^2/2, in a few long steps."""
    speed, stiffness = 0.5, 1e7
    tables = {
        "rotor": {"eccentricity": 0.0, "damping_ratio": 0.0, "frequency": 0.5},
        "stator": {"model": "rigid"},
        "contact": {"stiffness": stiffness, "friction": 0.0, "damping": 0.0, "damping_ratio": None},
        "drive": {"speed": 1.0, "duration": 0.01},
        "start": {"rotor": [[0.0, 0.0]], "rotor_velocity": [[speed, 0.0]]},
    }
    for method in ("rk45", "taylor8"):
        solver = {"method": method, "rtol": 1e-3}
        whole = rsc.simulate(rsc.Scene.from_dict(changed(LAVAL, solver=solver, **tables))).stretches().whole()
        assert whole.force_max == pytest.approx(speed * np.sqrt(stiffness * 1.0), rel=2e-4)


def test_facts_survive_the_file_and_a_resumed_run(tmp_path, monkeypatch):
    """In memory, in a file, and continued from a checkpoint: the same numbers."""
    scene = rsc.Scene.from_dict(SCENES["bouncing"])
    rows = rsc.simulate(scene).stretches().rows
    assert rows.shape[1] == len(COLUMNS)
    simulate(scene, path=tmp_path / "whole.h5")
    assert rsc.load(tmp_path / "whole.h5").stretches().rows.tobytes() == rows.tobytes()
    monkeypatch.setattr("rsc.simulation.run.CHUNK_STEPS", 300)
    blocks = iter(range(10))

    def stop(*_):
        if next(blocks) > 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted(scene, tmp_path / "part.h5", stop)
    resumed = simulate(scene, path=tmp_path / "part.h5", resume=True)
    assert resumed.stretches().rows.tobytes() == rows.tobytes()


def interrupted(scene, path, stop):
    """A run to a file that a Ctrl-C ends after some chunks."""
    import rsc.study.run.simulate as module

    original = module._Pace.remark
    module._Pace.remark = lambda self: stop()
    try:
        simulate(scene, path=path)
    finally:
        module._Pace.remark = original


def test_a_damaged_row_of_facts_is_refused(tmp_path):
    import h5py

    path = tmp_path / "r.h5"
    simulate(rsc.Scene.from_dict(LAVAL), path=path)
    with h5py.File(path, "r+") as file:
        file["stretches/facts"][0, 3] *= 2.0
    with pytest.raises(rsc.DataError, match="the facts of a stretch are damaged"):
        rsc.load(path).stretches()
