"""Sphinx: the site of rsc from docs/ and the docstrings (`make docs`)."""

import re
import shutil
import sys
from pathlib import Path

import docutils.nodes
import latex2mathml.converter

import rsc  # noqa: F401 (a site without the package would lack its reference)

sys.path.insert(0, str(Path(__file__).parents[1] / "tools"))
import notebooks

project = "rsc"
author = "the rsc developers"
copyright = "2026, the rsc developers"

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
include_patterns = ["index.md", "users/**", "maintainers/**", "images/**"]

# equations are MathML, made here: browsers show it without a script and without a network
html_math_renderer = "mathml"

myst_enable_extensions = ["amsmath", "dollarmath"]
# so that page.md#section leads to a heading
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # shapes and units stand in the docstrings
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "furo"
html_title = "rsc"
html_static_path = ["static"]
html_css_files = ["wide.css"]


FIELD = re.compile(r"^([a-z][\w, ()]*) : ")


def _for_the_page(app, what, name, obj, options, lines):
    """Docstrings are written for help(): fields of a class become a list, and |d| is a magnitude, no substitution."""
    if what == "class" and not any(line.startswith("---") for line in lines):
        lines[:] = [re.sub(r"^ {4}", "  ", FIELD.sub(r"* **\1**: ", line, count=1)) for line in lines]
    lines[:] = [line.replace("|", "\\|") for line in lines]


TAG = re.compile(r"\\tag\{(.*?)\}")


def _mathml(latex, display):
    """MathML of an equation; latex2mathml fails on what it cannot read."""
    return latex2mathml.converter.convert(TAG.sub("", latex).strip(), display="block" if display else "inline")


def _inline(self, node):
    self.body.append(_mathml(node.astext(), False))
    raise docutils.nodes.SkipNode


def _display(self, node):
    """An equation with its number, in a row that scrolls by itself on a narrow page."""
    number = TAG.search(node.astext())
    text = f'<span class="eqno">({number[1]})</span>' if number else ""
    self.body.append(f'<div class="math equation">{_mathml(node.astext(), True)}{text}</div>')
    raise docutils.nodes.SkipNode


SECTION = re.compile(r"^## (.+)\n\n\[`(\w+)\.py`\].*?\n\n!\[(.+)\]\(", re.MULTILINE)
ARCHIVE = '<p><a href="../notebooks.zip" download>All notebooks with the data they read</a></p>'
CARD = '<a href="#{anchor}"><img src="../_images/gallery_{name}.png" alt="{alt}" loading="lazy"><span>{title}</span></a>'


def _gallery(app, page, source):
    """Of the gallery: thumbnails that lead to the sections, before the first, and notebooks beside the scripts."""
    if page != "users/gallery":
        return
    cards = [
        CARD.format(anchor="-".join(re.findall(r"\w+", title.lower())), name=name, alt=alt, title=title)
        for title, name, alt in SECTION.findall(source[0])
    ]
    grid = "```{raw} html\n<div class=\"cards\">\n" + "\n".join(cards) + f"\n</div>\n{ARCHIVE}\n```\n\n"
    intro, heading, sections = source[0].partition("## ")
    link = r'\g<0> (<a href="../notebooks/\2.ipynb" download>notebook</a>)'
    sections = re.sub(r"^(\[`(\w+)\.py`\]\([^)]+\))", link, sections, flags=re.MULTILINE)
    source[0] = intro + grid + heading + sections


def _notebooks(app):
    """Those of the gallery and the data they read, and all in one archive."""
    folder = Path(app.outdir) / "notebooks"
    notebooks.write(folder)
    shutil.make_archive(str(folder), "zip", folder)


def setup(app):
    """Connect what is not in an extension."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    app.connect("source-read", _gallery)
    app.connect("builder-inited", _notebooks)
    app.connect("autodoc-process-docstring", _for_the_page, priority=400)  # before napoleon
