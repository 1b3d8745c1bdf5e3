"""What a predicted whirl takes from the drive, and what that gives."""

from rsc.analysis.paper.predict import Whirl
from rsc.analysis.several.whirl import SeveralWhirl
from rsc.system.held import Load, loads
from rsc.system.system import System


def whirl_loads(system: System, whirl: Whirl) -> tuple[Load, ...]:
    """What friction of a whirl that slides takes from the drive of a system, mu F_N d_R/2 at each contact, beside the torque of
    that drive; empty without a torque in the drive, and of one that cannot slide."""
    if system.drive is None or "sliding" in whirl.violated:
        return ()
    torque = 0.0
    for contact in system.contacts:
        law = contact.law
        if law.diameter is None:
            return ()
        F_N = whirl.contacts[contact.name].normal_force if isinstance(whirl, SeveralWhirl) else whirl.normal_force
        torque += 0.5 * law.friction * F_N * law.diameter
    return loads(system.drive, whirl.speed, torque)
