"""Every row of the list of bad inputs and faults with its tests, or the reason why it has none; `--write` keeps the table.

A row without a reason and without a test ends with exit code 1. `make test` runs the tests; here they are counted.
"""

import argparse
import subprocess
import sys
import tomllib
from pathlib import Path

from pages import TABLES, write_page

ROOT = Path(__file__).resolve().parent.parent
GROUPS = {"A": "numbers", "B": "file form", "C": "command line", "D": "result files", "E": "hostile", "F": "faults"}
GROUPS["S"] = "failure stories"


def collected():
    """Names of all tests."""
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-o", "addopts="]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return [line for line in done.stdout.splitlines() if "::" in line]


def matching(names, key, row):
    """Tests of a row: the names that hold one of its patterns (and its `part`, when there is one)."""
    patterns = row.get("tests") or [f"[{key} "]
    return [name for name in names if any(p in name for p in patterns) and row.get("part", "") in name]


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
    names, wrong = collected(), []
    rows = tomllib.loads(Path(__file__).with_name("trust_rows.toml").read_text(encoding="utf-8"))
    lines = ["| row | input or fault | tried | by |", "|---|---|---|---|"]
    counts = ["| group | rows | met by tests | cases |", "|---|---|---|---|"]
    for group, title in GROUPS.items():
        cases = met = 0
        for number, row in rows[group].items():
            key = f"{group}{number}"
            found = [] if "none" in row else matching(names, key, row)
            functions = sorted({name.split("[")[0].split("::", 1)[1] for name in found})
            if not found and "none" not in row:
                wrong.append(key)
            cases, met = cases + len(found), met + bool(found)
            lines.append(f"| {key} | {row['what']} | {len(found) or '-'} | {row.get('none') or ', '.join(functions)} |")
        counts.append(f"| {group}: {title} | {len(rows[group])} | {met} | {cases} |")
    text = "\n".join([*counts, "", *lines])
    print(text)
    if wrong:
        print(f"rows without a test: {', '.join(wrong)}", file=sys.stderr)
    elif options.write:
        write_page(TABLES / "bad_inputs.md", "Bad inputs and faults", "python tools/trust_table.py --write", text)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
