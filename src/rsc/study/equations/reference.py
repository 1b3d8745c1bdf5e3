"""A reference solution of a scene by scipy's DOP853, which ends its steps on every switch of a contact: no code of the kernel."""

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.errors import SolverError
from rsc.study.equations.equations import Equations, Switch

INSIDE = 6  # places in each step where the switches are looked at
ROUNDING = 1e-7  # of the largest value of a switching function in a stretch
SHORTEST = 1e-3  # of the longest step: shorter ones are not tried
NEAR, FAR = 1e-12, 1e-11  # relative tolerances whose difference is the error of a reference


def dop853(equations: Equations, times: NDArray[np.float64], rtol: float) -> NDArray[np.float64]:
    """(n_times, n_state) at rising times from 0 on, in s.

    Raises
    ------
    SolverError
        A step became too short.
    """
    from scipy.integrate import solve_ivp

    rows = np.empty((len(times), len(equations.start)))
    t, y = 0.0, equations.start
    states, filled, longest = equations.states(t, y), 0, equations.longest_step
    while filled < len(times):
        run: Any = solve_ivp(
            equations.rhs, (t, max(float(times[-1]), t)), y, "DOP853", events=equations.switches(states), dense_output=True,
            args=(states,), rtol=rtol, atol=rtol * equations.scale, max_step=longest,
        )  # fmt: skip
        if not run.success:
            raise SolverError(f"the reference ended at {t:.6g} s: {run.message}")
        if longest > SHORTEST * equations.longest_step and _missed(equations.switches(states), run):
            longest *= 0.25
            continue
        longest = equations.longest_step
        last = len(times) if run.status == 0 else int(np.searchsorted(times, run.t[-1], side="right"))
        if last > filled:
            rows[filled:last] = run.sol(times[filled:last]).T
        t, y, filled = float(run.t[-1]), run.y[:, -1], max(last, filled)
        for switch, hits in zip(equations.switches(states), run.t_events, strict=True):
            if len(hits):
                states = switch.after(t, y)
    return rows


def _missed(switches: list[Switch], run: Any) -> bool:
    """Whether one of the switches was passed and passed back within a step, which its sign at the steps does not show."""
    times = np.concatenate([np.linspace(*step, INSIDE + 2)[1:-1] for step in pairwise(run.t)])
    rows = run.sol(times).T
    for switch in switches:
        values = switch.direction * np.array([switch(t, y) for t, y in zip(times, rows, strict=True)])
        if values.max() > ROUNDING * np.abs(values).max():
            return True
    return False


def reference(equations: Equations, times: NDArray[np.float64]) -> tuple[NDArray[np.complex128], float]:
    """((n_times, n) complex m, its error in gaps): the displacements, and their largest difference to a run ten times coarser."""
    fine, coarse = (equations.displacements(dop853(equations, times, rtol)) for rtol in (NEAR, FAR))
    return fine, float(np.abs(fine - coarse).max() / equations.constants.gap.min())
