"""Forged results, plans, parts, datasets and stores, every checksum right: what the commands make of 20,000 of them.

    python tools/forged.py                 20,000 cases; --write keeps the table in docs/maintainers/tables
    python tools/forged.py --log FILE      goes on where it was stopped: the file has a line for each case that is done
    python tools/forged.py --only 4711     one case again

A case is a number, from which all its changes follow (tests/support/forge.py, forge_sweeps.py): links, kinds, shapes, counts,
times, scenes, numbers and texts that no run and no sweep would write. Every command must end with exit code 0, 2, 4 or 5 and one
line, in 2 s of processor time (10 s where it computes or draws) and 300 MB, change no other file, and compute a part anew where
it is another one's. An interrupt ends the cases; the table tells how many there were. Exit code 1 where one does not.
"""

import argparse
import collections
import contextlib
import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))

import trials
from pages import TABLES, write_page

EVERY = 10  # of so many cases one is plotted as well


def table(outcomes):
    """Lines of a table: command by command what became of the cases."""
    words = sorted({word for counts in outcomes.values() for word in counts})
    lines = ["| command | " + " | ".join(words) + " |", "|---" * (1 + len(words)) + "|"]
    return lines + [f"| {name} | " + " | ".join(str(counts[word]) for word in words) + " |" for name, counts in outcomes.items()]


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=20_000)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--only", type=int, help="this case alone")
    parser.add_argument("--log", type=Path, help="lines of JSON [case, ends]: cases in it are not run again")
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
    numbers = range(options.first, options.first + options.cases) if options.only is None else [options.only]
    done = [json.loads(line) for line in options.log.read_text().splitlines()] if options.log and options.log.exists() else []
    done = {number: ends for number, ends in done if number in numbers}
    left, failed = [number for number in numbers if number not in done], 0
    with contextlib.suppress(KeyboardInterrupt), tempfile.TemporaryDirectory() as folder, trials.samples(folder) as pairs:
        sweeps = trials.swept(folder)
        for number, ends, problem in trials.trials(left, pairs, sweeps, folder, lambda number: number % EVERY == 0):
            done[number] = ends or {"any": "FAILED"}
            if problem:
                failed += 1
                print(f"case {number}: {problem}", file=sys.stderr, flush=True)
            elif options.log:
                with options.log.open("a") as log:
                    log.write(json.dumps([number, ends]) + "\n")
    outcomes = collections.defaultdict(collections.Counter)
    for ends in done.values():
        for command, word in ends.items():
            outcomes[command][word] += 1
    lines = [f"{len(done)} forged files of runs and sweeps, {failed} failures.", "", *table(outcomes)]
    print("\n".join(lines))
    if options.write and not failed:
        command = f"python tools/forged.py --cases {len(done)} --write"
        write_page(TABLES / "forged.md", "Forged files", command, "\n".join(lines))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
