"""What `make release` refuses: versions and dates that differ, a changelog that nobody reads to its end."""

import sys
import tomllib
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[3] / "tools"))
import release

CITED = 'version: 1.2.3\ndate-released: "2026-01-31"\n'


@pytest.mark.parametrize(
    ("citation", "changelog", "problem"),
    [
        (CITED, "# Changelog\n\n## 1.2.3 (2026-01-31)\n\n- a line\n", None),
        (CITED, "# Changelog\n\n## Unreleased\n\n- a line\n\n## 1.2.3 (2026-01-31)\n\n- a line\n", None),
        (CITED.replace("1.2.3", "1.2.2"), "## 1.2.3 (2026-01-31)\n", "CITATION.cff is of version 1.2.2"),
        (CITED, "## 1.2.3 (unreleased)\n", 'the newest version is "1.2.3 (unreleased)", not "1.2.3 (2026-01-31)"'),
        (CITED, "## 1.2.3 (2026-02-01)\n", 'not "1.2.3 (2026-01-31)"'),
        (CITED, "# Changelog\n", 'the newest version is ""'),
        (CITED, "## 1.2.3 (2026-01-31)\n" + "- a line\n" * 61, "takes 61 lines, at most 60"),
        (CITED, "## Unreleased\n" + "- a line\n" * 21 + "## 1.2.3 (2026-01-31)\n", "21 lines are unreleased"),
    ],
)
def test_what_does_not_fit_is_told(citation, changelog, problem):
    problems = list(release.wrong_words("1.2.3", citation, changelog))
    assert len(problems) == bool(problem) and (not problem or problem in problems[0])


def test_this_version_can_be_released():
    version = tomllib.loads((release.ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    texts = [(release.ROOT / name).read_text(encoding="utf-8") for name in ("CITATION.cff", "CHANGELOG.md")]
    assert not list(release.wrong_words(version, *texts))


def test_every_library_of_a_release_has_hashes():
    listed, hashed = (path.read_text(encoding="utf-8") for path in (release.CONSTRAINTS, release.HASHED))
    assert release.pinned(hashed) == release.pinned(listed) and len(release.pinned(listed)) > 30
    assert all("--hash=sha256:" in part for part in hashed.split("\n\n")[0].replace("\\\n", "").strip().splitlines())


def test_what_the_plotting_script_bundles_is_in_the_bill_of_materials():
    notice = release.NOTICE.read_text(encoding="utf-8")
    parts = {part["purl"]: part["licenses"][0]["license"]["id"] for part in release.bundled(notice)}
    assert len(parts) == 27 and parts["pkg:npm/%40plotly/d3@3.8.2"] == "BSD-3-Clause"
    assert set(parts.values()) == {"MIT", "BSD-3-Clause", "Zlib"}
