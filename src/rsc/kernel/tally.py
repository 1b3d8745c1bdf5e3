"""What a run adds up: energy ledger, counts, samples."""

from typing import NamedTuple

from rsc.kernel import springs
from rsc.kernel.contact import CLIPPED, OPEN, normal_force
from rsc.kernel.dense import dense_of
from rsc.kernel.drive import is_driven, mark_turns
from rsc.kernel.losses import follows, is_none, rotates
from rsc.kernel.model import (
    CONTACT_TIME,
    E_BRAKED,
    E_CONTACT,
    E_DRIVE,
    E_FOLLOWING,
    E_FRICTION,
    E_ROTATING,
    E_TORQUE,
    LIMITED,
    ONSETS,
    REJECTED,
    RELEASES,
    RHS_CALLS,
    STEPS,
    STIFF,
    SWITCHES,
)
from rsc.kernel.rhs import Powers
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.switches import kinematics_inside


class Tally(NamedTuple):
    """Sums over the accepted steps."""

    work: object  # Powers integrated, and in `contact` what is lost by the clip
    contact_time: float
    steps: int
    rejected: int
    switches: int
    onsets: int
    releases: int
    limited: int  # of the steps since the last look for stiffness, those near the limit of stability
    stiff: int  # 1 + normal state where a stiff motion was found, 0 before


@unrolled
def _load_rotating(con, real):
    """The work through rotating damping so far, () without."""
    return (lambda con, real: real[E_ROTATING]) if rotates(con) else (lambda con, real: ())


@unrolled
def _load_following(con, real):
    """The work of coefficients that follow the speed so far, () without."""
    return (lambda con, real: real[E_FOLLOWING]) if follows(con) else (lambda con, real: ())


@unrolled
def _put_back(real, i, energy):
    """Put one of them back."""

    def store(real, i, energy):
        real[i] = energy

    return (lambda real, i, energy: None) if is_none(energy) else store


@unrolled
def _load_spin(con, real):
    """The work of a drive's torque and of what brakes it so far, () of a prescribed speed."""
    if not is_driven(con):
        return lambda con, real: ()
    return lambda con, real: vec.from_numbers((real[E_TORQUE], real[E_BRAKED]), con.stiffness)


@unrolled
def _put_spin_back(real, energies):
    """Put them back."""

    def store(real, energies):
        real[E_TORQUE], real[E_BRAKED] = vec.lane(energies, 0), vec.lane(energies, 1)

    return (lambda real, energies: None) if is_none(energies) else store


@inlined
def load_tally(con, work, width):
    """The sums so far."""
    real, count = work.real, work.count
    damping, drive = vec.load(work.ledger_damping, width), vec.load_product(work.ledger_input, width)
    rotating, following = _load_rotating(con, real), _load_following(con, real)
    return Tally(
        Powers(damping, drive, real[E_CONTACT], real[E_FRICTION], real[E_DRIVE], rotating, following, _load_spin(con, real)),
        real[CONTACT_TIME],
        count[STEPS],
        count[REJECTED],
        count[SWITCHES],
        count[ONSETS],
        count[RELEASES],
        count[LIMITED],
        count[STIFF],
    )


@inlined
def store_tally(work, tally, calls):
    """Put the sums back; `calls` of the right-hand side were made by steps, one more was where a new contact state began."""
    real, count, before = work.real, work.count, tally.work
    count[RHS_CALLS] += calls + tally.switches - count[SWITCHES]
    vec.store(work.ledger_damping, before.damping)
    vec.store(work.ledger_input, before.drive)
    real[E_CONTACT], real[E_FRICTION], real[E_DRIVE] = before.contact, before.friction, before.ring
    _put_back(real, E_ROTATING, before.rotating)
    _put_back(real, E_FOLLOWING, before.following)
    _put_spin_back(real, before.spin)
    real[CONTACT_TIME] = tally.contact_time
    count[STEPS], count[REJECTED], count[SWITCHES] = tally.steps, tally.rejected, tally.switches
    count[ONSETS], count[RELEASES] = tally.onsets, tally.releases
    count[LIMITED], count[STIFF] = tally.limited, tally.stiff


@inlined
def book(con, tally, work, contact, kins, h):
    """The sums after an accepted step: the work done until its end, and contact time; kins = contact kinematics at its start and
    end."""
    lost = work.contact
    time = tally.contact_time + h if contact.normal != OPEN else tally.contact_time
    if contact.normal == CLIPPED:
        # without a force the spring unloads for nothing: what it held is lost
        p_0, p_1 = kins[0].place.penetration, max(kins[1].place.penetration, 0.0)
        lost += springs.power(con.surfaces.spring, p_0, p_1)
    limited = tally.limited + 1 if h > contact.near_limit else tally.limited
    counts = (tally.steps + 1, tally.rejected, tally.switches, tally.onsets, tally.releases, limited, tally.stiff)
    sums = Powers(work.damping, work.drive, lost, work.friction, work.ring, work.rotating, work.following, work.spin)
    return Tally(sums, time, *counts)


@inlined
def _counted(tally, rejected, switches, onset, release):
    """The sums with counts added."""
    t = tally
    counts = (t.steps, t.rejected + rejected, t.switches + switches, t.onsets + onset, t.releases + release, t.limited, t.stiff)
    return Tally(t.work, t.contact_time, *counts)


@inlined
def end_window(tally, stiff):
    """The sums after a look for stiffness."""
    t = tally
    counts = (t.steps, t.rejected, t.switches, t.onsets, t.releases, 0, stiff)
    return Tally(t.work, t.contact_time, *counts)


@inlined
def count_rejected(tally):
    """One more attempt that was too long."""
    return _counted(tally, 1, 0, 0, 0)


@inlined
def count_switch(tally, inside, normal, normal_new):
    """One more switch unless the step ended inside its state (at a corner of the schedule), perhaps an onset or a release."""
    onset = 1 if normal == OPEN and normal_new != OPEN else 0
    release = 1 if normal != OPEN and normal_new == OPEN else 0
    return _counted(tally, 0, 0 if inside else 1, onset, release)


class Output(NamedTuple):
    """Where samples are written, a row each: x, v where it is kept, normal force, friction force, tangential velocity."""

    base: int  # address of the first row
    columns: int  # numbers in a row
    velocities: int  # numbers in front of v, 0 where no velocities are kept
    first: int  # number of the first sample
    rows: int  # samples that fit


@inlined
def save_samples(con, law, where, sample, path, end, method):
    """Write every sample time inside a step from number `sample` on into an Output; returns the next."""
    start, h = path.clock, path.h
    dense = dense_of(path, method)
    time = sample / con.sample_rate
    while (time - end.hi) - end.lo <= 0.0:
        theta = min(max(((time - start.hi) - start.lo) / h, 0.0), 1.0)
        (x, v), kin = kinematics_inside(con, path, dense, theta)
        force = normal_force(law, kin)
        force = force if force > 0.0 else 0.0  # not max: without contact 0 times a negative penetration is -0.0
        row = (sample - where.first) * where.columns
        vec.store_at(where.base, row, x)
        mark_turns(con, where.base, row, path.clock.phase, x, v)
        if where.velocities > 0:
            vec.store_at(where.base, row + where.velocities, v)
        forces = row + where.columns - 3
        vec.store_number(where.base, forces, force)
        vec.store_number(where.base, forces + 1, force * (law.mu + law.mu_slope * kin.motion.slip))
        vec.store_number(where.base, forces + 2, kin.motion.tangential)
        sample += 1
        time = sample / con.sample_rate
    return sample
