"""The pictures of docs/users/pictures.md, README and the site: runs of scenes of data/reference, drawn and made small.

    python tools/doc_pictures.py        writes docs/images/
"""

import tempfile
from pathlib import Path

from PIL import Image

from rsc import check, load_scene
from rsc.show import plots
from rsc.show.report_pictures import amplitude, draw, orbit

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
WIDTH, COLOURS = 1300, 256


def keep(picture):
    """Store a picture in docs/images/ with fewer points and colours: pages load faster, and so does the repository."""
    with Image.open(picture) as image:
        size = WIDTH, round(WIDTH * image.height / image.width)
        small = image.convert("RGB").resize(size, Image.Resampling.LANCZOS)
    small.quantize(COLOURS, dither=Image.Dither.NONE).save(IMAGES / picture.name, optimize=True)


def reported(name):
    """Report of a reference scene."""
    return check(load_scene(ROOT / "data" / "reference" / f"{name}.toml"), progress=True)


def main():
    """The very light stator of the paper, run-down and both amplitudes, and the orbit of a rotor that whirls to the end."""
    up, down = reported("gyroscopic_disk_very_light"), reported("gyroscopic_disk_very_light_rundown")
    whirling = reported("laval")
    with tempfile.TemporaryDirectory() as folder:
        pictures = {Path(path).name: Path(path) for path in draw(down, Path(folder))}
        plots.save(amplitude([up, down], up.result.scene.title), pictures["amplitude.png"])
        plots.save(orbit(whirling.result, whirling.result.scene.title), pictures["orbit.png"])
        for picture in pictures.values():
            keep(picture)


if __name__ == "__main__":
    main()
