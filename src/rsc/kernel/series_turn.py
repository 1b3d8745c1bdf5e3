"""The shaft's turn in a Taylor series: coefficients of e^{i phi} and of Omega in theta = (t - t_0)/h.

E = e^{i phi} solves E' = i h Omega E. A prescribed speed is a line, so that all of E is known before the motion is; one that
gives way (drive.py) is a coordinate, whose coefficients come with those of the motion.
"""

from typing import NamedTuple

from rsc.kernel.simd.emit import Emitted, fma, pair_of, product


class BrakedSeries(NamedTuple):
    """What turns against a drive, coefficient by coefficient, times h."""

    friction: Emitted  # N m, mu sigma F_N d_R/2 of all contacts
    others: Emitted  # N m, what the contact rings take, less what rotating damping gives


class Prescribed:
    """A speed that changes at a constant rate.

    e : coefficients of e^{i phi} up to `order`
    """

    def __init__(self, con, clock, h, per_h, order):
        self.con, self.h, self.per_h, self.omega, self.omega_dot = con, h, per_h, clock.omega, clock.omega_dot
        self.rate = clock.omega_dot * h
        self.e, speed, rate = [pair_of(clock.cos, clock.sin)], clock.omega * h, clock.omega_dot * h * h
        for k in range(order):
            slope = self.e[k] * speed
            slope = fma(rate, self.e[k - 1], slope) if k else slope
            self.e.append(slope.turned() * (1.0 / (k + 1)))

    def speed(self, k):
        """Omega_k, None of zero."""
        return (self.omega, self.rate, None)[min(k, 2)]

    def times(self, a, k):
        """Coefficient k of Omega a."""
        turn = self.omega * a[k]
        return fma(self.rate, a[k - 1], turn) if k else turn

    def plus_times(self, a, k, total):
        """total + coefficient k of Omega a."""
        total = fma(self.omega, a[k], total)
        return fma(self.rate, a[k - 1], total) if k else total

    def times_rate(self, integral, a, b):
        """Integral of h Omega' times the sum of all products of two vectors."""
        return integral(a, b).pair().across() * self.rate

    def imposed(self, k):
        """h times the unbalance with its run-up term, -(e^{i phi})'' U, and the load."""
        con, e = self.con, self.e
        b = e[k + 2] * (self.per_h * -float((k + 1) * (k + 2)))
        f = con.unbalance * b.lane(0) if k else fma(self.h, con.load, con.unbalance * b.lane(0))
        f = fma(b.lane(1), con.i_unbalance, f)

        def euler(f):
            w = e[k] * self.rate
            return fma(w.lane(1), con.euler, fma(w.lane(0) * -1.0, con.i_euler, f))

        return f.where(con.has_euler, euler) if con.columns else f

    def given_way(self, a, k, v, braked):
        """Accelerations as they are: nothing turns the drive."""
        return a


class Driven:
    """A speed that gives way, drive.py's equations by coefficients: `given_way` ends those of every order.

    Of u = U_e e^{i phi} every product with the motion is that of e^{i phi} with a pair of numbers, U_e^H of the motion.
    """

    def __init__(self, con, clock, torque, h):
        self.con, self.drive, self.torque, self.h = con, con.drive, torque, h
        self.e, self.omega = [pair_of(clock.cos, clock.sin)], [clock.omega]
        self.once = []  # Omega e^{i phi}
        self.force, self.motion = [], []  # -i U_e^H a_0 times h and (U_e - U)^H r', as pairs (real, imaginary part)
        self.along = []  # Re((u - u_0)^H r')
        self.rate, self.motor, self.friction = [], [], []  # h Omega'; h times the torques of the drive and of friction

    def speed(self, k):
        """Omega_k."""
        return self.omega[k]

    def times(self, a, k):
        """Coefficient k of Omega a."""
        return product(self.omega, a, k)

    def plus_times(self, a, k, total):
        """total + coefficient k of Omega a."""
        for j in range(k + 1):
            total = fma(self.omega[j], a[k - j], total)
        return total

    def times_rate(self, integral, a, b):
        """Integral of h Omega' times the sum of all products of two vectors."""
        return integral(self.rate, [product(a, b, k).pair().across() for k in range(len(a))])

    def imposed(self, k):
        """h times the load; the unbalance, whose work is the drive's, comes with `given_way`. Takes e^{i phi} one further."""
        self.once.append(product(self.omega, self.e, k))
        self.e.append(self.once[k].turned() * (self.h * (1.0 / (k + 1))))
        return self.con.load * (self.h if k == 0 else self.h * 0.0)

    def given_way(self, a, k, v, braked):
        """Accelerations a with all but unbalance and Omega', h/(k + 1) times coefficient k, with both; braked: `BrakedSeries`, h
        times coefficient k of what turns against the drive. Takes Omega one order further."""
        drive, con, part = self.drive, self.con, 1.0 / (k + 1)
        twice = product(self.omega, self.once, k) * (self.h * part)
        a = fma(twice.lane(0), drive.unbalance, fma(twice.lane(1), drive.i_unbalance, a))
        along, across = (_number(row * a) * (k + 1.0) for row in (drive.euler, drive.i_euler))
        self.force.append(pair_of(across, along * -1.0))
        rising = self.h * self.torque.b * self.omega[k]
        self.motor.append(fma(self.h, self.torque.a, rising) if k == 0 else rising)
        self.friction.append(braked.friction)
        net = self.motor[k] - braked.friction - braked.others - drive.mass * product(self.e, self.force, k).across()
        if con.columns:  # without gyroscopics u is u_0
            self.motion.append(pair_of(_number(con.euler * v[k]), _number(con.i_euler * v[k])))
            self.along.append(product(self.e, self.motion, k).across())
            net = fma(drive.mass * self.h, product(self.omega, self.along, k), net)
        if drive.weight:
            real, imaginary = drive.weight
            net = fma(self.h * imaginary, self.e[k].lane(0), fma(self.h * real * -1.0, self.e[k].lane(1), net))
        self.rate.append(net * drive.per_inertia)
        self.omega.append(self.rate[k] * part)
        turns = product(self.rate, self.e, k) * part
        a = fma(self.rate[k] * part, drive.spin, a)
        return fma(turns.lane(1), drive.euler, fma(turns.lane(0) * -1.0, drive.i_euler, a))

    def work(self, integral):
        """(work of the torque, work that friction takes from the drive)."""
        omega = self.omega[: len(self.motor)]
        return pair_of(integral(self.motor, omega), integral(self.friction, omega))


def _number(vector):
    """Sum of all numbers of a vector."""
    return vector.pair().across()
