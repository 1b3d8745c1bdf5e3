"""Whirl with unbalance: harmonic balance, first order and the paper's (28) beside the simulator.

    python bench/balance_table.py           prints the table
    python bench/balance_table.py --write   keeps it in bench/results

Each row is a run at constant speed, started on the whirl without unbalance and long enough to forget that.
"""

import sys
from pathlib import Path

import numpy as np

import rsc
from rsc.analysis.balance.balance import NotBalanced, balance
from rsc.analysis.balance.floquet import balance_growth
from rsc.analysis.paper.predict import predict_system
from rsc.system.assemble import assemble

ROOT = Path(__file__).parent.parent
REFERENCE = ROOT / "data" / "reference"
sys.path.insert(0, str(ROOT / "tools"))

from pages import RESULTS, write_page  # noqa: E402

RATE = 4000.0
SPAN = 2.0  # s of steady motion that is measured
MOST_SETTLING = 90.0  # s

# scene, whirl frequency Hz, rotor speed Hz
CASES = [
    ("laval", -60.66, 50.0),
    ("laval", -60.66, 80.0),
    ("mdof_2x2", -12.90, 20.0),
    ("mdof_2x2", -38.04, 20.0),
    ("gyroscopic_disk_very_light", -24.36, 60.0),
    ("gyroscopic_disk_very_light", -48.81, 60.0),
    ("gyroscopic_disk_light", -22.10, 70.0),
    ("gyroscopic_transition", -34.69, 60.0),
    ("gyroscopic_transition", -49.60, 90.0),
    ("chain_10", -44.59, 40.0),
]
RATIOS = (0.01, 0.03, 0.1)


def with_unbalance(scene, ratio):
    """A scene whose largest mass eccentricity is a share of its gap."""
    rotor, amount = scene.rotor, ratio * scene.contact.gap
    if rotor.model in ("laval", "disk"):
        return scene.with_values({"rotor.eccentricity": amount})
    own = np.abs([complex(item) for item in rotor.eccentricity])
    return scene.with_values({"rotor.eccentricity": [float(item) for item in own / own.max() * amount]})


def simulated(scene, whirl):
    """Frequency (Hz), envelope (m, m) and contact share of the steady end of a run started on a whirl."""
    settling = min(16.0 / abs(whirl.growth_rate), MOST_SETTLING)
    content = scene.with_values({"solver.rtol": 1e-9, "output.rate": RATE}).to_dict()
    content["drive"] = {"speed": whirl.speed, "duration": settling + SPAN}
    content["start"] = {"whirl": whirl.frequency}
    result = rsc.simulate(rsc.Scene.from_dict(content))
    n = int(SPAN * RATE)
    motion, force = result.contact_rotor()[-n:], result.normal_force[-n:]
    return _frequency(motion, whirl.frequency), _extremes(np.abs(motion)), float((force > 0.0).mean())


def _frequency(motion, near):
    """Frequency of the strongest line next to a frequency, by the phase between two windows."""
    for _ in range(3):
        half = len(motion) // 2
        turned = motion * np.exp(-2j * np.pi * near * np.arange(len(motion)) / RATE)
        first, second = ((turned[i * half : (i + 1) * half] * np.kaiser(half, 20.0)).sum() for i in (0, 1))
        near += np.angle(second / first) / (2.0 * np.pi * half / RATE)
    return near


def _extremes(size):
    """Smallest and largest value of samples, refined by a parabola."""
    ends = []
    for i in (np.argmin(size[1:-1]) + 1, np.argmax(size[1:-1]) + 1):
        left, mid, right = size[i - 1 : i + 2]
        bend = left - 2.0 * mid + right
        ends.append(mid - (right - left) ** 2 / (8.0 * bend) if bend else mid)
    return tuple(ends)


def error(found, wanted):
    """Largest relative error of an envelope."""
    return max(abs(a / b - 1.0) for a, b in zip(found, wanted, strict=True))


def compared(name, frequency, speed, ratio):
    """System, (simulated frequency, envelope, contact share), Balance or the share reached, Whirl of one row."""
    scene = with_unbalance(rsc.load_scene(REFERENCE / f"{name}.toml"), ratio)
    system = assemble(scene)
    whirl = min(predict_system(system, speed), key=lambda w: abs(w.frequency - frequency))
    try:
        found = balance(system, whirl.frequency, speed)
    except NotBalanced as failure:
        found = failure.reached
    return system, simulated(scene, whirl), found, whirl


def row(case, ratio):
    """A line of the table."""
    system, (frequency, envelope, share), found, whirl = compared(*case, ratio)
    gap = system.gap
    start = f"| {case[0]} | {case[2]:g} | {whirl.frequency:.2f} | {ratio:g} |"
    if isinstance(found, float):
        end = "contact lost" if share < 1.0 else "on its way out of contact"
        return f"{start} {end} | | no such motion above ecc/gap {found * ratio:.4f} (fold) | | | |"
    if share < 1.0:
        rate = balance_growth(system, found).rate
        return f"{start} contact lost | | unstable, growth rate {rate:+.2f} 1/s | | | |"
    balanced, consistent, printed = (
        error(e, envelope) for e in (found.envelope, whirl.synchronous.consistent.envelope, whirl.synchronous.printed.envelope)
    )
    return (
        f"{start} {frequency:.5f} | {envelope[0] / gap:.5f} .. {envelope[1] / gap:.5f} "
        f"| {abs(found.frequency / frequency - 1.0):.0e} | {balanced:.0e} | {consistent:.1e} | {printed:.1e} |"
    )


def table():
    """The whole table as Markdown."""
    lines = [
        "| scene | speed Hz | whirl Hz | ecc/gap | simulated Psi Hz | simulated envelope / gap "
        "| balance: error of Psi | balance: envelope | first order | paper (28) |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for case in CASES:
        for ratio in RATIOS:
            lines.append(row(case, ratio))
            print(lines[-1], file=sys.stderr, flush=True)
    return "\n".join(lines)


def main():
    """Print the table, or keep it."""
    text = table()
    if "--write" not in sys.argv[1:]:
        print(text)
        return
    title = "Whirls with unbalance, predicted and simulated"
    write_page(RESULTS / "balance_table.md", title, "python bench/balance_table.py --write", text)


if __name__ == "__main__":
    main()
