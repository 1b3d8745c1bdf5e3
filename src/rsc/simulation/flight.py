"""Who flies, and the weights of flight: exact motion of linear coordinates between contacts (`rsc.kernel.flight`).

Without contact every coordinate is a damped oscillator of its own, x'' = K x + C x' + f(t), with K, C <= 0 and with everything
that couples it to others in f. Where f is the polynomial of degree 4 through its values at five nodes of a block, x and x' at any
time are sums of x_0, x_0' and those values; the weights depend on K, C and the lengths of block and time alone.

Lengths are counted in units: a unit is a sample of the output or 1/2, 1/4, ... of one. Blocks last `shortest` units or 2, 4, 8
times as many.
"""

import numpy as np

from rsc.kernel.model import NODES, FlightData, rows_before
from rsc.simulation.lines import on_lines
from rsc.simulation.stiffness import component_matrix

# angle in rad by which the shaft turns, or half of that by which the slowest mode swings, in the longest block
ANGLE = 0.5
LENGTHS, UNITS = 4, 8  # lengths of blocks, and units in the longest where those are not shorter than need be
MOST_SHORTEST = 3  # power of two of the units in the shortest block: the weights of a longest one must stay in the cache
# times longer than a stable step the longest block would be, and has to be where a power of two or the modes cut it short
LIMITED, LEAST = 16.0, 8.0
OUT_OF_SCALE = 1e6  # the same, from which on no run in contact could end: such a scene is refused, flight or not
CONTRACTION = 0.5  # of the sweep over the nodes, per sweep
SWEEPS = 16  # of a random start, after which its growth tells the spectral radius
GROWTH = 10.0  # of a free motion in a block
# a fourth derivative leaves at most so much of the fourth power of a step between a motion and the cubic through its ends
CUBIC = 1.0 / 384.0
TAYLOR = 14  # terms of an exponential whose exponent is at most 1/2
_N_STATE, _N_INTEGRALS = 2, 5
# powers of s, row by row, of the polynomials that are 1 at one node of [0, 1] and 0 at the others
_LAGRANGE = np.array(
    [
        np.poly(np.delete(np.arange(NODES) / 4.0, m))[::-1] / np.prod(m / 4.0 - np.delete(np.arange(NODES) / 4.0, m))
        for m in range(NODES)
    ]
)
_FACTORIALS = np.array([1.0, 1.0, 2.0, 6.0, 24.0])


def with_flight(model):
    """(the model with what it needs to fly, () where it does not; why one that would gain by it does not, "" else)."""
    fastest = 2.0 * np.pi * float(abs(model.corner_speed).max())
    if model.drive or any(contact.race for contact in model.contacts):
        return model, ""
    if len(model.rotating_columns) or len(model.following_stiffness) or model.states:
        return model, ""
    rate = max(fastest, 0.5 * _slowest(model))
    longest = ANGLE / rate if rate > 0.0 else np.inf
    longest = min(longest, UNITS * 0.5 * model.stretch)  # no more than a stretch ends between two times
    if not LIMITED * model.stable_open <= np.sqrt(2.0) * longest <= OUT_OF_SCALE * model.stable_open:
        return model, ""
    flight, why = _flight(model, longest, fastest)
    return model._replace(flight=flight), why


def _slowest(model):
    """The lowest frequency of a coordinate that springs hold, rad/s; 0 of none."""
    held = -model.stiffness[model.stiffness < 0.0]
    return float(np.sqrt(held.min())) if held.size else 0.0


def _grid(model, longest):
    """(units in a sample, units of the shortest block, whether more of them would be needed): powers of two, so that the longest
    block comes near `longest` s."""
    power = round(np.log2(longest * model.sample_rate / UNITS))
    return 2 ** max(-power, 0), 2 ** min(max(power, 0), MOST_SHORTEST), power > MOST_SHORTEST


def _flight(model, longest, fastest):
    """(FlightData or (), why not)."""
    per_sample, shortest, short = _grid(model, longest)
    unit = 1.0 / (model.sample_rate * per_sample)
    stiffness, damping = model.stiffness[::2], model.damping[::2]
    lengths = shortest * unit * 2.0 ** np.arange(LENGTHS)
    count = LENGTHS - _too_long(stiffness, damping, lengths)
    if not _pay(model, lengths[:count]):
        cause = "a mode grows by itself" if count < LENGTHS else "output.rate is too high"
        return (), cause if short or count < LENGTHS else ""
    with np.errstate(over="ignore", invalid="ignore"):
        weights = _weights(stiffness, damping, unit, shortest, count)
    if not np.isfinite(weights).all():
        return (), "its weights are not finite"
    count = _contracting(model, weights, shortest, count, fastest)
    if not _pay(model, lengths[:count]):
        return (), "dampers, gyroscopics or springs couple the modes too strongly"
    weights = on_lines(weights[: rows_before(count, shortest)].repeat(2, axis=1))
    hidden, clear = _hidden(model, unit, fastest)
    return FlightData(weights, hidden, clear, model.sample_rate * per_sample, per_sample, shortest, count), ""


def _pay(model, lengths):
    """Whether the longest of some lengths, s, is so much longer than a stable step that flight gains by it."""
    return len(lengths) > 0 and LEAST * model.stable_open <= lengths[-1]


def _too_long(stiffness, damping, lengths):
    """How many of the lengths (k,) in s let a free motion grow too much, counted from the longest."""
    half = 0.5 * damping
    growth = (half + np.sqrt((half * half + stiffness).astype(complex)).real).max(initial=0.0)
    return int((growth * lengths > np.log(GROWTH)).sum())


def _hidden(model, unit, fastest):
    """(weights (contacts, 2, 2n) of the squares of x and v, m^2: how far a contact deflection may be from the cubic between two
    targets; (contacts,) the largest deflection, m, of which it is sure that nothing touches).

    In a time tau a motion a e^{i w t} is at most |a| m, m = min(2, (w tau)^4/384), from its cubic; for the sum over the modes
    (sum c_i a_i)^2 <= n sum c_i^2 a_i^2 with c_i = |Phi_i| m_i, and a_i^2 <= 2 (|x_i|^2 + |v_i|^2/w_i^2).
    """
    w = np.maximum(np.sqrt(np.maximum(-model.stiffness, 0.0)), max(fastest, 1e-6 / unit))
    n = model.stiffness.size // 2
    missed = np.minimum(2.0, CUBIC * (w * unit) ** 4)
    ring = min(2.0, CUBIC * (fastest * unit) ** 4)
    hidden, clear = np.empty((len(model.contacts), 2, 2 * n)), np.empty(len(model.contacts))
    for i, contact in enumerate(model.contacts):
        hidden[i, 0] = 2.0 * n * (contact.contact_row * missed) ** 2
        hidden[i, 1] = hidden[i, 0] / w**2
        clear[i] = contact.gap - (ring * abs(complex(*contact.ring)) if contact.ring else 0.0)
    return hidden, clear


def _weights(stiffness, damping, unit, shortest, count):
    """All rows (rows_before(count), n), of the longer blocks behind those of the shorter ones.

    Of a block come, for every node but the first, the 14 rows of (x, v) there, then 7 rows for each integral of v times the
    polynomial of a node, then 14 rows for every unit. The 7 rows are the weights of x_0, v_0 and the forces at the nodes.
    """
    parts = min(shortest / 4.0, 1.0)  # units between two times of which all others are multiples
    most = round(shortest * 2 ** (count - 1) / parts)
    exact = _exponentials(stiffness, damping, parts * unit, most)
    free = _free(stiffness, damping, parts * unit * np.arange(1, most + 1))
    rows = []
    for j in range(count):
        units = shortest * 2**j
        steps = round(units / parts)  # of the block
        nodes = steps // 4 * np.arange(1, NODES)
        targets = round(1.0 / parts) * np.arange(1, units + 1)
        # powers of time in steps -> values of the force at the nodes, derivative by derivative
        shapes = _LAGRANGE.T * _FACTORIALS[:, None] / float(steps) ** np.arange(NODES)[:, None]
        moved = _moved(exact, free, shapes, parts * unit, np.concatenate([nodes, targets]) - 1)
        rows += [moved[: len(nodes)].reshape(-1, len(stiffness)), _worked(exact, shapes, steps, parts * unit)]
        rows.append(moved[len(nodes) :].reshape(-1, len(stiffness)))
    return np.concatenate(rows)


def _moved(exact, free, shapes, step, places):
    """Weights (times, 14, n) of x and v at some times."""
    by_force = exact[:, :, :_N_STATE, _N_STATE : _N_STATE + NODES][places]  # (times, n, 2, derivatives)
    by_force = (by_force.reshape(-1, NODES) @ shapes).reshape(by_force.shape)
    by_force *= np.array([[step**2], [step]])
    rows = np.concatenate([free[places], by_force], axis=-1)
    return rows.transpose(0, 2, 3, 1).reshape(len(places), 14, -1)


def _worked(exact, shapes, steps, step):
    """Weights (35, n) of the integrals of v l_m over a block, m the nodes.

    By Cauchy's formula the k-fold integral of v is that of v (T - s)^(k-1)/(k-1)!; l_m(T - s) = l_(4-m)(s) gives the rest.
    """
    last = exact[steps - 1][:, _N_STATE + NODES :]  # (n, 5, state)
    by_force = last[:, :, _N_STATE : _N_STATE + NODES] @ shapes
    rows = np.concatenate([last[:, :, :1], step * last[:, :, 1:_N_STATE], step**2 * by_force], axis=-1)
    return (shapes[:, ::-1].T @ rows).transpose(1, 2, 0).reshape(7 * NODES, -1)


def _exponentials(stiffness, damping, step, most):
    """exp(k A) for k = 1 ... most, (most, n, 12, 12), of x, v, f and its derivatives, and the 1 to 5-fold integrals of v, with
    the time in steps."""
    size = _N_STATE + NODES + _N_INTEGRALS
    matrices = np.zeros((len(stiffness), size, size))
    # v over a speed of its own, so that no entry is the square of an exponent
    speed = np.maximum(np.sqrt(abs(stiffness)) * step, 1.0)
    matrices[:, 0, 1] = speed
    matrices[:, 1, 0], matrices[:, 1, 1], matrices[:, 1, 2] = stiffness * step**2 / speed, damping * step, 1.0 / speed
    for k in range(_N_STATE, _N_STATE + NODES - 1):
        matrices[:, k, k + 1] = 1.0
    first = _N_STATE + NODES
    matrices[:, first, 1] = speed
    for k in range(first + 1, size):
        matrices[:, k, k - 1] = 1.0
    halvings = max(0, int(np.ceil(np.log2(2.0 * max(abs(matrices).sum(axis=-1).max(), 1e-300)))))
    matrices *= 0.5**halvings
    less_one, power = matrices.copy(), matrices
    for k in range(2, TAYLOR + 1):
        power = power @ matrices / k
        less_one += power
    for _ in range(halvings):  # (1 + D)^2 = 1 + (2 D + D^2): small exponents keep their digits
        less_one = 2.0 * less_one + less_one @ less_one
    exact = np.empty((most, *matrices.shape))
    exact[0] = less_one + np.eye(size)
    known = 1
    while known < most:
        more = min(known, most - known)
        exact[known : known + more] = exact[:more] @ exact[known - 1]
        known += more
    exact[:, :, 1] *= speed[:, None]
    exact[..., 1] /= speed[:, None]
    return exact


def _free(stiffness, damping, times):
    """(x, v) by (x_0, v_0) at some times without forces, (times, n, 2, 2), in closed form and extended precision: they are
    multiplied with themselves many thousand times."""
    k, half, t = stiffness.astype(np.longdouble), 0.5 * damping.astype(np.longdouble), times.astype(np.longdouble)[:, None]
    square = half * half + k
    root = np.sqrt(abs(square))
    swings = square < 0.0
    angle = root * t
    # e^{half t} inside: a strongly damped mode's hyperbolic functions alone overflow
    up, down = np.exp(half * t + angle), np.exp(half * t - angle)
    cosine = np.where(swings, np.exp(half * t) * np.cos(angle), 0.5 * (up + down))
    sine = np.where(swings, np.exp(half * t) * np.sin(angle), 0.5 * (up - down))
    small = angle < 1e-4
    inverse = np.where(small, 1.0, root)
    b = np.where(small, np.exp(half * t) * t * (1.0 + np.where(swings, -1.0, 1.0) * angle * angle / 6.0), sine / inverse)
    return np.stack([np.stack([cosine - half * b, b], axis=-1), np.stack([k * b, cosine + half * b], axis=-1)], axis=-2).astype(
        float
    )


def _contracting(model, weights, shortest, count, fastest):
    """How many lengths, from the shortest on, have sweeps that converge."""
    couplings = _couplings(model, fastest)
    while couplings is not None and count > 0:
        first = rows_before(count - 1, shortest)
        if _radius(weights[first : first + 14 * (NODES - 1)].reshape(NODES - 1, 2, 7, -1), *couplings) <= CONTRACTION:
            break
        count -= 1
    return count


def _couplings(model, Omega):
    """Matrices (2n, 2n) of the forces between coordinates by x and by v at a speed in rad/s; None without any."""
    n = model.stiffness.size // 2
    by_x, by_v, by_component = None, np.zeros((2 * n, 2 * n)), len(model.stiffness_columns) > 0
    if by_component:
        by_x = component_matrix(model.stiffness_columns)
    if len(model.damping_columns):
        columns = model.damping_columns
        by_v += component_matrix(columns) if by_component else np.kron(columns[:, ::2].T, np.eye(2))
    if len(model.gyroscopic_columns):
        by_v += Omega * np.kron(model.gyroscopic_columns[:, ::2].T, [[0.0, -1.0], [1.0, 0.0]])
    return (by_x, by_v) if by_x is not None or by_v.any() else None


def _radius(nodes, by_x, by_v):
    """Spectral radius of a sweep over the nodes, whose weights are (4, 2, 7, n), by its powers."""
    force = np.random.default_rng(1).standard_normal((NODES - 1, by_v.shape[0]))
    weights, sizes = nodes.repeat(2, axis=-1)[:, :, 3:], []
    for _ in range(SWEEPS):
        for m in range(NODES - 1):
            v = np.einsum("ki,ki->i", weights[m, 1], force)
            force[m] = by_v @ v if by_x is None else by_v @ v + by_x @ np.einsum("ki,ki->i", weights[m, 0], force)
        sizes.append(np.linalg.norm(force))
        if not 0.0 < sizes[-1] < np.inf:
            return sizes[-1]  # nothing is left, or there is no hope
        force /= sizes[-1]
    return float(np.exp(np.log(sizes[SWEEPS // 2 :]).mean()))
