"""Pages that a command writes, whole or a section of them; nobody edits by hand what it writes."""

import os
import platform
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TABLES = ROOT / "docs" / "maintainers" / "tables"  # what the tests show
RESULTS = ROOT / "bench" / "results"  # what was measured


def machine():
    """Processor of this machine: its name, its number of cores, and whether it has registers of eight doubles."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        facts = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in lines)}
        name = f"{facts['model name']} {'with' if 'avx512f' in facts['flags'] else 'without'} AVX-512"
    except (OSError, KeyError):
        name = platform.processor() or platform.machine()
    return f"{name}, {os.cpu_count()} cores"


def write_page(path, title, command, text):
    """Write the Markdown `text` to `path` below a title and a line that tells the command and the machine."""
    head = f"# {title}\n\nWritten by `{command}` on {machine()}; do not edit by hand.\n\n"
    path.write_text(head + text.rstrip("\n") + "\n", encoding="utf-8")


def _section(page, name):
    text = page.read_text(encoding="utf-8")
    pattern = rf"(?<=<!-- {re.escape(name)}: begin -->\n).*?(?=<!-- {re.escape(name)}: end -->)"
    matches = list(re.finditer(pattern, text, re.DOTALL))
    if len(matches) != 1:
        raise SystemExit(f"{page} must have exactly one section '{name}'")
    return text, matches[0]


def read_section(page, name):
    """Text between `<!-- NAME: begin -->` and `<!-- NAME: end -->` of a page, which must have it exactly once."""
    return _section(page, name)[1][0]


def replace_section(page, name, text):
    """Put `text` into the section `name` of a page."""
    old, match = _section(page, name)
    page.write_text(old[: match.start()] + text.rstrip("\n") + "\n" + old[match.end() :], encoding="utf-8")
