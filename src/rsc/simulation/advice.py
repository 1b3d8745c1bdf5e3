"""What is said of how a run ended: where it was, why, and what to change."""

import numpy as np

from rsc.kernel import model as kernel
from rsc.kernel import springs
from rsc.kernel.contact import CLOSING, OPENING
from rsc.kernel.tableau import METHODS
from rsc.results.summary import Status
from rsc.simulation import driven
from rsc.simulation.stiffness import limits

# fraction of the turnover above which a residual of the energy ledger is reported
OPEN_LEDGER = 0.01


def advice_of(run, status, ledger):
    """One sentence on why a Run ended with a Status and this Ledger, and what to change; empty where nothing is to be said."""
    limit = _limit(run)
    if status == Status.FINISHED:
        why = run.packed.grounded
        grounded = why and f"between contacts the motion is integrated in steps, not in closed form: {why}"
        return "; ".join(filter(None, (limit, _unclosed(ledger), grounded)))
    if status == Status.OUT_OF_ASSUMPTIONS:
        return run.sliding.advice()
    where, h = _where(run), run.work.real[kernel.H]
    if status == Status.STIFF:
        return f"{limit}; stopped {where}, since solver.max_steps such steps cannot reach the end"
    if status == Status.STOPPED:
        return f"the rotor has stopped {_where(run)}: to keep it turning raise drive.torque at low speeds or lower friction"
    if status == Status.DIVERGED:
        return f"the motion diverged {where}: {_what_fed(run.system, ledger, run.sliding)}"
    if status == Status.STEP_COLLAPSED:
        return f"the step size fell to {h:.3g} s {where}: loosen solver.rtol or look for a stiffness or mass far out of scale"
    if status == Status.NON_FINITE:
        return f"non-finite acceleration {where}: look for values in the scene that overflow"
    if status == Status.TOO_MANY_STEPS:
        cause = f" ({limit})" if limit else ""
        return f"solver.max_steps reached {where}: raise it, shorten the run or loosen solver.rtol{cause}"
    return f"interrupted {where}; the samples so far are kept"


def _limit(run):
    """What limits the steps of a stiff run and how to change that; "" if the run is not stiff."""
    stiff = int(run.work.count[kernel.STIFF]) - 1
    if stiff < 0:
        return ""
    state, sizes = {CLOSING: "closing", OPENING: "opening"}.get(stiff, "open"), (run.system.n_rotor, run.system.n_stator)
    limit, best = (limits(run.packed.model, sizes, method)[state] for method in (run.packed.method, METHODS["taylor8"]))
    series = all(springs.ROOMS[type(data.surfaces.spring)].coefficient for data in run.packed.model.contacts)
    return limit.advice(best.step / limit.step if series else 1.0)


def _where(run):
    """Current time, speed, deflection and contact of the run, for messages."""
    model = run.packed.model
    omega = driven.speed_of(model, run.work.v) if model.drive else run.system.speed_at(run.time)
    speed = float(omega) / (2.0 * np.pi)
    rotor = run.scene.contacts[0].of_rotor(run.packed.physical(run.work.x[None, :])[0][0])
    contact = "in contact" if max(kernel.of_contacts(run.work.count, kernel.NORMAL)) > 0 else "no contact"
    return f"at {run.time:.6g} s ({speed:.4g} Hz, rotor at {abs(rotor):.3g} m, {contact})"


def _unclosed(ledger):
    """One sentence on a ledger that does not close; "" if it does."""
    if not abs(ledger.residual) > OPEN_LEDGER * ledger.turnover:
        return ""
    share = 100.0 * abs(ledger.residual) / ledger.turnover
    return (
        f"the energy ledger does not close: its residual is {share:.2g} % of the turnover, due to noise in fast modes; the "
        "motion is within its tolerance, the energies are not: use taylor8 or a tighter rtol"
    )


def _what_fed(system, ledger, sliding):
    if ledger.turned_in > max(ledger.friction_in, abs(ledger.energy_in)):
        return "the drive fed it through rotating damping; raise other damping, or lower rotating damping or the speed"
    if ledger.control_in > max(ledger.friction_in, abs(ledger.energy_in)):
        return "the control of the first-order states fed it; `rsc modes` shows whether it holds the rotor without contact"
    if ledger.friction_in < 0.5 * abs(ledger.energy_in):
        if system.skew:
            return "skew stiffness or the imposed forces fed it; raise damping or lower skew stiffness"
        return "the imposed forces fed it; look for negative damping or an undamped resonance"
    if any(contact.law.diameter is None for contact in system.contacts):
        return (
            "contact friction fed it: the one-sided law (no contact.diameter) always slides forward, but sliding (12) is lost "
            f"with any diameter below {sliding.least_diameter:.3g} m; give contact.diameter, or lower friction"
        )
    return "contact friction fed it, with sliding throughout; lower friction or add stator damping"
