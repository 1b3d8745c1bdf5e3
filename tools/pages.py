"""Sections of a Markdown page that commands write: everything between `<!-- NAME: begin -->` and `<!-- NAME: end -->`."""

import re


def replace_section(page, name, text):
    """Put `text` into the section `name` of a page, which must have it exactly once."""
    old = page.read_text(encoding="utf-8")
    pattern = re.compile(rf"(<!-- {re.escape(name)}: begin -->\n).*?(<!-- {re.escape(name)}: end -->)", re.DOTALL)
    if len(pattern.findall(old)) != 1:
        raise SystemExit(f"{page} must have exactly one section '{name}'")
    page.write_text(pattern.sub(lambda found: found[1] + text + "\n" + found[2], old), encoding="utf-8")
