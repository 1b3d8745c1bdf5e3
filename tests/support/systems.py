"""Systems for the tests of the analytic rooms: reference scenes, random systems, and the equations of physics.md."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np

from rsc.scene.scene import load_scene
from rsc.system.assemble import assemble
from rsc.system.system import System

REFERENCE = Path(__file__).parents[2] / "data" / "reference"
TWO_PI = 2.0 * np.pi


def reference_scene(name):
    return load_scene(REFERENCE / f"{name}.toml")


def reference(name):
    """System of a reference scene."""
    return assemble(reference_scene(name))


def expected(name):
    """Expected numbers of a reference scene."""
    return tomllib.loads((REFERENCE / f"{name}.expected.toml").read_text())


def changed(system, **values):
    """A System with some fields changed."""
    return replace(system, **values)


def make_system(rotor, stator, contact, **more):
    """System of rotor = (mass, damping, stiffness, gyroscopic), stator = (mass, damping, stiffness) matrices and
    contact = (rotor coordinate, stator coordinate, friction, stiffness)."""
    n_rotor, n_stator = len(rotor[0]), len(stator[0])
    i_rotor, i_stator, friction, stiffness = contact
    ecc = np.zeros(n_rotor)
    ecc[i_rotor] = 5e-5
    fields = {
        **dict(zip(("mass_r", "damping_r", "stiffness_r", "gyroscopic_r"), rotor, strict=True)),
        **dict(zip(("mass_s", "damping_s", "stiffness_s"), stator, strict=True)),
        "contact_r": np.eye(n_rotor)[i_rotor],
        "contact_s": np.eye(n_stator)[i_stator] if n_stator else np.zeros(0),
        "unbalance": (rotor[0] - rotor[3]) @ ecc + 0j,
        "unbalance_euler": rotor[0] @ ecc + 0j,
        "load": np.zeros(n_rotor, complex),
        "gap": 1e-3,
        "friction": friction,
        "contact_stiffness": stiffness,
        "contact_damping": 0.0,
        "ring_ecc": 0j,
        "diameter": None,
        "slip_velocity": None,
        "schedule_time": np.array([0.0, 1.0]),
        "schedule_speed": np.array([TWO_PI * 50.0, TWO_PI * 50.0]),
    }
    return System(**{**fields, **more})


def jeffcott(mass=1.0, damping=20.0, stiffness=4e4, friction=0.3):
    """Laval rotor in a rigid wall (M = 0), practically rigid contact."""
    one, none = np.ones((1, 1)), np.zeros((0, 0))
    rotor = (mass * one, damping * one, stiffness * one, 0.0 * one)
    return make_system(rotor, (none, none, none), (0, 0, friction, np.inf))


def random_system(rng, most=6, least_stator=0):
    """1..most rotor and least_stator..most stator coordinates, random symmetric matrices, damping ratios 0.1 % to 30 %."""
    n_rotor, n_stator = rng.integers(1, most + 1), rng.integers(least_stator, most + 1)
    ratio = 10.0 ** rng.uniform(-3.0, -0.5)
    rotor = random_body(rng, n_rotor, ratio)
    stator = random_body(rng, n_stator, ratio * 10.0 ** rng.uniform(-0.5, 0.5))
    polar = rng.uniform(0.0, 2.0, n_rotor) * np.diag(rotor[0]) * (np.arange(n_rotor) > 0)
    friction = 10.0 ** rng.uniform(-2.0, 0.0)
    contact = (0, rng.integers(0, max(n_stator, 1)), friction, 10.0 ** rng.uniform(6.0, 8.0))
    return make_system((*rotor, np.diag(polar)), stator, contact)


def with_skew(rng, system, size=0.3, driving=0.1):
    """The same system with random symmetric skew matrices: Q and S, S as large as `driving` of the stiffness, either sign."""
    fields = {}
    for name in ("r", "s"):
        stiffness, damping = getattr(system, f"stiffness_{name}"), getattr(system, f"damping_{name}")
        fields[f"skew_stiffness_{name}"] = driving * _random_like(rng, stiffness)
        fields[f"skew_damping_{name}"] = size * _random_like(rng, damping)
    return changed(system, **fields)


def _random_like(rng, matrix):
    """A random symmetric matrix with entries as large as those of one, by its diagonal."""
    size = np.sqrt(np.abs(np.diag(matrix)))
    noise = rng.normal(size=matrix.shape)
    return size[:, None] * 0.5 * (noise + noise.T) * size


def skew_part(system, body):
    """(i Q, i S) of "r" or "s", zero where there is none."""
    parts = (getattr(system, f"skew_{kind}_{body}") for kind in ("damping", "stiffness"))
    return tuple(0.0 if part is None else 1j * part for part in parts)


def with_anisotropy(rng, system, size=0.1):
    """The same system with random complex symmetric E and C, as large as `size` of the stiffness and damping."""
    fields = {}
    for name in ("r", "s"):
        for kind in ("stiffness", "damping"):
            matrix = getattr(system, f"{kind}_{name}")
            fields[f"anisotropic_{kind}_{name}"] = size * (_random_like(rng, matrix) + 1j * _random_like(rng, matrix))
    return changed(system, **fields)


def anisotropic_part(system, body):
    """(C, E) of "r" or "s", zero where there is none."""
    none = np.zeros_like(getattr(system, f"mass_{body}"))
    parts = (getattr(system, f"anisotropic_{kind}_{body}") for kind in ("damping", "stiffness"))
    return tuple(none if part is None else part for part in parts)


def random_body(rng, n, ratio):
    if n == 0:
        return (np.zeros((0, 0)),) * 3
    mass = np.diag(10.0 ** rng.uniform(-1.0, 1.0, n))
    omega = TWO_PI * 10.0 ** rng.uniform(0.7, 2.5, n)
    modes, _ = np.linalg.qr(rng.normal(size=(n, n)))
    shape = np.sqrt(mass) @ modes
    damping = shape @ np.diag(2.0 * ratio * omega * rng.uniform(0.3, 3.0, n)) @ shape.T
    stiffness = shape @ np.diag(omega**2) @ shape.T
    return mass, 0.5 * (damping + damping.T), 0.5 * (stiffness + stiffness.T)


def random_rotor(rng):
    """A rotor of 2 to 4 coordinates with gyroscopics in a light, well damped stator of 1 or 2: often two whirls at once."""
    n_rotor, n_stator = int(rng.integers(2, 5)), int(rng.integers(1, 3))
    rotor = random_body(rng, n_rotor, 10.0 ** rng.uniform(-3.0, -1.7))
    mass, damping, stiffness = random_body(rng, n_stator, 10.0 ** rng.uniform(-2.0, -0.7))
    light = 10.0 ** rng.uniform(-2.0, 0.0)
    polar = np.diag(rng.uniform(0.5, 2.0, n_rotor) * np.diag(rotor[0]) * (np.arange(n_rotor) > 0))
    contact = (0, 0, rng.uniform(0.1, 0.5), 1e8)
    return make_system((*rotor, polar), (light * mass, light * damping, light * stiffness), contact)


def scanned_condition(system, Psi, Omega):
    """Im cH / |cH| on many points, from the poles and residues of the first-order form."""
    poles_of_all, shares_of_all = [], []
    for mass, damping, stiffness, contact, body in (
        (system.mass_r, system.damping_r - 1j * Omega * system.gyroscopic_r, system.stiffness_r, system.contact_r, "r"),
        (system.mass_s, system.damping_s + 0j, system.stiffness_s, system.contact_s, "s"),
    ):
        n = len(mass)
        damping, stiffness = (part + skew for part, skew in zip((damping, stiffness), skew_part(system, body), strict=True))
        if n == 0:
            continue
        inverse = np.linalg.inv(mass)
        state = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
        poles, modes = np.linalg.eig(state)
        shares = (contact @ modes[:n]) * np.linalg.solve(modes, np.concatenate([np.zeros(n), inverse @ contact]))
        poles_of_all.append(poles)
        shares_of_all.append(shares)
    pole, share = -1j * np.concatenate(poles_of_all)[:, None], -1j * (1.0 + 1j * system.friction) * np.concatenate(shares_of_all)
    # share / (Psi - pole) in real numbers, which is faster than the quotient
    by_distance, by_one = np.stack([share.real, share.imag]), np.stack([-share.imag, share.real]) * pole.imag.T
    values = np.empty(len(Psi))
    for i in range(0, len(Psi), 2000):  # blocks that stay in the cache
        distance = Psi[i : i + 2000] - pole.real
        inverse = 1.0 / (distance**2 + pole.imag**2)
        re, im = by_distance @ (distance * inverse) + by_one @ inverse
        values[i : i + 2000] = im / np.hypot(re, im)
    return values


def scan_grid(n_points=100_000):
    """Frequencies of a scan, rad/s: both signs, logarithmic from 0.01 Hz to 100 kHz."""
    half = TWO_PI * np.logspace(-2.0, 5.0, n_points // 2)
    return np.concatenate([-half[::-1], half])


def beside_scan(system, Omega, roots, grid):
    """Roots beside the sign changes of a scan: cells with a sign change but no odd number of roots (n, 2), roots (n,) in
    cells with an odd number but no sign change, and roots (n,) that the scan does not see (pairs within one cell).

    The damped condition has no poles: a cell with a sign change holds one root more than an even number, others an even one.
    """
    values = scanned_condition(system, grid, Omega)
    expected_odd = values[:-1] * values[1:] < 0.0
    middle = np.searchsorted(grid, 0.0) - 1  # the cell around 0 is none: a standing deflection is no whirl
    expected_odd[middle] = False
    cells = np.searchsorted(grid, roots) - 1
    inside = (cells >= 0) & (cells < len(grid) - 1) & (cells != middle)
    roots, cells = roots[inside], cells[inside]
    counts = np.bincount(cells, minlength=len(grid) - 1)
    lost = np.flatnonzero(expected_odd & (counts % 2 == 0))
    return (
        np.stack([grid[lost], grid[lost + 1]], axis=1),
        roots[(counts % 2 == 1)[cells] & ~expected_odd[cells]],
        roots[(counts > 1)[cells]],
    )


def contact_force(system, d, d_dot, b_star=None, surface=None):
    """F_C of (7), (10), (11), sigma = +1, or with the speed of the rotor's surface friction that follows the slip; with b_star a
    two-sided damper without clip instead of the one-sided one."""
    direction = d / abs(d)
    distance_dot = (d_dot * np.conj(direction)).real
    penetration = abs(d) - system.gap
    if b_star is not None:
        normal = system.contact_stiffness * penetration + b_star * distance_dot
    elif penetration <= 0.0:
        normal = 0.0
    else:
        normal = max(0.0, system.contact_stiffness * penetration - system.contact_damping * max(-distance_dot, 0.0))
    slip = None if surface is None else surface + (d_dot * np.conj(direction)).imag
    sigma = 1.0 if slip is None else np.clip(slip / system.slip_velocity, -1.0, 1.0)
    return (1.0 + 1j * system.friction * sigma) * normal * direction


def accelerations(system, state, Omega, b_star=None, unbalance=0.0, rolls=False):
    """r'' of (2), (3) at constant speed; state = (r_R, r_S, r_R', r_S') complex, in the fixed frame. rolls: friction follows the
    slip."""
    n_rotor, n_stator = system.n_rotor, system.n_stator
    r_rotor, r_stator, v_rotor, v_stator = np.split(state, np.cumsum([n_rotor, n_stator, n_rotor]))
    d = system.contact_r @ r_rotor - system.contact_s @ r_stator
    d_dot = system.contact_r @ v_rotor - system.contact_s @ v_stator
    force = contact_force(system, d, d_dot, b_star, 0.5 * Omega * system.diameter if rolls else None)
    (Q_r, S_r), (Q_s, S_s) = (skew_part(system, body) for body in ("r", "s"))
    damping = system.damping_r - 1j * Omega * system.gyroscopic_r + Q_r
    (C_r, E_r), (C_s, E_s) = (anisotropic_part(system, body) for body in ("r", "s"))
    load_r = unbalance * system.unbalance * Omega**2 - system.contact_r * force - C_r @ v_rotor.conj() - E_r @ r_rotor.conj()
    a_rotor = np.linalg.solve(system.mass_r, load_r - damping @ v_rotor - (system.stiffness_r + S_r) @ r_rotor)
    force_s = system.contact_s * force - C_s @ v_stator.conj() - E_s @ r_stator.conj()
    load_s = force_s - (system.damping_s + Q_s) @ v_stator - (system.stiffness_s + S_s) @ r_stator
    return np.concatenate([a_rotor, np.linalg.solve(system.mass_s, load_s)])


def fixed_frame_rate(system, Omega, unbalance=0.0):
    """state -> state' of (2), (3) for `solve_ivp`: like `accelerations`, with the matrices inverted once."""
    n_rotor, n_stator = system.n_rotor, system.n_stator
    n = n_rotor + n_stator
    inverse = np.zeros((n, n))
    inverse[:n_rotor, :n_rotor] = np.linalg.inv(system.mass_r)
    inverse[n_rotor:, n_rotor:] = np.linalg.inv(system.mass_s)
    linear = np.zeros((2 * n, 2 * n), complex)
    linear[:n, n:] = np.eye(n)
    for part, stiffness, damping, body in (
        (slice(0, n_rotor), system.stiffness_r, system.damping_r - 1j * Omega * system.gyroscopic_r, "r"),
        (slice(n_rotor, n), system.stiffness_s, system.damping_s, "s"),
    ):
        damping, stiffness = (matrix + skew for matrix, skew in zip((damping, stiffness), skew_part(system, body), strict=True))
        rows = slice(n + part.start, n + part.stop)
        linear[rows, part] = -inverse[part, part] @ stiffness
        linear[rows, n + part.start : n + part.stop] = -inverse[part, part] @ damping
    relative = np.concatenate([system.contact_r, -system.contact_s])
    push = np.concatenate([np.zeros(n), inverse @ relative])
    drive = np.zeros(2 * n, complex)
    drive[n : n + n_rotor] = unbalance * Omega**2 * (inverse[:n_rotor, :n_rotor] @ system.unbalance)
    pick = np.zeros((2, 2 * n))
    pick[0, :n] = pick[1, n:] = relative

    def rate(time, state):
        d, d_dot = pick @ state
        turning = np.exp(1j * Omega * time) * drive if unbalance else 0.0
        return linear @ state - push * contact_force(system, complex(d), complex(d_dot)) + turning

    return rate
