"""Data of the kernel: constant `Model`, mutable `Work`, and return codes of `march`.

Shapes: n = N + M vibration modes, stored as interleaved pairs (y, z).
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
from rsc.kernel.states import states_of


class ContactData(NamedTuple):
    """One contact of a Model: rows in the kernel's coordinates, and constants."""

    contact_row: np.ndarray  # (2n,) Phi, - : contact deflection d = sum Phi_i x_i (stator entries negative)
    rotor_row: np.ndarray  # (2n,) rotor part of contact_row: r_R at the contact
    force_row: np.ndarray  # (2n,) -P, 1/kg (negated): acceleration per newton of F_C
    ring: tuple  # (y, z), m, eccentricity of the contact ring; () without one, which is a different type
    offset: tuple  # (y, z), m, rest position of the stator's centre; () if zero
    gap: float  # m
    surfaces: Surfaces
    race: tuple  # `race.RaceData`, () if the stator surface cannot rotate


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
    """Constants of one scene; every array float64, C-contiguous; created only by `rsc.simulation.pack`."""

    stiffness: np.ndarray  # (2n,) -omega_i^2, 1/s^2 (negative, so that it is added)
    damping: np.ndarray  # (2n,) -c_ii, 1/s, diagonal part, negative
    unbalance: np.ndarray  # (2n,) U, m
    euler: np.ndarray  # (2n,) W, m: Euler term beyond U (zero without gyroscopics)
    load: np.ndarray  # (2n,) f0 per mass, m/s^2
    scale_x: np.ndarray  # (2n,) (gap)^2, m^2: absolute tolerance of x is rtol * sqrt(this)
    scale_v: np.ndarray  # (2n,) (gap omega_i)^2, m^2/s^2
    weight: np.ndarray  # (2n,) modal masses, kg (rotor and stator reference mass), for energies only
    # absent matrices are (), a different type: such a kernel is compiled separately, without the code for them
    damping_columns: np.ndarray  # (n, 2n) -C off-diagonal part, column by column
    gyroscopic_columns: np.ndarray  # (n, 2n) G, 1/1
    # (2n, 2n) skew and anisotropic stiffness, negative, in the layout of `vec.times_components`; if present, the damping matrix
    # has that layout too
    stiffness_columns: np.ndarray
    rotating_columns: np.ndarray  # (n, 2n) D_i per mass, 1/s, rotating damping: acts on v - i Omega x
    # (intervals, 2, 2n, 2n) speed-dependent coefficients: between two knots K_a + Omega K_b, instead of stiffness_columns, and
    # B_a + Omega B_b, instead of damping_columns
    following_stiffness: np.ndarray
    following_damping: np.ndarray
    contacts: tuple  # `ContactData` of each contact; their number is part of the type
    # `drive.DriveData` if the speed is integrated: `unbalance` is then zero and vectors have one more pair at the end
    drive: tuple
    flight: tuple  # `FlightData`, () if the scene has no exact flight
    states: tuple  # `states.StateData`, () without first-order states
    watched_rows: np.ndarray  # (k, 2n) one row per clearance, like `contact_row`
    watched_gaps: np.ndarray  # (k,) m
    corner_time: np.ndarray  # (k,) s, corners of the speed schedule
    corner_speed: np.ndarray  # (k,) Hz
    corner_interval: np.ndarray  # (k,) index of the interval between knots after each corner, () without knots
    rtol: float
    switch_tol: float  # velocity error allowed for overshooting a switch, relative like rtol
    h_max: float  # s, at most a quarter turn at any speed of the schedule
    stable_open: float  # s, longest stable step without contact
    stable_closing: float  # s, longest stable step with all contact springs
    stable_opening: float  # s, longest stable step with all contact springs and dampers
    resolved_angle: float  # largest h omega at which the error estimate of an oscillation passes
    divergence: float  # m, a larger |d| counts as diverged
    max_steps: int
    sample_rate: float  # Hz
    stretch: float  # s, length of a stretch, over which facts are accumulated (facts.py)


class Work(NamedTuple):
    """All state of a run; saved completely, it is a checkpoint from which the run continues bit for bit."""

    x: np.ndarray  # (2n,) m
    v: np.ndarray  # (2n,) m/s
    ledger_damping: np.ndarray  # (2n,) m^2/s^2: integral of v * (C v), elementwise
    ledger_input: np.ndarray  # (2n,) integral of v * (unbalance + load); its sum in the first pair if vectors span registers
    real: np.ndarray  # (N_REAL,) indices see below
    count: np.ndarray  # (N_COUNT,) int64
    stretch: np.ndarray  # (N_STRETCH,) current stretch, see facts.py


# names of the vectors that a step reads, and of those that it changes
MODEL_VECTORS, CONTACT_VECTORS, WORK_VECTORS = Model._fields[:7], ContactData._fields[:3], Work._fields[:4]


# indices into Work.real; FLIGHT: see `flight.READY`
(
    T_HI, T_LO, PHASE, H, CONTACT_TIME, E_CONTACT, E_FRICTION, E_DRIVE, E_ROTATING, E_FOLLOWING, E_TORQUE, E_BRAKED, FLIGHT,
    E_CONTROL, N_REAL,
) = range(15)  # fmt: skip
# indices into Work.count; LIMITED: steps near the stability limit in this window, STIFF: 1 + normal state in which found stiff
NORMAL, FRICTION, SAMPLES, SEGMENT, RHS_CALLS, STEPS, REJECTED, SWITCHES, ONSETS, RELEASES, LIMITED, STIFF, N_COUNT = range(13)

# return codes of march
RUNNING, BUFFER_FULL, FINISHED, DIVERGED, STEP_COLLAPSED, NON_FINITE, TOO_MANY_STEPS, TOO_STIFF, STOPPED = range(9)


# entries appended to Work.real and Work.count for every contact but the first, in this order
REAL_OF_CONTACT, COUNT_OF_CONTACT = (CONTACT_TIME, E_CONTACT, E_FRICTION, E_DRIVE), (NORMAL, FRICTION, ONSETS, RELEASES)


def n_real(contacts):
    """Length of Work.real for this number of contacts."""
    return N_REAL + len(REAL_OF_CONTACT) * (contacts - 1)


def n_count(contacts):
    """Length of Work.count for this number of contacts."""
    return N_COUNT + len(COUNT_OF_CONTACT) * (contacts - 1)


def places_of(numbers, i):
    """Indices of entry i of every contact in `numbers`, which is Work.real or Work.count."""
    kinds, shared = (COUNT_OF_CONTACT, N_COUNT) if numbers.dtype == np.int64 else (REAL_OF_CONTACT, N_REAL)
    return [i, *range(shared + kinds.index(i), len(numbers), len(kinds))]


def of_contacts(numbers, i):
    """Entry i of every contact in Work.real or Work.count."""
    return numbers[places_of(numbers, i)]


class ContactConstants(NamedTuple):
    """A contact as values in registers. Code for a single contact takes these instead of all Constants, so they repeat the few
    constants it needs."""

    contact_row: object
    rotor_row: object
    force_row: object
    gap: float
    surfaces: Surfaces
    ring_y: float
    ring_z: float
    offset_y: float
    offset_z: float
    has_ring: bool  # known at compile time
    has_offset: bool
    scale_v: object
    switch_tol: float
    drive: tuple
    race: tuple  # `race.Race`, () without


class Constants(NamedTuple):
    """Vectors and numbers of a Model as values in registers, as a step needs them: no arrays, so that helpers count no
    references."""

    stiffness: object
    damping: object
    unbalance: object
    i_unbalance: object  # times the imaginary unit
    euler: object
    i_euler: object
    load: object
    scale: object  # squared scales: of x in the first component of a pair, of v in the second
    contacts: tuple  # `ContactConstants` of each contact
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
    has_euler: bool  # known at compile time
    columns: tuple  # addresses of the damping and gyroscopic matrices (0: none) and of the stiffness; () without any
    rotating: tuple  # address of the rotating damping, () without
    following: tuple  # see `following_of`, () if all coefficients are constant
    drive: tuple  # `drive.Drive`, () if the speed is prescribed
    flight: tuple  # `Flight`, () if the scene has no exact flight
    states: tuple  # `states.PackedStates`, () without first-order states


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
    """Address of a matrix, 0 if absent."""
    return vec.address(columns) if is_array(columns) else 0


@question
def _one_is_there(*matrices):
    """Whether at least one of the matrices is present."""
    return not all(map(is_none, matrices))


@static
def _addresses_of(damping, gyroscopic, stiffness, rotating, following, states):
    """See `Constants.columns`; with rotating damping or states not (), since those use the code for full matrices."""
    if _one_is_there(stiffness, following):
        return _address_of(damping), _address_of(gyroscopic), _address_of(stiffness)
    if _one_is_there(damping, gyroscopic, rotating, states):
        return _address_of(damping), _address_of(gyroscopic)
    return ()


@static
def following_of(stiffness, damping, interval):
    """Speed-dependent coefficients: (address of the interval of each corner, bytes of a matrix, address of the stiffness, and
    of the damping if speed-dependent); () if all are constant."""
    if not is_array(stiffness):
        return ()
    size = 8 * stiffness.shape[2] * stiffness.shape[3]
    if not is_array(damping):
        return vec.address(interval), size, vec.address(stiffness)
    return vec.address(interval), size, vec.address(stiffness), vec.address(damping)


@static
def _where_there_is(columns):
    """(address of a matrix,), () if absent."""
    return (vec.address(columns),) if is_array(columns) else ()


@static
def _pair_of(pair):
    """(y, z) of a ring or an offset, zeros if absent."""
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
    """The Constants of a Model; `width` is a tuple of 2n floats of which only the length matters."""
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
            model.states,
        ),
        rotating=_where_there_is(model.rotating_columns),
        following=following_of(model.following_stiffness, model.following_damping, model.corner_interval),
        drive=drive,
        flight=_flight_of(model.flight),
        states=states_of(model.states, width),
    )
