"""Pictures of the stability maps."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

FINE, GOOD, WRONG, BLOWN, STOPPED = range(5)
COLOURS = ("#7fbf7b", "#d5efd2", "#c8102e", "#e07b00", "#ffd34d")
LABELS = ("error <= 1e-4", "error <= 1 %", "wrong (> 1 %), reported as success", "blow-up", "stopped with a reason")


def _grid(rows, x, y):
    """Sorted values of two columns and a function that lays a third out as (y, x)."""
    xs, ys = (np.array(sorted({float(row[name]) for row in rows})) for name in (x, y))

    def laid(value):
        out = np.full((ys.size, xs.size), np.nan)
        for row in rows:
            out[np.searchsorted(ys, float(row[y])), np.searchsorted(xs, float(row[x]))] = value(row)
        return out

    return xs, ys, laid


def _edges(values):
    """Edges of cells around logarithmic values."""
    logs = np.log10(values)
    middle = 0.5 * (logs[1:] + logs[:-1])
    return 10.0 ** np.concatenate([[2 * logs[0] - middle[0]], middle, [2 * logs[-1] - middle[-1]]])


def _class(row):
    if row["class"] == "blow-up" or row["class"] == "nan":
        return BLOWN
    if row["class"] not in ("right", "wrong"):
        return STOPPED
    return FINE if row["error"] <= 1e-4 else GOOD if row["error"] <= 1e-2 else WRONG


def _over(rows, name):
    """(stiffness ratios, values) of a quantity that depends on the stiffness only."""
    found = {row["stiffness_ratio"]: row[name] for row in rows}
    ratios = sorted(found)
    return np.array(ratios), np.array([found[r] for r in ratios])


def fixed_picture(rows, scenes, path, caption):
    """RK4 and Newmark: what happened over stiffness and step."""
    figure, axes = plt.subplots(2, 2, figsize=(11, 8.6), sharex=True, sharey=True, layout="constrained")
    cmap = ListedColormap(COLOURS)
    for i, method in enumerate(("RK4", "Newmark")):
        for j, scene in enumerate(scenes):
            mine = [row for row in rows if row["method"] == method and row["scene"] == scene]
            xs, ys, laid = _grid(mine, "stiffness_ratio", "h_s")
            ax = axes[i, j]
            ax.pcolormesh(_edges(xs), _edges(ys), laid(_class), cmap=cmap, norm=BoundaryNorm(np.arange(6) - 0.5, 5))
            ratios, omega = _over(mine, "contact_frequency_rad_s")
            ax.plot(ratios, 2.0 * np.sqrt(2.0) / omega, color="black", linewidth=1.6)
            ax.plot(ratios, np.pi / omega / 10.0, color="black", linewidth=1.6, linestyle="--")
            ax.set(xscale="log", yscale="log", title=f"{method}: {scene}", ylim=(_edges(ys)[0], _edges(ys)[-1]))
            ax.set_xlim(_edges(xs)[0], _edges(xs)[-1])
            if i == 1:
                ax.set_xlabel("contact stiffness / rotor stiffness")
            if j == 0:
                ax.set_ylabel("step h in s")
    handles = [Patch(facecolor=c, label=text) for c, text in zip(COLOURS, LABELS, strict=True)]
    handles += [
        Line2D([], [], color="black", label="h omega_C = 2.83: RK4's limit on the imaginary axis"),
        Line2D([], [], color="black", linestyle="--", label="10 steps in half a period of the contact"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False, fontsize=9)
    figure.suptitle(f"Fixed steps: what happened in 50 ms of motion, switches ignored ({caption})", fontsize=10)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def rsc_picture(rows, scenes, method, path, caption):
    """rsc: error over tolerance, and mean step over the stability limit of Dormand-Prince 5(4)."""
    figure, axes = plt.subplots(2, 2, figsize=(11, 8.6), sharex=True, sharey=True, layout="constrained")
    for j, scene in enumerate(scenes):
        mine = [row for row in rows if row["method"] == method and row["scene"] == scene]
        xs, ys, laid = _grid(mine, "stiffness_ratio", "rtol")
        share = laid(lambda row: row["h_s"] / row["limit_dp5_s"])
        error = laid(lambda row: max(row["error"], 1e-16) / row["rtol"])
        above = axes[0, j].pcolormesh(_edges(xs), _edges(ys), np.log10(error), cmap="RdYlGn_r", vmin=-5, vmax=5)
        below = axes[1, j].pcolormesh(_edges(xs), _edges(ys), share, cmap="cividis", vmin=0.0, vmax=1.0)
        for ax in axes[:, j]:
            ax.set(xscale="log", yscale="log", xlim=(_edges(xs)[0], _edges(xs)[-1]), ylim=(_edges(ys)[0], _edges(ys)[-1]))
            for level, style in ((0.6, "-"), (1.0, "--")):
                if np.nanmax(share) > level:
                    ax.contour(xs, ys, share, levels=[level], colors="black", linewidths=1.5, linestyles=style)
            _marks(ax, mine)
        _chatter(axes[1, j], mine)
        axes[0, j].set_title(f"{scene}: error / rtol", fontsize=11)
        what = "mean step" if "rub" in scene else "contact time / steps"
        axes[1, j].set_title(f"{scene}: {what}, over the stability limit", fontsize=11)
        axes[1, j].set_xlabel("contact stiffness / rotor stiffness")
    for i in (0, 1):
        axes[i, 0].set_ylabel("rtol")
    bar = figure.colorbar(above, ax=axes[0], label="error over largest displacement / rtol", ticks=range(-4, 5, 2))
    bar.ax.set_yticklabels([f"1e{k}" if k else "1" for k in range(-4, 5, 2)])
    figure.colorbar(below, ax=axes[1], label="step / stability limit of DP5 in closed contact")
    handles = [
        Line2D([], [], color="black", label="step = 0.6 of the limit: below, error control sets it; above, stability"),
        Line2D([], [], color="black", linestyle="--", label="step = the limit: above, contact chatters within the tolerance"),
        Line2D([], [], color="#ff00c8", marker="o", markersize=4, linestyle="", label="more than twice the true contact onsets"),
        Line2D([], [], color="red", marker="x", linestyle="", label="error > 1000 rtol reported as success"),
        Line2D([], [], color="blue", marker="s", markerfacecolor="none", linestyle="", label="stopped with a reason"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False, fontsize=9)
    figure.suptitle(f"{method}: where its accuracy comes from, 50 ms of motion ({caption})", fontsize=10)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def _marks(ax, rows):
    """Failed attempts, drawn."""
    wrong = [(row["stiffness_ratio"], row["rtol"]) for row in rows if row["class"] == "wrong"]
    stopped = [(row["stiffness_ratio"], row["rtol"]) for row in rows if row["class"] not in ("right", "wrong")]
    if wrong:
        ax.plot(*zip(*wrong, strict=True), "x", color="red", markersize=5)
    if stopped:
        ax.plot(*zip(*stopped, strict=True), "s", color="blue", markerfacecolor="none", markersize=5)


def _chatter(ax, rows):
    """Mark runs that count more than twice the contact onsets of the tightest run: right motion, wrong forces and counts."""
    tightest = min(row["rtol"] for row in rows)
    true = {row["stiffness_ratio"]: int(row["onsets"]) for row in rows if row["rtol"] == tightest}
    found = [(row["stiffness_ratio"], row["rtol"]) for row in rows if int(row["onsets"]) > 2 * true[row["stiffness_ratio"]]]
    if found:
        ax.plot(*zip(*found, strict=True), "o", color="#ff00c8", markersize=3.5)
