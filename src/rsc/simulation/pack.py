"""System -> kernel Model: real modes of rotor and stator separately, scaled to metres, and packed arrays.

In real modes the stiffness is diagonal, and so is modal or Rayleigh damping; only what remains full (other damping, gyroscopics)
needs the kernel's matrices. The modes of each body are normalised to the mass of its contact coordinate, so that every coordinate
of the kernel is a length and one absolute tolerance, rtol times the gap, fits all. With skew or anisotropic springs, whose work
the ledger books together with that of the unbalance using the rotor's mass, the stator's modes are normalised to that mass as
well and its tolerances scaled. The modes are refined in extended precision, where available, and rounded once at the end: errors
of the eigensolver, relative to the highest frequency, would otherwise perturb the low modes by much more than rounding.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from rsc.errors import SolverError
from rsc.kernel import model as kernel
from rsc.kernel import springs
from rsc.kernel.contact import Surfaces
from rsc.kernel.tableau import METHODS, table_of
from rsc.simulation.driven import with_drive
from rsc.simulation.flight import with_flight
from rsc.simulation.following import additions, changes, corners, lines_between, of_bearings, reference
from rsc.simulation.lines import longer, on_lines
from rsc.simulation.races import with_races
from rsc.simulation.shapes import times
from rsc.simulation.sliding import signed
from rsc.simulation.states import stiffness_at, with_states
from rsc.simulation.stiffness import fastest, resolved_angle
from rsc.simulation.stretches import stretch_length
from rsc.system.system import ContactLaw

# kind of spring for each class of contact law
SPRINGS = {ContactLaw: springs.Linear}
# off-diagonal entries below this fraction of the diagonal are rounding, not physics
ROUNDING = 1e-12
# corrections of modes, each of which squares the error, and the largest entry of a valid correction
REFINEMENTS, LARGE_TURN = 2, 1e-3
# fraction of the contact frequency: lower bound for a rotor on hardly any support, so that velocities have a tolerance
SLOWEST = 1e-4
# rad/s, from which the natural frequency of a rotor in a magnetic bearing is looked for, in this many looks
FASTEST, LOOKS = 1e4, 6


@dataclass(frozen=True)
class RealModes:
    """Real modes of one body: r = shape @ x, every x a length; x = inverse @ r."""

    shape: np.ndarray  # (n, n)
    inverse: np.ndarray  # (n, n)
    stiffness: np.ndarray  # (n,) omega^2, 1/s^2
    reference_mass: float  # kg

    def rounded(self):
        """These modes in double precision."""
        parts = (np.asarray(part, dtype=float) for part in (self.shape, self.inverse, self.stiffness))
        return RealModes(*parts, self.reference_mass)


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
    rotor = _modes(system.rotor.mass, _mechanical(system.rotor), system.contacts[0].rotor)
    stator = _modes(system.stator.mass, _mechanical(system.stator), system.contacts[0].stator)
    share = np.ones(system.n_rotor + system.n_stator)
    by_component = changes(full) or any(body.directed for body in system.bodies)
    if by_component:
        share[system.n_rotor :] = stator.reference_mass / rotor.reference_mass
        stator = _with_mass(stator, rotor.reference_mass)
    gap = min(contact.gap for contact in system.contacts)
    omega = np.sqrt(np.maximum(np.concatenate([rotor.stiffness, stator.stiffness]), 0.0))  # rigid-body modes: rounding
    diagonal, columns = _damping(system, rotor, stator, by_component)
    forces = np.array([system.rotor.unbalance, system.rotor.unbalance_euler - system.rotor.unbalance, system.rotor.load])
    unbalance, euler, load = _rotor_pairs(forces, rotor, system.n_stator)
    mass = np.repeat([rotor.reference_mass, stator.reference_mass], [system.n_rotor, system.n_stator])
    contacts = tuple(_contact_data(contact, rotor, stator, mass, (name, system.sense)) for contact in system.contacts)
    omega_contact = max(_frequency(contact, mass) for contact in contacts)
    omega_ref = max(np.sqrt(rotor_reference(system)), SLOWEST * omega_contact)
    rtol = _rtol(system, omega_ref, solver.rtol, omega_contact)
    h_max = float(_quarter_period(system, omega_ref))
    model = kernel.Model(
        stiffness=_twice(-np.concatenate([rotor.stiffness, stator.stiffness])),
        damping=_twice(-diagonal),
        unbalance=unbalance,
        euler=euler,
        load=load,
        weight=_twice(mass),
        scale_x=_twice(gap**2 * share),
        scale_v=_twice((gap * np.maximum(omega, omega_ref)) ** 2 * share),
        gyroscopic_columns=_on_rotor(system, system.rotor.gyroscopic, rotor),
        rotating_columns=_on_rotor(system, system.rotor.rotating_damping, rotor),
        **_directed_columns(full, system, columns, rotor, stator) if by_component else _same_all_round(columns),
        contacts=contacts,
        drive=(),
        flight=(),
        states=(),
        watched_rows=_watched_rows(system, rotor, stator),
        watched_gaps=np.array([clearance.gap for clearance in system.clearances]) if system.clearances else (),
        **_corners(full),
        rtol=rtol,
        switch_tol=_switch_tol(rtol),
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


def _rtol(system, omega, rtol, omega_contact):
    """The requested tolerance, or a tighter one that resolves the contact; omega in rad/s is the frequency of `rotor_reference`,
    omega_contact that of the closed contact.

    Velocities may have errors of rtol gap omega. With a contact frequency omega_c these are small compared with the penetration
    of a whirl, gap (omega/omega_c)^2, only if rtol << omega/omega_c: beyond, the contact chatters and its force is noise
    (maps.csv). Friction that reverses within a slip range is resolved only if rtol gap omega << slip_velocity: beyond, sticking
    is a noise of full friction forces, and a run can be off by a thousand times its tolerance (dozen.csv, S8).
    """
    rtol = min(rtol, 0.03 * omega / omega_contact)
    for contact in system.contacts:
        if contact.law.diameter is not None:
            fastest = omega
            if system.n_stator:
                c = int(contact.stator.argmax())
                fastest = max(omega, np.sqrt(abs(system.stator.stiffness[c, c]) / system.stator.mass[c, c]))
            rtol = min(rtol, 0.01 * contact.law.slip_velocity / (contact.gap * fastest))
    return float(max(rtol, 1e-13))


def _switch_tol(rtol):
    """Allowed overshoot of a switch at the end of a step, in the error norm: a tenth of rtol at 1e-4, a hundredth at 1e-6.

    A tighter bound costs repeated steps if steps are long, hardly any if they are short. Meeting switches late gives the contact
    small impulses, always to the same side, which shows in how long a run-up stays on an unstable whirl
    (tests/literature/test_reference_runs.py).
    """
    return float(max(rtol * min(0.1, 10.0 * np.sqrt(rtol)), 2.0**-52))


def rotor_reference(system):
    """Squared natural frequency, (rad/s)^2, of the rotor's contact coordinate with all others fixed; the largest of several."""
    places = [int(contact.rotor.argmax()) for contact in system.contacts]
    return max(_squared(system.rotor, c) for c in places)


def _squared(body, c):
    """Squared natural frequency of coordinate c alone, from above with the stiffness of first-order states."""
    square = abs(body.stiffness[c, c]) / body.mass[c, c]
    if body.n_states:
        square = FASTEST**2
        for _ in range(LOOKS):
            square = abs(body.stiffness[c, c] + stiffness_at(body, np.sqrt(square))[c, c]) / body.mass[c, c]
    return square


def first_step(packed):
    """Length of the first attempted step, s: safe for the fastest mode with the stiffest contact closed."""
    m = packed.model
    contact = max(
        springs.limit(data.surfaces.spring) * float(np.abs(data.force_row[::2] * data.contact_row[::2]).sum()) for data in
        m.contacts
    )
    omega2 = float(np.abs(m.stiffness).max()) + contact
    return min(0.1 * m.rtol**0.2 / np.sqrt(omega2), m.h_max)


def _quarter_period(system, omega_ref):
    """Longest step in s: a quarter turn, up to which rotations of the stages are accurate (`turn.turned`)."""
    return 0.5 * np.pi / max(omega_ref, system.fastest)


def _modes(mass, stiffness, contact):
    """Modes of one body, normalised to the reference mass; diagonal matrices keep their coordinates."""
    n = mass.shape[0]
    if n == 0:
        return RealModes(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0), 1.0)
    if n == 1:  # the usual case in ensembles of small scenes
        return RealModes(np.ones((1, 1)), np.ones((1, 1)), stiffness[0] / mass[0], float(mass[0, 0]))
    c = int(contact.argmax())
    reference = float(mass[c, c])
    relative = mass / reference
    if _is_diagonal(mass) and _is_diagonal(stiffness):
        shape = np.diag(1.0 / np.sqrt(relative.diagonal()))
        omega2 = stiffness.diagonal() / mass.diagonal()
    else:
        omega2, shape = _refined(stiffness / reference, relative, scipy.linalg.eigh(stiffness / reference, relative)[1])
        # the zero of a rigid-body mode is computed as rounding of either sign
        omega2 = np.where(np.abs(omega2) < ROUNDING * np.abs(omega2).max(), 0.0, omega2)
    return RealModes(shape, shape.T @ relative, omega2, reference)


def _with_mass(modes, mass):
    """The same modes normalised to another mass in kg."""
    size = np.sqrt(mass / modes.reference_mass)
    return RealModes(modes.shape * size, modes.inverse / size, modes.stiffness, mass)


def _refined(stiffness, mass, shape):
    """(omega^2, modes) in extended precision, from modes in double precision.

    With R = 1 - X^T M X and S = X^T K X the correction X E, E_ij = (S_ij + w_j R_ij)/(w_j - w_i), E_ii = R_ii/2, squares the
    error (Ogita and Aishima 2018). For modes so close that E_ij would be large any linear combination is as good: they are only
    made orthogonal, by E_ij = R_ij/2.
    """
    stiffness, mass, shape = (matrix.astype(np.longdouble) for matrix in (stiffness, mass, shape))
    for _ in range(REFINEMENTS):
        missing = np.eye(len(mass)) - shape.T @ mass @ shape
        energy = shape.T @ stiffness @ shape
        omega2 = energy.diagonal() / (1.0 - missing.diagonal())
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = (energy + omega2 * missing) / (omega2 - omega2[:, None])
        small = np.abs(turn) < LARGE_TURN  # false on the diagonal, which is infinite or NaN
        shape = shape + shape @ np.where(small, turn, 0.5 * missing)
    return omega2, shape


def _is_diagonal(matrix):
    return np.count_nonzero(matrix) == np.count_nonzero(matrix.diagonal())


def _damping(system, rotor, stator, by_component):
    """Diagonal (n,) and columns of the rest of M^-1 B in modes, including skew and anisotropic damping."""
    full = _block_diagonal(
        rotor.shape.T @ system.rotor.damping @ rotor.shape / rotor.reference_mass,
        stator.shape.T @ system.stator.damping @ stator.shape / stator.reference_mass,
    )
    diagonal = full.diagonal().copy()
    np.fill_diagonal(full, 0.0)
    if full.any():
        size = np.sqrt(np.abs(diagonal[:, None] * diagonal))
        full[np.abs(full) <= ROUNDING * np.maximum(size, np.abs(diagonal).max())] = 0.0
    if by_component:
        skew, anisotropic = _directed(system, "damping", rotor, stator)
        columns = _by_component(skew - full, anisotropic)
        return diagonal, columns if columns.any() else ()
    return diagonal, _columns(-full)


def _directed(system, kind, rotor, stator):
    """(linear, conjugate), complex (n, n): linear r + conjugate conj(r) is the force per mass in modes due to skew and
    anisotropic "stiffness", or due to the "damping" for r'."""
    parts = {}
    for name in ("skew", "anisotropic"):
        matrices = [getattr(body, f"{name}_{kind}") for body in system.bodies]
        parts[name] = scipy.linalg.block_diag(
            *(
                np.zeros_like(modes.shape) if matrix is None else modes.shape.T @ matrix @ modes.shape / modes.reference_mass
                for matrix, modes in zip(matrices, (rotor, stator), strict=True)
            )
        )
    return -1j * parts["skew"], -parts["anisotropic"]


def _by_component(linear, conjugate):
    """The matrix x -> linear x + conjugate conj(x) for `vec.times_components`, (2n, 2n)."""
    same = np.stack([linear.real + conjugate.real, linear.real - conjugate.real])  # y of y, z of z
    other = np.stack([conjugate.imag - linear.imag, conjugate.imag + linear.imag])  # y of z, z of y
    return on_lines(np.concatenate([part.transpose(2, 1, 0).reshape(len(linear), -1) for part in (same, other)]))


def _corners(full):
    """The corners of the schedule, including the knots that it passes."""
    time, speed, interval = corners(full)
    return {
        "corner_time": np.array(time, dtype=float),
        "corner_speed": np.array(speed, dtype=float) / (2.0 * np.pi),
        "corner_interval": interval,
    }


def _same_all_round(damping):
    """Matrices of a model without skew and anisotropic stiffness, with this damping."""
    return {"damping_columns": damping, "stiffness_columns": (), "following_stiffness": (), "following_damping": ()}


def _directed_columns(full, system, damping, rotor, stator):
    """Matrices of a model by component, including speed-dependent ones; system: the `reference` of the full one."""
    stiffness = _by_component(*_directed(system, "stiffness", rotor, stator))
    made = _same_all_round(damping) | {"stiffness_columns": stiffness}
    if not changes(full):
        return made
    following = _following(full, system, {"stiffness": stiffness, "damping": damping}, rotor)
    made |= {"stiffness_columns": (), "following_stiffness": following[0], "following_damping": following[1]}
    return made | ({"damping_columns": ()} if len(following[1]) else {})


def _following(full, system, columns, rotor):
    """[stiffness, damping] matrices of coefficients that change (`Model`), with the constant ones included; damping () if it is
    constant. system: the `reference` of the full one, columns: its matrices."""
    made, more = [], system.n_stator
    for kind in ("stiffness", "damping"):
        knots = _each_by_component(additions(full, system.rotor, kind, rotor), more) if len(full.knot_speed) else np.zeros(0)
        bearings = _each_by_component(of_bearings(full, kind, rotor), more) if full.switched else np.zeros(0)
        if kind == "damping" and not (knots.any() or bearings.any()):
            made.append(())
            continue
        constant = columns[kind] if len(columns[kind]) else 0.0
        width = 2 * (system.n_rotor + more)
        if len(knots):
            lines = lines_between(full.knot_speed, knots + constant)
        else:
            lines = np.zeros((1, 2, width, width))
            lines[0, 0] += constant
        for part in bearings[::-1]:  # those that are switched off later are still there
            earlier = lines[: len(full.knot_speed) + 1].copy()
            earlier[:, 0] += part
            lines = np.concatenate([earlier, lines])
        made.append(on_lines(lines.reshape(-1, lines.shape[-1])).reshape(lines.shape))
    return made


def _each_by_component(parts, more):
    """`_by_component` of pairs of matrices (k, N, N), with `more` coordinates of the stator."""
    pads = ((0, 0), (0, more), (0, more))
    return np.array([_by_component(*pair) for pair in zip(*(np.pad(part, pads) for part in parts), strict=True)])


def _on_rotor(system, matrix, rotor):
    """Columns of a rotor matrix per mass, in modes; () if zero or None."""
    if matrix is None or not matrix.any():
        return ()
    matrix = rotor.shape.T @ matrix @ rotor.shape / rotor.reference_mass
    return _columns(_block_diagonal(matrix, np.zeros_like(system.stator.mass)))


def _block_diagonal(first, second):
    """Two square matrices along the diagonal; SciPy's function takes ten times as long, noticeable in ensembles of small
    scenes."""
    n, m = first.shape[0], second.shape[0]
    matrix = np.zeros((n + m, n + m))
    matrix[:n, :n], matrix[n:, n:] = first, second
    return matrix


def _columns(matrix):
    """Columns with every entry twice, (n, 2n); () for a zero matrix."""
    if not matrix.any():
        return ()
    return on_lines(matrix.T.repeat(2, axis=1))


def _twice(values):
    return np.asarray(values, dtype=float).repeat(2)


def _rotor_pairs(forces, rotor, n_stator):
    """Complex forces on the rotor (k, N) as accelerations in modes, (k, 2n); zero on the stator."""
    pairs = np.zeros((len(forces), len(rotor.shape) + n_stator), dtype=complex)
    pairs[:, : len(rotor.shape)] = forces @ rotor.shape / rotor.reference_mass
    return pairs.view(float)
