"""Sections of a Markdown page that commands write: everything between `<!-- NAME: begin -->` and `<!-- NAME: end -->`."""

import re


def _section(page, name):
    text = page.read_text(encoding="utf-8")
    pattern = rf"(?<=<!-- {re.escape(name)}: begin -->\n).*?(?=<!-- {re.escape(name)}: end -->)"
    found = list(re.finditer(pattern, text, re.DOTALL))
    if len(found) != 1:
        raise SystemExit(f"{page} must have exactly one section '{name}'")
    return text, found[0]


def read_section(page, name):
    """Text of the section `name` of a page, which must have it exactly once."""
    return _section(page, name)[1][0]


def replace_section(page, name, text):
    """Put `text` into the section `name` of a page."""
    old, found = _section(page, name)
    page.write_text(old[: found.start()] + text.rstrip("\n") + "\n" + old[found.end() :], encoding="utf-8")
