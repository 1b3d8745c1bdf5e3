"""An engine of another family for whole scenes: LSODA (multistep, Adams and BDF) on docs/users/physics.md section 2, written
anew, with no knowledge of contact switches; and the lines of its motion by a padded FFT and a parabola."""

import numpy as np
from numba import njit
from scipy.integrate import odeint

RTOL = 1e-9
STEPS_PER_CONTACT_PERIOD = 10.0
PADDING, MOST_LINES, NEAR_BINS = 8, 60, 2.0
OFF_LINE = 0.15  # bins: a line further from where it should be is not it alone
BAND = 3  # bins on either side of a line that belong to it
SIDE_LOBE = 10.0 ** (-31.5 / 20.0)  # of a Hann window, the first, 2.36 bins away; they fall with the third power of the distance


@njit
def rate(u, t, c, matrices):
    """u' of u = pairs (y, z) of r, s, r', s'; see `constants` for c and matrices."""
    n = matrices.shape[2]
    speed = c[0] + c[1] * (t - c[2])
    phi = c[3] + c[0] * (t - c[2]) + 0.5 * c[1] * (t - c[2]) ** 2
    turn = complex(np.cos(phi), np.sin(phi))
    ring = complex(c[4], c[5]) * turn
    d, v = ring, 1j * speed * ring
    for i in range(n):
        d += matrices[3, 0, i] * complex(u[2 * i], u[2 * i + 1])
        v += matrices[3, 0, i] * complex(u[2 * (n + i)], u[2 * (n + i) + 1])
    distance = abs(d)
    force = 0j
    if distance > c[6]:
        along = v * d.conjugate() / distance
        opening = max(-along.real, 0.0)
        normal = max(0.0, c[8] * (distance - c[6]) - c[9] * opening)
        sign = 1.0
        if c[10] > 0.0:
            sign = min(1.0, max(-1.0, (0.5 * speed * c[10] + along.imag) / c[11]))
        force = complex(1.0, c[7] * sign) * normal * d / distance
    out = np.empty_like(u)
    for i in range(n):
        out[2 * i], out[2 * i + 1] = u[2 * (n + i)], u[2 * (n + i) + 1]
        a = complex(matrices[4, 0, i], matrices[4, 1, i]) * speed**2 - 1j * c[1] * complex(matrices[4, 2, i], matrices[4, 3, i])
        a = a * turn + complex(matrices[4, 4, i], matrices[4, 5, i]) - matrices[3, 1, i] * force
        for k in range(n):
            r_dot = complex(u[2 * (n + k)], u[2 * (n + k) + 1])
            a -= matrices[0, i, k] * complex(u[2 * k], u[2 * k + 1])
            a -= (matrices[1, i, k] - 1j * speed * matrices[2, i, k]) * r_dot
        out[2 * (n + i)], out[2 * (n + i) + 1] = a.real, a.imag
    return out


def constants(system):
    """(c, matrices) of a System for `rate`: numbers with the speed of its first segment; matrices (5, n, n) or larger: M^-1 K,
    M^-1 B, M^-1 G, then the rows l and M^-1 l, then the rows of M^-1 times unbalance, its Euler part and load (y, z each)."""
    n_r, n = system.n_rotor, system.n_rotor + system.n_stator
    side = max(n, 6)
    inverse, stiffness, damping, gyroscopic = np.zeros((4, n, n))
    inverse[:n_r, :n_r] = np.linalg.inv(system.mass_r)
    stiffness[:n_r, :n_r], damping[:n_r, :n_r], gyroscopic[:n_r, :n_r] = system.stiffness_r, system.damping_r, system.gyroscopic_r
    if system.n_stator:
        inverse[n_r:, n_r:] = np.linalg.inv(system.mass_s)
        stiffness[n_r:, n_r:], damping[n_r:, n_r:] = system.stiffness_s, system.damping_s
    relative = np.concatenate([system.contact_r, -system.contact_s])
    packed = np.zeros((5, side, n))
    for i, matrix in enumerate((stiffness, damping, gyroscopic)):
        packed[i, :n] = inverse @ matrix
    packed[3, 0], packed[3, 1] = relative, inverse @ relative
    for i, vector in enumerate((system.unbalance, system.unbalance_euler, system.load)):
        scaled = inverse[:, :n_r] @ vector
        packed[4, 2 * i], packed[4, 2 * i + 1] = scaled.real, scaled.imag
    c = np.array([
        0.0, 0.0, 0.0, 0.0, system.ring_ecc.real, system.ring_ecc.imag, system.gap, system.friction, system.contact_stiffness,
        system.contact_damping, system.diameter or 0.0, system.slip_velocity or 1.0,
    ])  # fmt: skip
    return c, packed


def integrate(system, start, times):
    """(rotor, stator), complex (n_time, N) and (n_time, M), by LSODA; NaN from where it gives up."""
    c, packed = constants(system)
    n = packed.shape[2]
    parts = (start.rotor, start.stator, start.rotor_velocity, start.stator_velocity)
    u = np.concatenate(parts).astype(complex).view(float).copy()
    contact_rate = np.sqrt(system.contact_stiffness * (packed[3, 0] @ packed[3, 1]))
    h_max = 2.0 * np.pi / contact_rate / STEPS_PER_CONTACT_PERIOD
    atol = RTOL * system.gap * np.repeat([1.0, contact_rate], 2 * n)
    rows = np.full((len(times), 4 * n), np.nan)
    rows[0], phi = u, 0.0
    corners, speeds = system.schedule_time, system.schedule_speed
    for t0, t1, s0, s1 in zip(corners[:-1], corners[1:], speeds[:-1], speeds[1:], strict=True):
        c[:4] = s0, (s1 - s0) / (t1 - t0), t0, phi
        phi += 0.5 * (s0 + s1) * (t1 - t0)
        inside = np.flatnonzero((times > t0) & (times <= t1))
        grid = np.unique(np.concatenate([[t0], times[inside], [min(t1, times[-1])]]))
        if len(grid) < 2:
            break
        found, facts = odeint(rate, u, grid, args=(c, packed), rtol=RTOL, atol=atol, hmax=h_max, mxstep=200_000, full_output=True)
        good = facts["message"].startswith("Integration successful") and np.isfinite(found).all()
        if not good:
            break
        rows[inside] = found[np.searchsorted(grid, times[inside])]
        u = found[-1]
    q = np.ascontiguousarray(rows).view(complex)
    return q[:, : system.n_rotor], q[:, system.n_rotor : n]


def lines(piece, sample_rate, chirp=0.0):
    """(frequency, amplitude) of the lines of a piece of a complex signal, strongest first; a circle of radius A reads A.

    Hann window, zeros behind, a parabola through the logarithms of three points; local maxima that may be side lobes of stronger
    lines are left out. chirp: of a line that moves, its change over the piece in bins; its frequency is that in the middle.
    """
    n = len(piece)
    window = np.hanning(n + 1)[:n]
    tau = (np.arange(n) - 0.5 * n) / n
    turned = piece * window * np.exp(-1j * np.pi * chirp * tau**2) if chirp else piece * window
    amplitude = np.abs(np.fft.fftshift(np.fft.fft(turned, PADDING * n))) / window.sum()
    frequency = np.fft.fftshift(np.fft.fftfreq(PADDING * n, 1.0 / sample_rate))
    i = 1 + np.flatnonzero((amplitude[1:-1] > amplitude[:-2]) & (amplitude[1:-1] >= amplitude[2:]))
    i = i[np.argsort(-amplitude[i])][:MOST_LINES]
    low, middle, high = (np.log(np.maximum(amplitude[i + k], 1e-300)) for k in (-1, 0, 1))
    bend = low - 2.0 * middle + high
    shift = np.where(bend < 0.0, 0.5 * (low - high) / np.where(bend < 0.0, bend, 1.0), 0.0)
    height = np.exp(middle - 0.25 * (low - high) * shift)
    place = frequency[i] + shift * (frequency[1] - frequency[0])
    real = height > 2.0 * np.tril(side_lobe(np.abs(place[:, None] - place) * n / sample_rate) * height, -1).sum(axis=1)
    return place[real], height[real]


def side_lobe(bins):
    """Height of the side lobes of a Hann window this many bins from a line, as a share of the line; within 2 bins that of the
    first."""
    return SIDE_LOBE * (2.36 / np.maximum(bins, 2.0)) ** 3


def line_near(piece, sample_rate, wanted, chirp):
    """(frequency, least and largest amplitude) of the strongest line next to a frequency; NaN where there is none.

    A line that grows, decays or moves during the window has no one amplitude: the least is the height of its peak, the largest
    what a line at rest with the power of the band around it has.
    """
    frequency, amplitude = lines(piece, sample_rate, chirp)
    near = np.flatnonzero(np.abs(frequency - wanted) <= max(NEAR_BINS * sample_rate / len(piece), 0.03 * abs(wanted)))
    if not near.size:
        return np.nan, np.nan, np.nan
    at, height = frequency[near[0]], amplitude[near[0]]
    n = len(piece)
    window = np.hanning(n + 1)[:n]
    turned = piece * window * np.exp(-2j * np.pi * at * np.arange(n) / sample_rate)
    power = np.abs(np.fft.fft(turned, PADDING * n)[np.r_[: BAND * PADDING + 1, -BAND * PADDING : 0]]) ** 2
    return at, height, max(height, np.sqrt(power.sum() / (PADDING * n * (window**2).sum())))


def synchronous_line(piece, phi):
    """(amplitude, what side lobes of other lines may add) of the line that turns with the angle phi, (n,) rad; what may be added
    is infinite where another line is too close to tell them apart."""
    n = len(piece)
    window = np.hanning(n + 1)[:n]
    turned = piece * np.exp(-1j * phi)
    value = abs((turned * window).sum()) / window.sum()
    frequency, amplitude = lines(turned, float(n))  # in bins, the wanted line at zero
    if not (np.abs(frequency) < OFF_LINE).any() or (np.abs(frequency[np.abs(frequency) >= OFF_LINE]) < 3.0).any():
        return value, np.inf
    others = np.abs(frequency) >= OFF_LINE
    return value, float((side_lobe(np.abs(frequency[others])) * amplitude[others]).sum())
