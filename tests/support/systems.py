"""Systems for the tests of the analytic rooms: reference scenes, random systems, and the equations of physics.md."""

import tomllib
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from rsc.scene.scene import load_scene
from rsc.system.assemble import assemble
from rsc.system.body import Body
from rsc.system.system import ContactLaw, System, SystemContact

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


SKEW = ("skew_stiffness_r", "skew_damping_r", "skew_stiffness_s", "skew_damping_s")
ANISOTROPIC = ("anisotropic_stiffness_r", "anisotropic_damping_r", "anisotropic_stiffness_s", "anisotropic_damping_s")
_OF_LAW = {"friction": "friction", "contact_stiffness": "stiffness", "contact_damping": "damping", "diameter": "diameter",
           "slip_velocity": "slip_velocity"}  # fmt: skip
_OF_CONTACT = {"gap": "gap", "ring_ecc": "ring"}


def _place(name):
    """Where a System has a quantity by its short name: ("rotor", "mass") of "mass_r", ("contact", "gap") of "gap", ..."""
    if name in _OF_LAW:
        return "law", _OF_LAW[name]
    if name in _OF_CONTACT:
        return "contact", _OF_CONTACT[name]
    if name.startswith("schedule"):
        return "", name
    body = "stator" if name.endswith("_s") else "rotor"
    return body, name.removesuffix("_r").removesuffix("_s")


def quantity(system, name):
    """A quantity of a System by its short name: "mass_r", "anisotropic_damping_s", "unbalance", "friction", "gap", ..."""
    where, field = _place(name)
    return getattr(getattr(system, where) if where else system, field)


def quantities(system):
    """Every quantity of a System of one contact, of its bodies and of its law: ("rotor", "mass"): M_R, ..."""
    parts = {"rotor": system.rotor, "stator": system.stator, "contact": system.contact, "law": system.law, "drive": system}
    whole = {"drive": ("rotor", "stator", "contacts"), "contact": ("law", "name")}
    return {
        (part, field.name): getattr(values, field.name)
        for part, values in parts.items() for field in fields(values) if field.name not in whole.get(part, ())
    }  # fmt: skip


def changed(system, **values):
    """A System with some quantities changed, by their short names (`quantity`)."""
    for name, new in values.items():
        where, field = _place(name)
        part = {field: new}
        if where == "law":
            where, part = "contact", {"law": replace(system.law, **part)}
        if where == "contact":
            where, part = "", {"contacts": (replace(system.contact, **part),)}
        system = replace(system, **({where: replace(getattr(system, where), **part)} if where else part))
        if field == "contact" and where:  # the row of a body is that of the contact
            system = replace(system, contacts=(replace(system.contact, **{where: new}),))
    return system


def make_system(rotor, stator, contact, **more):
    """System of rotor = (mass, damping, stiffness, gyroscopic), stator = (mass, damping, stiffness) matrices and
    contact = (rotor coordinate, stator coordinate, friction, stiffness)."""
    n_rotor, n_stator = len(rotor[0]), len(stator[0])
    i_rotor, i_stator, friction, stiffness = contact
    ecc = np.zeros(n_rotor)
    ecc[i_rotor] = 5e-5
    rows = np.eye(n_rotor)[i_rotor], np.eye(n_stator)[i_stator] if n_stator else np.zeros(0)
    imposed = {
        "unbalance": (rotor[0] - rotor[3]) @ ecc + 0j,
        "unbalance_euler": rotor[0] @ ecc + 0j,
        "load": np.zeros(n_rotor, complex),
    }
    system = System(
        Body(*rotor[:3], rows[0], rotor[3], **imposed),
        Body(*stator, rows[1], np.zeros((n_stator, n_stator))),
        (SystemContact(ContactLaw(stiffness, 0.0, friction), 1e-3, *rows),),
        np.array([0.0, 1.0]),
        np.array([TWO_PI * 50.0, TWO_PI * 50.0]),
    )
    return changed(system, **more)


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
        stiffness, damping = quantity(system, f"stiffness_{name}"), quantity(system, f"damping_{name}")
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
    parts = (quantity(system, f"skew_{kind}_{body}") for kind in ("damping", "stiffness"))
    return tuple(0.0 if part is None else 1j * part for part in parts)


def with_anisotropy(rng, system, size=0.1):
    """The same system with random complex symmetric E and C, as large as `size` of the stiffness and damping."""
    fields = {}
    for name in ("r", "s"):
        for kind in ("stiffness", "damping"):
            matrix = quantity(system, f"{kind}_{name}")
            fields[f"anisotropic_{kind}_{name}"] = size * (_random_like(rng, matrix) + 1j * _random_like(rng, matrix))
    return changed(system, **fields)


def anisotropic_part(system, body):
    """(C, E) of "r" or "s", zero where there is none."""
    none = np.zeros_like(quantity(system, f"mass_{body}"))
    parts = (quantity(system, f"anisotropic_{kind}_{body}") for kind in ("damping", "stiffness"))
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
        (part.mass, part.damping - 1j * Omega * part.gyroscopic, part.stiffness, part.contact, name)
        for name, part in (("r", system.rotor), ("s", system.stator))
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
    c = 1.0 + 1j * system.law.friction
    pole, share = -1j * np.concatenate(poles_of_all)[:, None], -1j * c * np.concatenate(shares_of_all)
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
    penetration = abs(d) - system.contact.gap
    if b_star is not None:
        normal = system.law.stiffness * penetration + b_star * distance_dot
    elif penetration <= 0.0:
        normal = 0.0
    else:
        normal = max(0.0, system.law.stiffness * penetration - system.law.damping * max(-distance_dot, 0.0))
    slip = None if surface is None else surface + (d_dot * np.conj(direction)).imag
    sigma = 1.0 if slip is None else np.clip(slip / system.law.slip_velocity, -1.0, 1.0)
    return (1.0 + 1j * system.law.friction * sigma) * normal * direction


def accelerations(system, state, Omega, b_star=None, unbalance=0.0, rolls=False):
    """r'' of (2), (3) at constant speed; state = (r_R, r_S, r_R', r_S') complex, in the fixed frame. rolls: friction follows the
    slip."""
    n_rotor, n_stator = system.n_rotor, system.n_stator
    r_rotor, r_stator, v_rotor, v_stator = np.split(state, np.cumsum([n_rotor, n_stator, n_rotor]))
    d = system.rotor.contact @ r_rotor - system.stator.contact @ r_stator
    d_dot = system.rotor.contact @ v_rotor - system.stator.contact @ v_stator
    force = contact_force(system, d, d_dot, b_star, 0.5 * Omega * system.law.diameter if rolls else None)
    (Q_r, S_r), (Q_s, S_s) = (skew_part(system, body) for body in ("r", "s"))
    damping = system.rotor.damping - 1j * Omega * system.rotor.gyroscopic + Q_r
    (C_r, E_r), (C_s, E_s) = (anisotropic_part(system, body) for body in ("r", "s"))
    load_r = unbalance * system.rotor.unbalance * Omega**2 - system.rotor.contact * force
    load_r = load_r - C_r @ v_rotor.conj() - E_r @ r_rotor.conj()
    if system.rotor.rotating_damping is not None:
        load_r = load_r - system.rotor.rotating_damping @ (v_rotor - 1j * Omega * r_rotor)
    a_rotor = np.linalg.solve(system.rotor.mass, load_r - damping @ v_rotor - (system.rotor.stiffness + S_r) @ r_rotor)
    force_s = system.stator.contact * force - C_s @ v_stator.conj() - E_s @ r_stator.conj()
    load_s = force_s - (system.stator.damping + Q_s) @ v_stator - (system.stator.stiffness + S_s) @ r_stator
    return np.concatenate([a_rotor, np.linalg.solve(system.stator.mass, load_s)])


def fixed_frame_rate(system, Omega, unbalance=0.0):
    """state -> state' of (2), (3) for `solve_ivp`: like `accelerations`, with the matrices inverted once."""
    n_rotor, n_stator = system.n_rotor, system.n_stator
    n = n_rotor + n_stator
    inverse = np.zeros((n, n))
    inverse[:n_rotor, :n_rotor] = np.linalg.inv(system.rotor.mass)
    inverse[n_rotor:, n_rotor:] = np.linalg.inv(system.stator.mass)
    linear = np.zeros((2 * n, 2 * n), complex)
    linear[:n, n:] = np.eye(n)
    for part, stiffness, damping, body in (
        (slice(0, n_rotor), system.rotor.stiffness, system.rotor.damping - 1j * Omega * system.rotor.gyroscopic, "r"),
        (slice(n_rotor, n), system.stator.stiffness, system.stator.damping, "s"),
    ):
        damping, stiffness = (matrix + skew for matrix, skew in zip((damping, stiffness), skew_part(system, body), strict=True))
        rows = slice(n + part.start, n + part.stop)
        linear[rows, part] = -inverse[part, part] @ stiffness
        linear[rows, n + part.start : n + part.stop] = -inverse[part, part] @ damping
    relative = np.concatenate([system.rotor.contact, -system.stator.contact])
    push = np.concatenate([np.zeros(n), inverse @ relative])
    drive = np.zeros(2 * n, complex)
    drive[n : n + n_rotor] = unbalance * Omega**2 * (inverse[:n_rotor, :n_rotor] @ system.rotor.unbalance)
    pick = np.zeros((2, 2 * n))
    pick[0, :n] = pick[1, n:] = relative

    def rate(time, state):
        d, d_dot = pick @ state
        turning = np.exp(1j * Omega * time) * drive if unbalance else 0.0
        return linear @ state - push * contact_force(system, complex(d), complex(d_dot)) + turning

    return rate
