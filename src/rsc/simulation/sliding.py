"""Does the one-sided friction law hold? Its condition (12), sliding forward, looked at in the samples of a run."""

import math
from dataclasses import replace

import numpy as np


def signed(law, sense):
    """The law for the kernel, whose one-sided friction drives the way the rotor turns (`System.sense`): where that is backwards,
    mu < 0."""
    return law if law.diameter is not None else replace(law, friction=sense * law.friction)


def _chosen(values, mask):
    """The chosen values; without a copy where all are."""
    return values if mask.all() else values[mask]


class SlidingWatch:
    """Where v_rel = Omega d_R/2 + v_t > 0 could hold in contact, for a law that slides forward without knowing the diameter d_R;
    of a rotor that turns backwards (sense = -1) in the mirror image, where both have the other sign.

    state : (5,) least diameter in m for which every sample in contact with Omega > 0 slides forward; then time in s (infinite:
        never), speed in Hz, normal force in N and tangential velocity v_t in m/s of the first sample in contact that slides
        forward with no diameter (Omega <= 0 and v_t <= 0).
    """

    def __init__(self, sense, state=None):
        self._sense = sense
        self.state = np.array([0.0, math.inf, 0.0, 0.0, 0.0]) if state is None else np.array(state)

    least_diameter = property(lambda self: float(self.state[0]))
    lost_at = property(lambda self: float(self.state[1]))

    def see(self, block):
        """Look at a block of samples."""
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
        """What a run says whose sliding was lost for certain."""
        _, time, speed, force, tangential = self.state
        return (
            f"the one-sided friction law slides forward (12), which no diameter can do from {time:.6g} s on ({speed:.4g} Hz, in "
            f"contact with {force:.3g} N, surface moving at {tangential:.3g} m/s): give contact.diameter, so that friction "
            "may stop and reverse, or keep the sense of rotation"
        )
