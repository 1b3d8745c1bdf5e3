"""Picture of the physics that a tolerance changes: jump speed, agreement horizon, statistics."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import LogLocator


def picture(jump_rows, chaos_rows, facts, path, caption):
    """Three panels."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(15.5, 5.2), layout="constrained")
    _jumps(left, jump_rows)
    rtol = np.array([row["rtol"] for row in chaos_rows])
    _horizon(middle, chaos_rows, rtol, facts)
    _statistics(right, chaos_rows, rtol, facts)
    for ax in (left, middle, right):
        ax.set_xscale("log")
        ax.set_xlabel("rtol")
        ax.xaxis.set_major_locator(LogLocator(numticks=20))
        ax.grid(True, which="major", color="0.9")
        ax.set_axisbelow(True)
    figure.suptitle(f"Physics that a tolerance changes ({caption})", fontsize=10)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def _jumps(ax, rows):
    durations = list(dict.fromkeys(row["duration_s"] for row in rows))
    for k, duration in enumerate(durations):
        mine = [row for row in rows if row["duration_s"] == duration]
        colour = plt.get_cmap("viridis")(k / max(len(durations) - 1, 1) * 0.85)
        label = f"{duration:g} s ({mine[0]['rate_hz_per_s']:.2g} Hz/s)"
        ax.plot([row["rtol"] for row in mine], [row["jump_hz"] for row in mine], "o-", color=colour, label=label)
        ax.axhline(mine[0]["predicted_jump_hz"], color=colour, linestyle="--", linewidth=1.2)
    ax.axhline(rows[0]["crossing_hz"], color="black", linewidth=1.0)
    words = f"stability lost, {rows[0]['crossing_hz']:.1f} Hz"
    ax.text(0.98, rows[0]["crossing_hz"] + 0.6, words, ha="right", va="bottom", fontsize=9, transform=ax.get_yaxis_transform())
    ax.plot([], [], color="0.4", linestyle="--", label="predicted (rsc.analysis.follow.delayed_jump)")
    ax.set(ylabel="jump speed in Hz", title="Delayed jump of a run-up, 20 to 150 Hz")
    ax.set_ylim(bottom=48.0)
    ax.legend(fontsize=8.5, ncols=2, loc="lower left")


def _horizon(ax, rows, rtol, facts):
    median = np.array([row["horizon_turns"] for row in rows])
    spread = [median - [row["horizon_least"] for row in rows], [row["horizon_most"] for row in rows] - median]
    ax.errorbar(rtol, median, yerr=spread, fmt="o", color="#1f4e9c", capsize=3, label="simulated: median and range of the starts")
    growth = facts["growth_per_turn"]
    fine = np.logspace(np.log10(rtol.min()), np.log10(rtol.max()), 50)
    label = f"ln(0.01 / rtol) / {growth:.2f}: growth per turn by a shadow run"
    ax.plot(fine, np.maximum(np.log(1e-2 / fine) / growth, 0.0), color="black", linestyle="--", label=label)
    ax.set(ylabel="turns until 1 % of the gap apart", title="Chaotic partial rub: agreement with rtol 1e-13", ylim=(0.0, None))
    ax.legend(fontsize=8.5, loc="upper right")


def _statistics(ax, rows, rtol, facts):
    distance = [max(row["ks_to_tightest"], 1e-4) for row in rows[:-1]]
    periodic = np.array([row["attractor_period_turns"] > 0 for row in rows[:-1]])
    ax.plot(rtol[:-1], distance, "o", color="#1f4e9c", label="KS distance of |r| to the tightest rtol")
    if periodic.any():
        ax.plot(rtol[:-1][periodic], np.array(distance)[periodic], "s", color="#c8102e", markerfacecolor="none", markersize=11,
                label="settled on a periodic motion")  # fmt: skip
    ax.axhline(facts["alarm_level"], color="black", linestyle="--", label="alarm level, 1 % false alarms (blocks drawn again)")
    ax.axhline(facts["ks_friction_20_percent"], color="#c8102e", linestyle=":", label="friction + 20 %")
    title = f"Chaotic partial rub: statistics over {facts['turns']:,} turns"
    ax.set(yscale="log", ylabel="Kolmogorov-Smirnov distance", title=title)
    ax.legend(fontsize=8.5, loc="best")
