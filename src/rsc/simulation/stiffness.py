"""Longest stable step, and which motion of the scene limits it.

For z = h lambda one step multiplies a motion e^{lambda t} by R(z) and estimates its error as |E(z)|, both polynomials of the
method. Contact direction and friction are frozen: radial spring and damper alone determine the fast time scales.
"""

import math
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from rsc.kernel.contact import limits_of
from rsc.kernel.tableau import table_of
from rsc.simulation.driven import interval_at

# bound of |R|: no noticeable growth within the few hundred steps until stiffness is detected
BOUND = 1.001
RAY = np.arange(1, 201) / 20.0
LONGER = 1.5  # gain in step length from which taylor8 pays off: its steps cost more than those of rk45
# directions evaluated at a time: more would not fit into the processor's cache
PART = 64


@dataclass(frozen=True)
class Limit:
    """The motion that limits the stable step most, in one contact state."""

    step: float  # s, longest stable step
    eigenvalue: complex  # 1/s
    cause: str
    is_mode: bool = False  # a mode of a body, not the contact

    def advice(self, longer):
        """One sentence on what limits the steps and what to change.

        longer : float, factor by which "taylor8" could lengthen the steps; 1 for taylor8 itself
        """
        change = f'solver.method = "taylor8" takes {longer:.1f} times longer steps' if longer > LONGER else ""
        other = "remove it by a reduced model" if self.is_mode else "a softer or slower one allows longer steps"
        return (
            f"{self.cause} limits the step ({1e3 * self.step:.3g} ms, a tenth of what accuracy needs, or less): "
            f"this costs running time, not accuracy; {change + '; or ' if change else ''}{other}"
        )


def stable_steps(eigenvalues, method):
    """Longest steps in s under which motions e^{eigenvalue t} do not grow numerically; infinite if unstable or static."""
    size = abs(eigenvalues)
    still = (size == 0.0) | (eigenvalues.real > 1e-9 * size)
    size = np.where(size > 0.0, size, 1.0)
    directions = (eigenvalues / size).ravel()
    longest = np.concatenate([_longest(directions[i : i + PART], method) for i in range(0, directions.size, PART)])
    return np.where(still, np.inf, longest.reshape(size.shape) / size)


def _longest(directions, method):
    """Largest |z| along complex directions (n,) up to which |R(z)| stays within BOUND."""
    z = RAY * directions[:, None]
    growth = np.zeros_like(z)
    for coefficient in _polynomials(method)[0]:  # in place: the copies of numpy.polyval would be noticeable in ensembles
        growth *= z
        growth += coefficient
    grows = growth.real**2 + growth.imag**2 > BOUND**2
    return np.where(grows.any(axis=-1), RAY[grows.argmax(axis=-1)], RAY[-1])


@lru_cache
def resolved_angle(rtol, method):
    """Largest h omega at which the error estimate of an oscillation of unit amplitude is below rtol."""
    angles, log_errors = _oscillation_errors(method)
    return float(np.interp(np.log(rtol), log_errors, angles))


@cache
def _oscillation_errors(method):
    """(h omega, log of the error estimate there of an oscillation of unit amplitude)."""
    angles = np.geomspace(1e-3, 3.0, 200)
    errors = abs(np.polyval(_polynomials(method)[1], 1j * angles))
    return angles, np.log(np.maximum.accumulate(errors))


@cache
def _polynomials(method):
    """Coefficients, highest power first, of R(z) = 1 + z b (1 - z A)^-1 1 and E(z) = z e (1 - z A)^-1 1; for a Taylor series of
    the truncated e^z and its last term."""
    n_stages, table = len(method), table_of(method)
    if table is None:
        growth = [1.0 / math.factorial(k) for k in range(n_stages, -1, -1)]
        return growth, growth[:1] + [0.0] * n_stages
    matrix = np.zeros((n_stages + 1, n_stages + 1))
    for i, row in enumerate((*table.rows, table.weights), start=1):
        matrix[i, : len(row)] = row
    powers = [np.linalg.matrix_power(matrix, k) @ np.ones(n_stages + 1) for k in range(n_stages + 1)]
    growth = [np.append(table.weights, 0.0) @ p for p in powers[::-1]] + [1.0]
    error = [np.array(table.error) @ p for p in powers[::-1]] + [0.0]
    return growth, error


def limits(model, sizes, method):
    """{"open": Limit, "closing": Limit, "opening": Limit}: without contact, with contact spring, with spring and damper.

    Parameters: kernel Model, sizes (N, M) of its bodies, method.
    """
    free, spring, damper = zip(*(part[0].tolist() for part in fastest([model], method)), strict=True)
    number = 1 + int(np.argmin(abs(abs(free[1]) - np.sqrt(abs(model.stiffness[::2])))))
    rates = _rates_of_states(model)
    body, number = ("rotor", number) if number <= sizes[0] else ("stator", number - sizes[0])
    mode = f"mode {number} of the {body} at {_hertz(free[1])}"
    if rates.size and abs(free[1].imag) < abs(free[1].real) and abs(rates - free[1]).min() < 0.5 * abs(free[1]):
        mode = f"a first-order state (time constant {1e3 / abs(free[1]):.3g} ms)"
    k_c = f"the contact spring k_C (contact.stiffness, {_hertz(spring[1])})"
    b_c = f"the contact damper b_C (time constant {1e3 / abs(damper[1]):.3g} ms)"
    by_mode = spring[0] > 0.5 * free[0]
    closing = Limit(*spring, mode if by_mode else k_c, by_mode)
    by_spring = damper[0] > 0.5 * spring[0]
    opening = Limit(*damper, closing.cause if by_spring else b_c, by_spring and by_mode)
    return {"open": Limit(*free, mode, True), "closing": closing, "opening": opening}


def _rates_of_states(model):
    """Eigenvalues (p,) in 1/s of the first-order states alone; empty without."""
    if not model.states:
        return np.zeros(0)
    places = np.flatnonzero(model.states.mark[::2])
    return np.linalg.eigvals(model.states.columns[0, 0, places][:, 2 * places].T)


def _hertz(eigenvalue):
    return f"{abs(eigenvalue) / (2.0 * np.pi):.4g} Hz"


def fastest(models, method):
    """(longest stable steps, eigenvalues), both (models, 3), of the motions that limit the step most: without contact, with
    contact spring, with spring and damper. Parameters: kernel Models with equal numbers of coordinates, their method."""
    steps, eigenvalues = np.empty((len(models), 3)), np.empty((len(models), 3), dtype=complex)
    turning = np.array([_turns(model) for model in models])
    by_component = np.array([len(model.stiffness_columns) + len(model.following_stiffness) > 0 for model in models])
    for chosen in (turning & ~by_component, ~turning & ~by_component):  # bits independent of other models
        if chosen.any():
            steps[chosen], eigenvalues[chosen] = _fastest([models[i] for i in np.flatnonzero(chosen)], method)
    for i in np.flatnonzero(by_component):
        of_places = [_shortest(_of_components(models[i], *place), False, method) for place in _places(models[i])]
        longest, motions = map(np.array, zip(*of_places, strict=True))
        place = longest.argmin(axis=0)[None]
        steps[i], eigenvalues[i] = (np.take_along_axis(part, place, 0)[0] for part in (longest, motions))
    return steps, eigenvalues


def _places(model):
    """[(speed in Hz, interval between knots)] at which stability is evaluated: the highest speed, or with speed-dependent
    coefficients the lowest and highest one of each interval."""
    if not len(model.following_stiffness):
        return [(model.corner_speed[abs(model.corner_speed).argmax()], 0)]
    if model.drive:
        fastest = abs(model.corner_speed).max()
        ends = [0.0, *(knot for knot in model.drive.knots / (2.0 * np.pi) if 0.0 < knot < fastest), fastest]
        middles = 2.0 * np.pi * (np.array(ends[1:]) + ends[:-1]) / 2.0
        return [(speed, interval_at(model, middle)) for i, middle in enumerate(middles) for speed in ends[i : i + 2]]
    places = {}
    for i, interval in enumerate(model.corner_interval[:-1].astype(int).tolist()):
        ends = model.corner_speed[i : i + 2].tolist()
        low, high = places.get(interval, (ends[0], ends[0]))
        places[interval] = min(low, *ends), max(high, *ends)
    return [(speed, interval) for interval, ends in places.items() for speed in ends]


def _turns(model):
    return len(model.gyroscopic_columns) > 0 or len(model.rotating_columns) > 0


def _fastest(models, method):
    """`fastest` for models that all have gyroscopics or rotating damping, or all have none and real matrices."""
    n, turning = models[0].stiffness.size // 2, _turns(models[0])
    matrices = np.zeros((len(models), 3, 2 * n, 2 * n), dtype=complex if turning else float)
    axes = np.arange(n)
    matrices[:, :, axes, axes + n] = 1.0
    for whole, model in zip(matrices, models, strict=True):
        whole[:, axes + n, axes] = model.stiffness[::2]
        whole[:, axes + n, axes + n] = model.damping[::2]
        for contact in model.contacts:
            _press(whole, contact, contact.force_row[::2, None] * contact.contact_row[::2])
        if len(model.damping_columns):
            whole[:, n:, n:] += model.damping_columns[:, ::2].T
        speed = 2.0j * np.pi * abs(model.corner_speed).max()
        if len(model.gyroscopic_columns):
            whole[:, n:, n:] += speed * model.gyroscopic_columns[:, ::2].T
        if model.states:
            whole[:, n:, n:] += model.states.columns[0, 0, :, ::2].T
            whole[:, n:, :n] += model.states.columns[0, 1, :, ::2].T
        if len(model.rotating_columns):
            whole[:, n:, n:] -= model.rotating_columns[:, ::2].T
            whole[:, n:, :n] += speed * model.rotating_columns[:, ::2].T
    return _shortest(matrices, turning, method)


def _press(matrices, contact, pushed):
    """Add a contact to the three matrices: to the second with its spring, to the third with its damper, too; pushed:
    accelerations per force and deflection."""
    n = len(pushed)
    stiffness, damping = limits_of(contact.surfaces)
    matrices[1:, n:, :n] += stiffness * pushed
    matrices[2, n:, n:] += damping * pushed


def _shortest(matrices, turning, method):
    """(shortest stable step, its eigenvalue), both (..., 3), of matrices (..., 3, k, k), real unless turning."""
    eigenvalues = np.linalg.eigvals(matrices).astype(complex)
    # both eigenvalues of a conjugate pair need the same step
    steps, one = np.full(eigenvalues.shape, np.inf), (eigenvalues.imag >= 0.0) | turning
    steps[one] = stable_steps(eigenvalues[one], method)
    place = steps.argmin(axis=-1)[..., None]
    return np.take_along_axis(steps, place, -1)[..., 0], np.take_along_axis(eigenvalues, place, -1)[..., 0]


def _of_components(model, speed, interval):
    """The three matrices of a model with skew or anisotropic springs or dampers for the components y and z, real (3, 4n, 4n), at
    a speed in Hz."""
    n = model.stiffness.size
    matrices = np.zeros((3, 2 * n, 2 * n))
    matrices[:, :n, n:] = np.eye(n)
    speed = 2.0 * np.pi * speed
    stiffness, damping = (component_matrix(columns) for columns in _columns_at(model, speed, interval))
    matrices[:, n:, :n] = np.diag(model.stiffness) + stiffness
    matrices[:, n:, n:] = np.diag(model.damping) + damping
    if len(model.gyroscopic_columns):
        matrices[:, n:, n:] += speed * np.kron(model.gyroscopic_columns[:, ::2].T, [[0.0, -1.0], [1.0, 0.0]])
    if len(model.rotating_columns):
        matrices[:, n:, n:] -= np.kron(model.rotating_columns[:, ::2].T, np.eye(2))
        matrices[:, n:, :n] += speed * np.kron(model.rotating_columns[:, ::2].T, [[0.0, -1.0], [1.0, 0.0]])
    if model.states:
        matrices[:, n:, n:] += np.kron(model.states.columns[0, 0, :, ::2].T, np.eye(2))
        matrices[:, n:, :n] += np.kron(model.states.columns[0, 1, :, ::2].T, np.eye(2))
    for contact in model.contacts:
        _press(matrices, contact, np.kron(np.outer(contact.force_row[::2], contact.contact_row[::2]), np.eye(2)))
    return matrices


def _columns_at(model, Omega, interval):
    """Columns of stiffness and damping by component at a speed in rad/s, in an interval between knots."""
    width = model.stiffness.size
    made = []
    for name in ("stiffness", "damping"):
        constant, following = (getattr(model, f"{name}_columns"), getattr(model, f"following_{name}"))
        columns = constant if len(constant) else np.zeros((width, width))
        made.append(following[interval, 0] + Omega * following[interval, 1] if len(following) else columns)
    return made


def spring_matrix(model, interval, speed):
    """Matrix (2n, 2n) by component of the springs not in `Model.stiffness`, in an interval between knots at a speed in Hz; None
    if there are none."""
    if not len(model.stiffness_columns) + len(model.following_stiffness):
        return None
    return component_matrix(_columns_at(model, 2.0 * np.pi * speed, interval)[0])


def component_matrix(columns):
    """Matrix (2n, 2n) in the components (y_0, z_0, y_1, ...) from columns in the kernel's layout (`vec.times_components`)."""
    n = len(columns) // 2
    matrix = np.empty((n, 2, n, 2))
    for c in range(2):
        matrix[:, c, :, c], matrix[:, c, :, 1 - c] = (part[:, c::2].T for part in columns.reshape(2, n, 2 * n))
    return matrix.reshape(2 * n, 2 * n)
