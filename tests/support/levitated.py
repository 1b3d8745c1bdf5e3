"""A chain of masses in magnetic bearings that fail: its equations written down once more, in components, by SciPy alone."""

import numpy as np
from scipy.integrate import solve_ivp


def controllers(bearings, t, x, states):
    """(force on the masses (n, 2), rates) of bearings [(mass number, keys)] with states (bearings, 3, 2): a, q, u."""
    force, rates = np.zeros_like(x), np.empty_like(states)
    for (place, keys), (a, q, u), rate in zip(bearings, states, rates, strict=True):
        filtered, lag = keys["derivative_filter"] * (x[place] - a), 2.0 * np.pi * keys["amplifier"]
        wanted = keys["proportional"] * x[place] + keys["integral"] * q + keys["derivative"] * filtered
        rate[:] = filtered, x[place], lag * (wanted - u)
        if t < keys.get("off", np.inf):
            force[place] += keys["negative_stiffness"] * x[place] - u
    return force, rates


def motion(rotor, stator, contact, speed, times, start):
    """Displacements (times, n, 2) of the masses, with constant speed in Hz and without friction that changes its direction.

    rotor : masses, eccentricity, stiffness between neighbours, gravity, bearings; stator : mass, stiffness, damping;
    contact : gap, stiffness, friction, diameter, slip_velocity, at the last mass; start : (n, 2) displacements at rest
    """
    masses, n, Omega = np.array(rotor["masses"]), len(rotor["masses"]), 2.0 * np.pi * speed
    spring, count = rotor["stiffness"], len(rotor["bearings"])
    links = spring * (np.diag([1.0] + [2.0] * (n - 2) + [1.0]) - np.eye(n, k=1) - np.eye(n, k=-1))

    def split(y):
        x, v, s, w = np.split(y[: 4 * n + 4].reshape(-1, 2), [n, 2 * n, 2 * n + 1])
        return x, v, s[0], w[0], y[4 * n + 4 :].reshape(count, 3, 2)

    def rates(t, y, until):
        x, v, s, w, z = split(y)
        force, turned = controllers(rotor["bearings"], min(t, until), x, z)
        angle = Omega * t
        heavy = rotor["eccentricity"] * Omega**2 * masses[:, None] * np.array([np.cos(angle), np.sin(angle)])
        force += heavy - links @ x - rotor["gravity"] * np.outer(masses, [0.0, 1.0])
        apart, moving = x[-1] - s, v[-1] - w
        distance = np.hypot(*apart)
        pressed = np.zeros(2)
        if distance > contact["gap"]:
            out = apart / distance
            along = np.array([-out[1], out[0]])
            slip = Omega * contact["diameter"] / 2.0 + moving @ along
            sliding = contact["friction"] * np.clip(slip / contact["slip_velocity"], -1.0, 1.0)
            pressed = contact["stiffness"] * (distance - contact["gap"]) * (out + sliding * along)
            force[-1] -= pressed
        carried = (pressed - stator["stiffness"] * s - stator["damping"] * w) / stator["mass"]
        return np.concatenate([v.ravel(), (force / masses[:, None]).ravel(), w, carried, turned.ravel()])

    y = np.concatenate([np.ravel(start), np.zeros(2 * n + 4 + 6 * count)])
    failures = sorted({keys["off"] for _, keys in rotor["bearings"] if "off" in keys})
    seen, begin = [], 0.0
    for end in (*failures, times[-1]):
        inside = times[(times >= begin) & ((times < end) | (end == times[-1]))]
        until = np.nextafter(end, 0.0) if end in failures else np.inf
        atol = 1e-13 * np.concatenate([np.full(2 * n, contact["gap"]), np.full(len(y) - 2 * n, 1.0)])
        asked = np.union1d(inside, end)
        piece = solve_ivp(rates, (begin, end), y, "DOP853", asked, args=(until,), rtol=1e-11, atol=atol, max_step=2e-4)
        seen.append(piece.y[: 2 * n, : len(inside)].T.reshape(-1, n, 2))
        begin, y = end, piece.y[:, -1]
    return np.concatenate(seen)
