"""Every script of docs/gallery/ runs, prints what docs/users/gallery.md shows, leaves its plot, in the time it may take."""

import re
import runpy
import time
from pathlib import Path

import numpy as np
import pytest
from test_documents import printed_by

ROOT = Path(__file__).parents[3]
SCRIPTS = sorted((ROOT / "docs" / "gallery").glob("*.py"))
PAGE = (ROOT / "docs" / "users" / "gallery.md").read_text(encoding="utf-8")
LINK, PICTURE = r"^\[`(\w+)\.py`\]\(\.\./gallery/\1\.py\).*?", r"^!\[[^]]+\]\(\.\./images/gallery_\1\.png\)$.*?"
SECTION = re.compile(LINK + PICTURE + r"^```text\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SHOWN = dict(SECTION.findall(PAGE))
LONGEST = 20.0  # s of processor time, with compiled kernels
LINES = range(20, 71)
HEAVIEST = 80_000  # bytes of a picture
LONG = {  # ten seconds and more, compiling included
    "clearances", "compressor", "fitted", "journal_bearings", "levitated_machine", "levitated_rotor", "rotor_drop", "shaft_drop",
}  # fmt: skip


@pytest.mark.parametrize(
    "path", [pytest.param(path, id=path.stem, marks=[pytest.mark.nightly] * (path.stem in LONG)) for path in SCRIPTS]
)
def test_a_script_prints_what_its_page_shows(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for _ in range(2):  # the first run may compile
        begin = time.process_time()
        output = printed_by(lambda: runpy.run_path(str(path), run_name="__main__"))[1]
        took = time.process_time() - begin
        if took <= LONGEST:
            break
    assert took <= LONGEST
    assert output == SHOWN[path.stem]
    for name in (f"{path.stem}.png", *re.findall(r'save_html\("(.*)"', path.read_text(encoding="utf-8"))):
        assert (tmp_path / name).stat().st_size > 10_000


def test_the_page_shows_ten_scripts_and_their_pictures():
    assert set(SHOWN) == {path.stem for path in SCRIPTS} and len(SHOWN) >= 10
    for path in SCRIPTS:
        text = path.read_text(encoding="utf-8")
        assert text.startswith('"""') and len(text.splitlines()) in LINES, path.name
        assert (ROOT / "docs" / "images" / f"gallery_{path.stem}.png").stat().st_size < HEAVIEST


@pytest.mark.nightly
def test_the_oil_film_of_the_gallery_is_the_short_bearing(tmp_path, monkeypatch):
    """Load and coefficients in closed form (M. I. Friswell et al., Dynamics of Rotating Machines, 2010, 5.5)."""
    monkeypatch.chdir(tmp_path)
    names, _ = printed_by(lambda: runpy.run_path(str(ROOT / "docs" / "gallery" / "journal_bearings.py")))
    load, clearance = names["WEIGHT"], names["CLEARANCE"]
    for speed, stiffness, damping, e in names["knots"]:
        Omega, square, root = 2.0 * np.pi * speed, 1.0 - e**2, np.sqrt(1.0 - e**2)
        carried = names["OIL"] * Omega * names["RADIUS"] * names["LENGTH"] ** 3 / clearance**2 * e / (4.0 * square**2)
        assert carried * np.sqrt(16.0 * e**2 + np.pi**2 * square) == pytest.approx(load, rel=1e-5)
        h = (np.pi**2 * square + 16.0 * e**2) ** -1.5
        a = [
            4.0 * (np.pi**2 * (2.0 - e**2) + 16.0 * e**2),
            np.pi * (np.pi**2 * square**2 - 16.0 * e**4) / (e * root),
            -np.pi * (np.pi**2 * square * (1.0 + 2.0 * e**2) + 32.0 * e**2 * (1.0 + e**2)) / (e * root),
            4.0 * (np.pi**2 * (1.0 + 2.0 * e**2) + 32.0 * e**2 * (1.0 + e**2) / square),
        ]
        skew = -8.0 * (np.pi**2 * (1.0 + 2.0 * e**2) - 16.0 * e**2)
        b = [
            2.0 * np.pi * root * (np.pi**2 * (1.0 + 2.0 * e**2) - 16.0 * e**2) / e,
            skew,
            skew,
            2.0 * np.pi * (np.pi**2 * square**2 + 48.0 * e**2) / (e * root),
        ]
        assert stiffness == pytest.approx(load / clearance * h * np.array(a), rel=1e-3)
        assert damping == pytest.approx(load / (clearance * Omega) * h * np.array(b), rel=1e-3)
