"""The figures of the verification ladder: run its tests and print what they measured; `--write` keeps the table."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from pages import TABLES, write_page

ROOT = Path(__file__).resolve().parent.parent


def measured():
    """(pytest's exit code, [rung, what, largest measured, its limit, times measured] in the order of the rungs)."""
    tests = sorted(str(path) for path in (ROOT / "tests").rglob("test_ladder_*.py"))
    with tempfile.TemporaryDirectory() as folder:
        figures = Path(folder, "figures.jsonl")
        environment = os.environ | {"RSC_FIGURES": str(figures)}
        code = subprocess.run([sys.executable, "-m", "pytest", "-q", *tests], cwd=ROOT, env=environment, check=False).returncode
        lines = [json.loads(line) for line in figures.read_text(encoding="utf-8").splitlines()]
    found = {}
    for rung, what, value, limit in lines:
        row = found.setdefault((rung, what), [value, limit, 0])
        if value / abs(limit) >= row[0] / abs(row[1]):
            row[:2] = value, limit
        row[2] += 1
    rows = [[rung, what, *row] for (rung, what), row in found.items()]
    return code, sorted(rows, key=lambda row: (int(row[0][1:]), row[1]))


def table(rows):
    """Markdown table; of a figure measured several times the one nearest to its limit."""
    lines = ["| rung | figure | measured | limit |", "|---|---|---|---|"]
    for rung, what, value, limit, _ in rows:
        lines.append(f"| {rung} | {what.replace('|', chr(92) + '|')} | {value:.3g} | {limit:.3g} |")
    return "\n".join(lines)


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
    code, rows = measured()
    text = table(rows)
    print(text)
    if options.write and code == 0:
        write_page(TABLES / "ladder.md", "Verification ladder", "python tools/ladder_table.py --write", text)
    return code


if __name__ == "__main__":
    sys.exit(main())
