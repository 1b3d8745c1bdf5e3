"""What the points of work_precision.py say: times at equal error, who is fastest, and the pictures."""

import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.patheffects
import matplotlib.pyplot as plt
import matplotlib.ticker
import numpy as np

TARGETS = (1e-3, 1e-4, 1e-6, 1e-8, 1e-9)
NAIVE, PLAIN_C, DP5 = "naive Numba DP5", "plain C, rsc's DP5", "rsc rk45"
TITLES = {
    "P1": "P1: Laval rotor in backward whirl, 30 s run-up, 8,300 damper switches",
    "P1c": "P1c: bouncing, 306 contact onsets in 10 s",
    "P2": "P2: ten disks and three stator masses in backward whirl, 10 s",
    "gyro": "gyro: the paper's gyroscopic rotor in backward whirl, 10 s through the synchronous resonance",
    "pump": "pump: whirl at two seals, run up by a motor's torque, a bearing that follows the speed, 5 s",
    "ROSS": "ROSS: two-disc finite-element rotor, 12 modes, 20 s run-up into the rub",
}
CAUSES = (
    "W wrong by > 1000 tol (fixed step: > 1 gap) but reported success, N NaN, B blow-up, "
    "C step collapsed or refused to go on, T time limit, R refused"
)
OURS = ("#c1121f", "#7b2cbf", "#00a08a")
COLOURS = {"yardstick": "#222222", "compiled": "#1d6fb8", "scipy": "#d98a00", "sundials": "#8c564b", "fixed": "#3a8f3a"}
MARKS = "osD^vP*X"
RAIL_FROM = 3.5  # gaps: where the picture's axis ends and the rail begins


def attempted(rows, name, label):
    """The points of a method on a problem, loosest first."""
    return [row for row in rows if row.problem == name and row.method == label and row.setting == row.setting]


def time_at(rows, name, label, target):
    """Seconds at an error by log-log interpolation on the worst error of this or any tighter setting, or None."""
    mine = [row for row in attempted(rows, name, label) if np.isfinite(row.error) and np.isfinite(row.seconds)]
    if not mine:
        return None
    error = np.maximum.accumulate([row.error for row in mine][::-1])[::-1]
    seconds = np.array([row.seconds for row in mine])
    below = np.flatnonzero(error <= target)
    if below.size == 0:
        return None
    # a looser setting may have taken longer than a tighter one: the cheapest way to the error counts
    first = below[0]
    best = float(seconds[first:].min())
    if first == 0 or error[first] == error[first - 1]:
        return best
    share = np.log(error[first - 1] / target) / np.log(error[first - 1] / error[first])
    return min(best, float(seconds[first - 1] * (seconds[first] / seconds[first - 1]) ** share))


def labels(rows, name):
    """Methods with points on a problem, in the order of the legend."""
    return list(dict.fromkeys(row.method for row in rows if row.problem == name and row.setting == row.setting))


def ranking(rows, name, target):
    """{label: seconds at the error}, fastest first."""
    found = {label: time_at(rows, name, label, target) for label in labels(rows, name)}
    return dict(sorted(((label, spent) for label, spent in found.items() if spent is not None), key=lambda item: item[1]))


def is_peer(label):
    """Whether a method is none of ours: neither rsc nor a yardstick."""
    return not label.startswith("rsc") and label not in (NAIVE, PLAIN_C)


def comparison(rows, name, target):
    """(line of the table, sentence on who beats rsc or None)."""
    ranked = ranking(rows, name, target)
    ours = next(((label, spent) for label, spent in ranked.items() if label.startswith("rsc")), None)
    peers = [(label, spent) for label, spent in ranked.items() if is_peer(label)]
    if ours is None:
        return (
            f"{name:5} {target:.0e}  rsc never reached it",
            f"at {target:.0e} rsc has no point, {len(peers)} peers have" if peers else None,
        )
    naive = ranked.get(NAIVE)
    line = f"{name:5} {target:.0e}  {ours[0]:14} {ours[1]:.4f} s  naive "
    line += f"{naive:.4f} s = {ours[1] / naive:.3f}" if naive else "never        "
    line += f"  best peer {peers[0][0]} {peers[0][1]:.4f} s = {ours[1] / peers[0][1]:.3f}" if peers else "  no peer reached it"
    beaten = [f"{label} by {ours[1] / spent:.2f}" for label, spent in peers if spent < ours[1]]
    return line, f"at {target:.0e} rsc is beaten by " + ", ".join(beaten) if beaten else None


def core_over_naive(rows, name):
    """rsc's DP5 core over the naive kernel at the targets that both reach, as text."""
    pairs = [(target, time_at(rows, name, DP5, target), time_at(rows, name, NAIVE, target)) for target in TARGETS]
    return ", ".join(f"{ours / naive:.3f} at {target:.0e}" for target, ours, naive in pairs if ours and naive) or "never both"


def ratio_to_c(rows, name):
    """Median over the settings of rsc's DP5 core over the C yardstick at the same tolerance, or None."""
    ours = {row.setting: row.seconds_min for row in attempted(rows, name, DP5) if np.isfinite(row.error)}
    theirs = {row.setting: row.seconds_min for row in attempted(rows, name, PLAIN_C) if np.isfinite(row.error)}
    both = [ours[setting] / theirs[setting] for setting in ours if setting in theirs]
    return float(np.median(both)) if both else None


def _common(notes):
    """Notes in order, those that are not of all problems behind the names of theirs."""
    named = {}
    for name, mine in notes.items():
        for note in mine:
            named.setdefault(note, []).append(name)
    return [note if len(names) == len(notes) else f"{', '.join(names)}: {note}" for note, names in named.items()]


def report(rows, notes):
    """The table as text: fastest at equal error, ratios, who beats rsc, first calls, absent peers; notes of every problem."""
    lines = [*_common(notes), "", "rsc's best method at equal error, ratio to the naive kernel and to the best peer:"]
    for name in dict.fromkeys(row.problem for row in rows):
        beaten = []
        for target in TARGETS:
            line, sentence = comparison(rows, name, target)
            lines.append(line)
            beaten += [sentence] if sentence else []
        lines += [f"      {sentence}" for sentence in beaten] or ["      rsc is on the front at every error"]
        lines.append(f"      DP5 core over naive: {core_over_naive(rows, name)}")
        ratio = ratio_to_c(rows, name)
        lines.append(
            f"      DP5 core over plain C, same tolerance, least times, median: {ratio:.2f}" if ratio else "      no C yardstick"
        )
    failures = [row for row in rows if row.cause and row.cause not in ("absent", "first call") and "not begun" not in row.remark]
    lines += [
        "",
        "points that failed: " + (", ".join(f"{r.problem} {r.method} {r.setting:g}: {r.cause}" for r in failures) or "none"),
    ]
    first = [f"{row.problem} {row.method} {row.setup:.1f}" for row in rows if row.cause == "first call" and row.setup >= 0.05]
    shared = "compilation; what several methods or problems share counts for the first of them; below 0.05 s left out"
    lines += ["", f"seconds of the first call ({shared}): " + ", ".join(first)]
    absent = [f"{row.problem} {row.method} ({row.remark})" for row in rows if row.cause == "absent"]
    lines += ["", "absent: " + (", ".join(absent) or "none")]
    return "\n".join("\n".join(textwrap.wrap(line, 170, subsequent_indent="    ")) for line in lines) + "\n"


def _style(label, family, members):
    """(colour, mark, line width) of a method."""
    place = members.index(label)
    if family == "rsc":
        return OURS[place % len(OURS)], MARKS[place % len(MARKS)], 2.6
    colour = matplotlib.colors.to_rgb(COLOURS[family])
    lighter = tuple(c + (1.0 - c) * 0.55 * place / max(len(members) - 1, 1) for c in colour)
    return lighter, MARKS[place % len(MARKS)], 1.3


def _draw(axes, rows, name, value, rail):
    """One panel: a curve through all points with an error; the failed ones hollow on the rail (W at its own error as well)."""
    families = {row.method: row.family for row in rows}
    handles = {}
    for label in labels(rows, name):
        members = [other for other in labels(rows, name) if families[other] == families[label]]
        colour, mark, width = _style(label, families[label], members)
        known = [row for row in attempted(rows, name, label) if row.cause in ("", "W") and row.error < RAIL_FROM]
        x, y = [max(row.error, 1e-16) for row in known], [value(row) for row in known]
        handles[label] = axes.plot(x, y, color=colour, marker=mark, lw=width, ms=5, zorder=3 if families[label] == "rsc" else 2)[
            0
        ]
        for row in known:
            if row.cause:
                axes.plot(row.error, value(row), marker=mark, mfc="white", mec=colour, ms=5, ls="none", zorder=4)
        if families[label] == "rsc" and x:
            rim = [matplotlib.patheffects.withStroke(linewidth=3, foreground="white")]
            look = {"color": colour, "fontsize": 10, "fontweight": "bold", "path_effects": rim, "zorder": 5}
            place = (-6, -14 - 12 * members.index(label))
            axes.annotate(label, (x[-1], y[-1]), place, textcoords="offset points", **look)
        if value(rows[0]._replace(seconds=1.0, calls=0)) == 1.0:
            spread = [[row.seconds - row.seconds_min for row in known], [row.seconds_max - row.seconds for row in known]]
            axes.errorbar(x, y, yerr=spread, fmt="none", ecolor=colour, elinewidth=0.8, zorder=1)
        for row in attempted(rows, name, label):
            if row.cause and np.isfinite(value(row)) and value(row) > 0.0:
                place = rail[row.cause]
                axes.plot(place, value(row), marker=mark, mfc="none", mec=colour, ms=6, ls="none", zorder=4)
    return handles


def picture(name, rows, notes, limit):
    """Figure of a problem: error against time and against calls, the fail rail at the right of both."""
    figure, panels = plt.subplots(1, 2, figsize=(15, 8.6))
    figure.subplots_adjust(left=0.055, right=0.82, top=0.93, bottom=0.25, wspace=0.16)
    mine = [row for row in rows if row.problem == name]
    # points that were never begun stand at the limit
    mine = [row._replace(seconds=limit, seconds_min=limit, seconds_max=limit) if row.cause == "T" else row for row in mine]
    least = min([row.error for row in mine if row.cause in ("", "W") and row.error > 0.0], default=1e-12)
    known = [row.reference_error for row in mine if row.setting == row.setting and np.isfinite(row.reference_error)]
    floor = max(100.0 * max(known, default=0.0), 1e-14)
    rail = {cause: 10.0 ** (1.0 + 0.55 * i) for i, cause in enumerate("WNBCTR")}
    quantities = (
        ("processor time, s", lambda row: row.seconds),
        ("calls of the right-hand side", lambda row: float(row.calls or np.nan)),
    )
    for axes, (title, value) in zip(panels, quantities, strict=True):
        handles = _draw(axes, mine, name, value, rail)
        axes.set(xscale="log", yscale="log", xlabel="largest displacement error, gaps", ylabel=title)
        axes.set_xlim(0.3 * least, 1.6 * rail["R"])
        axes.axvspan(RAIL_FROM, 1.6 * rail["R"], color="#f1e4e4", zorder=0)
        axes.axvspan(1e-17, floor, color="#eeeeee", zorder=0)
        for cause, place in rail.items():
            axes.text(
                place, 1.01, cause, transform=axes.get_xaxis_transform(), ha="center", va="bottom", fontsize=10, fontweight="bold"
            )
        axes.text(10.0**2.4, 0.985, "failed", transform=axes.get_xaxis_transform(), ha="center", va="top", fontsize=10)
        axes.yaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1.0, 2.0, 5.0), numticks=40))
        axes.yaxis.set_major_formatter(
            matplotlib.ticker.FuncFormatter(lambda value, _: f"{value:g}" if value < 1e4 else f"{value:.0e}")
        )
        axes.set_xticks([10.0**i for i in range(-14, 1, 2) if 10.0**i > axes.get_xlim()[0]])
        axes.minorticks_off()
        axes.grid(alpha=0.3)
    told = [_with_failures(mine, name, label) for label in handles]
    figure.legend(handles.values(), told, loc="center left", bbox_to_anchor=(0.825, 0.6), frameon=False, fontsize=9)
    figure.suptitle(TITLES[name], x=0.055, ha="left", fontsize=13)
    _caption(figure, name, mine, notes, floor)
    return figure


def _with_failures(rows, name, label):
    """A method's name with how many of its points failed and why: marks on the rail lie one upon another."""
    causes = [row.cause for row in attempted(rows, name, label)]
    failed = " ".join(f"{causes.count(cause)}{cause}" for cause in "WNBCTR" if cause in causes)
    return f"{label} ({failed})" if failed else label


def _caption(figure, name, rows, notes, floor):
    sentences = [sentence for target in TARGETS if (sentence := comparison(rows, name, target)[1])]
    ratio = ratio_to_c(rows, name)
    parts = [
        "Lower left is better. "
        + ("; ".join(sentences) if sentences else "rsc is on the front at every error from 1e-3 to 1e-9")
        + ".",
        f"rsc's DP5 core takes {ratio:.2f} times the plain C of the same algorithm." if ratio else "",
        f"Failed points, hollow on the rail (W also at its error) and counted in the legend: {CAUSES}.",
        "After a T the tighter settings of a method are not begun; they count as T and have no calls.",
        f"Grey at the left (below {floor:.0e}): less than 100 times the reference's own error.",
        "heyoka's calls: steps times (order + 1). Bars: least and largest time.",
        ". ".join(notes) + ".",
    ]
    absent = [row.method for row in rows if row.cause == "absent"]
    parts += ["Absent: " + ", ".join(absent) + "."] if absent else []
    figure.text(0.055, 0.17, "\n".join(textwrap.wrap(" ".join(parts), 185)), va="top", fontsize=9)
