"""What a predicted whirl takes from the drive."""

from rsc.analysis.paper.predict import Whirl
from rsc.system.held import Held, held
from rsc.system.system import System


def whirl_held(system: System, whirl: Whirl) -> tuple[Held, ...]:
    """What the drive of a system makes of a whirl that slides, whose friction takes mu F_N d_R/2; empty without a torque in the
    drive, and of one that cannot slide."""
    if system.drive is None or system.law.diameter is None or "sliding" in whirl.violated:
        return ()
    return held(system.drive, whirl.speed, 0.5 * system.law.friction * whirl.normal_force * system.law.diameter)
