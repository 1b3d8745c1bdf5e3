"""Whirls at several contacts on supports whose directions differ: their mirror lines, and what is claimed of them."""

import numpy as np
import pytest
import scipy.optimize

import rsc
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.several.predict import predict_several
from rsc.study.prediction.predictions import predictions
from rsc.study.report.check import report
from rsc.system.assemble import assemble
from two_seals import pump


def on_supports(share, **values):
    """The pump with two seals, a share of 1e6 N/m (and of 100 N s/m) stiffer one way than the other, at one mass turned."""
    k, c = 1e6 * share, 100.0 * share
    scene = pump(**values)
    content = scene.to_dict()
    content["rotor"]["supports"] = [[0, [k, 0.3 * k, 0.3 * k, -k], [c, 0.0, 0.0, -c]], [2, [k, 0.0, 0.0, -k]]]
    content["rotor"]["allow_negative_damping"] = True
    return rsc.Scene.from_dict(content)


def pairs(shape):
    return [[float(z.real), float(z.imag)] for z in shape]


@pytest.mark.parametrize(("share", "close"), [(1e-3, 1e-5), (0.1, 0.02)])
def test_at_one_contact_the_mirror_line_is_that_of_a_single_contact(share, close):
    """That of a single contact is exact in what joins the lines, this one of first order: alike to the share."""
    system, compared = assemble(on_supports(share)), 0
    for name in ("seal", "bush"):
        own = {round(whirl.frequency, 4): whirl.mirror for whirl in predict_system(system.at_contact(name), 50.0)}
        for whirl in predict_several(system, 50.0):
            if whirl.pressed == (name,):
                known = own[round(whirl.frequency, 4)]
                assert whirl.mirror.share == pytest.approx(known.share, rel=close)
                assert whirl.mirror.third_amplitude == pytest.approx(known.third_amplitude, rel=close)
                assert whirl.mirror.envelope == pytest.approx(known.envelope, rel=close * known.share)
                compared += 1
    assert compared >= 3


def test_the_lines_of_a_whirl_at_both_seals_are_those_of_a_run():
    scene = on_supports(0.1)
    (whirl,) = (whirl for whirl in rsc.predict(scene, 50.0) if whirl.stable and whirl.frequency < 0.0)
    content, turning = scene.to_dict(), 2j * np.pi * whirl.frequency
    content["rotor"]["eccentricity"] = [0.0, 0.0, 0.0]
    content["start"] = {"allow_penetration": True}
    for name in ("rotor", "stator"):
        shape = getattr(whirl, f"{name}_shape")
        content["start"] |= {name: pairs(shape), f"{name}_velocity": pairs(turning * shape)}
    content |= {"solver": {"rtol": 1e-9}, "output": {"rate": 8000.0}, "drive": {"speed": 50.0, "duration": 2.0}}
    result = rsc.simulate(rsc.Scene.from_dict(content))
    hardest = max(scene.contacts, key=lambda contact: whirl.contacts[contact.name].normal_force).rotor_coordinate
    z, t = result.rotor[-8000:, hardest], result.time[-8000:]

    def lines(frequency):
        waves = np.exp(2j * np.pi * np.outer(t - t[0], frequency * np.array([1, -1, 3])))
        sizes, _, _, _ = np.linalg.lstsq(waves, z, rcond=None)
        return np.abs(sizes), np.abs(z - waves @ sizes).sum()

    ends = whirl.frequency - 0.1, whirl.frequency + 0.1
    best = scipy.optimize.minimize_scalar(lambda f: lines(f)[1], bounds=ends, method="bounded", options={"xatol": 1e-6})
    own, mirror, third = lines(best.x)[0]
    assert best.x == pytest.approx(whirl.frequency, abs=0.1)  # of second order in the share of the mirror line
    assert mirror / own == pytest.approx(whirl.mirror.amplitude / whirl.rotor_amplitude, rel=0.03)
    assert third == pytest.approx(whirl.mirror.third_amplitude, rel=0.05)


def test_a_whirl_that_is_no_circle_is_not_claimed_and_a_remark_tells_it():
    for share, circle in ((0.1, True), (0.6, False)):
        told = predictions(on_supports(share), [50.0])[0]
        (whirl,) = (whirl for whirl in told.whirls if whirl.growth_rate < 0.0 and len(whirl.pressed) == 2)
        assert whirl.stable == circle == ("nearly_circular" not in whirl.violated) == (whirl.mirror.share <= 0.1)
        (remark,) = (text for text in told.remarks if f"{whirl.frequency:.4f} Hz" in text)
        assert "elliptical, counter-rotating component" in remark and ("not assessed" in remark) != circle


def test_a_run_on_unequal_supports_is_checked():
    told = report(rsc.simulate(on_supports(0.1, **{"drive.duration": 1.0})), lists=False)
    assert told.branches and all(whirl.mirror is not None for branch in told.branches for whirl in branch.whirls)
    assert any("elliptical" in text for text in told.remarks)
