"""The page of a sweep: results, maps, varied keys, scene; one file without script."""

import base64
import io
from html import escape
from pathlib import Path

from rsc.show.pictures.settings import default_settings

import numpy as np

from rsc.errors import one_line
from rsc.files.mark import HTML
from rsc.files.output import OutputFile
from rsc.show.page import head, made
from rsc.show.page.sections import answers, table
from rsc.show.sweeps import pictures as sweep_pictures
from rsc.show.sweeps import words as sweep_words
from rsc.show.words.units import shown_as_in

DPI = 110
CAPTIONS = {
    "danger": "What backward whirls do: none exists, one exists, one is stable, a run ends in one.",
    "severity": "What each case means for the machine, by the run and the motions that were listed: safe to destructive.",
    "motion": "The motion in which the run of each case ends.",
    **sweep_pictures.SETS,
    "scatter": "Stable backward whirls of the scattered values: the middle nine tenths of each, and how often there is one.",
}


def sweep_page_file(data, path):
    """The file of the page of a sweep (`rsc.results.labelled.Labelled`), to be written by `rsc.files.output.put_all`."""
    return OutputFile(Path(path), sweep_page(data).encode(), HTML)


def sweep_page(data):
    """The text of the page of a sweep, in the units that are chosen, or else those of its scene."""
    with shown_as_in(sweep_pictures.scene_of(data)):
        return _page(data)


def _page(data):
    title = escape(one_line(data.attributes.get("title", "")) or "sweep")
    figures = "".join(_figure(name, figure) for name, figure in sweep_pictures.pictures(data).items())
    why = "".join(f"<li>{escape(line)}</li>" for line in sweep_words.reasons(data))
    sections = [
        f"<section><h2>Answer</h2>{answers(_answer(data))}</section>",
        f'<section><h2>Pictures</h2><div class="grid2">{figures}</div></section>' if figures else "",
        f"<section><h2>Cases that did not finish</h2><ul>{why}</ul></section>" if why else "",
        f"<section><h2>What was varied</h2>{table(('key', 'from', 'to', 'values', 'in', 'meaning'), _varied(data))}</section>",
        f"<section><h2>Origin</h2><p>Computed: {escape(data.attributes.get('computed', ''))}. Made with "
        f"{escape(data.attributes.get('versions', ''))}.</p><h3>Scene before anything was varied, with every default</h3>"
        f'<pre class="long">{escape(data.attributes.get("scene", ""))}</pre></section>',
    ]
    body = f'<main><h1>{title}</h1><p class="soft">sweep; page of {made()}</p>{"".join(sections)}</main>'
    return f"{head(title)}<body>{body}</body></html>\n"


def _answer(data):
    """(topic, text): ends of the cases, danger classes, extremes and their places."""
    lines = [("cases", sweep_words.ends(data).partition(": ")[2])]
    if danger := sweep_words.dangers(data):
        lines.append(("backward whirl", danger.partition(": ")[2]))
    if severity := sweep_words.severities(data):
        lines.append(("severity", severity.partition(": ")[2]))
    return lines + [(text, f"{value} at {where}") for text, value, where in sweep_words.extremes(data)]


@default_settings()
def _figure(name, figure):
    """A plot within the page, with its description."""
    figure.set_dpi(DPI)
    content = io.BytesIO()
    figure.savefig(content, format="png")
    caption = escape(CAPTIONS.get(name, sweep_pictures.MAPPED.get(name, ("", name.replace("_", " ")))[1]))
    source = base64.b64encode(content.getvalue()).decode()
    return f'<figure><img src="data:image/png;base64,{source}" alt="{caption}"><figcaption>{caption}</figcaption></figure>'


def _varied(data):
    """Table rows of the varied keys."""
    rows = []
    for key, (_, values, about) in data.coordinates.items():
        low, high = (values.min(), values.max()) if values.dtype.kind in "fiu" else (values[0], values[-1])
        shown = [f"{end:.6g}" if isinstance(end, (float, np.floating)) else str(end) for end in (low, high)]
        rows.append((key, *shown, str(len(values)), about.get("units", ""), about.get("long_name", "")))
    return rows
