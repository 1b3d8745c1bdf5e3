"""Pages that a command writes whole: title, command, machine, table. Nobody edits them by hand."""

import os
import platform
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
