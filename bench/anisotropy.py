"""Whirls in supports whose directions differ: isotropic mean, its mirror line, exact, and a time integration of its own.

    python bench/anisotropy.py            prints the tables
    python bench/anisotropy.py --write    keeps them in bench/results/anisotropy.md

The integration shares no code with rsc: real coordinates y and z, classical Runge-Kutta with a fixed step. It starts on the whirl
of the isotropic mean; lines and envelope are those of its last second.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numba
import numpy as np
import scipy.linalg
import scipy.optimize

from rsc.analysis.balance.balance import NotBalanced
from rsc.analysis.balance.elliptic_whirl import elliptic_whirl
from rsc.analysis.paper.anisotropy import mirror_line
from rsc.analysis.paper.whirls import steady_whirls, whirl_shapes

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "support")]

from pages import RESULTS, write_page  # noqa: E402
from ross_rotors import rub_rotor  # noqa: E402
from systems import TWO_PI, anisotropic_part, changed, reference, skew_part  # noqa: E402

STEP, DURATION, LAST = 1e-5, 4.0, 1.0  # s
EVERY = 20  # steps from sample to sample
NEAR = 8.0  # Hz around the whirl of the mean in which the line is looked for
HEADER = (
    "| {} | isotropic mean | its mirror line, share | exact | integrated | envelope, exact and integrated |\n"
    "|---|---|---|---|---|---|"
)


def real_form(system, Omega):
    """Mass-free K and D (2n, 2n) of y and z, the pushes of the contact force (2, 2n), and the row of the distance."""
    blocks = {}
    for body, gyroscopic in (("r", Omega * system.gyroscopic_r), ("s", 0.0)):
        (Q, S), (C, E) = skew_part(system, body), anisotropic_part(system, body)
        mass, damping, stiffness = (getattr(system, f"{name}_{body}") for name in ("mass", "damping", "stiffness"))
        blocks[body] = mass + 0j, damping - 1j * gyroscopic + Q, stiffness + S, C, E
    mass, damping, stiffness, C, E = (scipy.linalg.block_diag(*pair) for pair in zip(*blocks.values(), strict=True))

    def real(own, conjugate):
        plus, minus = own + conjugate, own - conjugate
        return np.block([[plus.real, -minus.imag], [plus.imag, minus.real]])

    inverse = np.linalg.inv(real(mass, 0.0 * mass))
    row = np.concatenate([system.contact_r, -system.contact_s])
    pushes = np.array([inverse @ np.concatenate(pair) for pair in ((row, 0.0 * row), (0.0 * row, row))])
    return inverse @ real(stiffness, E), inverse @ real(damping, C), pushes, row


@numba.njit(error_model="numpy")
def _acceleration(K, D, pushes, row, law, x, v):
    n = row.size
    y, z = row @ x[:n], row @ x[n:]
    distance, gap, stiffness, friction = np.hypot(y, z), law[0], law[1], law[2]
    a = -(K @ x) - D @ v
    if distance > gap:
        force = stiffness * (distance - gap) / distance
        a -= force * ((y - friction * z) * pushes[0] + (z + friction * y) * pushes[1])
    return a


@numba.njit(error_model="numpy")
def _run(K, D, pushes, row, law, x, v, times):
    """Samples (n, 2n) of x at every so many steps, from a step on; times = (step, steps, first, every)."""
    h, steps, first, every = times
    samples = np.zeros(((steps - first) // every, x.size))
    for i in range(steps):
        if i >= first and (i - first) % every == 0 and (i - first) // every < samples.shape[0]:
            samples[(i - first) // every] = x
        a = _acceleration(K, D, pushes, row, law, x, v)
        b = _acceleration(K, D, pushes, row, law, x + 0.5 * h * v, v + 0.5 * h * a)
        c = _acceleration(K, D, pushes, row, law, x + 0.5 * h * v + 0.25 * h * h * a, v + 0.5 * h * b)
        d = _acceleration(K, D, pushes, row, law, x + h * v + 0.5 * h * h * b, v + h * c)
        x = x + h * v + h * h / 6.0 * (a + b + c)
        v = v + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return samples


def integrated(system, Psi, F_N, Omega):
    """(frequency Hz, sizes of the lines at it and at its negative, (smallest, largest) |r|), over the gap; None: no whirl."""
    K, D, pushes, row = real_form(system, Omega)
    law = np.array([system.gap, system.contact_stiffness, system.friction])
    shape = np.concatenate(whirl_shapes(system, Psi, F_N, Omega))
    x, v = (np.concatenate([part.real, part.imag]) for part in (shape, 1j * Psi * shape))
    samples = _run(K, D, pushes, row, law, x, v, (STEP, round(DURATION / STEP), round((DURATION - LAST) / STEP), EVERY))
    n, time = len(row), np.arange(len(samples)) * EVERY * STEP
    r = (samples[:, : system.n_rotor] + 1j * samples[:, n : n + system.n_rotor]) @ system.contact_r / system.gap
    if np.abs(r).max() < 1.0:
        return None
    window = np.hanning(len(r))

    def size(frequency):
        return -abs((r * window) @ np.exp(-1j * TWO_PI * frequency * time))

    grid = Psi / TWO_PI + np.linspace(-NEAR, NEAR, 801)
    best = grid[np.argmin([size(frequency) for frequency in grid])]
    found = scipy.optimize.minimize_scalar(size, bounds=(best - 0.05, best + 0.05), method="bounded", options={"xatol": 1e-8}).x
    lines = np.exp(1j * TWO_PI * found * np.outer(time, (1, -1, 3, -3, 5, -5)))
    sizes = np.abs(np.linalg.lstsq(lines, r, rcond=None)[0])
    return found, sizes[0], sizes[1], (np.abs(r).min(), np.abs(r).max())


def row_of(name, system, speed, near, reduced=None):
    """One row of a table: the whirl of the mean next to a frequency in Hz; the integration may have a smaller system."""
    Omega, gap = TWO_PI * speed, system.gap
    Psi, F_N = steady_whirls(system, Omega)
    i = np.argmin(np.abs(Psi / TWO_PI - near))
    lines = mirror_line(system, Psi[i : i + 1], F_N[i : i + 1], Omega)
    amplitude = abs(whirl_shapes(system, Psi[i], F_N[i], Omega)[0] @ system.contact_r)
    try:
        exact = elliptic_whirl(system, Psi[i] / TWO_PI, speed)
        told = f"{exact.frequency:.3f} Hz, {exact.amplitude / gap:.4f}, {exact.mirror_amplitude / gap:.4f}"
        ends = "{:.4f} to {:.4f}".format(*np.array(exact.envelope) / gap)
    except NotBalanced as problem:
        told, ends = f"none beyond {100.0 * problem.reached:.0f} % of it", "-"
    reduced = system if reduced is None else reduced
    Psi_r, F_r = steady_whirls(reduced, Omega)
    j = np.argmin(np.abs(Psi_r - Psi[i]))
    run = integrated(reduced, Psi_r[j], F_r[j], Omega)
    seen, seen_ends = "no contact", "-"
    if run is not None:
        seen, seen_ends = "{:.3f} Hz, {:.4f}, {:.4f}".format(*run[:3]), "{:.4f} to {:.4f}".format(*run[3])
    share = f"{lines.line[0] / gap:.4f}, {100.0 * lines.share[0]:.1f} %"
    return f"| {name} | {Psi[i] / TWO_PI:.3f} Hz, {amplitude / gap:.4f} | {share} | {told} | {seen} | {ends}; {seen_ends} |"


def reduced(system, modes=9):
    """The rotor on its modes with the softer and with the stiffer bearings: few coordinates that know both directions."""
    parts = [system.stiffness_r + sign * anisotropic_part(system, "r")[1].real for sign in (1.0, -1.0)]
    shapes = [scipy.linalg.eigh(part, system.mass_r, subset_by_index=[0, modes - 1])[1] for part in parts]
    return projected(system, np.hstack([*shapes, np.linalg.solve(parts[0], system.contact_r)[:, None]]))


def projected(system, basis):
    """A System with its rotor on a basis (N, m), made orthonormal in the mass."""
    root = np.linalg.cholesky(system.mass_r).T
    left, sizes, _ = np.linalg.svd(root @ basis / np.linalg.norm(root @ basis, axis=0), full_matrices=False)
    basis = np.linalg.solve(root, left[:, sizes > 1e-6])
    names = ("mass_r", "damping_r", "stiffness_r", "gyroscopic_r", "anisotropic_stiffness_r", "anisotropic_damping_r")
    matrices = {name: getattr(system, name) for name in names}
    vectors = {name: basis.T @ getattr(system, name) for name in ("contact_r", "unbalance", "unbalance_euler", "load")}
    return replace(system, **{k: v if v is None else basis.T @ v @ basis for k, v in matrices.items()}, **vectors)


def tables():
    """Lines of the page."""
    lines = [
        "Frequency, amplitude and amplitude of the mirror line, in gaps, at the contact of the rotor; no contact damping.",
        "",
        "## Laval rotor of data/reference/laval.toml, k (1 +- share), 50 Hz",
        "",
        HEADER.format("share"),
    ]
    laval = changed(reference("laval"), contact_damping=0.0)
    for share in (0.02, 0.05, 0.1, 0.2, 0.4):
        system = changed(laval, anisotropic_stiffness_r=share * laval.stiffness_r + 0j)
        lines.append(row_of(f"{share:g}", system, 50.0, -60.66))
    lines += [
        "",
        "## Rub rotor of ROSS, 68 coordinates, in a stator of two masses (tests/support/ross_rotors.py)",
        "",
        "Bearings as they are, their means and the x values all round, and the x values (1 +- share) in both; the integration",
        "has the rotor on 14 to 19 coordinates.",
    ]
    for speed in (20.0, 50.0):
        lines += ["", HEADER.format(f"bearings, {speed:g} Hz")]
        for bearings, share in (("as they are", 0.0), *(("x", share) for share in (0.02, 0.05, 0.1, 0.2, 0.4))):
            system = rub_rotor(bearings, share)
            lines.append(row_of(f"{bearings} {share or ''}", system, speed, -34.5, reduced(system)))
        for bearings in ("mean", "harmonic", "x"):
            system = rub_rotor(bearings)
            lines.append(row_of(f"{bearings}, all round", system, speed, -34.5, reduced(system)))
    lines += ["", "The bearings as they are, on modes of their isotropic mean alone, exact:", ""]
    system = rub_rotor("as they are")
    for modes in (6, 10, 12, 14, 20, 40):
        small = projected(system, scipy.linalg.eigh(system.stiffness_r, system.mass_r, subset_by_index=[0, modes - 1])[1])
        exact = elliptic_whirl(small, -35.24, 20.0)
        gaps = exact.amplitude / small.gap, exact.mirror_amplitude / small.gap
        lines.append(f"- {modes} modes: {exact.frequency:.3f} Hz, {gaps[0]:.4f}, {gaps[1]:.4f}")
    return lines


def main():
    """Print or keep."""
    text = "\n".join(tables())
    print(text)
    if "--write" in sys.argv:
        title = "Whirls in supports whose directions differ"
        write_page(RESULTS / "anisotropy.md", title, "python bench/anisotropy.py --write", text)


if __name__ == "__main__":
    main()
