"""An integrator of your own beside rsc's: DOP853 of scipy, whose steps end on the switches of the contact, and Newmark's method.

`rsc.equations` gives the right-hand side of a scene with the states of its contacts and where they switch; `rsc.benchmark` puts
an integrator into a chart of error against time, beside rk45 and taylor8, against a reference that shares no code with them.
"""

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import rsc

REFERENCE = Path(__file__).parents[2] / "data" / "reference"


def dop853(equations, times, rtol):
    """States at the times; a step never crosses a switch."""
    t, y, rows = 0.0, equations.start, [equations.start]
    states = equations.states(t, y)
    while len(rows) < len(times):
        how = {"rtol": rtol, "atol": rtol * equations.scale, "args": (states,), "dense_output": True}
        switches = equations.switches(states)
        run = solve_ivp(equations.rhs, (t, times[-1]), y, "DOP853", events=switches, **how)
        t, y = run.t[-1], run.y[:, -1]
        rows += [run.sol(time) for time in times[len(rows) :] if time <= t]
        for switch, hits in zip(switches, run.t_events, strict=True):
            states = switch.after(t, y) if len(hits) else states
    return np.array(rows)


def newmark(equations, times, steps):
    """Average acceleration, so many steps between two times, each solved by Newton's method; switches are stepped over."""
    h, t, y, half = times[1] / steps, 0.0, equations.start, len(equations.start) // 2
    a, rows = equations.rhs(t, y)[half:], [y]
    for _ in times[1:]:
        for _ in range(int(steps)):
            t, x, v, new = t + h, y[:half], y[half:], a
            for _ in range(20):
                y = np.concatenate([x + h * v + h**2 / 4 * (a + new), v + h / 2 * (a + new)])
                J = equations.jacobian(t, y)[half:]
                off = new - equations.rhs(t, y)[half:]
                new = new - np.linalg.solve(np.eye(half) - h**2 / 4 * J[:, :half] - h / 2 * J[:, half:], off)
                if abs(off).max() < 1e-10 * abs(new).max():
                    break
            a = new
        rows.append(y)
    return np.array(rows)


scene = rsc.load_scene(REFERENCE / "laval.toml").with_values({"drive.speed": [50.0, 50.1], "drive.duration": 0.05})
chart = rsc.benchmark(scene, dop853, [1e-4, 1e-6, 1e-8], "DOP853 with events")
chart = rsc.benchmark(scene, newmark, [1, 2, 4, 8], "Newmark", beside=chart)
for point in chart.points:
    if not point.method.startswith("rsc"):
        print(f"{point.method}, {point.setting:g}: error of {point.error:.0e} gaps")
best = min(point.error for point in chart.points if point.method == "rsc taylor8")
print(f"rsc taylor8 agrees with the reference to {'1e-10' if best < 1e-10 else f'{best:.0e}'} gaps or better")
chart.plot().figure.savefig("own_integrator.png", dpi=110)
