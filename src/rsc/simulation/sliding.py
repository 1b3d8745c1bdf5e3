"""Check of the one-sided friction law: its condition (12), forward sliding, monitored in the samples of a run."""

import math
from dataclasses import replace

import numpy as np


def signed(law, sense):
    """The law for the kernel: one-sided friction acts in the sense of rotation (`System.sense`), so mu < 0 if the rotor turns
    backward."""
    return law if law.diameter is not None else replace(law, friction=sense * law.friction)


def _chosen(values, mask):
    """The chosen values, without a copy if all are chosen."""
    return values if mask.all() else values[mask]


class SlidingWatch:
    """Monitors whether v_rel = Omega d_R/2 + v_t > 0 can hold in contact, for the one-sided law, which has no diameter d_R; for a
    rotor that turns backward (sense = -1) in the mirror image, where both terms change sign.

    state : (5,) smallest diameter in m for which every sample in contact with Omega > 0 slides forward; then, for the first
    sample
        in contact that slides forward with no diameter (Omega <= 0 and v_t <= 0), time in s (infinite: never), speed in Hz,
        normal force in N and tangential velocity v_t in m/s
    """

    def __init__(self, sense, state=None):
        self._sense = sense
        self.state = np.array([0.0, math.inf, 0.0, 0.0, 0.0]) if state is None else np.array(state)

    least_diameter = property(lambda self: float(self.state[0]))
    lost_at = property(lambda self: float(self.state[1]))

    def see(self, block):
        """Check a block of samples."""
        touching = block["normal_force"] > 0.0
        speed, tangential = (self._sense * _chosen(block[name], touching) for name in ("speed", "tangential_velocity"))
        forward = speed > 0.0
        if forward.any():
            needed = -_chosen(tangential, forward) / (np.pi * _chosen(speed, forward))
            self.state[0] = max(self.state[0], float(needed.max()))
        lost = np.flatnonzero(~forward & (tangential <= 0.0))
        if len(lost) and self.lost_at == math.inf:
            i = np.flatnonzero(touching)[lost[0]]
            self.state[1:] = [block[name][i] for name in ("time", "speed", "normal_force", "tangential_velocity")]

    def advice(self):
        """Message for a run in which forward sliding was lost with any diameter."""
        _, time, speed, force, tangential = self.state
        return (
            f"the one-sided friction law requires forward sliding (12), impossible with any diameter from {time:.6g} s on "
            f"({speed:.4g} Hz, in contact with {force:.3g} N, surface moving at {tangential:.3g} m/s): give contact.diameter, so "
            "that friction may stop and reverse, or keep the sense of rotation"
        )
