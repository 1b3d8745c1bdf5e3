"""A motion filtered at one frequency, of signals whose ellipse is known."""

import numpy as np
import pytest

from rsc.measure.features import ellipse

RATE, COUNT = 1000.0, 2000  # Hz, samples: a window of 2 s
TIME = np.arange(COUNT) / RATE


def test_an_ellipse_is_found_beside_other_lines():
    forward, backward = 2e-3 * np.exp(0.7j), 0.5e-3 * np.exp(-1.1j)
    phi = 2.0 * np.pi * 31.0 * TIME
    others = 1e-3 * np.exp(-2j * np.pi * 17.0 * TIME) + 4e-4 * np.exp(2j * np.pi * 62.0 * TIME)
    found = ellipse(forward * np.exp(1j * phi) + backward * np.exp(-1j * phi) + others, 31.0 * TIME)
    assert found == pytest.approx((forward, backward), abs=1e-15)  # whole turns of every line: Hann leaks nothing


@pytest.mark.parametrize(("forward", "backward"), [(1.0, 0.0), (0.0, 1.0j), (0.5, 0.5)])
def test_circles_of_both_senses_and_a_line_are_special_ellipses(forward, backward):
    phi = 2.0 * np.pi * 30.3 * TIME
    found = ellipse(forward * np.exp(1j * phi) + backward * np.exp(-1j * phi), 30.3 * TIME)
    assert found == pytest.approx((forward, backward), abs=1e-5)  # 30.3 * 2 turns are not whole: the other side leaks a little


def test_the_frequency_may_change_within_the_window():
    turned = 20.0 * TIME + 4.0 * TIME**2  # 20 to 36 Hz
    motion = 1e-3 * np.exp(2j * np.pi * turned) + 3e-4j * np.exp(-2j * np.pi * turned)
    assert ellipse(motion, turned) == pytest.approx((1e-3, 3e-4j), abs=3e-7)
    assert abs(ellipse(motion, 28.0 * TIME)[0]) < 0.5e-3
