"""The rows of tools/seeded_bugs.toml and bench/ablation.py fit the sources as they are, and go on fitting when lines move."""

import ast
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
sys.path.append(str(ROOT / "tools"))
sys.path.append(str(ROOT / "bench"))

from ablation import AS_IT_IS, PATCHES  # noqa: E402
from anchors import Package, Stale  # noqa: E402

ROWS = tomllib.loads((ROOT / "tools" / "seeded_bugs.toml").read_text(encoding="utf-8"))
LOOP = """\
def count(values):
    total = 0.0
    for value in values:
        total = total + 2.0 * value
    return total
"""
LOOP_BODY = "total = 0.0\nfor value in values:\n    total = total + 2.0 * value"


@pytest.fixture(scope="module")
def package():
    return Package(ROOT / "src" / "rsc")


@pytest.mark.parametrize("row", ROWS["bug"], ids=[row["why"] for row in ROWS["bug"]])
def test_a_seeded_bug_fits_once_and_leaves_python(row, package):
    path, text = package.edited(row["place"], row["old"], row["new"])
    assert ast.dump(ast.parse(text)) != ast.dump(ast.parse(package.sources[path]))


@pytest.mark.parametrize("name", [name for name in PATCHES if name != AS_IT_IS])
def test_a_patch_of_the_ablation_fits(name, package):
    assert package.after(PATCHES[name]).sources != package.sources


def test_the_tests_that_are_to_notice_a_seeded_bug_exist():
    named = {test for tests in ROWS["rooms"].values() for test in tests} | {row["first"] for row in ROWS["bug"] if "first" in row}
    for test in sorted(named):
        file, _, function = test.split("[")[0].partition("::")
        assert f"def {function}" in (ROOT / file).read_text(encoding="utf-8"), test
    for part in ROWS["rooms"]:
        assert (ROOT / part).exists(), part


def package_of(folder, **files):
    for name, text in files.items():
        path = folder / "made" / (name.replace("__", "/") + ".py")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return Package(folder / "made")


MOVES = {
    "as it was": {"loops": LOOP},
    "another line": {"loops": '"""Text."""\n\nimport math\n\nSTART = math.pi\n\n\n' + LOOP},
    "another layout": {"loops": LOOP.replace("2.0 * value", "(  # twice\n            2.0\n            * value\n        )")},
    "another file": {"loops": "", "wing__sums": LOOP},
    "beside another": {"loops": LOOP, "others": "def counted(values):\n    return 2.0 * values\n"},
}


@pytest.mark.parametrize("files", MOVES.values(), ids=MOVES)
def test_an_edit_follows_what_it_is_for(files, tmp_path):
    path, text = package_of(tmp_path, **files).edited("count", "2.0 * value", "3.0 + value")
    namespace = {}
    exec(compile(text, path, "exec"), namespace)
    assert namespace["count"]([1.0, 2.0]) == 9.0  # 4 + 5: what takes the place keeps together


def test_statements_are_replaced_removed_and_put_in_front(tmp_path):
    package = package_of(tmp_path, loops=LOOP)
    found = {}
    edits = {
        "replaced": ("count", LOOP_BODY, "total = -1.0\nvalues.clear()"),
        "removed": ("loops", "total = total + 2.0 * value", ""),
        "in front": ("count", "", "@list\ndef doubled():\n    yield 1.0"),
    }
    for name, edit in edits.items():
        _, found[name] = package.edited(*edit)
    assert found["replaced"] == "def count(values):\n    total = -1.0\n    values.clear()\n    return total\n"
    assert found["removed"] == LOOP.replace("total = total + 2.0 * value", "pass")
    assert found["in front"] == "@list\ndef doubled():\n    yield 1.0\n\n\n" + LOOP


STALE = {
    "no such function": ("counted", "2.0 * value", "value"),
    "no such expression": ("count", "3.0 * value", "value"),
    "twice": ("count", "value", "1.0"),
    "no Python": ("count", "2.0 * value", "2.0 *"),
}


@pytest.mark.parametrize("edit", STALE.values(), ids=STALE)
def test_an_edit_that_does_not_fit_is_stale(edit, tmp_path):
    with pytest.raises(Stale):
        package_of(tmp_path, loops=LOOP).edited(*edit)
