"""The pictures of docs/users/, README and the site: the two runs of `make run` and two sweeps, drawn, opened and made small.

    python tools/doc_pictures.py        writes docs/images/; needs chromium (`make browser`)
"""

import shutil
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from rsc import Scene, cases, check, load_scene
from rsc.analysis.survey.survey import survey
from rsc.show.page import write_page
from rsc.show.pictures import plots
from rsc.show.pictures.branch_map import branch_map
from rsc.show.pictures.report_pictures import draw
from rsc.show.sweeps.pictures import pictures
from rsc.study.sweep.plan import make_plan
from rsc.study.sweep.sweep import computed

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
RIGHT = "gyroscopic_figure3_right"
LEFT = "gyroscopic_figure3_left"  # of which only the Campbell diagram is kept
WIDTH, COLOURS = 1300, 256
# windows of a browser: name -> width, height, colour scheme
SCREENS = {"page": (1180, 1500, "light"), "page_phone": (420, 1500, "dark")}
FLAGS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]


def keep(picture, name):
    """Store a picture in docs/images/ under a name, with fewer points and colours: pages load faster."""
    with Image.open(picture) as image:
        width = min(WIDTH, image.width)
        small = image.convert("RGB").resize((width, round(width * image.height / image.width)), Image.Resampling.LANCZOS)
    small.quantize(COLOURS, dither=Image.Dither.NONE).save(IMAGES / name, optimize=True)


def scene_of(name):
    """A reference scene."""
    return load_scene(ROOT / "data" / "reference" / f"{name}.toml")


def pictures_of(report, folder):
    """name of a picture -> its file, of a report."""
    return {Path(path).name: Path(path) for path in draw(report, Path(folder))}


def screens_of(report, folder):
    """name of a picture -> its file: the upper part of the page of a report in windows of a browser."""
    page, screens = write_page(report, Path(folder) / "report.html"), {}
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        for name, (width, height, scheme) in SCREENS.items():
            tab = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
            tab.goto(page.as_uri())
            tab.wait_for_selector("body[data-ready=yes]", timeout=60_000)
            screens[f"{name}.png"] = Path(folder) / f"{name}.png"
            tab.screenshot(path=screens[f"{name}.png"])
        browser.close()
    return screens


def sweep_map():
    """Whirl danger of the tutorial's pump over friction and speed, after an impact."""
    text = (ROOT / "docs" / "users" / "tutorial.md").read_text(encoding="utf-8")
    pump = Scene.from_toml(text.split("```toml\n")[1].split("```")[0], "pump.toml")
    scene = pump.with_values({"start.running": True, "start.impulse": [3.0, 0.0], "drive.duration": 2.0})
    grid = cases(scene, {"contact.friction": "0.05:0.4:36", "drive.speed": "20:60:41"})
    return pictures(computed(make_plan(scene, grid, "predict,run"), None))["danger"]


def basin():
    """In which motion the rotor of Figure 3 right ends after an impact at 60 Hz while it turns without contact."""
    change = {"drive.speed": 60.0, "drive.duration": 5.0, "output.rate": 500.0, "start.running": True}
    scene = scene_of(RIGHT).with_values(change)
    impacts = cases(scene, {f"start.impulse[{i}]": "-2.5:2.5:100" for i in (0, 1)})
    return pictures(computed(make_plan(scene, impacts, "run"), None))["motion"]


def main():
    """Run, draw and open both scenes."""
    with tempfile.TemporaryDirectory() as folder:
        for name, figure in (("danger.png", sweep_map()), ("basin.png", basin())):
            plots.save(figure, Path(folder) / name)
            keep(Path(folder) / name, name)
    with tempfile.TemporaryDirectory() as folder:
        report = check(scene_of(RIGHT), progress=True)
        for name, picture in (pictures_of(report, folder) | screens_of(report, folder)).items():
            keep(picture, name)
    with tempfile.TemporaryDirectory() as folder:
        plots.save(branch_map(survey(scene_of(RIGHT))), Path(folder) / "map.png")
        keep(Path(folder) / "map.png", "map.png")
    with tempfile.TemporaryDirectory() as folder:
        keep(pictures_of(check(scene_of(LEFT), progress=True), folder)["campbell.png"], "campbell_left.png")


if __name__ == "__main__":
    main()
