"""The pictures of docs/users/gallery.md: every script of docs/gallery is run, and its plot kept.

    python tools/gallery_pictures.py [NAME ...]     writes docs/images/gallery_NAME.png
"""

import os
import runpy
import sys
import tempfile

from doc_pictures import ROOT, keep

SCRIPTS = ROOT / "docs" / "gallery"


def main():
    """Run the scripts that are named, or all."""
    for name in sys.argv[1:] or sorted(path.stem for path in SCRIPTS.glob("*.py")):
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            runpy.run_path(str(SCRIPTS / f"{name}.py"), run_name="__main__")
            keep(f"{name}.png", f"gallery_{name}.png")
            os.chdir(ROOT)


if __name__ == "__main__":
    main()
