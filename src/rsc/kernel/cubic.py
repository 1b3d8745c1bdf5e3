"""Inside a step: the cubic through values and slopes at both ends, its extrema, and where it first reaches a size."""

from rsc.kernel.simd.jit import compiled, inlined

LOOKS, HALVINGS = 16, 40  # for locating when a gap is exceeded


@inlined
def extreme(f, f_new, slope, slope_new):
    """Extremum inside a step by the cubic Hermite polynomial, if the slopes at its ends differ in sign; else the final value."""
    if not slope * slope_new < 0.0:
        return f_new
    a, b = 0.0, 1.0
    slope_a, slope_b = slope, slope_new
    value = f_new
    for _ in range(2):
        theta = a + (b - a) * slope_a / (slope_a - slope_b)
        value, between = cubic(f, f_new, slope, slope_new, theta)
        if between * slope > 0.0:
            a, slope_a = theta, between
        else:
            b, slope_b = theta, between
    return value


@inlined
def largest_between(begin, end, h):
    """(largest |r|^2 inside a step, its theta in 0 to 1) where |r| grows at the start and shrinks at the end; begin = (r, r'),
    end likewise; r as a cubic."""
    (y, z), (y_dot, z_dot) = begin
    (y_new, z_new), (y_dot_new, z_dot_new) = end
    a, b = 0.0, 1.0
    slope_a, slope_b = y * y_dot + z * z_dot, y_new * y_dot_new + z_new * z_dot_new
    largest = theta = 0.0
    for _ in range(2):
        theta = a + (b - a) * slope_a / (slope_a - slope_b)
        p, p_dot = cubic(y, y_new, h * y_dot, h * y_dot_new, theta)
        q, q_dot = cubic(z, z_new, h * z_dot, h * z_dot_new, theta)
        largest, slope = max(largest, p * p + q * q), (p * p_dot + q * q_dot) / h
        if slope > 0.0:
            a, slope_a = theta, slope
        else:
            b, slope_b = theta, slope
    return largest, theta


@inlined
def cubic(f_0, f_1, slope_0, slope_1, theta):
    """(value, slope) at theta in [0, 1] of the cubic with these values and slopes at 0 and 1."""
    rise, left = f_1 - f_0, 1.0 - theta
    bend, twist = slope_0 - rise, rise - slope_1
    value = f_0 + theta * (rise + left * (left * bend + theta * twist))
    slope = rise + left * (left - 2.0 * theta) * bend + theta * (2.0 * left - theta) * twist
    return value, slope


@compiled
def passage(begin, end, h, gap):
    """theta in 0 to 1 at which |d| first reaches a gap in a step; d as a cubic."""
    (y, z), (y_dot, z_dot) = begin
    (y_new, z_new), (y_dot_new, z_dot_new) = end
    a, b = 0.0, 1.0
    for i in range(1, LOOKS):
        theta = i / LOOKS
        p = cubic(y, y_new, h * y_dot, h * y_dot_new, theta)[0]
        q = cubic(z, z_new, h * z_dot, h * z_dot_new, theta)[0]
        if p * p + q * q > gap * gap:
            b = theta
            break
        a = theta
    for _ in range(HALVINGS):
        theta = 0.5 * (a + b)
        p = cubic(y, y_new, h * y_dot, h * y_dot_new, theta)[0]
        q = cubic(z, z_new, h * z_dot, h * z_dot_new, theta)[0]
        if p * p + q * q > gap * gap:
            b = theta
        else:
            a = theta
    return b
