"""The matrix picture of the hard dozen: a row per setting, a column per method, what happened in colour and letter."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Patch, Rectangle

COLOURS = {
    "wrong": "#c8102e", "nan": "#7a3b00", "blow-up": "#e07b00", "honest": "#ffd34d", "time": "#b4b4b4", "stiff": "#b9a2e0",
    "refused": "#9ecae9", "right": "#d5efd2",
}  # fmt: skip
DARK = ("wrong", "nan")


def _cell(row, letter):
    """Text of a cell: the letter and the error where there is one."""
    if np.isfinite(row["error"]) and row["class"] in ("right", "wrong"):
        return f"{letter}  {row['error']:.0e}".strip() if letter else f"{row['error']:.0e}"
    if row["class"] == "time":
        return f"T  at {100 * row['reached_s'] / row['duration_s']:.0f} %"
    return letter


def picture(rows, classes, path, caption):
    """Write the matrix to `path`; classes: name -> (letter, words)."""
    settings = list(dict.fromkeys((r["scene"], r["name"], r["setting"], r["oracle"]) for r in rows))
    methods = list(dict.fromkeys(r["method"] for r in rows))
    found = {(r["scene"], r["setting"], r["method"]): r for r in rows}
    # inches: names of scenes and settings left, oracles right, heading above, legend below
    left, right, top, bottom = 4.2, 1.45, 1.35, 0.75
    width, height = left + right + 1.05 * len(methods), top + bottom + 0.27 * (len(settings) + 1.4)
    figure = plt.figure(figsize=(width, height))
    across, up = 1.05 * len(methods) / width, (height - top - bottom) / height
    axes = figure.add_axes((left / width, bottom / height, across, up))
    for y, (scene, _, setting, _) in enumerate(settings):
        for x, method in enumerate(methods):
            row = found[scene, setting, method]
            axes.add_patch(Rectangle((x, y), 1, 1, facecolor=COLOURS[row["class"]], edgecolor="white", linewidth=1.2))
            ink = "white" if row["class"] in DARK else "black"
            weight = "normal" if row["class"] in ("right", "time") else "bold"
            text = _cell(row, classes[row["class"]][0])
            axes.text(x + 0.5, y + 0.5, text, ha="center", va="center", fontsize=8, color=ink, weight=weight)
    _frame(axes, settings, methods, (0.98 * left / (1.05 * len(methods)), 0.98 * right / (1.05 * len(methods))))
    for x, method in enumerate(methods):
        mine = [r["class"] for r in rows if r["method"] == method]
        text = f"{mine.count('right')} right\n{mine.count('wrong')} W"
        ink = "#c8102e" if mine.count("wrong") else "black"
        axes.text(x + 0.5, len(settings) + 0.25, text, ha="center", va="top", fontsize=8.5, weight="bold", color=ink)
    told = {name: f"{letter}: {words}" if letter else words for name, (letter, words) in classes.items()}
    handles = [Patch(facecolor=COLOURS[name], label=words) for name, words in told.items()]
    figure.legend(handles=handles, loc="lower center", ncols=4, fontsize=8.5, frameon=False)
    figure.text(0.01, 1.0 - 0.12 / height, "The hard dozen: what happened to each method", fontsize=14, weight="bold", va="top")
    figure.text(
        0.01, 1.0 - 0.42 / height,
        "Number in a field: error against the scene's oracle over the largest displacement (S9: energy drift per 100 impacts; "
        "S12 chaos: Kolmogorov-Smirnov distance).\n"
        "Wrong: beyond 1000 x rtol (rtol 1e-6), fixed steps beyond 1 %. Fixed steps of 20 us, in S11 100 us. scipy: compiled "
        "right-hand side that ignores the switches.\n"
        f"{caption}",
        fontsize=8, va="top", linespacing=1.3,
    )  # fmt: skip
    figure.savefig(path, dpi=130)
    plt.close(figure)


def _frame(axes, settings, methods, margins):
    """Axes without ticks, labels of rows and columns, lines between scenes; margins in widths of the axes."""
    left, right = margins
    axes.set_xlim(0, len(methods))
    axes.set_ylim(len(settings) + 1.4, 0)
    axes.set_xticks(np.arange(len(methods)) + 0.5, methods, fontsize=9, weight="bold")
    axes.xaxis.set_ticks_position("top")
    axes.set_yticks(np.arange(len(settings)) + 0.5, [setting for _, _, setting, _ in settings], fontsize=8.5)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)
    blended = axes.get_yaxis_transform()
    names = [scene for scene, *_ in settings]
    for scene in dict.fromkeys(names):
        first, count = names.index(scene), names.count(scene)
        axes.plot([-left, 1.0 + right], [first, first], color="0.6", linewidth=0.8, transform=blended, clip_on=False)
        _, title, _, _ = settings[first]
        label = f"{scene}  {title}"
        axes.text(-left + 0.01, first + 0.5, label, transform=blended, ha="left", va="center", fontsize=9, weight="bold")
        oracles = list(dict.fromkeys(o.split(",")[0] for _, _, _, o in settings[first : first + count]))
        axes.text(1.015, first + 0.5, oracles[0], transform=blended, ha="left", va="center", fontsize=8, color="0.25")
        for k, oracle in enumerate(oracles[1:], 1):
            axes.text(1.015, first + 0.5 + k, oracle, transform=blended, ha="left", va="center", fontsize=8, color="0.25")
    axes.text(1.015, -0.35, "oracle", transform=blended, ha="left", va="center", fontsize=9, weight="bold")
