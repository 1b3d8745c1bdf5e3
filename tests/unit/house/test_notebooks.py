"""The notebooks of the gallery are its scripts: valid, of the same statements, in cells that compile (`make nightly` runs)."""

import ast
import re
import sys
from pathlib import Path

import nbformat
import pytest

sys.path.insert(0, str(Path(__file__).parents[3] / "tools"))
import notebooks

SCRIPTS = sorted(notebooks.SCRIPTS.glob("*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_a_notebook_has_the_statements_of_its_script(script):
    made = notebooks.notebook(script)
    nbformat.validate(made)
    text, *code = made.cells
    assert text.cell_type == "markdown" and text.source.startswith("# ") and {cell.cell_type for cell in code} == {"code"}
    statements = [ast.dump(each) for cell in code for each in ast.parse(cell.source).body]
    expected = ast.parse(script.read_text(encoding="utf-8").replace(notebooks.HOME, "Path()")).body[1:]
    assert statements == [ast.dump(each) for each in expected]
    assert len(code) > 2 and "__file__" not in "".join(cell.source for cell in code)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_a_script_draws_its_plot_on_axes_which_a_notebook_shows(script):
    assert re.search(rf'\.savefig\("{script.stem}\.png"', script.read_text(encoding="utf-8"))


def test_notebooks_are_written_with_their_data_and_equal_bytes(tmp_path):
    paths = notebooks.write(tmp_path / "one")
    assert [path.stem for path in paths] == [script.stem for script in SCRIPTS]
    with_data = {script.stem: notebooks.data_files(script) for script in SCRIPTS if notebooks.data_files(script)}
    assert set(with_data) == {script.stem for script in SCRIPTS if notebooks.HOME in script.read_text(encoding="utf-8")} != set()
    for files in with_data.values():
        assert all((tmp_path / "one" / file).is_file() for file in files)
    again = notebooks.write(tmp_path / "two")
    assert [path.read_bytes() for path in paths] == [path.read_bytes() for path in again]
