"""Step cost and right-hand-side cost of the kernel over the number of coordinates; no assertion on times.

    pytest bench/suite --benchmark-only

`extra_info` of each benchmark holds nanoseconds per step or per right-hand side of the fastest round.
"""

import numpy as np
import pytest

import rsc
from rsc.kernel import model as kernel
from rsc.kernel.march import march
from rsc.simulation.pack import pack
from rsc.simulation.run import new_work
from rsc.simulation.stretches import room_for
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble

SIZES = ((1, 1), (2, 1), (4, 2), (10, 3), (13, 3))
STEPS = 20_000


def chain(n_rotor, n_stator):
    """Chain of disks in a stable whirl in a chain of masses: first frequencies 30 and 150 Hz whatever the numbers of masses."""
    k_r = (2.0 * np.pi * 30.0 / (2.0 * np.sin(0.5 * np.pi / (n_rotor + 1)))) ** 2
    k_s = 0.25 * (2.0 * np.pi * 150.0 / (2.0 * np.sin(0.5 * np.pi / (2 * n_stator + 1)))) ** 2
    middle = n_rotor // 2
    # with these each has a stable whirl
    friction = 0.2 if n_rotor < 4 else 0.3
    return rsc.Scene.from_dict({
        "rotor": {"model": "chain", "masses": [1.0] * n_rotor, "stiffnesses": [k_r] * (n_rotor + 1), "damping_ratio": 0.02,
                  "eccentricity": 1e-5},
        "stator": {"model": "chain", "masses": [0.25] * n_stator, "stiffnesses": [k_s] * n_stator + [0.0], "damping_ratio": 0.1},
        "contact": {"rotor_coordinate": middle, "stator_coordinate": n_stator - 1, "gap": 1e-3, "friction": friction,
                    "stiffness": 3.55e6, "damping_ratio": 0.05},
        "drive": {"speed": [20.0, 60.0], "duration": 1e4},
        "start": {"whirl": "backward"},
    })  # fmt: skip


@pytest.mark.parametrize(("n_rotor", "n_stator"), SIZES)
def test_step(benchmark, n_rotor, n_stator):
    """20,000 attempted steps of the run, output at 2 kHz included."""
    scene = chain(n_rotor, n_stator)
    system = assemble(scene)
    packed = pack(system, scene.solver, 2000.0)
    start = initial_state(scene, system)
    out = np.zeros((200_000, 2 * (n_rotor + n_stator) + 3))
    counts = []

    def fresh():
        return (packed.model, new_work(packed, start), out, room_for(packed.model), packed.width, packed.method, STEPS), {}

    def run(*arguments):
        march(*arguments)
        counts.append(arguments[1].count)

    benchmark.pedantic(run, setup=fresh, rounds=7, warmup_rounds=1)
    steps, calls = (int(counts[-1][i]) for i in (kernel.STEPS, kernel.RHS_CALLS))
    assert steps > STEPS // 2
    if benchmark.stats:
        fastest = benchmark.stats.stats.min
        benchmark.extra_info["ns_per_step"] = 1e9 * fastest / steps
        benchmark.extra_info["ns_per_right_hand_side"] = 1e9 * fastest / calls
