"""The whirl condition of several pressed contacts, (W) of docs/users/physics.md section 3.10, and Newton's method on it.

In the frame turning with Psi contact j of the pressed set is deflected by (s_j + N_j/k_j) u_j, u_j = e^{i phi_j}, and pushes with
c_j N_j u_j, c_j = 1 + i mu_j. With H_jk = l_j^T A(Psi)^-1 l_k, l_j = [l_Rj, -l_Sj],

    sum_k H_jk c_k N_k u_k + (s_j + N_j/k_j) u_j = 0   for every j.                                                          (W)

Only differences of the phases count: phi of the first is 0. Unknown are Psi, the N_j and the other phases. Everything here treats
m candidates at once; frequencies are rad/s.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.paper.law import law_at
from rsc.analysis.paper.receptance import dynamic_stiffness, solve_at, transposed
from rsc.system.system import FloatOrArray, System

MET = 1e-10  # of the gaps: what may be left of (W)
_STEPS = 40
_SETTLED = 1e-12  # relative steps below which an iterate is the solution but for rounding
# largest steps: of Psi in shares of itself, of the forces in shares of their sum, of the phases in rad
_LONGEST_PSI, _LONGEST_N, _LONGEST_PHI = 0.05, 0.5, 0.5
_SAME = 1e-7  # relative differences of unknowns up to which two solutions are one


class Whirling(NamedTuple):
    """Whirls or candidates of one pressed set: Psi (m,) rad/s, N (m, n) N, phi (m, n) rad with phi of the first contact 0."""

    Psi: Any
    N: Any
    phi: Any

    def at(self, i):
        """Some of them."""
        return Whirling(*(part[i] for part in self))


@dataclass(frozen=True, eq=False)
class Pressed:
    """Some contacts of a system at one rotor speed, which are pressed."""

    bodies: Any  # rotor and stator as one Body of N + M coordinates, with first-order states as more coordinates
    Omega: Any  # rad/s, or (m,) of m candidates, all of whose arrays have one more axis then
    rows: Any  # (n, N + M) l_j
    laws: tuple[Any, ...]  # a `SteadyLaw` for each
    turn: Any  # (n,) c_j
    gap: Any  # (n,) m, s_j; or (m, n) of m candidates
    stiffness: Any  # (n,) N/m, k_j
    ring: Any  # (n,) complex m, eccentricity of the rotor's ring
    states: int = 0  # p, number of the first-order states, the last of the coordinates

    @property
    def n(self):
        """Number of contacts."""
        return len(self.laws)

    def dynamic_stiffness(self, Psi: FloatOrArray):
        """A(Psi), (m, N + M, N + M)."""
        return dynamic_stiffness(self.bodies.mass, self.bodies.by_frequency(self.Omega), self.bodies.static, Psi)

    def solved(self, Psi: NDArray[np.float64]):
        """A^-1 l_j as columns, (m, N + M, n); not a number where A is exactly singular."""
        matrices = self.dynamic_stiffness(Psi)
        try:
            columns = transposed(self.rows)
            return np.linalg.solve(matrices, np.broadcast_to(columns, (len(Psi), *columns.shape[-2:])))
        except np.linalg.LinAlgError:  # a pole of undamped bodies, to the last bit
            columns = np.stack([solve_at(matrices, self.rows[..., j, :]) for j in range(self.n)], axis=-1)
            return np.where(np.isfinite(columns), columns, np.nan)

    def receptances(self, Psi: NDArray[np.float64]):
        """H (m, n, n) in m/N and dH/dPsi."""
        solved = self.solved(Psi)
        moved = self.bodies.by_frequency(self.Omega) @ solved
        moved -= 2.0 * Psi[:, None, None] * (self.bodies.mass @ solved)
        return self.rows @ solved, -self.left(Psi, solved) @ moved

    def left(self, Psi: FloatOrArray, solved):
        """l_j^T A^-1 as rows (m, n, N + M), given A^-1 l_j as columns: the same where A is symmetric."""
        if self.bodies.symmetric:
            return transposed(solved)
        matrices = transposed(self.dynamic_stiffness(Psi))
        return np.stack([solve_at(matrices, self.rows[..., j, :]) for j in range(self.n)], axis=-2)

    def distances(self, N):
        """|d_j| = s_j + N_j/k_j in m."""
        return self.gap + N / self.stiffness

    def shapes(self, whirls):
        """Deflections (m, N + M) of both bodies in the turning frame, and first-order states; the first contact at angle 0."""
        force = self.turn * whirls.N * np.exp(1j * whirls.phi)
        return -(self.solved(whirls.Psi) @ force[:, :, None])[:, :, 0]

    def at(self, i):
        """The same for some of m candidates that have gaps of their own."""
        return self if self.gap.ndim == 1 else replace(self, gap=self.gap[i])

    def without(self, j):
        """The pressed set without its contact j."""
        kept = np.arange(self.n) != j
        laws = tuple(law for law, stays in zip(self.laws, kept, strict=True) if stays)
        arrays = {name: getattr(self, name)[kept] for name in ("rows", "turn", "gap", "stiffness", "ring")}
        return replace(self, laws=laws, **arrays)


def pressed(system: System, Omega: FloatOrArray, contacts):
    """The `Pressed` of some contacts of a System (their numbers) at a rotor speed in rad/s; of several speeds, or of a stack of
    systems, every array has one more axis, the first."""
    own, p = [system.contacts[j] for j in contacts], system.n_states
    laws = tuple(law_at(contact) for contact in own)
    return Pressed(
        bodies=system.at_speed(Omega).joined().with_states(),
        Omega=Omega,
        rows=np.stack([_row(contact, p) for contact in own], axis=-2),
        laws=laws,
        turn=np.stack([law.turn for law in laws], axis=-1),
        gap=np.stack([law.gap for law in laws], axis=-1),
        stiffness=np.stack([law.stiffness for law in laws], axis=-1),
        ring=np.stack([contact.ring for contact in own], axis=-1),
        states=p,
    )


def _row(contact, p):
    """l of a contact, with zeros for p first-order states."""
    parts = [contact.rotor, -contact.stator]
    return np.concatenate([*parts, np.zeros((*contact.rotor.shape[:-1], p))] if p else parts, axis=-1)


def residual(own, whirls):
    """What is left of (W) at candidates, (m, n) complex, over the gaps."""
    H, _ = own.receptances(whirls.Psi)
    return _left(own, H, whirls) / own.gap


def _left(own, H, whirls):
    u = np.exp(1j * whirls.phi)
    return (H @ (own.turn * whirls.N * u)[:, :, None])[:, :, 0] + own.distances(whirls.N) * u


def _slopes(own, H, H_slope, whirls):
    """Derivatives (m, n, 2 n) of what is left of (W) by Psi, every N_j, and phi_j but the first."""
    u = np.exp(1j * whirls.phi)
    each = np.eye(own.n)
    by_N = (H * own.turn + each / own.stiffness) * u[:, None, :]
    by_phi = 1j * (H * (own.turn * whirls.N)[:, None, :] + each * own.distances(whirls.N)[:, None, :]) * u[:, None, :]
    by_Psi = H_slope @ (own.turn * whirls.N * u)[:, :, None]
    return np.concatenate([by_Psi, by_N, by_phi[:, :, 1:]], axis=2)


def shifted(own, error, whirls):
    """By how much the frequencies Psi of whirls change, to first order, when the receptances H change by `error` (m, n, n)."""
    H, H_slope = own.receptances(whirls.Psi)
    gap = own.gap[:, None]
    return _solved(_slopes(own, H, H_slope, whirls) / gap, _left(own, H + error, whirls) / gap[:, 0])[:, 0]


def newton(own, whirls):
    """Newton's method on (W) from m candidates.

    Returns
    -------
    whirls : Whirling
        The last iterates.
    met : (m,) bool
        Whether (W) is met; forces of either sign.
    """
    n, roots = own.n, Whirling(*(np.array(part, dtype=float) for part in whirls))
    active, met = np.arange(len(roots.Psi)), np.zeros(len(roots.Psi), bool)
    for _ in range(_STEPS):
        at, some = roots.at(active), own.at(active)
        H, H_slope = own.receptances(at.Psi)
        left, slopes = _left(some, H, at) / some.gap, _slopes(some, H, H_slope, at) / some.gap[..., None]
        sound = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(left).all(axis=1)
        step = np.full((len(active), 2 * n), np.nan)
        step[sound] = _solved(slopes[sound], left[sound])
        total = np.abs(at.N).sum(axis=1)[:, None]
        share = np.concatenate([np.abs(step[:, :1] / at.Psi[:, None]), np.abs(step[:, 1 : n + 1]) / total], axis=1)
        turns = np.abs(step[:, n + 1 :])
        longest = np.concatenate([share[:, :1] / _LONGEST_PSI, share[:, 1:] / _LONGEST_N, turns / _LONGEST_PHI], axis=1)
        step /= np.maximum(longest.max(axis=1), 1.0)[:, None]
        roots.Psi[active] += step[:, 0]
        roots.N[active] += step[:, 1 : n + 1]
        roots.phi[active, 1:] += step[:, n + 1 :]
        size = np.concatenate([share, turns], axis=1).max(axis=1)
        met[active] = np.abs(left).max(axis=1) < MET
        on = np.isfinite(size) & ~((size < _SETTLED) | (met[active] & (size < 1e3 * _SETTLED)))
        active = active[on]
        if not len(active):
            break
    return roots, met & np.isfinite(roots.Psi)


def _solved(slopes, left):
    """Newton's steps (m, 2 n) of complex equations in real unknowns; not a number where they are singular."""
    matrices = np.concatenate([slopes.real, slopes.imag], axis=1)
    right = -np.concatenate([left.real, left.imag], axis=1)
    # columns of one size, so that the singular ones show
    scale = np.abs(matrices).max(axis=1)
    scale[scale == 0.0] = 1.0
    try:
        return np.linalg.solve(matrices / scale[:, None, :], right[:, :, None])[:, :, 0] / scale
    except np.linalg.LinAlgError:
        if len(matrices) == 1:
            return np.full(right.shape, np.nan)
        half = len(matrices) // 2
        return np.concatenate([_solved(slopes[part], left[part]) for part in (slice(half), slice(half, None))])


def settled(own, candidates, bounds):
    """The whirls that Newton's method reaches from candidates: all forces positive, Psi within one of some ranges in rad/s, each
    once, by rising frequency."""
    roots, met = newton(own, candidates)
    inside = np.zeros(len(met), bool)
    for low, high in bounds:
        inside |= (roots.Psi > low) & (roots.Psi < high)
    roots = roots.at(met & inside & (roots.N > 0.0).all(axis=1))
    roots = roots.at(np.lexsort((roots.N[:, 0], roots.Psi)))
    kept = []
    for i in range(len(roots.Psi)):
        if not any(_same(roots, i, k) for k in reversed(kept)):
            kept.append(i)
    roots = roots.at(np.array(kept, dtype=int))
    return roots._replace(phi=np.angle(np.exp(1j * roots.phi)))


def _same(roots, i, k):
    apart = abs(roots.Psi[i] - roots.Psi[k]) > _SAME * abs(roots.Psi[i])
    return not (
        apart
        or np.abs(roots.N[i] - roots.N[k]).max() > _SAME * roots.N[i].max() * 1e2
        or np.abs(np.exp(1j * roots.phi[i]) - np.exp(1j * roots.phi[k])).max() > _SAME * 1e2
    )
