"""What the comparison says of every template of `rsc new` and every reference scene, and why it does where it does not agree.

    python tools/verdicts.py            simulates and compares all, about a minute; prints the table
    python tools/verdicts.py --write    keeps it in docs/maintainers/tables

Exit code 1 when a window or a change of whirl differs.
"""

import argparse
import sys
from collections import Counter
from pathlib import Path

from pages import TABLES, write_page
from rsc import Scene, check, load_scene
from rsc.measure.words import AGREES, DIFFERS, NO_WHIRL
from rsc.scene.files.templates import MODELS, STARTS, template

ROOT = Path(__file__).resolve().parent.parent


def scenes():
    """name -> scene, of the templates and of data/reference."""
    found = {f"rsc new {model} --start {start}": Scene.from_toml(template(model, start)) for model in MODELS for start in STARTS}
    files = sorted(path for path in (ROOT / "data" / "reference").glob("*.toml") if not path.name.endswith(".expected.toml"))
    return found | {path.stem: load_scene(path) for path in files}


def reasons(rows):
    """Reasons of the rows that do not agree, with how many rows have each; the first of each and without its numbers."""
    told = Counter()
    for row in rows:
        if row.verdict not in (AGREES, NO_WHIRL):
            why = [" ".join([reason.code, *reason.names]) for reason in row.reasons[:1]]
            told[": ".join([row.verdict, *why])] += 1
    return told


def line(name, report):
    """The row of the table of one scene."""
    compared = [row for row in report.rows if row.verdict != NO_WHIRL]
    agree = sum(row.verdict == AGREES for row in compared)
    others = "; ".join(f"{count} {reason}" for reason, count in reasons(report.rows).most_common())
    changes = ", ".join(f"{new.before or 'none'} to {new.after or 'none'}: {new.verdict}" for new in report.transitions)
    return f"| {name} | {len(compared)} | {agree} | {changes} | {others} |"


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options, lines, differ = parser.parse_args(), [], 0
    for name, scene in scenes().items():
        report = check(scene)
        lines.append(line(name, report))
        differ += sum(item.verdict == DIFFERS for item in (*report.rows, *report.transitions))
    head = ["| scene | comparisons | agree | changes of whirl | the others |", "|---|---|---|---|---|"]
    text = "\n".join([f"{differ} comparisons differ without a reason of computed size.", "", *head, *lines])
    print(text)
    if options.write:
        write_page(TABLES / "verdicts.md", "Verdicts", "python tools/verdicts.py --write", text)
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
