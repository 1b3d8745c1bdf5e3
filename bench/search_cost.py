"""What `rsc check` with its list, `rsc motions` and `rsc impact` cost: processor time of whole commands beside what is asked.

    python bench/search_cost.py [--before FOLDER] [--quick] [--write]

Each command in a process of its own, its kernel compiled before, the least of two; start and libraries included. --quick: once.
--before: a checkout of baa79b3, the commit before lists of motions, whose `rsc check` took 2.20 s where the bounds were set
(results/main_job.md of that commit); it is measured as well, and all bounds grow as this machine is slower at it. --write:
results/search_cost.md. Exit code 1 if something takes longer than asked.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from main_job import REFERENCE, RESULTS, ROOT, command, table, write_page

PUMP = """
[rotor]
model = "laval"
mass = 12.0
frequency = "2600 rpm"
damping_ratio = 0.02
eccentricity = "0.02 mm"
[stator]
model = "laval"
mass = 3.0
frequency = 160.0
damping_ratio = 0.1
[contact]
gap = "0.25 mm"
friction = {friction}
stiffness = "50 kN/mm"
damping_ratio = 0.05
diameter = "80 mm"
[drive]
speed = 50.0
duration = 1.0
"""
FRICTIONS = (0.2, 0.25, 0.3, 0.4)
MACHINE = 1, 142  # seed and number in answers_scenes.py of a reduced machine of 10 + 2 coordinates
THEN = 2.20  # s, `rsc check` of baa79b3 where the bounds were set
FAN, FAN_SPEED = ROOT / "bench" / "fan.toml", 1480.0 / 60.0
COMPRESSOR, COMPRESSOR_SPEED, SEAL = ROOT / "data" / "reference" / "machines" / "ross_compressor.mat", 150.0, 27


def cases(folder):
    """(name, s that are asked for, keys of `command`, its arguments)."""
    yield "`rsc check` of the reference run, page and list", 3.5, {}, ("check", REFERENCE, "-o", "out")
    yield "the same without the list", 2.2, {"lists": False}, ("check", REFERENCE, "-o", "out")
    for friction in FRICTIONS:
        path = folder / f"pump_{friction}.toml"
        path.write_text(PUMP.format(friction=friction), encoding="utf-8")
        yield f"`rsc motions`, 64 starts, the tutorial's pump with friction {friction}", 5.0, {}, ("motions", path)
    from answers_scenes import scene_text

    text, words = scene_text(*MACHINE, constant=True)
    (folder / "reduced.toml").write_text(text, encoding="utf-8")
    yield f"`rsc motions`, 64 starts, a {words.partition(',')[0]}", 20.0, {}, ("motions", folder / "reduced.toml")
    yield "`rsc impact`, 24 directions, bench/fan.toml", 8.0, {}, ("impact", FAN, "--speed", FAN_SPEED)
    path, coordinates = compressor(folder)
    arguments = ("impact", path, "--speed", COMPRESSOR_SPEED, "--directions", 2)
    yield f"`rsc impact`, two directions, ROSS's compressor with {coordinates} coordinates", 40.0, {}, arguments


def compressor(folder):
    """(scene that `rsc import` writes of ROSS's compressor, how many coordinates it has)."""
    import rsc
    from rsc.machine.imports.ross import read_ross
    from rsc.study.import_model import import_model

    path = folder / "compressor.toml"
    import_model(read_ross(COMPRESSOR, COMPRESSOR_SPEED), path, SEAL)
    scene = rsc.load_scene(path)
    return path, scene.rotor.n_coordinates + scene.stator.n_coordinates


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--before", metavar="FOLDER", help="a checkout of baa79b3, measured as well")
    parser.add_argument("--quick", action="store_true", help="each command once")
    parser.add_argument("--write", action="store_true", help="keep the table in bench/results")
    options = parser.parse_args()
    rows, late, words = [], 0, ""
    times = 1 if options.quick else 2
    with tempfile.TemporaryDirectory() as name:
        folder, slower = Path(name), 1.0
        if options.before:
            before, _ = command(Path(options.before).resolve(), folder, "check", REFERENCE, "-o", "out", times=times + 1)
            slower = before / THEN
            words = f"`rsc check` of baa79b3 takes {before:.1f} s here, {THEN} s where the bounds were set: they are scaled. "
        for what, asked, keys, arguments in cases(folder):
            command(ROOT, folder, *arguments, times=1)  # compiles
            seconds, megabytes = command(ROOT, folder, *arguments, times=times, **keys)
            asked *= slower
            late += seconds > asked
            rows.append([what, f"{seconds:.1f}", f"{asked:.1f}", f"{megabytes:.0f}"])
            print(" ".join(rows[-1]), flush=True)
    lines = table(["command", "processor time, s", "asked: at most", "memory, MB"], rows)
    lines.append(words + (f"{late} of {len(rows)} take longer than asked." if late else "None takes longer than asked."))
    print(lines[-1])
    if options.write:
        how = "python bench/search_cost.py " + "--before FOLDER " * bool(options.before) + "--write"
        write_page(RESULTS / "search_cost.md", "What searches for motions cost", how, "\n".join(lines))
    return 1 if late else 0


if __name__ == "__main__":
    sys.exit(main())
