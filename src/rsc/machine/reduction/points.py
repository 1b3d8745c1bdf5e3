"""Points of frequency, speed and input at which full and reduced body are compared, and the scale of the errors."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from rsc.machine.reduction.body import ComplexArray, FloatArray, n_contacts, solutions
from rsc.machine.reduction.feedback import loop_frequencies
from rsc.machine.reduction.shift import HELD, Shift
from rsc.system.body import Body

# smallest response to which an error is related, relative to that of a single-degree-of-freedom body (see `Scale`)
FLOOR = 0.01
# largest one, beyond which 1/H is compared: at an undamped resonance H has no significant digits
CEILING = 1000.0
N_FREQUENCIES, N_SPEEDS, N_SYNCHRONOUS = 41, 5, 25
# relative distance of a point from its natural frequency, at which the receptance of an undamped body is infinite
BESIDE = 3e-4
# points that are refined, points added on each side at successively half the distance; grid points for a reduced body
N_WORST, N_CLOSER, N_FINE = 8, 7, 400


@dataclass(eq=False)
class Points:
    """Comparison points (Psi, Omega, input column) of full and reduced body, with exact solutions where available."""

    Psi: FloatArray  # (p,) rad/s
    Omega: FloatArray  # (p,) rad/s
    column: np.ndarray  # (p,) int: contact rows (usually only 0), then unbalances, then the load
    exact: ComplexArray  # (p, c + q) displacement of contacts and observers of the full body; NaN where not solved
    states: dict[int, ComplexArray]  # i -> (n,) solution of the full body, where solved
    n_contacts: int = 1  # c

    def solve(self, body: Body, places: np.ndarray) -> None:
        """Solve the full body at the points with these indices."""
        columns = body.inputs[:, self.column[places]]
        for i, x in zip(places, solutions(body, self.Psi[places], self.Omega[places], columns), strict=True):
            self.states[int(i)], self.exact[i] = x, body.outputs @ x

    def joined(self, other: "Points") -> "Points":
        """Both sets of points as one."""
        shifted = {len(self.Psi) + i: x for i, x in other.states.items()}
        names = ("Psi", "Omega", "column", "exact")
        arrays = {name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in names}
        return Points(**arrays, states=self.states | shifted, n_contacts=self.n_contacts)


def points(
    body: Body, reduced: Body, band: tuple[float, float], speeds: tuple[float, float], offset: float, shift: Shift = HELD
) -> Points:
    """Points in the band and at the speeds; an offset between 0 and 1 shifts them between those of offset 0.

    The receptance is sampled at equal spacing, next to undamped natural frequencies, and at peaks and antiresonances of the
    reduced body, of one with first-order states also at the frequencies of its closed loop; for a body with equal forward and
    backward whirl on one side only. Unbalance responses are sampled likewise along the speeds. The load is one point. With
    several contacts each has its own receptance, with a force there. With a shift no frequency is below its lowest one, and the
    load is one that oscillates with the frequency of the shift.
    """
    resonant = body if isinstance(body.mass, np.ndarray) else reduced
    Omegas, beside = compared_speeds(body, speeds, N_SPEEDS, offset), 1.0 + BESIDE * (1.0 + offset)
    low, high = band
    if body.mirrored:
        low, high = (0.0 if low <= 0.0 <= high else min(abs(low), abs(high))), max(abs(low), abs(high))
    rows: list[tuple[FloatArray, FloatArray, int]] = []  # Psi, Omega and column
    c = n_contacts(body)
    for Omega in Omegas:
        natural = natural_frequencies(resonant, Omega, shift) * beside
        if body.n_states:
            natural = np.concatenate([natural, loop_frequencies(reduced, Omega)])
        natural = natural[(natural > low) & (natural < high)]
        for contact in range(c):
            turns = extrema(reduced, (low, high), contact, contact, Omega, shift)
            Psi = shift.off_zero(np.concatenate([between((low, high), N_FREQUENCIES, offset), natural, turns]))
            rows.append((Psi, np.full(Psi.shape, Omega), contact))
    for column in c + np.flatnonzero(body.unbalance.any(axis=0)):
        critical = critical_speeds(resonant, shift) * beside
        critical = critical[(critical > speeds[0]) & (critical < speeds[1])]
        turns = np.concatenate([extrema(reduced, speeds, int(column), contact, None, shift) for contact in range(c)])
        Psi = shift.off_zero(np.concatenate([between(speeds, N_SYNCHRONOUS, offset), critical, turns]))
        rows.append((Psi, Psi, int(column)))
    if body.load.any():
        held = Omegas[:1] if body.knots is None else Omegas
        rows.append((np.full(held.shape, shift.loading), held, c + body.unbalance.shape[1]))
    frequencies, rotor_speeds = (np.concatenate([row[i] for row in rows]) for i in (0, 1))
    columns = np.concatenate([np.full(row[0].shape, row[2]) for row in rows])
    return Points(frequencies, rotor_speeds, columns, np.full((len(columns), len(body.outputs)), np.nan + 0j), {}, c)


def extrema(
    reduced: Body, ends: tuple[float, float], column: int, contact: int, Omega: float | None, shift: Shift = HELD
) -> FloatArray:
    """Frequencies of local extrema of a contact's response to an input, at a speed or (None) synchronous; rad/s."""
    low, high = ends
    row = reduced.outputs[contact]
    if low == high:
        return np.zeros(0)

    def size(Psi: FloatArray) -> FloatArray:
        flat = shift.off_zero(Psi.ravel())
        columns = np.repeat(reduced.inputs[:, column : column + 1], flat.size, axis=1)
        x = solutions(reduced, flat, flat if Omega is None else np.full(flat.shape, Omega), columns)
        return np.abs(x @ row).reshape(Psi.shape)

    grid = np.linspace(low, high, N_FINE)
    values = size(grid)
    change = np.sign(np.diff(values))
    turns = 1 + np.flatnonzero(change[:-1] * change[1:] < 0.0)
    places, sign, step = grid[turns], change[turns - 1], grid[1] - grid[0]
    for _ in range(2):  # refine twice: the extremum among nine neighbouring points
        around = places[:, None] + step * np.linspace(-1.0, 1.0, 9)
        places = np.take_along_axis(around, np.argmax(sign[:, None] * size(around), axis=1)[:, None], axis=1)[:, 0]
        step /= 4.0
    return places * (1.0 + 1e-6)  # not exactly at the peak of an undamped body


def closer(
    around: Points, errors: FloatArray, band: tuple[float, float], speeds: tuple[float, float], shift: Shift = HELD
) -> Points:
    """Points increasingly close to the worst ones, since errors have narrow peaks near resonances and antiresonances.

    errors : (p,) at the points `around`.
    """
    worst = np.argsort(errors)[::-1][:N_WORST]
    worst = worst[around.Psi[worst] != 0.0]
    steps = 0.5 ** np.arange(1, N_CLOSER + 1)
    steps = np.concatenate([-steps, steps])
    contact = (around.column[worst] < around.n_contacts)[:, None]
    width = np.where(contact, (band[1] - band[0]) / (N_FREQUENCIES - 1), (speeds[1] - speeds[0]) / (N_SYNCHRONOUS - 1))
    low, high = np.where(contact, band[0], speeds[0]), np.where(contact, band[1], speeds[1])
    Psi = shift.off_zero(np.clip(around.Psi[worst, None] + width * steps, low, high))
    Omega = np.where(contact, around.Omega[worst, None], Psi)
    column = np.broadcast_to(around.column[worst, None], Psi.shape).ravel()
    exact = np.full((column.size, around.exact.shape[1]), np.nan + 0j)
    return Points(Psi.ravel(), Omega.ravel(), column, exact, {}, around.n_contacts)


def between(ends: tuple[float, float], count: int, offset: float) -> FloatArray:
    """`count` equally spaced points including both ends; with an offset, points between them."""
    low, high = ends
    if low == high:
        return np.array([low])
    if not offset:
        return np.linspace(low, high, count)
    return low + (high - low) * (np.arange(count - 1 + (count == 1)) + offset) / max(count - 1, 1)


def compared_speeds(body: Body, speeds: tuple[float, float], count: int, offset: float) -> FloatArray:
    """Speeds at which a body is compared: equally spaced; a single one if the body does not depend on the speed; with
    speed-dependent coefficients also the knots, so that each of their matrices is covered."""
    if body.knots is None or speeds[0] == speeds[1]:
        return between(speeds, count if body.turns else 1, offset)
    inside = body.knots.speed[(body.knots.speed > speeds[0]) & (body.knots.speed < speeds[1])]
    grid = np.union1d(between(speeds, count, 0.0), inside)
    return grid if not offset else grid[:-1] + offset * np.diff(grid)


def natural_frequencies(body: Body, Omega: float, shift: Shift = HELD) -> FloatArray:
    """Signed undamped natural frequencies at a speed, rad/s; empty for a sparse body. With a shift those above its lowest one."""
    if not isinstance(body.mass, np.ndarray):
        return np.zeros(0)
    if shift.square:
        frequencies = _hardly_held(body.at_knots(Omega), Omega, shift)
        return np.sort(frequencies[np.abs(frequencies) > shift.least])
    mass, gyroscopic = _by_stiffness(body.at_knots(Omega))
    if gyroscopic is None:
        slow = np.sqrt(np.maximum(scipy.linalg.eigvalsh(mass), 0.0))
        slow = np.concatenate([-slow, slow])
    else:
        # (s^2 + s Omega g - m) z = 0 with s = 1/Psi, in coordinates where the stiffness is one
        n = len(mass)
        slow = scipy.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [mass, -Omega * gyroscopic]])).real
    slow = slow[np.abs(slow) > 1e-9 * np.abs(slow).max(initial=0.0)]
    return np.sort(1.0 / slow)


def _hardly_held(body: Body, Omega: float, shift: Shift) -> FloatArray:
    """Natural frequencies of a body that is hardly held, from (1 - w^2 m - Psi^2 m + Psi Omega g) z = 0 in coordinates where the
    stiffness shifted by w^2 is one."""
    mass, gyroscopic = _by_stiffness(replace(body, stiffness=shift.stiffness(body)))
    one = np.eye(len(mass))
    turning = 0.0 * mass if gyroscopic is None else Omega * gyroscopic
    first, second = scipy.linalg.block_diag(one, one), scipy.linalg.block_diag(one, mass)
    first[: len(one)], first[len(one) :] = np.hstack([0.0 * one, one]), np.hstack([one - shift.square * mass, turning])
    return _real(scipy.linalg.eigvals(first, second))


def _real(values: ComplexArray) -> FloatArray:
    """The finite eigenvalues that are real up to rounding."""
    values = values[np.isfinite(values)]
    return np.asarray(values.real[np.abs(values.imag) <= 1e-6 * np.abs(values.real)])


def critical_speeds(body: Body, shift: Shift = HELD) -> FloatArray:
    """Undamped critical speeds, at which a natural frequency equals the speed, rad/s; empty for a sparse body. With
    speed-dependent coefficients, those for the coefficients of each knot."""
    if not isinstance(body.mass, np.ndarray):
        return np.zeros(0)
    if body.knots is not None:
        return np.unique(np.concatenate([critical_speeds(body.at_knots(Omega), shift) for Omega in body.knots.speed]))
    if shift.square:
        turning = 0.0 if body.gyroscopic is None else body.gyroscopic
        squares = _real(scipy.linalg.eigvals(body.stiffness, body.mass - turning))
        return np.sort(np.sqrt(squares[squares > shift.least**2]))
    mass, gyroscopic = _by_stiffness(body)
    slow = scipy.linalg.eigvalsh(mass if gyroscopic is None else mass - gyroscopic)
    return np.sort(1.0 / np.sqrt(slow[slow > 1e-18 * slow.max(initial=0.0)]))


def _by_stiffness(body: Body) -> tuple[FloatArray, FloatArray | None]:
    """Mass and gyroscopic matrix in coordinates where the stiffness is the identity."""
    triangle = scipy.linalg.cholesky(body.stiffness, lower=True)

    def turned(matrix: FloatArray) -> FloatArray:
        half = scipy.linalg.solve_triangular(triangle, matrix, lower=True)
        whole = scipy.linalg.solve_triangular(triangle, half.T, lower=True)
        return 0.5 * (whole + whole.T)

    return turned(body.mass), None if body.gyroscopic is None else turned(body.gyroscopic)


class Scale:
    """Scale of the errors of contact and observer displacements: the response, limited below and above.

    The static flexibility between input and output is at most the geometric mean of their direct flexibilities. A body with one
    degree of freedom, moving like the static deflection of the contact, has it divided by 1 + (Psi / Psi_one)^2, apart from the
    sign of resonance. A response 1/FLOOR times smaller is an antiresonance, where the motion of the contact has no significant
    digits. One CEILING times larger is an undamped resonance, where the smallest shift of the pole is an error of all of H: there
    errors of 1/H are related to the smallest 1/H, (1/H - 1/H_r) CEILING = (H - H_r) / (H H_r / CEILING). With several contacts
    each has such a body for a force at it; for other inputs that with the lowest frequency is used.

    Parameters
    ----------
    body : Body
    inputs : (n, c + m + 1)
        Static deflections due to the inputs.
    outputs : (n, c + q)
        Static deflections due to unit forces at the outputs. With first-order states both are due to forces that grow, in the
        closed loop.
    """

    def __init__(self, body: Body, inputs: ComplexArray, outputs: FloatArray) -> None:
        self._input = np.abs(np.einsum("ij,ij->j", body.inputs.conj(), inputs).real)
        self._output = np.abs(np.einsum("ij,ij->j", body.outputs.T, outputs))
        c = n_contacts(body)
        alone = [np.sqrt(self._output[i] / (shape @ (body.mass @ shape))) for i, shape in enumerate(outputs.T[:c])]
        self._Psi_one = np.array(alone + [min(alone)] * (len(self._input) - c))  # of every input

    def of(self, points: Points, values: ComplexArray, reduced: ComplexArray) -> FloatArray:
        """(p, c + q) scales for displacements (p, c + q) at points, and those of the reduced body."""
        static = np.sqrt(self._input[points.column][:, None] * self._output)
        one = static / (1.0 + (points.Psi / self._Psi_one[points.column])[:, None] ** 2)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            resonant = np.abs(values) * np.abs(reduced) / (CEILING * one)
        beyond = np.abs(values) > CEILING * one
        return np.maximum(np.where(beyond, resonant, np.abs(values)), FLOOR * one)
