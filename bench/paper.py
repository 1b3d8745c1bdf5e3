"""The paper's Figures 3 to 6 drawn from the reference scenes, and every number of its text beside prediction and simulation.

    python bench/paper.py [3-left|3-right|4|5|6|table]        without an argument all of them

Writes results/paper_3_left.png, ..., results/paper_6.png and results/paper.md. The parameters of the paper are not published: the
scenes are reconstructions (data/reference/README.md), so the pictures show the paper's findings and not its machine.
"""

import argparse
import csv
import io
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from PIL import Image

import rsc
from problems import DATA, RESULTS
from rsc.analysis.balance.balance import HARMONICS, balance
from rsc.analysis.follow.branches import branches
from rsc.analysis.paper.synchronous import synchronous_resonance
from rsc.analysis.survey.survey import survey
from rsc.measure.words import FREQUENCY, TOLERANCES
from rsc.show.pictures.axes import HALO
from rsc.show.pictures.report_pictures import amplitude, campbell
from rsc.system.assemble import assemble

SCENES = {
    "left": "gyroscopic_figure3_left", "right": "gyroscopic_figure3_right", "run-up": "mdof_2x2", "run-down": "mdof_2x2_rundown",
}  # fmt: skip
WIDE = (1.0, 300.0)  # Hz, speeds over which the ends of the whirl of Figure 4 are looked for
COLOURS = 256  # of a stored picture


@cache
def scene_of(run):
    """Scene of one of SCENES, or "B down": that of Figure 3 (right) running down from 80 Hz on whirl B."""
    if run == "B down":
        whirl = whirl_of("right", 80.0, -43.85)
        values = {"drive.speed": [80.0, 30.0], "drive.duration": 60.0, "start.whirl": whirl.frequency}
        return scene_of("right").with_values(values)
    return rsc.load_scene(DATA / f"{SCENES[run]}.toml")


@cache
def report_of(run):
    """Simulation, prediction and comparison of a run."""
    print(f"simulates: {scene_of(run).title}", flush=True)
    return rsc.check(scene_of(run))


@cache
def survey_of(run):
    """The predictions alone."""
    return survey(scene_of(run))


def whirl_of(run, speed, frequency):
    """The predicted whirl next to a frequency, Hz."""
    return min(rsc.predict(scene_of(run), speed), key=lambda whirl: abs(whirl.frequency - frequency))


def largest_at(speed, line):
    """Speed at which a line is largest, by the parabola through its largest value and the two beside it."""
    i = int(np.argmax(line))
    bend, slope, _ = np.polyfit(speed[i - 1 : i + 2] - speed[i], line[i - 1 : i + 2], 2)
    return speed[i] - 0.5 * slope / bend


# ---------------------------------------------------------------- predicted


def resonance_in_contact(run):
    """Speed in Hz at which the forward rub is largest, in closed form."""
    limits = 2.0 * np.pi * np.sort(scene_of(run).drive.speed)
    return synchronous_resonance(assemble(scene_of(run)), limits) / (2.0 * np.pi)


def resonance_on_whirl(run, label, step=0.25, near=2.0):
    """Speed in Hz at which the unbalance line on a whirl is largest, with the whole unbalance by harmonic balance.

    Looked for near the place where its first order is largest in the stable part of the branch.
    """
    system, (low, high) = assemble(scene_of(run)), sorted(scene_of(run).drive.speed)
    branch = next(b for b in branches(system, np.arange(low, high + step, step)) if b.label == label)
    first_order = np.array([w.synchronous.consistent.amplitude for w in branch.whirls])
    first = largest_at(branch.speed[branch.stable], first_order[branch.stable])
    whirls = [w for w in branch.whirls if abs(w.speed - first) <= near]
    motions = [balance(system, w.frequency, w.speed) for w in whirls]
    return largest_at(np.array([w.speed for w in whirls]), np.array([abs(m.rotor[HARMONICS + 1]) for m in motions]))


def branch_of(run, label):
    """A predicted branch over the speeds of a run."""
    return next(b for b in survey_of(run).branches if b.label == label)


def end_of_stable_whirl(run, end):
    """First (end = 0) or last (-1) speed in Hz at which a stable whirl is predicted; NaN where it lasts to that end of WIDE."""
    found = branches(assemble(scene_of(run)), np.linspace(*WIDE, 300))
    speed = np.sort(np.concatenate([b.speed[b.stable] for b in found]))[end]
    return np.nan if speed == WIDE[end] else speed


# ---------------------------------------------------------------- simulated


def rows_of(run, quantity):
    """Comparisons of one quantity in every window of a run."""
    return [row for row in report_of(run).rows if row.quantity == quantity]


def whirling(run):
    """Speeds in Hz of the windows whose line is a predicted whirl."""
    return [row.speed for row in rows_of(run, "whirl frequency") if row.branch]


def largest_line(run):
    """Speed in Hz at which the synchronous line of the windows is largest."""
    rows = rows_of(run, "synchronous line")
    return largest_at(np.array([row.speed for row in rows]), np.array([row.simulated for row in rows]))


def jump(run):
    """The one change of whirl of a run."""
    (change,) = report_of(run).transitions
    return change


def lost_on_the_way_down():
    """Speed in Hz at which the run-down on whirl B is no longer on it."""
    rows = rows_of("B down", "whirl frequency")
    return min(row.speed for row in rows if row.branch == rows[0].branch)


def windows_on(frequency):
    """Number of windows of run-up and run-down whose strongest backward line is a frequency, and of all windows."""
    lines = np.array([row.simulated for run in ("run-up", "run-down") for row in rows_of(run, "whirl frequency")])
    return int((np.abs(lines / frequency - 1.0) < TOLERANCES[FREQUENCY]).sum()), len(lines)


def median_of(run, quantity):
    """Median over the windows of a run that are on a predicted whirl, Hz or m."""
    return float(np.median([row.simulated for row in rows_of(run, quantity) if row.branch]))


def sizes(run, frequency):
    """Predicted and simulated amplitude of the whirl of a run, in words."""
    gap = scene_of(run).contact.gap
    predicted = whirl_of(run, scene_of(run).drive.speed[0], frequency).rotor_amplitude
    return f"amplitude {predicted / gap:.3f} gaps predicted, {median_of(run, 'whirl amplitude') / gap:.3f} simulated (median)"


# ---------------------------------------------------------------- the statements of the paper


class Statement(NamedTuple):
    """How a number of the paper is predicted and simulated: functions without arguments that return Hz (NaN: none), what the
    prediction is computed by, and a remark in words."""

    predicted: Callable[[], float]
    by: str
    simulated: Callable[[], float]
    remark: Callable[[], str]


STATEMENTS = {
    ("3 left", "synchronous resonance"): Statement(
        lambda: resonance_in_contact("left"), "synchronous_resonance", lambda: largest_line("left"),
        lambda: f"the reconstruction's whirl lasts until {max(whirling('left')):.1f} Hz only: contact is lost during the beat "
        "with the unbalance; the line is then that of the forward rub",
    ),
    ("3 right", "synchronous resonance"): Statement(
        lambda: resonance_on_whirl("right", "A"), "balance", lambda: report_of("right").resonances[0].speed,
        lambda: "the unbalance line on whirl A",
    ),
    ("3 right", "transition speed"): Statement(
        lambda: survey_of("right").delays["A"].jump, "survey, delays", lambda: jump("right").taken_over,
        lambda: f"whirl A loses stability at {branch_of('right', 'A').lost[0]:.2f} Hz and ends at "
        f"{branch_of('right', 'A').end.value:.2f} Hz; the jump between them depends on the run-up rate and on the disturbance: "
        "predicted for rounding alone",
    ),
    ("3 right", "coexistence from"): Statement(
        lambda: branch_of("right", "B").begin.value, "branches", lost_on_the_way_down,
        lambda: f"whirl B begins at a fold but is unstable up to {branch_of('right', 'B').events[0].value:.2f} Hz: no simulation "
        "stays on it below; simulated is where a run-down on it leaves it",
    ),
    ("4", "whirl from"): Statement(
        lambda: end_of_stable_whirl("right", 0), "branches", lambda: min(whirling("right")),
        lambda: f"not met as a limit: a stable whirl is predicted at every speed of {WIDE[0]:g} to {WIDE[1]:g} Hz; the run "
        "begins at 20 Hz on the whirl and whirls in its first window",
    ),
    ("4", "whirl to"): Statement(
        lambda: end_of_stable_whirl("right", -1), "branches", lambda: max(whirling("right")),
        lambda: "not met as a limit, as above; the run ends at 150 Hz and whirls in its last window",
    ),
    ("5 and 6", "Psi_1"): Statement(
        lambda: whirl_of("run-up", 20.0, -9.47).frequency, "predict", lambda: np.nan,
        lambda: f"predicted to grow with {whirl_of('run-up', 20.0, -9.47).growth_rate:+.2f} 1/s; "
        "{} of {} windows of run-up and run-down are on it".format(*windows_on(-9.47)),
    ),
    ("5 and 6", "Psi_2"): Statement(
        lambda: whirl_of("run-up", 20.0, -12.9).frequency, "predict", lambda: median_of("run-up", "whirl frequency"),
        lambda: sizes("run-up", -12.9),
    ),
    ("5 and 6", "Psi_3"): Statement(
        lambda: whirl_of("run-down", 20.0, -38.0).frequency, "predict", lambda: median_of("run-down", "whirl frequency"),
        lambda: f"{sizes('run-down', -38.0)}: smaller than Psi_2",
    ),
}  # fmt: skip
HEADER = ("Figure", "Quantity", "Printed, Hz", "Predicted, Hz", "by", "Simulated, Hz",
          "Predicted less printed", "Simulated less printed", "Remark")  # fmt: skip


def published():
    """Rows of published.csv: dict of figure, quantity, value (float, NaN where the text has none), unit, meaning."""
    text = (DATA / "published.csv").read_text(encoding="utf-8")
    return [row | {"value": float(row["value"] or "nan")} for row in csv.DictReader(io.StringIO(text))]


def number(value, sign=""):
    """A cell with a frequency."""
    return "none" if np.isnan(value) else f"{round(value, 2) + 0.0:{sign}.2f}"


def table():
    """The table in Markdown: one row for each row of published.csv."""
    lines = ["| " + " | ".join(HEADER) + " |", "|" + "---|" * len(HEADER)]
    for row in published():
        statement = STATEMENTS[row["figure"], row["quantity"]]
        printed, predicted, simulated = row["value"], statement.predicted(), statement.simulated()
        lines.append("| " + " | ".join((
            row["figure"], row["quantity"], f"{printed:g}" if printed == printed else "none", number(predicted), statement.by,
            number(simulated), number(predicted - printed, "+"), number(simulated - printed, "+"), statement.remark(),
        )) + " |")  # fmt: skip
    return "\n".join(lines)


def write_table():
    """results/paper.md."""
    head = (
        "# The numbers of the paper's text, printed, predicted and simulated\n\n"
        "Written by `python bench/paper.py table`; do not edit by hand. The scenes are reconstructions: they were searched for\n"
        "so that they meet the printed numbers, and what is left of a difference is not tuned away. A window of a run spans \n"
        "about one Hz of rotor speed; a speed read from windows is worth some tenths of it.\n"
    )
    pictures = "\n".join(f"![Figure {name}]({path_of(name).name})\n" for name in FIGURES)
    (RESULTS / "paper.md").write_text(f"{head}\n{table()}\n\n{pictures}", encoding="utf-8")
    print(table())


# ---------------------------------------------------------------- the figures


def mark_speed(figure, speed, words):
    """A speed of a Campbell diagram marked and named at its right edge."""
    axes = figure.axes[0]
    axes.axhline(speed, color="tab:blue", linestyle=":", linewidth=1.2)
    axes.annotate(words, (0.99, speed), xycoords=axes.get_yaxis_transform(), xytext=(0, -3), textcoords="offset points",
                  ha="right", va="top", fontsize=9, color="tab:blue", path_effects=HALO, zorder=13)  # fmt: skip


def title(figure, run):
    """Title of a figure: its number, and whose run it is instead of the paper's."""
    return f"Figure {figure}, {scene_of(run).title.partition(' (Figure')[0]}"


def printed(figure, quantity):
    """A number of the paper's text."""
    return next(row["value"] for row in published() if (row["figure"], row["quantity"]) == (figure, quantity))


def figure_3_left():
    """Spectra over rotor speed: the whirl, then the resonance of the rub."""
    figure = campbell(report_of("left"), title("3 left", "left"))
    speed = largest_line("left")
    mark_speed(figure, speed, f"1X largest at {speed:.1f} Hz (paper: {printed('3 left', 'synchronous resonance'):g})")
    mark_speed(figure, max(whirling("left")), f"whirl until {max(whirling('left')):.1f} Hz")
    return [figure]


def figure_3_right():
    """Spectra over rotor speed: two whirls and the jump between them."""
    figure = campbell(report_of("right"), title("3 right", "right"))
    peak, change = report_of("right").resonances[0], jump("right")
    mark_speed(figure, peak.speed, f"1X largest at {peak.speed:.1f} Hz (paper: {printed('3 right', 'synchronous resonance'):g})")
    words = f"jump {change.before} to {change.after} at {change.taken_over:.1f} Hz"
    mark_speed(figure, change.taken_over, f"{words} (paper: about {printed('3 right', 'transition speed'):g})")
    return [figure]


def figure_4():
    """Amplitudes over rotor speed, simulated beside predicted."""
    return [amplitude([report_of("right")], title("4", "right"))]


def figure_5():
    """Spectra of run-up and run-down beside each other."""
    return [campbell(report_of(run), title("5", run)) for run in ("run-up", "run-down")]


def figure_6():
    """Amplitudes of run-up and run-down in one picture."""
    return [amplitude([report_of("run-up"), report_of("run-down")], title("6", "run-up").replace("run-up", "both runs"))]


FIGURES = {"3-left": figure_3_left, "3-right": figure_3_right, "4": figure_4, "5": figure_5, "6": figure_6}


def path_of(name):
    """File of a figure."""
    return RESULTS / f"paper_{name.replace('-', '_')}.png"


def write_figure(name):
    """One figure of the paper, its parts beside each other."""
    parts = []
    for figure in FIGURES[name]():
        stored = io.BytesIO()
        figure.savefig(stored, format="png", dpi=130)
        parts.append(Image.open(stored).convert("RGB"))
    whole = Image.new("RGB", (sum(part.width for part in parts), max(part.height for part in parts)), "white")
    for i, part in enumerate(parts):
        whole.paste(part, (sum(p.width for p in parts[:i]), 0))
    whole.quantize(COLOURS, dither=Image.Dither.NONE).save(path_of(name), optimize=True)
    print(path_of(name))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", nargs="?", choices=[*FIGURES, "table"], help="default: all of them")
    wanted = parser.parse_args().what
    for what in [wanted] if wanted else [*FIGURES, "table"]:
        if what == "table":
            write_table()
        else:
            write_figure(what)


if __name__ == "__main__":
    main()
