"""System -> kernel Model: real modes of rotor and stator separately, scaled to metres, and packed arrays.

In real modes the stiffness is diagonal, and so is modal or Rayleigh damping; only what remains full (other damping, gyroscopics)
needs the kernel's matrices. Every coordinate of the kernel is a length, so that one absolute tolerance, rtol times the gap, fits
all. With skew or anisotropic springs, whose work the ledger books together with that of the unbalance using the rotor's mass, the
stator's modes are normalised to that mass as well and its tolerances scaled.
"""

from dataclasses import dataclass, replace

import numpy as np

from rsc.errors import SolverError
from rsc.kernel import model as kernel
from rsc.kernel import springs
from rsc.kernel.contact import Surfaces
from rsc.kernel.tableau import METHODS, table_of
from rsc.simulation.columns import damping_of, directed_columns, rotor_columns, same_all_round
from rsc.simulation.driven import with_drive
from rsc.simulation.flight import with_flight
from rsc.simulation.following import changes, corners, reference
from rsc.simulation.lines import longer
from rsc.simulation.races import with_races
from rsc.simulation.real_modes import RealModes, modes_of, with_mass
from rsc.simulation.shapes import times
from rsc.simulation.sliding import signed
from rsc.simulation.states import with_states
from rsc.simulation.stiffness import fastest, resolved_angle
from rsc.simulation.stretches import stretch_length
from rsc.simulation.tolerances import quarter_period, rotor_reference, rtol_of, switch_tol_of
from rsc.system.system import ContactLaw

# kind of spring for each class of contact law
SPRINGS = {ContactLaw: springs.Linear}
# fraction of the contact frequency: lower bound for a rotor on hardly any support, so that velocities have a tolerance
SLOWEST = 1e-4


@dataclass(frozen=True)
class Packed:
    """A Model with the transformations between the kernel's and the scene's coordinates."""

    model: kernel.Model
    rotor: RealModes
    stator: RealModes
    method: tuple  # selects the method in the kernel
    state_size: np.ndarray  # (p,) what the kernel multiplies the first-order states of rotor and stator with
    grounded: str = ""  # why a scene that would gain by exact flight does not use it

    @property
    def width(self):
        """Tuple whose length is the width of the kernel's vectors."""
        return (0.0,) * self.model.stiffness.shape[0]

    @property
    def longest_step(self):
        """Length in s of the longest step or block of flight."""
        flight = self.model.flight
        block = flight.shortest * 2 ** (flight.count - 1) / flight.unit_rate if flight else 0.0
        return max(self.model.h_max, block)

    @property
    def n_numbers(self):
        """Numbers 2n of the scene's coordinates, states and races; the kernel may have more (lines.py)."""
        races = sum(len(contact.race) > 0 for contact in self.model.contacts)
        return 2 * (self._bodies + len(self.state_size) + races)

    @property
    def _bodies(self):
        """Number of coordinates of both bodies."""
        return len(self.rotor.shape) + len(self.stator.shape)

    def kept(self, vector):
        """The part of a kernel vector that is state: without the padding."""
        return np.append(vector[: self.n_numbers], vector[-2:]) if self.model.drive else vector[: self.n_numbers].copy()

    def restored(self, kept):
        """The kernel vector for the numbers from `kept`."""
        vector = longer(kept[: self.n_numbers], self.model.stiffness.size)
        if self.model.drive:
            vector[-2:] = kept[self.n_numbers :]
        return vector

    def physical(self, x):
        """Kernel coordinates (k, 2n), rows contiguous -> complex displacements of rotor (k, N) and stator (k, M) in m, a single
        mode without a copy; or rates of the coordinates -> velocities in m/s."""
        pairs = x.view(np.complex128)
        n, m = self.rotor.shape.shape[0], self.stator.shape.shape[0]
        return times(self.rotor.shape, pairs[:, :n]), times(self.stator.shape, pairs[:, n : n + m])

    def states(self, x):
        """Kernel coordinates of samples (k, 2n), or velocities -> complex first-order states (k, p) of rotor, then stator."""
        n = self._bodies
        return x.view(np.complex128)[:, n : n + len(self.state_size)] / self.state_size

    def with_states(self, v, states):
        """Kernel velocities (2n,) with the complex first-order states (p,) of rotor, then stator."""
        v, n = v.copy(), self._bodies
        v.view(complex)[n : n + len(states)] = self.state_size * states
        return v

    def modal(self, rotor, stator):
        """Complex displacements (or velocities) of rotor (N,) and stator (M,) -> kernel coordinates (2n,)."""
        x = np.zeros(self.model.stiffness.shape[0])
        pairs, n, m = x.view(complex), len(rotor), len(stator)
        pairs[:n], pairs[n : n + m] = self.rotor.inverse @ rotor, self.stator.inverse @ stator
        return x


def pack(system, solver, sample_rate, fill=False):
    """Model of a scene.

    Parameters
    ----------
    system : System
        Matrices in SI units and rad/s.
    solver : scene solver settings (method, rtol, divergence in gaps, max_steps).
    sample_rate : float
        Output samples per second.
    fill : bool
        Whether the coordinates are padded to a class size (`in_classes`).
    """
    (packed,) = _limited([_packed(system, solver, sample_rate)])
    return _extended(packed, system, fill)


def pack_all(systems, scenes):
    """`pack` for systems of scenes with equal numbers of coordinates, with the same bits, padded `in_classes`: list of Packed."""
    pairs = list(zip(systems, scenes, strict=True))
    packed = _limited([_packed(system, scene.solver, scene.output.rate) for system, scene in pairs])
    made = []
    for part, (system, scene) in zip(packed, pairs, strict=True):
        made.append(_extended(part, system, in_classes(scene)))
    return made


def in_classes(scene):
    """Whether the coordinates of a scene are padded to a class size (lines.py): where a reduction has chosen their number."""
    return "reduced" in (scene.rotor.model, scene.stator.model)


def _extended(packed, system, fill):
    """Append to the coordinates of the bodies races, then padding, then the drive; and add the weights of exact flight."""
    model, grounded = with_flight(with_drive(with_races(packed.model, system), system, fill))
    return replace(packed, model=model, grounded=grounded)


def _packed(full, solver, sample_rate):
    """Packed without stability limits and with exactly the coordinates of the scene."""
    system = reference(full)
    name = method_of(solver)
    method = _stages(name)
    rotor = modes_of(system.rotor.mass, _mechanical(system.rotor), system.contacts[0].rotor)
    stator = modes_of(system.stator.mass, _mechanical(system.stator), system.contacts[0].stator)
    share = np.ones(system.n_rotor + system.n_stator)
    by_component = changes(full) or any(body.directed for body in system.bodies)
    if by_component:
        share[system.n_rotor :] = stator.reference_mass / rotor.reference_mass
        stator = with_mass(stator, rotor.reference_mass)
    gap = min(contact.gap for contact in system.contacts)
    omega = np.sqrt(np.maximum(np.concatenate([rotor.stiffness, stator.stiffness]), 0.0))  # rigid-body modes: rounding
    diagonal, columns = damping_of(system, rotor, stator, by_component)
    forces = np.array([system.rotor.unbalance, system.rotor.unbalance_euler - system.rotor.unbalance, system.rotor.load])
    unbalance, euler, load = _rotor_pairs(forces, rotor, system.n_stator)
    mass = np.repeat([rotor.reference_mass, stator.reference_mass], [system.n_rotor, system.n_stator])
    contacts = tuple(_contact_data(contact, rotor, stator, mass, (name, system.sense)) for contact in system.contacts)
    omega_contact = max(_frequency(contact, mass) for contact in contacts)
    omega_ref = max(np.sqrt(rotor_reference(system)), SLOWEST * omega_contact)
    rtol = rtol_of(system, omega_ref, solver.rtol, omega_contact)
    h_max = float(quarter_period(system, omega_ref))
    model = kernel.Model(
        stiffness=_twice(-np.concatenate([rotor.stiffness, stator.stiffness])),
        damping=_twice(-diagonal),
        unbalance=unbalance,
        euler=euler,
        load=load,
        weight=_twice(mass),
        scale_x=_twice(gap**2 * share),
        scale_v=_twice((gap * np.maximum(omega, omega_ref)) ** 2 * share),
        gyroscopic_columns=rotor_columns(system, system.rotor.gyroscopic, rotor),
        rotating_columns=rotor_columns(system, system.rotor.rotating_damping, rotor),
        **directed_columns(full, system, columns, rotor, stator) if by_component else same_all_round(columns),
        contacts=contacts,
        drive=(),
        flight=(),
        states=(),
        watched_rows=_watched_rows(system, rotor, stator),
        watched_gaps=np.array([clearance.gap for clearance in system.clearances]) if system.clearances else (),
        **_corners(full),
        rtol=rtol,
        switch_tol=switch_tol_of(rtol),
        h_max=h_max,
        stable_open=0.0,
        stable_closing=0.0,
        stable_opening=0.0,
        resolved_angle=resolved_angle(rtol, method),
        divergence=float(solver.divergence * gap),
        max_steps=int(solver.max_steps),
        sample_rate=float(sample_rate),
        stretch=stretch_length(h_max, float(system.schedule_time[-1])),
    )
    modes = rotor.rounded(), stator.rounded()
    model, state_size = with_states(model, full, modes, gap, max(omega_ref, np.sqrt(rotor_reference(full.at_start))))
    return Packed(model, *modes, method, state_size)


def _mechanical(body):
    """Stiffness (n, n) of a body without the part that belongs to first-order states, whose modes the kernel uses."""
    return body.stiffness if body.state_stiffness is None else body.stiffness - body.state_stiffness


def _stages(name):
    """The tuple that selects a method in the kernel; SolverError for a method that no longer exists."""
    if name not in METHODS:  # possible in a stored scene
        raise SolverError(f"solver.method = {name!r} no longer exists; use one of {', '.join(METHODS)}")
    return METHODS[name]


def _contact_data(contact, rotor, stator, mass, run):
    """ContactData in modes with masses (n,); run = (method, sense of rotation)."""
    row = np.concatenate([rotor.shape.T @ contact.rotor, -stator.shape.T @ contact.stator])
    return kernel.ContactData(
        contact_row=_twice(row),
        rotor_row=_twice(np.where(np.arange(len(row)) < len(rotor.shape), row, 0.0)),
        force_row=_twice(-row / mass),
        ring=(float(np.real(contact.ring)), float(np.imag(contact.ring))) if contact.ring else (),
        offset=(float(np.real(contact.offset)), float(np.imag(contact.offset))) if contact.offset else (),
        gap=float(contact.gap),
        surfaces=_surfaces(signed(contact.law, run[1]), contact.gap, run[0]),
        race=(),
    )


def _frequency(contact, mass):
    """Natural frequency of a closed contact, rad/s."""
    return np.sqrt(springs.limit(contact.surfaces.spring) * float((contact.contact_row[::2] ** 2 / mass).sum()))


def _watched_rows(system, rotor, stator):
    """Rows (k, 2n) in modes for the clearances, like those of contacts; () without any."""
    if not system.clearances:
        return ()
    rows = [np.concatenate([rotor.shape.T @ place.rotor, -stator.shape.T @ place.stator]) for place in system.clearances]
    return np.array(rows, dtype=float).repeat(2, axis=1)


def _surfaces(law, gap, method):
    """Constants of the contacting surfaces; SolverError for a law that the kernel, or this method, does not support."""
    if type(law) not in SPRINGS:
        raise SolverError(f"the kernel has no spring for the contact law {type(law).__name__} (see CONTRIBUTING.md)")
    kind = SPRINGS[type(law)]
    if table_of(METHODS[method]) is None and springs.ROOMS[kind].coefficient is None:
        raise SolverError(f"solver.method = {method!r}: the contact law {type(law).__name__} has no series; use rk45")
    return Surfaces(
        springs.ROOMS[kind].of(law, gap),
        damping=float(law.damping),
        friction=float(law.friction),
        radius=0.0 if law.diameter is None else 0.5 * float(law.diameter),
        slip_velocity=1.0 if law.slip_velocity is None else float(law.slip_velocity),
    )


def _limited(packed):
    """Fill in the longest stable steps."""
    for method in {part.method for part in packed}:
        places = [i for i, part in enumerate(packed) if part.method == method]
        steps, _ = fastest([packed[i].model for i in places], method)
        for i, (free, spring, damper) in zip(places, steps.tolist(), strict=True):
            model = packed[i].model._replace(stable_open=free, stable_closing=spring, stable_opening=damper)
            packed[i] = replace(packed[i], model=model)
    return packed


def method_of(solver):
    """The method of solver settings; "auto" is taylor8, the fastest or nearly so at any error."""
    return "taylor8" if solver.method == "auto" else solver.method


def _corners(full):
    """The corners of the schedule, including the knots that it passes."""
    time, speed, interval = corners(full)
    return {
        "corner_time": np.array(time, dtype=float),
        "corner_speed": np.array(speed, dtype=float) / (2.0 * np.pi),
        "corner_interval": interval,
    }


def _twice(values):
    return np.asarray(values, dtype=float).repeat(2)


def _rotor_pairs(forces, rotor, n_stator):
    """Complex forces on the rotor (k, N) as accelerations in modes, (k, 2n); zero on the stator."""
    pairs = np.zeros((len(forces), len(rotor.shape) + n_stator), dtype=complex)
    pairs[:, : len(rotor.shape)] = forces @ rotor.shape / rotor.reference_mass
    return pairs.view(float)
