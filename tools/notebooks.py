"""Notebooks of the gallery: each script of docs/gallery as cells, its docstring as text, with the data files it reads.

    python tools/notebooks.py [NAME ...] [-o FOLDER] [--run]     writes FOLDER/NAME.ipynb, by default into out/notebooks

`--run` executes them as well, so that printed lines and plots are kept inside; it fails where a cell does. `make docs` puts
them on the site without.
"""

import argparse
import ast
import re
import shutil
from pathlib import Path

import jupytext
import nbformat

ROOT = Path(__file__).resolve().parents[1]
SCRIPTS = ROOT / "docs" / "gallery"
HOME = "Path(__file__).parents[2]"  # in a script: the repository; in a notebook: its own folder
DATA = re.compile(r'"([\w.]+\.(?:toml|mat))"')
LONGEST = 600  # s that a cell may take
KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}


def notebook(script):
    """The notebook of a script, in nbformat's form: cells end at the blank lines of the script."""
    text = script.read_text(encoding="utf-8")
    made = jupytext.reads(text.replace(HOME, "Path()"), "py:light")
    first, *cells = made.cells
    title, _, body = ast.get_docstring(ast.parse(text)).partition("\n")
    first = nbformat.v4.new_markdown_cell(f"# {title}\n{body}")
    made.cells = [first, *_joined_imports(cells)]
    for i, cell in enumerate(made.cells):
        cell["id"] = f"cell-{i}"  # else a random one
    made.metadata = nbformat.from_dict({"kernelspec": KERNEL, "language_info": {"name": "python"}})
    return made


def _joined_imports(cells):
    """The cells, those of imports at the beginning as one."""
    count = next(i for i, cell in enumerate(cells) if not _imports_only(cell.source))
    return [nbformat.v4.new_code_cell("\n\n".join(cell.source for cell in cells[:count])), *cells[count:]]


def _imports_only(source):
    return all(isinstance(statement, ast.Import | ast.ImportFrom) for statement in ast.parse(source).body)


def data_files(script):
    """Files of data/reference that a script reads, relative to the repository."""
    text = script.read_text(encoding="utf-8")
    named = DATA.findall(text) if HOME in text else []
    return sorted(path.relative_to(ROOT) for name in named for path in (ROOT / "data" / "reference").rglob(name))


def write(folder, names=()):
    """The notebooks of the scripts that are named, or of all, with their data; returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name in names or sorted(path.stem for path in SCRIPTS.glob("*.py")):
        script = SCRIPTS / f"{name}.py"
        for file in data_files(script):
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / file, folder / file)
        written.append(folder / f"{name}.ipynb")
        nbformat.write(notebook(script), written[-1])
    return written


def run(path):
    """Execute a notebook in its folder and keep what its cells give."""
    from nbclient import NotebookClient  # needs a kernel, which the site does without

    made = nbformat.read(path, as_version=4)
    NotebookClient(made, timeout=LONGEST, kernel_name=KERNEL["name"], resources={"metadata": {"path": path.parent}}).execute()
    nbformat.write(made, path)
    kinds = [kind for cell in made.cells for output in cell.get("outputs", []) for kind in output.get("data", ())]
    if "image/png" not in kinds:
        raise SystemExit(f"{path}: no cell shows a plot")


def main():
    """Read the arguments, write, execute."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "notebooks")
    parser.add_argument("--run", action="store_true")
    options = parser.parse_args()
    for path in write(options.output, options.names):
        if options.run:
            run(path)
        print(path)


if __name__ == "__main__":
    main()
