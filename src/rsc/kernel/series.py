"""A step by Taylor series: coefficients of the motion in theta = (t - t_0)/h, specialised to the equations of this kernel.

Every quantity is a polynomial or solves a first-order differential equation: the unbalance e^{i phi} by E' = i h Omega E, the
contact's distance by g = |d|^2/|d_0|^2, q = g'/(2 g) and w = |d_0|/|d| with w' = -q w, the force by F_N/|d| = k (1 - s/|d|)
+ b q/h. The coefficients of a product of series are Cauchy sums. docs/maintainers/kernel.md has the recurrences.
"""

from types import SimpleNamespace
from typing import NamedTuple

from numba import types
from numba.extending import intrinsic

from rsc.kernel.series_turn import BrakedSeries, Driven, Prescribed
from rsc.kernel.simd.emit import PAIR, Emitted, fma, pair_of, parts, product
from rsc.kernel.springs import ROOMS


class Series(NamedTuple):
    """x and v of a step as Taylor coefficients, in ascending order."""

    x: object
    v: object


def _square(a, twice, k):
    """Coefficient k of a . a from a_j and 2 a_j."""
    total = None if k % 2 else a[k // 2] * (twice[k // 2] * 0.5)
    for j in range((k - 1) // 2, -1, -1):
        total = twice[j] * a[k - j] if total is None else fma(twice[j], a[k - j], total)
    return total


def _integral(a, b):
    """Integral over the step of the product of two series."""
    total = a[0] * b[0]
    for k in range(1, len(a)):
        total = fma(1.0 / (k + 1), product(a, b, k), total)
    return total


def _integral_of_square(a):
    """Integral over the step of the square of a series."""
    total = None
    for j in range((len(a) + 1) // 2):
        inner = a[j] * (1.0 / (2 * j + 1))
        for m in range(j + 1, len(a) - j):
            inner = fma(2.0 / (j + m + 1), a[m], inner)
        total = a[j] * inner if total is None else fma(a[j], inner, total)
    return total


def _sum(a):
    """Value of a series at the end of the step (theta = 1)."""
    total = a[1]
    for part in a[2:]:
        total = total + part
    return a[0] + total


def _slope(a):
    """Derivative of a series at the end of the step (theta = 1)."""
    total = a[1]
    for k in range(2, len(a)):
        total = fma(float(k), a[k], total)
    return total


class _Turned:
    """Series of rotating damping: its force on the motion relative to the rotor, v - i Omega x, times h."""

    def __init__(self, con, shaft, h):
        self.base, self.minus_h, self.shaft, self.x = con.rotating[0], h * -1.0, shaft, []
        self.carried, self.slide, self.force = [], [], []

    def add(self, x, v, k):
        """Coefficient k of the force, from those of x up to k and from v_k."""
        carried = self.shaft.times(x, k).turned()
        self.carried.append(carried)
        self.slide.append(v - carried)
        self.force.append(self.minus_h * self.slide[k].columns(self.base))
        return self.force[k]

    def torque(self, x, k):
        """Coefficient k of the torque it takes from the drive, per mass: -Im(r^H D_i (r' - i Omega r))."""
        self.x.append(x[k].turned())
        return product(self.x, self.force, k).pair().across()

    def work(self):
        """(work on the motion relative to the rotor by lane, work of the drive), both per mass."""
        return _integral(self.slide, self.force), _integral(self.carried, self.force).pair().across()


class _Following:
    """Series of a speed-dependent stiffness or damping force, (K_a + Omega K_b) x."""

    def __init__(self, shaft, bases):
        self.bases, self.shaft, self.by_speed = bases, shaft, []

    def add(self, x):
        """Next coefficient of the force, from that of x."""
        swapped = x.swapped()
        self.by_speed.append(x.columns(self.bases[1], swapped))
        return self.shaft.plus_times(self.by_speed, len(self.by_speed) - 1, x.columns(self.bases[0], swapped))

    def work(self, x):
        """1/2 Omega' x^H K_b x over the step, per mass; K_b is negative, like all stiffness in the kernel."""
        return self.shaft.times_rate(_integral, x, self.by_speed) * -0.5


class _Control:
    """Series of what first-order states add to accelerations, times h; nothing without them."""

    def __init__(self, con, bases, h):
        self.states, self.bases, self.h, self.change = con.states, bases, h, []

    def added(self, a, x, v):
        """Accelerations with the next coefficient, from those of x and v."""
        if not self.states:
            return a
        self.change.append((v.columns(self.bases[0]) + x.columns(self.bases[1])) * self.h)
        return a + self.change[-1]

    def work(self, v, none):
        """Work on the bodies over the step, J."""
        return (self.states.weight * _integral(v, self.change)).pair().across() if self.states else none


class _Contact:
    """Series of a closed contact, in ascending order; factors are applied where they delay no later operation."""

    def __init__(self, con, law, place, shaft, h, per_h, kind):
        self.con, self.law, self.shaft, self.e, self.h, self.per_h, self.kind = con, law, shaft, shaft.e, h, per_h, kind
        self.inverse = place.inverse
        self.d = [pair_of(place.d_y, place.d_z)]
        self.d_dot, self.swapped = [], []  # d' and (d_z', d_y')
        # everything is divided by |d_0|^2 once, so that no coefficient needs a division or square root
        self.per_square = place.inverse * place.inverse
        self.twice, self.minus_g, self.q = [], [None], []  # 2 d_j/|d_0|^2, -g_j
        self.spring = kind.coefficient(law.spring, place, con.gap, h)
        self.per_length = []  # h F_N/|d|
        self.normal, self.across = [], []  # h F_N d/|d|, and that times mu sigma if creeping
        self.w, self.cross, self.mu = [None], [], []
        # for torques of friction: |d_0|, h mu sigma F_N/|d|, |d|/|d_0|
        self.distance, self.share, self.longer = place.distance, [], [1.0]

    def add(self, k, v):
        """Coefficient k of h F_N d/|d|, and of the part to be turned by 90 degrees for friction, from coefficient k of v."""
        self._deflection(k, v)
        damped = self.kind.damped
        # with a damper the force needs p' of this order, hence q_k; without, q_(k-1) suffices, which is known earlier
        while len(self.q) < (k + 1 if damped else k):
            self._distance(len(self.q) + 1)
        self.per_length.append(self.spring.at(k, self.q))
        if damped:
            self.per_length[k] = fma(self.law.b, self.q[k], self.per_length[k])
        self.normal.append(product(self.per_length, self.d, k))
        if not self.kind.creeping:
            return self.normal[k], self.normal[k]
        self._creep(k, v)
        self.across.append(product(self.mu, self.normal, k))
        return self.normal[k], self.across[k]

    def friction(self, k):
        """Coefficient k of h mu sigma F_N; to be called once for each order, ascending."""
        self.share.append(product(self.mu, self.per_length, k) if self.kind.creeping else self.per_length[k] * self.law.mu)
        if k:
            self.longer.append(product(self.q, self.longer, k - 1) * (1.0 / k))
        return product(self.share, self.longer, k) * self.distance

    def ring_torque(self, k):
        """Coefficient k of the torque that the ring takes from a drive, h Im(conj(ring e^{i phi}) F_C)."""

        def torque(none):
            ring = [self._ring(j).turned() for j in range(k + 1)]
            return none + product(self._forces(), ring, k).across()

        return (self.h * 0.0).where(self.con.has_ring, torque)

    def work(self):
        """[energy fed by friction, work against the normal force if damped, energy fed by the contact ring]."""
        zero, kind = self.h * 0.0, self.kind
        if kind.creeping:
            friction = _integral(self.across, self.swapped).difference()
        else:
            friction = _integral(self.normal, self.swapped).difference() * self.law.mu
        normal = _integral(self.normal, self.d_dot).across() if kind.damped else zero

        def ring(none):
            total = self._forces()
            return none + _integral(total, [self._ring(k + 1) * (self.per_h * (k + 1.0)) for k in range(len(total))]).across()

        return [friction * -1.0, normal, zero.where(self.con.has_ring, ring)]

    def _forces(self):
        """Coefficients of h F_C."""
        across = self.across if self.kind.creeping else [self.law.mu * normal for normal in self.normal]
        return [n + a.turned() for n, a in zip(self.normal, across, strict=True)]

    def _ring(self, k):
        """Coefficient k of the rotating eccentric ring, ring e^{i phi}."""
        ring = pair_of(self.con.ring_y, self.con.ring_z)
        return fma(self.e[k].lane(0), ring, ring.turned() * self.e[k].lane(1))

    def _deflection(self, k, v):
        """Append d'_k and d_(k + 1)."""
        row = self.con.contact_row
        rate = (row * v).pair().where(self.con.has_ring, lambda r: r + self._ring(k + 1) * (self.per_h * (k + 1.0)))
        self.d_dot.append(rate)
        self.swapped.append(rate.swapped())
        self.twice.append(self.d[k] * (self.per_square * 2.0))
        self.d.append(rate * (self.h * (1.0 / (k + 1))))

    def _distance(self, m):
        """Append g_m and q_(m - 1)."""
        g = _square(self.d, self.twice, m).across()
        self.q.append(g * 0.5 if m == 1 else fma(0.5 * m, g, product(self.minus_g, self.q, m - 1, 1, m - 1)))
        self.minus_g.append(g * -1.0)

    def _creep(self, k, v):
        """Append coefficient k of mu sigma, which depends on the slip."""
        if k:
            w = self.q[k - 1] * (-1.0 / k)
            self.w.append(w if k == 1 else fma(-1.0 / k, product(self.q, self.w, k - 1, 0, k - 2), w))
        self.cross.append(product(self.d, self.swapped, k).difference())
        tangential = self.cross[k] if k == 0 else self.cross[k] + product(self.cross, self.w, k, 0, k - 1)
        slip = tangential * self.inverse
        speed = self.shaft.speed(k)
        if speed is not None:
            slip = fma(self.con.surfaces.radius, speed, slip)
        if self.con.race:
            slip = slip - (self.con.race.row * v).pair().lane(0)
        mu = slip * self.law.mu_slope
        self.mu.append(mu + self.law.mu if self.kind.together and k == 0 else mu)


def _expand(con, laws, places, instant, start, h, order, kind):
    """A step of length h: (coefficients of x, of v, [x, v and a at its end, integrals of the powers: damping and drive by lane],
    for every contact [fed by friction, work against the normal force if damped, fed by its ring], [fed by the drive through
    rotating damping, by a speed-dependent stiffness, by first-order states], work of drive torque and of friction against it)."""
    per_h, clock, following = h.reciprocal(), instant.turn, instant.following
    driven = bool(con.drive)
    shaft = Driven(con, clock, instant.torque, h) if driven else Prescribed(con, clock, h, per_h, order + 1)
    contacts = []
    if kind.pressed:
        contacts = [_Contact(*each, shaft, h, per_h, kind) for each in zip(con.contacts, laws, places, strict=True)]
    stiffness, damper = con.stiffness * h, con.damping * h
    side_rows = [contact.con.force_row.turned() for contact in contacts]
    if not kind.creeping:
        side_rows = [row * contact.law.mu for row, contact in zip(side_rows, contacts, strict=True)]
    x, v, damping, drive, control = [start[0]], [start[1]], [], [], _Control(con, instant.states, h)
    turned = _Turned(con, shaft, h) if con.rotating else None
    none = h * 0.0

    def coupled(without, i, change):
        return without.where(con.columns[i], lambda value: change(value, con.columns[i])) if con.columns else without

    by_component = len(con.columns) > 2
    springs, dampers = (_Following(shaft, part) if part else None for part in (following[:2], following[2:]))

    def times(base, vector):
        return vector.columns(base, vector.swapped()) if by_component else vector.columns(base)

    for k in range(order):
        part = 1.0 / (k + 1)
        drive.append(shaft.imposed(k))
        if by_component:
            drive[k] = fma(h, springs.add(x[k]) if springs else times(con.columns[2], x[k]), drive[k])
        slow = damper * v[k]
        if dampers:
            damping.append(fma(h, dampers.add(v[k]), slow))
        else:
            damping.append(coupled(slow, 0, lambda s, base, k=k: fma(h, times(base, v[k]), s)))
        a = fma(stiffness, x[k], drive[k]) + damping[k]

        def gyroscopic(a, base, k=k):
            return fma(h, shaft.times(v, k).columns(base).turned(), a)

        a = coupled(a, 1, gyroscopic)
        a = control.added(a, x[k], v[k])
        a = (a + turned.add(x, v[k], k) if turned else a) * part
        for contact, side_row in zip(contacts, side_rows, strict=True):
            normal, across = contact.add(k, v[k])
            pushed = fma(normal.repeated(a), contact.con.force_row * part, a)
            a = fma(across.swapped().repeated(a), side_row * part, pushed)
        a = _with_turning(con, a, k, v, x, shaft, contacts, turned) if driven or _has_race(con) else a
        x.append(v[k] * (h * part))
        v.append(a)
    if dampers:
        lost = _integral(v[:order], damping)
    else:
        lost = coupled(damper * _integral_of_square(v[:order]), 0, lambda *_: _integral(v[:order], damping))
    fed = _integral(v[:order], drive).product(v[0])
    works = [contact.work() for contact in contacts] or [[none] * 3 for _ in con.contacts]
    others = [none, springs.work(x[:order]) if springs else none, control.work(v[:order], none)]
    if turned:
        taken, others[0] = turned.work()
        lost = lost + taken
    spin = shaft.work(_integral) if driven else pair_of(none, none)
    return x, v, [_sum(x), _sum(v), _slope(v) * per_h, lost, fed], works, others, spin


def _has_race(con):
    return any(contact.race for contact in con.contacts)


def _with_turning(con, a, k, v, x, shaft, contacts, turned):
    """Add to accelerations, h/(k + 1) times coefficient k, the motion of races and of a torque-limited drive."""
    zero = shaft.h * 0.0
    torque = zero
    others = shaft.drive.mass * turned.torque(x, k) if turned and con.drive else zero
    for contact in contacts:
        friction = contact.friction(k)
        if contact.con.race:
            a = fma(friction * contact.con.race.per_mass * (1.0 / (k + 1)), contact.con.race.row, a)
        if con.drive:
            torque = fma(friction, contact.con.surfaces.radius, torque)
            others = others + contact.ring_torque(k)
    return shaft.given_way(a, k, v, BrakedSeries(torque, others))


def _expansion(*of):
    """Intrinsic (con, laws, contact places, `step.Instant`, (x, v), h, method) -> (coefficients of x, of v, x, v, a, damping,
    drive, for every contact friction, normal, ring, then rotating, by_speed, control, spin) of `_expand`, for contact states
    whose laws have these parts."""

    @intrinsic
    def expand(typingctx, con, laws, places, instant, start, h, method):
        order, x = len(method), start.dtype
        kind = SimpleNamespace(**{name: name in of for name in ("pressed", "damped", "creeping", "together")})
        law = laws[0]
        kind.coefficient = ROOMS[law.types[law.fields.index("spring")].instance_class].coefficient
        many, each = types.UniTuple(x, order + 1), types.UniTuple(h, len(laws))
        result = types.Tuple((many, many, x, x, x, x, x.product_type, each, each, each, h, h, h, PAIR))

        def codegen(context, builder, sig, args):
            tables = [parts(builder, sig.args[i], args[i]) for i in range(4)]
            begin = [Emitted(builder, x, builder.extract_value(args[4], i)) for i in range(2)]
            x_k, v_k, vectors, works, others, spin = _expand(*tables, begin, Emitted(builder, h, args[5]), order, kind)
            rows = [context.make_tuple(builder, many, [item.code for item in row]) for row in (x_k, v_k)]
            energies = [context.make_tuple(builder, each, [work[i].code for work in works]) for i in range(3)]
            numbers = [item.code for item in vectors], [item.code for item in (*others, spin)]
            return context.make_tuple(builder, result, [*rows, *numbers[0], *energies, *numbers[1]])

        return result(con, laws, places, instant, start, h, method), codegen

    return expand


free = _expansion()
sliding = _expansion("pressed")
damped = _expansion("pressed", "damped")
creeping = _expansion("pressed", "damped", "creeping")
# several contacts, each in any state: an open one adds zeros
together = _expansion("pressed", "damped", "creeping", "together")
