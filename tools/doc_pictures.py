"""The pictures of docs/users/pictures.md, README and the site: two runs of the paper's very light stator, drawn and made small.

    python tools/doc_pictures.py        writes docs/images/
"""

import tempfile
from pathlib import Path

from PIL import Image

from rsc import check, load_scene
from rsc.show import plots
from rsc.show.report_pictures import amplitude, draw

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
SCENES = ("gyroscopic_disk_very_light", "gyroscopic_disk_very_light_rundown")
WIDTH, COLOURS = 1300, 64


def keep(picture):
    """Store a picture in docs/images/ with fewer points and colours: pages load faster, and so does the repository."""
    with Image.open(picture) as image:
        size = WIDTH, round(WIDTH * image.height / image.width)
        small = image.convert("RGB").resize(size, Image.Resampling.LANCZOS)
    small.quantize(COLOURS, dither=Image.Dither.NONE).save(IMAGES / picture.name, optimize=True)


def main():
    """Run both scenes, draw the run-down and the amplitudes of both."""
    reports = [check(load_scene(ROOT / "data" / "reference" / f"{name}.toml"), progress=True) for name in SCENES]
    with tempfile.TemporaryDirectory() as folder:
        pictures = {Path(path).name: Path(path) for path in draw(reports[-1], Path(folder))}
        plots.save(amplitude(reports, reports[0].result.scene.title), pictures["amplitude.png"])
        for picture in pictures.values():
            keep(picture)


if __name__ == "__main__":
    main()
