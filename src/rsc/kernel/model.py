"""The data of the kernel: constant `Model`, mutable `Work`, and what `march` returns.

Shapes: n = N + M modes of vibration, pairs (y, z) interleaved.
"""

from typing import NamedTuple

import numpy as np

from rsc.kernel.contact import Surfaces
from rsc.kernel.drive import drive_of
from rsc.kernel.questions import is_array, is_none
from rsc.kernel.race import race_of
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import anywhere, inlined
from rsc.kernel.simd.static import question, static


class ContactData(NamedTuple):
    """One contact in a Model: its rows in the kernel's coordinates, and its constants."""

    contact_row: np.ndarray  # (2n,) Phi, - : contact deflection d = sum Phi_i x_i (stator entries negative)
    rotor_row: np.ndarray  # (2n,) the rotor's part of it: r_R at the contact
    force_row: np.ndarray  # (2n,) -P, 1/kg (negated): acceleration per newton of F_C
    ring: tuple  # (y, z), m, eccentricity of the contact ring, () without: another type
    offset: tuple  # (y, z), m, of the stator's centre at rest, () without
    gap: float  # m
    surfaces: Surfaces
    race: tuple  # `race.RaceData`, () of a stator that does not turn


NODES = 5  # of a block of flight, evenly over it, at which the forces are known
# rows of weights: for a number of the motion, for its state (x, v), and for what a block has before its units
ROWS_OF_NUMBER = 2 + NODES
ROWS_OF_STATE, ROWS_OF_NODES = 2 * ROWS_OF_NUMBER, 2 * ROWS_OF_NUMBER * (NODES - 1) + ROWS_OF_NUMBER * NODES


class FlightData(NamedTuple):
    """What a Model needs to fly, see `rsc.kernel.flight`; made by `rsc.simulation.flight`."""

    weights: np.ndarray  # (rows_before(count, shortest), 2n) see `rsc.simulation.flight`
    hidden: np.ndarray  # (contacts, 2, 2n) of the squares of x and v: square of what a mode may hide between two units, m^2
    clear: np.ndarray  # (contacts,) m, |d| up to which nothing touches
    unit_rate: float  # units per s: a power of two times the sample rate
    per_sample: int  # units in a sample
    shortest: int  # units of the shortest block; the others have 2, 4, ... times as many
    count: int  # of lengths


@anywhere
def rows_before(length, shortest):
    """Rows of weights before those of a length: of each come those of the nodes, of the work at them, and of every unit."""
    return ROWS_OF_NODES * length + ROWS_OF_STATE * shortest * ((1 << length) - 1)


class Model(NamedTuple):
    """Constants of one scene; every array float64, C-contiguous; made by `rsc.simulation.pack` only."""

    stiffness: np.ndarray  # (2n,) -omega_i^2, 1/s^2 (negated: it is added)
    damping: np.ndarray  # (2n,) -c_ii, 1/s (negated), the diagonal part
    unbalance: np.ndarray  # (2n,) U, m
    euler: np.ndarray  # (2n,) W, m: Euler term beyond U (zero without gyroscopics)
    load: np.ndarray  # (2n,) f0 per mass, m/s^2
    scale_x: np.ndarray  # (2n,) (gap)^2, m^2: absolute tolerance of x is rtol * sqrt(this)
    scale_v: np.ndarray  # (2n,) (gap omega_i)^2, m^2/s^2
    weight: np.ndarray  # (2n,) modal masses, kg (rotor and stator reference mass), for energies only
    # when there is none (), another type: that kernel is compiled apart, without what a matrix or a ring would need
    damping_columns: np.ndarray  # (n, 2n) -C off-diagonal part, column by column
    gyroscopic_columns: np.ndarray  # (n, 2n) G, 1/1
    # (2n, 2n) skew and anisotropic stiffness, negated, as `vec.times_components` takes it; with it such is the damping's matrix
    stiffness_columns: np.ndarray
    rotating_columns: np.ndarray  # (n, 2n) D_i per mass, 1/s, rotating damping: acts on v - i Omega x
    # (intervals, 2, 2n, 2n) of coefficients that follow the speed: between two knots K_a + Omega K_b, in place of
    # stiffness_columns, and B_a + Omega B_b in place of damping_columns
    following_stiffness: np.ndarray
    following_damping: np.ndarray
    contacts: tuple  # a `ContactData` each: how many there are is a type
    drive: tuple  # `drive.DriveData` of an integrated speed; then no unbalance above, and a last pair of numbers more
    flight: tuple  # `FlightData`, () of a scene that does not fly
    watched_rows: np.ndarray  # (k, 2n) a row a clearance, as `contact_row`
    watched_gaps: np.ndarray  # (k,) m
    corner_time: np.ndarray  # (k,) s, corners of the speed schedule
    corner_speed: np.ndarray  # (k,) Hz
    corner_interval: np.ndarray  # (k,) number of the interval between knots behind each corner, () without knots
    rtol: float
    switch_tol: float  # error of the velocity that a switch met late may leave, relative as rtol
    h_max: float  # s, no more than a quarter of a turn at any speed of the schedule
    stable_open: float  # s, the longest stable step without contact
    stable_closing: float  # s, with the springs of all contacts
    stable_opening: float  # s, with their springs and dampers
    resolved_angle: float  # h omega of an oscillation whose error estimate just passes
    divergence: float  # m, |d| beyond which the run has diverged
    max_steps: int
    sample_rate: float  # Hz
    stretch: float  # s, length of a stretch of the run, over which facts are added up (facts.py)


class Work(NamedTuple):
    """Everything that changes while marching; saved whole, it is a checkpoint that continues bit for bit."""

    x: np.ndarray  # (2n,) m
    v: np.ndarray  # (2n,) m/s
    ledger_damping: np.ndarray  # (2n,) m^2/s^2 per number: integral of v * (C v)
    ledger_input: np.ndarray  # (2n,) integral of v * (unbalance + load); of vectors of several registers in the first pair
    real: np.ndarray  # (N_REAL,) see the indices below
    count: np.ndarray  # (N_COUNT,) int64
    stretch: np.ndarray  # (N_STRETCH,) the running stretch, see facts.py


# names of the vectors that a step needs, and of those that it changes
MODEL_VECTORS, CONTACT_VECTORS, WORK_VECTORS = Model._fields[:7], ContactData._fields[:3], Work._fields[:4]


# indices into Work.real; FLIGHT: see `flight.READY`
(
    T_HI, T_LO, PHASE, H, CONTACT_TIME, E_CONTACT, E_FRICTION, E_DRIVE, E_ROTATING, E_FOLLOWING, E_TORQUE, E_BRAKED, FLIGHT,
    N_REAL,
) = range(14)  # fmt: skip
# indices into Work.count; LIMITED: steps near the limit of stability in this window, STIFF: 1 + normal state where it was found
NORMAL, FRICTION, SAMPLES, SEGMENT, RHS_CALLS, STEPS, REJECTED, SWITCHES, ONSETS, RELEASES, LIMITED, STIFF, N_COUNT = range(13)

# what march returns
RUNNING, BUFFER_FULL, FINISHED, DIVERGED, STEP_COLLAPSED, NON_FINITE, TOO_MANY_STEPS, TOO_STIFF, STOPPED = range(9)


# behind these for every contact but the first, in the same order: what Work.real and Work.count have of it
REAL_OF_CONTACT, COUNT_OF_CONTACT = (CONTACT_TIME, E_CONTACT, E_FRICTION, E_DRIVE), (NORMAL, FRICTION, ONSETS, RELEASES)


def n_real(contacts):
    """Length of Work.real with so many contacts."""
    return N_REAL + len(REAL_OF_CONTACT) * (contacts - 1)


def n_count(contacts):
    """Length of Work.count with so many contacts."""
    return N_COUNT + len(COUNT_OF_CONTACT) * (contacts - 1)


def places_of(numbers, i):
    """Where Work.real or Work.count, `numbers`, has the number i of every contact."""
    kinds, own = (COUNT_OF_CONTACT, N_COUNT) if numbers.dtype == np.int64 else (REAL_OF_CONTACT, N_REAL)
    return [i, *range(own + kinds.index(i), len(numbers), len(kinds))]


def of_contacts(numbers, i):
    """The number i of every contact in Work.real or Work.count."""
    return numbers[places_of(numbers, i)]


class ContactConstants(NamedTuple):
    """A contact as values in registers. What looks at one contact alone takes these in the place of all Constants, so they have
    besides what such code needs of those."""

    contact_row: object
    rotor_row: object
    force_row: object
    gap: float
    surfaces: Surfaces
    ring_y: float
    ring_z: float
    offset_y: float
    offset_z: float
    has_ring: bool  # known while compiling
    has_offset: bool
    scale_v: object
    switch_tol: float
    drive: tuple
    race: tuple  # `race.Race`, () without


class Constants(NamedTuple):
    """The vectors and numbers of a Model as values in registers, as a step needs them: no arrays, so that helpers count no
    references."""

    stiffness: object
    damping: object
    unbalance: object
    i_unbalance: object  # times the imaginary unit
    euler: object
    i_euler: object
    load: object
    scale: object  # of x in the first number of a pair, of v in the second
    contacts: tuple  # a `ContactConstants` each
    switch_tol: float
    per_rtol2: float  # 1/rtol^2
    h_max: float
    stable_open: float
    stable_closing: float
    stable_opening: float
    resolved_angle: float
    divergence2: float  # m^2
    sample_rate: float
    max_steps: int
    has_euler: bool  # known while compiling
    columns: tuple  # addresses of the matrices of damping and gyroscopics, 0 for none, and of the stiffness; () without any
    rotating: tuple  # address of the rotating damping, () without
    following: tuple  # see `following_of`, () without coefficients that follow the speed
    drive: tuple  # `drive.Drive`, () of a prescribed speed
    flight: tuple  # `Flight`, () of a scene that does not fly


class Flight(NamedTuple):
    """`FlightData` as addresses and numbers."""

    weights: int
    hidden: int
    clear: int
    unit_rate: float
    per_sample: int
    shortest: int
    count: int


@static
def _flight_of(data):
    """The Flight of FlightData, () without."""
    if is_none(data):
        return ()
    weights, hidden, clear = vec.address(data.weights), vec.address(data.hidden), vec.address(data.clear)
    return Flight(weights, hidden, clear, data.unit_rate, data.per_sample, data.shortest, data.count)


@static
def _address_of(columns):
    """Address of a matrix, 0 of none."""
    return vec.address(columns) if is_array(columns) else 0


@question
def _one_is_there(*matrices):
    """Whether one of some matrices is there."""
    return any(map(is_array, matrices))


@static
def _addresses_of(damping, gyroscopic, stiffness, rotating, following):
    """See `Constants.columns`: not () either beside rotating damping, which needs the code of full matrices."""
    if _one_is_there(stiffness, following):
        return _address_of(damping), _address_of(gyroscopic), _address_of(stiffness)
    if _one_is_there(damping, gyroscopic, rotating):
        return _address_of(damping), _address_of(gyroscopic)
    return ()


@static
def following_of(stiffness, damping, interval):
    """Of coefficients that follow the speed: (address of the corners' intervals, bytes of a matrix, address of the stiffness, and
    of the damping where that follows), () without."""
    if not is_array(stiffness):
        return ()
    size = 8 * stiffness.shape[2] * stiffness.shape[3]
    if not is_array(damping):
        return vec.address(interval), size, vec.address(stiffness)
    return vec.address(interval), size, vec.address(stiffness), vec.address(damping)


@static
def _where_there_is(columns):
    """(address of a matrix,), () of none."""
    return (vec.address(columns),) if is_array(columns) else ()


@static
def _pair_of(pair):
    """(y, z) of a ring or an offset, without one zeros."""
    return (0.0, 0.0) if is_none(pair) else pair


@inlined
def _contact_of(data, scale_v, switch_tol, drive, width):
    ring, offset = _pair_of(data.ring), _pair_of(data.offset)
    return ContactConstants(
        vec.load(data.contact_row, width), vec.load(data.rotor_row, width), vec.load(data.force_row, width),
        data.gap, data.surfaces,
        ring[0], ring[1], offset[0], offset[1], len(data.ring) > 0, len(data.offset) > 0, scale_v, switch_tol, drive,
        race_of(data.race, width),
    )  # fmt: skip


@static
def _contacts_of(data, scale_v, switch_tol, drive, width):
    """The ContactConstants of every ContactData."""
    if is_none(data):
        return ()
    return (_contact_of(data[0], scale_v, switch_tol, drive, width),) + _contacts_of(data[1:], scale_v, switch_tol, drive, width)


@inlined
def constants(model, width):
    """The Constants of a Model; `width` is a tuple of 2 n floats that only carries its length."""
    euler, unbalance = vec.load(model.euler, width), vec.load(model.unbalance, width)
    scale_v, drive = vec.load(model.scale_v, width), drive_of(model.drive, width)
    return Constants(
        stiffness=vec.load(model.stiffness, width),
        damping=vec.load(model.damping, width),
        unbalance=unbalance,
        i_unbalance=vec.times_i(unbalance),
        euler=euler,
        i_euler=vec.times_i(euler),
        load=vec.load(model.load, width),
        scale=vec.alternate(vec.load(model.scale_x, width), scale_v),
        contacts=_contacts_of(model.contacts, scale_v, model.switch_tol, drive, width),
        switch_tol=model.switch_tol,
        per_rtol2=1.0 / (model.rtol * model.rtol),
        h_max=model.h_max,
        stable_open=model.stable_open,
        stable_closing=model.stable_closing,
        stable_opening=model.stable_opening,
        resolved_angle=model.resolved_angle,
        divergence2=model.divergence * model.divergence,
        sample_rate=model.sample_rate,
        max_steps=model.max_steps,
        has_euler=vec.largest(euler * euler + vec.swap(euler * euler)) != 0.0,
        columns=_addresses_of(
            model.damping_columns,
            model.gyroscopic_columns,
            model.stiffness_columns,
            model.rotating_columns,
            model.following_stiffness,
        ),
        rotating=_where_there_is(model.rotating_columns),
        following=following_of(model.following_stiffness, model.following_damping, model.corner_interval),
        drive=drive,
        flight=_flight_of(model.flight),
    )
