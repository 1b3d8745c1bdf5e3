"""report.html: a run, its predictions and their comparison in one file that needs neither a network nor other files.

Everything is there without script and on paper (SVG and tables). With script plotly draws the same pictures to zoom into, and one
cursor moves through them; plotly's script and the numbers stand in the page, compressed.
"""

import base64
import gzip
import json
from datetime import UTC, datetime
from html import escape
from pathlib import Path

import numpy as np

from rsc.errors import one_line
from rsc.files.mark import HTML
from rsc.files.output import OutputFile, put_all
from rsc.show.page import sections
from rsc.show.page.svg import svg
from rsc.show.pictures import paths
from rsc.show.pictures.abscissa import Abscissa
from rsc.show.pictures.album import PICTURES, SECTIONS, described
from rsc.show.pictures.moments import moments
from rsc.show.words.answer import answer
from rsc.show.words.text import notes
from rsc.show.words.units import largest_finite, shown_as_in
from rsc.show.words.wording import length

HERE = Path(__file__).parent
# lines, dots, bars and heat maps of plotly.js 4.1.1 (MIT; what is bundled in it: NOTICE in the same folder): the script of
# `npm pack plotly.js-cartesian-dist-min@4.1.1`, compressed by zopfli
LIBRARY = HERE / "plotly" / "plotly-cartesian.min.js.gz"
NOTICE = HERE / "plotly" / "NOTICE"
# no address is ever asked for anything, whatever a scene's title holds
POLICY = "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"

SHAPES = (
    '<p class="live"><button id="animate" type="button" aria-pressed="false">Animate the mode shapes</button></p>'
    '<p class="soft">Mode shapes of the rotor without contact, in an oblique view: z up, y away from the reader. Blue nodes '
    "whirl forward, red ones backward; each orbit begins at its node and ends before it. The size is arbitrary; the animation "
    "omits growth and decay. Modes that the contact cannot excite are not shown.</p>"
)
# legend of an orbit
BODIES = {
    "simulated": "Blue: rotor; vermilion: where it touches; green: stator; dashed: the gap around the stator",
    "measured": "Blue: rotor; dashed: the gap of the scene around its resting position",
}


def write_page(report, path, others=()):
    """Write report.html of a Report; returns its Path. DataError when the file cannot be written; `others` as `page_file`."""
    put_all([page_file(report, path, others)])
    return Path(path)


def page_file(report, path, others=()):
    """The file report.html of a Report, to be written by `rsc.files.output.put_all`.

    others : Reports of other runs, whose amplitudes are drawn beside its own (run-up and run-down show the hysteresis)
    """
    with report.result.kept_open(), shown_as_in(report.result.scene):
        return OutputFile(Path(path), page(report, others).encode(), HTML)


def page(report, others=()):
    """The text of report.html."""
    along, chosen = Abscissa(report), moments(report)
    drawn = described(report, along, others)
    at_moments = paths.moments(report, chosen)
    cursor = paths.at_cursor(report, along)
    figures = {section: _figures(drawn, section, report) for section in SECTIONS}
    orbits = [_figure(f"moment{i}", picture, caption) for i, (caption, picture) in enumerate(at_moments)]
    drawn |= {f"moment{i}": picture for i, (_, picture) in enumerate(at_moments)}
    title = escape(one_line(report.result.scene.title) or f"{report.word} run")
    body = _body(report, title, figures, orbits)
    data = {"pictures": {name: _for_script(picture) for name, picture in drawn.items()}, "cursor": cursor}
    return (
        f"{head(title)}<body>{body}"
        f'<script type="application/octet-stream" id="report">{_packed(data)}</script>'
        f'<script type="application/octet-stream" id="library">{_library()}</script>'
        f'<script type="text/plain" id="licences">{NOTICE.read_text(encoding="utf-8")}</script>'
        f"<script>{_script()}</script></body></html>\n"
    )


def head(title):
    """The beginning of a page up to its body; `title` is escaped already."""
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><meta name="color-scheme" content="light dark">'
        f"<style>{(HERE / 'page.css').read_text(encoding='utf-8')}</style></head>"
    )


def made():
    """When a page is made."""
    return datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")


def _body(report, title, figures, orbits):
    labels = [branch.label for branch in report.branches]
    choices = "".join(f"<option>{escape(label)}</option>" for label in labels)
    result, remarks = report.result, [("note", text.removeprefix("note: ")) for text in notes(report)]
    if report.lead:
        remarks.append(("pictures", f"at {report.lead}, which takes the largest impulse of all contacts"))
    source = f"{result.status} at {result.summary.end_time:.6g} s" if result.summary else f"measured: {result.source}"
    return (
        f"<main><h1>{title}</h1>"
        f'<p class="soft">{escape(source)}; report of {made()}</p>'
        f"<section><h2>Answer</h2>{sections.answers([*answer(report), *remarks])}</section>"
        '<section class="live controls" aria-label="cursor"><label for="cursor">Cursor over all pictures</label>'
        f'<label for="whirl">whirl</label><select id="whirl"><option value="">all</option>{choices}</select>'
        '<button id="play" type="button" aria-pressed="false">Play the run</button>'
        '<input type="range" id="cursor" min="0" max="1" value="0"><output id="readout" for="cursor"></output></section>'
        '<section class="live"><div class="grid2"><div id="orbit" role="img" aria-label="orbit of the rotor at the cursor"></div>'
        '<div id="spectrum" role="img" aria-label="spectrum at the cursor"></div></div></section>'
        f"{_section('Machine', _machine(report, figures['Machine']))}"
        f"<section><h2>Frequencies</h2>{figures['Frequencies']}</section>"
        f"<section><h2>Amplitude</h2>{figures['Amplitude']}</section>"
        f"<section><h2>Predicted whirls: where they begin, end and jump</h2>{sections.whirls(report)}</section>"
        f"{_section('Force and friction', figures['Force and friction'])}"
        f'<section><h2>Orbits at key speeds</h2><div class="grid3">{"".join(orbits)}</div>'
        f'<p class="soft">{BODIES[report.word]}; a mark at '
        "every revolution of the shaft; dotted: filtered at 1X (purple) and at the whirl frequency (light blue), ellipses of the "
        "forward and the backward line there.</p></section>"
        f"<section><h2>Unbalance response</h2>{figures['Unbalance response']}{sections.limits(report)}</section>"
        f"{_section('Energy', figures['Energy'])}{_section('What can last', sections.motions(report))}"
        f"{_section(f'{report.word.capitalize()} and predicted', sections.windows(report))}"
        f"<section><h2>Assumptions and their sizes</h2>{sections.assumptions(report)}</section>"
        f"<section><h2>Origin</h2>{sections.origin(report)}</section></main>"
    )


def _machine(report, figures):
    """The rotor in numbers, its drawing, and its mode shapes, which a button sets in motion."""
    return sections.machine(report) + figures + (SHAPES if report.modes.shapes else "")


def _section(title, content):
    """A section of the page; nothing where it has nothing to show."""
    return f"<section><h2>{title}</h2>{content}</section>" if content else ""


def _figures(drawn, section, report):
    """The figures of a section in their order, narrow ones side by side before the others."""
    own = {name: picture for name, picture in drawn.items() if PICTURES[name].section == section}
    words = {"word": report.word, "mean": length(largest_finite(np.abs(report.centre)))}
    captions = {name: picture.get("caption") or PICTURES[name].caption.format(**words) for name, picture in own.items()}
    figures = [("width" in picture["layout"], _figure(name, picture, captions[name])) for name, picture in own.items()]
    narrow, wide = ("".join(figure for is_narrow, figure in figures if is_narrow == side) for side in (True, False))
    return (f'<div class="grid3">{narrow}</div>' if narrow else "") + wide


def _figure(name, picture, caption):
    words = escape(caption)
    return f'<figure><div class="plot" id="{name}"></div>{svg(picture, caption)}<figcaption>{words}</figcaption></figure>'


def _for_script(picture):
    """A plot without the data needed for print only."""
    data = [{key: value for key, value in trace.items() if key != "levels"} for trace in picture["data"]]
    return {"data": data, "layout": picture["layout"]}


def _packed(data):
    """Data for the script: JSON, compressed; the byte for the operating system says unknown, on every one."""
    packed = gzip.compress(json.dumps(data, allow_nan=False, separators=(",", ":")).encode(), 9, mtime=0)
    return lettered(packed[:9] + b"\xff" + packed[10:])


def _script():
    """The page's own script, without its comments and indentation."""
    lines = (line.strip() for line in (HERE / "page.js").read_text(encoding="utf-8").splitlines())
    return "\n".join(line for line in lines if line and not line.startswith("//"))


def _library():
    """plotly's script, compressed."""
    return lettered(LIBRARY.read_bytes())


def lettered(content):
    """Bytes encoded so that they are safe inside a script element: base 85, with a comma for <."""
    return base64.b85encode(content).decode().replace("<", ",")
