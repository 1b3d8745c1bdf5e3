"""How a run ended: status, counters and energies."""

import enum
from dataclasses import dataclass


class Status(enum.StrEnum):
    """How a run ended."""

    FINISHED = "finished"
    DIVERGED = "diverged"
    STIFF = "stiff"
    STEP_COLLAPSED = "step collapsed"
    NON_FINITE = "non-finite"
    TOO_MANY_STEPS = "too many steps"
    INTERRUPTED = "interrupted"
    STOPPED = "stopped"  # the speed of a drive with a torque fell to zero
    OUT_OF_ASSUMPTIONS = "out of assumptions"  # it reached its end, but sliding forward (12) was lost under the one-sided law


@dataclass(frozen=True)
class Ledger:
    """Energies of a run in J; residual = energy_in + turned_in + followed_in + driven_in + control_in + friction_in - every
    dissipated part - change. Of a drive with a torque all that turns belongs to it."""

    energy_in: float  # by unbalance, load, skew stiffness and the contact ring; with a torque by load and skew stiffness
    # by contact friction into the lateral motion (negative: taken out); with a torque less the slip's heat and what turns a race
    friction_in: float
    rotor_damping: float  # dissipated, by anisotropic and rotating damping as well; skew damping takes nothing
    stator_damping: float
    contact_damping: float
    change: float  # kinetic and elastic energy, of anisotropic springs and with a torque J Omega^2/2 as well, end minus start
    residual: float
    turned_in: float = 0.0  # given by the drive through rotating damping, which takes it again or feeds the whirl with it
    followed_in: float = 0.0  # fed by a stiffness that follows the speed, 1/2 int Omega' r^H K_b r
    driven_in: float = 0.0  # work of the drive's torque, int T Omega
    control_in: float = 0.0  # by the control: work of first-order states and of the negative stiffness of magnetic bearings

    @property
    def turnover(self) -> float:
        """Sum of the magnitudes of all parts: the scale the residual is judged by."""
        fed = (self.energy_in, self.turned_in, self.followed_in, self.driven_in, self.control_in, self.friction_in)
        lost = (self.rotor_damping, self.stator_damping, self.contact_damping)
        return sum(abs(p) for p in (*fed, *lost)) + abs(self.change)


@dataclass(frozen=True)
class Summary:
    """How a run ended: status, advice, counters, energies and the versions it was made with."""

    status: Status
    advice: str  # one sentence; empty for a finished run that nothing slowed down
    end_time: float  # s reached
    rtol: float  # as used: solver.rtol, or less where that would not resolve the contact (`rsc.simulation.tolerances`)
    steps: int
    rejected: int
    rhs_calls: int
    switches: int  # contact switches that ended a step
    contact_onsets: int
    contact_releases: int
    contact_time: float  # s in contact
    least_diameter: float  # m, contact.diameter from which on every sample in contact slides forward (12); 0 with a diameter
    sliding_lost: float  # s, first sample in contact that slides forward with no diameter; infinite: never
    ledger: Ledger
    versions: str
