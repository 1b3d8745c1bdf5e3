"""Where a motion that runs away would end: the rolling whirls of shafts whose diameter at the contact is assumed.

Without a diameter friction keeps its sense however fast the contact turns, the paper's condition (12), and what should come to
roll grows without bound.
"""

from collections.abc import Sequence
from math import tau as TWO_PI

from rsc.analysis.paper.rolling import rolling_whirls
from rsc.measure.catalogue import AssumedRoll, LastingMotion, Predicted
from rsc.scene.scene import Scene
from rsc.system.assemble import assemble
from rsc.system.border import border_of

CLEARANCES = (0.0025, 0.05)  # gap over the radius of the shaft that is assumed, of a tight and of a wide one


def assumed_rolls(scene: Scene, speed: float, lasting: Sequence[LastingMotion]) -> tuple[AssumedRoll, ...]:
    """The rolling whirl for each assumed diameter, of a list with a motion that runs away at its only contact; else ()."""
    if all(motion.bounded for motion in lasting) or len(scene.contacts) > 1 or scene.contact.diameter is not None or not speed:
        return ()
    return tuple(_assumed(scene, speed, 2.0 * scene.contact.gap / clearance) for clearance in CLEARANCES)


def _assumed(scene: Scene, speed: float, diameter: float) -> AssumedRoll:
    system = assemble(scene.with_values({"contact.diameter": diameter}))
    rolls = [roll for roll in rolling_whirls(system, TWO_PI * speed) if roll.stable and roll.Psi < 0.0]
    if not rolls:
        return AssumedRoll(diameter, None, None)
    hardest = max(rolls, key=lambda roll: roll.normal_force)
    frequency, amplitude, force = hardest.Psi / TWO_PI, hardest.rotor_amplitude, hardest.normal_force
    border = border_of(system, speed, [force], amplitude, frequency)
    nan = float("nan")
    return AssumedRoll(diameter, Predicted("roll", frequency, amplitude, force, hardest.growth_rate, nan, True), border)
