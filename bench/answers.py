"""A judge of answers: `rsc check` of random scenes of twelve kinds, every line judged by a second engine and labels of its own.

    python bench/answers.py [COUNT] [--seed 1] [--first 0] [--jobs 1] [--write]     default 300
    python bench/answers.py --lists [COUNT] ...                                     default 60, constant speed
    python bench/answers.py --converged [COUNT] ...                                 the second engine against itself

Asked of every scene: no crash (a refusal is one line of an `RscError`); every line of the answer is true by samples of the
second engine (answers_engine.py) and labels from them (answers_labels.py); rows that "agree" do so for the second engine as well;
no line contradicts another. A number on which runs of the second engine from slightly other starts do not agree is skipped and
counted. --lists: every lasting motion that random impacts of the second engine find is in the list of `rsc.motions`, and every
motion of the list lasts in the second engine. Scenes with a false line are saved under out/answers/, the first line says what is
said and what is right. --write keeps every scene as it ends in results/answers.json, in place of an older judgement of it, and
writes the tables of all that are kept to results/answers.md. Exit code 1 if there is a false line.
"""

import argparse
import collections
import json
import subprocess
import sys
import time
import traceback
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))

import rsc  # noqa: E402
from answers_engine import Drive, State, integrate, machine_of  # noqa: E402
from answers_limits import JUDGE, LIMIT, JudgeTooLong, begin, end, judging  # noqa: E402
from answers_lines import findings  # noqa: E402
from answers_lists import MISSING, STARTS, judged_list  # noqa: E402
from answers_scenes import KINDS, kind_of, scene_text  # noqa: E402
from answers_spectra import chirps_of, judged  # noqa: E402
from answers_witness import Finding, Witness  # noqa: E402
from pages import RESULTS, write_page  # noqa: E402
from rsc.study.run.start import initial_state  # noqa: E402
from rsc.system.assemble import assemble  # noqa: E402

SAVED = ROOT / "out" / "answers"
FINER = 4  # samples of the second engine for one of rsc, in windows whose rows are judged
SAME = 0.05  # of the largest displacement in a window: below, the engines still run together


class Case(NamedTuple):
    """One scene: number, kind, words, how `check` ended, seconds, Counter of lines by topic, findings (list of Finding), and the
    tree of src/rsc that was judged."""

    number: int
    kind: str
    words: str
    end: str
    seconds: float
    lines: collections.Counter
    findings: list
    tree: str


def case_of(seed, number, judge, constant):
    """Run and judge one scene."""
    text, words = scene_text(seed, number, constant)
    begun = time.process_time()
    begin()
    told, found, ended = collections.Counter(), [], "crashed"
    try:
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            ended, told, found = judge(rsc.Scene.from_toml(text))
        found = [*found, *(Finding("warning of Python", str(w.message)) for w in heard[:1] if "/rsc/" in w.filename)]
    except rsc.RscError as error:
        ended = f"refused: {error}"
        if not str(error) or "\n" in str(error):
            found = [Finding("refusal of more than one line", str(error))]
    except JudgeTooLong:
        ended, found = "not judged", [Finding("time of the judge", f"longer than {JUDGE:g} s", True)]
    except KeyboardInterrupt:
        pass
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        place = [frame for frame in frames if "/rsc/" in frame.filename or "answers" in frame.filename][-1]
        where = f"{place.name}, {Path(place.filename).name} line {place.lineno}"
        found = [Finding(f"crash: {type(error).__name__}", f"{where}: {error}")]
    if end() and ended != "not judged":
        told, found, ended = collections.Counter(), [Finding("time", f"longer than {LIMIT:g} s", True)], "too long"
    if any(not one.skipped for one in found):
        _save(f"{'list' if constant else 'check'}_{seed}_{number}", text, found)
    return Case(number, kind_of(number), words, ended, time.process_time() - begun, told, found, _tree())


def _tree():
    """Short name that git gives the content of src/rsc."""
    out = subprocess.run(["git", "rev-parse", "--short", "HEAD:src/rsc"], cwd=ROOT, capture_output=True, text=True, check=False)
    return out.stdout.strip() or "unknown"


def _save(name, text, found):
    SAVED.mkdir(parents=True, exist_ok=True)
    false = "".join(f"# {one.topic}: {one.detail}\n" for one in found if not one.skipped)
    (SAVED / f"{name}.toml").write_text(false + text, encoding="utf-8")


def judge_answer(scene):
    """(how the run ended, lines, findings) of `rsc.check` of a scene."""
    report = rsc.check(scene)
    judging()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the judge
        count, found = findings(report)
        found += rows_of(report)
    return str(report.result.status), count, found


def rows_of(report):
    """Findings of rows that agree, by the second engine, in windows where both engines run together."""
    result, fall = report.result, report.fall
    witness = Witness(report)
    run, step, gap = witness.signals[0], result.time[1] - result.time[0], result.scene.contact.gap
    if run.diverged or len(result.time) < 3:
        return []
    windows, found = report.windows, []
    fine = result.time[0] + np.arange((len(result.time) - 1) * FINER + 1) * step / FINER
    inside = fine[fine <= run.time[-1]]
    system = witness.system
    motion = integrate(witness.machine, witness.drive, State.of(initial_state(result.scene, system)), run.time[-1])
    rotor, stator = (
        CubicHermiteSpline(motion.time, values, rates)(inside)
        for values, rates in ((motion.rotor, motion.rotor_rate), (motion.stator, motion.stator_rate))
    )
    phi = witness.drive.angle_at(inside)
    pieces = {"rotor": rotor, "stator": stator, "distance": rotor - stator + witness.machine.ring * np.exp(1j * phi)}
    chirps = chirps_of(windows, fall)
    for i, window in enumerate(windows):
        first = max(round((fall.time[i] - 0.5 * fall.window - result.time[0]) / step), 0)
        part, finer = slice(first, first + fall.n_samples), slice(FINER * first, FINER * (first + fall.n_samples))
        own = {name: values[finer] for name, values in pieces.items()}
        ours = result.contact_rotor()[part]
        if len(own["rotor"]) < FINER * fall.n_samples or not len(own["rotor"]):
            continue
        if np.abs(own["rotor"][::FINER] - ours).max() > SAME * max(np.abs(ours).max(), 0.01 * gap):
            continue
        first, last = witness.edges[list(witness.places(i))]
        touches = bool(run.touch[run.part(first, last)].any())  # a window shorter than the run's stretches is told what these do
        for kind, detail in judged(window, own, (phi[finer], chirps[i]), FINER / step, gap if touches else np.inf):
            found.append(Finding(f"row: {kind}", f"window {i} at {fall.time[i]:.3f} s, {fall.speed[i]:.2f} Hz: {detail}"))
    return found


def table_of(cases, lists):
    """Lines of Markdown: kinds of scenes, false lines by topic."""
    false = collections.Counter(one.topic for case in cases for one in case.findings if not one.skipped)
    skipped = collections.Counter(one.topic for case in cases for one in case.findings if one.skipped)
    lines = sum((case.lines for case in cases), collections.Counter())
    ends = collections.Counter(case.end.partition(":")[0] for case in cases)
    wrong = sum(any(not one.skipped for one in case.findings) for case in cases)
    what = "lists of motions at constant speed" if lists else "answers"
    text = [
        f"{len(cases)} {what}: " + ", ".join(f"{count} {end}" for end, count in ends.most_common()) + ". "
        f"{lines.total()} {'motions' if lists else 'lines'} judged, {sum(false.values())} false, in {wrong} scenes; "
        f"{sum(skipped.values())} numbers or kinds on which the second engine's own runs do not agree were skipped.",
        *([_share_listed(cases)] if lists else []), f"Judged: {_trees(cases)}.",
        "", f"| {'finding' if lists else 'line'} | judged | false | skipped |", "|---|---|---|---|",
    ]  # fmt: skip
    topics = dict.fromkeys((*(() if lists else TOPICS), *lines, *false, *skipped))
    text += [f"| {topic} | {lines[topic] or ''} | {false[topic]} | {skipped[topic]} |" for topic in topics]
    text += ["", "| kind of scene | scenes | lines | scenes with a false one |", "|---|---|---|---|"]
    for kind in KINDS:
        own = [case for case in cases if case.kind == kind]
        text.append(f"| {kind} | {len(own)} | {sum(case.lines.total() for case in own)} | "
                    f"{sum(any(not one.skipped for one in case.findings) for case in own)} |")  # fmt: skip
    return text


def _share_listed(cases):
    """How many of the motions that last after impacts of the second engine are in the lists."""
    found = sum(case.lines[topic] for case in cases for topic in MISSING)
    missing = [[one.topic for one in case.findings if one.topic in MISSING] for case in cases]
    own = [lost for case, lost in zip(cases, missing, strict=True) if sum(case.lines[topic] for topic in MISSING)]
    lost, whole = sum(map(len, missing)), own.count([])
    return (
        f"Of {found} lasting motions that {STARTS} impacts of the second engine on each machine end in, {found - lost} "
        f"({100.0 * (found - lost) / max(found, 1):.1f} %) are in the lists; in {whole} of {len(own)} scenes "
        f"({100.0 * whole / max(len(own), 1):.1f} %) all of them are."
    )


def _trees(cases):
    """The versions of src/rsc that were judged."""
    count = collections.Counter(case.tree for case in cases)
    return ", ".join(f"{number} with src/rsc of tree {tree}" for tree, number in count.items())


TOPICS = (
    "verdict", "whirl", "frequency", "amplitude", "force", "drive", "change", "at the end", "after an impact", "not reached",
    "coverage", "mu_min", "check", "contradiction",
)  # fmt: skip


def converged(seed, numbers):
    """Lines on the second engine against itself with samples and tolerance twice as fine."""
    differences = []
    for number in numbers:
        scene = rsc.Scene.from_toml(scene_text(seed, number)[0])
        system = assemble(scene)
        drive, machine = Drive.of(system.schedule_time, system.schedule_speed), machine_of(system)
        start = State.of(initial_state(scene, system))
        one, two = (integrate(machine, drive, start, system.schedule_time[-1], finer) for finer in (1.0, 2.0))
        count = min(len(one.time), (len(two.time) + 1) // 2) // 4
        size = np.abs(one.rotor[:count]).max()
        differences.append(np.abs(one.rotor[:count] - two.rotor[: 2 * count : 2]).max() / size)
    values = np.array(differences)
    return [
        "The second engine against itself with samples and tolerance twice as fine, the first quarter of "
        f"{len(values)} runs: median difference {np.median(values):.1e} of the motion, "
        f"{np.sum(values < 1e-3)} runs below 1e-3, largest {values.max():.1e}."
    ]


def run_all(options):
    """Cases, each whenever it has ended and is printed."""
    judge = judged_list if options.lists else judge_answer
    numbers = range(options.first, options.first + options.count)
    with ProcessPoolExecutor(options.jobs) as pool:
        futures = [pool.submit(case_of, options.seed, number, judge, options.lists) for number in numbers]
        for future in futures:
            case = future.result()
            false = [one for one in case.findings if not one.skipped]
            told = "".join(f"\n    {one.topic}: {one.detail}" for one in false)
            skips = len(case.findings) - len(false)
            print(
                f"{case.number} {case.words}: {case.end}, {case.seconds:.1f} s, {case.lines.total()} lines, "
                f"{skips} skipped{told}",
                flush=True,
            )
            yield case


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--lists", action="store_true", help="judge lists of motions instead of answers")
    parser.add_argument("--converged", action="store_true", help="only compare the second engine with itself")
    parser.add_argument("--write", action="store_true", help="keep the scenes and the tables in bench/results (of seed 1)")
    options = parser.parse_args()
    options.count = options.count or (60 if options.lists else 24 if options.converged else 300)
    part, cases, text = "lists" if options.lists else "answers", [], []
    if options.write and options.seed != 1:
        parser.error("--write keeps scenes of seed 1")
    if options.converged:
        text = converged(options.seed, range(options.first, options.first + options.count))
        if options.write:
            _keep("converged", text)
    else:
        for case in run_all(options):
            cases.append(case)
            if options.write:
                _keep(part, {str(case.number): case._asdict()})
        text = table_of(cases, options.lists)
    print("\n".join(text))
    return 1 if any(not one.skipped for case in cases for one in case.findings) else 0


def _keep(part, more):
    """Add judged scenes, or the lines of the comparison of the second engine with itself, and write all tables anew."""
    parts, path = RESULTS / "answers.json", RESULTS / "answers.md"
    known = json.loads(parts.read_text(encoding="utf-8")) if parts.exists() else {}
    if isinstance(more, dict):
        more = dict(sorted({**known.get(part, {}), **more}.items(), key=lambda one: int(one[0])))
    known[part] = more
    parts.write_text(_json(known), encoding="utf-8")
    text = []
    for name in ("answers", "lists"):
        text += [*table_of([_case(one) for one in known[name].values()], name == "lists"), ""] if name in known else []
    text += known.get("converged", [])
    write_page(
        path,
        "Answers judged by a second engine",
        "python bench/answers.py --write, with --lists and --converged",
        "\n".join(text),
    )


def _json(known):
    """One line for each scene."""
    texts = []
    for part, content in known.items():
        own = content.items() if isinstance(content, dict) else []
        lines = [f"{json.dumps(number)}: {json.dumps(case)}" for number, case in own] or [json.dumps(line) for line in content]
        begin, end = "{}" if isinstance(content, dict) else "[]"
        texts.append(f"{json.dumps(part)}: {begin}\n" + ",\n".join(lines) + f"\n{end}")
    return "{\n" + ",\n".join(texts) + "\n}\n"


def _case(content):
    """A Case as it was kept."""
    findings = [Finding(*one) for one in content["findings"]]
    return Case(**{**content, "lines": collections.Counter(content["lines"]), "findings": findings})


if __name__ == "__main__":
    sys.exit(main())
