"""The pictures of docs/users/pictures.md, README and the site: the two runs of `make run` and a sweep, drawn and made small,
and one of bench/.

    python tools/doc_pictures.py        writes docs/images/
"""

import tempfile
from pathlib import Path

from PIL import Image

from rsc import Scene, cases, check, load_scene
from rsc.analysis.survey import survey
from rsc.show import plots
from rsc.show.report_pictures import branch_map, draw
from rsc.show.sweep_pictures import pictures
from rsc.study.sweep.plan import make_plan
from rsc.study.sweep.sweep import computed

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
RIGHT = "gyroscopic_figure3_right"
LEFT = "gyroscopic_figure3_left"  # of which only the Campbell picture is kept
WIDTH, COLOURS = 1300, 256


def keep(picture, name):
    """Store a picture in docs/images/ under a name, with fewer points and colours: pages load faster."""
    with Image.open(picture) as image:
        size = WIDTH, round(WIDTH * image.height / image.width)
        small = image.convert("RGB").resize(size, Image.Resampling.LANCZOS)
    small.quantize(COLOURS, dither=Image.Dither.NONE).save(IMAGES / name, optimize=True)


def scene_of(name):
    """A reference scene."""
    return load_scene(ROOT / "data" / "reference" / f"{name}.toml")


def pictures_of(name, folder):
    """name of a picture -> its file, of a run of a reference scene."""
    report = check(scene_of(name), progress=True)
    return {Path(path).name: Path(path) for path in draw(report, Path(folder))}


def sweep_map():
    """Whirl danger of the tutorial's pump over friction and speed, after a knock."""
    text = (ROOT / "docs" / "users" / "tutorial.md").read_text(encoding="utf-8")
    pump = Scene.from_toml(text.split("```toml\n")[1].split("```")[0], "pump.toml")
    scene = pump.with_values({"start.running": True, "start.knock": [3.0, 0.0], "drive.duration": 2.0})
    grid = cases(scene, {"contact.friction": "0.05:0.4:36", "drive.speed": "20:60:41"})
    return pictures(computed(make_plan(scene, grid, "predict,run"), None))["danger"]


def main():
    """Run and draw both scenes."""
    with tempfile.TemporaryDirectory() as folder:
        plots.save(sweep_map(), Path(folder) / "danger.png")
        keep(Path(folder) / "danger.png", "danger.png")
    with tempfile.TemporaryDirectory() as folder:
        for name, picture in pictures_of(RIGHT, folder).items():
            keep(picture, name)
    with tempfile.TemporaryDirectory() as folder:
        plots.save(branch_map(survey(scene_of(RIGHT))), Path(folder) / "map.png")
        keep(Path(folder) / "map.png", "map.png")
    keep(ROOT / "bench" / "results" / "basin_running.png", "basin.png")
    with tempfile.TemporaryDirectory() as folder:
        keep(pictures_of(LEFT, folder)["campbell.png"], "campbell_left.png")


if __name__ == "__main__":
    main()
