"""Random scenes end to end: `rsc.check` of each against an engine of another family and spectra of that engine's own motion.

    python bench/end_to_end.py [COUNT] [--seed 1] [--first 0]     default 200; writes results/end_to_end.md and .csv

Asked of every scene: no crash (a refusal is one line of an `RscError`); where a row says that simulation and prediction agree,
the other engine's line agrees with the prediction as well, within the tolerance times SLACK; where a window says that there is no
whirl, the other engine's motion has no backward line in contact, of rotor, stator or the distance between them. Reported is also
the share of windows in contact that get a verdict other than "outside assumptions". Scenes with a violation are saved under
out/end_to_end/, to be run again with `rsc check`; all violations stand in violations.txt there. Exit code 1 if there is one.

Where motions are chaotic the engines part; their windows are compared all the same, since a line of an attractor does not depend
on its phase, but they are counted apart.
"""

import argparse
import collections
import csv
import signal
import sys
import time
import traceback
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

import rsc
from end_to_end_engine import NEAR_BINS, integrate, line_near, lines, synchronous_line
from end_to_end_scenes import scene_text
from problems import RESULTS
from rsc.measure import spectra
from rsc.measure.verdict import ALONE
from rsc.measure.windows import LINE_FLOOR
from rsc.measure.words import AGREES, NO_WHIRL, OUTSIDE, TOLERANCES
from rsc.study.start import initial_state
from rsc.system.assemble import assemble

SAVED = Path(__file__).parents[1] / "out" / "end_to_end"
LIMIT = 120.0  # s, of one scene
SLACK = 1.5  # tolerances of the comparison times this: both sides read lines from windows
BIN_ERROR = 0.05  # bins, of a line that least squares read from a window
SAME = 0.05  # of the largest displacement in a window (of LINE_FLOOR gaps at least): below, the engines still run together
CLEAR = 3.0  # times LINE_FLOOR: a backward line that nobody may overlook
ON_ORDER = 0.15  # bins
FINER = 4  # samples of the other engine for one of rsc: a line of rsc above half its rate is no backward line of the other
GRAZE = 0.02  # share of a window in contact up to which the engines may differ on whether it touches at all
GROWTH = 5.0  # between quarters of a window


class Violation(NamedTuple):
    """What went wrong in a scene: kind in words, number of the scene, whether the engines ran together there, details."""

    kind: str
    number: int
    same: bool
    detail: str


class Case(NamedTuple):
    """One scene: its number, kind in words, how `check` ended, verdicts of all and of the contact windows, violations."""

    number: int
    words: str
    end: str
    seconds: float
    windows: int
    contact: int
    together: int
    verdicts: collections.Counter  # (quantity, verdict) of windows in contact
    agreed: int  # rows that agree
    violations: list


class TooLong(BaseException):
    """A scene took longer than LIMIT."""


def _alarm(number, frame):
    raise TooLong


def case_of(seed, number):
    """Run and judge one scene."""
    text, words = scene_text(seed, number)
    begun = time.perf_counter()
    signal.signal(signal.SIGALRM, _alarm)
    signal.setitimer(signal.ITIMER_REAL, LIMIT)
    found, report, end = [], None, "crashed"
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            scene = rsc.Scene.from_toml(text)
            report = rsc.check(scene)
        end = str(report.result.status)
        found += [Violation("a warning of Python", number, True, str(w.message)) for w in told[:1]]
    except rsc.RscError as error:
        end = f"refused: {error}"
        if not str(error) or "\n" in str(error):
            found.append(Violation("a refusal of more than one line", number, True, str(error)))
    except TooLong:
        found.append(Violation(f"longer than {LIMIT:g} s", number, True, words))
    except Exception as error:
        place = [frame for frame in traceback.extract_tb(error.__traceback__) if "/rsc/" in frame.filename][-1]
        kind = f"crash: {type(error).__name__} in {place.name}, {Path(place.filename).name}"
        found.append(Violation(kind, number, True, f"line {place.lineno}: {error}"))
    seconds = time.perf_counter() - begun
    facts = (0, 0, 0, collections.Counter(), 0)
    if report is not None:
        try:
            *facts, more = compared(report, number)
            found += more
        except TooLong:
            end += " (the other engine took too long)"
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    if found:
        SAVED.mkdir(parents=True, exist_ok=True)
        (SAVED / f"{seed}_{number}.toml").write_text(text, encoding="utf-8")
    return Case(number, words, end, seconds, *facts, found)


def compared(report, number):
    """(windows, contact windows, windows where the engines run together, verdicts, agreeing rows, violations) of one report."""
    result, fall = report.result, report.fall
    scene, system = result.scene, assemble(result.scene)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of an engine that gives up
        fine = result.time[0] + np.arange((len(result.time) - 1) * FINER + 1) * (result.time[1] - result.time[0]) / FINER
        rotor, stator = integrate(system, initial_state(scene, system), fine)
    signals, phi = signals_of(system, fine, rotor, stator)
    windows = windows_of(report.rows)
    assert len(windows) == len(fall.time)
    n, step = fall.n_samples, result.time[1] - result.time[0]
    chirps = chirps_of(windows, fall)
    verdicts, together, contact, agreed, found = collections.Counter(), 0, 0, 0, []
    for i, rows in enumerate(windows):
        first = max(round((fall.time[i] - 0.5 * fall.window - result.time[0]) / step), 0)
        part = slice(first, first + n)
        finer = slice(FINER * first, FINER * (first + n))
        pieces = {name: values[finer] for name, values in signals.items()}
        touching = (result.normal_force[part] > 0.0).mean()
        contact += touching > 0.0
        if touching > 0.0:
            verdicts.update((row.quantity, row.verdict) for row in rows)
        agreed += sum(row.verdict == AGREES for row in rows)
        if not np.isfinite(pieces["rotor"]).all():
            continue
        apart = np.abs(pieces["rotor"][::FINER] - result.contact_rotor()[part]).max()
        same = bool(apart < SAME * max(np.abs(pieces["rotor"]).max(), LINE_FLOOR * scene.contact.gap))
        together += same
        for kind, detail in judged(rows, pieces, (phi[finer], chirps[i]), FINER / step, scene.contact.gap):
            found.append(Violation(kind, number, same, f"window {i} at {fall.time[i]:.3f} s, {fall.speed[i]:.2f} Hz: {detail}"))
    return len(windows), int(contact), together, verdicts, agreed, found


def signals_of(system, at, rotor, stator):
    """(motions at the contact in which a backward line may show: name -> complex (n_time,); the angle of rotation (n_time,))."""
    speed = system.speed_at(at)
    phi = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(at))])
    r, s = rotor @ system.contact_r, stator @ system.contact_s if system.n_stator else np.zeros(len(at), complex)
    return {"rotor": r, "distance": r - s + system.ring_ecc * np.exp(1j * phi), "stator": s}, phi


def windows_of(rows):
    """Rows of a report by window: a new one begins with each whirl frequency."""
    windows = []
    for row in rows:
        if row.quantity == "whirl frequency":
            windows.append([])
        windows[-1].append(row)
    return windows


def chirps_of(windows, fall):
    """Bins by which the predicted line of each window moves during it, by the windows beside it on the same whirl."""
    whirl, moves = [rows[0] for rows in windows], np.zeros(len(windows))
    for i in range(1, len(whirl) - 1):
        if whirl[i - 1].branch == whirl[i].branch == whirl[i + 1].branch != "":
            moves[i] = (whirl[i + 1].predicted - whirl[i - 1].predicted) / (fall.time[i + 1] - fall.time[i - 1]) * fall.window**2
    return moves


def judged(rows, pieces, turning, rate, gap):
    """(kind, detail) of what is wrong in one window, judged by the other engine's motion; turning: (phi, chirp)."""
    phi, chirp = turning
    by_name = {row.quantity: row for row in rows}
    piece, bin_width = pieces["rotor"], rate / len(pieces["rotor"])
    whirl, size, synchronous = (by_name[name] for name in TOLERANCES)
    tolerance = {name: SLACK * limit for name, limit in TOLERANCES.items()}
    if AGREES in (whirl.verdict, size.verdict):
        f, least, largest = line_near(piece, rate, whirl.predicted, chirp)
        allowed = tolerance[whirl.quantity] + BIN_ERROR * bin_width / abs(whirl.predicted)
        if whirl.verdict == AGREES and not abs(f / whirl.predicted - 1.0) <= allowed:
            yield "agrees in frequency, wrongly", told(whirl, f, bin_width)
        if "of the stator" in size.note:
            _, least, largest = line_near(pieces["stator"], rate, whirl.predicted, chirp)
        near = np.clip(size.predicted, least, largest)
        if size.verdict == AGREES and abs(near / size.predicted - 1.0) > tolerance[size.quantity]:
            yield "agrees in amplitude, wrongly", told(size, near, bin_width)
    if synchronous.verdict == AGREES and synchronous.predicted > 0.0:
        a, blur = synchronous_line(piece, phi) if synchronous.by != ALONE else (_peak(piece, rate, synchronous.speed), 0.0)
        if abs(a - synchronous.predicted) > tolerance[synchronous.quantity] * synchronous.predicted + 2.0 * blur:
            yield "agrees in the synchronous line, wrongly", told(synchronous, a, bin_width)
    touching = np.abs(pieces["distance"]) > gap
    if whirl.contact == 0.0 and touching.mean() > GRAZE:
        yield "contact that rsc has not", f"contact {100 * touching.mean():.0f} %"
    if whirl.verdict == NO_WHIRL and whirl.contact > 0.0 and touching.any() and not grows(piece):
        yield from overlooked(pieces, rate, gap, touching.mean(), whirl.speed)


def _peak(piece, rate, speed):
    """The line at the rotor speed as rsc reads it: past a resonance, where the rotor rings down, it is not of one phase."""
    fall = spectra.waterfall(np.arange(len(piece)) / rate, piece, np.full(len(piece), speed), window=len(piece) / rate)
    return float(np.nan_to_num(spectra.line_at(fall, speed).amplitude[0]))


def grows(piece):
    """Whether a motion grows or decays so much within a window that its spectrum has no lines."""
    quarters = [np.abs(part).max() for part in np.array_split(piece, 4)]
    return max(quarters) > GROWTH * min(quarters)


def told(row, value, bin_width):
    return (
        f"{row.quantity} predicted {row.predicted:.6g}, rsc {row.simulated:.6g}, other engine {value:.6g}, "
        f"bins of {bin_width:.3g} Hz, branch {row.branch!r}, {row.note}"
    )


def overlooked(pieces, rate, gap, share, speed):
    """(kind, detail) of backward lines in contact, clearly above the floor, in a window that is said to have no whirl."""
    for name, piece in pieces.items():
        frequency, amplitude = lines(piece, rate)
        back = np.flatnonzero((frequency < -NEAR_BINS * rate / len(piece)) & (amplitude > CLEAR * LINE_FLOOR * gap))
        if back.size:
            f, a, top = frequency[back[0]], amplitude[back[0]], amplitude.max()
            beside = "in permanent contact" if share >= 1.0 else "in partial contact"
            orders = np.arange(1.0, 4.0) * speed
            beside += ", at a multiple of -1X" if np.abs(f + orders).min() < ON_ORDER * rate / len(piece) else ""
            beside += ", above half the output rate" if abs(f) > 0.5 * rate / FINER else ""
            yield (
                f"a backward line called no whirl, {name}, {beside}",
                f"{f:.4g} Hz of {a / gap:.3g} gaps, strongest line {top / gap:.3g} gaps, contact {100 * share:.0f} %",
            )
            return


def counted(cases):
    """Kind -> violations of that kind, the most frequent kinds first."""
    kinds = collections.defaultdict(list)
    for case in cases:
        for violation in case.violations:
            kinds[violation.kind].append(violation)
    return dict(sorted(kinds.items(), key=lambda item: -len(item[1])))


def report_text(cases, seed, seconds):
    """What was found, in Markdown."""
    ends = collections.Counter(case.end.partition(":")[0] for case in cases)
    verdicts = sum((case.verdicts for case in cases), collections.Counter())
    contact, windows, together = (sum(getattr(case, name) for case in cases) for name in ("contact", "windows", "together"))
    outside = verdicts["whirl frequency", OUTSIDE]
    text = [
        "# Random scenes end to end",
        "",
        f"Written by `python bench/end_to_end.py {len(cases)} --seed {seed}` in {seconds / 60:.0f} min on one core; "
        "do not edit by hand.",
        "",
        f"{len(cases)} scenes: " + ", ".join(f"{count} {end}" for end, count in ends.most_common()) + ".",
        f"{windows} windows, {contact} of them in contact; in {together} the two engines run together within "
        f"{100 * SAME:g} % of the motion.",
        f"{sum(case.agreed for case in cases)} rows agree. Windows in contact with a verdict on the whirl other than "
        f'"{OUTSIDE}": {100 * (1 - outside / max(contact, 1)):.1f} %.',
        "",
        "| verdict on windows in contact | " + " | ".join(TOLERANCES) + " |",
        "|---|" + "---|" * len(TOLERANCES),
    ]
    for verdict in dict.fromkeys(verdict for _, verdict in verdicts):
        text.append(f"| {verdict} | " + " | ".join(str(verdicts[name, verdict]) for name in TOLERANCES) + " |")
    text += ["", "| violation | engines together | apart | scenes | numbers | the first |", "|---|---|---|---|---|---|"]
    for kind, found in counted(cases).items():
        numbers = list(dict.fromkeys(v.number for v in found))
        same = sum(v.same for v in found)
        shown = ", ".join(map(str, numbers[:12])) + (" ..." if len(numbers) > 12 else "")
        text.append(f"| {kind} | {same} | {len(found) - same} | {len(numbers)} | {shown} | {found[0].detail} |")
    if not counted(cases):
        text.append("| none | 0 | 0 | 0 | | |")
    return "\n".join(text) + "\n"


def write(cases, seed, seconds):
    """results/end_to_end.md and .csv, and all violations with their details under out/."""
    (RESULTS / "end_to_end.md").write_text(report_text(cases, seed, seconds), encoding="utf-8")
    with open(RESULTS / "end_to_end.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("scene", "kind", "end", "windows", "contact", "together", "agreeing rows", "outside", "violations"))
        for case in cases:
            outside = case.verdicts["whirl frequency", OUTSIDE]
            numbers = (case.windows, case.contact, case.together, case.agreed, outside, len(case.violations))
            writer.writerow((case.number, case.words, case.end, *numbers))
    SAVED.mkdir(parents=True, exist_ok=True)
    with open(SAVED / "violations.txt", "w", encoding="utf-8") as file:
        for case in cases:
            for v in case.violations:
                place = f"{v.number} [{case.words}; {case.end}] {v.kind}, engines {'together' if v.same else 'apart'}"
                file.write(f"{place}: {v.detail}\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    options = parser.parse_args()
    begun, cases = time.perf_counter(), []
    for old in SAVED.glob(f"{options.seed}_*.toml"):
        old.unlink()
    for number in range(options.first, options.first + options.count):
        case = case_of(options.seed, number)
        cases.append(case)
        kinds = collections.Counter(v.kind for v in case.violations)
        print(f"{number} {case.words}: {case.end}, {case.seconds:.1f} s, {case.contact} of {case.windows} windows in contact, "
              f"{case.together} together" + "".join(f"\n    {n} x {kind}" for kind, n in kinds.items()), flush=True)  # fmt: skip
    write(cases, options.seed, time.perf_counter() - begun)
    print(report_text(cases, options.seed, time.perf_counter() - begun))
    return 1 if any(case.violations for case in cases) else 0


if __name__ == "__main__":
    sys.exit(main())
