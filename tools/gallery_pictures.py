"""The pictures of docs/users/gallery.md: every script of docs/gallery is run, and a figure of its page kept.

    python tools/gallery_pictures.py [NAME ...]     writes docs/images/gallery_NAME.png; needs chromium (`make browser`)
"""

import os
import runpy
import shutil
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

from doc_pictures import FLAGS, ROOT, keep

SCRIPTS = ROOT / "docs" / "gallery"
# the figure of a page that shows what its machine teaches; "" where the script leaves a picture instead of a page
FIGURES = {
    "pump_seal": "#campbell",
    "overhung_fan": "",
    "two_disc_snubber": "#amplitude",
    "compressor": "#campbell",
    "figure3": "#campbell",
    "bouncing": "#moment0",
    "journal_bearings": "#campbell",
    "measured": "#campbell",
    "danger_map": "img",
    "clearances": "#campbell",
    "coast_down": "#campbell",
    "two_seals": "#force",
    "rotor_drop": "",
    "fitted": "#amplitude",
    "own_integrator": "",
}
WIDTH = 900


def taken(page, figure, file):
    """A screenshot of one figure of a page, as a window of WIDTH shows it."""
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        tab = browser.new_page(viewport={"width": WIDTH, "height": 1000}, color_scheme="light")
        tab.goto(page.resolve().as_uri())
        if figure.startswith("#"):  # a page with script
            tab.wait_for_selector("body[data-ready=yes]", timeout=60_000)
        tab.locator("figure", has=tab.locator(figure)).first.screenshot(path=file)
        browser.close()


def main():
    """Run the scripts that are named, or all."""
    for name in sys.argv[1:] or FIGURES:
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            runpy.run_path(str(SCRIPTS / f"{name}.py"), run_name="__main__")
            picture, page = Path(f"{name}.png"), Path(f"{name}.html")
            if FIGURES[name]:
                taken(page if page.is_file() else Path(name) / "report.html", FIGURES[name], picture)
            keep(picture, f"gallery_{name}.png")
            os.chdir(ROOT)


if __name__ == "__main__":
    main()
