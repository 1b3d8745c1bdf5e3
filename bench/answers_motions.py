"""Motions that last at a constant speed, by the second engine: where its runs end, and starts on and beside what is claimed."""

import itertools
import math
from typing import NamedTuple

import numpy as np

from answers_engine import State, at_speed, integrate, machine_of
from answers_labels import NO_CONTACT, RUNNING_AWAY, SELF_EXCITED, Signals, kinds

PERIODS = 12.0  # of the slowest of shaft and free vibrations, a block
LEAST, MOST, FOLDS = 8, 60, 6.0  # blocks of a run at least and at most, e-foldings of the slowest decay
ALIKE, LAST = 0.01, 6  # change from block to block of a motion at rest; blocks looked at of one that is not
FAR, GROWS = 20.0, 1.02  # gaps, and growth from block to block, of a motion that runs away
STEADY, RESTLESS = (0.02, 0.05, 0.1), (0.1, 0.3, 0.5)  # of frequency, |r|, force: up to which two motions are one
BESIDE = 0.03
TRIES = 4  # impacts tried for a motion that is said to be possible
FOLLOWED = 2  # whole runs more of what is not at rest, or of the claimed kind and another size: a slow approach may look alike


class End(NamedTuple):
    """Where a run ends: kinds that it may be called, mean turning Hz, largest |r| m, largest force N, share of contact, whether
    it is steady, its last state."""

    kinds: set
    turning: float
    size: float
    force: float
    share: float
    steady: bool
    state: State


class AtSpeed:
    """A machine of a rsc.system.System at one speed, Hz."""

    def __init__(self, system, speed):
        self.machine, self.speed, self.omega = machine_of(system), speed, 2.0 * np.pi * speed
        n = self.machine.n_rotor
        self.n, m = n, self.machine
        first = np.zeros((4 * n, 4 * n))  # on real coordinates: what acts on the conjugate is not linear in complex ones
        first[: 2 * n, 2 * n :] = np.eye(2 * n)
        damping = m.damping[:n, :n] - 1j * self.omega * m.gyroscopic[:n, :n]
        first[2 * n :, : 2 * n] = -_real(m.stiffness[:n, :n], m.stiffness_conj[:n, :n])
        first[2 * n :, 2 * n :] = -_real(damping, m.damping_conj[:n, :n])
        values = np.linalg.eigvals(first)
        size = abs(values.imag)
        slowest = size[size > 1e-6 * size.max()].min() / (2.0 * np.pi) if size.max() > 0.0 else speed
        decays = -values.real[values.real < 0.0]
        self.block = PERIODS / min(slowest, speed)
        decay = decays.min() if decays.size else slowest
        self.grows = bool(values.real.max() > 1e-6 * slowest)  # then no contact never lasts, however long it takes to touch
        self.blocks = MOST if self.grows else int(np.clip(FOLDS / (decay * self.block), LEAST, MOST))

    def running(self, touching=False):
        """The steady motion of the rotor by unbalance and load without contact, at the shaft's angle 0; None if it would touch,
        unless that does not matter."""
        m, n, omega = self.machine, self.n, self.omega
        k, b, g = m.stiffness[:n, :n], m.damping[:n, :n], m.gyroscopic[:n, :n]
        e, c = m.stiffness_conj[:n, :n], m.damping_conj[:n, :n]

        def dynamic(w):
            return k - np.eye(n) * w**2 + 1j * w * (b - 1j * omega * g)

        whole = np.block([[dynamic(omega), e + 1j * omega * c], [(e - 1j * omega * c).conj(), dynamic(-omega).conj()]])
        both = np.linalg.solve(whole, np.concatenate([m.unbalance[:n] * omega**2, np.zeros(n)]))
        forward, backward = both[:n], both[n:].conj()
        static = np.linalg.lstsq(_real(k, e), np.concatenate([m.load[:n].real, m.load[:n].imag]), rcond=None)[0]
        static = static[:n] + 1j * static[n:]
        reach = sum(abs(part) for part in (m.row[:n] @ static, m.row[:n] @ forward + m.ring, m.row[:n] @ backward))
        if reach > m.gap and not touching:
            return None
        still = np.zeros(len(m.row) - n)
        return State(
            *(np.concatenate([part, still]) for part in (static + forward + backward, 1j * omega * (forward - backward)))
        )

    def hit(self, state, impulse):
        """A state after an impulse (complex, N s) on the rotor at the contact."""
        change = self.machine.push.astype(complex) * impulse
        change[self.n :] = 0.0
        return state._replace(v=state.v + change)

    def circle(self, frequency, amplitude):
        """States on a circle of the contact at a frequency in Hz with an amplitude |r| in m, without and with what unbalance adds
        to the velocities."""
        m, w = self.machine, 2.0 * np.pi * frequency
        dynamic = m.stiffness - np.eye(len(m.row)) * w**2 + 1j * w * (m.damping - 1j * self.omega * m.gyroscopic)
        shape = np.linalg.solve(dynamic, -m.push.astype(complex))
        shape *= amplitude / abs(m.row[: self.n] @ shape[: self.n]) * np.exp(-1j * np.angle(m.row @ shape))
        on = State(shape, 1j * w * shape)
        return [on._replace(v=on.v + self.running(touching=True).v), on]

    def rub(self, force):
        """A state of permanent contact that turns with the shaft, pressed with a force in N: of all directions of the contact the
        one in which the deflection lies."""
        m, w = self.machine, self.omega
        dynamic = m.stiffness - np.eye(len(m.row)) * w**2 + 1j * w * (m.damping - 1j * w * m.gyroscopic)
        turns = np.exp(2j * np.pi * np.arange(720) / 720)
        loads = (m.unbalance * w**2)[:, None] - np.outer(m.push, force * (1.0 + 1j * m.friction) * turns)
        shapes = np.linalg.solve(dynamic, loads)
        off = abs(m.row @ shapes + m.ring - (m.gap + force / m.k) * turns)
        shape = shapes[:, np.argmin(off)]
        return State(shape, 1j * w * shape)

    def end(self, state, whole=False):
        """The End of a run from a state; whole: not stopped where it looks steady."""
        blocks = []
        for _ in range(self.blocks):
            run = integrate(self.machine, at_speed(self.omega, self.block, state.angle), state, self.block)
            signals, state = Signals(run), run.state
            if run.diverged:
                return End({RUNNING_AWAY}, 0.0, np.inf, np.inf, 1.0, True, state)
            facts = (signals.turning(0.0, self.block), signals.largest(signals.rotor), signals.largest(signals.force))
            blocks.append((kinds(signals, 0.0, self.block), *facts, float(signals.touch.mean()), signals.largest(signals.d)))
            if self._away(blocks):
                return End({RUNNING_AWAY}, *facts, 1.0, True, state)
            if self._steady(blocks) and (not whole or len(blocks) == self.blocks):
                allowed, *facts, _ = blocks[-1]
                return End(allowed, *facts, True, state)
        last = blocks[-LAST:]
        numbers = np.array([block[1:] for block in last])
        turning, share = numbers[:, 0].mean(), numbers[:, 3].mean()
        every = set.intersection(*(block[0] for block in last))
        if self.grows and NO_CONTACT in every:
            every = set()
        elif not every:  # of another kind from block to block: what it is in all of them
            long = integrate(self.machine, at_speed(self.omega, LAST * self.block, state.angle), state, LAST * self.block)
            every = kinds(Signals(long), 0.0, LAST * self.block)
        return End(every, turning, numbers[:, 1].max(), numbers[:, 2].max(), share, False, state)

    def _away(self, blocks):
        sizes = [block[5] for block in blocks[-LAST:]]
        rises = all(b > GROWS * a for a, b in itertools.pairwise(sizes))
        return len(sizes) == LAST and sizes[-1] > FAR * self.machine.gap and rises

    def _steady(self, blocks):
        if len(blocks) < 3:
            return False
        (known, *_), numbers = blocks[-1], np.array([block[1:5] for block in blocks[-3:]])
        if NO_CONTACT in known:
            return not (self.grows or numbers[:, 3].any())
        scales = np.array([abs(numbers[-1, 0]), max(numbers[-1, 1], self.machine.gap), numbers[-1, 2], 1.0])
        return bool((np.ptp(numbers, axis=0) <= ALIKE * scales).all())

    def lasts(self, end, dice):
        """The End of a run beside the state of an end, its velocities changed by 3 %, if that is the same motion; else None."""
        z = dice.uniform(-1.0, 1.0, (2, len(end.state.v)))
        # in the whole of its run: three blocks that are alike may be a slow departure
        beside = self.end(end.state._replace(v=end.state.v * (1.0 + BESIDE * (z[0] + 1j * z[1]))), whole=True)
        return beside if beside.kinds & end.kinds and same(beside, end, self.machine.gap) else None


def _real(matrix, conjugate):
    """Matrix on [y, z] of u -> A u + B conj(u)."""
    return np.block(
        [[(matrix + conjugate).real, (conjugate - matrix).imag], [(matrix + conjugate).imag, (matrix - conjugate).real]]
    )


def same(a, b, gap):
    """Whether two motions of one kind (End or Claim) are one."""
    kinds = a.kinds & b.kinds
    if kinds & {NO_CONTACT, RUNNING_AWAY}:
        return True
    of_frequency, of_size, of_force = STEADY if a.steady and b.steady else RESTLESS
    if kinds & (SELF_EXCITED | {"forward rub"}) and abs(a.turning - b.turning) > of_frequency * max(
        abs(a.turning), abs(b.turning)
    ):
        return False
    return abs(a.size - b.size) <= of_size * max(a.size, b.size, gap) and abs(a.force - b.force) <= of_force * max(
        a.force, b.force
    )


class Claim(NamedTuple):
    """A motion that is said to last; as End."""

    kinds: set
    turning: float
    size: float
    force: float
    steady: bool


def reached(at, claim, starts):
    """The End of the first of some starts that ends in a claimed motion, or None, and what the others end in."""
    others = []
    for start in starts:
        end = at.end(start)
        for _ in range(FOLLOWED):
            there = bool(claim.kinds & end.kinds)
            if same(claim, end, at.machine.gap) if there else end.steady:
                break
            end = at.end(end.state, whole=True)
        if claim.kinds & end.kinds and same(claim, end, at.machine.gap):
            return end, others
        others.append(end)
    return None, others


def base_of(at):
    """The motion that random impacts disturb: running without contact, or what a start at rest settles to."""
    free = at.running()
    if free is not None:
        return free
    m, n = at.machine, at.n
    static = np.zeros(len(m.row), complex)
    static[:n] = np.linalg.lstsq(m.stiffness[:n, :n], m.load[:n], rcond=None)[0]
    pressed = abs(m.row @ static)
    return at.end(State(static * min(1.0, m.gap / pressed if pressed else 1.0), 0.0 * static)).state


def starts_of(at, listed, motion):
    """States that should end in a listed motion: random impacts that rsc says do, and circles of its rate and size."""
    index = next(i for i, one in enumerate(listed.motions) if one is motion)
    impacts = [complex(*listed.impulse[k]) for k in np.flatnonzero(listed.ended == index)[:TRIES]]
    still = motion.motion == NO_CONTACT
    base = base_of(at) if impacts or still else None
    yield from [base] if still else []
    yield from (at.hit(base, impulse) for impulse in impacts)
    if motion.motion == "forward rub":
        yield at.rub(motion.force_mean)
    if motion.predicted is not None:
        yield from at.circle(motion.predicted.frequency, motion.predicted.amplitude)
    for one in listed.not_reached:  # an unstable whirl leads to the motion round it, or to another
        if one.frequency * motion.frequency > 0.0:
            yield from at.circle(one.frequency, one.amplitude)
    if math.isfinite(motion.frequency) and motion.frequency:
        for share in (1.0, 0.8, 0.6):
            yield from at.circle(motion.frequency, share * min(motion.amplitude_max, 50.0 * at.machine.gap))


def claim_of(motion):
    """A listed motion as a Claim."""
    turning = 0.0 if math.isnan(motion.frequency) else motion.frequency
    return Claim({motion.motion}, turning, motion.amplitude_max, motion.force_max, not motion.modulated)


def told(ends, at):
    """Some ends in words."""
    texts = []
    for end in ends[:6]:
        kinds = "/".join(sorted(end.kinds)) or "changing kinds"
        texts.append(f"{kinds} ({end.turning:.4g} Hz, {end.size / at.machine.gap:.3g} gaps, {end.force:.4g} N)")
    return ", ".join(texts) or "nothing: no start is known"
