"""What a predicted whirl takes from the drive."""

from rsc.analysis.paper.predict import Whirl
from rsc.system.held import Held, held
from rsc.system.system import System


def whirl_held(system: System, whirl: Whirl) -> tuple[Held, ...]:
    """What the drive of a system makes of a whirl that slides, whose friction takes mu F_N d_R/2 at each contact; empty without a
    torque in the drive, and of one that cannot slide."""
    if system.drive is None or "sliding" in whirl.violated:
        return ()
    at = getattr(whirl, "contacts", None)  # of a SeveralWhirl
    torque = 0.0
    for contact in system.contacts:
        F_N, law = at[contact.name].normal_force if at else whirl.normal_force, contact.law
        if law.diameter is None:
            return ()
        torque += 0.5 * law.friction * F_N * law.diameter
    return held(system.drive, whirl.speed, torque)
