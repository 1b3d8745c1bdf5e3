"""No setting of matplotlib changes a picture: the same bytes under any matplotlibrc."""

import os
import subprocess
import sys

import matplotlib
import numpy as np
import pytest

from reports import short_report
from rsc.files.mark import PNG
from rsc.measure.kinds import Kind
from rsc.show.pictures import maps, plots, report_pictures
from rsc.show.pictures.axes import new_figure
from rsc.show.pictures.maps import Curve, Panel, Side
from rsc.show.sweeps import pictures as sweep_pictures

SETTINGS = {
    "LaTeX": "text.usetex: True\ntext.latex.preamble: \\usepackage{nothing}",
    "other fonts": "font.family: serif\nfont.size: 17\nmathtext.fontset: cm\nfont.serif: Nimbus Roman",
    "resolution": "figure.dpi: 300\nsavefig.dpi: 40\nfigure.figsize: 1, 1",
    "format": "savefig.format: svg\nsavefig.bbox: tight\nsavefig.transparent: True\nsavefig.facecolor: black",
    "backend": "backend: svg\ninteractive: True",
    "dark": "axes.facecolor: black\nfigure.facecolor: black\ntext.color: white\nxtick.color: white\nlines.linewidth: 7",
    "layout": "figure.constrained_layout.use: False\nfigure.autolayout: True\naxes.titlelocation: left\nlegend.loc: center",
    "numbers": "axes.formatter.use_locale: True\naxes.formatter.use_mathtext: True\naxes.formatter.limits: -1, 1",
    "no mathematics": "text.parse_math: False\ntext.hinting: none\ntext.antialiased: False\npath.simplify: False",
    "images": "image.cmap: jet\nimage.origin: upper\nimage.interpolation: bicubic\naxes.prop_cycle: cycler('color', ['red'])",
}  # fmt: skip
TITLE = r"\input{/etc/passwd} $\alpha$ 5 $"


def drawn(folder):
    """The bytes of pictures of every kind."""
    x, y = Side(np.array([1.0, 10.0, 100.0]), "speed in Hz"), Side(np.array([0.1, 0.2]), "friction $\\mu$")
    values = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, np.nan]])
    panels = [Panel("force", "N", [Curve("a", values[0], "line"), Curve("b $x$", values[1], "dots")])]
    how = {"legend": list(zip(map(str, Kind), maps.CLASS_COLOURS, strict=False)), "title": TITLE}
    figures = {
        "values": lambda: maps.plot_values(x, y, values, quantity="amplitude", unit="m", title=TITLE),
        "classes": lambda: maps.plot_classes(x, y, np.array([[0, 1, 2], [3, -1, 5]]), **how),
        "panels": lambda: maps.plot_panels(x, panels, title=TITLE),
        "campbell": lambda: report_pictures.campbell(short_report(), TITLE),
        "amplitude": lambda: report_pictures.amplitude([short_report()], TITLE),
    }
    made = {name: plots.picture_file(make(), folder / f"{name}.png").content for name, make in figures.items()}
    return made | {"svg": plots.picture_file(figures["panels"](), folder / "p.svg").content}


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    return drawn(tmp_path_factory.mktemp("expected"))


@pytest.mark.parametrize("name", SETTINGS)
def test_every_picture_has_the_same_bytes_under_any_settings(name, expected, tmp_path):
    (tmp_path / "matplotlibrc").write_text(SETTINGS[name])
    with matplotlib.rc_context(fname=tmp_path / "matplotlibrc"):
        before = dict(matplotlib.rcParams)
        made = drawn(tmp_path)
        assert dict(matplotlib.rcParams) == before  # those of the caller come back
    assert [own for own in expected if made[own] != expected[own]] == []


def test_the_settings_of_a_folder_do_not_reach_a_picture(expected, tmp_path):
    (tmp_path / "matplotlibrc").write_text("\n".join(SETTINGS.values()))
    program = (
        "import matplotlib; assert matplotlib.rcParams['text.usetex']; from pathlib import Path; import numpy as np\n"
        "from rsc.show.pictures import maps, plots; from rsc.show.pictures.maps import Curve, Panel, Side\n"
        "x = Side(np.array([1.0, 10.0, 100.0]), 'speed in Hz')\n"
        "panels = [Panel('force', 'N', [Curve('a', [1.0, 2.0, 3.0], 'line'), Curve('b $x$', [4.0, 5.0, np.nan], 'dots')])]\n"
        f"plots.save(maps.plot_panels(x, panels, title={TITLE!r}), Path('panels.png'))"
    )
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, env=os.environ, check=True, capture_output=True)
    assert (tmp_path / "panels.png").read_bytes() == PNG.marked(expected["panels"])


def test_settings_that_matplotlib_cannot_read_change_nothing(expected, tmp_path):
    """Neither in the current folder nor where the user has them; of other faults matplotlib tells itself, and goes on."""
    program = (
        "from pathlib import Path; import numpy as np\n"
        "from rsc.show.pictures import maps, plots; from rsc.show.pictures.maps import Curve, Panel, Side\n"
        "x = Side(np.array([1.0, 10.0, 100.0]), 'speed in Hz')\n"
        "panels = [Panel('force', 'N', [Curve('a', [1.0, 2.0, 3.0], 'line'), Curve('b $x$', [4.0, 5.0, np.nan], 'dots')])]\n"
        f"plots.save(maps.plot_panels(x, panels, title={TITLE!r}), Path('panels.png'), True)"
    )
    for content in ("# gr\xfc\xdfe\ntext.usetex: True".encode("latin-1"), b"\xff\xfe", b"axes.facecolor: no\nnonsense: 1\n\0"):
        for folder in (tmp_path, tmp_path / "home"):
            folder.mkdir(exist_ok=True)
            (folder / "matplotlibrc").write_bytes(content)
            own = os.environ | {"MPLCONFIGDIR": str(folder)}
            subprocess.run([sys.executable, "-c", program], cwd=tmp_path, env=own, check=True, capture_output=True)
            (folder / "matplotlibrc").unlink()
            assert (tmp_path / "panels.png").read_bytes() == PNG.marked(expected["panels"])


def test_no_title_of_a_scene_is_read_as_mathematics():
    figure, axes = new_figure(3.0, 3.0)
    axes.set_title(maps.as_text(TITLE))
    texts = [own.title for made in (figure, report_pictures.campbell(short_report(), TITLE)) for own in made.axes]
    shown = [text for text in texts if text.get_text()]
    assert len(shown) == 2
    for text in shown:
        cleaned, is_math = text._preprocess_math(text.get_text())
        assert not is_math and cleaned == TITLE and not text.get_usetex()


def test_every_public_picture_is_drawn_with_the_default_settings():
    with matplotlib.rc_context({"lines.linewidth": 77.0}):
        for function in (plots.stacked, plots.side_by_side, plots.film, maps.plot_starts, sweep_pictures.pictures):
            assert hasattr(function, "__wrapped__"), function
