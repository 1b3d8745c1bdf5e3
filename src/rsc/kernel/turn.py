"""Rotation of the shaft: sine and cosine by polynomials on packed vectors, accurate to the last bits; at the end of a step from
its phase, at all stages at once from those at its start."""

import math
from typing import NamedTuple

from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined

TWO_PI = 2.0 * math.pi
# Taylor coefficients of cos and sin(x)/r in r^2, r = x/(2 pi) in turns; truncation error below 2e-17 for |r| <= 1/4
COS = [(-1) ** k * TWO_PI ** (2 * k) / math.factorial(2 * k) for k in range(11)]
SIN = [(-1) ** k * TWO_PI ** (2 * k + 1) / math.factorial(2 * k + 1) for k in range(11)]
_, C1, C2, C3, C4, C5, C6, C7, C8, C9, C10 = COS
S0, S1, S2, S3, S4, S5, S6, S7, S8, S9, S10 = SIN


class Turn(NamedTuple):
    """Rotation of the shaft at one instant, or (with vectors) at several."""

    cos: object  # of phi
    sin: object
    omega: object  # phi', rad/s
    real: object  # (Omega^2 - i Omega') e^{i phi}, factor of the unbalance
    imag: object
    omega_dot: float  # phi'', rad/s^2


@inlined
def _polynomials(s):
    """((cos - 1)/r^2, sin/r) of r turns from s = r^2."""
    # even and odd powers separately (Estrin): two chains of half the length, which the processor runs in parallel
    q = s * s
    even_part = vec.fma(q, vec.fma(q, vec.fma(q, vec.spread(C10, q), vec.spread(C8, q)), vec.spread(C6, q)), vec.spread(C4, q))
    even_part = vec.fma(q, even_part, vec.spread(C2, q))
    odd_part = vec.fma(q, vec.fma(q, vec.fma(q, vec.spread(C9, q), vec.spread(C7, q)), vec.spread(C5, q)), vec.spread(C3, q))
    odd_part = vec.fma(q, odd_part, vec.spread(C1, q))
    c = vec.fma(s, even_part, odd_part)
    even_part = vec.fma(q, vec.fma(q, vec.fma(q, vec.spread(S10, q), vec.spread(S8, q)), vec.spread(S6, q)), vec.spread(S4, q))
    even_part = vec.fma(q, even_part, vec.spread(S2, q))
    odd_part = vec.fma(q, vec.fma(q, vec.fma(q, vec.spread(S9, q), vec.spread(S7, q)), vec.spread(S5, q)), vec.spread(S3, q))
    odd_part = vec.fma(q, odd_part, vec.spread(S1, q))
    return c, vec.fma(s, vec.fma(s, even_part, odd_part), vec.spread(S0, q))


@inlined
def cos_sin(phase):
    """(cos, sin) of a vector of phases in turns; the bits of a lane do not depend on the other lanes."""
    # reduce to a quarter turn about the nearest half turn; the sign follows from the parity of the half turns
    halves = vec.whole(2.0 * phase)
    r = phase - 0.5 * halves
    odd = halves - 2.0 * vec.whole(0.5 * halves)
    sign = vec.fma(-2.0, odd * odd, vec.spread(1.0, phase))
    s = r * r
    c, sine = _polynomials(s)
    return sign * vec.fma(s, c, vec.spread(1.0, s)), sign * r * sine


@inlined
def cos_sin_at(phase):
    """(cos, sin) of one phase in turns."""
    c, s = cos_sin(vec.from_numbers((phase, phase), phase))
    return vec.lane(c, 0), vec.lane(s, 0)


@inlined
def turned(cos, sin, angle):
    """(cos, sin) advanced by an angle (in turns) of at most a quarter turn; vectors.

    Rotating (cos, sin) by a quarter turn changes no bits: both sums have the same terms in the same order.
    """
    square = angle * angle
    c, s = _polynomials(square)
    c, s = square * c, angle * s  # cos(angle) - 1 and sin(angle)
    return vec.fma(-1.0 * s, sin, vec.fma(c, cos, cos)), vec.fma(s, cos, vec.fma(c, sin, sin))


@inlined
def turns_of(c, s, speed, speed_rate):
    """The Turns with given cosines and sines, at speeds in Hz with rate speed_rate in Hz/s."""
    omega = TWO_PI * speed
    omega_dot = TWO_PI * speed_rate
    square = omega * omega
    return Turn(c, s, omega, vec.fma(omega_dot, s, square * c), vec.fma(-omega_dot, c, square * s), omega_dot)


@inlined
def pick(turns, i):
    """The Turn in lane i."""
    return Turn(
        vec.lane(turns.cos, i),
        vec.lane(turns.sin, i),
        vec.lane(turns.omega, i),
        vec.lane(turns.real, i),
        vec.lane(turns.imag, i),
        turns.omega_dot,
    )
